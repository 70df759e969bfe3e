//! That an array does not fit what it stands beside.

/// An array that does not fit what it stands beside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mismatch {
    /// Of what it is an array: `index`, `solved` or `planes`.
    pub of: &'static str,
    /// Its name.
    pub array: &'static str,
    /// What it should hold.
    pub expected: &'static str,
}
