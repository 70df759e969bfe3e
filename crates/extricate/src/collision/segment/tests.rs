//! Segment checks against closed forms and dense samples.

use crate::collision::{CheckScratch, Checker, SegmentOptions, SegmentOutcome};
use crate::cspace::sampling::Halton;
use crate::cspace::{ConfigSpace, Label, Manifold};
use crate::math::{Pose, Vec3};
use crate::robot::Geometry;
use crate::scene::clearances::Clearances;
use crate::scene::{Body, BodyPair, Coordinate, Frame, MetricKind, Motion, Part, Scene, builtin};

const CLEARANCE: f64 = 1e-3;

/// Makes a scene with one joint that carries a shape, and one obstacle.
fn one_joint(turns: bool, carried: (Vec3, Geometry), obstacle: (Vec3, Geometry)) -> Checker {
    let mut space = ConfigSpace::default();
    let (q, v) = space.push("j", Manifold::Interval { lower: -3.0, upper: 3.0 }, 1.0);
    let coordinate = Coordinate { q, v, multiplier: 1.0, offset: 0.0 };
    let motion = if turns {
        Motion::Revolute { axis: Vec3::z(), coordinate }
    } else {
        Motion::Prismatic { axis: Vec3::x(), coordinate }
    };
    let frame = |motion| Frame { name: "f".into(), parent: 0, pose_parent_joint: Pose::identity(), motion };
    let body = |name: &str, frame, (at, geometry)| {
        let parts = vec![Part { pose_frame_part: Pose::translation(at), geometry }];
        Body { name: name.into(), robot: (frame > 0).then_some(0), frame, parts }
    };
    let scene = Scene {
        clearance: CLEARANCE,
        metric: MetricKind::Joint,
        joints: vec![],
        space,
        frames: vec![frame(Motion::World), frame(motion)],
        bodies: vec![body("arm", 1, carried), body("wall", 0, obstacle)],
        pairs: vec![BodyPair { first: 0, second: 1 }],
        warnings: vec![],
        links: vec![],
        clearances: Clearances::default(),
        rigid: vec![],
    };
    Checker::new(scene.into())
}

fn cuboid(x: f64, y: f64, z: f64) -> Geometry {
    Geometry::Box { half_extents: [x, y, z] }
}

fn ask(checker: &Checker, from: f64, to: f64) -> SegmentOutcome {
    checker.segment(&[from], &[to], &SegmentOptions::default(), &mut CheckScratch::default())
}

/// Asserts a contact at coordinate `exact`, met at a speed of `speed` \[m\] per unit of the
/// coordinate.
fn assert_meets(checker: &Checker, from: f64, to: f64, exact: f64, speed: f64) {
    let SegmentOutcome::Contact { free_until, colliding_at, pair } = ask(checker, from, to) else {
        panic!("{:?}", ask(checker, from, to));
    };
    assert_eq!(pair.index(), 0);
    let [free, colliding] = [free_until, colliding_at].map(|t| from + t * (to - from));
    assert!((free - exact) * (to - from).signum() <= 1e-9, "{free} {exact}");
    assert!((colliding - exact) * (to - from).signum() >= -1e-9, "{colliding} {exact}");
    assert!((colliding - free).abs() * speed <= 1.1e-4, "{free} {colliding}");
}

#[test]
fn a_box_that_slides_meets_a_box_where_it_should() {
    let slider = |wall: (Vec3, Geometry)| one_joint(false, (Vec3::zeros(), cuboid(0.1, 0.1, 0.1)), wall);
    let checker = slider((Vec3::x(), cuboid(0.2, 0.3, 0.3)));
    assert_meets(&checker, -1.0, 1.0, 0.7 - CLEARANCE, 1.0);
    assert_meets(&checker, 2.0, -0.5, 1.3 + CLEARANCE, 1.0);
    assert_eq!(ask(&checker, -3.0, 0.69), SegmentOutcome::Free);
    assert_eq!(ask(&checker, 0.5, 0.5), SegmentOutcome::Free);
    assert!(matches!(ask(&checker, 0.9, 2.0), SegmentOutcome::Contact { free_until: 0.0, colliding_at: 0.0, .. }));
    // Past a wall beside the path: clearly free, clearly in contact, and too near to decide.
    for (beside, found) in [(2e-4, "Free"), (-2e-4, "Contact"), (1e-6, "Undecided")] {
        let checker = slider((Vec3::new(1.0, 0.4 + CLEARANCE + beside, 0.0), cuboid(0.2, 0.3, 0.3)));
        let outcome = ask(&checker, -1.0, 3.0);
        assert!(format!("{outcome:?}").starts_with(found), "{beside}: {outcome:?}");
    }
}

#[test]
fn a_sheet_that_samples_miss_is_met() {
    let ball = || (Vec3::zeros(), Geometry::Sphere { radius: 1e-3 });
    let checker = one_joint(false, ball(), (Vec3::x() * 0.377, cuboid(1e-5, 1.0, 1.0)));
    let mut scratch = CheckScratch::default();
    let coarse = (0..=100).map(|k| -1.0 + f64::from(k) * 0.02);
    assert!(coarse.map(|x| checker.label(&[x], &mut scratch)).all(|label| label == Label::Free));
    assert_meets(&checker, -1.0, 1.0, 0.377 - 1e-5 - 1e-3 - CLEARANCE, 1.0);
}

#[test]
fn an_arm_that_turns_meets_a_wall_where_it_should() {
    // A ball at 1 m from the axis meets the plane y = 0.5 where sin(q) = 0.5 - radius - clearance.
    let (radius, wall) = (0.05, (Vec3::new(0.0, 1.5, 0.0), cuboid(3.0, 1.0, 1.0)));
    let checker = one_joint(true, (Vec3::x(), Geometry::Sphere { radius }), wall);
    let exact = f64::asin(0.5 - radius - CLEARANCE);
    assert_meets(&checker, -1.0, 1.2, exact, 1.05);
    assert_meets(&checker, 3.0, -1.0, std::f64::consts::PI - exact, 1.05);
    assert_eq!(ask(&checker, -2.9, exact - 1e-3), SegmentOutcome::Free);
}

#[test]
fn nothing_that_dense_samples_find_is_called_free() {
    let mut counts = [0; 3];
    for name in builtin::NAMES {
        let checker = Checker::new(builtin::scene(name).unwrap().into());
        let space = &checker.scene().space;
        let halton = Halton::new(space.nv(), 21);
        let [mut a, mut b, mut q] = [(); 3].map(|()| vec![0.0; space.nq()]);
        let mut scratch = CheckScratch::default();
        let mut asked = 0;
        for k in 0.. {
            halton.config(space, 2 * k, &mut a);
            halton.config(space, 2 * k + 1, &mut q);
            space.interpolate(&a, &q, [1.0, 0.3, 0.05][k as usize % 3], &mut b);
            if checker.label(&a, &mut scratch) == Label::Colliding {
                continue;
            }
            let outcome = checker.segment(&a, &b, &SegmentOptions::default(), &mut scratch);
            let fresh = checker.segment(&a, &b, &SegmentOptions::default(), &mut CheckScratch::default());
            assert_eq!(outcome, fresh, "what came before does not count");
            let mut at = |t: f64| {
                space.interpolate(&a, &b, t, &mut q);
                checker.label(&q, &mut scratch)
            };
            let free_until = match outcome {
                SegmentOutcome::Free => 1.0,
                SegmentOutcome::Contact { free_until, colliding_at, .. } => {
                    assert!(free_until < colliding_at && at(colliding_at) == Label::Colliding);
                    free_until
                }
                SegmentOutcome::Undecided { free_until, .. } => free_until,
            };
            counts[match outcome {
                SegmentOutcome::Free => 0,
                SegmentOutcome::Contact { .. } => 1,
                SegmentOutcome::Undecided { .. } => 2,
            }] += 1;
            for sample in 0..=10_000 {
                let t = free_until * f64::from(sample) / 1e4;
                assert_eq!(at(t), Label::Free, "{name} {k}: {t} of {free_until}");
            }
            asked += 1;
            if asked == 9 {
                break;
            }
        }
    }
    let [free, contact, undecided] = counts;
    assert!(free >= 10 && contact >= 10 && undecided <= 2, "{counts:?}");
}
