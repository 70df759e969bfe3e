//! Accuracy of the classifier of a learned model on configurations that learning never saw.

use crate::baselines::{HAND_ACCURACY_SHARE, SHELF_ARM_ACCURACY_SHARE, STATED_ACCURACY_DIFFERENCE_SHARE};
use crate::memory::learned;
use extricate::internals::cspace::sampling::Halton;
use extricate::internals::metric::MetricScratch;
use extricate::internals::metric::relative::RelativePoses;
use extricate::{Label, Solver, builtin};

/// Returns the shares of free and of colliding configurations, among `count` uniform ones, that are
/// predicted right.
fn accuracy(solver: &Solver, count: usize) -> [f64; 2] {
    let (scene, poses) = (solver.scene(), RelativePoses::new(solver.scene().clone()));
    let nq = scene.space().nq();
    // This seed is none of those of learning.
    let halton = Halton::new(scene.space().nv(), 4321);
    let mut configs = vec![0.0; count * nq];
    configs.chunks_exact_mut(nq).enumerate().for_each(|(i, q)| halton.config(scene.space(), i as u64, q));
    let mut labels = vec![Label::Free; count];
    solver.checker().label_batch(&configs, &mut labels);
    let features = |configs: &[f64], pairs: &[u32]| {
        let (mut out, mut scratch) = (Vec::new(), MetricScratch::default());
        configs.chunks_exact(nq).for_each(|q| poses.embed(q, pairs, &mut scratch, &mut out));
        out
    };
    let classifier = solver.model().unwrap().classifier().unwrap();
    classifier.accuracy(nq, &features, &configs, &labels).map(Option::unwrap)
}

#[test]
fn few_labels_make_a_classifier_that_is_right() {
    for (name, least) in [("shelf-arm", SHELF_ARM_ACCURACY_SHARE), ("hand", HAND_ACCURACY_SHARE)] {
        let solver = learned(builtin::scene(name).unwrap(), 20_000, 1);
        let [free, colliding] = accuracy(&solver, 10_000);
        let balanced = 0.5 * (free + colliding);
        println!("{name}: balanced accuracy {balanced:.4} (free {free:.4}, colliding {colliding:.4})");
        assert!(balanced > least, "{name}: {balanced}");
        // The model's own figures are about as high: its held-out configurations were not used for
        // training either.
        let statistics = solver.model().unwrap().statistics();
        let told = 0.5 * (statistics.accuracy_free.unwrap() + statistics.accuracy_colliding.unwrap());
        assert!((told - balanced).abs() < STATED_ACCURACY_DIFFERENCE_SHARE, "{name}: {told} {balanced}");
    }
}
