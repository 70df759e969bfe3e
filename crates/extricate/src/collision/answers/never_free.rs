//! Why no free configuration was found: pairs that collide in every sampled one. [`Checker`]
//! documents the functions without docs at its methods of the same names.

use super::pair_answers::{always_colliding, nearly_always_colliding};
use crate::collision::checker::Checker;
use crate::cspace::sampling::Halton;
use crate::scene::PairId;

/// Configurations sampled for the advice. A pair that collides in all of them is hardly ever free,
/// if at all.
const SAMPLED_CONFIGS: u64 = 100;
/// Pairs that the advice names; it counts the others.
const MAX_NAMED_PAIRS: usize = 20;

pub fn pairs_always_colliding(checker: &Checker, samples: u64) -> Vec<PairId> {
    until_stopped(checker, samples, || false)
}

pub fn pairs_nearly_always_colliding(checker: &Checker, samples: u64, share: f64) -> Vec<(PairId, usize)> {
    let misses = misses_allowed(samples as usize, share);
    let mut pairs = nearly_always_colliding(checker, configs(checker, samples), misses);
    pairs.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    pairs
}

/// Returns in how many of `samples` configurations a pair may be free that collides in `share` of
/// them.
pub fn misses_allowed(samples: usize, share: f64) -> usize {
    // A rounded share must not lose one: 0.95 of 1000 is 950 collisions.
    ((1.0 - share) * samples as f64 + 1e-6) as usize
}

fn until_stopped(checker: &Checker, samples: u64, stopped: impl Fn() -> bool) -> Vec<PairId> {
    always_colliding(checker, configs(checker, samples).take_while(|_| !stopped()))
}

fn configs(checker: &Checker, samples: u64) -> impl Iterator<Item = Vec<f64>> {
    let space = &checker.scene().space;
    let halton = Halton::new(space.nv(), 0);
    (0..samples).map(move |index| {
        let mut q = vec![0.0; space.nq()];
        halton.config(space, index, &mut q);
        q
    })
}

/// Formats pairs of names as the list that `disable` takes in the `[pairs]` table of a scene file.
pub fn disable_list(pairs: &[[&str; 2]]) -> String {
    // Debug quotes strings as TOML's basic strings are, except control characters, which no name
    // has.
    let pairs: Vec<_> = pairs.iter().map(|[a, b]| format!("[{a:?}, {b:?}]")).collect();
    format!("[{}]", pairs.join(", "))
}

pub fn advice_if_never_free(checker: &Checker, stopped: impl Fn() -> bool) -> Option<String> {
    let pairs = until_stopped(checker, SAMPLED_CONFIGS, stopped);
    let (named, others) = pairs.split_at(pairs.len().min(MAX_NAMED_PAIRS));
    let names: Vec<[&str; 2]> = named.iter().map(|pair| checker.scene().pair_names(*pair)).collect();
    let list = disable_list(&names);
    let others = if others.is_empty() { String::new() } else { format!("; {} more pairs do, too", others.len()) };
    let told = format!("these pairs collide in all of {SAMPLED_CONFIGS} configurations that were tried");
    let advice = format!("{told}; if by design, add to the scene: [pairs] disable = {list}{others}");
    (!pairs.is_empty()).then_some(advice)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Pose, Vec3};
    use crate::robot::Geometry;
    use crate::scene::{Body, builtin};

    #[test]
    fn pairs_that_collide_wherever_one_looks_are_named_with_the_line_to_add() {
        let world = |radius: f64| {
            let ball = Body::obstacle("all", Geometry::Sphere { radius }, Pose::translation(Vec3::x() * 50.0));
            Checker::new(builtin::scene("planar-arm").unwrap().with_obstacles([ball]).unwrap().into())
        };
        assert_eq!(advice_if_never_free(&world(1.0), || false), None);
        let checker = world(100.0);
        let asked = std::cell::Cell::new(0);
        let stopped = || asked.replace(asked.get() + 1) == 3;
        advice_if_never_free(&checker, stopped);
        assert_eq!(asked.get(), 4, "it goes on though it was told to stop");
        let advice = advice_if_never_free(&checker, || false).unwrap();
        assert!(advice.starts_with("these pairs collide in all of 100 configurations that were tried; if by design"));
        let pairs: Vec<_> = (0..checker.scene().pairs.len()).map(PairId::new).collect();
        let names = pairs.iter().map(|pair| checker.scene().pair_names(*pair)).filter(|[_, other]| *other == "all");
        let list = disable_list(&names.collect::<Vec<_>>());
        assert!(
            list.len() > 10 && advice.ends_with(&format!("add to the scene: [pairs] disable = {list}")),
            "{advice}"
        );
    }
}
