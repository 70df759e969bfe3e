//! What a hand holds at a configuration: which links touch, and on which side.

use serde::Serialize;

use super::hand::{Hand, Link};
use crate::collision::{CheckScratch, Contact, ContactQuery, ContactSearch};
use crate::math::Vec3;
use crate::query::Context;

/// How far \[m\] the nearest point of the object is looked for.
const FAR: f64 = 10.0;

/// A place where the hand touches the object.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GraspContact {
    /// Name of the link.
    pub link: String,
    /// Distance \[m\].
    pub distance: f64,
    /// The point on the object, in the world \[m\].
    pub point: [f64; 3],
    /// The unit normal into the object, in the world.
    pub normal: [f64; 3],
}

/// The links of a hand against the object, in the order of the hand.
#[derive(Debug, Clone, Default)]
pub struct Grip {
    /// Nearest signed distances beyond the clearance \[m\]; below 0 where a link penetrates.
    pub gaps: Vec<f64>,
    /// The unit vectors from the object toward the links, at the nearest places.
    pub normals: Vec<Vec3>,
}

impl Grip {
    /// The links of the hand at `q`, within `margin` \[m\] beyond the clearance, or however far.
    pub fn at(hand: &Hand, context: &Context, q: &[f64], margin: Option<f64>, scratch: &mut CheckScratch) -> Self {
        let (mut grip, mut contacts) = (Self::default(), Vec::new());
        let margin = context.clearance + margin.unwrap_or(FAR);
        for link in &hand.links {
            contacts.clear();
            let query = ContactQuery { margin, search: ContactSearch::Exact };
            context.checker.contacts_of(q, link.pair, query, scratch, &mut contacts);
            let nearest = contacts.iter().min_by(|a, b| a.distance.total_cmp(&b.distance));
            grip.gaps.push(nearest.map_or(f64::INFINITY, |contact| contact.distance - context.clearance));
            grip.normals.push(nearest.map_or_else(Vec3::zeros, |contact| toward_link(link, contact)));
        }
        // A mesh inside another has no contact.
        let collide = context.checker.collide(q, hand.links.iter().map(|link| link.pair), scratch);
        for (gap, collides) in grip.gaps.iter_mut().zip(collide) {
            *gap = if collides { gap.min(0.0) } else { gap.max(0.0) };
        }
        grip
    }

    /// Whether each link is nearer than `touch` \[m\] beyond the clearance.
    pub fn touching(&self, touch: f64) -> Vec<bool> {
        self.gaps.iter().map(|gap| *gap <= touch).collect()
    }

    /// Whether each finger of the hand has one of these links.
    pub fn fingers(hand: &Hand, links: &[bool]) -> Vec<bool> {
        let mut fingers = vec![false; hand.fingers.len()];
        for (link, is_one) in hand.links.iter().zip(links) {
            link.finger.into_iter().filter(|_| *is_one).for_each(|finger| fingers[finger] = true);
        }
        fingers
    }

    /// Whether each finger has a link that touches both here and there, on different sides.
    pub fn turned(&self, hand: &Hand, other: &Self, links: &[bool]) -> Vec<bool> {
        let has_turned = |at: usize| links[at] && self.normals[at].dot(&other.normals[at]) < 0.0;
        let turned: Vec<bool> = (0..hand.links.len()).map(has_turned).collect();
        Self::fingers(hand, &turned)
    }
}

/// The contact's normal, from the object toward the link.
pub fn toward_link(link: &Link, contact: &Contact) -> Vec3 {
    if link.is_second { -contact.normal } else { contact.normal }
}
