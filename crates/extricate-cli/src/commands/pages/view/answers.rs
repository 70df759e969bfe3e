//! Answers from lines of `query --json` and `grasp --json`. What they say is shown, not judged;
//! that they fit the scene is checked.

use std::path::Path;

use anyhow::{Context, bail};
use extricate::{Answer, Scene};
use extricate_view::GraspData;
use serde::Deserialize;

use crate::commands::query::Timed;

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

/// What tells the kinds of lines apart.
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
    /// Reads a file.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
        Ok(Self { name, text })
    }

    /// What the lines say: as many as there are queries.
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
                // Configurations that could not be used are left out of the queries too.
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
