//! Reads answers from lines of `query --json` and `grasp --json`. They have to fit the scene, but
//! the page shows their statements unchecked.

use std::path::Path;

use anyhow::{Context, bail};
use extricate::{Answer, Scene};
use extricate_view::GraspData;
use serde::Deserialize;

use crate::commands::query::Timed;

/// A file with lines of answers.
pub struct Answers {
    name: String,
    text: String,
}

/// The answer of a line.
pub enum Given {
    /// An answer and its time \[s\].
    Answer(Timed),
    /// A released grasp.
    Grasp(GraspData),
}

/// Distinguishes the kinds of lines.
#[derive(Deserialize)]
#[serde(untagged)]
enum Line {
    Grasp(Box<GraspData>),
    Error {
        error: String,
    },
    Answer {
        #[expect(dead_code, reason = "its name tells that the line is an answer")]
        depth: f64,
        #[serde(default)]
        seconds: f64,
    },
}

impl Answers {
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
        Ok(Self { name, text })
    }

    /// Reads one answer for each query.
    pub fn read(&self, scene: &Scene, queries: usize) -> anyhow::Result<Vec<Given>> {
        let mut answers = Vec::new();
        let lines = self.text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        for (at, line) in lines {
            let place = format!("{}: line {}", self.name, at + 1);
            match serde_json::from_str(line) {
                Ok(Line::Answer { seconds, .. }) => {
                    let answer = Answer::from_record(&place, line, scene)?;
                    answers.push(Given::Answer((Some(answer), seconds)));
                }
                Ok(Line::Grasp(grasp)) => {
                    scene.space().config_anywhere(&grasp.config).context(place)?;
                    answers.push(Given::Grasp(*grasp));
                }
                // Unusable configurations are left out of the queries too, so their lines are
                // skipped.
                Ok(Line::Error { error }) if error.starts_with("no free") => answers.push(Given::Answer((None, 0.0))),
                Ok(Line::Error { .. }) => {}
                Err(_) => bail!("{place}: expected an answer as `extricate query --json` or `grasp --json` prints it"),
            }
        }
        if answers.len() != queries {
            bail!("{}: got {} answers, expected {queries}, one a configuration", self.name, answers.len());
        }
        Ok(answers)
    }
}
