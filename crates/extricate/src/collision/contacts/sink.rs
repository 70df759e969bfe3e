//! The list to which contacts of two shapes go: in world coordinates, in the order of the pair,
//! thinned. No search.

use super::contact::Contact;
use crate::collision::convex_distance::Separation;
use crate::math::{Pose, Vec3};
use crate::scene::PairId;

/// Most contacts of a pair of bodies; those added by `push` are not limited.
const MAX_CONTACTS: usize = 12;
/// Contacts near each other whose normals have a larger cosine are redundant: the farther one is
/// dropped.
const SAME_NORMAL_COSINE: f64 = 0.97;

/// A contact in the frame of the first shape.
#[derive(Debug, Clone, Copy)]
pub struct Near {
    /// Signed distance \[m\], negative if the shapes overlap.
    pub distance: f64,
    /// Nearest (or deepest) point of the first shape \[m\].
    pub point_first: Vec3,
    /// Nearest (or deepest) point of the second shape \[m\].
    pub point_second: Vec3,
    /// Unit normal, from the second shape toward the first.
    pub normal: Vec3,
}

pub struct Sink<'a> {
    /// Maps the frame in which contacts are found to the world.
    pub pose_world: Pose,
    /// Whether the first shape of a contact is the second of the pair.
    pub swapped: bool,
    pub pair: PairId,
    /// Index of the first contact of the pair.
    pub start: usize,
    /// Margin within which contacts are requested \[m\].
    pub margin: f64,
    pub contacts: &'a mut Vec<Contact>,
}

impl Sink<'_> {
    fn contact(&self, near: &Near) -> Contact {
        let (p, q) = (self.pose_world.point(&near.point_first), self.pose_world.point(&near.point_second));
        let normal = self.pose_world.vector(&near.normal);
        let (point_first, point_second, normal) = if self.swapped { (q, p, -normal) } else { (p, q, normal) };
        Contact { pair: self.pair, distance: near.distance, point_first, point_second, normal }
    }

    /// Adds a contact without thinning.
    pub fn push(&mut self, near: &Near) {
        self.contacts.push(self.contact(near));
    }

    /// Adds a contact unless a nearer one is like it, and returns whether a farther one may still
    /// be kept. Contacts of one pair of shapes come nearest first. Farther ones of other shapes of
    /// the bodies give way.
    pub fn offer(&mut self, near: &Near) -> bool {
        let radius = (self.margin / 3.0).max(0.02);
        let contact = self.contact(near);
        let same = |c: &Contact| {
            c.normal.dot(&contact.normal) > SAME_NORMAL_COSINE && (c.point_first - contact.point_first).norm() < radius
        };
        let kept = &mut self.contacts[self.start..];
        let farthest = || (0..kept.len()).max_by(|i, j| kept[*i].distance.total_cmp(&kept[*j].distance));
        let has_room = kept.len() < MAX_CONTACTS;
        match kept.iter().position(same).or_else(|| farthest().filter(|_| !has_room)) {
            Some(at) if near.distance < kept[at].distance => kept[at] = contact,
            Some(_) => {}
            None => self.contacts.push(contact),
        }
        let kept = &self.contacts[self.start..];
        kept.len() < MAX_CONTACTS || kept.iter().any(|other| near.distance < other.distance)
    }
}

impl From<Separation> for Near {
    fn from(s: Separation) -> Self {
        Near { distance: s.distance, point_first: s.point_first, point_second: s.point_second, normal: s.normal }
    }
}
