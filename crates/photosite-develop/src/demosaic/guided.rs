//! The densest channel first, and the others by their differences to it: for any filter array.
//!
//! Detail is much the same in all channels; so the difference between two is smoother than either, and less is lost
//! when it is interpolated. Both steps are means weighted by a tent ([`bilinear`](super::bilinear)).

use super::bilinear::Tent;
use super::channels::{planes, together};
use crate::neighbours::{densest, steps};
use photosite_core::image::Planes;
use photosite_raw::Cfa;

/// Planes of all channels; measured values stay.
pub(super) fn demosaic(mosaic: &[f32], width: usize, height: usize, cfa: &Cfa) -> Planes {
    let size = [width, height];
    let guide = densest(cfa);
    let mut channels = planes(width, height, cfa);
    let tent = |channel: usize| Tent::new(cfa, channel, radius_for(cfa, channel));
    tent(guide).fill(&mut channels[guide].data, size, true, |i| mosaic[i]);
    let dense = std::mem::take(&mut channels[guide].data);
    for (c, channel) in channels.iter_mut().enumerate().filter(|(c, _)| *c != guide) {
        tent(c).fill(&mut channel.data, size, true, |i| mosaic[i] - dense[i]);
        channel.data.iter_mut().zip(&dense).for_each(|(value, dense)| *value += dense);
    }
    channels[guide].data = dense;
    together(width, height, channels)
}

/// The smallest radius at which every pixel has a neighbour of this channel.
fn radius_for(cfa: &Cfa, channel: usize) -> usize {
    let (columns, rows) = cfa.tile_size();
    let seen = |radius: usize| {
        (0..columns * rows).all(|i| !steps(cfa, [i % columns, i / columns], channel, radius).is_empty())
    };
    (0..columns.max(rows)).find(|&radius| seen(radius)).unwrap_or(columns.max(rows))
}
