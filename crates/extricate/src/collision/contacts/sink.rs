//! Where contacts of two shapes go: into the world, in the order of the pair, thinned. No search.

use super::contact::Contact;
use crate::collision::convex_distance::Separation;
use crate::math::{Pose, Vec3};
use crate::scene::PairId;

/// Most contacts of a pair that meshes give.
const MOST: usize = 12;
/// Contacts whose normals have a larger cosine and that are near each other tell the same: the
/// farther one is dropped.
const SAME_NORMAL: f64 = 0.97;

/// A contact in the frame of a mesh, which is the first shape.
#[derive(Debug, Clone, Copy)]
pub struct Near {
    /// Signed \[m\].
    pub distance: f64,
    /// Of the first shape \[m\].
    pub point_first: Vec3,
    /// Of the second shape \[m\].
    pub point_second: Vec3,
    /// Unit, from the second toward the first.
    pub normal: Vec3,
}

/// Where contacts go: into the world, in the order of the pair, thinned.
pub struct Sink<'a> {
    /// Maps the frame in which contacts are found to the world.
    pub pose_world: Pose,
    /// Whether the first shape there is the second of the pair.
    pub swapped: bool,
    /// Index of the checked pair of bodies.
    pub pair: PairId,
    /// Where the contacts of the pair start.
    pub start: usize,
    /// Within which contacts are asked for \[m\].
    pub margin: f64,
    /// All contacts so far.
    pub contacts: &'a mut Vec<Contact>,
}

impl Sink<'_> {
    fn contact(&self, near: &Near) -> Contact {
        let (p, q) = (self.pose_world.point(&near.point_first), self.pose_world.point(&near.point_second));
        let normal = self.pose_world.vector(&near.normal);
        let (point_first, point_second, normal) = if self.swapped { (q, p, -normal) } else { (p, q, normal) };
        Contact { pair: self.pair, distance: near.distance, point_first, point_second, normal }
    }

    /// Adds a contact as it is.
    pub fn push(&mut self, near: &Near) {
        self.contacts.push(self.contact(near));
    }

    /// Keeps a contact that tells what no nearer one did; returns whether a farther one may be
    /// kept. Those of one pair of shapes come nearest first; those of bodies' other shapes that are
    /// farther give way.
    pub fn offer(&mut self, near: &Near) -> bool {
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

impl From<Separation> for Near {
    fn from(s: Separation) -> Self {
        Near { distance: s.distance, point_first: s.point_first, point_second: s.point_second, normal: s.normal }
    }
}
