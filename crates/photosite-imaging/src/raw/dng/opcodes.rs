//! Opcode lists: what a developer shall do about the lens ([Dng16](photosite_core::references#dng16), chapter 7).

use crate::raw::{GainMap, Warp, WarpKind};

const WARP_RECTILINEAR: u32 = 1;
const WARP_FISHEYE: u32 = 2;
const GAIN_MAP: u32 = 9;
/// The version of DNG that these opcodes came with.
const SINCE: [u8; 4] = [1, 3, 0, 0];
/// A developer that does not know the opcode may leave it out.
const OPTIONAL: u32 = 1;

/// OpcodeList2 with a gain map for pixels of `tile` columns and rows, one opcode for each place of the tile.
pub(super) fn gain_map(map: &GainMap, [width, height]: [usize; 2], [columns, rows]: [usize; 2]) -> Vec<u8> {
    let opcodes = (0..columns * rows).map(|place| {
        let mut to = Vec::new();
        let (left, top) = (place % columns, place / columns);
        for n in [top, left, height, width, 0, 1, rows, columns, map.rows(), map.columns()] {
            to.extend((n as u32).to_be_bytes());
        }
        // Points lie on the edges: at 0 and 1, and evenly in between.
        let spacing = |points: usize| 1.0 / (points as f64 - 1.0).max(1.0);
        for x in [spacing(map.rows()), spacing(map.columns()), 0.0, 0.0] {
            to.extend(x.to_be_bytes());
        }
        to.extend(1u32.to_be_bytes());
        to.extend(map.gains().iter().flat_map(|gain| gain.to_be_bytes()));
        (GAIN_MAP, to)
    });
    list(opcodes)
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

/// Identifiers and parameters of a list; what is damaged ends it.
fn opcodes(mut list: &[u8]) -> Vec<(u32, &[u8])> {
    let mut found = Vec::new();
    let count = unsigned(&mut list).unwrap_or(0);
    for _ in 0..count {
        let mut opcode = || {
            let id = unsigned(&mut list)?;
            list.split_off(..8)?;
            let length = unsigned(&mut list)?;
            Some((id, list.split_off(..length as usize)?))
        };
        let Some(opcode) = opcode() else { break };
        found.push(opcode);
    }
    found
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

/// The gain map of OpcodeList2, where there is one for all pixels of the active area.
pub(super) fn read_gain_map(list: &[u8], [width, height]: [usize; 2]) -> Option<GainMap> {
    let maps: Vec<_> = opcodes(list).into_iter().filter(|(id, _)| *id == GAIN_MAP).collect();
    let (_, mut first) = *maps.first()?;
    let from = &mut first;
    let [_, _, bottom, right, plane, _, row_pitch, column_pitch, rows, columns] = {
        let mut numbers = [0; 10];
        for number in &mut numbers {
            *number = unsigned(from)? as usize;
        }
        numbers
    };
    let mut placing = [0.0; 4];
    for x in &mut placing {
        *x = float(from)?;
    }
    let spacing = |points: usize| 1.0 / (points as f64 - 1.0).max(1.0);
    let even = placing[2..] == [0.0, 0.0]
        && (placing[0] - spacing(rows)).abs() < 1e-6
        && (placing[1] - spacing(columns)).abs() < 1e-6;
    let whole = [bottom, right, plane, unsigned(from)? as usize] == [height, width, 0, 1];
    if !even || !whole || maps.len() != row_pitch.checked_mul(column_pitch)? {
        return None;
    }
    let gains: Vec<f32> = from.as_chunks::<4>().0.iter().map(|&bytes| f32::from_be_bytes(bytes)).collect();
    // Maps that differ between colours cannot be stated here.
    let same = maps.iter().all(|(_, map)| map.get(76..) == maps[0].1.get(76..));
    if same { GainMap::new(columns, rows, gains).ok() } else { None }
}

/// The correction of OpcodeList3, where it is one for all colours.
pub(super) fn read_warp(list: &[u8]) -> Option<Warp> {
    let kind = |id: u32| match id {
        WARP_RECTILINEAR => Some(WarpKind::Rectilinear),
        WARP_FISHEYE => Some(WarpKind::Fisheye),
        _ => None,
    };
    let (kind, mut from) = opcodes(list).into_iter().find_map(|(id, from)| Some((kind(id)?, from)))?;
    if unsigned(&mut from)? != 1 {
        return None;
    }
    let radial = numbers(&mut from)?;
    let tangential = if kind == WarpKind::Rectilinear { numbers(&mut from)? } else { [0.0; 2] };
    Some(Warp { kind, radial, tangential, centre: numbers(&mut from)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_come_back_and_cut_ones_are_left_out() {
        let map = GainMap::new(3, 2, vec![1.5, 1.0, 1.25, 1.5, 1.0, 1.75]).expect("6 gains");
        for tile in [[1, 1], [2, 2]] {
            let list = gain_map(&map, [64, 48], tile);
            assert_eq!(read_gain_map(&list, [64, 48]).as_ref(), Some(&map));
            assert_eq!(read_gain_map(&list, [64, 47]), None, "not of the whole picture");
            assert!((0..list.len()).all(|length| read_gain_map(&list[..length], [64, 48]).is_none()));
        }
        let radial = [1.0, -0.1, 0.02, 0.0];
        for (kind, tangential) in [(WarpKind::Rectilinear, [1e-3, -2e-3]), (WarpKind::Fisheye, [0.0; 2])] {
            let warp_of = Warp { kind, radial, tangential, centre: [0.5, 0.49] };
            let list = warp(&warp_of);
            assert_eq!(read_warp(&list), Some(warp_of));
            assert!((0..list.len()).all(|length| read_warp(&list[..length]).is_none()));
        }
    }
}
