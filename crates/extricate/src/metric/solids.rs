//! Volume moments of the geometry that each frame carries, and the object norm's embedding.

use crate::math::{Mat3, Pose, Vec3};
use crate::robot::mesh::moments::Moments;
use crate::scene::{Part, Scene};

/// Moments of every moving frame that carries geometry.
#[derive(Debug, Clone, Default)]
pub struct Solids {
    /// Moments by frame, in the order of the scene's frames.
    pub frames: Vec<FrameSolid>,
}

/// Moments of the geometry that one frame carries.
#[derive(Debug, Clone)]
pub struct FrameSolid {
    /// Index of the frame.
    pub frame: usize,
    /// Share of the moving volume (or area, or weight of points).
    pub share: f64,
    /// Centroid in frame coordinates \[m\].
    pub centroid: Vec3,
    /// `root root' = ` second moment about the centroid divided by the volume, in frame axes \[m\].
    pub root: Mat3,
    /// Inverse of the second moment [1/m^2]; `None` if the geometry is flat.
    pub inverse_second: Option<Mat3>,
}

/// Geometry is flat if the least eigenvalue of its second moment is below this share of the
/// largest. Rounding leaves far less of a zero.
const FLAT_SHARE: f64 = 1e-12;
/// Rounding error of an eigenvalue, as a share of the largest one. Subtracting it can only make
/// motion factors larger, so that bounds hold.
const EIGENVALUE_ROUNDING_SHARE: f64 = 1e-14;

impl Solids {
    /// Computes the moments of all moving geometry: of volumes if every part has one, otherwise of
    /// surface areas.
    pub fn new(scene: &Scene) -> Self {
        let moving = || scene.bodies.iter().filter(|body| body.frame != 0).flat_map(|body| &body.parts);
        let solid = moving().all(|part| part.geometry.volume_moments().is_some());
        let moments = |part: &Part| {
            let local = match part.geometry.volume_moments() {
                Some(volume) if solid => volume,
                _ => part.geometry.area_moments(),
            };
            local.transformed(&part.pose_frame_part)
        };
        let mut frames: Vec<(usize, Moments)> = Vec::new();
        for frame in 1..scene.frames.len() {
            let parts = scene.bodies.iter().filter(|body| body.frame == frame).flat_map(|body| &body.parts);
            let Some(sum) = Moments::combine(parts.map(moments)) else { continue };
            if sum.measure > 0.0 {
                frames.push((frame, sum));
            }
        }
        Self::of_moments(frames)
    }

    /// Computes moments of points instead of volumes. `weighted` has frames with a weight and
    /// points, which share the weight equally.
    ///
    /// A weighted mean square of displacements is at most the largest square, whatever the weights.
    /// So the embedding never exceeds the largest displacement, and is closest to it if the weight
    /// lies on the points that move farthest.
    pub fn of_points<'a>(weighted: impl Iterator<Item = (usize, f64, &'a [Vec3])>) -> Self {
        let moments = |(frame, measure, points): (usize, f64, &[Vec3])| {
            let share = 1.0 / points.len() as f64;
            let centroid: Vec3 = points.iter().sum::<Vec3>() * share;
            let spread = |p: &Vec3| (p - centroid) * (p - centroid).transpose() * share;
            (frame, Moments { measure, centroid, second_moment: points.iter().map(spread).sum() })
        };
        Self::of_moments(weighted.filter(|(_, weight, _)| *weight > 0.0).map(moments).collect())
    }

    fn of_moments(frames: Vec<(usize, Moments)>) -> Self {
        let total: f64 = frames.iter().map(|(_, m)| m.measure).sum();
        let frames = frames
            .into_iter()
            .map(|(frame, m)| {
                let eigen = m.second_moment.symmetric_eigen();
                let roots = eigen.eigenvalues.map(|x| x.max(0.0).sqrt());
                let (least, most) = (eigen.eigenvalues.min(), eigen.eigenvalues.max());
                FrameSolid {
                    frame,
                    share: m.measure / total,
                    centroid: m.centroid,
                    root: eigen.eigenvectors * Mat3::from_diagonal(&roots),
                    // Other ways to invert a nearly flat moment need not give a positive matrix.
                    inverse_second: (least > FLAT_SHARE * most).then(|| {
                        let inverse = eigen.eigenvalues.map(|x| 1.0 / (x - EIGENVALUE_ROUNDING_SHARE * most));
                        eigen.eigenvectors * Mat3::from_diagonal(&inverse) * eigen.eigenvectors.transpose()
                    }),
                }
            })
            .collect();
        Self { frames }
    }

    /// Writes `sqrt(share) [c, R root]` for each frame: 12 numbers. The Euclidean distance between
    /// two such vectors is the object norm.
    pub fn embed(&self, poses: &[Pose], out: &mut [f64]) {
        for (solid, slot) in self.frames.iter().zip(out.chunks_exact_mut(12)) {
            let pose = &poses[solid.frame];
            let scale = solid.share.sqrt();
            let centroid = pose.point(&solid.centroid) * scale;
            let axes = pose.rotation * solid.root * scale;
            slot[..3].copy_from_slice(centroid.as_slice());
            slot[3..].copy_from_slice(axes.as_slice());
        }
    }
}

impl FrameSolid {
    /// Returns `B` with `displacement of the point <= B * object norm`, for a point in frame
    /// coordinates. It is infinite if the geometry is flat.
    ///
    /// `B = sqrt(1 / share) sqrt(1 + (p - c)' S^-1 (p - c))`: the displacement field is affine,
    /// `u(p) = u(c) + A (p - c)`, and `|A (p - c)| <= |A S^(1/2)| |S^(-1/2) (p - c)|`.
    /// Cauchy-Schwarz combines the two terms.
    pub fn motion_factor(&self, point_frame: &Vec3) -> f64 {
        let arm = point_frame - self.centroid;
        match &self.inverse_second {
            Some(inverse) => ((1.0 + arm.dot(&(inverse * arm)).max(0.0)) / self.share).sqrt(),
            None => f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Pose;

    /// No point of a flat or nearly flat sheet moves farther than its factor allows.
    #[test]
    fn factors_of_sheets_hold() {
        let (mut finite, mut seen) = (0, 0);
        for k in 0..2000 {
            let x = f64::from(k);
            let turn = |a: f64| Pose::from_xyz_rpy([0.0; 3], [a * 1.3, a * 0.7, a * 2.1]).rotation;
            let thickness = 10f64.powf(-12.0 * (0.37 * x).fract()) * f64::from(k % 3);
            let attitude = turn(0.61 * x);
            let corner = |i: u32| {
                let side = |bit: u32, half: f64| if i >> bit & 1 == 1 { half } else { -half };
                attitude * Vec3::new(side(0, 7.0), side(1, 3.0), side(2, thickness))
            };
            let points: Vec<Vec3> = (0..8).map(corner).collect();
            let solids = Solids::of_points(std::iter::once((1, 1.0, &points[..])));
            let motion = turn(0.29 * x + 0.1) - Mat3::identity();
            let moves: Vec<Vec3> = points.iter().map(|p| motion * p).collect();
            let norm = (moves.iter().map(Vec3::norm_squared).sum::<f64>() / 8.0).sqrt();
            for (point, moved) in points.iter().zip(&moves) {
                let factor = solids.frames[0].motion_factor(point);
                finite += usize::from(factor.is_finite());
                seen += 1;
                assert!(moved.norm() <= factor * norm * (1.0 + 1e-9), "{k}: {} {factor} {norm}", moved.norm());
            }
        }
        assert!(finite * 4 > seen && finite < seen, "{finite} of {seen}");
    }
}
