//! Metric axioms, embeddings, Monte Carlo integration and motion bounds, on the built-in scenes.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::motion_bound::{BoundedPoint, MotionPath};
use crate::cspace::sampling::uniform;
use crate::math::{LANES, Vec3};
use crate::metric::*;
use crate::robot::Geometry;
use crate::scene::builtin;

const KINDS: [MetricKind; 3] = [MetricKind::Joint, MetricKind::ObjectNorm, MetricKind::MaxDisplacement];

fn each(mut check: impl FnMut(&Metric, &mut dyn FnMut() -> Vec<f64>, &str)) {
    for name in builtin::NAMES {
        let scene = Arc::new(builtin::scene(name).unwrap());
        for kind in KINDS {
            let metric = Metric::of_kind(scene.clone(), kind);
            let mut rng = ChaCha8Rng::seed_from_u64(5);
            let mut sample = || {
                let mut q = vec![0.0; scene.space.nq()];
                uniform(&scene.space, &mut rng, &mut q);
                q
            };
            check(&metric, &mut sample, name);
        }
    }
}

#[test]
fn metrics_obey_the_axioms_and_embeddings_stay_below() {
    each(|metric, sample, name| {
        let mut scratch = MetricScratch::default();
        let mut embed = |q: &[f64]| {
            let mut out = vec![0.0; metric.embedding_len()];
            metric.embed(q, &mut scratch, &mut out);
            out
        };
        for _ in 0..60 {
            let (a, b, c) = (sample(), sample(), sample());
            let (ab, bc, ac) = (metric.distance(&a, &b), metric.distance(&b, &c), metric.distance(&a, &c));
            assert!(metric.distance(&a, &a) < 1e-7);
            assert!(ab > 0.0 && (ab - metric.distance(&b, &a)).abs() < 1e-9 * ab);
            assert!(ac <= (ab + bc) * (1.0 + 1e-12), "{name}: triangle inequality, {ac} > {ab} + {bc}");
            let chord = euclidean(&embed(&a), &embed(&b));
            assert!(chord <= ab * (1.0 + 1e-9) + 1e-12, "{name} {:?}: embedding {chord} > {ab}", metric.kind());
            if metric.kind() == MetricKind::ObjectNorm {
                assert!((chord - ab).abs() < 1e-9);
            }
        }
    });
}

#[test]
fn near_configurations_are_near() {
    each(|metric, sample, _| {
        let space = &metric.scene().space;
        let (a, mut b) = (sample(), vec![0.0; space.nq()]);
        let step: Vec<f64> = (0..space.nv()).map(|k| 1e-6 * (k as f64 + 1.0)).collect();
        space.integrate(&a, &step, &mut b);
        assert!(metric.distance(&a, &b) < 1e-3);
    });
}

/// Compares the object norm's closed form with a Monte Carlo integral over the volume of a box.
#[test]
fn object_norm_is_the_integral_over_the_volume() {
    let scene = Arc::new(builtin::scene("free-box").unwrap());
    let metric = Metric::of_kind(scene.clone(), MetricKind::ObjectNorm);
    let body = scene.bodies.iter().find(|b| b.robot.is_some()).unwrap();
    let Geometry::Box { half_extents } = &body.parts[0].geometry else { panic!("free-box carries a box") };
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let (mut a, mut b) = (vec![0.0; scene.space.nq()], vec![0.0; scene.space.nq()]);
    uniform(&scene.space, &mut rng, &mut a);
    uniform(&scene.space, &mut rng, &mut b);
    let (mut from, mut to) = (Vec::new(), Vec::new());
    forward(&scene, &a, &mut from);
    forward(&scene, &b, &mut to);
    let (mut sum, count) = (0.0, 200_000);
    for _ in 0..count {
        let corner = Vec3::from_fn(|_, _| rng.random::<f64>() * 2.0 - 1.0);
        let point = body.parts[0].pose_frame_part.point(&corner.component_mul(&Vec3::from(*half_extents)));
        sum += (from[body.frame].point(&point) - to[body.frame].point(&point)).norm_squared();
    }
    let sampled = (sum / f64::from(count)).sqrt();
    let closed = metric.distance(&a, &b);
    assert!((sampled - closed).abs() < 3e-3 * closed, "{sampled} {closed}");
}

/// No point of any body moves farther than its motion bound, seen from the world or from another
/// body.
#[test]
fn motion_bounds_are_never_exceeded() {
    each(|metric, sample, name| {
        let scene = metric.scene();
        let space = &scene.space;
        let mut scratch = MotionPath::default();
        let (mut from, mut to) = (Vec::new(), Vec::new());
        let moving: Vec<&crate::scene::Body> = scene.bodies.iter().filter(|b| b.frame != 0).collect();
        for round in 0..200 {
            let (a, far) = (sample(), sample());
            let mut b = far.clone();
            // Steps reach from 1/256 of the way to all of it.
            space.interpolate(&a, &far, 0.5_f64.powi(round % 9), &mut b);
            forward(scene, &a, &mut from);
            forward(scene, &b, &mut to);
            let distance = metric.distance(&a, &b);
            for body in &moving {
                let tessellated = body.parts[0].geometry.tessellate(6);
                let local = body.parts[0]
                    .pose_frame_part
                    .point(&tessellated.vertices[round as usize % tessellated.vertices.len()]);
                for other in [0, moving[round as usize % moving.len()].frame] {
                    if other == body.frame {
                        continue;
                    }
                    let position = from[body.frame].point(&local);
                    let point = BoundedPoint {
                        position,
                        of: body.frame,
                        relative_to: other,
                        inside_of: true,
                        inside_relative_to: false,
                    };
                    let seen_before = from[other].inverse_point(&position);
                    let seen_after = to[other].inverse_point(&to[body.frame].point(&local));
                    let moved = (seen_after - seen_before).norm();
                    let bound = metric.motion_bound(&from, &point, distance, &mut scratch);
                    assert!(moved <= bound * (1.0 + 1e-9) + 1e-12, "{name} {:?}: {moved} > {bound}", metric.kind());
                    let eight =
                        scratch.levers().squared_rates(&[position.x, position.y, position.z].map(|x| [x; LANES]));
                    let quick = distance * eight[round as usize % LANES].sqrt();
                    assert!(quick <= bound * (1.0 + 1e-12), "{name} {:?}: {quick} > {bound}", metric.kind());
                }
            }
        }
    });
}

/// Compares the closed forms for balls and rims with dense samples of them.
#[test]
fn largest_displacement_is_attained_on_round_shapes() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut number = || rng.random::<f64>() * 2.0 - 1.0;
    for _ in 0..50 {
        let mut pose = || {
            let v = [number(), number(), number()];
            Pose::from_xyz_rpy([number(), number(), number()], v.map(|x| 3.0 * x))
        };
        let (from, to) = (pose(), pose());
        let frame =
            extremes::FrameExtremes { frame: 0, balls: vec![(Vec3::new(0.1, 0.2, 0.3), 0.5)], ..Default::default() };
        let rim = extremes::FrameExtremes {
            frame: 0,
            circles: vec![(Vec3::new(0.1, 0.2, 0.3), Vec3::x() * 0.5, Vec3::y() * 0.5)],
            ..Default::default()
        };
        let exact = |f: &extremes::FrameExtremes| {
            {
                let mut f = f.clone();
                f.radius = f64::INFINITY;
                extremes::Extremes { frames: vec![f] }
            }
            .max_displacement(&[from], &[to])
        };
        let displacement = |offset: Vec3| {
            let point = Vec3::new(0.1, 0.2, 0.3) + offset;
            (from.point(&point) - to.point(&point)).norm()
        };
        let (mut ball, mut circle) = (0.0_f64, 0.0_f64);
        for i in 0..400 {
            let t = f64::from(i) / 400.0 * std::f64::consts::TAU;
            circle = circle.max(displacement(Vec3::new(t.cos(), t.sin(), 0.0) * 0.5));
            for j in 0..200 {
                let z = f64::from(j) / 99.5 - 1.0;
                let r = (1.0 - z * z).max(0.0).sqrt();
                ball = ball.max(displacement(Vec3::new(r * t.cos(), r * t.sin(), z) * 0.5));
            }
        }
        assert!(ball <= exact(&frame) + 1e-12 && exact(&frame) < ball + 2e-3, "{ball} {}", exact(&frame));
        assert!(circle <= exact(&rim) + 1e-12 && exact(&rim) < circle + 2e-3, "{circle} {}", exact(&rim));
    }
}

/// Slow twin: of all samples, one by one, the farthest is found. All found ones are far, and those
/// of one frame are far from each other.
#[test]
fn the_farthest_points_are_found() {
    let (mut far, mut several) = (extremes::FarPoints::default(), 0);
    for name in builtin::NAMES {
        let scene = Arc::new(builtin::scene(name).unwrap());
        let metric = Metric::of_kind(scene.clone(), MetricKind::MaxDisplacement);
        let (mut from, mut to) = (Vec::new(), Vec::new());
        for (a, b) in sampled_pairs(&scene).take(20) {
            forward(&scene, &a, &mut from);
            forward(&scene, &b, &mut to);
            metric.extremes().farthest(&from, &to, &mut far);
            let frames = &metric.extremes().frames;
            let moved = |frame: usize, p: &Vec3| (to[frame].point(p) - from[frame].point(p)).norm();
            let all = frames.iter().flat_map(|f| f.samples.iter().map(|p| moved(f.frame, p)));
            let largest = all.fold(0.0, f64::max);
            let found = far.points.iter().map(|p| p.distance).fold(0.0, f64::max);
            assert!((found - largest).abs() < 1e-12, "{name}: {found} {largest}");
            for (i, point) in far.points.iter().enumerate() {
                let local = to[point.frame].inverse_point(&point.now);
                assert!((moved(point.frame, &local) - point.distance).abs() < 1e-12 && point.distance > 0.79 * largest);
                assert!((point.moved.norm() - point.distance).abs() < 1e-12);
                let radius = frames.iter().find(|f| f.frame == point.frame).unwrap().radius;
                let others = far.points[..i].iter().filter(|other| other.frame == point.frame);
                for other in others {
                    several += 1;
                    assert!((other.now - point.now).norm() > 0.149 * radius);
                }
            }
        }
    }
    assert!(several > 100, "{several}");
}
