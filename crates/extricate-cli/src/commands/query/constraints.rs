//! Which configurations count as answers: the options of `query` that say so.

use anyhow::Context;
use clap::Args;
use extricate::{QueryOptions, Scene, Toward};

use crate::args::{length, share_or_more};
use crate::input::Configs;

/// What an answer has to keep, and where it should lie.
#[derive(Args)]
#[command(next_help_heading = "World and constraints")]
pub struct ConstraintArgs {
    /// Aim at this clearance in metres in place of the scene's; a witness that would be more than
    /// ten times as far as the nearest at the scene's clearance keeps less, and the answer says so
    #[arg(long, value_name = "M", value_parser = length, allow_negative_numbers = true)]
    clearance: Option<f64>,
    /// Joints that stay where the query has them, by name
    #[arg(long, value_name = "JOINT", value_delimiter = ',', conflicts_with = "free")]
    locked: Vec<String>,
    /// The joints that may move, by name; all others are locked
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    free: Vec<String>,
    /// Other weights of squared displacements, of the metric of the joints; what a model has
    /// learned is then not used
    #[arg(long, value_name = "JOINT=W", value_delimiter = ',', value_parser = weight)]
    weights: Vec<(String, f64)>,
    /// Of exits that are about as near, choose the one nearest to this configuration
    #[arg(long, value_name = "Q", allow_hyphen_values = true)]
    toward: Option<String>,
    /// With --toward: an exit counts that is farther than the nearest by at most this share
    #[arg(long, value_name = "SHARE", value_parser = share_or_more, allow_negative_numbers = true, default_value_t = 0.25, requires = "toward")]
    toward_share: f64,
    /// Prove how far around the witness nothing touches
    #[arg(long)]
    free_radius: bool,
}

impl ConstraintArgs {
    /// Whether an exit is to be chosen by a goal.
    pub fn has_goal(&self) -> bool {
        self.toward.is_some()
    }

    /// Adds them to the options of queries in a scene.
    pub fn apply(&self, scene: &Scene, options: &mut QueryOptions) -> anyhow::Result<()> {
        options.clearance = self.clearance;
        options.free_radius = self.free_radius;
        options.locked = scene.joints_named("--locked", self.locked.iter().map(String::as_str))?;
        if !self.free.is_empty() {
            let free = scene.joints_named("--free", self.free.iter().map(String::as_str))?;
            options.locked = (0..scene.joints.len()).filter(|joint| !free.contains(joint)).collect();
        }
        if let Some(words) = &self.toward {
            let goal = Configs::of_words(std::slice::from_ref(words)).next(scene)?;
            let goal = goal.and_then(Result::ok).map(|(_, goal)| goal);
            let expected = || format!("--toward: got {words}, expected {} numbers within the limits", scene.space.nq());
            options.toward = Some(Toward { goal: goal.with_context(expected)?.to_vec(), share: self.toward_share });
        }
        Ok(())
    }

    /// The scene with the weights, where some were given.
    pub fn weighted(&self, scene: &Scene) -> anyhow::Result<Option<Scene>> {
        if self.weights.is_empty() {
            return Ok(None);
        }
        let weights = self.weights.iter().map(|(name, weight)| (name.as_str(), [*weight; 2]));
        Ok(Some(scene.weighted(weights)?))
    }
}

fn weight(text: &str) -> Result<(String, f64), String> {
    let parts = text.rsplit_once('=').and_then(|(name, weight)| Some((name.to_string(), weight.parse().ok()?)));
    parts.ok_or_else(|| "expected JOINT=W, such as elbow=4".into())
}
