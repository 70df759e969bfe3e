/* The C interface of extricate. Written by cbindgen from crates/extricate-c/src/abi, do not edit:
 * UPDATE_HEADER=1 cargo test -p extricate-c --test header
 *
 * Every function that can fail returns an ExtricateStatus. If that is not EXTRICATE_OK,
 * extricate_last_error() says what is wrong. Handles belong to the caller, who frees each of them
 * once, with the function of its type; null may be given there. No handle has to outlive another: a
 * solver keeps its scene. Any number of threads may use one scene, solver, hand or result at the
 * same time; only extricate_solver_set_options() needs a solver for itself. A stream and a roadmap
 * are for one thread at a time. Strings are UTF-8 and end with a zero. Lengths are in metres, angles in radians.
 *
 * Pointers must be null or valid, as in every C interface: a handle that was freed, or an array that
 * is shorter than was said, is not noticed. A null pointer, or a wrong length that can be seen,
 * gives EXTRICATE_ARGUMENT. */

#ifndef EXTRICATE_H
#define EXTRICATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// There is a result.
#define EXTRICATE_OK 0

// Nothing free was found, but the call is valid.
#define EXTRICATE_NOTHING_FREE 1

// An argument is a null pointer, has a wrong length, or is an invalid option.
#define EXTRICATE_ARGUMENT 2

// A configuration has a wrong length, is not finite, or is beyond limits that the call enforces.
#define EXTRICATE_CONFIGURATION 3

// A file cannot be read or written.
#define EXTRICATE_FILE 4

// A scene, robot, mesh or world has invalid content, or a name is unknown.
#define EXTRICATE_INPUT 5

// A model file is truncated, altered, foreign or of another version.
#define EXTRICATE_MODEL 6

// The library caught an internal error.
#define EXTRICATE_INTERNAL 7

// Version of this interface. It increases if programs have to be recompiled.
#define EXTRICATE_ABI 2

// Effort: the nearest stored sample of a model; without a model, the first exit that is found.
#define EXTRICATE_NEAREST 0

// Effort: descents from several starts in different directions; the best end is verified.
#define EXTRICATE_REFINED 1

// Effort: many starts and long refinement.
#define EXTRICATE_EXHAUSTIVE 2

// Effort: like refined, and then branch and bound until the gap is proved or a limit is reached.
#define EXTRICATE_PROVED 3

// Effort: like refined with fewer descents, which takes about half the checks.
#define EXTRICATE_QUICK 4

// Metric: the weighted change of the joints [rad or m].
#define EXTRICATE_METRIC_JOINT 0

// Metric: the root mean square displacement of the robot's solids [m].
#define EXTRICATE_METRIC_OBJECT_NORM 1

// Metric: the largest displacement of any point of the robot [m].
#define EXTRICATE_METRIC_MAX_DISPLACEMENT 2

// A lower bound above 0 is proved, or the query is free.
#define EXTRICATE_IS_PROVED 0

// No lower bound is proved, because the colliding bodies are surfaces, which enclose nothing.
#define EXTRICATE_UNPROVED_SURFACES 1

// No lower bound is proved, because the bodies overlap too little.
#define EXTRICATE_UNPROVED_SHALLOW 2

// Nothing is proved: nothing collides, and a kept link is off.
#define EXTRICATE_UNPROVED_OFF 3

// Shape: a box; `size` holds its full sides [m].
#define EXTRICATE_BOX 0

// Shape: a ball; `size[0]` is its radius [m].
#define EXTRICATE_SPHERE 1

// Shape: a cylinder along z; `size` holds its radius and its length [m].
#define EXTRICATE_CYLINDER 2

// Shape: a capsule along z; `size` holds radius and length of its cylindrical part [m].
#define EXTRICATE_CAPSULE 3

// Shape: a mesh; `points` are its corners [m], and each of `triangles` joins three of them.
#define EXTRICATE_MESH 4

// Shape: balls of radius `size[0]` around `points` [m]; for obstacles only.
#define EXTRICATE_POINTS 5

// Shape: occupied `cells` of side `size[0]` [m]; for obstacles only.
#define EXTRICATE_VOXELS 6

// Shape: everything behind a plane of normal `size` at `offset` [m] along it; for obstacles
// only.
#define EXTRICATE_HALF_SPACE 7

// Shape: ground whose heights are given on a grid, with cells of side `size[0]` [m]; for
// obstacles only. `heights` are its rows along x, one after the other [m], of `columns` each.
#define EXTRICATE_HEIGHT_FIELD 8

// Samples: free and colliding ones.
#define EXTRICATE_ANY 0

// Samples: free ones alone.
#define EXTRICATE_FREE 1

// Samples: colliding ones alone.
#define EXTRICATE_COLLIDING 2

// Escape: no step found a path.
#define EXTRICATE_ESCAPE_NONE 0

// Escape: the query is free.
#define EXTRICATE_ESCAPE_FREE 1

// Escape: the path is a straight edge to the nearest exit.
#define EXTRICATE_ESCAPE_NEAREST 2

// Escape: the path is a straight edge to another exit.
#define EXTRICATE_ESCAPE_EXIT 3

// Escape: the path separates the colliding pairs step by step.
#define EXTRICATE_ESCAPE_PUSHED 4

// Escape: trees that grew toward each other found the path.
#define EXTRICATE_ESCAPE_GROWN 5

// Plan: no step found a path.
#define EXTRICATE_PLAN_NONE 0

// Plan: the free part is the straight edge between its ends.
#define EXTRICATE_PLAN_STRAIGHT 1

// Plan: trees from both ends found the free part.
#define EXTRICATE_PLAN_TREES 2

// Plan: the free part goes through the roadmap.
#define EXTRICATE_PLAN_ROADMAP 3

// A release keeps the contacts of the links that touched.
#define EXTRICATE_KEEP_CONTACTS 0

// A release keeps the pose alone: the nearest free configuration, whatever it touches.
#define EXTRICATE_KEEP_POSE 1

// The answer to a query. It never changes, and pointers into it stay valid until it is freed.
typedef struct ExtricateAnswer ExtricateAnswer;

// Contacts of bodies that are near each other. They never change, and pointers to them stay valid
// until they are freed.
typedef struct ExtricateContacts ExtricateContacts;

// A path out of collision. It never changes, and pointers into it stay valid until it is freed.
typedef struct ExtricateEscape ExtricateEscape;

// A configuration of a hand that holds an object and penetrates nothing. It never changes, and
// pointers into it stay valid until it is freed.
typedef struct ExtricateGrasp ExtricateGrasp;

// A hand that can hold one obstacle of a scene. It never changes.
typedef struct ExtricateHand ExtricateHand;

// The triangles of a body. It never changes, and pointers into it stay valid until it is freed.
typedef struct ExtricateMesh ExtricateMesh;

// A path between two configurations. It never changes, and pointers into it stay valid until it is
// freed.
typedef struct ExtricatePlan ExtricatePlan;

// Positions by joint. They never change, and pointers to them stay valid until they are freed.
typedef struct ExtricatePositions ExtricatePositions;

// A free path in place of one that collides. It never changes, and pointers into it stay valid
// until it is freed.
typedef struct ExtricateRepaired ExtricateRepaired;

// Free configurations and proved edges between them, which plans add to and reuse.
typedef struct ExtricateRoadmap ExtricateRoadmap;

// A scene, perhaps with a model that was learned from it or from a similar scene. It never
// changes.
typedef struct ExtricateScene ExtricateScene;

// A scene with query options. Only extricate_solver_set_options() changes it.
typedef struct ExtricateSolver ExtricateSolver;

// A sequence of queries that are near each other. Each query starts from the exit of the one
// before.
typedef struct ExtricateStream ExtricateStream;

// Status that a function returns: EXTRICATE_OK, or the reason why there is no result.
typedef int32_t ExtricateStatus;

// Two bodies that must stay apart, as indices of bodies.
typedef struct ExtricatePair {
    // The lower index.
    size_t first;
    // The higher index.
    size_t second;
} ExtricatePair;

// A limit of what files may hold.
typedef struct ExtricateLoadLimit {
    // Name of the limit, such as "triangles"; docs/reference/limits.md lists them.
    const char *name;
    // The most that files may hold.
    size_t most;
} ExtricateLoadLimit;

// How files are loaded. Members that are null and 0 stand for the defaults.
typedef struct ExtricateLoadOptions {
    // Folders in which `package://NAME/...` is looked up first; null for none.
    const char *const *packages;
    // Number of folders in `packages`.
    size_t package_count;
    // Limits in place of the default ones; null for none.
    const struct ExtricateLoadLimit *limits;
    // Number of limits in `limits`.
    size_t limit_count;
} ExtricateLoadOptions;

// A text that replaces a file that a scene names.
typedef struct ExtricateText {
    // The path, as the scene spells it.
    const char *path;
    // The content of the file.
    const char *text;
} ExtricateText;

// The state of a learning run.
typedef struct ExtricateProgress {
    // The current step: "exploring", "training", "tracing the boundary", "solving" or "measuring".
    // It lives as long as the call of the function that gets it.
    const char *stage;
    // Share of the budget spent, 0 to 1.
    double fraction;
    // Labels (exact checks) spent.
    size_t labels;
    // Number of boundary samples found.
    size_t boundary_samples;
    // Held-out balanced accuracy of the last classifier; nan before the first.
    double accuracy;
} ExtricateProgress;

// The pose of a body.
typedef struct ExtricatePose {
    // x, y, z [m].
    double position[3];
    // Unit quaternion x, y, z, w.
    double quaternion[4];
} ExtricatePose;

// One shape. Members that its kind does not name are not read.
typedef struct ExtricateShape {
    // EXTRICATE_BOX or another of the kinds.
    uint32_t kind;
    // Sizes, whose meaning depends on `kind`.
    double size[3];
    // Position of the plane of a half-space along its unit normal [m].
    double offset;
    // Points, three numbers each [m].
    const double *points;
    // Number of `points`.
    size_t point_count;
    // Triangles, three indices of points each.
    const uint32_t *triangles;
    // Number of `triangles`.
    size_t triangle_count;
    // Cells, three indices each.
    const int32_t *cells;
    // Number of `cells`.
    size_t cell_count;
    // Whether to use the convex hull of a mesh: 0 or 1.
    uint32_t convex;
    // Heights of a height field, row by row [m].
    const double *heights;
    // Number of heights in `heights`.
    size_t height_count;
    // Number of heights of a row.
    size_t columns;
} ExtricateShape;

// An obstacle, or an object that a link holds.
typedef struct ExtricateObstacle {
    // Its name, which must be unique in the scene.
    const char *name;
    // Its shape.
    struct ExtricateShape shape;
    // Its pose in the world; for an object that a link holds, in the coordinates of the link.
    struct ExtricatePose pose;
} ExtricateObstacle;

// The weights of a joint in the joint metric.
typedef struct ExtricateWeight {
    // Name of the joint.
    const char *joint;
    // Weight of squared displacements.
    double translation;
    // Weight of squared rotations of a floating or planar base; that of its other coordinates is
    // `translation`. For other joints both are the same number.
    double rotation;
} ExtricateWeight;

// Options of a query. extricate_options_init() fills in the defaults; then set the members that
// differ. In a member that is 0 or 1, any other number counts as 1.
typedef struct ExtricateOptions {
    // How hard to search: EXTRICATE_NEAREST, _QUICK, _REFINED, _EXHAUSTIVE or _PROVED;
    // EXTRICATE_REFINED by default.
    uint32_t effort;
    // Whether to refuse configurations beyond the limits instead of answering them: 0 or 1; 0 by
    // default.
    uint32_t refuse_outside;
    // Whether to prove a radius around the witness within which nothing touches: 0 or 1; 0 by
    // default.
    uint32_t free_radius;
    // Whether to report how much of the straight segment to the witness collides: 0 or 1; 0 by
    // default.
    uint32_t segment;
    // Whether to report contacts with EXTRICATE_NEAREST as well; the other efforts always report
    // them: 0 or 1; 0 by default.
    uint32_t contacts;
    // Number of distinct exits to find: 1 to 100000; 1 by default.
    size_t exits;
    // Number of descents to start: 1 to 100000; 0 by default, which means that the effort sets it.
    size_t starts;
    // Share of the depth that need not be proved; the search stops when it is reached: 0 or more
    // and less than 1; nan by default, which means that the effort sets it.
    double gap;
    // Clearance to aim at for the witness: 0 to 1e9 [m]; nan by default, which means that of the
    // scene.
    double clearance;
    // Most collision checks and distance evaluations to spend: 0 or more; SIZE_MAX by default, for
    // no limit.
    size_t max_checks;
    // Most seconds to spend: more than 0; infinity by default, for no limit.
    double max_seconds;
    // The names of joints that keep their positions in the query; null by default, for none.
    const char *const *locked;
    // Number of `locked` joints.
    size_t locked_count;
    // The names of the joints that may move, in place of `locked`: all others keep their positions
    // in the query; null by default, for all.
    const char *const *free;
    // Number of `free` joints.
    size_t free_count;
    // One or several links that keep their places; null by default, for none. The text is the name
    // of a link, or JSON: {"link": "tool0", "position": 1e-4, "rotation": 1e-3}, or an array of
    // such objects. docs/how-to/constraints.md lists the keys.
    const char *keep;
    // The pairs of names of bodies that have to touch at the witness, one name after another; null
    // by default, for none. Their distance is then at most 0.5 mm beyond the clearance.
    const char *const *touch;
    // Number of names in `touch`, which is even.
    size_t touch_count;
    // Weights of joints, in place of those of the scene; null by default, for none. They prepare
    // the scene anew, and a model is not used with them.
    const struct ExtricateWeight *weights;
    // Number of joints in `weights`.
    size_t weight_count;
    // The goal, a configuration: among exits about as near as the nearest, the one nearest to the
    // goal becomes the witness; null by default, for none.
    const double *toward;
    // Number of coordinates of the goal: that of a configuration.
    size_t toward_count;
    // An exit counts as about as near if it is farther than the nearest by at most this share of
    // the nearest's depth: 0 to 1e9; 0.25 by default.
    double toward_share;
    // Function that ends a query early if it returns true; null by default, for none. Queries call
    // it between their steps, on any thread, and on several at once. It must not throw.
    bool (*stop)(void*);
    // Argument that queries pass to `stop`.
    void *stop_data;
} ExtricateOptions;

// The numbers of an answer.
typedef struct ExtricateSummary {
    // Distance from the query to the witness, in the scene's metric; 0 if the query is free,
    // infinity if nothing free was found.
    double depth;
    // Proved lower bound of the depth: no free configuration is nearer.
    double lower_bound;
    // Share of the depth that is not proved.
    double gap;
    // Largest displacement of any point of the robot, from the query to the witness [m].
    double max_displacement;
    // Estimated share of starts that would lead to an exit that was not found; nan if unknown.
    double unseen;
    // Clearance that the witness keeps [m], except for pairs with one of their own.
    double clearance;
    // Proved radius around the witness within which nothing touches; nan if not requested.
    double free_radius;
    // Fraction of the straight segment up to which a collision was found; nan if not requested.
    double segment_colliding_until;
    // Fraction from which on the straight segment is proved free; nan if not requested.
    double segment_free_from;
    // Depth of the nearest exit, if the witness is the proxy of a continuous stream, which may be
    // farther; nan if it is not.
    double nearest;
    // Collision checks and distance evaluations spent.
    uint64_t checks;
    // EXTRICATE_IS_PROVED, or the reason why no lower bound is proved.
    uint32_t unproved;
    // Whether there is a witness.
    bool found;
    // Whether the query itself is free.
    bool is_free;
    // Whether the exact checker found the witness free during this query.
    bool verified;
    // Whether no other distinct exit within 1 % of the depth was found.
    bool unique;
    // Whether a limit of checks or seconds, or a stop, ended the search before it was done.
    bool cut_short;
    // Whether the witness is the proxy of a continuous stream that goes back to the nearest exit
    // along a path that was proved free.
    bool detour;
} ExtricateSummary;

// How far a kept link is off.
typedef struct ExtricateKeptError {
    // Distance of the link's origin from its place [m].
    double position;
    // Angle of the link, or of its kept axis, from its orientation [rad].
    double rotation;
} ExtricateKeptError;

// A contact of two bodies at a witness, in world coordinates.
typedef struct ExtricateContact {
    // The bodies.
    struct ExtricatePair pair;
    // Signed distance of the points [m]; negative if the bodies overlap.
    double distance;
    // Point on the first body [m].
    double point_first[3];
    // Point on the second body [m].
    double point_second[3];
    // Unit vector from the second body toward the first.
    double normal[3];
} ExtricateContact;

// One of several exits.
typedef struct ExtricateExit {
    // Distance from the query to the witness, in the scene's metric.
    double depth;
    // A free configuration, with as many numbers as the query. It lives as long as the answer.
    const double *witness;
} ExtricateExit;

// Result of the check of a segment between two configurations. Fractions are of its length.
typedef struct ExtricateSegment {
    // Whether every configuration of the segment is proved free.
    bool is_free;
    // Whether a collision was found. If neither this nor `is_free` is set, only `free_until` is
    // proved.
    bool collides;
    // Fraction up to which every configuration is proved free.
    double free_until;
    // Fraction at which a configuration collides, or nearly collides if `collides` is not set; nan
    // if the segment is free.
    double at;
    // The bodies that collide there, or nearly do; both indices are SIZE_MAX if the segment is
    // free.
    struct ExtricatePair pair;
} ExtricateSegment;

// How far a configuration is from the boundary of the free ones.
typedef struct ExtricateSignedDistance {
    // Distance to the witness, in the scene's metric: negative if the configuration collides, else
    // 0 or more. Infinity if nothing in contact was found, or nothing near enough; nan if the
    // configuration collides and nothing free was found.
    double distance;
    // Proved bound of the same sign: nothing nearer than this is on the other side; nan as
    // `distance`.
    double bound;
    // A pair that collides, or for a free configuration the pair that touches at the witness.
    // Both indices are SIZE_MAX if there is none.
    struct ExtricatePair pair;
    // Configurations at which the exact checker evaluated anything.
    uint64_t checks;
    // Whether a limit of checks or seconds, or a stop, ended the search before it was done.
    bool cut_short;
} ExtricateSignedDistance;

// Options of a stream. extricate_stream_options_init() fills in the defaults.
typedef struct ExtricateStreamOptions {
    // The stream keeps the exit of the last frame until another is nearer by more than this share
    // of its depth: 0 or more and less than 1; 0 by default, which always uses the nearest.
    double hysteresis;
    // Number of other starts that each frame tries; 2 by default.
    size_t starts_per_frame;
    // Whether the witness is a proxy that never jumps: 0 or 1; 0 by default. From frame to frame a
    // proxy only moves where every configuration on its way is proved free.
    uint32_t continuous;
} ExtricateStreamOptions;

// Options of extricate_escape(). extricate_escape_options_init() fills in the defaults; then set
// the members that differ.
typedef struct ExtricateEscapeOptions {
    // Clearance that the end of the path should keep: 0 to 1e9 [m]; nan by default, which means
    // that of the scene plus 1 mm. A near end with less clearance is preferred to a far one.
    double aim;
    // Depth by which a pair that collides at the query may get deeper on the path: 0 to 1e9 [m];
    // 1e-3 by default.
    double tolerance;
    // Links that keep their places at the query, or at given poses, all along the path, as in
    // ExtricateOptions; null by default, for none.
    const char *keep;
    // Goal of a later motion, a configuration: of exits that are about as near, the one nearest to
    // it is preferred; null by default, for none.
    const double *toward;
    // Number of coordinates of the goal: that of a configuration.
    size_t toward_count;
    // Number of exits to which straight edges are tried: 0 to 100000; 6 by default.
    size_t exits;
    // Resolution at which edges are proved: 0 to 1e9 [m]; 1e-4 by default.
    double resolution;
    // Most checks of the trees, which grow only if nothing simpler leads out of collision: 20000
    // by default.
    size_t tree_checks;
    // Seed of all random numbers; 0 by default.
    uint64_t seed;
    // Most checks to spend; SIZE_MAX by default, for no limit.
    size_t max_checks;
    // Most seconds to spend: more than 0; infinity by default, for no limit.
    double max_seconds;
    // Function that ends the call early if it returns true, as in ExtricateOptions; null by
    // default, for none.
    bool (*stop)(void*);
    // Argument that the call passes to `stop`.
    void *stop_data;
} ExtricateEscapeOptions;

// The numbers of an escape.
typedef struct ExtricateEscapeSummary {
    // Whether a path was found.
    bool found;
    // The step that found the path: EXTRICATE_ESCAPE_NONE or another.
    uint32_t method;
    // Index of the point from which on the path is proved free.
    size_t free_from;
    // Most that any pair that collides at the query was found deeper than there [m]. It is
    // proved to be at most the tolerance.
    double deepening;
    // Least of 1, 2, 5 and 10 mm with which, as a larger tolerance, a path is found [m]. It is
    // nan if a path was found, or if none is found with these either.
    double needed_tolerance;
    // Length of the path in the scene's metric.
    double length;
    // Largest displacement of any point of the robot from the query to any point of the path
    // [m].
    double max_displacement;
    // Number of configurations at which the exact checker evaluated anything.
    uint64_t checks;
} ExtricateEscapeSummary;

// A pair of bodies and its signed distance.
typedef struct ExtricatePairDistance {
    // The two bodies of the pair.
    struct ExtricatePair pair;
    // Signed distance [m]; negative if the bodies overlap.
    double distance;
} ExtricatePairDistance;

// Options of extricate_plan(). extricate_plan_options_init() fills in the defaults; then set the
// members that differ.
typedef struct ExtricatePlanOptions {
    // Resolution at which edges are proved: 0 to 1e9 [m]; 1e-4 by default.
    double resolution;
    // Depth by which a pair that collides at an end may get deeper on the path: 0 to 1e9 [m];
    // 1e-3 by default.
    double tolerance;
    // Links that keep their places at the start, or at given poses, all along the path, as in
    // ExtricateOptions; null by default, for none. Such plans neither use nor extend a roadmap.
    const char *keep;
    // Clearance to which the points of the free part are pushed off: 0 to 1e9 [m]; nan by
    // default, which leaves the path short. With `keep` it has to be nan.
    double clearance;
    // Whether to shorten the path: 0 or 1; 1 by default.
    uint32_t shortcut;
    // Seed of all random numbers; 0 by default.
    uint64_t seed;
    // Number of threads, 0 by default, for one per core. The path does not depend on it.
    size_t threads;
    // Most checks to spend; 1000000 by default, SIZE_MAX for no limit.
    size_t max_checks;
    // Most seconds to spend: more than 0; infinity by default, for no limit.
    double max_seconds;
    // Function that ends the call early if it returns true, as in ExtricateOptions; null by
    // default, for none.
    bool (*stop)(void*);
    // Argument that the call passes to `stop`.
    void *stop_data;
} ExtricatePlanOptions;

// The numbers of a plan.
typedef struct ExtricatePlanSummary {
    // Whether a path was found.
    bool found;
    // The step that found the free part: EXTRICATE_PLAN_NONE or another.
    uint32_t method;
    // Index of the point from which on the path is proved free; 0 if the start is free.
    size_t free_from;
    // Index of the point up to which the path is proved free; the last one if the goal is free.
    size_t free_to;
    // Length of the path in the scene's metric.
    double length;
    // Number of configurations at which the exact checker evaluated anything.
    uint64_t checks;
    // Number of configurations in the roadmap.
    size_t nodes;
} ExtricatePlanSummary;

// Options of extricate_repair(). extricate_repair_options_init() fills in the defaults; then set
// the members that differ.
typedef struct ExtricateRepairOptions {
    // Clearance to which configurations are pushed out: 0 to 1e9 [m]. It is nan by default,
    // which means that of the scene plus a tenth of the radius of the smallest moving body.
    double aim;
    // Largest accepted deviation from the path, in the scene's metric: 0 to 1e9; infinity by
    // default, for no limit.
    double max_deviation;
    // Links that keep their places at the first row, or at given poses, all along the path, as in
    // ExtricateOptions; null by default, for none. With `frames`, each row keeps them where it has
    // them.
    const char *keep;
    // Whether the rows are frames of a motion, so that the result has one point for each, at the
    // same time: 0 or 1; 0 by default.
    uint32_t frames;
    // With `frames`, but not with `keep`: the longest step from frame to frame, in the scene's
    // metric: more than 0; infinity by default, for no limit. The result lags behind steps that
    // are longer.
    double max_step;
    // With `frames`: pairs that are at most this far apart beyond the clearance in a row, or
    // overlap there, stay as near if they can: more than 0 [m]; nan by default, which keeps no
    // contacts.
    double touch;
    // Resolution at which edges are proved: 0 to 1e9 [m]; 1e-4 by default.
    double resolution;
    // Seed of all random numbers; 0 by default.
    uint64_t seed;
    // Most checks to spend; 100000 by default, SIZE_MAX for no limit.
    size_t max_checks;
    // Most seconds to spend: more than 0; infinity by default, for no limit.
    double max_seconds;
    // Function that ends the call early if it returns true, as in ExtricateOptions; null by
    // default, for none.
    bool (*stop)(void*);
    // Argument that the call passes to `stop`.
    void *stop_data;
} ExtricateRepairOptions;

// The numbers of a repaired path.
typedef struct ExtricateRepairedSummary {
    // Whether a path was found.
    bool found;
    // Largest distance of a point from its place on the old path, in the scene's metric. Rows of
    // the old path that the new one cuts off count too.
    double deviation;
    // Length of the path in the scene's metric.
    double length;
    // Length of the old path in the scene's metric.
    double length_before;
    // Number of stretches of the old path that were replaced.
    size_t stretches;
    // Number of gaps in these stretches that trees had to close.
    size_t gaps;
    // Number of pairs that touch, summed over the rows; 0 if `touch` of the options is nan.
    size_t touched;
    // Number of these that touch in the result.
    size_t kept;
    // Number of configurations at which the exact checker evaluated anything.
    uint64_t checks;
} ExtricateRepairedSummary;

// Options of extricate_release(). extricate_release_options_init() fills in the defaults; then set
// the members that differ.
typedef struct ExtricateReleaseOptions {
    // What the release keeps: EXTRICATE_KEEP_CONTACTS by default, or EXTRICATE_KEEP_POSE.
    uint32_t keep;
    // Distance beyond the clearance up to which a link touches the object: 0 to 1e9 [m]; 2e-3 by
    // default.
    double touch;
    // Coefficient of friction, for the quality of the grasp: 0 to 1e9; 0.8 by default, 0 leaves
    // the quality unmeasured.
    double friction;
    // Configuration with open fingers, from which each finger closes on its side of the object.
    // It is null by default, which means every joint at 0, or at the limit nearest to 0.
    const double *open;
    // Number of coordinates of `open`: that of a configuration.
    size_t open_count;
    // Clearance to aim at: 0 to 1e9 [m]; nan by default, which means that of the scene.
    double clearance;
    // The names of joints that keep their positions; null by default, for none.
    const char *const *locked;
    // Number of `locked` joints.
    size_t locked_count;
    // Most checks to spend; SIZE_MAX by default, for no limit.
    size_t max_checks;
    // Most seconds to spend: more than 0; infinity by default, for no limit.
    double max_seconds;
    // Function that ends the call early if it returns true, as in ExtricateOptions; null by
    // default, for none.
    bool (*stop)(void*);
    // Argument that the call passes to `stop`.
    void *stop_data;
} ExtricateReleaseOptions;

// The numbers of a grasp.
typedef struct ExtricateGraspSummary {
    // Distance from the query, in the scene's metric.
    double moved;
    // Whether the exact checker called it free during this call.
    bool verified;
    // Whether every kept contact is on its side of the object.
    bool kept_sides;
    // Number of fingers that touched at the query.
    size_t fingers_before;
    // Number of those fingers that still touch.
    size_t fingers_kept;
    // Greatest depth of a link in the object at the query [m]; 0 if none was in it.
    double depth_before;
    // Largest wrench that the contacts resist in every direction; nan if it was not measured.
    double epsilon;
    // Whether the contacts resist every wrench; false if it was not measured.
    bool force_closure;
    // Number of exact checks and contact evaluations.
    uint64_t checks;
} ExtricateGraspSummary;

// A contact of a link with the object that a hand holds.
typedef struct ExtricateGraspContact {
    // Name of the link, which lives as long as the grasp.
    const char *link;
    // Signed distance of link and object [m].
    double distance;
    // Point on the object, in the world [m].
    double point[3];
    // Unit vector into the object.
    double normal[3];
} ExtricateGraspContact;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Returns the message of the last call that failed on this thread: file or argument, value, and
// what was expected. The message is empty if no call failed. It stays until the next call on this
// thread fails, or the thread ends; destructors of the thread's variables may find it gone.
const char *extricate_last_error(void);

// Fails with this message and EXTRICATE_ARGUMENT. A layer on top of this interface calls it to
// refuse an argument as the functions here do: extricate_last_error() then returns the message.
ExtricateStatus extricate_refuse(const char *message);

// Returns the version of the library, such as "0.2.0".
const char *extricate_version(void);

// Returns EXTRICATE_ABI of the library. A program that was compiled with another value must not
// continue.
uint32_t extricate_abi(void);

// Returns the number of coordinates of a configuration; 0 if `scene` is null.
size_t extricate_scene_nq(const struct ExtricateScene *scene);

// Returns the number of tangent coordinates: one for each coordinate, but three for a rotation,
// which has four coordinates; 0 if `scene` is null.
size_t extricate_scene_nv(const struct ExtricateScene *scene);

// Returns the number of joints that have coordinates; 0 if `scene` is null. Indices of joints
// follow the order of coordinates.
size_t extricate_scene_joint_count(const struct ExtricateScene *scene);

// Returns the name of a joint, which lives as long as the scene; null if there is no such joint.
const char *extricate_scene_joint_name(const struct ExtricateScene *scene, size_t index);

// Writes the first coordinate of a joint and the number of its coordinates; 0 and 0 if there is no
// such joint.
ExtricateStatus extricate_scene_joint_coordinates(const struct ExtricateScene *scene,
                                                  size_t index,
                                                  size_t *first,
                                                  size_t *count);

// Writes the limits of all coordinates: `nq` lower and `nq` upper ones. A continuous joint has
// minus and plus pi, which are the same position. The coordinates of a quaternion have minus and
// plus 1.
ExtricateStatus extricate_scene_limits(const struct ExtricateScene *scene,
                                       double *lower,
                                       double *upper,
                                       size_t nq);

// Writes the configuration in which the named joints have these positions [rad or m], which
// follow one another. `sizes` holds the number of coordinates of each joint; null means one each.
// Locked, mimic and fixed joints may be among them, because robots report them too.
ExtricateStatus extricate_scene_config(const struct ExtricateScene *scene,
                                       const char *const *names,
                                       const size_t *sizes,
                                       size_t count,
                                       const double *positions,
                                       size_t position_count,
                                       double *q,
                                       size_t nq);

// Makes the positions by joint at `q`, the inverse of extricate_scene_config(): mimic and locked
// joints are among them, fixed ones are not. `q` may be beyond the limits.
ExtricateStatus extricate_scene_positions(const struct ExtricateScene *scene,
                                          const double *q,
                                          size_t nq,
                                          struct ExtricatePositions **positions);

// Returns the number of joints that have positions; 0 if `positions` is null.
size_t extricate_positions_size(const struct ExtricatePositions *positions);

// Returns the name of a joint that has positions, which lives as long as `positions`; null if
// there is no such joint.
const char *extricate_positions_name(const struct ExtricatePositions *positions, size_t index);

// Returns the number of coordinates of a joint, and points `values` to its positions [rad or m];
// 0 if there is no such joint.
size_t extricate_positions_values(const struct ExtricatePositions *positions,
                                  size_t index,
                                  const double **values);

// Frees the positions of joints.
void extricate_positions_free(struct ExtricatePositions *positions);

// Writes the configuration in a text that holds a ROS message: a JointState, alone or in a
// RobotState, a PlanningScene or a planning request. The ending of `name` sets the format, .yaml
// or .json. Error messages contain `name`.
ExtricateStatus extricate_scene_config_text(const struct ExtricateScene *scene,
                                            const char *name,
                                            const char *text,
                                            double *q,
                                            size_t nq);

// Returns the number of bodies: links with geometry, obstacles and attached objects; 0 if `scene`
// is null.
size_t extricate_scene_body_count(const struct ExtricateScene *scene);

// Returns the name of a body, which lives as long as the scene; null if there is no such body.
const char *extricate_scene_body_name(const struct ExtricateScene *scene, size_t index);

// Returns the number of checked pairs of bodies; 0 if `scene` is null.
size_t extricate_scene_pair_count(const struct ExtricateScene *scene);

// Returns a checked pair; both indices are SIZE_MAX if there is no such pair.
struct ExtricatePair extricate_scene_pair(const struct ExtricateScene *scene, size_t index);

// Returns the least distance that free configurations keep [m], except for pairs with a
// clearance of their own; nan if `scene` is null.
double extricate_scene_clearance(const struct ExtricateScene *scene);

// Returns the metric in which depths are measured: EXTRICATE_METRIC_JOINT or another.
uint32_t extricate_scene_metric(const struct ExtricateScene *scene);

// Returns whether a model was learned from exactly this scene; extricate_save() writes that model.
// A changed scene keeps the model of the original scene, whose samples are additional starts of
// queries.
bool extricate_scene_is_learned(const struct ExtricateScene *scene);

// Returns how the model was learned and its measured quality, as JSON, which lives as long as the
// scene; null if the scene has no model. docs/reference/statistics.md describes the keys.
const char *extricate_scene_statistics(const struct ExtricateScene *scene);

// Returns the number of stored samples of the model, and points `samples` to the first number of
// the first one. They are free configurations beside the boundary, follow one another and have
// `nq` numbers each. Returns 0 if the scene has no model.
size_t extricate_scene_samples(const struct ExtricateScene *scene, const double **samples);

// Returns the number of warnings about the scene, such as open meshes, defaults that were assumed,
// and ignored content of a message of MoveIt; 0 if `scene` is null.
size_t extricate_scene_warning_count(const struct ExtricateScene *scene);

// Returns a warning, which lives as long as the scene; null if there is no such warning.
const char *extricate_scene_warning(const struct ExtricateScene *scene, size_t index);

// Loads a scene file (TOML), a URDF as a scene of that robot alone, or a model file as the learned
// scene with its model. Null options mean the defaults; they do not apply to a model.
ExtricateStatus extricate_load(const char *path,
                               const struct ExtricateLoadOptions *options,
                               struct ExtricateScene **scene);

// Makes a scene from the text of a scene file (TOML) or of a URDF, without a file.
//
// Relative paths in the text start from `folder`; null means the working directory. If `texts`
// contains a path of the text, its content replaces that file, so a URDF in memory needs no file
// either. Meshes are read from files.
ExtricateStatus extricate_scene_from_text(const char *text,
                                          const char *folder,
                                          const struct ExtricateText *texts,
                                          size_t text_count,
                                          struct ExtricateScene **scene);

// Makes one of the scenes that come with the library, such as "shelf-arm" or "planar-arm".
ExtricateStatus extricate_scene_builtin(const char *name, struct ExtricateScene **scene);

// Learns a model of the scene: stored samples, which are additional starts of queries. Learning
// takes seconds for most robots. Writes the same scene with the model to `model`.
//
// `labels` is the number of exact checks to spend, 0 for the default. `seconds` limits the time;
// it is more than 0, and infinity means no limit. `threads` is 0 for one per core. The model
// depends only on scene, labels and seed, unless the time limit ended learning.
//
// `progress` is null, or a function that is called after each step, on any thread. It gets the
// state of the run and `progress_data`. If it returns false, the run ends and keeps what it has
// learned. It must not throw.
ExtricateStatus extricate_learn(const struct ExtricateScene *scene,
                                size_t labels,
                                double seconds,
                                uint64_t seed,
                                size_t threads,
                                bool (*progress)(const struct ExtricateProgress*, void*),
                                void *progress_data,
                                struct ExtricateScene **model);

// Writes a learned model to a file; extricate_load() reads it.
ExtricateStatus extricate_save(const struct ExtricateScene *model, const char *path);

// Prepares the scene for queries. Without this call, the first query or check does it. Preparation
// takes milliseconds to seconds, the longest for meshes.
ExtricateStatus extricate_scene_prepare(const struct ExtricateScene *scene);

// Frees a scene; solvers, streams and answers that were made from it stay valid.
void extricate_scene_free(struct ExtricateScene *scene);

// Makes a scene in which obstacles have other poses: `count` names, and their poses in the world.
ExtricateStatus extricate_scene_moved(const struct ExtricateScene *scene,
                                      const char *const *names,
                                      const struct ExtricatePose *poses,
                                      size_t count,
                                      struct ExtricateScene **changed);

// Makes a scene with additional obstacles.
ExtricateStatus extricate_scene_with_obstacles(const struct ExtricateScene *scene,
                                               const struct ExtricateObstacle *obstacles,
                                               size_t count,
                                               struct ExtricateScene **changed);

// Makes a scene without the named obstacles or attached objects.
ExtricateStatus extricate_scene_without(const struct ExtricateScene *scene,
                                        const char *const *names,
                                        size_t count,
                                        struct ExtricateScene **changed);

// Makes a scene without any obstacle; attached objects stay.
ExtricateStatus extricate_scene_without_obstacles(const struct ExtricateScene *scene,
                                                  struct ExtricateScene **changed);

// Makes a scene that does not check these pairs of bodies: two names per pair, one after the
// other.
ExtricateStatus extricate_scene_disabled(const struct ExtricateScene *scene,
                                         const char *const *names,
                                         size_t pair_count,
                                         struct ExtricateScene **changed);

// Makes a scene with an object that a link holds, such as a can in a gripper. The pose of the
// object is in the coordinates of the link. The object is checked against everything except bodies
// fixed to the link and the bodies named in `touch`.
ExtricateStatus extricate_scene_attached(const struct ExtricateScene *scene,
                                         const struct ExtricateObstacle *object,
                                         const char *link,
                                         const char *const *touch,
                                         size_t touch_count,
                                         struct ExtricateScene **changed);

// Puts the robots of the scene into the world of a file: a scene file (TOML) without a robot,
// MoveIt's .scene text, or a PlanningScene message as .yaml or .json. Null options mean the
// defaults.
ExtricateStatus extricate_scene_in_world(const struct ExtricateScene *scene,
                                         const char *path,
                                         const struct ExtricateLoadOptions *options,
                                         struct ExtricateScene **changed);

// Puts the robots of the scene into the world of a text, as extricate_scene_in_world() does for a
// file. The ending of `name` sets the format: .toml, .scene, .yaml or .json. Error messages
// contain `name`.
ExtricateStatus extricate_scene_in_world_text(const struct ExtricateScene *scene,
                                              const char *name,
                                              const char *text,
                                              struct ExtricateScene **changed);

// Fills in the default options.
ExtricateStatus extricate_options_init(struct ExtricateOptions *options);

// Makes a solver, which answers queries of the scene with these options. The solver keeps the
// scene and shares its prepared data. The call copies the options; null means the defaults.
ExtricateStatus extricate_solver_new(const struct ExtricateScene *scene,
                                     const struct ExtricateOptions *options,
                                     struct ExtricateSolver **solver);

// Sets the options of a solver for the queries that follow; null means the defaults. No other
// thread may use the solver during the call.
ExtricateStatus extricate_solver_set_options(struct ExtricateSolver *solver,
                                             const struct ExtricateOptions *options);

// Queries configurations all over the space for about this many seconds, so that the first real
// query is as fast as later ones; 0.03 s are enough. Answers stay the same.
ExtricateStatus extricate_solver_warm_up(const struct ExtricateSolver *solver, double seconds);

// Frees a solver; its answers stay valid.
void extricate_solver_free(struct ExtricateSolver *solver);

// Finds the nearest free configuration to `q`, which has `nq` numbers and may be beyond the
// limits. Writes an answer, which the caller frees with extricate_answer_free(). Returns
// EXTRICATE_NOTHING_FREE if nothing free was found: free configurations may be rare, or locked
// joints, a clearance or a stop left none.
ExtricateStatus extricate_query(const struct ExtricateSolver *solver,
                                const double *q,
                                size_t nq,
                                struct ExtricateAnswer **answer);

// Finds the witness of extricate_query() alone, in less time. Writes `nq` numbers, those of `q` if
// it is free. It proves nothing, unless the effort is EXTRICATE_PROVED or the options set a gap.
// Returns the same status as extricate_query().
ExtricateStatus extricate_nearest_exit(const struct ExtricateSolver *solver,
                                       const double *q,
                                       size_t nq,
                                       double *witness);

// Returns the numbers of an answer, such as depth and lower bound; null if `answer` is null.
const struct ExtricateSummary *extricate_answer_summary(const struct ExtricateAnswer *answer);

// Returns the free configuration, with as many numbers as the query; null if `answer` is null.
const double *extricate_answer_witness(const struct ExtricateAnswer *answer);

// Returns the gradient of the depth with respect to the query: `nv` numbers, in tangent
// coordinates; null if `answer` is null.
const double *extricate_answer_gradient(const struct ExtricateAnswer *answer);

// Returns the number of pairs that collide at the query, and points `pairs` to them. With
// EXTRICATE_NEAREST it is one pair, unless the options request contacts.
size_t extricate_answer_colliding(const struct ExtricateAnswer *answer,
                                  const struct ExtricatePair **pairs);

// Returns the number of pairs that touch at the witness, and points `pairs` to them.
size_t extricate_answer_touching(const struct ExtricateAnswer *answer,
                                 const struct ExtricatePair **pairs);

// Returns the number of coordinates of the query that are beyond their limits, and points
// `coordinates` to their indices.
size_t extricate_answer_outside(const struct ExtricateAnswer *answer, const size_t **coordinates);

// Returns the number of kept links that are off at the query by more than their tolerances, and
// points `links` to their indices in the order of the option `keep`.
size_t extricate_answer_off(const struct ExtricateAnswer *answer, const size_t **links);

// Returns the number of kept links, and points `kept` to how far each is off at the witness; none
// if the query is free.
size_t extricate_answer_kept(const struct ExtricateAnswer *answer,
                             const struct ExtricateKeptError **kept);

// Returns the number of contacts at the witness, and points `contacts` to them.
size_t extricate_answer_contacts(const struct ExtricateAnswer *answer,
                                 const struct ExtricateContact **contacts);

// Returns the number of distinct exits, if the options request more than one, and points `exits`
// to them, nearest first.
size_t extricate_answer_exits(const struct ExtricateAnswer *answer,
                              const struct ExtricateExit **exits);

// Frees an answer.
void extricate_answer_free(struct ExtricateAnswer *answer);

// Checks whether a configuration is free: it is within all limits, and every checked pair keeps
// the clearance. The result is exact for the geometry of the scene.
ExtricateStatus extricate_check(const struct ExtricateSolver *solver,
                                const double *q,
                                size_t nq,
                                bool *is_free);

// Computes the least signed distance of any checked pair [m]: negative if two bodies overlap,
// infinity if no pair is checked. A positive distance is exact; between convex shapes, every
// distance is exact.
ExtricateStatus extricate_distance(const struct ExtricateSolver *solver,
                                   const double *q,
                                   size_t nq,
                                   double *distance);

// Computes the radius of a ball around a configuration, in the scene's metric, in which every
// configuration within the limits is proved free; 0 if the configuration is not free.
ExtricateStatus extricate_free_radius(const struct ExtricateSolver *solver,
                                      const double *q,
                                      size_t nq,
                                      double *radius);

// Computes the signed distances of all checked pairs [m], in the order of
// extricate_scene_pair(). `pair_count` must be the number that extricate_scene_pair_count()
// returns.
ExtricateStatus extricate_pair_distances(const struct ExtricateSolver *solver,
                                         const double *q,
                                         size_t nq,
                                         double *distances,
                                         size_t pair_count);

// Checks whether the whole straight segment from one configuration to another is free, by proof,
// not by sampling. Both ends must be within the limits. The first contact is located to within
// `resolution` [m]; 1e-4 is usual.
ExtricateStatus extricate_check_segment(const struct ExtricateSolver *solver,
                                        const double *from,
                                        const double *to,
                                        size_t nq,
                                        double resolution,
                                        struct ExtricateSegment *segment);

// Computes the distance between two configurations in the scene's metric, which also measures
// depths.
ExtricateStatus extricate_metric_distance(const struct ExtricateScene *scene,
                                          const double *from,
                                          const double *to,
                                          size_t nq,
                                          double *distance);

// Writes the pairs of bodies that collide at a configuration within the limits, and their number
// to `count`. `pair_count` must be the number that extricate_scene_pair_count() returns, since all
// pairs may collide.
ExtricateStatus extricate_colliding_pairs(const struct ExtricateSolver *solver,
                                          const double *q,
                                          size_t nq,
                                          struct ExtricatePair *pairs,
                                          size_t pair_count,
                                          size_t *count);

// Writes the pairs of bodies that collide in at least the share `share` of `samples` random
// configurations, and their number to `count`. Most likely they are links that overlap by design:
// extricate_scene_disabled() takes them off. A share of 1 and 100 samples are usual. `pair_count`
// must be the number that extricate_scene_pair_count() returns.
ExtricateStatus extricate_always_colliding(const struct ExtricateScene *scene,
                                           size_t samples,
                                           uint64_t seed,
                                           double share,
                                           struct ExtricatePair *pairs,
                                           size_t pair_count,
                                           size_t *count);

// Makes the contacts of all bodies that are nearer to each other than `within` [m] at a
// configuration within the limits, free or not, in the order of their pairs. A pair of convex
// shapes has one contact, which is exact. Meshes have several, and the nearest is exact; if meshes
// overlap, all are estimates.
ExtricateStatus extricate_contacts(const struct ExtricateSolver *solver,
                                   const double *q,
                                   size_t nq,
                                   double within,
                                   struct ExtricateContacts **contacts);

// Makes the nearest contact of every pair of bodies that are nearer to each other than `within`
// [m], with the gradient of its distance. These are the rows that controllers and quadratic
// programs take. Otherwise as extricate_contacts().
ExtricateStatus extricate_distance_rows(const struct ExtricateSolver *solver,
                                        const double *q,
                                        size_t nq,
                                        double within,
                                        struct ExtricateContacts **contacts);

// Returns the gradients of the distances of contacts that extricate_distance_rows() made: `nv`
// numbers for each contact [m per rad or m], in tangent coordinates. Returns null if there are
// none.
const double *extricate_contacts_gradients(const struct ExtricateContacts *contacts);

// Returns the number of contacts, and points `list` to them.
size_t extricate_contacts_list(const struct ExtricateContacts *contacts,
                               const struct ExtricateContact **list);

// Frees contacts of bodies.
void extricate_contacts_free(struct ExtricateContacts *contacts);

// Draws `count` uniformly random configurations within the limits, `nq` numbers each: with
// EXTRICATE_FREE or EXTRICATE_COLLIDING those of that kind alone, with EXTRICATE_ANY all. They
// depend on the scene and `seed` alone. All cores check them. If a million in a row are of the
// other kind, the call fails with EXTRICATE_INPUT.
ExtricateStatus extricate_sample(const struct ExtricateScene *scene,
                                 uint32_t kind,
                                 size_t count,
                                 uint64_t seed,
                                 double *q,
                                 size_t nq);

// Finds the nearest free configurations to `count` queries, which follow one another in `q`, `nq`
// numbers each. Writes `count` witnesses and `count` summaries, in the same order. If nothing free
// was found for a query, `found` of its summary is false and its witness is nan. Each answer
// equals that of extricate_query(), with any number of threads (0: one per core). If a row is
// wrong, the call fails before the first query.
ExtricateStatus extricate_query_batch(const struct ExtricateScene *scene,
                                      const struct ExtricateOptions *options,
                                      const double *q,
                                      size_t count,
                                      size_t nq,
                                      size_t threads,
                                      double *witnesses,
                                      struct ExtricateSummary *summaries);

// Measures how far each of `count` configurations is from the boundary of the free ones, in the
// scene's metric. For one that collides it is minus the depth, else the distance to the nearest in
// contact. They follow one another in `q`, `nq` numbers each, and may be beyond the limits.
// `within` is a distance above 0 beyond which a free configuration is far enough; infinity for
// none. `threads` is 0 for one per core. Limits on checks and seconds, effort and locked joints
// are those of the options of the solver.
//
// Writes `count` distances, witnesses of `nq` numbers and gradients of `nv` numbers, in tangent
// coordinates. The witness is the nearest free configuration, or the nearest in contact, which is
// free and just touches; nan if there is none. The gradient is that of the distance; it is 0
// without a witness, and nan if nothing free was found.
ExtricateStatus extricate_signed_distances(const struct ExtricateSolver *solver,
                                           const double *q,
                                           size_t count,
                                           size_t nq,
                                           size_t nv,
                                           double within,
                                           size_t threads,
                                           struct ExtricateSignedDistance *distances,
                                           double *witnesses,
                                           double *gradients);

// Checks whether each of `count` configurations is free, as extricate_check() does for one. They
// follow one another in `q`, `nq` numbers each. `threads` is 0 for one per core.
ExtricateStatus extricate_check_batch(const struct ExtricateScene *scene,
                                      const double *q,
                                      size_t count,
                                      size_t nq,
                                      size_t threads,
                                      bool *is_free);

// Computes the least signed distance of any checked pair [m] at each of `count` configurations,
// as extricate_distance() does for one. They follow one another in `q`, `nq` numbers each.
// `threads` is 0 for one per core.
ExtricateStatus extricate_distance_batch(const struct ExtricateScene *scene,
                                         const double *q,
                                         size_t count,
                                         size_t nq,
                                         size_t threads,
                                         double *distances);

// Checks whether whole segments are free, as extricate_check_segment() does for one: from each of
// `count` configurations in `from` to the same one in `to`, `nq` numbers each. `threads` is 0 for
// one per core.
ExtricateStatus extricate_check_segment_batch(const struct ExtricateScene *scene,
                                              const double *from,
                                              const double *to,
                                              size_t count,
                                              size_t nq,
                                              double resolution,
                                              size_t threads,
                                              struct ExtricateSegment *segments);

// Fills in the default options of streams.
ExtricateStatus extricate_stream_options_init(struct ExtricateStreamOptions *options);

// Makes a stream, which answers queries that are near each other, such as the frames of one
// motion. Each query starts from the exit of the one before. The stream keeps the scene; one
// thread at a time may use it.
// Null options mean the defaults.
ExtricateStatus extricate_stream_new(const struct ExtricateScene *scene,
                                     const struct ExtricateOptions *options,
                                     const struct ExtricateStreamOptions *stream_options,
                                     struct ExtricateStream **stream);

// Answers the next frame; otherwise as extricate_query().
ExtricateStatus extricate_stream_query(struct ExtricateStream *stream,
                                       const double *q,
                                       size_t nq,
                                       struct ExtricateAnswer **answer);

// Sets the scene of a stream for the frames that follow, such as one in which obstacles moved. It
// must have the same coordinates.
ExtricateStatus extricate_stream_set_scene(struct ExtricateStream *stream,
                                           const struct ExtricateScene *scene);

// Forgets the frames so far; the next frame is answered as a single query.
ExtricateStatus extricate_stream_restart(struct ExtricateStream *stream);

// Frees a stream; its answers stay valid.
void extricate_stream_free(struct ExtricateStream *stream);

// Fills in the default options of escapes.
ExtricateStatus extricate_escape_options_init(struct ExtricateEscapeOptions *options);

// Finds a path out of collision, from `q` to a free configuration; null options mean the defaults.
// `q` must be within the limits. If no path is found, `escape` has no points and says why.
//
// On the way no pair collides that does not at `q`, and none that does gets deeper by more than
// the tolerance. All of this is proved for every configuration of the path. The query options of
// the solver do not apply.
ExtricateStatus extricate_escape(const struct ExtricateSolver *solver,
                                 const double *q,
                                 size_t nq,
                                 const struct ExtricateEscapeOptions *options,
                                 struct ExtricateEscape **escape);

// Returns the numbers of an escape; null if `escape` is null.
const struct ExtricateEscapeSummary *extricate_escape_summary(const struct ExtricateEscape *escape);

// Returns the number of points of the path, the query first, and points `points` to the first
// number of the first one. Each has as many numbers as the query, and follows the one before; 0 if
// no path was found.
size_t extricate_escape_points(const struct ExtricateEscape *escape, const double **points);

// Returns the number of pairs that collide at the query, and points `pairs` to them and their
// signed distances there.
size_t extricate_escape_colliding(const struct ExtricateEscape *escape,
                                  const struct ExtricatePairDistance **pairs);

// Frees an escape. Those of a plan belong to the plan.
void extricate_escape_free(struct ExtricateEscape *escape);

// Fills in the default options of plans.
ExtricateStatus extricate_plan_options_init(struct ExtricatePlanOptions *options);

// Finds a path from `start` to `goal`, with every edge proved; null options mean the defaults.
// Both must be within the limits. An end that collides is led out of collision first, as
// extricate_escape() does, toward the other end. If no path is found, `plan` has no points.
//
// `roadmap` is null, or a roadmap of earlier calls, which the plan extends, so that plans of one
// scene that share it become cheaper. No other thread may use the roadmap during the call.
ExtricateStatus extricate_plan(const struct ExtricateSolver *solver,
                               const double *start,
                               const double *goal,
                               size_t nq,
                               const struct ExtricatePlanOptions *options,
                               struct ExtricateRoadmap *roadmap,
                               struct ExtricatePlan **plan);

// Returns the numbers of a plan; null if `plan` is null.
const struct ExtricatePlanSummary *extricate_plan_summary(const struct ExtricatePlan *plan);

// Returns the number of points of the path from start to goal, and points `points` to the first
// number of the first one. Each has as many numbers as the start, and follows the one before; 0 if
// no path was found.
size_t extricate_plan_points(const struct ExtricatePlan *plan, const double **points);

// Returns the path from a colliding start to the free part, which lives as long as the plan; null
// if the start is free. If it has no points, it says why there is no plan.
const struct ExtricateEscape *extricate_plan_start_escape(const struct ExtricatePlan *plan);

// Returns the same from a colliding goal, which the plan takes in reverse.
const struct ExtricateEscape *extricate_plan_goal_escape(const struct ExtricatePlan *plan);

// Frees a plan, with its escapes.
void extricate_plan_free(struct ExtricatePlan *plan);

// Fills in the default options of repairs.
ExtricateStatus extricate_repair_options_init(struct ExtricateRepairOptions *options);

// Finds a path that is proved free, as near to the given one as it can. `path` has `count`
// configurations within the limits, which follow one another, `nq` numbers each. Null options mean
// the defaults. A colliding end is moved too. If no path is found, `repaired` has no points.
ExtricateStatus extricate_repair(const struct ExtricateSolver *solver,
                                 const double *path,
                                 size_t count,
                                 size_t nq,
                                 const struct ExtricateRepairOptions *options,
                                 struct ExtricateRepaired **repaired);

// Returns the numbers of a repaired path; null if `repaired` is null.
const struct ExtricateRepairedSummary *extricate_repaired_summary(const struct ExtricateRepaired *repaired);

// Returns the number of points of a repaired path, and points `points` to the first number of the
// first one. Each has `nq` numbers, and follows the one before; 0 if no path was found.
size_t extricate_repaired_points(const struct ExtricateRepaired *repaired, const double **points);

// Returns the number of points of a repaired path, and points `places` to the place of each on the
// old path: 2.25 is a quarter of the edge from row 2 to row 3. Places ascend, and are whole
// numbers for rows that stay.
size_t extricate_repaired_places(const struct ExtricateRepaired *repaired, const double **places);

// Frees a repaired path.
void extricate_repaired_free(struct ExtricateRepaired *repaired);

// Makes an empty roadmap: free configurations and proved edges between them, which
// extricate_plan() adds to and reuses. One thread at a time may use it.
//
// In another scene with the same coordinates a roadmap is a guess that saves checks: every path
// that is returned is proved in the scene of the plan.
ExtricateStatus extricate_roadmap_new(const struct ExtricateScene *scene,
                                      uint64_t seed,
                                      struct ExtricateRoadmap **roadmap);

// Reads a roadmap file for a scene.
ExtricateStatus extricate_roadmap_load(const char *path,
                                       const struct ExtricateScene *scene,
                                       struct ExtricateRoadmap **roadmap);

// Writes a roadmap file. A reader sees the old file or the whole new one. It replaces no file that
// is not a roadmap.
ExtricateStatus extricate_roadmap_save(const struct ExtricateRoadmap *roadmap, const char *path);

// Returns the number of configurations of a roadmap; 0 if `roadmap` is null.
size_t extricate_roadmap_size(const struct ExtricateRoadmap *roadmap);

// Returns the number of proved edges of a roadmap; 0 if `roadmap` is null.
size_t extricate_roadmap_edges(const struct ExtricateRoadmap *roadmap);

// Returns the number of configurations that were evaluated to make a roadmap; 0 if `roadmap` is
// null.
size_t extricate_roadmap_checks(const struct ExtricateRoadmap *roadmap);

// Frees a roadmap of plans.
void extricate_roadmap_free(struct ExtricateRoadmap *roadmap);

// Fills in the default options of releases.
ExtricateStatus extricate_release_options_init(struct ExtricateReleaseOptions *options);

// Makes the hand of a scene that holds the obstacle `object`: it finds the fingers, and prepares
// what releases need. It keeps the scene, but no model; any number of threads may use it.
//
// If `scene_weights` is false, the base of a floating hand gets weights. They make moving the hand
// about as expensive as moving its fingers. Otherwise the weights of the scene apply.
ExtricateStatus extricate_hand_new(const struct ExtricateScene *scene,
                                   const char *object,
                                   bool scene_weights,
                                   struct ExtricateHand **hand);

// Frees a hand; its grasps stay valid.
void extricate_hand_free(struct ExtricateHand *hand);

// Finds the nearest configuration at which no finger penetrates the object and the hand still
// holds it; null options mean the defaults. `q` may be beyond the limits. If nothing free was
// found, it returns EXTRICATE_NOTHING_FREE.
ExtricateStatus extricate_release(const struct ExtricateHand *hand,
                                  const double *q,
                                  size_t nq,
                                  const struct ExtricateReleaseOptions *options,
                                  struct ExtricateGrasp **grasp);

// Returns the numbers of a grasp; null if `grasp` is null.
const struct ExtricateGraspSummary *extricate_grasp_summary(const struct ExtricateGrasp *grasp);

// Returns the configuration of a grasp, with as many numbers as the query; null if `grasp` is
// null.
const double *extricate_grasp_config(const struct ExtricateGrasp *grasp);

// Returns the number of contacts with the object, and points `contacts` to them.
size_t extricate_grasp_contacts(const struct ExtricateGrasp *grasp,
                                const struct ExtricateGraspContact **contacts);

// Returns the name of a link that touched the object at the query, or was in it; null if there are
// not so many.
const char *extricate_grasp_touched(const struct ExtricateGrasp *grasp, size_t index);

// Returns the name of one of those links that still touches it; null if there are not so many.
const char *extricate_grasp_kept(const struct ExtricateGrasp *grasp, size_t index);

// Frees a grasp; null is ignored.
void extricate_grasp_free(struct ExtricateGrasp *grasp);

// Computes where bodies are in the world at `count` configurations, which follow one another in
// `q`, `nq` numbers each. `names` are those of bodies or of links, which need no geometry; null
// means all bodies. Writes a transform for each configuration and name, from a body's own
// coordinates [m] to those of the world: 16 numbers, a 4 by 4 matrix row by row. A link has the
// coordinates of its URDF; an obstacle or an attached object has those of its shape.
// `transform_count` must be the number of transforms: `count` times the number of names or bodies.
ExtricateStatus extricate_scene_poses(const struct ExtricateScene *scene,
                                      const char *const *names,
                                      size_t name_count,
                                      const double *q,
                                      size_t count,
                                      size_t nq,
                                      double *transforms,
                                      size_t transform_count);

// Makes the triangles of a body, to draw it at its place by extricate_scene_poses(). Round shapes
// are inscribed and get `segments` sides around their axis, 3 or more; 32 are usual. A half-space
// becomes a square of 10 m.
ExtricateStatus extricate_scene_mesh(const struct ExtricateScene *scene,
                                     size_t body,
                                     size_t segments,
                                     struct ExtricateMesh **mesh);

// Returns the number of corners of a mesh, and points `points` to their coordinates [m], three
// numbers each.
size_t extricate_mesh_points(const struct ExtricateMesh *mesh, const double **points);

// Returns the number of triangles of a mesh, and points `triangles` to the indices of their
// corners, three each, counterclockwise from outside.
size_t extricate_mesh_triangles(const struct ExtricateMesh *mesh, const uint32_t **triangles);

// Frees the triangles of a body.
void extricate_mesh_free(struct ExtricateMesh *mesh);

// Finds the points that are not the robot's own: at `q`, no link is nearer to them than `padding`
// [m]. `points` holds three numbers for each, in the world. Writes `point_count` flags, true for
// the points to keep. Obstacles do not count.
ExtricateStatus extricate_scene_robot_filter(const struct ExtricateScene *scene,
                                             const double *points,
                                             size_t point_count,
                                             const double *q,
                                             size_t nq,
                                             double padding,
                                             bool *keep);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* EXTRICATE_H */
