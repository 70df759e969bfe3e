//! Which balls inside a body, and which points of its surface, bounds look at.

use super::{BALLS, Ball, QUICK_BALLS, SURFACE_POINTS};
use crate::collision::{Checker, largest_balls};
use crate::math::Vec3;

/// Those of a body, in coordinates of its solid.
pub fn balls(checker: &Checker, body: usize) -> Vec<Ball> {
    // Of what may have no end a grid finds nothing, and how deep the links lie in it is told at
    // once.
    if checker.scene().bodies[body].parts.iter().any(|part| part.geometry.is_scenery()) {
        return Vec::new();
    }
    let pose_frame_solid = checker.pose_frame_solid(body);
    let mut vertices = Vec::new();
    for part in &checker.scene().bodies[body].parts {
        let mesh = part.geometry.tessellate(8);
        let pose_solid_part = pose_frame_solid.inverse().then(&part.pose_frame_part);
        vertices.extend(mesh.vertices.iter().map(|v| pose_solid_part.point(v)));
    }
    let low = vertices.iter().fold(Vec3::repeat(f64::INFINITY), |a, b| a.inf(b));
    let high = vertices.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |a, b| a.sup(b));
    let depth = |centre: &Vec3| checker.solid_depth(body, &pose_frame_solid.point(centre));
    let inside = largest_balls(&low, &high, BALLS, depth);
    let mut chosen: Vec<Ball> = inside.into_iter().map(|(centre, radius)| Ball { centre, radius }).collect();
    spread_first(&mut chosen, QUICK_BALLS);
    chosen.extend(spread(&vertices, SURFACE_POINTS).into_iter().map(|centre| Ball { centre, radius: 0.0 }));
    chosen
}

/// Brings `count` balls to the front, after the largest, that are large and far from each other: of
/// a ring, whose balls are all as large, not six side by side.
fn spread_first(balls: &mut [Ball], count: usize) {
    for at in 1..count.min(balls.len()) {
        let worth = |ball: &Ball| {
            let gaps = balls[..at].iter().map(|other| (ball.centre - other.centre).norm());
            ball.radius * ball.radius * gaps.fold(f64::INFINITY, f64::min)
        };
        let best = (at..balls.len()).max_by(|a, b| worth(&balls[*a]).total_cmp(&worth(&balls[*b])));
        balls[at..=best.unwrap_or(at)].rotate_right(1);
    }
}

/// Farthest-point sampling.
fn spread(points: &[Vec3], count: usize) -> Vec<Vec3> {
    let Some(first) = points.first() else { return Vec::new() };
    let mut chosen = vec![*first];
    let mut gap: Vec<f64> = points.iter().map(|p| (p - first).norm()).collect();
    while chosen.len() < count {
        let (at, distance) = gap.iter().enumerate().fold((0, 0.0), |a, (i, g)| if *g > a.1 { (i, *g) } else { a });
        if distance <= 0.0 {
            break;
        }
        chosen.push(points[at]);
        gap.iter_mut().zip(points).for_each(|(g, p)| *g = g.min((p - points[at]).norm()));
    }
    chosen
}
