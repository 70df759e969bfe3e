//! Directions along which one pair of bodies may part, and how far it has to move for each.

use crate::collision::{Contact, OverlappingPieces};
use crate::kinematics::Twists;
use crate::math::Vec3;
use crate::query::local_metric::LocalMetric;
use crate::scene::Scene;

/// Directions that a pair may choose.
#[derive(Default)]
pub struct PairDirections {
    /// Least displacement of the pair over all choices \[metric units\].
    pub least: f64,
    /// All choices; shortest first after [`PairDirections::sort`].
    pub all: Vec<PairDirection>,
    /// Constraint of each choice on displacements, row major.
    rows: Vec<f64>,
    lifted: Vec<f64>,
}

#[derive(Debug, Clone, Copy)]
pub struct PairDirection {
    /// Least displacement of the pair for this direction \[metric units\].
    length: f64,
    /// Overlap of the two along it, including the clearance \[m\].
    pub overlap: f64,
    row: usize,
}

/// Inputs that all measurements of choices share.
pub struct Measure<'a> {
    /// Unit directions that are measured besides the axes of the shapes.
    pub sphere: &'a [Vec3],
    pub scene: &'a Scene,
    /// Motion of the bodies at the configuration.
    pub twists: &'a Twists,
    pub local: &'a LocalMetric,
    /// Bounds of displacements; coordinates with equal bounds stay.
    pub limits: (&'a [f64], &'a [f64]),
    /// Distance that the shapes have to keep \[m\].
    pub distance: f64,
}

impl PairDirections {
    pub fn clear(&mut self) {
        self.least = 0.0;
        self.all.clear();
        self.rows.clear();
    }

    /// Measures the directions of a pair. Leaves none if the pair has to move no farther than
    /// `floor` for one of them, in particular if it is apart.
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
            self.all.push(PairDirection { length, overlap, row: self.rows.len() / nv - 1 });
            least = least.min(length);
        }
        self.least = least;
    }

    /// Adds the row of a contact. Returns how much distance a displacement of length 1 can gain.
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

    pub fn sort(&mut self) {
        self.all.sort_unstable_by(|a, b| a.length.total_cmp(&b.length).then(a.row.cmp(&b.row)));
    }

    /// Returns the constraint of a choice on displacements: `row . step >= overlap`.
    pub fn row(&self, choice: usize) -> &[f64] {
        let nv = self.rows.len() / self.all.len();
        &self.rows[self.all[choice].row * nv..][..nv]
    }
}
