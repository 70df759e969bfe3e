//! How many starts the queries of a scene take, measured on held-out configurations.
//!
//! How late the start is that finds the nearest exit has a long tail: its far quantiles, which say
//! how many starts miss one exit in a hundred, are chance where a few hundred configurations are
//! asked. The mean of its logarithm is not, and the quantiles follow it: over twelve models of six
//! scenes the 98th percentile was 23 to 86 times it, over one part in seven of its range.

use rayon::prelude::*;
use serde::{Deserialize, Deserializer};

use super::budget::EvaluationBudget;
use crate::cspace::Config;
use crate::query::{Context, QueryScratch, Ranks, StartsPerDof, measure_ranks};

/// Held-out colliding configurations that are asked.
const QUERIES: usize = 1024;
/// They may take this times the checks of other measurements: what every query costs depends on
/// them.
const TIMES_THE_CHECKS: usize = 2;
/// Asked between two looks at the clock.
const ASKED_AT_ONCE: usize = 16;
/// Starts for each unit of the mean logarithm.
const STORED_A_LOG: f64 = 75.0;
const AROUND_A_LOG: f64 = 120.0;
/// What is taken for the means before anything is measured, and for how many configurations that
/// counts.
const BEFORE: Means = Means { stored: 0.06, around: 0.003 };
const BEFORE_COUNTS: f64 = 64.0;

/// Of the logarithm of ranks, over degrees of freedom.
#[derive(Debug, Clone, Copy)]
struct Means {
    stored: f64,
    around: f64,
}

/// Where nothing was measured.
pub fn unmeasured() -> StartsPerDof {
    starts(BEFORE)
}

fn starts(means: Means) -> StartsPerDof {
    StartsPerDof { stored: STORED_A_LOG * means.stored, around: AROUND_A_LOG * means.around }
}

/// Starts for each degree of freedom, and the evaluations that it took to tell. `colliding` (row
/// major) are asked as long as the extent pays for it.
///
/// # Guarantee
/// Without a time to stop at, the result depends on the arguments alone, not on the number of
/// threads.
pub fn calibrate(
    context: &Context,
    colliding: &[f64],
    extent: &EvaluationBudget,
    go_on: &mut dyn FnMut() -> bool,
) -> (StartsPerDof, usize) {
    let space = &context.checker.scene().space;
    let before = extent
        .known
        .map_or(BEFORE, |known| Means { stored: known.stored / STORED_A_LOG, around: known.around / AROUND_A_LOG });
    let (mut found, mut checks, mut size): (Vec<Ranks>, _, _) = (Vec::new(), 0, 1);
    let most_checks = extent.checks.saturating_mul(TIMES_THE_CHECKS);
    let mut rest = &colliding[..colliding.len().min(QUERIES * space.nq())];
    while !rest.is_empty() && extent.queries > 0 && checks < most_checks && !extent.is_over() && go_on() {
        let block;
        (block, rest) = rest.split_at(rest.len().min(size * space.nq()));
        // Knn at first: how many evaluations one takes differs by a hundred times from scene to
        // scene.
        size = ASKED_AT_ONCE.min(2 * size);
        let rows: Vec<(Vec<Ranks>, usize)> = block
            .par_chunks_exact(space.nq())
            .with_max_len(1)
            .map_init(QueryScratch::default, |scratch, q| {
                // A configuration that was drawn keeps the limits but for rounding, which this
                // mends.
                space.config(q).map_or((Vec::new(), 0), |q: Config| measure_ranks(context, &q, scratch))
            })
            .collect();
        for (ranks, spent) in rows {
            found.extend(ranks);
            checks += spent;
        }
    }
    (starts(means(&found, before)), checks)
}

/// Of what was found, and of what was thought before.
fn means(found: &[Ranks], before: Means) -> Means {
    let mean = |before: f64, of: &dyn Fn(&Ranks) -> f64| {
        let sum: f64 = found.iter().map(|ranks| of(ranks) / ranks.degrees.max(1) as f64).sum();
        (BEFORE_COUNTS * before + sum) / (BEFORE_COUNTS + found.len() as f64)
    };
    Means {
        stored: mean(before.stored, &|ranks| (ranks.stored.max(1) as f64).ln()),
        around: mean(before.around, &|ranks| (1.0 + ranks.around as f64).ln()),
    }
}

/// A model's numbers as its file says them; models of format 6 and before say one of four words.
#[derive(Deserialize)]
#[serde(untagged)]
enum Told {
    Numbers(StartsPerDof),
    Width(String),
}

/// Reads them.
pub fn read<'de, D: Deserializer<'de>>(source: D) -> Result<StartsPerDof, D::Error> {
    use serde::de::Error;
    let (stored, around) = match Told::deserialize(source)? {
        Told::Numbers(StartsPerDof { stored, around }) => (stored, around),
        Told::Width(width) => match &width[..] {
            "narrow" => (1.0, 0.0),
            "usual" => (2.0, 0.0),
            "wide" => (4.0, 0.5),
            "widest" => (7.0, 1.0),
            _ => return Err(D::Error::custom(format!("width: got {width}, expected narrow, usual, wide or widest"))),
        },
    };
    if stored >= 0.0 && around >= 0.0 && stored.is_finite() && around.is_finite() {
        Ok(StartsPerDof { stored, around })
    } else {
        Err(D::Error::custom(format!(
            "starts_per_dof: got {stored} and {around}, expected finite numbers of at least 0"
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::LearnOptions;
    use crate::model::Model;
    use crate::model::evaluate::tests::colliding;
    use crate::scene::builtin;

    fn learned(name: &str, labels: usize, seed: u64) -> Model {
        let options = LearnOptions { labels, seconds: None, seed, ..LearnOptions::default() };
        Model::learn(builtin::scene(name).unwrap(), &options).unwrap()
    }

    #[test]
    fn what_is_found_late_takes_more_starts() {
        let ranks = |stored, around| Ranks { degrees: 7, stored, around };
        let of = |stored, around| starts(means(&vec![ranks(stored, around); 200], BEFORE));
        assert!(of(1, 0).stored < of(2, 0).stored && of(2, 0).stored < of(20, 0).stored);
        assert!(of(1, 0).around < of(1, 1).around && of(1, 1).around < of(1, 20).around);
        assert_eq!(starts(means(&[], BEFORE)), unmeasured());
    }

    #[test]
    fn it_does_not_depend_on_the_number_of_threads_and_little_on_chance() {
        // Few queries need more than one start: what is told of fewer labels is chance.
        let models = [1, 2, 3].map(|seed| learned("shelf-arm", 150_000, seed));
        let rows: Vec<f64> = colliding(&models[0], 64).iter().flat_map(|q| q.to_vec()).collect();
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| calibrate(&models[0].context(), &rows, &EvaluationBudget::in_full(0), &mut || true))
        };
        assert_eq!(on(1), on(3));
        let stored = models.map(|model| model.statistics().starts_per_dof.stored);
        let (least, most) =
            (stored.iter().copied().fold(f64::INFINITY, f64::min), stored.iter().copied().fold(0.0, f64::max));
        assert!(most < 1.5 * least, "{stored:?}");
    }

    #[test]
    fn words_of_older_models_are_read() {
        #[derive(Deserialize)]
        struct Statistics {
            #[serde(alias = "width", deserialize_with = "read")]
            starts_per_dof: StartsPerDof,
        }
        let read = |text: &str| serde_json::from_str::<Statistics>(text).map(|found| found.starts_per_dof.stored);
        assert_eq!(read(r#"{"width": "wide"}"#).unwrap(), 4.0);
        assert_eq!(read(r#"{"starts_per_dof": {"stored": 2.5, "around": 0.25}}"#).unwrap(), 2.5);
        for wrong in [r#"{"width": "wider"}"#, r#"{"starts_per_dof": {"stored": -1.0, "around": 0.0}}"#] {
            assert!(read(wrong).unwrap_err().to_string().contains("expected"), "{wrong}");
        }
    }
}
