//! The program; all of it is in the library of this package, which fuzz targets use too.

use std::process::ExitCode;

fn main() -> ExitCode {
    extricate_cli::run()
}
