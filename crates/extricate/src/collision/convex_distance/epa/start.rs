//! A tetrahedron around a simplex that holds or touches the origin, from which the expansion
//! starts.

use crate::collision::convex_distance::gjk::{Simplex, normal_of_edges};
use crate::collision::convex_distance::minkowski::{Difference, Vertex};
use crate::math::Vec3;

/// The solid or flat start of the expansion.
pub(crate) enum Start {
    /// A tetrahedron with volume that holds the origin up to rounding.
    Solid([Vertex; 4]),
    /// The difference has no thickness along `normal` (unit); the origin is at `vertex` up to
    /// rounding.
    Flat { vertex: Vertex, normal: Vec3 },
}

/// Completes `simplex` with support points in the directions it does not span.
pub(crate) fn tetrahedron(difference: &Difference, simplex: &Simplex) -> Start {
    // A thinner difference has no depth worth finding: the plane across it is within the thickness
    // of the best.
    let thin = 1e-12 * difference.scale;
    let mut vertices = simplex.vertices;
    let near = nearest_to_origin(simplex);
    let mut count = simplex.count;
    if count == 1 {
        let away = |vertex: &Vertex| (vertex.point - vertices[0].point).norm();
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
        match farthest(difference, &axes, away, thin) {
            Some(vertex) => vertices[1] = vertex,
            None => return Start::Flat { vertex: near, normal: Vec3::x() },
        }
        count = 2;
    }
    if count == 2 {
        let line = (vertices[1].point - vertices[0].point).normalize();
        let across = line.cross(&Vec3::ith(line.iamin(), 1.0)).normalize();
        let away = |vertex: &Vertex| (vertex.point - vertices[0].point).cross(&line).norm();
        match farthest(difference, &[across, line.cross(&across)], away, thin) {
            Some(vertex) => vertices[2] = vertex,
            None => return Start::Flat { vertex: near, normal: across },
        }
        count = 3;
    }
    let [a, b, c] = [0, 1, 2].map(|k| vertices[k].point);
    let normal = normal_of_edges(&(b - a), &(c - b), &(a - c)).0.normalize();
    if count == 3 {
        let away = |vertex: &Vertex| (vertex.point - a).dot(&normal).abs();
        match farthest(difference, &[normal], away, thin) {
            Some(vertex) => vertices[3] = vertex,
            None => return Start::Flat { vertex: near, normal },
        }
    }
    if (vertices[3].point - a).dot(&normal) > 0.0 {
        vertices.swap(1, 2);
    }
    Start::Solid(vertices)
}

/// Returns the support point along plus or minus one of `axes` that lies farthest `away`, if
/// farther than `least`.
fn farthest(difference: &Difference, axes: &[Vec3], away: impl Fn(&Vertex) -> f64, least: f64) -> Option<Vertex> {
    let (mut best, mut best_away) = (None, least);
    for axis in axes {
        for direction in [*axis, -axis] {
            let vertex = difference.support(&direction);
            let vertex_away = away(&vertex);
            if vertex_away > best_away {
                (best, best_away) = (Some(vertex), vertex_away);
            }
        }
    }
    best
}

/// Returns the nearest point of a simplex that touches the origin.
fn nearest_to_origin(simplex: &Simplex) -> Vertex {
    let Some(feature) = simplex.nearest(0.0) else { return simplex.vertices[0] };
    let mut near = Vertex::default();
    for (index, weight) in feature.indices.into_iter().zip(feature.weights).take(feature.count) {
        near.point += simplex.vertices[index].point * weight;
        near.first += simplex.vertices[index].first * weight;
    }
    near
}
