//! A small dense quadratic program: the step of one refinement iteration.

use crate::math::linear_algebra::{LANES, dot};
use crate::math::quadratic_form::{Factor, QuadraticForm};
use crate::math::vectorized;

/// `minimise t' H t / 2 + g' t  subject to  A t >= b` and a box around the first unknowns, by a
/// dual active-set method.
///
/// From the unconstrained minimum (with a diagonal Hessian, from that in the box), the most
/// violated row joins the active set; while its multiplier grows, the multipliers of rows that it
/// depends on shrink, and the first that would turn negative leaves. The objective only grows
/// meanwhile.
///
/// # Source
/// D. Goldfarb and A. Idnani, "A numerically stable dual method for solving strictly convex
/// quadratic programs", Mathematical Programming 27, 1983, doi:10.1007/BF02591962. Deviation:
/// instead of a QR factorisation, the Cholesky factor of the few active rows' Gram matrix gains a
/// row when one joins, and is made anew from where one leaves.
#[derive(Debug, Clone, Default)]
pub struct Qp {
    nv: usize,
    /// Numbers a row: the unknowns, and zeros up to whole lanes.
    width: usize,
    /// The Hessian's.
    factor: Factor,
    /// Rows of `A`, row major, `width` numbers each, as all vectors over the unknowns.
    rows: Vec<f64>,
    /// Right-hand sides.
    bounds: Vec<f64>,
    /// Inverse Euclidean norms of the rows; 0 until one is requested.
    scales: Vec<f64>,
    /// The box: least and greatest values of the first unknowns. Its rows are numbered after those
    /// of `A`, lower sides first.
    low: Vec<f64>,
    high: Vec<f64>,
    /// `H^-1 a_i` of the active rows.
    lifted: Vec<f64>,
    active: Vec<usize>,
    multipliers: Vec<f64>,
    /// Cholesky factor of the active rows' Gram matrix in the inner product of `H^-1`: the rows of
    /// its lower triangle.
    gram: Vec<f64>,
    /// What stands left of the diagonal in the row that it would gain next.
    forward: Vec<f64>,
    dependence: Vec<f64>,
    direction: Vec<f64>,
    raised: Vec<f64>,
    /// Value of the objective at the step.
    objective: f64,
    /// The solution.
    pub step: Vec<f64>,
}

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QpOutcome {
    /// The step satisfies every constraint and is optimal.
    Solved,
    /// The constraints contradict each other (or nearly); the step is the last one reached.
    Infeasible,
    /// The least value of the objective is above what was requested; the step is the last one
    /// reached.
    Above,
}

/// A row is violated when it misses its bound by more than this times its norm \[rad or m\].
const TOLERANCE: f64 = 1e-10;

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

    /// Keeps the first unknowns within `[low, high]`.
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

    /// Rows of `A` so far.
    pub fn rows(&self) -> usize {
        self.bounds.len()
    }

    /// The row that was added last.
    pub fn last_row(&self) -> &[f64] {
        self.row(self.bounds.len() - 1)
    }

    /// Right-hand side of the row that was added last.
    pub fn last_bound(&mut self) -> &mut f64 {
        self.bounds.last_mut().expect("a row was pushed")
    }

    /// Sum of the multipliers of the first `rows` rows: the slope of the optimum when all their
    /// bounds rise together.
    pub fn multiplier_sum(&self, rows: usize) -> f64 {
        self.active.iter().zip(&self.multipliers).filter(|(row, _)| **row < rows).map(|(_, m)| m).sum()
    }

    /// Solves for a Hessian and a gradient over the unknowns; the solution is `step`. Ends as soon
    /// as the objective is proved to stay above `most`.
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

    /// From the unconstrained minimum to the least in the box, each unknown on its own, as a
    /// diagonal Hessian allows.
    #[inline(always)]
    fn start_in_box(&mut self) {
        let width = self.low.len();
        for k in 0..width {
            let (least, inverse) = (self.step[k], self.factor.inverse(k));
            let held = least.clamp(self.low[k], self.high[k]);
            let off = (held - least).abs();
            if off <= TOLERANCE {
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
            // Such rows are at right angles.
            self.gram.resize(self.gram.len() + self.active.len() - 1, 0.0);
            self.gram.push(inverse.sqrt());
        }
    }

    /// By how much, in units of its norm, the step misses the row that it misses most.
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

    /// The unknown that a row of the box holds, and on which side.
    fn side(&self, row: usize) -> Option<(usize, f64)> {
        let (sides, width) = (row.checked_sub(self.bounds.len())?, self.low.len());
        Some(if sides < width { (sides, 1.0) } else { (sides - width, -1.0) })
    }

    /// Row `row` times `x`.
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
        let mut worst = (None, TOLERANCE);
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

    /// Raises the multiplier of `row` until it holds with equality, dropping active rows on the
    /// way, as far as the objective stays below `most`; infeasible where no step can satisfy it
    /// along with the others.
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
            // The dual gains as much by this multiplier alone, from where it stands.
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

    /// `dependence` becomes the coefficients that express `direction` by the lifted active rows, in
    /// the Hessian's inner product.
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

    /// Factors the Gram matrix of the active rows anew, from number `first` on.
    fn factor_gram(&mut self, first: usize) {
        self.gram.truncate(first * (first + 1) / 2);
        for i in first..self.active.len() {
            for (j, lifted) in self.lifted.chunks_exact(self.width).take(i + 1).enumerate() {
                let inner = self.row_dot(self.active[i], lifted);
                let (mine, at) = (&self.gram[i * (i + 1) / 2..], j * (j + 1) / 2);
                let rest = inner - dot(&mine[..j], &self.gram[at..at + j]);
                // Rows that depend on each other are never active together, but rounding may have
                // them seem to be.
                let entry = if i == j { rest.max(1e-14 * inner).sqrt() } else { rest / self.gram[at + j] };
                self.gram.push(entry);
            }
        }
    }
}

/// Row `i` of a packed lower triangle: what stands before the diagonal, and what on it.
#[inline(always)]
fn factor_row(packed: &[f64], i: usize) -> (&[f64], f64) {
    let start = i * (i + 1) / 2;
    (&packed[start..start + i], packed[start + i])
}

#[cfg(test)]
mod tests;
