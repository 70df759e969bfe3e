//! Distances between configurations, each with an embedding that never exceeds it.
//!
//! Every metric `d` comes with `phi: C -> R^m` such that `|phi(q) - phi(q')| <= d(q, q')`: a Euclidean index over `phi` plus
//! re-ranking is exact under `d`. Not here: searching (`boundary`), collision.

pub mod extremes;
pub mod motion_bound;
pub mod quadratic;
pub mod solids;

use std::sync::Arc;

use crate::cspace::Manifold;
use crate::kinematics::forward;
use crate::math::Pose;
use crate::scene::{MetricSpec, Scene};
use extremes::Extremes;
use solids::Solids;

/// The metric of a scene.
///
/// | kind | distance | embedding |
/// |---|---|---|
/// | joint | `sqrt(sum w delta^2)`: wrapped on circles, geodesic angle on SO(3) | scaled coordinates, chords of circles and rotations |
/// | object norm | root mean square displacement of the moving volume \[m\] | exact, 12 numbers a moving frame |
/// | max displacement | largest displacement of any point of the moving geometry \[m\] | the object norm's |
pub struct Metric {
    scene: Arc<Scene>,
    kind: MetricSpec,
    solids: Solids,
    extremes: Extremes,
    diameter: f64,
    lever: f64,
}

/// A configuration with what repeated distances from it reuse. Made by [`Metric::anchor`].
#[derive(Debug, Clone, Default)]
pub struct Anchor {
    /// The configuration.
    pub q: Vec<f64>,
    poses: Vec<Pose>,
    embedding: Vec<f64>,
}

/// Memory that distances reuse.
#[derive(Debug, Clone, Default)]
pub struct MetricScratch {
    poses: Vec<Pose>,
    embedding: Vec<f64>,
}

impl Metric {
    /// The metric that `scene` names.
    pub fn new(scene: Arc<Scene>) -> Self {
        let kind = scene.metric;
        Self::of_kind(scene, kind)
    }

    /// A metric of the given kind over `scene`, whatever the scene names.
    pub fn of_kind(scene: Arc<Scene>, kind: MetricSpec) -> Self {
        let (solids, extremes) = (Solids::new(&scene), Extremes::new(&scene));
        let mut metric = Self { scene, kind, solids, extremes, diameter: 0.0, lever: 0.0 };
        (metric.diameter, metric.lever) = (metric.measure_diameter(), metric.measure_lever());
        metric
    }

    /// Its kind.
    pub fn kind(&self) -> MetricSpec {
        self.kind
    }

    /// Moving frames with their volume moments.
    pub fn solids(&self) -> &Solids {
        &self.solids
    }

    pub(crate) fn scene(&self) -> &Scene {
        &self.scene
    }

    pub(crate) fn extremes(&self) -> &Extremes {
        &self.extremes
    }

    /// Number of coordinates of the embedding.
    pub fn embedding_len(&self) -> usize {
        match self.kind {
            MetricSpec::Joint => self.scene.space.factors().iter().map(|f| chord_len(&f.manifold)).sum(),
            MetricSpec::ObjectNorm | MetricSpec::MaxDisplacement => 12 * self.solids.frames.len(),
        }
    }

    /// Embeds `q` (length `nq`) into `out` (length [`Metric::embedding_len`]).
    ///
    /// # Guarantee
    /// `|phi(a) - phi(b)| <= distance(a, b)` up to rounding.
    pub fn embed(&self, q: &[f64], scratch: &mut MetricScratch, out: &mut [f64]) {
        match self.kind {
            MetricSpec::Joint => self.embed_joint(q, out),
            MetricSpec::ObjectNorm | MetricSpec::MaxDisplacement => {
                forward(&self.scene, q, &mut scratch.poses);
                self.solids.embed(&scratch.poses, out);
            }
        }
    }

    fn embed_joint(&self, q: &[f64], out: &mut [f64]) {
        let mut at = 0;
        for factor in self.scene.space.factors() {
            let scale = factor.weight.sqrt();
            match factor.manifold {
                Manifold::Interval { .. } => out[at] = scale * q[factor.q],
                Manifold::Circle => {
                    let (sin, cos) = q[factor.q].sin_cos();
                    out[at] = scale * cos;
                    out[at + 1] = scale * sin;
                }
                Manifold::Rotation => {
                    // |R - R'| in the Frobenius norm is 2 sqrt(2) sin(angle / 2); divided by sqrt(2) it is a chord.
                    let rotation = crate::math::quaternion_matrix(&q[factor.q..factor.q + 4]);
                    for (slot, x) in out[at..at + 9].iter_mut().zip(rotation.iter()) {
                        *slot = scale * std::f64::consts::FRAC_1_SQRT_2 * x;
                    }
                }
            }
            at += chord_len(&factor.manifold);
        }
    }

    /// A length of the order of the largest distance between any two configurations, in metric units.
    pub fn diameter(&self) -> f64 {
        self.diameter
    }

    /// Largest displacement of a point \[m\] that a small step of length 1 (metric units) typically causes.
    pub fn lever(&self) -> f64 {
        self.lever
    }

    fn measure_diameter(&self) -> f64 {
        match self.kind {
            MetricSpec::Joint => self.scene.space.diameter(),
            MetricSpec::ObjectNorm | MetricSpec::MaxDisplacement => {
                self.sampled_pairs().map(|(a, b)| self.distance(&a, &b)).fold(0.0, f64::max)
            }
        }
    }

    /// The largest ratio among some short random steps.
    fn measure_lever(&self) -> f64 {
        let mut anchor = Anchor::default();
        let mut scratch = MetricScratch::default();
        let ratio = |(a, far): (Vec<f64>, Vec<f64>)| {
            let mut b = far.clone();
            self.scene.space.interpolate(&a, &far, 0.01, &mut b);
            self.anchor(&a, &mut anchor);
            let distance = self.distance_from(&anchor, &b, &mut scratch);
            self.max_displacement_from(&anchor, &b, &mut scratch) / distance.max(1e-300)
        };
        self.sampled_pairs().map(ratio).fold(0.0, f64::max)
    }

    /// A few pairs of low-discrepancy configurations.
    fn sampled_pairs(&self) -> impl Iterator<Item = (Vec<f64>, Vec<f64>)> {
        let space = &self.scene.space;
        let halton = crate::cspace::sampling::Halton::new(space.nv(), 0);
        (0..32).map(move |i| {
            let (mut a, mut b) = (vec![0.0; space.nq()], vec![0.0; space.nq()]);
            halton.config(space, 2 * i, &mut a);
            halton.config(space, 2 * i + 1, &mut b);
            (a, b)
        })
    }

    /// Prepares repeated distances from `q`.
    pub fn anchor(&self, q: &[f64], anchor: &mut Anchor) {
        anchor.q.clear();
        anchor.q.extend_from_slice(q);
        forward(&self.scene, q, &mut anchor.poses);
        if self.kind != MetricSpec::Joint {
            anchor.embedding.resize(12 * self.solids.frames.len(), 0.0);
            self.solids.embed(&anchor.poses, &mut anchor.embedding);
        }
    }

    /// Distance from the anchor to `q`, in metric units.
    pub fn distance_from(&self, anchor: &Anchor, q: &[f64], scratch: &mut MetricScratch) -> f64 {
        match self.kind {
            MetricSpec::Joint => self.scene.space.distance(&anchor.q, q),
            MetricSpec::ObjectNorm => {
                forward(&self.scene, q, &mut scratch.poses);
                scratch.embedding.resize(anchor.embedding.len(), 0.0);
                self.solids.embed(&scratch.poses, &mut scratch.embedding);
                euclidean(&anchor.embedding, &scratch.embedding)
            }
            MetricSpec::MaxDisplacement => self.max_displacement_from(anchor, q, scratch),
        }
    }

    /// Distance between two configurations, in metric units.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let mut anchor = Anchor::default();
        self.anchor(a, &mut anchor);
        self.distance_from(&anchor, b, &mut MetricScratch::default())
    }

    /// Largest displacement \[m\] of any point of the moving geometry between the anchor and `q`, whatever the metric.
    pub fn max_displacement_from(&self, anchor: &Anchor, q: &[f64], scratch: &mut MetricScratch) -> f64 {
        forward(&self.scene, q, &mut scratch.poses);
        self.extremes.max_displacement(&anchor.poses, &scratch.poses)
    }
}

fn chord_len(manifold: &Manifold) -> usize {
    match manifold {
        Manifold::Interval { .. } => 1,
        Manifold::Circle => 2,
        Manifold::Rotation => 9,
    }
}

fn euclidean(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests;
