//! Proof of an answer by branch and bound.

use super::Search;
use crate::cspace::Label;
use crate::query::bound::branch_and_bound::{Branches, Step};
use crate::query::groups::Groups;

/// Raises the lower bound by branch and bound until the gap is closed, the budget is spent or
/// nothing can be expanded.
pub fn prove(search: &mut Search) {
    if search.is_proved() || !Branches::can_search(search.context) {
        return;
    }
    let Some(gap) = search.known.proof.gap else { return };
    let mut branches = std::mem::take(&mut search.known.proof.branches);
    let mut groups = Groups::default();
    groups.split(search.context, search.known.proof.colliding.iter().copied());
    if groups.roots().count() > 1 {
        prove_groups(search, &groups, gap, &mut branches);
    }
    if !search.is_proved() {
        let bound = branch(search, &mut branches, None, gap);
        search.known.proof.raise(bound);
    }
    search.known.proof.branches = branches;
}

/// Bounds each group of pairs by itself, while other joints stay where the exit has them. The
/// squares of the bounds add.
fn prove_groups(search: &mut Search, groups: &Groups, gap: f64, branches: &mut Branches) {
    let nv = search.context.checker.scene().space.nv();
    let mut squared = 0.0;
    for root in groups.roots() {
        let holds: Vec<bool> = (0..nv).map(|v| groups.holds(root, v)).collect();
        squared += branch(search, branches, Some(&holds), gap).powi(2);
    }
    search.known.proof.raise(f64::sqrt(squared));
}

/// Runs branch and bound over all coordinates, or those that `holds` marks; returns the bound.
fn branch(search: &mut Search, branches: &mut Branches, holds: Option<&[bool]>, gap: f64) -> f64 {
    let (context, q) = (search.context, search.known.anchor.q.clone());
    let nearest = |search: &Search| search.known.exits.nearest().map(|end| end.config.clone()).unwrap_or_default();
    let exit = nearest(search);
    branches.begin(context, &q, holds, &exit);
    // Only these coordinates count in the depth to reach.
    let mut depth = branches.length(context, &q, &exit);
    let mut next = 1;
    while !search.evaluator.is_spent() {
        search.evaluator.checks += 1;
        match branches.step(context, &q, (1.0 - gap) * depth, &mut search.evaluator.check) {
            Step::Closed | Step::Full => break,
            Step::Free(found) => {
                depth = depth.min(found);
                offer(search, branches.config());
            }
            // Exits that no descent has found may lie near an open branch.
            Step::Open if branches.expanded() >= next => {
                next *= 2;
                let (ceiling, config) = (search.known.exits.depth(), branches.config().to_vec());
                if let Some(found) = search.descend_alone(&config, ceiling, search.plan.polish) {
                    search.keep(found, false);
                    depth = depth.min(branches.length(context, &q, &nearest(search)));
                }
            }
            Step::Open => {}
        }
    }
    branches.bound()
}

/// Offers a configuration if it is free and nearer than every exit.
fn offer(search: &mut Search, config: &[f64]) {
    let depth = search.evaluator.distance(search.context, &search.known.anchor, config);
    if depth < search.known.exits.depth() && search.evaluator.label(search.context, config) == Label::Free {
        search.offer_free(config);
    }
}
