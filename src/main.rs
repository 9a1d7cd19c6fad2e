//! The `photosite` command: parses the command line, calls the library, prints, exits.

#![forbid(unsafe_code)]

mod cli;

use std::process::ExitCode;

use photosite_simd::Heap;

/// Says so where memory ends, and never waits for any.
#[global_allocator]
static HEAP: Heap = Heap;

fn main() -> ExitCode {
    cli::run()
}
