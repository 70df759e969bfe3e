//! Exceptions from [`crate::Scene::clearance`], and clearances as scene files write them.

use std::fmt;

use serde::de::{MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize};

/// Clearance of scenes that give none \[m\].
pub const CLEARANCE: f64 = 1e-4;

/// `clearance = 1e-4`, or `clearance = { world = 0.02, self = 1e-4 }`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClearanceEntry {
    /// One clearance for every pair \[m\].
    Uniform(f64),
    /// One clearance for pairs with an obstacle, another for all other pairs.
    Split(SplitClearance),
}

/// `{ world = .., self = .. }`; each is [`CLEARANCE`] if absent.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SplitClearance {
    /// Clearance of pairs with an obstacle \[m\].
    pub world: Option<f64>,
    /// Clearance of pairs of links and attached objects \[m\].
    #[serde(rename = "self")]
    pub own: Option<f64>,
}

impl Default for ClearanceEntry {
    fn default() -> Self {
        Self::Uniform(CLEARANCE)
    }
}

impl ClearanceEntry {
    /// Returns the scene's clearance, and for a table that of pairs without an obstacle \[m\].
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

/// Exceptions from [`crate::Scene::clearance`]. They name bodies, so that they hold for pairs that
/// are added later, too.
///
/// A scene can keep the world far away and still let the robot's own links come near each other:
/// `own` and `pairs` replace the clearance, `padding` adds to it toward obstacles.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Clearances {
    /// Clearance of pairs without an obstacle \[m\]; `None` stands for that of the scene.
    pub own: Option<f64>,
    /// Clearance of a pair by the names of its bodies \[m\]; it overrides all others and padding.
    pub pairs: Vec<([String; 2], f64)>,
    /// Length \[m\], at least 0, that a body adds to the clearance of its pairs with obstacles, or
    /// an obstacle to that of all its pairs.
    pub padding: Vec<(String, f64)>,
}

/// Clearance of one pair, relative to that of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairClearance {
    /// Clearance that replaces the scene's \[m\].
    pub own: Option<f64>,
    /// Length added to the scene's clearance \[m\], without effect if `own` is given.
    pub padding: f64,
}

impl PairClearance {
    /// Returns the pair's clearance \[m\] in a scene with the clearance `base`.
    pub fn over(&self, base: f64) -> f64 {
        self.own.unwrap_or(base + self.padding)
    }
}

impl Clearances {
    /// Returns whether there are no exceptions.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
