/* The C interface of extricate. Written by cbindgen from crates/extricate-c/src/abi, do not edit:
 * UPDATE_HEADER=1 cargo test -p extricate-c header
 *
 * Every function that can fail returns an ExtricateStatus; extricate_last_error() then says what is
 * wrong. Handles belong to the caller, who frees them, once, with the function of their type; null
 * is allowed there. No handle has to outlive another: a solver keeps its scene. A scene and an
 * answer never change, and any number of threads may use one. A solver or a stream is used by one
 * thread at a time. Strings are UTF-8 and end with a zero. Lengths are in metres, angles in radians.
 *
 * Pointers must be null or valid, as in every C interface: a handle that was freed, or an array that
 * is shorter than was said, is not noticed. A null pointer or a wrong length where it can be seen
 * gives EXTRICATE_ARGUMENT. */

#ifndef EXTRICATE_H
#define EXTRICATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// There is a result.
#define EXTRICATE_OK 0

// Nothing free was found: no fault of the call.
#define EXTRICATE_NOTHING_FREE 1

// A null pointer, a wrong length, a name that nothing has, an option that makes no sense.
#define EXTRICATE_ARGUMENT 2

// A configuration of the wrong length, not finite, or beyond limits where that is refused.
#define EXTRICATE_CONFIGURATION 3

// A file cannot be read or written.
#define EXTRICATE_FILE 4

// A scene, robot, mesh or world says something that cannot be used.
#define EXTRICATE_INPUT 5

// A model file is truncated, altered, foreign or of another version.
#define EXTRICATE_MODEL 6

// A fault of this library, caught.
#define EXTRICATE_INTERNAL 7

// Number of this interface: it grows where a program has to be compiled anew.
#define EXTRICATE_ABI 1

// Effort: the nearest stored sample; needs a model.
#define EXTRICATE_NEAREST 0

// Effort: diverse starts, descents, verification. The default.
#define EXTRICATE_REFINED 1

// Effort: many starts.
#define EXTRICATE_EXHAUSTIVE 2

// Effort: as refined, and then branch and bound until the gap is proved or the budget ends.
#define EXTRICATE_PROVED 3

// As refined, with fewer starts: about half the checks.
#define EXTRICATE_QUICK 4

// Metric of the joints [rad], weighted.
#define EXTRICATE_METRIC_JOINT 0

// Root mean square displacement of the robot's solids [m].
#define EXTRICATE_METRIC_OBJECT_NORM 1

// Largest displacement of any point [m].
#define EXTRICATE_METRIC_MAX_DISPLACEMENT 2

// Something is proved, or the query is free.
#define EXTRICATE_IS_PROVED 0

// Nothing is proved: what collides are surfaces, which enclose nothing.
#define EXTRICATE_UNPROVED_SURFACES 1

// Nothing is proved: the overlap is too shallow.
#define EXTRICATE_UNPROVED_SHALLOW 2

// Shape: a box, `size` are its full sides [m].
#define EXTRICATE_BOX 0

// Shape: `size[0]` is the radius [m].
#define EXTRICATE_SPHERE 1

// Shape: `size` are radius and length [m], along z.
#define EXTRICATE_CYLINDER 2

// Shape: `size` are radius and length of the cylindrical part [m], along z.
#define EXTRICATE_CAPSULE 3

// Shape: `points` are corners [m], `triangles` indices of three each.
#define EXTRICATE_MESH 4

// Shape: `points` [m] with balls of radius `size[0]` about them; obstacles only.
#define EXTRICATE_POINTS 5

// Shape: occupied `cells` of side `size[0]` [m]; obstacles only.
#define EXTRICATE_VOXELS 6

// Shape: what lies behind the plane with the normal `size`, at `offset` [m]; obstacles only.
#define EXTRICATE_HALF_SPACE 7

// An answer. Immutable; may be shared between threads.
typedef struct ExtricateAnswer ExtricateAnswer;

// A scene, or a model in its scene or in another one. Immutable; may be shared between threads.
typedef struct ExtricateScene ExtricateScene;

// Options of queries of one scene, and memory. One for each thread.
typedef struct ExtricateSolver ExtricateSolver;

// Queries that follow each other closely. One for each thread.
typedef struct ExtricateStream ExtricateStream;

// What a function returns: EXTRICATE_OK, or why there is no result.
typedef int32_t ExtricateStatus;

// Two bodies that have to stay apart, as indices of bodies.
typedef struct ExtricatePair {
    // The lower index.
    size_t first;
    // The higher one.
    size_t second;
} ExtricatePair;

// A text that stands for a file which a scene names.
typedef struct ExtricateText {
    // The path, as the scene spells it.
    const char *path;
    // What the file would hold.
    const char *text;
} ExtricateText;

// Where something stands.
typedef struct ExtricatePose {
    // x, y, z [m].
    double position[3];
    // Unit quaternion x, y, z, w.
    double quaternion[4];
} ExtricatePose;

// One shape. Members that its kind does not name are not read.
typedef struct ExtricateShape {
    // EXTRICATE_BOX and so on.
    uint32_t kind;
    // See the kinds.
    double size[3];
    // Of a half-space, along its unit normal [m].
    double offset;
    // Three numbers each [m].
    const double *points;
    // How many points.
    size_t point_count;
    // Three indices of points each.
    const uint32_t *triangles;
    // How many triangles.
    size_t triangle_count;
    // Three indices each.
    const int32_t *cells;
    // How many cells.
    size_t cell_count;
    // Of a mesh: not 0 where its convex hull stands for it.
    uint32_t convex;
} ExtricateShape;

// An obstacle, or an object for a link to hold.
typedef struct ExtricateObstacle {
    // A name of its own.
    const char *name;
    // Its shape.
    struct ExtricateShape shape;
    // In the world; of an attached object, in the link's coordinates.
    struct ExtricatePose pose;
} ExtricateObstacle;

// What is asked of a query. Fill it with extricate_options_init() first.
typedef struct ExtricateOptions {
    // EXTRICATE_REFINED and so on.
    uint32_t effort;
    // Not 0: configurations beyond the limits are refused, not answered.
    uint32_t refuse_outside;
    // Not 0: prove within which distance of the witness nothing touches.
    uint32_t free_radius;
    // Not 0: tell how much of the straight segment to the witness collides.
    uint32_t segment;
    // Not 0: tell contacts with EXTRICATE_NEAREST too.
    uint32_t contacts;
    // How many distinct exits to look for; 1 by default.
    size_t exits;
    // How many starts; 0 leaves it to the effort.
    size_t starts;
    // Share of the depth that need not be proved, in [0, 1); nan for none.
    double gap;
    // Clearance to aim at [m]; nan for that of the scene.
    double clearance;
    // Most checks; SIZE_MAX for no limit.
    size_t max_checks;
    // Most seconds; infinity for no limit.
    double max_seconds;
    // Names of joints that stay where the query has them.
    const char *const *locked;
    // How many.
    size_t locked_count;
    // A configuration that the witness is to be near to, among exits about as near; or null.
    const double *toward;
    // How many numbers it has: those of a configuration.
    size_t toward_count;
    // Exits count that are farther than the nearest one by at most this share of its depth.
    double toward_share;
    // Ends a query early where it says true: called between its steps, on any thread, of a batch
    // on several at once; null for none. It must not throw.
    bool (*stop)(void*);
    // What `stop` is given.
    void *stop_data;
} ExtricateOptions;

// What is known of an answer, in numbers.
typedef struct ExtricateSummary {
    // Distance from the query to the witness, in the scene's metric; 0 where the query is free,
    // infinity where nothing free was found.
    double depth;
    // Proved: no free configuration is nearer.
    double lower_bound;
    // Share of the depth that is not proved.
    double gap;
    // Largest displacement of any point of the robot, from the query to the witness [m].
    double max_displacement;
    // Estimated share of starts that would lead to an exit which was not met; nan where unknown.
    double unseen;
    // What the witness keeps [m].
    double clearance;
    // Proved: nothing touches nearer to the witness than this; nan where not requested.
    double free_radius;
    // Fraction of the straight segment up to which a collision was found; nan where not requested.
    double segment_colliding_until;
    // Fraction from which on the straight segment is proved free; nan where not requested.
    double segment_free_from;
    // Collision checks and distance evaluations spent.
    uint64_t checks;
    // EXTRICATE_IS_PROVED, or why nothing is.
    uint32_t unproved;
    // Whether there is a witness.
    bool found;
    // Whether the query itself is free.
    bool is_free;
    // Whether the exact checker called the witness free during this query.
    bool verified;
    // Whether no other distinct exit within 1 % of the depth was met.
    bool unique;
    // Whether a limit of checks or seconds, or a stop, ended the search before it was done.
    bool cut_short;
} ExtricateSummary;

// Where two bodies touch at a witness, in world coordinates.
typedef struct ExtricateContact {
    // The bodies.
    struct ExtricatePair pair;
    // Signed [m]; negative where they overlap.
    double distance;
    // On the first body [m].
    double point_first[3];
    // On the second body [m].
    double point_second[3];
    // Unit, from the second body toward the first.
    double normal[3];
} ExtricateContact;

// One of several exits.
typedef struct ExtricateExit {
    // Distance from the query.
    double depth;
    // nq numbers, which live as long as the answer.
    const double *witness;
} ExtricateExit;

// What is known of the segment between two configurations. Fractions are of its length.
typedef struct ExtricateSegment {
    // Proved: every configuration of the segment is free.
    bool is_free;
    // A collision was found; where neither is set, nothing is proved.
    bool collides;
    // Up to here every configuration is free: proved.
    double free_until;
    // Where a configuration collides, or nearly does where nothing is proved; nan where free.
    double at;
    // What does; no bodies where free, both indices are SIZE_MAX then.
    struct ExtricatePair pair;
} ExtricateSegment;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// What the last call that failed on this thread says is wrong: file or argument, value, and what
// was expected. Empty where none failed. It stays until the next call on this thread fails, or the
// thread ends: destructors of its variables may find that messages are gone.
const char *extricate_last_error(void);

// Fails with this message and EXTRICATE_ARGUMENT. A layer on top of this interface calls it to
// refuse an argument as the functions here do: extricate_last_error() then gives the message.
ExtricateStatus extricate_refuse(const char *message);

// Version of the library, such as "0.2.0".
const char *extricate_version(void);

// EXTRICATE_ABI of the library; a program that was compiled with another one must not go on.
uint32_t extricate_abi(void);

// Coordinates of a configuration; 0 for null.
size_t extricate_scene_nq(const struct ExtricateScene *scene);

// Tangent coordinates: one a coordinate, three for a rotation; 0 for null.
size_t extricate_scene_nv(const struct ExtricateScene *scene);

// Joints that have coordinates, in the order of these; 0 for null.
size_t extricate_scene_joint_count(const struct ExtricateScene *scene);

// Name of a joint, which lives as long as the scene; null where there is none.
const char *extricate_scene_joint_name(const struct ExtricateScene *scene, size_t index);

// The first coordinate of a joint and how many it has; 0 and 0 where there is no such joint.
ExtricateStatus extricate_scene_joint_coordinates(const struct ExtricateScene *scene,
                                                  size_t index,
                                                  size_t *first,
                                                  size_t *count);

// Limits of all coordinates: `nq` lower and `nq` upper ones. Angles of continuous joints have
// minus and plus pi, which are the same place; quaternions minus and plus 1.
ExtricateStatus extricate_scene_limits(const struct ExtricateScene *scene,
                                       double *lower,
                                       double *upper,
                                       size_t nq);

// The configuration in which the joints of these names have these positions, one number each [rad
// or m]. Locked, mimic and fixed joints may be among them, as robots report them.
ExtricateStatus extricate_scene_config(const struct ExtricateScene *scene,
                                       const char *const *names,
                                       const double *positions,
                                       size_t count,
                                       double *q,
                                       size_t nq);

// The same of a message as text: a JointState, alone or in a RobotState, a PlanningScene or a
// request to plan. The end of `name` tells what it is: .yaml or .json; messages repeat the name.
ExtricateStatus extricate_scene_config_text(const struct ExtricateScene *scene,
                                            const char *name,
                                            const char *text,
                                            double *q,
                                            size_t nq);

// Bodies: links with geometry, obstacles, attached objects; 0 for null.
size_t extricate_scene_body_count(const struct ExtricateScene *scene);

// Name of a body, which lives as long as the scene; null where there is none.
const char *extricate_scene_body_name(const struct ExtricateScene *scene, size_t index);

// Checked pairs; 0 for null.
size_t extricate_scene_pair_count(const struct ExtricateScene *scene);

// A checked pair; both indices are SIZE_MAX where there is none.
struct ExtricatePair extricate_scene_pair(const struct ExtricateScene *scene, size_t index);

// Least distance that free configurations keep, but for pairs with one of their own [m]; nan for
// null.
double extricate_scene_clearance(const struct ExtricateScene *scene);

// EXTRICATE_METRIC_JOINT and so on, which distances are measured by.
uint32_t extricate_scene_metric(const struct ExtricateScene *scene);

// Whether there is a model, of this scene or of the one that it was made from.
bool extricate_scene_is_learned(const struct ExtricateScene *scene);

// Things to know of the scene: open meshes, defaults taken, what a message of MoveIt says that is
// not taken; 0 for null.
size_t extricate_scene_warning_count(const struct ExtricateScene *scene);

// A warning, which lives as long as the scene; null where there is none.
const char *extricate_scene_warning(const struct ExtricateScene *scene, size_t index);

// Loads a scene file (TOML), a URDF, as a scene of that robot alone, or a model file.
ExtricateStatus extricate_load(const char *path, struct ExtricateScene **scene);

// Makes a scene of the text of a scene file (TOML) or of a URDF, without a file.
//
// Paths in it start from `folder`, null for the working directory. Where a path in the text is one
// of `texts`, that text stands for the file: so a URDF that a program holds needs no file either.
// Meshes are read from files.
ExtricateStatus extricate_scene_from_text(const char *text,
                                          const char *folder,
                                          const struct ExtricateText *texts,
                                          size_t text_count,
                                          struct ExtricateScene **scene);

// Makes one of the scenes that come with the library, such as "shelf-arm" or "planar-arm".
ExtricateStatus extricate_scene_builtin(const char *name, struct ExtricateScene **scene);

// Learns a model of the scene, which adds stored samples as starts: seconds for most cells.
//
// `labels` are the exact checks to spend, 0 for the usual number; `seconds` is the most time, more
// than 0, infinity for no limit; `threads` is 0 for one a core. The model depends on scene, labels
// and seed alone, unless time ended it.
ExtricateStatus extricate_learn(const struct ExtricateScene *scene,
                                size_t labels,
                                double seconds,
                                uint64_t seed,
                                size_t threads,
                                struct ExtricateScene **model);

// Writes a learned model to a file; extricate_load() reads it.
ExtricateStatus extricate_save(const struct ExtricateScene *model, const char *path);

// Prepares the scene for queries: what the first solver or check would do. Takes milliseconds to
// seconds, the longest for meshes.
ExtricateStatus extricate_scene_prepare(const struct ExtricateScene *scene);

// Frees a scene; solvers, streams and answers that were made of it stay.
void extricate_scene_free(struct ExtricateScene *scene);

// Obstacles elsewhere: `count` names and their poses in the world.
ExtricateStatus extricate_scene_moved(const struct ExtricateScene *scene,
                                      const char *const *names,
                                      const struct ExtricatePose *poses,
                                      size_t count,
                                      struct ExtricateScene **changed);

// More obstacles.
ExtricateStatus extricate_scene_with_obstacles(const struct ExtricateScene *scene,
                                               const struct ExtricateObstacle *obstacles,
                                               size_t count,
                                               struct ExtricateScene **changed);

// Fewer obstacles, or objects that links hold, by their names.
ExtricateStatus extricate_scene_without(const struct ExtricateScene *scene,
                                        const char *const *names,
                                        size_t count,
                                        struct ExtricateScene **changed);

// Without any obstacle; objects that links hold stay.
ExtricateStatus extricate_scene_without_obstacles(const struct ExtricateScene *scene,
                                                  struct ExtricateScene **changed);

// Pairs of bodies that are no longer checked: two names a pair, one after the other.
ExtricateStatus extricate_scene_disabled(const struct ExtricateScene *scene,
                                         const char *const *names,
                                         size_t pair_count,
                                         struct ExtricateScene **changed);

// An object that a link holds, such as a can in a gripper. Its pose is in the link's coordinates;
// it is checked against everything but what is fixed to the link and the bodies named in `touch`.
ExtricateStatus extricate_scene_attached(const struct ExtricateScene *scene,
                                         const struct ExtricateObstacle *object,
                                         const char *link,
                                         const char *const *touch,
                                         size_t touch_count,
                                         struct ExtricateScene **changed);

// The robots of the scene in the world of a file: a scene file (TOML) without a robot, MoveIt's
// .scene text, or a PlanningScene message as .yaml or .json.
ExtricateStatus extricate_scene_in_world(const struct ExtricateScene *scene,
                                         const char *path,
                                         struct ExtricateScene **changed);

// The same of a text. The end of `name` tells what it is: .toml, .scene, .yaml or .json; messages
// repeat the name.
ExtricateStatus extricate_scene_in_world_text(const struct ExtricateScene *scene,
                                              const char *name,
                                              const char *text,
                                              struct ExtricateScene **changed);

// Fills in the usual options.
ExtricateStatus extricate_options_init(struct ExtricateOptions *options);

// Makes a solver of queries of the scene. One for each thread; any number for one scene, which it
// keeps. Options are read now; null stands for the usual ones.
ExtricateStatus extricate_solver_new(const struct ExtricateScene *scene,
                                     const struct ExtricateOptions *options,
                                     struct ExtricateSolver **solver);

// Other options for the queries that follow; null stands for the usual ones.
ExtricateStatus extricate_solver_set_options(struct ExtricateSolver *solver,
                                             const struct ExtricateOptions *options);

// Queries configurations all over the space for about so many seconds, so that the first query
// that counts takes as long as those that follow: 0.03 are enough. Answers stay the same.
ExtricateStatus extricate_solver_warm_up(struct ExtricateSolver *solver, double seconds);

// Frees a solver; its answers stay.
void extricate_solver_free(struct ExtricateSolver *solver);

// The nearest free configuration to `q`, which is `nq` numbers, beyond the limits too. Writes an
// answer, to be freed with extricate_answer_free(). EXTRICATE_NOTHING_FREE where nothing free was
// found: without a model only where it is rare indeed, and with joints that stay.
ExtricateStatus extricate_query(struct ExtricateSolver *solver,
                                const double *q,
                                size_t nq,
                                struct ExtricateAnswer **answer);

// Depth, bound and the other numbers; null for null.
const struct ExtricateSummary *extricate_answer_summary(const struct ExtricateAnswer *answer);

// The free configuration, as many numbers as the query; null for null.
const double *extricate_answer_witness(const struct ExtricateAnswer *answer);

// How the depth changes with the query: `nv` numbers, in tangent coordinates; null for null.
const double *extricate_answer_gradient(const struct ExtricateAnswer *answer);

// Pairs that collide at the query: returns how many, and writes where they are.
size_t extricate_answer_colliding(const struct ExtricateAnswer *answer,
                                  const struct ExtricatePair **pairs);

// Pairs that touch at the witness: returns how many, and writes where they are.
size_t extricate_answer_touching(const struct ExtricateAnswer *answer,
                                 const struct ExtricatePair **pairs);

// Coordinates of the query beyond their limits: returns how many, and writes where their indices
// are.
size_t extricate_answer_outside(const struct ExtricateAnswer *answer, const size_t **coordinates);

// Where bodies touch at the witness: returns how many contacts, and writes where they are.
size_t extricate_answer_contacts(const struct ExtricateAnswer *answer,
                                 const struct ExtricateContact **contacts);

// The distinct exits, nearest first, where more than one was asked for: returns how many, and
// writes where they are.
size_t extricate_answer_exits(const struct ExtricateAnswer *answer,
                              const struct ExtricateExit **exits);

// Frees an answer.
void extricate_answer_free(struct ExtricateAnswer *answer);

// Whether a configuration is free: within all limits, and every checked pair keeps the clearance.
// Exact, on the geometry of the scene.
ExtricateStatus extricate_check(struct ExtricateSolver *solver,
                                const double *q,
                                size_t nq,
                                bool *is_free);

// Least signed distance of any checked pair [m]: negative where two bodies overlap, infinity
// where no pair is checked. Exact where positive, and of convex shapes.
ExtricateStatus extricate_distance(struct ExtricateSolver *solver,
                                   const double *q,
                                   size_t nq,
                                   double *distance);

// Signed distances of all checked pairs [m], by pair; `pair_count` is that of the scene.
ExtricateStatus extricate_pair_distances(struct ExtricateSolver *solver,
                                         const double *q,
                                         size_t nq,
                                         double *distances,
                                         size_t pair_count);

// Whether the whole segment from one configuration to another is free, both within the limits:
// proved, not sampled. `resolution` is how closely a first contact is enclosed [m]: 1e-4 is
// usual.
ExtricateStatus extricate_check_segment(struct ExtricateSolver *solver,
                                        const double *from,
                                        const double *to,
                                        size_t nq,
                                        double resolution,
                                        struct ExtricateSegment *segment);

// How far two configurations are from each other, in the scene's metric: what depths are measured
// by.
ExtricateStatus extricate_metric_distance(const struct ExtricateScene *scene,
                                          const double *from,
                                          const double *to,
                                          size_t nq,
                                          double *distance);

// The nearest free configurations to `count` queries, one after another in `q`, of `nq` numbers
// each. Writes `count` witnesses in the same order and `count` summaries; of where nothing free
// was found, `found` is false and the witness nan. Each answer is that of extricate_query() alone,
// whatever the number of threads (0: one a core). One wrong row fails the call before anything is
// queried.
ExtricateStatus extricate_query_batch(const struct ExtricateScene *scene,
                                      const struct ExtricateOptions *options,
                                      const double *q,
                                      size_t count,
                                      size_t nq,
                                      size_t threads,
                                      double *witnesses,
                                      struct ExtricateSummary *summaries);

// Whether `count` configurations are free: within all limits, and every checked pair keeps the
// clearance.
ExtricateStatus extricate_check_batch(const struct ExtricateScene *scene,
                                      const double *q,
                                      size_t count,
                                      size_t nq,
                                      size_t threads,
                                      bool *is_free);

// Least signed distances of any checked pair at `count` configurations [m]: negative where two
// bodies overlap, infinity where no pair is checked.
ExtricateStatus extricate_distance_batch(const struct ExtricateScene *scene,
                                         const double *q,
                                         size_t count,
                                         size_t nq,
                                         size_t threads,
                                         double *distances);

// Makes a stream of queries of the scene, which it keeps. One for each thread.
//
// The exit of the last frame is kept until another is nearer by more than the share `hysteresis`
// of its depth, in [0, 1); 0 always takes the nearest. `starts_per_frame` other starts are tried
// each frame; 4 are usual.
ExtricateStatus extricate_stream_new(const struct ExtricateScene *scene,
                                     const struct ExtricateOptions *options,
                                     double hysteresis,
                                     size_t starts_per_frame,
                                     struct ExtricateStream **stream);

// The answer for the next frame; otherwise as extricate_query().
ExtricateStatus extricate_stream_query(struct ExtricateStream *stream,
                                       const double *q,
                                       size_t nq,
                                       struct ExtricateAnswer **answer);

// Another scene for the frames that follow, such as one in which obstacles moved. It must have the
// same coordinates.
ExtricateStatus extricate_stream_set_scene(struct ExtricateStream *stream,
                                           const struct ExtricateScene *scene);

// Forgets the frames so far: the next one is answered as a query on its own.
ExtricateStatus extricate_stream_restart(struct ExtricateStream *stream);

// Frees a stream; its answers stay.
void extricate_stream_free(struct ExtricateStream *stream);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* EXTRICATE_H */
