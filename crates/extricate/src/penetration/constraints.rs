//! Queries with a clearance of their own, or with joints that stay: what they stand on.

use super::change::Change;
use super::context::Context;
use super::options::QueryOptions;
use crate::collision::Checker;
use crate::scene::Scene;

/// What a query's own constraints make of what it stands on; kept while it is asked.
#[derive(Default)]
pub struct Constraints {
    checker: Option<Checker>,
    change: Option<Change>,
    locked: Vec<bool>,
}

impl Constraints {
    /// Those of the options; nothing is made where they have none.
    pub fn new(context: &Context, options: &QueryOptions) -> Self {
        let mut own = Self::default();
        if let Some(aim) = options.clearance.filter(|aim| *aim != context.clearance) {
            let (wider, pairs) = (aim - context.clearance, context.checker.scene().pairs.len());
            let has_samples = !context.samples().is_empty();
            let change = || context.change.map_or_else(|| Change::of_clearance(pairs, wider), |was| was.widened(wider));
            own.change = has_samples.then(change);
            own.checker = Some(context.checker.with_clearance(aim));
        }
        if !options.locked.is_empty() {
            own.locked = locked(context.checker.scene(), &options.locked);
        }
        own
    }

    /// The context under them.
    pub fn apply<'a>(&'a self, context: &Context<'a>) -> Context<'a> {
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
