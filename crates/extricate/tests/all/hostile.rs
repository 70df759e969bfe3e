//! Files that demand more than robots do: each kind is refused in time, or read in time.

use std::path::Path;
use std::time::{Duration, Instant};

use extricate::internals::robot::formats::{parse, parse_among};
use extricate::internals::scene::assemble::assemble_entries;
use extricate::internals::scene::file;
use extricate::internals::scene::import::import;
use extricate::{Checker, Error, LoadLimit, LoadLimits, Result, Scene, builtin, load_scene};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::baselines::HOSTILE_FILE_SECONDS;

const ROBOT: &str = "[[robot]]\nurdf = 'r.urdf'\n";

fn link(name: &str, shape: &str) -> String {
    format!("<link name='{name}'><collision><geometry>{shape}</geometry></collision></link>")
}

fn joint(name: &str, parent: &str, child: &str, more: &str) -> String {
    format!(
        "<joint name='{name}' type='revolute'><origin xyz='1 0 0'/><parent link='{parent}'/><child link='{child}'/>\
         <limit lower='-1' upper='1'/>{more}</joint>"
    )
}

const BALL: &str = "<sphere radius='0.1'/>";

fn chain(count: usize, mimic: bool) -> String {
    let follows = |k: usize| if mimic && k > 0 { format!("<mimic joint='j{}'/>", k - 1) } else { String::new() };
    let links: String = (0..count).map(|k| link(&format!("l{k}"), if mimic && k > 1 { "" } else { BALL })).collect();
    let links = links.replace("<collision><geometry></geometry></collision>", "");
    let joint = |k: usize| joint(&format!("j{k}"), &format!("l{k}"), &format!("l{}", k + 1), &follows(k));
    let joints: String = (0..count - 1).map(joint).collect();
    format!("<robot name='r'>{links}{joints}</robot>")
}

fn scene_of(text: &str, files: &[(&str, &[u8])], limits: &LoadLimits) -> Result<Scene> {
    let entries = file::parse_within("s.toml", text, limits)?;
    assemble_entries(Path::new("s.toml"), &entries, &mut |path| {
        let found = files.iter().find(|(name, _)| Path::new(name) == path);
        let missing = || Error::Read { path: path.into(), source: std::io::ErrorKind::NotFound.into() };
        found.map(|(_, bytes)| bytes.to_vec()).ok_or_else(missing)
    })
}

fn obstacles(count: usize) -> String {
    let obstacle = |k: usize| {
        let (x, y) = (k % 300, k / 300);
        format!("[[obstacle]]\nname = 'o{k}'\nshape = {{ sphere = 0.01 }}\npose = {{ xyz = [{x}, {y}, 3] }}\n")
    };
    (0..count).map(obstacle).collect()
}

const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

const DAE: &str = "<COLLADA><library_geometries><geometry id='g'><mesh><source id='p'><float_array id='a'>0 0 0 1 0 0 0 1 0\
    </float_array></source><vertices id='v'><input semantic='POSITION' source='#p'/></vertices><triangles><input \
    semantic='VERTEX' source='#v' offset='0'/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>\
    <library_visual_scenes><visual_scene id='s'><node>NODES</node></visual_scene></library_visual_scenes>\
    <scene><instance_visual_scene url='#s'/></scene></COLLADA>";

#[test]
fn every_limit_refuses_what_is_more_and_names_itself() {
    let two = chain(2, false);
    let mesh = two.replacen(BALL, "<mesh filename='t.obj' scale='2 1 1'/>", 1);
    let nodes = DAE.replace("NODES", &"<instance_geometry url='#g'/>".repeat(9));
    let shown = format!("{ROBOT}[[obstacle]]\nname = 'o'\nshape = {{ mesh = 't.dae' }}\n");
    let often = DAE.replace("NODES", &"<instance_geometry url='#g'/>".repeat(2000));
    let often = often.replace("<node>", &format!("<node>{}", "<instance_node url='#m'/>".repeat(9)));
    let often = often.replace(
        "<library_visual_scenes>",
        &format!(
            "<library_nodes><node id='m'>{}</node></library_nodes><library_visual_scenes>",
            "<instance_geometry url='#g'/>".repeat(2000)
        ),
    );
    let shown_often = shown.replace("t.dae", "often.dae");
    let with_box = format!("{ROBOT}{}", obstacles(3));
    for (limit, most, text, urdf) in [
        (LoadLimit::FileBytes, 10, ROBOT, &mesh),
        (LoadLimit::TextBytes, 100, ROBOT, &two),
        (LoadLimit::XmlNodes, 10, ROBOT, &two),
        (LoadLimit::XmlAttributes, 1, ROBOT, &two),
        (LoadLimit::XmlDepth, 2, ROBOT, &two),
        (LoadLimit::Values, 5, &with_box, &two),
        (LoadLimit::MeshNodes, 9, &shown, &two),
        (LoadLimit::Placed, 0, &shown_often, &two),
        (LoadLimit::Vertices, 3, ROBOT, &mesh),
        (LoadLimit::Triangles, 7, ROBOT, &mesh),
        (LoadLimit::Links, 1, ROBOT, &two),
        (LoadLimit::Shapes, 1, ROBOT, &two),
        (LoadLimit::Obstacles, 2, &with_box, &two),
        (LoadLimit::Pairs, 2, &with_box, &two),
        (LoadLimit::NameBytes, 1, ROBOT, &two),
    ] {
        let files = [
            ("r.urdf", urdf.as_bytes()),
            ("t.obj", TETRAHEDRON.as_bytes()),
            ("t.dae", nodes.as_bytes()),
            ("often.dae", often.as_bytes()),
        ];
        let loaded = scene_of(text, &files, &LoadLimits::default());
        assert!(loaded.is_ok(), "{limit:?}: {}", loaded.unwrap_err());
        let message = scene_of(text, &files, &LoadLimits::default().with(limit, most)).unwrap_err().to_string();
        assert!(message.contains(&format!("`{}=", limit.name())), "{limit:?}: {message}");
    }
}

#[track_caller]
fn in_time<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let began = Instant::now();
    let done = work();
    let is_in_time = began.elapsed() < Duration::from_secs(HOSTILE_FILE_SECONDS);
    assert!(is_in_time, "{what}: {:.1} s", began.elapsed().as_secs_f64());
    done
}

#[test]
fn time_does_not_grow_with_the_square_of_a_robot() {
    let limits = LoadLimits::default().with(LoadLimit::Links, 30_000);
    let load = |text: &str, files: &[(&str, &[u8])]| scene_of(text, files, &limits);
    let two = chain(2, false);
    let disabled: String = (0..100_000).map(|k| format!("<disable_collisions link1='a{k}' link2='b'/>\n")).collect();
    let srdf = format!("<robot>{disabled}</robot>");
    let with_srdf = format!("{ROBOT}srdf = 'r.srdf'\n{}", obstacles(1));
    let files = [("r.urdf", two.as_bytes()), ("r.srdf", srdf.as_bytes())];
    in_time("disabled pairs", || load(&with_srdf, &files).unwrap());
    let mimic = chain(20_000, true);
    in_time("a chain of followers", || load(ROBOT, &[("r.urdf", mimic.as_bytes())]).unwrap());
    let many = format!("{ROBOT}{}", obstacles(50_000));
    let scene = in_time("obstacles", || load(&many, &[("r.urdf", two.as_bytes())]).unwrap());
    assert_eq!(scene.pairs().len(), 50_000);
    let names = (0..50_000).map(|k| format!("['l1', 'o{k}']")).collect::<Vec<_>>().join(", ");
    let none = format!("{many}[pairs]\ndisable = [{names}]\n");
    let scene = in_time("disabled obstacles", || load(&none, &[("r.urdf", two.as_bytes())]).unwrap());
    assert!(scene.pairs().is_empty());
    let prefixes: String = (0..200_000).map(|k| format!("<p{}:x/>", k % 60)).collect();
    let prefixes = two.replace("</robot>", &format!("{prefixes}</robot>"));
    in_time("prefixes", || load(ROBOT, &[("r.urdf", prefixes.as_bytes())]).unwrap());
}

#[test]
fn time_does_not_grow_with_the_square_of_a_mesh() {
    // All but three corners lie within one cell of the welding tolerance.
    let corner = |k: usize| [k % 40, k / 40 % 40, k / 1600].map(|x| 1e-8 * x as f64);
    let crowd: String = (0..48_000).map(corner).map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let faces: String = (4..40_000).step_by(3).map(|k| format!("f {k} {} {}\n", k + 1, k + 41)).collect();
    let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{crowd}f 1 2 3\n{faces}");
    in_time("corners in one cell", || parse("a.obj", text.as_bytes()).unwrap());
    let cube = |k: usize| {
        let corner = |c: usize| [c & 1, c >> 1 & 1, c >> 2].map(|bit| (2.0 * bit as f64 - 1.0) * (1.0 + k as f64));
        let corners: String = (0..8).map(corner).map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
        let faces = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]];
        let face = |mut face: [usize; 4]| {
            face.iter_mut().for_each(|corner| *corner += 8 * k);
            if k % 2 == 1 {
                face.reverse();
            }
            format!("f {} {} {} {}\n", face[0], face[1], face[2], face[3])
        };
        corners + &faces.map(face).concat()
    };
    let nested: String = (0..5_000).map(cube).collect();
    in_time("nested parts", || parse("a.obj", nested.as_bytes()).unwrap());
    let few: String = (0..4).map(cube).collect();
    let few = parse("a.obj", few.as_bytes()).unwrap();
    assert_eq!((0..4).filter(|&component| few.is_cavity(component)).count(), 2, "a few parts have cavities");
    let primitive = "<triangles><input semantic='VERTEX' source='#v' offset='0'/><p>0 1 2</p></triangles>";
    let many = DAE.replace("</mesh>", &format!("{}</mesh>", primitive.repeat(3_000)));
    let many = many.replace("0 0 0 1 0 0 0 1 0", &"0 0 0 1 0 0 0 1 0 ".repeat(20_000));
    in_time("primitives of one array", || parse("a.dae", many.replace("NODES", "").as_bytes()).unwrap());
    let shown = many.replace("NODES", &"<instance_geometry url='#g'/>".repeat(1_000));
    in_time("geometries shown again", || parse("a.dae", shown.as_bytes()).unwrap());
    let corners = (0..27_000).map(|k| format!("{k} {} {} ", k % 7, k % 11)).collect::<String>();
    let indices = (0..27_000).map(|k| format!("{k} ")).collect::<String>();
    let large = DAE.replace("0 0 0 1 0 0 0 1 0", &corners).replace("0 1 2", &indices);
    let large = large.replace("NODES", &"<instance_geometry url='#g'/>".repeat(500));
    let refused = in_time("a large geometry shown again", || parse("a.dae", large.as_bytes()).unwrap_err().to_string());
    assert!(refused.contains("`placed="), "{refused}");
}

/// Corners and triangles lie anywhere: what is near in the file is far apart in space, and
/// everything overlaps.
#[test]
fn time_does_not_grow_with_the_disorder_of_a_mesh() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut corners = |count: usize, height: f64| -> String {
        let mut line = |_| {
            let [x, y, z]: [f64; 3] = rng.random();
            format!("v {x} {y} {}\n", height * z)
        };
        (0..count).map(&mut line).collect()
    };
    let (flat, few) = (corners(300_000, 0.0), corners(1_000, 1.0));
    let outline: String = (1..=300_000).map(|k| format!(" {k}")).collect();
    let face = format!("{flat}f{outline}\n");
    in_time("a face of many corners", || parse("a.obj", face.as_bytes()).unwrap());
    let mut corner = || rng.random_range(1..=1_000);
    let soup: String = (0..500_000).map(|_| format!("f {} {} {}\n", corner(), corner(), corner())).collect();
    let (soup, robot) = (format!("{few}{soup}"), chain(2, false).replace(BALL, "<mesh filename='t.obj'/>"));
    let files = [("r.urdf", robot.as_bytes()), ("t.obj", soup.as_bytes())];
    let scene = in_time("a soup of triangles", || scene_of(ROBOT, &files, &LoadLimits::default()).unwrap());
    in_time("a soup of triangles, prepared", || Checker::new(scene.into()));
}

#[test]
fn what_a_file_only_announces_takes_nothing() {
    let limits = LoadLimits::default();
    let read = |name: &str, bytes: &[u8]| {
        let mut beside = |_: &str| Ok(vec![0; 1 << 20]);
        in_time(name, || parse_among(name, bytes, &limits, &mut beside, &mut Vec::new()).unwrap_err().to_string())
    };
    let ply = "ply\nformat binary_little_endian 1.0\nelement nothing 4000000000\nelement vertex 0\nproperty float x\n\
               property float y\nproperty float z\nend_header\n";
    assert!(read("a.ply", ply.as_bytes()).contains("element nothing"));
    let few = ply.replace("4000000000", "1000000");
    assert!(read("a.ply", few.as_bytes()).contains("got 1000000 of nothing in"));
    let gltf = |rest: &str| format!("{{\"asset\":{{\"version\":\"2.0\"}},{rest}}}");
    let buffers = vec!["{\"uri\":\"b.bin\",\"byteLength\":9}"; 10_000].join(",");
    assert!(read("a.gltf", gltf(&format!("\"buffers\":[{buffers}]")).as_bytes()).contains("no triangles"));
    let nodes = vec!["{}"; 2_000_000].join(",");
    assert!(read("a.gltf", gltf(&format!("\"nodes\":[{nodes}]")).as_bytes()).contains("mesh-nodes"));
    let mut stl = vec![0; 134];
    stl[80..84].copy_from_slice(&4_000_000_000u32.to_le_bytes());
    assert!(read("a.stl", &stl).contains("got 134 bytes"));
    let values = format!("clearance = [{}]", "1,".repeat(6_000_000));
    let refused = in_time("an array", || scene_of(&values, &[], &limits).unwrap_err().to_string());
    assert!(refused.contains("`values="), "{refused}");
    let laughs = "a: &a [1,1,1,1,1,1,1,1,1]\nb: &b [*a,*a,*a,*a,*a,*a,*a,*a,*a]\nc: &c [*b,*b,*b,*b,*b,*b,*b,*b,*b]\n\
                  d: &d [*c,*c,*c,*c,*c,*c,*c,*c,*c]\ne: &e [*d,*d,*d,*d,*d,*d,*d,*d,*d]\nf: &f [*e,*e,*e,*e,*e,*e,*e,*e]\n\
                  g: &g [*f,*f,*f,*f,*f,*f,*f,*f,*f]\nworld: [*g,*g,*g,*g,*g,*g,*g,*g,*g]\n";
    let read = || import(Path::new("w.yaml"), laughs, None, &limits.clone().with(LoadLimit::Values, 10_000));
    assert!(in_time("aliases", read).is_err());
}

#[test]
fn indices_are_whole_numbers() {
    let good = DAE.replace("NODES", "<instance_geometry url='#g'/>");
    assert_eq!(parse("a.dae", good.as_bytes()).unwrap().triangles.len(), 1);
    let message = |text: String| parse("a.dae", text.as_bytes()).unwrap_err().to_string();
    for bad in ["nan 1 2", "0.9 1.9 2.2", "-1 1 2", "0 1 3", "inf 1 2"] {
        assert!(message(good.replace("0 1 2<", &format!("{bad}<"))).contains("expected one of 3 vertices"), "{bad}");
    }
    let polygons = good.replace("triangles>", "polylist>").replace("<p>", "<vcount>COUNT</vcount><p>");
    assert_eq!(parse("a.dae", polygons.replace("COUNT", "3").as_bytes()).unwrap().triangles.len(), 1);
    for bad in ["3.7", "-3", "nan", "1e300"] {
        assert!(message(polygons.replace("COUNT", bad)).contains("expected whole numbers of corners"), "{bad}");
    }
    assert!(message(good.replace("offset='0'", "offset='0.5'")).contains("expected a small whole number"));
}

#[test]
fn messages_are_short_whatever_files_hold() {
    let limits = LoadLimits::default();
    let long = "x ".repeat(1 << 20);
    let two = chain(2, false);
    let scene = |text: &str, urdf: &str| scene_of(text, &[("r.urdf", urdf.as_bytes())], &limits).unwrap_err();
    let name = "n".repeat(1 << 20);
    let roots: String = (0..9_000).map(|k| format!("<link name='l{k}'/>")).collect();
    let mesh = |file: &str, text: String| parse(file, text.as_bytes()).unwrap_err();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let errors = [
        mesh("a.stl", format!("solid a\nfacet normal 0 0 1\nouter loop\nvertex {long}\n")),
        mesh("a.obj", format!("{triangle}f 1 2 {long}\n")),
        mesh("a.ply", format!("ply\nformat ascii 1.0\nelement {name} 3\n{long}\nend_header\n")),
        mesh("a.dae", DAE.replace("0 1 2", &name)),
        mesh("a.gltf", format!("{{\"asset\": \"{long}\"}}")),
        mesh(&format!("a.{name}"), String::new()),
        scene(ROBOT, &format!("<robot>{roots}</robot>")),
        scene(ROBOT, &two.replace("l1", &name)),
        scene(ROBOT, &two.replace("0.1", &long)),
        scene(ROBOT, &two.replace("revolute", &name)),
        scene(ROBOT, &two.replace("sphere", &name)),
        scene(&format!("{ROBOT}locked = {{ '{name}' = 1 }}\n"), &two),
        scene(&format!("{ROBOT}[pairs]\ndisable = [['{name}', 'l0']]\n"), &two),
        scene(&format!("[[robot]]\nurdf = '{name}'\n"), &two),
        scene(&format!("{ROBOT}{name} = 3\n"), &two),
        builtin::scene("planar-arm")
            .unwrap()
            .moved([(name.as_str(), extricate::geometry::Pose::identity())])
            .unwrap_err(),
    ];
    for (number, error) in errors.iter().enumerate() {
        let message = error.to_string();
        assert!(message.len() < 2500, "{number}: {} bytes: {}", message.len(), &message[..300]);
    }
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_are_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.stl");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo");
    assert!(made.success());
    let scene = folder.path().join("s.toml");
    for named in [pipe.display().to_string(), "/dev/zero".into()] {
        std::fs::write(folder.path().join("r.urdf"), chain(2, false)).unwrap();
        std::fs::write(&scene, format!("{ROBOT}[[obstacle]]\nname = 'o'\nshape = {{ points = '{named}' }}\n")).unwrap();
        let message = in_time("as points", || load_scene(&scene).unwrap_err().to_string());
        assert!(message.contains("it is a device or a pipe, expected a file"), "{message}");
        std::fs::write(&scene, format!("[[robot]]\nurdf = '{named}'\n")).unwrap();
        let message = in_time("as a URDF", || load_scene(&scene).unwrap_err().to_string());
        assert!(message.contains("it is a device or a pipe, expected a file"), "{message}");
        let message = in_time("as a scene", || load_scene(&named).unwrap_err().to_string());
        assert!(message.contains("it is a device or a pipe, expected a file"), "{message}");
    }
}
