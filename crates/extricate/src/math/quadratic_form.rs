//! Quadratic forms on small vectors, row major. Diagonal forms store their diagonal alone.

use super::linear_algebra::{cholesky, cholesky_solve, dot, forward_solve, transposed_solve};

/// A symmetric positive definite form `x' A x`.
#[derive(Debug, Clone, Default)]
pub struct QuadraticForm {
    size: usize,
    is_diagonal: bool,
    /// The diagonal of `A`, or all of it.
    entries: Vec<f64>,
}

/// The Cholesky factor `L` of a form, `A = L L'`.
#[derive(Debug, Clone, Default)]
pub struct Factor {
    size: usize,
    is_diagonal: bool,
    /// The inverse of the diagonal of `A`, or the lower triangle of `L`.
    entries: Vec<f64>,
}

impl QuadraticForm {
    /// Resets the form to zeros; a diagonal form has no other entries to set.
    pub fn reset(&mut self, size: usize, is_diagonal: bool) {
        (self.size, self.is_diagonal) = (size, is_diagonal);
        self.entries.clear();
        self.entries.resize(if is_diagonal { size } else { size * size }, 0.0);
    }

    /// Copies another form into the memory of this one.
    pub fn copy_from(&mut self, other: &Self) {
        (self.size, self.is_diagonal) = (other.size, other.is_diagonal);
        self.entries.clone_from(&other.entries);
    }

    /// Returns the identity form `x' x`.
    pub fn identity(size: usize) -> Self {
        Self { size, is_diagonal: true, entries: vec![1.0; size] }
    }

    /// Returns a form with all `entries`, row major.
    #[cfg(test)]
    pub fn dense(size: usize, entries: Vec<f64>) -> Self {
        debug_assert_eq!(entries.len(), size * size);
        Self { size, is_diagonal: false, entries }
    }

    /// Length of the vectors.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Returns whether only the diagonal is stored.
    pub fn is_diagonal(&self) -> bool {
        self.is_diagonal
    }

    /// Entries in row-major order, or the diagonal alone, for writing.
    pub fn entries_mut(&mut self) -> &mut [f64] {
        &mut self.entries
    }

    /// Entries in row-major order, or the diagonal alone.
    pub fn entries(&self) -> &[f64] {
        &self.entries
    }

    fn step(&self) -> usize {
        if self.is_diagonal { 1 } else { self.size + 1 }
    }

    /// Returns entry `at` of the diagonal.
    pub fn diagonal(&self, at: usize) -> f64 {
        self.entries[at * self.step()]
    }

    /// Adds `share` of the largest diagonal entry, at least of `least`, to the diagonal.
    pub fn damp(&mut self, share: f64, least: f64) {
        let step = self.step();
        let largest = self.entries.iter().step_by(step).copied().fold(0.0, f64::max).max(least);
        self.entries.iter_mut().step_by(step).for_each(|entry| *entry += share * largest);
    }

    /// Returns `a' A b`.
    pub fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        if self.is_diagonal {
            return self.entries.iter().zip(a.iter().zip(b)).map(|(h, (a, b))| h * a * b).sum();
        }
        let rows = self.entries.chunks_exact(self.size.max(1)).zip(a);
        rows.map(|(row, a)| a * dot(row, &b[..self.size])).sum()
    }

    /// Returns `sqrt(a' A a)`.
    pub fn length(&self, a: &[f64]) -> f64 {
        self.product(a, a).max(0.0).sqrt()
    }

    /// Writes the Cholesky factor of the form to `factor`.
    pub fn factor(&self, factor: &mut Factor) {
        (factor.size, factor.is_diagonal) = (self.size, self.is_diagonal);
        factor.entries.clear();
        if self.is_diagonal {
            factor.entries.extend(self.entries.iter().map(|h| 1.0 / h));
        } else {
            factor.entries.extend_from_slice(&self.entries);
            cholesky(&mut factor.entries, self.size);
        }
    }
}

impl Factor {
    /// Returns whether the factored form is diagonal.
    pub fn is_diagonal(&self) -> bool {
        self.is_diagonal
    }

    /// Returns diagonal entry `at` of the inverse of a diagonal form.
    pub fn inverse(&self, at: usize) -> f64 {
        self.entries[at]
    }

    /// Replaces `x` by `A^-1 x`.
    #[inline(always)]
    pub fn solve(&self, x: &mut [f64]) {
        if self.is_diagonal {
            x.iter_mut().zip(&self.entries).for_each(|(x, inverse)| *x *= inverse);
        } else {
            cholesky_solve(&self.entries, self.size, x);
        }
    }

    /// Replaces `x` by `L^-1 x`.
    pub fn solve_lower(&self, x: &mut [f64]) {
        if self.is_diagonal {
            x.iter_mut().zip(&self.entries).for_each(|(x, inverse)| *x *= inverse.sqrt());
        } else {
            forward_solve(&self.entries, self.size, x);
        }
    }

    /// Replaces `x` by `L'^-1 x`.
    pub fn solve_upper(&self, x: &mut [f64]) {
        if self.is_diagonal {
            self.solve_lower(x);
        } else {
            transposed_solve(&self.entries, self.size, x);
        }
    }

    /// Appends `L' x` to `out`.
    pub fn extend_upper(&self, x: &[f64], out: &mut Vec<f64>) {
        if self.is_diagonal {
            out.extend(x.iter().zip(&self.entries).map(|(x, inverse)| x / inverse.sqrt()));
        } else {
            let column = |k: usize| (k..self.size).map(|i| self.entries[i * self.size + k] * x[i]).sum::<f64>();
            out.extend((0..self.size).map(column));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A diagonal form and its factor give the same results as the dense form with zeros.
    #[test]
    fn a_diagonal_form_is_one_with_zeros_beside_it() {
        let weights = [0.5, 2.0, 7.0];
        let mut form = QuadraticForm::identity(3);
        form.entries_mut().copy_from_slice(&weights);
        form.damp(0.1, 20.0);
        let mut full = vec![0.0; 9];
        (0..3).for_each(|k| full[4 * k] = weights[k] + 2.0);
        let full = QuadraticForm::dense(3, full);
        let [mut one, mut other] = [Factor::default(), Factor::default()];
        form.factor(&mut one);
        full.factor(&mut other);
        let (a, b) = ([1.0, -2.0, 0.5], [0.3, 0.4, -3.0]);
        let near = |x: f64, y: f64| assert!((x - y).abs() < 1e-14, "{x} {y}");
        near(form.product(&a, &b), full.product(&a, &b));
        near(form.length(&a), full.length(&a));
        for k in 0..3 {
            near(form.diagonal(k), full.diagonal(k));
        }
        let ways: [fn(&Factor, &mut [f64]); 3] = [Factor::solve, Factor::solve_lower, Factor::solve_upper];
        for way in ways {
            let (mut x, mut y) = (a, a);
            way(&one, &mut x);
            way(&other, &mut y);
            x.into_iter().zip(y).for_each(|(x, y)| near(x, y));
        }
        let (mut x, mut y) = (Vec::new(), Vec::new());
        one.extend_upper(&a, &mut x);
        other.extend_upper(&a, &mut y);
        x.into_iter().zip(y).for_each(|(x, y)| near(x, y));
    }
}
