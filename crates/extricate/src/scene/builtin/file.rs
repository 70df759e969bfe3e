//! The type of a generated file.

/// Path relative to the scene file, and contents.
pub type File = (String, Vec<u8>);
