//! `extricate` in a browser, without a server: opens a scene or a model, answers queries and moves
//! obstacles.
//!
//! `exports` is the interface for JavaScript: bytes in, bytes out, and it reads no pointer.
//! `session` keeps the open scene or model, and answers requests.

mod exports;
mod session;

pub use session::Session;
