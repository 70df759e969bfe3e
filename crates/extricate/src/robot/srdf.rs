//! SRDF: `disable_collisions` and groups. Everything else in the file is ignored.
