//! First inputs of the targets that read texts and meshes, with one of each kind of thing that a
//! format can express.

use extricate::builtin;

/// An input and its name.
type Seed = (String, Vec<u8>);

/// A URDF with all kinds of joints, shapes, limits and warnings.
pub const ARM: &str = "<?xml version='1.0'?><!DOCTYPE robot [<!ELEMENT robot ANY>]><robot name='arm' xmlns:k='k'>\n\
    <link name='base'><collision><origin xyz='0 0 -0.2' rpy='0 0 0.5'/><geometry><box size='0.4 0.4 0.1'/></geometry>\
    </collision></link><link name='a'><collision><geometry><cylinder radius='0.1' length='0.5'/></geometry></collision>\
    <visual><geometry><sphere radius='0'/></geometry></visual></link>\n<link name='b'><collision><geometry><mesh \
    filename='t.obj' scale='1 -2 0.5'/></geometry></collision></link><link name='c'><collision><geometry>\
    <capsule radius='0.05' length='0.2'/></geometry></collision></link><link name='d'/><link name='e'><collision><geometry>\
    <sphere radius='0.1'/></geometry></collision></link>\n<s:x y:z='1'/>\
    <joint name='j1' type='revolute'><origin xyz='0 0 1'/><parent link='base'/><child link='a'/><axis xyz='0 0 1'/>\
    <limit lower='-2' upper='2' effort='1' velocity='1'/></joint><joint name='j2' type='prismatic'><origin xyz='0.5 0 0'/>\
    <parent link='a'/><child link='b'/><axis xyz='1 0 0'/><limit lower='0' upper='0.4'/></joint>\n<joint name='j3' \
    type='continuous'><origin xyz='0.5 0 0' rpy='0 1.5 0'/><parent link='b'/><child link='c'/><axis xyz='0 1 1'/></joint>\
    <joint name='j4' type='revolute'><parent link='c'/><child link='d'/><axis xyz='1 0 0'/><mimic joint='j1' \
    multiplier='-0.5' offset='0.1'/></joint><joint name='j5' type='fixed'><origin xyz='1 1 1'/><parent link='d'/>\
    <child link='e'/></joint></robot>";

/// An SRDF with groups of every kind, and everything that decides which pairs are checked.
pub const GROUPS: &str = "<robot name='arm'><virtual_joint name='w' type='fixed' parent_frame='w' child_link='base'/>\
    <group name='arm'><chain base_link='base' tip_link='c'/><group name='more'/></group><group name='more'><link name='d'/>\
    <joint name='j3'/><joint name='w'/></group><disable_collisions link1='a' link2='c' reason='Never'/>\
    <disable_default_collisions link='e'/><enable_collisions link1='e' link2='a'/></robot>";

/// An OBJ of a tetrahedron of 1 m.
pub const TETRAHEDRON: &str =
    "o t\nv 0 0 0\nv 1 0 0 # x\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1/1 2/2 4/3\nf 1//1 4//2 3//2\nf -3 -2 -1\n";

const SCENE: &str = "clearance = { world = 1e-3, self = 1e-4 }\nmetric = { kind = 'joint', weights = { j1 = 2 } }\n\
    padding = { a = 0.01 }\n[[robot]]\nurdf = 'arm.urdf'\nsrdf = 'arm.srdf'\ngroup = 'arm'\nname = 'r'\nbase = 'planar'\n\
    bounds = { min = [-1, -1], max = [1, 1] }\nlocked = { j2 = 0.1 }\nlimits = { j1 = [-1, 1] }\npackages = ['.']\n\
    geometry = 'convex-hull'\npose = { xyz = [0, 0, 0.5], rpy = [0, 0, 1] }\n";

const OBSTACLES: &str = "[[obstacle]]\nname = 'box'\nshape = { box = [1, 2, 0.1] }\npose = { xyz = [1, 0, 1], quat_wxyz = \
    [1, 0, 0, 0] }\n[[obstacle]]\nname = 'mesh'\nshape = { mesh = 't.obj', scale = [1, 2, -1], convex = true }\n\
    [[obstacle]]\nname = 'points'\nshape = { points = 'p.xyz', radius = 0.1 }\n[[obstacle]]\nname = 'cells'\n\
    shape = { voxels = [[9, 9, 9], [9, 9, 8]], size = 0.2 }\n[[obstacle]]\nname = 'floor'\nshape = { half-space = [0, 0, 1], \
    offset = -3 }\n[[obstacle]]\nname = 'ground'\nshape = { height-field = [[0, 1], [1, 0]], size = 1 }\n\
    pose = { xyz = [0, 0, -5] }\n[[attached]]\nname = 'can'\nlink = 'LINK'\nshape = { cylinder = [0.03, 0.1] }\n\
    touch = ['box']\n[pairs]\ndisable = [['LINK', 'box']]\nclearance = [['LINK', 'mesh', 1e-3]]\n";

const WORLD_TEXT: &str = "(noname)+++\n* table\n0.5 0 0.1\n0 0 0 1\n4\nbox\n0.4 0.6 0.2\n0.1 0 0\n0 0 0 1\n0 0 0 0\ncone\n\
    0.1 0.3\n0 0 1\n0 0 0 1\n0 0 0 0\nplane\n0 0 2 1\n0 0 0\n0 0 0 1\n0 0 0 0\nmesh\n4 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n\
    0 2 1\n0 1 3\n1 2 3\n2 0 3\n0 0 3\n0 0 0 1\n0 0 0 0\n0\n.\n";

const WORLD_YAML: &str = "world:\n  collision_objects:\n  - id: box\n    header: {frame_id: world}\n    primitives:\n\
    \x20   - {type: 1, dimensions: [0.1, 0.2, 0.3]}\n    primitive_poses:\n    - position: {x: 1, y: 0, z: 2}\n\
    \x20     orientation: {x: 0, y: 0, z: 0, w: 1}\n    operation: 0\n  octomap:\n\
    \x20   octomap: {binary: true, id: OcTree, resolution: 0.1, data: AMADAAMAAwADAAMAAwADAAMAAwADAAMAAwADAAMACgA=}\n\
    allowed_collision_matrix:\n\
    \x20 entry_names: [box, link_1]\n  entry_values:\n  - enabled: [false, true]\n  - enabled: [true, false]\n\
    \x20 default_entry_names: [box]\n  default_entry_values: [true]\nlink_padding:\n- {link_name: link_1, padding: 0.01}\n";

const WORLD_JSON: &str = "{\"world\": {\"collision_objects\": [{\"id\": \"m\", \"meshes\": [{\"vertices\": [{\"x\": 0, \"y\": 0, \
    \"z\": 5}, {\"x\": 1, \"y\": 0, \"z\": 5}, {\"x\": 0, \"y\": 1, \"z\": 5}], \"triangles\": [{\"vertex_indices\": \
    [0, 1, 2]}]}], \"mesh_poses\": [{}]}]}, \"robot_state\": {\"attached_collision_objects\": [{\"link_name\": \"link_6\", \
    \"object\": {\"id\": \"can\", \"primitives\": [{\"type\": 3, \"dimensions\": [0.1, 0.02]}]}, \"touch_links\": \
    [\"link_5\"]}]}, \"is_diff\": true}";

const QUERIES: &str = "# lines\n[0, 0.3, 0, -1.8, 0, 2, 0.8]\n{\"id\": 1, \"q\": [0, 0, 0, -1, 0, 1, 0]}\n\
    0.1,0.2,0,-1,0,1,0\n0.1 0.2 0 -1 0 1 0\n{\"q\": {\"joint_1\": 0.5, \"joint_2\": [0.1]}}\n\
    {\"name\": [\"joint_1\"], \"position\": [0.5]}\n{\"from\": [0, 0, 0, -1, 0, 1, 0], \"to\": [0, 1, 0, -1, 0, 1, 0]}\n\
    [[0, 0, 0, -1, 0, 1, 0], [0, 1, 0, -1, 0, 1, 0]]\n[1e9, NaN, null, \"x\", true]\n";

const DAE: &str = "<?xml version='1.0'?><COLLADA xmlns='c' version='1.4.1'><asset><unit meter='0.1'/></asset>\
    <library_geometries><geometry id='g'><mesh><source id='p'><float_array id='pa' count='12'>0 0 0 1 0 0 0 2 0 0 0 3\
    </float_array><technique_common><accessor source='#pa' count='4' stride='3'/></technique_common></source>\
    <vertices id='v'><input semantic='POSITION' source='#p'/></vertices><triangles count='2'><input semantic='VERTEX' \
    source='#v' offset='0'/><input semantic='NORMAL' source='#n' offset='1'/><p>0 0 2 0 1 0 0 0 1 0 3 0</p></triangles>\
    <polylist count='1'><input semantic='VERTEX' source='#v' offset='0'/><vcount>4</vcount><p>0 1 2 3</p></polylist>\
    <polygons><input semantic='VERTEX' source='#v' offset='0'/><ph><p>0 1 2</p><h>0 1 3</h></ph></polygons>\
    <tristrips><input semantic='VERTEX' source='#v' offset='0'/><p>0 1 2 3</p></tristrips></mesh></geometry>\
    </library_geometries><library_controllers><controller id='c'><skin source='#g'><bind_shape_matrix>1 0 0 0 0 1 0 0 0 0 1 \
    0 0 0 0 1</bind_shape_matrix></skin></controller></library_controllers><library_visual_scenes><visual_scene id='s'>\
    <node id='n'><translate>1 2 3</translate><rotate>0 0 1 90</rotate><scale>1 -1 2</scale><instance_geometry url='#g'/>\
    <node><matrix>1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_controller url='#c'/></node></node><node>\
    <instance_node url='#n'/></node></visual_scene></library_visual_scenes><scene><instance_visual_scene url='#s'/></scene>\
    </COLLADA>";

const PLY: &str = "ply\nformat ascii 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    property uchar red\nelement camera 1\nproperty float view\nelement face 4\nproperty list uchar int vertex_indices\n\
    end_header\n0 0 0 1\n1 0 0 2\n0 1 0 3\n0 0 1 4\n9\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

fn named(seeds: impl IntoIterator<Item = impl Into<Vec<u8>>>) -> Vec<Seed> {
    seeds.into_iter().enumerate().map(|(number, bytes)| (format!("seed-{number}"), bytes.into())).collect()
}

/// Returns URDFs of robots.
pub fn urdf() -> Vec<Seed> {
    let built_in = builtin::files("shelf-arm").unwrap_or_default();
    let built_in = built_in.into_iter().filter(|(name, _)| name.ends_with("urdf")).map(|(_, bytes)| bytes);
    let short = "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='planar'><parent link='a'/>\
                 <child link='b'/></joint></robot>";
    named(built_in.chain([ARM.into(), short.into(), short.replace("planar", "floating").into()]))
}

/// Returns SRDFs of the arm.
pub fn srdf() -> Vec<Seed> {
    named([GROUPS, "<robot><group name='arm'><joint name='j1'/></group></robot>"])
}

/// Returns scene files of the arm.
pub fn scene() -> Vec<Seed> {
    named([format!("{SCENE}{}", OBSTACLES.replace("LINK", "c")), "[[robot]]\nurdf = 'a.urdf'\n".into(), SCENE.into()])
}

/// Returns worlds in the form of scene files.
pub fn world() -> Vec<Seed> {
    named([OBSTACLES.replace("LINK", "link_6"), "[[obstacle]]\nname = 'a'\nshape = { sphere = 0.5 }\n".into()])
}

/// Returns worlds of MoveIt in its three formats.
pub fn moveit() -> Vec<Seed> {
    named([WORLD_TEXT, WORLD_YAML, WORLD_JSON])
}

/// Returns lines of configurations.
pub fn queries() -> Vec<Seed> {
    named([QUERIES, "joint_1,joint_2\n0.1,0.2\n"])
}

/// Returns binary and ASCII STL files.
pub fn stl() -> Vec<Seed> {
    let corners = [[0f32, 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
    let (mut binary, mut ascii) = (vec![b' '; 80], String::from("solid a\n"));
    binary.extend(4u32.to_le_bytes());
    for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        binary.extend([0; 12]);
        ascii += "facet normal 0 0 1\nouter loop\n";
        for [x, y, z] in face.map(|k: usize| corners[k]) {
            [x, y, z].iter().for_each(|x| binary.extend(x.to_le_bytes()));
            ascii += &format!("vertex {x} {y} {z}\n");
        }
        binary.extend([0; 2]);
        ascii += "endloop\nendfacet\n";
    }
    named([binary, (ascii + "endsolid a\n").into()])
}

/// Returns OBJ files: a tetrahedron with indices of every form, and a concave face.
pub fn obj() -> Vec<Seed> {
    let concave = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nv 0 2 0\nf 1 2 3 \\\n4 5\n";
    named([TETRAHEDRON, concave])
}

/// Returns the only COLLADA file.
pub fn dae() -> Vec<Seed> {
    named([DAE])
}

/// Returns PLY files of both kinds.
pub fn ply() -> Vec<Seed> {
    let (header, _) = PLY.split_once("end_header\n").unwrap_or((PLY, ""));
    let mut binary = header.replace("ascii", "binary_little_endian").into_bytes();
    binary.extend(b"end_header\n");
    for corner in [[0f32, 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]] {
        corner.iter().for_each(|x| binary.extend(x.to_le_bytes()));
        binary.push(7);
    }
    binary.extend(1f32.to_le_bytes());
    for face in [[0i32, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        binary.push(3);
        face.iter().for_each(|k| binary.extend(k.to_le_bytes()));
    }
    named([binary, PLY.into()])
}

/// Returns glTF files: binary, and text that names a file.
pub fn glb() -> Vec<Seed> {
    let json = |buffer: &str| {
        format!(
            "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{{\"mesh\":0,\
             \"translation\":[1,0,0],\"children\":[1]}},{{\"mesh\":0,\"scale\":[1,-1,1]}}],\"meshes\":[{{\"primitives\":\
             [{{\"attributes\":{{\"POSITION\":0}},\"indices\":1}}]}}],\"accessors\":[{{\"bufferView\":0,\
             \"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,1]}},{{\"bufferView\":1,\
             \"componentType\":5121,\"count\":12,\"type\":\"SCALAR\"}}],\"bufferViews\":[{{\"buffer\":0,\"byteLength\":48}},\
             {{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}}],\"buffers\":[{{{buffer}\"byteLength\":60}}]}}"
        )
    };
    let mut data: Vec<u8> = Vec::new();
    for corner in [[0f32, 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]] {
        corner.iter().for_each(|x| data.extend(x.to_le_bytes()));
    }
    data.extend([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]);
    let mut text = json("").into_bytes();
    while !text.len().is_multiple_of(4) {
        text.push(b' ');
    }
    let mut binary = b"glTF\x02\0\0\0".to_vec();
    binary.extend((12 + 8 + text.len() as u32 + 8 + data.len() as u32).to_le_bytes());
    for (kind, bytes) in [(b"JSON", &text), (b"BIN\0", &data)] {
        binary.extend((bytes.len() as u32).to_le_bytes());
        binary.extend(kind);
        binary.extend(bytes);
    }
    named([binary, json("\"uri\":\"b.bin\",").into()])
}

/// Returns clouds of points: PCD in its three kinds, PLY without faces, text with colours.
pub fn cloud() -> Vec<Seed> {
    let head = |data: &str| {
        format!(
            "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\n\
             VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA {data}\n"
        )
    };
    let ascii = head("ascii") + "0 0 3 255\nnan nan nan 0\n";
    let (mut binary, mut packed) = (head("binary").into_bytes(), head("binary_compressed").into_bytes());
    for x in [0f32, 0., 3., 1., 1., 0., 3., 1.] {
        binary.extend(x.to_le_bytes());
    }
    // The data are four literals, and the rest repeats them.
    let lzf = [3, 0, 0, 128, 63, 7 << 5, 19, 3];
    packed.extend((lzf.len() as u32).to_le_bytes());
    packed.extend(32u32.to_le_bytes());
    packed.extend(lzf);
    let ply = PLY.split("element camera").next().unwrap_or_default().to_owned()
        + "element face 0\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1\n1 0 0 2\n0 nan 0 3\n0 0 1 4\n";
    named([ascii.into_bytes(), binary, packed, ply.into(), b"x,y,z,r\n0,0,3,9\nnan,nan,nan,0\n".to_vec()])
}
