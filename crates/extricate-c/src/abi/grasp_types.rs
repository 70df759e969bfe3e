//! The constants and plain structures of grasps.

use std::ffi::{c_char, c_void};

/// A release keeps the contacts of the links that touched.
pub const EXTRICATE_KEEP_CONTACTS: u32 = 0;
/// A release keeps the pose alone: the nearest free configuration, whatever it touches.
pub const EXTRICATE_KEEP_POSE: u32 = 1;

/// Options of extricate_release(). extricate_release_options_init() fills in the defaults; then set
/// the members that differ.
#[repr(C)]
pub struct ExtricateReleaseOptions {
    /// What the release keeps: EXTRICATE_KEEP_CONTACTS by default, or EXTRICATE_KEEP_POSE.
    pub keep: u32,
    /// Distance beyond the clearance up to which a link touches the object: 0 to 1e9 \[m\]; 2e-3 by
    /// default.
    pub touch: f64,
    /// Coefficient of friction, for the quality of the grasp: 0 to 1e9; 0.8 by default, 0 leaves
    /// the quality unmeasured.
    pub friction: f64,
    /// Configuration with open fingers, from which each finger closes on its side of the object;
    /// null by default, which means every joint at 0, or at the limit nearest to 0.
    pub open: *const f64,
    /// Number of coordinates of `open`: that of a configuration.
    pub open_count: usize,
    /// Clearance to aim at: 0 to 1e9 \[m\]; nan by default, which means that of the scene.
    pub clearance: f64,
    /// The names of joints that keep their positions; null by default, for none.
    pub locked: *const *const c_char,
    /// Number of `locked` joints.
    pub locked_count: usize,
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

/// The numbers of a grasp.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateGraspSummary {
    /// Distance from the query, in the scene's metric.
    pub moved: f64,
    /// Whether the exact checker called it free during this call.
    pub verified: bool,
    /// Whether every kept contact is on its side of the object.
    pub kept_sides: bool,
    /// Number of fingers that touched at the query.
    pub fingers_before: usize,
    /// Number of those fingers that still touch.
    pub fingers_kept: usize,
    /// Greatest depth of a link in the object at the query \[m\]; 0 if none was in it.
    pub depth_before: f64,
    /// Largest wrench that the contacts resist in every direction; nan if it was not measured.
    pub epsilon: f64,
    /// Whether the contacts resist every wrench; false if it was not measured.
    pub force_closure: bool,
    /// Number of exact checks and contact evaluations.
    pub checks: u64,
}

/// A contact of a link with the object that a hand holds.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateGraspContact {
    /// Name of the link, which lives as long as the grasp.
    pub link: *const c_char,
    /// Signed distance \[m\].
    pub distance: f64,
    /// Point on the object, in the world \[m\].
    pub point: [f64; 3],
    /// Unit vector into the object.
    pub normal: [f64; 3],
}
