//! Opcode lists: what a developer shall do about the lens ([Dng16](photosite_core::references#dng16), chapter 7).

use crate::{AreaSpec, GainMap, Opcode, PerLine, PixelArea, Reach, Warp, WarpKind};

const WARP_RECTILINEAR: u32 = 1;
const WARP_FISHEYE: u32 = 2;
const FIX_VIGNETTE_RADIAL: u32 = 3;
const FIX_BAD_PIXELS_CONSTANT: u32 = 4;
const FIX_BAD_PIXELS_LIST: u32 = 5;
const MAP_TABLE: u32 = 7;
const MAP_POLYNOMIAL: u32 = 8;
const GAIN_MAP: u32 = 9;
/// Opcodes with a value for each row or column.
const PER_LINE: [(u32, PerLine); 4] = [
    (10, PerLine::DeltaPerRow),
    (11, PerLine::DeltaPerColumn),
    (12, PerLine::ScalePerRow),
    (13, PerLine::ScalePerColumn),
];
/// Largest degree of a polynomial.
const LARGEST_DEGREE: u32 = 8;
/// The version of DNG that these opcodes came with.
const SINCE: [u8; 4] = [1, 3, 0, 0];
/// A developer that does not know the opcode may leave it out.
const OPTIONAL: u32 = 1;

/// A list of opcodes, the last of which may be a correction of distortion. A gain map for all pixels is an opcode for
/// each place of a tile of `tile` columns and rows.
pub(super) fn list_of(opcodes: &[Opcode], warp: Option<&Warp>, size: [usize; 2], tile: [usize; 2]) -> Vec<u8> {
    let with_tile = |opcode: &Opcode| match gain_map_of(opcode).filter(|map| map.reach().is_none()) {
        Some(map) => places(map, size, tile).iter().map(|reach| (GAIN_MAP, gain_map(map, reach))).collect(),
        None => vec![written(opcode)],
    };
    let opcodes: Vec<_> = opcodes.iter().flat_map(with_tile).chain(warp.map(written_warp)).collect();
    list(opcodes.into_iter())
}

fn gain_map_of(opcode: &Opcode) -> Option<&GainMap> {
    if let Opcode::GainMap(map) = opcode { Some(map) } else { None }
}

/// Opcode's number and the bytes of its parameters.
fn written(opcode: &Opcode) -> (u32, Vec<u8>) {
    let mut to = Vec::new();
    let id = match opcode {
        Opcode::FixVignetteRadial { k, centre } => {
            to.extend(k.iter().chain(centre).flat_map(|x| x.to_be_bytes()));
            FIX_VIGNETTE_RADIAL
        }
        // Nobody needs the phase of the mosaic, which follows.
        Opcode::FixBadPixelsConstant(value) => {
            to.extend([*value, 0].map(u32::to_be_bytes).as_flattened());
            FIX_BAD_PIXELS_CONSTANT
        }
        Opcode::FixBadPixelsList(areas) => {
            to.extend([0, 0, areas.len() as u32].map(u32::to_be_bytes).as_flattened());
            areas.iter().for_each(|area| to.extend(rectangle(area)));
            FIX_BAD_PIXELS_LIST
        }
        Opcode::MapTable(area, table) => {
            to.extend(area_spec(area));
            to.extend((table.len() as u32).to_be_bytes());
            to.extend(table.iter().flat_map(|n| n.to_be_bytes()));
            MAP_TABLE
        }
        Opcode::MapPolynomial(area, coefficients) => {
            to.extend(area_spec(area));
            to.extend((coefficients.len() as u32 - 1).to_be_bytes());
            to.extend(coefficients.iter().flat_map(|x| x.to_be_bytes()));
            MAP_POLYNOMIAL
        }
        Opcode::GainMap(map) => {
            to.extend(map.reach().map(|reach| gain_map(map, reach)).unwrap_or_default());
            GAIN_MAP
        }
        Opcode::PerLine(area, what, lines) => {
            to.extend(area_spec(area));
            to.extend((lines.len() as u32).to_be_bytes());
            to.extend(lines.iter().flat_map(|x| x.to_be_bytes()));
            PER_LINE.iter().find(|(_, of)| of == what).map_or(0, |(id, _)| *id)
        }
    };
    (id, to)
}

fn rectangle(area: &PixelArea) -> Vec<u8> {
    [area.y, area.x, area.y + area.height, area.x + area.width].map(|n| (n as u32).to_be_bytes()).concat()
}

fn area_spec(AreaSpec { area, pitch, plane, planes }: &AreaSpec) -> Vec<u8> {
    let numbers = [*plane, *planes, pitch[1], pitch[0]].map(|n| (n as u32).to_be_bytes());
    [rectangle(area), numbers.concat()].concat()
}

/// Pixels that a map is for, place by place of a tile.
fn places(map: &GainMap, [width, height]: [usize; 2], [columns, rows]: [usize; 2]) -> Vec<Reach> {
    // Points lie on the edges: at 0 and 1, and evenly in between.
    let spacing = [map.columns(), map.rows()].map(|points| 1.0 / (points as f64 - 1.0).max(1.0));
    let reach = |place: usize| {
        let (x, y) = (place % columns, place / columns);
        Reach {
            pixels: AreaSpec {
                area: PixelArea { x, y, width: width.saturating_sub(x), height: height.saturating_sub(y) },
                pitch: [columns, rows],
                plane: 0,
                planes: 1,
            },
            spacing,
            origin: [0.0; 2],
            gains_per_point: 1,
        }
    };
    (0..columns * rows).map(reach).collect()
}

fn gain_map(map: &GainMap, reach: &Reach) -> Vec<u8> {
    let Reach { pixels, spacing, origin, gains_per_point } = reach;
    let mut to = area_spec(pixels);
    to.extend([map.rows(), map.columns()].map(|n| (n as u32).to_be_bytes()).as_flattened());
    for x in [spacing[1], spacing[0], origin[1], origin[0]] {
        to.extend(x.to_be_bytes());
    }
    to.extend((*gains_per_point as u32).to_be_bytes());
    to.extend(map.gains().iter().flat_map(|gain| gain.to_be_bytes()));
    to
}

fn written_warp(warp: &Warp) -> (u32, Vec<u8>) {
    let mut to = 1u32.to_be_bytes().to_vec();
    let (id, tangential) = match warp.kind {
        WarpKind::Rectilinear => (WARP_RECTILINEAR, &warp.tangential[..]),
        WarpKind::Fisheye => (WARP_FISHEYE, &[][..]),
    };
    let numbers = warp.radial.iter().chain(tangential).chain(&warp.centre);
    to.extend(numbers.flat_map(|x| x.to_be_bytes()));
    (id, to)
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

/// An opcode of a list, as it is stored.
struct Stored<'a> {
    id: u32,
    is_optional: bool,
    parameters: &'a [u8],
}

/// The opcodes of a list, and whether it is whole; what is damaged ends it.
fn opcodes(mut list: &[u8]) -> (Vec<Stored<'_>>, bool) {
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
            Some(Stored { id, is_optional, parameters: list.split_off(..length as usize)? })
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

/// Corrections that a developer shall make, from the opcode lists.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Corrections {
    /// Changes of pixel values, by list.
    pub(super) opcodes: [Vec<Opcode>; 3],
    pub(super) warp: Option<Warp>,
    /// Warnings about opcodes that are left out.
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

/// Reads the three lists of an image whose active area has `size` columns and rows, and whose stored pixels have
/// `samples` values each.
pub(super) fn read(lists: [&[u8]; 3], size: [usize; 2], samples: usize) -> Corrections {
    let mut found = Corrections::default();
    for (number, bytes) in (1..).zip(lists) {
        let (opcodes, is_whole) = opcodes(bytes);
        for opcode in &opcodes {
            let followed = match (number, opcode.id) {
                // What comes after a warp would be of the warped image.
                (3, _) if found.warp.is_some() => None,
                (3, WARP_RECTILINEAR | WARP_FISHEYE) => read_warp(opcode).map(|(warp, is_of_all_colours)| {
                    found.warp = Some(warp);
                    if !is_of_all_colours {
                        found.left_out.push(format!(
                            "{} of OpcodeList3 differs between colours: that of green is taken for all, and \
                                 colour fringes of the lens stay",
                            name(opcode.id)
                        ));
                    }
                }),
                (2 | 3, FIX_BAD_PIXELS_CONSTANT | FIX_BAD_PIXELS_LIST) => None,
                (1, FIX_BAD_PIXELS_CONSTANT | FIX_BAD_PIXELS_LIST) if samples != 1 => None,
                (list, _) => read_opcode(opcode).map(|opcode| found.opcodes[list - 1].push(opcode)),
            };
            if followed.is_none() {
                found.left_out.push(complaint(number, opcode));
            }
        }
        if !is_whole {
            found.left_out.push(format!("OpcodeList{number} is damaged: what it says from there on is left out"));
        }
    }
    let is_map = |opcode: &Opcode| matches!(opcode, Opcode::GainMap(_));
    let alike = found.opcodes[1].chunk_by(|a, b| is_map(a) && is_map(b));
    found.opcodes[1] = alike.flat_map(|opcodes| for_all(opcodes, size)).collect();
    found
}

fn name(id: u32) -> String {
    let known = (id as usize).checked_sub(1).and_then(|i| NAMES.get(i));
    known.map_or_else(|| format!("opcode {id}"), |name| (*name).to_owned())
}

fn complaint(list: usize, opcode: &Stored<'_>) -> String {
    let so = match opcode.id {
        1 | 2 | 14 => "the lens's distortion stays",
        3 => "the corners stay as dark as the lens makes them",
        4 | 5 => "defective pixels stay; develop.defects looks for them",
        6 => "the edges that it cuts off stay",
        _ => "the pixel values stay as they are stored",
    };
    let must = if opcode.is_optional { "" } else { ", which the file marks as required," };
    format!("{} of OpcodeList{list}{must} is left out: {so}", name(opcode.id))
}

/// Puts maps that are alike and together for every place of a tile into one for all pixels.
fn for_all(opcodes: &[Opcode], size: [usize; 2]) -> Vec<Opcode> {
    let maps: Vec<&GainMap> = opcodes.iter().filter_map(gain_map_of).collect();
    let Some(&first) = maps.first() else { return opcodes.to_vec() };
    let [columns, rows] = first.reach().map_or([1; 2], |reach| reach.pixels.pitch);
    if columns.checked_mul(rows) != Some(maps.len()) || !maps.iter().all(|map| map.is_like(first)) {
        return opcodes.to_vec();
    }
    let wanted = places(first, size, [columns, rows]);
    // Points that a few roundings move.
    let is_near = |a: &[f64; 2], b: &[f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    let is_there = |place: &Reach| {
        maps.iter().filter_map(|map| map.reach()).any(|reach| {
            let exact = Reach { spacing: place.spacing, origin: place.origin, ..reach.clone() };
            exact == *place && is_near(&reach.spacing, &place.spacing) && is_near(&reach.origin, &place.origin)
        })
    };
    if !wanted.iter().all(is_there) {
        return opcodes.to_vec();
    }
    match GainMap::new(first.columns(), first.rows(), first.gains().to_vec()) {
        Ok(map) => vec![Opcode::GainMap(map)],
        Err(_) => opcodes.to_vec(),
    }
}

/// A change of pixel values; `None` of other opcodes and of damaged ones.
fn read_opcode(opcode: &Stored<'_>) -> Option<Opcode> {
    let mut from = opcode.parameters;
    let from = &mut from;
    let per_line = PER_LINE.iter().find(|(id, _)| *id == opcode.id).map(|(_, what)| *what);
    Some(match opcode.id {
        FIX_VIGNETTE_RADIAL => Opcode::FixVignetteRadial { k: numbers(from)?, centre: numbers(from)? },
        FIX_BAD_PIXELS_CONSTANT => {
            let [constant, _] = whole(from)?;
            Opcode::FixBadPixelsConstant(constant as u32)
        }
        FIX_BAD_PIXELS_LIST => {
            let [_, points, rectangles] = whole(from)?;
            // No more than there are bytes for.
            let fits = points.checked_mul(8)?.checked_add(rectangles.checked_mul(16)?)? <= from.len();
            let points = 0..if fits { points } else { return None };
            let point = |from: &mut &[u8]| whole(from).map(|[y, x]| PixelArea { x, y, width: 1, height: 1 });
            let points: Option<Vec<_>> = points.map(|_| point(from)).collect();
            let rectangles: Option<Vec<_>> = (0..rectangles).map(|_| read_rectangle(from)).collect();
            Opcode::FixBadPixelsList([points?, rectangles?].concat())
        }
        MAP_TABLE => {
            let (area, count) = (read_area_spec(from)?, unsigned(from)? as usize);
            let table = from.as_chunks::<2>().0.iter().map(|&bytes| u16::from_be_bytes(bytes)).collect::<Vec<_>>();
            Opcode::MapTable(area, (count > 0).then(|| table.get(..count))??.to_vec())
        }
        MAP_POLYNOMIAL => {
            let (area, degree) = (read_area_spec(from)?, unsigned(from).filter(|n| *n <= LARGEST_DEGREE)?);
            let coefficients: Option<Vec<f64>> = (0..=degree).map(|_| numbers(from).map(|[x]| x)).collect();
            Opcode::MapPolynomial(area, coefficients?)
        }
        GAIN_MAP => Opcode::GainMap(read_gain_map(from)?),
        _ => {
            let (what, area, count) = (per_line?, read_area_spec(from)?, unsigned(from)? as usize);
            let lines = from.as_chunks::<4>().0.iter().map(|&bytes| f32::from_be_bytes(bytes)).collect::<Vec<_>>();
            let is_whole = count == what.lines(&area) && lines.iter().all(|x| x.is_finite());
            Opcode::PerLine(area, what, is_whole.then(|| lines.get(..count))??.to_vec())
        }
    })
}

fn whole<const N: usize>(from: &mut &[u8]) -> Option<[usize; N]> {
    let mut whole = [0; N];
    for number in &mut whole {
        *number = unsigned(from)? as usize;
    }
    Some(whole)
}

fn read_rectangle(from: &mut &[u8]) -> Option<PixelArea> {
    let [top, left, bottom, right] = whole(from)?;
    Some(PixelArea { x: left, y: top, width: right.checked_sub(left)?, height: bottom.checked_sub(top)? })
}

fn read_area_spec(from: &mut &[u8]) -> Option<AreaSpec> {
    let area = read_rectangle(from)?;
    let [plane, planes, row_pitch, column_pitch] = whole(from)?;
    let pitch = [column_pitch, row_pitch];
    (!pitch.contains(&0)).then_some(AreaSpec { area, pitch, plane, planes })
}

fn read_gain_map(from: &mut &[u8]) -> Option<GainMap> {
    let pixels = read_area_spec(from)?;
    let [rows, columns] = whole(from)?;
    let [down, across, first_down, first_across] = numbers(from)?;
    let gains_per_point = unsigned(from)? as usize;
    let gains: Vec<f32> = from.as_chunks::<4>().0.iter().map(|&bytes| f32::from_be_bytes(bytes)).collect();
    let (spacing, origin) = ([across, down], [first_across, first_down]);
    let reach = Reach { pixels, spacing, origin, gains_per_point };
    GainMap::of_some(columns, rows, gains, reach).ok()
}

/// A correction of distortion, and whether it is the same for all colours: of three that differ, that of green.
fn read_warp(opcode: &Stored<'_>) -> Option<(Warp, bool)> {
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

    fn has_reach(opcode: &Opcode) -> bool {
        matches!(opcode, Opcode::GainMap(map) if map.reach().is_some())
    }

    fn corrections(list_2: &[u8], list_3: &[u8]) -> Corrections {
        read([&[], list_2, list_3], [64, 48], 1)
    }

    #[test]
    fn lists_come_back_and_cut_ones_are_said_to_be_damaged() {
        let map = GainMap::new(3, 2, vec![1.5, 1.0, 1.25, 1.5, 1.0, 1.75]).expect("6 gains");
        for tile in [[1, 1], [2, 2]] {
            let map = Opcode::GainMap(map.clone());
            let list = list_of(std::slice::from_ref(&map), None, [64, 48], tile);
            assert_eq!(corrections(&list, &[]).opcodes[1], std::slice::from_ref(&map));
            let of_another_size = &read([&[], &list, &[]], [64, 47], 1).opcodes[1];
            assert_eq!((of_another_size.len(), has_reach(&of_another_size[0])), (tile[0] * tile[1], true));
            for length in 1..list.len() {
                let found = corrections(&list[..length], &[]);
                assert!(found.opcodes[1].iter().all(has_reach), "not for all pixels");
                assert!(found.left_out[0].contains("OpcodeList2 is damaged"), "{found:?}");
            }
        }
        let radial = [1.0, -0.1, 0.02, 0.0];
        for (kind, tangential) in [(WarpKind::Rectilinear, [1e-3, -2e-3]), (WarpKind::Fisheye, [0.0; 2])] {
            let warp_of = Warp { kind, radial, tangential, centre: [0.5, 0.49] };
            let list = list_of(&[], Some(&warp_of), [64, 48], [1, 1]);
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
            pixels: AreaSpec {
                area: PixelArea { x, y, width: 60 - x, height: 40 - y },
                pitch: [2, 2],
                plane: 0,
                planes: 1,
            },
            spacing: [0.5, 0.9],
            origin: [0.1, -0.05],
            gains_per_point: 1,
        };
        let map = |x: usize, y: usize| {
            let gains = (0..6).map(|i| 1.0 + 0.25 * (i + x + 2 * y) as f32).collect();
            Opcode::GainMap(GainMap::of_some(3, 2, gains, reach(x, y)).expect("6 gains"))
        };
        let maps = [map(0, 0), map(1, 0), map(0, 1), map(1, 1)];
        let list = list_of(&maps, None, [64, 48], [2, 2]);
        let opcodes = [vec![], maps.to_vec(), vec![]];
        assert_eq!(corrections(&list, &[]), Corrections { opcodes, ..Corrections::default() });
    }

    #[test]
    fn opcodes_that_nobody_follows_are_named_with_their_list() {
        for number in 1..=3u32 {
            for id in 1..=15u32 {
                let mut bytes = list(std::iter::once((id, vec![0; if id == 4 { 4 } else { 8 }])));
                // The flag of what may be left out.
                bytes[15] = 0;
                let mut lists: [&[u8]; 3] = [&[]; 3];
                lists[number as usize - 1] = &bytes;
                let found = read(lists, [64, 48], 1);
                let name = if id == 15 { "opcode 15".to_owned() } else { NAMES[id as usize - 1].to_owned() };
                let said = format!("{name} of OpcodeList{number}, which the file marks as required, is left out");
                assert!(found.left_out.len() == 1 && found.left_out[0].starts_with(&said), "{found:?}");
            }
        }
    }
}
