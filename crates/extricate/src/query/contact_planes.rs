//! Indexes samples for queries and stores the contact planes of the solved ones, so that the first
//! step from such a sample evaluates no contacts.

use rayon::prelude::*;

use super::plan::MARGIN;
use crate::collision::{CheckScratch, Checker, Contact, ContactQuery, ContactSearch};
use crate::kinematics::Twists;
use crate::metric::Metric;
use crate::samples::SampleSet;
use crate::samples::contact_planes::ContactPlanes;

/// Most planes of a solved sample, the nearest ones. With 24, models of hands are twice as large,
/// and queries take as many checks.
const MAX_PLANES: usize = 8;
/// Solved samples in one task of a thread.
const SAMPLES_PER_TASK: usize = 64;

/// Indexes `configs` (row major, each called free by `checker`), whose last `exits` rows are solved
/// samples, and stores the contact planes of those. Meshes are represented by their convex pieces,
/// as in descents.
///
/// # Panics
/// Panics if there are fewer rows than `exits`.
pub fn index_samples(checker: &Checker, metric: &Metric, configs: Vec<f64>, exits: usize, seed: u64) -> SampleSet {
    checker.prepare_proposals();
    let mut samples = SampleSet::with_solved(metric, checker.scene().space.nq(), configs, exits, seed);
    store_contact_planes(checker, &mut samples);
    samples
}

fn store_contact_planes(checker: &Checker, samples: &mut SampleSet) {
    let space = &checker.scene().space;
    let first = samples.len() - samples.solved();
    let exits = &samples.configs()[first * space.nq()..];
    let parts: Vec<ContactPlanes> = exits
        .par_chunks(SAMPLES_PER_TASK * space.nq())
        .map_init(Scratch::default, |scratch, rows| {
            let mut planes = ContactPlanes::new(space.nv());
            for q in rows.chunks_exact(space.nq()) {
                add(checker, q, scratch, &mut planes);
            }
            planes
        })
        .collect();
    let mut all = ContactPlanes::new(space.nv());
    parts.iter().for_each(|part| all.append(part));
    samples.set_contact_planes(all);
}

#[derive(Default)]
struct Scratch {
    check: CheckScratch,
    contacts: Vec<Contact>,
    twists: Twists,
}

fn add(checker: &Checker, q: &[f64], scratch: &mut Scratch, planes: &mut ContactPlanes) {
    let scene = checker.scene();
    let Scratch { check, contacts, twists } = scratch;
    contacts.clear();
    // Evaluate each sample alone: the planes must not depend on how samples are divided among
    // threads.
    check.forget_contacts();
    // Note the contacts that a descent would use. With fewer, the projection comes too near the
    // query; contacts twice as far away rotate before they are reached. Contacts of triangles are
    // too many.
    let search = if checker.all_convex() { ContactSearch::Exact } else { ContactSearch::Proposal };
    let query = ContactQuery { margin: checker.base_clearance() + MARGIN, search };
    checker.contacts(q, query, check, contacts);
    twists.set(scene, check.poses());
    contacts.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    let mut row = vec![0.0; scene.space.nv()];
    for contact in contacts.iter().take(MAX_PLANES) {
        row.fill(0.0);
        contact.add_gradient(scene, twists, &mut row);
        planes.push(contact.pair.index(), contact.distance - checker.base_clearance(), &row);
    }
    planes.end_sample();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::Label;
    use crate::cspace::sampling::Halton;
    use crate::scene::builtin;

    /// Any free configurations serve as solved samples here.
    fn noted(name: &str, threads: usize) -> (Checker, SampleSet) {
        let scene = std::sync::Arc::new(builtin::scene(name).unwrap());
        let (checker, metric) = (Checker::new(scene.clone()), Metric::new(scene.clone()));
        let (space, mut configs) = (&scene.space, Vec::new());
        let (halton, mut q, mut scratch) = (Halton::new(space.nv(), 3), vec![0.0; space.nq()], CheckScratch::default());
        for k in 0..4000 {
            halton.config(space, k, &mut q);
            if checker.label(&q, &mut scratch) == Label::Free {
                configs.extend_from_slice(&q);
            }
        }
        let rows = configs.len() / space.nq();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let samples = pool.install(|| index_samples(&checker, &metric, configs, rows - 10, 0));
        (checker, samples)
    }

    #[test]
    fn planes_tell_how_distances_change() {
        for name in ["planar-arm", "hand"] {
            let (checker, samples) = noted(name, 2);
            let space = &checker.scene().space;
            let (mut scratch, mut near, mut compared) = (CheckScratch::default(), Vec::new(), 0);
            assert!(samples.planes(9).is_none(), "no exit");
            for id in 10..samples.len() as u32 {
                let q = samples.config(id);
                let step: Vec<f64> = (0..space.nv()).map(|k| 1e-5 * (f64::from(id) + k as f64).sin()).collect();
                let mut moved = q.to_vec();
                space.integrate(q, &step, &mut moved);
                // The planes of all pairs predict the least distance after the step.
                let change =
                    |gradient: &mut dyn Iterator<Item = f64>| gradient.zip(&step).map(|(g, s)| g * s).sum::<f64>();
                let planes = samples.planes(id).unwrap();
                let Some(least) = planes.iter().map(|(room, mut g)| room + change(&mut g)).reduce(f64::min) else {
                    continue;
                };
                near.clear();
                let query = ContactQuery { margin: 0.1, search: ContactSearch::Exact };
                checker.contacts(&moved, query, &mut scratch, &mut near);
                let distance = near.iter().map(|contact| contact.distance).fold(f64::INFINITY, f64::min);
                let expected = checker.scene().clearance + least;
                assert!((distance - expected).abs() < 1e-8, "{name} {id}: {distance} {expected}");
                compared += 1;
            }
            assert!(compared > 30, "{name}: {compared}");
        }
    }

    #[test]
    fn planes_do_not_depend_on_the_number_of_threads() {
        let [(_, one), (_, three)] = [1, 3].map(|threads| noted("hand", threads));
        let planes = |samples: &SampleSet, id| -> Vec<(f64, Vec<f64>)> {
            samples.planes(id).unwrap().iter().map(|(room, gradient)| (room, gradient.collect())).collect()
        };
        for id in 10..one.len() as u32 {
            assert_eq!(planes(&one, id), planes(&three, id));
        }
    }
}
