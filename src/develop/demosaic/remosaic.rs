//! Quad Bayer and the like: blocks of pixels of one channel become a Bayer mosaic of the same size first.
//!
//! A pixel that has the wrong channel for that takes the value which [`guided`](super::guided) finds for it.

use rayon::prelude::*;

use super::{guided, menon};
use crate::image::Planes;
use crate::raw::Cfa;

/// Planes R, G and B.
pub(super) fn demosaic(mosaic: &[f32], width: usize, height: usize, cfa: &Cfa) -> Planes {
    let estimated = guided::demosaic(mosaic, width, height, cfa);
    let Some(bayer) = bayer_of(cfa) else { return estimated };
    let value = |i: usize| estimated.channels()[bayer.channel_at(i % width, i / width)].data[i];
    let remosaiced: Vec<f32> = (0..width * height).into_par_iter().map(value).collect();
    drop(estimated);
    menon::demosaic(&remosaiced, width, height, &bayer)
}

/// The Bayer filter whose pixels an array's blocks are; `None` where there are no such blocks.
pub(in crate::develop) fn bayer_of(cfa: &Cfa) -> Option<Cfa> {
    let (columns, rows) = cfa.tile_size();
    let block = columns / 2;
    if columns != rows || columns % 2 == 1 || block < 2 || cfa.is_full() {
        return None;
    }
    // A part of a picture may begin anywhere within a block.
    (0..block * block).find_map(|i| {
        let (left, top) = (i % block, i / block);
        let corner = |x: usize, y: usize| cfa.channel_at(left + x * block, top + y * block);
        let fills = |i: usize| {
            let (x, y) = (i % columns, i / columns);
            cfa.channel_at(left + x, top + y) == corner(x / block, y / block)
        };
        let letters = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| cfa.channels()[corner(x, y)].as_str());
        let bayer = Cfa::parse(&letters.concat()).ok().filter(Cfa::is_bayer)?;
        (0..columns * rows).all(fills).then_some(bayer)
    })
}
