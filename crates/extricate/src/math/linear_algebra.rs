//! Dense linear algebra for small problems of any size: row-major slices, no allocation.

/// Number of partial sums in [`dot`]; independent sums need not wait for each other.
pub const LANES: usize = 4;

/// Returns the inner product `a' b`.
#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for (x, y) in a.iter().zip(b) {
        sums.iter_mut().zip(x.iter().zip(y)).for_each(|(sum, (x, y))| *sum += x * y);
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(x, y)| x * y).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// Replaces a row-major matrix by its Cholesky factor (lower triangle). A pivot below 1e-14 of the
/// largest diagonal entry is raised to that value.
#[inline(always)]
pub fn cholesky(m: &mut [f64], n: usize) {
    let floor = (0..n).map(|k| m[k * n + k]).fold(f64::MIN_POSITIVE, f64::max) * 1e-14;
    for j in 0..n {
        for i in j..n {
            let sum = m[i * n + j] - dot(&m[i * n..i * n + j], &m[j * n..j * n + j]);
            m[i * n + j] = if i == j { sum.max(floor).sqrt() } else { sum / m[j * n + j] };
        }
    }
}

/// Solves `L L' x = b` in place for the lower triangle `L`.
#[inline(always)]
pub fn cholesky_solve(factor: &[f64], n: usize, x: &mut [f64]) {
    forward_solve(factor, n, x);
    transposed_solve(factor, n, x);
}

/// Solves `L x = b` in place for the lower triangle `L`.
#[inline(always)]
pub fn forward_solve(factor: &[f64], n: usize, x: &mut [f64]) {
    for i in 0..n {
        x[i] = (x[i] - dot(&factor[i * n..i * n + i], &x[..i])) / factor[i * n + i];
    }
}

/// Solves `L' x = b` in place for the lower triangle `L`.
#[inline(always)]
pub fn transposed_solve(factor: &[f64], n: usize, x: &mut [f64]) {
    for i in (0..n).rev() {
        let mut sum = x[i];
        for j in i + 1..n {
            sum -= factor[j * n + i] * x[j];
        }
        x[i] = sum / factor[i * n + i];
    }
}

/// Returns the Euclidean distance between two points.
#[inline(always)]
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b) {
        sum += (a - b) * (a - b);
    }
    sum.sqrt()
}
