//! An answer as the page reads it, with the exact checker's verdicts along its exits.

use std::collections::BTreeMap;

use extricate::{
    Anchor, Answer, CheckScratch, Config, ConfigSpace, Contact, Manifold, MetricScratch, PairId, Solver, TOUCHING,
};
use serde::Serialize;

use crate::played::{Played, Waypoint, leg};
use crate::scene_data::BodyData;
use crate::slice::{Slice, slice};

/// Parts of the straight segment to an exit; the checker evaluates both ends and every percent
/// between.
const SEGMENT_STEPS: usize = 100;
/// Largest number of exits of one answer that are shown, nearest first.
const MAX_EXITS: usize = 9;
/// Largest number of contacts of one exit that are drawn.
const MAX_CONTACTS: usize = 64;

/// Amount of data that is added to answers.
#[derive(Debug, Clone, Copy)]
pub struct Detail {
    /// Cells along each side of a slice; 0 for no slice.
    pub slice_cells: usize,
    /// Whether the nearest distance of any checked pair is measured along every exit.
    pub distances: bool,
}

impl Default for Detail {
    fn default() -> Self {
        Self { slice_cells: 112, distances: true }
    }
}

/// Computes the data that pages show beside answers, with the exact checker.
pub struct Inspector<'a> {
    solver: &'a Solver,
    detail: Detail,
    scratch: CheckScratch,
}

/// A query and its answer.
#[derive(Debug, Default, Serialize)]
pub struct AnswerData {
    q: Vec<f64>,
    /// The answer under the names of the library, with pairs and coordinates as numbers. `None` if
    /// nothing free was found.
    answer: Option<Answer>,
    /// Time of the library call \[s\], if it was measured.
    seconds: Option<f64>,
    /// A contact of pairs that collide at the query.
    contacts: Vec<Contact>,
    /// The witness, then other distinct exits; empty if the query is free.
    exits: Vec<ExitData>,
    /// Bodies of every pair that is mentioned.
    pairs: BTreeMap<usize, [usize; 2]>,
    slice: Option<Slice>,
    /// A path or a grasp that is played back in place of an answer.
    #[serde(skip_serializing_if = "Option::is_none")]
    played: Option<Played>,
    /// The object of a grasp, which is the body after those of the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) object: Option<BodyData>,
}

#[derive(Debug, Serialize)]
pub(crate) struct ExitData {
    depth: f64,
    /// Waypoints between the query and the witness; empty if the segment is straight.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    way: Vec<Waypoint>,
    witness: Vec<f64>,
    /// Largest displacement of any point of the robot \[m\].
    max_displacement: f64,
    touching: Vec<PairId>,
    contacts: Vec<Contact>,
    stretches: Vec<Stretch>,
    /// The least signed distance \[m\] of any checked pair at every percent of the way; negative
    /// if bodies overlap. Empty if it was not measured.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    distances: Vec<f32>,
}

/// Pairs that collide from a percent of the straight segment on, until the next stretch.
#[derive(Debug, PartialEq, Serialize)]
struct Stretch {
    from: usize,
    pairs: Vec<PairId>,
    /// Whether a joint is beyond its limits.
    outside: bool,
}

impl<'a> Inspector<'a> {
    /// Takes the solver in whose scene the answers are.
    pub fn new(solver: &'a Solver, detail: Detail) -> Self {
        Self { solver, detail, scratch: CheckScratch::default() }
    }

    /// Adds the data of the page to an answer to the query `q`; `seconds` is the time of the
    /// library call.
    pub fn answer_data(&mut self, q: &Config, answer: Option<Answer>, seconds: Option<f64>) -> AnswerData {
        let exits = answer.as_ref().map_or(Vec::new(), |answer| self.exits(q, answer));
        let contacts = if exits.is_empty() { Vec::new() } else { self.contacts_at_query(q) };
        let mut named: Vec<PairId> = exits.iter().flat_map(ExitData::pairs).collect();
        named.extend(contacts.iter().map(|contact| contact.pair));
        named.extend(answer.iter().flat_map(|a| a.colliding.iter().chain(&a.touching)));
        let pairs = named.iter().map(|pair| self.bodies(*pair)).collect();
        let slice = answer.as_ref().filter(|_| self.detail.slice_cells > 0).and_then(|answer| {
            let witnesses: Vec<&[f64]> = exits.iter().map(|exit| &*exit.witness).collect();
            let radii = [answer.lower_bound, answer.depth];
            slice(self.solver, q, &witnesses, radii, self.detail.slice_cells, &mut self.scratch)
        });
        AnswerData { q: q.to_vec(), answer, seconds, contacts, exits, pairs, slice, ..AnswerData::default() }
    }

    pub(crate) fn detail(&self) -> Detail {
        self.detail
    }

    pub(crate) fn solver(&self) -> &'a Solver {
        self.solver
    }

    /// Returns the page's data of something other than an answer, which leads from `q` to an exit.
    pub(crate) fn played_data(&mut self, q: &Config, exit: ExitData, played: Played) -> AnswerData {
        let contacts = self.contacts_at_query(q);
        let named = exit.pairs().chain(contacts.iter().map(|contact| contact.pair));
        let pairs = named.map(|pair| self.bodies(pair)).collect();
        let (q, exits, played) = (q.to_vec(), vec![exit], Some(played));
        AnswerData { q, contacts, exits, pairs, played, ..AnswerData::default() }
    }

    /// Returns the page's data of an exit that no query found. Contacts within `reach` \[m\] count
    /// too; without it none are listed.
    pub(crate) fn exit_by_way(
        &mut self,
        q: &Config,
        way: Vec<Waypoint>,
        witness: Vec<f64>,
        depth: f64,
        reach: Option<f64>,
    ) -> ExitData {
        let ends = way.iter().map(|point| &point.q).chain([&witness]);
        let max_displacement = ends.map(|end| self.moved(q, end)).fold(0.0, f64::max);
        let (stretches, distances) = self.course(q, &way, &witness);
        let clearance = self.solver.scene().clearance();
        let mut contacts = reach.map_or(Vec::new(), |reach| self.contacts(&witness, clearance.max(reach)));
        contacts.truncate(MAX_CONTACTS);
        let touching = contacts.iter().map(|contact| contact.pair).collect();
        ExitData { depth, way, witness, max_displacement, touching, contacts, stretches, distances }
    }

    /// Returns the index and the bodies of a pair.
    fn bodies(&self, pair: PairId) -> (usize, [usize; 2]) {
        let found = self.solver.scene().pairs()[pair.index()];
        (pair.index(), [found.first, found.second])
    }

    /// Largest displacement \[m\] of any point of the robot.
    fn moved(&self, from: &[f64], to: &[f64]) -> f64 {
        let (metric, mut anchor) = (self.solver.metric(), Anchor::default());
        metric.anchor(from, &mut anchor);
        metric.max_displacement_from(&anchor, to, &mut MetricScratch::default())
    }

    fn exits(&mut self, q: &Config, answer: &Answer) -> Vec<ExitData> {
        if answer.is_free() {
            return Vec::new();
        }
        let mut all: Vec<(f64, &Config, &[PairId])> =
            answer.exits.iter().map(|exit| (exit.depth, &exit.witness, &exit.touching[..])).collect();
        if all.is_empty() {
            all.push((answer.depth, &answer.witness, &answer.touching));
        }
        let of_exit = |(depth, witness, touching): (f64, &Config, &[PairId])| ExitData {
            touching: touching.to_vec(),
            contacts: self.contacts(witness, answer.clearance),
            ..self.exit_by_way(q, Vec::new(), witness.to_vec(), depth, None)
        };
        let mut exits: Vec<ExitData> = all.into_iter().take(MAX_EXITS).map(of_exit).collect();
        if let Some(nearest) = exits.first_mut() {
            (nearest.max_displacement, nearest.contacts) = (answer.max_displacement, answer.contacts.clone());
        }
        exits.iter_mut().for_each(|exit| exit.contacts.truncate(MAX_CONTACTS));
        exits
    }

    fn contacts(&mut self, q: &[f64], clearance: f64) -> Vec<Contact> {
        let mut contacts = Vec::new();
        self.solver.checker().contacts_within(q, clearance + TOUCHING, &mut self.scratch, &mut contacts);
        contacts
    }

    /// Returns a contact of every pair that collides at the query: the one whose distance is
    /// nearest to that of the pair. Shapes that overlap also have contacts along longer ways apart;
    /// those that are twice as deep as the pair are left out.
    fn contacts_at_query(&mut self, q: &[f64]) -> Vec<Contact> {
        let colliding = self.solver.colliding_pairs(q);
        if colliding.is_empty() {
            return Vec::new();
        }
        let distances = self.solver.pair_distances(q);
        let all = self.contacts(q, self.solver.scene().clearance());
        let off = |contact: &Contact| (contact.distance - distances[contact.pair.index()]).abs();
        let of_pair = |pair: &PairId| {
            let depth = distances[pair.index()].abs();
            let own = all.iter().filter(|contact| contact.pair == *pair && off(contact) <= depth + TOUCHING);
            own.min_by(|a, b| off(a).total_cmp(&off(b))).cloned()
        };
        colliding.iter().filter_map(of_pair).take(MAX_CONTACTS).collect()
    }

    /// Returns what collides along the way, and the nearest distances at every percent of it.
    fn course(&self, q: &[f64], way: &[Waypoint], witness: &[f64]) -> (Vec<Stretch>, Vec<f32>) {
        let space = self.solver.scene().space();
        let (mut at, mut stretches) = (vec![0.0; q.len()], Vec::<Stretch>::new());
        let mut distances = Vec::new();
        for step in 0..=SEGMENT_STEPS {
            let (from, to, share) = leg(q, way, witness, step as f64 / SEGMENT_STEPS as f64);
            between(space, from, to, share, &mut at);
            let pairs = self.solver.colliding_pairs(&at);
            let outside = space.outside(&at).next().is_some();
            if stretches.last().is_none_or(|last| (&last.pairs, last.outside) != (&pairs, outside)) {
                stretches.push(Stretch { from: step, pairs, outside });
            }
            if self.detail.distances {
                distances.push(self.solver.distance(&at) as f32);
            }
        }
        (stretches, distances)
    }
}

impl ExitData {
    fn pairs(&self) -> impl Iterator<Item = PairId> + '_ {
        let of_stretches = self.stretches.iter().flat_map(|stretch| &stretch.pairs);
        of_stretches.chain(&self.touching).copied().chain(self.contacts.iter().map(|contact| contact.pair))
    }
}

/// The point at fraction `t` of the straight segment, even if an end is beyond the limits.
fn between(space: &ConfigSpace, from: &[f64], to: &[f64], t: f64, out: &mut [f64]) {
    if t == 1.0 {
        return out.copy_from_slice(to);
    }
    space.interpolate(from, to, t, out);
    let intervals = space.factors().iter().filter(|f| matches!(f.manifold, Manifold::Interval { .. }));
    intervals.for_each(|f| out[f.q] = from[f.q] + t * (to[f.q] - from[f.q]));
}

#[cfg(test)]
mod tests {
    use super::*;
    use extricate::{Label, QueryOptions, Sampler, builtin};
    use std::ops::ControlFlow;

    /// The page's data of a configuration of this label, moved by `by` in its last joint.
    fn shown(label: Label, by: f64) -> (AnswerData, Solver) {
        let options = QueryOptions::default().exits(4);
        let solver = Solver::new(builtin::scene("planar-arm").unwrap()).options(options).unwrap();
        let drawn = Sampler::new(&solver, Some(label), 0).draw(1, &mut |_, _| ControlFlow::Continue(()));
        let mut q = drawn.unwrap().remove(0);
        *q.last_mut().unwrap() += by;
        let q = solver.scene().space().config_anywhere(&q).unwrap();
        let data = Inspector::new(&solver, Detail { slice_cells: 24, distances: true }).answer_data(
            &q,
            solver.query(&q),
            Some(1e-3),
        );
        (data, solver)
    }

    #[test]
    fn an_exit_begins_in_collision_and_ends_free() {
        let (data, solver) = shown(Label::Colliding, 0.0);
        let answer = data.answer.as_ref().unwrap();
        assert_eq!(data.exits[0].witness, *answer.witness);
        assert!((data.exits[0].max_displacement - answer.max_displacement).abs() < 1e-12);
        for exit in &data.exits {
            let (first, last) = (&exit.stretches[0], exit.stretches.last().unwrap());
            assert_eq!((first.from, &first.pairs), (0, &answer.colliding));
            assert!(last.pairs.is_empty() && !last.outside && last.from <= SEGMENT_STEPS);
            assert!(!exit.contacts.is_empty(), "an exit touches something");
            // Distances are negative while solids overlap, and keep the clearance at the exit.
            let distances = &exit.distances;
            assert!(distances.len() == SEGMENT_STEPS + 1 && distances[0] <= 0.0 && distances[SEGMENT_STEPS] >= 0.0);
        }
        assert!(data.pairs.iter().all(|(pair, bodies)| {
            let found = solver.scene().pairs()[*pair];
            *bodies == [found.first, found.second]
        }));
        let at_query: Vec<PairId> = data.contacts.iter().map(|contact| contact.pair).collect();
        assert!(answer.colliding.iter().all(|pair| at_query.contains(pair)), "{at_query:?}");
        assert!(data.contacts.iter().all(|contact| contact.distance <= 0.0), "they overlap");
        // The page contains the answer of the library, digit for digit.
        let text = serde_json::to_value(&data).unwrap();
        assert_eq!(text["answer"], serde_json::to_value(answer).unwrap());
    }

    #[test]
    fn a_free_query_has_no_exit_and_one_beyond_the_limits_is_outside_at_first() {
        let (free, _) = shown(Label::Free, 0.0);
        assert!(free.answer.as_ref().unwrap().is_free() && free.exits.is_empty() && free.slice.is_none());
        let (beyond, _) = shown(Label::Free, 7.0);
        assert!(!beyond.answer.as_ref().unwrap().outside.is_empty());
        assert!(beyond.exits[0].stretches[0].outside && !beyond.exits[0].stretches.last().unwrap().outside);
    }
}
