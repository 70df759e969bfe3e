//! `extricate` in a browser: a scene or a model is opened once, then queried, and its obstacles
//! moved, without a server.
//!
//! `exports` is what JavaScript calls: bytes in, bytes out, no pointer is read here. `session` is
//! what is open, and what requests mean.

mod exports;
mod session;

pub use session::Session;
