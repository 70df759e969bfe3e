//! The constants and plain structures that the header declares.

use std::ffi::{c_char, c_void};

/// Status that a function returns: EXTRICATE_OK, or the reason why there is no result.
pub type ExtricateStatus = i32;

/// There is a result.
pub const EXTRICATE_OK: i32 = 0;
/// Nothing free was found, but the call is valid.
pub const EXTRICATE_NOTHING_FREE: i32 = 1;
/// An argument is a null pointer, has a wrong length, or is an invalid option.
pub const EXTRICATE_ARGUMENT: i32 = 2;
/// A configuration has a wrong length, is not finite, or is beyond limits that the call enforces.
pub const EXTRICATE_CONFIGURATION: i32 = 3;
/// A file cannot be read or written.
pub const EXTRICATE_FILE: i32 = 4;
/// A scene, robot, mesh or world has invalid content, or a name is unknown.
pub const EXTRICATE_INPUT: i32 = 5;
/// A model file is truncated, altered, foreign or of another version.
pub const EXTRICATE_MODEL: i32 = 6;
/// The library caught an internal error.
pub const EXTRICATE_INTERNAL: i32 = 7;

/// Version of this interface. It increases if programs have to be recompiled.
pub const EXTRICATE_ABI: u32 = 2;

/// Effort: the nearest stored sample of a model; without a model, the first exit that is found.
pub const EXTRICATE_NEAREST: u32 = 0;
/// Effort: descents from several starts in different directions; the best end is verified.
pub const EXTRICATE_REFINED: u32 = 1;
/// Effort: many starts and long refinement.
pub const EXTRICATE_EXHAUSTIVE: u32 = 2;
/// Effort: like refined, and then branch and bound until the gap is proved or a limit is reached.
pub const EXTRICATE_PROVED: u32 = 3;
/// Effort: like refined with fewer descents, which takes about half the checks.
pub const EXTRICATE_QUICK: u32 = 4;

/// Metric: the weighted change of the joints \[rad or m\].
pub const EXTRICATE_METRIC_JOINT: u32 = 0;
/// Metric: the root mean square displacement of the robot's solids \[m\].
pub const EXTRICATE_METRIC_OBJECT_NORM: u32 = 1;
/// Metric: the largest displacement of any point of the robot \[m\].
pub const EXTRICATE_METRIC_MAX_DISPLACEMENT: u32 = 2;

/// A lower bound above 0 is proved, or the query is free.
pub const EXTRICATE_IS_PROVED: u32 = 0;
/// No lower bound is proved, because the colliding bodies are surfaces, which enclose nothing.
pub const EXTRICATE_UNPROVED_SURFACES: u32 = 1;
/// No lower bound is proved, because the bodies overlap too little.
pub const EXTRICATE_UNPROVED_SHALLOW: u32 = 2;
/// Nothing is proved: nothing collides, and a kept link is off.
pub const EXTRICATE_UNPROVED_OFF: u32 = 3;

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
/// Shape: balls of radius `size[0]` around `points` \[m\]; for obstacles only.
pub const EXTRICATE_POINTS: u32 = 5;
/// Shape: occupied `cells` of side `size[0]` \[m\]; for obstacles only.
pub const EXTRICATE_VOXELS: u32 = 6;
/// Shape: everything behind a plane of normal `size` at `offset` \[m\] along it; for obstacles
/// only.
pub const EXTRICATE_HALF_SPACE: u32 = 7;

/// Shape: ground whose heights are given on a grid, with cells of side `size[0]` \[m\]; for
/// obstacles only. `heights` are its rows along x, one after the other \[m\], of `columns` each.
pub const EXTRICATE_HEIGHT_FIELD: u32 = 8;

/// Samples: free and colliding ones.
pub const EXTRICATE_ANY: u32 = 0;
/// Samples: free ones alone.
pub const EXTRICATE_FREE: u32 = 1;
/// Samples: colliding ones alone.
pub const EXTRICATE_COLLIDING: u32 = 2;

/// The pose of a body.
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
    /// Sizes, whose meaning depends on `kind`.
    pub size: [f64; 3],
    /// Position of the plane of a half-space along its unit normal \[m\].
    pub offset: f64,
    /// Points, three numbers each \[m\].
    pub points: *const f64,
    /// Number of `points`.
    pub point_count: usize,
    /// Triangles, three indices of points each.
    pub triangles: *const u32,
    /// Number of `triangles`.
    pub triangle_count: usize,
    /// Cells, three indices each.
    pub cells: *const i32,
    /// Number of `cells`.
    pub cell_count: usize,
    /// Whether to use the convex hull of a mesh: 0 or 1.
    pub convex: u32,
    /// Heights of a height field, row by row \[m\].
    pub heights: *const f64,
    /// Number of heights in `heights`.
    pub height_count: usize,
    /// Number of heights of a row.
    pub columns: usize,
}

/// An obstacle, or an object that a link holds.
#[repr(C)]
pub struct ExtricateObstacle {
    /// Its name, which must be unique in the scene.
    pub name: *const c_char,
    /// Its shape.
    pub shape: ExtricateShape,
    /// Its pose in the world; for an object that a link holds, in the coordinates of the link.
    pub pose: ExtricatePose,
}

/// A text that replaces a file that a scene names.
#[repr(C)]
pub struct ExtricateText {
    /// The path, as the scene spells it.
    pub path: *const c_char,
    /// The content of the file.
    pub text: *const c_char,
}

/// A limit of what files may hold.
#[repr(C)]
pub struct ExtricateLoadLimit {
    /// Name of the limit, such as "triangles"; docs/reference/limits.md lists them.
    pub name: *const c_char,
    /// The most that files may hold.
    pub most: usize,
}

/// How files are loaded. Members that are null and 0 stand for the defaults.
#[repr(C)]
pub struct ExtricateLoadOptions {
    /// Folders in which `package://NAME/...` is looked up first; null for none.
    pub packages: *const *const c_char,
    /// Number of folders in `packages`.
    pub package_count: usize,
    /// Limits in place of the default ones; null for none.
    pub limits: *const ExtricateLoadLimit,
    /// Number of limits in `limits`.
    pub limit_count: usize,
}

/// The state of a learning run.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateProgress {
    /// The current step: "exploring", "training", "tracing the boundary", "solving" or "measuring".
    /// It lives as long as the call of the function that gets it.
    pub stage: *const c_char,
    /// Share of the budget spent, 0 to 1.
    pub fraction: f64,
    /// Labels (exact checks) spent.
    pub labels: usize,
    /// Number of boundary samples found.
    pub boundary_samples: usize,
    /// Held-out balanced accuracy of the last classifier; nan before the first.
    pub accuracy: f64,
}

/// The weights of a joint in the joint metric.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ExtricateWeight {
    /// Name of the joint.
    pub joint: *const c_char,
    /// Weight of squared displacements.
    pub translation: f64,
    /// Weight of squared rotations of a floating or planar base; that of its other coordinates is
    /// `translation`. For other joints both are the same number.
    pub rotation: f64,
}

/// Options of a query. extricate_options_init() fills in the defaults; then set the members that
/// differ. In a member that is 0 or 1, any other number counts as 1.
#[repr(C)]
pub struct ExtricateOptions {
    /// How hard to search: EXTRICATE_NEAREST, _QUICK, _REFINED, _EXHAUSTIVE or _PROVED;
    /// EXTRICATE_REFINED by default.
    pub effort: u32,
    /// Whether to refuse configurations beyond the limits instead of answering them: 0 or 1; 0 by
    /// default.
    pub refuse_outside: u32,
    /// Whether to prove a radius around the witness within which nothing touches: 0 or 1; 0 by
    /// default.
    pub free_radius: u32,
    /// Whether to report how much of the straight segment to the witness collides: 0 or 1; 0 by
    /// default.
    pub segment: u32,
    /// Whether to report contacts with EXTRICATE_NEAREST as well; the other efforts always report
    /// them: 0 or 1; 0 by default.
    pub contacts: u32,
    /// Number of distinct exits to find: 1 to 100000; 1 by default.
    pub exits: usize,
    /// Number of descents to start: 1 to 100000; 0 by default, which means that the effort sets it.
    pub starts: usize,
    /// Share of the depth that need not be proved; the search stops when it is reached: 0 or more
    /// and less than 1; nan by default, which means that the effort sets it.
    pub gap: f64,
    /// Clearance to aim at for the witness: 0 to 1e9 \[m\]; nan by default, which means that of the
    /// scene.
    pub clearance: f64,
    /// Most collision checks and distance evaluations to spend: 0 or more; SIZE_MAX by default, for
    /// no limit.
    pub max_checks: usize,
    /// Most seconds to spend: more than 0; infinity by default, for no limit.
    pub max_seconds: f64,
    /// The names of joints that keep their positions in the query; null by default, for none.
    pub locked: *const *const c_char,
    /// Number of `locked` joints.
    pub locked_count: usize,
    /// The names of the joints that may move, in place of `locked`: all others keep their positions
    /// in the query; null by default, for all.
    pub free: *const *const c_char,
    /// Number of `free` joints.
    pub free_count: usize,
    /// One or several links that keep their places; null by default, for none. The text is the name
    /// of a link, or JSON: {"link": "tool0", "position": 1e-4, "rotation": 1e-3}, or an array of
    /// such objects. docs/how-to/constraints.md lists the keys.
    pub keep: *const c_char,
    /// The pairs of names of bodies that have to touch at the witness, one name after another; null
    /// by default, for none. Their distance is then at most 0.5 mm beyond the clearance.
    pub touch: *const *const c_char,
    /// Number of names in `touch`, which is even.
    pub touch_count: usize,
    /// Weights of joints, in place of those of the scene; null by default, for none. They prepare
    /// the scene anew, and a model is not used with them.
    pub weights: *const ExtricateWeight,
    /// Number of joints in `weights`.
    pub weight_count: usize,
    /// The goal, a configuration: among exits about as near as the nearest, the one nearest to the
    /// goal becomes the witness; null by default, for none.
    pub toward: *const f64,
    /// Number of coordinates of the goal: that of a configuration.
    pub toward_count: usize,
    /// An exit counts as about as near if it is farther than the nearest by at most this share of
    /// the nearest's depth: 0 to 1e9; 0.25 by default.
    pub toward_share: f64,
    /// Function that ends a query early if it returns true; null by default, for none. Queries call
    /// it between their steps, on any thread, and on several at once. It must not throw.
    pub stop: Option<unsafe extern "C" fn(*mut c_void) -> bool>,
    /// Argument that queries pass to `stop`.
    pub stop_data: *mut c_void,
}

/// Options of a stream. extricate_stream_options_init() fills in the defaults.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ExtricateStreamOptions {
    /// The stream keeps the exit of the last frame until another is nearer by more than this share
    /// of its depth: 0 or more and less than 1; 0 by default, which always uses the nearest.
    pub hysteresis: f64,
    /// Number of other starts that each frame tries; 2 by default.
    pub starts_per_frame: usize,
    /// Whether the witness is a proxy that never jumps: 0 or 1; 0 by default. From frame to frame a
    /// proxy only moves where every configuration on its way is proved free.
    pub continuous: u32,
}

/// The numbers of an answer.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateSummary {
    /// Distance from the query to the witness, in the scene's metric; 0 if the query is free,
    /// infinity if nothing free was found.
    pub depth: f64,
    /// Proved lower bound of the depth: no free configuration is nearer.
    pub lower_bound: f64,
    /// Share of the depth that is not proved.
    pub gap: f64,
    /// Largest displacement of any point of the robot, from the query to the witness \[m\].
    pub max_displacement: f64,
    /// Estimated share of starts that would lead to an exit that was not found; nan if unknown.
    pub unseen: f64,
    /// Clearance that the witness keeps \[m\], except for pairs with one of their own.
    pub clearance: f64,
    /// Proved radius around the witness within which nothing touches; nan if not requested.
    pub free_radius: f64,
    /// Fraction of the straight segment up to which a collision was found; nan if not requested.
    pub segment_colliding_until: f64,
    /// Fraction from which on the straight segment is proved free; nan if not requested.
    pub segment_free_from: f64,
    /// Depth of the nearest exit, if the witness is the proxy of a continuous stream, which may be
    /// farther; nan if it is not.
    pub nearest: f64,
    /// Collision checks and distance evaluations spent.
    pub checks: u64,
    /// EXTRICATE_IS_PROVED, or the reason why no lower bound is proved.
    pub unproved: u32,
    /// Whether there is a witness.
    pub found: bool,
    /// Whether the query itself is free.
    pub is_free: bool,
    /// Whether the exact checker found the witness free during this query.
    pub verified: bool,
    /// Whether no other distinct exit within 1 % of the depth was found.
    pub unique: bool,
    /// Whether a limit of checks or seconds, or a stop, ended the search before it was done.
    pub cut_short: bool,
    /// Whether the witness is the proxy of a continuous stream that goes back to the nearest exit
    /// along a path that was proved free.
    pub detour: bool,
}

/// Two bodies that must stay apart, as indices of bodies.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExtricatePair {
    /// The lower index.
    pub first: usize,
    /// The higher index.
    pub second: usize,
}

/// How far a kept link is off.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateKeptError {
    /// Distance of the link's origin from its place \[m\].
    pub position: f64,
    /// Angle of the link, or of its kept axis, from its orientation \[rad\].
    pub rotation: f64,
}

/// How far a configuration is from the boundary of the free ones.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateSignedDistance {
    /// Distance to the witness, in the scene's metric: negative if the configuration collides, else
    /// 0 or more. Infinity if nothing in contact was found, or nothing near enough; nan if the
    /// configuration collides and nothing free was found.
    pub distance: f64,
    /// Proved bound of the same sign: nothing nearer than this is on the other side; nan as
    /// `distance`.
    pub bound: f64,
    /// A pair that collides, or for a free configuration the pair that touches at the witness.
    /// Both indices are SIZE_MAX if there is none.
    pub pair: ExtricatePair,
    /// Configurations at which the exact checker evaluated anything.
    pub checks: u64,
    /// Whether a limit of checks or seconds, or a stop, ended the search before it was done.
    pub cut_short: bool,
}

/// A contact of two bodies at a witness, in world coordinates.
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
    /// A free configuration, with as many numbers as the query. It lives as long as the answer.
    pub witness: *const f64,
}

/// Result of the check of a segment between two configurations. Fractions are of its length.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtricateSegment {
    /// Whether every configuration of the segment is proved free.
    pub is_free: bool,
    /// Whether a collision was found. If neither this nor `is_free` is set, only `free_until` is
    /// proved.
    pub collides: bool,
    /// Fraction up to which every configuration is proved free.
    pub free_until: f64,
    /// Fraction at which a configuration collides, or nearly collides if `collides` is not set; nan
    /// if the segment is free.
    pub at: f64,
    /// The bodies that collide there, or nearly do; both indices are SIZE_MAX if the segment is
    /// free.
    pub pair: ExtricatePair,
}
