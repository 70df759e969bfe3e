//! Why nothing free was found: pairs that collide wherever one looks.

use super::found::{always_colliding, nearly_always_colliding};
use crate::collision::checker::Checker;
use crate::cspace::sampling::Halton;
use crate::scene::PairId;

/// Configurations that are tried. A pair that collides in all of them is hardly ever free, if at
/// all.
const TRIED: u64 = 100;
/// Pairs that a message names.
const NAMED: usize = 20;

/// Pairs that collide in each of `samples` low-discrepancy configurations: most likely overlap by
/// design.
pub fn pairs_always_colliding(checker: &Checker, samples: u64) -> Vec<PairId> {
    until_stopped(checker, samples, || false)
}

/// Pairs that collide in at least this share of `samples` low-discrepancy configurations, and in
/// how many, the most frequent first.
pub fn pairs_nearly_always_colliding(checker: &Checker, samples: u64, share: f64) -> Vec<(PairId, usize)> {
    let misses = misses_allowed(samples as usize, share);
    let mut pairs = nearly_always_colliding(checker, configs(checker, samples), misses);
    pairs.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    pairs
}

/// In how many of so many configurations a pair may be free that collides in this share of them.
pub fn misses_allowed(samples: usize, share: f64) -> usize {
    // The share may be rounded: 0.95 of 1000 is 950 collisions.
    ((1.0 - share) * samples as f64 + 1e-6) as usize
}

fn until_stopped(checker: &Checker, samples: u64, stopped: impl Fn() -> bool) -> Vec<PairId> {
    always_colliding(checker, configs(checker, samples).take_while(|_| !stopped()))
}

/// Low-discrepancy configurations.
fn configs(checker: &Checker, samples: u64) -> impl Iterator<Item = Vec<f64>> {
    let space = &checker.scene().space;
    let halton = Halton::new(space.nv(), 0);
    (0..samples).map(move |index| {
        let mut q = vec![0.0; space.nq()];
        halton.config(space, index, &mut q);
        q
    })
}

/// Pairs, by their names, as the list that the scene file's `[pairs]` table takes for `disable`.
pub fn disable_list(pairs: &[[&str; 2]]) -> String {
    // Debug quotes a string as TOML's basic strings do, but for control characters, which no name
    // has.
    let pairs: Vec<_> = pairs.iter().map(|[a, b]| format!("[{a:?}, {b:?}]")).collect();
    format!("[{}]", pairs.join(", "))
}

/// What to say where no free configuration was found: which pairs collide in all of a hundred
/// configurations, and what to do if they overlap by design. `None` where no pair does. Nothing to
/// rely on where `stopped` said so.
pub fn advice_if_never_free(checker: &Checker, stopped: impl Fn() -> bool) -> Option<String> {
    let pairs = until_stopped(checker, TRIED, stopped);
    let (named, others) = pairs.split_at(pairs.len().min(NAMED));
    let names: Vec<[&str; 2]> = named.iter().map(|pair| checker.scene().pair_names(*pair)).collect();
    let list = disable_list(&names);
    let others = if others.is_empty() { String::new() } else { format!("; {} more pairs do, too", others.len()) };
    let told = format!("these pairs collide in all of {TRIED} configurations that were tried");
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
