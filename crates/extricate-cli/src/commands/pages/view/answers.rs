//! Answers from lines of `query --json` and `grasp --json`, names back to numbers. What they say is
//! shown, not judged; that they fit the scene is checked.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context, bail};
use extricate::geometry::Vec3;
use extricate::{Answer, Contact, Effort, Exit, PairId, Scene, StraightSegment, Unproved};
use extricate_view::GraspData;
use serde::Deserialize;

use crate::commands::query::asker::Timed;

/// Lines of answers.
pub struct Answers {
    name: String,
    text: String,
}

/// What a line says of its configuration.
pub enum Given {
    /// What was answered, and how long it took \[s\].
    Answer(Timed),
    /// What was released.
    Grasp(GraspData),
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Line {
    Answer(Box<Row>),
    Grasp(Box<GraspData>),
    Error { error: String },
}

#[derive(Deserialize)]
struct Row {
    depth: f64,
    lower_bound: f64,
    gap: f64,
    #[serde(default)]
    unproved: Option<String>,
    witness: Vec<f64>,
    #[serde(default)]
    seconds: f64,
    checks: usize,
    max_displacement: f64,
    colliding: Vec<[String; 2]>,
    #[serde(default)]
    outside: Vec<String>,
    touching: Vec<[String; 2]>,
    #[serde(default)]
    unseen: Option<f64>,
    clearance: f64,
    verified: bool,
    effort: String,
    contacts: Vec<ContactRow>,
    gradient: Vec<f64>,
    unique: bool,
    #[serde(default)]
    cut_short: bool,
    #[serde(default)]
    exits: Vec<ExitRow>,
    #[serde(default)]
    free_radius: Option<f64>,
    #[serde(default)]
    segment: Option<SegmentRow>,
}

#[derive(Deserialize)]
struct ContactRow {
    pair: [String; 2],
    distance: f64,
    point_first: [f64; 3],
    point_second: [f64; 3],
    normal: [f64; 3],
}

#[derive(Deserialize)]
struct ExitRow {
    depth: f64,
    witness: Vec<f64>,
    touching: Vec<[String; 2]>,
}

#[derive(Deserialize)]
struct SegmentRow {
    colliding_until: f64,
    free_from: f64,
}

impl Answers {
    /// Reads a file.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
        Ok(Self { name, text })
    }

    /// What the lines say: as many as there are queries.
    pub fn read(&self, scene: &Scene, queries: usize) -> anyhow::Result<Vec<Given>> {
        let names = Names::of(scene);
        let mut answers = Vec::new();
        let lines = self.text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        for (at, line) in lines {
            let place = || format!("{}: line {}", self.name, at + 1);
            match serde_json::from_str(line) {
                Ok(Line::Answer(row)) => {
                    let seconds = row.seconds;
                    let answer = names.answer(*row).map_err(|fault| anyhow::anyhow!("{}: {fault}", place()))?;
                    answers.push(Given::Answer((Some(answer), seconds)));
                }
                Ok(Line::Grasp(grasp)) => {
                    let config = names.witness(grasp.config.clone());
                    config.map_err(|fault| anyhow::anyhow!("{}: {fault}", place()))?;
                    answers.push(Given::Grasp(*grasp));
                }
                // Configurations that could not be used are left out of the queries too.
                Ok(Line::Error { error }) if error.starts_with("no free") => answers.push(Given::Answer((None, 0.0))),
                Ok(Line::Error { .. }) => {}
                Err(_) => {
                    bail!("{}: expected an answer as `extricate query --json` or `grasp --json` prints it", place())
                }
            }
        }
        if answers.len() != queries {
            bail!("{}: got {} answers, expected {queries}, one a configuration", self.name, answers.len());
        }
        Ok(answers)
    }
}

/// Numbers of what is named in a scene.
struct Names<'a> {
    scene: &'a Scene,
    pairs: HashMap<[&'a str; 2], PairId>,
}

impl<'a> Names<'a> {
    fn of(scene: &'a Scene) -> Self {
        let pairs = (0..scene.pairs.len()).map(PairId::new).map(|pair| (scene.pair_names(pair), pair)).collect();
        Self { scene, pairs }
    }

    fn pair(&self, [first, second]: &[String; 2]) -> Result<PairId, String> {
        let found = self.pairs.get(&[first.as_str(), second.as_str()]);
        found.copied().ok_or_else(|| format!("pair: got {first} - {second}, expected a checked pair of the scene"))
    }

    fn pairs(&self, names: &[[String; 2]]) -> Result<Vec<PairId>, String> {
        names.iter().map(|names| self.pair(names)).collect()
    }

    fn witness(&self, witness: Vec<f64>) -> Result<Vec<f64>, String> {
        let nq = self.scene.space.nq();
        match witness.len() {
            found if found != nq => Err(format!("witness: got {found} numbers, expected {nq}")),
            _ => Ok(witness),
        }
    }

    fn contact(&self, row: &ContactRow) -> Result<Contact, String> {
        let [point_first, point_second, normal] = [row.point_first, row.point_second, row.normal].map(Vec3::from);
        Ok(Contact { pair: self.pair(&row.pair)?, distance: row.distance, point_first, point_second, normal })
    }

    fn exit(&self, row: ExitRow) -> Result<Exit, String> {
        let touching = self.pairs(&row.touching)?;
        Ok(Exit { depth: row.depth, witness: self.witness(row.witness)?, touching })
    }

    fn answer(&self, row: Row) -> Result<Answer, String> {
        let effort = Effort::ALL.into_iter().find(|effort| effort.name() == row.effort);
        let outside = self.scene.joints.iter().filter(|joint| row.outside.contains(&joint.name));
        let segment = |s: SegmentRow| StraightSegment { colliding_until: s.colliding_until, free_from: s.free_from };
        Ok(Answer {
            depth: row.depth,
            lower_bound: row.lower_bound,
            gap: row.gap,
            unproved: [Unproved::Surfaces, Unproved::Shallow]
                .into_iter()
                .find(|u| row.unproved.as_deref() == Some(u.name())),
            witness: self.witness(row.witness)?,
            effort: effort.ok_or_else(|| format!("effort: got {}, expected that of a query", row.effort))?,
            checks: row.checks,
            max_displacement: row.max_displacement,
            colliding: self.pairs(&row.colliding)?,
            outside: outside.map(|joint| joint.q.start).collect(),
            touching: self.pairs(&row.touching)?,
            nearest: None,
            unseen: row.unseen,
            clearance: row.clearance,
            free_radius: row.free_radius,
            verified: row.verified,
            contacts: row.contacts.iter().map(|contact| self.contact(contact)).collect::<Result<_, _>>()?,
            gradient: row.gradient,
            unique: row.unique,
            cut_short: row.cut_short,
            exits: row.exits.into_iter().map(|exit| self.exit(exit)).collect::<Result<_, _>>()?,
            segment: row.segment.map(segment),
        })
    }
}
