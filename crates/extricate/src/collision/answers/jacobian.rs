//! Gradients of near distances, for controllers and programs with constraints on distances.

use crate::collision::{CheckScratch, Checker, Contact};
use crate::kinematics::Twists;

/// The distance of a checked pair, and how it changes.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct DistanceRow {
    /// The nearest contact of the pair, with its signed distance \[m\].
    pub contact: Contact,
    /// Derivative of the distance over the tangent coordinates \[m per rad or m\], of length `nv`.
    pub gradient: Vec<f64>,
}

pub fn distance_rows(checker: &Checker, q: &[f64], within: f64, scratch: &mut CheckScratch) -> Vec<DistanceRow> {
    let (scene, mut contacts, mut twists) = (checker.scene(), Vec::new(), Twists::default());
    checker.contacts_within(q, within, scratch, &mut contacts);
    contacts.sort_by(|a, b| a.pair.cmp(&b.pair).then(a.distance.total_cmp(&b.distance)));
    contacts.dedup_by_key(|contact| contact.pair);
    twists.set(scene, scratch.poses());
    let row = |contact: Contact| {
        let mut gradient = vec![0.0; scene.space.nv()];
        contact.add_gradient(scene, &twists, &mut gradient);
        DistanceRow { contact, gradient }
    };
    contacts.into_iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::cspace::sampling::uniform;
    use crate::scene::builtin;

    /// Central differences agree with the rows, but for the few pairs whose nearest points jump.
    #[test]
    fn rows_are_derivatives_of_distances() {
        let (mut agree, mut all) = (0, 0);
        for name in ["planar-arm", "shelf-arm", "dual-arm", "hand", "free-box"] {
            let checker = Checker::new(builtin::scene(name).unwrap().into());
            let (space, mut scratch) = (&checker.scene().space, CheckScratch::default());
            let mut rng = ChaCha8Rng::seed_from_u64(3);
            let (mut q, mut step, mut moved) = (vec![0.0; space.nq()], vec![0.0; space.nv()], vec![0.0; space.nq()]);
            for _ in 0..4 {
                uniform(space, &mut rng, &mut q);
                let rows = checker.distance_rows(&q, 0.1, &mut scratch);
                for v in 0..space.nv() {
                    let mut side = |sign: f64| {
                        step[v] = sign * 1e-6;
                        space.integrate(&q, &step, &mut moved);
                        step[v] = 0.0;
                        checker.signed_distances(&moved, &mut scratch)
                    };
                    let (after, before) = (side(1.0), side(-1.0));
                    for row in rows.iter().filter(|row| row.contact.distance > 1e-3) {
                        let pair = row.contact.pair.index();
                        let middle = 0.5 * (after[pair] + before[pair]);
                        assert!((row.contact.distance - middle).abs() < 1e-6, "{name}: {row:?}, {middle}");
                        all += 1;
                        agree += usize::from(((after[pair] - before[pair]) / 2e-6 - row.gradient[v]).abs() < 1e-6);
                    }
                }
            }
        }
        assert!(all > 200 && agree * 100 >= all * 97, "{agree} of {all}");
    }
}
