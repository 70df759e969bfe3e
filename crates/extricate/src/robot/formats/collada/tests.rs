//! Tests COLLADA files written here, with positions as coal gives them (through assimp), except for
//! the unit.

use crate::math::Vec3;
use crate::robot::formats::parse;
use crate::robot::{LoadLimits, TriangleMesh};

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
    // The scene shows nothing, so the geometry stays unplaced.
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
fn nodes_that_show_each_other_twice_do_not_fill_the_memory() {
    let good = dae("", "<node><instance_node url='#n0'/></node>", TETRAHEDRON);
    for (last, refused) in [("", "got 1000001 nodes (those shown again count)"), (HERE, "`placed=")] {
        let link =
            |k: usize| format!("<node id='n{k}'>{}</node>", format!("<instance_node url='#n{}'/>", k + 1).repeat(2));
        let nodes: String = (0..40).map(link).collect();
        let text = good.replace("<node id='n'>", &format!("{nodes}<node id='n40'>{last}</node><node id='n'>"));
        let message = parse("a.dae", text.as_bytes()).unwrap_err().to_string();
        assert!(message.contains(refused), "{message}");
    }
}

/// A frame: an outer ring of side 4 and an inner one of side 2, both from z = -0.5 to 0.5.
fn frame(front: &str, back: &str) -> String {
    let mut points = String::new();
    for z in ["-0.5", "0.5"] {
        for half in [2, 1] {
            for [x, y] in [[-1, -1], [1, -1], [1, 1], [-1, 1]] {
                points += &format!("{} {} {z} ", x * half, y * half);
            }
        }
    }
    let input = "<input semantic='VERTEX' source='#v' offset='0'/>";
    let side = |ring: usize, k: usize, inward: bool| {
        let (a, b) = (4 * ring + k, 4 * ring + (k + 1) % 4);
        let quad = if inward { [b, a, a + 8, b + 8] } else { [a, b, b + 8, a + 8] };
        format!("<p>{} {} {} {}</p>", quad[0], quad[1], quad[2], quad[3])
    };
    let sides: String = (0..4).map(|k| side(0, k, false) + &side(1, k, true)).collect();
    dae("", "", &format!("<polygons>{input}{front}{back}{sides}</polygons>"))
        .replace("0 0 0 1 0 0 0 2 0 0 0 3", points.trim())
        .replace("count='12'", "count='48'")
        .replace("count='4' stride", "count='16' stride")
}

#[test]
fn holes_of_polygons_stay_open() {
    let [front, back] = [
        "<ph><p>8 9 10 11</p><h>12 15 14 13</h></ph>",
        // Holes may be wound either way.
        "<ph><p>0 3 2 1</p><h>4 7 6 5</h></ph>",
    ];
    let mut warnings = Vec::new();
    let mesh = crate::robot::formats::parse_and_warn("a.dae", frame(front, back).as_bytes(), &mut warnings).unwrap();
    assert!(mesh.is_closed() && warnings.is_empty(), "{warnings:?}");
    let volume = crate::robot::Geometry::Mesh(mesh.into()).volume_moments().unwrap().measure;
    assert!((volume - 12.0).abs() < 1e-12, "{volume}");
    // A face is named if its hole reaches beyond its outline, and the solid stays closed.
    let wrong = frame(front, "<ph><p>4 7 6 5</p><h>0 3 2 1</h></ph>");
    let mesh = crate::robot::formats::parse_and_warn("a.dae", wrong.as_bytes(), &mut warnings).unwrap();
    assert!(mesh.is_closed());
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].starts_with("a.dae: <polygons> in line 1: face 2: a face of 8 corners"), "{warnings:?}");
}

#[test]
fn mirrored_nodes_keep_what_faces_outward() {
    let facing = |scale: &str| {
        let node = format!("<node><scale>{scale}</scale>{HERE}</node>");
        let soup = super::parse("a.dae", dae("", &node, TETRAHEDRON).as_bytes(), &LoadLimits::default()).unwrap();
        let volume = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|k| soup.vertices[k as usize]);
            a.cross(&b).dot(&c)
        };
        soup.triangles.iter().map(volume).sum::<f64>()
    };
    assert!((facing("1 1 1") - facing("1 -1 1")).abs() < 1e-12);
}

#[test]
fn indices_are_numbers_of_vertices() {
    let good = dae("", &format!("<node>{HERE}</node>"), TETRAHEDRON);
    for index in ["NaN", "-1", "4", "inf"] {
        let bad = good.replace("2 0 3 0<", &format!("2 0 {index} 0<"));
        assert!(parse("a.dae", bad.as_bytes()).unwrap_err().to_string().contains("expected one of 4 vertices"));
    }
}

#[test]
fn truncation_never_panics() {
    let good = dae("<unit meter='1'/>", &format!("<node>{HERE}</node>"), TETRAHEDRON);
    for length in 0..good.len() {
        assert!(parse("a.dae", &good.as_bytes()[..length]).is_err());
    }
}
