//! Grip of a hand at a configuration: which links touch, and on which side.

use serde::Serialize;

use super::hand::{Hand, Link};
use crate::collision::{CheckScratch, Contact, ContactQuery, ContactSearch};
use crate::math::Vec3;
use crate::query::Context;

/// Distance \[m\] within which the nearest point of the object is searched if no margin is given.
const MAX_GAP_M: f64 = 10.0;

/// A place where the hand touches the object.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GraspContact {
    /// Name of the link.
    pub link: String,
    /// Distance between link and object \[m\].
    pub distance: f64,
    /// Point on the object, in world coordinates \[m\].
    pub point: [f64; 3],
    /// Unit normal into the object, in world coordinates.
    pub normal: [f64; 3],
}

/// Distances and directions of a hand's links from the object, in the order of the links.
#[derive(Debug, Clone, Default)]
pub struct Grip {
    /// Signed distance of each link beyond the clearance \[m\]; below 0 if the link penetrates.
    pub gaps: Vec<f64>,
    /// Unit vector from the object toward each link, at the nearest points; 0 beyond the margin.
    pub normals: Vec<Vec3>,
}

impl Grip {
    /// Measures the links at `q`, up to `margin` \[m\] beyond the clearance; `None` is 10 m.
    pub fn at(hand: &Hand, context: &Context, q: &[f64], margin: Option<f64>, scratch: &mut CheckScratch) -> Self {
        let (mut grip, mut contacts) = (Self::default(), Vec::new());
        let margin = context.clearance + margin.unwrap_or(MAX_GAP_M);
        for link in &hand.links {
            contacts.clear();
            let query = ContactQuery { margin, search: ContactSearch::Exact };
            context.checker.contacts_of(q, link.pair, query, scratch, &mut contacts);
            let nearest = contacts.iter().min_by(|a, b| a.distance.total_cmp(&b.distance));
            grip.gaps.push(nearest.map_or(f64::INFINITY, |contact| contact.distance - context.clearance));
            grip.normals.push(nearest.map_or_else(Vec3::zeros, |contact| toward_link(link, contact)));
        }
        // A mesh wholly inside another has no contact, so the collision check decides the sign.
        let collide = context.checker.collide(q, hand.links.iter().map(|link| link.pair), scratch);
        for (gap, collides) in grip.gaps.iter_mut().zip(collide) {
            *gap = if collides { gap.min(0.0) } else { gap.max(0.0) };
        }
        grip
    }

    /// Whether each link is within `touch` \[m\] beyond the clearance.
    pub fn touching(&self, touch: f64) -> Vec<bool> {
        self.gaps.iter().map(|gap| *gap <= touch).collect()
    }

    /// Whether each finger of the hand has one of the marked links.
    pub fn fingers(hand: &Hand, links: &[bool]) -> Vec<bool> {
        let mut fingers = vec![false; hand.fingers.len()];
        for (link, is_one) in hand.links.iter().zip(links) {
            link.finger.into_iter().filter(|_| *is_one).for_each(|finger| fingers[finger] = true);
        }
        fingers
    }

    /// Whether each finger has a marked link whose normals in the two grips are opposed.
    pub fn turned(&self, hand: &Hand, other: &Self, links: &[bool]) -> Vec<bool> {
        let has_turned = |at: usize| links[at] && self.normals[at].dot(&other.normals[at]) < 0.0;
        let turned: Vec<bool> = (0..hand.links.len()).map(has_turned).collect();
        Self::fingers(hand, &turned)
    }
}

/// Returns the contact's normal, from the object toward the link.
pub fn toward_link(link: &Link, contact: &Contact) -> Vec3 {
    if link.is_second { -contact.normal } else { contact.normal }
}
