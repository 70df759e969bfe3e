//! How widely the queries of a scene have to search: the least that misses next to nothing, measured.

use rayon::prelude::*;

use super::measure::Extent;
use crate::penetration::{Ground, QueryOptions, QueryScratch, Width, nearest_exit};
use crate::scene::MetricSpec;

/// Held-out colliding configurations that are asked at every width.
const QUERIES: usize = 512;
/// With fewer, a width that misses none says nothing: one that misses one in twelve does so of 24 in one of eight models, of 64 in one of 260.
const LEAST_TO_TELL: usize = 64;
/// With fewer, it does not say that queries may be narrower than usual: of a width that misses one in twenty-five, none of 64 misses
/// in one of fourteen models.
const LEAST_TO_NARROW: usize = 256;
/// Of so many, one may be missed.
const ASKED_A_MISS: usize = 100;
/// By the narrowest, one of so many: the usual one misses a third of what it does, for a third more checks.
const ASKED_A_MISS_OF_NARROW: usize = 200;
/// Of fewer, none: a width that misses one in twenty-five misses no more than one of 111 in one of sixteen models, of 160 in one of ninety.
const LEAST_TO_MISS: usize = 160;
/// An answer farther than this times the nearest one of all widths misses it.
const NEAR: f64 = 1.05;
/// Asked between two looks at the clock.
const ASKED_AT_ONCE: usize = 16;

/// Of each width, in their order: how many nearest ways out it missed.
type Misses = [usize; Width::ALL.len()];

/// The least width that misses no more than one nearest way out in a hundred (the narrowest: in two hundred), as far as the wider ones find it; the widest
/// where all do. `colliding`
/// (row major) are asked at every width that may still be the one, and the evaluations that took are returned too. Where less than 256 could be asked,
/// none narrower than what the extent knows, or else than usual; where less than 160, none that missed one of them; where less than 64 and nothing is
/// known, the widest under the metric of the joints.
///
/// # Guarantee
/// Without a time to stop at, the result depends on the arguments alone, not on the number of threads.
pub fn choose_width(
    ground: &Ground,
    colliding: &[f64],
    extent: &Extent,
    go_on: &mut dyn FnMut() -> bool,
) -> (Width, usize) {
    let nq = ground.checker.scene().space.nq();
    let mut rest = &colliding[..colliding.len().min(QUERIES * nq)];
    let all = rest.len() / nq;
    let (mut misses, mut asked, mut checks): (Misses, _, _) = ([0; Width::ALL.len()], 0, 0);
    // Few at first: how many evaluations one takes differs by a hundred times from scene to scene.
    let mut size = 1;
    // Until something is told that makes them narrower, queries search as widely as they can; not where the metric bends, under which the usual
    // width misses little (5 of 1,000 queries of `free-box`, the widest 2 for a ninth more checks).
    let untold = if ground.metric.kind() == MetricSpec::Joint { Width::Widest } else { Width::Usual };
    let before = Before { known: extent.known, untold };
    // Widths tell apart what searches in turn.
    if !ground.takes_turns() || extent.queries == 0 || all < LEAST_TO_TELL {
        return (before.known.unwrap_or(untold), 0);
    }
    // Half of what may be spent; the other half is for the excess.
    let most = extent.checks / 2;
    while !rest.is_empty() && !extent.is_over() && go_on() {
        if checks > most {
            break;
        }
        let widths: Vec<Width> = candidates(&misses, all).collect();
        if widths.len() == 1 {
            break;
        }
        let block;
        (block, rest) = rest.split_at(rest.len().min(size * nq));
        size = ASKED_AT_ONCE.min(2 * size);
        let rows: Vec<(Misses, usize)> = block
            .par_chunks_exact(nq)
            .with_max_len(1)
            .map_init(QueryScratch::default, |scratch, q| missed(ground, q, &widths, scratch))
            .collect();
        asked += rows.len();
        for (missed, spent) in rows {
            misses.iter_mut().zip(missed).for_each(|(sum, one)| *sum += one);
            checks += spent;
        }
    }
    (chosen(&misses, asked, all, before), checks)
}

/// What is thought of the width before any was tried.
#[derive(Debug, Clone, Copy)]
struct Before {
    /// By an earlier model of nearly the same scene.
    known: Option<Width>,
    /// Taken where nothing is known and nothing is told.
    untold: Width,
}

/// Of `asked` configurations of `all`.
fn chosen(misses: &Misses, asked: usize, all: usize, before: Before) -> Width {
    if candidates(misses, all).count() == 1 {
        return Width::Widest;
    }
    let least = match (asked, before.known) {
        (LEAST_TO_NARROW.., _) => Width::Narrow,
        (_, Some(known)) => known,
        (..LEAST_TO_TELL, None) => before.untold,
        (_, None) => Width::Usual,
    };
    candidates(misses, asked).find(|width| *width >= least).unwrap_or(Width::Widest)
}

/// Widths that have missed no more than they may of `asked`, and the widest.
fn candidates(misses: &Misses, asked: usize) -> impl Iterator<Item = Width> {
    let allowed = move |width: Width| match width {
        _ if asked < LEAST_TO_MISS => 0,
        Width::Narrow => asked / ASKED_A_MISS_OF_NARROW,
        _ => asked / ASKED_A_MISS,
    };
    let may_be = move |(width, missed): &(Width, usize)| *width == Width::Widest || *missed <= allowed(*width);
    Width::ALL.into_iter().zip(*misses).filter(may_be).map(|(width, _)| width)
}

/// Which of `widths` missed the nearest way out of `q` that one of them found, and the evaluations of all.
fn missed(ground: &Ground, q: &[f64], widths: &[Width], scratch: &mut QueryScratch) -> (Misses, usize) {
    let (mut depths, mut checks, mut nearest) = ([f64::INFINITY; Width::ALL.len()], 0, f64::INFINITY);
    // A configuration that was drawn keeps the limits but for rounding, which this mends.
    let Ok(q) = ground.checker.scene().space.config(q) else { return (Misses::default(), 0) };
    for &width in widths {
        let ground = Ground { width, ..*ground };
        let Some(answer) = nearest_exit(&ground, &q, &QueryOptions::default(), scratch) else { continue };
        checks += scratch.checks();
        depths[width as usize] = answer.depth;
        nearest = nearest.min(answer.depth);
    }
    let mut missed = Misses::default();
    widths.iter().for_each(|width| missed[*width as usize] = usize::from(depths[*width as usize] > NEAR * nearest));
    (missed, checks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::LearnOptions;
    use crate::model::Model;
    use crate::model::measure::tests::colliding;
    use crate::scene::builtin;
    use std::ops::ControlFlow;

    fn learned(name: &str, labels: usize) -> Model {
        let options = LearnOptions { labels, seconds: None, seed: 2, ..LearnOptions::default() };
        Model::learn(builtin::scene(name).unwrap(), &options, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    fn rows(model: &Model, count: usize) -> Vec<f64> {
        colliding(model, count).iter().flat_map(|q| q.to_vec()).collect()
    }

    #[test]
    fn the_least_width_that_misses_no_more_than_it_may_is_taken() {
        let first = |misses, asked| candidates(&misses, asked).next().unwrap();
        assert_eq!(first([1, 9, 9, 9], 256), Width::Narrow);
        assert_eq!(first([2, 2, 0, 0], 256), Width::Usual);
        assert_eq!(first([3, 3, 3, 9], 256), Width::Widest);
        assert_eq!([159, 160, 200].map(|asked| first([1, 1, 0, 0], asked)), [Width::Wide, Width::Usual, Width::Narrow]);
        assert_eq!(candidates(&[3, 2, 3, 9], 256).collect::<Vec<_>>(), [Width::Usual, Width::Widest]);
        // Of few, none may be missed, and nothing is told that would make queries narrower.
        let usual = Before { known: Some(Width::Usual), untold: Width::Widest };
        let of_few = |misses| chosen(&misses, 20, 512, usual);
        assert_eq!(
            [of_few([0; 4]), of_few([1, 0, 0, 0]), of_few([2, 1, 0, 0])],
            [Width::Usual, Width::Usual, Width::Wide]
        );
        assert_eq!([of_few([3, 3, 1, 2]), of_few([6, 6, 6, 1])], [Width::Widest; 2]);
        assert_eq!(
            [64, 255, 256].map(|asked| chosen(&[0; 4], asked, 512, usual)),
            [Width::Usual, Width::Usual, Width::Narrow]
        );
        assert_eq!([199, 200].map(|asked| chosen(&[2, 2, 0, 0], asked, 512, usual)), [Width::Wide, Width::Usual]);
        // Where nothing is known, as wide as can be until there is something to tell by.
        let of_unknown = |asked| chosen(&[1, 0, 0, 0], asked, 512, Before { known: None, ..usual });
        assert_eq!([0, 63].map(of_unknown), [Width::Widest; 2]);
        assert_eq!([64, 159, 160, 255].map(of_unknown), [Width::Usual; 4]);
        // What is known is not narrowed by a few.
        let of_wide = |asked| chosen(&[0; 4], asked, 512, Before { known: Some(Width::Wide), ..usual });
        assert_eq!(
            [0, 24, 100, 255, 256].map(of_wide),
            [Width::Wide, Width::Wide, Width::Wide, Width::Wide, Width::Narrow]
        );
    }

    #[test]
    fn what_is_chosen_does_not_depend_on_the_number_of_threads() {
        let model = learned("hand", 30_000);
        let (asked, extent) = (rows(&model, 96), Extent::in_full(0));
        let chosen = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| choose_width(&model.ground(), &asked, &extent, &mut || true))
        };
        let (width, checks) = chosen(1);
        assert_eq!((width, checks), chosen(3));
        assert!(checks > 96, "{checks}");
    }

    #[test]
    fn wider_queries_miss_less() {
        let model = learned("dual-arm", 40_000);
        let mut scratch = QueryScratch::default();
        let mut misses = Misses::default();
        for q in colliding(&model, 80) {
            let (one, checks) = missed(&model.ground(), &q, &Width::ALL, &mut scratch);
            assert!(checks > 0 && one.iter().all(|missed| *missed <= 1) && one.contains(&0), "{one:?}");
            misses.iter_mut().zip(one).for_each(|(sum, one)| *sum += one);
        }
        assert!(misses[3] < misses[1] && misses[3] < misses[0], "{misses:?}");
    }

    #[test]
    fn nothing_is_chosen_where_nothing_can_be_told() {
        let model = learned("planar-arm", 12_000);
        let ground = model.ground();
        let choose = |rows: &[f64], extent: &Extent, go_on: bool| choose_width(&ground, rows, extent, &mut || go_on);
        let (few, many) = (rows(&model, 20), rows(&model, 70));
        let in_full = Extent::in_full(0);
        assert_eq!(choose(&few, &in_full, true), (Width::Widest, 0));
        let known = Extent { known: Some(Width::Wide), ..in_full };
        assert_eq!(choose(&few, &known, true), (Width::Wide, 0), "what was known stays");
        assert_eq!(choose(&many, &in_full, false), (Width::Widest, 0));
        // What the first one takes shows that enough of them are not to be paid for.
        let (width, checks) = choose(&many, &Extent { checks: 100, ..in_full }, true);
        assert!(width == Width::Widest && checks > 0 && checks < 1000, "{width:?} {checks}");
        assert!(choose(&many, &in_full, true).1 > 2 * checks);
    }
}
