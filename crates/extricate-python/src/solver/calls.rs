//! The calls that `Solver`, `Scene` and `Model` share. A scene answers as a solver without a model
//! does; a model answers as a solver of its own scene with this model.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::Solver;
use super::stream::Stream;
use crate::entries::lists::Names;
use crate::error::{Seed, Whole};
use crate::model::Model;
use crate::motion::roadmap::Roadmap;
use crate::motion::{escape, plan, release, repair};
use crate::queries;
use crate::queries::batch;
use crate::queries::page::{self, Shown};
use crate::queries::signed_distance;
use crate::scene::Scene;

/// Defines the shared calls for a class; `batch` is the name of its call for many queries.
macro_rules! calls {
    ($class:ident, $batch:ident) => {
        #[pymethods]
        impl $class {
            /// Finds the nearest free configuration to q. Nothing has to be learned first.
            ///
            /// q: float64 (nq,). A q beyond limits is not free; distances are measured from it as
            ///     it is, and `Answer.outside` names the joints.
            /// options: a `QueryOptions` that holds these keywords; a keyword beside it overrides
            ///     its field.
            /// effort: "nearest" (the nearest stored sample of a model, or one nearly as near;
            ///     without a model the first exit found), "quick" (fewer starts than refined),
            ///     "refined" (descents from several starts, the nearest exit verified),
            ///     "exhaustive", or "proved": as refined, then until the gap is proved or the
            ///     budget is spent; set max_seconds.
            /// exits: number of distinct exits to find, for `Answer.exits`.
            /// gap: stop as soon as it is proved that nothing free is nearer by more than this
            ///     share of the depth; effort "proved" works for it. None is 0.15 with "quick" and
            ///     "refined", 0.05 with "proved", and does not stop "exhaustive". With 0, no proof
            ///     stops the search. Not with several exits.
            /// starts: number of stored samples and configurations around q from which descents
            ///     start; None leaves it to the effort. Fewer are faster and miss the nearest exit
            ///     more often. Not with effort "nearest".
            /// max_checks, max_seconds: limits at which to stop early, with the best answer so far;
            ///     more of either never gives a larger depth.
            /// segment: whether to check the straight segment to the witness, see `Answer.segment`;
            ///     costs as much as many checks.
            /// contacts: with effort "nearest", whether to report every colliding pair, not one
            ///     alone, and the contacts at the witness; both take longer than to find it. The
            ///     other efforts always report them.
            /// clearance: clearance to aim at [m] in place of the scene's, for pairs without one of
            ///     their own. A witness that would be more than ten times as far as the nearest at
            ///     the scene's clearance keeps less, see `Answer.clearance`.
            /// locked: names of joints that stay where q has them.
            /// free: in place of `locked`, the names of the joints that may move.
            /// keep: links that stay where they are, a name or a mapping, or a list of these:
            ///     {"link": "tool0", "position": 1e-4, "rotation": 1e-3} are the tolerances [m] and
            ///     [rad] that apply if none are given; None lets the link move or rotate freely.
            ///     "pose" is a pose to bring it to, as `Box` takes it; "relative_to" another link
            ///     in whose coordinates the pose is kept; with "axis" (3,), only this axis of the
            ///     link keeps its direction. See `Answer.kept`.
            /// touch: pairs of names of bodies, as [("leg", "ground")], that have to touch at the
            ///     witness: their distance is at most 0.5 mm beyond the clearance. None is found if
            ///     they cannot.
            /// weights: by joint, weights of squared displacements in place of the scene's, in the
            ///     joint metric; the search then ignores what was learned.
            /// toward, toward_share: a configuration and a share. Among exits that are farther than
            ///     the nearest by at most that share of its depth, the query takes the one nearest
            ///     to the configuration.
            /// free_radius: whether to prove how far around the witness nothing touches, see
            ///     `Answer.free_radius`; costs as much as many checks.
            /// limits: "forgive" answers configurations beyond the limits, "refuse" raises
            ///     ValueError for them.
            ///
            /// Returns an `Answer`; None if nothing free was found, not even among 20,000
            /// configurations (2,000 if links are kept), or if locked joints leave nothing. Then,
            /// if some pairs collide in every drawn configuration, a warning names them. The search
            /// for them runs once, whatever `max_checks` and `max_seconds` are. If warnings are
            /// errors, the call raises the warning in place of all its answers.
            ///
            /// Raises ValueError for a wrong shape, values that are not finite, options that make
            /// no sense.
            #[pyo3(signature = (q, **options), text_signature = "($self, q, *, options=None, effort='refined', exits=1, gap=None, starts=None, max_checks=None, max_seconds=None, segment=False, contacts=False, clearance=None, locked=None, free=None, keep=None, touch=None, weights=None, toward=None, toward_share=0.25, free_radius=False, limits='forgive')")]
            fn query<'py>(
                slf: &Bound<'py, Self>,
                q: &Bound<'py, PyAny>,
                options: Option<&Bound<'py, PyDict>>,
            ) -> PyResult<Option<Bound<'py, PyAny>>> {
                queries::query(slf.get().handle(), q, options, slf)
            }

            /// Finds the nearest free configuration to each of Q, on many threads.
            ///
            /// Q: float64 (n, nq); beyond limits as in `query`. A C-contiguous array is not copied;
            ///     do not write to it meanwhile.
            /// options, effort, gap, starts, max_checks, max_seconds: as in `query`, for each row.
            /// exits: number of distinct exits to find.
            /// segment: whether to check the straight segments to the witnesses; costs as much as
            ///     many checks.
            /// contacts: whether to report the pairs that collide and that touch; with effort
            ///     "nearest" that takes longer than to find the witness.
            /// clearance, locked, free, keep, touch, weights, toward, toward_share, free_radius,
            ///     limits: as in `query`, for each row.
            /// errors: "raise", or "mask": a row that is no configuration gets a depth of nan, and
            ///     the others are answered as usual.
            /// threads: 0 for one per core.
            ///
            /// Returns a structured array (n,) with the fields depth, lower_bound, gap,
            /// max_displacement [m], clearance, unseen, checks, witness (nq,), gradient (nv,),
            /// verified, free and unique, with the meanings that they have in `Answer`. Options add
            /// fields:
            ///
            /// several exits: exit_count, the number found (0 if the query is free), exit_depths
            ///     (exits,) and exit_witnesses (exits, nq), nearest first, the witness before
            ///     others, nan from exit_count on;
            /// segment: segment (2,), nan if the query is free;
            /// free_radius: free_radius, nan if the query is free;
            /// keep, touch: kept (links + pairs, 2), how far each kept link is off at the witness
            ///     [m, rad], then how far each pair is beyond the clearance [m, 0]; nan if the
            ///     query is free;
            /// contacts: colliding and touching, bool (pairs,), in the order of `Scene.pairs`; with
            ///     several exits also exit_touching, (exits, pairs). `query` returns points and
            ///     normals of contacts.
            ///
            /// If nothing free was found for a row, its depth is inf, its witness, gradient and
            /// max_displacement are nan, verified and free are False, and it has no exits; the call
            /// warns as `query` does.
            ///
            /// Raises ValueError for a wrong shape or values that are not finite, before it answers
            /// any row; the message names the row.
            #[pyo3(signature = (Q, **options), text_signature = "($self, Q, *, options=None, effort='refined', exits=1, gap=None, starts=None, max_checks=None, max_seconds=None, segment=False, contacts=False, clearance=None, locked=None, free=None, keep=None, touch=None, weights=None, toward=None, toward_share=0.25, free_radius=False, limits='forgive', errors='raise', threads=0)")]
            #[allow(non_snake_case)]
            fn $batch<'py>(
                &self,
                Q: &Bound<'py, PyAny>,
                options: Option<&Bound<'py, PyDict>>,
            ) -> PyResult<Bound<'py, PyAny>> {
                batch::answers(self.handle(), Q, options)
            }

            /// Computes how far each of Q is from the boundary of the free configurations, in the
            /// scene's metric: minus the depth for one that collides, else the distance to the
            /// nearest one in contact. Limits of joints are no contacts.
            ///
            /// Q: float64 (n, nq), or (nq,) for one; beyond limits as in `query`.
            /// within: a distance beyond which a free configuration is far enough: the search ends
            ///     once nothing is proved to touch within it. None searches on.
            /// max_checks, max_seconds: limits at which to stop early, for each row.
            /// threads: 0 for one per core.
            ///
            /// Returns a structured array (n,), or a record for one, with the fields
            /// distance (negative inside, inf if nothing in contact was found, or none within
            /// `within`), bound (proved, of the same sign: nothing nearer is on the other side),
            /// witness (nq,) (the nearest free configuration, or the nearest in contact, which is
            /// free and just touches; nan if there is none), gradient (nv,) (of the distance; unit
            /// in the metric), pair (index into `pairs`: one that collides, or that touches at the
            /// witness; -1 if there is none), checks and cut_short. If a row collides and nothing
            /// free was found, its numbers are nan, and the call warns as `query` does.
            ///
            /// The true distance of a free row lies between bound and distance.
            ///
            /// Raises ValueError for a wrong shape, values that are not finite, options that make
            /// no sense.
            #[pyo3(signature = (Q, *, within = None, max_checks = None, max_seconds = None, threads = 0))]
            #[allow(non_snake_case)]
            fn signed_distance<'py>(
                &self,
                Q: &Bound<'py, PyAny>,
                within: Option<f64>,
                max_checks: Option<Whole>,
                max_seconds: Option<f64>,
                threads: i64,
            ) -> PyResult<Bound<'py, PyAny>> {
                signed_distance::signed_distance(self.handle(), Q, (within, max_checks, max_seconds, threads))
            }

            /// Proves how far around each of Q everything is free, in the scene's metric. It is
            /// about the bound of `signed_distance`, without the search for a contact.
            ///
            /// Q: float64 (n, nq), or (nq,) for one.
            /// threads: 0 for one per core.
            ///
            /// Returns float64 (n,), or a float for one: every configuration nearer than this that
            /// is within the limits is free; 0 for one that is not free.
            ///
            /// Raises ValueError for a wrong shape and values that are not finite.
            #[pyo3(signature = (Q, *, threads = 0))]
            #[allow(non_snake_case)]
            fn free_radius<'py>(&self, Q: &Bound<'py, PyAny>, threads: i64) -> PyResult<Bound<'py, PyAny>> {
                signed_distance::free_radius(self.handle(), Q, threads)
            }

            /// Makes a `Stream`, for queries that follow each other closely, as from a simulation:
            /// each is warm-started from the one before.
            ///
            /// options, effort, gap, starts, max_checks, max_seconds, segment, contacts, clearance,
            ///     locked, free, keep, touch, weights, free_radius, limits: as in `query`, for each
            ///     frame.
            /// hysteresis: keep the exit of the last frame until another one is nearer by more than
            ///     this share of its depth; 0 always takes the nearest.
            /// starts_per_frame: number of starts that each frame tries for a nearer exit, besides
            ///     those that cost no check.
            /// continuous: whether the witness never jumps: from frame to frame it only moves if
            ///     every configuration on its way is proved free. Something may then hold it back
            ///     while another exit is nearer (`Answer.nearest`), or while the query is free. It
            ///     aims at `clearance`, by default 0.5 mm more than the scene's; hysteresis has no
            ///     effect.
            #[pyo3(signature = (**options), text_signature = "($self, *, options=None, effort='refined', hysteresis=0.0, starts_per_frame=2, continuous=False, gap=None, starts=None, max_checks=None, max_seconds=None, segment=False, contacts=False, clearance=None, locked=None, free=None, keep=None, touch=None, weights=None, free_radius=False, limits='forgive')")]
            fn stream(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Stream> {
                Stream::new(py, self.handle(), options)
            }

            /// Shows configurations and their answers as a page, in a browser or a notebook: the
            /// robot, a ghost of the query, contacts, the slider to each exit, the numbers and the
            /// proof, and a slice of the space.
            ///
            /// Q: float64 (n, nq), or (nq,) for one; None draws 5 random ones in collision.
            /// path: the file to write; None writes a temporary one.
            /// open: whether a browser opens the page; None opens it outside notebooks, which show
            ///     the returned page.
            /// live: whether users can drag joints in the page.
            /// All other keywords: as in `query`; exits is 3 if the effort finds several.
            #[pyo3(signature = (Q = None, *, path = None, open = None, live = false, **options))]
            #[allow(non_snake_case)]
            fn show<'py>(
                &self,
                py: Python<'py>,
                Q: Option<&Bound<'py, PyAny>>,
                path: Option<PathBuf>,
                open: Option<bool>,
                live: bool,
                options: Option<&Bound<'py, PyDict>>,
            ) -> PyResult<Bound<'py, PyAny>> {
                page::show(py, self.handle(), Q, options, Shown { path, open, live })
            }

            /// Finds a path out of collision: from q to a free configuration. On the way, no pair
            /// of bodies collides that does not collide at q, and no pair that does gets deeper by
            /// more than `tolerance`.
            ///
            /// q: a configuration within its limits, (nq,).
            /// aim: clearance that the end is to keep [m]; None is the scene's plus 1 mm. The
            ///     search prefers a near end that keeps less, at least the scene's, to a far one.
            /// tolerance: by how much a pair that collides at q may get deeper [m].
            /// keep: links that keep their places at q, or given poses, all along the path; as in
            ///     `query`.
            /// toward: a configuration, (nq,). Of exits that are about as near, the search prefers
            ///     the one nearest to it.
            /// exits: number of exits to try straight edges to.
            /// resolution: how finely edges are proved [m].
            /// tree_checks: checks of the trees that grow if nothing simpler leads out.
            /// seed: seed of all random numbers.
            /// max_checks, max_seconds: limits at which to give up.
            ///
            /// Returns an `Escape`; its `points` are None if no path was found, and the call warns
            /// as `query` does. All that it reports of the path is proved for every configuration
            /// between, not for samples.
            ///
            /// Raises ValueError for a wrong shape, values beyond limits, kept links that are off
            /// at q, options that make no sense.
            #[pyo3(signature = (q, *, aim = None, tolerance = 1e-3, keep = None, toward = None, exits = Whole::Number(6), resolution = 1e-4, tree_checks = Whole::Number(20_000), seed = Seed(0), max_checks = None, max_seconds = None), text_signature = "($self, q, *, aim=None, tolerance=1e-3, keep=None, toward=None, exits=6, resolution=1e-4, tree_checks=20000, seed=0, max_checks=None, max_seconds=None)")]
            fn escape<'py>(
                &self,
                q: &Bound<'py, PyAny>,
                aim: Option<f64>,
                tolerance: f64,
                keep: Option<Bound<'py, PyAny>>,
                toward: Option<Bound<'py, PyAny>>,
                exits: Whole,
                resolution: f64,
                tree_checks: Whole,
                seed: Seed,
                max_checks: Option<Whole>,
                max_seconds: Option<f64>,
            ) -> PyResult<Bound<'py, PyAny>> {
                let keywords = (aim, tolerance, keep, toward, exits, resolution, tree_checks, seed.0, max_checks, max_seconds);
                escape::escape(self.handle(), q, keywords)
            }

            /// Finds a path between two configurations, also through narrow passages. Every edge of
            /// it is proved. An end that collides is first led out of collision, as by `escape`.
            ///
            /// start, goal: configurations, (nq,).
            /// roadmap: a `Roadmap` of earlier calls, which this one adds to.
            /// resolution: how finely edges are proved [m].
            /// tolerance: depth [m] by which a pair that collides at an end may get deeper on the
            ///     path.
            /// keep: links that keep their places at the start, or given poses, all along the path;
            ///     as in `query`. Such plans neither use nor extend the roadmap.
            /// clearance: clearance [m] that the points of the free path are pushed off to, or as
            ///     much of it as they can keep nearby. None leaves the path short; with keep, it
            ///     has to be None.
            /// shortcut: whether to shorten the path.
            /// seed: seed of all random numbers.
            /// threads: threads that grow the roadmap, 0 for one per core; the path is the same.
            /// max_checks, max_seconds: limits at which to give up.
            ///
            /// Returns a `Plan`; its `points` are None if no path was found.
            ///
            /// Raises ValueError for a wrong shape, ends beyond their limits, kept links that are
            /// off at an end, options that make no sense.
            #[pyo3(signature = (start, goal, *, roadmap = None, resolution = 1e-4, tolerance = 1e-3, keep = None, clearance = None, shortcut = true, seed = Seed(0), threads = 0, max_checks = Some(Whole::Number(1_000_000)), max_seconds = None), text_signature = "($self, start, goal, *, roadmap=None, resolution=1e-4, tolerance=1e-3, keep=None, clearance=None, shortcut=True, seed=0, threads=0, max_checks=1000000, max_seconds=None)")]
            fn plan<'py>(
                &self,
                start: &Bound<'py, PyAny>,
                goal: &Bound<'py, PyAny>,
                roadmap: Option<Bound<'py, Roadmap>>,
                resolution: f64,
                tolerance: f64,
                keep: Option<Bound<'py, PyAny>>,
                clearance: Option<f64>,
                shortcut: bool,
                seed: Seed,
                threads: i64,
                max_checks: Option<Whole>,
                max_seconds: Option<f64>,
            ) -> PyResult<Bound<'py, PyAny>> {
                let keywords = (roadmap, resolution, tolerance, keep, clearance, shortcut, seed.0, threads, max_checks, max_seconds);
                plan::plan(self.handle(), (start, goal), keywords)
            }

            /// Replaces a path that collides by one that is proved free, as near to the old one as
            /// the search finds. Free parts of the old path stay.
            ///
            /// path: configurations one after the other, (n, nq).
            /// aim: clearance to push configurations out to [m], or as much of it as they can keep
            ///     nearby. None is the scene's plus a tenth of the radius of the smallest moving
            ///     body.
            /// max_deviation: largest distance, in the scene's metric, of the new path from the old
            ///     one, and from the new one of rows that it cuts off; None for no limit.
            /// keep: links that keep their places at the first row, or given poses, all along the
            ///     path; as in `query`. With frames, each row keeps them where it has them.
            /// frames: whether the rows are frames of a motion. The result then has one row for
            ///     each, at the same time, 0.5 mm off what it touches unless `aim` says otherwise.
            /// max_step: with frames, but not with keep, the longest step from row to row, in the
            ///     scene's metric. The result lags behind longer steps. None for no limit.
            /// touch: with frames, pairs of bodies that are at most this far apart [m] beyond the
            ///     clearance in a row, or overlap there, stay as near if they can, such as a sole
            ///     and the ground. The default of `aim` is then at most half of it. None keeps no
            ///     contacts.
            /// resolution: how finely edges are proved [m].
            /// seed: seed of all random numbers.
            /// max_checks, max_seconds: limits at which to give up.
            ///
            /// Returns a `Repaired`; its `points` are None if no path was found.
            ///
            /// Raises ValueError for a wrong shape, rows beyond limits, options that make no sense.
            #[pyo3(signature = (path, *, aim = None, max_deviation = None, keep = None, frames = false, max_step = None, touch = None, resolution = 1e-4, seed = Seed(0), max_checks = Some(Whole::Number(100_000)), max_seconds = None), text_signature = "($self, path, *, aim=None, max_deviation=None, keep=None, frames=False, max_step=None, touch=None, resolution=1e-4, seed=0, max_checks=100000, max_seconds=None)")]
            fn repair<'py>(
                &self,
                path: &Bound<'py, PyAny>,
                aim: Option<f64>,
                max_deviation: Option<f64>,
                keep: Option<Bound<'py, PyAny>>,
                frames: bool,
                max_step: Option<f64>,
                touch: Option<f64>,
                resolution: f64,
                seed: Seed,
                max_checks: Option<Whole>,
                max_seconds: Option<f64>,
            ) -> PyResult<Bound<'py, PyAny>> {
                let keywords = (aim, max_deviation, keep, frames, max_step, touch, resolution, seed.0, max_checks, max_seconds);
                repair::repair(self.handle(), path, keywords)
            }

            /// Finds the nearest hands to Q that penetrate nothing. Links that touched the object
            /// still touch it, each finger on its side. It uses no model.
            ///
            /// Q: float64 (n, nq), or (nq,) for one; it may be beyond the limits.
            /// object: the object that is held: the name of an obstacle; an obstacle that is not in
            ///     the scene, such as a `Mesh`; or a sequence of n obstacles, one a row (one that
            ///     occurs several times is prepared once).
            /// keep: "contacts", or "pose": the nearest free hand, whatever it touches.
            /// touch: a link touches if it is nearer than this [m] beyond the clearance.
            /// friction: coefficient of friction, for `Grasp.epsilon` and `Grasp.force_closure`;
            ///     None leaves them out.
            /// open: a configuration with open fingers (nq,), which shows on which side of the
            ///     object each finger is; None takes 0 for every joint, or the limit nearest to it.
            /// clearance: clearance to aim at in place of the scene's [m].
            /// locked: names of joints that stay; "base" is the base of a floating hand.
            /// weights: as in `query`. With None, if the scene gives a floating base no weights,
            ///     moving it costs about as much as moving fingers. "scene" takes the scene's.
            /// max_checks: end each row after about this many checks and contact evaluations.
            /// max_seconds: end each row after about this many seconds.
            /// threads: 0 for one per core; the answers are the same.
            ///
            /// Returns a `Grasp` for one row, else a list; None if nothing free was found.
            ///
            /// Raises ValueError for wrong shapes, names and values, and objects that cannot be
            /// used.
            #[pyo3(signature = (Q, *, object, keep = "contacts", touch = 2e-3, friction = Some(0.8), open = None, clearance = None, locked = Names::default(), weights = None, max_checks = None, max_seconds = None, threads = 0), text_signature = "($self, Q, *, object, keep='contacts', touch=2e-3, friction=0.8, open=None, clearance=None, locked=(), weights=None, max_checks=None, max_seconds=None, threads=0)")]
            #[allow(non_snake_case)]
            fn release<'py>(
                &self,
                Q: &Bound<'py, PyAny>,
                object: &Bound<'py, PyAny>,
                keep: &str,
                touch: f64,
                friction: Option<f64>,
                open: Option<&Bound<'py, PyAny>>,
                clearance: Option<f64>,
                locked: Names,
                weights: Option<&Bound<'py, PyAny>>,
                max_checks: Option<Whole>,
                max_seconds: Option<f64>,
                threads: i64,
            ) -> PyResult<Bound<'py, PyAny>> {
                let lengths = (touch, friction, clearance);
                let keywords = (keep, lengths, open, locked, weights, max_checks, max_seconds, threads);
                release::release(self.handle(), Q, object, keywords)
            }
        }
    };
}

calls!(Solver, batch);
calls!(Scene, query_batch);
calls!(Model, query_batch);
