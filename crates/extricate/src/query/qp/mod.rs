//! A solver for small dense quadratic programs, which give the steps of descents.

use crate::math::linear_algebra::{LANES, dot};
use crate::math::quadratic_form::{Factor, QuadraticForm};
use crate::math::vectorized;

/// Solves `minimise t' H t / 2 + g' t  subject to  A t >= b` with a box around the first unknowns,
/// by a dual active-set method.
///
/// The method starts at the unconstrained minimum, or at the minimum in the box if the Hessian is
/// diagonal. The most violated row joins the active set. While its multiplier grows, the
/// multipliers of rows that it depends on shrink, and the first to reach zero leaves. The objective
/// only grows meanwhile.
///
/// # Source
/// D. Goldfarb and A. Idnani, "A numerically stable dual method for solving strictly convex
/// quadratic programs", Mathematical Programming 27, 1983, doi:10.1007/BF02591962. Deviation:
/// instead of a QR factorisation, the Cholesky factor of the few active rows' Gram matrix gains a
/// row when one joins, and is recomputed from the row that leaves.
#[derive(Debug, Clone, Default)]
pub struct Qp {
    nv: usize,
    /// Numbers in a row: the unknowns, padded with zeros to whole lanes.
    width: usize,
    factor: Factor,
    /// Rows of `A`, row major, `width` numbers each like all vectors over the unknowns.
    rows: Vec<f64>,
    bounds: Vec<f64>,
    /// Inverse Euclidean norms of the rows; 0 until computed.
    scales: Vec<f64>,
    /// Limits of the first unknowns. The rows of this box are numbered after those of `A`, lower
    /// sides first.
    low: Vec<f64>,
    high: Vec<f64>,
    /// `H^-1 a_i` of the active rows.
    lifted: Vec<f64>,
    active: Vec<usize>,
    multipliers: Vec<f64>,
    /// Cholesky factor of the active rows' Gram matrix in the inner product of `H^-1`: its lower
    /// triangle, packed by rows.
    gram: Vec<f64>,
    /// Off-diagonal entries of the row that `gram` gains next.
    forward: Vec<f64>,
    dependence: Vec<f64>,
    direction: Vec<f64>,
    raised: Vec<f64>,
    objective: f64,
    /// The step that the last solve reached.
    pub step: Vec<f64>,
}

/// The outcome of a solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QpOutcome {
    /// The step satisfies every constraint and is optimal.
    Solved,
    /// The constraints contradict each other (or nearly); the step is the last one reached.
    Infeasible,
    /// The minimum is above the requested value; the step is the last one reached.
    Above,
}

/// A row is violated if it misses its bound by more than this times its norm \[rad or m\].
const VIOLATION_TOLERANCE: f64 = 1e-10;

impl Qp {
    /// Starts a problem with `nv` unknowns.
    pub fn reset(&mut self, nv: usize) {
        self.nv = nv;
        self.width = nv.next_multiple_of(LANES);
        self.rows.clear();
        self.bounds.clear();
        self.low.clear();
        self.high.clear();
    }

    /// Limits the first unknowns to `[low, high]`.
    pub fn set_box(&mut self, low: &[f64], high: &[f64]) {
        self.low.extend_from_slice(low);
        self.high.extend_from_slice(high);
    }

    /// Adds a row of zeros with right-hand side `bound`; fill in the returned slice.
    pub fn push(&mut self, bound: f64) -> &mut [f64] {
        let at = self.rows.len();
        self.rows.resize(at + self.width, 0.0);
        self.bounds.push(bound);
        &mut self.rows[at..at + self.nv]
    }

    /// Returns the number of rows of `A` so far.
    pub fn rows(&self) -> usize {
        self.bounds.len()
    }

    /// Returns the row that was added last.
    pub fn last_row(&self) -> &[f64] {
        self.row(self.bounds.len() - 1)
    }

    /// Returns the right-hand side of the row that was added last.
    pub fn last_bound(&mut self) -> &mut f64 {
        self.bounds.last_mut().expect("a row was pushed")
    }

    /// Returns the sum of the multipliers of the first `rows` rows: the slope of the minimum if all
    /// their bounds rise together.
    pub fn multiplier_sum(&self, rows: usize) -> f64 {
        self.active.iter().zip(&self.multipliers).filter(|(row, _)| **row < rows).map(|(_, m)| m).sum()
    }

    /// Solves for a Hessian and a gradient over the unknowns, and writes the solution to `step`.
    /// Ends as soon as the minimum is proved to exceed `most`.
    pub fn solve(&mut self, hessian: &QuadraticForm, gradient: &[f64], most: f64) -> QpOutcome {
        let outcome = vectorized(
            #[inline(always)]
            || self.solve_padded(hessian, gradient, most),
        );
        self.step.truncate(self.nv);
        outcome
    }

    #[inline(always)]
    fn solve_padded(&mut self, hessian: &QuadraticForm, gradient: &[f64], most: f64) -> QpOutcome {
        let nv = self.nv;
        hessian.factor(&mut self.factor);
        self.step.clear();
        self.step.extend(gradient.iter().map(|g| -g));
        self.factor.solve(&mut self.step);
        self.active.clear();
        self.multipliers.clear();
        self.lifted.clear();
        self.gram.clear();
        self.objective = 0.5 * dot(&self.step, gradient);
        self.step.resize(self.width, 0.0);
        if self.factor.is_diagonal() {
            self.start_in_box();
        }
        self.scales.clear();
        self.scales.resize(self.bounds.len(), 0.0);
        for _ in 0..10 * nv + 20 {
            if self.objective > most {
                return QpOutcome::Above;
            }
            let Some(row) = self.most_violated() else { return QpOutcome::Solved };
            match self.satisfy(row, most) {
                QpOutcome::Solved => {}
                failed => return failed,
            }
        }
        QpOutcome::Infeasible
    }

    /// Moves from the unconstrained minimum to the minimum in the box. A diagonal Hessian allows
    /// this for each unknown separately.
    #[inline(always)]
    fn start_in_box(&mut self) {
        let width = self.low.len();
        for k in 0..width {
            let (least, inverse) = (self.step[k], self.factor.inverse(k));
            let held = least.clamp(self.low[k], self.high[k]);
            let off = (held - least).abs();
            if off <= VIOLATION_TOLERANCE {
                continue;
            }
            let sign = if held > least { 1.0 } else { -1.0 };
            self.step[k] = held;
            self.objective += 0.5 * off * off / inverse;
            self.active.push(self.bounds.len() + if sign > 0.0 { k } else { width + k });
            self.multipliers.push(off / inverse);
            let at = self.lifted.len();
            self.lifted.resize(at + self.width, 0.0);
            self.lifted[at + k] = sign * inverse;
            // Rows of the box are orthogonal.
            self.gram.resize(self.gram.len() + self.active.len() - 1, 0.0);
            self.gram.push(inverse.sqrt());
        }
    }

    /// Returns the largest violation of a row by the step, in units of the row's norm.
    pub fn largest_violation(&self) -> f64 {
        let of_rows = (0..self.bounds.len()).map(|i| {
            let row = self.row(i);
            (self.bounds[i] - dot(row, &self.step)) / dot(row, row).sqrt().max(1e-9)
        });
        let of_box =
            self.step.iter().zip(self.low.iter().zip(&self.high)).map(|(x, (low, high))| (low - x).max(x - high));
        of_rows.chain(of_box).fold(0.0, f64::max)
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.rows[i * self.width..][..self.nv]
    }

    /// Returns the unknown and the side of a row of the box; `None` for a row of `A`.
    fn side(&self, row: usize) -> Option<(usize, f64)> {
        let (sides, width) = (row.checked_sub(self.bounds.len())?, self.low.len());
        Some(if sides < width { (sides, 1.0) } else { (sides - width, -1.0) })
    }

    fn row_dot(&self, row: usize, x: &[f64]) -> f64 {
        self.side(row).map_or_else(|| dot(&self.rows[row * self.width..][..self.width], x), |(k, sign)| sign * x[k])
    }

    fn bound(&self, row: usize) -> f64 {
        match self.side(row) {
            None => self.bounds[row],
            Some((k, sign)) => {
                if sign > 0.0 {
                    self.low[k]
                } else {
                    -self.high[k]
                }
            }
        }
    }

    #[inline(always)]
    fn most_violated(&mut self) -> Option<usize> {
        let mut worst = (None, VIOLATION_TOLERANCE);
        let mut consider = |row: usize, violation: f64| {
            if violation > worst.1 {
                worst = (Some(row), violation);
            }
        };
        for (i, row) in self.rows.chunks_exact(self.width).enumerate() {
            let missing = self.bounds[i] - dot(row, &self.step);
            if missing > 0.0 {
                if self.scales[i] == 0.0 {
                    self.scales[i] = 1.0 / dot(row, row).sqrt().max(1e-9);
                }
                consider(i, missing * self.scales[i]);
            }
        }
        let (first, width) = (self.bounds.len(), self.low.len());
        for (k, step) in self.step[..width].iter().enumerate() {
            consider(first + k, self.low[k] - step);
            consider(first + width + k, step - self.high[k]);
        }
        worst.0
    }

    /// Raises the multiplier of `row` until the row holds with equality, and drops active rows on
    /// the way. Ends early if the objective exceeds `most`. Infeasible if no step satisfies the row
    /// together with the others.
    #[inline(always)]
    fn satisfy(&mut self, row: usize, most: f64) -> QpOutcome {
        let (nv, width) = (self.nv, self.width);
        let mut multiplier = 0.0;
        let pivot = loop {
            self.direction.clear();
            self.direction.resize(width, 0.0);
            match self.side(row) {
                None => self.direction.copy_from_slice(&self.rows[row * width..][..width]),
                Some((k, sign)) => self.direction[k] = sign,
            }
            self.factor.solve(&mut self.direction[..nv]);
            self.raised.clear();
            self.raised.extend_from_slice(&self.direction);
            let own = self.row_dot(row, &self.direction);
            let missing = self.bound(row) - self.row_dot(row, &self.step);
            // The dual objective gains this much if only the multiplier of this row grows.
            let gain = missing * (0.5 * missing / own + multiplier);
            if self.objective + gain.max(0.0) > most {
                return QpOutcome::Above;
            }
            self.solve_dependence();
            for (lifted, r) in self.lifted.chunks_exact(width).zip(&self.dependence) {
                self.direction.iter_mut().zip(lifted).for_each(|(d, l)| *d -= r * l);
            }
            let curvature = self.row_dot(row, &self.direction);
            let full = if curvature > 1e-10 * own { missing / curvature } else { f64::INFINITY };
            let mut blocking = (None, full);
            for (i, r) in self.dependence.iter().enumerate() {
                if *r > 1e-14 && self.multipliers[i] / r < blocking.1 {
                    blocking = (Some(i), self.multipliers[i] / r);
                }
            }
            if blocking.1.is_infinite() {
                return QpOutcome::Infeasible;
            }
            if full.is_finite() {
                self.objective += blocking.1 * curvature * (0.5 * blocking.1 + multiplier);
            }
            multiplier += blocking.1;
            self.multipliers.iter_mut().zip(&self.dependence).for_each(|(m, r)| *m = (*m - blocking.1 * r).max(0.0));
            if full.is_finite() {
                self.step.iter_mut().zip(&self.direction).for_each(|(s, d)| *s += blocking.1 * d);
            }
            let Some(leaving) = blocking.0 else { break curvature.sqrt() };
            self.active.remove(leaving);
            self.multipliers.remove(leaving);
            self.lifted.drain(leaving * width..(leaving + 1) * width);
            self.factor_gram(leaving);
        };
        self.gram.extend_from_slice(&self.forward);
        self.gram.push(pivot);
        self.lifted.extend_from_slice(&self.raised);
        self.active.push(row);
        self.multipliers.push(multiplier);
        QpOutcome::Solved
    }

    /// Fills `dependence` with the coefficients that express `direction` by the lifted active rows,
    /// in the Hessian's inner product.
    #[inline(always)]
    fn solve_dependence(&mut self) {
        self.forward.clear();
        for (i, &row) in self.active.iter().enumerate() {
            let (before, pivot) = factor_row(&self.gram, i);
            let rest = self.row_dot(row, &self.direction) - dot(before, &self.forward);
            self.forward.push(rest / pivot);
        }
        self.dependence.clear();
        self.dependence.extend_from_slice(&self.forward);
        for i in (0..self.active.len()).rev() {
            let (before, pivot) = factor_row(&self.gram, i);
            self.dependence[i] /= pivot;
            let last = self.dependence[i];
            self.dependence.iter_mut().zip(before).for_each(|(d, l)| *d -= l * last);
        }
    }

    /// Recomputes the factor of the Gram matrix of the active rows from row `first` on.
    fn factor_gram(&mut self, first: usize) {
        self.gram.truncate(first * (first + 1) / 2);
        for i in first..self.active.len() {
            for (j, lifted) in self.lifted.chunks_exact(self.width).take(i + 1).enumerate() {
                let inner = self.row_dot(self.active[i], lifted);
                let (mine, at) = (&self.gram[i * (i + 1) / 2..], j * (j + 1) / 2);
                let rest = inner - dot(&mine[..j], &self.gram[at..at + j]);
                // Active rows are independent, but rounding may hide that.
                let entry = if i == j { rest.max(1e-14 * inner).sqrt() } else { rest / self.gram[at + j] };
                self.gram.push(entry);
            }
        }
    }
}

/// Returns row `i` of a packed lower triangle: the entries before the diagonal, and the diagonal.
#[inline(always)]
fn factor_row(packed: &[f64], i: usize) -> (&[f64], f64) {
    let start = i * (i + 1) / 2;
    (&packed[start..start + i], packed[start + i])
}

#[cfg(test)]
mod tests;
