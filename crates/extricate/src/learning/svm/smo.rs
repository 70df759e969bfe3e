//! Trains a support vector classifier by sequential minimal optimisation. Features, scaling and the
//! choice of parameters are elsewhere.
//!
//! The problem is stated in signed coefficients `beta_i = y_i alpha_i` (`y = 1` for free, `-1` for
//! colliding), as in L. Bottou and C.-J. Lin, "Support vector machine solvers", 2007. It is to
//! maximise `sum y_i beta_i - 1/2 beta' K beta` with `sum beta = 0` and `0 <= y_i beta_i <= C_i`.
//! Its gradient, here the *error* `y_i - (K beta)_i`, equals the bias at the optimum for every
//! coefficient strictly between its bounds. No label then appears in the inner loops.

use super::kernel::PointSet;
use super::kernel_cache::RowCache;
use super::kernel_tile::kernel_sums;
use super::working_set::{ActiveSet, Coefficient, error_range, may_rest};

/// Training gives up after this many steps per point; the sets tried here need less than a tenth.
const MAX_STEPS_PER_POINT: u64 = 2_000;

/// Steps between two tests of which points may rest: rare enough to cost nothing, since a test is
/// one pass over the points.
const STEPS_BETWEEN_REST_TESTS: u64 = 500;

/// Points are gathered again once fewer than this share of them still take part.
const GATHER_SHARE: f64 = 0.7;

/// Parameters of the training problem, and the accuracy of its solution.
#[derive(Debug, Clone)]
pub struct SvmOptions {
    /// Bound `C` on the coefficients of points labelled `true`.
    pub c_positive: f64,
    /// Bound `C` on the coefficients of points labelled `false`.
    pub c_negative: f64,
    /// Factor `gamma` of the kernel `exp(-gamma |x - y|^2)`.
    pub gamma: f64,
    /// Violation of the optimality conditions at which to stop, in units of the decision value.
    pub tolerance: f64,
    /// Memory for kernel rows \[bytes\]; at least two rows are kept. The solution does not depend
    /// on it.
    pub cache_bytes: usize,
}

/// Solution of [`train`], and what it cost.
#[derive(Debug, Clone)]
pub struct SvmSolution {
    /// Dual variables, `0 <= alpha <= C`; zero unless the point is a support vector.
    pub alphas: Vec<f64>,
    /// The decision value is `sum y_i alpha_i K(x_i, x) + bias`.
    pub bias: f64,
    /// Number of steps, each of two variables.
    pub iterations: u64,
    /// Number of errors updated by all steps, which measures their cost.
    pub renewed: u64,
    /// Most memory that kernel rows took \[bytes\].
    pub cached: usize,
    /// Dual objective `sum alpha - 1/2 sum alpha_i alpha_j y_i y_j K_ij`, which training maximises.
    pub dual_objective: f64,
    /// Largest remaining violation of the optimality conditions; at most the tolerance unless the
    /// steps ran out.
    pub violation: f64,
}

/// Solves the dual problem of the soft-margin classifier with a Gaussian kernel.
///
/// `labels[i]` is the class of point `i`. `warm` holds dual variables of the first points to start
/// from. If they break their bounds or the balance of the classes, both are restored.
///
/// # Guarantee
/// At the end, `error_i - error_j <= tolerance` for all `i` whose signed coefficient may grow and
/// all `j` whose coefficient may shrink (equation 6 of the source). This holds for the kernel
/// matrix in `f32`. The result depends on the arguments alone, not on the number of threads.
///
/// # Cost
/// A step takes two passes over the points that take part, and computes up to two kernel rows that
/// the cache lacks.
///
/// # Source
/// R.-E. Fan, P.-H. Chen, C.-J. Lin, "Working set selection using second order information for
/// training support vector machines", JMLR 6, 2005, section 2.3 (WSS 2). Shrinking after T.
/// Joachims, 1998, with one deviation: points that rest leave the arrays and the rows, so that the
/// passes stay contiguous.
pub fn train(points: &PointSet, labels: &[bool], options: &SvmOptions, warm: Option<&[f64]>) -> SvmSolution {
    train_looking(points, labels, options, warm, STEPS_BETWEEN_REST_TESTS)
}

/// Does the same as [`train`], with `between_looks` steps between two tests for points that rest.
fn train_looking(
    points: &PointSet,
    labels: &[bool],
    options: &SvmOptions,
    warm: Option<&[f64]>,
    between_looks: u64,
) -> SvmSolution {
    assert_eq!(points.len(), labels.len(), "one label a point");
    let mut all: Vec<Coefficient> = labels
        .iter()
        .map(|positive| match positive {
            true => Coefficient { beta: 0.0, error: 1.0, least: 0.0, greatest: options.c_positive },
            false => Coefficient { beta: 0.0, error: -1.0, least: -options.c_negative, greatest: 0.0 },
        })
        .collect();
    let mut known = all.clone();
    if let Some(warm) = warm {
        start_from(warm, &mut all);
        renew_errors(points, options.gamma, &known, &mut all, |_| true);
    }
    let limit = MAX_STEPS_PER_POINT * labels.len().max(100) as u64;
    let mut effort = Effort { limit, between_looks, iterations: 0, renewed: 0, cached: 0 };
    let mut active = (0..labels.len() as u32).collect::<Vec<u32>>();
    let violation = loop {
        known.copy_from_slice(&all);
        let left = solve(points, &mut all, active, options, &mut effort);
        let mut rests = vec![true; labels.len()];
        left.iter().for_each(|i| rests[*i as usize] = false);
        renew_errors(points, options.gamma, &known, &mut all, |i| rests[i]);
        let range = error_range(all.iter().copied());
        if range.0 - range.1 <= options.tolerance || effort.iterations >= limit {
            break (range.0 - range.1).max(0.0);
        }
        active = (0..labels.len() as u32).filter(|i| !may_rest(&all[*i as usize], range)).collect();
    };
    solution(labels, &all, &effort, violation)
}

/// Cost of training so far, and its limit.
struct Effort {
    /// Largest number of steps.
    limit: u64,
    between_looks: u64,
    iterations: u64,
    renewed: u64,
    cached: usize,
}

/// Takes steps among the points `active` until they satisfy the optimality conditions; returns
/// those that still took part.
fn solve(
    points: &PointSet,
    all: &mut [Coefficient],
    active: Vec<u32>,
    options: &SvmOptions,
    effort: &mut Effort,
) -> Vec<u32> {
    let mut rows = RowCache::new(points.gather(&active), options.gamma, options.cache_bytes);
    let mut set = ActiveSet::gather(all, active);
    let mut next_look = effort.iterations.saturating_add(effort.between_looks);
    let mut first = set.first();
    while let Some(i) = first {
        let second = set.second(i.value, rows.row(i.position));
        let Some(j) = second.filter(|j| j.value > options.tolerance && effort.iterations < effort.limit) else { break };
        let (row_i, row_j) = rows.two_rows(i.position, j.position);
        first = set.step(i.position, j.position, row_i, row_j);
        effort.iterations += 1;
        effort.renewed += set.points.len() as u64;
        if effort.iterations >= next_look {
            next_look += effort.between_looks;
            let keep = set.restless();
            if (keep.len() as f64) < GATHER_SHARE * set.points.len() as f64 {
                set.scatter(all);
                effort.cached = effort.cached.max(rows.bytes_held());
                rows.keep(&keep);
                set = ActiveSet::gather(all, keep.iter().map(|p| set.points[*p as usize]).collect());
                first = set.first();
            }
        }
    }
    set.scatter(all);
    effort.cached = effort.cached.max(rows.bytes_held());
    set.points
}

/// Copies `warm` and makes it feasible: clamps it to the bounds, then scales the heavier class down
/// to balance.
fn start_from(warm: &[f64], all: &mut [Coefficient]) {
    let (mut positive, mut negative) = (0.0, 0.0);
    for (c, alpha) in all.iter_mut().zip(warm) {
        let bound = c.least + c.greatest; // one of them is 0
        c.beta = alpha.clamp(0.0, bound.abs()).copysign(bound);
        positive += c.beta.max(0.0);
        negative -= c.beta.min(0.0);
    }
    let balance = f64::min(positive, negative);
    for c in all.iter_mut().take(warm.len()) {
        let sum = if c.greatest > 0.0 { positive } else { negative };
        if balance < sum {
            c.beta *= balance / sum;
        }
    }
}

/// Updates the errors of the chosen points from `known` ones by the changes of coefficients.
fn renew_errors(
    points: &PointSet,
    gamma: f64,
    known: &[Coefficient],
    all: &mut [Coefficient],
    chosen: impl Fn(usize) -> bool,
) {
    let change = |i: u32| all[i as usize].beta - known[i as usize].beta;
    let chosen: Vec<u32> = (0..all.len() as u32).filter(|i| chosen(*i as usize)).collect();
    if chosen.is_empty() {
        return;
    }
    let (changed, changes): (Vec<u32>, Vec<f64>) =
        (0..all.len() as u32).map(|i| (i, change(i))).filter(|(_, change)| *change != 0.0).unzip();
    let sums = kernel_sums(&points.gather(&chosen), &points.gather(&changed), &changes, gamma);
    for (i, sum) in chosen.into_iter().map(|i| i as usize).zip(sums) {
        all[i].error = known[i].error - sum;
    }
}

fn solution(labels: &[bool], all: &[Coefficient], effort: &Effort, violation: f64) -> SvmSolution {
    let (mut objective, mut inside, mut count) = (0.0, 0.0, 0usize);
    for (c, positive) in all.iter().zip(labels) {
        objective += 0.5 * c.beta * (c.error + if *positive { 1.0 } else { -1.0 });
        if c.grows() && c.shrinks() {
            inside += c.error;
            count += 1;
        }
    }
    // If no coefficient lies inside its bounds, any bias between these two satisfies the optimality
    // conditions.
    let (lower, upper) = error_range(all.iter().copied());
    let bias = match (count, lower.is_finite(), upper.is_finite()) {
        (1.., ..) => inside / count as f64,
        (0, true, true) => 0.5 * (lower + upper),
        (0, true, false) => lower,
        (0, false, true) => upper,
        (0, false, false) => 0.0,
    };
    let alphas = all.iter().map(|c| c.beta.abs()).collect();
    let Effort { iterations, renewed, cached, .. } = *effort;
    SvmSolution { alphas, bias, iterations, renewed, cached, dual_objective: objective, violation }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Two noisy classes in the plane.
    fn data(n: usize, seed: u64) -> (Vec<f64>, Vec<bool>) {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let rows: Vec<f64> = (0..2 * n).map(|_| f64::from(rng.random::<f32>() * 4.0 - 2.0)).collect();
        let noisy = |x: &[f64]| ((0.7..1.4).contains(&f64::hypot(x[0], x[1]))) ^ (rng.random::<f64>() < 0.05);
        let labels = rows.chunks_exact(2).map(noisy).collect();
        (rows, labels)
    }

    fn options(tolerance: f64) -> SvmOptions {
        SvmOptions { c_positive: 40.0, c_negative: 15.0, gamma: 2.0, tolerance, cache_bytes: 1 << 20 }
    }

    fn kernel(rows: &[f64], gamma: f64) -> Vec<Vec<f64>> {
        let squared = |a: &[f64], b: &[f64]| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
        rows.chunks_exact(2).map(|a| rows.chunks_exact(2).map(|b| (-gamma * squared(a, b)).exp()).collect()).collect()
    }

    fn signs(labels: &[bool]) -> Vec<f64> {
        labels.iter().map(|positive| if *positive { 1.0 } else { -1.0 }).collect()
    }

    /// Largest violation of the conditions of Karush, Kuhn and Tucker, with the kernel in `f64`.
    fn violation(rows: &[f64], labels: &[bool], options: &SvmOptions, alphas: &[f64]) -> f64 {
        let (kernel, y) = (kernel(rows, options.gamma), signs(labels));
        let all = (0..labels.len()).map(|i| {
            let field: f64 = (0..labels.len()).map(|j| kernel[i][j] * y[j] * alphas[j]).sum();
            let (least, greatest) = if labels[i] { (0.0, options.c_positive) } else { (-options.c_negative, 0.0) };
            let beta = y[i] * alphas[i];
            assert!((least..=greatest).contains(&beta));
            Coefficient { beta, error: y[i] - field, least, greatest }
        });
        let (largest, least) = error_range(all);
        largest - least
    }

    #[test]
    fn solution_satisfies_the_optimality_conditions() {
        for (n, cache_bytes) in [(700, 1 << 24), (333, 0)] {
            let (rows, labels) = data(n, n as u64);
            let options = SvmOptions { cache_bytes, ..options(1e-3) };
            let solution = train(&PointSet::from_rows(&rows, 2), &labels, &options, None);
            assert!(solution.violation <= 1e-3);
            let violation = violation(&rows, &labels, &options, &solution.alphas);
            assert!(violation <= 1e-3 + 2e-4, "{violation}"); // rows are f32
            let balance: f64 = solution.alphas.iter().zip(signs(&labels)).map(|(a, y)| a * y).sum();
            assert!(balance.abs() < 1e-9, "{balance}");
        }
    }

    #[test]
    fn agrees_with_projected_gradients() {
        let (rows, labels) = data(60, 5);
        let options = options(1e-5);
        let solution = train(&PointSet::from_rows(&rows, 2), &labels, &options, None);
        let slow = projected_gradients(&rows, &labels, &options);
        assert!((solution.dual_objective / slow - 1.0).abs() < 1e-4, "{} {slow}", solution.dual_objective);
    }

    /// Slow twin: gradient ascent, projected onto the box and the balance by bisection. Returns the
    /// dual objective.
    fn projected_gradients(rows: &[f64], labels: &[bool], options: &SvmOptions) -> f64 {
        let (kernel, y, n) = (kernel(rows, options.gamma), signs(labels), labels.len());
        let bounds = |i: usize| if labels[i] { (0.0, options.c_positive) } else { (-options.c_negative, 0.0) };
        let gradient = |beta: &[f64]| -> Vec<f64> {
            (0..n).map(|i| y[i] - (0..n).map(|j| kernel[i][j] * beta[j]).sum::<f64>()).collect()
        };
        let mut beta = vec![0.0; n];
        let rate = 1.0 / kernel.iter().map(|row| row.iter().sum::<f64>()).fold(0.0, f64::max);
        for _ in 0..40_000 {
            let moved: Vec<f64> = gradient(&beta).iter().zip(&beta).map(|(g, b)| b + rate * g).collect();
            let shifted = |shift: f64| (0..n).map(|i| (moved[i] - shift).clamp(bounds(i).0, bounds(i).1)).collect();
            let (mut low, mut high) = (-1e3, 1e3);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let trial: Vec<f64> = shifted(middle);
                *(if trial.iter().sum::<f64>() > 0.0 { &mut low } else { &mut high }) = middle;
            }
            beta = shifted(low);
        }
        let gradient = gradient(&beta);
        (0..n).map(|i| 0.5 * beta[i] * (y[i] + gradient[i])).sum()
    }

    #[test]
    fn warm_start_is_made_feasible_and_ends_at_the_same_optimum() {
        let (rows, labels) = data(400, 6);
        let points = PointSet::from_rows(&rows, 2);
        let cold = train(&points, &labels, &options(1e-4), None);
        let mut warm = train(&PointSet::from_rows(&rows[..600], 2), &labels[..300], &options(1e-4), None).alphas;
        warm[0] = 1e9;
        warm[1] = -1.0;
        let warm = train(&points, &labels, &options(1e-4), Some(&warm));
        assert!((warm.dual_objective / cold.dual_objective - 1.0).abs() < 1e-6);
        assert!(violation(&rows, &labels, &options(1e-4), &warm.alphas) < 3e-4);
    }

    /// The saving differs from set to set, from nothing to half of the steps.
    #[test]
    fn a_warm_start_takes_fewer_steps() {
        let mut steps = [0; 2];
        for n in [300, 500, 1000, 2000, 3000, 5000] {
            let (rows, labels) = data(n, 7);
            let (points, before) = (PointSet::from_rows(&rows, 2), n - n / 10);
            let cold = train(&points, &labels, &options(1e-2), None);
            let first = train(&PointSet::from_rows(&rows[..2 * before], 2), &labels[..before], &options(1e-2), None);
            let warm = train(&points, &labels, &options(1e-2), Some(&first.alphas));
            println!("{n} points: {} steps, {} from those of {before}", cold.iterations, warm.iterations);
            steps = [steps[0] + cold.iterations, steps[1] + warm.iterations];
        }
        assert!(5 * steps[1] <= 4 * steps[0], "{steps:?}");
    }

    /// The slow twin never lets points rest, so every step updates the errors of all.
    #[test]
    fn resting_points_save_work_and_change_nothing() {
        let (rows, labels) = data(4000, 8);
        let points = PointSet::from_rows(&rows, 2);
        let slow = train_looking(&points, &labels, &options(1e-3), None, u64::MAX);
        let fast = train(&points, &labels, &options(1e-3), None);
        println!(
            "errors renewed {} of {}, steps {} of {}",
            fast.renewed, slow.renewed, fast.iterations, slow.iterations
        );
        assert_eq!(slow.renewed, slow.iterations * 4000);
        assert!(3 * fast.renewed <= slow.renewed, "{} {}", fast.renewed, slow.renewed);
        assert!((fast.dual_objective / slow.dual_objective - 1.0).abs() < 1e-5);
        assert!(fast.violation <= 1e-3, "{}", fast.violation);
    }
}
