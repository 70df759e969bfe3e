//! Messages to the user on standard error, all in one shape: `extricate: error: ...`.

use std::fmt::Display;
use std::io::Write;

/// Something failed.
pub fn error(message: impl Display) {
    write("error: ", message);
}

/// Something is worth knowing before the result is trusted.
pub fn warning(message: impl Display) {
    write("warning: ", message);
}

/// Where a long job stands, or what was done.
pub fn note(message: impl Display) {
    write("", message);
}

/// A closed standard error is no reason to stop.
fn write(severity: &str, message: impl Display) {
    let _ = writeln!(std::io::stderr().lock(), "extricate: {severity}{message}");
}
