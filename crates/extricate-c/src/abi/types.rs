//! The constants and plain structures that the header declares.

use std::ffi::{c_char, c_void};

/// What a function returns: EXTRICATE_OK, or why there is no result.
pub type ExtricateStatus = i32;

/// There is a result.
pub const EXTRICATE_OK: i32 = 0;
/// Nothing free was found, though nothing is wrong with the call.
pub const EXTRICATE_NOTHING_FREE: i32 = 1;
/// An argument is a null pointer, has a wrong length, or is an option that makes no sense.
pub const EXTRICATE_ARGUMENT: i32 = 2;
/// A configuration has a wrong length, is not finite, or is beyond limits while that is refused.
pub const EXTRICATE_CONFIGURATION: i32 = 3;
/// A file cannot be read or written.
pub const EXTRICATE_FILE: i32 = 4;
/// A scene, robot, mesh or world says something that cannot be used, or a name is unknown.
pub const EXTRICATE_INPUT: i32 = 5;
/// A model file is truncated, altered, foreign or of another version.
pub const EXTRICATE_MODEL: i32 = 6;
/// A fault of this library was caught.
pub const EXTRICATE_INTERNAL: i32 = 7;

/// Number of this interface: it grows if programs have to be compiled anew.
pub const EXTRICATE_ABI: u32 = 1;

/// Effort: the nearest stored sample of a model; without a model, the first exit that is found.
pub const EXTRICATE_NEAREST: u32 = 0;
/// Effort: descents from several starts in different directions; the best end is verified.
pub const EXTRICATE_REFINED: u32 = 1;
/// Effort: many starts and long refinement.
pub const EXTRICATE_EXHAUSTIVE: u32 = 2;
/// Effort: as refined, and then branch and bound until the gap is proved or a limit is reached.
pub const EXTRICATE_PROVED: u32 = 3;
/// Effort: as refined with fewer descents, which takes about half the checks.
pub const EXTRICATE_QUICK: u32 = 4;

/// Metric: the weighted change of the joints \[rad or m\].
pub const EXTRICATE_METRIC_JOINT: u32 = 0;
/// Metric: the root mean square displacement of the robot's solids \[m\].
pub const EXTRICATE_METRIC_OBJECT_NORM: u32 = 1;
/// Metric: the largest displacement of any point of the robot \[m\].
pub const EXTRICATE_METRIC_MAX_DISPLACEMENT: u32 = 2;

/// A lower bound above 0 is proved, or the query is free.
pub const EXTRICATE_IS_PROVED: u32 = 0;
/// No lower bound is proved: what collides are surfaces, which enclose nothing.
pub const EXTRICATE_UNPROVED_SURFACES: u32 = 1;
/// No lower bound is proved: the bodies overlap too little.
pub const EXTRICATE_UNPROVED_SHALLOW: u32 = 2;

/// Shape: a box; `size` holds its full sides \[m\].
pub const EXTRICATE_BOX: u32 = 0;
/// Shape: a ball; `size[0]` is its radius \[m\].
pub const EXTRICATE_SPHERE: u32 = 1;
/// Shape: a cylinder along z; `size` holds its radius and its length \[m\].
pub const EXTRICATE_CYLINDER: u32 = 2;
/// Shape: a capsule along z; `size` holds radius and length of its cylindrical part \[m\].
pub const EXTRICATE_CAPSULE: u32 = 3;
/// Shape: a mesh; `points` are its corners \[m\], and each of `triangles` joins three of them.
pub const EXTRICATE_MESH: u32 = 4;
/// Shape: balls of radius `size[0]` around `points` \[m\]; for obstacles alone.
pub const EXTRICATE_POINTS: u32 = 5;
/// Shape: occupied `cells` of side `size[0]` \[m\]; for obstacles alone.
pub const EXTRICATE_VOXELS: u32 = 6;
/// Shape: all behind a plane of normal `size` at `offset` \[m\] along it; for obstacles alone.
pub const EXTRICATE_HALF_SPACE: u32 = 7;

/// Where something stands.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ExtricatePose {
    /// x, y, z \[m\].
    pub position: [f64; 3],
    /// Unit quaternion x, y, z, w.
    pub quaternion: [f64; 4],
}

/// One shape. Members that its kind does not name are not read.
#[repr(C)]
pub struct ExtricateShape {
    /// EXTRICATE_BOX or another of the kinds.
    pub kind: u32,
    /// Numbers that the kinds explain.
    pub size: [f64; 3],
    /// Where the plane of a half-space is, along its unit normal \[m\].
    pub offset: f64,
    /// Points, three numbers each \[m\].
    pub points: *const f64,
    /// How many points.
    pub point_count: usize,
    /// Triangles, three indices of points each.
    pub triangles: *const u32,
    /// How many triangles.
    pub triangle_count: usize,
    /// Cells, three indices each.
    pub cells: *const i32,
    /// How many cells.
    pub cell_count: usize,
    /// Whether the convex hull of a mesh stands for it: 0 or 1.
    pub convex: u32,
}

/// An obstacle, or an object for a link to hold.
#[repr(C)]
pub struct ExtricateObstacle {
    /// Its name, which nothing else in the scene has.
    pub name: *const c_char,
    /// Its shape.
    pub shape: ExtricateShape,
    /// Its pose in the world; that of an object for a link, in the coordinates of the link.
    pub pose: ExtricatePose,
}

/// A text that stands for a file which a scene names.
#[repr(C)]
pub struct ExtricateText {
    /// The path, as the scene spells it.
    pub path: *const c_char,
    /// What the file would hold.
    pub text: *const c_char,
}

/// Options of a query. extricate_options_init() fills in the defaults; set what differs then.
/// Any number but 0 counts as 1 in a member that is 0 or 1.
#[repr(C)]
pub struct ExtricateOptions {
    /// How hard to try: EXTRICATE_NEAREST, _QUICK, _REFINED, _EXHAUSTIVE or _PROVED;
    /// EXTRICATE_REFINED by default.
    pub effort: u32,
    /// Whether to refuse configurations beyond the limits, in place of answering them: 0 or 1; 0 by
    /// default.
    pub refuse_outside: u32,
    /// Whether to prove how far around the witness nothing touches: 0 or 1; 0 by default.
    pub free_radius: u32,
    /// Whether to tell how much of the straight segment to the witness collides: 0 or 1; 0 by
    /// default.
    pub segment: u32,
    /// Whether to tell contacts with EXTRICATE_NEAREST as well; the other efforts always do: 0 or
    /// 1; 0 by default.
    pub contacts: u32,
    /// How many distinct exits to look for: 1 to 100000; 1 by default.
    pub exits: usize,
    /// How many descents to start: 1 to 100000; 0 by default, which leaves it to the effort.
    pub starts: usize,
    /// Share of the depth that need not be proved, at which the search stops: 0 or more and less
    /// than 1; nan by default, which leaves it to the effort.
    pub gap: f64,
    /// Clearance that the witness is to keep: 0 to 1e9 \[m\]; nan by default, for that of the
    /// scene.
    pub clearance: f64,
    /// Most collision checks and distance evaluations to spend: 0 or more; SIZE_MAX by default, for
    /// no limit.
    pub max_checks: usize,
    /// Most seconds to spend: more than 0; infinity by default, for no limit.
    pub max_seconds: f64,
    /// The names of joints that stay where the query has them; null by default, for none.
    pub locked: *const *const c_char,
    /// How many joints are locked.
    pub locked_count: usize,
    /// The goal, a configuration: of exits that are about as near as the nearest, the one that is
    /// nearest to it becomes the witness; null by default, for none.
    pub toward: *const f64,
    /// How many numbers the goal has: those of a configuration.
    pub toward_count: usize,
    /// By which share of its depth an exit may be farther than the nearest to count as about as
    /// near: 0 to 1e9; 0.25 by default.
    pub toward_share: f64,
    /// Ends a query early if it returns true; null by default, for none. It is called between the
    /// steps of a query, on any thread, and on several at once. It must not throw.
    pub stop: Option<unsafe extern "C" fn(*mut c_void) -> bool>,
    /// What `stop` is called with.
    pub stop_data: *mut c_void,
}

/// What is known of an answer, in numbers.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateSummary {
    /// Distance from the query to the witness, in the scene's metric; 0 if the query is free,
    /// infinity if nothing free was found.
    pub depth: f64,
    /// Proved: no free configuration is nearer.
    pub lower_bound: f64,
    /// Share of the depth that is not proved.
    pub gap: f64,
    /// Largest displacement of any point of the robot, from the query to the witness \[m\].
    pub max_displacement: f64,
    /// Estimated share of starts that would lead to an exit which was not met; nan if unknown.
    pub unseen: f64,
    /// Clearance that the witness keeps \[m\], but for pairs with one of their own.
    pub clearance: f64,
    /// Proved: nothing touches nearer to the witness than this; nan if it was not requested.
    pub free_radius: f64,
    /// Fraction of the straight segment up to which a collision was found; nan if not requested.
    pub segment_colliding_until: f64,
    /// Fraction from which on the straight segment is proved free; nan if not requested.
    pub segment_free_from: f64,
    /// Collision checks and distance evaluations spent.
    pub checks: u64,
    /// EXTRICATE_IS_PROVED, or why no lower bound is proved.
    pub unproved: u32,
    /// Whether there is a witness.
    pub found: bool,
    /// Whether the query itself is free.
    pub is_free: bool,
    /// Whether the exact checker called the witness free during this query.
    pub verified: bool,
    /// Whether no other distinct exit within 1 % of the depth was met.
    pub unique: bool,
    /// Whether a limit of checks or seconds, or a stop, ended the search before it was done.
    pub cut_short: bool,
}

/// Two bodies that have to stay apart, as indices of bodies.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExtricatePair {
    /// The lower index.
    pub first: usize,
    /// The higher one.
    pub second: usize,
}

/// Where two bodies touch at a witness, in world coordinates.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateContact {
    /// The bodies.
    pub pair: ExtricatePair,
    /// Signed distance of the points \[m\]; negative if the bodies overlap.
    pub distance: f64,
    /// Point on the first body \[m\].
    pub point_first: [f64; 3],
    /// Point on the second body \[m\].
    pub point_second: [f64; 3],
    /// Unit vector from the second body toward the first.
    pub normal: [f64; 3],
}

/// One of several exits.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateExit {
    /// Distance from the query to the witness, in the scene's metric.
    pub depth: f64,
    /// A free configuration, as many numbers as the query, which live as long as the answer.
    pub witness: *const f64,
}

/// What is known of the segment between two configurations. Fractions are of its length.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateSegment {
    /// Proved: every configuration of the segment is free.
    pub is_free: bool,
    /// A collision was found. If neither this nor `is_free` is set, only `free_until` is proved.
    pub collides: bool,
    /// Proved: up to this fraction every configuration is free.
    pub free_until: f64,
    /// Fraction at which a configuration collides, or nearly does if that is not proved; nan if the
    /// segment is free.
    pub at: f64,
    /// The bodies that do; both indices are SIZE_MAX if the segment is free.
    pub pair: ExtricatePair,
}
