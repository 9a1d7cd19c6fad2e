//! Statements of files that nobody follows are said by every command that reads an image.

use std::io::Cursor;

use image::{DynamicImage, GrayImage, ImageFormat, RgbImage};
use photosite::raw::{Cfa, Orientation, RawImage, RawMetadata, write_dng};
use tiff::encoder::{TiffEncoder, colortype::Gray16};
use tiff::tags::Tag;

use crate::folder::Folder;

const SIZE: [u32; 2] = [64, 48];

/// Codes of an edge, a few degrees off the columns.
fn code(x: u32, y: u32) -> u8 {
    if 10 * x + y > 344 { 200 } else { 60 }
}

/// An EXIF block with an orientation of 6 and, in the directory of EXIF, Adobe RGB, byte by byte.
fn exif() -> Vec<u8> {
    let short = |tag: u16, x: u8| [&tag.to_be_bytes()[..], &[0, 3, 0, 0, 0, 1, 0, x, 0, 0]].concat();
    let pointer = [&0x8769u16.to_be_bytes()[..], &[0, 4, 0, 0, 0, 1, 0, 0, 0, 38]].concat();
    let main = [&b"MM\0*\0\0\0\x08\0\x02"[..], &short(0x0112, 6), &pointer, &[0; 4]].concat();
    [&main[..], &[0, 1], &short(0xa001, 2), &[0; 4]].concat()
}

/// A JPEG file with that block behind its beginning.
fn jpeg() -> Vec<u8> {
    let image = RgbImage::from_fn(SIZE[0], SIZE[1], |x, y| [code(x, y); 3].into());
    let mut file = Cursor::new(Vec::new());
    DynamicImage::from(image).write_to(&mut file, ImageFormat::Jpeg).expect("encoded");
    let block = [&b"Exif\0\0"[..], &exif()].concat();
    let segment = [&[0xff, 0xe1], &(block.len() as u16 + 2).to_be_bytes()[..], &block].concat();
    let mut bytes = file.into_inner();
    bytes.splice(2..2, segment);
    bytes
}

/// A PNG file with the same block, a gain map, and pixels that are half as wide as high.
fn png() -> Vec<u8> {
    let mut file = Vec::new();
    let mut info = png::Info::with_size(SIZE[0], SIZE[1]);
    info.pixel_dims = Some(png::PixelDimensions { xppu: 2, yppu: 1, unit: png::Unit::Unspecified });
    let mut writer = png::Encoder::with_info(&mut file, info).expect("begun").write_header().expect("begun");
    writer.write_chunk(png::chunk::ChunkType(*b"eXIf"), &exif()).expect("written");
    writer.write_chunk(png::chunk::ChunkType(*b"gmAP"), &[]).expect("written");
    let codes = GrayImage::from_fn(SIZE[0], SIZE[1], |x, y| [code(x, y)].into());
    writer.write_image_data(codes.as_raw()).expect("written");
    writer.finish().expect("written");
    file
}

/// A TIFF file of two pages, to be turned.
fn tiff() -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file).expect("begun");
    let codes: Vec<u16> = (0..SIZE[0] * SIZE[1]).map(|i| 256 * u16::from(code(i % SIZE[0], i / SIZE[0]))).collect();
    for _ in 0..2 {
        let mut image = encoder.new_image::<Gray16>(SIZE[0], SIZE[1]).expect("begun");
        image.encoder().write_tag(Tag::Orientation, 6u16).expect("written");
        image.write_data(&codes).expect("written");
    }
    file.into_inner()
}

/// A DNG file of a monochrome sensor for readers of DNG 1.8, to be turned.
fn dng(exposure_time_s: f64) -> Vec<u8> {
    let data = (0..SIZE[0] * SIZE[1]).map(|i| 16 * u16::from(code(i % SIZE[0], i / SIZE[0]))).collect();
    let raw = RawImage::bare(SIZE[0] as usize, SIZE[1] as usize, data, Cfa::mono(), 4095);
    let orientation = Orientation::of_number(6.0).expect("one of eight");
    let metadata = RawMetadata { orientation, exposure_time_s, ..RawMetadata::default() };
    let mut file = Cursor::new(Vec::new());
    write_dng(&RawImage { metadata, ..raw }, &mut file).expect("written");
    let mut bytes = file.into_inner();
    // DNGBackwardVersion: four bytes, in the entry itself.
    let entry = [&50707u16.to_le_bytes()[..], &1u16.to_le_bytes(), &4u32.to_le_bytes()].concat();
    let at = bytes.windows(entry.len()).position(|part| part == entry).expect("its entry") + entry.len();
    bytes[at..at + 4].copy_from_slice(&[1, 8, 0, 0]);
    bytes
}

/// Every command that reads an image, and whether it takes pixels as they lie in the file.
const COMMANDS: [(&str, bool); 9] = [
    ("info A --json", false),
    ("develop A -o out.png --force", false),
    ("expose A --unit lux --one 10 --set exposure.time_s=0.001 -o out --force", true),
    ("compare A A", true),
    ("measure histogram A", true),
    ("measure similarity A A", true),
    ("measure mtf A", true),
    ("noise A", true),
    ("noise add A -o out.npy --force --set gaussian.sigma=1", true),
];

#[test]
fn every_command_says_what_a_file_states_and_nobody_follows() {
    let turned = "Orientation 6 is left out";
    for (name, file, notes, of_pixels) in [
        ("a.jpg", jpeg(), vec!["EXIF's ColorSpace, Adobe RGB, is left out"], vec![turned]),
        ("a.png", png(), vec!["its gain map is left out"], vec![turned, "pixels 0.5000 times as wide as high"]),
        ("a.tiff", tiff(), vec!["1 more page is left out"], vec![turned]),
        ("a.dng", dng(0.01), vec!["DNGBackwardVersion 1.8.0.0: the file is made for newer readers"], vec![turned]),
    ] {
        let folder = Folder::new([(name, file)]);
        for (command, takes_pixels) in COMMANDS {
            let arguments = command.replace('A', name);
            let found = folder.run(&arguments);
            let said = found.text() + &found.stdout;
            let of_pixels = of_pixels.iter().filter(|_| takes_pixels);
            for words in notes.iter().chain(of_pixels) {
                assert!(said.contains(&format!("{name}: {words}")), "{arguments}: {words}: {found:?}");
                // What a value of 1 is belongs to the assumption alone.
                let mut lines = found.stderr.lines();
                assert!(!lines.any(|line| line.contains(words) && line.contains("; 1 is")), "{arguments}: {found:?}");
            }
        }
    }
}

#[test]
fn maps_and_brackets_say_it_too() {
    let folder = Folder::new([("map.tiff", tiff()), ("short.dng", dng(0.01)), ("long.dng", dng(0.02))]);
    for (command, words) in [
        ("depth map.tiff -o out.npy --focal-length-px 100 --baseline-m 0.1", "map.tiff: 1 more page is left out"),
        ("merge-hdr short.dng long.dng -o out.exr", "long.dng: DNGBackwardVersion 1.8.0.0"),
    ] {
        let said = folder.succeed(command).text();
        assert!(said.contains(words), "{command}: {said}");
    }
}

/// Sets of EMVA 1288 name the first of the images that have more pages, and how many others.
#[test]
fn pages_of_images_of_a_set_are_said_to_be_left_out() {
    let folder = Folder::new([]);
    folder.succeed("emva1288 sony-imx249-mono --size 64x48 --steps 8 --spatial 4 -o sets -q");
    let images: Vec<_> =
        folder.contents().into_keys().filter(|path| path.extension().is_some_and(|e| e == "tiff")).collect();
    for path in &images {
        let read = photosite::read_raw(&folder.path(&path.to_string_lossy())).expect("an image");
        let mut file = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut file).expect("begun");
        for _ in 0..2 {
            encoder.write_image::<Gray16>(read.width as u32, read.height as u32, &read.data).expect("written");
        }
        folder.add(&path.to_string_lossy(), file.into_inner());
    }
    let said = folder.succeed("emva1288-report sets").text();
    let words = format!(
        "1 more page is left out: the first alone is read; the same holds of {} other images",
        images.len() - 1
    );
    assert!(said.contains(&words), "{said}");
}
