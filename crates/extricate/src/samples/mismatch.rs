//! The error for a stored array that contradicts the model it belongs to.

/// A stored array that contradicts the model it belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mismatch {
    /// Owner of the array: `index`, `exits` (the index of solved samples) or `planes`.
    pub of: &'static str,
    /// Name of the array.
    pub array: &'static str,
    /// What the array should hold.
    pub expected: &'static str,
}
