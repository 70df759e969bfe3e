//! The scene file format (TOML), as written by users. Not the resolved scene.
