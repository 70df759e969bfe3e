//! An answer of the library in the structures of the header. No pointers of callers.

use extricate::{Answer, Contact, PairId, Scene, SegmentOutcome, Unproved};

use super::handles::ExtricateAnswer;
use super::types::{
    EXTRICATE_IS_PROVED, EXTRICATE_UNPROVED_SHALLOW, EXTRICATE_UNPROVED_SURFACES, ExtricateContact, ExtricateExit,
    ExtricatePair, ExtricateSegment, ExtricateSummary,
};

/// Where there is no pair.
pub const NO_PAIR: ExtricatePair = ExtricatePair { first: usize::MAX, second: usize::MAX };

/// Where nothing free was found.
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
    checks: 0,
    unproved: EXTRICATE_IS_PROVED,
    found: false,
    is_free: false,
    verified: false,
    unique: false,
    cut_short: false,
};

/// The numbers of an answer.
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
        checks: answer.checks as u64,
        unproved: match answer.unproved {
            None => EXTRICATE_IS_PROVED,
            Some(Unproved::Surfaces) => EXTRICATE_UNPROVED_SURFACES,
            Some(Unproved::Shallow) => EXTRICATE_UNPROVED_SHALLOW,
        },
        found: true,
        is_free: answer.is_free(),
        verified: answer.verified,
        unique: answer.unique,
        cut_short: answer.cut_short,
    }
}

/// All of an answer.
pub fn answer(scene: &Scene, answer: Answer) -> ExtricateAnswer {
    let pairs = |pairs: &[PairId]| pairs.iter().map(|id| pair(scene, *id)).collect();
    let contact = |contact: &Contact| ExtricateContact {
        pair: pair(scene, contact.pair),
        distance: contact.distance,
        point_first: contact.point_first.into(),
        point_second: contact.point_second.into(),
        normal: contact.normal.into(),
    };
    let (summary, colliding, touching) = (summary(&answer), pairs(&answer.colliding), pairs(&answer.touching));
    let contacts = answer.contacts.iter().map(contact).collect();
    let (depths, witnesses): (Vec<f64>, Vec<Vec<f64>>) =
        answer.exits.into_iter().map(|exit| (exit.depth, exit.witness)).unzip();
    let exit = |(depth, witness): (f64, &Vec<f64>)| ExtricateExit { depth, witness: witness.as_ptr() };
    ExtricateAnswer {
        summary,
        witness: answer.witness,
        gradient: answer.gradient,
        colliding,
        touching,
        outside: answer.outside,
        contacts,
        exits: depths.into_iter().zip(&witnesses).map(exit).collect(),
        _exit_witnesses: witnesses,
    }
}

/// What is known of a segment.
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
    }
}

fn pair(scene: &Scene, id: PairId) -> ExtricatePair {
    scene.pairs.get(id.index()).map_or(NO_PAIR, |pair| ExtricatePair { first: pair.first, second: pair.second })
}
