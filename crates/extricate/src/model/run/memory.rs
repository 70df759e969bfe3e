//! Memory of a run, counted from the lengths of its lists: so it does not depend on where the run
//! was stopped and resumed.

use super::Run;
use super::work::{Found, Work};
use crate::samples::SampleSet;

/// How many copies of the lists there are beside them while a checkpoint is written.
const COPIES_TO_STORE: usize = 2;

/// Of lists, indices over them, what exits know of their contacts, and on top of these what is
/// larger, the index that the end will make or a checkpoint \[bytes\].
pub fn bytes<W: Work>(run: &Run<W>) -> usize {
    let (Found { samples, exits, apart, bytes: listed, .. }, nq) = (run.work.found(), run.ground.nq());
    let indexed = |rows: usize, exits: usize| SampleSet::bytes(&run.ground.metric, nq, rows, exits);
    let traced = run.work.traced(run.tracer.as_ref());
    let starts = traced.map_or(0, |place| indexed(place.starts, 0) + indexed(place.indexed, 0));
    let solver = run.solver.as_ref();
    let solver_bytes = solver.map_or(0, |set| set.bytes_of_planes() + indexed(set.len(), set.solved()));
    // Exits are alike in what they know. While it is gathered there are two of it.
    let exits = exits + apart.len() / nq;
    let planes = run.work.bytes_of_two_exits(solver) * exits;
    let finished = indexed((samples.len() + apart.len()) / nq, exits) + planes;
    listed + starts + solver_bytes + finished.max(COPIES_TO_STORE * listed)
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use crate::learning::LearnOptions;
    use crate::model::EndedBy;
    use crate::model::learner::Learner;
    use crate::scene::builtin;

    /// Every unit that was not the last left the count within the limit, and so does exploration by
    /// far.
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
