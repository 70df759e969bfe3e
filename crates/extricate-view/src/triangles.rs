//! Surfaces in compact form: few triangles, vertices as whole numbers, bytes as text.

use std::collections::HashMap;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use extricate::geometry::{Body, Geometry, Pose, TriangleMesh};
use serde::Serialize;

/// Segments around a round shape.
pub const SEGMENTS: usize = 32;
/// Segments around round shapes of a body that has many.
const COARSE_SEGMENTS: usize = 4;
/// Number of shapes of a body above which its round ones are drawn coarsely.
const MANY_PARTS: usize = 200;
/// Steps of a coordinate across a body: two bytes, with an error below 0.01 mm in a metre.
const COORDINATE_STEPS: f64 = 65535.0;
/// Cells across a body's longest side in which vertices are merged, finest first.
const GRID_CELLS: [f64; 9] = [512.0, 256.0, 160.0, 100.0, 64.0, 40.0, 24.0, 12.0, 6.0];

/// A surface in the coordinates of a body's frame.
#[derive(Default)]
pub struct Surface {
    /// Positions in the body's frame \[m\].
    pub vertices: Vec<[f64; 3]>,
    /// Indices of three vertices, counterclockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// A surface as the page reads it.
#[derive(Debug, Serialize)]
pub struct Encoded {
    /// Least corner of the bounding box \[m\].
    low: [f64; 3],
    /// Sides of the bounding box \[m\]; a coordinate is `low + side * number / 65535`.
    side: [f64; 3],
    /// Three numbers of two bytes per vertex, little endian, in base64.
    vertices: String,
    /// Three numbers per triangle, of two bytes each, or of four if `wide`.
    triangles: String,
    wide: bool,
    /// Approximate distance within which vertices were merged \[m\]; 0 if none were.
    merged: f64,
}

impl Surface {
    /// Tessellates all shapes of a body but points and voxels, which are [`crate::cloud::Cloud`]s.
    pub fn of(body: &Body) -> Self {
        let segments = if body.parts.len() > MANY_PARTS { COARSE_SEGMENTS } else { SEGMENTS };
        let mut surface = Self::default();
        for part in &body.parts {
            if !matches!(part.geometry, Geometry::Points(_) | Geometry::Voxels(_)) {
                surface.add(&part.geometry.tessellate(segments), &part.pose_frame_part);
            }
        }
        surface
    }

    /// Adds a mesh at its pose in the body's frame.
    pub fn add(&mut self, mesh: &TriangleMesh, pose: &Pose) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(mesh.vertices().map(|vertex| pose.transform(vertex)));
        self.triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(|corner| corner + first)));
    }

    /// Returns the surface with fewer triangles: vertices in one cell of a grid become one, and
    /// triangles without area are removed.
    ///
    /// # Source
    /// Rossignac, Borrel, Multi-resolution 3D approximations for rendering complex scenes (1993),
    /// doi:10.1007/978-3-642-78114-8_29.
    fn merged(&self, cell: f64, low: &[f64; 3]) -> Self {
        let mut of_cell: HashMap<[i64; 3], u32> = HashMap::new();
        let mut vertices = Vec::new();
        let place = |v: &[f64; 3]| [0, 1, 2].map(|k| ((v[k] - low[k]) / cell).floor() as i64);
        let number: Vec<u32> = self
            .vertices
            .iter()
            .map(|v| {
                *of_cell.entry(place(v)).or_insert_with(|| {
                    vertices.push(*v);
                    vertices.len() as u32 - 1
                })
            })
            .collect();
        let renumbered = self.triangles.iter().map(|triangle| triangle.map(|corner| number[corner as usize]));
        let mut triangles: Vec<[u32; 3]> = renumbered.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        // Remove copies of a triangle. Rotating the least corner to the front keeps the
        // orientation.
        for triangle in &mut triangles {
            let least = (0..3).min_by_key(|&at| triangle[at]).unwrap_or(0);
            triangle.rotate_left(least);
        }
        triangles.sort_unstable();
        triangles.dedup();
        Self { vertices, triangles }
    }

    /// Encodes the surface with at most about `most` triangles; `None` if there is nothing to draw,
    /// or if a vertex is not finite.
    pub fn encode(&self, most: usize) -> Option<Encoded> {
        let (low, side) = bounding_box(&self.vertices)?;
        let longest = side.into_iter().fold(0.0, f64::max);
        if self.triangles.is_empty() {
            return None;
        }
        if self.triangles.len() <= most {
            return Some(self.as_text(low, side, 0.0));
        }
        let coarsest = longest / GRID_CELLS[GRID_CELLS.len() - 1];
        let fits = |cell: &f64| *cell >= coarsest || self.merged(*cell, &low).triangles.len() <= most;
        let cell = GRID_CELLS.iter().map(|cells| longest / cells).find(fits)?;
        Some(self.merged(cell, &low).as_text(low, side, cell))
    }

    fn as_text(&self, low: [f64; 3], side: [f64; 3], merged: f64) -> Encoded {
        let wide = self.vertices.len() > usize::from(u16::MAX);
        let corners = self.triangles.iter().flatten();
        let triangles: Vec<u8> = match wide {
            true => corners.flat_map(|corner| corner.to_le_bytes()).collect(),
            false => corners.flat_map(|corner| (*corner as u16).to_le_bytes()).collect(),
        };
        Encoded {
            low,
            side,
            vertices: in_box(&self.vertices, low, side),
            triangles: BASE64_STANDARD.encode(triangles),
            wide,
            merged,
        }
    }
}

/// Least corner and sides of the box around some points; `None` if there are none, or if one is not
/// finite.
pub fn bounding_box(points: &[[f64; 3]]) -> Option<([f64; 3], [f64; 3])> {
    let first = *points.first()?;
    let with = |(low, high): ([f64; 3], [f64; 3]), v: &[f64; 3]| {
        ([0, 1, 2].map(|k| low[k].min(v[k])), [0, 1, 2].map(|k| high[k].max(v[k])))
    };
    let (low, high) = points.iter().fold((first, first), with);
    let side = [0, 1, 2].map(|k| high[k] - low[k]);
    side.iter().all(|length| length.is_finite()).then_some((low, side))
}

/// Points of a box as numbers of two bytes, in base64.
pub fn in_box(points: &[[f64; 3]], low: [f64; 3], side: [f64; 3]) -> String {
    let step = |x: f64, k: usize| {
        if side[k] > 0.0 { (COORDINATE_STEPS * (x - low[k]) / side[k]).round() as u16 } else { 0 }
    };
    let numbers = points.iter().flat_map(|v| (0..3).map(move |k| step(v[k], k)));
    BASE64_STANDARD.encode(numbers.flat_map(u16::to_le_bytes).collect::<Vec<u8>>())
}

/// Shares at most about `most` triangles among several surfaces: small ones keep theirs, large ones
/// share the rest.
pub fn shares(counts: &[usize], most: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..counts.len()).collect();
    order.sort_by_key(|&at| counts[at]);
    let (mut left, mut shares) = (most, vec![0; counts.len()]);
    for (done, &at) in order.iter().enumerate() {
        let share = (left / (counts.len() - done)).max(1);
        shares[at] = share;
        left = left.saturating_sub(counts[at].min(share));
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of many triangles.
    fn ball() -> Surface {
        let mesh = Geometry::Sphere { radius: 0.5 }.tessellate(64);
        Surface { vertices: mesh.vertices().collect(), triangles: mesh.triangles.clone() }
    }

    #[test]
    fn small_surfaces_keep_their_triangles_and_large_ones_share_the_rest() {
        assert_eq!(shares(&[10, 5000, 20], 1000), [333, 970, 495]);
        assert_eq!(shares(&[], 10), Vec::<usize>::new());
        let ball = ball();
        let all = ball.encode(usize::MAX).unwrap();
        assert_eq!(all.merged, 0.0);
        let few = ball.encode(300).unwrap();
        assert!(few.merged > 0.0 && few.merged < 0.2, "{}", few.merged);
        assert!(few.triangles.len() < all.triangles.len() / 4);
    }

    #[test]
    fn coordinates_come_back_to_a_hundredth_of_a_millimetre() {
        let text = ball().encode(usize::MAX).unwrap();
        let bytes = BASE64_STANDARD.decode(text.vertices).unwrap();
        let numbers: Vec<f64> = bytes.chunks(2).map(|b| f64::from(u16::from_le_bytes([b[0], b[1]]))).collect();
        for (read, vertex) in numbers.chunks(3).zip(&ball().vertices) {
            for k in 0..3 {
                let x = text.low[k] + text.side[k] * read[k] / COORDINATE_STEPS;
                assert!((x - vertex[k]).abs() < 1e-5, "{x} {}", vertex[k]);
            }
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_left_out() {
        let body = |parts| Body { name: "b".into(), robot: None, frame: 0, parts };
        assert!(Surface::of(&body(vec![])).encode(10).is_none());
        let part = extricate::parts::Part {
            pose_frame_part: Pose::identity(),
            geometry: Geometry::Box { half_extents: [f64::INFINITY, 1.0, 1.0] },
        };
        assert!(Surface::of(&body(vec![part])).encode(10).is_none());
    }
}
