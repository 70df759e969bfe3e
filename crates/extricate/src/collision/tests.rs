//! The checker as a whole, against closed forms and against itself, on small scenes built by hand.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::shapes::test_mesh::{bumpy, cuboid, joined, opened, placed};
use super::{CheckScratch, Checker, Contact, ContactQuery, ContactSearch, always_colliding, most_often_colliding};
use crate::cspace::sampling::uniform;
use crate::cspace::{ConfigSpace, Label, Manifold};
use crate::kinematics;
use crate::math::{Pose, Vec3};
use crate::robot::{Geometry, TriangleMesh};
use crate::scene::clearances::Clearances;
use crate::scene::{Body, BodyPair, Coordinate, Frame, MetricKind, Motion, PairId, Part, Scene};

/// Bodies that fly freely (x, y, z within 4 m, quaternion), all pairs checked, clearance 1 mm.
fn flying(bodies: Vec<Vec<Part>>) -> Checker {
    let mut space = ConfigSpace::default();
    let still = Frame { name: "world".into(), parent: 0, pose_parent_joint: Pose::identity(), motion: Motion::World };
    let mut frames = vec![still.clone()];
    let mut scene_bodies = Vec::new();
    for (k, parts) in bodies.into_iter().enumerate() {
        let mut parent = 0;
        for axis in 0..3 {
            let (q, v) = space.push(format!("{k}.{axis}"), Manifold::Interval { lower: -4.0, upper: 4.0 }, 1.0);
            let coordinate = Coordinate { q, v, multiplier: 1.0, offset: 0.0 };
            let motion = Motion::Prismatic { axis: Vec3::ith(axis, 1.0), coordinate };
            frames.push(Frame { parent, motion, ..still.clone() });
            parent = frames.len() - 1;
        }
        let (q, v) = space.push(format!("{k}.r"), Manifold::Rotation, 1.0);
        frames.push(Frame { parent, motion: Motion::Ball { q, v }, ..still.clone() });
        scene_bodies.push(Body { name: k.to_string(), robot: Some(k), frame: frames.len() - 1, parts });
    }
    let count = scene_bodies.len();
    let pairs = (0..count).flat_map(|first| (first + 1..count).map(move |second| BodyPair { first, second })).collect();
    let (metric, joints, warnings) = (MetricKind::Joint, vec![], vec![]);
    let (links, clearances) = (vec![], Clearances::default());
    let bodies = scene_bodies;
    let rigid = vec![];
    let scene =
        Scene { clearance: 1e-3, metric, joints, space, frames, bodies, pairs, warnings, links, clearances, rigid };
    Checker::new(Arc::new(scene))
}

fn part(geometry: Geometry) -> Vec<Part> {
    vec![Part { pose_frame_part: Pose::identity(), geometry }]
}

fn mesh(mesh: TriangleMesh) -> Vec<Part> {
    part(Geometry::Mesh(Arc::new(mesh)))
}

/// Returns the coordinates of bodies at these positions, none rotated.
fn at(positions: &[[f64; 3]]) -> Vec<f64> {
    positions.iter().flat_map(|[x, y, z]| [*x, *y, *z, 0.0, 0.0, 0.0, 1.0]).collect()
}

fn two(checker: &Checker, x: f64) -> (Label, f64) {
    let q = at(&[[x, 0.0, 0.0], [0.0; 3]]);
    let mut scratch = CheckScratch::default();
    (checker.label(&q, &mut scratch), checker.clearance(&q, &mut scratch))
}

#[test]
fn primitives_in_closed_form() {
    let ball = || part(Geometry::Sphere { radius: 0.5 });
    let block = part(Geometry::Box { half_extents: [1.0, 2.0, 3.0] });
    let can = part(Geometry::Cylinder { radius: 0.25, half_length: 1.0 });
    let pill = part(Geometry::Capsule { radius: 0.25, half_length: 1.0 });
    let cube = mesh(cuboid(Vec3::zeros(), Vec3::new(1.0, 2.0, 3.0)));
    let hull = part(Geometry::ConvexHull(Arc::new(cuboid(Vec3::zeros(), Vec3::new(0.25, 0.25, 0.25)))));
    for (other, reach) in [(ball(), 0.5), (block, 1.0), (can, 0.25), (pill, 0.25), (cube, 1.0), (hull, 0.25)] {
        for (first, second) in [(ball(), other.clone()), (other.clone(), ball())] {
            let checker = flying(vec![first, second]);
            for gap in [-0.1, -1e-3, 0.9e-3, 1.1e-3, 0.3, 2.0] {
                let (label, clearance) = two(&checker, reach + 0.5 + gap);
                assert_eq!(label, if gap < 1e-3 { Label::Colliding } else { Label::Free }, "{gap}");
                assert!((clearance - gap).abs() < 1e-6, "{clearance} {gap}");
            }
        }
    }
}

#[test]
fn solids_hold_what_is_inside_them() {
    let shell = || bumpy(1, 3, 0.2);
    let tiny = |x: f64| placed(bumpy(2, 1, 0.2), 0.05, Vec3::new(x, 0.0, 0.0));
    let sphere = Geometry::Sphere { radius: 0.05 };
    let label = |first: Vec<Part>, second: Vec<Part>| {
        let forward = two(&flying(vec![first.clone(), second.clone()]), 0.0);
        assert_eq!(forward.0, two(&flying(vec![second, first]), 0.0).0);
        assert_eq!(forward.0 == Label::Free, forward.1 >= 1e-3, "{}", forward.1);
        forward
    };
    let (found, depth) = label(mesh(shell()), mesh(tiny(0.0)));
    assert!(found == Label::Colliding && depth < -0.7 && depth > -1.1, "{depth}");
    assert_eq!(label(mesh(shell()), part(sphere.clone())).0, Label::Colliding);
    assert_eq!(label(mesh(shell()), mesh(joined(&[tiny(3.0), tiny(0.1)]))).0, Label::Colliding, "one component inside");
    assert_eq!(label(mesh(shell()), mesh(opened(tiny(0.0), 3))).0, Label::Colliding, "a surface inside a solid");
    assert_eq!(label(mesh(opened(shell(), 1)), mesh(tiny(0.0))).0, Label::Free, "an open shell holds nothing");
    assert_eq!(label(mesh(opened(shell(), 1)), part(sphere.clone())).0, Label::Free);
    let nested = joined(&[shell(), placed(shell(), 0.5, Vec3::zeros())]);
    assert_eq!(label(mesh(nested), mesh(tiny(0.0))).0, Label::Colliding, "inside two shells is inside");
    assert_eq!(label(part(Geometry::Sphere { radius: 2.0 }), mesh(tiny(0.0))).0, Label::Colliding);
    let several = vec![
        Part { pose_frame_part: Pose::translation(Vec3::x() * 3.0), geometry: sphere.clone() },
        Part { pose_frame_part: Pose::translation(Vec3::x() * 0.1), geometry: sphere },
    ];
    assert_eq!(label(mesh(shell()), several).0, Label::Colliding, "the second part is inside");
}

/// Four bodies of every kind, near enough to each other that about half of all configurations
/// collide.
fn mixed() -> Checker {
    let lumps = joined(&[placed(bumpy(3, 2, 0.6), 0.9, Vec3::x() * 0.5), placed(bumpy(4, 1, 0.5), 0.5, -Vec3::x())]);
    let hull = Geometry::ConvexHull(Arc::new(cuboid(Vec3::zeros(), Vec3::new(0.3, 0.6, 0.4))));
    let can = Geometry::Cylinder { radius: 0.4, half_length: 0.8 };
    let pill = Geometry::Capsule { radius: 0.3, half_length: 0.5 };
    let pose_frame_part = Pose::from_xyz_rpy([0.7, 0.0, 0.2], [0.4, 0.5, 0.6]);
    let mut bars = part(hull);
    bars.push(Part { pose_frame_part, geometry: pill });
    flying(vec![mesh(bumpy(5, 2, 0.8)), mesh(lumps), bars, part(can)])
}

/// Configurations around the boundary: random ones and bisections between a free and a colliding
/// one.
fn configurations(checker: &Checker, count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let space = &checker.scene().space;
    let mut scratch = CheckScratch::default();
    let mut sides: [Option<Vec<f64>>; 2] = [None, None];
    let mut all = Vec::new();
    while all.len() < count {
        let mut q = vec![0.0; space.nq()];
        uniform(space, &mut rng, &mut q);
        for pair in q.chunks_exact_mut(7) {
            pair[..3].iter_mut().for_each(|x| *x *= 0.6);
        }
        let side = usize::from(checker.label(&q, &mut scratch) == Label::Free);
        sides[side] = Some(q.clone());
        all.push(q);
        if let [Some(colliding), Some(free)] = &sides {
            let (mut a, mut b) = (colliding.clone(), free.clone());
            for _ in 0..rng.random_range(4..24) {
                let mut middle = a.clone();
                space.interpolate(&a, &b, 0.5, &mut middle);
                let free = checker.label(&middle, &mut scratch) == Label::Free;
                *(if free { &mut b } else { &mut a }) = middle;
            }
            all.extend([a, b]);
            sides = [None, None];
        }
    }
    all
}

#[test]
fn label_agrees_with_clearance_and_pairs_and_ignores_what_came_before() {
    let checker = mixed();
    let (mut used, mut free) = (CheckScratch::default(), 0);
    for q in configurations(&checker, 1200, 11) {
        let fresh = checker.label(&q, &mut CheckScratch::default());
        assert_eq!(checker.label(&q, &mut used), fresh);
        let clearance = checker.clearance(&q, &mut used);
        assert!(
            (clearance - 1e-3).abs() < 1e-7 || (clearance >= 1e-3) == (fresh == Label::Free),
            "{clearance} {fresh:?} {q:?}"
        );
        let mut pairs = Vec::new();
        checker.colliding_pairs(&q, &mut used, &mut pairs);
        assert_eq!(pairs.is_empty(), fresh == Label::Free);
        let one = checker.colliding_pair(&q, &mut used);
        assert_eq!(one, checker.colliding_pair(&q, &mut CheckScratch::default()));
        assert_eq!(one.is_none(), pairs.is_empty());
        assert!(one.is_none_or(|pair| pairs.contains(&pair)));
        checker.label(&q, &mut used);
        let proved: Vec<PairId> =
            pairs.iter().copied().filter(|pair| checker.pair_seen_to_collide(pair.index(), &mut used)).collect();
        assert!(proved.is_empty() || one.is_some_and(|pair| proved.contains(&pair)), "{one:?} {proved:?}");
        free += usize::from(fresh == Label::Free);
    }
    assert!((300..900).contains(&free), "{free}");
}

#[test]
fn a_scratch_may_serve_several_checkers() {
    let (one, other) = (mixed(), flying(vec![mesh(bumpy(5, 1, 0.8)), mesh(bumpy(6, 1, 0.8))]));
    let mut scratch = CheckScratch::default();
    for q in configurations(&one, 50, 12) {
        assert_eq!(one.label(&q, &mut scratch), one.label(&q, &mut CheckScratch::default()));
        assert_eq!(other.label(&q[..14], &mut scratch), other.label(&q[..14], &mut CheckScratch::default()));
    }
}

fn within(margin: f64) -> ContactQuery {
    ContactQuery { margin, search: ContactSearch::Exact }
}

#[test]
fn nearest_contact_is_the_clearance_and_its_gradient_is_right() {
    let checker = mixed();
    let scene = checker.scene();
    let space = &scene.space;
    let (mut scratch, mut contacts, mut poses) = (CheckScratch::default(), Vec::<Contact>::new(), Vec::new());
    let (mut gradients, mut smooth) = (0, 0);
    for q in configurations(&checker, 600, 13) {
        let clearance = checker.clearance(&q, &mut scratch);
        contacts.clear();
        checker.contacts(&q, within(0.1), &mut scratch, &mut contacts);
        for c in &contacts {
            assert!((c.normal.norm() - 1.0).abs() < 1e-9 && c.distance < 0.1);
            let slack = if c.distance > 0.0 { 1e-9 } else { 1e-4 }; // depths of curved shapes are estimates
            assert!(((c.point_first - c.point_second).dot(&c.normal) - c.distance).abs() < slack, "{c:?}");
        }
        if !(1e-4..0.09).contains(&clearance) {
            continue;
        }
        let nearest = contacts.iter().min_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap();
        assert!((nearest.distance - clearance).abs() < 1e-9);
        kinematics::forward(scene, &q, &mut poses);
        let mut gradient = vec![0.0; space.nv()];
        let pair = scene.pairs[nearest.pair.index()];
        for (body, point, sign) in [(pair.first, nearest.point_first, 1.0), (pair.second, nearest.point_second, -1.0)] {
            let frame = scene.bodies[body].frame;
            kinematics::add_point_gradient(scene, &poses, frame, &point, &nearest.normal, sign, &mut gradient);
        }
        // The witness may jump between features. If both one-sided differences agree, they are the
        // gradient.
        for k in 0..space.nv() {
            let mut at = |step: f64| {
                let mut tangent = vec![0.0; space.nv()];
                tangent[k] = step;
                let mut moved = q.clone();
                space.integrate(&q, &tangent, &mut moved);
                checker.clearance(&moved, &mut scratch)
            };
            let (up, down) = ((at(1e-6) - clearance) / 1e-6, (clearance - at(-1e-6)) / 1e-6);
            gradients += 1;
            if (up - down).abs() < 1e-3 {
                smooth += 1;
                assert!((0.5 * (up + down) - gradient[k]).abs() < 2e-3, "{k}: {up} {down} {}", gradient[k]);
            }
        }
    }
    assert!(smooth > 1000 && smooth * 10 > gradients * 8, "{smooth} of {gradients}");
}

#[test]
fn two_plates_touch_in_several_places() {
    let plate = |z: f64| opened(cuboid(Vec3::new(0.0, 0.0, z), Vec3::new(0.5, 0.5, 0.1)), 0);
    let open = |z: f64| {
        let mut mesh = plate(z);
        mesh.components[0].closed = false;
        mesh
    };
    let checker = flying(vec![mesh(open(0.0)), mesh(open(0.21))]);
    let mut contacts = Vec::new();
    checker.contacts(&at(&[[0.0; 3], [0.0; 3]]), within(0.05), &mut CheckScratch::default(), &mut contacts);
    assert!((2..=12).contains(&contacts.len()), "{}", contacts.len());
    assert!(contacts.iter().all(|c| (c.distance - 0.01).abs() < 1e-12 && (c.normal + Vec3::z()).norm() < 1e-9));
}

#[test]
fn overlapping_meshes_push_each_other_out() {
    let cube = || {
        let corner = placed(bumpy(1, 0, 0.0), 0.01, Vec3::new(9.0, 0.0, 0.0));
        mesh(joined(&[cuboid(Vec3::zeros(), Vec3::new(1.0, 1.0, 1.0)), corner]))
    };
    let checker = flying(vec![cube(), cube()]);
    let mut contacts = Vec::new();
    let q = at(&[[1.9, 0.01, 0.02], [0.0; 3]]);
    checker.contacts(&q, within(0.05), &mut CheckScratch::default(), &mut contacts);
    assert!(contacts.iter().any(|c| (c.distance + 0.1).abs() < 1e-9 && (c.normal - Vec3::x()).norm() < 1e-9));
    let mut swapped = Vec::new();
    checker.contacts(&at(&[[0.0; 3], [1.9, 0.01, 0.02]]), within(0.05), &mut CheckScratch::default(), &mut swapped);
    assert!(swapped.iter().any(|c| (c.normal + Vec3::x()).norm() < 1e-9));
}

#[test]
fn depth_in_a_body_is_that_of_its_deepest_part() {
    let checker = mixed();
    assert!((checker.solid_depth(2, &Vec3::zeros()) - 0.3).abs() < 1e-12);
    assert!((checker.solid_depth(2, &Vec3::new(0.7, 0.0, 0.2)) - 0.3).abs() < 1e-12);
    assert!((checker.solid_depth(3, &Vec3::new(0.0, 0.0, 1.0)) + 0.2).abs() < 1e-12);
    assert!(checker.solid_depth(0, &Vec3::zeros()) > 0.4);
}

#[test]
fn pairs_that_always_collide_are_found() {
    let ball = |radius: f64| part(Geometry::Sphere { radius });
    let checker = flying(vec![ball(0.5), ball(0.5), ball(9.0)]);
    let configs = [at(&[[0.0; 3], [0.4, 0.0, 0.0], [1.0; 3]]), at(&[[2.0; 3], [0.4, 0.0, 0.0], [1.0; 3]])];
    assert_eq!(always_colliding(&checker, &configs), [1, 2].map(PairId::new));
    assert!(always_colliding(&checker, [[0.0; 0]; 0]).is_empty());
    let more: Vec<Vec<f64>> = (0..7).map(|k| configs[usize::from(k != 3)].clone()).collect();
    let nearly = |misses| {
        let found = checker.nearly_always_colliding(&more, misses);
        found.into_iter().map(|(pair, count)| (pair.index(), count)).collect::<Vec<_>>()
    };
    assert_eq!(nearly(0), [(1, 7), (2, 7)]);
    assert_eq!(nearly(5), [(1, 7), (2, 7)]);
    assert_eq!(nearly(6), [(0, 1), (1, 7), (2, 7)]);
    assert_eq!(checker.nearly_always_colliding(&more[..3], usize::MAX).len(), 2);
    assert_eq!(
        most_often_colliding(&checker, &configs),
        [(1, 2), (2, 2), (0, 1)].map(|(pair, count)| (PairId::new(pair), count))
    );
    assert!(most_often_colliding(&checker, &[]).is_empty());
}

#[test]
fn checkers_are_shared_between_threads() {
    fn shared<T: Send + Sync>() {}
    shared::<Checker>();
}

/// Blades of several heights are shapes of one body, under a block. Whichever comes first, the
/// nearest one is found.
#[test]
fn the_nearest_of_several_shapes_of_a_body_is_told() {
    let shape = |top: f64| Part {
        pose_frame_part: Pose::identity(),
        geometry: Geometry::Mesh(Arc::new(joined(&[
            cuboid(Vec3::new(0.0, 0.0, top - 0.1), Vec3::new(0.005, 0.1, 0.1)),
            cuboid(Vec3::new(0.0, 0.0, -0.5), Vec3::new(0.05, 0.05, 0.05)),
        ]))),
    };
    // Many lower blades, rotated all ways, fill the list before the last one comes.
    let around = |turn: usize| {
        let tilt = Pose::from_xyz_rpy([0.0; 3], [0.0, 0.0, 0.13 * turn as f64]);
        Part { pose_frame_part: tilt, ..shape(0.3 - 1e-3 * turn as f64) }
    };
    for search in [ContactSearch::Proposal, ContactSearch::Exact] {
        for tops in [vec![shape(0.3), shape(0.31)], vec![shape(0.31), shape(0.3)]] {
            for rest in [0, 24] {
                let parts: Vec<Part> = (0..rest).map(around).chain(tops.clone()).collect();
                let checker = flying(vec![parts, mesh(cuboid(Vec3::zeros(), Vec3::new(1.0, 1.0, 0.1)))]);
                for gap in [0.011, -0.002] {
                    let q = at(&[[0.0; 3], [0.0, 0.0, 0.41 + gap]]);
                    let mut contacts = Vec::new();
                    let query = ContactQuery { margin: 0.05, search };
                    checker.contacts(&q, query, &mut CheckScratch::default(), &mut contacts);
                    let least = contacts.iter().map(|c| c.distance).fold(f64::INFINITY, f64::min);
                    let same = if gap > 0.0 { (least - gap).abs() < 1e-4 } else { least <= gap };
                    assert!(same, "{search:?} {rest} {gap}: {least} of {}", contacts.len());
                }
            }
        }
    }
}
