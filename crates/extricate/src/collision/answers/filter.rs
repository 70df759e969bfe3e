//! Removes the points of the robot itself from a cloud; see [`Checker::robot_filter`].

use super::depth::solid_depth_above;
use crate::collision::checker::{CheckScratch, Checker};
use crate::math::Vec3;

pub fn robot_filter(
    checker: &Checker,
    q: &[f64],
    points: &[[f64; 3]],
    padding: f64,
    scratch: &mut CheckScratch,
) -> Vec<bool> {
    checker.place(q, scratch);
    let scene = checker.scene_arc().clone();
    let links: Vec<usize> = (0..scene.bodies.len()).filter(|&body| scene.bodies[body].robot.is_some()).collect();
    let poses = scratch.placement.poses.clone();
    let mut is_near = |body: usize, point: &Vec3| {
        let prepared = &checker.bodies.bodies[body];
        let point = poses[prepared.frame].inverse_point(point);
        let reach = prepared.ball.1 + padding;
        reach >= 0.0
            && (point - prepared.ball.0).norm_squared() <= reach * reach
            && solid_depth_above(checker, body, &point, -padding, scratch).is_some()
    };
    points.iter().map(|point| !links.iter().any(|&body| is_near(body, &Vec3::from(*point)))).collect()
}
