//! Sweeps closed surfaces along curves and writes them as STL, for meshes of built-in scenes.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::Vector4;

use crate::math::Vec3;

/// A point of a tube's middle line and the tube's radius there: `[x, y, z, radius]` \[m\].
pub type Station = [f64; 4];

/// How a tube ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// A disc closes it.
    Flat,
    /// A half ball closes it.
    Round,
}

/// Vertices \[m\], and triangles whose normals point outward.
#[derive(Debug, Clone, Default)]
pub struct Surface {
    pub vertices: Vec<Vec3>,
    pub triangles: Vec<[usize; 3]>,
}

/// Number of vertices around a tube.
const SIDES: usize = 14;
/// Number of rings for each span between two stations.
const RINGS_PER_SPAN: usize = 3;
/// Number of rings of a half ball between its rim and its pole.
const CAP_RINGS: usize = 3;

/// Builds a closed tube along the Catmull-Rom curve through `stations` (at least two); the radius
/// follows the same curve.
///
/// # Source
/// E. Catmull and R. Rom, "A class of local interpolating splines", 1974,
/// doi:10.1016/B978-0-12-079050-0.50020-5; the uniform variant, with end tangents along the first
/// and last chord.
pub fn tube(stations: &[Station], ends: [End; 2]) -> Surface {
    let line = smooth(stations);
    let last = line.len() - 1;
    let tangents: Vec<Vec3> =
        (0..=last).map(|k| (line[(k + 1).min(last)] - line[k.saturating_sub(1)]).xyz().normalize()).collect();
    // Rings are (center, tangent, radius): first cap from its pole, line, last cap to its pole.
    let mut rings = Vec::new();
    let cap_angles = |end: End| (1..=CAP_RINGS).filter(move |_| end == End::Round).map(|k| k as f64 / 4.0 * FRAC_PI_2);
    let cap = |k: usize, sign: f64, angle: f64| {
        let (center, tangent, radius) = (line[k].xyz(), tangents[k], line[k].w);
        (center + tangent * (sign * radius * angle.sin()), tangent, radius * angle.cos())
    };
    rings.extend(cap_angles(ends[0]).map(|angle| cap(0, -1.0, angle)).rev());
    rings.extend((0..=last).map(|k| (line[k].xyz(), tangents[k], line[k].w)));
    rings.extend(cap_angles(ends[1]).map(|angle| cap(last, 1.0, angle)));
    let pole = |k: usize, sign: f64, end: End| cap(k, sign, if end == End::Round { FRAC_PI_2 } else { 0.0 }).0;
    close(&rings, pole(0, -1.0, ends[0]), pole(last, 1.0, ends[1]))
}

fn smooth(stations: &[Station]) -> Vec<Vector4<f64>> {
    let points: Vec<Vector4<f64>> = stations.iter().map(|&station| Vector4::from(station)).collect();
    let last = points.len() - 1;
    let mut line = Vec::new();
    for k in 0..last {
        let (b, c) = (points[k], points[k + 1]);
        let a = if k == 0 { 2.0 * b - c } else { points[k - 1] };
        let d = if k + 1 == last { 2.0 * c - b } else { points[k + 2] };
        for step in 0..RINGS_PER_SPAN {
            let t = step as f64 / RINGS_PER_SPAN as f64;
            let cubic = (3.0 * (b - c) + d - a) * t + 2.0 * a - 5.0 * b + 4.0 * c - d;
            line.push(b + 0.5 * t * (c - a + t * cubic));
        }
    }
    line.push(points[last]);
    line
}

/// Joins rings (center, unit tangent, radius) to each other and to the poles at both ends.
fn close(rings: &[(Vec3, Vec3, f64)], first_pole: Vec3, last_pole: Vec3) -> Surface {
    let mut surface = Surface { vertices: vec![first_pole], triangles: Vec::new() };
    let least = rings[0].1.iamin();
    let mut normal = Vec3::ith(least, 1.0);
    for (center, tangent, radius) in rings {
        // Parallel transport projects the last normal onto the plane across the new tangent.
        normal = (normal - tangent * tangent.dot(&normal)).normalize();
        let binormal = tangent.cross(&normal);
        surface.vertices.extend((0..SIDES).map(|side| {
            let (sin, cos) = (TAU * side as f64 / SIDES as f64).sin_cos();
            center + (normal * cos + binormal * sin) * *radius
        }));
    }
    let end = surface.vertices.len();
    surface.vertices.push(last_pole);
    let vertex = |ring: usize, side: usize| 1 + ring * SIDES + side % SIDES;
    for side in 0..SIDES {
        surface.triangles.push([0, vertex(0, side + 1), vertex(0, side)]);
        for ring in 0..rings.len() - 1 {
            quad(
                &mut surface,
                [vertex(ring, side), vertex(ring, side + 1), vertex(ring + 1, side + 1), vertex(ring + 1, side)],
            );
        }
        let ring = rings.len() - 1;
        surface.triangles.push([end, vertex(ring, side), vertex(ring, side + 1)]);
    }
    surface
}

fn quad(surface: &mut Surface, [a, b, c, d]: [usize; 4]) {
    surface.triangles.extend([[a, b, c], [a, c, d]]);
}

/// Builds a torus about z from the radii \[m\] of its middle line and of its tube.
pub fn torus(radius: f64, tube_radius: f64) -> Surface {
    const TORUS_RINGS: usize = 36;
    let mut surface = Surface::default();
    for ring in 0..TORUS_RINGS {
        let (sin, cos) = (TAU * ring as f64 / TORUS_RINGS as f64).sin_cos();
        for side in 0..SIDES {
            let (up, out) = (TAU * side as f64 / SIDES as f64).sin_cos();
            let r = radius + tube_radius * out;
            surface.vertices.push(Vec3::new(r * cos, r * sin, tube_radius * up));
        }
    }
    let vertex = |ring: usize, side: usize| ring % TORUS_RINGS * SIDES + side % SIDES;
    for ring in 0..TORUS_RINGS {
        for side in 0..SIDES {
            quad(
                &mut surface,
                [vertex(ring, side), vertex(ring + 1, side), vertex(ring + 1, side + 1), vertex(ring, side + 1)],
            );
        }
    }
    surface
}

/// Writes several surfaces as binary STL; normals stay 0, because readers compute them.
pub fn stl(surfaces: &[Surface]) -> Vec<u8> {
    let mut bytes = vec![0u8; 80];
    let count: usize = surfaces.iter().map(|surface| surface.triangles.len()).sum();
    bytes.extend((count as u32).to_le_bytes());
    for surface in surfaces {
        for triangle in &surface.triangles {
            bytes.extend([0; 12]);
            for vertex in triangle {
                bytes.extend(surface.vertices[*vertex].iter().flat_map(|x| (*x as f32).to_le_bytes()));
            }
            bytes.extend([0; 2]);
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;
    use std::f64::consts::PI;

    fn volume(surface: &Surface) -> f64 {
        let of = |[a, b, c]: &[usize; 3]| {
            let v = &surface.vertices;
            v[*a].dot(&v[*b].cross(&v[*c])) / 6.0
        };
        surface.triangles.iter().map(of).sum()
    }

    fn assert_closed(surface: &Surface) {
        let mut edges: HashMap<(usize, usize), i32> = HashMap::new();
        for [a, b, c] in &surface.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry((*from.min(to), *from.max(to))).or_default() += if from < to { 1 } else { 1000 };
            }
        }
        assert!(edges.values().all(|&count| count == 1001));
    }

    #[test]
    fn tubes_are_closed_and_outward() {
        let flat = tube(&[[0.0, 0.0, 0.0, 0.1], [0.0, 0.0, 1.0, 0.1]], [End::Flat; 2]);
        assert_closed(&flat);
        let share = volume(&flat) / (PI * 0.01);
        assert!((0.96..1.0).contains(&share), "{share}");
        let round = tube(&[[0.0, 0.0, 0.0, 0.1], [0.0, 0.1, 0.5, 0.08], [0.2, 0.2, 1.0, 0.1]], [End::Round; 2]);
        assert_closed(&round);
        assert!(volume(&round) > 0.02);
        assert_eq!(round.triangles.len(), 2 * SIDES * (2 * RINGS_PER_SPAN + 2 * CAP_RINGS + 1));
    }

    #[test]
    fn torus_has_its_volume() {
        let torus = torus(0.3, 0.1);
        assert_closed(&torus);
        let share = volume(&torus) / (2.0 * PI * PI * 0.3 * 0.01);
        assert!((0.94..1.0).contains(&share), "{share}");
        assert_eq!(stl(&[torus]).len(), 84 + 50 * 2 * 36 * SIDES);
    }
}
