//! Labels of one configuration, and of batches on one thread or on all. [`Checker`] documents the
//! public functions at its methods of the same names.

use rayon::prelude::*;

use super::recent_pairs::NO_PAIR;
use crate::collision::checker::{CheckScratch, Checker};
use crate::cspace::Label;
use crate::kinematics::LANES;
use crate::math::Vec3;

/// Configurations that a thread labels before it requests more: enough to make handing out work
/// cheap, few enough that no thread ends long after the others.
const CHUNK_CONFIGS: usize = 64;

pub fn label(checker: &Checker, q: &[f64], scratch: &mut CheckScratch) -> Label {
    checker.place(q, scratch);
    if recent_collides(checker, scratch) {
        return Label::Colliding;
    }
    checker.find_near(checker.most_clearance, scratch);
    label_found(checker, scratch)
}

pub fn label_batch(checker: &Checker, configs: &[f64], labels: &mut [Label]) {
    assert_rows(checker, configs, labels);
    let width = CHUNK_CONFIGS * checker.scene.space.nq();
    configs
        .par_chunks(width)
        .zip(labels.par_chunks_mut(CHUNK_CONFIGS))
        .for_each_init(CheckScratch::default, |scratch, (configs, labels)| {
            label_rows(checker, configs, labels, scratch)
        });
}

pub fn label_batch_serial(checker: &Checker, configs: &[f64], labels: &mut [Label], scratch: &mut CheckScratch) {
    assert_rows(checker, configs, labels);
    label_rows(checker, configs, labels, scratch);
}

/// Labels configurations block by block. Bodies are fully placed only at those configurations for
/// which pairs are left to check.
fn label_rows(checker: &Checker, configs: &[f64], labels: &mut [Label], scratch: &mut CheckScratch) {
    let (scene, nq) = (&*checker.scene, checker.scene.space.nq());
    checker.adopt(scratch);
    for (configs, labels) in configs.chunks(LANES * nq).zip(labels.chunks_mut(LANES)) {
        let ball = |body: usize| (checker.bodies.bodies[body].frame, &checker.bodies.bodies[body].ball.0);
        scratch.block.place(scene, configs);
        scratch.block.points(checker.broad.movers().map(ball), &mut scratch.centers);
        for (lane, label) in labels.iter_mut().enumerate() {
            for (body, center) in checker.broad.movers().zip(&scratch.centers) {
                scratch.placement.centers[body] = Vec3::from(center.map(|x| x[lane]));
            }
            scratch.nowhere = false;
            let recent = scratch.history.recent;
            let again = recent.iter().any(|&pair| pair != NO_PAIR && balls_near(checker, pair as usize, scratch));
            if again {
                checker.bodies.place_lane(&scratch.block, lane, &mut scratch.placement);
                if recent_collides(checker, scratch) {
                    *label = Label::Colliding;
                    continue;
                }
            }
            checker.find_near(checker.most_clearance, scratch);
            if !again && !scratch.broad.pairs.is_empty() {
                checker.bodies.place_lane(&scratch.block, lane, &mut scratch.placement);
            }
            *label = label_found(checker, scratch);
        }
    }
}

/// Returns whether one of the pairs that collided last does so again.
fn recent_collides(checker: &Checker, scratch: &mut CheckScratch) -> bool {
    for pair in scratch.history.recent {
        if pair != NO_PAIR
            && checker.is_checked(pair)
            && balls_near(checker, pair as usize, scratch)
            && checker.pair_collides(pair as usize, scratch)
        {
            scratch.history.note(pair);
            return true;
        }
    }
    false
}

/// Checks the pairs that the broad phase found, without the recent ones, which were tried before.
/// Pairs that collided last come first.
fn label_found(checker: &Checker, scratch: &mut CheckScratch) -> Label {
    let recent = scratch.history.recent;
    scratch.broad.pairs.retain(|pair| !recent.contains(pair));
    let mut may_have_collided = true;
    for at in 0..scratch.broad.pairs.len() {
        if may_have_collided {
            let (pairs, collided) = (&mut scratch.broad.pairs, &scratch.history.collided);
            let latest = (at..pairs.len()).max_by_key(|&k| collided[pairs[k] as usize]).expect("not empty");
            pairs.swap(at, latest);
            may_have_collided = collided[pairs[at] as usize] > 0;
        }
        let pair = scratch.broad.pairs[at];
        if checker.pair_collides(pair as usize, scratch) {
            scratch.history.note(pair);
            return Label::Colliding;
        }
    }
    Label::Free
}

fn balls_near(checker: &Checker, pair: usize, scratch: &CheckScratch) -> bool {
    let clearance = checker.clearance_of(pair);
    let (pair, centers) = (&checker.pairs[pair], &scratch.placement.centers);
    let reach = pair.radii + clearance;
    reach >= 0.0 && (centers[pair.first] - centers[pair.second]).norm_squared() <= reach * reach
}

fn assert_rows(checker: &Checker, configs: &[f64], labels: &[Label]) {
    let (rows, nq) = (labels.len(), checker.scene.space.nq());
    assert_eq!(configs.len(), rows * nq, "{rows} labels of configurations of {nq} coordinates");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::sampling::Halton;
    use crate::scene::Motion;
    use crate::scene::builtin;

    #[test]
    fn batches_say_what_single_labels_say_whatever_the_threads() {
        for name in builtin::NAMES {
            let checker = Checker::new(builtin::scene(name).unwrap().into());
            let space = &checker.scene().space;
            let halton = Halton::new(space.nv(), 8);
            let count = 1003;
            let mut configs = vec![0.0; count * space.nq()];
            for (k, q) in configs.chunks_exact_mut(space.nq()).enumerate() {
                halton.config(space, k as u64, q);
            }
            let fresh = |q: &[f64]| checker.label(q, &mut CheckScratch::default());
            let single: Vec<Label> = configs.chunks_exact(space.nq()).map(fresh).collect();
            let mut labels = vec![Label::Free; count];
            checker.label_batch_serial(&configs, &mut labels, &mut CheckScratch::default());
            assert_eq!(labels, single, "{name}");
            for threads in [1, 2, 5] {
                labels.fill(Label::Colliding);
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| checker.label_batch(&configs, &mut labels));
                assert_eq!(labels, single, "{name}, {threads} threads");
            }
            let colliding = single.iter().filter(|label| **label == Label::Colliding).count();
            assert!((count / 10..count).contains(&colliding), "{name}: {colliding}");
        }
    }

    #[test]
    #[should_panic(expected = "2 labels of configurations of 3 coordinates")]
    fn a_batch_of_the_wrong_length_is_refused() {
        let checker = Checker::new(builtin::scene("planar-arm").unwrap().into());
        checker.label_batch(&[0.0; 7], &mut [Label::Free; 2]);
    }

    /// A scene built in code may give a body a pose that is not finite.
    #[test]
    fn what_is_nowhere_is_not_free() {
        let mut scene = builtin::scene("planar-arm").unwrap();
        let Motion::Revolute { coordinate, .. } = &mut scene.frames[3].motion else { panic!("it turns") };
        coordinate.multiplier = f64::INFINITY;
        let checker = Checker::new(scene.into());
        // The first two links are free there.
        let configs = [1.9, 0.0, 0.0, 1.9, 0.0, -1.0, 1.9, 0.0, 2.0];
        let mut labels = [Label::Free; 3];
        checker.label_batch(&configs, &mut labels);
        assert_eq!(labels, [Label::Colliding; 3]);
        let mut pairs = Vec::new();
        checker.colliding_pairs(&configs[..3], &mut CheckScratch::default(), &mut pairs);
        assert!(!pairs.is_empty() && checker.colliding_pair(&configs[..3], &mut CheckScratch::default()).is_some());
        let single = configs.chunks(3).map(|q| checker.label(q, &mut CheckScratch::default()));
        assert!(single.into_iter().all(|label| label == Label::Colliding));
        // The scratch carries nothing of it to another checker.
        let (sound, mut scratch) =
            (Checker::new(builtin::scene("planar-arm").unwrap().into()), CheckScratch::default());
        assert_eq!(checker.label(&configs[..3], &mut scratch), Label::Colliding);
        assert_eq!(sound.label(&configs[..3], &mut scratch), Label::Free);
    }
}
