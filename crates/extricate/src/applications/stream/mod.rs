//! Streams of queries that follow each other closely, as from a simulation or a haptic device.

mod detour;
mod follower;
mod proxy;

use std::fmt;

pub use follower::{Follower, StreamOptions};
pub(crate) use proxy::DEFAULT_MARGIN_M;

use crate::cspace::Config;
use crate::error::{Error, Result};
use crate::query::Answer;
use crate::solver::Solver;

impl Solver {
    /// Opens a stream of queries that follow each other closely, with the options of this solver.
    ///
    /// # Errors
    /// [`Error::Option`](crate::Error::Option) for an option that makes no sense.
    pub fn stream(&self, options: StreamOptions) -> Result<Stream> {
        options.check()?;
        if options.continuous && !self.query_options().touch.is_empty() {
            let (value, expected) =
                ("pairs that touch".into(), "none in a continuous stream, whose proxy moves straight".into());
            return Err(Error::Option { name: "touch", value, expected });
        }
        let follower = Follower::new(options, self.query_options().clone());
        Ok(Stream { solver: self.clone(), follower })
    }
}

/// Answers the frames of one motion, each search starting from the answer before. It has a memory:
/// its answers depend on the frames before.
///
/// ```
/// use extricate::{Solver, StreamOptions, builtin};
/// let solver = Solver::new(builtin::scene("planar-arm")?);
/// let mut stream = solver.stream(StreamOptions::default())?;
/// for step in 0..5 {
///     let q = solver.scene().config(&[0.0, 0.01 * f64::from(step), 0.0])?;
///     let answer = stream.query(&q).expect("something is free");
///     assert!(answer.lower_bound <= answer.depth);
/// }
/// # extricate::Result::Ok(())
/// ```
pub struct Stream {
    solver: Solver,
    follower: Follower,
}

impl Stream {
    /// Answers the next frame; returns `None` as [`Solver::query`] does, and if the proxy of a
    /// continuous stream cannot keep the links.
    ///
    /// # Guarantee
    /// The guarantee of [`Solver::query`] holds. While the query stands still, all starts of a
    /// refined query are tried within as many frames as their number divided by `starts_per_frame`.
    pub fn query(&mut self, q: &Config) -> Option<Answer> {
        self.follower.query(&self.solver.context(), q)
    }

    /// Answers a frame in the scene of another solver, such as one by [`Solver::with_scene`]. The
    /// options stay those of the stream.
    ///
    /// # Errors
    /// [`Error::Input`](crate::Error::Input) if that scene has other joints.
    pub fn query_in(&mut self, solver: &Solver, q: &Config) -> Result<Option<Answer>> {
        if solver.scene().joints != self.solver.scene().joints {
            let problem = "got other joints than the stream's, expected the same: begin a stream of that scene";
            return Err(Error::input("scene", "joints", problem));
        }
        Ok(self.follower.query(&solver.context(), q))
    }

    /// Forgets the frames so far, so that the next one is answered as a query on its own.
    pub fn restart(&mut self) {
        self.follower.restart();
    }

    /// The solver that opened this stream.
    pub fn solver(&self) -> &Solver {
        &self.solver
    }
}

impl fmt::Debug for Stream {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Stream").field("solver", &self.solver).finish_non_exhaustive()
    }
}
