//! Tables of a development as words that kernels read, one behind the other.

use photosite_develop::packed::{Demosaicking, Line, PackedDevelopment, Place};

/// Words of a place of the tile: black level, factor, white balance, channel.
pub(crate) const PLACE_WORDS: usize = 4;
/// Words of a line of a gain map: indices of the gains on both sides, part of the way.
pub(crate) const LINE_WORDS: usize = 3;
/// Words of a gain map: places of its lines across and down, and of its gains.
pub(crate) const MAP_WORDS: usize = 3;
/// Words of a neighbour: steps to the right and down, weight.
pub(crate) const TAP_WORDS: usize = 3;
/// Index of nothing.
pub(crate) const NONE: u32 = u32::MAX;

/// Places of the tables of each kind, in words.
#[derive(Debug, Default)]
pub(crate) struct Sections {
    /// Linear number for each stored one, a word each.
    pub(crate) linearisation: u32,
    /// Places of the tile, [`PLACE_WORDS`] each.
    pub(crate) places: u32,
    /// Gain maps, [`MAP_WORDS`] each.
    pub(crate) gain_maps: u32,
    /// First neighbour and their number, for each place of a Bayer tile and each channel.
    pub(crate) neighbours: u32,
    /// Least value of every code from 1 on.
    pub(crate) levels: u32,
}

/// Words of all tables, a word at least.
pub(crate) fn words(of: &PackedDevelopment) -> (Vec<u32>, Sections) {
    let mut words = vec![NONE];
    let mut section = |more: &mut dyn Iterator<Item = u32>| {
        let first = words.len() as u32;
        words.extend(more);
        first
    };
    let linearisation = section(&mut of.linearisation.iter().map(|dn| u32::from(*dn)));
    let place = |place: &Place| {
        let Place { black, factor, balance, channel } = *place;
        [black.to_bits(), factor.to_bits(), balance.to_bits(), channel as u32]
    };
    let places = section(&mut of.places.iter().flat_map(place));
    let line = |line: &Option<Line>| match line {
        Some(Line { indices: [first, second], part }) => [*first as u32, *second as u32, part.to_bits()],
        None => [NONE; LINE_WORDS],
    };
    let mut maps = Vec::new();
    for map in &of.gain_maps {
        maps.push(section(&mut map.across.iter().flat_map(line)));
        maps.push(section(&mut map.down.iter().flat_map(line)));
        maps.push(section(&mut map.gains.iter().map(|gain| gain.to_bits())));
    }
    let gain_maps = section(&mut maps.into_iter());
    let mut lists = Vec::new();
    if let Demosaicking::Bilinear(neighbours) = &of.demosaicking {
        for taps in neighbours.as_flattened() {
            let tap = |&([dx, dy], weight): &([isize; 2], f32)| [dx as u32, dy as u32, weight.to_bits()];
            lists.extend([section(&mut taps.iter().flat_map(tap)), taps.len() as u32]);
        }
    }
    let neighbours = section(&mut lists.into_iter());
    let levels = section(&mut of.levels.iter().map(|level| level.to_bits()));
    (words, Sections { linearisation, places, gain_maps, neighbours, levels })
}
