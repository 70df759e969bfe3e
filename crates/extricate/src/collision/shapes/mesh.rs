//! A mesh prepared for checks: its tree, and which of its components bound a solid. No pairs.

use super::bvh::{Bvh, Nearest, TreeLayout, build};
use crate::collision::narrow_phase::containment::{Inside, is_inside};
use crate::math::Vec3;
use crate::robot::TriangleMesh;

/// A mesh with its tree. Components without triangles are dropped. Triangles of closed components
/// face out of the solid, as in the mesh.
#[derive(Debug, Clone)]
pub struct MeshShape {
    /// Tree with one group for each solid and one for all triangles of open components. A solid is
    /// a closed component with its cavities.
    pub tree: Bvh,
    /// Whether each group is closed. A closed group is a solid by itself, even within another one;
    /// an open group is a surface.
    pub closed: Vec<bool>,
    /// Rule of each solid for points inside it.
    insides: Vec<Inside>,
    /// One vertex of each component.
    pub representatives: Vec<Vec3>,
    /// All vertices that triangles use.
    pub vertices: Vec<Vec3>,
}

impl MeshShape {
    /// Prepares `mesh`, which must have a triangle.
    pub fn new(mesh: &TriangleMesh) -> Self {
        Self::with_tree(mesh, |groups| Some(build(groups))).expect("a tree can be built of any triangles")
    }

    /// Prepares `mesh` with a tree from `layout`; `None` if that does not fit.
    pub fn with_layout(mesh: &TriangleMesh, layout: TreeLayout) -> Option<Self> {
        Self::with_tree(mesh, |groups| Bvh::with_layout(groups, layout))
    }

    fn with_tree(mesh: &TriangleMesh, tree: impl FnOnce(&[Vec<[Vec3; 3]>]) -> Option<Bvh>) -> Option<Self> {
        let components = || mesh.components.iter().filter(|c| !c.triangles.is_empty());
        let corners = |t: &[u32; 3]| t.map(|v| mesh.vertices[v as usize]);
        let mut solids: Vec<(Vec<[u32; 3]>, bool)> = Vec::new();
        for (index, component) in mesh.components.iter().enumerate() {
            if component.closed && !component.triangles.is_empty() {
                let triangles = &mesh.triangles[component.triangles.clone()];
                match solids.last_mut().filter(|_| mesh.is_cavity(index)) {
                    Some((solid, has_cavities)) => {
                        solid.extend(triangles);
                        *has_cavities = true;
                    }
                    None => solids.push((triangles.to_vec(), false)),
                }
            }
        }
        let insides = solids.iter().map(|(solid, has_cavities)| Inside::of(solid, *has_cavities)).collect();
        let mut groups: Vec<Vec<[Vec3; 3]>> =
            solids.iter().map(|(solid, _)| solid.iter().map(corners).collect()).collect();
        let mut closed = vec![true; groups.len()];
        let open = components().filter(|c| !c.closed);
        let surfaces: Vec<[Vec3; 3]> =
            open.flat_map(|c| mesh.triangles[c.triangles.clone()].iter().map(corners)).collect();
        if !surfaces.is_empty() {
            groups.push(surfaces);
            closed.push(false);
        }
        let mut used = vec![false; mesh.vertices.len()];
        mesh.triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
        Some(Self {
            tree: tree(&groups)?,
            closed,
            insides,
            representatives: components().map(|c| corners(&mesh.triangles[c.triangles.start])[0]).collect(),
            vertices: mesh.vertices.iter().zip(used).filter_map(|(v, used)| used.then_some(*v)).collect(),
        })
    }

    /// Whether `point` lies inside a solid.
    pub fn holds(&self, point: &Vec3, stack: &mut Vec<(f64, u32)>) -> bool {
        self.tree.cuboid.may_hold(point)
            && (0..self.insides.len()).any(|c| is_inside(&self.tree, (c, self.insides[c]), point, stack))
    }

    /// Depth \[m\] of `point` in the solid that contains it deepest, and the nearest point of its
    /// surface. `None` if the depth does not exceed `floor` >= 0.
    pub fn depth_inside(&self, point: &Vec3, floor: f64, stack: &mut Vec<(f64, u32)>) -> Option<(f64, Vec3)> {
        let mut best = None;
        let mut floor_squared = floor * floor;
        for c in 0..self.insides.len() {
            let root = self.tree.groups[c].root;
            if !self.tree.bounds_of(root).may_hold(point) {
                continue;
            }
            let nearest = self.tree.closest_point(root, point, f64::INFINITY, floor_squared, stack);
            if let Some(Nearest { point: surface, squared, .. }) = nearest
                && squared > floor_squared
                && is_inside(&self.tree, (c, self.insides[c]), point, stack)
            {
                (best, floor_squared) = (Some((squared.sqrt(), surface)), squared);
            }
        }
        best
    }

    /// Signed depth \[m\] of `point`, if above `least`. Inside, it is the depth in the deepest
    /// solid, a lower bound of that in the union of all. Outside, it is minus the distance to the
    /// nearest triangle.
    pub fn depth_above(&self, point: &Vec3, least: f64, stack: &mut Vec<(f64, u32)>) -> Option<f64> {
        if let Some((depth, _)) = self.depth_inside(point, least.max(0.0), stack) {
            return Some(depth);
        }
        if least >= 0.0 {
            return None;
        }
        let nearest = self.tree.closest_point(self.tree.root, point, least * least, 0.0, stack);
        nearest.map(|near| -near.squared.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::shapes::test_mesh::{bumpy, cuboid, joined, opened};

    #[test]
    fn shuffled_windings_are_mended() {
        let mesh = bumpy(1, 3, 0.2);
        for flip in [1, 2, 3] {
            let mut triangles = mesh.triangles.clone();
            triangles.iter_mut().step_by(flip).for_each(|t| t.swap(0, 1));
            let shape = MeshShape::new(&TriangleMesh::new(mesh.vertices.clone(), triangles));
            assert_eq!(shape.tree.triangles(0..shape.tree.blocks.len()).count(), mesh.triangles.len());
            for triangle in shape.tree.triangles(0..shape.tree.blocks.len()) {
                let [a, b, c] = triangle.points;
                assert!((b - a).cross(&(c - a)).dot(&(a + b + c)) > 0.0);
            }
        }
    }

    #[test]
    fn depth_is_that_of_the_deepest_component() {
        let big = cuboid(Vec3::zeros(), Vec3::new(1.0, 1.0, 1.0));
        let small = cuboid(Vec3::new(0.5, 0.0, 0.0), Vec3::new(0.25, 0.25, 0.25));
        let lid = opened(cuboid(Vec3::new(3.0, 0.0, 0.0), Vec3::new(0.5, 0.5, 0.5)), 2);
        let shape = MeshShape::new(&joined(&[big, small, lid]));
        let mut stack = Vec::new();
        let mut above = |x: f64, least: f64| shape.depth_above(&Vec3::new(x, 0.01, 0.02), least, &mut stack);
        let mut depth = |x: f64| above(x, f64::NEG_INFINITY).unwrap();
        assert!((depth(0.5) - 0.5).abs() < 1e-12, "a shell within the solid does not make it shallower");
        assert!((depth(0.1) - 0.9).abs() < 1e-12);
        assert!((depth(1.5) + 0.5).abs() < 1e-12);
        assert!((depth(3.0) + 0.48).abs() < 1e-12, "an open box holds nothing: {}", depth(3.0));
    }

    /// Boxes with either winding, as files may have them, and the total winding number around a
    /// point.
    fn nest(boxes: &[(Vec3, Vec3, bool)]) -> (MeshShape, impl Fn(&Vec3) -> i32) {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for (center, half, outward) in boxes {
            let mesh = cuboid(*center, *half);
            let first = vertices.len() as u32;
            vertices.extend(mesh.vertices);
            let wound = |[a, b, c]: [u32; 3]| if *outward { [a, b, c] } else { [a, c, b] };
            triangles.extend(mesh.triangles.iter().map(|t| wound(t.map(|v| v + first))));
        }
        let boxes = boxes.to_vec();
        let winding = move |p: &Vec3| {
            let within = |center: &Vec3, half: &Vec3| (0..3).all(|k| (p[k] - center[k]).abs() < half[k]);
            boxes
                .iter()
                .map(|(c, h, outward)| {
                    if !within(c, h) {
                        0
                    } else if *outward {
                        1
                    } else {
                        -1
                    }
                })
                .sum()
        };
        (MeshShape::new(&TriangleMesh::new(vertices, triangles)), winding)
    }

    /// Distance to the nearest side of any box.
    fn from_sides(p: &Vec3, boxes: &[(Vec3, Vec3, bool)]) -> f64 {
        let from = |(center, half, _): &(Vec3, Vec3, bool)| {
            let beyond = (p - center).abs() - half;
            let outside = beyond.sup(&Vec3::zeros()).norm();
            if outside > 0.0 { outside } else { -beyond.max() }
        };
        boxes.iter().map(from).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn cavities_three_deep_are_free_and_their_walls_solid() {
        let at = |x: f64, half: f64, outward: bool| (Vec3::new(x, 0.0, 0.0), Vec3::repeat(half), outward);
        let boxes = [
            at(0.0, 1.0, true),
            at(0.1, 0.85, false),
            at(0.15, 0.7, true),
            at(0.2, 0.5, false),
            at(0.25, 0.4, true),
            at(0.3, 0.2, false),
            // Another solid that overlaps the outermost wall from outside and reaches into the
            // first cavity.
            (Vec3::new(0.0, -1.0, 0.0), Vec3::new(0.1, 0.2, 0.1), true),
        ];
        let (shape, winding) = nest(&boxes);
        assert_eq!(shape.closed.len(), 4, "a solid and its cavities are one group");
        let mut rng: rand_chacha::ChaCha8Rng = rand::SeedableRng::seed_from_u64(3);
        let (mut free, mut held, stack) = (0, 0, &mut Vec::new());
        for _ in 0..4000 {
            let p = Vec3::from_fn(|_, _| 2.6 * (rand::RngExt::random::<f64>(&mut rng) - 0.5));
            let depth = shape.depth_above(&p, f64::NEG_INFINITY, stack).unwrap();
            let nearest = from_sides(&p, &boxes);
            assert_eq!(shape.holds(&p, stack), winding(&p) > 0, "{p}");
            if winding(&p) > 0 {
                held += 1;
                // The depth is at least the distance to the nearest side of all. A ball of this
                // radius never reaches free space.
                assert!(depth >= nearest - 1e-12, "{p} {depth} {nearest}");
                let air = (0..600).map(|k| {
                    let way = Vec3::new((k as f64).sin(), (k as f64 * 1.7).cos(), (k as f64 * 0.3).sin()).normalize();
                    p + way * (depth * (1.0 - 1e-9))
                });
                assert!(air.into_iter().all(|q| winding(&q) > 0), "{p}: a ball of its depth reaches into the air");
            } else {
                free += usize::from((0..3).all(|k| p[k].abs() < 0.85));
                assert!((depth + nearest).abs() < 1e-12, "{p} {depth} {nearest}");
            }
        }
        assert!(free > 200 && held > 300, "{free} {held}");
    }

    #[test]
    fn solids_that_overlap_stay_solid_also_where_they_share_a_corner() {
        let at = |c: f64, half: f64| (Vec3::repeat(c), Vec3::repeat(half), true);
        for boxes in [[at(0.0, 0.5), at(0.25, 0.25)], [at(0.0, 0.5), at(0.3, 0.5)], [at(0.0, 0.5), at(0.0, 0.25)]] {
            let (shape, winding) = nest(&boxes);
            let mut rng: rand_chacha::ChaCha8Rng = rand::SeedableRng::seed_from_u64(4);
            for _ in 0..500 {
                let p = Vec3::from_fn(|_, _| 1.8 * (rand::RngExt::random::<f64>(&mut rng) - 0.5));
                assert_eq!(shape.holds(&p, &mut Vec::new()), winding(&p) != 0, "{p}");
            }
        }
    }
}
