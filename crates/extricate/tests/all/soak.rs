//! Many queries, each answer judged by another library's distances. The long version is `cargo run --release --example soak`.

use std::ops::ControlFlow;
use std::sync::Arc;

use extricate::cspace::sampling::Halton;
use extricate::{CheckScratch, Checker, Label, Model, QueryOptions};

use crate::recheck::Recheck;

/// What went wrong in a run over one scene, in words; and how many queries collided.
#[derive(Debug, Default)]
pub struct Findings {
    pub asked: usize,
    pub colliding: usize,
    pub faults: Vec<String>,
}

/// Asks `model` for `count` low-discrepancy configurations from index `from` on, and judges every answer. `tell` hears of progress.
pub fn soak(
    model: &Model,
    options: &QueryOptions,
    from: u64,
    count: usize,
    threads: usize,
    tell: &mut dyn FnMut(&Findings),
) -> Findings {
    let scene = model.scene();
    let space = &scene.space;
    let recheck = Recheck::new(scene);
    // Nothing that a query has touched: another checker, with memory of its own.
    let (checker, mut check) = (Checker::new(Arc::new(scene.clone())), CheckScratch::default());
    let halton = Halton::new(space.nv(), 17);
    let query = |index: usize| {
        let mut q = vec![0.0; space.nq()];
        halton.config(space, from + index as u64, &mut q);
        space.config(&q).expect("a sample is a configuration")
    };
    let mut findings = Findings::default();
    model.query_batch((0..count).map(query), options, threads, &mut |answered| {
        let (q, answer) = (query(answered.index), &answered.answer);
        findings.asked += 1;
        let mut fault = |what: &str| findings.faults.push(format!("{what}: query {:?}, {answer:?}", &q[..]));
        if answer.depth == 0.0 {
            if !recheck.agrees_free(&q) {
                fault("called free, but collides");
            }
        } else {
            if !recheck.agrees_colliding(&q) {
                fault("called colliding, but is free");
            }
            if !recheck.agrees_free(&answer.witness) || checker.label(&answer.witness, &mut check) != Label::Free {
                fault("the witness collides");
            }
            if !space
                .config(&answer.witness)
                .is_ok_and(|w| w.iter().zip(&answer.witness).all(|(a, b)| (a - b).abs() < 1e-9))
            {
                fault("the witness is out of limits");
            }
            let distance = model.metric().distance(&q, &answer.witness);
            if (distance - answer.depth).abs() > 1e-9 + 1e-6 * distance {
                fault("the witness is not at the depth");
            }
            if !(0.0..=answer.depth).contains(&answer.lower_bound) {
                fault("the lower bound is above the depth");
            }
        }
        findings.colliding += usize::from(answer.depth > 0.0);
        tell(&findings);
        ControlFlow::Continue(())
    });
    if findings.asked != count {
        findings.faults.push(format!("{} answers to {count} queries", findings.asked));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::learn;
    use extricate::scene::builtin;

    #[test]
    fn no_answer_is_wrong_or_missing() {
        for name in builtin::NAMES {
            let model = learn(builtin::scene(name).unwrap(), 6_000, 3);
            let findings = soak(&model, &QueryOptions::default(), 0, 150, 0, &mut |_| {});
            assert!(
                findings.faults.is_empty(),
                "{name}: {} faults, first: {}",
                findings.faults.len(),
                findings.faults[0]
            );
            assert!(findings.colliding > 10, "{name}: {} of 150 collide", findings.colliding);
        }
    }
}
