//! Ground below a grid of heights: an endless prism below every triangle of the surface. A pyramid
//! of least and greatest heights finds the prisms.
//!
//! Convex searches see a prism only as deep as the other shape needs: nothing below that shape
//! matters.

use std::sync::Arc;

use super::nodes::{Approach, At, ENDLESS_HALF_SIDE_M, Element};
use crate::collision::narrow_phase::triangle::{Triangle, closest_on_triangle};
use crate::collision::shapes::ConvexSolid;
use crate::collision::shapes::bounds::{Aabb, Relative};
use crate::collision::shapes::bvh::push_sorted;
use crate::collision::shapes::convex::{ConvexCore, ConvexShape};
use crate::math::Vec3;
use crate::robot::HeightField;

/// A grid of heights with its pyramid.
#[derive(Debug, Clone)]
pub struct Field {
    grid: Arc<HeightField>,
    /// Levels from the cells to the root, with blocks of 1, 2, 4, ... cells a side.
    levels: Vec<Level>,
}

#[derive(Debug, Clone)]
struct Level {
    /// Number of blocks along x and y.
    blocks: [usize; 2],
    heights: Vec<(f64, f64)>,
}

impl Field {
    /// Prepares a grid; `None` for one without a cell.
    pub fn new(grid: &Arc<HeightField>) -> Option<Self> {
        let [rows, columns] = grid.shape();
        if rows < 2 || columns < 2 {
            return None;
        }
        let blocks = [rows - 1, columns - 1];
        let of_cell = |at: usize| {
            let (i, j) = (at / blocks[1], at % blocks[1]);
            let corners = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)].map(|(i, j)| grid.vertex(i, j).z);
            corners.into_iter().fold(EMPTY_RANGE, |range, z| joined(range, (z, z)))
        };
        let heights = (0..blocks[0] * blocks[1]).map(of_cell).collect();
        let mut levels = vec![Level { blocks, heights }];
        while let Some(below) = levels.last().filter(|level| level.heights.len() > 1) {
            let blocks = below.blocks.map(|count| count.div_ceil(2));
            let of_block = |at: usize| {
                below
                    .children(at / blocks[1], at % blocks[1])
                    .fold(EMPTY_RANGE, |range, k| joined(range, below.heights[k]))
            };
            let heights = (0..blocks[0] * blocks[1]).map(of_block).collect();
            levels.push(Level { blocks, heights });
        }
        Some(Self { grid: grid.clone(), levels })
    }

    pub fn root(&self) -> At {
        At::new(self.levels.len() - 1, 0)
    }

    /// Bounding box, which ends far below the surface.
    pub fn bounds(&self) -> Aabb {
        self.block_bounds(self.root(), -2.0 * ENDLESS_HALF_SIDE_M)
    }

    fn top(&self) -> f64 {
        self.levels.last().map_or(0.0, |level| level.heights[0].1)
    }

    /// Corners \[m\] of the grid's rectangle.
    fn sides(&self) -> ([f64; 2], [f64; 2]) {
        ([0.0; 2], self.levels[0].blocks.map(|count| count as f64 * self.grid.size()))
    }

    /// Lower and upper corner of the surface of a block.
    fn block(&self, at: At) -> (Vec3, Vec3) {
        let (level, side) = (&self.levels[at.level()], self.grid.size());
        let (i, j) = (at.number() / level.blocks[1], at.number() % level.blocks[1]);
        let end = |k: usize, axis: usize| (k << at.level()).min(self.levels[0].blocks[axis]) as f64 * side;
        let (low, high) = level.heights[at.number()];
        (Vec3::new(end(i, 0), end(j, 1), low), Vec3::new(end(i + 1, 0), end(j + 1, 1), high))
    }

    /// Box around a block from `bottom` \[m\] upward, or from its lowest surface if that is lower.
    fn block_bounds(&self, at: At, bottom: f64) -> Aabb {
        let (mut lower, upper) = self.block(at);
        lower.z = lower.z.min(bottom);
        Aabb::between(&lower, &upper)
    }

    /// Children of a block: smaller blocks, or the two triangles of a cell.
    fn children(&self, at: At) -> impl Iterator<Item = At> {
        let blocks = (at.level() > 0).then(|| {
            let (level, below) = (&self.levels[at.level()], &self.levels[at.level() - 1]);
            let (i, j) = (at.number() / level.blocks[1], at.number() % level.blocks[1]);
            below.children(i, j).map(move |number| At::new(at.level() - 1, number))
        });
        let triangles = (at.level() == 0).then(|| [0, 1].map(|k| At::element(2 * at.number() + k)));
        blocks.into_iter().flatten().chain(triangles.into_iter().flatten())
    }

    /// See [`super::Scenery::open`].
    pub fn open(&self, at: At, approach: &Approach, limit: f64, mut each: impl FnMut(f64, At)) {
        let bottom = self.bottom(approach.low);
        let bound_of = |at: At| approach.relative.lower_bound(&self.block_bounds(at, bottom), approach.bounds);
        if at.level() == 0 {
            let bound = bound_of(at);
            self.children(at).for_each(|child| each(bound, child));
            return;
        }
        for child in self.children(at) {
            let bound = bound_of(child);
            if bound < limit {
                each(bound, child);
            }
        }
    }

    /// Height \[m\] at which prisms end if the other shape begins at `low` \[m\].
    fn bottom(&self, low: f64) -> f64 {
        low - self.grid.size()
    }

    fn triangle(&self, number: u32) -> Option<[Vec3; 3]> {
        let (cell, second) = (number as usize / 2, number % 2 == 1);
        let blocks = self.levels[0].blocks;
        (cell < blocks[0] * blocks[1]).then(|| self.grid.triangle(cell / blocks[1], cell % blocks[1], second))
    }

    /// Makes the prism below a triangle; see [`super::Scenery::with_element`].
    pub fn with_element<R>(&self, number: u32, low: f64, f: impl FnOnce(Element) -> R) -> Option<R> {
        let corners = self.triangle(number)?;
        let lowest = corners.iter().map(|p| p.z).fold(self.bottom(low), f64::min);
        let bottom = if lowest < self.bottom(low) { lowest - self.grid.size() } else { lowest };
        let place = (corners[0] + corners[1] + corners[2]) / 3.0;
        let top = corners.map(|p| p - place);
        let core = ConvexCore::Prism { top, bottom: bottom - place.z };
        let (lower, upper) = top.iter().fold((top[0], top[0]), |(l, u), p| (l.inf(p), u.sup(p)));
        let bounds = Aabb::between(&Vec3::new(lower.x, lower.y, bottom - place.z), &upper);
        let solid = ConvexSolid::without_planes(ConvexShape { core, radius: 0.0 });
        Some(f(Element { solid: &solid, bounds: &bounds, place }))
    }

    /// Height \[m\] of the surface; `None` beside the grid.
    pub fn surface(&self, x: f64, y: f64) -> Option<f64> {
        let ([x0, y0], [x1, y1]) = self.sides();
        if !(x0 <= x && x <= x1 && y0 <= y && y <= y1) {
            return None;
        }
        let place = |x: f64, axis: usize| {
            let cell = ((x / self.grid.size()) as usize).min(self.levels[0].blocks[axis] - 1);
            (cell, x / self.grid.size() - cell as f64)
        };
        let ((i, u), (j, v)) = (place(x, 0), place(y, 1));
        let [a, b, c] = self.grid.triangle(i, j, v > u).map(|p| p.z);
        // Corners are (0, 0), then (1, 0) and (1, 1), or (1, 1) and (0, 1).
        Some(if v > u { a + (b - c) * u + (c - a) * v } else { a + (b - a) * u + (c - b) * v })
    }

    pub fn holds(&self, point: &Vec3) -> bool {
        self.surface(point.x, point.y).is_some_and(|surface| point.z < surface)
    }

    /// Least and greatest height \[m\] of the cells that a rectangle touches; `None` beside the
    /// grid.
    pub fn heights_in(&self, lower: [f64; 2], upper: [f64; 2], stack: &mut Vec<(f64, u32)>) -> Option<(f64, f64)> {
        let mut range = EMPTY_RANGE;
        stack.clear();
        stack.push((0.0, self.root().0));
        while let Some((_, at)) = stack.pop() {
            let at = At(at);
            let (low, high) = self.block(at);
            let overlaps = (0..2).all(|k| low[k] <= upper[k] && lower[k] <= high[k]);
            let holds = (0..2).all(|k| lower[k] <= low[k] && high[k] <= upper[k]);
            if !overlaps || (low.z >= range.0 && high.z <= range.1) {
                continue;
            }
            if holds || at.level() == 0 {
                range = joined(range, (low.z, high.z));
            } else {
                stack.extend(self.children(at).map(|child| (0.0, child.0)));
            }
        }
        (range.0 <= range.1).then_some(range)
    }

    /// Intersection of the grid's rectangle with another one; `None` if it is empty.
    pub fn clipped(&self, lower: [f64; 2], upper: [f64; 2]) -> Option<([f64; 2], [f64; 2])> {
        let (low, high) = self.sides();
        let both = ([0, 1].map(|k| lower[k].max(low[k])), [0, 1].map(|k| upper[k].min(high[k])));
        (0..2).all(|k| both.0[k] < both.1[k]).then_some(both)
    }

    /// Height \[m\] of the highest surface point above `low` \[m\].
    pub fn rise_above(&self, low: f64) -> f64 {
        self.top() - low
    }

    /// See [`super::Scenery::depth_above`].
    pub fn depth_above(&self, point: &Vec3, least: f64, stack: &mut Vec<(f64, u32)>) -> Option<f64> {
        let ([x0, y0], [x1, y1]) = self.sides();
        let aside = Vec3::new(point.x.clamp(x0, x1), point.y.clamp(y0, y1), point.z);
        let lateral = (point - aside).norm();
        let below = self.holds(&aside);
        let depth = if below && lateral > 0.0 {
            -lateral
        } else if below {
            let wall = (point.x - x0).min(x1 - point.x).min(point.y - y0).min(y1 - point.y);
            let near = self.surface_distance(point, wall, stack);
            near.unwrap_or(wall)
        } else {
            let reach = if least < 0.0 { -least } else { return None };
            -self.surface_distance(point, reach, stack)?
        };
        Some(depth).filter(|depth| *depth > least)
    }

    /// Distance \[m\] of a point from the surface, if below `limit`.
    fn surface_distance(&self, point: &Vec3, limit: f64, stack: &mut Vec<(f64, u32)>) -> Option<f64> {
        let (mut squared, mut best) = (limit * limit, None);
        let bound_of = |at: At| {
            let (low, high) = self.block(at);
            (low - point).sup(&(point - high)).sup(&Vec3::zeros()).norm_squared()
        };
        stack.clear();
        stack.push((0.0, self.root().0));
        while let Some((bound, at)) = stack.pop() {
            let at = At(at);
            if bound >= squared {
                continue;
            }
            if let Some(corners) = at.as_element().and_then(|number| self.triangle(number)) {
                let near = (closest_on_triangle(&Triangle::new(corners), point) - point).norm_squared();
                if near < squared {
                    (squared, best) = (near, Some(near));
                }
                continue;
            }
            let start = stack.len();
            for child in self.children(at) {
                let bound = if at.level() == 0 { bound } else { bound_of(child) };
                push_sorted(stack, start, (bound, child.0), |entry| entry.0);
            }
        }
        best.map(f64::sqrt)
    }
}

const EMPTY_RANGE: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

fn joined(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.min(b.0), a.1.max(b.1))
}

impl Level {
    /// Numbers of the blocks of this level below one block of the next.
    fn children(&self, i: usize, j: usize) -> impl Iterator<Item = usize> + use<> {
        let [rows, columns] = self.blocks;
        let places = [(2 * i, 2 * j), (2 * i, 2 * j + 1), (2 * i + 1, 2 * j), (2 * i + 1, 2 * j + 1)];
        places.into_iter().filter(move |(i, j)| *i < rows && *j < columns).map(move |(i, j)| i * columns + j)
    }
}

/// Relative pose after the other shape is raised by `rise` \[m\].
pub fn raised(relative: &Relative, rise: f64) -> Relative {
    let mut pose = relative.pose_a_b;
    pose.translation.z += rise;
    Relative::new(pose)
}
