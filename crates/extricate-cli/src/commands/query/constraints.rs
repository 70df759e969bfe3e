//! The options of `query` that decide which configurations count as answers.

use anyhow::Context;
use clap::Args;
use extricate::{QueryOptions, Scene, Solver};

use crate::args::{goal_to_come, length, share_or_more};
use crate::commands::kept_links;
use crate::input::Configs;

/// Options that decide which configurations count as answers.
#[derive(Args)]
#[command(next_help_heading = "World and constraints")]
pub struct ConstraintArgs {
    /// Aim at this clearance in metres instead of the scene's. If that puts the witness more than
    /// ten times as far as the nearest one at the scene's clearance, the witness keeps less
    /// clearance, and the answer reports it
    #[arg(long, value_name = "M", value_parser = length, allow_negative_numbers = true)]
    clearance: Option<f64>,
    /// Names of joints that keep their positions in the query
    #[arg(long, value_name = "JOINT", value_delimiter = ',', conflicts_with = "free")]
    locked: Vec<String>,
    /// Names of the joints that may move; all others are locked
    #[arg(long, value_name = "JOINT", value_delimiter = ',')]
    free: Vec<String>,
    /// Links that keep their places: the name of a link, a JSON object such as {"link": "tool0",
    /// "rotation": null}, or an array of objects. Tolerances are position (1e-4 m) and rotation
    /// (1e-3 rad); null leaves the link free. With axis, only this axis of the link keeps its
    /// direction. With pose, as in scene files, the link is brought there. With relative_to, the
    /// pose is in the coordinates of another link
    #[arg(long, value_name = "LINK")]
    keep: Option<String>,
    /// Names of two bodies that have to touch at the witness: a leg and the ground, for
    /// example. Their distance is then at most 0.5 mm beyond the clearance. May be given several
    /// times
    #[arg(long, value_name = "BODY,BODY", value_parser = two_names)]
    touch: Vec<[String; 2]>,
    /// Weights of squared joint displacements in the metric, instead of the scene's; a model is
    /// then not used
    #[arg(long, value_name = "JOINT=W", value_delimiter = ',', value_parser = weight)]
    weights: Vec<(String, f64)>,
    /// Choose the exit nearest to this configuration, among exits about as near as the nearest one
    #[arg(long, value_name = "Q", allow_hyphen_values = true)]
    toward: Option<String>,
    /// With --toward: consider exits that are farther than the nearest one by at most this share of
    /// its depth
    #[arg(long, value_name = "SHARE", value_parser = share_or_more, allow_negative_numbers = true, default_value_t = 0.25, requires = "toward")]
    toward_share: f64,
    /// Prove a radius around the witness within which nothing touches
    #[arg(long)]
    free_radius: bool,
}

impl ConstraintArgs {
    /// Sets the options that need no scene. The goal is a placeholder until [`Self::set_in`].
    pub fn set(&self, options: &mut QueryOptions) {
        options.clearance = self.clearance;
        options.free_radius = self.free_radius;
        options.toward = self.toward.as_ref().map(|_| goal_to_come(self.toward_share));
    }

    /// Sets the options that need the scene: the joints that are named, and the goal.
    pub fn set_in(&self, scene: &Scene, options: &mut QueryOptions) -> anyhow::Result<()> {
        options.locked = scene.joints_named("--locked", self.locked.iter().map(String::as_str))?;
        if !self.free.is_empty() {
            let free = scene.joints_named("--free", self.free.iter().map(String::as_str))?;
            options.locked = (0..scene.joints().len()).filter(|joint| !free.contains(joint)).collect();
        }
        options.keep = kept_links(self.keep.as_deref(), scene)?;
        let named = |[a, b]: &[String; 2]| scene.pair_named("--touch", [a, b]);
        options.touch = self.touch.iter().map(named).collect::<extricate::Result<_>>()?;
        if let (Some(words), Some(toward)) = (&self.toward, &mut options.toward) {
            let goal = Configs::of_words(std::slice::from_ref(words)).next(scene)?;
            let goal = goal.and_then(Result::ok).map(|(_, goal)| goal);
            let expected =
                || format!("--toward: got {words}, expected {} numbers within the limits", scene.space().nq());
            toward.goal = goal.with_context(expected)?;
        }
        Ok(())
    }

    /// Applies the weights to the solver, if some were given.
    pub fn weighted(&self, solver: Solver) -> extricate::Result<Solver> {
        if self.weights.is_empty() {
            return Ok(solver);
        }
        solver.weighted(self.weights.iter().map(|(name, weight)| (name.as_str(), [*weight; 2])))
    }
}

fn weight(text: &str) -> Result<(String, f64), String> {
    let parts = text.rsplit_once('=').and_then(|(name, weight)| Some((name.to_string(), weight.parse().ok()?)));
    parts.ok_or_else(|| "expected JOINT=W, such as elbow=4".into())
}

/// Reads the names of two bodies.
fn two_names(text: &str) -> Result<[String; 2], String> {
    let names: Vec<&str> = text.split(',').map(str::trim).collect();
    match names[..] {
        [a, b] if !a.is_empty() && !b.is_empty() => Ok([a.into(), b.into()]),
        _ => Err("expected the names of two bodies, with a comma between".into()),
    }
}
