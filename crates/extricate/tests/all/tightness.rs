//! How tight proved bounds are: a change that loosens them fails here, though every bound still
//! holds.

use extricate::{Effort, QueryOptions, QueryScratch, builtin};

use crate::memory::learn;
use crate::query::colliding;

/// Of each scene, the least mean of the bound over the depth of a refined answer: bounds of refined
/// answers, and of `nearest` ones.
///
/// Measured by this test, which prints them, with the seed that it learns with: 0.2806, 0.7031,
/// 0.5094, 0.3019, 0.5271, 0.4540 and 0.1809, 0.6012, 0.2604, 0.1698, 0.3572, 0.2119. Bounds depend
/// on the query, not on what was learned: with three other seeds the first six differed by 0.4 % at
/// most. These are 1 to 3 % below.
const FLOORS: [(&str, f64, f64); 6] = [
    ("shelf-arm", 0.277, 0.177),
    ("planar-arm", 0.697, 0.592),
    ("free-box", 0.503, 0.255),
    ("dual-arm", 0.297, 0.166),
    ("hand", 0.522, 0.350),
    ("four-legs", 0.449, 0.207),
];

#[test]
fn bounds_are_as_tight_as_they_were() {
    let mut looser = Vec::new();
    assert_eq!(FLOORS.map(|(name, ..)| name), builtin::NAMES);
    for (name, refined_floor, nearest_floor) in FLOORS {
        let model = learn(builtin::scene(name).unwrap(), 6_000, 7);
        let mut scratch = QueryScratch::default();
        let (mut refined, mut nearest) = (0.0, 0.0);
        let queries = colliding(&model, 100);
        for q in &queries {
            let mut ask = |effort| {
                model.view().query_with(q, &QueryOptions { effort, ..QueryOptions::default() }, &mut scratch).unwrap()
            };
            let answer = ask(Effort::Refined);
            refined += answer.lower_bound / answer.depth / queries.len() as f64;
            nearest += ask(Effort::Nearest).lower_bound / answer.depth / queries.len() as f64;
        }
        println!("{name}: {refined:.4} refined, {nearest:.4} nearest");
        if refined < refined_floor || nearest < nearest_floor {
            looser.push(format!(
                "{name}: bounds are {refined:.4} and of `nearest` {nearest:.4} of the depth, were {refined_floor} and {nearest_floor} at least"
            ));
        }
    }
    assert!(looser.is_empty(), "{}", looser.join("\n"));
}
