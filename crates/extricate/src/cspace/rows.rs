//! Many configurations as one list of numbers.

use crate::error::{Error, Result};

/// Configurations one after the other in one list, `nq` numbers each. Limits are not checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rows<'a> {
    values: &'a [f64],
    nq: usize,
}

impl<'a> Rows<'a> {
    /// Splits a list into rows of `nq` numbers.
    ///
    /// # Errors
    /// If `nq` is 0, or the list is no whole number of rows.
    pub fn new(values: &'a [f64], nq: usize) -> Result<Self> {
        if nq == 0 || !values.len().is_multiple_of(nq) {
            let problem = format!("got {} numbers, expected a multiple of {nq}", values.len());
            return Err(Error::input("configurations", "rows", problem));
        }
        Ok(Self { values, nq })
    }

    /// Number of rows in the list.
    pub fn len(&self) -> usize {
        self.values.len() / self.nq
    }

    /// Returns whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Returns row `index`, counted from 0.
    ///
    /// # Panics
    /// If there are no more than `index` rows.
    pub fn row(&self, index: usize) -> &'a [f64] {
        &self.values[index * self.nq..][..self.nq]
    }

    /// Iterates over all rows, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &'a [f64]> {
        self.values.chunks_exact(self.nq)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_whole() {
        let values = [1.0, 2.0, 3.0, 4.0];
        let rows = Rows::new(&values, 2).unwrap();
        assert_eq!((rows.len(), rows.row(1), rows.iter().len()), (2, &[3.0, 4.0][..], 2));
        assert!(Rows::new(&values, 3).is_err() && Rows::new(&values, 0).is_err());
        assert!(Rows::new(&[], 3).unwrap().is_empty());
    }
}
