//! Starts that keep the links of a query: the self-motion of an arm, and other solutions of its
//! inverse kinematics. If pairs have to touch, the same draws are starts.

use std::f64::consts::{PI, TAU};

use super::Search;
use crate::cspace::sampling::Halton;
use crate::cspace::{Factor, Manifold};
use crate::query::descent::Start;
use crate::scene::{Frame, Motion, Scene};

/// Configurations are drawn at these shares of the way from the query to anywhere. Those from
/// anywhere find all solutions of an arm without self-motion; those nearby follow a self-motion.
const SHARES: [f64; 4] = [1.0, 0.4, 1.0, 0.15];
/// A start repeats a nearer one within this share of its own distance, and within the second share
/// of the space's diameter.
const ALIKE_SHARE: f64 = 0.1;
const ZERO_SHARE: f64 = 0.03;
/// Starts beyond this multiple of the depth to beat are not tried.
const MAX_DEPTH_FACTOR: f64 = 1.2;

/// Descends from a configuration that keeps the links; returns whether there was one. The first
/// call draws them all.
pub fn from_kept(search: &mut Search, number: usize) -> bool {
    if number == 0 {
        search.known.kept = draw(search);
    }
    let most = MAX_DEPTH_FACTOR * search.known.ceiling();
    let Some((_, config)) = search.known.kept.get(number).filter(|(distance, _)| *distance <= most).cloned() else {
        return false;
    };
    search.try_start(Start::at(&config));
    true
}

/// Draws configurations near the query and far, moves each to where the links are kept, and returns
/// those that are unlike each other with their distances, nearest first.
fn draw(search: &mut Search) -> Vec<(f64, Vec<f64>)> {
    let (context, known) = (search.context, &mut *search.known);
    let (scene, space) = (context.checker.scene(), &context.checker.scene().space);
    let (halton, mut drawn) = (Halton::new(space.nv(), 0), vec![0.0; space.nq()]);
    let turning: Vec<&Factor> = space.factors().iter().filter(|factor| turns_whole(scene, factor)).collect();
    let mut found = Vec::new();
    for index in 0..=search.plan.kept_draws {
        if search.evaluator.is_spent() {
            break;
        }
        halton.config(space, index as u64, &mut drawn);
        let mut config = drawn.clone();
        // The first is the query itself, which may be off.
        let share = if index == 0 { 0.0 } else { SHARES[index % SHARES.len()] };
        space.interpolate(&known.rest, &drawn, share, &mut config);
        context.hold(&known.rest, &mut config);
        if search.evaluator.project(context, &mut config) {
            turning.iter().for_each(|factor| unwind(factor, &known.anchor.q, &mut config));
            let distance = search.evaluator.distance(context, &known.anchor, &config);
            // A query at its place in which pairs do not touch is a start too.
            if distance > 0.0 || context.touching.are_required {
                found.push((distance, config));
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut unlike: Vec<(f64, Vec<f64>)> = Vec::new();
    for (distance, config) in found {
        let least = (ALIKE_SHARE * distance).max(ZERO_SHARE * context.scale);
        if unlike.iter().all(|(_, other)| known.local.distance(space, other, &config) >= least) {
            unlike.push((distance, config));
        }
    }
    unlike
}

/// Whether whole turns of a coordinate change nothing but the coordinate.
fn turns_whole(scene: &Scene, factor: &Factor) -> bool {
    let is_whole = |frame: &Frame| match &frame.motion {
        Motion::Revolute { coordinate, .. } => coordinate.v != factor.v || coordinate.multiplier.abs() == 1.0,
        Motion::Prismatic { coordinate, .. } => coordinate.v != factor.v,
        Motion::World | Motion::Ball { .. } => true,
    };
    matches!(factor.manifold, Manifold::Interval { lower, upper } if upper - lower >= TAU)
        && scene.frames.iter().all(is_whole)
}

/// Turns a joint by whole turns to where it is nearest to the query within its limits.
fn unwind(factor: &Factor, q: &[f64], config: &mut [f64]) {
    let Manifold::Interval { lower, upper } = factor.manifold else { return };
    let (x, q) = (&mut config[factor.q], q[factor.q]);
    while *x - q > PI && *x - TAU >= lower {
        *x -= TAU;
    }
    while q - *x > PI && *x + TAU <= upper {
        *x += TAU;
    }
}
