//! Asking: one view of a model, of a changed scene or of a world without a model, and the solver
//! that keeps memory and options from one query to the next.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use crate::collision::Checker;
use crate::cspace::sampling::Halton;
use crate::cspace::{Config, Rows};
use crate::error::Result;
use crate::query::answer::Answer;
use crate::query::batch::{Answered, in_blocks};
use crate::query::context::Context;
use crate::query::nearest_exit::query;
use crate::query::options::QueryOptions;
use crate::query::search::scratch::QueryScratch;
use crate::query::stream::Stream;
use crate::scene::Scene;

/// What queries are answered from: a model in its own scene ([`crate::Model::view`]), a model in
/// another one ([`crate::Model::in_scene`]), or a world without a model ([`crate::World::view`]).
/// Costs nothing to copy.
#[derive(Clone, Copy)]
pub struct View<'a> {
    context: Context<'a>,
}

impl<'a> View<'a> {
    pub(crate) fn new(context: Context<'a>) -> Self {
        Self { context }
    }

    pub(crate) fn context(&self) -> &Context<'a> {
        &self.context
    }

    /// The scene that queries are about.
    pub fn scene(&self) -> &'a Scene {
        self.context.checker.scene()
    }

    /// Its exact checker.
    pub fn checker(&self) -> &'a Checker {
        self.context.checker
    }

    /// The nearest free configuration to `q`, with default options. `None` where nothing free was
    /// found: of a model, only in a changed scene.
    ///
    /// # Guarantee
    /// The witness was verified during this call, and the lower bound is proved.
    ///
    /// # Cost
    /// Memory is made for this query alone; see [`View::solver`].
    pub fn query(&self, q: &Config) -> Option<Answer> {
        self.solver(QueryOptions::default()).query(q)
    }

    /// Answers with these options, and keeps memory between queries. One for each thread.
    pub fn solver(&self, options: QueryOptions) -> Solver<'a> {
        Solver { view: *self, options, scratch: QueryScratch::default() }
    }

    /// As [`View::query`], with options, and memory that the caller keeps. `None` also where joints
    /// are locked or a clearance is aimed at, and nothing free was found, or where the search for a
    /// first witness was stopped.
    ///
    /// # Guarantee
    /// That of [`View::query`]; with [`crate::Effort::Nearest`] the witness was verified when the
    /// model was learned. In a changed scene samples are verified anew as they are needed, which
    /// [`Answer::checks`] counts.
    pub fn query_with(&self, q: &Config, options: &QueryOptions, scratch: &mut QueryScratch) -> Option<Answer> {
        query(&self.context, q, options, scratch)
    }

    /// The answer for the next frame of a stream of queries that are near each other: begun from
    /// the last one, see [`Stream`]. Another view may be taken in every frame, as where obstacles
    /// move.
    ///
    /// # Guarantee
    /// That of [`View::query_with`]; but the answer also depends on the frames before.
    pub fn query_next(&self, q: &Config, stream: &mut Stream) -> Option<Answer> {
        stream.query(&self.context, q)
    }

    /// Gives the answers to many queries, in order, to `each`, which may end it; returns how many
    /// were given. Works on `threads` threads (0: one a core).
    ///
    /// # Guarantee
    /// Each answer is that of [`View::query_with`] alone (unless a limit in seconds ends it),
    /// whatever the number of threads. At most 4096 answers are held at a time.
    pub fn query_batch(
        &self,
        queries: impl IntoIterator<Item = Config>,
        options: &QueryOptions,
        threads: usize,
        each: &mut dyn FnMut(Answered<Option<Answer>>) -> ControlFlow<()>,
    ) -> usize {
        let answer = |q: &Config, scratch: &mut QueryScratch| self.query_with(q, options, scratch);
        in_blocks(&mut queries.into_iter(), threads, &answer, each)
    }

    /// [`Solver::warm_up`] with memory that the caller keeps.
    pub fn warm_up(&self, options: &QueryOptions, scratch: &mut QueryScratch, duration: Duration) {
        let (space, started) = (&self.scene().space, Instant::now());
        let (halton, mut q) = (Halton::new(space.nv(), 1), vec![0.0; space.nq()]);
        let configs = (0..).map_while(|index| {
            halton.config(space, index, &mut q);
            (started.elapsed() < duration).then(|| space.config(&q))
        });
        configs.flatten().for_each(|q| {
            self.query_with(&q, options, scratch);
        });
    }
}

/// Options, and memory that stays from one query to the next.
///
/// ```
/// use extricate::{Effort, QueryOptions, Rows, World, builtin};
/// let world = World::new(builtin::scene("planar-arm")?);
/// let options = QueryOptions { effort: Effort::Exhaustive, ..QueryOptions::default() };
/// let mut solver = world.solver(options);
/// let answer = solver.query(&world.scene().config(&[0.0, 0.0, 0.0])?).expect("something is free");
/// assert!(answer.lower_bound <= answer.depth);
/// let both = solver.batch(Rows::new(&[0.0, 0.0, 0.0, 0.5, 0.0, 0.0], 3)?)?;
/// assert_eq!(both[0].as_ref(), Some(&answer));
/// # extricate::Result::Ok(())
/// ```
pub struct Solver<'a> {
    view: View<'a>,
    options: QueryOptions,
    scratch: QueryScratch,
}

impl Solver<'_> {
    /// The options of every query.
    pub fn options(&self) -> &QueryOptions {
        &self.options
    }

    /// The nearest free configuration to `q`, see [`View::query_with`].
    pub fn query(&mut self, q: &Config) -> Option<Answer> {
        self.view.query_with(q, &self.options, &mut self.scratch)
    }

    /// The answers to all rows, in order, on all cores.
    ///
    /// # Errors
    /// Where a row is not finite, or not as long as a configuration; the row is named.
    pub fn batch(&self, rows: Rows) -> Result<Vec<Option<Answer>>> {
        let space = &self.view.scene().space;
        let configs = rows.iter().map(|row| space.config_anywhere(row)).collect::<Result<Vec<Config>>>()?;
        let mut answers = Vec::with_capacity(configs.len());
        self.view.query_batch(configs, &self.options, 0, &mut |answered| {
            answers.push(answered.answer);
            ControlFlow::Continue(())
        });
        Ok(answers)
    }

    /// Queries configurations spread over the whole space, for about as long as `duration`, so that
    /// the first query that counts takes as long as those that follow. The first hundred of a
    /// program that has just loaded a model take up to twice as long: code and samples are not yet
    /// near the processor, and there is no memory. 30 ms are enough.
    ///
    /// # Guarantee
    /// Answers stay the same.
    pub fn warm_up(&mut self, duration: Duration) {
        self.view.warm_up(&self.options, &mut self.scratch, duration);
    }
}
