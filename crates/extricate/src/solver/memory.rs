//! Scratch memory that queries and checks reuse, whichever thread they run on.

use std::sync::{Mutex, PoisonError};

use crate::collision::CheckScratch;
use crate::query::QueryScratch;

/// Scratches of one kind that are kept; more threads than that allocate theirs anew.
const MAX_KEPT_SCRATCHES: usize = 256;

/// Pool of scratch memory, one scratch for each thread that was ever at work at the same time.
#[derive(Default)]
pub struct Memory {
    queries: Mutex<Vec<QueryScratch>>,
    checks: Mutex<Vec<CheckScratch>>,
}

impl Memory {
    /// Calls `work` with scratch memory that nobody else uses meanwhile.
    pub fn of_queries<T>(&self, work: impl FnOnce(&mut QueryScratch) -> T) -> T {
        with(&self.queries, work)
    }

    /// Does the same as [`Memory::of_queries`] for checks.
    pub fn of_checks<T>(&self, work: impl FnOnce(&mut CheckScratch) -> T) -> T {
        with(&self.checks, work)
    }
}

fn with<Scratch: Default, T>(pool: &Mutex<Vec<Scratch>>, work: impl FnOnce(&mut Scratch) -> T) -> T {
    let own = pool.lock().unwrap_or_else(PoisonError::into_inner).pop();
    let mut scratch = own.unwrap_or_default();
    let result = work(&mut scratch);
    let mut pool = pool.lock().unwrap_or_else(PoisonError::into_inner);
    if pool.len() < MAX_KEPT_SCRATCHES {
        pool.push(scratch);
    }
    result
}
