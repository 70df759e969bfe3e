//! The program; all of it is in the library of this package, which the fuzz targets read lines with.

use std::process::ExitCode;

fn main() -> ExitCode {
    extricate_cli::run()
}
