//! Converts answers of the library to the structures of the header; reads no pointers of callers.

use extricate::{Answer, Contact, KeptError, PairId, Scene, SegmentOutcome, SignedDistance};

use super::handles::ExtricateAnswer;
use super::types::{
    EXTRICATE_IS_PROVED, ExtricateContact, ExtricateExit, ExtricateKeptError, ExtricatePair, ExtricateSegment,
    ExtricateSignedDistance, ExtricateSummary,
};
use crate::enum_constants::{UNPROVED, number};

/// Placeholder in the header's structures if there is no pair.
pub const NO_PAIR: ExtricatePair = ExtricatePair { first: usize::MAX, second: usize::MAX };

/// The summary of a query for which nothing free was found.
pub const NOTHING: ExtricateSummary = ExtricateSummary {
    depth: f64::INFINITY,
    lower_bound: 0.0,
    gap: 1.0,
    max_displacement: f64::NAN,
    unseen: f64::NAN,
    clearance: f64::NAN,
    free_radius: f64::NAN,
    segment_colliding_until: f64::NAN,
    segment_free_from: f64::NAN,
    nearest: f64::NAN,
    checks: 0,
    unproved: EXTRICATE_IS_PROVED,
    found: false,
    is_free: false,
    verified: false,
    unique: false,
    cut_short: false,
    detour: false,
};

pub fn summary(answer: &Answer) -> ExtricateSummary {
    let or_nan = |value: Option<f64>| value.unwrap_or(f64::NAN);
    ExtricateSummary {
        depth: answer.depth,
        lower_bound: answer.lower_bound,
        gap: answer.gap,
        max_displacement: answer.max_displacement,
        unseen: or_nan(answer.unseen),
        clearance: answer.clearance,
        free_radius: or_nan(answer.free_radius),
        segment_colliding_until: or_nan(answer.segment.map(|segment| segment.colliding_until)),
        segment_free_from: or_nan(answer.segment.map(|segment| segment.free_from)),
        nearest: or_nan(answer.nearest),
        checks: answer.checks as u64,
        unproved: answer.unproved.map_or(EXTRICATE_IS_PROVED, |why| number(UNPROVED, why)),
        found: true,
        is_free: answer.is_free(),
        verified: answer.verified,
        unique: answer.unique,
        cut_short: answer.cut_short,
        detour: answer.detour,
    }
}

pub fn answer(scene: &Scene, answer: Answer) -> ExtricateAnswer {
    let pairs = |pairs: &[PairId]| pairs.iter().map(|id| pair(scene, *id)).collect();
    let (colliding, touching) = (pairs(&answer.colliding), pairs(&answer.touching));
    let contacts = answer.contacts.iter().map(|one| contact(scene, one)).collect();
    let exits = answer.exits.iter().map(|exit| ExtricateExit { depth: exit.depth, witness: exit.witness.as_ptr() });
    let kept = |kept: &KeptError| ExtricateKeptError { position: kept.position, rotation: kept.rotation };
    let kept = answer.kept.iter().map(kept).collect();
    let (summary, exits) = (summary(&answer), exits.collect());
    ExtricateAnswer { summary, colliding, touching, kept, contacts, exits, answer }
}

pub fn contact(scene: &Scene, contact: &Contact) -> ExtricateContact {
    let [point_first, point_second] = contact.points();
    let (pair, distance, normal) = (pair(scene, contact.pair), contact.distance, contact.normal());
    ExtricateContact { pair, distance, point_first, point_second, normal }
}

pub fn segment(scene: &Scene, outcome: SegmentOutcome) -> ExtricateSegment {
    match outcome {
        SegmentOutcome::Free => {
            ExtricateSegment { is_free: true, collides: false, free_until: 1.0, at: f64::NAN, pair: NO_PAIR }
        }
        SegmentOutcome::Contact { free_until, colliding_at, pair: id } => {
            ExtricateSegment { is_free: false, collides: true, free_until, at: colliding_at, pair: pair(scene, id) }
        }
        SegmentOutcome::Undecided { free_until, near_at, pair: id } => {
            ExtricateSegment { is_free: false, collides: false, free_until, at: near_at, pair: pair(scene, id) }
        }
        // A later library may return other outcomes, of which nothing is known here.
        _ => ExtricateSegment { is_free: false, collides: false, free_until: 0.0, at: f64::NAN, pair: NO_PAIR },
    }
}

/// The signed distance of a configuration that collides, if nothing free was found.
pub const NO_DISTANCE: ExtricateSignedDistance =
    ExtricateSignedDistance { distance: f64::NAN, bound: f64::NAN, pair: NO_PAIR, checks: 0, cut_short: false };

pub fn signed_distance(scene: &Scene, found: &SignedDistance) -> ExtricateSignedDistance {
    let SignedDistance { distance, bound, checks, cut_short, .. } = *found;
    let pair = found.pairs.first().map_or(NO_PAIR, |id| pair(scene, *id));
    ExtricateSignedDistance { distance, bound, pair, checks: checks as u64, cut_short }
}

pub fn pair(scene: &Scene, id: PairId) -> ExtricatePair {
    scene.pairs().get(id.index()).map_or(NO_PAIR, |pair| ExtricatePair { first: pair.first, second: pair.second })
}
