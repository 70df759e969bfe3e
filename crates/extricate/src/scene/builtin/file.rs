//! A file that the built-in scenes generate.

/// Path relative to the scene file, and contents.
pub type File = (String, Vec<u8>);
