//! Independent parts: joints that colliding pairs do not connect have exits of their own, and the
//! nearest exit of all combines them.
//!
//! A stored sample holds one combination; the right one of 2^n is hardly ever stored. So each part
//! is searched on its own, from the query in its joints and a free configuration in the others,
//! which any sample whose coordinates of the part are near may start.

mod idle;

use super::coordinates::{coordinates, own};
use super::run::run;
use super::{Incumbent, Known, Search};
use crate::collision::{ContactQuery, ContactSearch};
use crate::query::answer::TOUCHING;
use crate::query::context::Context;
use crate::query::starts::{Ask, PartOf};
use crate::samples::contact_planes::Elsewhere;
use crate::scene::{Motion, PairId, Scene};
use idle::return_idle;

/// Which joints belong together, and memory for the search over one part.
#[derive(Default)]
pub struct IndependentParts {
    /// A union-find forest over the tangent coordinates.
    parent: Vec<usize>,
    /// Whether a coordinate moves a pair that collides.
    is_moved: Vec<bool>,
    /// Whether it is on a chain with one that does.
    is_related: Vec<bool>,
    /// Which parts were searched as they are now, by their roots.
    is_searched: Vec<bool>,
    /// Which factors of the space a part has.
    searched: Vec<usize>,
    /// Of which pairs contact planes hold in a search over a part.
    holding: Vec<bool>,
    base: Vec<f64>,
    known: Known,
}

/// Searches every part on its own, and parts that turn out to touch each other as one.
pub fn search_parts(whole: &mut Search, parts: &mut IndependentParts) {
    let scene = whole.context.checker.scene();
    // Something free to work on, as near as one descent leads; a sample that does not move what
    // stays is hardly stored.
    if whole.context.locked.is_empty()
        && let Some(first) = whole.start(0)
        && !whole.is_far(first)
    {
        whole.try_sample(first);
    }
    return_idle(whole, &parts.is_moved, &mut parts.base);
    let mut seen = 1.0;
    loop {
        for root in 0..scene.space.nv() {
            if parts.is_root(root) && !parts.is_searched[root] && !whole.evaluator.is_spent() {
                parts.is_searched[root] = true;
                seen *= 1.0 - search_part(whole, parts, root);
            }
        }
        // What stood in their way may be out of it now.
        return_idle(whole, &parts.is_moved, &mut parts.base);
        if whole.evaluator.is_spent() || !parts.join_touching(whole) {
            break;
        }
    }
    whole.known.unseen_in_parts = Some(1.0 - seen);
}

/// Searches the part of a root, the others where the incumbent has them; the share of starts that
/// would lead to an unmet exit of it.
fn search_part(whole: &mut Search, parts: &mut IndependentParts, root: usize) -> f64 {
    let (context, space) = (whole.context, &whole.context.checker.scene().space);
    parts.prepare(context, root);
    if parts.searched.is_empty() {
        return 0.0;
    }
    let IndependentParts { searched, holding, base, known, .. } = parts;
    base.clone_from(&whole.known.incumbent.config);
    let wider = context.change.map_or(0.0, |change| change.of_planes().wider);
    let part = PartOf { all: space.factors(), searched, base, holding: Elsewhere { stays: holding, wider } };
    let plan = whole.plan.over(part.degrees());
    let mut from = std::mem::take(&mut known.composed);
    part.compose(&whole.known.anchor.q, &mut from);
    context.metric.anchor(&from, &mut known.anchor);
    known.composed = from;
    let depth = whole.evaluator.distance(context, &known.anchor, base);
    known.begin(context, whole.known.wanted);
    known.take(depth, base, whole.known.incumbent.verified);
    if whole.turn.is_some() {
        // The exit of the last frame was carried to its end just now.
        known.ends.push(base);
    }
    let ask = Ask { context, plan: &plan, anchor: &known.anchor, part: Some(part) };
    known.starts.gather_for_part(&ask, &part);
    let mut search = Search {
        context,
        plan,
        known,
        evaluator: whole.evaluator,
        descent: whole.descent,
        boundary: whole.boundary,
        believes: whole.believes,
        turn: whole.turn,
        part: Some(part),
    };
    let ranks = run(&mut search);
    whole.turn = search.turn;
    whole.known.ranks.push(ranks);
    let unseen = known.unseen();
    let distance = whole.evaluator.distance(context, &whole.known.anchor, &known.incumbent.config);
    if distance < whole.known.incumbent.depth {
        let Incumbent { config, verified, .. } = &known.incumbent;
        whole.known.exits.offer(space, &mut whole.known.local, distance, config);
        whole.known.take(distance, config, *verified);
    }
    unseen
}

impl IndependentParts {
    /// Groups the coordinates by the pairs that collide.
    pub fn split(&mut self, scene: &Scene, colliding: &[PairId]) -> &Self {
        let nv = scene.space.nv();
        self.parent.clear();
        self.parent.extend(0..nv);
        self.is_moved.clear();
        self.is_moved.resize(nv, false);
        self.is_searched.clear();
        self.is_searched.resize(nv, false);
        self.is_related.clear();
        self.is_related.resize(nv, false);
        colliding.iter().for_each(|pair| {
            self.join(scene, *pair);
        });
        self.join_carried(scene);
        self
    }

    /// Adds the joints that a part carries to it, and notes which joints share a chain with one.
    fn join_carried(&mut self, scene: &Scene) {
        let world = |frame: usize| matches!(scene.frames[frame].motion, Motion::World);
        for frame in 0..scene.frames.len() {
            let mut above = scene.frames[frame].parent;
            while !world(above) && own(scene, above).all(|v| !self.is_moved[v]) {
                above = scene.frames[above].parent;
            }
            let is_carried = !world(above);
            for v in own(scene, frame).filter(|_| is_carried) {
                self.unite(own(scene, above).start, v);
            }
            if is_carried || own(scene, frame).any(|v| self.is_moved[v]) {
                let mut below = frame;
                while !world(below) {
                    own(scene, below).for_each(|v| self.is_related[v] = true);
                    below = scene.frames[below].parent;
                }
            }
        }
    }

    /// Makes two coordinates be of one part; whether they were not.
    fn unite(&mut self, a: usize, b: usize) -> bool {
        let is_new = !std::mem::replace(&mut self.is_moved[b], true);
        let (a, b) = (self.root(a), self.root(b));
        if a != b {
            self.parent[a.max(b)] = a.min(b);
        }
        if a != b || is_new {
            self.is_searched[a.min(b)] = false;
        }
        a != b || is_new
    }

    /// Whether to search the parts one by one: there are several, or limbs that no part has to do
    /// with.
    pub fn are_independent(&self) -> bool {
        self.count() > 1 || self.is_related.iter().any(|is_related| !is_related)
    }

    /// How many parts there are.
    pub fn count(&self) -> usize {
        self.roots().count()
    }

    /// One coordinate of each part.
    pub fn roots(&self) -> impl Iterator<Item = usize> + use<'_> {
        (0..self.parent.len()).filter(|v| self.is_root(*v))
    }

    /// The tangent coordinates of the part of a root.
    pub fn of(&self, root: usize) -> impl Iterator<Item = usize> + use<'_> {
        (0..self.parent.len()).filter(move |v| self.is_moved[*v] && self.root(*v) == root)
    }

    /// Of every tangent coordinate, whether it moves a pair that collides.
    pub fn moved(&self) -> &[bool] {
        &self.is_moved
    }

    /// Whether nothing that may move parts one of these pairs.
    pub fn hold_some(context: &Context, pairs: &[PairId]) -> bool {
        let is_held = |pair: &PairId| {
            let mut all = true;
            coordinates(context.checker.scene(), *pair, &mut |v| all &= context.is_locked(v));
            all
        };
        pairs.iter().any(is_held)
    }

    /// Whether the part of a root moves the bodies of a pair relative to each other.
    pub fn moves(&self, scene: &Scene, root: usize, pair: PairId) -> bool {
        let mut any = false;
        coordinates(scene, pair, &mut |v| any |= self.is_moved[v] && self.root(v) == self.root(root));
        any
    }

    /// Joins the coordinates of a pair to one part; whether they were not before.
    pub fn join(&mut self, scene: &Scene, pair: PairId) -> bool {
        let (mut first, mut joined) = (None, false);
        coordinates(scene, pair, &mut |v| joined |= self.unite(*first.get_or_insert(v), v));
        joined
    }

    /// Joins parts that a pair connects which touches at the incumbent; whether there were any.
    fn join_touching(&mut self, whole: &mut Search) -> bool {
        let (context, scene) = (whole.context, whole.context.checker.scene());
        let margin = context.clearance + TOUCHING;
        let query = ContactQuery { margin, search: ContactSearch::Proposal };
        whole.evaluator.contacts_at(context, &whole.known.incumbent.config, query);
        let touching = whole.evaluator.contacts.iter().filter(|contact| contact.distance < margin);
        touching.map(|contact| contact.pair).fold(false, |joined, pair| self.join(scene, pair) | joined)
    }

    /// Lists the factors of a part that may move, and the pairs that nothing else moves.
    fn prepare(&mut self, context: &Context, root: usize) {
        let scene = context.checker.scene();
        let (mut searched, mut holding) = (std::mem::take(&mut self.searched), std::mem::take(&mut self.holding));
        let is_of_part = |v: usize| self.is_moved[v] && self.root(v) == root && !context.is_locked(v);
        searched.clear();
        let factors = scene.space.factors();
        searched.extend((0..factors.len()).filter(|at| is_of_part(factors[*at].v)));
        let depends_on_part_alone = |pair: PairId| {
            let (mut any, mut all) = (false, true);
            coordinates(scene, pair, &mut |v| {
                any = true;
                all &= is_of_part(v);
            });
            any && all
        };
        holding.clear();
        match context.change {
            None => holding.extend((0..scene.pairs.len()).map(PairId::new).map(depends_on_part_alone)),
            Some(change) => holding
                .extend(change.pairs_here().iter().map(|p| p.map(PairId::new).is_some_and(depends_on_part_alone))),
        }
        (self.searched, self.holding) = (searched, holding);
    }

    fn root(&self, mut v: usize) -> usize {
        while self.parent[v] != v {
            v = self.parent[v];
        }
        v
    }

    fn is_root(&self, v: usize) -> bool {
        self.is_moved[v] && self.parent[v] == v
    }
}

#[cfg(test)]
mod tests {

    use std::path::Path;

    use super::*;
    use crate::learning::LearnOptions;
    use crate::model::Model;
    use crate::query::{Effort, QueryOptions, QueryScratch};
    use crate::scene::assemble::assemble;
    use crate::scene::{MetricKind, builtin};

    /// Carts on rails of their own, each before a wall: of `n` that collide, one is free where it
    /// is 0.6 and the clearance from its wall's middle.
    fn carts(n: usize, metric: MetricKind) -> Model {
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
        urdf += "</robot>";
        let toml = format!("[[robot]]\nurdf = 'carts.urdf'\n{toml}");
        let mut scene =
            assemble(Path::new("scene.toml"), &toml, &mut |_: &Path| Ok(urdf.clone().into_bytes())).unwrap();
        scene.metric = metric;
        let options = LearnOptions { labels: 30_000, seconds: None, ..LearnOptions::default() };
        Model::learn(scene, &options).unwrap()
    }

    #[test]
    fn the_nearest_exit_of_many_limbs_combines_those_of_each() {
        for (n, metric) in
            [(4, MetricKind::Joint), (8, MetricKind::Joint), (16, MetricKind::Joint), (6, MetricKind::ObjectNorm)]
        {
            let model = carts(n, metric);
            let (mut scratch, clear) = (QueryScratch::default(), 0.6 + model.scene().clearance);
            let (mut found, mut checks, all) = (0, 0, 60);
            for at in 0..all {
                let x = |k: usize| 2.0 * (0.618_034 * (at * n + k + 1) as f64).fract() - 1.0;
                let q = model.scene().space.config(&(0..n).map(x).collect::<Vec<_>>()).unwrap();
                let mut to = q.to_vec();
                to.iter_mut().filter(|x| x.abs() < clear).for_each(|x| *x = clear.copysign(*x));
                let exact = model.metric().distance(&q, &to);
                let answer = model.view().query_with(&q, &QueryOptions::default(), &mut scratch).unwrap();
                let unlearned = model.world().view().query_with(&q, &QueryOptions::default(), &mut scratch).unwrap();
                assert!(unlearned.verified && unlearned.depth > exact - 1e-6 && unlearned.depth <= 1.05 * exact + 1e-6);
                assert!(answer.verified && answer.depth > exact - 1e-6 && answer.lower_bound <= answer.depth);
                found += usize::from(answer.depth <= 1.05 * exact + 1e-6);
                checks += answer.checks;
                let exhaustive = QueryOptions { effort: Effort::Exhaustive, ..QueryOptions::default() };
                assert!(
                    at > 3 || model.view().query_with(&q, &exhaustive, &mut scratch).unwrap().depth <= answer.depth
                );
            }
            println!("{n} carts, {metric:?}: {found} of {all}, {checks} checks");
            assert!(found * 100 >= 95 * all, "{n} {metric:?}: {found} of {all}");
            assert!(checks <= 8 * n * all, "{n} {metric:?}: {checks}");
        }
    }

    #[test]
    fn pairs_that_share_a_joint_are_of_one_part() {
        let scene = builtin::scene("dual-arm").unwrap();
        let joints = |pair: PairId| {
            let mut found = Vec::new();
            coordinates(&scene, pair, &mut |v| found.push(v));
            found
        };
        let of_arm = |arm: usize| {
            let is_of_arm = |pair: &PairId| {
                let joints = joints(*pair);
                !joints.is_empty() && joints.iter().all(|v| v / 7 == arm)
            };
            (0..scene.pairs.len()).map(PairId::new).filter(is_of_arm).collect::<Vec<_>>()
        };
        let (left, right) = (of_arm(0), of_arm(1));
        let both = (0..scene.pairs.len())
            .map(PairId::new)
            .find(|pair| joints(*pair).iter().any(|v| *v < 7) && joints(*pair).iter().any(|v| *v > 6));
        let mut parts = IndependentParts::default();
        parts.split(&scene, &[left[0], right[0]]);
        assert_eq!(parts.count(), 2);
        parts.split(&scene, &[left[0], right[0], both.unwrap()]);
        assert_eq!(parts.count(), 1);
        parts.split(&scene, &[]);
        assert_eq!(parts.count(), 0);
    }
}
