//! A scene in words and as JSON: coordinates in order, bodies, checked pairs, warnings.

use std::fmt::Write;

use extricate::parts::{MeshCount, SceneJoint};
use extricate::{Manifold, PairId, Scene};
use serde::Serialize;

use crate::commands::disable_line;
use crate::report::{count, counted, fixed, metric_unit, percent, what_a_unit_is};

/// Largest number of links that are named with their triangles.
const MAX_LINKS: usize = 3;

/// The scene's description that `info` prints.
#[derive(Serialize)]
pub struct SceneInfo<'a> {
    clearance: f64,
    metric: &'static str,
    #[serde(skip)]
    unit: &'static str,
    #[serde(skip)]
    what_a_unit_is: Option<String>,
    coordinates: usize,
    degrees_of_freedom: usize,
    joints: Vec<JointInfo<'a>>,
    bodies: Vec<BodyInfo<'a>>,
    meshes: Vec<MeshInfo<'a>>,
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

/// A link whose meshes are checked as they are, not by their hulls.
#[derive(Serialize)]
struct MeshInfo<'a> {
    link: &'a str,
    triangles: usize,
    /// Number of triangles of the convex hulls of the same meshes.
    hull_triangles: usize,
}

/// Pairs that collide in all or nearly all sampled configurations.
#[derive(Serialize)]
pub struct OftenColliding<'a> {
    always_colliding: AlwaysColliding<'a>,
    nearly_always_colliding: Vec<NearlyAlways<'a>>,
    #[serde(skip)]
    least: f64,
}

/// Pairs that collide in every sampled configuration.
#[derive(Serialize)]
struct AlwaysColliding<'a> {
    samples: u64,
    pairs: Vec<[&'a str; 2]>,
    /// Line for the table `[pairs]` of the scene file.
    #[serde(skip_serializing_if = "Option::is_none")]
    disable: Option<String>,
}

/// A pair that collides in most of the same configurations.
#[derive(Serialize)]
struct NearlyAlways<'a> {
    pair: [&'a str; 2],
    /// Share of the sampled configurations in which it collides.
    share: f64,
}

impl<'a> SceneInfo<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        let body = |body: &'a extricate::geometry::Body| BodyInfo {
            name: &body.name,
            obstacle: body.robot.is_none(),
            moves: body.frame != 0,
            parts: body.parts.len(),
        };
        let mesh = |mesh: MeshCount| MeshInfo {
            link: &scene.bodies()[mesh.body].name,
            triangles: mesh.triangles,
            hull_triangles: mesh.hull_triangles,
        };
        Self {
            clearance: scene.clearance(),
            metric: scene.metric().name(),
            unit: metric_unit(scene),
            what_a_unit_is: what_a_unit_is(scene, "`weights` of the metric"),
            coordinates: scene.space().nq(),
            degrees_of_freedom: scene.space().nv(),
            joints: scene.joints().iter().map(|joint| joint_info(scene, joint)).collect(),
            bodies: scene.bodies().iter().map(body).collect(),
            meshes: scene.mesh_counts().into_iter().map(mesh).collect(),
            pair_count: scene.pairs().len(),
            pairs: (0..scene.pairs().len()).map(|pair| scene.pair_names(PairId::new(pair))).collect(),
            warnings: scene.warnings(),
        }
    }

    pub fn metric_unit(&self) -> &'static str {
        self.unit
    }

    /// Describes the scene for people. Pairs are many and listed only on request.
    pub fn text(&self, list_pairs: bool) -> String {
        let obstacles = self.bodies.iter().filter(|b| b.obstacle).count();
        let mut text = String::new();
        let mut line = |content: String| writeln!(text, "{content}").expect("writing to a string");
        line(format!("  clearance   {} m", self.clearance));
        let unit = self.what_a_unit_is.as_ref().map_or(String::new(), |told| format!(": {told}"));
        line(format!("  metric      {} [{}]{unit}", self.metric, self.unit));
        let links = counted(self.bodies.len() - obstacles, "robot link", "robot links");
        line(format!("  bodies      {links}, {}", counted(obstacles, "obstacle", "obstacles")));
        if !self.meshes.is_empty() {
            line(format!("  meshes      {}", MeshInfo::text(&self.meshes)));
        }
        line(format!("  pairs       {} checked", self.pair_count));
        let coordinates = counted(self.coordinates, "coordinate", "coordinates");
        let freedoms = counted(self.degrees_of_freedom, "degree of freedom", "degrees of freedom");
        line(format!("joints ({coordinates}, {freedoms}):"));
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
            Some([lower, upper]) => format!("[{}, {}]", fixed(lower, 5), fixed(upper, 5)),
            None => self.manifold.into(),
        }
    }
}

fn joint_info<'a>(scene: &'a Scene, joint: &'a SceneJoint) -> JointInfo<'a> {
    let factors = scene.space().factors().iter().filter(|factor| joint.q.contains(&factor.q));
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

impl MeshInfo<'_> {
    /// Describes all meshes in one line.
    fn text(meshes: &[Self]) -> String {
        let sum = |of: fn(&Self) -> usize| count(meshes.iter().map(of).sum());
        let shown = |mesh: &Self| format!("{} in {}", count(mesh.triangles), mesh.link);
        let mut links: Vec<String> = meshes.iter().take(MAX_LINKS).map(shown).collect();
        if meshes.len() > MAX_LINKS {
            links.push(format!("and {}", counted(meshes.len() - MAX_LINKS, "more link", "more links")));
        }
        let (all, hulls) = (sum(|mesh| mesh.triangles), sum(|mesh| mesh.hull_triangles));
        let taken = format!("{all} triangles, taken as they are ({})", links.join(", "));
        if all == hulls {
            return format!("{taken}, as many as their convex hulls have");
        }
        format!(
            "{taken}; their convex hulls have {hulls} and are checked faster: `geometry = \"convex-hull\"`, or `links` for \
             some, in the scene file"
        )
    }
}

impl<'a> OftenColliding<'a> {
    /// Sorts the pairs `found`, each with the number of `samples` configurations in which it
    /// collides: a share of `least` or more.
    pub fn new(samples: u64, least: f64, found: impl Iterator<Item = ([&'a str; 2], u64)>) -> Self {
        let (always, nearly): (Vec<_>, Vec<_>) = found.partition(|(_, count)| *count == samples);
        let pairs: Vec<[&str; 2]> = always.into_iter().map(|(pair, _)| pair).collect();
        let disable = (!pairs.is_empty()).then(|| disable_line(&pairs));
        let share = |count: u64| count as f64 / samples as f64;
        let nearly = nearly.into_iter().map(|(pair, count)| NearlyAlways { pair, share: share(count) });
        Self {
            always_colliding: AlwaysColliding { samples, pairs, disable },
            nearly_always_colliding: nearly.collect(),
            least,
        }
    }

    /// Describes the pairs for people, with the line to add to the scene file.
    pub fn text(&self) -> String {
        let Self { always_colliding: always, nearly_always_colliding: nearly, least } = self;
        let samples = count(always.samples as usize);
        let mut text = String::new();
        match &always.disable {
            None if nearly.is_empty() => {
                return format!("no pair collides in {} or more of {samples} sampled configurations", percent(*least));
            }
            None => {}
            Some(disable) => {
                text += &format!("pairs that collide in all of {samples} sampled configurations:\n");
                always.pairs.iter().for_each(|[a, b]| text += &format!("  {a} - {b}\n"));
                text += &format!("if they overlap by design, add to the scene file under [pairs]:\n  {disable}\n");
            }
        }
        if !nearly.is_empty() {
            text += &format!("pairs that collide in nearly all of {samples} sampled configurations:\n");
            nearly.iter().for_each(|NearlyAlways { pair: [a, b], share }| {
                text += &format!("  {a} - {b}: {}\n", percent(*share));
            });
            text += "if they overlap by design, they belong under `disable` too\n";
        }
        text.truncate(text.trim_end().len());
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use extricate::entries::{assemble_scene, parse};

    /// Two links with revolute joints in front of a wall.
    fn small_scene() -> Scene {
        let link = |name: &str| {
            format!(
                "<link name='{name}'><collision><geometry><box size='0.3 0.05 0.05'/></geometry></collision></link>"
            )
        };
        let urdf = format!(
            "<robot name='r'><link name='base'/>{}{}\
             <joint name='shoulder' type='revolute'><parent link='base'/><child link='upper'/><axis xyz='0 0 1'/>\
             <limit lower='-3' upper='3' effort='1' velocity='1'/></joint>\
             <joint name='elbow' type='continuous'><origin xyz='0.4 0 0'/><parent link='upper'/><child link='fore'/>\
             <axis xyz='0 1 0'/></joint></robot>",
            link("upper"),
            link("fore")
        );
        let wall = "metric = { kind = 'joint' }\n[[robot]]\nurdf = 'r'\n[[obstacle]]\nname = 'wall'\nshape = { box = [0.04, 0.8, 0.6] }\n\
                    pose = { xyz = [0.9, 0, 0.3] }\n";
        assemble_scene("s", &parse("s", wall).unwrap(), &[("r".into(), urdf)]).unwrap()
    }

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
        let of = |found: &[([&'static str; 2], u64)]| OftenColliding::new(1000, 0.95, found.iter().copied());
        let none = of(&[]);
        assert_eq!(none.text(), "no pair collides in 95 % or more of 1,000 sampled configurations");
        assert!(!serde_json::to_string(&none).unwrap().contains("disable"));
        let some = of(&[(["palm", "tip"], 1000)]);
        assert!(some.text().ends_with("disable = [[\"palm\", \"tip\"]]"));
        let nearly = of(&[(["palm", "tip"], 973)]);
        assert_eq!(
            nearly.text(),
            "pairs that collide in nearly all of 1,000 sampled configurations:\n  palm - tip: 97.3 %\n\
             if they overlap by design, they belong under `disable` too"
        );
        let json = serde_json::to_value(&nearly).unwrap();
        assert_eq!(json["nearly_always_colliding"], serde_json::json!([{ "pair": ["palm", "tip"], "share": 0.973 }]));
        assert_eq!(json["always_colliding"]["pairs"], serde_json::json!([]));
    }

    #[test]
    fn what_hulls_would_save_is_told() {
        let mesh = |link, triangles| MeshInfo { link, triangles, hull_triangles: 100 };
        let text = MeshInfo::text(&[mesh("link3", 52920), mesh("link4", 7000), mesh("a", 30), mesh("b", 20)]);
        assert!(
            text.starts_with(
                "59,970 triangles, taken as they are (52,920 in link3, 7,000 in link4, 30 in a, and 1 more link); their \
                 convex hulls have 400 and"
            ),
            "{text}"
        );
        let convex = MeshInfo::text(&[mesh("link3", 100)]);
        assert_eq!(convex, "100 triangles, taken as they are (100 in link3), as many as their convex hulls have");
    }
}
