//! Cells of space, cut plane by plane until the hull of the part of a mesh in each follows the
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

/// Cuts end once no piece stands out of the mesh by more than this share of its radius (of the ball
/// around its box). Lab L076.
pub const TOLERANCE_SHARE: f64 = 0.004;
/// Planes along the depth of a notch that are compared as cuts, evenly rotated about it. Lab L076.
const TURNED_CUTS: usize = 8;
/// Largest faces of a hull at which its distance from the mesh is measured.
pub const NOTCH_FACES: usize = 48;
/// Number of those faces while cuts are compared.
pub const ROUGH_NOTCH_FACES: usize = 8;
/// Points of the surface in a cell, beside which notches are searched for.
pub const NOTCH_POINTS: usize = 128;
/// A notch is followed outward in steps of a share of its depth. They are halved if they gain less
/// than [`MIN_GAIN_SHARE`], and end once they are no larger than this.
const MIN_STEP_SHARE: f64 = 0.05;
/// Least gain of a step outward, as a share of the depth.
const MIN_GAIN_SHARE: f64 = 0.01;
/// Weight of the length of a cut's edge (as a share of the size of the cell) beside the notch left
/// (as a share of the depth before).
const EDGE_LENGTH_WEIGHT: f64 = 0.2;
/// Weight of the shallower of the two notches that a cut leaves. Without it, a cut that only halves
/// that notch passes for one that leaves nothing there.
const SHALLOW_SIDE_WEIGHT: f64 = 0.2;
/// Flat hulls are thickened by this share of the radius of the mesh's ball.
pub const THICKNESS: f64 = 1e-6;

/// A convex cell of space, and the part of the mesh in it.
pub struct Cell {
    /// Triangles of the surface of the cell.
    pub walls: Vec<[Vec3; 3]>,
    pub triangles: Vec<[Vec3; 3]>,
    /// Points spread evenly over `triangles`, in no order.
    pub points: Vec<SurfacePoint>,
    pub hull: TriangleMesh,
    pub notch: Option<Concavity>,
    /// Depth of its notch if no cut can make it shallower \[m\], else 0.
    pub left: f64,
}

/// The place where a hull stands out of the mesh farthest.
#[derive(Clone, Copy)]
pub struct Concavity {
    /// Distance of the hull from the mesh \[m\].
    pub depth: f64,
    /// Nearest point of the mesh.
    pub bottom: Vec3,
    /// Unit vector from `bottom` to the hull.
    pub outward: Vec3,
    /// Unit normal of the triangle at `bottom`.
    pub normal: Vec3,
}

/// Cuts the box around triangles of a mesh of `radius` \[m\] into cells. It ends once the hull of
/// what lies in each stands out by no more than `tolerance` \[m\], or there are `most` cells.
///
/// With `across`, cuts across a notch are tried too. Without them, bars are cut in vain if the
/// nearest face between their ends is not the inner one. That is good enough for proposals of
/// contacts.
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

/// Returns the depth of the deepest notch that cells leave \[m\].
pub fn deepest(cells: &[Cell]) -> f64 {
    cells.iter().map(|cell| cell.notch.map_or(cell.left, |notch| notch.depth)).fold(0.0, f64::max)
}

/// A mesh and the settings of its cuts.
pub struct Divider<'a> {
    pub mesh: &'a MeshShape,
    /// Flat hulls are thickened by this \[m\].
    pub thickness: f64,
    /// Whether cuts across a notch are tried too.
    pub across: bool,
}

impl Divider<'_> {
    /// Returns a cell; `None` if nothing lies in it.
    fn cell(&self, walls: Vec<[Vec3; 3]>, triangles: Vec<[Vec3; 3]>, stack: &mut Vec<(f64, u32)>) -> Option<Cell> {
        let mut points: Vec<Vec3> = triangles.iter().flatten().copied().collect();
        // The part of the solid in the cell has its corners at corners of clipped triangles, or of
        // the cell.
        let of_cell = distinct(walls.iter().flatten().copied().collect());
        points.extend(of_cell.iter().filter(|p| self.mesh.depth_inside(p, self.thickness, stack).is_some()));
        let points = distinct(points);
        if points.is_empty() {
            return None;
        }
        let hull = self.hull(&points);
        let points = surface_points(&triangles, NOTCH_POINTS);
        let notch = self.notch(&hull, NOTCH_FACES, &points, stack);
        Some(Cell { walls, triangles, points, hull, notch, left: 0.0 })
    }

    /// Returns the hull of points. If they lie in a plane, they are thickened by `thickness` along
    /// the axes.
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

    /// Returns the deepest notch below the middles of the `most` largest faces of `hull` and of
    /// their edges, or beside `points`. It is followed outward while it grows deeper.
    pub fn notch(
        &self,
        hull: &TriangleMesh,
        most: usize,
        points: &[SurfacePoint],
        stack: &mut Vec<(f64, u32)>,
    ) -> Option<Concavity> {
        let tree = &self.mesh.tree;
        let mut deepest: Option<Concavity> = None;
        let mut measure = |point: Vec3, deepest: &mut Option<Concavity>| {
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
                measure(point, &mut deepest);
            }
        }
        let plane = |[a, b, c]: &[Vec3; 3]| Some(((b - a).cross(&(c - a)).try_normalize(0.0)?, *a));
        let planes: Vec<(Vec3, Vec3)> = faces.iter().filter_map(plane).collect();
        let depth_in_hull = |p: &Vec3| planes.iter().map(|(n, a)| n.dot(&(a - p))).fold(f64::INFINITY, f64::min);
        for SurfacePoint { point, normal } in points {
            // If a point of the surface is deep in the hull, so are the points beside it: the hull
            // holds a ball of that radius around it.
            let half = 0.5 * depth_in_hull(point);
            if half > deepest.map_or(self.thickness, |notch| notch.depth) && half.is_finite() {
                measure(point + normal * half, &mut deepest);
                measure(point - normal * half, &mut deepest);
            }
        }
        let mut step = 0.5;
        while let Some(notch) = deepest.filter(|_| step > MIN_STEP_SHARE) {
            let point = notch.bottom + notch.outward * (notch.depth * (1.0 + step));
            if depth_in_hull(&point) >= 0.0 {
                measure(point, &mut deepest);
            }
            if deepest.is_none_or(|now| now.depth < notch.depth * (1.0 + MIN_GAIN_SHARE)) {
                step *= 0.5;
            }
        }
        deepest
    }

    /// Returns the cut that leaves the least deep notches and has a short edge. It is a plane
    /// through the bottom of a notch: along its depth, along the face there, or across the depth.
    fn best_cut(&self, cell: &Cell, notch: &Concavity) -> Option<Cut> {
        let across = notch.outward.cross(&Vec3::ith(notch.outward.iamin(), 1.0)).normalize();
        let other = notch.outward.cross(&across);
        let turned = (0..TURNED_CUTS).map(|k| {
            let (sine, cosine) = sin_cos(std::f64::consts::PI * k as f64 / TURNED_CUTS as f64);
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
                self.notch(&side.hull()?, ROUGH_NOTCH_FACES, &points, &mut Vec::new())
            });
            let left: Vec<f64> = left.map(|notch| notch.depth).collect();
            let (deepest, both) = (left.iter().copied().fold(0.0, f64::max), left.iter().sum::<f64>());
            ((deepest + SHALLOW_SIDE_WEIGHT * (both - deepest)) / notch.depth + EDGE_LENGTH_WEIGHT * length / size, cut)
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

/// Returns the points sorted, each once.
pub fn distinct(mut points: Vec<Vec3>) -> Vec<Vec3> {
    points.sort_by(|a, b| a.as_slice().partial_cmp(b.as_slice()).expect("finite"));
    points.dedup();
    points
}

/// Returns the corners of each triangle.
pub fn corners(mesh: &TriangleMesh) -> impl Iterator<Item = [Vec3; 3]> {
    (0..mesh.triangles.len()).map(|t| mesh.corners(t))
}
