//! Facets and edges to paths: the far ones first, lit from the upper left, facets that face away
//! left out.

use std::fmt::Write;

use extricate::geometry::Vec3;
use svg::node::element::{Group, Path};

use super::camera::{Camera, Projected};
use super::surface::{Facet, Look, Surface};

/// Steps of brightness; neighbours of one step share a path.
const SHADES: f64 = 24.0;
/// Toward the light: right, up and toward the camera.
const LIGHT: [f64; 3] = [-0.35, 0.75, 0.55];
/// Brightness of what no light reaches.
const AMBIENT: f64 = 0.45;

/// Colour of the edges of obstacles.
const EDGE: Paint = Paint { rgb: [122, 106, 78], opacity: 1.0 };

/// What a path looks like; facets of one paint that follow each other share a path.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Paint {
    rgb: [u8; 3],
    opacity: f64,
}

/// A facet or a piece of an edge, ready to be drawn.
struct Item {
    distance: f64,
    paint: Paint,
    /// Two for an edge, three for a facet.
    corners: Vec<Projected>,
}

/// All visible facets of `surfaces` as seen by `camera`.
pub fn facets(surfaces: &[&Surface], camera: &Camera) -> Group {
    let light = camera.direction(LIGHT).normalize();
    let mut items = Vec::new();
    for facet in surfaces.iter().flat_map(|s| &s.facets) {
        let normal = facet.normal();
        let toward_eye = camera.eye - facet.middle();
        if normal.dot(&toward_eye) > 0.0 {
            let corners = facet.corners.iter().map(|c| camera.project(c)).collect();
            items.push(Item { distance: toward_eye.norm(), paint: paint(facet, &normal, &light), corners });
        }
    }
    for ends in surfaces.iter().flat_map(|s| &s.edges) {
        let distance = (camera.eye - 0.5 * (ends[0] + ends[1])).norm();
        items.push(Item { distance, paint: EDGE, corners: ends.iter().map(|c| camera.project(c)).collect() });
    }
    items.sort_by(|a, b| b.distance.total_cmp(&a.distance));
    let group = Group::new().set("stroke-linejoin", "round").set("stroke-linecap", "round").set("stroke-width", 0.5);
    items.chunk_by(|a, b| a.paint == b.paint).fold(group, |group, run| group.add(path(run)))
}

fn paint(facet: &Facet, normal: &Vec3, light: &Vec3) -> Paint {
    let lambert = normal.dot(light).max(0.0);
    let shade = ((AMBIENT + (1.0 - AMBIENT) * lambert) * SHADES).round() / SHADES;
    // Two tones, so that neighbouring links are told apart.
    let link = if facet.body.is_multiple_of(2) { [0.66, 0.76, 0.88] } else { [0.93, 0.94, 0.96] };
    let (colour, opacity) = match (facet.look, facet.obstacle) {
        (Look::Hit, false) => ([0.93, 0.27, 0.22], 1.0),
        (Look::Hit, true) => ([0.95, 0.55, 0.35], 0.5),
        (Look::Plain, false) => (link, 1.0),
        (Look::Plain, true) => ([0.80, 0.70, 0.52], 0.38),
        (Look::Ghost, _) => ([0.93, 0.27, 0.22], 0.13),
    };
    Paint { rgb: colour.map(|c: f64| (255.0 * c * shade).round() as u8), opacity }
}

/// Items of one paint as one path.
fn path(run: &[Item]) -> Path {
    let Paint { rgb: [r, g, b], opacity } = run[0].paint;
    // Translucent facets carry no stroke to hide rounding, so theirs has to be finer.
    let per_pixel = if opacity < 1.0 { 100.0 } else { 10.0 };
    let mut data = String::new();
    run.iter().for_each(|item| append(&mut data, &item.corners, per_pixel));
    let colour = format!("#{r:02x}{g:02x}{b:02x}");
    let path = Path::new().set("d", data).set("fill", colour.clone());
    if opacity < 1.0 {
        // A stroke would be seen twice where translucent neighbours meet; without one only sharp
        // edges leave no seam.
        path.set("fill-opacity", opacity).set("shape-rendering", "crispEdges")
    } else {
        path.set("stroke", colour)
    }
}

/// Relative coordinates: half the bytes of absolute ones.
fn append(data: &mut String, corners: &[Projected], per_pixel: f64) {
    let steps = |p: &Projected| [p.x, p.y].map(|v| (per_pixel * v).round() as i64);
    let mut last = [0, 0];
    for (k, corner) in corners.iter().enumerate() {
        let now = steps(corner);
        let lead = ["M", "l", " "][k.min(2)];
        for (lead, value) in [(lead, now[0] - last[0]), (" ", now[1] - last[1])] {
            // A minus sign parts numbers well enough.
            let lead = if value < 0 && lead == " " { "" } else { lead };
            write!(data, "{lead}{}", value as f64 / per_pixel).expect("writing to a string");
        }
        last = now;
    }
    data.push('z');
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::camera::Frame;

    #[test]
    fn what_faces_away_is_left_out_and_runs_share_a_path() {
        let corners = |x: f64| [[x, 0.0, 0.0], [x + 0.1, 0.0, 0.0], [x, 0.0, 0.1]].map(Vec3::from);
        let facet = |corners: [Vec3; 3]| Facet { corners, body: 0, obstacle: false, look: Look::Plain };
        let turned = |[a, b, c]: [Vec3; 3]| [a, c, b];
        let seen = Surface {
            facets: vec![facet(corners(0.0)), facet(corners(0.2)), facet(turned(corners(0.4)))],
            edges: vec![],
        };
        let camera = Camera::facing(&seen, &seen, Frame { width: 100.0, height: 100.0 });
        let text = facets(&[&seen], &camera).to_string();
        assert_eq!(text.matches("<path").count(), 1, "{text}");
        let drawn = text.matches('M').count();
        assert!(drawn == 1 || drawn == 2, "one side or the other: {text}");
    }
}
