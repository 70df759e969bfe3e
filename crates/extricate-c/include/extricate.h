/* The C interface of extricate. Written by cbindgen from crates/extricate-c/src/abi, do not edit:
 * UPDATE_HEADER=1 cargo test -p extricate-c --test header
 *
 * Every function that can fail returns an ExtricateStatus. If that is not EXTRICATE_OK,
 * extricate_last_error() says what is wrong. Handles belong to the caller, who frees each of them
 * once, with the function of its type; null may be given there. No handle has to outlive another: a
 * solver keeps its scene. Any number of threads may use one scene, solver or answer at the same
 * time; only extricate_solver_set_options() needs a solver for itself. A stream is for one thread
 * at a time. Strings are UTF-8 and end with a zero. Lengths are in metres, angles in radians.
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

// Nothing free was found, though nothing is wrong with the call.
#define EXTRICATE_NOTHING_FREE 1

// An argument is a null pointer, has a wrong length, or is an option that makes no sense.
#define EXTRICATE_ARGUMENT 2

// A configuration has a wrong length, is not finite, or is beyond limits while that is refused.
#define EXTRICATE_CONFIGURATION 3

// A file cannot be read or written.
#define EXTRICATE_FILE 4

// A scene, robot, mesh or world says something that cannot be used, or a name is unknown.
#define EXTRICATE_INPUT 5

// A model file is truncated, altered, foreign or of another version.
#define EXTRICATE_MODEL 6

// A fault of this library was caught.
#define EXTRICATE_INTERNAL 7

// Number of this interface: it grows if programs have to be compiled anew.
#define EXTRICATE_ABI 1

// Effort: the nearest stored sample of a model; without a model, the first exit that is found.
#define EXTRICATE_NEAREST 0

// Effort: descents from several starts in different directions; the best end is verified.
#define EXTRICATE_REFINED 1

// Effort: many starts and long refinement.
#define EXTRICATE_EXHAUSTIVE 2

// Effort: as refined, and then branch and bound until the gap is proved or a limit is reached.
#define EXTRICATE_PROVED 3

// Effort: as refined with fewer descents, which takes about half the checks.
#define EXTRICATE_QUICK 4

// Metric: the weighted change of the joints [rad or m].
#define EXTRICATE_METRIC_JOINT 0

// Metric: the root mean square displacement of the robot's solids [m].
#define EXTRICATE_METRIC_OBJECT_NORM 1

// Metric: the largest displacement of any point of the robot [m].
#define EXTRICATE_METRIC_MAX_DISPLACEMENT 2

// A lower bound above 0 is proved, or the query is free.
#define EXTRICATE_IS_PROVED 0

// No lower bound is proved: what collides are surfaces, which enclose nothing.
#define EXTRICATE_UNPROVED_SURFACES 1

// No lower bound is proved: the bodies overlap too little.
#define EXTRICATE_UNPROVED_SHALLOW 2

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

// Shape: balls of radius `size[0]` around `points` [m]; for obstacles alone.
#define EXTRICATE_POINTS 5

// Shape: occupied `cells` of side `size[0]` [m]; for obstacles alone.
#define EXTRICATE_VOXELS 6

// Shape: all behind a plane of normal `size` at `offset` [m] along it; for obstacles alone.
#define EXTRICATE_HALF_SPACE 7

// The answer to a query. It never changes, and what its functions point to lives as long as it.
typedef struct ExtricateAnswer ExtricateAnswer;

// A scene, perhaps with a model that was learned of it or of a scene like it. It never changes.
typedef struct ExtricateScene ExtricateScene;

// A scene with options of queries. Only extricate_solver_set_options() changes it.
typedef struct ExtricateSolver ExtricateSolver;

// Queries that follow each other closely, each of which begins with the exit of the one before.
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
    // EXTRICATE_BOX or another of the kinds.
    uint32_t kind;
    // Numbers that the kinds explain.
    double size[3];
    // Where the plane of a half-space is, along its unit normal [m].
    double offset;
    // Points, three numbers each [m].
    const double *points;
    // How many points.
    size_t point_count;
    // Triangles, three indices of points each.
    const uint32_t *triangles;
    // How many triangles.
    size_t triangle_count;
    // Cells, three indices each.
    const int32_t *cells;
    // How many cells.
    size_t cell_count;
    // Whether the convex hull of a mesh stands for it: 0 or 1.
    uint32_t convex;
} ExtricateShape;

// An obstacle, or an object for a link to hold.
typedef struct ExtricateObstacle {
    // Its name, which nothing else in the scene has.
    const char *name;
    // Its shape.
    struct ExtricateShape shape;
    // Its pose in the world; that of an object for a link, in the coordinates of the link.
    struct ExtricatePose pose;
} ExtricateObstacle;

// Options of a query. extricate_options_init() fills in the defaults; set what differs then.
// Any number but 0 counts as 1 in a member that is 0 or 1.
typedef struct ExtricateOptions {
    // How hard to try: EXTRICATE_NEAREST, _QUICK, _REFINED, _EXHAUSTIVE or _PROVED;
    // EXTRICATE_REFINED by default.
    uint32_t effort;
    // Whether to refuse configurations beyond the limits, in place of answering them: 0 or 1; 0 by
    // default.
    uint32_t refuse_outside;
    // Whether to prove how far around the witness nothing touches: 0 or 1; 0 by default.
    uint32_t free_radius;
    // Whether to tell how much of the straight segment to the witness collides: 0 or 1; 0 by
    // default.
    uint32_t segment;
    // Whether to tell contacts with EXTRICATE_NEAREST as well; the other efforts always do: 0 or
    // 1; 0 by default.
    uint32_t contacts;
    // How many distinct exits to look for: 1 to 100000; 1 by default.
    size_t exits;
    // How many descents to start: 1 to 100000; 0 by default, which leaves it to the effort.
    size_t starts;
    // Share of the depth that need not be proved, at which the search stops: 0 or more and less
    // than 1; nan by default, which leaves it to the effort.
    double gap;
    // Clearance that the witness is to keep: 0 to 1e9 [m]; nan by default, for that of the
    // scene.
    double clearance;
    // Most collision checks and distance evaluations to spend: 0 or more; SIZE_MAX by default, for
    // no limit.
    size_t max_checks;
    // Most seconds to spend: more than 0; infinity by default, for no limit.
    double max_seconds;
    // The names of joints that stay where the query has them; null by default, for none.
    const char *const *locked;
    // How many joints are locked.
    size_t locked_count;
    // The goal, a configuration: of exits that are about as near as the nearest, the one that is
    // nearest to it becomes the witness; null by default, for none.
    const double *toward;
    // How many numbers the goal has: those of a configuration.
    size_t toward_count;
    // By which share of its depth an exit may be farther than the nearest to count as about as
    // near: 0 to 1e9; 0.25 by default.
    double toward_share;
    // Ends a query early if it returns true; null by default, for none. It is called between the
    // steps of a query, on any thread, and on several at once. It must not throw.
    bool (*stop)(void*);
    // What `stop` is called with.
    void *stop_data;
} ExtricateOptions;

// What is known of an answer, in numbers.
typedef struct ExtricateSummary {
    // Distance from the query to the witness, in the scene's metric; 0 if the query is free,
    // infinity if nothing free was found.
    double depth;
    // Proved: no free configuration is nearer.
    double lower_bound;
    // Share of the depth that is not proved.
    double gap;
    // Largest displacement of any point of the robot, from the query to the witness [m].
    double max_displacement;
    // Estimated share of starts that would lead to an exit which was not met; nan if unknown.
    double unseen;
    // Clearance that the witness keeps [m], but for pairs with one of their own.
    double clearance;
    // Proved: nothing touches nearer to the witness than this; nan if it was not requested.
    double free_radius;
    // Fraction of the straight segment up to which a collision was found; nan if not requested.
    double segment_colliding_until;
    // Fraction from which on the straight segment is proved free; nan if not requested.
    double segment_free_from;
    // Collision checks and distance evaluations spent.
    uint64_t checks;
    // EXTRICATE_IS_PROVED, or why no lower bound is proved.
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
    // A free configuration, as many numbers as the query, which live as long as the answer.
    const double *witness;
} ExtricateExit;

// What is known of the segment between two configurations. Fractions are of its length.
typedef struct ExtricateSegment {
    // Proved: every configuration of the segment is free.
    bool is_free;
    // A collision was found. If neither this nor `is_free` is set, only `free_until` is proved.
    bool collides;
    // Proved: up to this fraction every configuration is free.
    double free_until;
    // Fraction at which a configuration collides, or nearly does if that is not proved; nan if the
    // segment is free.
    double at;
    // The bodies that do; both indices are SIZE_MAX if the segment is free.
    struct ExtricatePair pair;
} ExtricateSegment;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// What the last call that failed on this thread says is wrong: file or argument, value, and what
// was expected. It is empty if none failed, and stays until the next call on this thread fails, or
// the thread ends: destructors of its variables may find that messages are gone.
const char *extricate_last_error(void);

// Fails with this message and EXTRICATE_ARGUMENT. A layer on top of this interface calls it to
// refuse an argument as the functions here do: extricate_last_error() then gives the message.
ExtricateStatus extricate_refuse(const char *message);

// Version of the library, such as "0.2.0".
const char *extricate_version(void);

// EXTRICATE_ABI of the library; a program that was compiled with another one must not go on.
uint32_t extricate_abi(void);

// How many coordinates a configuration has; 0 for null.
size_t extricate_scene_nq(const struct ExtricateScene *scene);

// How many tangent coordinates there are: one for each coordinate, but three for a rotation, which
// has four coordinates; 0 for null.
size_t extricate_scene_nv(const struct ExtricateScene *scene);

// How many joints have coordinates; 0 for null. They are counted in the order of coordinates.
size_t extricate_scene_joint_count(const struct ExtricateScene *scene);

// Name of a joint, which lives as long as the scene; null if there is no such joint.
const char *extricate_scene_joint_name(const struct ExtricateScene *scene, size_t index);

// The first coordinate of a joint and how many it has; 0 and 0 if there is no such joint.
ExtricateStatus extricate_scene_joint_coordinates(const struct ExtricateScene *scene,
                                                  size_t index,
                                                  size_t *first,
                                                  size_t *count);

// Limits of all coordinates: `nq` lower and `nq` upper ones. Those of a continuous joint are minus
// and plus pi, which are the same place; those of a quaternion are minus and plus 1.
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

// The configuration that a message of ROS holds as text: a JointState, alone or in a RobotState, a
// PlanningScene or a request to plan. The end of `name` tells what it is: .yaml or .json. Messages
// of errors say `name`.
ExtricateStatus extricate_scene_config_text(const struct ExtricateScene *scene,
                                            const char *name,
                                            const char *text,
                                            double *q,
                                            size_t nq);

// How many bodies there are: links with geometry, obstacles, attached objects; 0 for null.
size_t extricate_scene_body_count(const struct ExtricateScene *scene);

// Name of a body, which lives as long as the scene; null if there is no such body.
const char *extricate_scene_body_name(const struct ExtricateScene *scene, size_t index);

// How many pairs of bodies are checked; 0 for null.
size_t extricate_scene_pair_count(const struct ExtricateScene *scene);

// A checked pair; both indices are SIZE_MAX if there is no such pair.
struct ExtricatePair extricate_scene_pair(const struct ExtricateScene *scene, size_t index);

// Least distance that free configurations keep, but for pairs with one of their own [m]; nan for
// null.
double extricate_scene_clearance(const struct ExtricateScene *scene);

// EXTRICATE_METRIC_JOINT or another metric, by which depths are measured.
uint32_t extricate_scene_metric(const struct ExtricateScene *scene);

// Whether a model was learned of this very scene, which extricate_save() then writes. A changed
// scene keeps the model of the scene before, whose samples are starts of queries there.
bool extricate_scene_is_learned(const struct ExtricateScene *scene);

// How many warnings there are, things to know of the scene: open meshes, defaults taken, what a
// message of MoveIt says that is not taken; 0 for null.
size_t extricate_scene_warning_count(const struct ExtricateScene *scene);

// A warning, which lives as long as the scene; null if there is no such warning.
const char *extricate_scene_warning(const struct ExtricateScene *scene, size_t index);

// Loads a scene file (TOML); a URDF, as a scene of that robot alone; or a model file, as the scene
// that was learned, with the model.
ExtricateStatus extricate_load(const char *path, struct ExtricateScene **scene);

// Makes a scene of the text of a scene file (TOML) or of a URDF, without a file.
//
// Paths in it start from `folder`, null for the working directory. If a path in the text is one of
// `texts`, that text stands for the file: so a URDF that a program holds needs no file either.
// Meshes are read from files.
ExtricateStatus extricate_scene_from_text(const char *text,
                                          const char *folder,
                                          const struct ExtricateText *texts,
                                          size_t text_count,
                                          struct ExtricateScene **scene);

// Makes one of the scenes that come with the library, such as "shelf-arm" or "planar-arm".
ExtricateStatus extricate_scene_builtin(const char *name, struct ExtricateScene **scene);

// Learns a model of the scene: stored samples, from which queries start too. It takes seconds for
// most robots. The result is the same scene with the model.
//
// `labels` are the exact checks to spend, 0 for the usual number; `seconds` is the most time, more
// than 0, infinity for no limit; `threads` is 0 for one a core. The model depends on scene, labels
// and seed alone, unless the limit in seconds ended learning.
ExtricateStatus extricate_learn(const struct ExtricateScene *scene,
                                size_t labels,
                                double seconds,
                                uint64_t seed,
                                size_t threads,
                                struct ExtricateScene **model);

// Writes a learned model to a file; extricate_load() reads it.
ExtricateStatus extricate_save(const struct ExtricateScene *model, const char *path);

// Prepares the scene for queries, as the first query or check of it does if this was not called.
// It takes milliseconds to seconds, the longest for meshes.
ExtricateStatus extricate_scene_prepare(const struct ExtricateScene *scene);

// Frees a scene; solvers, streams and answers that were made of it stay.
void extricate_scene_free(struct ExtricateScene *scene);

// The scene with obstacles elsewhere: `count` names, and their poses in the world.
ExtricateStatus extricate_scene_moved(const struct ExtricateScene *scene,
                                      const char *const *names,
                                      const struct ExtricatePose *poses,
                                      size_t count,
                                      struct ExtricateScene **changed);

// The scene with more obstacles.
ExtricateStatus extricate_scene_with_obstacles(const struct ExtricateScene *scene,
                                               const struct ExtricateObstacle *obstacles,
                                               size_t count,
                                               struct ExtricateScene **changed);

// The scene without the obstacles, or the objects that links hold, of these names.
ExtricateStatus extricate_scene_without(const struct ExtricateScene *scene,
                                        const char *const *names,
                                        size_t count,
                                        struct ExtricateScene **changed);

// The scene without any obstacle; objects that links hold stay.
ExtricateStatus extricate_scene_without_obstacles(const struct ExtricateScene *scene,
                                                  struct ExtricateScene **changed);

// The scene with these pairs of bodies no longer checked: two names a pair, one after the other.
ExtricateStatus extricate_scene_disabled(const struct ExtricateScene *scene,
                                         const char *const *names,
                                         size_t pair_count,
                                         struct ExtricateScene **changed);

// The scene with an object that a link holds, such as a can in a gripper. Its pose is in the
// coordinates of the link; it is checked against everything but what is fixed to the link and the
// bodies named in `touch`.
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

// The robots of the scene in the world of a text, as extricate_scene_in_world() takes a file. The
// end of `name` tells what it is: .toml, .scene, .yaml or .json; messages repeat the name.
ExtricateStatus extricate_scene_in_world_text(const struct ExtricateScene *scene,
                                              const char *name,
                                              const char *text,
                                              struct ExtricateScene **changed);

// Fills in the usual options.
ExtricateStatus extricate_options_init(struct ExtricateOptions *options);

// Makes a solver, which answers queries of the scene with these options. It keeps the scene, and
// shares what is prepared of it. Options are read now; null stands for the usual ones.
ExtricateStatus extricate_solver_new(const struct ExtricateScene *scene,
                                     const struct ExtricateOptions *options,
                                     struct ExtricateSolver **solver);

// Gives a solver other options for the queries that follow; null stands for the usual ones. No
// other thread may use the solver meanwhile.
ExtricateStatus extricate_solver_set_options(struct ExtricateSolver *solver,
                                             const struct ExtricateOptions *options);

// Queries configurations all over the space for about so many seconds, so that the first query
// that counts takes as long as those that follow: 0.03 s are enough. Answers stay the same.
ExtricateStatus extricate_solver_warm_up(const struct ExtricateSolver *solver, double seconds);

// Frees a solver; its answers stay.
void extricate_solver_free(struct ExtricateSolver *solver);

// The nearest free configuration to `q`, which is `nq` numbers, within the limits or beyond them.
// Writes an answer, to be freed with extricate_answer_free(). Returns EXTRICATE_NOTHING_FREE if
// nothing free was found: it may be rare, or locked joints, a clearance or a stop left nothing.
ExtricateStatus extricate_query(const struct ExtricateSolver *solver,
                                const double *q,
                                size_t nq,
                                struct ExtricateAnswer **answer);

// The witness of extricate_query() alone: writes `nq` numbers, those of `q` if it is free. Nothing
// is proved but what effort `proved` or a gap of the options ask for, which takes less time.
// Returns what extricate_query() does.
ExtricateStatus extricate_nearest_exit(const struct ExtricateSolver *solver,
                                       const double *q,
                                       size_t nq,
                                       double *witness);

// The numbers of an answer, such as depth and lower bound; null for null.
const struct ExtricateSummary *extricate_answer_summary(const struct ExtricateAnswer *answer);

// The free configuration, as many numbers as the query; null for null.
const double *extricate_answer_witness(const struct ExtricateAnswer *answer);

// How the depth changes with the query: `nv` numbers, in tangent coordinates; null for null.
const double *extricate_answer_gradient(const struct ExtricateAnswer *answer);

// Pairs that collide at the query, one of them alone with EXTRICATE_NEAREST unless contacts are
// reported: returns how many, and points to them.
size_t extricate_answer_colliding(const struct ExtricateAnswer *answer,
                                  const struct ExtricatePair **pairs);

// Pairs that touch at the witness: returns how many, and writes where they are.
size_t extricate_answer_touching(const struct ExtricateAnswer *answer,
                                 const struct ExtricatePair **pairs);

// Coordinates of the query that are beyond their limits: returns how many, and points to their
// indices.
size_t extricate_answer_outside(const struct ExtricateAnswer *answer, const size_t **coordinates);

// Where bodies touch at the witness: returns how many contacts, and writes where they are.
size_t extricate_answer_contacts(const struct ExtricateAnswer *answer,
                                 const struct ExtricateContact **contacts);

// The distinct exits, nearest first, if more than one was requested: returns how many, and writes
// where they are.
size_t extricate_answer_exits(const struct ExtricateAnswer *answer,
                              const struct ExtricateExit **exits);

// Frees an answer.
void extricate_answer_free(struct ExtricateAnswer *answer);

// Whether a configuration is free: within all limits, and every checked pair keeps the clearance.
// Exact, on the geometry of the scene.
ExtricateStatus extricate_check(const struct ExtricateSolver *solver,
                                const double *q,
                                size_t nq,
                                bool *is_free);

// Least signed distance of any checked pair [m]: negative if two bodies overlap, infinity if no
// pair is checked. It is exact if it is positive, and of convex shapes always.
ExtricateStatus extricate_distance(const struct ExtricateSolver *solver,
                                   const double *q,
                                   size_t nq,
                                   double *distance);

// Signed distances of all checked pairs [m], in the order of extricate_scene_pair().
// There are as many as extricate_scene_pair_count() says, and `pair_count` has to be that number.
ExtricateStatus extricate_pair_distances(const struct ExtricateSolver *solver,
                                         const double *q,
                                         size_t nq,
                                         double *distances,
                                         size_t pair_count);

// Whether the whole straight segment from one configuration to another is free: proved, not
// sampled. Both ends must be within the limits. `resolution` is how closely a first contact is
// enclosed [m]; 1e-4 is usual.
ExtricateStatus extricate_check_segment(const struct ExtricateSolver *solver,
                                        const double *from,
                                        const double *to,
                                        size_t nq,
                                        double resolution,
                                        struct ExtricateSegment *segment);

// How far two configurations are from each other, in the metric of the scene: that of depths.
ExtricateStatus extricate_metric_distance(const struct ExtricateScene *scene,
                                          const double *from,
                                          const double *to,
                                          size_t nq,
                                          double *distance);

// The nearest free configurations to `count` queries, one after another in `q`, of `nq` numbers
// each. Writes `count` witnesses in the same order and `count` summaries. If nothing free was
// found for a query, `found` of its summary is false and its witness is nan. Each answer is that
// of extricate_query() alone, whatever the number of threads (0: one a core). One wrong row fails
// the call before anything is queried.
ExtricateStatus extricate_query_batch(const struct ExtricateScene *scene,
                                      const struct ExtricateOptions *options,
                                      const double *q,
                                      size_t count,
                                      size_t nq,
                                      size_t threads,
                                      double *witnesses,
                                      struct ExtricateSummary *summaries);

// Whether each of `count` configurations is free, as extricate_check() tells it of one. They stand
// one after another in `q`, of `nq` numbers each; `threads` is 0 for one a core.
ExtricateStatus extricate_check_batch(const struct ExtricateScene *scene,
                                      const double *q,
                                      size_t count,
                                      size_t nq,
                                      size_t threads,
                                      bool *is_free);

// The least signed distance of any checked pair [m] at each of `count` configurations, as
// extricate_distance() tells it of one. They stand one after another in `q`, of `nq` numbers each;
// `threads` is 0 for one a core.
ExtricateStatus extricate_distance_batch(const struct ExtricateScene *scene,
                                         const double *q,
                                         size_t count,
                                         size_t nq,
                                         size_t threads,
                                         double *distances);

// Makes a stream, which answers queries that follow each other closely, the frames of one motion.
// Each begins with the exit of the one before. The stream keeps the scene; one thread at a time
// may use it.
//
// The exit of the last frame is kept until another is nearer by more than the share `hysteresis`
// of its depth, in [0, 1); 0 always takes the nearest. `starts_per_frame` other starts are tried
// each frame; 2 are usual.
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

// Gives a stream another scene for the frames that follow, such as one in which obstacles moved.
// It must have the same coordinates.
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
