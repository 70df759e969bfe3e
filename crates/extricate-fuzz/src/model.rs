//! The target of model files. It corrects the checksum, as an attacker can, so that only the
//! content is left to be refused.

use std::path::Path;
use std::sync::Arc;

use extricate::internals::cspace::sampling::Halton;
use extricate::internals::io::model_file;
use extricate::internals::scene::Motion;
use extricate::internals::scene::assemble::bodies::radius;
use extricate::{
    CheckScratch, Checker, Effort, Label, LearnOptions, Manifold, Model, QueryOptions, Scene, Solver, Termination,
};

use crate::container::Container;
use crate::scenes;

/// Configurations that a model is queried about.
const MODEL_QUERIES: u64 = 3;
/// Budget of a query: a model may claim to need any number of checks.
const MAX_CHECKS: usize = 400;

/// Length \[m\] beyond which a scene is vast.
const VAST_LENGTH_M: f64 = 1e5;

/// Reads a model file and queries the model; panics if an answer is wrong.
pub fn run(bytes: &[u8]) {
    let sealed = Container::open(bytes).map(|file| file.sealed());
    if let Ok(model) = model_file::decode(Path::new("m"), sealed.as_deref().unwrap_or(bytes)) {
        query(model);
    }
}

/// Queries a model and checks the promises of its answers.
///
/// # Panics
/// If a promise does not hold.
pub fn query(model: impl Into<Arc<Model>>) {
    let solver = Solver::of_model(model);
    let (scene, space) = (solver.scene(), solver.scene().space());
    // The promises are about the scene, so another checker of it has to agree.
    let checker = Checker::new(Arc::clone(scene));
    let mut check = CheckScratch::default();
    let halton = Halton::new(space.nv(), 5);
    let (mut q, is_vast) = (vec![0.0; space.nq()], is_vast(scene));
    for index in 0..MODEL_QUERIES {
        halton.config(space, index, &mut q);
        let Ok(q) = space.config(&q) else { panic!("a configuration that was drawn is none: {q:?}") };
        for effort in [Effort::Nearest, Effort::Refined] {
            let options = QueryOptions::default().effort(effort).termination(Termination::after_checks(MAX_CHECKS));
            let asked = solver.clone().options(options.segment(!is_vast)).expect("sound options");
            let Some(answer) = asked.query(&q) else { continue };
            assert!(answer.lower_bound <= answer.depth, "bound {} above {}", answer.lower_bound, answer.depth);
            if answer.verified {
                let witness = space.config(&answer.witness).expect("a verified witness is a configuration");
                assert_eq!(space.outside(&answer.witness).count(), 0, "a verified witness keeps its limits");
                let is_free = checker.label(&witness, &mut check) == Label::Free;
                assert!(is_free || is_vast, "a verified witness is free: {:?}", answer.witness);
            }
        }
    }
}

/// Returns whether something of the scene is so large or so far away that the rounding of a
/// distance is coarse beside a clearance. Two checkers that remember other checks may then
/// disagree.
fn is_vast(scene: &Scene) -> bool {
    let places = scene.frames().iter().map(|frame| &frame.pose_parent_joint);
    let places = places.chain(scene.bodies().iter().flat_map(|body| &body.parts).map(|part| &part.pose_frame_part));
    let sizes = scene.bodies().iter().flat_map(|body| &body.parts).map(|part| radius(&part.geometry));
    let coordinates = scene.frames().iter().map(|frame| match &frame.motion {
        Motion::Revolute { coordinate, .. } | Motion::Prismatic { coordinate, .. } => {
            coordinate.multiplier.abs().max(coordinate.offset.abs())
        }
        Motion::World | Motion::Ball { .. } => 0.0,
    });
    let limits = scene.space().factors().iter().map(|factor| match factor.manifold {
        Manifold::Interval { lower, upper } => lower.abs().max(upper.abs()),
        Manifold::Circle | Manifold::Rotation => 0.0,
    });
    let mut lengths = places.map(|pose| pose.translation.amax()).chain(sizes).chain(coordinates).chain(limits);
    lengths.any(|length| length > VAST_LENGTH_M)
}

/// Returns models of small scenes.
pub fn corpus() -> Vec<(String, Vec<u8>)> {
    let learned = |name: &str, labels| {
        let mut options = LearnOptions::default().labels(labels).seed(3).threads(1);
        options.seconds = None;
        let model = Model::learn(scenes::scene(name), &options).expect("something is free");
        (format!("{name}-{labels}"), model_file::encode(&model))
    };
    // With 12,000 labels some samples are solved.
    vec![learned("few", 300), learned("few", 12_000), learned("many", 300), learned("free-box", 300)]
}
