//! What a search begins with: the nearest sample, or, in a scene that is not the one that was
//! learned, one that is free there.

use super::Ask;
use super::directions::find_by_directions;
use crate::cspace::Label;
use crate::cspace::sampling::Halton;
use crate::query::descent::Start;
use crate::query::report::coverage::Coverage;
use crate::query::search::Search;
use crate::query::search::parts::IndependentParts;
use crate::samples::{SampleKind, SampleQuery};

/// Nearest samples that are checked before descents from the nearest are tried: where so many
/// collide, hardly any may be free, as where the clearance is larger than it was; and a descent
/// takes about as many checks.
const LOOKED_AT: usize = 16;
/// Times as many are looked at next.
const MORE: usize = 8;
/// A sample that by its planes misses the clearance by more than this \[m\] collides: they are of
/// single precision.
const SURE: f64 = 1e-6;
/// Descents that are tried then.
const LED_OUT: usize = 8;
/// Configurations that are tried where no stored one is free any more.
const LAST_RESORT: u64 = 20_000;

/// Makes a free configuration the incumbent and tells how usual its distance is. A stored one is
/// believed in the scene that was learned. In another one it is the nearest that is free now; where
/// the nearest of them collide, what a descent from one of those leads to; or else any free
/// configuration. `None` where there is none, or looking for it was stopped; a budget does not end
/// it, since without a witness there is no answer.
pub fn first_witness(search: &mut Search, parts: &mut IndependentParts) -> Option<Option<f64>> {
    if search.context.begins_without_samples() {
        find_without_samples(search, parts)?;
        return Some(None);
    }
    let (context, known) = (search.context, &mut *search.known);
    let ask = Ask { context, plan: &search.plan, anchor: &known.anchor, part: None };
    known.starts.gather(&ask, search.plan.starts, search.boundary);
    let coverage: &Coverage = context.learned.coverage;
    if !context.scene_changed() {
        let &(id, depth) = known.starts.near().first()?;
        let (id, nearest) = known.starts.nearer_sample(&ask, depth, search.boundary).unwrap_or((id, depth));
        known.take(nearest, context.samples().config(id), false);
        return Some(coverage.of(depth));
    }
    let found = free_sample(search).or_else(|| lead_out(search)).or_else(|| any_sample(search));
    let distance = found.or_else(|| any_free(search))?;
    Some(coverage.of(distance))
}

/// Where nothing was learned: where colliding bodies part; else, where several limbs collide, one
/// that is put together limb by limb; else any free configuration.
fn find_without_samples(search: &mut Search, parts: &mut IndependentParts) -> Option<()> {
    search.known.take(f64::INFINITY, &[], false);
    let count = parts.count();
    if count <= search.plan.most_choices {
        let limit = search.evaluator.lift_limit();
        find_by_directions(search);
        search.evaluator.limit = limit;
    }
    if search.known.incumbent.depth.is_infinite() && count > 1 && search.known.resort.is_none() {
        put_together(search, parts);
    }
    if search.known.incumbent.depth.is_infinite() {
        any_free(search)?;
    }
    Some(())
}

/// Takes every part from a configuration of a low-discrepancy sequence at which nothing of it
/// collides, the others where they are by then: all of many limbs are free at once hardly anywhere,
/// each on its own soon.
fn put_together(search: &mut Search, parts: &mut IndependentParts) {
    let (context, scene) = (search.context, search.context.checker.scene());
    let (space, q) = (&scene.space, &search.known.anchor.q);
    let halton = Halton::new(space.nv(), 0);
    let (mut config, mut sample, mut colliding) = (q.clone(), vec![0.0; space.nq()], Vec::new());
    space.clamp(&mut config);
    let mut open: Vec<usize> = parts.roots().collect();
    let (mut index, mut looks) = (0, 0);
    while looks < LAST_RESORT && !search.evaluator.is_stopped() {
        halton.config(space, index, &mut sample);
        context.hold(q, &mut sample);
        index += 1;
        open.retain(|root| {
            let mut trial = config.clone();
            for factor in space.factors().iter().filter(|factor| parts.of(*root).any(|v| v == factor.v)) {
                trial[factor.coordinates()].copy_from_slice(&sample[factor.coordinates()]);
            }
            colliding.clear();
            context.checker.colliding_pairs(&trial, &mut search.evaluator.check, &mut colliding);
            looks += 1;
            let collides = colliding.iter().any(|pair| parts.moves(scene, *root, *pair));
            if !collides {
                config = trial;
            }
            collides
        });
        if !open.is_empty() {
            continue;
        }
        colliding.clear();
        context.checker.colliding_pairs(&config, &mut search.evaluator.check, &mut colliding);
        looks += 1;
        if colliding.is_empty() {
            search.evaluator.checks += looks as usize;
            let depth = search.evaluator.distance(context, &search.known.anchor, &config);
            return search.known.take(depth, &config, true);
        }
        // Parts that meet each other are one.
        colliding.iter().for_each(|pair| {
            parts.join(scene, *pair);
        });
        open.extend(parts.roots().filter(|root| colliding.iter().any(|pair| parts.moves(scene, *root, *pair))));
    }
    search.evaluator.checks += looks as usize;
}

/// The nearest of the gathered samples that is free now.
fn free_sample(search: &mut Search) -> Option<f64> {
    let mut left = LOOKED_AT;
    for at in 0..search.known.starts.near().len() {
        let (id, depth) = search.known.starts.near()[at];
        if left == 0 || search.evaluator.is_stopped() {
            return None;
        }
        let planes = Start::of(search.context, id).planes;
        if planes.is_some_and(|planes| planes.iter().any(|(room, _)| room < -SURE)) {
            continue;
        }
        left -= 1;
        if takes(search, id, depth) {
            return Some(depth);
        }
    }
    None
}

/// Makes a sample the incumbent if it is free.
fn takes(search: &mut Search, id: u32, depth: f64) -> bool {
    let config = search.context.samples().config(id);
    let is_free = search.evaluator.label(search.context, config) == Label::Free;
    if is_free {
        search.known.take(depth, config, true);
    }
    is_free
}

/// The end of a descent from one of the nearest gathered samples.
fn lead_out(search: &mut Search) -> Option<f64> {
    let limit = search.evaluator.lift_limit();
    let mut found = None;
    for at in 0..LED_OUT.min(search.known.starts.near().len()) {
        if search.evaluator.is_stopped() {
            break;
        }
        let (id, distance) = search.known.starts.near()[at];
        let start = Start::at(search.context.samples().config(id));
        let (depth, _) = search.descend_alone(start, f64::INFINITY, search.plan.descent);
        if let Some(depth) = depth
            && search.evaluator.label(search.context, &search.descent.best) == Label::Free
        {
            search.known.take(depth, &search.descent.best, true);
            found = Some(distance);
            break;
        }
    }
    search.evaluator.limit = limit;
    found
}

/// The nearest of all samples that is free now.
fn any_sample(search: &mut Search) -> Option<f64> {
    let (samples, metric) = (search.context.samples(), search.context.metric);
    let (mut near, mut looked_at, mut count) = (Vec::new(), 0, MORE * LOOKED_AT);
    loop {
        samples.nearest(
            SampleQuery { among: SampleKind::All, ..SampleQuery::NEAREST },
            metric,
            &search.known.anchor,
            count,
            search.boundary,
            &mut near,
        );
        for &(id, depth) in &near[looked_at..] {
            if search.evaluator.is_stopped() {
                return None;
            }
            if takes(search, id, depth) {
                return Some(depth);
            }
        }
        looked_at = near.len();
        if looked_at < count {
            return None;
        }
        count *= MORE;
    }
}

/// The first free configuration of a low-discrepancy sequence, or the one that is known
/// ([`Known::resort`](crate::query::search::Known::resort)); it is far from all samples.
fn any_free(search: &mut Search) -> Option<f64> {
    let (context, space) = (search.context, &search.context.checker.scene().space);
    if let Some(config) = search.known.resort.take() {
        let is_free = !config.is_empty() && search.evaluator.label(context, &config) == Label::Free;
        if is_free {
            let depth = search.evaluator.distance(context, &search.known.anchor, &config);
            search.known.take(depth, &config, true);
        }
        search.known.resort = Some(config);
        return is_free.then_some(f64::INFINITY);
    }
    let halton = Halton::new(space.nv(), 0);
    let mut config = vec![0.0; space.nq()];
    for index in 0..LAST_RESORT {
        if search.evaluator.is_stopped() {
            return None;
        }
        halton.config(space, index, &mut config);
        context.hold(&search.known.anchor.q, &mut config);
        if search.evaluator.label(context, &config) == Label::Free {
            let depth = search.evaluator.distance(context, &search.known.anchor, &config);
            search.known.take(depth, &config, true);
            return Some(f64::INFINITY);
        }
    }
    None
}
