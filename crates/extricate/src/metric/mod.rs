//! Distances between configurations, each with an embedding that never exceeds it.
//!
//! Every metric `d` comes with `phi: C -> R^m` such that `|phi(q) - phi(q')| <= d(q, q')`: a
//! Euclidean index over `phi` plus re-ranking is exact under `d`. The index itself is in `samples`.

mod coordinate_use;
pub mod extremes;
mod inertia;
pub mod motion_bound;
pub mod pair_motion;
pub mod quadratic;
pub mod relative;
pub mod solids;

use std::fmt;
use std::sync::Arc;

use crate::cspace::sampling::Halton;
use crate::cspace::{Factor, Manifold};
use crate::kinematics::forward;
use crate::math::Pose;
use crate::math::elementary::sin_cos;
use crate::scene::{MetricKind, Scene};
use coordinate_use::{CoordinateUse, coordinate_uses};
use extremes::Extremes;
use solids::Solids;

/// The metric of a scene.
///
/// | kind | distance | embedding |
/// |---|---|---|
/// | joint | `sqrt(sum w delta^2)`: wrapped on circles, geodesic angle on SO(3) | scaled coordinates, chords of circles and rotations |
/// | object norm | root mean square displacement of the moving volume \[m\] | exact, 12 numbers a moving frame |
/// | max displacement | largest displacement of any point of the moving geometry \[m\] | root mean square displacement of the points that move farthest as a rule, 12 numbers a moving frame |
pub struct Metric {
    scene: Arc<Scene>,
    kind: MetricKind,
    solids: Solids,
    extremes: Extremes,
    uses: Vec<CoordinateUse>,
    diameter: f64,
    lever: f64,
}

/// A configuration and the data that repeated distances from it share; [`Metric::anchor`] makes it.
#[derive(Debug, Clone, Default)]
pub struct Anchor {
    /// Configuration from which distances are measured.
    pub q: Vec<f64>,
    /// Frame poses at `q`.
    #[doc(hidden)]
    pub poses: Vec<Pose>,
    embedding: Vec<f64>,
}

/// Buffers that distance evaluations reuse.
#[derive(Debug, Clone, Default)]
pub struct MetricScratch {
    poses: Vec<Pose>,
    embedding: Vec<f64>,
}

impl fmt::Debug for Metric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Metric").field("kind", &self.kind).field("diameter", &self.diameter).finish_non_exhaustive()
    }
}

impl Metric {
    /// Makes the metric that `scene` names.
    pub fn new(scene: Arc<Scene>) -> Self {
        let kind = scene.metric;
        Self::of_kind(scene, kind)
    }

    /// Makes a metric of the given kind over `scene`, whatever kind the scene names.
    pub fn of_kind(scene: Arc<Scene>, kind: MetricKind) -> Self {
        let extremes = Extremes::new(&scene);
        let solids = match kind {
            MetricKind::MaxDisplacement => far_points(&scene, &extremes),
            MetricKind::Joint | MetricKind::ObjectNorm => Solids::new(&scene),
        };
        let uses = coordinate_uses(&scene);
        let mut metric = Self { scene, kind, solids, extremes, uses, diameter: 0.0, lever: 0.0 };
        (metric.diameter, metric.lever) = (metric.measure_diameter(), metric.measure_lever());
        metric
    }

    /// Returns whether this is also the metric of `scene`: same kind, coordinates, frames and
    /// moving bodies.
    #[doc(hidden)]
    pub fn is_of(&self, scene: &Scene) -> bool {
        let own = &*self.scene;
        let is_of_joints = self.kind == scene.metric && own.space == scene.space && own.frames == scene.frames;
        is_of_joints && own.moving_bodies().eq(scene.moving_bodies())
    }

    /// Returns the kind of distance.
    pub fn kind(&self) -> MetricKind {
        self.kind
    }

    /// Returns the moving frames with the moments of their geometry.
    #[doc(hidden)]
    pub fn solids(&self) -> &Solids {
        &self.solids
    }

    pub(crate) fn scene(&self) -> &Scene {
        &self.scene
    }

    fn coordinate_uses(&self) -> &[CoordinateUse] {
        &self.uses
    }

    pub(crate) fn extremes(&self) -> &Extremes {
        &self.extremes
    }

    /// Returns the number of coordinates of the embedding, at least one.
    #[doc(hidden)]
    pub fn embedding_len(&self) -> usize {
        match self.kind {
            MetricKind::Joint => self.scene.space.factors().iter().map(|f| chord_len(&f.manifold)).sum(),
            // If no frame moves geometry, one coordinate remains that `embed` leaves as it is.
            MetricKind::ObjectNorm | MetricKind::MaxDisplacement => (12 * self.solids.frames.len()).max(1),
        }
    }

    /// Embeds `q` (length `nq`) into `out` (length [`Metric::embedding_len`]).
    ///
    /// # Guarantee
    /// `|phi(a) - phi(b)| <= distance(a, b)` up to rounding.
    #[doc(hidden)]
    pub fn embed(&self, q: &[f64], scratch: &mut MetricScratch, out: &mut [f64]) {
        match self.kind {
            MetricKind::Joint => self.embed_joint(q, out),
            MetricKind::ObjectNorm | MetricKind::MaxDisplacement => {
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
                    let (sin, cos) = sin_cos(q[factor.q]);
                    out[at] = scale * cos;
                    out[at + 1] = scale * sin;
                }
                Manifold::Rotation => {
                    // |R - R'| in the Frobenius norm is 2 sqrt(2) sin(angle / 2). Divided by
                    // sqrt(2) it is a chord, no longer than the angle.
                    let rotation = crate::math::quaternion_matrix(&q[factor.q..factor.q + 4]);
                    for (slot, x) in out[at..at + 9].iter_mut().zip(rotation.iter()) {
                        *slot = scale * std::f64::consts::FRAC_1_SQRT_2 * x;
                    }
                }
            }
            at += chord_len(&factor.manifold);
        }
    }

    /// Returns whether the joint metric equals the distance between embeddings: every joint is an
    /// interval. It is `false` for all other metrics.
    #[doc(hidden)]
    pub fn embedding_is_exact(&self) -> bool {
        let is_interval = |factor: &Factor| matches!(factor.manifold, Manifold::Interval { .. });
        self.kind == MetricKind::Joint && self.scene.space.factors().iter().all(is_interval)
    }

    /// Returns the largest distance between two configurations, or an estimate, in metric units.
    pub fn diameter(&self) -> f64 {
        self.diameter
    }

    /// Returns the largest displacement of any point per metric unit \[m\], as measured over short
    /// steps between sampled configurations.
    #[doc(hidden)]
    pub fn lever(&self) -> f64 {
        self.lever
    }

    /// Returns the root mean square displacement at `q` of what each tangent coordinate carries
    /// [m per rad, or 1]. It is 0 for a coordinate that carries nothing.
    #[doc(hidden)]
    pub fn levers(&self, q: &[f64]) -> Vec<f64> {
        let mut poses = Vec::new();
        forward(&self.scene, q, &mut poses);
        inertia::levers(&self.scene, &self.solids, &poses)
    }

    fn measure_diameter(&self) -> f64 {
        match self.kind {
            MetricKind::Joint => self.scene.space.diameter(),
            MetricKind::ObjectNorm | MetricKind::MaxDisplacement => {
                sampled_pairs(&self.scene).map(|(a, b)| self.distance(&a, &b)).fold(0.0, f64::max)
            }
        }
    }

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
        sampled_pairs(&self.scene).map(ratio).fold(0.0, f64::max)
    }

    /// Prepares repeated distances from `q`.
    pub fn anchor(&self, q: &[f64], anchor: &mut Anchor) {
        forward(&self.scene, q, &mut anchor.poses);
        self.finish_anchor(q, anchor);
    }

    /// Prepares repeated distances from `q`, given the frame poses there.
    #[doc(hidden)]
    pub fn anchor_at(&self, q: &[f64], poses: &[Pose], anchor: &mut Anchor) {
        anchor.poses.clear();
        anchor.poses.extend_from_slice(poses);
        self.finish_anchor(q, anchor);
    }

    fn finish_anchor(&self, q: &[f64], anchor: &mut Anchor) {
        anchor.q.clear();
        anchor.q.extend_from_slice(q);
        if self.kind != MetricKind::Joint {
            anchor.embedding.resize(12 * self.solids.frames.len(), 0.0);
            self.solids.embed(&anchor.poses, &mut anchor.embedding);
        }
    }

    /// Returns the distance from the anchor to `q`, in metric units.
    pub fn distance_from(&self, anchor: &Anchor, q: &[f64], scratch: &mut MetricScratch) -> f64 {
        match self.kind {
            MetricKind::Joint => self.scene.space.distance(&anchor.q, q),
            MetricKind::ObjectNorm => {
                forward(&self.scene, q, &mut scratch.poses);
                scratch.embedding.resize(anchor.embedding.len(), 0.0);
                self.solids.embed(&scratch.poses, &mut scratch.embedding);
                euclidean(&anchor.embedding, &scratch.embedding)
            }
            MetricKind::MaxDisplacement => self.max_displacement_from(anchor, q, scratch),
        }
    }

    /// Returns the distance between two configurations, in metric units.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let mut anchor = Anchor::default();
        self.anchor(a, &mut anchor);
        self.distance_from(&anchor, b, &mut MetricScratch::default())
    }

    /// Returns the largest displacement \[m\] of any point of the moving geometry between the
    /// anchor and `q`, whatever the metric.
    pub fn max_displacement_from(&self, anchor: &Anchor, q: &[f64], scratch: &mut MetricScratch) -> f64 {
        forward(&self.scene, q, &mut scratch.poses);
        self.max_displacement_at(anchor, &scratch.poses)
    }

    /// Returns the largest displacement \[m\] between the anchor and frame poses `poses`.
    #[doc(hidden)]
    pub fn max_displacement_at(&self, anchor: &Anchor, poses: &[Pose]) -> f64 {
        self.extremes.max_displacement(&anchor.poses, poses)
    }
}

/// Returns pairs of configurations from a Halton sequence, the same on every call.
fn sampled_pairs(scene: &Scene) -> impl Iterator<Item = (Vec<f64>, Vec<f64>)> + use<'_> {
    let space = &scene.space;
    let halton = Halton::new(space.nv(), 0);
    (0..64).map(move |i| {
        let (mut a, mut b) = (vec![0.0; space.nq()], vec![0.0; space.nq()]);
        halton.config(space, 2 * i, &mut a);
        halton.config(space, 2 * i + 1, &mut b);
        (a, b)
    })
}

/// Weights each frame by how often it holds the farthest point between sampled configurations, near
/// and far, so that the mean square displacement comes close to the largest one.
fn far_points(scene: &Scene, extremes: &Extremes) -> Solids {
    let mut counts = vec![0.0; extremes.frames.len()];
    let (mut from, mut to) = (Vec::new(), Vec::new());
    for (a, far) in sampled_pairs(scene) {
        for share in [0.05, 0.2, 1.0] {
            let mut b = far.clone();
            scene.space.interpolate(&a, &far, share, &mut b);
            forward(scene, &a, &mut from);
            forward(scene, &b, &mut to);
            if let Some(frame) = extremes.farthest_frame(&from, &to) {
                counts[frame] += 1.0;
            }
        }
    }
    // Every frame keeps some weight, so that motions of frames near the base alone count too.
    let rest = 0.05 * counts.iter().sum::<f64>() / counts.len().max(1) as f64;
    Solids::of_points(extremes.frames.iter().zip(counts).map(|(f, n)| (f.frame, n + rest, f.samples.as_slice())))
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
