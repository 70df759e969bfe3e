//! Penetration depth of two overlapping convex shapes (expanding polytope algorithm), with bounds
//! from both sides: every support plane bounds the depth from above, the polytope inside the
//! difference from below.
//!
//! Source: G. van den Bergen, *Proximity queries and penetration depth computation on 3D game
//! objects*, Game Developers Conference 2001. Deviations: the horizon comes from all visible faces,
//! so that rounding cannot tear the surface; the answer is the best support plane met, not the last
//! face; a difference without volume is answered directly.

mod horizon;
mod polytope;
mod start;

use super::gjk::{Simplex, nearest_on_triangle};
use super::minkowski::{Difference, Vertex};
use crate::math::{Vec3, vectorized};
use polytope::Polytope;
use start::Start;

/// Depth of the origin in the difference of two cores, in the frame of the first: `lower <= depth
/// <= upper` \[m\].
pub(crate) struct Penetration {
    /// Proved by the polytope; about 0 if nothing is proved.
    pub lower: f64,
    /// Proved by the support plane at `normal`.
    pub upper: f64,
    /// Unit normal: moving the first core by `-upper` along it parts the cores.
    pub normal: Vec3,
    /// Deepest point of the first core \[m\]. That of the second lies `upper` behind it, at the
    /// plane and not in a face, because a curved boundary bulges beyond its faces.
    pub first: Vec3,
}

/// Returns the depth of the origin, which `simplex` holds or touches. Stops early if the depth is
/// proved to be above `deeper_than` or at most `not_above` \[m\].
///
/// # Cost
/// At most one support point per vertex of the polytope, 128 in all; about 10 for small polytopes.
/// It does not allocate.
pub(crate) fn penetration(difference: &Difference, simplex: &Simplex, deeper_than: f64, not_above: f64) -> Penetration {
    match start::tetrahedron(difference, simplex) {
        Start::Flat { vertex, normal } => flat(difference, vertex, normal),
        Start::Solid(vertices) => expand(difference, vertices, deeper_than, not_above, 0.0),
    }
}

/// Computes [`penetration`], but ends as soon as both bounds agree to within the share `slack` of
/// the upper one.
pub(crate) fn penetration_within(difference: &Difference, simplex: &Simplex, slack: f64) -> Penetration {
    match start::tetrahedron(difference, simplex) {
        Start::Flat { vertex, normal } => flat(difference, vertex, normal),
        Start::Solid(vertices) => expand(difference, vertices, f64::INFINITY, f64::NEG_INFINITY, slack),
    }
}

/// Returns the depth if the difference has no thickness along `normal`.
fn flat(difference: &Difference, vertex: Vertex, normal: Vec3) -> Penetration {
    let height = |normal: &Vec3| difference.support(normal).point.dot(normal);
    let (ahead, behind) = (height(&normal), height(&-normal));
    let (upper, normal) = if ahead <= behind { (ahead, normal) } else { (behind, -normal) };
    Penetration { lower: -difference.touching, upper, normal, first: vertex.first }
}

fn expand(difference: &Difference, vertices: [Vertex; 4], deeper_than: f64, not_above: f64, slack: f64) -> Penetration {
    vectorized(
        #[inline(always)]
        || expand_inlined(difference, vertices, deeper_than, not_above, slack),
    )
}

#[inline(always)]
fn expand_inlined(
    difference: &Difference,
    vertices: [Vertex; 4],
    deeper_than: f64,
    not_above: f64,
    slack: f64,
) -> Penetration {
    // Curved cores would be refined without end; their faces shrink fourfold in height with each
    // halving.
    let tolerance = difference.scale * if difference.is_curved() { 1e-9 } else { 1e-12 };
    let mut polytope = Polytope::empty(difference.scale, difference.rounding);
    polytope.start(vertices);
    let (mut upper, mut normal, mut corners) = (f64::INFINITY, Vec3::x(), [0; 3]);
    while let Some(nearest) = polytope.nearest_face() {
        let face = *polytope.face(nearest);
        if face.distance >= upper - tolerance.max(slack * upper)
            || (face.distance > deeper_than && polytope.lower() > deeper_than)
        {
            break;
        }
        let vertex = difference.support(&face.normal);
        let height = vertex.point.dot(&face.normal);
        if height < upper {
            (upper, normal, corners) = (height, face.normal, face.corners);
        }
        if upper <= not_above || height - face.distance <= tolerance.max(slack * upper) {
            break;
        }
        if polytope.is_full() {
            break;
        }
        if !polytope.add(nearest, vertex) {
            // The surface is as fine as rounding lets it be here.
            polytope.settle(nearest);
        }
    }
    // The start holds the origin or touches it.
    let lower = polytope.lower().max(-difference.touching).min(upper);
    let first = deepest(&polytope, corners);
    Penetration { lower, upper, normal, first }
}

/// Returns the point of the first core that belongs to the projection of the origin onto a face.
fn deepest(polytope: &Polytope, corners: [u8; 3]) -> Vec3 {
    let vertices = corners.map(|corner| polytope.vertex(corner));
    let feature = nearest_on_triangle(vertices.map(|vertex| &vertex.point), [0, 1, 2]);
    (0..feature.count).map(|k| vertices[feature.indices[k]].first * feature.weights[k]).sum()
}
