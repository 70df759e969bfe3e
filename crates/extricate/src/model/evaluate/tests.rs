//! Tests that figures hold for configurations that were not measured.

use super::*;
use crate::learning::LearnOptions;
use crate::model::Model;
use crate::query::prepared::tests::colliding;
use crate::query::query;
use crate::scene::builtin;

fn learned(labels: usize) -> Model {
    let options = LearnOptions { labels, seconds: None, seed: 2, ..LearnOptions::default() };
    Model::learn(builtin::scene("planar-arm").unwrap(), &options).unwrap()
}

/// Context of queries with a model, in its own scene.
pub fn of_model(model: &Model) -> Context<'_> {
    model.prepared().with(Some(model.stored()))
}

#[test]
fn figures_hold_for_configurations_that_were_not_measured() {
    let model = learned(60_000);
    let found = model.statistics();
    let (density, excess) = (found.density.unwrap(), found.excess.unwrap());
    let options = QueryOptions { effort: Effort::Nearest, ..QueryOptions::default() };
    let (context, mut scratch) = (of_model(&model), QueryScratch::default());
    let queries = colliding(model.prepared(), 2000);
    let answers: Vec<_> = queries.iter().map(|q| query(&context, q, &options, &mut scratch).unwrap()).collect();
    let share = |of: &dyn Fn(&crate::query::Answer) -> bool| {
        answers.iter().filter(|answer| of(answer)).count() as f64 / answers.len() as f64
    };
    for (reach, expected) in [(density.reach_median, 0.5), (density.reach_p95, 0.95)] {
        let nearer = share(&|answer| answer.depth <= reach);
        assert!((nearer - expected).abs() < 0.07, "{nearer} {expected}");
    }
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
fn a_caller_that_says_no_gets_nothing() {
    const LABELS: usize = 12_000;
    let model = learned(LABELS);
    for most in [0, 1, 3, 9] {
        let mut asked = 0;
        let mut go_on = || {
            asked += 1;
            asked <= most
        };
        assert!(measure(model.prepared(), model.boundary(), &Extent::after(LABELS, 1), &mut go_on).is_none(), "{most}");
    }
    let over = Extent { until: Some(Instant::now()), ..Extent::after(LABELS, 1) };
    let found = measure(model.prepared(), model.boundary(), &over, &mut || true).unwrap();
    assert_eq!((found.density, found.excess, found.gap, found.checks), (None, None, None, 0));
}
