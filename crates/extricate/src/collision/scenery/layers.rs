//! Number of layers of occupied cells around each cell of a grid.

/// Returns for every cell its number of steps to the nearest empty cell. A step leads to one of the
/// 26 neighbours, so a cell beside an empty one has 1. `cells` must ascend.
///
/// The cube of `2 k - 1` cells a side around a cell of `k` layers is therefore full.
///
/// # Source
/// A. Rosenfeld and J. L. Pfaltz, "Sequential operations in digital picture processing", Journal of
/// the ACM 13(4), 1966, doi:10.1145/321356.321357: two passes in the order of the cells. Deviation:
/// the cells are a sorted list, and an index for every earlier neighbour advances along the list.
pub fn layers(cells: &[[i32; 3]]) -> Vec<u16> {
    let mut layers = vec![u16::MAX; cells.len()];
    for forward in [true, false] {
        // The 13 neighbours that come before a cell in the order of the pass.
        let steps: Vec<[i32; 3]> = (0..13).map(|n| [n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1]).collect();
        let mut places = [0usize; 13];
        for visit in 0..cells.len() {
            let at = |visit: usize| if forward { visit } else { cells.len() - 1 - visit };
            let cell = cells[at(visit)];
            let mut least = layers[at(visit)];
            for (step, place) in steps.iter().zip(&mut places) {
                let sign = if forward { 1 } else { -1 };
                let wanted: [i32; 3] = std::array::from_fn(|k| cell[k].saturating_add(sign * step[k]));
                let is_before = |other: &[i32; 3]| if forward { *other < wanted } else { *other > wanted };
                while *place < visit && is_before(&cells[at(*place)]) {
                    *place += 1;
                }
                let beside = if *place < visit && cells[at(*place)] == wanted { layers[at(*place)] } else { 0 };
                least = least.min(beside.saturating_add(1));
            }
            layers[at(visit)] = least;
        }
    }
    layers
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use std::collections::HashSet;

    #[test]
    fn layers_are_what_growing_cubes_count() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        let mut deepest = 0;
        for round in 0..30 {
            let side = 4 + round % 9;
            let share = [0.5, 0.95, 0.995][round as usize % 3];
            let mut cells: Vec<[i32; 3]> = (0..side * side * side)
                .map(|at| [at / (side * side) - 2, at / side % side, at % side + 5])
                .filter(|_| rng.random::<f64>() < share)
                .collect();
            cells.sort_unstable();
            let set: HashSet<[i32; 3]> = cells.iter().copied().collect();
            let is_full = |cell: &[i32; 3], k: i32| {
                let range = -k..=k;
                let offsets = range.clone().flat_map(|x| {
                    let range = range.clone();
                    range.clone().flat_map(move |y| range.clone().map(move |z| [x, y, z]))
                });
                offsets.into_iter().all(|o| set.contains(&[cell[0] + o[0], cell[1] + o[1], cell[2] + o[2]]))
            };
            for (cell, found) in cells.iter().zip(layers(&cells)) {
                let expected = (1..).find(|k| !is_full(cell, *k)).unwrap();
                assert_eq!(i32::from(found), expected, "{cell:?}");
                deepest = deepest.max(found);
            }
        }
        assert!(deepest > 3, "{deepest}");
    }
}
