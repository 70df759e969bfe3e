//! Starts at which colliding bodies part: a best-first search over separating directions.
//!
//! Two convex bodies are apart if some unit direction separates them. A free configuration thus
//! chooses, for every colliding pair, a direction on a two-dimensional sphere, whatever the degrees
//! of freedom. To first order each choice is a half-space of displacements, and the shortest
//! displacement in it leads to a start. If another pair collides there, that pair chooses too, and
//! the displacement has to lie in both half-spaces. Displacements are visited shortest first, up to
//! a multiple of the nearest depth; a descent starts from each.

pub mod displacement_tree;
mod pair_directions;

use super::Search;
use crate::query::descent::Start;
use displacement_tree::{Directions, Node};

/// A displacement repeats a visited one if they differ by less than this share of its length. With
/// 0.1, queries find the same for 4 % more checks.
const ALIKE_SHARE: f64 = 0.2;
/// A displacement is not branched if its descent ends within this multiple of its length: children
/// would hardly lead nearer. With 1.05, queries find the same for 2 % more checks.
const SETTLED_FACTOR: f64 = 1.1;

/// Visits the shortest displacement that is unlike the visited ones; returns whether there was one.
pub fn visit_next(search: &mut Search) -> bool {
    let mut tree = std::mem::take(&mut search.known.directions);
    if tree.nodes.is_empty() {
        tree.begin(search.context, &search.known.local, &search.known.anchor.q);
    }
    let most = search.plan.direction_factor * search.known.ceiling();
    let mut was_new = false;
    while !was_new && let Some(node) = tree.shortest(most) {
        was_new = visit(&mut tree, search, node);
    }
    search.known.directions = tree;
    was_new
}

/// Descends from a displacement, and branches if it collides. Returns false if it repeats a visited
/// one.
fn visit(tree: &mut Directions, search: &mut Search, at: usize) -> bool {
    let (context, nv) = (search.context, tree.low.len());
    let scene = context.checker.scene();
    let step = &tree.steps[at * nv..][..nv];
    let length = tree.nodes[at].length;
    let is_like = |(other, node): (usize, &Node)| {
        let product = || search.known.local.product(step, &tree.steps[other * nv..][..nv]);
        let between = || length * length + node.length * node.length - 2.0 * product();
        node.is_visited && between() < (ALIKE_SHARE * length).powi(2)
    };
    let is_known = tree.nodes.iter().enumerate().any(is_like);
    (tree.nodes[at].is_open, tree.nodes[at].is_visited) = (false, !is_known);
    if is_known {
        return false;
    }
    tree.config.resize(scene.space.nq(), 0.0);
    scene.space.integrate(&search.known.anchor.q, step, &mut tree.config);
    context.hold(&search.known.rest, &mut tree.config);
    if (at > 0 || tree.begins_outside)
        && let Some(depth) = search.try_start(Start::at(&tree.config))
        && depth <= SETTLED_FACTOR * length
    {
        return true;
    }
    if tree.nodes[at].choices == search.plan.most_choices || search.evaluator.is_spent() {
        return true;
    }
    tree.colliding.clear();
    context.checker.colliding_pairs(&tree.config, &mut search.evaluator.check, &mut tree.colliding);
    // The check of the query itself has been counted before.
    search.evaluator.checks += usize::from(at > 0);
    if !tree.colliding.is_empty() {
        tree.measure(context, &search.known.local, &mut search.evaluator.check);
        let most = search.plan.direction_factor * search.known.ceiling();
        tree.branch(at, &search.known.local, most);
    }
    true
}
