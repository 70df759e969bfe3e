//! Layers of the page that are off at first: how links look, and what stands for their shapes in
//! quick tests.

use extricate::geometry::Pose;
use extricate::parts::{StandIns, Visual};
use extricate::{Scene, Solver};
use serde::Serialize;

use crate::triangles::{Encoded, SEGMENTS, Surface, shares};

/// Largest number of triangles of all visual shapes: about 0.15 MB of text.
const MAX_VISUAL_TRIANGLES: usize = 12_000;
/// Largest number of triangles of all convex pieces.
const MAX_PIECE_TRIANGLES: usize = 4000;
/// Largest number of balls; those of later bodies are left out.
const MAX_BALLS: usize = 1000;

/// Shapes of one colour by which a link is seen.
#[derive(Debug, Serialize)]
pub struct VisualData {
    /// The body of the link; `None` for a link that collides with nothing.
    body: Option<usize>,
    frame: usize,
    /// Red, green and blue, each a byte, as one number.
    colour: Option<u32>,
    surface: Encoded,
}

/// Balls and convex pieces of a body.
#[derive(Debug, Serialize)]
pub struct StandInData {
    body: usize,
    /// Centre and radius \[m\].
    balls: Vec<[f32; 4]>,
    pieces: Option<Encoded>,
}

/// Encodes visual shapes, those of one link and colour together.
pub fn visual_data(scene: &Scene, visuals: &[Visual]) -> Vec<VisualData> {
    let byte = |x: f64| (255.0 * x).round() as u32;
    let mut found: Vec<(&str, Option<u32>, Surface)> = Vec::new();
    for visual in visuals {
        let Some(seat) = scene.seat_named(&visual.link) else { continue };
        // Exporters hide shapes by an opacity of 0.
        if visual.rgba.is_some_and(|[.., opacity]| opacity == 0.0) {
            continue;
        }
        let colour = visual.rgba.map(|[r, g, b, _]| byte(r) << 16 | byte(g) << 8 | byte(b));
        if found.last().is_none_or(|(link, other, _)| (*link, *other) != (&visual.link, colour)) {
            found.push((&visual.link, colour, Surface::default()));
        }
        let pose = seat.pose_frame_own.then(&visual.pose_link_shape);
        if let Some((.., surface)) = found.last_mut() {
            surface.add(&visual.geometry.tessellate(SEGMENTS), &pose);
        }
    }
    let counts: Vec<usize> = found.iter().map(|(.., surface)| surface.triangles.len()).collect();
    let shares = shares(&counts, MAX_VISUAL_TRIANGLES);
    let encoded = |((link, colour, surface), most): ((&str, Option<u32>, Surface), usize)| {
        let body = scene.bodies().iter().position(|body| body.robot.is_some() && body.name == link);
        Some(VisualData { body, frame: scene.seat_named(link)?.frame, colour, surface: surface.encode(most)? })
    };
    found.into_iter().zip(shares).filter_map(encoded).collect()
}

/// Encodes the balls and convex pieces of all bodies that have some. Returns how many balls there
/// are too, as a page may leave some out.
pub fn stand_in_data(solver: &Solver) -> (Vec<StandInData>, usize) {
    let of_body = |body: usize| {
        let StandIns { balls, pieces } = solver.checker().stand_ins(body);
        let mut surface = Surface::default();
        pieces.iter().for_each(|piece| surface.add(piece, &Pose::identity()));
        (balls, surface)
    };
    let found: Vec<_> = (0..solver.scene().bodies().len()).map(of_body).collect();
    let ball_count = found.iter().map(|(balls, _)| balls.len()).sum();
    let counts: Vec<usize> = found.iter().map(|(_, surface)| surface.triangles.len()).collect();
    let shares = shares(&counts, MAX_PIECE_TRIANGLES);
    let mut left = MAX_BALLS;
    let mut data = Vec::new();
    for (body, ((balls, surface), most)) in found.into_iter().zip(shares).enumerate() {
        let balls: Vec<[f32; 4]> =
            balls.iter().take(left).map(|([x, y, z], radius)| [*x, *y, *z, *radius].map(|x| x as f32)).collect();
        left -= balls.len();
        let pieces = surface.encode(most);
        if !balls.is_empty() || pieces.is_some() {
            data.push(StandInData { body, balls, pieces });
        }
    }
    (data, ball_count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use extricate::builtin;
    use extricate::geometry::Geometry;

    #[test]
    fn visual_shapes_of_one_link_and_colour_are_one_surface() {
        let scene = builtin::scene("planar-arm").unwrap();
        let visual = |link: &str, rgba| Visual {
            link: link.into(),
            pose_link_shape: Pose::identity(),
            geometry: Geometry::Box { half_extents: [0.1; 3] },
            rgba,
        };
        let (name, red) = (&scene.bodies()[0].name[..], Some([1.0, 0.0, 0.5, 1.0]));
        let hidden = Some([1.0, 1.0, 1.0, 0.0]);
        let all = [(name, red), (name, red), (name, None), (name, hidden), ("nobody", red)];
        let data = visual_data(&scene, &all.map(|(link, rgba)| visual(link, rgba)));
        let found: Vec<_> = data.iter().map(|one| (one.body, one.colour)).collect();
        assert_eq!(found, [(Some(0), Some(0xff_00_80)), (Some(0), None)]);
        assert_eq!(data[0].frame, scene.bodies()[0].frame);
    }

    #[test]
    fn pieces_of_a_mesh_are_there_once_a_query_made_them() {
        let solver = Solver::new(builtin::scene("free-box").unwrap());
        solver.checker().prepare_proposals();
        let (data, ball_count) = stand_in_data(&solver);
        assert_eq!(data.iter().map(|one| one.balls.len()).sum::<usize>(), ball_count);
        assert!(
            data.iter().any(|one| one.pieces.is_some()) && data.iter().any(|one| !one.balls.is_empty()),
            "{data:?}"
        );
    }
}
