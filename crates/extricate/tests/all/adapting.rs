//! Models adapted to a changed scene: as good as those learned anew, for a fifth of the labels.

use std::sync::Arc;

use extricate::internals::cspace::sampling::Halton;
use extricate::internals::model::adapt::labels_to_adapt;
use extricate::internals::model::{Adapted, EndedBy};
use extricate::{Checker, LearnOptions, Model, QueryOptions, QueryScratch, Scene, builtin};

use crate::memory;

const LABELS: usize = 60_000;

fn options(labels: usize) -> LearnOptions {
    LearnOptions { labels, seconds: None, seed: 6, ..LearnOptions::default() }
}

fn learn(scene: Scene, labels: usize) -> Model {
    Model::learn(scene, &options(labels)).unwrap()
}

fn adapt(model: &Model, scene: Scene, labels: usize) -> Model {
    model.adapt(scene, &options(labels)).unwrap()
}

/// The scene with its first obstacle moved a little.
fn moved(scene: &Scene) -> Scene {
    let mut moved = scene.clone();
    let obstacle = moved.bodies.iter_mut().find(|b| b.robot.is_none()).unwrap();
    obstacle.parts.iter_mut().for_each(|part| {
        part.pose_frame_part.translation.x += 0.03;
        part.pose_frame_part.translation.y -= 0.02;
    });
    moved
}

/// Depths of the first colliding configurations of a sequence, each with its witness checked.
fn depths(model: &Model, count: usize) -> Vec<f64> {
    let scene = model.scene();
    let (checker, halton) = (Checker::new(Arc::new(scene.clone())), Halton::new(scene.space.nv(), 77));
    let (mut scratch, mut q, mut depths) = (QueryScratch::default(), vec![0.0; scene.space.nq()], Vec::new());
    for i in 0.. {
        halton.config(&scene.space, i, &mut q);
        let answer =
            model.view().query_with(&scene.space.config(&q).unwrap(), &QueryOptions::default(), &mut scratch).unwrap();
        if answer.depth > 0.0 {
            assert!(answer.verified && checker.clearance(&answer.witness, &mut Default::default()) >= scene.clearance);
            depths.push(answer.depth);
        }
        if depths.len() == count {
            break;
        }
    }
    depths
}

/// The scene without its first obstacle.
fn without(scene: &Scene) -> Scene {
    let mut without = scene.clone();
    let gone = without.bodies.iter().position(|b| b.robot.is_none()).unwrap();
    without.pairs.retain(|p| p.first != gone && p.second != gone);
    without
}

/// Asserts that `adapted` finds about as many of the nearest exits as `anew`, of the same scene.
fn assert_as_good(what: &str, adapted: &Model, anew: &Model) {
    let (anew, adapted) = (depths(anew, 60), depths(adapted, 60));
    let within = |a: &[f64], b: &[f64]| a.iter().zip(b).filter(|(a, b)| **a <= 1.05 * **b).count();
    let (of_adapted, of_anew) = (within(&adapted, &anew), within(&anew, &adapted));
    assert!(of_adapted + 2 >= of_anew, "{what}: within 5 % of the other: {of_adapted} adapted, {of_anew} anew");
}

#[test]
fn a_small_change_costs_a_fifth_and_no_quality() {
    for name in ["planar-arm", "shelf-arm"] {
        let old = builtin::scene(name).unwrap();
        let model = learn(old.clone(), LABELS);
        // Moved, taken away, and put there.
        let changes = [(&model, moved(&old)), (&model, without(&old)), (&learn(without(&old), LABELS), old)];
        for (change, (model, new)) in changes.into_iter().enumerate() {
            let (anew, adapted) = (learn(new.clone(), LABELS), adapt(model, new, LABELS / 5));
            assert!(adapted.statistics().labels <= LABELS / 5, "{name}: {:?}", adapted.statistics());
            assert!(adapted.statistics().accuracy_free.is_some() && adapted.statistics().boundary_gap.is_some());
            assert_as_good(&format!("{name} {change}"), &adapted, &anew);
        }
    }
}

/// Models with exits; every time a fifth of what learning took, however little the last time did.
#[test]
fn a_model_that_is_adapted_again_and_again_stays_as_good() {
    let there = builtin::scene("planar-arm").unwrap();
    let learned = learn(there.clone(), 150_000);
    let mut model = adapt(&learned, moved(&there), labels_to_adapt(&learned));
    for times in 2..=4 {
        let to = if times % 2 == 0 { there.clone() } else { moved(&there) };
        assert_eq!(labels_to_adapt(&model), labels_to_adapt(&learned));
        model = adapt(&model, to, labels_to_adapt(&model));
        let found = model.statistics();
        assert_eq!(found.adapted, Some(Adapted { learned_labels: learned.statistics().labels, times }));
        assert!(found.solved_samples > learned.statistics().solved_samples / 4 && found.excess.is_some(), "{found:?}");
    }
    assert_as_good("four times", &model, &learned);
}

#[test]
fn every_kept_sample_is_free_in_the_new_scene() {
    let old = builtin::scene("planar-arm").unwrap();
    let without = without(&old);
    let model = learn(old.clone(), 20_000);
    let full = learn(without.clone(), 20_000);
    // Moved, taken away, and put there.
    for (model, new) in [(&model, moved(&old)), (&model, without), (&full, old)] {
        let adapted = adapt(model, new.clone(), 10_000);
        let checker = Checker::new(Arc::new(new));
        let mut scratch = Default::default();
        for q in adapted.boundary().configs().chunks_exact(adapted.scene().space.nq()) {
            assert!(checker.label(q, &mut scratch) == extricate::Label::Free, "{q:?}");
        }
        assert!(adapted.boundary().len() > 500, "{}", adapted.boundary().len());
    }
}

#[test]
fn adapting_keeps_its_limits_and_does_not_depend_on_threads() {
    let old = builtin::scene("planar-arm").unwrap();
    let model = learn(old.clone(), 20_000);
    let with = |threads| {
        let options = LearnOptions { threads, ..options(5000) };
        model.adapt(moved(&old), &options).unwrap()
    };
    assert!(
        extricate::internals::io::model_file::encode(&with(1))
            == extricate::internals::io::model_file::encode(&with(2))
    );
    for labels in [100, 500, 3000] {
        assert!(adapt(&model, moved(&old), labels).statistics().labels <= labels);
    }
    let boundless = LearnOptions { seconds: Some(0.2), ..options(usize::MAX) };
    let boundless = model.adapt(moved(&old), &boundless).unwrap();
    assert_eq!(boundless.statistics().ended_by, EndedBy::Seconds);
    // Nothing changed: the samples stay.
    let same = adapt(&model, old.clone(), 20_000);
    assert_eq!(same.boundary().configs(), model.boundary().configs());
    let other = model.adapt(builtin::scene("hand").unwrap(), &options(100));
    assert!(other.err().unwrap().to_string().contains("learn the scene anew"));
}

/// A slide before a box that grows until it holds all of the rail: the run spends its labels on
/// looking for something free, and ends.
#[test]
fn where_nothing_is_free_any_more_adapting_ends_and_says_so() {
    let urdf = r#"<robot name="r"><link name="rail"/><link name="slide"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
        <joint name="x" type="prismatic"><parent link="rail"/><child link="slide"/><axis xyz="1 0 0"/><limit lower="-1" upper="1"/></joint></robot>"#;
    let beside = |size: f64| {
        let toml = format!(
            "[[robot]]\nurdf = \"r.urdf\"\n[[obstacle]]\nname = \"box\"\nshape = {{ box = [{size}, {size}, {size}] }}\n"
        );
        memory::scene(&toml, &[("r.urdf", urdf.into())])
    };
    let model = learn(beside(0.5), 1000);
    let error = model.adapt(beside(4.0), &options(6000)).err().unwrap().to_string();
    assert!(error.contains("no stored sample is free in the new scene"), "{error}");
}
