//! Which pairs of bodies are checked.
