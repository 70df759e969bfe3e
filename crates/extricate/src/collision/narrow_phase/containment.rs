//! Whether a point lies in the solid that closed components of a mesh bound.

use pulp::{Arch, Simd, WithSimd};

use super::triangle::Triangle;
use crate::collision::shapes::bvh::{Bvh, Ref, lanes_of, rounding_at};
use crate::math::Vec3;
use crate::math::elementary::atan2;
use crate::robot::mesh::edges::{Side, same_edge, sorted_sides};

/// Directions of the rays, one after another. None is parallel to an axis or to another direction.
const RAY_DIRECTIONS: [[f64; 3]; 4] = [
    [0.3145, 0.2713, 0.909684],
    [-0.5772, 0.6947, 0.43172],
    [0.1419, -0.8665, -0.479514],
    [-0.2231, -0.412453, 0.883081],
];

/// A crossing is uncertain within this relative distance of an edge, or if the sine of its angle to
/// the plane is this small. Far above rounding (1e-13), far below what random rays meet.
const DOUBT_SHARE: f64 = 1e-9;

/// Rule by which a closed surface decides whether it encloses a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Inside {
    /// The surface winds around the point. A surface that passes through itself thus encloses what
    /// it covers twice.
    Wound,
    /// The surface winds around the point more often outward than inward: cavities wind inward.
    Hollow,
    /// A ray from the point crosses the surface an odd number of times. Used if the orientations of
    /// faces contradict each other.
    Odd,
}

impl Inside {
    /// Chooses the rule for triangles with an even number at every edge. Winding numbers are usable
    /// if equally many triangles run along each edge in either direction.
    pub fn of(triangles: &[[u32; 3]], has_cavities: bool) -> Self {
        let sides = sorted_sides(triangles);
        let cancel = |ring: &[Side]| 2 * ring.iter().filter(|side| side.forward).count() == ring.len();
        match sides.chunk_by(same_edge).all(cancel) {
            true if has_cavities => Self::Hollow,
            true => Self::Wound,
            false => Self::Odd,
        }
    }

    fn holds(self, winding: i64) -> bool {
        match self {
            Self::Wound => winding != 0,
            Self::Hollow => winding > 0,
            Self::Odd => winding % 2 != 0,
        }
    }
}

/// Whether `point` is inside closed group `group` of `tree`. Within rounding of the surface, either
/// answer is right.
///
/// The crossings of a ray are added up, outward ones less inward ones. A ray that passes too near
/// an edge or along a face gives way to the next; after four rays, solid angles decide.
///
/// # Source
/// The winding number as a sum of solid angles: A. Van Oosterom and J. Strackee, 1983,
/// doi:10.1109/TBME.1983.325207.
pub fn is_inside(tree: &Bvh, (group, inside): (usize, Inside), point: &Vec3, stack: &mut Vec<(f64, u32)>) -> bool {
    let group = &tree.groups[group];
    if !tree.bounds_of(group.root).may_hold(point) {
        return false;
    }
    let counted = RAY_DIRECTIONS.iter().find_map(|direction| {
        let direction = &Vec3::from(*direction);
        Arch::new().dispatch(Crossings { tree, root: group.root, origin: point, direction, stack })
    });
    let angles = || winding_number(tree.triangles(group.blocks.clone()), point).round() as i64;
    inside.holds(counted.unwrap_or_else(angles))
}

/// Counts how much more often a ray leaves through triangles than it enters; `None` if a crossing
/// is uncertain.
struct Crossings<'a> {
    tree: &'a Bvh,
    root: Ref,
    origin: &'a Vec3,
    direction: &'a Vec3,
    stack: &'a mut Vec<(f64, u32)>,
}

impl WithSimd for Crossings<'_> {
    type Output = Option<i64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<i64> {
        let Self { tree, root, origin, direction, stack } = self;
        let place = [origin.x as f32, origin.y as f32, origin.z as f32];
        let inverse = [0, 1, 2].map(|i| (1.0 / direction[i]) as f32);
        // Far wider than the uncertain strip, so that a ray along a face of a box still meets the
        // triangles on that face.
        let rounding = rounding_at(origin, &tree.cuboid);
        let mut sum = 0;
        stack.clear();
        stack.push((0.0, root.0));
        while let Some((_, at)) = stack.pop() {
            let at = Ref(at);
            if at.is_block() {
                let block = &tree.blocks[at.index()];
                for lane in lanes_of(block.boxes.met_by(simd, &place, &inverse, rounding)) {
                    sum += crosses(&block.triangle(lane), origin, direction)?;
                }
            } else {
                let node = &tree.nodes[at.index()];
                for lane in lanes_of(node.boxes.met_by(simd, &place, &inverse, rounding)) {
                    stack.push((0.0, node.children[lane].0));
                }
            }
        }
        Some(sum)
    }
}

/// Returns 1 if a ray crosses a triangle along its normal, -1 if against it, 0 if not at all, and
/// `None` if this is uncertain.
fn crosses(triangle: &Triangle, origin: &Vec3, direction: &Vec3) -> Option<i64> {
    let [a, b, c] = triangle.points.map(|p| p - origin);
    let (e1, e2) = (b - a, c - a);
    let normal = e1.cross(&e2);
    let slope = normal.dot(direction);
    // Barycentric coordinates of the crossing, from triple products of corners and direction.
    let (u, v, w) =
        (direction.dot(&b.cross(&c)) / slope, direction.dot(&c.cross(&a)) / slope, direction.dot(&a.cross(&b)) / slope);
    let size = e1.norm_squared().max(e2.norm_squared());
    let far = a.norm().max(b.norm()).max(c.norm());
    // Rounding of the triple products grows with distance and edge length, not with the area.
    let doubt = DOUBT_SHARE + 1e-14 * far * size.sqrt() / slope.abs();
    let least = u.min(v).min(w);
    if slope.abs() <= DOUBT_SHARE * size || least.is_nan() {
        let along = far + size.sqrt();
        // The triangle is edge-on: the crossing is uncertain only if the ray comes near it.
        let axis = direction / direction.norm();
        let off = [a, b, c].map(|p| (p - axis * p.dot(&axis)).norm()).into_iter().fold(f64::INFINITY, f64::min);
        return if off > size.sqrt() + DOUBT_SHARE * along { Some(0) } else { None };
    }
    if least < -doubt {
        return Some(0);
    }
    let t = normal.dot(&a) / slope;
    if least <= doubt {
        return if t < -DOUBT_SHARE * far { Some(0) } else { None };
    }
    Some(if t <= 0.0 {
        0
    } else if slope > 0.0 {
        1
    } else {
        -1
    })
}

/// Number of times that the triangles wind around `point`: 1 or -1 inside a simple solid, 0
/// outside.
fn winding_number(triangles: impl Iterator<Item = Triangle>, point: &Vec3) -> f64 {
    let angle = |triangle: Triangle| {
        let [a, b, c] = triangle.points.map(|p| p - point);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let denominator = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2.0 * atan2(a.dot(&b.cross(&c)), denominator)
    };
    triangles.map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::shapes::mesh::MeshShape;
    use crate::collision::shapes::test_mesh::{bumpy, cuboid};
    use rand::{RngExt, SeedableRng};

    #[test]
    fn ray_parity_equals_winding_number() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(6);
        let shape = MeshShape::new(&bumpy(7, 3, 0.4));
        let mut stack = Vec::new();
        let mut inside = 0;
        for _ in 0..3000 {
            let p = Vec3::from_fn(|_, _| 2.4 * (rng.random::<f64>() - 0.5));
            let expected = winding_number(shape.tree.triangles(0..shape.tree.blocks.len()), &p).abs() > 0.5;
            assert_eq!(is_inside(&shape.tree, (0, Inside::Wound), &p, &mut stack), expected, "{p}");
            inside += usize::from(expected);
        }
        assert!((500..2500).contains(&inside));
    }

    #[test]
    fn rays_through_edges_and_corners_are_answered() {
        let shape = MeshShape::new(&cuboid(Vec3::zeros(), Vec3::new(1.0, 1.0, 1.0)));
        let mut stack = Vec::new();
        for d in RAY_DIRECTIONS {
            let d = Vec3::from(d);
            // Rays that aim at a corner, an edge, and the diagonal of a face.
            for target in [Vec3::new(1.0, 1.0, 1.0), Vec3::new(0.3, 1.0, 1.0), Vec3::new(0.5, 0.5, 1.0), Vec3::zeros()]
            {
                for step in [0.25, 0.5, 0.9, 3.0] {
                    let p = target - d * step;
                    let expected = p.abs().max() < 1.0;
                    if (p.abs().max() - 1.0).abs() > 1e-9 {
                        assert_eq!(is_inside(&shape.tree, (0, Inside::Wound), &p, &mut stack), expected, "{p}");
                    }
                }
            }
        }
        assert!(
            (winding_number(shape.tree.triangles(0..shape.tree.blocks.len()), &Vec3::new(0.1, 0.2, 0.3)) - 1.0).abs()
                < 1e-12
        );
        assert!(
            winding_number(shape.tree.triangles(0..shape.tree.blocks.len()), &Vec3::new(1.1, 0.2, 0.3)).abs() < 1e-12
        );
    }
}
