//! A scene as the page reads it: the data to place and draw every body at any configuration.

use extricate::geometry::Pose;
use extricate::parts::{Factor, Frame, MotionRecord, Visual};
use extricate::{Manifold, Scene, Solver};
use serde::Serialize;

use crate::cloud::{self, Cloud, clouds};
use crate::layers::{StandInData, VisualData, stand_in_data, visual_data};
use crate::triangles::{Encoded, Surface, shares};
use crate::unit::metric_unit;

/// Largest number of triangles of a page: about 0.6 MB of text.
const MAX_TRIANGLES: usize = 50_000;
/// Largest number of triangles of the object of a grasp, of which a page may have many.
const MAX_OBJECT_TRIANGLES: usize = 3000;
/// Largest number of points and voxels of a page: about 0.8 MB of text.
const MAX_CENTRES: usize = 100_000;

/// A scene as the page reads it.
#[derive(Debug, Serialize)]
pub struct SceneData<'a> {
    /// Unit of the metric's distances.
    unit: &'static str,
    metric: &'static str,
    joints: Vec<JointData<'a>>,
    factors: &'a [Factor],
    frames: Vec<FrameData>,
    bodies: Vec<BodyData>,
    /// How links look.
    visuals: Vec<VisualData>,
    /// What stands for the shapes of bodies in quick tests.
    stand_ins: Vec<StandInData>,
    /// Number of balls in all bodies; `stand_ins` may have fewer.
    balls: usize,
    probe: Probe,
}

#[derive(Debug, Serialize)]
struct JointData<'a> {
    name: &'a str,
    kind: &'a str,
    /// Index of the first coordinate; the others follow it.
    first: usize,
    count: usize,
}

#[derive(Debug, Serialize)]
struct FrameData {
    parent: usize,
    /// Columns of the rotation, then the translation \[m\].
    pose: [f64; 12],
    #[serde(flatten)]
    motion: MotionRecord,
}

#[derive(Debug, Serialize)]
pub struct BodyData {
    name: String,
    frame: usize,
    /// Whether the body is a link, not an obstacle or an attached object.
    link: bool,
    /// Pose of an obstacle, which the page replaces to move it.
    #[serde(skip_serializing_if = "Option::is_none")]
    seat: Option<[f64; 12]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    surface: Option<Encoded>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    clouds: Vec<Cloud>,
}

/// Positions of the frames at a configuration, by which the page checks its kinematics.
#[derive(Debug, Serialize)]
struct Probe {
    q: Vec<f64>,
    origins: Vec<[f64; 3]>,
}

/// Collects the data that the page needs of a scene whose links look like `visuals`.
pub fn scene_data<'a>(solver: &'a Solver, visuals: &[Visual]) -> SceneData<'a> {
    let scene = solver.scene();
    let surfaces: Vec<Surface> = scene.bodies().iter().map(Surface::of).collect();
    let counts: Vec<usize> = surfaces.iter().map(|surface| surface.triangles.len()).collect();
    let triangle_shares = shares(&counts, MAX_TRIANGLES);
    let centres: Vec<usize> = scene.bodies().iter().map(cloud::count).collect();
    let centre_shares = shares(&centres, MAX_CENTRES);
    let body = |at: usize| {
        let step = centres[at].div_ceil(centre_shares[at]).max(1);
        body_data(scene, at, surfaces[at].encode(triangle_shares[at]), step)
    };
    let (stand_ins, balls) = stand_in_data(solver);
    SceneData {
        unit: metric_unit(scene),
        metric: scene.metric().name(),
        joints: scene
            .joints()
            .iter()
            .map(|j| JointData { name: &j.name, kind: &j.kind, first: j.q.start, count: j.q.len() })
            .collect(),
        factors: scene.space().factors(),
        frames: scene.frames().iter().map(frame_data).collect(),
        bodies: (0..scene.bodies().len()).map(body).collect(),
        visuals: visual_data(scene, visuals),
        stand_ins,
        balls,
        probe: probe(scene),
    }
}

fn body_data(scene: &Scene, at: usize, surface: Option<Encoded>, step: usize) -> BodyData {
    let body = &scene.bodies()[at];
    BodyData {
        name: body.name.clone(),
        frame: body.frame,
        link: body.robot.is_some(),
        seat: body.is_obstacle().then(|| numbers(&scene.seat_of_body(at).pose_frame_own)),
        surface,
        clouds: clouds(body, step),
    }
}

/// Returns the last body of a scene, which is the object of a grasp.
pub fn object_data(scene: &Scene) -> Option<BodyData> {
    let at = scene.bodies().len().checked_sub(1)?;
    Some(body_data(scene, at, Surface::of(&scene.bodies()[at]).encode(MAX_OBJECT_TRIANGLES), 1))
}

fn frame_data(frame: &Frame) -> FrameData {
    FrameData { parent: frame.parent, pose: numbers(&frame.pose_parent_joint), motion: frame.motion_record() }
}

/// Columns of the rotation, then the translation.
pub fn numbers(pose: &Pose) -> [f64; 12] {
    let [x, y, z] = pose.columns();
    let numbers = [x, y, z, pose.origin()].concat();
    std::array::from_fn(|k| numbers[k])
}

/// Evaluates the frames at a configuration in which joints are away from 0.
fn probe(scene: &Scene) -> Probe {
    let mut q = vec![0.0; scene.space().nq()];
    for factor in scene.space().factors() {
        match factor.manifold {
            Manifold::Interval { lower, upper } => q[factor.q] = lower + 0.7 * (upper - lower),
            Manifold::Circle => q[factor.q] = 1.0,
            Manifold::Rotation => q[factor.coordinates()].copy_from_slice(&[0.1, 0.7, 0.1, 0.7]),
        }
    }
    let mut poses = Vec::new();
    scene.poses(&q, &mut poses);
    Probe { q, origins: poses.iter().map(|pose| pose.translation.into()).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_frame_and_body_of_the_built_in_scenes_is_there() {
        for name in extricate::builtin::NAMES {
            let scene = extricate::builtin::scene(name).unwrap();
            let solver = Solver::new(scene);
            let scene = solver.scene();
            let value = serde_json::to_value(scene_data(&solver, &[])).unwrap();
            assert_eq!(value["frames"].as_array().unwrap().len(), scene.frames().len(), "{name}");
            assert_eq!(value["frames"][0]["motion"], "world");
            let bodies = value["bodies"].as_array().unwrap();
            assert!(bodies.iter().all(|body| !body["surface"].is_null()), "{name}");
            assert_eq!(value["probe"]["origins"].as_array().unwrap().len(), scene.frames().len());
            assert!(value.to_string().len() < 900_000, "{name}: {}", value.to_string().len());
        }
    }
}
