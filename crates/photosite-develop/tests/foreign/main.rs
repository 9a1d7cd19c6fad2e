//! Files as other programs write them, byte by byte.

use std::io::Cursor;

use photosite_core::Invalid;
use photosite_develop::{DevelopSettings, develop_linear};
use photosite_raw::rules::{Kind, Treatment};
use photosite_raw::*;

mod opcodes;

/// A tag, its type by TIFF's number, and its numbers.
type Entry = (u16, u16, Vec<f64>);

/// Form in which a file is written.
#[derive(Clone, Copy, Default)]
struct Form {
    is_big: bool,
    is_big_endian: bool,
}

const USUAL: Form = Form { is_big: false, is_big_endian: false };

impl Form {
    fn number(self, number: u64, count: usize) -> Vec<u8> {
        let mut bytes = number.to_le_bytes()[..count].to_vec();
        if self.is_big_endian {
            bytes.reverse();
        }
        bytes
    }

    fn place(self) -> usize {
        if self.is_big { 8 } else { 4 }
    }

    fn value(self, kind: u16, x: f64) -> Vec<u8> {
        match kind {
            1 | 2 | 7 => vec![x as u8],
            3 => self.number(x as u64, 2),
            4 | 13 => self.number(x as u64, 4),
            5 => [self.number((x * 65_536.0) as u64, 4), self.number(65_536, 4)].concat(),
            10 => [self.number((x * 65_536.0) as i64 as u64, 4), self.number(65_536, 4)].concat(),
            11 => self.number(u64::from((x as f32).to_bits()), 4),
            12 => self.number(x.to_bits(), 8),
            16 => self.number(x as u64, 8),
            _ => panic!("type {kind}"),
        }
    }

    /// Appends a directory with one strip; where it begins and where the place of the next one is.
    fn append(self, file: &mut Vec<u8>, tags: &[Entry], strip: &[u8]) -> (usize, usize) {
        let mut tags = tags.to_vec();
        if !strip.is_empty() {
            let long = if self.is_big { 16 } else { 4 };
            tags.push((273, long, vec![file.len() as f64]));
            tags.push((279, long, vec![strip.len() as f64]));
            file.extend(strip);
        }
        tags.sort_by_key(|(tag, ..)| *tag);
        let mut directory = self.number(tags.len() as u64, if self.is_big { 8 } else { 2 });
        for (tag, kind, numbers) in &tags {
            let mut bytes: Vec<u8> = numbers.iter().flat_map(|&x| self.value(*kind, x)).collect();
            directory.extend([self.number(u64::from(*tag), 2), self.number(u64::from(*kind), 2)].concat());
            directory.extend(self.number(numbers.len() as u64, self.place()));
            if bytes.len() > self.place() {
                file.resize(file.len().next_multiple_of(2), 0);
                let place = file.len();
                file.extend(bytes);
                bytes = self.number(place as u64, self.place());
            }
            bytes.resize(self.place(), 0);
            directory.extend(bytes);
        }
        file.resize(file.len().next_multiple_of(2), 0);
        let begins = file.len();
        file.extend(directory);
        let next = file.len();
        file.extend(self.number(0, self.place()));
        (begins, next)
    }

    /// A file of pages, of which the first may have directories beneath it.
    fn file(self, pages: &[(&[Entry], &[u8])], beneath: &[(&[Entry], &[u8])]) -> Vec<u8> {
        let mut file = if self.is_big_endian { b"MM".to_vec() } else { b"II".to_vec() };
        if self.is_big {
            file.extend([self.number(43, 2), self.number(8, 2), self.number(0, 2)].concat());
        } else {
            file.extend(self.number(42, 2));
        }
        let mut next = file.len();
        file.extend(self.number(0, self.place()));
        let sub: Vec<f64> = beneath.iter().map(|(tags, strip)| self.append(&mut file, tags, strip).0 as f64).collect();
        for (i, (tags, strip)) in pages.iter().enumerate() {
            let mut tags = tags.to_vec();
            if i == 0 && !sub.is_empty() {
                tags.push((330, 4, sub.clone()));
            }
            let (begins, after) = self.append(&mut file, &tags, strip);
            file.splice(next..next + self.place(), self.number(begins as u64, self.place()));
            next = after;
        }
        file
    }
}

/// The given tags, and those of the others that they do not have.
fn with(tags: &[Entry], others: &[Entry]) -> Vec<Entry> {
    let others = others.iter().filter(|(tag, ..)| tags.iter().all(|(given, ..)| given != tag));
    tags.iter().chain(others).cloned().collect()
}

/// Grey image of 4 × 2 pixels of 16 bits.
fn grey() -> Vec<Entry> {
    let one = |tag, x| (tag, 3, vec![x]);
    vec![one(256, 4.0), one(257, 2.0), one(258, 16.0), one(259, 1.0), one(262, 1.0), one(277, 1.0), one(278, 2.0)]
}

/// Mosaic of red, green and blue of 4 × 2 pixels that sees as linear sRGB does.
fn mosaic() -> Vec<Entry> {
    let dng = [
        (262, 3, vec![32_803.0]),
        (33_421, 3, vec![2.0, 2.0]),
        (33_422, 1, vec![0.0, 1.0, 1.0, 2.0]),
        (50_706, 1, vec![1.0, 4.0, 0.0, 0.0]),
        (50_717, 4, vec![60_000.0]),
        (50_728, 5, vec![1.0; 3]),
    ];
    with(&dng, &grey())
}

/// LinearRaw image of three numbers at each pixel.
fn linear_raw() -> Vec<Entry> {
    let dng = [(262, 3, vec![34_892.0]), (277, 3, vec![3.0]), (258, 3, vec![16.0; 3])];
    let mut tags = with(&dng, &mosaic());
    tags.retain(|(tag, ..)| ![33_421, 33_422].contains(tag));
    tags
}

fn bytes_of(form: Form, numbers: &[u16]) -> Vec<u8> {
    numbers.iter().flat_map(|&n| form.number(n.into(), 2)).collect()
}

const NUMBERS: [u16; 8] = [60, 120, 180, 240, 300, 30_000, 45_000, 60_000];

fn dng(tags: &[Entry]) -> Result<RawImage, Invalid> {
    read_dng(Cursor::new(USUAL.file(&[(tags, &bytes_of(USUAL, &NUMBERS))], &[])))
}

fn tiff(tags: &[Entry]) -> Result<RawImage, Invalid> {
    read_tiff(Cursor::new(USUAL.file(&[(tags, &bytes_of(USUAL, &NUMBERS))], &[])))
}

/// Files with every tag of the table alone: with what is harmless, and with something else.
#[test]
fn every_tag_of_the_tables_is_followed_or_named() {
    for (kind, read, base) in
        [(Kind::Dng, dng as fn(&[Entry]) -> Result<RawImage, Invalid>, mosaic()), (Kind::Tiff, tiff, grey())]
    {
        let plain = read(&base).expect("plain");
        assert_eq!(plain.metadata.left_out, Vec::<String>::new());
        // ExtraSamples changes how many numbers a pixel has.
        for &(tag, name, treatment) in kind.rules().filter(|(tag, ..)| *tag != 338) {
            let with_tag = |numbers: Vec<f64>| read(&with(&[(tag, 12, numbers)], &base));
            match treatment {
                Treatment::Followed => {}
                Treatment::Neutral => {
                    assert_eq!(with_tag(vec![0.375; 5]).expect(name), plain, "{name} changes something");
                }
                Treatment::LeftOut(harmless, so) => {
                    for numbers in harmless {
                        let left_out = with_tag(numbers.to_vec()).expect(name).metadata.left_out;
                        assert_eq!(left_out, Vec::<String>::new(), "{name} says nothing else");
                    }
                    let left_out = with_tag(vec![0.375; 5]).expect(name).metadata.left_out;
                    let [said] = &left_out[..] else { panic!("{name}: {left_out:?}") };
                    assert!(said.starts_with(name) && said.ends_with(so), "{said}");
                }
                Treatment::Refused(harmless) => {
                    let found = with_tag(harmless.to_vec()).expect(name);
                    assert_eq!((found.data, found.metadata.left_out), (plain.data.clone(), Vec::new()), "{name}");
                    let error = with_tag(vec![2.0; harmless.len()]).expect_err(name);
                    assert!(error.key == name && error.help.is_some(), "{error}");
                }
            }
        }
    }
}

/// The numbers that exiftool 12.57 has for DNG's own tags.
#[test]
fn the_table_knows_all_tags_of_the_specification_and_names_others() {
    const KNOWN: &[u16] = &[
        50_706, 50_707, 50_708, 50_709, 50_710, 50_711, 50_712, 50_713, 50_714, 50_715, 50_716, 50_717, 50_718, 50_719,
        50_720, 50_721, 50_722, 50_723, 50_724, 50_725, 50_726, 50_727, 50_728, 50_729, 50_730, 50_731, 50_732, 50_733,
        50_734, 50_735, 50_736, 50_737, 50_738, 50_739, 50_740, 50_740, 50_741, 50_778, 50_779, 50_780, 50_781, 50_827,
        50_828, 50_829, 50_830, 50_831, 50_832, 50_833, 50_834, 50_879, 50_931, 50_932, 50_934, 50_935, 50_936, 50_937,
        50_938, 50_939, 50_940, 50_941, 50_942, 50_964, 50_965, 50_966, 50_967, 50_968, 50_969, 50_970, 50_971, 50_972,
        50_973, 50_974, 50_975, 50_981, 50_982, 51_008, 51_009, 51_022, 51_041, 51_043, 51_044, 51_058, 51_081, 51_089,
        51_090, 51_091, 51_105, 51_107, 51_108, 51_109, 51_110, 51_111, 51_112, 51_114, 51_125, 51_177, 51_178, 51_179,
        51_180, 51_181, 51_182, 52_525, 52_526, 52_528, 52_529, 52_530, 52_531, 52_532, 52_533, 52_534, 52_535, 52_536,
        52_537, 52_538, 52_539,
    ];
    for tag in KNOWN {
        assert!(Kind::Dng.rules().any(|(known, ..)| known == tag), "{tag} is not in the table");
    }
    let numbers: Vec<u16> = Kind::Dng.rules().map(|(number, ..)| *number).collect();
    assert!(numbers.iter().all(|tag| numbers.iter().filter(|other| *other == tag).count() == 1), "listed twice");
    let found = dng(&with(&[(52_599, 3, vec![7.0]), (50_976, 3, vec![7.0])], &mosaic())).expect("read");
    assert_eq!(found.metadata.left_out, ["tags that photosite does not know are left out: 50976, 52599"]);
}

#[test]
fn both_kinds_of_tiff_are_read_in_both_orders() {
    for is_big in [false, true] {
        for is_big_endian in [false, true] {
            let form = Form { is_big, is_big_endian };
            let file = |tags: &[Entry]| form.file(&[(tags, &bytes_of(form, &NUMBERS))], &[]);
            let grey = read_tiff(Cursor::new(file(&grey()))).expect("TIFF");
            assert_eq!((grey.data, grey.width, grey.metadata.is_silent()), (NUMBERS.to_vec(), 4, true));
            let mosaic = read_dng(Cursor::new(file(&mosaic()))).expect("DNG");
            assert_eq!((mosaic.data, mosaic.cfa.to_string()), (NUMBERS.to_vec(), "RGGB".to_owned()));
            for length in 0..file(&self::mosaic()).len() {
                let cut = &file(&self::mosaic())[..length];
                let _ = (read_dng(Cursor::new(cut)), read_tiff(Cursor::new(cut)));
            }
        }
    }
}

#[test]
fn images_beside_the_one_that_is_read_are_counted() {
    let numbers = bytes_of(USUAL, &NUMBERS);
    let page = |kind: f64| with(&[(254, 4, vec![kind])], &grey());
    let [full, small, mask] = [0.0, 1.0, 4.0].map(page);
    let said = |pages: &[&[Entry]], beneath: &[&[Entry]]| {
        let [pages, beneath] =
            [pages, beneath].map(|all| all.iter().map(|&tags| (tags, &numbers[..])).collect::<Vec<_>>());
        USUAL.file(&pages, &beneath)
    };
    let left_out = |file: Vec<u8>| read_tiff(Cursor::new(file)).expect("TIFF").metadata.left_out;
    assert_eq!(left_out(said(&[&full, &full], &[])), ["1 more page is left out: the first alone is read"]);
    assert_eq!(
        left_out(said(&[&full, &small, &full, &mask, &full], &[])),
        ["2 more pages are left out: the first alone is read"]
    );
    assert_eq!(left_out(said(&[&full, &small], &[])), Vec::<String>::new());
    assert_eq!(left_out(said(&[&full], &[&small, &small])), ["2 images beneath the first are left out"]);
    let text = |text: &str| (270, 2, text.bytes().map(f64::from).collect::<Vec<f64>>());
    let stack = with(&[text("ImageJ=1.54f\nimages=12\nslices=12\n\0")], &grey());
    assert_eq!(tiff(&stack).expect("TIFF").metadata.left_out, ["11 more pages are left out: the first alone is read"]);
    let two = said(&[&with(&[(262, 3, vec![1.0]), (50_706, 1, vec![1.0; 4])], &small)], &[&mosaic(), &mosaic()]);
    let found = read_dng(Cursor::new(two)).expect("DNG");
    assert_eq!(found.metadata.left_out, ["1 more raw image in the file is left out"]);
    // A directory that names itself as the next ends.
    let mut loops = USUAL.file(&[(&full, &numbers)], &[]);
    let first = loops[4..8].to_vec();
    let end = loops.len() - 4;
    loops.splice(end.., first);
    assert_eq!(tiff_notes(Cursor::new(loops)).expect("TIFF"), TiffNotes::default());
}

#[test]
fn colours_that_are_multiplied_by_transparency_are_told() {
    for (alpha, count) in [(0.0, 0), (1.0, 1), (2.0, 0)] {
        let tags = with(&[(258, 3, vec![16.0; 2]), (277, 3, vec![2.0]), (338, 3, vec![alpha])], &grey());
        let notes = tiff_notes(Cursor::new(USUAL.file(&[(&tags, &[0; 32])], &[]))).expect("TIFF");
        assert_eq!(notes.left_out.len(), count, "{alpha}: {:?}", notes.left_out);
    }
}

#[test]
fn shapes_and_turns_of_tiff_images_are_told() {
    let uneven = with(&[(282, 5, vec![72.0]), (283, 5, vec![144.0])], &grey());
    let said = "XResolution 72 and YResolution 144 are left out: its pixels are taken for square";
    assert_eq!(tiff(&uneven).expect("TIFF").metadata.left_out, [said]);
    let upright = tiff(&with(&[(274, 3, vec![6.0])], &grey())).expect("TIFF").metadata;
    assert_eq!((upright.orientation.number(), upright.left_out.len()), (6, 0));
    let none = tiff(&with(&[(274, 3, vec![9.0])], &grey())).expect("TIFF").metadata;
    assert_eq!(none.left_out, ["Orientation 9 is none: the image is not turned"]);
    let profile = tiff(&with(&[(34_675, 7, vec![0.0; 9])], &grey())).expect("TIFF").metadata;
    assert!(profile.left_out[0].starts_with("ICCProfile is left out"), "{:?}", profile.left_out);
    let palette = [(258, 3, vec![8.0]), (262, 3, vec![3.0]), (320, 3, vec![0.0; 768])];
    assert!(tiff(&with(&palette, &grey())).expect_err("a palette").help.is_some());
    // Where white is 0, numbers count from the other end, as Pillow has it.
    let inverse = tiff(&with(&[(262, 3, vec![0.0])], &grey())).expect("TIFF");
    assert_eq!(inverse.data, NUMBERS.map(|n| u16::MAX - n));
}

#[test]
fn exposure_in_the_first_directory_counts_and_that_of_exif_comes_before_it() {
    let facts = [(33_434, 5, vec![0.125]), (33_437, 5, vec![4.0]), (34_855, 3, vec![100.0]), (37_386, 5, vec![25.0])];
    let said = |raw: RawImage| {
        let RawMetadata { exposure_time_s, f_number, iso, focal_length_m, .. } = raw.metadata;
        (exposure_time_s, f_number, iso, focal_length_m)
    };
    let all = (0.125, Some(4.0), Some(100), Some(0.025));
    assert_eq!(said(dng(&with(&facts, &mosaic())).expect("DNG")), all);
    // Beneath a small image, in its directory, or in that of the raw one.
    let small = with(&[(254, 4, vec![1.0]), (262, 3, vec![1.0]), (50_706, 1, vec![1.0; 4])], &grey());
    let numbers = bytes_of(USUAL, &NUMBERS);
    for (first, raw) in [(with(&facts, &small), mosaic()), (small, with(&facts, &mosaic()))] {
        let file = USUAL.file(&[(&first, &numbers)], &[(&raw, &numbers)]);
        assert_eq!(said(read_dng(Cursor::new(file)).expect("DNG")), all);
    }
    // What 16 bits cannot say, other tags do.
    let wide = [(34_855, 3, vec![65_535.0]), (34_866, 4, vec![102_400.0])];
    assert_eq!(dng(&with(&wide, &mosaic())).expect("DNG").metadata.iso, Some(102_400));
}

#[test]
fn white_levels_are_those_of_each_plane_and_by_default_of_all_bits() {
    let numbers: Vec<u16> =
        (0..8).flat_map(|i| [1000 + 5900 * i / 8, 2000 + 4800 * i / 8, 3000 + 3700 * i / 8]).collect();
    let levels = |tag: u16, levels: [f64; 3]| (tag, 4, levels.to_vec());
    let planes = [levels(50_714, [1000.0, 2000.0, 3000.0]), levels(50_717, [60_000.0, 50_000.0, 40_000.0])];
    let file = USUAL.file(&[(&with(&planes, &linear_raw()), &bytes_of(USUAL, &numbers))], &[]);
    let raw = read_dng(Cursor::new(file)).expect("DNG");
    assert_eq!((raw.white_level_dn, [0, 1, 2].map(|c| raw.white_of(c))), (40_000, [60_000, 50_000, 40_000]));
    let (image, _) = develop_linear(&raw, &DevelopSettings::default()).expect("developed");
    for (channel, (plane, (black, white))) in
        [("R", (1000.0, 60_000.0)), ("G", (2000.0, 50_000.0)), ("B", (3000.0, 40_000.0))].into_iter().enumerate()
    {
        for (i, x) in image.plane(plane).expect("RGB").iter().enumerate() {
            let wanted = (f32::from(numbers[3 * i + channel]) - black) / (white - black);
            assert!((x - wanted).abs() < 1e-6, "{plane} {i}: {x} {wanted}");
        }
    }
    let mut written = Cursor::new(Vec::new());
    write_dng(&raw, &mut written).expect("written");
    written.set_position(0);
    assert_eq!(read_dng(written).expect("read").channel_whites_dn, raw.channel_whites_dn);

    let mut silent = mosaic();
    silent.retain(|(tag, ..)| *tag != 50_717);
    assert_eq!(dng(&silent).expect("DNG").white_level_dn, 65_535);
    let twelve = with(&[(258, 3, vec![12.0])], &silent);
    assert_eq!(dng(&twelve).expect("DNG").white_level_dn, 4095);
}

#[test]
fn images_are_cropped_as_their_file_says() {
    let crop = [(50_719, 5, vec![1.0, 0.0]), (50_720, 5, vec![2.0, 2.0])];
    let raw = dng(&with(&crop, &mosaic())).expect("DNG");
    let developed = |settings: &DevelopSettings| develop_linear(&raw, settings).expect("developed").0;
    let settings = |default_crop| DevelopSettings { default_crop, ..DevelopSettings::default() };
    let (cropped, whole) = (developed(&settings(true)), developed(&settings(false)));
    assert_eq!([cropped.width(), cropped.height(), whole.width(), whole.height()], [2, 2, 4, 2]);
    for plane in ["R", "G", "B"] {
        let [part, all] = [&cropped, &whole].map(|image| image.plane(plane).expect("RGB"));
        assert_eq!(part, [all[1], all[2], all[5], all[6]]);
    }
    let resized = developed(&DevelopSettings { resize_px: Some([6, 9]), ..settings(true) });
    assert_eq!([resized.width(), resized.height()], [6, 9]);
}

#[test]
fn developed_images_stand_upright_unless_asked_not_to() {
    let raw = dng(&with(&[(274, 3, vec![6.0])], &mosaic())).expect("DNG");
    let settings = |orientation| DevelopSettings { orientation, ..DevelopSettings::default() };
    let size = |settings: &DevelopSettings| {
        let (image, _) = develop_linear(&raw, settings).expect("developed");
        [image.width(), image.height()]
    };
    assert_eq!([size(&settings(true)), size(&settings(false))], [[2, 4], [4, 2]]);
    let of_size = |orientation| DevelopSettings { resize_px: Some([6, 9]), ..settings(orientation) };
    assert_eq!([size(&of_size(true)), size(&of_size(false))], [[6, 9]; 2]);
    let (upright, _) = develop_linear(&raw, &settings(true)).expect("developed");
    let (lying, _) = develop_linear(&raw, &settings(false)).expect("developed");
    // A quarter turn clockwise: the lower left pixel comes to the upper left.
    assert_eq!(upright.plane("G").expect("green")[0], lying.plane("G").expect("green")[4]);
}

#[test]
fn floating_point_numbers_of_all_widths_are_read() {
    // 0, ¼, ½, ¾, 1, 1½, 2, ⅛ in 16, 24 and 32 bits, most significant byte first.
    let half = [0x0000, 0x3400, 0x3800, 0x3a00, 0x3c00, 0x3e00, 0x4000, 0x3000];
    let of_24 = [0, 0x3d_0000, 0x3e_0000, 0x3e_8000, 0x3f_0000, 0x3f_8000, 0x40_0000, 0x3c_0000];
    let single = [0.0f32, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 0.125].map(f32::to_bits);
    for is_big_endian in [false, true] {
        let form = Form { is_big: false, is_big_endian };
        for (bits, numbers) in [(16, half), (24, of_24), (32, single)] {
            let size = bits / 8;
            let strip: Vec<u8> = numbers.iter().flat_map(|&n| form.number(n.into(), size)).collect();
            let tags = [(258, 3, vec![bits as f64]), (339, 3, vec![3.0]), (50_717, 4, vec![1.0])];
            let raw = read_dng(Cursor::new(form.file(&[(&with(&tags, &mosaic()), &strip)], &[]))).expect("DNG");
            // 2 becomes the largest number, 65 535, and white ⌊65 535/2⌋.
            assert_eq!(raw.white_level_dn, 32_767, "{bits}");
            let wanted = [0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 0.125].map(|x: f64| (x * 32_767.0).round() as u16);
            assert_eq!(raw.data, wanted, "{bits} bits");
            assert!(raw.metadata.left_out[0].contains("are rounded"), "{:?}", raw.metadata.left_out);
            // The same behind zlib, with like bytes together and differences over one, two or four numbers.
            for (predictor, stride) in [(3.0, 1), (34_894.0, 2), (34_895.0, 4)] {
                let mut all = Vec::new();
                for row in numbers.chunks(4) {
                    let byte = |i: usize, n: u32| n.to_be_bytes()[4 - size + i];
                    let planes: Vec<u8> = (0..size).flat_map(|i| row.iter().map(move |&n| byte(i, n))).collect();
                    let less = |i: usize| if i < stride { 0 } else { planes[i - stride] };
                    all.extend((0..planes.len()).map(|i| planes[i].wrapping_sub(less(i))));
                }
                let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
                std::io::Write::write_all(&mut zlib, &all).expect("in memory");
                let strip = zlib.finish().expect("in memory");
                let tags = with(&[(259, 3, vec![8.0]), (317, 3, vec![predictor])], &tags);
                let file = form.file(&[(&with(&tags, &mosaic()), &strip)], &[]);
                assert_eq!(read_dng(Cursor::new(file)).expect("DNG").data, wanted, "{bits} bits, {predictor}");
            }
        }
    }
}

#[test]
fn codings_that_are_not_read_are_refused_by_what_they_are() {
    for (tags, key, word) in [
        (vec![(259, 3, vec![34_892.0])], "Compression", "lossy JPEG"),
        (vec![(259, 3, vec![52_546.0])], "Compression", "JPEG XL"),
        (vec![(258, 3, vec![32.0])], "BitsPerSample", "32"),
        (vec![(258, 3, vec![64.0]), (339, 3, vec![3.0])], "BitsPerSample", "64"),
        (vec![(339, 3, vec![2.0])], "SampleFormat", "2"),
        (vec![(259, 3, vec![8.0]), (317, 3, vec![7.0])], "Predictor", "7"),
    ] {
        let error = dng(&with(&tags, &mosaic())).expect_err(key);
        assert!(error.key == key && error.message.contains(word) && error.help.is_some(), "{error}");
    }
}

#[test]
fn a_calibration_of_another_signature_is_not_used() {
    let signature = |tag: u16, text: &str| (tag, 2, text.bytes().chain([0]).map(f64::from).collect::<Vec<f64>>());
    let identity: Vec<f64> = (0..9).map(|i| if i % 4 == 0 { 1.0 } else { 0.0 }).collect();
    let twice: Vec<f64> = identity.iter().map(|x| 2.0 * x).collect();
    let matrices = [(50_721, 10, identity.clone()), (50_778, 3, vec![21.0]), (50_723, 10, twice)];
    let factor = |signatures: &[Entry]| {
        let raw = dng(&with(signatures, &with(&matrices, &mosaic()))).expect("DNG");
        raw.metadata.calibrations[0].colour_matrix[0][0]
    };
    assert_eq!(factor(&[]), 2.0);
    assert_eq!(factor(&[signature(50_931, "com.adobe"), signature(50_932, "com.adobe")]), 2.0);
    assert_eq!(factor(&[signature(50_931, "com.adobe"), signature(50_932, "mine")]), 1.0);
    assert_eq!(factor(&[signature(50_931, "com.adobe")]), 1.0);
}

#[test]
fn parts_and_levels_that_are_not_followed_are_told() {
    let crop = [(50_719, 5, vec![3.0, 0.0]), (50_720, 5, vec![2.0, 2.0])];
    let said = dng(&with(&crop, &mosaic())).expect("DNG").metadata.left_out;
    let wanted = "DefaultCropSize, 2 × 2 pixels at 3, 0, is left out: the active area has 4 × 2 pixels";
    assert_eq!(said, [wanted]);
    let masked = (50_830, 4, vec![0.0, 0.0, 2.0, 1.0]);
    let said = dng(&with(std::slice::from_ref(&masked), &mosaic())).expect("DNG").metadata.left_out;
    assert!(said[0].starts_with("MaskedAreas is left out: black is taken for 0"), "{said:?}");
    let stated = with(&[masked, (50_714, 4, vec![7.0])], &mosaic());
    assert_eq!(dng(&stated).expect("DNG").metadata.left_out, Vec::<String>::new());
    let newer = with(&[(50_707, 1, vec![1.0, 8.0, 0.0, 0.0])], &mosaic());
    assert!(dng(&newer).expect("DNG").metadata.left_out[0].starts_with("DNGBackwardVersion 1.8.0.0"));
}
