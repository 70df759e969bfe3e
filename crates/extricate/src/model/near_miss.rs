//! Near misses: free configurations a few steps away from a contact that was not seen yet.
//!
//! Random configurations miss small colliding components; descents along a distance find them.

use std::collections::HashMap;

use rayon::prelude::*;

use crate::collision::{CheckScratch, Checker, Contact, ContactQuery, ContactSearch};
use crate::cspace::Label;
use crate::kinematics::Twists;
use crate::learning::exploration::Exploration;
use crate::learning::{Budget, LabelBatch};
use crate::math::Vec3;
use crate::metric::Metric;
use crate::scene::PairId;

/// Share of the budget for evaluating random configurations, and again for descending from them.
const EVALUATION_SHARE: f64 = 0.05;
/// Most random configurations evaluated: by then, common contacts are known.
const MAX_EVALUATIONS: usize = 500;
/// A near miss is at most this share of the space's diameter from contact, to first order.
const REACH_SHARE: f64 = 0.1;
/// Contacts of a pair count as one if their points on both bodies are nearer than this share of the
/// motion that [`REACH_SHARE`] allows.
const PATCH_SHARE: f64 = 0.25;
/// Share of that motion within which contacts of meshes are searched: the cost grows with what is
/// near, and far misses come last.
const MESH_MARGIN_SHARE: f64 = 0.2;
/// Most descents toward one contact.
const MAX_DESCENTS_PER_CONTACT: usize = 3;
/// Most steps of one descent; if contact is possible, most descents need two to four.
const MAX_STEPS: usize = 6;
/// Factor that lengthens steps, so that they end in collision.
const OVERSHOOT_FACTOR: f64 = 1.05;
/// Configurations evaluated, or descents made, between two checks of the budget.
const CONFIGS_PER_BATCH: usize = 32;

/// A point on each of two bodies where they touch or nearly touch.
#[derive(Debug, Clone, Copy)]
struct Patch {
    pair: PairId,
    /// Points in the frames of the bodies \[m\].
    places: [Vec3; 2],
}

/// A step from a configuration to a contact.
#[derive(Debug, Clone)]
struct Miss {
    patch: Patch,
    from: Vec<f64>,
    /// Tangent vector along which the linearised distance reaches the clearance.
    step: Vec<f64>,
    /// Length of the step in the joint metric.
    length: f64,
    distance: f64,
}

/// Memory that the evaluations of one thread reuse.
#[derive(Default)]
struct ContactScratch {
    check: CheckScratch,
    contacts: Vec<Contact>,
    twists: Twists,
    gradient: Vec<f64>,
    step: Vec<f64>,
}

/// Patches by pair: scenes of many small obstacles have thousands.
#[derive(Default)]
struct Patches(HashMap<PairId, Vec<Patch>>);

/// A search for near misses in one scene.
pub struct NearMisses<'a> {
    checker: &'a Checker,
    /// Contacts of a pair count as one if their points on both bodies are nearer than this \[m\].
    patch: f64,
    /// Largest distance of a contact that is searched \[m\].
    margin: f64,
    /// Longest step to a contact, in the joint metric.
    reach: f64,
}

impl<'a> NearMisses<'a> {
    pub fn new(checker: &'a Checker, metric: &Metric) -> Self {
        let margin = checker.scene().clearance + REACH_SHARE * metric.diameter() * metric.lever();
        let patch = PATCH_SHARE * margin;
        let margin = if checker.all_convex() { margin } else { MESH_MARGIN_SHARE * margin };
        Self { checker, patch, margin, reach: REACH_SHARE * checker.scene().space.diameter() }
    }

    /// Returns colliding configurations (row major) with contacts that no evaluated configuration
    /// of `known` makes, one for each contact. The lists of `known` have to begin with uniform
    /// configurations. Every evaluation of contacts counts as a label.
    ///
    /// # Guarantee
    /// Each was labelled colliding. The result does not depend on the number of threads.
    pub fn seeds(&self, known: &Exploration, label: &LabelBatch, budget: &mut Budget) -> Vec<f64> {
        self.checker.prepare_proposals();
        let nq = self.checker.scene().space.nq();
        let allowed = (EVALUATION_SHARE * (budget.spent() + budget.left()) as f64) as usize;
        let (until, began) = (budget.fraction() + 2.0 * EVALUATION_SHARE, budget.spent());
        let [free, colliding] = [&known.free, &known.colliding].map(|list| list.len() / nq);
        let looks = allowed.min(MAX_EVALUATIONS).min(free + colliding);
        let at_colliding = (looks * colliding).div_ceil((free + colliding).max(1)).min(looks);
        let mut touched = Patches::default();
        for found in self.contacts_at_all(&known.colliding[..at_colliding * nq], None, until, budget) {
            found.into_iter().filter(|miss| self.touches(miss)).for_each(|miss| touched.push(miss.patch));
        }
        let free = &known.free[..(looks - at_colliding) * nq];
        let mut misses: Vec<Miss> = self.contacts_at_all(free, None, until, budget).into_iter().flatten().collect();
        misses.retain(|miss| !self.touches(miss) && touched.count(&miss.patch, self.patch) == 0);
        misses.sort_by(|a, b| a.length.total_cmp(&b.length));
        let (mut seeds, mut tried, mut at) = (Vec::new(), Patches::default(), 0);
        while at < misses.len() && budget.spent() < began + looks + allowed && budget.fraction() <= until {
            let mut batch: Vec<Miss> = Vec::new();
            while at < misses.len() && batch.len() < CONFIGS_PER_BATCH {
                let miss = &misses[at];
                at += 1;
                if tried.count(&miss.patch, self.patch) < MAX_DESCENTS_PER_CONTACT
                    && touched.count(&miss.patch, self.patch) == 0
                {
                    tried.push(miss.patch);
                    batch.push(miss.clone());
                }
            }
            for (end, patch) in self.descend(batch, label, until, budget) {
                // One descent for each contact is enough.
                if touched.count(&patch, self.patch) == 0 {
                    touched.push(patch);
                    seeds.extend(end);
                }
            }
        }
        seeds
    }

    /// Returns the ends of descents that were labelled colliding, each with the contact reached.
    fn descend(
        &self,
        mut misses: Vec<Miss>,
        label: &LabelBatch,
        until: f64,
        budget: &mut Budget,
    ) -> Vec<(Vec<f64>, Patch)> {
        let nq = self.checker.scene().space.nq();
        let (mut ends, mut patches) = (Vec::new(), Vec::new());
        for _ in 0..MAX_STEPS {
            let trials: Vec<f64> = misses.iter().flat_map(|miss| self.stepped(miss)).collect();
            if misses.is_empty() || misses.len() > budget.left() {
                break;
            }
            let pairs: Vec<PairId> = misses.iter().map(|miss| miss.patch.pair).collect();
            let found = self.contacts_at_all(&trials, Some(&pairs), until, budget);
            let mut going_on = Vec::new();
            for ((miss, trial), near) in misses.into_iter().zip(trials.chunks_exact(nq)).zip(found) {
                match near.into_iter().min_by(|a, b| a.distance.total_cmp(&b.distance)) {
                    Some(now) if self.touches(&now) => {
                        ends.extend_from_slice(trial);
                        patches.push(now.patch);
                    }
                    Some(now) if now.distance < miss.distance => going_on.push(now),
                    _ => {}
                }
            }
            misses = going_on;
        }
        ends.truncate(budget.left().saturating_mul(nq));
        let labels = if ends.is_empty() { Vec::new() } else { budget.label(label, &ends) };
        let labelled = ends.chunks_exact(nq).zip(patches).zip(labels);
        labelled.filter(|(_, label)| *label == Label::Colliding).map(|((q, patch), _)| (q.to_vec(), patch)).collect()
    }

    fn stepped(&self, miss: &Miss) -> Vec<f64> {
        let (mut out, scale) = (miss.from.clone(), OVERSHOOT_FACTOR * (self.reach / miss.length.max(1e-300)).min(1.0));
        let step: Vec<f64> = miss.step.iter().map(|s| s * scale).collect();
        self.checker.scene().space.integrate(&miss.from, &step, &mut out);
        out
    }

    /// Returns the near contacts at each of `configs`: of all pairs, or of one given pair each. It
    /// stops early once the share `until` of the budget is spent.
    fn contacts_at_all(
        &self,
        configs: &[f64],
        pairs: Option<&[PairId]>,
        until: f64,
        budget: &mut Budget,
    ) -> Vec<Vec<Miss>> {
        let nq = self.checker.scene().space.nq();
        let mut all = Vec::new();
        for (batch, configs) in configs.chunks(CONFIGS_PER_BATCH * nq).enumerate() {
            if budget.end().is_some() || budget.fraction() > until {
                break;
            }
            let found =
                configs.par_chunks_exact(nq).enumerate().map_init(ContactScratch::default, |scratch, (k, q)| {
                    self.contacts_at(q, pairs.map(|pairs| pairs[batch * CONFIGS_PER_BATCH + k]), scratch)
                });
            all.par_extend(found);
            budget.spend(configs.len() / nq);
        }
        all
    }

    fn contacts_at(&self, q: &[f64], pair: Option<PairId>, scratch: &mut ContactScratch) -> Vec<Miss> {
        // Proposals suffice and take a fraction of the time, since labels decide.
        let query = ContactQuery { margin: self.margin, search: ContactSearch::Proposal };
        // The result must not depend on what this thread evaluated before.
        scratch.check.forget_contacts();
        scratch.contacts.clear();
        match pair {
            Some(pair) => self.checker.contacts_of(q, pair, query, &mut scratch.check, &mut scratch.contacts),
            None => self.checker.contacts(q, query, &mut scratch.check, &mut scratch.contacts),
        }
        scratch.twists.set(self.checker.scene(), scratch.check.poses());
        let contacts = std::mem::take(&mut scratch.contacts);
        let misses = contacts.iter().filter_map(|contact| self.miss(q, contact, scratch)).collect();
        scratch.contacts = contacts;
        misses
    }

    /// Returns the step to a contact; `None` if it is out of reach, which overlaps never are.
    fn miss(&self, q: &[f64], contact: &Contact, scratch: &mut ContactScratch) -> Option<Miss> {
        let ContactScratch { check, twists, gradient, step, .. } = scratch;
        let (scene, poses) = (self.checker.scene(), check.poses());
        gradient.clear();
        gradient.resize(scene.space.nv(), 0.0);
        contact.add_gradient(scene, twists, gradient);
        // Direction of the shortest step, in the joint metric, that changes the linearised
        // distance.
        step.clone_from(gradient);
        for factor in scene.space.factors() {
            step[factor.tangents()].iter_mut().for_each(|s| *s /= factor.weight);
        }
        let slope = gradient.iter().zip(&*step).map(|(g, s)| g * s).sum::<f64>().sqrt();
        let length = (contact.distance - scene.clearance).max(0.0) / slope;
        let touches = contact.distance < scene.clearance;
        if !touches && (length.is_nan() || length > self.reach) {
            return None;
        }
        let step = step.iter().map(|s| s * (-length / slope)).collect();
        let pair = &scene.pairs[contact.pair.index()];
        let frames = [pair.first, pair.second].map(|body| scene.bodies[body].frame);
        let points = [contact.point_first, contact.point_second];
        let places = [0, 1].map(|side| poses[frames[side]].inverse_point(&points[side]));
        let patch = Patch { pair: contact.pair, places };
        Some(Miss { patch, from: q.to_vec(), step, length, distance: contact.distance })
    }

    fn touches(&self, miss: &Miss) -> bool {
        miss.distance < self.checker.scene().clearance
    }
}

impl Patches {
    fn push(&mut self, patch: Patch) {
        self.0.entry(patch.pair).or_default().push(patch);
    }

    /// Number of patches that are the same contact: nearer than `within` \[m\] on both bodies.
    fn count(&self, patch: &Patch, within: f64) -> usize {
        let is_same = |other: &&Patch| (0..2).all(|side| (patch.places[side] - other.places[side]).norm() < within);
        self.0.get(&patch.pair).map_or(0, |others| others.iter().filter(is_same).count())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::sampling::Halton;
    use crate::learning::LearnOptions;
    use crate::scene::builtin;
    use std::ops::ControlFlow;

    /// Only free configurations are known, as if everything that collides were too small to be hit.
    #[test]
    fn descents_end_in_contacts_and_are_counted_whatever_the_threads() {
        for name in builtin::NAMES {
            let checker = Checker::new(builtin::scene(name).unwrap().into());
            let (metric, space) = (Metric::new(checker.scene_arc().clone()), &checker.scene().space);
            let options = LearnOptions { labels: 4000, seconds: None, ..LearnOptions::default() };
            let label = |configs: &[f64]| {
                let mut labels = vec![Label::Free; configs.len() / space.nq()];
                checker.label_batch(configs, &mut labels);
                labels
            };
            let run = || {
                let mut report = |_: &_| ControlFlow::Continue(());
                let (mut budget, mut known) = (Budget::new(&options, &mut report), Exploration::default());
                known.extend(space, &Halton::new(space.nv(), 4), 800, &label, &mut budget);
                known.colliding.clear();
                (NearMisses::new(&checker, &metric).seeds(&known, &label, &mut budget), budget.spent())
            };
            let on =
                |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run);
            let (seeds, spent) = on(1);
            let count = seeds.len() / space.nq();
            println!("{name}: {count} contacts for {} checks", spent - 800);
            assert!(count > 0, "{name}");
            assert!(label(&seeds).iter().all(|label| *label == Label::Colliding), "{name}");
            // It spends at least a hundred evaluations, and a step and a label for every seed. It
            // spends at most its share, and the last batch.
            assert!(spent >= 900 + 2 * count && spent <= 1200 + 2 * MAX_STEPS * CONFIGS_PER_BATCH, "{name}: {spent}");
            assert_eq!(on(3), (seeds, spent), "{name}");
        }
    }
}
