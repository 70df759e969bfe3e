//! Commands that answer with paths: out of collision, between two configurations, and in place of a
//! path that collides.

pub mod escape;
pub mod plan;
pub mod repair;

use anyhow::Context;
use extricate::{Config, Scene};

use crate::input::Configs;
use crate::notice;

/// Parses the configuration of an option.
fn config(name: &str, word: &str, scene: &Scene) -> anyhow::Result<Config> {
    let mut configs = Configs::of_word(name, word);
    let entry = configs.next(scene)?.with_context(|| format!("{name}: got nothing, expected a configuration"))?;
    configs.take_notes().iter().for_each(notice::warning);
    entry.map(|(_, q)| q).map_err(|bad| anyhow::anyhow!("{name}: {}", bad.error))
}
