//! The camera: where it stands, and from world coordinates to the picture.

use extricate::geometry::Vec3;

use super::surface::{Surface, bounds};

/// Height of the camera above the horizon \[rad\].
const ELEVATION: f64 = 0.42;
/// Directions tried around the vertical.
const AZIMUTHS: usize = 24;
/// Distance of the camera in radii of what it looks at: far enough for a mild perspective.
const DISTANCE: f64 = 4.5;
/// Obstacles farther than this many radii from the robot do not widen the picture.
const NEAR_OBSTACLE: f64 = 1.5;
/// Empty border as a share of the picture.
const BORDER: f64 = 0.04;

/// Size of a picture \[px\].
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// \[px\]
    pub width: f64,
    /// \[px\]
    pub height: f64,
}

/// A point of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// To the right \[px\].
    pub x: f64,
    /// Down \[px\].
    pub y: f64,
    /// From the camera along the line of sight \[m\].
    pub depth: f64,
}

/// A perspective camera that stands upright.
#[derive(Debug, Clone)]
pub struct Camera {
    /// Where it stands, world \[m\].
    pub eye: Vec3,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    scale: f64,
    offset: [f64; 2],
}

impl Camera {
    /// From the side on which the robot stands before the obstacles, where its motion from `before`
    /// to `after` is seen best; everything that is near the robot fits `frame`.
    pub fn facing(before: &Surface, after: &Surface, frame: Frame) -> Self {
        let robot: Vec<Vec3> = [before, after].into_iter().flat_map(|s| corners(s, false)).collect();
        let (low, high) = bounds(robot.iter().copied());
        let centre = if robot.is_empty() { Vec3::zeros() } else { 0.5 * (low + high) };
        let radius = robot.iter().map(|p| (p - centre).norm()).fold(1e-3, f64::max);
        let near = |p: &Vec3| (p - centre).norm() < NEAR_OBSTACLE * radius;
        let obstacles: Vec<Vec3> = corners(before, true).filter(near).collect();
        let toward_obstacles = if obstacles.is_empty() {
            Vec3::zeros()
        } else {
            let mean = obstacles.iter().sum::<Vec3>() / obstacles.len() as f64 - centre;
            Vec3::new(mean.x, mean.y, 0.0).try_normalize(0.1 * radius).unwrap_or_else(Vec3::zeros)
        };
        let direction = best_direction(before, after, &toward_obstacles);
        let mut camera = Self::looking(centre, direction, DISTANCE * radius);
        camera.fit(robot.iter().chain(&obstacles), frame);
        camera
    }

    /// The place of a world point in the picture.
    pub fn project(&self, point: &Vec3) -> Projected {
        let from_eye = point - self.eye;
        // What is beside or behind the camera has no place; it is kept finite and lies outside the
        // frame.
        let depth = from_eye.dot(&self.forward).max(1e-6);
        let factor = self.scale / depth;
        Projected {
            x: self.offset[0] + factor * from_eye.dot(&self.right),
            y: self.offset[1] - factor * from_eye.dot(&self.up),
            depth,
        }
    }

    /// A direction given as right, up and toward the camera, in world coordinates.
    pub fn direction(&self, [right, up, back]: [f64; 3]) -> Vec3 {
        self.right * right + self.up * up - self.forward * back
    }

    fn looking(target: Vec3, direction: Vec3, distance: f64) -> Self {
        let forward = -direction;
        let right = forward.cross(&Vec3::z()).normalize();
        let up = right.cross(&forward);
        Self { eye: target + direction * distance, forward, right, up, scale: 1.0, offset: [0.0; 2] }
    }

    fn fit<'a>(&mut self, points: impl Iterator<Item = &'a Vec3>, frame: Frame) {
        let placed = points.map(|p| self.project(p)).map(|p| Vec3::new(p.x, p.y, 0.0));
        let (low, high) = bounds(placed);
        if low.x > high.x {
            return;
        }
        let size = (high - low).sup(&Vec3::repeat(1e-9));
        let inner = 1.0 - 2.0 * BORDER;
        self.scale = (inner * frame.width / size.x).min(inner * frame.height / size.y);
        let middle = 0.5 * (low + high) * self.scale;
        self.offset = [0.5 * frame.width - middle.x, 0.5 * frame.height - middle.y];
    }
}

fn corners(surface: &Surface, obstacle: bool) -> impl Iterator<Item = Vec3> + '_ {
    surface.facets.iter().filter(move |f| f.obstacle == obstacle).flat_map(|f| f.corners)
}

/// The direction toward the camera, among those not from behind the obstacles, across which the
/// robot moves most.
fn best_direction(before: &Surface, after: &Surface, toward_obstacles: &Vec3) -> Vec3 {
    let moved: Vec<Vec3> = corners(before, false).zip(corners(after, false)).map(|(a, b)| b - a).collect();
    let seen = |direction: &Vec3| -> f64 { moved.iter().map(|m| (m - direction * m.dot(direction)).norm()).sum() };
    let mut best = (f64::NEG_INFINITY, Vec3::x());
    for k in 0..AZIMUTHS {
        let azimuth = std::f64::consts::TAU * (k as f64 + 0.5) / AZIMUTHS as f64;
        let (sin, cos) = azimuth.sin_cos();
        let direction = Vec3::new(ELEVATION.cos() * cos, ELEVATION.cos() * sin, ELEVATION.sin());
        // A little from behind is fine, for obstacles are translucent; straight from the front
        // hides how deep they are.
        if !(-0.75..=0.1).contains(&direction.dot(toward_obstacles)) {
            continue;
        }
        let score = seen(&direction);
        if score > best.0 {
            best = (score, direction);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::surface::{Facet, Look};

    fn surface(offset: Vec3) -> Surface {
        let corner = |x: f64, y: f64, z: f64| Vec3::new(x, y, z);
        let robot = [corner(0.0, 0.0, 0.0), corner(0.5, 0.0, 0.5), corner(0.0, 0.0, 1.0)].map(|p| p + offset);
        let wall = [corner(1.0, -0.3, 0.0), corner(1.0, 0.3, 0.0), corner(1.0, 0.0, 0.5)];
        let facet = |corners, obstacle| Facet { corners, body: 0, obstacle, look: Look::Plain };
        Surface { facets: vec![facet(robot, false), facet(wall, true)], edges: vec![] }
    }

    #[test]
    fn all_that_is_near_fits_the_frame() {
        let frame = Frame { width: 300.0, height: 200.0 };
        let (before, after) = (surface(Vec3::zeros()), surface(Vec3::new(0.0, 0.0, 0.3)));
        let camera = Camera::facing(&before, &after, frame);
        for point in corners(&before, false).chain(corners(&after, false)) {
            let p = camera.project(&point);
            assert!(p.depth > 0.1 && p.x > 0.0 && p.x < 300.0 && p.y > 0.0 && p.y < 200.0, "{p:?}");
        }
    }

    #[test]
    fn up_is_up_and_near_is_near() {
        let camera = Camera::looking(Vec3::zeros(), Vec3::new(0.0, -1.0, 0.0), 5.0);
        assert!(camera.project(&Vec3::z()).y < camera.project(&Vec3::zeros()).y);
        assert!(camera.project(&Vec3::x()).x > camera.project(&Vec3::zeros()).x);
        assert_eq!(camera.project(&Vec3::new(0.0, -1.0, 0.0)).depth, 4.0);
    }

    #[test]
    fn motion_is_seen_from_its_side() {
        let (before, after) = (surface(Vec3::zeros()), surface(Vec3::new(0.3, 0.0, 0.0)));
        let direction = best_direction(&before, &after, &Vec3::zeros());
        assert!(direction.y.abs() > direction.x.abs(), "{direction:?}");
    }
}
