//! Clouds, grids, half-spaces and the ground, each as one body: compared with separate obstacles,
//! and with closed forms.

use std::fmt::Write as _;
use std::path::Path;

use allocation_counter::measure;
use extricate::internals::cspace::sampling::Halton;
use extricate::internals::math::Vec3;
use extricate::internals::scene::assemble::assemble;
use extricate::{CheckScratch, Checker, Label, Scene, Solver};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::baselines::{
    CLOUD_COLLIDING_SHARE, GROUND_COLLIDING_CONFIGS, HALF_SPACE_COLLIDING_CONFIGS, SCENERY_QUERY_ALLOCATIONS,
    VOXELS_COLLIDING_SHARE,
};

/// An arm of four revolute links: a box, a cylinder, a capsule, and `{last}` in place of the fourth
/// shape.
const ARM: &str = r#"<robot name="arm"><link name="base"/>
<link name="a"><collision><origin xyz="0 0 0.2"/><geometry><box size="0.12 0.08 0.36"/></geometry></collision></link>
<link name="b"><collision><origin xyz="0 0 0.15"/><geometry><cylinder radius="0.05" length="0.26"/></geometry></collision></link>
<link name="c"><collision><origin xyz="0 0 0.12"/><geometry><capsule radius="0.04" length="0.2"/></geometry></collision></link>
<link name="d"><collision><geometry>{last}</geometry></collision></link>
<joint name="j1" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="j2" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 0.4"/><axis xyz="0 1 0"/><limit lower="-2.8" upper="2.8" effort="1" velocity="1"/></joint>
<joint name="j3" type="revolute"><parent link="b"/><child link="c"/><origin xyz="0 0 0.3"/><axis xyz="1 0 0"/><limit lower="-2.8" upper="2.8" effort="1" velocity="1"/></joint>
<joint name="j4" type="revolute"><parent link="c"/><child link="d"/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/><limit lower="-2.8" upper="2.8" effort="1" velocity="1"/></joint>
</robot>"#;

/// Writes two boxes at an angle: a closed mesh that is not convex.
fn bracket() -> String {
    let mut text = String::new();
    for (k, (center, half)) in
        [([0.0, 0.0, 0.05], [0.03, 0.03, 0.05]), ([0.06, 0.0, 0.09], [0.06, 0.02, 0.02])].into_iter().enumerate()
    {
        for corner in 0..8 {
            let at = |axis: usize| center[axis] + if corner >> axis & 1 == 1 { half[axis] } else { -half[axis] };
            writeln!(text, "v {} {} {}", at(0), at(1), at(2)).unwrap();
        }
        for face in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
            writeln!(text, "f {}", face.map(|v: usize| (v + 8 * k).to_string()).join(" ")).unwrap();
        }
    }
    text
}

const BALL: &str = r#"<sphere radius="0.06"/>"#;
const BRACKET: &str = r#"<mesh filename="bracket.obj"/>"#;

fn scene(last: &str, obstacles: &str) -> Scene {
    let text = format!("[[robot]]\nurdf = 'arm.urdf'\n{obstacles}");
    let mut read = |path: &Path| match path.to_str() {
        Some("arm.urdf") => Ok(ARM.replace("{last}", last).into_bytes()),
        Some("bracket.obj") => Ok(bracket().into_bytes()),
        _ => panic!("{}", path.display()),
    };
    assemble(Path::new("scene.toml"), &text, &mut read).unwrap()
}

fn checker(last: &str, obstacles: &str) -> Checker {
    Checker::new(scene(last, obstacles).into())
}

fn rows(rows: &[[f64; 3]]) -> String {
    let rows: Vec<String> = rows.iter().map(|row| format!("{row:?}")).collect();
    format!("[{}]", rows.join(", "))
}

fn cloud(count: usize, seed: u64) -> Vec<[f64; 3]> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut near = || 2.0 * rng.random::<f64>() - 1.0;
    // Points where the arm always is are left out.
    let all = std::iter::from_fn(|| Some([near(), near(), 0.2 + near()]));
    all.filter(|p| p[0].hypot(p[1]) > 0.25).take(count).collect()
}

/// A pose that rotates about every axis, so that no result holds along the axes alone.
const POSE: &str = "pose = { xyz = [0.1, -0.05, 0.02], rpy = [0.3, -0.2, 0.7] }";

/// Asserts equal labels and distances of both at `count` configurations; returns how many collide.
fn assert_same(one: &Checker, many: &Checker, count: u64) -> usize {
    let space = one.scene().space();
    let (halton, mut q) = (Halton::new(space.nv(), 3), vec![0.0; space.nq()]);
    let [mut a, mut b] = [(); 2].map(|()| CheckScratch::default());
    let mut colliding = 0;
    for k in 0..count {
        halton.config(space, k, &mut q);
        let labels = [one.label(&q, &mut a), many.label(&q, &mut b)];
        let distances = [one.clearance(&q, &mut a), many.clearance(&q, &mut b)];
        assert_eq!(labels[0], labels[1], "{k}: {distances:?}");
        assert!((distances[0] - distances[1]).abs() < 1e-7, "{k}: {distances:?}");
        assert_eq!(labels[0] == Label::Colliding, distances[0] < one.scene().clearance(), "{k}: {distances:?}");
        colliding += usize::from(labels[0] == Label::Colliding);
    }
    colliding
}

#[test]
fn a_cloud_is_as_many_balls() {
    for (last, radius, count) in [(BALL, 0.03, 10_000), (BRACKET, 0.03, 10_000), (BRACKET, 0.0, 10_000)] {
        let points = cloud(150, 5);
        let one = format!(
            "[[obstacle]]\nname = 'cloud'\nshape = {{ points = {}, radius = {radius} }}\n{POSE}\n",
            rows(&points)
        );
        let pose = extricate::geometry::Pose::from_xyz_rpy([0.1, -0.05, 0.02], [0.3, -0.2, 0.7]);
        // A ball needs a radius, so a point becomes one of a tenth of a nanometre.
        let size = f64::max(radius, 1e-10);
        let ball = |(k, p): (usize, &[f64; 3])| {
            let at = <[f64; 3]>::from(pose.point(&Vec3::from(*p)));
            format!("[[obstacle]]\nname = 'p{k}'\nshape = {{ sphere = {size:?} }}\npose = {{ xyz = {at:?} }}\n")
        };
        let many: String = points.iter().enumerate().map(ball).collect();
        let (one, many) = (checker(last, &one), checker(last, &many));
        assert!(one.scene().pairs().len() < 12 && many.scene().pairs().len() > 500);
        let colliding = assert_same(&one, &many, count);
        let collide = colliding as f64 > CLOUD_COLLIDING_SHARE * count as f64;
        assert!(collide && colliding < count as usize, "{last}: {colliding}");
    }
}

#[test]
fn voxels_are_as_many_boxes() {
    for (last, count) in [(BALL, 10_000), (BRACKET, 10_000)] {
        let size = 0.06;
        let mut cells: Vec<[f64; 3]> = cloud(200, 7).iter().map(|p| p.map(|x| (x / size).floor())).collect();
        // Some cells are side by side.
        cells.extend((0..30).map(|k| [6.0 + f64::from(k % 3), -2.0 + f64::from(k / 3 % 5), 3.0 + f64::from(k / 15)]));
        let whole: Vec<[i32; 3]> = cells.iter().map(|c| c.map(|x| x as i32)).collect();
        let one = format!("[[obstacle]]\nname = 'map'\nshape = {{ voxels = {whole:?}, size = {size} }}\n{POSE}\n");
        let pose = extricate::geometry::Pose::from_xyz_rpy([0.1, -0.05, 0.02], [0.3, -0.2, 0.7]);
        let cube = |(k, c): (usize, &[f64; 3])| {
            let at = <[f64; 3]>::from(pose.point(&Vec3::from(c.map(|x| (x + 0.5) * size))));
            format!(
                "[[obstacle]]\nname = 'v{k}'\nshape = {{ box = [{size}, {size}, {size}] }}\n\
                 pose = {{ xyz = {at:?}, rpy = [0.3, -0.2, 0.7] }}\n"
            )
        };
        let many: String = cells.iter().enumerate().map(cube).collect();
        let colliding = assert_same(&checker(last, &one), &checker(last, &many), count);
        let collide = colliding as f64 > VOXELS_COLLIDING_SHARE * count as f64;
        assert!(collide && colliding < count as usize, "{last}: {colliding}");
    }
}

#[test]
fn labels_of_scenery_allocate_nothing() {
    let cells: Vec<[i32; 3]> = cloud(2_000, 9).iter().map(|p| p.map(|x| (x / 0.05).floor() as i32)).collect();
    let heights: Vec<Vec<f64>> = (0..40).map(|i| (0..40).map(|j| 0.02 * f64::from(i * j % 7)).collect()).collect();
    let obstacles = format!(
        "[[obstacle]]\nname = 'cloud'\nshape = {{ points = {}, radius = 0.01 }}\n\
         [[obstacle]]\nname = 'map'\nshape = {{ voxels = {cells:?}, size = 0.05 }}\n\
         [[obstacle]]\nname = 'floor'\nshape = {{ half-space = [0.1, 0, 1], offset = -0.3 }}\n\
         [[obstacle]]\nname = 'ground'\nshape = {{ height-field = {heights:?}, size = 0.05 }}\npose = {{ xyz = [-1, -1, 0] }}\n",
        rows(&cloud(2_000, 8))
    );
    for last in [BALL, BRACKET] {
        let checker = checker(last, &obstacles);
        let space = checker.scene().space();
        let (halton, mut q, mut scratch) = (Halton::new(space.nv(), 3), vec![0.0; space.nq()], CheckScratch::default());
        let pass = |scratch: &mut CheckScratch, q: &mut [f64]| {
            measure(|| {
                for k in 0..300 {
                    halton.config(space, k, q);
                    checker.label(q, scratch);
                    checker.clearance(q, scratch);
                }
            })
            .count_total
        };
        pass(&mut scratch, &mut q);
        assert_eq!(pass(&mut scratch, &mut q), 0, "{last}");
    }
}

/// Queries among scenery, too, allocate only the lists of their answers, once the memory of their
/// solver has grown.
#[test]
fn queries_among_scenery_allocate_their_answers_alone() {
    let obstacles = format!(
        "[[obstacle]]\nname = 'cloud'\nshape = {{ points = {}, radius = 0.02 }}\n\
         [[obstacle]]\nname = 'floor'\nshape = {{ half-space = [0, 0, 1], offset = -0.1 }}\n\
         [[obstacle]]\nname = 'ground'\nshape = {{ height-field = [[0, 0.1], [0, 0.2]], size = 0.7 }}\npose = {{ xyz = [0.2, -0.3, 0] }}\n",
        rows(&cloud(1_000, 8))
    );
    let world = Solver::new(scene(BALL, &obstacles));
    let space = world.scene().space();
    let (halton, mut q) = (Halton::new(space.nv(), 3), vec![0.0; space.nq()]);
    let mut most = 0;
    for pass in 0..5 {
        for k in 0..40 {
            halton.config(space, k, &mut q);
            let config = space.config(&q).unwrap();
            let mut answer = None;
            let count = measure(|| answer = world.query(&config)).count_total;
            assert!(answer.is_some());
            most = if pass == 4 { most.max(count) } else { 0 };
        }
    }
    assert!(most <= SCENERY_QUERY_ALLOCATIONS, "{most}");
}

/// The pose of a height field of 3 m a side, tilted a little.
const TILTED: &str = "pose = { xyz = [-1.4, -1.6, -0.36], rpy = [0.1, -0.05, 0.2] }";

/// Writes a height field of `n` cells a side, and the same as a closed mesh with a floor 6 m below.
fn ground(n: usize, height: impl Fn(f64, f64) -> f64) -> (String, String) {
    let side = 3.0 / n as f64;
    let at = |i: usize, j: usize| height(i as f64 * side - 1.5, j as f64 * side - 1.5);
    let heights: Vec<Vec<f64>> = (0..=n).map(|i| (0..=n).map(|j| at(i, j)).collect()).collect();
    let field = format!("shape = {{ height-field = {heights:?}, size = {side:?} }}");
    let mut mesh = String::new();
    for level in [true, false] {
        for (i, row) in heights.iter().enumerate() {
            for (j, height) in row.iter().enumerate() {
                let z = if level { *height } else { -6.0 };
                writeln!(mesh, "v {:?} {:?} {z:?}", i as f64 * side, j as f64 * side).unwrap();
            }
        }
    }
    let mut face = |corners: [(usize, usize, bool); 3]| {
        let number = |(i, j, top)| 1 + i * (n + 1) + j + if top { 0 } else { (n + 1) * (n + 1) };
        let [a, b, c] = corners.map(number);
        writeln!(mesh, "f {a} {b} {c}").unwrap();
    };
    for i in 0..n {
        for j in 0..n {
            for top in [true, false] {
                let [a, b, c, d] = [(i, j, top), (i + 1, j, top), (i + 1, j + 1, top), (i, j + 1, top)];
                face(if top { [a, b, c] } else { [a, c, b] });
                face(if top { [a, c, d] } else { [a, d, c] });
            }
        }
        for end in [0, n] {
            let along_x = [(i, end, true), (i + 1, end, true), (i + 1, end, false), (i, end, false)];
            let along_y = [(end, i, true), (end, i + 1, true), (end, i + 1, false), (end, i, false)];
            for [a, b, c, d] in [along_x, along_y] {
                face([a, b, c]);
                face([a, c, d]);
            }
        }
    }
    (field, mesh)
}

#[test]
fn the_ground_is_a_deep_closed_mesh() {
    let waves = |x: f64, y: f64| 0.15 * (3.0 * x).sin() * (4.0 * y).cos() + 0.1 * x;
    let steps = |x: f64, y: f64| 0.2 * (x * 2.0).floor() * 0.3 + 0.1 * (y * 3.0).floor().rem_euclid(2.0);
    for (last, n, height) in [(BALL, 24, waves as fn(f64, f64) -> f64), (BRACKET, 15, steps)] {
        let (field, mesh) = ground(n, height);
        let entry = |shape: &str| format!("[[obstacle]]\nname = 'ground'\n{shape}\n{TILTED}\n");
        let text = format!("[[robot]]\nurdf = 'arm.urdf'\n{}", entry("shape = { mesh = 'ground.obj' }"));
        let mut read = |path: &Path| match path.to_str() {
            Some("arm.urdf") => Ok(ARM.replace("{last}", last).into_bytes()),
            Some("bracket.obj") => Ok(bracket().into_bytes()),
            _ => Ok(mesh.clone().into_bytes()),
        };
        let closed = Checker::new(assemble(Path::new("scene.toml"), &text, &mut read).unwrap().into());
        assert!(closed.scene().warnings().is_empty(), "{:?}", closed.scene().warnings());
        let field = checker(last, &entry(&field));
        let space = field.scene().space();
        let (halton, mut q) = (Halton::new(space.nv(), 3), vec![0.0; space.nq()]);
        let [mut a, mut b] = [(); 2].map(|()| CheckScratch::default());
        let mut colliding = 0;
        for k in 0..3_000 {
            halton.config(space, k, &mut q);
            let labels = [field.label(&q, &mut a), closed.label(&q, &mut b)];
            let distances = [field.clearance(&q, &mut a), closed.clearance(&q, &mut b)];
            assert_eq!(labels[0], labels[1], "{k}: {distances:?}");
            if distances[1] > 0.0 {
                assert!((distances[0] - distances[1]).abs() < 1e-7, "{k}: {distances:?}");
            } else {
                colliding += 1;
                assert!(distances[0] <= 1e-9, "{k}: {distances:?}");
            }
        }
        assert!(GROUND_COLLIDING_CONFIGS.contains(&colliding), "{colliding}");
    }
}

#[test]
fn a_half_space_is_a_large_box() {
    for last in [BALL, BRACKET] {
        let half = "[[obstacle]]\nname = 'floor'\nshape = { half-space = [0, 0, 3], offset = 0.05 }\n\
                    pose = { xyz = [0, 0, -0.1], rpy = [0.3, -0.2, 0.7] }\n";
        let pose = extricate::geometry::Pose::from_xyz_rpy([0.0, 0.0, -0.1], [0.3, -0.2, 0.7]);
        let at = <[f64; 3]>::from(pose.point(&Vec3::new(0.0, 0.0, 0.05 - 20.0)));
        let large = format!(
            "[[obstacle]]\nname = 'floor'\nshape = {{ box = [80, 80, 40] }}\n\
             pose = {{ xyz = {at:?}, rpy = [0.3, -0.2, 0.7] }}\n"
        );
        let (half, large) = (checker(last, half), checker(last, &large));
        let space = half.scene().space();
        let (halton, mut q) = (Halton::new(space.nv(), 3), vec![0.0; space.nq()]);
        let [mut a, mut b] = [(); 2].map(|()| CheckScratch::default());
        let mut colliding = 0;
        for k in 0..3_000 {
            halton.config(space, k, &mut q);
            let labels = [half.label(&q, &mut a), large.label(&q, &mut b)];
            let distances = [half.clearance(&q, &mut a), large.clearance(&q, &mut b)];
            assert_eq!(labels[0], labels[1], "{k}: {distances:?}");
            // Distances of overlapping meshes are estimates.
            if distances[1] > 0.0 || last == BALL {
                assert!((distances[0] - distances[1]).abs() < 1e-7, "{k}: {distances:?}");
            }
            colliding += usize::from(labels[0] == Label::Colliding);
        }
        assert!(HALF_SPACE_COLLIDING_CONFIGS.contains(&colliding), "{colliding}");
    }
}
