//! The `photosite` command.

#![forbid(unsafe_code)]

use std::process::ExitCode;

use photosite_simd::Heap;

/// Says so where memory ends, and never waits for any.
#[global_allocator]
static HEAP: Heap = Heap;

fn main() -> ExitCode {
    photosite_cli::run(std::env::args_os()).into()
}
