//! Opcodes of DNG files: what they do to values, and those that are left out.

use super::*;

/// A gain map's opcode: the places of the tile that it begins at, its planes, its gains on 2 × 2 points.
fn gain_map([top, left]: [u32; 2], pitch: u32, [plane, planes]: [u32; 2], per_point: u32, gains: &[f32]) -> Vec<u8> {
    let mut body = Vec::new();
    for n in [top, left, 2, 4, plane, planes, pitch, pitch, 2, 2] {
        body.extend(n.to_be_bytes());
    }
    for x in [1.0f64, 1.0, 0.0, 0.0] {
        body.extend(x.to_be_bytes());
    }
    body.extend(per_point.to_be_bytes());
    body.extend(gains.iter().flat_map(|gain| gain.to_be_bytes()));
    let head = [9, 0x0103_0000, 0, body.len() as u32].map(u32::to_be_bytes);
    [head.as_flattened(), &body].concat()
}

fn list(opcodes: &[Vec<u8>]) -> Entry {
    let bytes = [&(opcodes.len() as u32).to_be_bytes()[..], &opcodes.concat()].concat();
    (51_009, 7, bytes.into_iter().map(f64::from).collect())
}

#[test]
fn gains_of_each_colour_are_its_own() {
    // A place of a tile each, with gains of 1 + its number at the left edge and twice that at the right one.
    let maps: Vec<Vec<u8>> = (0..4u32)
        .map(|place| {
            let gain = 1.0 + place as f32;
            gain_map([place / 2, place % 2], 2, [0, 1], 1, &[gain, 2.0 * gain, gain, 2.0 * gain])
        })
        .collect();
    let raw = dng(&with(&[list(&maps)], &mosaic())).expect("DNG");
    assert_eq!((raw.metadata.gain_maps().count(), raw.metadata.left_out.len()), (4, 0));
    for (i, place) in [0usize, 1, 0, 1, 2, 3, 2, 3].into_iter().enumerate() {
        let (x, y) = (i % 4, i / 4);
        let of = raw.metadata.gain_maps().filter(|map| map.has_row(y) && map.has_number(x, 0));
        let gains: Vec<f32> = of.map(|map| map.at((x as f64 + 0.5) / 4.0, (y as f64 + 0.5) / 2.0)).collect();
        assert_eq!(gains, [(1.0 + place as f32) * (1.0 + (x as f32 + 0.5) / 4.0)], "{x} {y}");
    }
    // Planes of pixels that have three numbers: one map for green alone, one of three gains at each point.
    let several: Vec<f32> = [1.0, 2.0, 3.0].repeat(4);
    for (map, expected) in [
        (gain_map([0, 0], 1, [1, 1], 1, &[2.0; 4]), [1.0, 2.0, 1.0]),
        (gain_map([0, 0], 1, [0, 3], 3, &several), [1.0, 2.0, 3.0]),
    ] {
        let numbers = bytes_of(USUAL, &[6000; 24]);
        let file = USUAL.file(&[(&with(&[list(&[map])], &linear_raw()), &numbers)], &[]);
        let raw = read_dng(Cursor::new(file)).expect("DNG");
        let (image, _) = develop_linear(&raw, &DevelopSettings::default()).expect("developed");
        let found = ["R", "G", "B"].map(|plane| image.plane(plane).expect("RGB")[5]);
        assert!(found.iter().zip(expected).all(|(x, gain)| (x - 0.1 * gain).abs() < 1e-6), "{found:?} {expected:?}");
    }
}

/// An opcode with its parameters: whole numbers, then floating-point ones of 32 or 64 bits, then 16-bit ones.
fn opcode(id: u32, whole: &[u32], singles: &[f32], doubles: &[f64], halves: &[u16]) -> Vec<u8> {
    let mut body: Vec<u8> = whole.iter().flat_map(|n| n.to_be_bytes()).collect();
    body.extend(singles.iter().flat_map(|x| x.to_be_bytes()));
    body.extend(doubles.iter().flat_map(|x| x.to_be_bytes()));
    body.extend(halves.iter().flat_map(|n| n.to_be_bytes()));
    [[id, 0x0103_0000, 0, body.len() as u32].map(u32::to_be_bytes).as_flattened(), &body].concat()
}

/// 5 × 4 grey pixels, 1000, 2000 … 20 000 of 60 000, developed with these opcodes in a list: the signal times 60 000.
fn developed_with(number: u16, opcodes: &[Vec<u8>], settings: &DevelopSettings) -> Vec<f64> {
    let tag = [51_008, 51_009, 51_022][usize::from(number) - 1];
    let (_, kind, bytes) = list(opcodes);
    let tags = with(
        &[(256, 3, vec![5.0]), (257, 3, vec![4.0]), (278, 3, vec![4.0]), (262, 3, vec![34_892.0]), (tag, kind, bytes)],
        &mosaic(),
    );
    let tags: Vec<Entry> = tags.into_iter().filter(|(tag, ..)| ![33_421, 33_422, 50_728].contains(tag)).collect();
    let numbers: Vec<u16> = (1..=20).map(|i| 1000 * i).collect();
    let raw = read_dng(Cursor::new(USUAL.file(&[(&tags, &bytes_of(USUAL, &numbers))], &[]))).expect("DNG");
    assert_eq!(raw.metadata.left_out, Vec::<String>::new());
    let (image, _) = develop_linear(&raw, settings).expect("developed");
    image.plane("Y").expect("grey").iter().map(|x| f64::from(*x) * 60_000.0).collect()
}

/// Rows and columns 1 and 3 of the first three rows and all columns: area, planes, pitches.
const EVERY_SECOND: [u32; 8] = [1, 1, 4, 5, 0, 1, 2, 2];

/// Expected result of opcodes on values up to `white`, by their number, column and row, after DNG 1.7, chapter 7.
fn closed_form(id: u32, value: f64, [x, y]: [f64; 2], white: f64) -> f64 {
    let is_in = [x, y].iter().all(|n| [1.0, 3.0].contains(n));
    let (column, row) = ((x - 1.0) / 2.0, (y - 1.0) / 2.0);
    // Distances from the middle of 5 × 4 pixels; the corners are 2 and 1.5 away.
    let r2 = ((x - 2.0).powi(2) + (y - 1.5).powi(2)) / (4.0 + 2.25);
    match id {
        3 => {
            value * (1.0 + 0.5 * r2 - 0.25 * r2.powi(2) + 0.125 * r2.powi(3) + 0.0625 * r2.powi(4) - 0.03 * r2.powi(5))
        }
        _ if !is_in => value,
        // 65 535 is beyond a table of two, the first of which stands for 0 alone.
        7 => 30_000.0 * white / 65_535.0,
        8 => (0.1 * white + 0.5 * value + 0.3 * value * value / white).clamp(0.0, white),
        10 => value + [100.0, -200.0][row as usize] * white / 65_535.0,
        11 => value + [50.0, 300.0][column as usize] * white / 65_535.0,
        12 => value * [0.5, 1.5][row as usize],
        13 => value * [2.0, 0.25][column as usize],
        _ => unreachable!("{id}"),
    }
}

/// Parameters of an opcode as bytes; coefficients of a polynomial of stored values are of these.
fn as_bytes(id: u32, white: f64) -> Vec<u8> {
    let with = |more: u32| [&EVERY_SECOND[..], &[more]].concat();
    match id {
        3 => opcode(3, &[], &[], &[0.5, -0.25, 0.125, 0.0625, -0.03, 0.5, 0.5], &[]),
        7 => opcode(7, &with(2), &[], &[], &[11, 30_000]),
        8 => opcode(8, &with(2), &[], &[0.1 * white, 0.5, 0.3 / white], &[]),
        10 => opcode(10, &with(2), &[100.0, -200.0], &[], &[]),
        11 => opcode(11, &with(2), &[50.0, 300.0], &[], &[]),
        12 => opcode(12, &with(2), &[0.5, 1.5], &[], &[]),
        13 => opcode(13, &with(2), &[2.0, 0.25], &[], &[]),
        _ => unreachable!("{id}"),
    }
}

#[test]
fn opcodes_change_values_as_the_specification_has_it() {
    let ids = [3, 7, 8, 10, 11, 12, 13];
    let pairs = ids.into_iter().flat_map(|a| ids.map(|b| vec![a, b]));
    for (number, sequence) in
        (1..=3).flat_map(|number| ids.map(|id| vec![id]).into_iter().chain(pairs.clone()).map(move |ids| (number, ids)))
    {
        // Stored values reach up to 65 535 and are whole; linear ones up to the white level, which is 1.
        let (white, rounding) = if number == 1 { (65_535.0, 0.51) } else { (60_000.0, 0.05) };
        let scale = if number == 1 { 65_535.0 } else { 1.0 };
        let bytes: Vec<Vec<u8>> = sequence.iter().map(|id| as_bytes(*id, scale)).collect();
        let found = developed_with(number, &bytes, &DevelopSettings::default());
        for (i, found) in found.into_iter().enumerate() {
            let at = [(i % 5) as f64, (i / 5) as f64];
            let stored = 1000.0 * (i + 1) as f64;
            let wanted = sequence.iter().fold(stored, |value, id| closed_form(*id, value, at, white));
            // Highlights are clipped after all.
            let wanted = wanted.min(60_000.0);
            assert!((found - wanted).abs() < rounding, "list {number}, {sequence:?} at {at:?}: {found}, not {wanted}");
        }
    }
}

#[test]
fn listed_pixels_take_the_median_of_their_neighbours() {
    // Row 1, column 2 (8000) is one point, and the last row a rectangle.
    let listed = opcode(5, &[0, 1, 1, 1, 2, 3, 0, 4, 5], &[], &[], &[]);
    let constant = opcode(4, &[8000, 0], &[], &[], &[]);
    for (opcode, is_bad) in [(listed, (|i| i == 7 || i >= 15) as fn(usize) -> bool), (constant, |i| i == 7)] {
        for (i, found) in developed_with(1, &[opcode], &DevelopSettings::default()).into_iter().enumerate() {
            let stored = 1000.0 * (i + 1) as f64;
            match i {
                // The 8 around it are 2000 … 4000, 7000, 9000 and 12 000 … 14 000.
                7 => assert!((found - 8000.0).abs() < 0.01, "{found}"),
                i if is_bad(i) => assert!(found <= 15_000.0 && found < stored, "{i}: {found}"),
                _ => assert!((found - stored).abs() < 0.01, "{i}: {found}"),
            }
        }
    }
}

#[test]
fn falloff_stays_where_it_is_to() {
    let settings = DevelopSettings { lens_falloff: false, ..DevelopSettings::default() };
    for number in 1..=3 {
        let found = developed_with(number, &[as_bytes(3, 1.0)], &settings);
        assert!(found.iter().enumerate().all(|(i, x)| (x - 1000.0 * (i + 1) as f64).abs() < 0.01), "{found:?}");
    }
}

#[test]
fn what_follows_a_warp_is_left_out_with_a_warning() {
    let warp = opcode(1, &[1], &[], &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.5], &[]);
    let (_, kind, bytes) = list(&[as_bytes(12, 1.0), warp, as_bytes(3, 1.0)]);
    let metadata = dng(&with(&[(51_022, kind, bytes)], &mosaic())).expect("DNG").metadata;
    assert_eq!((metadata.opcodes[2].len(), metadata.distortion.is_some(), metadata.left_out.len()), (1, true, 1));
    assert!(metadata.left_out[0].starts_with("FixVignetteRadial of OpcodeList3, which the file marks as required"));
}
