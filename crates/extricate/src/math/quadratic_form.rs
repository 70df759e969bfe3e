//! Quadratic forms on small vectors, row major; of diagonal ones the diagonal alone.

use super::linear_algebra::{cholesky, cholesky_solve, dot, forward_solve, transposed_solve};

/// A symmetric positive definite form `x' A x`.
#[derive(Debug, Clone, Default)]
pub struct QuadraticForm {
    size: usize,
    is_diagonal: bool,
    /// The diagonal, or all of `A`.
    entries: Vec<f64>,
}

/// The Cholesky factor `L` of a form, `A = L L'`.
#[derive(Debug, Clone, Default)]
pub struct Factor {
    size: usize,
    is_diagonal: bool,
    /// The inverse of the diagonal, or the lower triangle of `L`.
    entries: Vec<f64>,
}

impl QuadraticForm {
    /// Begins anew with zeros; what is off a diagonal cannot be set.
    pub fn reset(&mut self, size: usize, is_diagonal: bool) {
        (self.size, self.is_diagonal) = (size, is_diagonal);
        self.entries.clear();
        self.entries.resize(if is_diagonal { size } else { size * size }, 0.0);
    }

    /// Becomes another one, in the memory that it has.
    pub fn copy_from(&mut self, other: &Self) {
        (self.size, self.is_diagonal) = (other.size, other.is_diagonal);
        self.entries.clone_from(&other.entries);
    }

    /// The identity.
    pub fn identity(size: usize) -> Self {
        Self { size, is_diagonal: true, entries: vec![1.0; size] }
    }

    /// A form of all its entries, row major, for tests.
    #[cfg(test)]
    pub fn dense(size: usize, entries: Vec<f64>) -> Self {
        debug_assert_eq!(entries.len(), size * size);
        Self { size, is_diagonal: false, entries }
    }

    /// Length of the vectors.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Whether only its diagonal is kept.
    pub fn is_diagonal(&self) -> bool {
        self.is_diagonal
    }

    /// The diagonal, or all of it, row major.
    pub fn entries_mut(&mut self) -> &mut [f64] {
        &mut self.entries
    }

    /// The same to read.
    pub fn entries(&self) -> &[f64] {
        &self.entries
    }

    fn step(&self) -> usize {
        if self.is_diagonal { 1 } else { self.size + 1 }
    }

    /// An entry of the diagonal.
    pub fn diagonal(&self, at: usize) -> f64 {
        self.entries[at * self.step()]
    }

    /// Adds a share of the largest entry of the diagonal, which is `least` at least, to all of
    /// them.
    pub fn damp(&mut self, share: f64, least: f64) {
        let step = self.step();
        let largest = self.entries.iter().step_by(step).copied().fold(0.0, f64::max).max(least);
        self.entries.iter_mut().step_by(step).for_each(|entry| *entry += share * largest);
    }

    /// `a' A b`.
    pub fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        if self.is_diagonal {
            return self.entries.iter().zip(a.iter().zip(b)).map(|(h, (a, b))| h * a * b).sum();
        }
        let rows = self.entries.chunks_exact(self.size.max(1)).zip(a);
        rows.map(|(row, a)| a * dot(row, &b[..self.size])).sum()
    }

    /// The root of `a' A a`.
    pub fn length(&self, a: &[f64]) -> f64 {
        self.product(a, a).max(0.0).sqrt()
    }

    /// Replaces `factor` by that of the form.
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
    /// Whether it is that of a diagonal form.
    pub fn is_diagonal(&self) -> bool {
        self.is_diagonal
    }

    /// An entry of the inverse of a diagonal form.
    pub fn inverse(&self, at: usize) -> f64 {
        self.entries[at]
    }

    /// `A^-1 x`, in place.
    #[inline(always)]
    pub fn solve(&self, x: &mut [f64]) {
        if self.is_diagonal {
            x.iter_mut().zip(&self.entries).for_each(|(x, inverse)| *x *= inverse);
        } else {
            cholesky_solve(&self.entries, self.size, x);
        }
    }

    /// `L^-1 x`, in place.
    pub fn solve_lower(&self, x: &mut [f64]) {
        if self.is_diagonal {
            x.iter_mut().zip(&self.entries).for_each(|(x, inverse)| *x *= inverse.sqrt());
        } else {
            forward_solve(&self.entries, self.size, x);
        }
    }

    /// `L'^-1 x`, in place.
    pub fn solve_upper(&self, x: &mut [f64]) {
        if self.is_diagonal {
            self.solve_lower(x);
        } else {
            transposed_solve(&self.entries, self.size, x);
        }
    }

    /// Appends `L' x`.
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

    /// What a diagonal form and its factor say is what the same form says with all its entries.
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
