//! Readers fed with damaged files: whatever comes in, an error or a picture comes out, never a panic, and soon.
//!
//! Each test damages good files in many ways, the same for the same number: [`LEAST_CASES`] for each good file, and
//! more for as long as `PHOTOSITE_FUZZ_S` says (left out: a second). What fails is written to the temporary folder, and
//! the message says where.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use photosite::capture::Capture;
use photosite::characterisation::Descriptor;
use photosite::io::gltf::{self, Choice, Moment};
use photosite::io::obj::{self, MissingNormals};
use photosite::math::hash::hash64;
use photosite::raw::{Cfa, DngCompression, RawImage, read_dng, read_pnm, read_tiff, write_compressed_dng, write_tiff};

/// No reader may take longer for a file of a few kilobytes, on a busy machine.
const SLOWEST: Duration = Duration::from_secs(20);

/// Damaged versions of each good file, on average, however busy the machine is. A version has 2½ pieces of damage on
/// average and each of the 7 kinds is at least one in 8 of them, so that the chance for a file to be spared one of the
/// kinds is at most 7·(7/8)⁵⁰ < 1 %.
const LEAST_CASES: usize = 20;

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Small numbers that follow from a seed.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, end: usize) -> usize {
        self.0 = hash64(self.0, 1);
        (self.0 % end.max(1) as u64) as usize
    }
}

/// Words that readers may stumble over.
const WORDS: [&str; 14] = [
    "-1",
    "0",
    "1e39",
    "NaN",
    "4294967295",
    "18446744073709551616",
    "null",
    "\"\"",
    "[]",
    "{}",
    "\\",
    "\n",
    "1e-45",
    "é",
];

/// One to four pieces of damage.
fn damaged(good: &[u8], numbers: &mut Numbers) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..=numbers.below(4) {
        let at = numbers.below(bytes.len());
        match numbers.below(8) {
            0 => bytes.truncate(at),
            1 | 2 if !bytes.is_empty() => bytes[at] ^= 1 << numbers.below(8),
            3 if !bytes.is_empty() => bytes[at] = [0, 0xff, 0x7f, 0x80, b'9', b'-'][numbers.below(6)],
            4 => {
                let end = (at + numbers.below(64)).min(bytes.len());
                bytes.drain(at..end);
            }
            5 => {
                let end = (at + numbers.below(64)).min(bytes.len());
                let piece = bytes[at..end].to_vec();
                let to = numbers.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            // A number in the text becomes another word.
            6 => {
                let is_number = |b: &u8| b.is_ascii_digit() || matches!(b, b'.' | b'-');
                if let Some(start) = bytes[at..].iter().position(is_number).map(|i| at + i) {
                    let end = bytes[start..].iter().position(|b| !is_number(b)).map_or(bytes.len(), |i| start + i);
                    bytes.splice(start..end, WORDS[numbers.below(WORDS.len())].bytes());
                }
            }
            _ => {
                let word = WORDS[numbers.below(WORDS.len())];
                bytes.splice(at..at, word.bytes());
            }
        }
    }
    bytes
}

/// Feeds `read` with damaged versions of the files: [`LEAST_CASES`] of each, and more until the time is up.
fn survive(name: &str, files: &[(String, Vec<u8>)], read: impl Fn(&str, &[u8])) {
    let seconds = std::env::var("PHOTOSITE_FUZZ_S").ok().and_then(|s| s.parse().ok()).unwrap_or(1.0);
    let start = Instant::now();
    let least = (LEAST_CASES * files.len()) as u64;
    let mut seed = 0;
    while seed < least || start.elapsed().as_secs_f64() < seconds {
        let mut numbers = Numbers(hash64(seed, 7));
        let (file, good) = &files[numbers.below(files.len())];
        let bytes = damaged(good, &mut numbers);
        let begun = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| read(file, &bytes)));
        if outcome.is_err() || begun.elapsed() > SLOWEST {
            let kept = std::env::temp_dir().join(format!("photosite-fuzz-{name}-{seed}"));
            std::fs::write(&kept, &bytes).expect("a writable temporary folder");
            panic!("{name} {file}, seed {seed}, after {:?}: see {}", begun.elapsed(), kept.display());
        }
        seed += 1;
    }
    eprintln!("{name}: {seed} damaged files");
}

/// Files of a folder with one of these endings.
fn files_of(folder: &str, endings: &[&str]) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = std::fs::read_dir(repository(folder))
        .expect("a folder of the repository")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| endings.iter().any(|ending| e == *ending)))
        .map(|path| {
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            (name, std::fs::read(&path).expect("a readable file"))
        })
        .collect();
    files.sort();
    assert!(!files.is_empty(), "{folder}");
    files
}

#[test]
fn gltf_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["shapes.bin", "pixels.png"] {
        std::fs::copy(repository("tests/gltf").join(name), folder.path().join(name)).expect("copied");
    }
    let mut files = files_of("tests/gltf", &["gltf"]);
    // A binary one, its bytes those of a text and of the shapes.
    let (_, text) = files.iter().find(|(name, _)| name == "animation-skin.gltf").expect("a file of animations");
    let shapes = std::fs::read(repository("tests/gltf/shapes.bin")).expect("readable");
    let json = String::from_utf8_lossy(text).replace("\"uri\": \"shapes.bin\",", "").into_bytes();
    let padded = |mut bytes: Vec<u8>, with| {
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let chunks = [(padded(json, b' '), b"JSON"), (padded(shapes, 0), b"BIN\0")];
    let length = 12 + chunks.iter().map(|(bytes, _)| 8 + bytes.len() as u32).sum::<u32>();
    let mut glb = [&b"glTF"[..], &2u32.to_le_bytes(), &length.to_le_bytes()].concat();
    for (bytes, kind) in chunks {
        glb.extend([&(bytes.len() as u32).to_le_bytes()[..], kind, &bytes].concat());
    }
    files.push(("binary.glb".to_owned(), glb));
    let moment = Moment { animation: "move".to_owned(), start_s: 0.2, duration_s: 0.5 };
    survive("glTF", &files, |name, bytes| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        let _ = gltf::read(&path, Choice { variant: Some("day"), moment: Some(&moment), sandbox: None });
    });
}

#[test]
fn obj_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut files = files_of("scenes/cornell-box", &["obj", "mtl"]);
    files.extend(files_of("scenes/colour-checker", &["mtl"]));
    for (name, bytes) in &files {
        std::fs::write(folder.path().join(name), bytes).expect("written");
    }
    let reads_mtl = |name: &str| format!("mtllib {name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl white\nf 1 2 3\n");
    survive("OBJ", &files, |name, bytes| {
        let path = folder.path().join(format!("damaged-{name}"));
        std::fs::write(&path, bytes).expect("written");
        let obj = if name.ends_with(".mtl") {
            let obj = folder.path().join("reads.obj");
            std::fs::write(&obj, reads_mtl(&format!("damaged-{name}"))).expect("written");
            obj
        } else {
            path
        };
        let _ = obj::read(&obj, MissingNormals::Smooth);
    });
}

#[test]
fn capture_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["cornell-box.obj", "cornell-box.mtl"] {
        std::fs::copy(repository("scenes/cornell-box").join(name), folder.path().join(name)).expect("copied");
    }
    let mut files = files_of("scenes/cornell-box", &["toml"]);
    let readme = std::fs::read_to_string(repository("README.md")).expect("README.md");
    let example = readme.split("```toml").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    let example = example.replace("\"room.glb\", \"vase.obj\"", "\"cornell-box.obj\"");
    // An OBJ file has none.
    let example = example.lines().filter(|line| !line.starts_with("animation")).collect::<Vec<_>>().join("\n");
    files.push(("readme.toml".to_owned(), example.into_bytes()));
    survive("capture", &files, |name, bytes| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        let _ = Capture::load_with(&path, &[]);
    });
}

#[test]
fn dng_files() {
    let mut files = Vec::new();
    for layout in ["RGGB", "mono", "x-trans", "full:RGB"] {
        for compression in
            [DngCompression::None, DngCompression::Packed, DngCompression::LosslessJpeg, DngCompression::Deflate]
        {
            let cfa = Cfa::parse(layout).expect("a layout");
            let (width, height) = (37, 23);
            let count = width * height * cfa.samples_per_pixel();
            let data = (0..count as u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 20) as u16).collect();
            let raw = RawImage { width, height, data, cfa, bits: 12, white_level_dn: 4000, ..RawImage::default() };
            let mut bytes = Cursor::new(Vec::new());
            if write_compressed_dng(&raw, compression, &mut bytes).is_ok() {
                files.push((format!("{layout} {compression:?}"), bytes.into_inner()));
            }
        }
    }
    assert!(files.len() > 4);
    survive("DNG", &files, |_, bytes| {
        let _ = read_dng(Cursor::new(bytes));
    });
}

#[test]
fn files_of_numbers() {
    let numbers: Vec<u16> = (0..37 * 23 * 3u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 16) as u16).collect();
    let raw = RawImage { width: 37, height: 23, data: numbers[..37 * 23].to_vec(), ..RawImage::default() };
    let mut tiff = Cursor::new(Vec::new());
    write_tiff(&raw, &mut tiff).expect("written");
    // The same file with half as many bits.
    let mut narrow = tiff.get_ref().clone();
    let bits = narrow.windows(12).position(|entry| entry[..8] == [2, 1, 3, 0, 1, 0, 0, 0]).expect("BitsPerSample");
    narrow[bits + 8] = 8;
    assert_eq!(read_tiff(Cursor::new(&narrow)).expect("8 bits").bits, 8);
    let mut files = vec![("16-bit TIFF".to_owned(), tiff.into_inner()), ("8-bit TIFF".to_owned(), narrow)];
    let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_be_bytes()).collect();
    let words = numbers.iter().map(u16::to_string).collect::<Vec<_>>().join(" ");
    let bits = words.replace(|c: char| c.is_ascii_digit() && c != '1', "0");
    for (kind, pixels) in [
        ("P1\n37 23\n", bits.as_bytes()),
        ("P2\n# grey\n37 23\n65535\n", words.as_bytes()),
        ("P3\n37 23\n65535\n", words.as_bytes()),
        ("P4\n37 23\n", &bytes),
        ("P5\n37 23\n255\n", &bytes),
        ("P6\n37 23\n4095\n", &bytes),
    ] {
        let file = [kind.as_bytes(), pixels].concat();
        read_pnm(&file[..]).expect(kind);
        files.push((kind[..2].to_owned(), file));
    }
    survive("numbers", &files, |name, bytes| {
        let read = if name.ends_with("TIFF") { read_tiff(Cursor::new(bytes)) } else { read_pnm(bytes) };
        if let Ok(raw) = read {
            raw.validate().expect("whole");
        }
    });
}

#[test]
fn descriptors_of_image_sets() {
    let good = b"\xef\xbb\xbf# public\r\nv 4.0\r\nn 12 640 480\r\nb 000.00 000.35\r\ni a\\b.tif\r\ni c.tif\r\nd 0\r\ni d\r\ni e\r\n";
    survive("descriptor", &[("descriptor".to_owned(), good.to_vec())], |_, bytes| {
        let _ = Descriptor::parse(&String::from_utf8_lossy(bytes));
    });
}
