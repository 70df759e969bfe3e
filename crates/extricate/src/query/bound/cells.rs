//! Cells that cover the sphere of directions along which two convex sets may part.
//!
//! If two convex sets are `m` apart, a plane separates them: there is a unit normal `n` with
//! `n . (a - b) >= m` for *every* point `a` of the first and `b` of the second. A cell is the cone
//! of three directions with *one* choice of points. If `n = sum l_i n_i` with `l_i >= 0` separates
//! the sets, then `sum l_i n_i . (a - b) >= m`, so at least one corner satisfies
//!
//! `n_i . (a - b) >= m / sum l_i >= c m`
//!
//! if all corners are within an angle of cosine `c` of one direction. So whatever separates the
//! sets along a direction of the cell satisfies one of three inequalities. The only cost of a large
//! cell is that its points are the same all over it.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::collections::binary_heap::PeekMut;

use arrayvec::ArrayVec;

use crate::collision::ConvexPair;
use crate::math::{LANES, Vec3};
use crate::metric::pair_motion::Lanes;

/// Bounds how far a configuration has to move to part two points along a direction.
pub trait Parting {
    /// Places the points `a` of the first set and `b` of the second (world \[m\]) for the next
    /// bound.
    fn place(&mut self, points: [&Vec3; 2]);

    /// Returns a proved distance (metric units). At no configuration nearer than it is
    /// `n . (a - b)` larger than here by `needed` \[m\], for any of the three pairs. Stops refining
    /// at `enough`.
    fn least_distance(&mut self, needs: &[(Vec3, f64); 3], enough: f64) -> f64;

    /// Returns a rough bound of each candidate: the least over its inequalities, at most `enough`.
    /// Takes at most eight candidates.
    fn rough_distances(&mut self, candidates: &[Candidate], enough: f64) -> Lanes;
}

/// Two points that a cell may choose, with `N` directions along which they have to part.
#[derive(Debug, Clone, Copy)]
pub struct Candidate<const N: usize = 3> {
    /// World point of each set.
    pub points: [Vec3; 2],
    /// Directions, and by how much \[m\] the points have to part along each.
    pub needs: [(Vec3, f64); N],
}

/// Cells that cover a cone or the sphere; the one that bounds least is on top.
#[derive(Debug, Default)]
pub struct Cells {
    cells: BinaryHeap<Cell>,
}

/// The cone of directions between three corners.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    corners: [Corner; 3],
    /// The chosen world point of each set.
    points: [Vec3; 2],
    /// No direction of the cell parts the sets nearer than this (metric units).
    bound: f64,
    /// Whether `bound` comes from [`Parting::least_distance`], and no longer from a rough bound.
    is_close: bool,
}

#[derive(Debug, Clone, Copy)]
struct Corner {
    direction: Vec3,
    supports: [Vec3; 2],
}

impl Cells {
    /// Covers the cone of three directions, or the sphere if there is none, and refines the cell
    /// that bounds least. Stops once all cells bound `enough`, or after `most` splits and close
    /// bounds; returns the least bound.
    ///
    /// # Guarantee
    /// No configuration nearer than this parts the sets along a direction of the cone.
    pub fn cover(
        &mut self,
        pair: &ConvexPair,
        cone: Option<[Vec3; 3]>,
        parting: &mut impl Parting,
        enough: f64,
        most: usize,
    ) -> f64 {
        self.cells.clear();
        let corner = |direction: Vec3| Corner { direction, supports: pair.supports(&direction) };
        if let Some(cone) = cone {
            self.add(pair, &[cone.map(corner)], None, parting, enough);
        } else {
            let axes = [0, 1, 2].map(|k| [corner(Vec3::ith(k, 1.0)), corner(Vec3::ith(k, -1.0))]);
            for x in axes[0] {
                let octants = [0, 1, 2, 3].map(|k| [x, axes[1][k & 1], axes[2][k >> 1]]);
                self.add(pair, &octants, None, parting, enough);
            }
        }
        for _ in 0..most {
            let Some(mut worst) = self.cells.peek_mut() else { break };
            if worst.bound >= enough {
                break;
            }
            if !worst.is_close {
                worst.look_closely(pair, parting, enough);
                continue;
            }
            let worst = PeekMut::pop(worst);
            self.add(pair, &worst.split(&corner), Some(&worst), parting, enough);
        }
        self.cells.peek().map_or(f64::NEG_INFINITY, |cell| cell.bound)
    }

    /// Adds up to four cells, parts of `parent` if there is one, each with the points that bound
    /// most.
    fn add(
        &mut self,
        pair: &ConvexPair,
        cells: &[[Corner; 3]],
        parent: Option<&Cell>,
        parting: &mut impl Parting,
        enough: f64,
    ) {
        let mut candidates = ArrayVec::<Candidate, LANES>::new();
        let mut cells: ArrayVec<_, 4> = cells
            .iter()
            .map(|corners| {
                let (middle, start) = (middle(corners), candidates.len());
                let choices = [parent.map(|cell| cell.points), Some(pair.supports(&middle)), toward_origin(corners)];
                let choices = choices.into_iter().flatten();
                candidates
                    .extend(choices.map(|points| Candidate { points, needs: needs(pair, corners, &middle, &points) }));
                (*corners, start..candidates.len())
            })
            .collect();
        let bounds = parting.rough_distances(&candidates, enough);
        for (corners, own) in cells.drain(..) {
            let best = own.max_by(|x, y| bounds[*x].total_cmp(&bounds[*y]).then(y.cmp(x))).expect("its supports");
            // A bound of the parent holds for its parts.
            let bound = parent.map_or(bounds[best], |parent| bounds[best].max(parent.bound));
            self.cells.push(Cell { corners, points: candidates[best].points, bound, is_close: false });
        }
    }

    pub fn open(&self, enough: f64) -> impl Iterator<Item = &Cell> {
        self.cells.iter().filter(move |cell| cell.bound < enough)
    }
}

impl Cell {
    fn look_closely(&mut self, pair: &ConvexPair, parting: &mut impl Parting, enough: f64) {
        self.is_close = true;
        parting.place(self.points.each_ref());
        let needs = needs(pair, &self.corners, &middle(&self.corners), &self.points);
        let bound = parting.least_distance(&needs, enough).min(enough);
        self.bound = self.bound.max(bound);
    }

    pub fn cone(&self) -> [Vec3; 3] {
        self.corners.map(|corner| corner.direction)
    }

    /// Returns the chosen points and their three inequalities.
    pub fn inequalities(&self, pair: &ConvexPair) -> ([Vec3; 2], [(Vec3, f64); 3]) {
        (self.points, needs(pair, &self.corners, &middle(&self.corners), &self.points))
    }

    /// Splits the cell at the middle of its longest edge.
    fn split(&self, corner: &impl Fn(Vec3) -> Corner) -> [[Corner; 3]; 2] {
        let [a, b, c] = self.corners;
        let cosine = |x: &Corner, y: &Corner| x.direction.dot(&y.direction);
        let edges = [(cosine(&a, &b), [a, b, c]), (cosine(&b, &c), [b, c, a]), (cosine(&c, &a), [c, a, b])];
        let (_, [x, y, rest]) = edges.into_iter().min_by(|s, t| s.0.total_cmp(&t.0)).expect("three edges");
        let middle = corner((x.direction + y.direction).normalize());
        [[x, middle, rest], [middle, y, rest]]
    }
}

/// Rounding error of some dozen operations on positions, as a share of their lengths.
const ROUNDING: f64 = 1e-14;

/// Returns the direction of each corner, and by how much \[m\] the two points have to part along
/// it.
fn needs(pair: &ConvexPair, corners: &[Corner; 3], middle: &Vec3, [a, b]: &[Vec3; 2]) -> [(Vec3, f64); 3] {
    let cosine = corners.iter().map(|corner| corner.direction.dot(middle)).fold(1.0, f64::min);
    let rounding = ROUNDING * (a.norm() + b.norm() + pair.keeps());
    corners.map(|corner| (corner.direction, pair.keeps() * cosine - corner.direction.dot(&(a - b)) - rounding))
}

fn middle(corners: &[Corner; 3]) -> Vec3 {
    corners.iter().map(|corner| corner.direction).sum::<Vec3>().normalize()
}

impl Ord for Cell {
    /// The cell that bounds least is the greatest.
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound)
    }
}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Cell {}

/// Returns the points between the supports of the corners whose difference is nearest to the
/// origin, because the sets touch last there.
fn toward_origin(corners: &[Corner; 3]) -> Option<[Vec3; 2]> {
    let [x, y, z] = corners.map(|corner| corner.supports[0] - corner.supports[1]);
    let weights = nearest_weights(x, y, z)?;
    let between = |k: usize| (0..3).map(|i| corners[i].supports[k] * weights[i]).sum();
    Some([between(0), between(1)])
}

/// Returns the weights of the corners at the point of a triangle nearest to the origin.
fn nearest_weights(x: Vec3, y: Vec3, z: Vec3) -> Option<[f64; 3]> {
    let normal = (y - x).cross(&(z - x));
    let squared = normal.norm_squared();
    if squared > 1e-24 * (y - x).norm_squared() * (z - x).norm_squared() {
        let of = |p: &Vec3, q: &Vec3| p.cross(q).dot(&normal) / squared;
        let weights = [of(&y, &z), of(&z, &x), of(&x, &y)];
        if weights.iter().all(|weight| *weight >= 0.0) {
            let sum: f64 = weights.iter().sum();
            return Some(weights.map(|weight| weight / sum));
        }
    }
    let sides = [[x, y], [y, z], [z, x]].map(|[p, q]| {
        let edge = q - p;
        let squared = edge.norm_squared();
        let share = if squared > 0.0 { (-p.dot(&edge) / squared).clamp(0.0, 1.0) } else { 0.0 };
        (share, (p + edge * share).norm_squared())
    });
    let nearest = (0..3).min_by(|i, j| sides[*i].1.total_cmp(&sides[*j].1))?;
    let mut weights = [0.0; 3];
    weights[nearest] = 1.0 - sides[nearest].0;
    weights[(nearest + 1) % 3] = sides[nearest].0;
    Some(weights)
}
