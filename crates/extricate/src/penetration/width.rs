//! How widely a refined query searches: as narrowly as its scene allows.

use serde::{Deserialize, Serialize};

/// How many exits a refined query starts from (under the object norm four more for each degree of freedom); what a scene needs is measured when it
/// is learned.
///
/// Ordered: what is wider takes more checks and misses fewer ways out. It tells queries apart that search in turn (under the `joint` metric, or
/// the object norm where exits are many enough) in the scene that was learned; others search as widely at every width.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Width {
    /// One exit for each degree of freedom, with raw meshes two: where nearly every descent ends at the nearest way out.
    Narrow,
    /// Two of them. Where measuring was interrupted, or nothing was measured under another metric than that of the joints.
    #[default]
    Usual,
    /// Four of them.
    Wide,
    /// Seven of them, given up by their planes only where the foot is three times as far as narrower queries allow; where the metric bends, ten, given up
    /// as usual. Where exits are too few to rely on, four times as many samples as the others start from.
    Widest,
}

/// Fewest.
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

    /// Most exits that a query starts from. Raw meshes have ways out that are short and narrow, as hulls have not; where the metric is smooth, the
    /// widest queries give fewer of them up by their planes, which finds more than twice as many exits would.
    pub(super) fn exits(self, degrees: usize, along_hulls: bool, is_smooth: bool) -> usize {
        let a_degree = match self {
            Self::Narrow if along_hulls => 1,
            Self::Narrow | Self::Usual => 2,
            Self::Wide => 4,
            Self::Widest if is_smooth => 7,
            Self::Widest => 10,
        };
        (a_degree * degrees).max(LEAST_EXITS)
    }

    /// Samples that it starts from for each that the narrowest does, where there are too few exits.
    pub(super) fn samples(self) -> usize {
        if self == Self::Widest { 4 } else { 1 }
    }
}
