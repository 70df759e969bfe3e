//! Robots of kinds that the built-in scenes do not have: one that drives on a plane, and a chain of
//! many joints.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

use extricate::{Answer, CheckScratch, Checker, Config, Effort, Label, QueryOptions, Scene, Solver};

use crate::baselines::{PLANAR_BASE_AS_NEAR_ANSWERS, TWENTY_JOINTS_AS_NEAR_ANSWERS};
use crate::memory::{Joint, chain, collision, learned, scene};
use crate::query::{ask, colliding};

/// Returns refined and exhaustive answers for `count` configurations, from a model learned with few
/// labels, and checks all that they promise.
fn ask_all(scene: Scene, labels: usize, count: usize) -> (Solver, Vec<(Config, [Answer; 2])>) {
    // This checker shares no memory with the solver that answers.
    let checker = Checker::new(Arc::new(scene.clone()));
    let model = learned(scene, labels, 7);
    let mut check = CheckScratch::default();
    let mut all = Vec::new();
    for q in colliding(&model, count) {
        let answers = [Effort::Refined, Effort::Exhaustive].map(|effort| {
            let answer = ask(&model, &q, &QueryOptions::default().effort(effort));
            let witness = model.scene().space().config(&answer.witness).expect("a witness keeps the limits");
            assert!(answer.verified && checker.label(&witness, &mut check) == Label::Free, "{q:?}");
            assert!((model.metric().distance(&q, &witness) - answer.depth).abs() < 1e-6, "{q:?}");
            assert!(answer.depth > 0.0 && answer.lower_bound <= answer.depth, "{answer:?}");
            answer
        });
        let [refined, exhaustive] = &answers;
        assert!(exhaustive.depth <= refined.depth, "{q:?}: {} after {}", exhaustive.depth, refined.depth);
        assert!(refined.lower_bound <= exhaustive.depth && exhaustive.lower_bound <= exhaustive.depth, "{q:?}");
        all.push((q, answers));
    }
    (model, all)
}

/// Returns how many refined answers are at most 1 % farther than the exhaustive ones, and how many
/// bounds are above 0.
fn near_and_bounded(all: &[(Config, [Answer; 2])]) -> (usize, usize) {
    let near = all.iter().filter(|(_, [refined, exhaustive])| refined.depth <= 1.01 * exhaustive.depth).count();
    (near, all.iter().filter(|(_, [refined, _])| refined.lower_bound > 0.0).count())
}

/// A body longer than wide, with a boom that rotates on it, drives in a room of two halves.
#[test]
fn a_robot_on_a_planar_base_before_a_doorway() {
    let boom = collision([0.25, 0.0, 0.0], [0.0; 3], "<box size=\"0.5 0.06 0.06\"/>");
    let body = collision([0.0, 0.0, -0.2], [0.0; 3], "<box size=\"0.7 0.4 0.2\"/>");
    let urdf = chain(&[("revolute", [0.2, 0.0, 0.0], [0.0, 0.0, 1.0], -2.0, 2.0, &boom)]);
    let urdf = urdf.replace("<link name=\"base\"/>", &format!("<link name=\"base\">{body}</link>"));
    let wall = |name: &str, y: f64| {
        format!("[[obstacle]]\nname = \"{name}\"\nshape = {{ box = [0.2, 1.6, 1] }}\npose = {{ xyz = [0, {y}, 0] }}\n")
    };
    // The doorway is a metre wide.
    let toml = format!(
        "[[robot]]\nurdf = \"r.urdf\"\nbase = \"planar\"\nbounds = {{ min = [-2, -1.5], max = [2, 1.5] }}\n{}{}\
         [[obstacle]]\nname = \"column\"\nshape = {{ cylinder = [0.2, 1] }}\npose = {{ xyz = [1.2, 0.4, 0] }}\n",
        wall("left", 1.3),
        wall("right", -1.3)
    );
    let (model, all) = ask_all(scene(&toml, &[("r.urdf", urdf)]), 10_000, 40);
    let space = model.scene().space();
    assert_eq!((space.nq(), space.nv()), (4, 4));
    let mut check = CheckScratch::default();
    for (q, [_, exhaustive]) in &all {
        // Moves straight sideways in steps of 0.02 m: no exit there may be nearer than the answer.
        for k in 0..32 {
            let (sin, cos) = (TAU * f64::from(k) / 32.0).sin_cos();
            let place = |step: i32| {
                let far = 0.02 * f64::from(step);
                space.config(&[q[0] + far * cos, q[1] + far * sin, q[2], q[3]]).ok()
            };
            let free = |place: &Config| model.checker().label(place, &mut check) == Label::Free;
            let Some(out) = (1..100).map_while(place).find(free) else { continue };
            let depth = model.metric().distance(q, &out);
            assert!(exhaustive.depth <= depth, "{q:?}: {} but {depth} sideways", exhaustive.depth);
        }
    }
    let (near, bounded) = near_and_bounded(&all);
    println!("planar base: {near} of 40 as near as exhaustive, {bounded} bounds above 0");
    assert!(near >= PLANAR_BASE_AS_NEAR_ANSWERS && bounded == 40, "{near} {bounded}");
}

#[test]
fn a_chain_of_twenty_joints() {
    let link = collision([0.05, 0.0, 0.0], [0.0, FRAC_PI_2, 0.0], "<capsule radius=\"0.02\" length=\"0.1\"/>");
    let joint = |k: usize| -> Joint {
        let origin = if k == 0 { [0.0; 3] } else { [0.1, 0.0, 0.0] };
        let axis = if k.is_multiple_of(2) { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
        ("revolute", origin, axis, -0.8, 0.8, &link)
    };
    let joints: Vec<Joint> = (0..20).map(joint).collect();
    let post = |k: usize, xyz: [f64; 3]| {
        format!("[[obstacle]]\nname = \"ball_{k}\"\nshape = {{ sphere = 0.2 }}\npose = {{ xyz = {xyz:?} }}\n")
    };
    let places = [[0.6, 0.4, 0.1], [0.8, -0.2, 0.5], [0.9, 0.0, -0.4], [1.2, 0.3, 0.2]];
    let posts: String = places.into_iter().enumerate().map(|(k, xyz)| post(k, xyz)).collect();
    let toml = format!("[[robot]]\nurdf = \"r.urdf\"\n{posts}");
    let (model, all) = ask_all(scene(&toml, &[("r.urdf", chain(&joints))]), 10_000, 20);
    assert_eq!(model.scene().space().nv(), 20);
    let (near, bounded) = near_and_bounded(&all);
    println!("20 joints: {near} of 20 as near as exhaustive, {bounded} bounds above 0");
    assert!(near >= TWENTY_JOINTS_AS_NEAR_ANSWERS && bounded == 20, "{near} {bounded}");
}
