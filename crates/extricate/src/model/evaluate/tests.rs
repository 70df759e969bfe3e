//! Figures hold for configurations that were not measured.

use super::*;
use crate::collision::Checker;
use crate::learning::LearnOptions;
use crate::metric::Metric;
use crate::model::{Model, Statistics};
use crate::samples::SampleKind;
use crate::scene::builtin;

fn learned(labels: usize) -> Model {
    let options = LearnOptions { labels, seconds: None, seed: 2, ..LearnOptions::default() };
    Model::learn(builtin::scene("planar-arm").unwrap(), &options).unwrap()
}

/// Uniform colliding configurations that nothing else uses.
pub fn colliding(model: &Model, count: usize) -> Vec<Config> {
    let space = &model.scene().space;
    let (mut rng, mut q) = (ChaCha8Rng::seed_from_u64(4711), vec![0.0; space.nq()]);
    let all = std::iter::repeat_with(|| {
        uniform(space, &mut rng, &mut q);
        space.config(&q).unwrap()
    });
    all.filter(|q| model.checker().label(q, &mut Default::default()) == Label::Colliding).take(count).collect()
}

#[test]
fn figures_hold_for_configurations_that_were_not_measured() {
    let model = learned(60_000);
    let found = model.statistics();
    let (density, excess) = (found.density.unwrap(), found.excess.unwrap());
    let options = QueryOptions { effort: Effort::Nearest, ..QueryOptions::default() };
    let mut scratch = QueryScratch::default();
    let answers: Vec<_> =
        colliding(&model, 2000).iter().map(|q| model.view().query_with(q, &options, &mut scratch).unwrap()).collect();
    let share = |of: &dyn Fn(&crate::query::Answer) -> bool| {
        answers.iter().filter(|answer| of(answer)).count() as f64 / answers.len() as f64
    };
    for (reach, expected) in [(density.reach_median, 0.5), (density.reach_p95, 0.95)] {
        let nearer = share(&|answer| answer.depth <= reach);
        assert!((nearer - expected).abs() < 0.07, "{nearer} {expected}");
    }
    for level in [0.02, 0.1, 0.5] {
        let low = share(&|answer| answer.coverage.unwrap() <= level);
        assert!((low - level).abs() < 0.07, "{low} {level}");
    }
    assert!(share(&|answer| answer.is_far()) < 0.03);
    assert!(0.0 < density.spacing_median && density.spacing_median <= density.spacing_p95);
    assert!(excess.queries >= 8 && 0.0 <= excess.median && excess.median <= excess.p95, "{excess:?}");
    assert!(excess.within_5pct > 0.8, "{excess:?}");
    let gap = found.gap.unwrap();
    assert!(gap.queries == excess.queries && 0.0 < gap.median && gap.median <= gap.p95 && gap.p95 < 1.0, "{gap:?}");
    let [low, high] = found.accuracy_free_interval.unwrap();
    assert!(low < found.accuracy_free.unwrap() && found.accuracy_free.unwrap() < high && high - low < 0.1);
    assert!(found.measuring_checks > 1000 && found.measuring_checks < 60_000, "{}", found.measuring_checks);
}

#[test]
fn coverage_holds_for_queries_that_begin_at_exits() {
    let model = learned(700_000);
    assert_eq!(begins_with(&model.context()).among, SampleKind::Solved, "{}", model.boundary().solved());
    let mut scratch = QueryScratch::default();
    let queries = colliding(&model, 2000);
    let coverages: Vec<f64> = queries
        .iter()
        .map(|q| model.view().query_with(q, &QueryOptions::default(), &mut scratch).unwrap().coverage.unwrap())
        .collect();
    for level in [0.02, 0.1, 0.5] {
        let low = coverages.iter().filter(|coverage| **coverage <= level).count() as f64 / 2000.0;
        assert!((low - level).abs() < 0.05, "{low} {level}");
    }
}

#[test]
fn what_was_not_learned_is_called_far() {
    let model = learned(40_000);
    let nq = model.scene().space.nq();
    // Where the first joint points away from the first cylinder there are no samples any more.
    let seen = |q: &[f64]| q[0].abs() < 1.5;
    let rows = model.boundary().configs().chunks_exact(nq).filter(|q| seen(q)).flatten().copied().collect();
    let scene = model.checker().scene_arc().clone();
    let (coverage, statistics) =
        (model.coverage().clone(), Statistics { solved_samples: 0, ..model.statistics().clone() });
    let holed = Model::from_parts(Checker::new(scene.clone()), Metric::new(scene), rows, None, coverage, statistics);
    let (mut scratch, mut far, mut all) = (QueryScratch::default(), [0; 2], [0; 2]);
    for q in colliding(&model, 400).iter().filter(|q| !(1.0..2.5).contains(&q[0].abs())) {
        let side = usize::from(seen(q));
        all[side] += 1;
        far[side] += usize::from(holed.view().query_with(q, &QueryOptions::default(), &mut scratch).unwrap().is_far());
    }
    assert!(far[0] * 10 > all[0] * 9 && far[1] * 20 < all[1], "{far:?} of {all:?}");
}

#[test]
fn a_caller_that_says_no_gets_nothing() {
    let model = learned(12_000);
    for most in [0, 1, 3, 9] {
        let mut asked = 0;
        let mut go_on = || {
            asked += 1;
            asked <= most
        };
        assert!(measure(&model.context(), &EvaluationBudget::in_full(1), &mut go_on).is_none(), "{most}");
    }
    let over = EvaluationBudget { until: Some(Instant::now()), ..EvaluationBudget::in_full(1) };
    let found = measure(&model.context(), &over, &mut || true).unwrap();
    assert_eq!((found.density, found.excess, found.gap, found.checks), (None, None, None, 0));
}
