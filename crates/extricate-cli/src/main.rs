//! The program. Its code is in the library of this package, because fuzz targets use it too.

use std::process::ExitCode;

fn main() -> ExitCode {
    extricate_cli::run()
}
