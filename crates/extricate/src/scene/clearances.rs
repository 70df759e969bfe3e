//! How far pairs of bodies stay apart: [`crate::Scene::clearance`], and exceptions from it. No
//! distances.

use std::fmt;

use serde::de::{MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize};

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

/// Exceptions from [`crate::Scene::clearance`], by names of bodies: pairs that come later follow
/// them too.
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
}
