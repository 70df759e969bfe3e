//! Records of answers, with names in place of indices, which all shells show.

use serde::Serialize;

use super::answer::{Answer, Exit, StraightSegment, Unproved};
use super::keep::KeptError;
use super::options::Effort;
use crate::collision::Contact;
use crate::cspace::Config;
use crate::scene::{PairId, Scene};

/// The names of two bodies, in the order of the scene.
pub type PairNames<'a> = [&'a str; 2];

/// An [`Answer`] with the names that its scene has for bodies and joints; the fields are those of
/// the answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AnswerRecord<'a> {
    /// Distance from the query to the witness, see [`Answer::depth`].
    pub depth: f64,
    /// Proved lower bound on the depth, see [`Answer::lower_bound`].
    pub lower_bound: f64,
    /// Share of the depth that is not proved, see [`Answer::gap`].
    pub gap: f64,
    /// Why nothing is proved, see [`Answer::unproved`].
    pub unproved: Option<Unproved>,
    /// The free configuration that was found, see [`Answer::witness`].
    pub witness: &'a Config,
    /// Checks and distance evaluations spent, see [`Answer::checks`].
    pub checks: usize,
    /// Largest displacement of any point \[m\], see [`Answer::max_displacement`].
    pub max_displacement: f64,
    /// The bodies of each pair that collides at the query.
    pub colliding: Vec<PairNames<'a>>,
    /// The joints of the query that are beyond their limits.
    pub outside: Vec<&'a str>,
    /// The kept links that are off at the query, see [`Answer::off`].
    #[serde(skip_serializing_if = "<[usize]>::is_empty")]
    pub off: &'a [usize],
    /// How far each kept link is off at the witness, see [`Answer::kept`].
    #[serde(skip_serializing_if = "<[KeptError]>::is_empty")]
    pub kept: &'a [KeptError],
    /// The bodies of each pair that touches at the witness.
    pub touching: Vec<PairNames<'a>>,
    /// Estimated share of starts that lead to unmet exits, see [`Answer::unseen`].
    pub unseen: Option<f64>,
    /// Depth of the nearest exit if the witness is a proxy, see [`Answer::nearest`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nearest: Option<f64>,
    /// Whether a proxy goes back to the nearest exit, see [`Answer::detour`].
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub detour: bool,
    /// Clearance that the witness keeps \[m\], see [`Answer::clearance`].
    pub clearance: f64,
    /// Whether the witness was checked in this query, see [`Answer::verified`].
    pub verified: bool,
    /// The effort that was requested, see [`Answer::effort`].
    pub effort: Effort,
    /// Contacts at the witness, see [`Answer::contacts`].
    pub contacts: Vec<ContactRecord<'a>>,
    /// Gradient of the depth over the query, see [`Answer::gradient`].
    pub gradient: &'a [f64],
    /// Whether no exit about as near was met, see [`Answer::unique`].
    pub unique: bool,
    /// Whether a limit ended the search, see [`Answer::cut_short`].
    pub cut_short: bool,
    /// The distinct exits, nearest first, see [`Answer::exits`].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub exits: Vec<ExitRecord<'a>>,
    /// Proved distance without contact, see [`Answer::free_radius`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub free_radius: Option<f64>,
    /// The straight segment to the witness, see [`Answer::segment`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub segment: Option<StraightSegment>,
}

/// A [`Contact`] with names.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ContactRecord<'a> {
    /// The bodies that touch.
    pub pair: PairNames<'a>,
    /// Their signed distance \[m\].
    pub distance: f64,
    /// The nearest point of the first body \[m\], in the world.
    pub point_first: [f64; 3],
    /// The nearest point of the second body \[m\], in the world.
    pub point_second: [f64; 3],
    /// The unit normal from the second body toward the first, in the world: moving the first along
    /// it by `t` changes `distance` by `t`.
    pub normal: [f64; 3],
}

/// An [`Exit`] with names.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ExitRecord<'a> {
    /// The distance from the query, in the scene's metric.
    pub depth: f64,
    /// A free configuration at that distance.
    pub witness: &'a Config,
    /// The bodies of each pair that touches there.
    pub touching: Vec<PairNames<'a>>,
}

impl<'a> ContactRecord<'a> {
    /// Names a contact of `scene`.
    pub fn new(contact: &Contact, scene: &'a Scene) -> Self {
        let Contact { pair, distance, point_first, point_second, normal } = *contact;
        let [point_first, point_second, normal] = [point_first, point_second, normal].map(Into::into);
        Self { pair: scene.pair_names(pair), distance, point_first, point_second, normal }
    }
}

impl Answer {
    /// Returns the answer with the names of `scene`, in which the query was made.
    pub fn record<'a>(&'a self, scene: &'a Scene) -> AnswerRecord<'a> {
        let named = |pairs: &[PairId]| pairs.iter().map(|pair| scene.pair_names(*pair)).collect::<Vec<_>>();
        let exit =
            |exit: &'a Exit| ExitRecord { depth: exit.depth, witness: &exit.witness, touching: named(&exit.touching) };
        AnswerRecord {
            depth: self.depth,
            lower_bound: self.lower_bound,
            gap: self.gap,
            unproved: self.unproved,
            witness: &self.witness,
            checks: self.checks,
            max_displacement: self.max_displacement,
            colliding: named(&self.colliding),
            outside: scene.joints_of(&self.outside),
            off: &self.off,
            kept: &self.kept,
            touching: named(&self.touching),
            unseen: self.unseen,
            nearest: self.nearest,
            detour: self.detour,
            clearance: self.clearance,
            verified: self.verified,
            effort: self.effort,
            contacts: self.contacts.iter().map(|contact| ContactRecord::new(contact, scene)).collect(),
            gradient: &self.gradient,
            unique: self.unique,
            cut_short: self.cut_short,
            exits: self.exits.iter().map(exit).collect(),
            free_radius: self.free_radius,
            segment: self.segment,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use crate::query::{KeptError, QueryOptions};
    use crate::scene::builtin;
    use crate::solver::Solver;

    fn keys(value: &serde_json::Value) -> BTreeSet<&str> {
        value.as_object().unwrap().keys().map(String::as_str).collect()
    }

    #[test]
    fn a_record_has_the_fields_of_its_answer_and_names() {
        let options = QueryOptions::default().exits(3).free_radius(true).segment(true);
        let solver = Solver::new(builtin::scene("planar-arm").unwrap()).options(options).unwrap();
        let mut answer = solver.query(&solver.scene().config(&[0.4, 0.0, 0.0]).unwrap()).unwrap();
        answer.nearest = Some(0.1);
        answer.detour = true;
        answer.off = vec![0];
        answer.kept = vec![KeptError { position: 0.0, rotation: 0.0 }];
        let record = serde_json::to_value(answer.record(solver.scene())).unwrap();
        let own = serde_json::to_value(&answer).unwrap();
        assert_eq!(keys(&record), keys(&own));
        assert_eq!(keys(&record["exits"][0]), keys(&own["exits"][0]));
        assert_eq!(keys(&record["contacts"][0]), keys(&own["contacts"][0]));
        let names = solver.scene().pair_names(answer.colliding[0]);
        assert_eq!(record["colliding"][0], serde_json::json!(names));
    }
}
