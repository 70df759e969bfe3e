//! Exits from clouds, grids, half-spaces and the ground: known depths, proofs, and the same map in
//! two forms.

use std::path::Path;

use extricate::internals::cspace::sampling::Halton;
use extricate::internals::math::Vec3;
use extricate::internals::scene::assemble::assemble;
use extricate::{Answer, CheckScratch, Label, PairId, QueryOptions, Scene, Solver};

use crate::baselines::{
    LEARNED_MAP_COLLIDING_CONFIGS, VOXEL_MAP_FARTHER_EXITS, VOXEL_MAP_MEDIAN_DEPTH_RATIO, WAVES_BOUND_SHARE,
};
use crate::memory::learn;
use crate::query;

/// A robot: a ball of 0.1 m that slides along three axes.
const BALL: &str = r#"<robot name="ball"><link name="w"/><link name="x"/><link name="y"/>
<link name="ball"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="jx" type="prismatic"><parent link="w"/><child link="x"/><axis xyz="1 0 0"/><limit lower="-5" upper="5" effort="1" velocity="1"/></joint>
<joint name="jy" type="prismatic"><parent link="x"/><child link="y"/><axis xyz="0 1 0"/><limit lower="-5" upper="5" effort="1" velocity="1"/></joint>
<joint name="jz" type="prismatic"><parent link="y"/><child link="ball"/><axis xyz="0 0 1"/><limit lower="-5" upper="5" effort="1" velocity="1"/></joint></robot>"#;

fn scene_of(urdf: &str, obstacles: &str) -> Scene {
    let text = format!("[[robot]]\nurdf = 'robot.urdf'\n{obstacles}");
    assemble(Path::new("scene.toml"), &text, &mut |_: &Path| Ok(urdf.as_bytes().to_vec())).unwrap()
}

/// Returns the nearest exit, without a gap that ends the search.
fn ask(world: &Solver, q: &[f64]) -> Answer {
    let q = world.scene().space().config(q).unwrap();
    let answer = query::ask(world, &q, &QueryOptions::default().gap(0.0));
    let label = world.checker().label(&answer.witness, &mut CheckScratch::default());
    assert!(answer.verified && label == Label::Free && answer.lower_bound <= answer.depth);
    answer
}

fn flat(size: f64, n: usize) -> String {
    let heights = vec![vec![0.0; n + 1]; n + 1];
    format!(
        "[[obstacle]]\nname = 'ground'\nshape = {{ height-field = {heights:?}, size = {size:?} }}\n\
         pose = {{ xyz = [{0:?}, {0:?}, 0] }}\n",
        -0.5 * size * n as f64
    )
}

#[test]
fn the_way_out_of_the_ground_is_up() {
    let plane = "[[obstacle]]\nname = 'ground'\nshape = { half-space = [0, 0, 1] }\n".to_string();
    for ground in [plane, flat(0.25, 40), flat(10.0, 1)] {
        let world = Solver::new(scene_of(BALL, &ground));
        for depth in [0.02, 0.5, 3.0] {
            let answer = ask(&world, &[0.03, 0.02, -depth]);
            let expected = depth + 0.1 + 1e-4;
            assert!((answer.depth - expected).abs() < 1e-5 * expected, "{} {expected}", answer.depth);
            assert!(answer.lower_bound > 0.999 * (depth + 0.1), "{} {expected}", answer.lower_bound);
            assert!((answer.witness[2] - 0.1001).abs() < 1e-5);
        }
    }
}

#[test]
fn a_leaning_half_space_is_left_along_its_normal() {
    let ground = "[[obstacle]]\nname = 'slope'\nshape = { half-space = [-1, 0, 2], offset = 0.3 }\n";
    let answer = ask(&Solver::new(scene_of(BALL, ground)), &[0.1, 0.2, -0.4]);
    let normal = Vec3::new(-1.0, 0.0, 2.0).normalize();
    let expected = 0.3 - normal.dot(&Vec3::new(0.1, 0.2, -0.4)) + 0.1 + 1e-4;
    assert!((answer.depth - expected).abs() < 1e-5, "{} {expected}", answer.depth);
    assert!(answer.lower_bound > 0.999 * expected - 1e-4, "{} {expected}", answer.lower_bound);
}

/// An open mesh of these waves, `z = 0.2 sin 2x cos 2y`, was found free 0.4 m below them.
#[test]
fn below_waves_nothing_is_free() {
    let at = |i: usize, j: usize| {
        let [x, y] = [i, j].map(|k| 0.2 * k as f64 - 2.0);
        0.2 * (2.0 * x).sin() * (2.0 * y).cos()
    };
    let heights: Vec<Vec<f64>> = (0..=20).map(|i| (0..=20).map(|j| at(i, j)).collect()).collect();
    let ground = format!(
        "[[obstacle]]\nname = 'terrain'\nshape = {{ height-field = {heights:?}, size = 0.2 }}\n\
         pose = {{ xyz = [-2, -2, 0] }}\n"
    );
    let world = Solver::new(scene_of(BALL, &ground));
    let mut check = CheckScratch::default();
    for k in 0..40 {
        let q = [0.0, 0.0, -0.5 - 0.05 * f64::from(k)];
        assert_eq!(world.checker().label(&q, &mut check), Label::Colliding);
        let answer = ask(&world, &q);
        let is_tight = answer.lower_bound > WAVES_BOUND_SHARE * answer.depth;
        assert!(is_tight, "{} {}", answer.lower_bound, answer.depth);
        // The depth is the least one over a fine grid of possible ends.
        let mut least = f64::INFINITY;
        for i in -20..=20 {
            for j in -20..=20 {
                let end = |z: f64| [0.04 * f64::from(i), 0.04 * f64::from(j), z];
                let (mut low, mut high) = (q[2], 0.5);
                for _ in 0..20 {
                    let middle = 0.5 * (low + high);
                    let is_free = world.checker().label(&end(middle), &mut check) == Label::Free;
                    (low, high) = if is_free { (low, middle) } else { (middle, high) };
                }
                least = least.min((Vec3::from(end(high)) - Vec3::from(q)).norm());
            }
        }
        assert!(answer.depth < 1.01 * least, "{k}: {} {least}", answer.depth);
    }
}

/// Returns an arm of seven joints, and the cells of 5 cm of a table top with two boxes on it.
fn small_map() -> (String, Vec<[i32; 3]>) {
    let (mut urdf, mut parent, mut below) =
        (String::from("<robot name='arm'><link name='base'/>"), "base".to_string(), 0.1);
    let axes = ["0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "0 0 1", "0 1 0"];
    for (k, (axis, length)) in axes.into_iter().zip([0.2, 0.3, 0.3, 0.15, 0.15, 0.1, 0.1]).enumerate() {
        urdf += &format!(
            "<link name='l{k}'><collision><origin xyz='0 0 {}'/><geometry><capsule radius='0.04' length='{}'/></geometry>\
             </collision></link><joint name='j{k}' type='revolute'><parent link='{parent}'/><child link='l{k}'/>\
             <origin xyz='0 0 {below}'/><axis xyz='{axis}'/><limit lower='-2.5' upper='2.5' effort='1' velocity='1'/></joint>",
            length / 2.0,
            length - 0.06
        );
        (parent, below) = (format!("l{k}"), length);
    }
    let mut cells: Vec<[i32; 3]> = (7..17).flat_map(|x| (-10..10).map(move |y| [x, y, 3])).collect();
    for (columns, rows) in [([10, 12], -6..-1), ([9, 13], 2..7)] {
        for x in columns {
            cells.extend(rows.clone().flat_map(|y| (4..9).map(move |z| [x, y, z])));
        }
    }
    (urdf + "</robot>", cells)
}

/// A map of 300 voxels as one body has the labels of 300 bodies, few pairs, and exits about as
/// near.
#[test]
fn a_map_of_voxels_is_one_body() {
    let (urdf, cells) = small_map();
    assert_eq!(cells.len(), 300);
    let one = format!(
        "[[obstacle]]\nname = 'map'\nshape = {{ voxels = {cells:?}, size = 0.05 }}\npose = {{ xyz = [-0.025, -0.025, -0.025] }}\n"
    );
    let cube = |(k, c): (usize, &[i32; 3])| {
        let at = c.map(|i| 0.05 * f64::from(i));
        format!("[[obstacle]]\nname = 'v{k}'\nshape = {{ box = [0.05, 0.05, 0.05] }}\npose = {{ xyz = {at:?} }}\n")
    };
    let many: String = cells.iter().enumerate().map(cube).collect();
    let [one, many] = [one, many].map(|obstacles| Solver::new(scene_of(&urdf, &obstacles)));
    assert_eq!([&one, &many].map(|world| world.scene().pairs().len()), [22, 2115]);
    let space = one.scene().space();
    let (halton, mut q) = (Halton::new(space.nv(), 3), vec![0.0; space.nq()]);
    let [mut a, mut b] = [(); 2].map(|()| CheckScratch::default());
    let (mut asked, mut ratios) = (0, Vec::new());
    for k in 0..2_000 {
        halton.config(space, k, &mut q);
        let label = one.checker().label(&q, &mut a);
        assert_eq!(label, many.checker().label(&q, &mut b));
        let mut pairs = Vec::new();
        one.checker().colliding_pairs(&q, &mut a, &mut pairs);
        let with_map = |pair: &PairId| one.scene().pair_names(*pair).contains(&"map");
        if label == Label::Colliding && pairs.iter().any(with_map) && asked < 40 {
            asked += 1;
            ratios.push(ask(&one, &q).depth / ask(&many, &q).depth);
        }
    }
    assert_eq!(asked, 40);
    ratios.sort_by(f64::total_cmp);
    let far = ratios.iter().filter(|ratio| **ratio > 1.05).count();
    let are_near = far <= VOXEL_MAP_FARTHER_EXITS && ratios[20] < VOXEL_MAP_MEDIAN_DEPTH_RATIO;
    assert!(are_near, "{ratios:?}");
}

/// Learning with a map uses the pairs of one body, and the model answers in other maps too.
#[test]
fn a_map_of_voxels_is_learned_as_one_body() {
    let (urdf, cells) = small_map();
    let map =
        |cells: &[[i32; 3]]| format!("[[obstacle]]\nname = 'map'\nshape = {{ voxels = {cells:?}, size = 0.05 }}\n");
    let model = learn(scene_of(&urdf, &map(&cells)), 3_000, 0);
    let bytes = extricate::internals::io::model_file::encode(&model);
    let model = extricate::internals::io::model_file::decode(Path::new("m"), &bytes).unwrap();
    let model = Solver::of_model(model);
    let other = model.with_scene(scene_of(&urdf, &map(&cells[..250]))).unwrap();
    let space = model.scene().space();
    let (halton, mut q, mut check) = (Halton::new(space.nv(), 4), vec![0.0; space.nq()], CheckScratch::default());
    let mut asked = 0;
    for k in 0..200 {
        halton.config(space, k, &mut q);
        let config = space.config(&q).unwrap();
        for answer in [model.query(&config), other.query(&config)] {
            let answer = answer.unwrap();
            assert!(answer.is_free() || answer.verified && answer.lower_bound <= answer.depth);
        }
        asked += usize::from(model.checker().label(&q, &mut check) == Label::Colliding);
    }
    assert!(asked > LEARNED_MAP_COLLIDING_CONFIGS, "{asked}");
}

#[test]
fn the_robots_own_points_are_left_out() {
    let (urdf, _) = small_map();
    let world = Solver::new(scene_of(
        &urdf,
        "[[obstacle]]\nname = 'ball'\nshape = { sphere = 0.2 }\npose = { xyz = [1, 0, 0] }\n",
    ));
    let mut check = CheckScratch::default();
    // The arm is upright: capsules of 4 cm along z.
    let q = [0.0; 7];
    for padding in [0.0, 0.02, 0.3] {
        let points: Vec<[f64; 3]> = (0..80).map(|k| [0.01 * f64::from(k) + 0.005, 0.0, 0.45]).collect();
        let keep = world.checker().robot_filter(&q, &points, padding, &mut check);
        for (point, keep) in points.iter().zip(keep) {
            assert_eq!(keep, point[0] > 0.04 + padding, "{point:?} {padding}");
        }
    }
    // Obstacles do not count.
    assert_eq!(world.checker().robot_filter(&q, &[[1.0, 0.0, 0.0]], 0.0, &mut check), [true]);
}
