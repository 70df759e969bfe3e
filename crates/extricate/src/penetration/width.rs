//! How widely a refined query searches: as narrowly as its scene allows.

use serde::{Deserialize, Serialize};

use super::plan::EXITS;

/// How many exits and samples a refined query starts from, and how early it gives one up; what a scene needs is measured when it is learned.
///
/// Ordered: what is wider takes more checks and misses fewer ways out. It tells queries apart that search under the `joint` metric in the
/// scene that was learned; others search as widely at every width.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Width {
    /// One exit for each degree of freedom, given up as soon as its planes do not promise much: where nearly every descent ends at the nearest way
    /// out.
    Narrow,
    /// Two of them, given up by their planes only where those put them far off. Where nothing was measured.
    #[default]
    Usual,
    /// The same, and first steps may lead far off: where obstacles have edges that ways out lead around.
    Wide,
    /// Such descents from forty exits and, where there are many of them, four times as many samples.
    Widest,
}

/// Fewest, along hulls.
const LEAST_EXITS: usize = 4;

impl Width {
    /// All of them, narrowest first.
    pub const ALL: [Self; 4] = [Self::Narrow, Self::Usual, Self::Wide, Self::Widest];

    /// As the command line and files name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Narrow => "narrow",
            Self::Usual => "usual",
            Self::Wide => "wide",
            Self::Widest => "widest",
        }
    }

    /// Most exits that a query starts from. Hulls have no way out that is short and narrow, as raw meshes have.
    pub(super) fn exits(self, degrees: usize, along_hulls: bool) -> usize {
        match self {
            Self::Narrow if along_hulls => degrees.clamp(LEAST_EXITS, EXITS),
            Self::Usual | Self::Wide if along_hulls => (2 * degrees).clamp(LEAST_EXITS, EXITS),
            Self::Narrow | Self::Usual | Self::Wide => EXITS,
            Self::Widest => 2 * EXITS,
        }
    }

    /// Samples that it starts from besides, for each that the narrowest does where there are many exits.
    pub(super) fn samples(self) -> usize {
        match self {
            Self::Narrow | Self::Usual | Self::Wide => 1,
            Self::Widest => 4,
        }
    }
}
