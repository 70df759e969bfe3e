//! Small isolated components of the colliding configurations, as self-collision makes them: how
//! many learning finds, compared with uniform sampling of as many labels. `cargo test -p extricate
//! --test all components -- --nocapture` prints both.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use extricate::internals::cspace::sampling::{Halton, uniform};
use extricate::{Checker, Label, Model, Scene};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::baselines::{
    FIXED_HUBS_3000_LABELS_COMPONENTS, FIXED_HUBS_10000_LABELS_COMPONENTS, SLIDING_HUBS_3000_LABELS_COMPONENTS,
    SLIDING_HUBS_10000_LABELS_COMPONENTS, SMALL_COMPONENTS_CONFIGS,
};
use crate::memory::{learn, scene};

/// Lengths of the spokes of two wheels \[m\] whose hubs are 2 m apart. Spoke `i` of one and `j` of
/// the other touch only if both point at each other, in a component of their own; shorter spokes
/// make it smaller.
const SPOKE_LENGTHS_M: [[f64; 5]; 2] = [[1.0, 1.004, 1.008, 1.012, 1.016], [0.996, 1.002, 1.008, 1.014, 1.02]];
const SPOKE_RADIUS_M: f64 = 0.012;
/// Angle within which two spokes can meet \[rad\]; their neighbours are 1.26 rad away.
const MEETING_ANGLE_RAD: f64 = 0.5;

/// Makes the scene of the wheels. If `slide` \[m\] is above 0, the hubs are on carts that slide so
/// far across the line between them: four degrees of freedom, and even smaller components.
fn wheels(slide: f64) -> Scene {
    let mut urdf = String::from("<robot name=\"wheels\"><link name=\"base\"/>");
    for (wheel, lengths) in SPOKE_LENGTHS_M.iter().enumerate() {
        let _ = write!(urdf, "<link name=\"wheel{wheel}\">");
        for (i, length) in lengths.iter().enumerate() {
            let (sin, cos) = (TAU * i as f64 / 5.0).sin_cos();
            // Spokes begin at a tenth of their length, and so stay apart at the hub.
            let _ = write!(
                urdf,
                "<collision><origin xyz=\"{} {} 0\" rpy=\"0 {} {}\"/><geometry><capsule radius=\"{SPOKE_RADIUS_M}\" length=\"{}\"/>\
                 </geometry></collision>",
                0.55 * length * cos,
                0.55 * length * sin,
                PI / 2.0,
                TAU * i as f64 / 5.0,
                0.9 * length
            );
        }
        let (mut hub, mut x) = ("base".to_string(), 2 * wheel);
        if slide > 0.0 {
            let _ = write!(
                urdf,
                "</link><link name=\"cart{wheel}\"/><joint name=\"slide{wheel}\" type=\"prismatic\"><parent link=\"base\"/>\
                 <child link=\"cart{wheel}\"/><origin xyz=\"{x} 0 0\"/><axis xyz=\"0 1 0\"/>\
                 <limit lower=\"{}\" upper=\"{slide}\" effort=\"1\" velocity=\"1\"/></joint>",
                -slide
            );
            (hub, x) = (format!("cart{wheel}"), 0);
        } else {
            urdf += "</link>";
        }
        let _ = write!(
            urdf,
            "<joint name=\"turn{wheel}\" type=\"continuous\"><parent link=\"{hub}\"/><child link=\"wheel{wheel}\"/>\
             <origin xyz=\"{x} 0 0\"/><axis xyz=\"0 0 1\"/></joint>"
        );
    }
    scene("[[robot]]\nurdf = \"wheels.urdf\"\n", &[("wheels.urdf", urdf + "</robot>")])
}

/// Returns the component that `q` is in or beside, if any: the spokes that point at the other hub.
fn component(q: &[f64]) -> Option<usize> {
    let pointing = |angle: f64, target: f64| {
        (0..5).find(|i| ((angle + TAU * *i as f64 / 5.0 - target + PI).rem_euclid(TAU) - PI).abs() < MEETING_ANGLE_RAD)
    };
    // The joints of one wheel follow those of the other.
    let (first, second) = (q[q.len() / 2 - 1], q[q.len() - 1]);
    Some(5 * pointing(first, 0.0)? + pointing(second, PI)?)
}

fn count(found: impl Iterator<Item = usize>) -> usize {
    let mut seen = [false; 25];
    found.for_each(|i| seen[i] = true);
    seen.iter().filter(|seen| **seen).count()
}

/// Counts the components beside which the model has a verified boundary sample, without stand-ins.
fn found_by_learning(model: &Model) -> usize {
    let samples = model.boundary().configs().chunks_exact(model.scene().space().nq());
    count(samples.skip(model.statistics().stand_ins).filter_map(component))
}

/// Counts the components that contain at least one of `labels` uniform configurations.
fn found_by_chance(scene: &Scene, checker: &Checker, labels: usize, seed: u64) -> usize {
    let (mut rng, mut q, mut scratch) =
        (ChaCha8Rng::seed_from_u64(seed), vec![0.0; scene.space().nq()], Default::default());
    count((0..labels).filter_map(|_| {
        uniform(scene.space(), &mut rng, &mut q);
        (checker.label(&q, &mut scratch) == Label::Colliding).then(|| component(&q))?
    }))
}

#[test]
fn there_are_as_many_components_as_pairs_of_spokes() {
    let scene = wheels(0.0);
    let checker = Checker::new(std::sync::Arc::new(scene.clone()));
    let (halton, mut q, mut scratch) = (Halton::new(2, 3), vec![0.0; 2], Default::default());
    let (mut inside, mut sizes) = (0, [0; 25]);
    for i in 0..200_000 {
        halton.config(scene.space(), i, &mut q);
        if checker.label(&q, &mut scratch) == Label::Colliding {
            inside += 1;
            sizes[component(&q).expect("only spokes that point at each other touch")] += 1;
        }
    }
    println!("components: {:.3} % of all configurations; of 200,000: {sizes:?}", inside as f64 / 2000.0);
    assert!(sizes.iter().all(|size| *size > 0) && inside < SMALL_COMPONENTS_CONFIGS, "{sizes:?}");
}

#[test]
fn small_components_are_found() {
    for (slide, labels, least) in [
        (0.0, 3000, FIXED_HUBS_3000_LABELS_COMPONENTS),
        (0.0, 10_000, FIXED_HUBS_10000_LABELS_COMPONENTS),
        (0.6, 3000, SLIDING_HUBS_3000_LABELS_COMPONENTS),
        (0.6, 10_000, SLIDING_HUBS_10000_LABELS_COMPONENTS),
    ] {
        let scene = wheels(slide);
        let checker = Checker::new(std::sync::Arc::new(scene.clone()));
        let (mut learned, mut by_chance) = (0, 0);
        for seed in 0..4 {
            learned += found_by_learning(&learn(scene.clone(), labels, seed));
            by_chance += found_by_chance(&scene, &checker, labels, seed);
        }
        println!(
            "slide {slide} m, {labels} labels, 4 seeds: {learned} of 100 components learned, {by_chance} by uniform sampling"
        );
        assert!(
            learned >= least.max(by_chance),
            "slide {slide} m: {learned} of 100 with {labels} labels, {by_chance} by chance"
        );
    }
}
