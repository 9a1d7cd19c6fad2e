//! Opcode lists: what a developer shall do about the lens ([Dng16](photosite_core::references#dng16), chapter 7).

use crate::raw::{GainMap, PixelArea, Reach, Warp, WarpKind};

const WARP_RECTILINEAR: u32 = 1;
const WARP_FISHEYE: u32 = 2;
const GAIN_MAP: u32 = 9;
/// The version of DNG that these opcodes came with.
const SINCE: [u8; 4] = [1, 3, 0, 0];
/// A developer that does not know the opcode may leave it out.
const OPTIONAL: u32 = 1;

/// OpcodeList2 with gain maps. One for all pixels is an opcode for each place of a tile of so many columns and rows.
pub(super) fn gain_maps(maps: &[GainMap], size: [usize; 2], tile: [usize; 2]) -> Vec<u8> {
    let opcodes = maps.iter().flat_map(|map| match map.reach() {
        Some(reach) => vec![(GAIN_MAP, gain_map(map, reach))],
        None => places(map, size, tile).iter().map(|reach| (GAIN_MAP, gain_map(map, reach))).collect(),
    });
    list(opcodes.collect::<Vec<_>>().into_iter())
}

/// Pixels that a map is for, place by place of a tile.
fn places(map: &GainMap, [width, height]: [usize; 2], [columns, rows]: [usize; 2]) -> Vec<Reach> {
    // Points lie on the edges: at 0 and 1, and evenly in between.
    let spacing = [map.columns(), map.rows()].map(|points| 1.0 / (points as f64 - 1.0).max(1.0));
    let reach = |place: usize| {
        let (x, y) = (place % columns, place / columns);
        Reach {
            area: PixelArea { x, y, width: width.saturating_sub(x), height: height.saturating_sub(y) },
            pitch: [columns, rows],
            plane: 0,
            planes: 1,
            spacing,
            origin: [0.0; 2],
            gains_per_point: 1,
        }
    };
    (0..columns * rows).map(reach).collect()
}

fn gain_map(map: &GainMap, reach: &Reach) -> Vec<u8> {
    let Reach { area, pitch, plane, planes, spacing, origin, gains_per_point } = reach;
    let mut to = Vec::new();
    let (bottom, right) = (area.y + area.height, area.x + area.width);
    for n in [area.y, area.x, bottom, right, *plane, *planes, pitch[1], pitch[0], map.rows(), map.columns()] {
        to.extend((n as u32).to_be_bytes());
    }
    for x in [spacing[1], spacing[0], origin[1], origin[0]] {
        to.extend(x.to_be_bytes());
    }
    to.extend((*gains_per_point as u32).to_be_bytes());
    to.extend(map.gains().iter().flat_map(|gain| gain.to_be_bytes()));
    to
}

/// OpcodeList3 with a correction of distortion.
pub(super) fn warp(warp: &Warp) -> Vec<u8> {
    let mut to = 1u32.to_be_bytes().to_vec();
    let (id, tangential) = match warp.kind {
        WarpKind::Rectilinear => (WARP_RECTILINEAR, &warp.tangential[..]),
        WarpKind::Fisheye => (WARP_FISHEYE, &[][..]),
    };
    let numbers = warp.radial.iter().chain(tangential).chain(&warp.centre);
    to.extend(numbers.flat_map(|x| x.to_be_bytes()));
    list(std::iter::once((id, to)))
}

fn list(opcodes: impl ExactSizeIterator<Item = (u32, Vec<u8>)>) -> Vec<u8> {
    let mut to = (opcodes.len() as u32).to_be_bytes().to_vec();
    for (id, parameters) in opcodes {
        to.extend(id.to_be_bytes());
        to.extend(SINCE);
        to.extend(OPTIONAL.to_be_bytes());
        to.extend((parameters.len() as u32).to_be_bytes());
        to.extend(parameters);
    }
    to
}

/// An opcode of a list.
struct Opcode<'a> {
    id: u32,
    is_optional: bool,
    parameters: &'a [u8],
}

/// The opcodes of a list, and whether it is whole; what is damaged ends it.
fn opcodes(mut list: &[u8]) -> (Vec<Opcode<'_>>, bool) {
    let mut found = Vec::new();
    if list.is_empty() {
        return (found, true);
    }
    let Some(count) = unsigned(&mut list) else { return (found, false) };
    for _ in 0..count {
        let mut opcode = || {
            let id = unsigned(&mut list)?;
            list.split_off(..4)?;
            let is_optional = unsigned(&mut list)? & OPTIONAL != 0;
            let length = unsigned(&mut list)?;
            Some(Opcode { id, is_optional, parameters: list.split_off(..length as usize)? })
        };
        let Some(opcode) = opcode() else { return (found, false) };
        found.push(opcode);
    }
    (found, true)
}

fn unsigned(from: &mut &[u8]) -> Option<u32> {
    from.split_off(..4)?.first_chunk().map(|&bytes| u32::from_be_bytes(bytes))
}

fn float(from: &mut &[u8]) -> Option<f64> {
    from.split_off(..8)?.first_chunk().map(|&bytes| f64::from_be_bytes(bytes))
}

fn numbers<const N: usize>(from: &mut &[u8]) -> Option<[f64; N]> {
    let mut numbers = [0.0; N];
    for x in &mut numbers {
        *x = float(from).filter(|x| x.is_finite())?;
    }
    Some(numbers)
}

/// What a developer shall do about the lens.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Corrections {
    pub(super) gain_maps: Vec<GainMap>,
    pub(super) warp: Option<Warp>,
    /// What the lists say besides, as warnings.
    pub(super) left_out: Vec<String>,
}

/// Names of the opcodes from 1 on.
const NAMES: [&str; 14] = [
    "WarpRectilinear",
    "WarpFisheye",
    "FixVignetteRadial",
    "FixBadPixelsConstant",
    "FixBadPixelsList",
    "TrimBounds",
    "MapTable",
    "MapPolynomial",
    "GainMap",
    "DeltaPerRow",
    "DeltaPerColumn",
    "ScalePerRow",
    "ScalePerColumn",
    "WarpRectilinear2",
];

/// What the three lists say of a picture whose active area has so many columns and rows.
pub(super) fn read(lists: [&[u8]; 3], size: [usize; 2]) -> Corrections {
    let mut found = Corrections::default();
    let mut maps = Vec::new();
    for (number, bytes) in (1..).zip(lists) {
        let (opcodes, is_whole) = opcodes(bytes);
        for opcode in &opcodes {
            let followed = match (number, opcode.id) {
                (2, GAIN_MAP) => read_gain_map(opcode.parameters).map(|map| maps.push(map)),
                (3, WARP_RECTILINEAR | WARP_FISHEYE) if found.warp.is_none() => {
                    read_warp(opcode).map(|(warp, is_of_all_colours)| {
                        found.warp = Some(warp);
                        if !is_of_all_colours {
                            found.left_out.push(format!(
                                "{} of OpcodeList3 differs between colours: that of green is taken for all, and \
                                 colour fringes of the lens stay",
                                name(opcode.id)
                            ));
                        }
                    })
                }
                _ => None,
            };
            if followed.is_none() {
                found.left_out.push(complaint(number, opcode));
            }
        }
        if !is_whole {
            found.left_out.push(format!("OpcodeList{number} is damaged: what it says from there on is left out"));
        }
    }
    found.gain_maps = for_all(maps, size);
    found
}

fn name(id: u32) -> String {
    let known = (id as usize).checked_sub(1).and_then(|i| NAMES.get(i));
    known.map_or_else(|| format!("opcode {id}"), |name| (*name).to_owned())
}

fn complaint(list: u32, opcode: &Opcode<'_>) -> String {
    let so = match opcode.id {
        1 | 2 | 14 => "the lens's distortion stays",
        3 => "the corners stay as dark as the lens makes them",
        4 | 5 => "defective pixels stay; develop.defects looks for them",
        6 => "the edges that it cuts off stay",
        _ => "the numbers stay as they are stored",
    };
    let must = if opcode.is_optional { "" } else { ", which the file marks as required," };
    format!("{} of OpcodeList{list}{must} is left out: {so}", name(opcode.id))
}

/// Puts maps that are alike and together for every place of a tile into one for all pixels.
fn for_all(maps: Vec<GainMap>, size: [usize; 2]) -> Vec<GainMap> {
    let Some(first) = maps.first() else { return maps };
    let [columns, rows] = first.reach().map_or([1; 2], |reach| reach.pitch);
    if columns.checked_mul(rows) != Some(maps.len()) || !maps.iter().all(|map| map.is_like(first)) {
        return maps;
    }
    let wanted = places(first, size, [columns, rows]);
    // Points that a few roundings move.
    let is_near = |a: &[f64; 2], b: &[f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    let is_there = |place: &Reach| {
        maps.iter().filter_map(GainMap::reach).any(|reach| {
            let exact = Reach { spacing: place.spacing, origin: place.origin, ..reach.clone() };
            exact == *place && is_near(&reach.spacing, &place.spacing) && is_near(&reach.origin, &place.origin)
        })
    };
    if !wanted.iter().all(is_there) {
        return maps;
    }
    match GainMap::new(first.columns(), first.rows(), first.gains().to_vec()) {
        Ok(map) => vec![map],
        Err(_) => maps,
    }
}

fn read_gain_map(mut parameters: &[u8]) -> Option<GainMap> {
    let from = &mut parameters;
    let mut whole = [0; 10];
    for number in &mut whole {
        *number = unsigned(from)? as usize;
    }
    let [top, left, bottom, right, plane, planes, row_pitch, column_pitch, rows, columns] = whole;
    let [down, across, first_down, first_across] = numbers(from)?;
    let gains_per_point = unsigned(from)? as usize;
    let gains: Vec<f32> = from.as_chunks::<4>().0.iter().map(|&bytes| f32::from_be_bytes(bytes)).collect();
    let (width, height) = (right.checked_sub(left)?, bottom.checked_sub(top)?);
    let reach = Reach {
        area: PixelArea { x: left, y: top, width, height },
        pitch: [column_pitch, row_pitch],
        plane,
        planes,
        spacing: [across, down],
        origin: [first_across, first_down],
        gains_per_point,
    };
    GainMap::of_some(columns, rows, gains, reach).ok()
}

/// A correction of distortion, and whether it is the same for all colours: of three that differ, that of green.
fn read_warp(opcode: &Opcode<'_>) -> Option<(Warp, bool)> {
    let kind = if opcode.id == WARP_FISHEYE { WarpKind::Fisheye } else { WarpKind::Rectilinear };
    let mut from = opcode.parameters;
    let from = &mut from;
    let planes = unsigned(from)?;
    let mut sets = Vec::new();
    for _ in 0..planes {
        let radial = numbers(from)?;
        let tangential = if kind == WarpKind::Rectilinear { numbers(from)? } else { [0.0; 2] };
        sets.push((radial, tangential));
    }
    let &(radial, tangential) = sets.get(sets.len() / 2)?;
    let is_of_all_colours = sets.iter().all(|set| *set == (radial, tangential));
    Some((Warp { kind, radial, tangential, centre: numbers(from)? }, is_of_all_colours))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corrections(list_2: &[u8], list_3: &[u8]) -> Corrections {
        read([&[], list_2, list_3], [64, 48])
    }

    #[test]
    fn lists_come_back_and_cut_ones_are_said_to_be_damaged() {
        let map = GainMap::new(3, 2, vec![1.5, 1.0, 1.25, 1.5, 1.0, 1.75]).expect("6 gains");
        for tile in [[1, 1], [2, 2]] {
            let list = gain_maps(std::slice::from_ref(&map), [64, 48], tile);
            assert_eq!(corrections(&list, &[]).gain_maps, std::slice::from_ref(&map));
            let of_another_size = read([&[], &list, &[]], [64, 47]).gain_maps;
            assert_eq!((of_another_size.len(), of_another_size[0].reach().is_some()), (tile[0] * tile[1], true));
            for length in 1..list.len() {
                let found = corrections(&list[..length], &[]);
                assert!(found.gain_maps.iter().all(|map| map.reach().is_some()), "not for all pixels");
                assert!(found.left_out[0].contains("OpcodeList2 is damaged"), "{found:?}");
            }
        }
        let radial = [1.0, -0.1, 0.02, 0.0];
        for (kind, tangential) in [(WarpKind::Rectilinear, [1e-3, -2e-3]), (WarpKind::Fisheye, [0.0; 2])] {
            let warp_of = Warp { kind, radial, tangential, centre: [0.5, 0.49] };
            let list = warp(&warp_of);
            assert_eq!(corrections(&[], &list), Corrections { warp: Some(warp_of), ..Corrections::default() });
            for length in 1..list.len() {
                let found = corrections(&[], &list[..length]);
                assert_eq!((found.warp, found.left_out.len()), (None, 1));
            }
        }
    }

    #[test]
    fn maps_of_some_pixels_come_back_as_they_are() {
        let reach = |x: usize, y: usize| Reach {
            area: PixelArea { x, y, width: 60 - x, height: 40 - y },
            pitch: [2, 2],
            plane: 0,
            planes: 1,
            spacing: [0.5, 0.9],
            origin: [0.1, -0.05],
            gains_per_point: 1,
        };
        let map = |x: usize, y: usize| {
            let gains = (0..6).map(|i| 1.0 + 0.25 * (i + x + 2 * y) as f32).collect();
            GainMap::of_some(3, 2, gains, reach(x, y)).expect("6 gains")
        };
        let maps = [map(0, 0), map(1, 0), map(0, 1), map(1, 1)];
        let list = gain_maps(&maps, [64, 48], [2, 2]);
        assert_eq!(corrections(&list, &[]), Corrections { gain_maps: maps.to_vec(), ..Corrections::default() });
    }

    #[test]
    fn opcodes_that_nobody_follows_are_named_with_their_list() {
        for number in 1..=3u32 {
            for id in 1..=15u32 {
                let mut bytes = list(std::iter::once((id, vec![0; 8])));
                // The flag of what may be left out.
                bytes[15] = 0;
                let mut lists: [&[u8]; 3] = [&[]; 3];
                lists[number as usize - 1] = &bytes;
                let found = read(lists, [64, 48]);
                let name = if id == 15 { "opcode 15".to_owned() } else { NAMES[id as usize - 1].to_owned() };
                let said = format!("{name} of OpcodeList{number}, which the file marks as required, is left out");
                assert!(found.left_out.len() == 1 && found.left_out[0].starts_with(&said), "{found:?}");
            }
        }
    }
}
