//! One picture of a query and its answer: the robot in collision, and beside it the nearest exit.
//! SVG, no raster.

mod camera;
mod paint;
mod surface;

use std::path::Path;

use extricate::internals::io;
use extricate::{Answer, Scene};
use svg::Document;
use svg::node::element::{ClipPath, Definitions, Group, Rectangle, Text};

use crate::report::{metric_unit, pair_names, pairs_in_words};
use camera::{Camera, Frame};
use surface::{Look, Surface};

/// Size of one panel \[px\].
const PANEL: Frame = Frame { width: 600.0, height: 560.0 };
/// Height below the panels for the captions \[px\].
const CAPTION: f64 = 70.0;
/// Pairs named in a caption.
const NAMED_PAIRS: usize = 2;

/// Draws `query` and `answer` and writes the picture, replacing an existing file.
pub fn write(scene: &Scene, query: &[f64], answer: &Answer, path: &Path) -> extricate::Result<()> {
    io::write_atomically(path, draw(scene, query, answer).to_string().as_bytes())
}

/// The picture of `query` (length `nq`) and its answer.
pub fn draw(scene: &Scene, query: &[f64], answer: &Answer) -> Document {
    let mut red = vec![false; scene.bodies.len()];
    for &pair in &answer.colliding {
        red[scene.pairs[pair.index()].first] = true;
        red[scene.pairs[pair.index()].second] = true;
    }
    let before = Surface::new(scene, query, &|body| if red[body] { Look::Hit } else { Look::Plain });
    let after = Surface::new(scene, &answer.witness, &|_| Look::Plain);
    let ghost = Surface::robots(scene, query, Look::Ghost);
    let camera = Camera::facing(&before, &after, PANEL);

    let width = 2.0 * PANEL.width;
    let clip = Rectangle::new().set("width", PANEL.width).set("height", PANEL.height);
    Document::new()
        .set("viewBox", (0, 0, width as u32, (PANEL.height + CAPTION) as u32))
        .set("font-family", "Helvetica, Arial, sans-serif")
        .add(Definitions::new().add(ClipPath::new().set("id", "panel").add(clip)))
        .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "#ffffff"))
        .add(panel(0.0, paint::facets(&[&before], &camera), &colliding_caption(scene, answer)))
        .add(panel(PANEL.width, paint::facets(&[&after, &ghost], &camera), &witness_caption(scene, answer)))
}

/// A title and a line of detail.
struct Caption {
    title: String,
    detail: String,
}

fn colliding_caption(scene: &Scene, answer: &Answer) -> Caption {
    let names = pair_names(scene, &answer.colliding);
    Caption { title: "in collision".into(), detail: pairs_in_words(&names, NAMED_PAIRS) }
}

fn witness_caption(scene: &Scene, answer: &Answer) -> Caption {
    let unit = metric_unit(scene);
    let verified = if answer.verified { "verified free, " } else { "" };
    Caption {
        title: format!("nearest exit: depth {:.3} {unit}", answer.depth),
        detail: format!(
            "{verified}moves {:.1} cm at most; nothing free within {:.3} {unit}",
            100.0 * answer.max_displacement,
            answer.lower_bound
        ),
    }
}

fn panel(x: f64, facets: Group, caption: &Caption) -> Group {
    let middle = PANEL.width / 2.0;
    let text = |y: f64, size: u32, content: &str| {
        Text::new(content)
            .set("x", middle)
            .set("y", PANEL.height + y)
            .set("font-size", size)
            .set("text-anchor", "middle")
            .set("fill", "#222222")
    };
    Group::new()
        .set("transform", format!("translate({x} 0)"))
        .add(Group::new().set("clip-path", "url(#panel)").add(facets))
        .add(text(22.0, 20, &caption.title).set("font-weight", "bold"))
        .add(text(46.0, 15, &caption.detail))
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use extricate::geometry::{Body, Geometry, Pose, Vec3};
    use extricate::internals::scene::{BodyPair, Coordinate, Frame as SceneFrame, Motion, Part, SceneJoint};
    use extricate::{ConfigSpace, Effort, Manifold, MetricKind};

    /// Two links that turn about z and y, before a wall.
    pub fn small_scene() -> Scene {
        let mut space = ConfigSpace::default();
        space.push("shoulder", Manifold::Interval { lower: -3.0, upper: 3.0 }, 1.0);
        space.push("elbow", Manifold::Circle, 1.0);
        let frame = |name: &str, parent, xyz: [f64; 3], motion| SceneFrame {
            name: name.into(),
            parent,
            pose_parent_joint: Pose::from_xyz_rpy(xyz, [0.0; 3]),
            motion,
        };
        let turn =
            |axis, q| Motion::Revolute { axis, coordinate: Coordinate { q, v: q, multiplier: 1.0, offset: 0.0 } };
        let part = |half: [f64; 3], xyz: [f64; 3]| Part {
            pose_frame_part: Pose::from_xyz_rpy(xyz, [0.0; 3]),
            geometry: Geometry::Box { half_extents: Vec3::from(half) },
        };
        let body = |name: &str, robot, frame, part| Body { name: name.into(), robot, frame, parts: vec![part] };
        let joint =
            |name: &str, kind: &str, at: usize| SceneJoint { name: name.into(), kind: kind.into(), q: at..at + 1 };
        Scene {
            clearance: 1e-4,
            metric: MetricKind::Joint,
            joints: vec![joint("shoulder", "revolute", 0), joint("elbow", "continuous", 1)],
            space,
            frames: vec![
                frame("world", 0, [0.0; 3], Motion::World),
                frame("shoulder", 0, [0.0, 0.0, 0.1], turn(Vec3::z(), 0)),
                frame("elbow", 1, [0.4, 0.0, 0.0], turn(Vec3::y(), 1)),
            ],
            bodies: vec![
                body("upper", Some(0), 1, part([0.2, 0.03, 0.03], [0.2, 0.0, 0.0])),
                body("fore", Some(0), 2, part([0.15, 0.025, 0.025], [0.15, 0.0, 0.0])),
                body("wall", None, 0, part([0.02, 0.4, 0.3], [0.6, 0.0, 0.3])),
            ],
            pairs: vec![BodyPair { first: 0, second: 2 }, BodyPair { first: 1, second: 2 }],
            warnings: vec![],
            links: vec![],
            clearances: Default::default(),
            rigid: vec![],
        }
    }

    fn answer() -> Answer {
        Answer {
            depth: 0.9,
            lower_bound: 0.2,
            gap: 0.78,
            unproved: None,
            witness: vec![0.9, 0.0],
            effort: Effort::Refined,
            checks: 10,
            max_displacement: 0.5,
            colliding: vec![extricate::PairId::new(1)],
            outside: vec![],
            touching: vec![extricate::PairId::new(1)],
            unseen: Some(0.1),
            nearest: None,
            clearance: 1e-4,
            free_radius: None,
            verified: true,
            contacts: vec![],
            gradient: vec![-1.0, 0.0],
            unique: true,
            cut_short: false,
            exits: vec![],
            segment: None,
        }
    }

    #[test]
    fn the_picture_names_what_collides_and_the_way_out() {
        let text = draw(&small_scene(), &[0.0, 0.0], &answer()).to_string();
        for part in ["in collision", "fore - wall", "depth 0.900 rad", "moves 50.0 cm at most", "<path"] {
            assert!(text.contains(part), "{part}");
        }
        assert!(!text.contains("NaN") && !text.contains("inf"), "a coordinate is no number");
        assert!(text.len() < 300_000, "{} bytes", text.len());
    }

    #[test]
    fn the_same_answer_gives_the_same_bytes() {
        let text = || draw(&small_scene(), &[0.0, 0.3], &answer()).to_string();
        assert_eq!(text(), text());
    }
}
