//! One number or a lane each: formulas that run on `f32`, on eight or on sixteen lanes.

mod lanes;
mod real;

pub use lanes::*;
pub use real::{Real, Vector};
