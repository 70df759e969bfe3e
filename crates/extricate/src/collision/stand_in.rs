//! What stands in for a shape where contacts with meshes are only proposed: a field of distances, and points of its surface.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::field::Field;
use super::shape::{Shape, ShapeKind};
use super::{Checker, convex::ConvexCore};
use crate::math::{Pose, Vec3};
use crate::robot::convex_hull::convex_hull;
use crate::robot::{Geometry, TriangleMesh};

/// Points that a surface is given, roughly: a link of a third of a metre has one every 2 cm.
const POINTS: f64 = 200.0;
/// Edge of a cluster of points, in distances between points.
const CLUSTER: f64 = 2.5;
/// The same of a group of clusters.
const GROUP: f64 = 7.5;
/// Points farther apart than this \[m\] see too little of contacts between them, and so do nodes half as far apart.
const COARSEST: f64 = 0.05;
/// Bands around round shapes.
const SEGMENTS: usize = 16;

/// In the frame of the shape.
#[derive(Debug)]
pub struct StandIn {
    /// None for shapes whose distances have a closed form.
    field: Option<Field>,
    /// Of clusters.
    groups: Vec<Gathered>,
    /// Of points.
    clusters: Vec<Gathered>,
    points: Vec<Vec3>,
    /// Between points \[m\].
    gap: f64,
}

/// Things in a ball.
#[derive(Debug)]
struct Gathered {
    center: Vec3,
    /// \[m\]
    radius: f64,
    members: Range<usize>,
}

/// A point of one shape's surface near another shape: frame of that other shape.
#[derive(Debug, Clone, Copy)]
pub struct NearPoint {
    /// Signed \[m\].
    pub distance: f64,
    /// The point.
    pub point: Vec3,
    /// Unit, away from the other shape.
    pub direction: Vec3,
}

impl StandIn {
    /// Looks at every part of the surface, and fills a grid where distances have no closed form.
    pub fn of(shape: &Shape) -> Self {
        let closed_form = matches!(&shape.kind, ShapeKind::Convex(solid) if solid.is_primitive());
        let (points, gap) = surface_points(&triangles(shape));
        // One a cell, the first.
        let mut thinned: BTreeMap<[i64; 3], Vec3> = BTreeMap::new();
        for point in points {
            thinned.entry(cell_of(&point, gap)).or_insert(point);
        }
        let mut points: Vec<Vec3> = thinned.into_values().collect();
        // By cells of groups, then of clusters.
        let cells = |point: &Vec3| [GROUP, CLUSTER].map(|edge| cell_of(point, edge * gap));
        points.sort_by_key(cells);
        let clusters = gathered(&points, |point| (*point, 0.0), |a, b| cells(a) == cells(b));
        let corner = |cluster: &Gathered| cells(&points[cluster.members.start])[0];
        let groups = gathered(&clusters, |cluster| (cluster.center, cluster.radius), |a, b| corner(a) == corner(b));
        Self { field: (!closed_form).then(|| Field::around(shape)), groups, clusters, points, gap }
    }

    /// Whether points of one of two shapes tell where they are near each other, and how near.
    pub fn can_tell(&self, other: &Self) -> bool {
        let sees = |points: &Self, field: &Self| {
            points.gap <= COARSEST && field.field.as_ref().is_none_or(|field| field.cell() <= 0.5 * COARSEST)
        };
        sees(self, other) || sees(other, self)
    }

    fn distance(&self, shape: &Shape, point: &Vec3) -> f64 {
        match (&self.field, &shape.kind) {
            (Some(field), _) => field.value(point),
            (None, ShapeKind::Convex(solid)) => -solid.depth(point),
            (None, ShapeKind::Mesh(_)) => f64::INFINITY,
        }
    }

    fn at_least(&self, shape: &Shape, point: &Vec3) -> f64 {
        self.field.as_ref().map_or_else(|| self.distance(shape, point), |field| field.at_least(point))
    }

    fn direction(&self, shape: &Shape, point: &Vec3) -> Option<Vec3> {
        if let Some(field) = &self.field {
            return field.direction(point);
        }
        let ShapeKind::Convex(solid) = &shape.kind else { return None };
        Some(solid.outward(point)).filter(|direction| *direction != Vec3::zeros())
    }
}

/// Appends the nearest point of every cluster of `of`'s surface that is nearer than `margin` \[m\] to `to`. `pose` maps
/// the frame of `of` to that of `to`.
pub fn near_points(of: &Shape, to: &Shape, pose: &Pose, margin: f64, found: &mut Vec<NearPoint>) {
    let (points, field) = (of.stand_in(), to.stand_in());
    let near = |ball: &&Gathered| field.at_least(to, &pose.point(&ball.center)) - ball.radius < margin;
    let groups = points.groups.iter().filter(near);
    for cluster in groups.flat_map(|group| &points.clusters[group.members.clone()]).filter(near) {
        let mut nearest = (margin, None);
        for point in points.points[cluster.members.clone()].iter().map(|point| pose.point(point)) {
            if field.at_least(to, &point) >= nearest.0 {
                continue;
            }
            let distance = field.distance(to, &point);
            if distance < nearest.0 {
                nearest = (distance, Some(point));
            }
        }
        if let (distance, Some(point)) = nearest
            && let Some(direction) = field.direction(to, &point)
        {
            found.push(NearPoint { distance, point, direction });
        }
    }
}

impl Checker {
    /// Makes now what proposals of contacts with meshes need, on all threads of the current pool; else the first of them does.
    pub fn prepare_proposals(&self) {
        let parts = |body: usize| &self.bodies.parts[self.bodies.bodies[body].parts.clone()];
        let is_mesh = |body: usize| parts(body).iter().any(|part| matches!(part.shape.kind, ShapeKind::Mesh(_)));
        let mut wanted = vec![false; self.bodies.bodies.len()];
        for pair in self.pairs.iter().filter(|pair| is_mesh(pair.first) || is_mesh(pair.second)) {
            (wanted[pair.first], wanted[pair.second]) = (true, true);
        }
        let bodies: Vec<usize> = (0..wanted.len()).filter(|body| wanted[*body]).collect();
        bodies.par_iter().flat_map(|body| parts(*body)).for_each(|part| {
            part.shape.stand_in();
        });
    }
}

fn triangles(shape: &Shape) -> Vec<[Vec3; 3]> {
    let solid = match &shape.kind {
        ShapeKind::Mesh(mesh) => return mesh.tree.triangles(0..mesh.tree.blocks.len()).map(|t| t.points).collect(),
        ShapeKind::Convex(solid) => solid,
    };
    let radius = solid.shape.radius;
    let mesh = match &solid.shape.core {
        ConvexCore::Point => Geometry::Sphere { radius }.tessellate(SEGMENTS),
        ConvexCore::Segment { half_length } => {
            Geometry::Capsule { radius, half_length: *half_length }.tessellate(SEGMENTS)
        }
        ConvexCore::Box { half_extents } => Geometry::Box { half_extents: *half_extents }.tessellate(SEGMENTS),
        ConvexCore::Cylinder { radius, half_length } => {
            Geometry::Cylinder { radius: *radius, half_length: *half_length }.tessellate(SEGMENTS)
        }
        ConvexCore::Triangle(corners) => TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2]]),
        ConvexCore::Hull(hull) => match convex_hull(hull.points()) {
            Some(mesh) => mesh,
            // Flat: its points alone.
            None => return hull.points().iter().map(|point| [*point; 3]).collect(),
        },
    };
    (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect()
}

/// Corners, then points of edges, then of faces, about `POINTS` where they are thinned to one in each cell as wide as the second result \[m\].
fn surface_points(triangles: &[[Vec3; 3]]) -> (Vec<Vec3>, f64) {
    let area: f64 = triangles.iter().map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum();
    let gap = (area / POINTS).sqrt().max(1e-9);
    let mut points: Vec<Vec3> = triangles.iter().flatten().copied().collect();
    for [a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let steps = ((to - from).norm() / gap).ceil() as usize;
            points.extend((1..steps).map(|k| from + (to - from) * (k as f64 / steps as f64)));
        }
    }
    for [a, b, c] in triangles {
        let steps = ((b - a).norm().max((c - a).norm()) / gap).ceil() as usize;
        let share = 1.0 / steps.max(1) as f64;
        points.extend(
            (1..steps)
                .flat_map(|i| (1..steps - i).map(move |j| (i, j)))
                .map(|(i, j)| a + (b - a) * (i as f64 * share) + (c - a) * (j as f64 * share)),
        );
    }
    (points, gap)
}

/// Runs of neighbouring members that belong together, in balls.
fn gathered<T>(members: &[T], ball: impl Fn(&T) -> (Vec3, f64), together: impl Fn(&T, &T) -> bool) -> Vec<Gathered> {
    let mut start = 0;
    let runs = members.chunk_by(together).map(|run| {
        let center = run.iter().map(|member| ball(member).0).sum::<Vec3>() / run.len() as f64;
        let reach = |member| (ball(member).0 - center).norm() + ball(member).1;
        let radius = run.iter().map(reach).fold(0.0, f64::max);
        start += run.len();
        Gathered { center, radius, members: start - run.len()..start }
    });
    runs.collect()
}

fn cell_of(point: &Vec3, edge: f64) -> [i64; 3] {
    [point.x, point.y, point.z].map(|x| (x / edge).floor() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::test_mesh::{bumpy, cuboid, opened, placed};
    use rand::{RngExt, SeedableRng};
    use std::sync::Arc;

    #[test]
    fn points_near_a_shape_are_found_at_their_distance() {
        let mesh = |mesh| Geometry::Mesh(Arc::new(mesh));
        let shapes = [
            mesh(placed(bumpy(3, 3, 0.3), 0.2, Vec3::new(0.1, 0.0, 0.0))),
            mesh(opened(placed(bumpy(5, 3, 0.2), 0.15, Vec3::zeros()), 30)),
            Geometry::ConvexHull(Arc::new(cuboid(Vec3::zeros(), Vec3::new(0.1, 0.2, 0.05)))),
            Geometry::Box { half_extents: Vec3::new(0.5, 0.6, 0.02) },
            Geometry::Capsule { radius: 0.06, half_length: 0.1 },
            Geometry::Cylinder { radius: 0.06, half_length: 0.1 },
        ]
        .map(|geometry| Shape::new(&geometry).unwrap());
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let (mut stack, mut off, mut count) = (Vec::new(), Vec::new(), 0);
        for round in 0..3000 {
            let mut vector = |scale: f64| Vec3::from_fn(|_, _| scale * (rng.random::<f64>() - 0.5));
            let pose = Pose::from_xyz_rpy(vector(0.7).into(), vector(6.0).into());
            let (of, to) = (&shapes[round % 6], &shapes[round / 6 % 6]);
            let mut found = Vec::new();
            near_points(of, to, &pose, 0.02, &mut found);
            let nearest = of.stand_in().points.iter().map(|p| -to.depth(&pose.point(p), &mut stack));
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            let first = found.iter().map(|near| near.distance).fold(f64::INFINITY, f64::min);
            if nearest < 0.01 {
                assert!(first < 0.02, "{round}: {nearest} missed");
                off.push((first - nearest).abs());
            }
            for near in found {
                let exact = -to.depth(&near.point, &mut stack);
                assert!((near.distance - exact).abs() < 0.02, "{round}: {} {exact}", near.distance);
                assert!((near.direction.norm() - 1.0).abs() < 1e-9);
                count += 1;
            }
        }
        off.sort_by(f64::total_cmp);
        assert!(count > 3000 && off.len() > 500, "{count} points, {} pairs", off.len());
        let median = off[off.len() / 2];
        assert!(median < 1e-3, "half of the nearest points are off by {median}");
    }

    #[test]
    fn surfaces_are_covered() {
        for geometry in [
            Geometry::Mesh(Arc::new(bumpy(3, 3, 0.3))),
            Geometry::Box { half_extents: Vec3::new(1.0, 2.0, 0.1) },
            Geometry::Sphere { radius: 0.5 },
        ] {
            let shape = Shape::new(&geometry).unwrap();
            let (all, gap) = surface_points(&triangles(&shape));
            let stand_in = shape.stand_in();
            let nearest = |p: &Vec3| stand_in.points.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
            assert!(all.iter().all(|p| nearest(p) < 2.0 * gap));
            assert!((50..1000).contains(&stand_in.points.len()), "{}", stand_in.points.len());
            let of_clusters = stand_in.groups.iter().flat_map(|group| group.members.clone());
            assert!(of_clusters.eq(0..stand_in.clusters.len()));
            for cluster in &stand_in.clusters {
                let held = |p: &Vec3| (p - cluster.center).norm() <= cluster.radius * (1.0 + 1e-9);
                assert!(stand_in.points[cluster.members.clone()].iter().all(held));
            }
        }
    }
}
