//! Memory of a run, counted from the lengths of its lists: so it does not depend on where the run was stopped and resumed.

use super::super::run_state::RunState;
use super::Learner;
use crate::boundary::SampleSet;
use crate::boundary::trace::Tracer;
use crate::learning::LearnOptions;
use crate::learning::explore::Exploration;
use crate::metric::Metric;

/// Part of the memory, one in so many, that exploration fills at most: the boundary needs the rest.
const EXPLORATION_PART: usize = 3;
/// How many copies of the lists there are beside them while a checkpoint is written.
const COPIES_TO_STORE: usize = 2;

impl Learner {
    /// Memory that the run holds, counted \[bytes\]: lists, indices over them, what exits know of their contacts, and on top of these what is
    /// larger, the index that [`Learner::finish`] will make or a checkpoint. Kernel rows of training are bounded besides. Not counted: scene
    /// and checker, what a thread works with, and what a unit of work holds only while it lasts.
    pub fn bytes(&self) -> usize {
        let RunState { known, samples, solved, .. } = &self.state;
        let nq = self.scene().space.nq();
        let indexed = |rows: usize, exits: usize| SampleSet::bytes(&self.ground.metric, nq, rows, exits);
        let starts = self.tracer.as_ref().map_or(0, |t| indexed(t.place().starts, 0) + indexed(t.place().indexed, 0));
        let (solver, solved_from) = self.solver.as_ref().map_or((0, 0), |set| (set.bytes_of_planes(), set.exits()));
        let solver_index = self.solver.as_ref().map_or(0, |set| indexed(set.len(), set.exits()));
        // Exits are alike in what they know. While it is gathered there are two of it.
        let planes = 2 * solver / solved_from.max(1) * solved.exits;
        let finished = indexed(samples.len() / nq, solved.exits) + planes;
        let listed = known.bytes() + size_of_val(&samples[..]);
        listed + starts + solver + solver_index + finished.max(COPIES_TO_STORE * listed)
    }
}

/// Whether what was explored, as the first pass of tracing will hold it, fills its part of the memory.
pub fn is_full(metric: &Metric, known: &Exploration, nq: usize, options: &LearnOptions) -> bool {
    let starts = Tracer::first_place(known, nq).starts;
    known.bytes() + SampleSet::bytes(metric, nq, starts, 0) > options.memory / EXPLORATION_PART
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::super::EndedBy;
    use super::*;
    use crate::scene::builtin;

    /// Every unit that was not the last left the count within the limit, and so does exploration by far.
    #[test]
    fn a_run_ends_where_its_memory_is_full() {
        let memory = 4 << 20;
        let options = LearnOptions { labels: 2_000_000, seconds: None, seed: 1, memory, ..LearnOptions::default() };
        let mut learner = Learner::new(builtin::scene("planar-arm").unwrap(), &options).unwrap();
        let (mut counted, mut go_on) = (vec![0], |_: &_| ControlFlow::Continue(()));
        while learner.step(&mut go_on) {
            counted.push(learner.bytes());
            if learner.state().samples.is_empty() {
                assert!(counted[counted.len() - 1] < memory, "{} while exploring", counted[counted.len() - 1]);
            }
        }
        // The one before the last exceeds it, after which nothing is done but measure.
        let over = counted.iter().position(|bytes| *bytes > memory).unwrap();
        assert!(over + 1 == counted.len() && counted[over] < 2 * memory, "{counted:?} of {memory}");
        let statistics = learner.finish(&mut go_on).unwrap().statistics().clone();
        assert_eq!(statistics.ended_by, EndedBy::Memory);
        println!("{} samples of {} labels", statistics.boundary_samples, statistics.labels);
        assert!(statistics.boundary_samples > 2000, "{}", statistics.boundary_samples);
    }
}
