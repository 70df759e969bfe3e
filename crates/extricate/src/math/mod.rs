//! Rigid transforms, shared vector types and vector instructions. Nothing here knows of robots or
//! scenes.

pub mod elementary;
pub mod linear_algebra;
pub mod quadratic_form;
pub mod simd;

use serde::{Deserialize, Serialize};

/// Column vector of three `f64`.
pub type Vec3 = nalgebra::Vector3<f64>;
/// 3 x 3 matrix of `f64`, column major.
pub type Mat3 = nalgebra::Matrix3<f64>;

/// Largest accepted coordinate \[m\] or angle \[rad\]: products of larger ones lose their meaning.
pub const FARTHEST: f64 = 1e9;

/// Number of values in one block for vector instructions: the width of an AVX register of `f32`.
pub const LANES: usize = 8;

/// Runs `f`, and all code inlined into it, with the widest vector instructions of this processor.
///
/// Mark the closure and the functions that it calls `#[inline(always)]`: code that is not inlined
/// is compiled without these instructions.
///
/// Results do not depend on the width, as Rust never fuses a multiplication with an addition by
/// itself.
#[inline(always)]
pub fn vectorized<R>(f: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(f)
}

/// A rigid transform: `pose_a_b` maps coordinates in frame `b` to coordinates in frame `a`.
///
/// Stored as a rotation matrix and a translation \[m\], because forward kinematics multiplies far
/// more often than it interpolates.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Orthonormal rotation matrix with determinant +1.
    #[doc(hidden)]
    pub rotation: Mat3,
    /// Origin of `b` in `a` \[m\].
    #[doc(hidden)]
    pub translation: Vec3,
}

impl Default for Pose {
    fn default() -> Self {
        Self::identity()
    }
}

impl Pose {
    /// Returns the identity transform.
    pub fn identity() -> Self {
        Self { rotation: Mat3::identity(), translation: Vec3::zeros() }
    }

    /// Makes a pose of the columns of its rotation and the origin of `b` in `a` \[m\]. The columns
    /// have to be orthonormal, with determinant +1; scenes refuse others.
    pub fn new(columns: [[f64; 3]; 3], origin: [f64; 3]) -> Self {
        Self { rotation: Mat3::from_columns(&columns.map(Vec3::from)), translation: origin.into() }
    }

    /// Makes a pure translation to `origin` \[m\].
    pub fn at(origin: [f64; 3]) -> Self {
        Self::translation(origin.into())
    }

    /// Returns the columns of the rotation matrix.
    pub fn columns(&self) -> [[f64; 3]; 3] {
        [0, 1, 2].map(|column| self.rotation.column(column).into_owned().into())
    }

    /// Returns the origin of `b` in `a` \[m\].
    pub fn origin(&self) -> [f64; 3] {
        self.translation.into()
    }

    /// Returns the coordinates in `a` of a point given in `b` \[m\].
    pub fn transform(&self, point: [f64; 3]) -> [f64; 3] {
        self.point(&point.into()).into()
    }

    /// Makes a pure translation \[m\].
    #[doc(hidden)]
    pub fn translation(translation: Vec3) -> Self {
        Self { rotation: Mat3::identity(), translation }
    }

    /// Makes a pose of a position \[m\] and roll, pitch, yaw \[rad\] about fixed axes x, y and z
    /// (the URDF convention).
    pub fn from_xyz_rpy(xyz: [f64; 3], rpy: [f64; 3]) -> Self {
        let rotation = nalgebra::Rotation3::from_euler_angles(rpy[0], rpy[1], rpy[2]).into_inner();
        Self { rotation, translation: Vec3::from(xyz) }
    }

    /// Composes `pose_a_b` (self) and `pose_b_c`, and returns `pose_a_c`.
    pub fn then(&self, other: &Pose) -> Pose {
        Pose {
            rotation: self.rotation * other.rotation,
            translation: self.rotation * other.translation + self.translation,
        }
    }

    /// Returns `pose_b_a`, the inverse of `pose_a_b`.
    pub fn inverse(&self) -> Pose {
        let rotation = self.rotation.transpose();
        Pose { rotation, translation: -(rotation * self.translation) }
    }

    /// Returns the coordinates in `a` of a point given in `b`.
    #[doc(hidden)]
    pub fn point(&self, point: &Vec3) -> Vec3 {
        self.rotation * point + self.translation
    }

    /// Applies [`Pose::point`] to eight points at once, axis by axis.
    #[inline(always)]
    #[doc(hidden)]
    pub fn points(&self, points: &[[f64; LANES]; 3]) -> [[f64; LANES]; 3] {
        let mut mapped = [[0.0; LANES]; 3];
        for (row, mapped) in mapped.iter_mut().enumerate() {
            let [x, y, z] = [self.rotation[(row, 0)], self.rotation[(row, 1)], self.rotation[(row, 2)]];
            for lane in 0..LANES {
                mapped[lane] = x * points[0][lane] + y * points[1][lane] + z * points[2][lane] + self.translation[row];
            }
        }
        mapped
    }

    /// Returns the coordinates in `b` of a point given in `a`.
    #[doc(hidden)]
    pub fn inverse_point(&self, point: &Vec3) -> Vec3 {
        self.rotation.tr_mul(&(point - self.translation))
    }

    /// Returns the coordinates in `a` of a direction given in `b`.
    #[doc(hidden)]
    pub fn vector(&self, vector: &Vec3) -> Vec3 {
        self.rotation * vector
    }

    /// Returns the coordinates in `b` of a direction given in `a`.
    #[doc(hidden)]
    pub fn inverse_vector(&self, vector: &Vec3) -> Vec3 {
        self.rotation.tr_mul(vector)
    }
}

/// Returns the rotation by `angle` \[rad\] about a unit `axis` (Rodrigues' formula).
pub fn axis_rotation(axis: &Vec3, angle: f64) -> Mat3 {
    let (sin, cos) = elementary::sin_cos(angle);
    let cross = axis.cross_matrix();
    Mat3::identity() + cross * sin + cross * cross * (1.0 - cos)
}

/// Returns the rotation matrix of a unit quaternion `[x, y, z, w]`.
pub fn quaternion_matrix(q: &[f64]) -> Mat3 {
    let (x, y, z, w) = (q[0], q[1], q[2], q[3]);
    Mat3::new(
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )
}

/// Returns the Hamilton product of quaternions `[x, y, z, w]`.
pub fn quaternion_product(a: &[f64], b: &[f64]) -> [f64; 4] {
    [
        a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
        a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
        a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
        a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
    ]
}

/// Returns the unit quaternion `[x, y, z, w]` of a rotation vector \[rad\]: angle times axis.
pub fn quaternion_exp(v: &[f64]) -> [f64; 4] {
    let angle = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let (sine, cosine) = elementary::sin_cos(0.5 * angle);
    let scale = if angle < 1e-6 { 0.5 - angle * angle / 48.0 } else { sine / angle };
    [v[0] * scale, v[1] * scale, v[2] * scale, cosine]
}

/// Returns the rotation vector \[rad\], at most `pi` long, that [`quaternion_exp`] maps to `q` or
/// `-q`.
pub fn quaternion_log(q: &[f64]) -> [f64; 3] {
    let sine = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2]).sqrt();
    let sign = if q[3] < 0.0 { -1.0 } else { 1.0 };
    let scale = if sine < 1e-9 { 2.0 } else { 2.0 * elementary::atan2(sine, q[3].abs()) / sine };
    [q[0] * scale * sign, q[1] * scale * sign, q[2] * scale * sign]
}

/// Wraps `angle` \[rad\] into `[-pi, pi)`.
pub fn wrap_angle(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    if (-PI..PI).contains(&angle) {
        return angle;
    }
    let wrapped = (angle + PI).rem_euclid(TAU) - PI;
    if wrapped >= PI { -PI } else { wrapped }
}

/// Returns `count` evenly spread unit vectors (a Fibonacci lattice).
///
/// # Source
/// Á. González, "Measurement of areas on a sphere using Fibonacci and latitude-longitude lattices",
/// Mathematical Geosciences 42, 2010, doi:10.1007/s11004-009-9257-x.
pub fn sphere(count: usize) -> impl Iterator<Item = Vec3> {
    let turn = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |k| {
        let z = 1.0 - (2 * k + 1) as f64 / count as f64;
        let (sin, cos) = elementary::sin_cos(turn * k as f64);
        let radius = (1.0 - z * z).sqrt();
        Vec3::new(radius * cos, radius * sin, z)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quaternion_log_inverts_exp() {
        for v in [[0.3, -0.2, 1.1], [1e-9, 0.0, 0.0], [0.0, 3.1, 0.0], [0.0; 3]] {
            let back = quaternion_log(&quaternion_exp(&v));
            for k in 0..3 {
                assert!((back[k] - v[k]).abs() < 1e-12, "{v:?} {back:?}");
            }
        }
    }

    #[test]
    fn rotations_agree() {
        let axis = Vec3::new(1.0, 2.0, -0.5).normalize();
        let q = quaternion_exp((axis * 0.7).as_slice());
        assert!((quaternion_matrix(&q) - axis_rotation(&axis, 0.7)).norm() < 1e-14);
        let p = quaternion_product(&q, &q);
        assert!((quaternion_matrix(&p) - axis_rotation(&axis, 1.4)).norm() < 1e-14);
    }

    #[test]
    fn pose_inverse_undoes() {
        let pose = Pose::from_xyz_rpy([0.1, 0.2, 0.3], [0.4, 0.5, 0.6]);
        let x = Vec3::new(1.0, -2.0, 3.0);
        assert!((pose.inverse_point(&pose.point(&x)) - x).norm() < 1e-14);
        assert!((pose.inverse().point(&pose.point(&x)) - x).norm() < 1e-14);
        assert!((pose.then(&pose.inverse()).translation).norm() < 1e-14);
        let eight = pose.points(&[[1.0; LANES], [-2.0; LANES], [3.0; LANES]]);
        assert!((pose.point(&x) - Vec3::from(eight.map(|axis| axis[LANES - 1]))).norm() < 1e-14);
    }

    #[test]
    fn directions_are_evenly_spread() {
        let all: Vec<Vec3> = sphere(64).collect();
        for (k, n) in all.iter().enumerate() {
            assert!((n.norm() - 1.0).abs() < 1e-12);
            let others = all.iter().enumerate().filter(|(l, _)| *l != k);
            let nearest = others.map(|(_, m)| n.angle(m)).fold(f64::INFINITY, f64::min);
            // Each of 64 caps of equal area is about 0.5 rad across.
            assert!((0.3..0.6).contains(&nearest), "{k}: {nearest}");
        }
    }

    #[test]
    fn angles_wrap() {
        use std::f64::consts::PI;
        assert_eq!(wrap_angle(PI), -PI);
        assert!((wrap_angle(7.0) - (7.0 - 2.0 * PI)).abs() < 1e-15);
        assert!((-PI..PI).contains(&wrap_angle(-PI - 1e-17)));
    }
}
