//! The `photosite` command: parses the command line, calls the library, prints, exits.

fn main() {}
