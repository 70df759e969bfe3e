//! Cells of space, cut plane by plane until the hull of what of a mesh lies in each follows the
//! surface.

use rayon::prelude::*;

use super::cut::{Cut, clip, sketched};
use super::surface_points::{SurfacePoint, surface_points};
use crate::collision::shapes::bounds::Aabb;
use crate::collision::shapes::mesh::MeshShape;
use crate::math::Vec3;
use crate::math::elementary::sin_cos;
use crate::robot::TriangleMesh;
use crate::robot::mesh::convex_hull::convex_hull;

/// How far pieces may stand out of the mesh, as a share of the radius of the mesh's ball, where so
/// many follow it that closely.
pub const TOLERANCE: f64 = 0.004;
/// Cuts tried at a notch.
const CUTS: usize = 8;
/// Faces of a hull whose distance from the mesh is looked at.
pub const FACES_LOOKED_AT: usize = 48;
/// The same while cuts are compared.
pub const FACES_GLANCED_AT: usize = 8;
/// Points of the surface in a cell, beside which notches are looked for.
pub const POINTS_LOOKED_AT: usize = 128;
/// Steps outward along a notch, as shares of its depth, are halved to this where they gain less
/// than [`GAIN`].
const LEAST_STEP: f64 = 0.05;
/// As a share of the depth.
const GAIN: f64 = 0.01;
/// What the length of a cut's edge, as a share of the size of the cell, is worth, as a share of the
/// depth of the notch.
const SHORT: f64 = 0.2;
/// What the depth of the notch that a cut leaves on the side of the less deep one counts: else a
/// cut that only halves it passes for one that leaves nothing there.
const OTHER_SIDE: f64 = 0.2;
/// What flat hulls are thickened by, as a share of the radius of the mesh's ball.
pub const THICKNESS: f64 = 1e-6;

/// A convex cell of space, and what of the mesh lies in it.
pub struct Cell {
    /// Its surface.
    pub walls: Vec<[Vec3; 3]>,
    pub triangles: Vec<[Vec3; 3]>,
    /// Of its surface, evenly spread, in no order.
    pub points: Vec<SurfacePoint>,
    pub hull: TriangleMesh,
    pub notch: Option<Concavity>,
    /// How deep its notch is, if there is none that a cut could make less deep \[m\].
    pub left: f64,
}

/// Where a hull stands out of the mesh farthest.
#[derive(Clone, Copy)]
pub struct Concavity {
    /// How far \[m\].
    pub depth: f64,
    /// The nearest point of the mesh.
    pub bottom: Vec3,
    /// Unit, from there to the hull.
    pub outward: Vec3,
    /// Unit, of the triangle there.
    pub normal: Vec3,
}

/// Cells of the box around triangles of a mesh of `radius`, cut until the hull of what lies in each
/// stands out by no more than `tolerance` \[m\], or there are `most`. `across`: whether cuts
/// across a notch are tried too. Without them bars between whose ends the nearest face is not the
/// inner one are cut in vain; proposals of contacts do with that.
pub fn cells(
    mesh: &MeshShape,
    triangles: Vec<[Vec3; 3]>,
    radius: f64,
    tolerance: f64,
    most: usize,
    across: bool,
) -> Vec<Cell> {
    let divider = Divider { mesh, thickness: THICKNESS * radius, across };
    let mut stack = Vec::new();
    let box_around = convex_hull(&Aabb::around(triangles.iter().flatten()).corners());
    let walls = box_around.map_or_else(Vec::new, |hull| corners(&hull).collect());
    let mut cells: Vec<Cell> = divider.cell(walls, triangles, &mut stack).into_iter().collect();
    let depth = |cell: &Cell| cell.notch.map_or(0.0, |notch| notch.depth);
    while cells.len() < most {
        let deepest = (0..cells.len()).max_by(|i, j| depth(&cells[*i]).total_cmp(&depth(&cells[*j])));
        let Some(deepest) = deepest.filter(|at| depth(&cells[*at]) > tolerance) else { break };
        let cell = cells.swap_remove(deepest);
        let cut = cell.notch.and_then(|notch| divider.best_cut(&cell, &notch));
        match cut {
            Some(cut) => cells.extend(divider.halves(&cell, &cut, &mut stack)),
            None => cells.push(Cell { notch: None, left: depth(&cell), ..cell }),
        }
    }
    cells
}

/// How deep the deepest notch is that cells leave \[m\].
pub fn deepest(cells: &[Cell]) -> f64 {
    cells.iter().map(|cell| cell.notch.map_or(cell.left, |notch| notch.depth)).fold(0.0, f64::max)
}

/// One mesh, and how it is cut.
pub struct Divider<'a> {
    pub mesh: &'a MeshShape,
    /// What flat hulls are thickened by \[m\].
    pub thickness: f64,
    /// Whether cuts across a notch are tried too.
    pub across: bool,
}

impl Divider<'_> {
    /// None where nothing lies in the cell.
    fn cell(&self, walls: Vec<[Vec3; 3]>, triangles: Vec<[Vec3; 3]>, stack: &mut Vec<(f64, u32)>) -> Option<Cell> {
        let mut points: Vec<Vec3> = triangles.iter().flatten().copied().collect();
        // The corners of what the solid and the cell have in common are corners of clipped
        // triangles, or corners of the cell.
        let of_cell = distinct(walls.iter().flatten().copied().collect());
        points.extend(of_cell.iter().filter(|p| self.mesh.depth_inside(p, self.thickness, stack).is_some()));
        let points = distinct(points);
        if points.is_empty() {
            return None;
        }
        let hull = self.hull(&points);
        let points = surface_points(&triangles, POINTS_LOOKED_AT);
        let notch = self.notch(&hull, FACES_LOOKED_AT, &points, stack);
        Some(Cell { walls, triangles, points, hull, notch, left: 0.0 })
    }

    /// The hull of points; of those in a plane, one that is as thin as a flat hull is.
    pub fn hull(&self, points: &[Vec3]) -> TriangleMesh {
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

    /// The deepest of those below middles of the `most` largest faces of `hull` and of their edges,
    /// and of those beside `points`; followed outward while it grows deeper.
    pub fn notch(
        &self,
        hull: &TriangleMesh,
        most: usize,
        points: &[SurfacePoint],
        stack: &mut Vec<(f64, u32)>,
    ) -> Option<Concavity> {
        let tree = &self.mesh.tree;
        let mut deepest: Option<Concavity> = None;
        let mut look_at = |point: Vec3, deepest: &mut Option<Concavity>| {
            let least = deepest.map_or(self.thickness, |notch| notch.depth).powi(2);
            let near = tree.closest_point(tree.root, &point, f64::INFINITY, least, stack);
            if let Some(near) = near.filter(|near| near.squared > least)
                && !self.mesh.holds(&point, stack)
            {
                let depth = near.squared.sqrt();
                let normal = tree.triangle(near.triangle).map_or_else(Vec3::zeros, |t| t.normal);
                *deepest = Some(Concavity { depth, bottom: near.point, outward: (point - near.point) / depth, normal });
            }
        };
        let area = |[a, b, c]: &[Vec3; 3]| (b - a).cross(&(c - a)).norm();
        let mut faces: Vec<[Vec3; 3]> = corners(hull).collect();
        faces.sort_by(|x, y| area(y).total_cmp(&area(x)));
        for [a, b, c] in faces.iter().take(most) {
            for point in [(a + b + c) / 3.0, (a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5] {
                look_at(point, &mut deepest);
            }
        }
        let plane = |[a, b, c]: &[Vec3; 3]| Some(((b - a).cross(&(c - a)).try_normalize(0.0)?, *a));
        let planes: Vec<(Vec3, Vec3)> = faces.iter().filter_map(plane).collect();
        let depth_in_hull = |p: &Vec3| planes.iter().map(|(n, a)| n.dot(&(a - p))).fold(f64::INFINITY, f64::min);
        for SurfacePoint { point, normal } in points {
            // Where a point of the surface is deep in the hull, so is what is beside it: the hull
            // holds a ball of that radius around it.
            let half = 0.5 * depth_in_hull(point);
            if half > deepest.map_or(self.thickness, |notch| notch.depth) && half.is_finite() {
                look_at(point + normal * half, &mut deepest);
                look_at(point - normal * half, &mut deepest);
            }
        }
        let mut step = 0.5;
        while let Some(notch) = deepest.filter(|_| step > LEAST_STEP) {
            let point = notch.bottom + notch.outward * (notch.depth * (1.0 + step));
            if depth_in_hull(&point) >= 0.0 {
                look_at(point, &mut deepest);
            }
            if deepest.is_none_or(|now| now.depth < notch.depth * (1.0 + GAIN)) {
                step *= 0.5;
            }
        }
        deepest
    }

    /// Of the planes through the bottom of a notch along its depth, and the plane of the face
    /// there, the one that leaves the least deep notches, and has a short edge.
    fn best_cut(&self, cell: &Cell, notch: &Concavity) -> Option<Cut> {
        let across = notch.outward.cross(&Vec3::ith(notch.outward.iamin(), 1.0)).normalize();
        let other = notch.outward.cross(&across);
        let turned = (0..CUTS).map(|k| {
            let (sine, cosine) = sin_cos(std::f64::consts::PI * k as f64 / CUTS as f64);
            across * cosine + other * sine
        });
        let size = Aabb::around(cell.hull.vertices.iter()).half.norm();
        let cuts = turned.chain([notch.normal]).chain(self.across.then_some(notch.outward)).map(|normal| {
            let cut = Cut { normal, offset: normal.dot(&notch.bottom), thickness: self.thickness };
            let heights = || cell.hull.vertices.iter().map(move |p| cut.height(p));
            let least = 0.02 * notch.depth;
            (heights().any(|h| h > least) && heights().any(|h| h < -least)).then_some(cut)
        });
        let cost = |cut: Cut| {
            let (sides, length) = sketched(&cell.triangles, &cut);
            let left = sides.iter().zip([-1.0, 1.0]).filter_map(|(side, sign)| {
                let points: Vec<SurfacePoint> =
                    cell.points.iter().filter(|p| sign * cut.height(&p.point) > 0.0).copied().collect();
                self.notch(&side.hull()?, FACES_GLANCED_AT, &points, &mut Vec::new())
            });
            let left: Vec<f64> = left.map(|notch| notch.depth).collect();
            let (deepest, both) = (left.iter().copied().fold(0.0, f64::max), left.iter().sum::<f64>());
            ((deepest + OTHER_SIDE * (both - deepest)) / notch.depth + SHORT * length / size, cut)
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

/// The points in order, each once.
pub fn distinct(mut points: Vec<Vec3>) -> Vec<Vec3> {
    points.sort_by(|a, b| a.as_slice().partial_cmp(b.as_slice()).expect("finite"));
    points.dedup();
    points
}

/// The corners of each triangle.
pub fn corners(mesh: &TriangleMesh) -> impl Iterator<Item = [Vec3; 3]> {
    (0..mesh.triangles.len()).map(|t| mesh.corners(t))
}
