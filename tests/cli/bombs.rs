//! Files that say little and mean much: what is packed in them takes no more memory than an image of their kind may.

use std::io::Write;
use std::process::Command;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use image::{DynamicImage, ImageFormat, RgbImage};

use crate::folder::Folder;
use crate::room::encoded;

/// So many zeros, packed.
fn packed(bytes: usize) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    let zeros = vec![0; 1 << 20];
    (0..bytes >> 20).for_each(|_| encoder.write_all(&zeros).expect("packed"));
    encoder.finish().expect("packed")
}

fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let sum = crc32fast::hash(&[&kind[..], data].concat());
    [&(data.len() as u32).to_be_bytes()[..], kind, data, &sum.to_be_bytes()].concat()
}

/// An image of 4 × 4 pixels with a chunk more behind its header.
fn png_with(more: &[u8]) -> Vec<u8> {
    let png = encoded(&DynamicImage::ImageRgb8(RgbImage::new(4, 4)), ImageFormat::Png);
    // The signature of 8 bytes and IHDR of 25.
    let (header, rest) = png.split_at(33);
    [header, more, rest].concat()
}

/// Runs a command that may take 400 MB of address space.
fn limited(folder: &Folder, arguments: &str) -> (Option<i32>, String) {
    let shell = format!("ulimit -v 400000; exec {} {arguments}", env!("CARGO_BIN_EXE_photosite"));
    let output = Command::new("sh").args(["-c", &shell]).current_dir(folder.path("")).output().expect("sh");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn profiles_and_texts_of_a_gigabyte_are_not_unpacked() {
    let gigabyte = packed(1 << 30);
    assert!(gigabyte.len() < 2 << 20, "{} bytes", gigabyte.len());
    let profile = chunk(b"iCCP", &[b"bomb\0\0", &gigabyte[..]].concat());
    let text = chunk(b"zTXt", &[b"bomb\0\0", &gigabyte[..]].concat());
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";
    let folder = Folder::new([("a.obj", obj.into()), ("a.mtl", "newmtl a\nmap_Kd profile.png\n".into())]);
    folder.add("profile.png", png_with(&profile));
    folder.add("text.png", png_with(&text));
    for command in
        ["info a.obj", "measure histogram profile.png", "compare profile.png text.png", "measure histogram text.png"]
    {
        let (status, error) = limited(&folder, command);
        assert_eq!(status, Some(0), "{command}: {error}");
    }
}

/// Headers that promise more pixels than the bytes behind them can hold.
#[test]
fn headers_of_more_pixels_than_the_file_holds_are_refused() {
    let mut png = encoded(&DynamicImage::ImageRgb8(RgbImage::new(4, 4)), ImageFormat::Png);
    let header = [&30_000u32.to_be_bytes()[..], &30_000u32.to_be_bytes(), &[8, 2, 0, 0, 0]].concat();
    png.splice(8..33, chunk(b"IHDR", &header));
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 30000 +X 30000\n".to_vec();
    let folder = Folder::new([("large.png", png), ("large.hdr", hdr)]);
    folder.add("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n");
    folder.add("a.mtl", "newmtl a\nmap_Kd large.png\n");
    folder.add(
        "sky.toml",
        "[scene]\ngeometry = ['b.obj']\nenvironment = { image = 'large.hdr', illuminance_lux = 500 }\n",
    );
    folder.add("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (command, file) in [
        ("info a.obj", "large.png"),
        ("info sky.toml", "large.hdr"),
        ("measure histogram large.png", "large.png"),
        ("compare large.png large.png", "large.png"),
    ] {
        folder.fail(command, 1, &[file, "cannot hold 30000 × 30000 pixels"]);
    }
}

/// Nested in whatever way, also where the parser recovers from an error.
#[test]
fn texts_that_nest_without_end_are_refused() {
    let folder = Folder::new([]);
    folder.add("recovering.toml", "a={b,c{d=1}\n".repeat(20_000));
    folder.add("dots.toml", "a.".repeat(100_000));
    folder.add("lists.toml", format!("a = {}", "[".repeat(100_000)));
    folder.add("lists.json", "[".repeat(100_000));
    for name in ["recovering.toml", "dots.toml", "lists.toml", "lists.json"] {
        for command in ["info", "render -o o", "dataset -o d", "lens", "emva1288 -o e", "view"] {
            let outcome = folder.run(&format!("{command} {name}"));
            assert!(matches!(outcome.status, Some(1 | 2)), "{command} {name}: {:?} {}", outcome.status, outcome.stderr);
            assert!(outcome.stderr.len() < 2000, "{command} {name}: {} bytes", outcome.stderr.len());
        }
    }
}

/// Content of files is quoted by its beginning.
#[test]
fn messages_do_not_repeat_long_words() {
    let word = "w".repeat(100_000);
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
    let files = [
        ("a.stl", format!("solid a\nfacet {word}\n")),
        ("a.ply", format!("ply\nformat ascii 1.0\n{word}\n")),
        ("a.obj", obj.to_owned()),
        ("a.mtl", format!("newmtl x\nKd {word} 0 0\n")),
        ("b.obj", obj.replace("mtllib a.mtl", &format!("mtllib {word}"))),
        ("c.obj", obj.replace("usemtl a", &format!("usemtl {word}")).replace("1 2 3", "1 2 9")),
        ("d.txt", format!("v 4.0\n{word}\n")),
        ("x.zmx", format!("{word} 1\n")),
        ("key.toml", format!("[scene]\n{word} = 1\n")),
        ("value.toml", format!("[scene]\ngeometry = ['{word}']\n")),
        ("type.toml", format!("[scene]\ngeometry = ['a.obj']\n[materials.a]\ntype = '{word}'\n")),
        ("set.toml", format!("capture = '{word}'\nframes = 1\n")),
        ("a.gltf", format!("{{\"asset\": {{\"version\": \"{word}\"}}}}")),
    ];
    let folder = Folder::new(files.map(|(name, text)| (name, text.into())));
    for command in [
        "info a.stl",
        "info a.ply",
        "info a.obj",
        "info b.obj",
        "info c.obj",
        "emva1288-report d.txt",
        "lens x.zmx",
        "render key.toml -o o",
        "render value.toml -o o",
        "render type.toml -o o",
        "dataset set.toml -o o",
        "info a.gltf",
    ] {
        let outcome = folder.run(command);
        assert!(outcome.stderr.len() < 5000, "{command}: {} bytes: {:.600}", outcome.stderr.len(), outcome.stderr);
    }
}
