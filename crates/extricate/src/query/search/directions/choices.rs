//! Along which directions one pair of bodies may part, and how far it has to move for each.

use crate::collision::{Contact, OverlappingPieces};
use crate::kinematics::Twists;
use crate::math::Vec3;
use crate::query::local_metric::LocalMetric;
use crate::scene::Scene;

/// The directions that a pair may choose.
#[derive(Default)]
pub struct Choices {
    /// How far \[metric units\] it has to move at least, whichever it chooses.
    pub least: f64,
    /// Every choice; shortest first once they are sorted.
    pub all: Vec<Choice>,
    /// What they ask of a displacement, a row each.
    rows: Vec<f64>,
    lifted: Vec<f64>,
}

/// One direction.
#[derive(Debug, Clone, Copy)]
pub struct Choice {
    /// How far \[metric units\] the pair has to move.
    length: f64,
    /// How far the two overlap along it, the clearance included \[m\].
    pub overlap: f64,
    row: usize,
}

/// What choices are measured in.
pub struct Measure<'a> {
    /// The directions.
    pub sphere: &'a [Vec3],
    /// What moves.
    pub scene: &'a Scene,
    /// How it moves at the configuration.
    pub twists: &'a Twists,
    /// How far a displacement is.
    pub local: &'a LocalMetric,
    /// Within which displacements are; coordinates whose limits are the same stay.
    pub limits: (&'a [f64], &'a [f64]),
    /// How far apart the shapes have to be \[m\].
    pub distance: f64,
}

impl Choices {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.least = 0.0;
        self.all.clear();
        self.rows.clear();
    }

    /// Measures the directions of a pair; none where it is apart, or has to move no farther than
    /// `floor` for one of them.
    pub fn set(&mut self, pair: &OverlappingPieces, by: &Measure, floor: f64) {
        self.clear();
        let nv = by.limits.0.len();
        let mut least = f64::INFINITY;
        for direction in pair.axes().chain(by.sphere.iter().copied()) {
            let contact = pair.across(&direction);
            let overlap = by.distance - contact.distance;
            let length = overlap / self.push(&contact, by).max(f64::MIN_POSITIVE);
            if length <= floor {
                return self.clear();
            }
            self.all.push(Choice { length, overlap, row: self.rows.len() / nv - 1 });
            least = least.min(length);
        }
        self.least = least;
    }

    /// Adds the row of a contact; how much a displacement of length 1 can give.
    fn push(&mut self, contact: &Contact, by: &Measure) -> f64 {
        let (low, high) = by.limits;
        let at = self.rows.len();
        self.rows.resize(at + low.len(), 0.0);
        contact.add_gradient(by.scene, by.twists, &mut self.rows[at..]);
        (0..low.len()).filter(|v| low[*v] == high[*v]).for_each(|v| self.rows[at + v] = 0.0);
        self.lifted.clear();
        self.lifted.extend_from_slice(&self.rows[at..]);
        by.local.slope(&mut self.lifted)
    }

    /// Brings the shortest first.
    pub fn sort(&mut self) {
        self.all.sort_unstable_by(|a, b| a.length.total_cmp(&b.length).then(a.row.cmp(&b.row)));
    }

    /// What a choice asks of displacements: `row . step >= overlap`.
    pub fn row(&self, choice: usize) -> &[f64] {
        let nv = self.rows.len() / self.all.len();
        &self.rows[self.all[choice].row * nv..][..nv]
    }
}
