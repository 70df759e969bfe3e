//! Contacts of two shapes: where they are near, as local constraints for proposals. What decides is elsewhere.

mod by_elements;
mod by_pieces;
mod overlap;

use std::collections::BinaryHeap;

use pulp::{Arch, Simd, WithSimd};

use super::bounds::Relative;
use super::bvh::{Boxes, Bvh, Cuboid, Lanes, Ref, Seen, View, below, lanes_of, rounded_up};
use super::gjk::Separation;
use super::mesh_mesh::{self, Pair};
use super::mesh_shape::MeshShape;
use super::pair_memory::PairMemories;
use super::part_pair::{Buffers, Hint, Placed};
use super::queue::Entry;
use super::shape::{ConvexSolid, ShapeKind};
use super::triangle;
use super::{Contact, ContactQuery, ContactSearch, mesh_convex};
use crate::math::{Pose, Vec3};
use by_elements::by_elements;
use by_pieces::{Candidate, are_parted, by_pieces};
use overlap::{crossing, outward};

/// Most contacts of a pair that meshes give.
const MOST: usize = 12;
/// Pairs of triangles that are compared until the nearest contact of two meshes is told; more only as long as it takes to find that one.
const TESTS: usize = 24;
/// What is farther than the nearest contact of two meshes by more than this share of the margin is not looked for: no step that the margin is made
/// for comes to it.
pub(super) const BEYOND_NEAREST: f64 = 0.5;
/// Contacts whose normals have a larger cosine and that are near each other tell the same: the farther one is dropped.
const SAME_NORMAL: f64 = 0.97;

/// Memory that gathering reuses.
#[derive(Debug, Default)]
pub struct ContactBuffers {
    queue: BinaryHeap<Entry>,
    found: Vec<Near>,
    /// Of meshes: what is farther is not looked for \[m\], and how much farther than what was found that may be.
    limit: f64,
    beyond: f64,
    /// Pairs of triangles, each as its block and lane of the first and of the second tree.
    triangles: Vec<[(u32, u8); 2]>,
    nodes: Vec<(f64, u32)>,
    /// Pairs of pieces, and lower bounds on their distances \[m\].
    candidates: Vec<Candidate>,
    /// Pieces of the one shape that are near the other as a whole.
    near_pieces: Vec<usize>,
    memory: PairMemories,
    /// Of searches for one pair of shapes.
    shapes: Buffers,
}

/// A contact in the frame of a mesh, which is the first shape.
#[derive(Debug, Clone, Copy)]
struct Near {
    distance: f64,
    point_first: Vec3,
    point_second: Vec3,
    normal: Vec3,
}

/// Entries of the queue are pairs of nodes, or the contact found at index `second`,
const FOUND: u32 = u32::MAX;
/// or the pair of triangles at that index.
const TRIANGLES: u32 = u32::MAX - 1;

/// Which two shapes are looked at.
#[derive(Debug, Clone, Copy)]
pub struct PairPlace {
    /// Index of the checked pair of bodies.
    pub pair: usize,
    /// Number of the pair of shapes.
    pub parts: usize,
    /// Where the contacts of the pair of bodies start.
    pub start: usize,
    /// Of the scene \[m\].
    pub clearance: f64,
}

/// Appends the contacts of two shapes nearer than `margin` \[m\] to those of `pair` at `contacts[start..]`.
///
/// Convex shapes give one, exact also below 0 where the search is. Meshes give their nearest one (exact above 0 where the search is) and others
/// that tell something else, up to twelve a pair, in an exact search none farther than that by more than half of the margin. Where surfaces cross, depth and normal are those that part two triangles along one
/// of their outward normals (or a triangle from a convex solid); where one lies inside the other they lead from a vertex
/// or centre to the nearest surface: heuristics for proposals.
pub fn gather(
    [first, second]: [Placed; 2],
    query: ContactQuery,
    place: PairPlace,
    hint: &mut Hint,
    buffers: &mut ContactBuffers,
    contacts: &mut Vec<Contact>,
) {
    use ShapeKind::{Convex, Mesh, Scenery};
    let (a, b) = (first.shape, second.shape);
    let ContactQuery { margin, search } = query;
    let PairPlace { pair, parts, start, clearance } = place;
    let relative = Relative::between(first.pose, second.pose);
    let are_convex = matches!((&a.kind, &b.kind), (Convex(_), Convex(_)));
    if !are_convex && relative.lower_bound(&a.bounds, &b.bounds) >= margin {
        return;
    }
    let sink = &mut Sink { pose_world: *first.pose, swapped: false, pair, start, margin, contacts };
    match (&a.kind, &b.kind) {
        (Scenery(x), _) => return by_elements(x, b, &relative, query, buffers, sink),
        (_, Scenery(y)) => {
            (sink.pose_world, sink.swapped) = (*second.pose, true);
            return by_elements(y, a, &Relative::between(second.pose, first.pose), query, buffers, sink);
        }
        _ => {}
    }
    // Trees of triangles take long to find that nothing is near.
    if !are_convex && search == ContactSearch::Exact && are_parted([a, b], &relative, margin, place, buffers) {
        return;
    }
    match (&a.kind, &b.kind) {
        _ if !are_convex && search == ContactSearch::Coarse => {
            by_pieces([a, b], &relative, query, place, buffers, sink)
        }
        (Convex(x), Convex(y)) => {
            let memory = buffers.memory.of(parts);
            let least = || relative.lower_bound(&a.bounds, &b.bounds);
            if let Some(found) = memory.contact([x, y], b.ball, &relative, query, clearance, least) {
                // A check of where the contact just keeps the clearance then takes one plane.
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

/// Where contacts go: into the world, in the order of the pair, thinned.
struct Sink<'a> {
    pose_world: Pose,
    swapped: bool,
    pair: usize,
    start: usize,
    margin: f64,
    contacts: &'a mut Vec<Contact>,
}

impl Sink<'_> {
    fn contact(&self, near: &Near) -> Contact {
        let (p, q) = (self.pose_world.point(&near.point_first), self.pose_world.point(&near.point_second));
        let normal = self.pose_world.vector(&near.normal);
        let (point_first, point_second, normal) = if self.swapped { (q, p, -normal) } else { (p, q, normal) };
        Contact { pair: self.pair, distance: near.distance, point_first, point_second, normal }
    }

    fn push(&mut self, near: &Near) {
        self.contacts.push(self.contact(near));
    }

    /// Keeps a contact that tells what no nearer one did; returns whether a farther one may be kept. Those of one pair of shapes come nearest
    /// first; those of bodies' other shapes that are farther give way.
    fn offer(&mut self, near: &Near) -> bool {
        let radius = (self.margin / 3.0).max(0.02);
        let contact = self.contact(near);
        let same = |c: &Contact| {
            c.normal.dot(&contact.normal) > SAME_NORMAL && (c.point_first - contact.point_first).norm() < radius
        };
        let kept = &mut self.contacts[self.start..];
        let farthest = || (0..kept.len()).max_by(|i, j| kept[*i].distance.total_cmp(&kept[*j].distance));
        let has_room = kept.len() < MOST;
        match kept.iter().position(same).or_else(|| farthest().filter(|_| !has_room)) {
            Some(at) if near.distance < kept[at].distance => kept[at] = contact,
            Some(_) => {}
            None => self.contacts.push(contact),
        }
        let kept = &self.contacts[self.start..];
        kept.len() < MOST || kept.iter().any(|other| near.distance < other.distance)
    }
}

impl ContactBuffers {
    /// Forgets what earlier searches found.
    pub fn forget(&mut self) {
        self.memory.forget();
    }

    fn restart(&mut self, margin: f64, bound: f64, first: u32, second: u32) {
        (self.limit, self.beyond) = (margin, BEYOND_NEAREST * margin);
        self.queue.clear();
        self.found.clear();
        self.triangles.clear();
        self.queue.push(Entry { bound, first, second });
    }

    fn find(&mut self, near: Near) {
        self.limit = self.limit.min(near.distance.max(0.0) + self.beyond);
        self.queue.push(Entry { bound: near.distance, first: FOUND, second: self.found.len() as u32 });
        self.found.push(near);
    }

    /// Runs through the queue, nearest first: `open` puts what a pair of nodes is made of into it, or compares two triangles, and returns how many
    /// it compared. Returns whether anything overlaps.
    fn run(&mut self, sink: &mut Sink, mut open: impl FnMut(&mut Self, f64, u32, u32) -> usize) -> bool {
        let (mut tests, mut offered) = (0, false);
        while let Some(entry) = self.queue.pop() {
            if entry.bound >= self.limit {
                break;
            } else if entry.first == FOUND {
                offered = true;
                if !sink.offer(&self.found[entry.second as usize]) {
                    break;
                }
            } else if tests < TESTS || !offered {
                tests += open(self, entry.bound, entry.first, entry.second);
            }
        }
        self.found.iter().any(|near| near.distance <= 0.0)
    }
}

fn mesh_with_mesh(a: &MeshShape, b: &MeshShape, relative: &Relative, buffers: &mut ContactBuffers, sink: &mut Sink) {
    let two = Pair::new(&a.tree, &b.tree, relative);
    let pose = &relative.pose_a_b;
    let whole = relative.lower_bound(&a.tree.bounds, &b.tree.bounds);
    buffers.restart(sink.margin, whole, a.tree.root.0, b.tree.root.0);
    let overlap = buffers.run(sink, |buffers, bound, i, j| {
        let limit = buffers.limit;
        if i == TRIANGLES {
            let [(i, k), (j, l)] = buffers.triangles[j as usize];
            let (s, t) = (&a.tree.blocks[i as usize], &b.tree.blocks[j as usize]);
            let (first, second) = (s.triangle(usize::from(k)), t.triangle(usize::from(l)).moved(pose));
            if let Some(witness) = triangle::closest(&first, &second, limit * limit) {
                let distance = witness.squared.sqrt();
                if distance > TOUCHING {
                    let normal = (witness.first - witness.second) / distance;
                    let (point_first, point_second) = (witness.first, witness.second);
                    buffers.find(Near { distance, point_first, point_second, normal });
                } else {
                    let closed = [a.closed[s.group as usize], b.closed[t.group as usize]];
                    if let Some(near) = crossing(&first, closed[0], &second, closed[1]) {
                        buffers.find(near);
                    }
                }
            }
            return 1;
        }
        let (i, j) = (Ref(i), Ref(j));
        if i.is_block() && j.is_block() {
            let each = |k: usize, l: usize, gap: f64| {
                let second = buffers.triangles.len() as u32;
                buffers.queue.push(Entry { bound: gap.max(bound), first: TRIANGLES, second });
                buffers.triangles.push([(i.index() as u32, k as u8), (j.index() as u32, l as u8)]);
            };
            Arch::new().dispatch(NearTriangles { pair: &two, i, j, limit, each });
        } else {
            Arch::new().dispatch(Open { pair: &two, i, j, limit, queue: &mut buffers.queue });
        }
        0
    });
    if !overlap {
        for p in &b.representatives {
            let p = pose.point(p);
            if let Some((depth, surface)) = a.depth_inside(&p, 0.0, &mut buffers.nodes) {
                sink.offer(&Near {
                    distance: -depth,
                    point_first: surface,
                    point_second: p,
                    normal: (p - surface) / depth,
                });
            }
        }
        for p in &a.representatives {
            if let Some((depth, surface)) = b.depth_inside(&pose.inverse_point(p), 0.0, &mut buffers.nodes) {
                let surface = pose.point(&surface);
                let normal = (surface - p) / depth;
                sink.offer(&Near { distance: -depth, point_first: *p, point_second: surface, normal });
            }
        }
    }
}

/// Puts what two, not both blocks, are made of into the queue.
struct Open<'a> {
    pair: &'a Pair<'a>,
    i: Ref,
    j: Ref,
    limit: f64,
    queue: &'a mut BinaryHeap<Entry>,
}

impl WithSimd for Open<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        mesh_mesh::children(simd, self.pair, self.i, self.j, rounded_up(self.limit), |bound, i, j| {
            self.queue.push(Entry { bound: f64::from(bound), first: i.0, second: j.0 });
        });
    }
}

/// Calls `each` with the triangles of two blocks that may be nearer than the limit.
struct NearTriangles<'a, F> {
    pair: &'a Pair<'a>,
    i: Ref,
    j: Ref,
    limit: f64,
    each: F,
}

impl<F: FnMut(usize, usize, f64)> WithSimd for NearTriangles<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        self.pair.near_triangles(simd, self.i, self.j, self.limit, |k, l, gap, _| {
            (self.each)(k, l, gap);
            false
        });
    }
}

/// Lower bounds of boxes against one.
struct LowerBounds<'a> {
    boxes: &'a Boxes,
    view: &'a View,
    seen: &'a Seen,
}

impl WithSimd for LowerBounds<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Lanes {
        self.boxes.lower_bounds(simd, self.view, self.seen)
    }
}

/// Distances \[m\] at which the direction between two points is lost to rounding.
const TOUCHING: f64 = 1e-10;

fn mesh_with_convex(
    mesh: &MeshShape,
    solid: &ConvexSolid,
    bounds: &super::bounds::Aabb,
    relative: &Relative,
    buffers: &mut ContactBuffers,
    sink: &mut Sink,
) {
    let tree: &Bvh = &mesh.tree;
    let pose = &relative.pose_a_b;
    let cuboid = Cuboid::around(bounds);
    let view = View::new(pose, &tree.cuboid, &cuboid);
    let seen = view.see(&cuboid, 0.0);
    let lower_bounds = |boxes: &Boxes| Arch::new().dispatch(LowerBounds { boxes, view: &view, seen: &seen });
    buffers.restart(sink.margin, relative.lower_bound(&tree.bounds, bounds), tree.root.0, 0);
    let overlap = buffers.run(sink, |buffers, _, at, _| {
        let limit = buffers.limit;
        let at = Ref(at);
        if !at.is_block() {
            let node = &tree.nodes[at.index()];
            let bounds = lower_bounds(&node.boxes);
            for lane in lanes_of(below(&bounds, rounded_up(limit))) {
                let bound = f64::from(bounds[lane]);
                buffers.queue.push(Entry { bound, first: node.children[lane].0, second: 0 });
            }
            return 0;
        }
        let block = &tree.blocks[at.index()];
        let bounds = lower_bounds(&block.boxes);
        let mut tests = 0;
        for lane in lanes_of(below(&bounds, rounded_up(limit))) {
            tests += 1;
            let face = block.triangle(lane);
            let closed = mesh.closed[block.group as usize];
            let found = mesh_convex::triangle_separation(&face, solid, pose, limit);
            if let Some(separation) = found.filter(|s| s.distance < limit) {
                buffers.find(outward(Near::from(separation), &face, closed, solid, pose));
            }
        }
        tests
    });
    let center = pose.point(&solid.shape.core.center());
    if !overlap && let Some((depth, surface)) = mesh.depth_inside(&center, 0.0, &mut buffers.nodes) {
        let normal = (center - surface) / depth;
        sink.offer(&Near { distance: -depth, point_first: surface, point_second: center, normal });
    }
}

impl From<Separation> for Near {
    fn from(s: Separation) -> Self {
        Near { distance: s.distance, point_first: s.point_first, point_second: s.point_second, normal: s.normal }
    }
}
