//! The planes that all methods fill.

use photosite_core::image::{Channel, Planes};
use photosite_raw::Cfa;

/// Empty planes of a filter array's channels.
pub(super) fn planes(width: usize, height: usize, cfa: &Cfa) -> Vec<Channel> {
    cfa.channels().iter().map(|name| Channel { name: name.clone(), data: vec![0.0; width * height] }).collect()
}

/// Planes that were made by [`planes`] for this size.
pub(super) fn together(width: usize, height: usize, channels: Vec<Channel>) -> Planes {
    Planes::new(width, height, channels).expect("planes were made for this size")
}
