//! The pose of one frame, at one configuration or at several. The operations and their order are
//! the same, so the bits are too.

use pulp::Simd;

use crate::math::{Pose, Vec3};

/// Position of a joint, at as many configurations as a register has lanes.
pub enum Joint<'a, S: Simd> {
    /// Rotation about a unit axis, by the angle of this sine and cosine.
    Revolute { axis: &'a Vec3, sine: S::f64s, cosine: S::f64s },
    /// Displacement along a unit axis \[m\].
    Prismatic { axis: &'a Vec3, length: S::f64s },
    /// Rotation by a unit quaternion x, y, z, w.
    Ball { quaternion: [S::f64s; 4] },
}

/// Columns of a rotation, then a translation.
pub type Numbers<S> = [<S as Simd>::f64s; 12];

/// Returns the world pose of a frame from that of its parent (`None` for the world).
#[inline(always)]
pub fn joint_pose<S: Simd>(simd: S, parent: Option<&Numbers<S>>, fixed: &Pose, joint: Joint<S>) -> Numbers<S> {
    let mut pose = match parent {
        None => constant(simd, fixed),
        Some(parent) => then(simd, parent, fixed),
    };
    match joint {
        Joint::Revolute { axis, sine, cosine } => {
            for (k, i, j) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
                if axis[i] == 0.0 && axis[j] == 0.0 {
                    let sine = if axis[k] > 0.0 { sine } else { simd.neg_f64s(sine) };
                    turn_columns(simd, &mut pose, i, j, sine, cosine);
                    return pose;
                }
            }
            turn(simd, &mut pose, &axis_rotation(simd, axis, sine, cosine));
        }
        Joint::Prismatic { axis, length } => {
            let unit = image(simd, &pose, axis);
            for r in 0..3 {
                pose[9 + r] = simd.add_f64s(pose[9 + r], simd.mul_f64s(unit[r], length));
            }
        }
        Joint::Ball { quaternion } => turn(simd, &mut pose, &quaternion_matrix(simd, quaternion)),
    }
    pose
}

#[inline(always)]
fn constant<S: Simd>(simd: S, pose: &Pose) -> Numbers<S> {
    let mut out = [simd.splat_f64s(0.0); 12];
    for (number, x) in out.iter_mut().zip(pose.rotation.as_slice().iter().chain(pose.translation.as_slice())) {
        *number = simd.splat_f64s(*x);
    }
    out
}

#[inline(always)]
fn then<S: Simd>(simd: S, parent: &Numbers<S>, fixed: &Pose) -> Numbers<S> {
    let mut out = *parent;
    for c in 0..3 {
        let column = image(simd, parent, &fixed.rotation.column(c).into_owned());
        out[3 * c..3 * c + 3].copy_from_slice(&column);
    }
    let t = image(simd, parent, &fixed.translation);
    for r in 0..3 {
        out[9 + r] = simd.add_f64s(t[r], parent[9 + r]);
    }
    out
}

/// Rotates a constant vector. This file uses loops since the closure of `array::from_fn` is not
/// compiled for vector registers: every operation in it would be a call.
#[inline(always)]
pub fn image<S: Simd>(simd: S, pose: &Numbers<S>, vector: &Vec3) -> [S::f64s; 3] {
    let [x, y, z] = [simd.splat_f64s(vector.x), simd.splat_f64s(vector.y), simd.splat_f64s(vector.z)];
    let mut out = [x; 3];
    for r in 0..3 {
        let sum = simd.add_f64s(simd.mul_f64s(pose[r], x), simd.mul_f64s(pose[3 + r], y));
        out[r] = simd.add_f64s(sum, simd.mul_f64s(pose[6 + r], z));
    }
    out
}

/// Rotates about the third axis of the frame, in cyclic order, which mixes the columns `i` and `j`.
#[inline(always)]
fn turn_columns<S: Simd>(simd: S, pose: &mut Numbers<S>, i: usize, j: usize, sine: S::f64s, cosine: S::f64s) {
    for r in 0..3 {
        let (a, b) = (pose[3 * i + r], pose[3 * j + r]);
        pose[3 * i + r] = simd.add_f64s(simd.mul_f64s(cosine, a), simd.mul_f64s(sine, b));
        pose[3 * j + r] = simd.sub_f64s(simd.mul_f64s(cosine, b), simd.mul_f64s(sine, a));
    }
}

/// Multiplies the rotation by another one, given by its columns.
#[inline(always)]
fn turn<S: Simd>(simd: S, pose: &mut Numbers<S>, rotation: &[[S::f64s; 3]; 3]) {
    let before = *pose;
    for c in 0..3 {
        for r in 0..3 {
            let of = |k: usize| simd.mul_f64s(before[3 * k + r], rotation[c][k]);
            pose[3 * c + r] = simd.add_f64s(simd.add_f64s(of(0), of(1)), of(2));
        }
    }
}

/// Columns of the rotation about a unit axis (Rodrigues' formula).
#[inline(always)]
fn axis_rotation<S: Simd>(simd: S, axis: &Vec3, sine: S::f64s, cosine: S::f64s) -> [[S::f64s; 3]; 3] {
    let versine = simd.sub_f64s(simd.splat_f64s(1.0), cosine);
    let [x, y, z] = [simd.splat_f64s(axis.x), simd.splat_f64s(axis.y), simd.splat_f64s(axis.z)];
    let scaled = [simd.mul_f64s(sine, x), simd.mul_f64s(sine, y), simd.mul_f64s(sine, z)];
    let square = |r: usize, c: usize| simd.mul_f64s(versine, simd.splat_f64s(axis[r] * axis[c]));
    let plus = |a: S::f64s, b: S::f64s| simd.add_f64s(a, b);
    let minus = |a: S::f64s, b: S::f64s| simd.sub_f64s(a, b);
    [
        [plus(cosine, square(0, 0)), plus(square(1, 0), scaled[2]), minus(square(2, 0), scaled[1])],
        [minus(square(0, 1), scaled[2]), plus(cosine, square(1, 1)), plus(square(2, 1), scaled[0])],
        [plus(square(0, 2), scaled[1]), minus(square(1, 2), scaled[0]), plus(cosine, square(2, 2))],
    ]
}

/// Columns of the rotation by a unit quaternion x, y, z, w.
#[inline(always)]
fn quaternion_matrix<S: Simd>(simd: S, [x, y, z, w]: [S::f64s; 4]) -> [[S::f64s; 3]; 3] {
    let (one, two) = (simd.splat_f64s(1.0), simd.splat_f64s(2.0));
    let mul = |a: S::f64s, b: S::f64s| simd.mul_f64s(a, b);
    let twice_sum = |a: S::f64s, b: S::f64s| simd.mul_f64s(two, simd.add_f64s(a, b));
    let twice_difference = |a: S::f64s, b: S::f64s| simd.mul_f64s(two, simd.sub_f64s(a, b));
    let diagonal = |a: S::f64s, b: S::f64s| simd.sub_f64s(one, twice_sum(mul(a, a), mul(b, b)));
    [
        [diagonal(y, z), twice_sum(mul(x, y), mul(w, z)), twice_difference(mul(x, z), mul(w, y))],
        [twice_difference(mul(x, y), mul(w, z)), diagonal(x, z), twice_sum(mul(y, z), mul(w, x))],
        [twice_sum(mul(x, z), mul(w, y)), twice_difference(mul(y, z), mul(w, x)), diagonal(x, y)],
    ]
}
