//! Optical glasses: six makers' catalogues, searched by name or by index and Abbe number, and a formula for glasses of
//! which only these two numbers are known.

mod catalogue;
mod matching;
mod numbers;

pub use catalogue::{CATALOGUES, Entry, entries};
pub use matching::{Found, by_name};
pub use numbers::{by_numbers, code, conrady};
