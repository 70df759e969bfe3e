//! Which points of a cloud are the robot's own.

use super::{CheckScratch, Checker};
use crate::math::Vec3;

impl Checker {
    /// Which of `points` (world coordinates \[m\]) no link of a robot comes nearer to than
    /// `padding` \[m\] at `q`: those to keep where a camera also sees the robot itself. A point
    /// inside a link is within any padding; obstacles do not count.
    ///
    /// # Cost
    /// A ball a point and link, and a look at the link's shapes where that is near.
    pub fn robot_filter(&self, q: &[f64], points: &[Vec3], padding: f64, scratch: &mut CheckScratch) -> Vec<bool> {
        self.place(q, scratch);
        let scene = self.scene_arc().clone();
        let links: Vec<usize> = (0..scene.bodies.len()).filter(|&body| scene.bodies[body].robot.is_some()).collect();
        let poses = scratch.placement.poses.clone();
        let mut is_near = |body: usize, point: &Vec3| {
            let prepared = &self.bodies.bodies[body];
            let point = poses[prepared.frame].inverse_point(point);
            let reach = prepared.ball.1 + padding;
            reach >= 0.0
                && (point - prepared.ball.0).norm_squared() <= reach * reach
                && self.solid_depth_above(body, &point, -padding, scratch).is_some()
        };
        points.iter().map(|point| !links.iter().any(|&body| is_near(body, point))).collect()
    }
}
