//! Fitted numbers of these tests, in the order of their files. No guarantee implies these bounds;
//! they come from what the program measured when a test was written. Numbers that follow from a
//! guarantee, a closed form or rounding stay in their test. Docs name the measured figure if it was
//! written down.
//!
//! A change that makes a figure worse has to change its bound here, with the reason in its commit.
//! A change that makes a figure better should tighten the bound.

use std::ops::Range;

// allocations.rs

/// A repeated list of queries allocates only its answers after fewer passes than this.
pub const ALLOCATION_WARM_UP_PASSES: usize = 6;

// analytic.rs, rigid.rs

/// More than this share of drawn queries collides in each scene with depths in closed form.
pub const ANALYTIC_COLLIDING_SHARE: f64 = 0.05;

// beyond_limits.rs

/// At most this share of depths beyond joint limits is 1 % above that of a long search.
pub const BEYOND_LIMITS_MISSED_SHARE: f64 = 0.04;

// budgets.rs

/// Learning about the planar arm finds something free with at least this many labels.
pub const SOMETHING_FREE_LABELS: usize = 10;
/// Learning about the planar arm finds a boundary with at least this many labels.
pub const BOUNDARY_FOUND_LABELS: usize = 100;
/// Learning spends nearly all labels of a budget of at least this many.
pub const SPENT_BUDGET_LABELS: usize = 5000;
/// Learning spends more than this share of a budget of at least `SPENT_BUDGET_LABELS`.
pub const SPENT_LABELS_SHARE: f64 = 0.9;
/// Learning ends with more boundary samples than this, however little time it has.
pub const LITTLE_TIME_BOUNDARY_SAMPLES: usize = 10;

// claims.rs

/// More than this many of 720 answers along drawn motions report that something moves.
pub const MOVED_ANSWERS: usize = 200;
/// At most this share of frames jumps in depth; with 2,000 frames a scene 28 of 11,880 did.
pub const DEPTH_JUMPS_SHARE: f64 = 0.005;

// components.rs

/// Fewer than this many of 200,000 configurations lie in the small components of two wheels.
pub const SMALL_COMPONENTS_CONFIGS: usize = 4000;
/// With 3,000 labels and fixed hubs, at least this many of 4 x 25 components are found.
pub const FIXED_HUBS_3000_LABELS_COMPONENTS: usize = 90;
/// With 10,000 labels and fixed hubs, at least this many of 4 x 25 components are found.
pub const FIXED_HUBS_10000_LABELS_COMPONENTS: usize = 98;
/// With 3,000 labels and sliding hubs, at least this many of 4 x 25 components are found.
pub const SLIDING_HUBS_3000_LABELS_COMPONENTS: usize = 58;
/// With 10,000 labels and sliding hubs, at least this many of 4 x 25 components are found.
pub const SLIDING_HUBS_10000_LABELS_COMPONENTS: usize = 86;

// constraints.rs

/// At least this share of depths under a wider clearance is within 1 % with and without a model.
pub const CLEARANCE_AS_NEAR_SHARE: f64 = 0.94;
/// More than this many of 90 answers with locked joints have an exit.
pub const LOCKED_FOUND_ANSWERS: usize = 60;
/// More than this many of 90 answers with locked joints have no exit, and there is none.
pub const LOCKED_NONE_ANSWERS: usize = 3;
/// More than this many of 50 frames of a stream with locked joints collide.
pub const LOCKED_STREAM_COLLIDING_FRAMES: usize = 20;
/// A goal chooses another exit than the nearest for more than this share of queries.
pub const GOAL_OTHER_EXIT_SHARE: f64 = 0.05;
/// More than this many of 2,400 configurations collide some 30 free radii away.
pub const FREE_RADIUS_COLLIDING_CONFIGS: usize = 10;
/// Under weights the exit is at most this many times as far as what was nearest without them.
pub const WEIGHTED_DEPTH_RATIO: f64 = 1.01;
/// With a heavy first joint, more than this many of 60 exits rotate it less than half as far.
pub const WEIGHTED_TURNED_LESS_EXITS: usize = 15;
/// With a heavy first joint, fewer than this many of 60 exits rotate it more than twice as far.
pub const WEIGHTED_TURNED_MORE_EXITS: usize = 5;

// hostile.rs

/// A hostile file is read or refused in fewer seconds, also on a machine that is busy.
pub const HOSTILE_FILE_SECONDS: u64 = 20;

// learned_classifier.rs

/// The balanced accuracy of 20,000 labels of the shelf arm is slightly above this share.
pub const SHELF_ARM_ACCURACY_SHARE: f64 = 0.955;
/// The balanced accuracy of 20,000 labels of the hand is slightly above this share.
pub const HAND_ACCURACY_SHARE: f64 = 0.965;
/// The accuracy that a model states differs by less than this share from that on new queries.
pub const STATED_ACCURACY_DIFFERENCE_SHARE: f64 = 0.025;

// meshes.rs

/// More than this many of 400 drawn configurations lie in the walls of a room.
pub const ROOM_COLLIDING_CONFIGS: usize = 60;
/// A bound in the walls of a room counts if it is above this share of the depth.
pub const ROOM_BOUND_OF_DEPTH_SHARE: f64 = 0.3;
/// More than this many of the two bounds of a query in the walls of a room count on average.
pub const ROOM_BOUNDS_PER_QUERY: f64 = 0.5;
/// An L of two bars is cut into at most this many convex parts.
pub const L_CONVEX_PARTS: usize = 8;

// narrow_places.rs

/// An escape to the near exit of a gap or slot takes fewer checks than this.
pub const NARROW_ESCAPE_CHECKS: usize = 500;
/// A repair to the near exit of a gap takes fewer checks than this.
pub const NARROW_REPAIR_CHECKS: usize = 1000;
/// A query that gives up clearance takes at most this many checks beyond its budget.
pub const GIVEN_UP_CLEARANCE_OVERDRAWN_CHECKS: usize = 40;
/// Streams of arms that begin in collision keep more than this of the aimed 0.6 mm.
pub const ARM_STREAM_CLEARANCE_METRES: f64 = 1.2e-4;
/// A repair of a spike, which has to deviate by 0.2 m, deviates by less than this.
pub const SPIKE_REPAIR_DEVIATION_METRES: f64 = 0.25;
/// A repair over a box, which has to deviate by 0.35 m, is found within this deviation.
pub const BOX_REPAIR_DEVIATION_METRES: f64 = 0.4;

// no_model.rs

/// At most this share of depths without a model is 5 % above that of a long search.
pub const NO_MODEL_MISSED_SHARE: f64 = 0.05;
/// More than this many of 40 queries for three exits without a model have several.
pub const NO_MODEL_SEVERAL_EXITS_QUERIES: usize = 20;
/// At least this many of 100 frames of a stream without a model are within 5 % of single queries.
pub const NO_MODEL_STREAM_AS_NEAR_FRAMES: usize = 90;

// other_robots.rs

/// At least this many of 40 refined depths of a planar base are within 1 % of exhaustive ones.
pub const PLANAR_BASE_AS_NEAR_ANSWERS: usize = 36;
/// At least this many of 20 refined depths of 20 joints are within 1 % of exhaustive ones.
pub const TWENTY_JOINTS_AS_NEAR_ANSWERS: usize = 16;

// property.rs

/// More than this many of 200 drawn configurations of every scene collide.
pub const PROPERTY_COLLIDING_CONFIGS: usize = 3;
/// More than this many of 300 boundary samples have a collision within the gap.
pub const BOUNDARY_BESIDE_SAMPLES: usize = 270;

// proved.rs

/// The bound of 80 checks is at least this share of the bound of 40 checks.
pub const PROVED_BOUND_KEPT_SHARE: f64 = 0.97;
/// A gap of 5 % closes within 80 checks for more than this share of queries.
pub const PROVED_GAPS_CLOSED_SHARE: f64 = 0.1;

// query.rs

/// More exits than this are found by 24 queries for four exits each.
pub const SEVERAL_EXITS_FOUND_EXITS: usize = 40;
/// More exits than this are found by 200 queries for six exits with 40 checks each.
pub const BUDGET_FOUND_EXITS: usize = 300;
/// A query that its caller stops takes less than this share of the checks of a full one.
pub const STOPPED_CHECKS_SHARE: f64 = 0.2;
/// At most this many slopes of eight largest displacements differ from the gradient, at kinks.
pub const GRADIENT_KINKS_SLOPES: usize = 8;
/// The gradient is the slope of the depth for at least this many of eight queries.
pub const GRADIENT_OF_DEPTH_QUERIES: usize = 6;
/// The straight segment to an exit collides for more than this share of its length.
pub const SEGMENT_COLLIDING_SHARE: f64 = 0.5;
/// More than this many of 40 queries of a scene have several colliding pairs.
pub const SEVERAL_PAIRS_QUERIES: usize = 3;

// query_changed.rs

/// After a change far away, queries take less than this many times the checks of before.
pub const FAR_CHANGE_CHECKS_RATIO: f64 = 1.5;
/// After a change far away, at least this many of 150 answers are as near as before.
pub const FAR_CHANGE_AS_NEAR_ANSWERS: usize = 145;
/// Without an obstacle, at least this many of 150 answers are nearer than with it.
pub const OBSTACLE_GONE_NEARER_ANSWERS: usize = 3;
/// Without an obstacle, at least this many of 150 answers are as near as learned anew.
pub const OBSTACLE_GONE_AS_NEAR_ANSWERS: usize = 144;
/// Without an obstacle, queries take less than this many times the checks of learning anew.
pub const OBSTACLE_GONE_CHECKS_RATIO: f64 = 2.0;
/// An added obstacle takes at least this many of 150 exits.
pub const OBSTACLE_ADDED_TAKEN_EXITS: usize = 5;
/// With an added obstacle, at least this many of 150 answers are as near as learned anew.
pub const OBSTACLE_ADDED_AS_NEAR_ANSWERS: usize = 141;
/// Under a larger clearance, queries take less than this many times the checks of before.
pub const LARGER_CLEARANCE_CHECKS_RATIO: f64 = 2.0;

// query_elsewhere.rs

/// At least this percentage of the planar arm's frames is within 1 % of a single query.
pub const PLANAR_ARM_STREAM_AS_NEAR_PERCENT: usize = 85;
/// At least this percentage of the free box's frames is within 1 % of a single query.
pub const FREE_BOX_STREAM_AS_NEAR_PERCENT: usize = 70;
/// More than this many of 180 frames of a stream collide.
pub const STREAM_COLLIDING_FRAMES: usize = 60;
/// Single queries take more than this many times the checks of a stream.
pub const ALONE_TO_STREAM_CHECKS_RATIO: f64 = 1.9;
/// At least this many of six streams that stand still are as near as a single query.
pub const STREAM_SETTLED_PLACES: usize = 2;
/// With solved samples, a shelf-arm stream takes below this percentage of single queries' checks.
pub const SHELF_ARM_EXITS_STREAM_CHECKS_PERCENT: usize = 40;
/// With solved samples, a hand stream takes below this percentage of single queries' checks.
pub const HAND_EXITS_STREAM_CHECKS_PERCENT: usize = 110;
/// A model for streams has more solved samples than this, as many as a single query starts from.
pub const EXITS_STREAM_SOLVED_SAMPLES: usize = 1600;
/// At most this share of a model's frames with solved samples is 1 % farther than single queries.
pub const EXITS_STREAM_FARTHER_SHARE: f64 = 0.05;
/// At least this share of frames is within 5 % of single queries while an obstacle moves.
pub const MOVING_OBSTACLE_AS_NEAR_SHARE: f64 = 0.9;
/// Hysteresis keeps exits that are at most this many times as far as its share allows.
pub const HYSTERESIS_DEPTH_RATIO: f64 = 1.02;
/// At least this many of 60 queries have two exits that are about as near.
pub const HYSTERESIS_QUERIES: usize = 2;
/// Without hysteresis, a stream changes exits more than this many times as often as with it.
pub const HYSTERESIS_TURNS_RATIO: usize = 3;
/// In a changed scene, at least this many of 25 answers are within 5 % of those learned anew.
pub const CHANGED_SCENE_AS_NEAR_ANSWERS: usize = 22;
/// A first witness in a changed scene takes at most this many checks, but for those that end it.
pub const FIRST_WITNESS_CHECKS: usize = 120;
/// For some query, the nearest free sample ranks at least this far among all samples.
pub const FIRST_FREE_SAMPLE_RANK: usize = 50;

// rigid.rs

/// Depths of a peg at a block's faces err by less than this; 4.1e-4 was measured.
pub const PEG_DEPTH_ERROR_METRES: f64 = 5e-4;
/// At least this many of 120 refined depths in the hole are within 0.01; 117 were.
pub const PEG_IN_HOLE_REFINED_ANSWERS: usize = 108;
/// At least this many of 120 exhaustive depths in the hole are within 0.01; all were.
pub const PEG_IN_HOLE_EXHAUSTIVE_ANSWERS: usize = 118;

// scene_edits.rs

/// The bound under a pair's own clearance is above this, for a depth of 0.01 m.
pub const PAIR_CLEARANCE_BOUND_METRES: f64 = 0.005;

// scenery.rs

/// More than this share of configurations collides with a cloud of points.
pub const CLOUD_COLLIDING_SHARE: f64 = 0.025;
/// More than this share of configurations collides with a map of voxels.
pub const VOXELS_COLLIDING_SHARE: f64 = 0.05;
/// A query among scenery allocates at most this many times.
pub const SCENERY_QUERY_ALLOCATIONS: u64 = 8;
/// This many of 3,000 configurations collide with a closed mesh of the ground.
pub const GROUND_COLLIDING_CONFIGS: Range<usize> = 100..2_900;
/// This many of 3,000 configurations collide with a half-space.
pub const HALF_SPACE_COLLIDING_CONFIGS: Range<usize> = 200..2_950;

// scenery_queries.rs

/// Below waves, the bound is above this share of the depth.
pub const WAVES_BOUND_SHARE: f64 = 0.9;
/// At most this many of 40 exits from one body of voxels are 5 % farther than from boxes.
pub const VOXEL_MAP_FARTHER_EXITS: usize = 6;
/// The median exit from one body of voxels is less than this many times as far as from boxes.
pub const VOXEL_MAP_MEDIAN_DEPTH_RATIO: f64 = 1.01;
/// More than this many of 200 configurations collide in a learned map.
pub const LEARNED_MAP_COLLIDING_CONFIGS: usize = 10;

// spoiled.rs

/// At least this many of 20 answers reveal each spoiled claim.
pub const SPOILED_NOTICED_ANSWERS: usize = 10;

// tightness.rs

/// The mean of bound over depth is at least this for `refined` and `nearest`; measured beside.
pub const BOUND_OF_DEPTH_SHARES: [(&str, f64, f64); 6] = [
    ("shelf-arm", 0.277, 0.177),  // measured: 0.2806 and 0.1809
    ("planar-arm", 0.697, 0.592), // 0.7031 and 0.6012
    ("free-box", 0.503, 0.255),   // 0.5094 and 0.2604
    ("dual-arm", 0.297, 0.166),   // 0.3019 and 0.1698
    ("hand", 0.522, 0.350),       // 0.5271 and 0.3572
    ("four-legs", 0.449, 0.207),  // 0.4540 and 0.2119
];
