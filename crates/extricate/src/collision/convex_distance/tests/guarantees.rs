//! The guarantees of the functions, for every kind of shape, size and degree of contact.

use crate::collision::convex_distance::tests::*;

fn random_shape(rng: &mut ChaCha8Rng) -> ConvexShape {
    let radius = if rng.random::<f64>() < 0.4 { 0.2 * rng.random::<f64>() } else { 0.0 };
    let core = if rng.random::<f64>() < 0.3 {
        ConvexCore::Cylinder { radius: 0.5 * rng.random::<f64>(), half_length: 0.5 * rng.random::<f64>() }
    } else {
        random_polytope(rng)
    };
    rounded(core, radius)
}

/// Returns the distance by which the plane at a right angle to `normal` parts the shapes (negative:
/// it does not).
fn parted_along(shapes: &[ConvexShape; 2], poses: &[Pose; 2], normal: &Vec3) -> f64 {
    let lowest = |k: usize, along: &Vec3| {
        let support = shapes[k].core.support(&poses[k].inverse_vector(&-along));
        poses[k].point(&support).dot(along) - shapes[k].radius
    };
    lowest(0, normal) + lowest(1, &-normal)
}

fn scaled(shape: &ConvexShape, size: f64) -> ConvexShape {
    let core = match &shape.core {
        ConvexCore::Point => ConvexCore::Point,
        ConvexCore::Segment { half_length } => ConvexCore::Segment { half_length: half_length * size },
        ConvexCore::Box { half_extents } => ConvexCore::Box { half_extents: half_extents * size },
        ConvexCore::Cylinder { radius, half_length } => {
            ConvexCore::Cylinder { radius: radius * size, half_length: half_length * size }
        }
        ConvexCore::Triangle(corners) => ConvexCore::Triangle(corners.map(|corner| corner * size)),
        ConvexCore::Hull(hull) => {
            ConvexCore::Hull(HullPoints::new(&hull.points().iter().map(|p| p * size).collect::<Vec<_>>()))
        }
        ConvexCore::Prism { top, bottom } => ConvexCore::Prism { top: top.map(|p| p * size), bottom: bottom * size },
    };
    rounded(core, shape.radius * size)
}

#[test]
fn both_bounds_meet_and_the_queries_agree() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for _ in 0..4_000 {
        let size = 10.0_f64.powf(-3.0 + 4.0 * rng.random::<f64>());
        let shapes = [scaled(&random_shape(&mut rng), size), scaled(&random_shape(&mut rng), size)];
        let mut poses = [random_pose(&mut rng, 0.6 * size), random_pose(&mut rng, 0.6 * size)];
        let curved = shapes.iter().any(|shape| shape.core.is_curved());
        let tolerance = size.max(0.1) * if curved { 1e-7 } else { 1e-9 };
        for step in 0..4 {
            let ask = |cutoff: f64| separation(&shapes[0], &poses[0], &shapes[1], &poses[1], cutoff);
            let near = |threshold: f64| nearer_than(&shapes[0], &poses[0], &shapes[1], &poses[1], threshold);
            let found = ask(f64::INFINITY).unwrap();
            let context = || format!("{found:?} {poses:?} {shapes:?}");
            // Proved from both sides: a plane parts the shapes by the distance, and the depth is no
            // less than the bound.
            let parted = parted_along(&shapes, &poses, &found.normal);
            // Between two vertices the normal is as good as rounding leaves it.
            let noise = if found.distance > 0.0 { 1e-15 * size * size / found.distance } else { 0.0 };
            assert!((parted - found.distance).abs() < tolerance + noise, "{parted} {}", context());
            let gap = -found.distance - found.depth_lower;
            assert!((-1e-14 * size..tolerance).contains(&gap), "{gap} {}", context());
            let between = found.point_first - found.point_second;
            assert!((between.dot(&found.normal) - found.distance).abs() < tolerance, "{}", context());

            let swapped = separation(&shapes[1], &poses[1], &shapes[0], &poses[0], f64::INFINITY).unwrap();
            assert!((swapped.distance - found.distance).abs() < tolerance, "{swapped:?} {}", context());

            let step_size = (1e-6 * found.distance.abs()).max(1.5 * tolerance);
            assert!(
                ask(found.distance + step_size).is_some() && ask(found.distance - step_size).is_none(),
                "{}",
                context()
            );
            assert!(near(found.distance + step_size) && !near(found.distance - step_size), "{}", context());

            let mut guess = random_vector(&mut rng);
            for _ in 0..2 {
                let again = separation_from(&mut guess, &shapes[0], &poses[0], &shapes[1], &poses[1], f64::INFINITY);
                assert!((again.unwrap().distance - found.distance).abs() < tolerance, "{again:?} {}", context());
                let below = found.distance - step_size;
                assert!(!nearer_than_from(&mut guess, &shapes[0], &poses[0], &shapes[1], &poses[1], below));
            }

            let contact = size * 10.0_f64.powf(-4.0 - 8.0 * rng.random::<f64>());
            let target = [0.0, contact, -contact][step % 3];
            poses[0].translation += found.normal * (target - found.distance);
        }
    }
}

#[test]
fn a_slack_distance_is_proved_and_not_much_too_small() {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let (mut early, mut exact) = (0, 0);
    for _ in 0..20_000 {
        let shapes = [random_shape(&mut rng), random_shape(&mut rng)];
        let poses = [random_pose(&mut rng, 1.0), random_pose(&mut rng, 1.0)];
        let slack = Slack { gap: 0.5 * rng.random::<f64>(), beyond: 0.1 * rng.random::<f64>(), ..Slack::NONE };
        let [first, second] = &shapes;
        let ask = |slack: Slack| {
            let mut last = LastFeatures::default();
            separation_near(&mut last, first, &poses[0], second, &poses[1], f64::INFINITY, slack).unwrap()
        };
        let (found, told) = (ask(Slack::NONE), ask(slack));
        let context = || format!("{found:?} {told:?} {slack:?} {poses:?} {shapes:?}");
        if (told.distance - found.distance).abs() < 1e-7 {
            exact += usize::from(found.distance < slack.beyond);
            continue;
        }
        early += 1;
        assert!(told.distance > slack.beyond && told.distance < found.distance, "{}", context());
        assert!(told.distance > (1.0 - slack.gap) * found.distance - 1e-9, "{}", context());
        assert!(parted_along(&shapes, &poses, &told.normal) > told.distance - 1e-9, "{}", context());
    }
    assert!(early > 1_000 && exact > 1_000, "{early} {exact}");
}

#[test]
fn shapes_that_are_not_numbers_end() {
    let shape = rounded(ConvexCore::Hull(HullPoints::new(&[Vec3::x(), Vec3::y(), Vec3::z(), -Vec3::x()])), 0.0);
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        let pose = Pose::translation(Vec3::new(bad, 0.0, 0.0));
        separation(&shape, &pose, &shape, &Pose::identity(), f64::INFINITY);
        nearer_than(&shape, &pose, &shape, &Pose::identity(), 0.0);
    }
}
