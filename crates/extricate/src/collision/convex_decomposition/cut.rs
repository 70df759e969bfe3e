//! A plane that cuts space, and what of a mesh is on either side of it.

use super::approximate_hull::Sketch;
use crate::math::Vec3;

/// A plane; points with `normal . x > offset` are above it.
#[derive(Clone, Copy)]
pub struct Cut {
    /// Unit normal of the plane.
    pub normal: Vec3,
    /// Distance of the plane from the origin along `normal` \[m\].
    pub offset: f64,
    /// Points nearer to the plane than this count as in it \[m\].
    pub thickness: f64,
}

impl Cut {
    /// Returns the height of a point above the plane \[m\]; 0 if it counts as in the plane.
    pub fn height(&self, point: &Vec3) -> f64 {
        let height = self.normal.dot(point) - self.offset;
        if height.abs() > self.thickness { height } else { 0.0 }
    }

    /// Returns whether some of a triangle is on that side (-1 or 1). A triangle in the plane is on
    /// the side that its normal leads away from, where its solid would be.
    fn reaches(&self, corners: &[Vec3; 3], heights: &[f64; 3], side: f64) -> bool {
        let is_in_plane = heights.iter().all(|h| *h == 0.0);
        let [a, b, c] = corners;
        let leads = || (b - a).cross(&(c - a)).dot(&self.normal) > 0.0;
        if is_in_plane { leads() == (side < 0.0) } else { heights.iter().any(|h| side * h > 0.0) }
    }
}

/// Returns the point at which an edge crosses a plane, from the heights of its ends.
fn crossing((from, above): (&Vec3, f64), (to, below): (&Vec3, f64)) -> Vec3 {
    from + (to - from) * (above / (above - below))
}

/// Appends the part of a triangle on one side of a plane, as triangles.
pub fn clip(corners: &[Vec3; 3], cut: &Cut, side: f64, parts: &mut Vec<[Vec3; 3]>) {
    let heights = corners.map(|p| cut.height(&p));
    if !cut.reaches(corners, &heights, side) {
        return;
    }
    let heights = heights.map(|h| side * h);
    let (mut kept, mut count) = ([Vec3::zeros(); 4], 0);
    for k in 0..3 {
        let next = (k + 1) % 3;
        if heights[k] >= 0.0 {
            kept[count] = corners[k];
            count += 1;
        }
        if heights[k] * heights[next] < 0.0 {
            kept[count] = crossing((&corners[k], heights[k]), (&corners[next], heights[next]));
            count += 1;
        }
    }
    parts.extend((2..count).map(|k| [kept[0], kept[k - 1], kept[k]]));
}

/// Returns sketches of what is on both sides of a cut, and the length of the line along which it
/// meets the mesh \[m\].
pub fn sketched(triangles: &[[Vec3; 3]], cut: &Cut) -> ([Sketch; 2], f64) {
    let mut sides = [Sketch::default(), Sketch::default()];
    let mut length = 0.0;
    for corners in triangles {
        let heights = corners.map(|p| cut.height(&p));
        let mut last = None;
        let reached = [-1.0, 1.0].map(|side| cut.reaches(corners, &heights, side));
        for k in 0..3 {
            let next = (k + 1) % 3;
            if heights[k] <= 0.0 && reached[0] {
                sides[0].add(&corners[k]);
            }
            if heights[k] >= 0.0 && reached[1] {
                sides[1].add(&corners[k]);
            }
            if heights[k] * heights[next] < 0.0 {
                let point = crossing((&corners[k], heights[k]), (&corners[next], heights[next]));
                sides.iter_mut().for_each(|side| side.add(&point));
                length += last.replace(point).map_or(0.0, |last: Vec3| (point - last).norm());
            }
        }
    }
    (sides, length)
}
