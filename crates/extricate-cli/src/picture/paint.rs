//! Facets to paths: the far ones first, lit from the upper left, those that face away left out.

use std::fmt::Write;

use extricate::math::Vec3;
use svg::node::element::{Group, Path};

use super::camera::{Camera, Projected};
use super::surface::{Facet, Look, Surface};

/// Steps of brightness; neighbours of one step share a path.
const SHADES: f64 = 24.0;
/// Toward the light, world coordinates; turned with the camera it would flatten every picture the same way.
const LIGHT: [f64; 3] = [-0.4, -0.5, 0.77];
/// Brightness of what no light reaches.
const AMBIENT: f64 = 0.45;

/// What a path looks like; facets of one paint that follow each other share a path.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Paint {
    rgb: [u8; 3],
    opacity: f64,
}

/// All visible facets of `surfaces` as seen by `camera`.
pub fn facets(surfaces: &[&Surface], camera: &Camera) -> Group {
    let mut visible: Vec<(f64, Paint, [Projected; 3])> = Vec::new();
    for facet in surfaces.iter().flat_map(|s| &s.facets) {
        let normal = facet.normal();
        let toward_eye = camera.eye - facet.middle();
        if normal.dot(&toward_eye) > 0.0 {
            visible.push((toward_eye.norm(), paint(facet, &normal), facet.corners.map(|c| camera.project(&c))));
        }
    }
    visible.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut group = Group::new().set("stroke-linejoin", "round").set("stroke-width", 0.5);
    let mut run: Option<(Paint, String)> = None;
    for (_, paint, corners) in &visible {
        match &mut run {
            Some((current, data)) if current == paint => append(data, corners),
            _ => {
                if let Some((paint, data)) = run.take() {
                    group = group.add(path(paint, data));
                }
                let mut data = String::new();
                append(&mut data, corners);
                run = Some((*paint, data));
            }
        }
    }
    match run {
        Some((paint, data)) => group.add(path(paint, data)),
        None => group,
    }
}

fn paint(facet: &Facet, normal: &Vec3) -> Paint {
    let lambert = normal.dot(&Vec3::from(LIGHT).normalize()).max(0.0);
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

fn path(paint: Paint, data: String) -> Path {
    let [r, g, b] = paint.rgb;
    let colour = format!("#{r:02x}{g:02x}{b:02x}");
    let path = Path::new().set("d", data).set("fill", colour.clone());
    if paint.opacity < 1.0 {
        // A stroke would be seen twice where translucent neighbours meet; without one only sharp edges leave no seam.
        path.set("fill-opacity", paint.opacity).set("shape-rendering", "crispEdges")
    } else {
        path.set("stroke", colour)
    }
}

/// Relative coordinates in tenths of a pixel: half the bytes of absolute ones.
fn append(data: &mut String, [a, b, c]: &[Projected; 3]) {
    let tenths = |v: f64| (10.0 * v).round() as i64;
    let from = |p: &Projected, q: &Projected| (tenths(q.x) - tenths(p.x), tenths(q.y) - tenths(p.y));
    let mut number = |lead: &str, v: i64| {
        let lead = if v < 0 && lead == " " { "" } else { lead };
        write!(data, "{lead}{}", v as f64 / 10.0).expect("writing to a string");
    };
    number("M", tenths(a.x));
    number(" ", tenths(a.y));
    let (b_from_a, c_from_b) = (from(a, b), from(b, c));
    number("l", b_from_a.0);
    number(" ", b_from_a.1);
    number(" ", c_from_b.0);
    number(" ", c_from_b.1);
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
        let seen = Surface { facets: vec![facet(corners(0.0)), facet(corners(0.2)), facet(turned(corners(0.4)))] };
        let camera = Camera::facing(&seen, &seen, Frame { width: 100.0, height: 100.0 });
        let text = facets(&[&seen], &camera).to_string();
        assert_eq!(text.matches("<path").count(), 1, "{text}");
        let drawn = text.matches('M').count();
        assert!(drawn == 1 || drawn == 2, "one side or the other: {text}");
    }
}
