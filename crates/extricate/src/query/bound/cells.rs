//! The sphere of directions along which two convex sets may part, covered by cells.
//!
//! Where two convex sets are `m` apart, a plane parts them: there is a unit normal `n` with `n . (a
//! - b) >= m` for *every* point `a` of the first and `b` of the second. A cell is the cone of three
//! directions with *one* choice of points. If `n = sum l_i n_i` with `l_i >= 0` parts the sets,
//! then `sum l_i n_i . (a - b) >= m`, so that at one corner at least
//!
//! `n_i . (a - b) >= m / sum l_i >= c m`
//!
//! where all corners are within an angle of cosine `c` of one direction. So whatever parts the sets
//! along a direction of the cell keeps one of three inequalities; how large the cell is costs
//! nothing but that its points are the same all over it.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::collision::ConvexPair;
use crate::math::Vec3;

/// What is to be bounded: how far a configuration has to go to part two points along a direction.
pub trait Parting {
    /// Looks at point `a` of the first set and `b` of the second (world \[m\]).
    fn place(&mut self, points: [&Vec3; 2]);

    /// No more than this comes of [`Parting::rough_distance`]; takes no time.
    fn linear_distance(&mut self, n: &Vec3, needed: f64) -> f64;

    /// Proved: no configuration nearer than this (metric units) has `n . (a - b)` larger than here
    /// by `needed` \[m\].
    fn rough_distance(&mut self, n: &Vec3, needed: f64) -> f64;

    /// The same, looked at more closely; no closer once it is `enough`.
    fn distance(&mut self, n: &Vec3, needed: f64, enough: f64) -> f64;
}

/// Cells that cover the sphere.
#[derive(Debug, Default)]
pub struct Cells {
    cells: BinaryHeap<Cell>,
}

/// A cone of directions.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    corners: [Corner; 3],
    /// World points of either set that are chosen for it.
    points: [Vec3; 2],
    /// Metric units.
    bound: f64,
    /// Whether it was looked at closely.
    is_close: bool,
}

/// A direction and the points that are supported along it.
#[derive(Debug, Clone, Copy)]
struct Corner {
    direction: Vec3,
    supports: [Vec3; 2],
}

impl Cells {
    /// Covers the cone of three directions, or the sphere, and splits the cell that bounds least,
    /// until all bound `enough` or there have been `most` splits; returns the least bound.
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
            self.cells.push(Cell::new(pair, cone.map(corner), None, parting, enough));
        } else {
            let axes = [0, 1, 2].map(|k| [corner(Vec3::ith(k, 1.0)), corner(Vec3::ith(k, -1.0))]);
            for k in 0..8 {
                let corners = [axes[0][k & 1], axes[1][k >> 1 & 1], axes[2][k >> 2]];
                self.cells.push(Cell::new(pair, corners, None, parting, enough));
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
            let [one, other] = worst.split(&corner).map(|half| Cell::new(pair, half, Some(&worst), parting, enough));
            *worst = one;
            drop(worst);
            self.cells.push(other);
        }
        self.cells.peek().map_or(f64::NEG_INFINITY, |cell| cell.bound)
    }

    /// The cells that bound less than `enough`.
    pub fn open(&self, enough: f64) -> impl Iterator<Item = &Cell> {
        self.cells.iter().filter(move |cell| cell.bound < enough)
    }
}

impl Cell {
    /// The cell with the points that bound most for it.
    fn new(
        pair: &ConvexPair,
        corners: [Corner; 3],
        parent: Option<&Self>,
        parting: &mut impl Parting,
        enough: f64,
    ) -> Self {
        let supports = pair.supports(&middle(&corners));
        let candidates = [parent.map(|cell| cell.points), Some(supports), toward_origin(&corners)];
        let mut cell = Self { corners, points: supports, bound: f64::NEG_INFINITY, is_close: false };
        for points in candidates.into_iter().flatten() {
            parting.place(points.each_ref());
            let needs = cell.needs(pair, &points);
            if needs.iter().any(|(n, needed)| parting.linear_distance(n, *needed) <= cell.bound) {
                continue;
            }
            let mut bound = enough;
            for (n, needed) in needs {
                bound = bound.min(parting.rough_distance(&n, needed));
                if bound <= cell.bound {
                    break;
                }
            }
            if bound > cell.bound {
                (cell.bound, cell.points) = (bound, points);
            }
        }
        // What holds for the whole cell holds for a part of it.
        cell.bound = parent.map_or(cell.bound, |parent| cell.bound.max(parent.bound));
        cell
    }

    fn look_closely(&mut self, pair: &ConvexPair, parting: &mut impl Parting, enough: f64) {
        self.is_close = true;
        parting.place(self.points.each_ref());
        let mut bound = enough;
        for (n, needed) in self.needs(pair, &self.points) {
            bound = bound.min(parting.distance(&n, needed, bound));
        }
        self.bound = self.bound.max(bound);
    }

    /// Its corners.
    pub fn cone(&self) -> [Vec3; 3] {
        self.corners.map(|corner| corner.direction)
    }

    /// The three inequalities of the chosen points.
    pub fn inequalities(&self, pair: &ConvexPair) -> ([Vec3; 2], [(Vec3, f64); 3]) {
        (self.points, self.needs(pair, &self.points))
    }

    /// Corners, and by how much \[m\] the two points have to part along each.
    fn needs(&self, pair: &ConvexPair, [a, b]: &[Vec3; 2]) -> [(Vec3, f64); 3] {
        let middle = middle(&self.corners);
        let cosine = self.corners.iter().map(|corner| corner.direction.dot(&middle)).fold(1.0, f64::min);
        // Of positions and of the few products.
        let rounding = ROUNDING * (a.norm() + b.norm() + pair.keeps());
        self.corners.map(|corner| (corner.direction, pair.keeps() * cosine - corner.direction.dot(&(a - b)) - rounding))
    }

    /// Two cells that make it up, parted at its longest edge.
    fn split(&self, corner: &impl Fn(Vec3) -> Corner) -> [[Corner; 3]; 2] {
        let [a, b, c] = self.corners;
        let cosine = |x: &Corner, y: &Corner| x.direction.dot(&y.direction);
        let edges = [(cosine(&a, &b), [a, b, c]), (cosine(&b, &c), [b, c, a]), (cosine(&c, &a), [c, a, b])];
        let (_, [x, y, rest]) = edges.into_iter().min_by(|s, t| s.0.total_cmp(&t.0)).expect("three edges");
        let middle = corner((x.direction + y.direction).normalize());
        [[x, middle, rest], [middle, y, rest]]
    }
}

/// Of some dozen operations on positions, relative to them.
const ROUNDING: f64 = 1e-14;

fn middle(corners: &[Corner; 3]) -> Vec3 {
    corners.iter().map(|corner| corner.direction).sum::<Vec3>().normalize()
}

impl Ord for Cell {
    /// The one that bounds least is the greatest.
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

/// Points of the sets, between the supports of the corners, whose difference is nearest to the
/// origin: there the sets touch last.
fn toward_origin(corners: &[Corner; 3]) -> Option<[Vec3; 2]> {
    let [x, y, z] = corners.map(|corner| corner.supports[0] - corner.supports[1]);
    let weights = nearest_weights(x, y, z)?;
    let between = |k: usize| (0..3).map(|i| corners[i].supports[k] * weights[i]).sum();
    Some([between(0), between(1)])
}

/// Weights of the corners at the point of a triangle nearest to the origin.
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
