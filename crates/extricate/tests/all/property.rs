//! Promises of every answer, on every built-in scene and under every metric: a free witness at the
//! stated distance, a bound below it, the same bytes for the same seed.

use extricate::internals::cspace::sampling::Halton;
use extricate::{CheckScratch, Checker, Effort, Label, MetricKind, QueryOptions, builtin};

use crate::baselines::{BOUNDARY_BESIDE_SAMPLES, PROPERTY_COLLIDING_CONFIGS};
use crate::memory::learned;
use crate::query::ask;

#[test]
fn every_witness_is_free_and_every_bound_holds() {
    for name in builtin::NAMES {
        for metric in [MetricKind::Joint, MetricKind::ObjectNorm, MetricKind::MaxDisplacement] {
            let scene = builtin::scene(name).unwrap().with_metric(metric);
            let checker = Checker::new(std::sync::Arc::new(scene.clone()));
            let model = learned(scene, 6_000, 7);
            let space = model.scene().space();
            let halton = Halton::new(space.nv(), 11);
            let mut check = CheckScratch::default();
            let mut q = vec![0.0; space.nq()];
            let mut colliding = 0;
            for i in 0..200 {
                halton.config(space, i, &mut q);
                if colliding == 12 {
                    break;
                }
                let free = checker.label(&q, &mut check) == Label::Free;
                colliding += usize::from(!free);
                let config = space.config(&q).unwrap();
                let refined = ask(&model, &config, &QueryOptions::default().effort(Effort::Refined));
                assert_eq!(free, refined.depth == 0.0, "{name}: {q:?}");
                assert_eq!(free, refined.colliding.is_empty());
                let witness = space.config(&refined.witness).expect("a witness keeps the limits");
                assert!(refined.verified && checker.label(&witness, &mut check) == Label::Free, "{name}: {q:?}");
                let distance = model.metric().distance(&q, &refined.witness);
                assert!(
                    (distance - refined.depth).abs() <= 1e-9 + 1e-6 * distance,
                    "{name}: {distance} {}",
                    refined.depth
                );
                assert!(refined.lower_bound >= 0.0 && refined.lower_bound <= refined.depth);
                let nearest = ask(&model, &config, &QueryOptions::default().effort(Effort::Nearest));
                assert!(nearest.depth >= refined.depth, "{name}: refinement made it worse");
                assert!(checker.label(&nearest.witness, &mut check) == Label::Free, "{name}: a stored sample collides");
                assert!(nearest.depth >= refined.lower_bound && refined.depth >= nearest.lower_bound, "{name}: {q:?}");
            }
            assert!(colliding > PROPERTY_COLLIDING_CONFIGS, "{name}: only {colliding} of 200 collide");
        }
    }
}

#[test]
fn boundary_samples_are_free_and_beside_a_collision() {
    let model = learned(builtin::scene("planar-arm").unwrap(), 20_000, 5);
    let (space, learned) = (model.scene().space(), model.model().unwrap());
    let gap = learned.statistics().boundary_gap.expect("a boundary");
    let mut check = CheckScratch::default();
    let mut beside = 0;
    let mut near = vec![0.0; space.nq()];
    let halton = Halton::new(space.nv(), 1);
    let (mut low, mut high) = (vec![0.0; space.nq()], vec![0.0; space.nq()]);
    for (i, q) in learned.boundary().configs().chunks_exact(space.nq()).enumerate() {
        assert_eq!(model.checker().label(q, &mut check), Label::Free);
        // The colliding partner is not stored, so some short step must find one.
        let found = (0..200).any(|k| {
            halton.config(space, 2 * k + 400 * i as u64, &mut low);
            halton.config(space, 2 * k + 1 + 400 * i as u64, &mut high);
            let length = space.distance(&low, &high).max(1e-9);
            let mut step = vec![0.0; space.nv()];
            space.difference(&low, &high, &mut step);
            step.iter_mut().for_each(|s| *s *= gap / length);
            space.integrate(q, &step, &mut near);
            model.checker().label(&near, &mut check) == Label::Colliding
        });
        beside += usize::from(found);
        if i == 300 {
            break;
        }
    }
    assert!(beside > BOUNDARY_BESIDE_SAMPLES, "{beside} of 300 samples have a collision within the gap");
}
