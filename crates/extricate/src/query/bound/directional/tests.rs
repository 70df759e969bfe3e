//! Bounds by directions against sampled configurations in which the bodies have parted.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::collision::CheckScratch;
use crate::cspace::sampling::uniform;
use crate::kinematics::forward;
use crate::query::bound::directional::*;
use crate::query::prepared::Prepared;
use crate::scene::{MetricKind, builtin};

/// No configuration in which a pair has parted is nearer than the bound of that pair, under any
/// metric.
#[test]
fn nothing_parts_nearer_than_the_bound() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let (mut parted, mut tightest) = (0, f64::INFINITY);
    for name in builtin::NAMES {
        for kind in [MetricKind::Joint, MetricKind::ObjectNorm, MetricKind::MaxDisplacement] {
            let mut scene = builtin::scene(name).unwrap();
            scene.metric = kind;
            let world = Prepared::new(Arc::new(scene));
            let (context, scene) = (world.context(), world.scene().clone());
            let space = &scene.space;
            let [mut q, mut to] = [(); 2].map(|()| vec![0.0; space.nq()]);
            let (mut check, mut scratch) = (CheckScratch::default(), DirectionalScratch::default());
            let (mut pairs, mut poses) = (Vec::new(), Vec::new());
            for _ in 0..40 {
                uniform(space, &mut rng, &mut q);
                pairs.clear();
                context.checker.colliding_pairs(&q, &mut check, &mut pairs);
                forward(&scene, &q, &mut poses);
                let mut bounds = Vec::new();
                context.checker.inner_pairs(&q, &pairs, &mut check, &mut |pair| {
                    bounds.push((pair.pair(), directional(&context, &poses, pair, 3.0, 60, &mut scratch)));
                });
                for k in 0..200 {
                    let scale = [1.0, 0.5, 0.2, 0.1][k % 4];
                    let step = (0..space.nv()).map(|_| scale * (2.0 * rng.random::<f64>() - 1.0));
                    space.integrate(&q, &step.collect::<Vec<_>>(), &mut to);
                    let distance = context.metric.distance(&q, &to);
                    let mut still = Vec::new();
                    context.checker.colliding_pairs(&to, &mut check, &mut still);
                    for (pair, bound) in bounds.iter().filter(|(pair, _)| !still.contains(pair)) {
                        assert!(
                            *bound <= distance,
                            "{name} {kind:?} {q:?} pair {pair:?}: {bound}, parted at {distance}"
                        );
                        parted += 1;
                        tightest = tightest.min(distance / bound);
                    }
                }
            }
        }
    }
    println!("{parted} parted, the nearest at {tightest:.3} of a bound");
    assert!(parted > 10_000 && tightest < 1.2, "{parted} {tightest}");
}
