//! Limits of learning: labels are never exceeded. Whatever ends it early, the result is usable and
//! reports how it ended.

use std::ops::ControlFlow;
use std::sync::Arc;

use extricate::{EndedBy, Error, LearnOptions, Model, Result, Solver, builtin};

use crate::baselines::{
    BOUNDARY_FOUND_LABELS, LITTLE_TIME_BOUNDARY_SAMPLES, SOMETHING_FREE_LABELS, SPENT_BUDGET_LABELS, SPENT_LABELS_SHARE,
};
use crate::memory::{labels_alone, scene};

fn learned(labels: usize, seconds: Option<f64>, most_reports: usize) -> Result<Arc<Model>> {
    let mut options = LearnOptions::default().labels(labels).seed(4).threads(2);
    options.seconds = seconds;
    let mut reports = 0;
    Model::learn_with(builtin::scene("planar-arm").unwrap(), &options, &mut |_| {
        reports += 1;
        if reports >= most_reports { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
    .map(Arc::new)
}

fn assert_usable(model: &Arc<Model>) {
    let q = model.scene().space().config(&[0.4, 0.1, 0.0]).unwrap();
    let answer = Solver::of_model(Arc::clone(model)).query(&q).unwrap();
    assert!(answer.depth > 0.0 && answer.verified && answer.lower_bound <= answer.depth, "{answer:?}");
}

#[test]
fn labels_are_a_limit_that_holds() {
    for labels in [1, 2, 3, 10, 31, 100, 997, 5000, 20_000] {
        let model = match learned(labels, None, usize::MAX) {
            Ok(model) => model,
            Err(Error::NothingFree { labels: spent, advice }) => {
                let is_few = spent <= labels && labels < SOMETHING_FREE_LABELS;
                assert!(is_few && advice.contains("too few"), "{spent} {advice}");
                continue;
            }
            Err(other) => panic!("{other}"),
        };
        let found = model.statistics();
        assert!(found.labels <= labels, "{} of {labels}", found.labels);
        assert_eq!(found.ended_by, EndedBy::Labels);
        assert!(labels < BOUNDARY_FOUND_LABELS || found.boundary_gap.is_some(), "no boundary from {labels} labels");
        let is_spent = found.labels as f64 > SPENT_LABELS_SHARE * labels as f64;
        assert!(labels < SPENT_BUDGET_LABELS || is_spent, "{} of {labels}", found.labels);
        assert_usable(&model);
    }
}

/// A slide can clear only one of two walls at a time.
#[test]
fn where_nothing_is_free_the_pairs_that_collide_most_often_are_named() {
    let urdf = r#"<robot name="r"><link name="rail"/><link name="slide"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
        <joint name="x" type="prismatic"><parent link="rail"/><child link="slide"/><axis xyz="1 0 0"/><limit lower="-1" upper="1"/></joint></robot>"#;
    let wall = |name: &str, x: f64| {
        format!("[[obstacle]]\nname = \"{name}\"\nshape = {{ box = [2, 1, 1] }}\npose = {{ xyz = [{x}, 0, 0] }}\n")
    };
    let walls = format!("[[robot]]\nurdf = \"r.urdf\"\n{}{}", wall("left", -1.0), wall("right", 0.5));
    let options = labels_alone(3000, 0);
    // The second case adds a third obstacle, which the slide cannot clear at all.
    let around = "[[obstacle]]\nname = \"around\"\nshape = { box = [4, 1, 1] }\n";
    let told = [
        "no single pair is to blame",
        "[pairs] disable = [[\"slide\", \"around\"]]; of the others, [\"slide\", \"right\"] (",
    ];
    for (toml, told) in [walls.clone(), walls + around].into_iter().zip(told) {
        let scene = scene(&toml, &[("r.urdf", urdf.into())]);
        let error = Model::learn(scene, &options).err().unwrap().to_string();
        let share = |name: &str| -> usize {
            let at = error.split(&format!("[\"slide\", \"{name}\"] (")).nth(1).expect(&error);
            at.split(" %").next().unwrap().parse().expect(&error)
        };
        assert!(error.contains(told), "{error}");
        // The slide hits the right wall from -0.6 on, and the left one up to 0.1.
        assert!((78..=82).contains(&share("right")) && (53..=57).contains(&share("left")), "{error}");
    }
}

#[test]
fn little_time_and_boundless_labels_still_find_the_boundary() {
    // The last of these times is enough for every stage.
    for seconds in [1e-9, 0.2, 1.0] {
        let model = learned(usize::MAX, Some(seconds), usize::MAX).unwrap();
        let found = model.statistics();
        assert_eq!(found.ended_by, EndedBy::Seconds);
        let has_samples = found.boundary_samples > LITTLE_TIME_BOUNDARY_SAMPLES;
        assert!(found.boundary_gap.is_some() && has_samples, "{found:?}");
        assert_usable(&model);
    }
}

#[test]
fn an_interruption_keeps_what_there_is() {
    for reports in [1, 3, 40] {
        let model = learned(1_000_000, None, reports).unwrap();
        assert_eq!(model.statistics().ended_by, EndedBy::Interruption);
        assert!(model.statistics().boundary_gap.is_some(), "{:?}", model.statistics());
        assert_usable(&model);
    }
}

#[test]
fn where_nothing_collides_nothing_is_claimed() {
    let scene = crate::memory::scene(
        "[[robot]]\nurdf = \"r.urdf\"\n",
        &[("r.urdf", crate::memory::chain(&[("revolute", [0.0; 3], [0.0, 0.0, 1.0], -1.0, 1.0, "")]))],
    );
    let found = crate::memory::learn(scene, 3000, 1).statistics().clone();
    assert_eq!((found.boundary_gap, found.accuracy_free, found.accuracy_colliding), (None, None, None));
    assert_eq!((found.labels, found.colliding_share), (3000, 0.0));
}
