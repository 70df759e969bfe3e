//! Convex hulls of vertex sets, by Quickhull with exact predicates.
//!
//! The collision library's hull asserts what rounding can break and has no proof, so this one
//! decides every side with exact arithmetic; the tests compare the two.

use robust::{Coord3D, orient3d};

use super::part::Component;
use crate::math::Vec3;
use crate::robot::TriangleMesh;

/// Points are flat if their width or height is below this share of their largest extent.
const FLAT_EXTENT_SHARE: f64 = 1e-9;

/// Returns the convex hull as a closed mesh with outward faces; `None` if the points lie (nearly)
/// in one plane.
///
/// # Guarantee
/// In exact arithmetic, no point lies beyond the plane of a face, so every point is in the hull.
/// Every vertex is one of `points`, unchanged. Never panics; points that are not finite, or beyond
/// 1e60, give `None`.
///
/// # Source
/// Barber, Dobkin, Huhdanpaa, "The Quickhull algorithm for convex hulls", ACM TOMS 22(4), 1996,
/// doi:10.1145/235815.235821. It works on triangles here, without merging, and Shewchuk's exact
/// predicate (1997, doi:10.1007/PL00009321) replaces its tolerances. A point in the plane of a face
/// does not see it.
pub fn convex_hull(points: &[Vec3]) -> Option<TriangleMesh> {
    let [a, b, c, d] = simplex(points)?;
    let mut hull = Hull { points, facets: Vec::new(), facet_at: vec![usize::MAX; points.len()] };
    for (corners, adjacent) in
        [([a, b, c], [3, 1, 2]), ([b, d, c], [3, 2, 0]), ([c, d, a], [1, 3, 0]), ([a, d, b], [2, 1, 0])]
    {
        hull.push(corners, adjacent);
    }
    hull.assign(0..points.len() as u32, 0..4);
    let mut open = vec![0, 1, 2, 3];
    while let Some(facet) = open.pop() {
        if hull.facets[facet].alive && !hull.facets[facet].outside.is_empty() {
            open.extend(hull.grow(facet)?);
        }
    }
    hull.into_mesh()
}

/// Four points that span a volume, the first three counter-clockwise seen from outside.
fn simplex(points: &[Vec3]) -> Option<[u32; 4]> {
    if points.len() < 4 || !points.iter().all(|p| p.iter().all(|x| x.abs() < 1e60)) {
        return None;
    }
    let farthest = |measure: &dyn Fn(&Vec3) -> f64| {
        let index = (0..points.len()).max_by(|&i, &j| measure(&points[i]).total_cmp(&measure(&points[j])))?;
        Some((index as u32, points[index], measure(&points[index])))
    };
    let extent = |axis: usize| Some((farthest(&|p| -p[axis])?, farthest(&|p| p[axis])?));
    let ends = [extent(0)?, extent(1)?, extent(2)?];
    let length = |(low, high): &((u32, Vec3, f64), (u32, Vec3, f64))| low.2 + high.2;
    let widest = ends.iter().max_by(|x, y| length(x).total_cmp(&length(y)))?;
    let ((a, base, _), (b, tip, _)) = *widest;
    let line = (tip - base).try_normalize(0.0)?;
    let (c, third, width) = farthest(&|p| (p - base).cross(&line).norm())?;
    let normal = line.cross(&(third - base)).try_normalize(0.0)?;
    let (d, fourth, height) = farthest(&|p| (p - base).dot(&normal).abs())?;
    let least = FLAT_EXTENT_SHARE * length(widest);
    if !(width > least && height > least) {
        return None;
    }
    let side = orient3d(coord(&base), coord(&tip), coord(&third), coord(&fourth));
    if side > 0.0 {
        Some([a, b, c, d])
    } else if side < 0.0 {
        Some([b, a, c, d])
    } else {
        None
    }
}

fn coord(p: &Vec3) -> Coord3D<f64> {
    Coord3D { x: p.x, y: p.y, z: p.z }
}

struct Facet {
    /// Vertices, counter-clockwise seen from outside.
    corners: [u32; 3],
    /// The facet across the side that begins at each corner.
    adjacent: [usize; 3],
    /// Outward normal of any length.
    normal: Vec3,
    /// Points beyond this facet, the farthest last (by rounded distance; any order would do).
    outside: Vec<u32>,
    reach: f64,
    alive: bool,
}

struct Hull<'a> {
    points: &'a [Vec3],
    facets: Vec<Facet>,
    /// Scratch: the new facet whose horizon side begins at each vertex.
    facet_at: Vec<usize>,
}

impl Hull<'_> {
    fn push(&mut self, corners: [u32; 3], adjacent: [usize; 3]) {
        let [a, b, c] = corners.map(|index| self.points[index as usize]);
        let normal = (b - a).cross(&(c - a));
        self.facets.push(Facet {
            corners,
            adjacent,
            normal,
            outside: Vec::new(),
            reach: f64::NEG_INFINITY,
            alive: true,
        });
    }

    fn sees(&self, point: u32, facet: usize) -> bool {
        let [a, b, c] = self.facets[facet].corners.map(|index| coord(&self.points[index as usize]));
        orient3d(a, b, c, coord(&self.points[point as usize])) < 0.0
    }

    /// Gives each point to the first of `facets` that it sees; a point that sees none is inside the
    /// hull.
    fn assign(&mut self, points: impl IntoIterator<Item = u32>, facets: std::ops::Range<usize>) {
        for point in points {
            let Some(facet) = facets.clone().find(|&facet| self.sees(point, facet)) else { continue };
            let facet = &mut self.facets[facet];
            let reach = (self.points[point as usize] - self.points[facet.corners[0] as usize]).dot(&facet.normal);
            facet.outside.push(point);
            if reach > facet.reach {
                facet.reach = reach;
            } else {
                let last = facet.outside.len() - 1;
                facet.outside.swap(last - 1, last);
            }
        }
    }

    /// Adds the farthest point beyond `facet` to the hull, and returns the new facets. `None`
    /// cannot happen while the predicate is exact.
    fn grow(&mut self, facet: usize) -> Option<std::ops::Range<usize>> {
        let apex = self.facets[facet].outside.pop()?;
        self.facets[facet].alive = false;
        let mut orphans = Vec::new();
        let mut visible = vec![facet];
        let mut horizon = Vec::new();
        while let Some(seen) = visible.pop() {
            orphans.append(&mut self.facets[seen].outside);
            for k in 0..3 {
                let other = self.facets[seen].adjacent[k];
                if !self.facets[other].alive {
                    continue;
                }
                if self.sees(apex, other) {
                    self.facets[other].alive = false;
                    visible.push(other);
                } else {
                    let corners = self.facets[seen].corners;
                    horizon.push((corners[k], corners[(k + 1) % 3], other));
                }
            }
        }
        let first = self.facets.len();
        for &(from, to, other) in &horizon {
            let new = self.facets.len();
            self.facet_at[from as usize] = new;
            let side = (0..3).find(|&k| self.facets[other].corners[k] == to)?;
            self.facets[other].adjacent[side] = new;
            self.push([from, to, apex], [other, usize::MAX, usize::MAX]);
        }
        for (new, &(_, to, _)) in (first..).zip(&horizon) {
            let next = self.facet_at[to as usize];
            if !(first..self.facets.len()).contains(&next) {
                return None;
            }
            self.facets[new].adjacent[1] = next;
            self.facets[next].adjacent[2] = new;
        }
        let new = first..self.facets.len();
        self.assign(orphans, new.clone());
        Some(new)
    }

    fn into_mesh(self) -> Option<TriangleMesh> {
        let mut new_index = vec![u32::MAX; self.points.len()];
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
        for facet in self.facets.iter().filter(|facet| facet.alive) {
            triangles.push(facet.corners.map(|old| {
                let slot = &mut new_index[old as usize];
                if *slot == u32::MAX {
                    *slot = vertices.len() as u32;
                    vertices.push(self.points[old as usize]);
                }
                *slot
            }));
        }
        let components = vec![Component { triangles: 0..triangles.len(), closed: true }];
        Some(TriangleMesh { vertices, triangles, components })
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::robot::Geometry;

    fn volume(mesh: &TriangleMesh) -> f64 {
        (0..mesh.triangles.len()).map(|t| mesh.corners(t)).map(|[a, b, c]| a.cross(&b).dot(&c) / 6.0).sum()
    }

    /// Asserts that the hull is closed, outward and convex, and that no point is beyond a face by
    /// more than 1e-9 of the diagonal.
    fn assert_hull(points: &[Vec3]) -> TriangleMesh {
        let hull = convex_hull(points).unwrap();
        let welded = TriangleMesh::new(hull.vertices.clone(), hull.triangles.clone());
        assert_eq!(hull.triangles.len(), 2 * hull.vertices.len() - 4, "Euler");
        assert!(welded.triangles.len() < hull.triangles.len() || welded.is_closed());
        assert!(volume(&hull) > 0.0);
        let (low, high) = points.iter().fold((points[0], points[0]), |(l, h), p| (l.inf(p), h.sup(p)));
        let tolerance = 1e-9 * (high - low).norm();
        for t in 0..hull.triangles.len() {
            let [a, b, c] = hull.corners(t);
            // A sliver's normal means nothing in rounded arithmetic; its sides were decided
            // exactly.
            let cross = (b - a).cross(&(c - a));
            if cross.norm() > 1e-6 * (b - a).norm() * (c - a).norm() {
                let normal = cross.normalize();
                assert!(points.iter().all(|p| normal.dot(&(p - a)) <= tolerance));
            }
            let [a, b, c] = [a, b, c].map(|p| coord(&p));
            assert!(points.iter().all(|p| orient3d(a, b, c, coord(p)) >= 0.0));
        }
        hull
    }

    fn cloud(rng: &mut ChaCha8Rng, count: usize) -> Vec<Vec3> {
        (0..count).map(|_| Vec3::from_fn(|_, _| rng.random::<f64>() - 0.5)).collect()
    }

    #[test]
    fn agrees_with_the_collision_library() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for count in [4, 5, 8, 30, 300] {
            let points = cloud(&mut rng, count);
            let hull = assert_hull(&points);
            let theirs: Vec<_> = points.iter().map(|p| parry3d_f64::math::Vector::new(p.x, p.y, p.z)).collect();
            let (vertices, faces) = parry3d_f64::transformation::try_convex_hull(&theirs).unwrap();
            let corner = |k: u32| Vec3::new(vertices[k as usize].x, vertices[k as usize].y, vertices[k as usize].z);
            let expected: f64 = faces.iter().map(|f| corner(f[0]).cross(&corner(f[1])).dot(&corner(f[2])) / 6.0).sum();
            assert!((volume(&hull) - expected).abs() < 1e-12, "{count}");
            assert_eq!(hull.vertices.len(), vertices.len());
        }
    }

    #[test]
    fn degenerate_positions_are_exact() {
        let grid: Vec<Vec3> =
            (0..125).map(|k| Vec3::new((k % 5) as f64, (k / 5 % 5) as f64, (k / 25) as f64) * 0.1).collect();
        assert_eq!(assert_hull(&grid).vertices.len(), 8);
        let mut twice = grid.clone();
        twice.extend(grid.iter().map(|p| p.add_scalar(1e-17)));
        assert!((volume(&assert_hull(&twice)) - 0.064).abs() < 1e-12);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for noise in [1e-16, 1e-13, 1e-10, 1e-7] {
            let noisy: Vec<Vec3> = grid.iter().zip(cloud(&mut rng, 125)).map(|(p, n)| p + n * noise).collect();
            assert_hull(&noisy);
        }
        for shape in [
            Geometry::Sphere { radius: 0.3 },
            Geometry::Cylinder { radius: 0.3, half_length: 1e-4 },
            Geometry::Capsule { radius: 1e-3, half_length: 2.0 },
        ] {
            let mesh = shape.tessellate(24);
            let turned = crate::math::Pose::from_xyz_rpy([5.0, 0.1, -3.0], [0.3, 1.1, -2.0]);
            let points: Vec<Vec3> = mesh.vertices.iter().map(|v| turned.point(v)).collect();
            let hull = assert_hull(&points);
            assert!((volume(&hull) / volume(&mesh) - 1.0).abs() < 1e-9, "{shape:?}");
        }
    }

    #[test]
    fn flat_and_senseless_input_is_none() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let square: Vec<Vec3> = cloud(&mut rng, 50).into_iter().map(|p| Vec3::new(p.x, p.y, 2.0)).collect();
        let line: Vec<Vec3> = square.iter().map(|p| Vec3::new(p.x, 2.0 * p.x, 3.0 * p.x)).collect();
        let nearly: Vec<Vec3> = cloud(&mut rng, 50).into_iter().map(|p| Vec3::new(p.x, p.y, 1e-11 * p.z)).collect();
        for points in [vec![], square, line, nearly, vec![Vec3::zeros(); 9], vec![Vec3::repeat(f64::NAN); 9]] {
            assert!(convex_hull(&points).is_none());
        }
        let thin: Vec<Vec3> = cloud(&mut rng, 50).into_iter().map(|p| Vec3::new(p.x, p.y, 1e-6 * p.z)).collect();
        assert_hull(&thin);
        assert!(convex_hull(&[Vec3::repeat(f64::INFINITY), Vec3::x(), Vec3::y(), Vec3::z()]).is_none());
    }
}
