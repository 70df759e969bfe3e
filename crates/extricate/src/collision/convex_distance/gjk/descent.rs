//! The descent to the point of a difference nearest to the origin, with proved early ends on both
//! sides.

use super::simplex::{Feature, Simplex};
use crate::collision::convex_distance::minkowski::Difference;
use crate::math::{Vec3, vectorized};

/// Far above what is needed: on average polytopes of up to 200 vertices take 3 to 11, cylinders in
/// near contact about 30.
const MAX_ITERATIONS: usize = 64;
/// Steps without visible progress before the search is given up: a guard against cycling in
/// rounding noise.
const MAX_STALLS: usize = 6;

/// When a descent may end although nearer points are left: once their distance is known to within a
/// share of itself.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EarlyEnd {
    /// Share of the distance beyond `from` that may be unknown.
    pub share: f64,
    /// Part of the distance that does not count, because shapes around the cores fill it \[m\].
    pub from: f64,
    /// The descent ends early only if a plane parts the cores by more than this \[m\].
    pub above: f64,
}

impl EarlyEnd {
    /// The descent does not end early.
    pub const NONE: Self = Self { share: 0.0, from: 0.0, above: f64::INFINITY };
}

/// How the descent ended.
#[derive(Debug)]
pub(crate) enum Outcome {
    /// A plane proves the cores farther apart than `apart_above`.
    Apart,
    /// Two points of the cores are nearer than `near_below`.
    Nearer(Settled),
    /// No nearer points were found, or the descent ended early.
    Settled(Settled),
    /// The simplex holds the origin, or touches it within rounding.
    Overlapping(Simplex),
}

/// The state in which the descent ended with the cores apart.
#[derive(Debug)]
pub(crate) struct Settled {
    /// Reduced to the vertices of `feature`, in its order.
    pub simplex: Simplex,
    pub feature: Feature,
    /// Distance by which the plane across the feature's direction was found to part the cores
    /// \[m\].
    pub plane: f64,
    /// Whether the search ended early, at a gap that the caller allows.
    pub is_coarse: bool,
}

impl Settled {
    /// Returns whether the plane proves much less than the distance, because rounding spoils the
    /// direction between near vertices.
    pub fn is_doubtful(&self, difference: &Difference) -> bool {
        !self.is_coarse && self.feature.square.sqrt() - self.plane > difference.touching
    }
}

/// Descends to the point of the difference nearest to the origin, until a support plane proves it
/// farther than `apart_above` or a point is nearer than `near_below` \[m\].
pub(crate) fn descend(difference: &Difference, guess: &mut Vec3, apart_above: f64, near_below: f64) -> Outcome {
    let apart_above = apart_above + difference.rounding;
    let mut direction = if *guess == Vec3::zeros() { difference.center() } else { *guess };
    if direction == Vec3::zeros() {
        direction = Vec3::x();
    }
    let start = difference.support(&-direction);
    *guess = direction;
    if start.point.dot(&direction) > apart_above * direction.norm() {
        return Outcome::Apart;
    }
    descend_from(difference, &mut Simplex::new(start), guess, apart_above, near_below, EarlyEnd::NONE)
}

/// Descends from a simplex of one to three points of the difference, which becomes the last one
/// reached. `guess` becomes the last direction. `apart_above` includes the rounding.
pub(crate) fn descend_from(
    difference: &Difference,
    simplex: &mut Simplex,
    guess: &mut Vec3,
    apart_above: f64,
    near_below: f64,
    early: EarlyEnd,
) -> Outcome {
    vectorized(
        #[inline(always)]
        || descend_inlined(difference, simplex, guess, apart_above, near_below, early),
    )
}

#[inline(always)]
fn descend_inlined(
    difference: &Difference,
    simplex: &mut Simplex,
    guess: &mut Vec3,
    apart_above: f64,
    near_below: f64,
    early: EarlyEnd,
) -> Outcome {
    let mut feature = simplex.nearest(0.0).expect("not a tetrahedron");
    simplex.keep(&feature);
    // Polytopes end exactly; curved cores approach their distance without end.
    let tolerance = if difference.is_curved() { 1e-11 * difference.scale } else { 0.25 * difference.rounding };
    let (mut stalls, mut plane) = (0, f64::NEG_INFINITY);
    for _ in 0..MAX_ITERATIONS {
        let distance = feature.square.sqrt();
        if distance < near_below {
            return Outcome::Nearer(Settled { simplex: *simplex, feature, plane: f64::NEG_INFINITY, is_coarse: false });
        }
        if distance <= difference.touching {
            return Outcome::Overlapping(*simplex);
        }
        *guess = feature.direction;
        let vertex = difference.support(&-feature.direction);
        plane = vertex.point.dot(&feature.direction) / feature.direction.norm();
        if plane > apart_above {
            return Outcome::Apart;
        }
        if plane > early.above && distance - plane <= early.share * (distance - early.from) {
            return Outcome::Settled(Settled { simplex: *simplex, feature, plane, is_coarse: true });
        }
        if distance - plane <= tolerance || simplex.contains(&vertex.point) {
            break;
        }
        simplex.push(vertex);
        let Some(next_feature) = simplex.nearest(4.0 * difference.rounding) else {
            return Outcome::Overlapping(*simplex);
        };
        // The new vertex lowers the distance unless rounding hides it; a new direction may still
        // make progress.
        if next_feature.square >= feature.square {
            stalls += 1;
            let is_worse = next_feature.square.sqrt() > distance + difference.rounding;
            if is_worse || stalls > MAX_STALLS || !next_feature.uses(simplex.count - 1) {
                simplex.pop();
                break;
            }
        }
        simplex.keep(&next_feature);
        feature = next_feature;
    }
    Outcome::Settled(Settled { simplex: *simplex, feature, plane, is_coarse: false })
}
