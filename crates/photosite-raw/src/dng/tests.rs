use std::io::Cursor;

use proptest::prelude::*;

use super::*;
use crate::{
    AreaSpec, BlackLevel, ColourCalibration, Distortion, GainMap, LightSource, Opcode, Orientation, PerLine,
    RawMetadata, Warp, WarpKind, write_tiff,
};

const COMPRESSIONS: [DngCompression; 4] =
    [DngCompression::None, DngCompression::Packed, DngCompression::LosslessJpeg, DngCompression::Deflate];

fn image(cfa: &str, width: usize, height: usize) -> RawImage {
    let cfa = Cfa::parse(cfa).expect("known");
    let channels = cfa.channels().len();
    let colour = !cfa.is_mono();
    let matrix = |factor: f64| (0..channels).map(|row| [0.75 * factor, -0.25, 0.125 * row as f64]).collect();
    let lit = |light: LightSource| {
        let factor = f64::from(light.0) / 16.0;
        let (colour_matrix, forward_matrix) = (matrix(factor), Some(matrix(factor / 2.0)));
        ColourCalibration { light, colour_matrix, forward_matrix }
    };
    RawImage {
        width,
        height,
        data: (0..width * height * cfa.samples_per_pixel()).map(|i| (i as u16).wrapping_mul(40_503)).collect(),
        bits: 12,
        black_level_dn: 64.into(),
        white_level_dn: 4095,
        metadata: RawMetadata {
            is_staggered: false,
            camera_model: "a camera".to_owned(),
            camera_serial: "41".to_owned(),
            pixel_pitch_m: Some([5e-6, 2.5e-6]),
            exposure_time_s: 0.01,
            iso: Some(if colour { 100 } else { 102_400 }),
            f_number: Some(2.8),
            focal_length_m: colour.then_some(0.016),
            calibrations: if colour {
                vec![lit(LightSource::A), lit(LightSource::D65), lit(LightSource::D50)]
            } else {
                vec![]
            },
            as_shot_neutral: colour.then(|| (0..channels).map(|c| 1.0 / (c + 1) as f64).collect()),
            as_shot_white_xy: None,
            noise_profile: vec![[1e-4, 2e-7]; channels],
            baseline_exposure_ev: 0.75,
            opcodes: if colour { opcodes(cfa.samples_per_pixel()) } else { Default::default() },
            default_crop: (width.min(height) >= 5).then_some(PixelArea { x: 1, y: 2, width: 3, height: 2 }),
            orientation: Orientation::of_number(if colour { 6.0 } else { 1.0 }).expect("one of eight"),
            left_out: vec![],
            stated_pixel_aspect: (!colour).then_some(1.5),
            distortion: colour.then_some(Distortion::Warp(Warp {
                kind: WarpKind::Rectilinear,
                radial: [1.0, -0.1, 0.02, 0.0],
                tangential: [1e-3, 0.0],
                centre: [0.5, 0.49],
            })),
        },
        cfa,
        ..RawImage::default()
    }
}

/// One opcode of each kind.
fn opcodes(samples: usize) -> [Vec<Opcode>; 3] {
    let area = PixelArea { x: 1, y: 0, width: 4, height: 3 };
    let some = AreaSpec { area, pitch: [1, 2], plane: 0, planes: samples };
    let map = GainMap::new(3, 2, vec![1.5, 1.25, 1.5, 1.75, 1.0, 1.5]).expect("6 gains");
    let mut stored = vec![
        Opcode::MapTable(some.clone(), vec![0, 7, 9]),
        Opcode::PerLine(some.clone(), PerLine::DeltaPerRow, vec![-1.5, 2.0]),
        Opcode::PerLine(some.clone(), PerLine::DeltaPerColumn, vec![1.0, 2.0, 3.0, 4.0]),
    ];
    if samples == 1 {
        stored.push(Opcode::FixBadPixelsConstant(7));
        stored.push(Opcode::FixBadPixelsList(vec![area, PixelArea { x: 7, y: 9, width: 1, height: 1 }]));
    }
    let linear = vec![
        Opcode::MapPolynomial(some.clone(), vec![0.0, 0.9, 0.1]),
        Opcode::GainMap(map),
        Opcode::PerLine(some.clone(), PerLine::ScalePerRow, vec![0.5, 2.0]),
    ];
    let shown = vec![
        Opcode::FixVignetteRadial { k: [0.5, -0.25, 0.125, 1e-3, -1e-4], centre: [0.5, 0.49] },
        Opcode::PerLine(some, PerLine::ScalePerColumn, vec![1.0, 2.0, 0.5, 4.0]),
    ];
    [stored, linear, shown]
}

fn file(raw: &RawImage, compression: DngCompression) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    write_compressed_dng(raw, compression, &mut file).expect("written");
    file.into_inner()
}

fn read(file: &[u8]) -> Result<RawImage, Invalid> {
    read_dng(Cursor::new(file))
}

const LAYOUTS: [&str; 11] =
    ["RGGB", "BGGR", "GRBG", "GBRG", "mono", "x-trans", "full:RGB", "quad-bayer", "rgbw", "ryyb", "cygm"];

#[test]
fn images_come_back_as_they_went() {
    for cfa in LAYOUTS {
        for (width, height) in [(1, 1), (2, 2), (37, 23), (300, 5), (515, 20)] {
            let raw = image(cfa, width, height);
            for compression in COMPRESSIONS {
                let found = read(&file(&raw, compression));
                assert_eq!(found.as_ref(), Ok(&raw), "{cfa} {width} × {height} {compression:?}");
            }
        }
    }
}

#[test]
fn nonlinear_numbers_come_back_with_their_table() {
    let raw = image("RGGB", 37, 23);
    let table: Vec<u16> = (0..1024u32).map(|code| (code * code / 255).min(4095) as u16).collect();
    let data = raw.data.iter().map(|dn| dn % 1024).collect();
    let raw = RawImage { data, bits: 10, linearisation: Some(table), ..raw };
    let linear = raw.linear();
    assert_eq!((linear.data[3], linear.bits), ((u32::from(raw.data[3]).pow(2) / 255).min(4095) as u16, 12));
    for compression in COMPRESSIONS {
        // Floating-point numbers have no tables.
        let expected = if compression == DngCompression::Deflate { &*linear } else { &raw };
        assert_eq!(read(&file(&raw, compression)).as_ref(), Ok(expected), "{compression:?}");
    }
}

#[test]
fn masked_pixels_and_black_levels_come_back() {
    for cfa in ["GRBG", "x-trans", "mono", "full:RGB"] {
        let raw = image(cfa, 40, 30);
        let area = PixelArea { x: 5, y: 3, width: 31, height: 25 };
        let levels: Vec<f32> = (0..raw.cfa.channels().len()).map(|c| 60.5 + c as f32).collect();
        // The file keeps what columns and rows add within the active area.
        let inside = |side: usize, first: usize, length: usize| -> Vec<f32> {
            (0..first + length).map(|i| if i < first { 0.0 } else { (i % 7) as f32 / 4.0 - 0.5 }).take(side).collect()
        };
        let black = BlackLevel::of_channels(&raw.cfa, &levels).expect("a level each");
        let black = black.with_deltas(&raw.cfa, inside(40, area.x, area.width), inside(30, area.y, area.height));
        let raw = RawImage { active_area: Some(area), black_level_dn: black, ..raw };
        for compression in COMPRESSIONS {
            let found = read(&file(&raw, compression)).expect("read");
            let row_length = raw.row_length();
            let samples = raw.cfa.samples_per_pixel();
            for y in area.y..area.y + area.height {
                for x in area.x * samples..(area.x + area.width) * samples {
                    assert_eq!(found.black_level_dn.at(x, y), raw.black_level_dn.at(x, y), "{cfa} at {x}, {y}");
                    assert_eq!(found.cfa.channel_at(x, y), raw.cfa.channel_at(x, y), "{cfa} at {x}, {y}");
                }
            }
            assert_eq!((&found.data, found.active_area, row_length), (&raw.data, Some(area), found.row_length()));
            assert_eq!((found.cropped().data, found.metadata), (raw.cropped().data, raw.metadata.clone()));
        }
    }
}

#[test]
fn numbers_are_packed_into_as_many_bits_as_they_need() {
    for (bits, largest, row_bytes) in [(8, 255, 37), (10, 1023, 47), (12, 4095, 56), (10, 1024, 51), (12, 65_535, 74)] {
        let mut raw = image("RGGB", 37, 23);
        (raw.bits, raw.white_level_dn) = (bits, (1 << bits) - 1);
        raw.data.iter_mut().for_each(|dn| *dn %= largest);
        raw.data[100] = largest;
        let [plain, packed] = [DngCompression::None, DngCompression::Packed].map(|c| file(&raw, c));
        // What follows begins at a multiple of four bytes.
        let less = (plain.len() - packed.len()) as i64;
        assert!((less - (2 * 37 - row_bytes) * 23).abs() < 4, "{bits} bits: {less} bytes less");
        assert_eq!(read(&packed).expect("read").data, raw.data, "{bits} bits");
    }
}

#[test]
fn mosaics_in_the_first_directory_are_read() {
    // As telephones and tools write them: 2 × 2 pixels of 16 bits.
    for big_endian in [false, true] {
        let short = |n: u16| if big_endian { n.to_be_bytes() } else { n.to_le_bytes() };
        let long = |n: u32| if big_endian { n.to_be_bytes() } else { n.to_le_bytes() };
        let shorts = |values: &[u16]| {
            let mut bytes = values.iter().flat_map(|&n| short(n)).collect::<Vec<u8>>();
            bytes.resize(4, 0);
            (3u16, values.len() as u32, bytes)
        };
        let bytes = |values: [u8; 4]| (1u16, 4u32, values.to_vec());
        let entries = [
            (256, shorts(&[2])),
            (257, shorts(&[2])),
            (258, shorts(&[16])),
            (259, shorts(&[1])),
            (262, shorts(&[32_803])),
            (273, shorts(&[8])),
            (277, shorts(&[1])),
            (279, shorts(&[8])),
            (33_421, shorts(&[2, 2])),
            (33_422, bytes([2, 1, 1, 0])),
            (50_706, bytes([1, 4, 0, 0])),
            (50_714, shorts(&[16])),
            (50_717, shorts(&[1023])),
        ];
        let mut file = if big_endian { b"MM\0*".to_vec() } else { b"II*\0".to_vec() };
        file.extend(long(16));
        file.extend([10, 200, 3000, 40].map(short).as_flattened());
        file.extend(short(entries.len() as u16));
        for (tag, (kind, count, value)) in &entries {
            file.extend([short(*tag), short(*kind)].as_flattened());
            file.extend(long(*count));
            file.extend(value);
        }
        file.extend(long(0));
        let raw = read(&file).expect("a DNG file");
        assert_eq!((raw.width, raw.height, &raw.data[..]), (2, 2, &[10, 200, 3000, 40][..]));
        assert_eq!((raw.cfa.to_string(), raw.white_level_dn), ("BGGR".to_owned(), 1023));
        for length in 0..file.len() {
            assert!(read(&file[..length]).is_err(), "cut to {length} bytes");
        }
    }
}

#[test]
fn clear_filters_come_back_as_white() {
    let found = read(&file(&image("rccb", 8, 6), DngCompression::None)).expect("read");
    assert_eq!(found.cfa, Cfa::parse("RWWB").expect("a tile").clone());
}

#[test]
fn what_dng_cannot_say_is_not_written() {
    for cfa in ["rgb-ir", "full:RI"] {
        let error = write_dng(&image(cfa, 8, 6), Cursor::new(Vec::new())).expect_err("refused");
        assert!(error.to_string().contains('I'), "{error}");
    }
    for (width, height) in [(0, 0), (0, 4), (4, 0)] {
        let raw = image("RGGB", width, height);
        assert!(write_dng(&raw, Cursor::new(Vec::new())).is_err());
        assert!(write_tiff(&raw, Cursor::new(Vec::new())).is_err());
    }
    let lacking = RawImage { data: vec![0; 7], ..image("mono", 4, 2) };
    assert!(write_dng(&lacking, Cursor::new(Vec::new())).is_err());
}

#[test]
fn the_same_image_gives_the_same_bytes() {
    let raw = image("GBRG", 1200, 23);
    for compression in COMPRESSIONS {
        assert_eq!(file(&raw, compression), file(&raw, compression));
    }
}

#[test]
fn cut_files_are_errors() {
    for compression in COMPRESSIONS {
        let whole = file(&image("RGGB", 20, 10), compression);
        for length in 0..whole.len() {
            assert!(read(&whole[..length]).is_err(), "{compression:?} cut to {length} bytes");
        }
    }
    assert!(read(b"not a raw file").is_err());
    let mut tiff = Cursor::new(Vec::new());
    write_tiff(&image("mono", 4, 4), &mut tiff).expect("written");
    assert!(read(&tiff.into_inner()).expect_err("no DNG").message.contains("no raw image"));
}

#[test]
fn damaged_bytes_are_no_panics() {
    for compression in COMPRESSIONS {
        let whole = file(&image("RGGB", 20, 10), compression);
        let mut damaged = whole.clone();
        for at in 0..damaged.len() {
            for value in [0x00, 0xff, damaged[at] ^ 0x10] {
                damaged[at] = value;
                let _ = read(&damaged);
            }
            damaged[at] = whole[at];
        }
    }
}

proptest! {
    #[test]
    fn files_damaged_in_several_places_are_no_panics(
        cfa in 0..LAYOUTS.len(),
        compression in 0..COMPRESSIONS.len(),
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut damaged = file(&image(LAYOUTS[cfa], 20, 10), COMPRESSIONS[compression]);
        for (at, value) in changes {
            let at = at.index(damaged.len());
            damaged[at] = value;
        }
        let _ = read(&damaged);
        let _ = read(&damaged[..cut.index(damaged.len())]);
    }
}

/// Files state staggered rows by the same tag for monochrome images as for mosaics, which other programs know.
#[test]
fn staggered_rows_come_back() {
    for cfa in ["mono", "RGGB"] {
        let cfa = Cfa::parse(cfa).expect("known");
        for is_staggered in [false, true] {
            let metadata = RawMetadata { is_staggered, ..RawMetadata::default() };
            let raw =
                RawImage { width: 4, height: 4, data: vec![7; 16], cfa: cfa.clone(), metadata, ..RawImage::default() };
            let mut file = Vec::new();
            write_dng(&raw, Cursor::new(&mut file)).expect("written");
            assert_eq!(read_dng(Cursor::new(&file)).expect("read").metadata.is_staggered, is_staggered);
        }
    }
}
