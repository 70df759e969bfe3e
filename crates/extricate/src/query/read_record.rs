//! Reading of an answer from its record.

use std::collections::HashMap;

use serde::Deserialize;

use super::answer::{Answer, Exit, StraightSegment};
use super::keep::KeptError;
use crate::collision::Contact;
use crate::cspace::Config;
use crate::error::{Error, Result};
use crate::scene::{PairId, Scene};

type PairNames = [String; 2];

/// The keys of [`super::AnswerRecord`]. Keys that earlier versions did not write have a default.
#[derive(Deserialize)]
struct Record {
    depth: f64,
    lower_bound: f64,
    gap: f64,
    #[serde(default)]
    unproved: Option<String>,
    witness: Vec<f64>,
    checks: usize,
    max_displacement: f64,
    colliding: Vec<PairNames>,
    #[serde(default)]
    outside: Vec<String>,
    #[serde(default)]
    off: Vec<usize>,
    #[serde(default)]
    kept: Vec<KeptError>,
    touching: Vec<PairNames>,
    #[serde(default)]
    unseen: Option<f64>,
    #[serde(default)]
    nearest: Option<f64>,
    #[serde(default)]
    detour: bool,
    clearance: f64,
    verified: bool,
    effort: String,
    contacts: Vec<ContactRecord>,
    gradient: Vec<f64>,
    unique: bool,
    #[serde(default)]
    cut_short: bool,
    #[serde(default)]
    exits: Vec<ExitRecord>,
    #[serde(default)]
    free_radius: Option<f64>,
    #[serde(default)]
    segment: Option<StraightSegment>,
}

#[derive(Deserialize)]
struct ContactRecord {
    pair: PairNames,
    distance: f64,
    point_first: [f64; 3],
    point_second: [f64; 3],
    normal: [f64; 3],
}

#[derive(Deserialize)]
struct ExitRecord {
    depth: f64,
    witness: Vec<f64>,
    touching: Vec<PairNames>,
}

impl Answer {
    /// Reads the answer whose [`Answer::record`], written as JSON, is `json`; messages call it
    /// `name`. Other keys are ignored. Values are taken as they are; only whether they fit the
    /// scene is checked. A joint beyond its limits becomes the first of its coordinates.
    ///
    /// # Errors
    /// [`Error::Input`] for a text that is no such record, a name that the scene does not have, or
    /// a witness that is no configuration of the scene.
    pub fn from_record(name: &str, json: &str, scene: &Scene) -> Result<Self> {
        let unread = |error: serde_json::Error| {
            Error::input(name, "answer", format!("{error}, expected what `extricate query --json` prints"))
        };
        let record: Record = serde_json::from_str(json).map_err(unread)?;
        Reader::new(name, scene).answer(record)
    }
}

/// Resolves the names of a scene.
struct Reader<'a> {
    name: &'a str,
    scene: &'a Scene,
    pairs: HashMap<[&'a str; 2], PairId>,
}

impl<'a> Reader<'a> {
    fn new(name: &'a str, scene: &'a Scene) -> Self {
        let pairs = (0..scene.pairs.len()).map(PairId::new).map(|pair| (scene.pair_names(pair), pair)).collect();
        Self { name, scene, pairs }
    }

    fn pair(&self, [first, second]: &PairNames) -> Result<PairId> {
        let problem = || format!("got {first} - {second}, expected a checked pair of the scene");
        let found = self.pairs.get(&[first.as_str(), second.as_str()]).copied();
        found.ok_or_else(|| Error::input(self.name, "pair", problem()))
    }

    fn pairs(&self, names: &[PairNames]) -> Result<Vec<PairId>> {
        names.iter().map(|names| self.pair(names)).collect()
    }

    /// Returns the first coordinate of each joint.
    fn coordinates(&self, joints: &[String]) -> Result<Vec<usize>> {
        let problem = |name: &String| format!("got {name}, expected a joint of the scene");
        let first = |name: &String| {
            let found = self.scene.joints.iter().find(|joint| joint.name == *name).map(|joint| joint.q.start);
            found.ok_or_else(|| Error::input(self.name, "outside", problem(name)))
        };
        joints.iter().map(first).collect()
    }

    fn config(&self, witness: &[f64]) -> Result<Config> {
        let config = self.scene.space.config_anywhere(witness);
        config.map_err(|error| Error::input(self.name, "witness", error.to_string()))
    }

    fn choice<T: std::str::FromStr<Err = Error>>(&self, word: &str) -> Result<T> {
        word.parse().map_err(|error| match error {
            Error::Option { name, value, expected } => {
                Error::input(self.name, name, format!("got {value}, expected {expected}"))
            }
            other => other,
        })
    }

    fn contact(&self, record: &ContactRecord) -> Result<Contact> {
        Ok(Contact {
            pair: self.pair(&record.pair)?,
            distance: record.distance,
            point_first: record.point_first.into(),
            point_second: record.point_second.into(),
            normal: record.normal.into(),
        })
    }

    fn exit(&self, record: &ExitRecord) -> Result<Exit> {
        let (witness, touching) = (self.config(&record.witness)?, self.pairs(&record.touching)?);
        Ok(Exit { depth: record.depth, witness, touching })
    }

    fn answer(&self, record: Record) -> Result<Answer> {
        Ok(Answer {
            depth: record.depth,
            lower_bound: record.lower_bound,
            gap: record.gap,
            unproved: record.unproved.map(|word| self.choice(&word)).transpose()?,
            witness: self.config(&record.witness)?,
            effort: self.choice(&record.effort)?,
            checks: record.checks,
            max_displacement: record.max_displacement,
            colliding: self.pairs(&record.colliding)?,
            outside: self.coordinates(&record.outside)?,
            off: record.off,
            kept: record.kept,
            touching: self.pairs(&record.touching)?,
            unseen: record.unseen,
            nearest: record.nearest,
            detour: record.detour,
            clearance: record.clearance,
            verified: record.verified,
            contacts: record.contacts.iter().map(|contact| self.contact(contact)).collect::<Result<_>>()?,
            gradient: record.gradient,
            unique: record.unique,
            cut_short: record.cut_short,
            exits: record.exits.iter().map(|exit| self.exit(exit)).collect::<Result<_>>()?,
            free_radius: record.free_radius,
            segment: record.segment,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::query::QueryOptions;
    use crate::scene::builtin;
    use crate::solver::Solver;

    #[test]
    fn an_answer_comes_back_from_its_record_and_faults_are_named() {
        let options = QueryOptions::default().exits(3).free_radius(true).segment(true);
        let solver = Solver::new(builtin::scene("planar-arm").unwrap()).options(options).unwrap();
        let scene = solver.scene();
        for q in [[0.4, 0.0, 0.0], [0.4, 9.0, 0.0]] {
            let answer = solver.query(&scene.space.config_anywhere(&q).unwrap()).unwrap();
            let json = serde_json::to_string(&answer.record(scene)).unwrap();
            assert_eq!(Answer::from_record("a", &json, scene).unwrap(), answer);
            for (from, to, expected) in [
                ("\"depth\"", "\"width\"", "a: answer: missing field `depth`"),
                ("\"refined\"", "\"lucky\"", "a: effort: got \"lucky\", expected \"nearest\""),
                ("\"witness\":[", "\"witness\":[0,", "a: witness: configuration: length: got 4"),
            ] {
                let message = Answer::from_record("a", &json.replace(from, to), scene).unwrap_err().to_string();
                assert!(message.starts_with(expected), "{message}");
            }
        }
    }
}
