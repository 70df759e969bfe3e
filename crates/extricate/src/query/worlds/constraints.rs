//! Queries with a clearance of their own, or with joints that stay: what they stand on.

use super::delta::Change;
use crate::collision::Checker;
use crate::query::context::Context;
use crate::query::options::QueryOptions;
use crate::scene::Scene;

/// Asks under the constraints of the options; where nothing is found that keeps their clearance,
/// with that of the scene.
pub fn under<T>(context: &Context, options: &QueryOptions, mut ask: impl FnMut(&Context) -> Option<T>) -> Option<T> {
    let aim = options.clearance.filter(|aim| *aim != context.clearance);
    let aimed = ask(&Constraints::new(context, aim, &options.locked).apply(context));
    if aimed.is_some() || aim.is_none() {
        return aimed;
    }
    ask(&Constraints::new(context, None, &options.locked).apply(context))
}

/// What a query's own constraints make of what it stands on; kept while it is asked.
#[derive(Default)]
struct Constraints {
    checker: Option<Checker>,
    change: Option<Change>,
    locked: Vec<bool>,
}

impl Constraints {
    /// Another clearance \[m\], and joints that stay; nothing is made where there are none.
    fn new(context: &Context, aim: Option<f64>, joints: &[usize]) -> Self {
        let mut own = Self::default();
        if let Some(aim) = aim {
            let (wider, pairs) = (aim - context.clearance, context.checker.scene().pairs.len());
            let has_samples = !context.samples().is_empty();
            let change = || context.change.map_or_else(|| Change::of_clearance(pairs, wider), |was| was.widened(wider));
            own.change = has_samples.then(change);
            own.checker = Some(context.checker.with_clearance(aim));
        }
        if !joints.is_empty() {
            own.locked = locked(context.checker.scene(), joints);
        }
        own
    }

    /// The context under them.
    fn apply<'a>(&'a self, context: &Context<'a>) -> Context<'a> {
        let checker = self.checker.as_ref().unwrap_or(context.checker);
        let change = self.change.as_ref().or(context.change);
        Context { checker, change, clearance: checker.base_clearance(), locked: &self.locked, ..*context }
    }
}

/// Of every tangent coordinate, whether one of the joints has it.
fn locked(scene: &Scene, joints: &[usize]) -> Vec<bool> {
    let mut locked = vec![false; scene.space.nv()];
    for factor in scene.space.factors() {
        let is_of = |joint: &usize| scene.joints.get(*joint).is_some_and(|joint| joint.q.contains(&factor.q));
        if joints.iter().any(is_of) {
            factor.tangents().for_each(|v| locked[v] = true);
        }
    }
    locked
}
