//! How a search is made to prove its answer: branch and bound until the gap is closed.

use super::Search;
use crate::cspace::Label;
use crate::query::bound::branch_and_bound::{Branches, Step};
use crate::query::bound::groups::Groups;
use crate::query::descent::Start;

/// Branch and bound until the gap is closed, the budget is spent or nothing can be expanded.
pub fn prove(search: &mut Search) {
    if search.is_proved() || !Branches::can_search(search.context) || !search.known.incumbent.verified {
        return;
    }
    let Some(gap) = search.known.proof.gap else { return };
    let mut branches = std::mem::take(&mut search.known.proof.branches);
    let mut groups = Groups::default();
    groups.split(search.context, &search.known.proof.colliding);
    if groups.count() > 1 {
        prove_groups(search, &groups, gap, &mut branches);
    }
    if !search.is_proved() {
        let bound = branch(search, &mut branches, None, gap);
        search.known.proof.proved = search.known.proof.proved.max(bound);
    }
    search.known.proof.branches = branches;
}

/// Each group of pairs by itself, while the others stay where the incumbent has them: their
/// squares add.
fn prove_groups(search: &mut Search, groups: &Groups, gap: f64, branches: &mut Branches) {
    let mut squared = 0.0;
    for group in 0..groups.count() {
        let holds: Vec<bool> = (0..search.context.checker.scene().space.nv()).map(|v| groups.holds(group, v)).collect();
        squared += branch(search, branches, Some(&holds), gap).powi(2);
    }
    search.known.proof.proved = search.known.proof.proved.max(f64::sqrt(squared));
}

/// Branch and bound over all coordinates, or some; what it proves.
fn branch(search: &mut Search, branches: &mut Branches, holds: Option<&[bool]>, gap: f64) -> f64 {
    let (context, q) = (search.context, search.known.anchor.q.clone());
    branches.begin(context, &q, holds, &search.known.incumbent.config);
    // Of the incumbent, what is of these coordinates.
    let mut depth = branches.length(context, &q, &search.known.incumbent.config);
    let mut next = 1;
    while !search.evaluator.is_spent() {
        search.evaluator.checks += 1;
        match branches.step(context, &q, (1.0 - gap) * depth, &mut search.evaluator.check) {
            Step::Closed | Step::Full => break,
            Step::Free(found) => {
                depth = depth.min(found);
                offer(search, branches.config());
            }
            // Near what is left there may be exits that no descent has found.
            Step::Open if branches.expanded() >= next => {
                next *= 2;
                let ceiling = search.known.incumbent.depth;
                let config = branches.config().to_vec();
                if let (Some(found), _) = search.descend_alone(Start::at(&config), ceiling, search.plan.polish) {
                    search.keep(found);
                    depth = depth.min(branches.length(context, &q, &search.known.incumbent.config));
                }
            }
            Step::Open => {}
        }
    }
    branches.bound()
}

/// Makes a configuration the incumbent if it is free and nearer.
fn offer(search: &mut Search, config: &[f64]) {
    let depth = search.evaluator.distance(search.context, &search.known.anchor, config);
    if depth < search.known.incumbent.depth && search.evaluator.label(search.context, config) == Label::Free {
        search.known.take(depth, config, true);
    }
}
