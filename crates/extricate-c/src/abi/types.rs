//! Numbers and plain structures that the header shows.

use std::ffi::{c_char, c_void};

/// What a function returns: EXTRICATE_OK, or why there is no result.
pub type ExtricateStatus = i32;

/// There is a result.
pub const EXTRICATE_OK: i32 = 0;
/// Nothing free was found: no fault of the call.
pub const EXTRICATE_NOTHING_FREE: i32 = 1;
/// A null pointer, a wrong length, a name that nothing has, an option that makes no sense.
pub const EXTRICATE_ARGUMENT: i32 = 2;
/// A configuration of the wrong length, not finite, or beyond limits where that is refused.
pub const EXTRICATE_CONFIGURATION: i32 = 3;
/// A file cannot be read or written.
pub const EXTRICATE_FILE: i32 = 4;
/// A scene, robot, mesh or world says something that cannot be used.
pub const EXTRICATE_INPUT: i32 = 5;
/// A model file is truncated, altered, foreign or of another version.
pub const EXTRICATE_MODEL: i32 = 6;
/// A fault of this library, caught.
pub const EXTRICATE_INTERNAL: i32 = 7;

/// Number of this interface: it grows where a program has to be compiled anew.
pub const EXTRICATE_ABI: u32 = 1;

/// Effort: the nearest stored sample; needs a model.
pub const EXTRICATE_NEAREST: u32 = 0;
/// Effort: diverse starts, descents, verification. The default.
pub const EXTRICATE_REFINED: u32 = 1;
/// Effort: many starts.
pub const EXTRICATE_EXHAUSTIVE: u32 = 2;
/// Effort: as refined, and then branch and bound until the gap is proved or the budget ends.
pub const EXTRICATE_PROVED: u32 = 3;
/// As refined, with fewer starts: about half the checks.
pub const EXTRICATE_QUICK: u32 = 4;

/// Metric of the joints \[rad\], weighted.
pub const EXTRICATE_METRIC_JOINT: u32 = 0;
/// Root mean square displacement of the robot's solids \[m\].
pub const EXTRICATE_METRIC_OBJECT_NORM: u32 = 1;
/// Largest displacement of any point \[m\].
pub const EXTRICATE_METRIC_MAX_DISPLACEMENT: u32 = 2;

/// Something is proved, or the query is free.
pub const EXTRICATE_IS_PROVED: u32 = 0;
/// Nothing is proved: what collides are surfaces, which enclose nothing.
pub const EXTRICATE_UNPROVED_SURFACES: u32 = 1;
/// Nothing is proved: the overlap is too shallow.
pub const EXTRICATE_UNPROVED_SHALLOW: u32 = 2;

/// Shape: a box, `size` are its full sides \[m\].
pub const EXTRICATE_BOX: u32 = 0;
/// Shape: `size[0]` is the radius \[m\].
pub const EXTRICATE_SPHERE: u32 = 1;
/// Shape: `size` are radius and length \[m\], along z.
pub const EXTRICATE_CYLINDER: u32 = 2;
/// Shape: `size` are radius and length of the cylindrical part \[m\], along z.
pub const EXTRICATE_CAPSULE: u32 = 3;
/// Shape: `points` are corners \[m\], `triangles` indices of three each.
pub const EXTRICATE_MESH: u32 = 4;
/// Shape: `points` \[m\] with balls of radius `size[0]` about them; obstacles only.
pub const EXTRICATE_POINTS: u32 = 5;
/// Shape: occupied `cells` of side `size[0]` \[m\]; obstacles only.
pub const EXTRICATE_VOXELS: u32 = 6;
/// Shape: what lies behind the plane with the normal `size`, at `offset` \[m\]; obstacles only.
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
    /// EXTRICATE_BOX and so on.
    pub kind: u32,
    /// See the kinds.
    pub size: [f64; 3],
    /// Of a half-space, along its unit normal \[m\].
    pub offset: f64,
    /// Three numbers each \[m\].
    pub points: *const f64,
    /// How many points.
    pub point_count: usize,
    /// Three indices of points each.
    pub triangles: *const u32,
    /// How many triangles.
    pub triangle_count: usize,
    /// Three indices each.
    pub cells: *const i32,
    /// How many cells.
    pub cell_count: usize,
    /// Of a mesh: not 0 where its convex hull stands for it.
    pub convex: u32,
}

/// An obstacle, or an object for a link to hold.
#[repr(C)]
pub struct ExtricateObstacle {
    /// A name of its own.
    pub name: *const c_char,
    /// Its shape.
    pub shape: ExtricateShape,
    /// In the world; of an attached object, in the link's coordinates.
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

/// What is asked of a query. Fill it with extricate_options_init() first.
#[repr(C)]
pub struct ExtricateOptions {
    /// EXTRICATE_REFINED and so on.
    pub effort: u32,
    /// Not 0: configurations beyond the limits are refused, not answered.
    pub refuse_outside: u32,
    /// Not 0: prove within which distance of the witness nothing touches.
    pub free_radius: u32,
    /// Not 0: tell how much of the straight segment to the witness collides.
    pub segment: u32,
    /// Not 0: tell contacts with EXTRICATE_NEAREST too.
    pub contacts: u32,
    /// How many distinct exits to look for; 1 by default.
    pub exits: usize,
    /// How many starts; 0 leaves it to the effort.
    pub starts: usize,
    /// Share of the depth that need not be proved, in \[0, 1); nan for none.
    pub gap: f64,
    /// Clearance to aim at \[m\]; nan for that of the scene.
    pub clearance: f64,
    /// Most checks; SIZE_MAX for no limit.
    pub max_checks: usize,
    /// Most seconds; infinity for no limit.
    pub max_seconds: f64,
    /// Names of joints that stay where the query has them.
    pub locked: *const *const c_char,
    /// How many.
    pub locked_count: usize,
    /// A configuration that the witness is to be near to, among exits about as near; or null.
    pub toward: *const f64,
    /// How many numbers it has: those of a configuration.
    pub toward_count: usize,
    /// Exits count that are farther than the nearest one by at most this share of its depth.
    pub toward_share: f64,
    /// Ends a query early where it says true: called between its steps, on any thread, of a batch
    /// on several at once; null for none. It must not throw.
    pub stop: Option<unsafe extern "C" fn(*mut c_void) -> bool>,
    /// What `stop` is given.
    pub stop_data: *mut c_void,
}

/// What is known of an answer, in numbers.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateSummary {
    /// Distance from the query to the witness, in the scene's metric; 0 where the query is free,
    /// infinity where nothing free was found.
    pub depth: f64,
    /// Proved: no free configuration is nearer.
    pub lower_bound: f64,
    /// Share of the depth that is not proved.
    pub gap: f64,
    /// Largest displacement of any point of the robot, from the query to the witness \[m\].
    pub max_displacement: f64,
    /// Estimated share of starts that would lead to an exit which was not met; nan where unknown.
    pub unseen: f64,
    /// What the witness keeps \[m\].
    pub clearance: f64,
    /// Proved: nothing touches nearer to the witness than this; nan where not requested.
    pub free_radius: f64,
    /// Fraction of the straight segment up to which a collision was found; nan where not requested.
    pub segment_colliding_until: f64,
    /// Fraction from which on the straight segment is proved free; nan where not requested.
    pub segment_free_from: f64,
    /// Collision checks and distance evaluations spent.
    pub checks: u64,
    /// EXTRICATE_IS_PROVED, or why nothing is.
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
    /// Signed \[m\]; negative where they overlap.
    pub distance: f64,
    /// On the first body \[m\].
    pub point_first: [f64; 3],
    /// On the second body \[m\].
    pub point_second: [f64; 3],
    /// Unit, from the second body toward the first.
    pub normal: [f64; 3],
}

/// One of several exits.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateExit {
    /// Distance from the query.
    pub depth: f64,
    /// nq numbers, which live as long as the answer.
    pub witness: *const f64,
}

/// What is known of the segment between two configurations. Fractions are of its length.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateSegment {
    /// Proved: every configuration of the segment is free.
    pub is_free: bool,
    /// A collision was found; where neither is set, nothing is proved.
    pub collides: bool,
    /// Up to here every configuration is free: proved.
    pub free_until: f64,
    /// Where a configuration collides, or nearly does where nothing is proved; nan where free.
    pub at: f64,
    /// What does; no bodies where free, both indices are SIZE_MAX then.
    pub pair: ExtricatePair,
}
