//! Labels of configurations: of one, of many on one thread, of many on all threads.

use rayon::prelude::*;

use super::{CheckScratch, Checker};
use crate::cspace::Label;
use crate::kinematics::LANES;
use crate::math::Vec3;

/// When pairs collided, to try first those that did last. No answer depends on it.
#[derive(Debug, Default)]
pub struct History {
    /// Those that did last, latest first: tried before the broad phase.
    recent: [u32; RECENT],
    /// The time of each, 0 for never.
    collided: Vec<u64>,
    now: u64,
}

/// How many pairs are tried before the broad phase.
const RECENT: usize = 4;
const NO_PAIR: u32 = u32::MAX;

impl History {
    /// Of pairs that never collided.
    pub fn new(pairs: usize) -> Self {
        Self { recent: [NO_PAIR; RECENT], collided: vec![0; pairs], now: 0 }
    }

    fn note(&mut self, pair: u32) {
        self.now += 1;
        self.collided[pair as usize] = self.now;
        let last = self.recent.iter().position(|other| *other == pair).unwrap_or(RECENT - 1);
        self.recent[last] = pair;
        self.recent[..=last].rotate_right(1);
    }
}

/// Configurations that a thread labels before it looks for more: enough to make handing out work cheap, few enough that no
/// thread ends long after the others.
const CHUNK: usize = 64;

impl Checker {
    /// Whether every checked pair keeps the clearance at `q` (length `nq`, within limits).
    ///
    /// Closed components of meshes are solid, open ones are surfaces. With a clearance of 0, surfaces that cross collide and
    /// surfaces that only touch do not.
    pub fn label(&self, q: &[f64], scratch: &mut CheckScratch) -> Label {
        self.place(q, scratch);
        if self.recent_collides(scratch) {
            return Label::Colliding;
        }
        self.find_near(self.most_clearance, scratch);
        self.label_found(scratch)
    }

    /// Labels `n` configurations (row major, `n x nq`, each within limits) on all threads of the current rayon pool.
    ///
    /// `labels[i]` is what [`Checker::label`] says of configuration `i`, whatever the number of threads.
    ///
    /// # Panics
    /// Where `configs` is not `labels.len() * nq` long.
    ///
    /// ```
    /// use extricate::{Checker, Label, scene::builtin};
    /// let scene = builtin::scene("planar-arm").unwrap();
    /// let checker = Checker::new(scene.into());
    /// let mut labels = [Label::Free; 2];
    /// checker.label_batch(&[0.0, 0.0, 0.0, 0.3, -0.2, 0.1], &mut labels);
    /// ```
    pub fn label_batch(&self, configs: &[f64], labels: &mut [Label]) {
        self.assert_rows(configs, labels);
        let width = CHUNK * self.scene.space.nq();
        configs
            .par_chunks(width)
            .zip(labels.par_chunks_mut(CHUNK))
            .for_each_init(CheckScratch::default, |scratch, (configs, labels)| {
                self.label_rows(configs, labels, scratch)
            });
    }

    /// As [`Checker::label_batch`] on the calling thread, without allocating once `scratch` has served this checker.
    ///
    /// # Panics
    /// Where `configs` is not `labels.len() * nq` long.
    pub fn label_batch_serial(&self, configs: &[f64], labels: &mut [Label], scratch: &mut CheckScratch) {
        self.assert_rows(configs, labels);
        self.label_rows(configs, labels, scratch);
    }

    /// Blocks of configurations are placed together; a configuration that the broad phase finds nothing for needs no more.
    fn label_rows(&self, configs: &[f64], labels: &mut [Label], scratch: &mut CheckScratch) {
        let (scene, nq) = (&*self.scene, self.scene.space.nq());
        self.adopt(scratch);
        for (configs, labels) in configs.chunks(LANES * nq).zip(labels.chunks_mut(LANES)) {
            let ball = |body: usize| (self.bodies.bodies[body].frame, &self.bodies.bodies[body].ball.0);
            scratch.block.place(scene, configs);
            scratch.block.points(self.broad.movers().map(ball), &mut scratch.centers);
            for (lane, label) in labels.iter_mut().enumerate() {
                for (body, center) in self.broad.movers().zip(&scratch.centers) {
                    scratch.placement.centers[body] = Vec3::from(center.map(|x| x[lane]));
                }
                let recent = scratch.history.recent;
                let again = recent.iter().any(|&pair| pair != NO_PAIR && self.balls_near(pair as usize, scratch));
                if again {
                    self.bodies.place_lane(&scratch.block, lane, &mut scratch.placement);
                    if self.recent_collides(scratch) {
                        *label = Label::Colliding;
                        continue;
                    }
                }
                self.find_near(self.most_clearance, scratch);
                if !again && !scratch.broad.pairs.is_empty() {
                    self.bodies.place_lane(&scratch.block, lane, &mut scratch.placement);
                }
                *label = self.label_found(scratch);
            }
        }
    }

    /// Whether one of the pairs that collided last does so again.
    fn recent_collides(&self, scratch: &mut CheckScratch) -> bool {
        for pair in scratch.history.recent {
            if pair != NO_PAIR && self.balls_near(pair as usize, scratch) && self.pair_collides(pair as usize, scratch)
            {
                scratch.history.note(pair);
                return true;
            }
        }
        false
    }

    /// Whether any pair collides that the broad phase found and that was not tried as a recent one. Those that did last
    /// come first.
    fn label_found(&self, scratch: &mut CheckScratch) -> Label {
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
            if self.pair_collides(pair as usize, scratch) {
                scratch.history.note(pair);
                return Label::Colliding;
            }
        }
        Label::Free
    }

    fn balls_near(&self, pair: usize, scratch: &CheckScratch) -> bool {
        let clearance = self.clearance_of(pair);
        let (pair, centers) = (&self.pairs[pair], &scratch.placement.centers);
        let reach = pair.radii + clearance;
        reach >= 0.0 && (centers[pair.first] - centers[pair.second]).norm_squared() <= reach * reach
    }

    fn assert_rows(&self, configs: &[f64], labels: &[Label]) {
        let (rows, nq) = (labels.len(), self.scene.space.nq());
        assert_eq!(configs.len(), rows * nq, "{rows} labels of configurations of {nq} coordinates");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::sampling::Halton;
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
}
