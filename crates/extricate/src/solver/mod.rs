//! The solver: one handle on a scene, with a model or without, for queries, checks and motions.

mod batch;
mod checks;
mod memory;
mod preparing;
mod sampling;
mod shared;

use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::collision::Checker;
use crate::cspace::sampling::Halton;
use crate::cspace::{Config, Rows};
use crate::error::{Error, Result};
use crate::metric::Metric;
use crate::model::Model;
use crate::query::prepared::Prepared;
use crate::query::{Answer, Context, QueryOptions, QueryScratch, Stored, nearest_exit_under, query};
use crate::scene::Scene;
pub use batch::Answered;
pub(crate) use batch::in_blocks;
pub(crate) use memory::Memory;
pub use sampling::Sampler;
use shared::{Learned, Shared};

/// The handle on a scene: it finds nearest free configurations, checks, and finds motions.
///
/// A model adds stored samples as further starts; the guarantees are the same with and without one.
/// Threads may share a solver, and a clone shares all that is prepared.
///
/// ```
/// use extricate::{Effort, QueryOptions, Rows, Solver, builtin};
/// let solver = Solver::new(builtin::scene("planar-arm")?);
/// let q = solver.scene().config(&[0.0, 0.0, 0.0])?;
/// let answer = solver.query(&q).expect("something is free");
/// assert!(solver.check(&answer.witness) && answer.lower_bound <= answer.depth);
///
/// let solver = solver.options(QueryOptions::default().effort(Effort::Exhaustive))?;
/// let both = solver.batch(Rows::new(&[0.0, 0.0, 0.0, 0.5, 0.0, 0.0], 3)?)?;
/// assert_eq!(both[0], solver.query(&q));
/// # extricate::Result::Ok(())
/// ```
#[derive(Clone)]
pub struct Solver {
    shared: Arc<Shared>,
    options: QueryOptions,
}

impl Solver {
    /// Makes a solver of a scene without a model. Nothing is prepared yet, see [`Solver::prepare`].
    pub fn new(scene: impl Into<Arc<Scene>>) -> Self {
        Self::of(Shared::new(scene.into(), None, None))
    }

    /// Makes a solver of the scene that a model was learned in, with that model.
    pub fn of_model(model: impl Into<Arc<Model>>) -> Self {
        Self::of(Shared::at_home(model.into()))
    }

    fn of(shared: Shared) -> Self {
        Self { shared: Arc::new(shared), options: QueryOptions::default() }
    }

    /// Returns this solver with a model, which was learned in this scene or in one of the same
    /// joints and metric. Obstacles, checked pairs and clearance may differ.
    ///
    /// # Errors
    /// [`Error::Input`](crate::Error::Input) if coordinates, limits, weights or the metric differ;
    /// for the metrics of displacement, also if the moving bodies differ.
    pub fn with_model(&self, model: impl Into<Arc<Model>>) -> Result<Self> {
        let shared = self.shared.of_learned(model.into(), Arc::clone(self.scene()))?;
        Ok(Self { shared: shared.into(), options: self.options.clone() })
    }

    /// Returns this solver without a model.
    pub fn without_model(&self) -> Self {
        let shared = match self.shared.learned {
            None => Arc::clone(&self.shared),
            Some(_) => {
                let scene = Arc::clone(&self.shared.scene);
                Shared::new(scene, None, self.shared.passed_on()).into()
            }
        };
        Self { shared, options: self.options.clone() }
    }

    /// Returns this solver for another scene, such as one in which an obstacle moved
    /// ([`Scene::moved`]). It reuses what is prepared of equal bodies.
    ///
    /// # Guarantee
    /// Without a model, answers are those of [`Solver::new`]. A model's samples serve as starts
    /// that may collide; the guarantees of answers hold.
    ///
    /// # Errors
    /// Those of [`Solver::with_model`]; [`Error::Option`] if options of this solver name joints or
    /// a goal that the scene does not have.
    pub fn with_scene(&self, scene: impl Into<Arc<Scene>>) -> Result<Self> {
        let scene = scene.into();
        self.check_options(&self.options, &scene)?;
        let shared = match &self.shared.learned {
            None => Shared::new(scene, None, self.shared.passed_on()),
            Some(learned) => self.shared.of_learned(Arc::clone(&learned.model), scene)?,
        };
        Ok(Self { shared: shared.into(), options: self.options.clone() })
    }

    /// Returns this solver with other weights of joints in the metric, see [`Scene::weighted`]. It
    /// drops the model, whose samples are stored by the metric that was learned.
    ///
    /// # Errors
    /// Those of [`Scene::weighted`].
    pub fn weighted<'a>(&self, weights: impl IntoIterator<Item = (&'a str, [f64; 2])>) -> Result<Self> {
        self.without_model().with_scene(self.scene().weighted(weights)?)
    }

    /// Returns this solver with other options of queries.
    ///
    /// # Errors
    /// [`Error::Option`](crate::Error::Option) for an option that makes no sense, see
    /// [`QueryOptions::check`]; also for a goal or locked joints that the scene does not have.
    pub fn options(self, options: QueryOptions) -> Result<Self> {
        options.check()?;
        self.check_options(&options, self.scene())?;
        Ok(Self { options, ..self })
    }

    /// Options of the queries of this solver.
    pub fn query_options(&self) -> &QueryOptions {
        &self.options
    }

    /// Checks that the locked joints and the goal of `options` fit `scene`.
    fn check_options(&self, options: &QueryOptions, scene: &Scene) -> Result<()> {
        let (joints, nq) = (scene.joints.len(), scene.space.nq());
        if let Some(bad) = options.locked.iter().find(|joint| **joint >= joints) {
            let expected = format!("indices below the {joints} joints");
            return Err(Error::Option { name: "locked", value: bad.to_string(), expected });
        }
        options.keep.iter().try_for_each(|keep| keep.check_links(scene))?;
        if let Some(bad) = options.touch.iter().find(|pair| pair.index() >= scene.pairs.len()) {
            let expected = format!("indices below the {} checked pairs", scene.pairs.len());
            return Err(Error::Option { name: "touch", value: bad.index().to_string(), expected });
        }
        if !options.touch.is_empty() && scene.pairs != self.scene().pairs {
            let (value, expected) = ("those of other bodies".into(), "checked pairs of the scene".into());
            return Err(Error::Option { name: "touch", value, expected });
        }
        let names = |scene: &Scene| scene.links.iter().map(|link| link.name.clone()).collect::<Vec<_>>();
        if !options.keep.is_empty() && names(scene) != names(self.scene()) {
            let (value, expected) = ("those of other links".into(), "links of the scene".into());
            return Err(Error::Option { name: "keep", value, expected });
        }
        if !options.locked.is_empty() && scene.joints != self.scene().joints {
            let (value, expected) = ("those of other joints".into(), "joints of the scene".into());
            return Err(Error::Option { name: "locked", value, expected });
        }
        match options.toward.as_ref().map(|toward| toward.goal.len()).filter(|length| *length != nq) {
            Some(length) => {
                let (value, expected) = (format!("{length} coordinates"), format!("{nq}"));
                Err(Error::Option { name: "toward", value, expected })
            }
            None => Ok(()),
        }
    }

    /// The scene that is queried.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.shared.scene
    }

    /// The model, if there is one, whichever scene it was learned in.
    pub fn model(&self) -> Option<&Arc<Model>> {
        self.shared.learned.as_ref().map(|learned| &learned.model)
    }

    /// Returns whether there is a model that was learned in this scene.
    pub fn is_learned(&self) -> bool {
        self.shared.learned.as_ref().is_some_and(|learned| learned.is_at_home)
    }

    /// Prepares all that answers need: the checker, the metric and the convex pieces around meshes.
    /// The first query does it too; checks prepare only what they need. Later calls cost nothing.
    ///
    /// # Cost
    /// Some tenths of a second for a robot of raw meshes, on all cores.
    pub fn prepare(&self) {
        self.shared.ready();
    }

    /// Returns whether [`Solver::prepare`] has nothing left to do.
    pub fn is_prepared(&self) -> bool {
        self.shared.is_ready()
    }

    /// Returns whether the checker and the metric are prepared.
    pub fn has_checker(&self) -> bool {
        self.shared.has_checker()
    }

    /// The exact checker of the scene; the first call prepares it.
    pub fn checker(&self) -> &Checker {
        self.shared.prepared().checker()
    }

    /// The metric that depths are measured in.
    pub fn metric(&self) -> &Arc<Metric> {
        self.shared.prepared().metric()
    }

    pub(crate) fn prepared(&self) -> &Prepared {
        self.shared.ready()
    }

    pub(crate) fn memory(&self) -> &Memory {
        &self.shared.memory
    }

    /// Borrows what a query reads: the prepared scene and, if there is a model, its stored samples.
    pub(crate) fn context(&self) -> Context<'_> {
        let prepared = self.shared.ready();
        match &self.shared.learned {
            None => prepared.with(None),
            Some(Learned { model, is_at_home: true }) => prepared.with(Some(model.stored())),
            Some(Learned { model, is_at_home: false }) => {
                prepared.with(Some(Stored { holding: Some(&[]), ..model.stored() }))
            }
        }
    }

    /// Finds the nearest free configuration to `q` and a proved lower bound. Returns `None` if
    /// nothing free was found, not even among 20,000 configurations (2,000 if links are kept). So
    /// it does if locked joints or a clearance leave nothing, or if the search for a first witness
    /// was stopped.
    ///
    /// # Guarantee
    /// The exact checker called the witness free during this call, and the lower bound is proved.
    /// With [`Effort::Nearest`](crate::Effort::Nearest) of a model in its own scene, the checker
    /// did so when the model was learned. Without a limit in seconds, the answer depends on the
    /// scene, the model, `q` and the options alone.
    pub fn query(&self, q: &Config) -> Option<Answer> {
        self.shared.memory.of_queries(|scratch| query(&self.context(), q, &self.options, scratch))
    }

    /// Finds the witness of [`Solver::query`] alone, for example for a simulator that resets a
    /// state in collision. It proves only what effort `proved` or a gap of the options demands. It
    /// returns `None` as a query does, and `q` itself if that is free.
    ///
    /// # Guarantee
    /// The exact checker called it free, as for a query. The default gap, which ends queries, does
    /// not apply, so the result may be nearer than their witness.
    ///
    /// ```
    /// # use extricate::{Solver, builtin};
    /// let solver = Solver::new(builtin::scene("planar-arm")?);
    /// let q = solver.scene().config(&[0.0, 0.1, 0.2])?;
    /// let witness = solver.nearest_exit(&q).expect("something is free");
    /// assert!(solver.check(&witness));
    /// # extricate::Result::Ok(())
    /// ```
    pub fn nearest_exit(&self, q: &Config) -> Option<Config> {
        let find = |scratch: &mut QueryScratch| {
            nearest_exit_under(&self.context(), q, &self.options, false, scratch).map(|answer| answer.witness)
        };
        self.shared.memory.of_queries(find)
    }

    /// Answers all rows, in order, on all cores.
    ///
    /// # Guarantee
    /// Each answer is that of [`Solver::query`].
    ///
    /// # Errors
    /// If a row is not finite, or not as long as a configuration; the coordinate is named.
    pub fn batch(&self, rows: Rows) -> Result<Vec<Option<Answer>>> {
        let space = &self.scene().space;
        let configs = rows.iter().map(|row| space.config_anywhere(row)).collect::<Result<Vec<Config>>>()?;
        let mut answers = Vec::with_capacity(configs.len());
        self.batch_each(configs, 0, &mut |answered| {
            answers.push(answered.answer);
            ControlFlow::Continue(())
        });
        Ok(answers)
    }

    /// Answers many queries on `threads` threads (0: one per core) and passes the answers, in
    /// order, to `each`, which may end the batch. Returns the number of answers passed on.
    ///
    /// # Guarantee
    /// Each answer is that of [`Solver::query`], whatever the number of threads. At most 4096
    /// answers are held at a time, or one per thread if there are more threads than that.
    pub fn batch_each(
        &self,
        queries: impl IntoIterator<Item = Config>,
        threads: usize,
        each: &mut dyn FnMut(Answered<Option<Answer>>) -> ControlFlow<()>,
    ) -> usize {
        self.prepare();
        let context = self.context();
        let ask = |q: &Config, scratch: &mut QueryScratch| query(&context, q, &self.options, scratch);
        in_blocks(&mut queries.into_iter(), threads, self.memory(), &ask, each)
    }

    /// Queries configurations spread over the whole space for about as long as `duration`, so that
    /// the first query that counts takes as long as later ones. The first hundred queries of a
    /// program take up to twice as long; 30 ms of warming up are enough.
    pub fn warm_up(&self, duration: Duration) {
        let (space, started) = (&self.scene().space, Instant::now());
        let (halton, mut q) = (Halton::new(space.nv(), 1), vec![0.0; space.nq()]);
        let configs = (0..).map_while(|index| {
            halton.config(space, index, &mut q);
            (started.elapsed() < duration).then(|| space.config(&q))
        });
        configs.flatten().for_each(|q| {
            self.query(&q);
        });
    }
}

impl fmt::Debug for Solver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (bodies, pairs) = (self.scene().bodies.len(), self.scene().pairs.len());
        let model = self.model().map(|model| model.statistics().boundary_samples);
        let mut told = f.debug_struct("Solver");
        told.field("bodies", &bodies).field("pairs", &pairs).field("stored_samples", &model);
        told.field("options", &self.options).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::LearnOptions;
    use crate::scene::builtin;

    fn scene() -> Scene {
        builtin::scene("planar-arm").unwrap()
    }

    #[test]
    fn public_types_can_be_printed() {
        fn printed<T: fmt::Debug>() {}
        printed::<(Solver, crate::Stream, Sampler, Model, Checker, Metric, crate::CheckScratch)>();
        printed::<(crate::Hand, crate::Roadmap, crate::files::OutputLock, crate::files::GrowingFile)>();
        let told = format!("{:?}", Solver::new(scene()));
        assert!(told.starts_with("Solver { bodies: "), "{told}");
    }

    #[test]
    fn changes_share_and_let_go() {
        let first = Solver::new(scene());
        let unprepared = first.with_scene(first.scene().without_obstacles()).unwrap();
        let strong = || Arc::strong_count(&first.shared);
        assert_eq!(strong(), 1, "nothing to share yet");
        first.prepare();
        let second = first.with_scene(first.scene().without_obstacles()).unwrap();
        assert_eq!(strong(), 2, "kept until the second is prepared");
        let third = second.with_scene(Arc::clone(first.scene())).unwrap();
        assert_eq!(strong(), 3, "what was never prepared passes on what it has");
        let q = first.scene().config(&[0.4, 0.0, 0.0]).unwrap();
        let answers = [&first, &unprepared, &second, &third].map(|solver| solver.query(&q).unwrap());
        assert_eq!(strong(), 1);
        assert!(answers[0].depth > 0.0);
        assert_eq!(answers[0], answers[3]);
        assert_eq!([answers[1].depth, answers[2].depth], [0.0, 0.0]);
    }

    #[test]
    fn a_model_is_at_home_in_an_equal_scene_alone() {
        let options = LearnOptions { labels: 2_000, ..LearnOptions::default() };
        let model = Arc::new(Model::learn(scene(), &options).unwrap());
        let solver = Solver::new(scene()).with_model(Arc::clone(&model)).unwrap();
        assert!(solver.is_learned());
        let q = solver.scene().config(&[0.4, 0.0, 0.0]).unwrap();
        assert_eq!(solver.query(&q), Solver::of_model(Arc::clone(&model)).query(&q));
        let emptied = solver.with_scene(scene().without_obstacles()).unwrap();
        assert!(!emptied.is_learned() && emptied.model().is_some());
        assert_eq!(emptied.query(&q).unwrap().depth, 0.0);
        assert!(emptied.with_scene(scene()).unwrap().is_learned());
        assert!(solver.without_model().model().is_none());
        let weighted = solver.weighted([("joint_1", [4.0, 4.0])]).unwrap();
        assert!(weighted.model().is_none() && weighted.query(&q).unwrap().depth > 0.0);
        let other = Solver::new(builtin::scene("hand").unwrap()).with_model(model);
        assert!(other.unwrap_err().to_string().contains("learn it anew"));
    }

    #[test]
    fn a_loaded_model_is_prepared_when_it_says_so() {
        let options = LearnOptions { labels: 2_000, ..LearnOptions::default() };
        let learned = Model::learn(builtin::scene("shelf-arm").unwrap(), &options).unwrap();
        let solver = Solver::of_model(Model::from_bytes("m", &learned.to_bytes()).unwrap());
        assert!(!solver.is_prepared() && !solver.has_checker());
        let q = vec![0.1; solver.scene().space.nq()];
        solver.check(&q);
        assert!(solver.has_checker() && !solver.is_prepared(), "checks need no pieces");
        solver.prepare();
        assert!(solver.is_prepared() && solver.checker().has_pieces() && !solver.checker().lacks_pieces());
        let again = solver.without_model();
        again.prepare();
        assert!(Arc::ptr_eq(again.metric(), solver.metric()), "the same scene is prepared once");
    }

    #[test]
    fn options_of_other_joints_are_refused() {
        let solver = Solver::new(scene());
        let goal = solver.scene().config(&[0.1, 0.2, 0.3]).unwrap();
        let toward = QueryOptions::default().toward(crate::query::Toward::new(goal, 0.25));
        let locked = QueryOptions::default().locked(vec![0]);
        let hand = || builtin::scene("hand").unwrap();
        for (options, part) in [(toward, "toward: got 3 coordinates, expected 5"), (locked, "locked: got those of")] {
            let refused = solver.clone().options(options).unwrap().with_scene(hand()).unwrap_err().to_string();
            assert!(refused.contains(part), "{refused}");
        }
        let refused = solver.clone().options(QueryOptions::default().locked(vec![3])).unwrap_err().to_string();
        assert!(refused.contains("locked: got 3, expected indices below the 3 joints"), "{refused}");
        let mut stream = solver.stream(crate::StreamOptions::default()).unwrap();
        let hand = Solver::new(hand());
        let q = hand.scene().config(&[0.0; 5]).unwrap();
        assert!(stream.query_in(&hand, &q).unwrap_err().to_string().contains("other joints"));
    }

    #[test]
    fn threads_of_a_pool_prepare_a_shared_solver() {
        let solver = Solver::new(builtin::scene("shelf-arm").unwrap());
        let q = solver.scene().config(&vec![0.1; solver.scene().space.nq()]).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
        let asked = pool.broadcast(|_| solver.query(&q).unwrap());
        assert!(asked.iter().all(|answer| *answer == asked[0]));
    }
}
