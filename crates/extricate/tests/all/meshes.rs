//! Meshes as exporters write them, from their files to answers: seams of f32, concave faces,
//! cavities.

use std::path::Path;

use extricate::internals::cspace::sampling::Halton;
use extricate::internals::io;
use extricate::{CheckScratch, Effort, Label, MetricKind, QueryOptions, Solver};

use crate::baselines::{L_CONVEX_PARTS, ROOM_BOUND_OF_DEPTH_SHARE, ROOM_BOUNDS_PER_QUERY, ROOM_COLLIDING_CONFIGS};
use crate::query::ask;

/// Makes a scene of a ball that slides along x, y and z among one mesh.
fn world(radius: f64, file: &str, mesh: &[u8], extra: &str) -> Solver {
    let shape = format!("{{ mesh = '{file}' }}");
    world_of(radius, file, mesh, &shape, extra)
}

/// Does the same with the shape as a scene file writes it.
fn world_of(radius: f64, file: &str, mesh: &[u8], shape: &str, extra: &str) -> Solver {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let link = |name: &str| format!("<link name='{name}'/>");
    let joint = |axis: &str, parent: &str, child: &str, along: &str| {
        format!(
            "<joint name='{axis}' type='prismatic'><parent link='{parent}'/><child link='{child}'/><axis xyz='{along}'/>\
             <limit lower='-5' upper='5' effort='1' velocity='1'/></joint>"
        )
    };
    let urdf = format!(
        "<robot name='r'>{}{}{}<link name='ball'><collision><geometry><sphere radius='{radius}'/></geometry></collision>\
         </link>{}{}{}</robot>",
        link("w"),
        link("a"),
        link("b"),
        joint("x", "w", "a", "1 0 0"),
        joint("y", "a", "b", "0 1 0"),
        joint("z", "b", "ball", "0 0 1")
    );
    write("r.urdf", urdf.as_bytes());
    write(file, mesh);
    let scene = format!("{extra}[[robot]]\nurdf = 'r.urdf'\n[[obstacle]]\nname = 'o'\nshape = {shape}\n");
    write("s.toml", scene.as_bytes());
    Solver::new(io::load_scene(folder.path().join(Path::new("s.toml"))).unwrap())
}

fn clearance(world: &Solver, q: [f64; 3]) -> f64 {
    let mut scratch = CheckScratch::default();
    let clearance = world.checker().clearance(&q, &mut scratch);
    let label = world.checker().label(&q, &mut scratch);
    assert_eq!(label == Label::Free, clearance >= world.scene().clearance(), "{q:?} {clearance}");
    clearance
}

/// Writes boxes as an OBJ: half sides, and whether the faces point outward.
fn boxes(all: &[([f64; 3], bool)]) -> String {
    let mut text = String::new();
    for (half, outward) in all {
        for k in 0..8 {
            let at = |axis: usize| if k >> axis & 1 == 1 { half[axis] } else { -half[axis] };
            text += &format!("v {} {} {}\n", at(0), at(1), at(2));
        }
        for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            let [a, b, c, d] = [a, b, c, d].map(|k| k - 8);
            text += &if *outward { format!("f {a} {b} {c} {d}\n") } else { format!("f {d} {c} {b} {a}\n") };
        }
    }
    text
}

/// Writes a binary STL of a cube around the origin, in which some corners are off by a unit in the
/// last place.
fn cube_with_seams(half: f32) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend(12u32.to_le_bytes());
    let mut count = 0u32;
    for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        for corners in [[a, b, c], [a, c, d]] {
            bytes.extend([0; 12]);
            for (corner, axis) in corners.iter().flat_map(|k: &usize| (0..3).map(move |axis| (k, axis))) {
                count = count.wrapping_mul(1_103_515_245).wrapping_add(12_345);
                let off = f32::from_bits(half.to_bits() + (count >> 16 & 1));
                bytes.extend(if corner >> axis & 1 == 1 { off } else { -off }.to_le_bytes());
            }
            bytes.extend([0; 2]);
        }
    }
    bytes
}

#[test]
fn a_solid_with_seams_holds_what_is_in_it() {
    let world = world(0.02, "cube.stl", &cube_with_seams(0.15), "");
    let warnings = world.scene().warnings();
    assert!(warnings.iter().all(|warning| !warning.contains("open: ")), "{warnings:?}");
    assert!(
        warnings.iter().any(|warning| warning.contains("cube.stl: ") && warning.contains("welded")),
        "{warnings:?}"
    );
    assert!((clearance(&world, [0.0; 3]) + 0.17).abs() < 1e-6);
    let q = world.scene().space().config(&[0.0; 3]).unwrap();
    let answer = world.query(&q).unwrap();
    assert!((answer.depth - 0.1701).abs() < 1e-5 && answer.lower_bound > 0.0, "{answer:?}");
}

const ROOM: [([f64; 3], bool); 2] = [([2.0, 2.0, 1.5], true), ([1.8, 1.8, 1.3], false)];

/// Returns the distance from a point to the nearest free centre of a ball with clearance.
fn depth_in_walls(q: &[f64], radius: f64, clearance: f64) -> f64 {
    let reach = radius + clearance;
    let [outer, inner] = ROOM.map(|(half, _)| half);
    let within = (0..3).map(|k| (q[k].abs() - (inner[k] - reach)).max(0.0).powi(2)).sum::<f64>().sqrt();
    let beyond: [f64; 3] = std::array::from_fn(|k| q[k].abs() - outer[k]);
    let outside = beyond.iter().map(|x| x.max(0.0).powi(2)).sum::<f64>().sqrt();
    let deepest = beyond.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
    within.min(if outside > 0.0 { (reach - outside).max(0.0) } else { reach - deepest })
}

#[test]
fn a_room_is_free_within_and_bounds_hold_in_its_walls() {
    for metric in [MetricKind::Joint, MetricKind::MaxDisplacement] {
        let extra = if metric == MetricKind::Joint { "" } else { "metric = { kind = 'max-displacement' }\n" };
        let world = world(0.1, "room.obj", boxes(&ROOM).as_bytes(), extra);
        assert!(world.scene().warnings().iter().any(|warning| warning.contains("it is a cavity")));
        assert!((clearance(&world, [0.0; 3]) - 1.2).abs() < 1e-9);
        assert!((clearance(&world, [1.5, 0.2, 0.1]) - 0.2).abs() < 1e-9);
        assert!((clearance(&world, [4.0, 0.2, 0.1]) - 1.9).abs() < 1e-9);
        let space = world.scene().space();
        let (halton, mut q) = (Halton::new(3, 7), vec![0.0; 3]);
        let (mut asked, mut bounded) = (0, 0);
        for k in 0..400 {
            halton.config(space, k, &mut q);
            q.iter_mut().for_each(|x| *x *= 0.44);
            let depth = depth_in_walls(&q, 0.1, world.scene().clearance());
            let label = world.checker().label(&q, &mut CheckScratch::default());
            assert_eq!(label == Label::Free, depth == 0.0, "{q:?} {depth}");
            if depth == 0.0 {
                continue;
            }
            asked += 1;
            for effort in [Effort::Nearest, Effort::Refined] {
                let options = QueryOptions::default().effort(effort);
                let answer = ask(&world, &space.config(&q).unwrap(), &options);
                assert!(answer.lower_bound <= depth + 1e-9, "{q:?}: bound {} depth {depth}", answer.lower_bound);
                assert!(answer.depth >= depth - 1e-9, "{q:?}: {} {depth}", answer.depth);
                assert!(effort == Effort::Nearest || answer.depth < 1.01 * depth + 1e-5, "{q:?}: {answer:?} {depth}");
                bounded += usize::from(answer.lower_bound > ROOM_BOUND_OF_DEPTH_SHARE * depth);
            }
        }
        let are_bounded = bounded as f64 > ROOM_BOUNDS_PER_QUERY * asked as f64;
        assert!(asked > ROOM_COLLIDING_CONFIGS && are_bounded, "{asked} {bounded}");
    }
}

#[test]
fn overlapping_boxes_that_face_outward_stay_solid() {
    let both = [([2.0, 2.0, 1.5], true), ([1.8, 1.8, 1.3], true)];
    let world = world(0.1, "both.obj", boxes(&both).as_bytes(), "");
    assert!(clearance(&world, [0.0; 3]) < -1.5);
    assert!(world.scene().warnings().is_empty(), "{:?}", world.scene().warnings());
}

#[test]
fn notches_of_concave_faces_are_free() {
    let outline = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]];
    for start in 0..6 {
        let ends: String = [[6, 5, 4, 3, 2, 1], [7, 8, 9, 10, 11, 12]]
            .map(|mut end: [u32; 6]| {
                end.rotate_left(start);
                format!("f{}\n", end.map(|k| format!(" {k}")).concat())
            })
            .concat();
        let at = |z: u32| outline.map(|[x, y]| format!("v {x} {y} {z}\n")).concat();
        let sides: String = (1..=6).map(|k| format!("f {k} {} {} {}\n", k % 6 + 1, k % 6 + 7, k + 6)).collect();
        let world = world(0.1, "l.obj", format!("{}{}{ends}{sides}", at(0), at(1)).as_bytes(), "");
        for z in [0.0, 0.5, 1.0] {
            let found = clearance(&world, [1.5, 1.5, z]);
            assert!((found - 0.4).abs() < 1e-9, "{start} {z}: {found}");
        }
        assert!(clearance(&world, [0.5, 0.5, 0.5]) < 0.0);
        assert!(world.scene().warnings().is_empty());
    }
}

#[test]
fn convex_parts_hold_the_mesh_and_follow_it() {
    // An L of two bars: its hull fills the corner, its parts do not.
    let bar = |low: [f64; 3], high: [f64; 3], first: usize| {
        let corners: String = (0..8)
            .map(|k| {
                let at = |axis: usize| if k >> axis & 1 == 1 { high[axis] } else { low[axis] };
                format!("v {} {} {}\n", at(0), at(1), at(2))
            })
            .collect();
        let faces = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]];
        let faces = faces.map(|face| format!("f {}\n", face.map(|k| (k + first).to_string()).join(" "))).concat();
        corners + &faces
    };
    let mesh = bar([0.0; 3], [2.0, 0.4, 0.4], 0) + &bar([0.1, 0.1, -0.1], [0.5, 2.0, 0.5], 8);
    let of = |kind: &str| world_of(0.05, "l.obj", mesh.as_bytes(), &format!("{{ mesh = 'l.obj', {kind} = true }}"), "");
    let (whole, parts) = (world(0.05, "l.obj", mesh.as_bytes(), ""), of("convex-parts"));
    let hull = of("convex");
    let body = parts.checker().scene().bodies().iter().find(|body| body.name == "o").unwrap();
    assert!((2..=L_CONVEX_PARTS).contains(&body.parts.len()), "{}", body.parts.len());
    let halton = Halton::new(3, 7);
    for q in (0..300).map(|index| [0, 1, 2].map(|k| 3.0 * halton.coordinate(index, k) - 0.5)) {
        let (exact, held) = (clearance(&whole, q), clearance(&parts, q));
        // A part exceeds the mesh by 0.4 % of its radius at most. Overlaps are those of the deepest
        // part, which the faces between parts bound.
        match exact <= 0.0 {
            true => assert!(held <= 1e-6, "{q:?}: {held} apart, {exact} in the mesh"),
            false => assert!((exact - 0.012..=exact + 1e-6).contains(&held), "{q:?}: {held} for {exact}"),
        }
    }
    let corner = [1.0, 1.0, 0.2];
    assert!(clearance(&hull, corner) < 0.0 && clearance(&parts, corner) > 0.4);
    assert!(parts.scene().warnings().is_empty(), "{:?}", parts.scene().warnings());
}

#[test]
fn convex_parts_that_fill_a_hollow_say_how_far_they_stand_out() {
    // The bin is one closed solid: walls of 2 mm around a metre, open above.
    let ring = |half: f64, low: f64| {
        [low, 0.5]
            .map(|z| [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(|[x, y]| [half * f64::from(x), half * f64::from(y), z]))
    };
    let corners = [ring(0.5, -0.5), ring(0.498, -0.498)].concat().concat();
    let mut mesh: String = corners.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    mesh += "f 4 3 2 1\nf 9 10 11 12\n";
    for k in 0..4 {
        let (a, b) = (k + 1, (k + 1) % 4 + 1);
        let outside = [a, b, b + 4, a + 4];
        let inside = [b + 8, a + 8, a + 12, b + 12];
        let rim = [a + 4, b + 4, b + 12, a + 12];
        for face in [outside, inside, rim] {
            mesh += &format!("f {}\n", face.map(|k: i32| k.to_string()).join(" "));
        }
    }
    let parts = world_of(0.05, "bin.obj", mesh.as_bytes(), "{ mesh = 'bin.obj', convex-parts = true }", "");
    let [warning] = parts.scene().warnings() else { panic!("{:?}", parts.scene().warnings()) };
    assert!(warning.contains("convex parts stand out of the mesh by up to ") && warning.contains(" m: "), "{warning}");
    let far: f64 = warning.split("up to ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((0.1..0.6).contains(&far), "{warning}");
    // As a mesh its hollow stays open, so no warning is due.
    let whole = world_of(0.05, "bin.obj", mesh.as_bytes(), "{ mesh = 'bin.obj' }", "");
    assert!(whole.scene().warnings().is_empty() && clearance(&whole, [0.0; 3]) > 0.4);
}
