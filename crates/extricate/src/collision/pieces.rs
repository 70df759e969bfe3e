//! Convex pieces that together hold a mesh: its box is cut, plane by plane, until the hull of what lies in each cell follows the surface.
//! One mesh, no pairs.

use rayon::prelude::*;

use super::Checker;
use super::bounds::{Aabb, bounding_ball};
use super::convex::{ConvexCore, ConvexShape, HullPoints};
use super::mesh_shape::MeshShape;
use super::shape::{ConvexSolid, Shape, ShapeKind};
use crate::math::Vec3;
use crate::robot::TriangleMesh;
use crate::robot::convex_hull::convex_hull;

/// Most pieces of a mesh.
const MOST: usize = 48;
/// How far a piece may stand out of the mesh, as a share of the radius of the mesh's ball.
const TOLERANCE: f64 = 0.004;
/// Cuts tried at a notch.
const CUTS: usize = 8;
/// Faces of a hull whose distance from the mesh is looked at.
const FACES_LOOKED_AT: usize = 48;
/// The same while cuts are compared.
const FACES_GLANCED_AT: usize = 8;
/// What the length of a cut's edge, as a share of the size of the cell, is worth, as a share of the depth of the notch.
const SHORT: f64 = 0.1;
/// What flat hulls are thickened by, as a share of the radius of the mesh's ball.
const THICKNESS: f64 = 1e-6;

/// A convex cell of space, and what of the mesh lies in it.
struct Cell {
    /// Its surface.
    walls: Vec<[Vec3; 3]>,
    triangles: Vec<[Vec3; 3]>,
    hull: TriangleMesh,
    notch: Option<Notch>,
}

/// Where a hull stands out of the mesh farthest.
#[derive(Clone, Copy)]
struct Notch {
    /// How far \[m\].
    depth: f64,
    /// The nearest point of the mesh.
    bottom: Vec3,
    /// Unit, from there to the hull.
    outward: Vec3,
    /// Unit, of the triangle there.
    normal: Vec3,
}

/// Points with `normal . x > offset` are above.
#[derive(Clone, Copy)]
struct Cut {
    normal: Vec3,
    offset: f64,
    /// What is nearer to the plane is in it \[m\].
    thickness: f64,
}

/// Convex shapes in the frame of `mesh` whose union holds its closed components and its surfaces.
///
/// Each is the hull of what lies in one cell, corners of the cell within the solid included. They stand out of the mesh by [`TOLERANCE`]
/// where no more than [`MOST`] are needed for that, as far as their largest faces tell.
pub fn pieces(mesh: &MeshShape, bounds: &Aabb) -> Vec<Shape> {
    let radius = bounds.half.norm();
    let divider = Divider { mesh, thickness: THICKNESS * radius };
    let mut stack = Vec::new();
    let box_around = convex_hull(&bounds.corners());
    let walls = box_around.map_or_else(Vec::new, |hull| corners(&hull).collect());
    let triangles = mesh.tree.triangles(0..mesh.tree.blocks.len()).map(|t| t.points).collect();
    let mut cells: Vec<Cell> = divider.cell(walls, triangles, &mut stack).into_iter().collect();
    let depth = |cell: &Cell| cell.notch.map_or(0.0, |notch| notch.depth);
    while cells.len() < MOST {
        let deepest = (0..cells.len()).max_by(|i, j| depth(&cells[*i]).total_cmp(&depth(&cells[*j])));
        let Some(deepest) = deepest.filter(|at| depth(&cells[*at]) > TOLERANCE * radius) else { break };
        let cell = cells.swap_remove(deepest);
        let cut = cell.notch.and_then(|notch| divider.best_cut(&cell, &notch));
        match cut {
            Some(cut) => cells.extend(divider.halves(&cell, &cut, &mut stack)),
            None => cells.push(Cell { notch: None, ..cell }),
        }
    }
    cells.into_iter().map(|cell| solid(&cell.hull.vertices)).collect()
}

impl Checker {
    /// Makes now the convex pieces of every mesh that is part of a checked pair, on all threads of the current pool; else the first to need them
    /// does.
    pub fn prepare_proposals(&self) {
        let parts = |body: usize| &self.bodies.parts[self.bodies.bodies[body].parts.clone()];
        let mut wanted = vec![false; self.bodies.bodies.len()];
        for pair in &self.pairs {
            (wanted[pair.first], wanted[pair.second]) = (true, true);
        }
        let bodies: Vec<usize> = (0..wanted.len()).filter(|body| wanted[*body]).collect();
        bodies.par_iter().flat_map(|body| parts(*body)).for_each(|part| {
            part.shape.pieces();
        });
    }
}

fn solid(points: &[Vec3]) -> Shape {
    let core = ConvexCore::Hull(HullPoints::new(points));
    let shape = ConvexShape { core, radius: 0.0 };
    let kind = ShapeKind::Convex(ConvexSolid::without_planes(shape));
    Shape::without_inner_balls(kind, Aabb::around(points.iter()), bounding_ball(points))
}

struct Divider<'a> {
    mesh: &'a MeshShape,
    thickness: f64,
}

impl Divider<'_> {
    /// None where nothing lies in the cell.
    fn cell(&self, walls: Vec<[Vec3; 3]>, triangles: Vec<[Vec3; 3]>, stack: &mut Vec<(f64, u32)>) -> Option<Cell> {
        let mut points: Vec<Vec3> = triangles.iter().flatten().copied().collect();
        // The corners of what the solid and the cell have in common are corners of clipped triangles, or corners of the cell.
        let mut of_cell: Vec<Vec3> = walls.iter().flatten().copied().collect();
        of_cell.sort_by(|a, b| a.as_slice().partial_cmp(b.as_slice()).expect("finite"));
        of_cell.dedup();
        points.extend(of_cell.iter().filter(|p| self.mesh.depth_inside(p, self.thickness, stack).is_some()));
        points.sort_by(|a, b| a.as_slice().partial_cmp(b.as_slice()).expect("finite"));
        points.dedup();
        if points.is_empty() {
            return None;
        }
        let hull = self.hull(&points);
        let notch = self.notch(&hull, FACES_LOOKED_AT, stack);
        Some(Cell { walls, triangles, hull, notch })
    }

    fn hull(&self, points: &[Vec3]) -> TriangleMesh {
        convex_hull(points)
            .or_else(|| {
                let steps = (0..6).map(|k| Vec3::ith(k % 3, if k < 3 { self.thickness } else { -self.thickness }));
                convex_hull(&steps.flat_map(|step| points.iter().map(move |p| p + step)).collect::<Vec<_>>())
            })
            .unwrap_or_else(|| TriangleMesh {
                vertices: points.to_vec(),
                triangles: Vec::new(),
                components: Vec::new(),
            })
    }

    /// The deepest below middles of the largest faces of `hull` and of their edges.
    fn notch(&self, hull: &TriangleMesh, most: usize, stack: &mut Vec<(f64, u32)>) -> Option<Notch> {
        let area = |[a, b, c]: &[Vec3; 3]| (b - a).cross(&(c - a)).norm();
        let mut faces: Vec<[Vec3; 3]> = corners(hull).collect();
        faces.sort_by(|x, y| area(y).total_cmp(&area(x)));
        let (tree, mut deepest) = (&self.mesh.tree, None);
        let mut beyond = self.thickness * self.thickness;
        for [a, b, c] in faces.iter().take(most) {
            for point in [(a + b + c) / 3.0, (a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5] {
                let near = tree.closest_point(tree.root, &point, f64::INFINITY, beyond, stack);
                if let Some(near) = near.filter(|near| near.squared > beyond)
                    && !self.mesh.holds(&point, stack)
                {
                    beyond = near.squared;
                    let depth = near.squared.sqrt();
                    let normal = tree.triangle(near.triangle).map_or_else(Vec3::zeros, |t| t.normal);
                    deepest = Some(Notch { depth, bottom: near.point, outward: (point - near.point) / depth, normal });
                }
            }
        }
        deepest
    }

    /// Of the planes through the bottom of a notch along its depth, and the plane of the face there, the one that leaves the least deep notches, and
    /// has a short edge where they hardly differ.
    fn best_cut(&self, cell: &Cell, notch: &Notch) -> Option<Cut> {
        let across = notch.outward.cross(&Vec3::ith(notch.outward.iamin(), 1.0)).normalize();
        let other = notch.outward.cross(&across);
        let turned = (0..CUTS).map(|k| {
            let (sine, cosine) = (std::f64::consts::PI * k as f64 / CUTS as f64).sin_cos();
            across * cosine + other * sine
        });
        let size = Aabb::around(cell.hull.vertices.iter()).half.norm();
        let cuts = turned.chain([notch.normal]).map(|normal| {
            let cut = Cut { normal, offset: normal.dot(&notch.bottom), thickness: self.thickness };
            let heights = || cell.hull.vertices.iter().map(move |p| cut.height(p));
            let least = 0.02 * notch.depth;
            (heights().any(|h| h > least) && heights().any(|h| h < -least)).then_some(cut)
        });
        let cost = |cut: Cut| {
            let (sides, length) = sketched(&cell.triangles, &cut);
            let left = sides.iter().filter_map(|side| self.notch(&side.hull()?, FACES_GLANCED_AT, &mut Vec::new()));
            let depth = left.map(|notch| notch.depth).fold(0.0, f64::max);
            (depth / notch.depth + SHORT * length / size, cut)
        };
        let costs: Vec<(f64, Cut)> = cuts.flatten().collect::<Vec<Cut>>().into_par_iter().map(cost).collect();
        costs.into_iter().min_by(|x, y| x.0.total_cmp(&y.0)).map(|(_, cut)| cut)
    }

    fn halves(&self, cell: &Cell, cut: &Cut, stack: &mut Vec<(f64, u32)>) -> Vec<Cell> {
        let sides = [-1.0, 1.0].into_iter().filter_map(|side| {
            let clipped = |all: &[[Vec3; 3]]| {
                let mut parts = Vec::new();
                all.iter().for_each(|triangle| clip(triangle, cut, side, &mut parts));
                parts
            };
            let walls: Vec<Vec3> = clipped(&cell.walls).into_iter().flatten().collect();
            let walls = convex_hull(&walls).map_or_else(Vec::new, |hull| corners(&hull).collect());
            self.cell(walls, clipped(&cell.triangles), stack)
        });
        sides.collect()
    }
}

fn corners(mesh: &TriangleMesh) -> impl Iterator<Item = [Vec3; 3]> {
    (0..mesh.triangles.len()).map(|t| mesh.corners(t))
}

impl Cut {
    fn height(&self, point: &Vec3) -> f64 {
        let height = self.normal.dot(point) - self.offset;
        if height.abs() > self.thickness { height } else { 0.0 }
    }

    /// Whether something of a triangle is on that side (-1 or 1): one that lies in the plane is on the side that its normal leads away from,
    /// where a solid would be.
    fn reaches(&self, corners: &[Vec3; 3], heights: &[f64; 3], side: f64) -> bool {
        let is_in_plane = heights.iter().all(|h| *h == 0.0);
        let [a, b, c] = corners;
        let leads = || (b - a).cross(&(c - a)).dot(&self.normal) > 0.0;
        if is_in_plane { leads() == (side < 0.0) } else { heights.iter().any(|h| side * h > 0.0) }
    }
}

/// Where an edge that crosses a plane does so, by the heights of its ends.
fn crossing((from, above): (&Vec3, f64), (to, below): (&Vec3, f64)) -> Vec3 {
    from + (to - from) * (above / (above - below))
}

/// The part of a triangle on one side of a plane.
fn clip(corners: &[Vec3; 3], cut: &Cut, side: f64, parts: &mut Vec<[Vec3; 3]>) {
    let heights = corners.map(|p| cut.height(&p));
    if !cut.reaches(corners, &heights, side) {
        return;
    }
    let heights = heights.map(|h| side * h);
    let (mut kept, mut count) = ([Vec3::zeros(); 4], 0);
    for k in 0..3 {
        let next = (k + 1) % 3;
        if heights[k] >= 0.0 {
            kept[count] = corners[k];
            count += 1;
        }
        if heights[k] * heights[next] < 0.0 {
            kept[count] = crossing((&corners[k], heights[k]), (&corners[next], heights[next]));
            count += 1;
        }
    }
    parts.extend((2..count).map(|k| [kept[0], kept[k - 1], kept[k]]));
}

/// Sketches of what is on both sides of a cut, and the length of the line along which it meets the mesh \[m\].
fn sketched(triangles: &[[Vec3; 3]], cut: &Cut) -> ([Sketch; 2], f64) {
    let mut sides = [Sketch::default(), Sketch::default()];
    let mut length = 0.0;
    for corners in triangles {
        let heights = corners.map(|p| cut.height(&p));
        let mut last = None;
        let reached = [-1.0, 1.0].map(|side| cut.reaches(corners, &heights, side));
        for k in 0..3 {
            let next = (k + 1) % 3;
            if heights[k] <= 0.0 && reached[0] {
                sides[0].add(&corners[k]);
            }
            if heights[k] >= 0.0 && reached[1] {
                sides[1].add(&corners[k]);
            }
            if heights[k] * heights[next] < 0.0 {
                let point = crossing((&corners[k], heights[k]), (&corners[next], heights[next]));
                sides.iter_mut().for_each(|side| side.add(&point));
                length += last.replace(point).map_or(0.0, |last: Vec3| (point - last).norm());
            }
        }
    }
    (sides, length)
}

/// Half the directions in which a sketch knows the farthest points: axes, and diagonals of faces and of a cube.
const DIRECTIONS: [[f64; 3]; 13] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, 1.0, -1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [1.0, -1.0, -1.0],
];

/// The farthest points of a set in a few directions.
struct Sketch {
    least: [(f64, Vec3); DIRECTIONS.len()],
    most: [(f64, Vec3); DIRECTIONS.len()],
}

impl Default for Sketch {
    fn default() -> Self {
        let none = |along| [(along, Vec3::zeros()); DIRECTIONS.len()];
        Self { least: none(f64::INFINITY), most: none(f64::NEG_INFINITY) }
    }
}

impl Sketch {
    fn add(&mut self, point: &Vec3) {
        for (k, [x, y, z]) in DIRECTIONS.iter().enumerate() {
            let along = x * point.x + y * point.y + z * point.z;
            if along < self.least[k].0 {
                self.least[k] = (along, *point);
            }
            if along > self.most[k].0 {
                self.most[k] = (along, *point);
            }
        }
    }

    fn hull(&self) -> Option<TriangleMesh> {
        let known = self.least.iter().chain(&self.most).filter(|(along, _)| along.is_finite());
        convex_hull(&known.map(|(_, point)| *point).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::gjk;
    use crate::collision::test_mesh::{bumpy, cuboid, joined, opened, placed};
    use crate::math::Pose;
    use rand::{RngExt, SeedableRng};

    fn divided(mesh: &TriangleMesh) -> (MeshShape, Vec<Shape>, f64) {
        let shape = MeshShape::new(mesh);
        let bounds = Aabb::around(shape.vertices.iter());
        let pieces = pieces(&shape, &bounds);
        (shape, pieces, bounds.half.norm())
    }

    fn solid_of(piece: &Shape) -> &ConvexSolid {
        let ShapeKind::Convex(solid) = &piece.kind else { panic!("convex") };
        solid
    }

    fn distance(piece: &Shape, point: &Vec3) -> f64 {
        let ball = ConvexShape { core: ConvexCore::Point, radius: 0.0 };
        let identity = Pose::identity();
        let found =
            gjk::separation(&ball, &Pose::translation(*point), &solid_of(piece).shape, &identity, f64::INFINITY);
        found.map_or(f64::INFINITY, |found| found.distance)
    }

    /// A ring of boxes, as a closed surface would be a torus.
    fn ring() -> TriangleMesh {
        let parts: Vec<TriangleMesh> = (0..12)
            .map(|k| {
                let turn = std::f64::consts::TAU * f64::from(k) / 12.0;
                cuboid(Vec3::new(turn.cos(), turn.sin(), 0.0) * 0.5, Vec3::new(0.14, 0.14, 0.1))
            })
            .collect();
        joined(&parts)
    }

    #[test]
    fn pieces_hold_the_mesh() {
        let bracket = [
            cuboid(Vec3::zeros(), Vec3::new(1.0, 0.2, 0.2)),
            cuboid(Vec3::new(0.8, 0.0, 1.0), Vec3::new(0.2, 0.2, 0.9)),
        ];
        let meshes =
            [joined(&bracket), bumpy(3, 2, 0.4), opened(placed(bumpy(5, 2, 0.2), 0.15, Vec3::x()), 30), ring()];
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
        for mesh in meshes {
            let (shape, pieces, radius) = divided(&mesh);
            let (mut on_surface, mut inside) = (0, 0);
            for round in 0..600 {
                let point = if round % 2 == 0 {
                    let [a, b, c] = mesh.corners(rng.random_range(0..mesh.triangles.len()));
                    let (s, t): (f64, f64) = (rng.random(), rng.random());
                    let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                    on_surface += 1;
                    a + (b - a) * s + (c - a) * t
                } else {
                    let [a, b] = [0; 2].map(|_| mesh.vertices[rng.random_range(0..mesh.vertices.len())]);
                    let point = a + (b - a) * rng.random::<f64>();
                    if !shape.holds(&point, &mut Vec::new()) {
                        continue;
                    }
                    inside += 1;
                    point
                };
                let nearest = pieces.iter().map(|piece| distance(piece, &point)).fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-9 * radius, "{nearest} from {} pieces", pieces.len());
            }
            assert!(on_surface == 300 && (inside > 10 || !mesh.is_closed()), "{inside}");
        }
    }

    #[test]
    fn pieces_follow_the_surface() {
        let bracket = [
            cuboid(Vec3::zeros(), Vec3::new(1.0, 0.2, 0.2)),
            cuboid(Vec3::new(0.8, 0.0, 1.0), Vec3::new(0.2, 0.2, 0.8)),
        ];
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        for (mesh, most, beyond) in [(joined(&bracket), 3, 1e-9), (ring(), MOST, 2.0 * TOLERANCE)] {
            let (shape, pieces, radius) = divided(&mesh);
            assert!((2..=most).contains(&pieces.len()), "{}", pieces.len());
            for piece in &pieces {
                let ConvexCore::Hull(hull) = &solid_of(piece).shape.core else { panic!("a hull") };
                for _ in 0..300 {
                    let mut weights: Vec<f64> = hull.points().iter().map(|_| rng.random::<f64>().powi(4)).collect();
                    let sum: f64 = weights.iter().sum();
                    weights.iter_mut().for_each(|w| *w /= sum);
                    let point: Vec3 = hull.points().iter().zip(&weights).map(|(p, w)| p * *w).sum();
                    let depth = shape.depth(&point, &mut Vec::new());
                    assert!(depth >= -beyond * radius, "{depth} of {radius} in one of {} pieces", pieces.len());
                }
            }
        }
    }

    #[test]
    fn the_same_mesh_gives_the_same_pieces_and_a_convex_one_gives_itself() {
        let points = |mesh: &TriangleMesh| -> Vec<Vec<Vec3>> {
            let hull = |piece: &Shape| match &solid_of(piece).shape.core {
                ConvexCore::Hull(hull) => hull.points().to_vec(),
                _ => panic!("a hull"),
            };
            divided(mesh).1.iter().map(hull).collect()
        };
        assert_eq!(points(&ring()), points(&ring()));
        assert_eq!(points(&cuboid(Vec3::zeros(), Vec3::new(1.0, 2.0, 3.0))).len(), 1);
    }
}
