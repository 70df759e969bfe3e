//! Maps enums of the library to the constants that the header has for them.

use extricate::{Effort, EscapeMethod, Keep, Label, MetricKind, PlanMethod, Unproved};

use crate::abi::grasp_types::{EXTRICATE_KEEP_CONTACTS, EXTRICATE_KEEP_POSE};
use crate::abi::motion_types::{
    EXTRICATE_ESCAPE_EXIT, EXTRICATE_ESCAPE_FREE, EXTRICATE_ESCAPE_GROWN, EXTRICATE_ESCAPE_NEAREST,
    EXTRICATE_ESCAPE_PUSHED, EXTRICATE_PLAN_ROADMAP, EXTRICATE_PLAN_STRAIGHT, EXTRICATE_PLAN_TREES,
};
use crate::abi::types::{
    EXTRICATE_ANY, EXTRICATE_COLLIDING, EXTRICATE_EXHAUSTIVE, EXTRICATE_FREE, EXTRICATE_METRIC_JOINT,
    EXTRICATE_METRIC_MAX_DISPLACEMENT, EXTRICATE_METRIC_OBJECT_NORM, EXTRICATE_NEAREST, EXTRICATE_PROVED,
    EXTRICATE_QUICK, EXTRICATE_REFINED, EXTRICATE_UNPROVED_OFF, EXTRICATE_UNPROVED_SHALLOW,
    EXTRICATE_UNPROVED_SURFACES,
};

pub const EFFORTS: &[(Effort, u32)] = &[
    (Effort::Nearest, EXTRICATE_NEAREST),
    (Effort::Quick, EXTRICATE_QUICK),
    (Effort::Refined, EXTRICATE_REFINED),
    (Effort::Exhaustive, EXTRICATE_EXHAUSTIVE),
    (Effort::Proved, EXTRICATE_PROVED),
];

pub const METRICS: &[(MetricKind, u32)] = &[
    (MetricKind::Joint, EXTRICATE_METRIC_JOINT),
    (MetricKind::ObjectNorm, EXTRICATE_METRIC_OBJECT_NORM),
    (MetricKind::MaxDisplacement, EXTRICATE_METRIC_MAX_DISPLACEMENT),
];

pub const UNPROVED: &[(Unproved, u32)] = &[
    (Unproved::Surfaces, EXTRICATE_UNPROVED_SURFACES),
    (Unproved::Shallow, EXTRICATE_UNPROVED_SHALLOW),
    (Unproved::Off, EXTRICATE_UNPROVED_OFF),
];

pub const ESCAPE_METHODS: &[(EscapeMethod, u32)] = &[
    (EscapeMethod::Free, EXTRICATE_ESCAPE_FREE),
    (EscapeMethod::Nearest, EXTRICATE_ESCAPE_NEAREST),
    (EscapeMethod::Exit, EXTRICATE_ESCAPE_EXIT),
    (EscapeMethod::Pushed, EXTRICATE_ESCAPE_PUSHED),
    (EscapeMethod::Grown, EXTRICATE_ESCAPE_GROWN),
];

pub const PLAN_METHODS: &[(PlanMethod, u32)] = &[
    (PlanMethod::Straight, EXTRICATE_PLAN_STRAIGHT),
    (PlanMethod::Trees, EXTRICATE_PLAN_TREES),
    (PlanMethod::Roadmap, EXTRICATE_PLAN_ROADMAP),
];

pub const KEEPS: &[(Keep, u32)] = &[(Keep::Contacts, EXTRICATE_KEEP_CONTACTS), (Keep::Pose, EXTRICATE_KEEP_POSE)];

/// What a sample may be; `None` is both.
pub const LABELS: &[(Option<Label>, u32)] =
    &[(None, EXTRICATE_ANY), (Some(Label::Free), EXTRICATE_FREE), (Some(Label::Colliding), EXTRICATE_COLLIDING)];

/// Returns the number of a choice. A test checks that every choice is in its table.
pub fn number<T: PartialEq>(table: &[(T, u32)], choice: T) -> u32 {
    table.iter().find(|(known, _)| *known == choice).map_or(u32::MAX, |(_, number)| *number)
}

/// Returns the choice with this number, if there is one.
pub fn choice<T: Copy>(table: &[(T, u32)], number: u32) -> Option<T> {
    table.iter().find(|(_, known)| *known == number).map(|(choice, _)| *choice)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_choice_has_a_number_of_its_own() {
        fn check<T: Copy + PartialEq>(table: &[(T, u32)], all: &[T]) {
            assert_eq!(table.len(), all.len());
            assert!(all.iter().all(|known| choice(table, number(table, *known)) == Some(*known)));
        }
        check(EFFORTS, Effort::ALL);
        check(METRICS, MetricKind::ALL);
        check(UNPROVED, Unproved::ALL);
        check(ESCAPE_METHODS, EscapeMethod::ALL);
        check(PLAN_METHODS, PlanMethod::ALL);
        check(KEEPS, Keep::ALL);
        assert_eq!(choice(EFFORTS, 99), None);
    }
}
