//! Contacts of two shapes of any kind.

use super::buffers::{ContactBuffers, PairPlace};
use super::by_elements::by_elements;
use super::by_pieces::{are_parted, by_pieces};
use super::contact::{Contact, ContactQuery, ContactSearch};
use super::mesh_convex::mesh_with_convex;
use super::mesh_mesh::mesh_with_mesh;
use super::sink::{Near, Sink};
use crate::collision::narrow_phase::SeparatingWitness;
use crate::collision::prepared::Placed;
use crate::collision::shapes::ShapeKind;
use crate::collision::shapes::bounds::Relative;

/// Appends the contacts of two shapes nearer than the query's margin to those of the pair, which
/// begin at `contacts[place.start]`.
///
/// Two convex shapes give one contact; in an exact search it is exact also below 0. Meshes give
/// their nearest contact, in an exact search exact above 0, and others that differ from it, up to
/// twelve a pair. In an exact search none is farther than the nearest by more than half of the
/// margin.
///
/// If surfaces cross, depth and normal are those that part two triangles along one of their outward
/// normals (or a triangle from a convex solid). If one shape lies inside the other, they lead from
/// a vertex or centre to the nearest surface. Both are heuristics for proposals.
pub fn gather(
    [first, second]: [Placed; 2],
    query: ContactQuery,
    place: PairPlace,
    hint: &mut SeparatingWitness,
    buffers: &mut ContactBuffers,
    contacts: &mut Vec<Contact>,
) {
    use ShapeKind::{Convex, Mesh, Scenery};
    let (a, b) = (first.shape(), second.shape());
    let prepared = [first.prepared, second.prepared];
    let ContactQuery { margin, search } = query;
    let PairPlace { pair, parts, start, clearance } = place;
    let relative = Relative::between(first.pose, second.pose);
    let are_convex = matches!((&a.kind, &b.kind), (Convex(_), Convex(_)));
    if !are_convex && relative.lower_bound(&a.bounds, &b.bounds) >= margin {
        return;
    }
    let sink = &mut Sink { pose_world: *first.pose, swapped: false, pair, start, margin, contacts };
    match (&a.kind, &b.kind) {
        (Scenery(x), _) => return by_elements(x, second.prepared, &relative, query, buffers, sink),
        (_, Scenery(y)) => {
            (sink.pose_world, sink.swapped) = (*second.pose, true);
            return by_elements(y, first.prepared, &Relative::between(second.pose, first.pose), query, buffers, sink);
        }
        _ => {}
    }
    // Trees of triangles take long to find that nothing is near, so pieces are tried first.
    if !are_convex && search == ContactSearch::Exact && are_parted(prepared, &relative, margin, place, buffers) {
        return;
    }
    match (&a.kind, &b.kind) {
        _ if !are_convex && search != ContactSearch::Exact => {
            by_pieces(prepared, &relative, query, place, buffers, sink)
        }
        (Convex(x), Convex(y)) => {
            let memory = buffers.memory.of(parts);
            let least = || relative.lower_bound(&a.bounds, &b.bounds);
            if let Some(found) = memory.contact([x, y], b.ball, &relative, query, clearance, least) {
                // A check at which this contact just keeps the clearance then takes one plane.
                hint.normal = found.normal;
                sink.push(&Near::from(found));
            }
        }
        (Mesh(x), Mesh(y)) => mesh_with_mesh(x, y, &relative, buffers, sink),
        (Mesh(x), Convex(y)) => mesh_with_convex(x, y, &b.bounds, &relative, buffers, sink),
        (Convex(x), Mesh(y)) => {
            (sink.pose_world, sink.swapped) = (*second.pose, true);
            let relative = Relative::between(second.pose, first.pose);
            mesh_with_convex(y, x, &a.bounds, &relative, buffers, sink);
        }
        (Scenery(_), _) | (_, Scenery(_)) => {}
    }
}
