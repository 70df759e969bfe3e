//! COLLADA files written here; positions as coal (through assimp) gives them, but for the unit.

use super::super::TriangleMesh;
use super::super::mesh_file::parse;
use crate::math::Vec3;

const TETRAHEDRON: &str = "<triangles count='4'><input semantic='NORMAL' source='#none' offset='1'/>\
    <input semantic='VERTEX' source='#v' offset='0'/><p>0 0 2 0 1 0 0 0 1 0 3 0 0 0 3 0 2 0 1 0 2 0 3 0</p></triangles>";

fn dae(unit: &str, nodes: &str, primitives: &str) -> String {
    format!(
        "<?xml version='1.0'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>\
        <asset>{unit}<up_axis>Y_UP</up_axis></asset><library_geometries><geometry id='g'><mesh>\
        <source id='p'><float_array id='pa' count='12'>0 0 0 1 0 0 0 2 0 0 0 3</float_array><technique_common>\
        <accessor source='#pa' count='4' stride='3'/></technique_common></source>\
        <vertices id='v'><input semantic='POSITION' source='#p'/></vertices>{primitives}</mesh></geometry>\
        </library_geometries><library_nodes><node id='n'><translate>0 0 5</translate><instance_geometry url='#g'/></node>\
        </library_nodes><library_visual_scenes><visual_scene id='s'>{nodes}</visual_scene></library_visual_scenes>\
        <scene><instance_visual_scene url='#s'/></scene></COLLADA>"
    )
}

fn bounds(mesh: &TriangleMesh) -> [Vec3; 2] {
    let first = mesh.vertices[0];
    mesh.vertices.iter().fold([first, first], |[low, high], v| [low.inf(v), high.sup(v)])
}

fn assert_bounds(unit: &str, nodes: &str, low: [f64; 3], high: [f64; 3]) {
    let mesh = parse("a.dae", dae(unit, nodes, TETRAHEDRON).as_bytes()).unwrap();
    assert!(mesh.is_closed());
    let found = bounds(&mesh);
    let error = (found[0] - Vec3::from(low)).norm() + (found[1] - Vec3::from(high)).norm();
    assert!(error < 1e-12, "{nodes}: {found:?}");
}

const HERE: &str = "<instance_geometry url='#g'/>";

#[test]
fn nodes_place_and_units_scale() {
    assert_bounds("", &format!("<node>{HERE}</node>"), [0., 0., 0.], [1., 2., 3.]);
    assert_bounds("<unit meter='0.001'/>", &format!("<node>{HERE}</node>"), [0., 0., 0.], [0.001, 0.002, 0.003]);
    let nested =
        format!("<node><translate>10 0 0</translate><node><rotate>0 0 1 90</rotate>{HERE}</node></node><node/>");
    assert_bounds("", &nested, [8., 0., 0.], [10., 1., 3.]);
    let twice = format!("<node><translate>10 0 0</translate>{HERE}</node><node>{HERE}</node>");
    assert_bounds("", &twice, [0., 0., 0.], [11., 2., 3.]);
    let order = "<node><scale>2 1 1</scale><translate>10 0 0</translate><rotate>1 0 0 90</rotate>";
    assert_bounds("", &format!("{order}{HERE}</node>"), [20., -3., 0.], [22., 0., 2.]);
    let matrix = format!("<node><matrix>0 -1 0 7 1 0 0 8 0 0 1 9 0 0 0 1</matrix>{HERE}</node>");
    assert_bounds("", &matrix, [5., 8., 9.], [7., 9., 12.]);
    assert_bounds("", "<node><instance_node url='#n'/></node>", [0., 0., 5.], [1., 2., 8.]);
    // Nothing in the scene: the geometry as it is.
    assert_bounds("", "<node><translate>10 0 0</translate></node>", [0., 0., 0.], [1., 2., 3.]);
}

#[test]
fn every_primitive_makes_triangles() {
    let input = "<input semantic='VERTEX' source='#v' offset='0'/>";
    let fans = format!("<trifans>{input}<p>0 1 2 3</p></trifans><trifans>{input}<p>0 3 1</p><p>1 3 2</p></trifans>");
    let strips = format!("<tristrips>{input}<p>0 2 1 3 0 2</p></tristrips>");
    let polygons = format!("<polygons>{input}<p>0 2 1</p><p>0 1 3</p><ph><p>0 3 2</p></ph><p>1 2 3</p></polygons>");
    let polylist = format!("<polylist>{input}<vcount>3 3 3 3</vcount><p>0 2 1 0 1 3 0 3 2 1 2 3</p></polylist>");
    for primitives in [fans, strips, polygons, polylist] {
        let mesh = parse("a.dae", dae("", "", &primitives).as_bytes()).unwrap();
        assert!(mesh.is_closed() && mesh.vertices.len() == 4 && mesh.triangles.len() == 4, "{primitives}");
    }
}

#[test]
fn what_is_wrong_is_named() {
    let message = |text: &str| parse("a.dae", text.as_bytes()).unwrap_err().to_string();
    let good = dae("", &format!("<node>{HERE}</node>"), TETRAHEDRON);
    assert!(message(&good.replace("'#g'", "'#h'")).contains("got url=\"#h\", expected `#` and an id in this file"));
    assert!(message(&good.replace("2 0 3 0<", "2 0 4 0<")).contains("got index 4, expected one of 4 vertices"));
    assert!(message(&good.replace("2 0 3 0<", "2 0<")).contains("got 11 corners, expected 12"));
    assert!(message(&good.replace("0 2 0 0 0 3<", "0 2 x 0 0 3<")).contains("got `x`, expected a number"));
    assert!(message(&good.replace("0 2 0 0 0 3<", "0 2 NaN 0 0 3<")).contains("expected finite coordinates"));
    assert!(message(&good.replace("COLLADA", "robot")).contains("got <robot>, expected <COLLADA>"));
    assert!(message(&dae("<unit meter='0'/>", "", TETRAHEDRON)).contains("expected a positive number"));
    let cycle = good
        .replace("<node id='n'>", "<node id='n'><instance_node url='#n'/>")
        .replace("<node>", "<node><instance_node url='#n'/>");
    assert!(message(&cycle).contains("expected no cycle"));
}

#[test]
fn truncation_never_panics() {
    let good = dae("<unit meter='1'/>", &format!("<node>{HERE}</node>"), TETRAHEDRON);
    for length in 0..good.len() {
        assert!(parse("a.dae", &good.as_bytes()[..length]).is_err());
    }
}
