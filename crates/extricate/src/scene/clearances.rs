//! How far pairs of bodies stay apart: [`Scene::clearance`], and exceptions from it. No distances.

use std::fmt;

use serde::de::{MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize};

use super::Scene;
use super::file::SceneFile;
use crate::error::Result;

/// The clearance of scenes that name none \[m\].
pub const CLEARANCE: f64 = 1e-4;

/// `clearance = 1e-4`, or `clearance = { world = 0.02, self = 1e-4 }`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClearanceEntry {
    /// Of every pair \[m\].
    Uniform(f64),
    /// Of pairs with an obstacle, and of others.
    Split(SplitClearance),
}

/// `{ world = .., self = .. }`; each is [`CLEARANCE`] where absent.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SplitClearance {
    /// Of pairs with an obstacle \[m\].
    pub world: Option<f64>,
    /// Of pairs of links and of what they hold \[m\].
    #[serde(rename = "self")]
    pub own: Option<f64>,
}

impl Default for ClearanceEntry {
    fn default() -> Self {
        Self::Uniform(CLEARANCE)
    }
}

impl ClearanceEntry {
    /// That of the scene, and that of pairs without an obstacle where it is another \[m\].
    pub fn lengths(&self) -> (f64, Option<f64>) {
        match *self {
            Self::Uniform(length) => (length, None),
            Self::Split(SplitClearance { world, own }) => (world.unwrap_or(CLEARANCE), own.or(Some(CLEARANCE))),
        }
    }
}

impl<'de> Deserialize<'de> for ClearanceEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = ClearanceEntry;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number, or a table `{ world = .., self = .. }`")
            }

            fn visit_f64<E>(self, length: f64) -> std::result::Result<ClearanceEntry, E> {
                Ok(ClearanceEntry::Uniform(length))
            }

            fn visit_i64<E>(self, length: i64) -> std::result::Result<ClearanceEntry, E> {
                Ok(ClearanceEntry::Uniform(length as f64))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> std::result::Result<ClearanceEntry, A::Error> {
                SplitClearance::deserialize(MapAccessDeserializer::new(map)).map(ClearanceEntry::Split)
            }
        }
        deserializer.deserialize_any(Either)
    }
}

/// Exceptions from [`Scene::clearance`], by names of bodies: pairs that come later follow them too.
///
/// The world can be kept far away and the robot's own links be let near each other: `own` and
/// `pairs` say what those keep, `padding` what is added toward obstacles.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Clearances {
    /// Of pairs of which neither body is an obstacle \[m\]; `None` for that of the scene.
    pub own: Option<f64>,
    /// Of a pair of names, whatever else is said \[m\].
    pub pairs: Vec<([String; 2], f64)>,
    /// What a body adds to the clearance of its pairs with obstacles, or an obstacle to that of all
    /// its pairs \[m\], at least 0.
    pub padding: Vec<(String, f64)>,
}

/// What a pair keeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairClearance {
    /// Where it is not the scene's \[m\].
    pub own: Option<f64>,
    /// Added to the scene's \[m\].
    pub padding: f64,
}

impl PairClearance {
    /// Least distance \[m\] where that of the scene is `base`.
    pub fn over(&self, base: f64) -> f64 {
        self.own.unwrap_or(base + self.padding)
    }
}

impl Clearances {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Those that a scene file asks for; `body` finds the name of a body as the scene has it by an
    /// element of a message and a name as the file has it, `None` for what has no geometry.
    pub fn of_file(entry: &SceneFile, body: &dyn Fn(String, &str) -> Result<Option<String>>) -> Result<Self> {
        let mut all = Self { own: entry.clearance.unwrap_or_default().lengths().1, ..Self::default() };
        for (a, b, length) in &entry.pairs.clearance {
            let find = |name| body(format!("pairs: clearance [{a:?}, {b:?}]"), name);
            if let (Some(a), Some(b)) = (find(a)?, find(b)?) {
                all.pairs.push(([a, b], *length));
            }
        }
        for (name, added) in &entry.padding {
            all.padding.extend(body("padding".into(), name)?.map(|name| (name, *added)));
        }
        Ok(all)
    }

    /// What every checked pair of `scene` keeps, in order.
    pub fn of_pairs(&self, scene: &Scene) -> Vec<PairClearance> {
        let named = |name: &str| scene.bodies.iter().position(|body| body.name == name);
        let mut padding = vec![0.0; scene.bodies.len()];
        for (name, added) in &self.padding {
            named(name).into_iter().for_each(|body| padding[body] += added);
        }
        let of_pair = |pair: &super::BodyPair| {
            let is_of_world = [pair.first, pair.second].iter().any(|body| scene.bodies[*body].is_obstacle());
            if is_of_world {
                return PairClearance { own: None, padding: padding[pair.first] + padding[pair.second] };
            }
            PairClearance { own: self.own, padding: 0.0 }
        };
        let mut all: Vec<PairClearance> = scene.pairs.iter().map(of_pair).collect();
        for ([a, b], clearance) in &self.pairs {
            let (Some(a), Some(b)) = (named(a), named(b)) else { continue };
            let pair = super::BodyPair { first: a.min(b), second: a.max(b) };
            if let Ok(at) = scene.pairs.binary_search(&pair) {
                all[at] = PairClearance { own: Some(*clearance), padding: 0.0 };
            }
        }
        all
    }
}
