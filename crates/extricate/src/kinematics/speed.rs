//! Bounds on the speed of points fixed to a frame while the configuration runs along a geodesic at
//! constant rates.

use crate::math::{Pose, Vec3};
use crate::scene::{Motion, Scene};

/// Appends upper bounds [m per unit of time] on the speed of every point of a ball to `speeds`. The
/// ball is fixed to `frame`; speeds are as seen from that frame (0), from its parent, and so on up
/// to the world.
///
/// `poses` are the present ones; `rates` is the constant velocity in tangent coordinates (length
/// `nv`, see [`crate::cspace::ConfigSpace::difference`]).
///
/// # Guarantee
/// The bounds hold for all times within `spell` of the present. Seen from a joint's own frame, a
/// point moves no farther than the joints nearer to it allow. So its distance from the joint's axis
/// is at most the present one plus that. Its speed as seen from the parent is at most that seen
/// from the frame, plus the turning rate times that distance (or the sliding rate).
pub fn ball_speeds(
    scene: &Scene,
    poses: &[Pose],
    rates: &[f64],
    spell: f64,
    (mut frame, center, radius): (usize, &Vec3, f64),
    speeds: &mut Vec<f64>,
) {
    let mut speed = 0.0;
    speeds.push(speed);
    while frame != 0 {
        let pose = &poses[frame];
        let arm = center - pose.translation;
        match &scene.frames[frame].motion {
            Motion::World => {}
            Motion::Revolute { axis, coordinate } => {
                let lever = pose.vector(axis).cross(&arm).norm() + radius + spell * speed;
                speed += (coordinate.multiplier * rates[coordinate.v]).abs() * lever;
            }
            Motion::Prismatic { coordinate, .. } => speed += (coordinate.multiplier * rates[coordinate.v]).abs(),
            Motion::Ball { v, .. } => {
                let rate = Vec3::new(rates[*v], rates[v + 1], rates[v + 2]).norm();
                speed += rate * (arm.norm() + radius + spell * speed);
            }
        }
        speeds.push(speed);
        frame = scene.frames[frame].parent;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::sampling::Halton;
    use crate::kinematics::forward;
    use crate::scene::builtin;

    #[test]
    fn no_point_of_the_ball_is_faster() {
        let mut tightest: f64 = 0.0;
        for name in builtin::NAMES {
            let scene = builtin::scene(name).unwrap();
            let space = &scene.space;
            let halton = Halton::new(space.nv(), 9);
            let [mut a, mut b, mut q] = [(); 3].map(|()| vec![0.0; space.nq()]);
            let (mut rates, mut now, mut then) = (vec![0.0; space.nv()], Vec::new(), Vec::new());
            let (local, radius) = (Vec3::new(0.05, -0.1, 0.2), 0.15);
            let mut speeds = Vec::new();
            for k in 0..40 {
                halton.config(space, 2 * k, &mut a);
                halton.config(space, 2 * k + 1, &mut b);
                space.difference(&a, &b, &mut rates);
                space.interpolate(&a, &b, 0.5, &mut q);
                forward(&scene, &q, &mut now);
                let spell = [0.5, 0.1, 1e-3][k as usize % 3];
                for frame in 0..scene.frames.len() {
                    speeds.clear();
                    let ball = (frame, &now[frame].point(&local), radius);
                    ball_speeds(&scene, &now, &rates, spell, ball, &mut speeds);
                    for step in [-1.0, -0.4, 0.7, 1.0] {
                        space.interpolate(&a, &b, 0.5 + step * spell, &mut q);
                        forward(&scene, &q, &mut then);
                        for direction in [Vec3::x(), -Vec3::y(), Vec3::z(), Vec3::zeros()] {
                            let point = local + radius * direction;
                            let mut seen_from = frame;
                            for speed in &speeds {
                                let at = |poses: &[Pose]| poses[seen_from].inverse_point(&poses[frame].point(&point));
                                let moved = (at(&then) - at(&now)).norm();
                                let bound = speed * spell * f64::abs(step);
                                assert!(moved <= bound + 1e-9, "{name} {frame} from {seen_from}: {moved} {bound}");
                                if bound > 0.0 {
                                    tightest = tightest.max(moved / bound);
                                }
                                seen_from = scene.frames[seen_from].parent;
                            }
                        }
                    }
                }
            }
        }
        assert!(tightest > 0.9, "{tightest}");
    }
}
