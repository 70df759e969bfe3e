//! Memory that gathering contacts reuses, and the queue of what may be nearest next.

use std::collections::BinaryHeap;

use super::cache::ContactCache;
use super::sink::{Near, Sink};
use crate::collision::narrow_phase::Buffers;
use crate::collision::narrow_phase::best_first::Entry;
use crate::scene::PairId;

/// Pairs of triangles that are compared until the nearest contact of two meshes is told; more only
/// as long as it takes to find that one.
const TESTS: usize = 24;
/// What is farther than the nearest contact of two meshes by more than this share of the margin is
/// not looked for: no step that the margin is made for comes to it.
pub const BEYOND_NEAREST: f64 = 0.5;
/// Two pieces, and a lower bound on how far apart they are \[m\].
pub type Candidate = (f64, usize, usize);

/// Memory that gathering reuses.
#[derive(Debug, Default)]
pub struct ContactBuffers {
    /// What is to be opened or offered next, nearest first.
    pub queue: BinaryHeap<Entry>,
    /// Contacts that are found and not all offered yet.
    pub found: Vec<Near>,
    /// Of meshes: what is farther is not looked for \[m\].
    pub limit: f64,
    /// Of meshes: how much farther than what was found that limit may be \[m\].
    beyond: f64,
    /// Pairs of triangles, each as its block and lane of the first and of the second tree.
    pub triangles: Vec<[(u32, u8); 2]>,
    /// Stack of descents of a tree and a point.
    pub nodes: Vec<(f64, u32)>,
    /// Pairs of pieces, and lower bounds on their distances \[m\].
    pub candidates: Vec<Candidate>,
    /// Pieces of the one shape that are near the other as a whole.
    pub near_pieces: Vec<usize>,
    /// What earlier searches found.
    pub memory: ContactCache,
    /// Stacks of searches for one pair of shapes.
    pub shapes: Buffers,
}

/// Entries of the queue are pairs of nodes, or the contact found at index `second`,
const FOUND: u32 = u32::MAX;
/// or the pair of triangles at that index.
pub const TRIANGLES: u32 = u32::MAX - 1;

/// Which two shapes are looked at.
#[derive(Debug, Clone, Copy)]
pub struct PairPlace {
    /// Index of the checked pair of bodies.
    pub pair: PairId,
    /// Number of the pair of shapes.
    pub parts: usize,
    /// Where the contacts of the pair of bodies start.
    pub start: usize,
    /// Of the scene \[m\].
    pub clearance: f64,
}

impl ContactBuffers {
    /// Forgets what earlier searches found.
    pub fn forget(&mut self) {
        self.memory.forget();
    }

    /// Starts a search within `margin` \[m\] from one pair of nodes.
    pub fn restart(&mut self, margin: f64, bound: f64, first: u32, second: u32) {
        (self.limit, self.beyond) = (margin, BEYOND_NEAREST * margin);
        self.queue.clear();
        self.found.clear();
        self.triangles.clear();
        self.queue.push(Entry { bound, first, second });
    }

    /// Takes in a contact: what is much farther is no longer looked for.
    pub fn find(&mut self, near: Near) {
        self.limit = self.limit.min(near.distance.max(0.0) + self.beyond);
        self.queue.push(Entry { bound: near.distance, first: FOUND, second: self.found.len() as u32 });
        self.found.push(near);
    }

    /// Runs through the queue, nearest first: `open` puts what a pair of nodes is made of into it,
    /// or compares two triangles, and returns how many it compared. Returns whether anything
    /// overlaps.
    pub fn run(&mut self, sink: &mut Sink, mut open: impl FnMut(&mut Self, f64, u32, u32) -> usize) -> bool {
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
