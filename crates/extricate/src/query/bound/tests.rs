//! Depths by balls against exact depths, and the convexity that quick bounds rest on.

use std::sync::Arc;

use crate::collision::Checker;
use crate::cspace::sampling::Halton;
use crate::math::Vec3;
use crate::metric::Metric;
use crate::query::bound::*;
use crate::query::inner_balls::InnerBalls;
use crate::scene::builtin;
use rand::{RngExt, SeedableRng};

#[test]
fn points_lie_at_least_as_deep_as_balls_say() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
    let (mut inside, mut exact, mut told) = (0, 0.0, 0.0);
    for name in ["hand", "shelf-arm", "free-box"] {
        let checker = Checker::new(builtin::scene(name).unwrap().into());
        let of_bodies = InnerBalls::new(&checker, None).bodies;
        for (body, balls) in of_bodies.iter().enumerate().filter(|(_, balls)| !balls.all.is_empty()) {
            // Test a centre too, because most digits are lost there.
            let centre = balls.all[0].centre;
            let mut depths = [[0.0; LANES]];
            balls.depths(&Pose::identity(), [[centre.x, centre.y, centre.z].map(|x| [x; LANES])].iter(), &mut depths);
            let radius = balls.all[0].radius;
            let is_near = |depth: &f64| *depth <= radius && *depth >= radius * (1.0 - 1e-7);
            assert!(!balls.hold_some() || depths[0].iter().all(is_near), "{name} {body}: {depths:?}");
            for _ in 0..50 {
                let mut number = |scale: f64| scale * (rng.random::<f64>() - 0.5);
                let pose = Pose::from_xyz_rpy([0.0; 3].map(|_| number(0.1)), [0.0; 3].map(|_| number(6.0)));
                let points = [[0.0; LANES]; 3].map(|axis| axis.map(|_| number(0.2)));
                let mut depths = [[0.0; LANES]];
                balls.depths(&pose, [points].iter(), &mut depths);
                for lane in 0..LANES {
                    let point = pose.point(&Vec3::from(points.map(|axis| axis[lane])));
                    let depth = checker.solid_depth(body, &point);
                    assert!(depths[0][lane] <= depth + 1e-12, "{name} {body} {point}: {depth} {depths:?}");
                    if depth > 0.0 {
                        inside += 1;
                        exact += depth;
                        told += depths[0][lane].max(0.0);
                    }
                }
            }
        }
    }
    println!("of the depths of {inside} points inside, balls tell {:.3}", told / exact);
    assert!(inside > 500 && told > 0.4 * exact, "{inside} {told} {exact}");
}

/// A quick bound takes a chord of the motion bound, which is safe if the motion bound is convex.
#[test]
fn motion_bounds_are_convex() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    for name in ["hand", "dual-arm", "free-box"] {
        let scene = Arc::new(builtin::scene(name).unwrap());
        let (metric, checker) = (Metric::new(scene.clone()), Checker::new(scene.clone()));
        let (mut check, mut path) = (CheckScratch::default(), MotionPath::default());
        let (halton, mut q) = (Halton::new(scene.space.nv(), 3), vec![0.0; scene.space.nq()]);
        for index in 0..300 {
            halton.config(&scene.space, index, &mut q);
            checker.label(&q, &mut check);
            let [of, relative_to] = [0, 0].map(|_: usize| rng.random_range(0..scene.frames.len()));
            let position = Vec3::from_fn(|_, _| 2.0 * (rng.random::<f64>() - 0.5));
            let point = BoundedPoint { position, of, relative_to, inside_of: true, inside_relative_to: false };
            metric.motion_between(check.poses(), of, relative_to, &mut path);
            metric.motion_of(check.poses(), &point, &mut path);
            let (low, high) = (rng.random::<f64>(), 1.0 + 2.0 * rng.random::<f64>());
            let chord = 0.5 * (path.bound(low) + path.bound(high));
            let middle = path.bound(0.5 * (low + high));
            assert!(middle <= chord * (1.0 + 1e-12), "{name} {of} {relative_to} {position}: {middle} {chord}");
        }
    }
}
