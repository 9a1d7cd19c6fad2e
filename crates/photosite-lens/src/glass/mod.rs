//! Optical glasses: those of six makers' catalogues, found by name or by index and Abbe number, and the formula that
//! stands in for a glass of which no more is known.

mod catalogue;
mod matching;
mod numbers;

pub use catalogue::{CATALOGUES, Entry, entries};
pub use matching::{Found, by_name};
pub use numbers::{by_numbers, code, conrady};
