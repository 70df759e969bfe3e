//! The search of all groups, and the combination of their exits.

use std::sync::Arc;

use super::known::Known;
use super::polish::polish;
use super::run::run;
use super::scratch::{GroupMemory, GroupResult, QueryScratch};
use super::sources::take_stored;
use super::{Hint, Search};
use crate::query::context::{Context, Stored};
use crate::query::groups::{Groups, coordinates};
use crate::query::plan::Plan;
use crate::scene::PairId;

#[derive(Clone, Copy)]
pub struct Pairs<'a> {
    /// Pairs that collide at the query.
    pub at_query: &'a [PairId],
    /// Pairs that collide at the query moved onto the joint limits.
    pub at_rest: &'a [PairId],
}

/// Searches the groups of the colliding pairs, combines their exits and verifies the result.
/// Returns the estimated share of starts that would lead to unmet exits; `None` if nothing free was
/// found.
pub fn search_groups(
    context: &Context,
    plan: Plan,
    pairs: Pairs,
    hint: &mut Hint,
    scratch: &mut QueryScratch,
) -> Option<f64> {
    let mut groups = std::mem::take(&mut scratch.groups);
    let mut memory = std::mem::take(&mut scratch.group_memory);
    let has_samples = context.stored.is_some() && !context.is_constrained();
    let are_free = context.stored.is_some_and(|stored| stored.holding.is_none());
    scratch.known.may_fall_back = has_samples && are_free && scratch.known.looks_anywhere;
    groups.split(context, pairs.at_rest.iter().copied());
    groups.join_carried(context);
    // A kept link moves with joints of any group, and so do pairs that have to touch.
    if groups.roots().next().is_none() || context.is_held() {
        groups.join_all(context);
    }
    let mut believes = !context.checker.all_convex();
    let unseen = loop {
        let is_one = groups.are_one(context);
        scratch.known.believes = believes;
        let unseen = match is_one {
            true => search_one(context, plan, pairs.at_query, hint, scratch),
            false => search_each(context, plan, pairs.at_query, &mut groups, (hint, &mut memory), scratch),
        };
        let mut whole = Search::whole(context, plan, scratch);
        if has_samples && whole.known.looks_anywhere {
            if unseen.is_none() {
                whole.known.exits.clear();
            }
            // A spent budget may fall back on this sample, so it always counts: a larger budget
            // must never lead farther.
            take_stored(&mut whole);
        }
        if whole.known.exits.len() > 0 && polish(&mut whole) {
            break unseen.or(Some(1.0));
        }
        if is_one && !believes || scratch.evaluator.is_stopped() {
            break None;
        }
        // The convex pieces around meshes may have misled the search: repeat it with exact checks.
        believes &= !is_one;
        groups.join_all(context);
    };
    (scratch.groups, scratch.group_memory) = (groups, memory);
    unseen
}

/// Searches the joints that are not locked as one group.
fn search_one(
    context: &Context,
    plan: Plan,
    colliding: &[PairId],
    hint: &mut Hint,
    scratch: &mut QueryScratch,
) -> Option<f64> {
    scratch.known.begin_group(colliding.iter().copied());
    scratch.evaluator.begin_group();
    let mut search = Search::whole(context, plan, scratch);
    search.believes = search.known.believes;
    search.turn = hint.turn;
    run(&mut search);
    hint.turn = search.turn;
    (scratch.known.exits.len() > 0).then(|| scratch.known.unseen())
}

/// Searches one group after another, until no two of them collide in their combined exit. `known`
/// then holds that exit.
///
/// A group is searched as if it were alone: pairs that other joints move too are left out. If none
/// of these collides in the combined exit, the separate searches lost nothing. If one does, the
/// joints that move it become one group.
fn search_each(
    context: &Context,
    plan: Plan,
    colliding: &[PairId],
    groups: &mut Groups,
    (hint, memory): (&mut Hint, &mut GroupMemory),
    scratch: &mut QueryScratch,
) -> Option<f64> {
    memory.forget_found();
    let turn = hint.turn;
    loop {
        while let Some(root) = groups.next_unsearched() {
            memory.drop_found(|found| groups.root(found.root) == root);
            // Every group tries the same starts of the stream.
            hint.turn = turn;
            search_group(context, plan, colliding, (groups, root), (hint, memory), scratch)?;
        }
        combine(context, plan, groups, memory, scratch);
        if !join_colliding(context, groups, memory, scratch) {
            break;
        }
        if groups.are_one(context) {
            return search_one(context, plan, colliding, hint, scratch);
        }
    }
    Some(1.0 - memory.found.iter().map(|found| 1.0 - found.unseen).product::<f64>())
}

/// Searches the group of a root for the pairs that it alone moves, while all other joints stay
/// where the query has them.
fn search_group(
    context: &Context,
    plan: Plan,
    colliding: &[PairId],
    (groups, root): (&Groups, usize),
    (hint, memory): (&mut Hint, &mut GroupMemory),
    scratch: &mut QueryScratch,
) -> Option<()> {
    let scene = context.checker.scene();
    let mut found = memory.spare.pop().unwrap_or_default();
    let GroupMemory { judged, holding, locked, own, .. } = memory;
    // This copies nothing: the checker that shared the marks is gone.
    let mut marked = judged.take().unwrap_or_default();
    let marks = Arc::make_mut(&mut marked);
    marks.clear();
    holding.clear();
    locked.clear();
    locked.extend((0..scene.space.nv()).map(|v| context.is_locked(v) || !groups.holds(root, v)));
    for pair in (0..scene.pairs.len()).map(PairId::new) {
        let (mut is_moved, mut is_alone, mut may_hold) = (false, true, true);
        coordinates(scene, pair, &mut |v| {
            is_moved |= groups.holds(root, v);
            is_alone &= groups.holds(root, v) || context.is_locked(v);
            may_hold &= !context.is_locked(v);
        });
        marks.push(is_moved && is_alone);
        holding.push(is_moved && is_alone && may_hold && context.stored.is_some_and(|stored| stored.holds(pair)));
    }
    own.clear();
    own.extend(colliding.iter().filter(|pair| marks[pair.index()]));
    let checker = context.checker.only(Arc::clone(&marked));
    let stored = context.stored.map(|stored| Stored { holding: Some(holding), ..stored });
    let of_group = Context { checker: &checker, locked, stored, ..*context };
    let degrees = locked.iter().filter(|is_locked| !**is_locked).count();
    let unseen = search_one(&of_group, plan.over(degrees), own, hint, scratch);
    drop(checker);
    memory.judged = Some(marked);
    let Known { exits, proof, .. } = &scratch.known;
    found.exits.clear();
    exits.iter().for_each(|end| found.exits.extend_from_slice(&end.config));
    (found.root, found.bound, found.unseen) = (root, proof.told(), unseen?);
    memory.found.push(found);
    Some(())
}

/// Offers the combination of the nearest exits of all groups, and its variants with one other exit
/// of one group.
fn combine(context: &Context, plan: Plan, groups: &Groups, memory: &mut GroupMemory, scratch: &mut QueryScratch) {
    let space = &context.checker.scene().space;
    let take = |config: &mut [f64], found: &GroupResult, exit: &[f64]| {
        for factor in space.factors().iter().filter(|factor| groups.holds(groups.root(found.root), factor.v)) {
            config[factor.coordinates()].copy_from_slice(&exit[factor.coordinates()]);
        }
    };
    let GroupMemory { found, best, config, bounds, .. } = memory;
    scratch.known.begin_group(std::iter::empty());
    scratch.evaluator.begin_group();
    best.clone_from(&scratch.known.rest);
    found.iter().for_each(|found| take(best, found, &found.exits[..space.nq()]));
    let mut whole = Search::whole(context, plan, scratch);
    whole.offer(best, false, false);
    for found in found.iter() {
        for exit in found.exits.chunks_exact(space.nq()).skip(1) {
            config.clone_from(best);
            take(config, found, exit);
            whole.offer(config, false, false);
        }
    }
    bounds.clear();
    bounds.extend(found.iter().filter_map(|found| found.bound));
    if bounds.len() == found.len() {
        let depth = whole.known.exits.depth();
        whole.known.proof.take_groups(context.metric.kind(), bounds, depth);
    }
}

/// Unites the joints that move a pair which collides at the nearest exit. Returns whether any were
/// apart before.
fn join_colliding(
    context: &Context,
    groups: &mut Groups,
    memory: &mut GroupMemory,
    scratch: &mut QueryScratch,
) -> bool {
    let QueryScratch { evaluator, known, .. } = scratch;
    let Some(exit) = known.exits.nearest() else { return false };
    if known.may_fall_back && evaluator.is_spent() {
        return false;
    }
    evaluator.checks += 1;
    memory.own.clear();
    context.checker.colliding_pairs(&exit.config, &mut evaluator.check, &mut memory.own);
    let joined = memory.own.iter().fold(false, |joined, pair| groups.join(context, *pair) | joined);
    groups.join_carried(context);
    // The united group probably has an exit near this one.
    known.hint.clone_from(&exit.config);
    joined
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::query::prepared::Prepared;
    use crate::query::{Effort, QueryOptions, query};
    use crate::scene::assemble::assemble;
    use crate::scene::{MetricKind, Scene};

    fn scene(urdf: &str, toml: &str) -> Scene {
        let toml = format!("[[robot]]\nurdf = 'r.urdf'\n{toml}");
        assemble(Path::new("scene.toml"), &toml, &mut |_: &Path| Ok(urdf.as_bytes().to_vec())).unwrap()
    }

    /// Carts on separate rails, each before a wall. A cart is free if it is at least 0.6 m and the
    /// clearance from the middle of its wall.
    fn carts(n: usize, metric: MetricKind) -> Prepared {
        let (mut urdf, mut toml) = (String::from("<robot name='carts'><link name='base'/>"), String::new());
        for k in 0..n {
            urdf += &format!(
                "<link name='c{k}'><collision><geometry><box size='0.2 0.2 0.2'/></geometry></collision></link>\
                 <joint name='j{k}' type='prismatic'><parent link='base'/><child link='c{k}'/><origin xyz='0 {k} 0'/>\
                 <axis xyz='1 0 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
            );
            toml += &format!(
                "[[obstacle]]\nname = 'w{k}'\nshape = {{ box = [1, 0.2, 0.2] }}\npose = {{ xyz = [0, {k}, 0] }}\n"
            );
        }
        let mut scene = scene(&(urdf + "</robot>"), &toml);
        scene.metric = metric;
        Prepared::new(scene)
    }

    #[test]
    fn the_nearest_exit_of_many_limbs_combines_those_of_each() {
        for (n, metric) in
            [(4, MetricKind::Joint), (8, MetricKind::Joint), (16, MetricKind::Joint), (6, MetricKind::ObjectNorm)]
        {
            let world = carts(n, metric);
            let (mut scratch, clear) = (QueryScratch::default(), 0.6 + world.scene().clearance);
            let (mut checks, all) = (0, 60);
            for at in 0..all {
                let x = |k: usize| 2.0 * (0.618_034 * (at * n + k) as f64).fract() - 1.0;
                let q = world.scene().config(&(0..n).map(x).collect::<Vec<_>>()).unwrap();
                let exit: Vec<f64> = q.iter().map(|x| if x.abs() < clear { clear.copysign(*x) } else { *x }).collect();
                let exact = world.metric().distance(&q, &exit);
                let answer = query(&world.context(), &q, &QueryOptions::default(), &mut scratch).unwrap();
                assert!(answer.verified && answer.depth > exact - 1e-6 && answer.depth <= 1.05 * exact + 1e-6);
                assert!(answer.lower_bound <= answer.depth);
                checks += answer.checks;
                let exhaustive = QueryOptions { effort: Effort::Exhaustive, ..QueryOptions::default() };
                let mut longer = || query(&world.context(), &q, &exhaustive, &mut scratch).unwrap();
                assert!(at > 3 || longer().depth <= answer.depth);
            }
            println!("{n} carts, {metric:?}: {checks} checks");
            assert!(checks <= 8 * n * all, "{n} {metric:?}: {checks}");
        }
    }

    /// One cart is in a wall. The other stays exactly where the query has it, unless it blocks the
    /// first.
    #[test]
    fn an_idle_limb_stays_unless_it_is_in_the_way() {
        let cart = |name: &str, axis: &str, x: f64| {
            format!(
                "<link name='{name}'><collision><geometry><box size='0.2 0.2 0.2'/></geometry></collision></link>\
                 <joint name='of_{name}' type='prismatic'><parent link='base'/><child link='{name}'/>\
                 <origin xyz='{x} 0 0'/><axis xyz='{axis}'/>\
                 <limit lower='-2' upper='2' effort='1' velocity='1'/></joint>"
            )
        };
        let urdf = format!(
            "<robot name='r'><link name='base'/>{}{}</robot>",
            cart("a", "1 0 0", 0.0),
            cart("b", "0 1 0", 0.35)
        );
        let toml = "[[obstacle]]\nname = 'wall'\nshape = { box = [0.4, 0.1, 0.2] }\npose = { xyz = [-0.1, 0, 0] }\n\
                    [[obstacle]]\nname = 'post'\nshape = { box = [0.05, 0.1, 0.2] }\npose = { xyz = [-0.4, 0, 0] }\n";
        let world = Prepared::new(scene(&urdf, toml));
        let ask = |q: [f64; 2]| {
            let q = world.scene().config(&q).unwrap();
            query(&world.context(), &q, &QueryOptions::default(), &mut QueryScratch::default()).unwrap()
        };
        let apart = ask([0.0, 0.7]);
        assert!(apart.witness[1] == 0.7 && (apart.depth - 0.2).abs() < 1e-3, "{apart:?}");
        let behind = ask([0.0, 0.15]);
        assert!(behind.witness[1] > 0.19 && (behind.depth - 0.2f64.hypot(0.05)).abs() < 1e-2, "{behind:?}");
    }
}
