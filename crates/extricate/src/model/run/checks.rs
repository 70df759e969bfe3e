//! What the places of runs have to hold that were read as bytes: whoever writes a checkpoint can
//! say anything.

use crate::learning::budget::Spent;
use crate::model::solve::SolvePlace;
use crate::model::statistics::{MOST, check_count};
use crate::samples::trace::TracePlace;

/// Most seconds that a run has spent: 30,000 years.
const MOST_SECONDS: f64 = 1e12;

/// What a run has spent, and the numbers of the points that come next.
///
/// # Errors
/// The element, its value, and what was expected.
pub fn check_spent(spent: &Spent, next: &[u64]) -> Result<(), String> {
    check_count("spent: labels", spent.labels)?;
    if !(0.0..=MOST_SECONDS).contains(&spent.seconds) {
        return Err(format!("spent: seconds: got {:?}, expected 0 to {MOST_SECONDS:e}", spent.seconds));
    }
    match next.iter().find(|next| **next > MOST) {
        Some(bad) => Err(format!("next: got {bad}, expected at most {MOST}")),
        None => Ok(()),
    }
}

/// Where tracing stands, of so many free configurations, samples and colliding configurations.
///
/// # Errors
/// The place, and what was expected.
pub fn check_traced(place: &TracePlace, [free, samples, colliding]: [usize; 3]) -> Result<(), String> {
    check_count("passes", place.passes)?;
    if place.starts <= free && place.indexed <= samples && place.seeds_used <= colliding {
        return Ok(());
    }
    Err(format!("tracing: got {place:?}, expected at most {free} starts, {samples} indexed, {colliding} seeds"))
}

/// Where solving stands, of so many samples and colliding configurations.
///
/// # Errors
/// The place, and what was expected.
pub fn check_solved(place: &SolvePlace, samples: usize, colliding: usize) -> Result<(), String> {
    if place.indexed <= place.exits && place.exits <= samples && place.seeds_used <= colliding {
        return Ok(());
    }
    Err(format!("solving: got {place:?}, expected at most {samples} exits, no more indexed, {colliding} seeds"))
}
