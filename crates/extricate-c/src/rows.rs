//! Reads consecutive configurations of callers.

use extricate::{Config, ConfigSpace};

use crate::status::{Fault, Result};

/// Reads all rows, which may lie beyond the limits; fails at the first that is no configuration.
pub fn configs_anywhere(space: &ConfigSpace, rows: (&[f64], usize, usize)) -> Result<Vec<Config>> {
    configs(space, rows, &|q| Ok(space.config_anywhere(q)?))
}

/// Reads all rows with `config`; fails at the first row that it refuses.
pub fn configs(
    space: &ConfigSpace,
    (q, count, nq): (&[f64], usize, usize),
    config: &dyn Fn(&[f64]) -> Result<Config>,
) -> Result<Vec<Config>> {
    let own = space.nq();
    if nq != own && count > 0 {
        return Err(Fault::argument(format!("nq: got {nq}, expected {own}")));
    }
    let rows = q.chunks_exact(own.max(1)).enumerate();
    rows.map(|(row, q)| config(q).map_err(|fault| fault.of(&format!("row {row}")))).collect()
}
