//! Compares the checker with brute force, for ordinary and awkward meshes in poses at random and
//! next to the margin.

pub mod brute_force_meshes;
pub mod drawn_poses;
pub mod meshes;

use extricate::geometry::TriangleMesh;
use extricate::internals::collision::PairScratch;
use extricate::internals::math::Vec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde_json::json;

use drawn_poses::{Approach, Body};
use meshes::{bumpy, hollow, joined, opened, sheet, single, slab, soup, torus};

/// Distance from the margin \[m\] within which either answer is accepted, for bodies up to 1 m;
/// larger bodies round in proportion.
pub const TOLERANCE_M: f64 = 1e-9;

/// Counts of compared poses.
#[derive(Debug, Clone, Default)]
pub struct Report {
    pub poses: usize,
    /// Poses nearer than the margin or contained, by brute force.
    pub near: usize,
    /// Poses within a micrometre of the margin.
    pub tight: usize,
    /// Poses with one body inside the other, surfaces apart.
    pub contained: usize,
    /// Poses within the tolerance of the margin, which are not judged.
    pub undecided: usize,
    /// Poses for which the checker contradicts brute force.
    pub disagreements: usize,
    /// The first ten disagreements in words.
    pub examples: Vec<String>,
}

impl Report {
    pub fn json(&self) -> String {
        json!({
            "poses": self.poses, "near": self.near, "within_1e-6": self.tight, "contained": self.contained,
            "undecided": self.undecided, "disagreements": self.disagreements, "examples": self.examples,
        })
        .to_string()
    }

    fn add(mut self, other: Self) -> Self {
        self.poses += other.poses;
        self.near += other.near;
        self.tight += other.tight;
        self.contained += other.contained;
        self.undecided += other.undecided;
        self.disagreements += other.disagreements;
        self.examples.extend(other.examples);
        self.examples.truncate(10);
        self
    }
}

/// Poses that one pair of bodies is compared in.
const POSES_PER_CASE: usize = 50;

/// Compares `poses` poses, rounded up to a multiple of 50; the same seed gives the same poses.
pub fn run(poses: usize, seed: u64) -> Report {
    let bodies = bodies();
    let cases = poses.div_ceil(POSES_PER_CASE);
    (0..cases).into_par_iter().map(|k| case(&bodies, k, seed)).reduce(Report::default, Report::add)
}

/// Ordinary meshes, thin sheets, grids of coplanar triangles, a single triangle, degenerate
/// triangles, nested and open parts.
fn bodies() -> Vec<(&'static str, TriangleMesh)> {
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    let scaled = |mesh: &TriangleMesh, s: f64| mesh.scaled([s; 3]);
    let ball = bumpy(2, 0.7);
    vec![
        ("ball", bumpy(3, 0.0)),
        ("torus", torus(0.7, 0.25, 24, 12)),
        ("open ball", opened(&bumpy(3, 1.0), 60)),
        ("sheet", sheet(8)),
        ("thin slab", slab(Vec3::new(0.8, 0.5, 1e-5), 5)),
        ("cube of grids", slab(Vec3::new(0.5, 0.5, 0.5), 4)),
        ("triangle", single()),
        ("soup of slivers", soup(120, &mut rng)),
        (
            "shells in a shell",
            joined(&[scaled(&bumpy(3, 2.0), 2.5), scaled(&ball, 0.4), opened(&scaled(&ball, 0.9), 9)]),
        ),
        ("hollow ball", hollow(&scaled(&bumpy(3, 0.0), 1.6), scaled(&bumpy(2, 0.5), 1.0))),
    ]
}

fn case(bodies: &[(&str, TriangleMesh)], index: usize, seed: u64) -> Report {
    let mut rng = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(index as u64));
    let ((name_a, a), (name_b, b)) = (&bodies[index % bodies.len()], &bodies[index / bodies.len() % bodies.len()]);
    // Sizes range from a tenth of a millimetre to a hundred metres, alike or not; most are
    // unscaled.
    let scale = [1.0, 1.0, 1.0, 1e-4, 100.0][rng.random_range(0..5)];
    let ratio = [1.0, 1.0, 1.0, 0.05, 20.0][rng.random_range(0..5)];
    let (a, b) = (Body::new(a.scaled([scale; 3])), Body::new(b.scaled([scale * ratio; 3])));
    let size = a.ball.1.max(b.ball.1);
    let margin = [0.0, 1e-6, 1e-4, 1e-2 * size][rng.random_range(0..4)];
    let tolerance = TOLERANCE_M * size.max(1.0);
    // Flat bodies are also aligned with the axes, so that faces are coplanar.
    let aligned = rng.random_range(0..4) == 0;
    let mut scratch = PairScratch::default();
    let mut report = Report::default();
    while report.poses < POSES_PER_CASE {
        let mut approach = Approach::random(&a, &b, &mut rng);
        if aligned {
            approach.align(rng.random_range(0..3));
        }
        let mut way = rng.random::<f64>() * (a.ball.1 + b.ball.1);
        if rng.random_range(0..3) > 0
            && let Some(edge) = approach.last_contact(&a, &b, margin, 0.1 * TOLERANCE_M, &mut scratch)
        {
            // Move between twice the tolerance and a millimetre to either side of the contact.
            let off = 2.0 * tolerance * 10f64.powf(rng.random::<f64>() * 5.7);
            way = edge + if rng.random() { off } else { -off };
        }
        let pose = approach.at(way);
        let ours = a.is_nearer(&b, &pose, margin, &mut scratch);
        let truth = brute_force_meshes::truth(
            &a.mesh,
            &b.mesh,
            &pose,
            [margin - tolerance, margin + 1e-6 + 2.0 * tolerance],
            tolerance,
        );
        report.poses += 1;
        report.contained += usize::from(truth.contained && truth.distance > margin + tolerance);
        report.tight += usize::from((truth.distance - margin).abs() < 1e-6);
        let expected = expected(&truth, margin, tolerance);
        match expected {
            None => report.undecided += 1,
            Some(near) => report.near += usize::from(near),
        }
        if expected.is_some_and(|near| near != ours) {
            report.disagreements += 1;
            report.examples.push(format!(
                "{name_a} x {scale}, {name_b} x {}, margin {margin}, case {index}: we say {ours}, {truth:?}",
                scale * ratio
            ));
        }
    }
    report
}

/// Whether the pair is nearer than the margin; `None` if the tolerance leaves it open.
pub fn expected(truth: &brute_force_meshes::Truth, margin: f64, tolerance: f64) -> Option<bool> {
    let near = truth.crosses_clearly || truth.distance < margin - tolerance;
    let far = truth.distance > margin + tolerance;
    if near || (far && truth.contained) { Some(true) } else { far.then_some(false) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_answer_differs_from_brute_force() {
        let report = run(8_100, 2);
        assert_eq!(report.disagreements, 0, "{:#?}", report.examples);
        assert!(report.poses >= 8_100 && report.undecided * 10 < report.poses, "{report:?}");
        let enough = report.near > 2000 && report.tight > 500 && report.contained > 50;
        assert!(enough, "the poses must be of all kinds: {report:?}");
    }

    #[test]
    fn a_wrong_answer_would_be_seen() {
        let near = brute_force_meshes::Truth { distance: 1e-4 - 3e-9, crosses_clearly: false, contained: false };
        assert_eq!(expected(&near, 1e-4, 1e-9), Some(true));
        assert_eq!(expected(&brute_force_meshes::Truth { distance: 1e-4 + 3e-9, ..near }, 1e-4, 1e-9), Some(false));
        assert_eq!(expected(&brute_force_meshes::Truth { distance: 1e-4, ..near }, 1e-4, 1e-9), None);
        assert_eq!(
            expected(&brute_force_meshes::Truth { distance: f64::INFINITY, contained: true, ..near }, 1e-4, 1e-9),
            Some(true)
        );
        assert_eq!(expected(&brute_force_meshes::Truth { distance: 0.0, ..near }, 0.0, 1e-9), None);
        assert_eq!(
            expected(&brute_force_meshes::Truth { distance: 0.0, crosses_clearly: true, ..near }, 0.0, 1e-9),
            Some(true)
        );
    }
}
