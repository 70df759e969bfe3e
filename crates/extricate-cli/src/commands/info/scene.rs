//! A scene in words and as JSON: coordinates in order, bodies, checked pairs, warnings.

use std::fmt::Write;

use extricate::internals::scene::SceneJoint;
use extricate::{Manifold, PairId, Scene};
use serde::Serialize;

use crate::commands::disable_line;
use crate::report::metric_unit;

/// What `info` says of a scene.
#[derive(Serialize)]
pub struct SceneInfo<'a> {
    clearance: f64,
    metric: &'static str,
    #[serde(skip)]
    unit: &'static str,
    coordinates: usize,
    degrees_of_freedom: usize,
    joints: Vec<JointInfo<'a>>,
    bodies: Vec<BodyInfo<'a>>,
    pair_count: usize,
    pairs: Vec<[&'a str; 2]>,
    warnings: &'a [String],
}

#[derive(Serialize)]
struct JointInfo<'a> {
    name: &'a str,
    kind: &'a str,
    /// Indices into a configuration.
    coordinates: Vec<usize>,
    factors: Vec<FactorInfo<'a>>,
}

/// One manifold of a joint: a planar joint has three, a floating one four.
#[derive(Serialize)]
struct FactorInfo<'a> {
    name: &'a str,
    manifold: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    limits: Option<[f64; 2]>,
    weight: f64,
}

#[derive(Serialize)]
struct BodyInfo<'a> {
    name: &'a str,
    obstacle: bool,
    moves: bool,
    parts: usize,
}

/// Pairs that collide wherever one looks.
#[derive(Serialize)]
pub struct AlwaysColliding<'a> {
    samples: u64,
    pairs: Vec<[&'a str; 2]>,
    /// The line to add to the scene file, under `[pairs]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    disable: Option<String>,
}

impl<'a> SceneInfo<'a> {
    /// Reads it off the scene.
    pub fn new(scene: &'a Scene) -> Self {
        let body = |body: &'a extricate::geometry::Body| BodyInfo {
            name: &body.name,
            obstacle: body.robot.is_none(),
            moves: body.frame != 0,
            parts: body.parts.len(),
        };
        Self {
            clearance: scene.clearance,
            metric: scene.metric.name(),
            unit: metric_unit(scene),
            coordinates: scene.space.nq(),
            degrees_of_freedom: scene.space.nv(),
            joints: scene.joints.iter().map(|joint| joint_info(scene, joint)).collect(),
            bodies: scene.bodies.iter().map(body).collect(),
            pair_count: scene.pairs.len(),
            pairs: (0..scene.pairs.len()).map(|pair| scene.pair_names(PairId::new(pair))).collect(),
            warnings: &scene.warnings,
        }
    }

    /// What the scene's metric is measured in.
    pub fn metric_unit(&self) -> &'static str {
        self.unit
    }

    /// For people; the pairs are many and listed only on request.
    pub fn text(&self, list_pairs: bool) -> String {
        let obstacles = self.bodies.iter().filter(|b| b.obstacle).count();
        let mut text = String::new();
        let mut line = |content: String| writeln!(text, "{content}").expect("writing to a string");
        line(format!("  clearance   {} m", self.clearance));
        line(format!("  metric      {} [{}]", self.metric, self.unit));
        line(format!("  bodies      {} robot links, {obstacles} obstacles", self.bodies.len() - obstacles));
        line(format!("  pairs       {} checked", self.pair_count));
        line(format!("joints ({} coordinates, {} degrees of freedom):", self.coordinates, self.degrees_of_freedom));
        let width = self.joints.iter().map(|j| j.name.chars().count()).max().unwrap_or(0);
        for joint in &self.joints {
            let range = match joint.coordinates[..] {
                [only] => only.to_string(),
                [first, .., last] => format!("{first}-{last}"),
                [] => "-".into(),
            };
            let spans = joint.factors.iter().map(FactorInfo::text).collect::<Vec<_>>().join(", ");
            line(format!("  {range:>5}  {:<width$}  {:<10}  {spans}", joint.name, joint.kind));
        }
        if list_pairs {
            line("checked pairs:".into());
            for [first, second] in &self.pairs {
                line(format!("  {first} - {second}"));
            }
        }
        if !self.warnings.is_empty() {
            line("warnings:".into());
            for warning in self.warnings {
                line(format!("  {warning}"));
            }
        }
        text.truncate(text.trim_end().len());
        text
    }
}

impl FactorInfo<'_> {
    fn text(&self) -> String {
        match self.limits {
            Some([lower, upper]) => format!("[{lower:.5}, {upper:.5}]"),
            None => self.manifold.into(),
        }
    }
}

fn joint_info<'a>(scene: &'a Scene, joint: &'a SceneJoint) -> JointInfo<'a> {
    let factors = scene.space.factors().iter().filter(|factor| joint.q.contains(&factor.q));
    let factors = factors.map(|factor| {
        let (manifold, limits) = match factor.manifold {
            Manifold::Interval { lower, upper } => ("interval", Some([lower, upper])),
            Manifold::Circle => ("circle", None),
            Manifold::Rotation => ("rotation (quaternion x, y, z, w)", None),
        };
        FactorInfo { name: &factor.name, manifold, limits, weight: factor.weight }
    });
    JointInfo {
        name: &joint.name,
        kind: &joint.kind,
        coordinates: joint.q.clone().collect(),
        factors: factors.collect(),
    }
}

impl<'a> AlwaysColliding<'a> {
    /// `pairs` collided in each of `samples` configurations.
    pub fn new(samples: u64, pairs: Vec<[&'a str; 2]>) -> Self {
        let disable = (!pairs.is_empty()).then(|| disable_line(&pairs));
        Self { samples, pairs, disable }
    }

    /// For people, with the line to add.
    pub fn text(&self) -> String {
        let Some(disable) = &self.disable else {
            return format!("no pair collides in all of {} sampled configurations", self.samples);
        };
        let mut text = format!("pairs that collide in all of {} sampled configurations:\n", self.samples);
        for [first, second] in &self.pairs {
            text += &format!("  {first} - {second}\n");
        }
        text + &format!("if they overlap by design, add to the scene file under [pairs]:\n  {disable}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::tests::small_scene;

    #[test]
    fn a_scene_is_described_in_order() {
        let scene = small_scene();
        let text = SceneInfo::new(&scene).text(true);
        assert!(text.contains("metric      joint [rad]"), "{text}");
        assert!(text.contains("    0  shoulder  revolute    [-3.00000, 3.00000]"), "{text}");
        assert!(text.contains("    1  elbow     continuous  circle"), "{text}");
        assert!(text.contains("  upper - wall"), "{text}");
        let json = serde_json::to_value(SceneInfo::new(&scene)).unwrap();
        assert_eq!(json["joints"][1]["coordinates"], serde_json::json!([1]));
        assert_eq!(json["joints"][0]["factors"][0]["limits"], serde_json::json!([-3.0, 3.0]));
        assert_eq!(json["pair_count"], 2);
    }

    #[test]
    fn pairs_that_always_collide_come_with_the_line_to_add() {
        let none = AlwaysColliding::new(500, vec![]);
        assert!(none.text().starts_with("no pair"));
        assert!(!serde_json::to_string(&none).unwrap().contains("disable"));
        let some = AlwaysColliding::new(500, vec![["palm", "tip"]]);
        assert!(some.text().ends_with("disable = [[\"palm\", \"tip\"]]"));
    }
}
