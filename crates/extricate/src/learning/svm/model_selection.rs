//! Choice of kernel width and penalty by validation on points that training did not see.

use rand::{Rng, RngExt, SeedableRng};
use rayon::prelude::*;

use super::kernel::{PointSet, WeightedPoints};
use super::options::{FitOptions, Hyperparameters, svm_options};
use super::smo::train;

/// Kernel widths that are tried, from three times the spread of the whole set to a third of it.
const GAMMA_FACTORS: [f64; 5] = [0.1, 0.3, 1.0, 3.0, 10.0];

const PENALTIES: [f64; 4] = [1.0, 10.0, 100.0, 1000.0];

/// Balanced accuracies this close count as equal: half the standard error for some hundred points
/// of the rarer class.
const EQUAL_ACCURACY_MARGIN: f64 = 0.005;

/// Returns the median of 1,000 squared distances between random pairs of points; 1 in place of 0.
pub fn median_squared_distance(points: &PointSet, seed: u64) -> f64 {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let pair = |_| {
        let (i, j) = (rng.random_range(0..points.len()), rng.random_range(0..points.len()));
        (0..points.dimensions()).map(|k| f64::from(points.coordinate(i, k) - points.coordinate(j, k)).powi(2)).sum()
    };
    let mut squared: Vec<f64> = if points.is_empty() { vec![] } else { (0..1_000).map(pair).collect() };
    squared.sort_by(f64::total_cmp);
    squared.get(squared.len() / 2).copied().filter(|median| *median > 0.0).unwrap_or(1.0)
}

/// Returns the parameters that `options` fix, and for the others those of best balanced accuracy on
/// held-out points. Among equally good ones it takes the least penalty, which trains fastest, then
/// the widest kernel.
pub fn choose(points: &PointSet, free: &[bool], spread: f64, options: &FitOptions) -> Hyperparameters {
    let gamma_factors = options.gamma_factor.map_or(GAMMA_FACTORS.to_vec(), |g| vec![g]);
    let penalties = options.penalty.map_or(PENALTIES.to_vec(), |c| vec![c]);
    let of_penalty = |penalty: &f64| {
        let penalty = *penalty;
        gamma_factors.iter().map(move |gamma_factor| Hyperparameters { gamma_factor: *gamma_factor, penalty })
    };
    let choices: Vec<Hyperparameters> = penalties.iter().flat_map(of_penalty).collect();
    let (training, validation) = split(free, options);
    if choices.len() == 1 || training.is_empty() {
        let middle = |given: Option<f64>, otherwise: f64| given.unwrap_or(otherwise);
        return Hyperparameters {
            gamma_factor: middle(options.gamma_factor, 1.0),
            penalty: middle(options.penalty, 100.0),
        };
    }
    let (seen, seen_free) = (points.gather(&training), of(free, &training));
    let options = &options.shared_out();
    let accuracy = |choice: &Hyperparameters| {
        let solved = svm_options(&seen_free, spread, *choice, options);
        let solution = train(&seen, &seen_free, &solved, None);
        let signed = |(alpha, free): (&f64, &bool)| if *free { *alpha } else { -alpha };
        let weights: Vec<f64> = solution.alphas.iter().zip(&seen_free).map(signed).collect();
        let sum = WeightedPoints::new(seen.clone(), &weights);
        let mut query = vec![0.0; points.dimensions()];
        let (mut right, mut all) = ([0usize; 2], [0usize; 2]);
        for i in &validation {
            points.copy_point(*i as usize, &mut query);
            let truth = free[*i as usize];
            right[usize::from(truth)] +=
                usize::from((sum.kernel_sum(&query, solved.gamma) + solution.bias > 0.0) == truth);
            all[usize::from(truth)] += 1;
        }
        0.5 * right[0] as f64 / all[0].max(1) as f64 + 0.5 * right[1] as f64 / all[1].max(1) as f64
    };
    let accuracies: Vec<f64> = choices.par_iter().map(accuracy).collect();
    let good_enough = accuracies.iter().fold(0.0, |a, b| f64::max(a, *b)) - EQUAL_ACCURACY_MARGIN;
    let first = accuracies.iter().position(|accuracy| *accuracy >= good_enough);
    choices[first.unwrap_or(0)]
}

/// Draws disjoint seeded samples for training and for validation, each of at most about
/// `search_points`. Both are empty if a class has fewer than four points.
///
/// Classes keep their shares, but a rare one gets at least a tenth. With balanced samples, the
/// chosen kernel would be too narrow for the rare class of the whole set.
fn split(free: &[bool], options: &FitOptions) -> (Vec<u32>, Vec<u32>) {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(options.seed.wrapping_add(1));
    let (mut training, mut validation) = (Vec::new(), Vec::new());
    for class in [true, false] {
        let mut members: Vec<u32> = (0..free.len() as u32).filter(|i| free[*i as usize] == class).collect();
        if members.len() < 4 {
            return (Vec::new(), Vec::new());
        }
        shuffle(&mut members, &mut rng);
        let share = (members.len() as f64 / free.len() as f64).max(0.1);
        let most = (share * options.search_points as f64).ceil() as usize;
        // Holds out a third, or more if there are plenty.
        let seen = most.min(members.len() - members.len() / 3);
        training.extend(&members[..seen]);
        validation.extend(members[seen..].iter().take(most));
    }
    training.sort_unstable();
    validation.sort_unstable();
    (training, validation)
}

/// Permutes `items` at random (R. A. Fisher and F. Yates).
fn shuffle(items: &mut [u32], rng: &mut impl Rng) {
    for i in (1..items.len()).rev() {
        items.swap(i, rng.random_range(0..=i));
    }
}

fn of(free: &[bool], points: &[u32]) -> Vec<bool> {
    points.iter().map(|i| free[*i as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn split_is_disjoint_and_holds_both_classes() {
        let free: Vec<bool> = (0..1000).map(|i| i % 5 != 0).collect();
        let (training, validation) = split(&free, &FitOptions { search_points: 1000, ..FitOptions::default() });
        assert!(training.iter().all(|i| validation.binary_search(i).is_err()));
        let count = |part: &[u32]| part.iter().filter(|i| free[**i as usize]).count();
        assert_eq!((training.len(), count(&training)), (534 + 134, 534));
        assert_eq!((validation.len(), count(&validation)), (266 + 66, 266));
        let (training, validation) = split(&free, &FitOptions { search_points: 100, ..FitOptions::default() });
        assert_eq!((training.len(), count(&training), validation.len(), count(&validation)), (100, 80, 100, 80));
        assert!(split(&[true; 9], &FitOptions::default()).0.is_empty());
    }

    #[test]
    fn median_is_that_of_the_pairs() {
        let rows: Vec<f64> = (0..2000).map(f64::from).map(|i| if i % 2.0 == 0.0 { 0.0 } else { 3.0 }).collect();
        let median = median_squared_distance(&PointSet::from_rows(&rows, 2), 0);
        assert_eq!(median, 1.0, "all points are equal");
        let spread = median_squared_distance(&PointSet::from_rows(&rows[..1000], 1), 0);
        assert!(spread == 9.0 || spread == 1.0);
    }
}
