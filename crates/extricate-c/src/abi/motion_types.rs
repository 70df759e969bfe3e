//! The constants and plain structures of motions: escapes, plans and repairs.

use std::ffi::{c_char, c_void};

use super::types::ExtricatePair;

/// Escape: no step found a path.
pub const EXTRICATE_ESCAPE_NONE: u32 = 0;
/// Escape: the query is free.
pub const EXTRICATE_ESCAPE_FREE: u32 = 1;
/// Escape: the path is a straight edge to the nearest exit.
pub const EXTRICATE_ESCAPE_NEAREST: u32 = 2;
/// Escape: the path is a straight edge to another exit.
pub const EXTRICATE_ESCAPE_EXIT: u32 = 3;
/// Escape: the path separates the colliding pairs step by step.
pub const EXTRICATE_ESCAPE_PUSHED: u32 = 4;
/// Escape: trees that grew toward each other found the path.
pub const EXTRICATE_ESCAPE_GROWN: u32 = 5;

/// Plan: no step found a path.
pub const EXTRICATE_PLAN_NONE: u32 = 0;
/// Plan: the free part is the straight edge between its ends.
pub const EXTRICATE_PLAN_STRAIGHT: u32 = 1;
/// Plan: trees from both ends found the free part.
pub const EXTRICATE_PLAN_TREES: u32 = 2;
/// Plan: the free part goes through the roadmap.
pub const EXTRICATE_PLAN_ROADMAP: u32 = 3;

/// Options of extricate_escape(). extricate_escape_options_init() fills in the defaults; then set
/// the members that differ.
#[repr(C)]
pub struct ExtricateEscapeOptions {
    /// Clearance that the end of the path should keep: 0 to 1e9 \[m\]; nan by default, which means
    /// that of the scene plus 1 mm. A near end with less clearance is preferred to a far one.
    pub aim: f64,
    /// Depth by which a pair that collides at the query may get deeper on the path: 0 to 1e9 \[m\];
    /// 1e-3 by default.
    pub tolerance: f64,
    /// Links that keep their places at the query, or at given poses, all along the path, as in
    /// ExtricateOptions; null by default, for none.
    pub keep: *const c_char,
    /// Goal of a later motion, a configuration: of exits that are about as near, the one nearest to
    /// it is preferred; null by default, for none.
    pub toward: *const f64,
    /// Number of coordinates of the goal: that of a configuration.
    pub toward_count: usize,
    /// Number of exits to which straight edges are tried: 0 to 100000; 6 by default.
    pub exits: usize,
    /// Resolution at which edges are proved: 0 to 1e9 \[m\]; 1e-4 by default.
    pub resolution: f64,
    /// Most checks of the trees, which grow only if nothing simpler leads out of collision: 20000
    /// by default.
    pub tree_checks: usize,
    /// Seed of all random numbers; 0 by default.
    pub seed: u64,
    /// Most checks to spend; SIZE_MAX by default, for no limit.
    pub max_checks: usize,
    /// Most seconds to spend: more than 0; infinity by default, for no limit.
    pub max_seconds: f64,
    /// Function that ends the call early if it returns true, as in ExtricateOptions; null by
    /// default, for none.
    pub stop: Option<unsafe extern "C" fn(*mut c_void) -> bool>,
    /// Argument that the call passes to `stop`.
    pub stop_data: *mut c_void,
}

/// Options of extricate_plan(). extricate_plan_options_init() fills in the defaults; then set the
/// members that differ.
#[repr(C)]
pub struct ExtricatePlanOptions {
    /// Resolution at which edges are proved: 0 to 1e9 \[m\]; 1e-4 by default.
    pub resolution: f64,
    /// Depth by which a pair that collides at an end may get deeper on the path: 0 to 1e9 \[m\];
    /// 1e-3 by default.
    pub tolerance: f64,
    /// Links that keep their places at the start, or at given poses, all along the path, as in
    /// ExtricateOptions; null by default, for none. Such plans neither use nor extend a roadmap.
    pub keep: *const c_char,
    /// Clearance to which the points of the free part are pushed off: 0 to 1e9 \[m\]; nan by
    /// default, which leaves the path short. With `keep` it has to be nan.
    pub clearance: f64,
    /// Whether to shorten the path: 0 or 1; 1 by default.
    pub shortcut: u32,
    /// Seed of all random numbers; 0 by default.
    pub seed: u64,
    /// Number of threads, 0 by default, for one per core. The path does not depend on it.
    pub threads: usize,
    /// Most checks to spend; 1000000 by default, SIZE_MAX for no limit.
    pub max_checks: usize,
    /// Most seconds to spend: more than 0; infinity by default, for no limit.
    pub max_seconds: f64,
    /// Function that ends the call early if it returns true, as in ExtricateOptions; null by
    /// default, for none.
    pub stop: Option<unsafe extern "C" fn(*mut c_void) -> bool>,
    /// Argument that the call passes to `stop`.
    pub stop_data: *mut c_void,
}

/// Options of extricate_repair(). extricate_repair_options_init() fills in the defaults; then set
/// the members that differ.
#[repr(C)]
pub struct ExtricateRepairOptions {
    /// Clearance to which configurations are pushed out: 0 to 1e9 \[m\]. It is nan by default,
    /// which means that of the scene plus a tenth of the radius of the smallest moving body.
    pub aim: f64,
    /// Largest accepted deviation from the path, in the scene's metric: 0 to 1e9; infinity by
    /// default, for no limit.
    pub max_deviation: f64,
    /// Links that keep their places at the first row, or at given poses, all along the path, as in
    /// ExtricateOptions; null by default, for none. With `frames`, each row keeps them where it has
    /// them.
    pub keep: *const c_char,
    /// Whether the rows are frames of a motion, so that the result has one point for each, at the
    /// same time: 0 or 1; 0 by default.
    pub frames: u32,
    /// With `frames`, but not with `keep`: the longest step from frame to frame, in the scene's
    /// metric: more than 0; infinity by default, for no limit. The result lags behind steps that
    /// are longer.
    pub max_step: f64,
    /// With `frames`: pairs that are at most this far apart beyond the clearance in a row, or
    /// overlap there, stay as near if they can: more than 0 \[m\]; nan by default, which keeps no
    /// contacts.
    pub touch: f64,
    /// Resolution at which edges are proved: 0 to 1e9 \[m\]; 1e-4 by default.
    pub resolution: f64,
    /// Seed of all random numbers; 0 by default.
    pub seed: u64,
    /// Most checks to spend; 100000 by default, SIZE_MAX for no limit.
    pub max_checks: usize,
    /// Most seconds to spend: more than 0; infinity by default, for no limit.
    pub max_seconds: f64,
    /// Function that ends the call early if it returns true, as in ExtricateOptions; null by
    /// default, for none.
    pub stop: Option<unsafe extern "C" fn(*mut c_void) -> bool>,
    /// Argument that the call passes to `stop`.
    pub stop_data: *mut c_void,
}

/// A pair of bodies and its signed distance.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricatePairDistance {
    /// The two bodies of the pair.
    pub pair: ExtricatePair,
    /// Signed distance \[m\]; negative if the bodies overlap.
    pub distance: f64,
}

/// The numbers of an escape.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateEscapeSummary {
    /// Whether a path was found.
    pub found: bool,
    /// The step that found the path: EXTRICATE_ESCAPE_NONE or another.
    pub method: u32,
    /// Index of the point from which on the path is proved free.
    pub free_from: usize,
    /// Most that any pair that collides at the query was found deeper than there \[m\]. It is
    /// proved to be at most the tolerance.
    pub deepening: f64,
    /// Least of 1, 2, 5 and 10 mm with which, as a larger tolerance, a path is found \[m\]. It is
    /// nan if a path was found, or if none is found with these either.
    pub needed_tolerance: f64,
    /// Length of the path in the scene's metric.
    pub length: f64,
    /// Largest displacement of any point of the robot from the query to any point of the path
    /// \[m\].
    pub max_displacement: f64,
    /// Number of configurations at which the exact checker evaluated anything.
    pub checks: u64,
}

/// The numbers of a plan.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricatePlanSummary {
    /// Whether a path was found.
    pub found: bool,
    /// The step that found the free part: EXTRICATE_PLAN_NONE or another.
    pub method: u32,
    /// Index of the point from which on the path is proved free; 0 if the start is free.
    pub free_from: usize,
    /// Index of the point up to which the path is proved free; the last one if the goal is free.
    pub free_to: usize,
    /// Length of the path in the scene's metric.
    pub length: f64,
    /// Number of configurations at which the exact checker evaluated anything.
    pub checks: u64,
    /// Number of configurations in the roadmap.
    pub nodes: usize,
}

/// The numbers of a repaired path.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateRepairedSummary {
    /// Whether a path was found.
    pub found: bool,
    /// Largest distance of a point from its place on the old path, in the scene's metric. Rows of
    /// the old path that the new one cuts off count too.
    pub deviation: f64,
    /// Length of the path in the scene's metric.
    pub length: f64,
    /// Length of the old path in the scene's metric.
    pub length_before: f64,
    /// Number of stretches of the old path that were replaced.
    pub stretches: usize,
    /// Number of gaps in these stretches that trees had to close.
    pub gaps: usize,
    /// Number of pairs that touch, summed over the rows; 0 if `touch` of the options is nan.
    pub touched: usize,
    /// Number of these that touch in the result.
    pub kept: usize,
    /// Number of configurations at which the exact checker evaluated anything.
    pub checks: u64,
}
