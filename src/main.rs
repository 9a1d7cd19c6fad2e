//! The `photosite` command: parses the command line, calls the library, prints, exits.

#![forbid(unsafe_code)]

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
