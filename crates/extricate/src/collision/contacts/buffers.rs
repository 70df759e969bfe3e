//! Scratch memory for gathering contacts, and the queue of candidates, nearest first.

use std::collections::BinaryHeap;

use super::cache::ContactCache;
use super::sink::{Near, Sink};
use crate::collision::narrow_phase::Buffers;
use crate::collision::narrow_phase::best_first::Entry;
use crate::scene::PairId;

/// Tests of triangles after which a search for contacts of meshes ends, unless its nearest contact
/// is not offered yet.
const MAX_TRIANGLE_TESTS: usize = 24;
/// A contact of meshes or scenery that is farther than the nearest one by more than this share of
/// the margin is not searched for: no step that the margin is meant for reaches it. Lab L061.
pub const BEYOND_NEAREST_SHARE: f64 = 0.5;
/// Lower bound on the distance of two pieces \[m\], and their indices.
pub type Candidate = (f64, usize, usize);

#[derive(Debug, Default)]
pub struct ContactBuffers {
    /// Entries that remain to be opened or offered, nearest first.
    pub queue: BinaryHeap<Entry>,
    /// Contacts that are found and not all offered yet.
    pub found: Vec<Near>,
    /// Contacts of meshes are not searched for beyond this distance \[m\].
    pub limit: f64,
    /// Largest distance of `limit` from the nearest contact found \[m\].
    beyond: f64,
    /// Pairs of triangles, each as block and lane in the first and in the second tree.
    pub triangles: Vec<[(u32, u8); 2]>,
    /// Stack for searches of a tree for a point.
    pub nodes: Vec<(f64, u32)>,
    pub candidates: Vec<Candidate>,
    /// Pieces of one shape that are near the other as a whole.
    pub near_pieces: Vec<usize>,
    /// Results of earlier searches.
    pub memory: ContactCache,
    /// Stacks of searches for one pair of shapes.
    pub shapes: Buffers,
}

/// Queue entries are pairs of nodes, unless `first` is a tag. This one marks the contact at index
/// `second` of `found`.
const CONTACT_ENTRY: u32 = u32::MAX;
/// Marks the pair of triangles at index `second` of `triangles`.
pub const TRIANGLES_ENTRY: u32 = u32::MAX - 1;

/// Two shapes whose contacts are gathered, and where they belong.
#[derive(Debug, Clone, Copy)]
pub struct PairPlace {
    pub pair: PairId,
    /// Number of the pair of shapes among all of the checker.
    pub parts: usize,
    /// Index of the first contact of the pair of bodies.
    pub start: usize,
    /// Clearance of the pair \[m\].
    pub clearance: f64,
}

impl ContactBuffers {
    pub fn forget(&mut self) {
        self.memory.forget();
    }

    /// Starts a search within `margin` \[m\] from one pair of nodes; `bound` is a lower bound on
    /// their distance.
    pub fn restart(&mut self, margin: f64, bound: f64, first: u32, second: u32) {
        (self.limit, self.beyond) = (margin, BEYOND_NEAREST_SHARE * margin);
        self.queue.clear();
        self.found.clear();
        self.triangles.clear();
        self.queue.push(Entry { bound, first, second });
    }

    /// Adds a contact, after which much farther ones are no longer searched for.
    pub fn find(&mut self, near: Near) {
        self.limit = self.limit.min(near.distance.max(0.0) + self.beyond);
        self.queue.push(Entry { bound: near.distance, first: CONTACT_ENTRY, second: self.found.len() as u32 });
        self.found.push(near);
    }

    /// Works through the queue, nearest first, and returns whether anything overlaps. `open` pushes
    /// the children of a pair of nodes, or compares triangles; it returns how many it compared.
    pub fn run(&mut self, sink: &mut Sink, mut open: impl FnMut(&mut Self, f64, u32, u32) -> usize) -> bool {
        let (mut tests, mut offered) = (0, false);
        while let Some(entry) = self.queue.pop() {
            if entry.bound >= self.limit {
                break;
            } else if entry.first == CONTACT_ENTRY {
                offered = true;
                if !sink.offer(&self.found[entry.second as usize]) {
                    break;
                }
            } else if tests < MAX_TRIANGLE_TESTS || !offered {
                tests += open(self, entry.bound, entry.first, entry.second);
            }
        }
        self.found.iter().any(|near| near.distance <= 0.0)
    }
}
