//! Every position of a file on the command line and in a capture, and every kind of file that is wrong there: one error that
//! names the file and says in plain words what is expected, and nothing is left behind.

use rstest::rstest;

use crate::dataset::{BOARD, sky};
use crate::folder::Folder;

/// Kinds of files; what is missing has the ending that a position wants.
const FILES: [&str; 14] = [
    "folder",
    "empty.txt",
    "text.txt",
    "bytes.bin",
    "table.csv",
    "board.toml",
    "set.toml",
    "sensor.toml",
    "lens.toml",
    "model.glb",
    "raw.dng",
    "picture.png",
    "sky.hdr",
    "capture.json",
];

fn folder() -> Folder {
    let sensor = include_str!("../../crates/photosite-sensor/assets/sensors/sony-imx249-mono.toml");
    let folder = Folder::new([
        ("empty.txt", Vec::new()),
        ("text.txt", b"hello world\n".to_vec()),
        ("bytes.bin", vec![0x89, 0, 1, 2, 0xff, 0xfe, b'\n', 7]),
        ("table.csv", b"wavelength_nm,value\n400,0.5\n700,0.6\n".to_vec()),
        ("board.toml", BOARD.into()),
        ("plain.toml", BOARD.replace("type = 'pinhole'\n", "").into()),
        ("set.toml", b"capture = 'board.toml'\nframes = 1\n".to_vec()),
        ("sensor.toml", sensor.into()),
        ("model.glb", crate::gltf::triangle().binary()),
        ("raw.dng", b"II*\0\x08\0\0\0\xff\x02".to_vec()),
        ("picture.png", b"\x89PNG\r\n\x1a\n".to_vec()),
        ("sky.hdr", sky(100)),
        ("capture.json", b"{}".to_vec()),
    ]);
    std::fs::create_dir(folder.path("folder")).expect("made");
    folder.succeed("lens double-gauss -o lens.toml --quiet");
    folder
}

/// Words of programmers, not of users.
const INTERNAL: [&str; 9] = ["Some(", "None", "Ok(", "Err(", "\\u{", "ErrorKind", "Os {", "unwrap", "panicked"];

/// Help, or words that say by themselves what must be different.
const TELLING: [&str; 5] = ["help: ", "cannot read", "cannot decode", "is not valid TOML", "is not an IES file"];

/// The command with `FILE` where the file is, the ending of a missing one, and files that are right there.
#[rstest]
#[case::render("render FILE -o x", "toml", &["board.toml", "model.glb"])]
#[case::expose("expose FILE -o x", "exr", &[])]
#[case::expose_with_unit("expose FILE --unit electrons -o x", "exr", &["sky.hdr"])]
#[case::develop("develop FILE -o x.png", "dng", &["sky.hdr"])]
#[case::merge("merge FILE -o x", "part", &[])]
#[case::merge_hdr("merge-hdr FILE FILE -o x.exr", "dng", &[])]
#[case::info("info FILE", "toml", &["board.toml", "sensor.toml", "model.glb", "sky.hdr"])]
#[case::lens("lens FILE", "zmx", &["lens.toml"])]
#[case::camera("camera FILE --format opencv", "toml", &["board.toml", "model.glb"])]
#[case::dataset("dataset FILE -o x", "toml", &["set.toml"])]
#[case::status("status FILE", "folder", &[])]
#[case::layout("layout FILE --format coco -o x", "folder", &[])]
#[case::rectify("rectify FILE -o x", "folder", &[])]
#[case::compare("compare FILE sky.hdr", "png", &["sky.hdr"])]
#[case::mtf("measure mtf FILE", "png", &["sky.hdr"])]
#[case::histogram("measure histogram FILE", "png", &["sky.hdr"])]
#[case::similarity("measure similarity sky.hdr FILE", "png", &["sky.hdr"])]
#[case::checker("measure checker sky.hdr --capture FILE", "toml", &["board.toml", "model.glb"])]
#[case::noise("noise FILE", "png", &["sky.hdr"])]
#[case::emva1288("emva1288 FILE -o x", "toml", &["sensor.toml"])]
#[case::emva1288_report("emva1288-report FILE", "txt", &[])]
#[case::fit("fit FILE -o x", "txt", &[])]
#[case::mitsuba("export-mitsuba FILE -o x", "toml", &["board.toml", "model.glb"])]
#[case::init("init FILE", "glb", &["model.glb"])]
#[case::geometry("render board.toml -o x --set scene.geometry=[\"FILE\"]", "glb", &["model.glb"])]
#[case::surroundings(
    "render board.toml -o x --set scene.environment={image=\"FILE\",nit_per_unit=1}", "hdr", &["sky.hdr"]
)]
#[case::preset("render board.toml -o x --set sensor.preset=\"FILE\"", "toml", &["sensor.toml"])]
#[case::prescription(
    "render plain.toml -o x --set lens={prescription=\"FILE\"}", "zmx", &["lens.toml"]
)]
#[case::transmittance("render board.toml -o x --set sensor.filter.transmittance={file=\"FILE\"}", "csv", &["table.csv"])]
#[case::profile(
    "render board.toml -o x --set lights=[{type=\"profile\",file=\"FILE\",position_m=[0,1,0]}]", "ies", &[]
)]
fn what_is_expected_is_said_in_plain_words(#[case] command: &str, #[case] ending: &str, #[case] right: &[&str]) {
    let folder = folder();
    let missing = format!("gone.{ending}");
    let mut bad = Vec::new();
    for file in FILES.iter().copied().filter(|file| !right.contains(file)).chain([&*missing]) {
        let before = folder.contents();
        let arguments = command.replace("FILE", file);
        let outcome = folder.run(&arguments);
        let text = outcome.text();
        let stem = file.split('.').next().unwrap_or(file);
        let mut wrong = Vec::new();
        if !matches!(outcome.status, Some(1 | 2)) || !outcome.stdout.is_empty() {
            wrong.push(format!("ends with {:?}", outcome.status));
        }
        if !text.contains(stem) {
            wrong.push("the file is not named".to_owned());
        }
        if !TELLING.iter().any(|words| text.contains(words)) {
            wrong.push("no help".to_owned());
        }
        wrong.extend(INTERNAL.iter().filter(|word| text.contains(**word)).map(|word| format!("says {word:?}")));
        if outcome.stderr.chars().any(|c| c.is_control() && c != '\n') {
            wrong.push("control characters".to_owned());
        }
        if folder.contents() != before {
            wrong.push("something is left behind".to_owned());
        }
        if !wrong.is_empty() {
            bad.push(format!("{arguments}: {}\n{}", wrong.join(", "), outcome.stderr));
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

/// Kind of a file that is certainly of another kind, which the message names.
#[rstest]
#[case::lens_as_capture("render lens.toml", "lens.toml: is a lens file", "photosite lens")]
#[case::lens_of_info("info lens.toml", "lens.toml: is a lens file", "photosite lens")]
#[case::lens_as_set("dataset lens.toml -o x", "lens.toml: is a lens file", "photosite lens")]
#[case::lens_as_sensor(
    "render board.toml -o x --set sensor.preset=\"lens.toml\"",
    "sensor.preset: lens.toml is a lens file",
    "photosite lens"
)]
#[case::capture_as_lens("lens board.toml", "board.toml: is a capture file, and a lens file", "photosite render")]
#[case::capture_as_prescription(
    "render plain.toml -o x --set lens.prescription=\"board.toml\"",
    "board.toml is a capture file",
    "photosite render"
)]
#[case::image_as_sensor(
    "render board.toml -o x --set sensor.preset=\"picture.png\"",
    "sensor.preset: picture.png is an image",
    "expose"
)]
#[case::folder_as_geometry(
    "render board.toml -o x --set scene.geometry=[\"folder\"]",
    "folder is a folder",
    ".gltf, .glb, .obj"
)]
#[case::raw_as_descriptor("emva1288-report raw.dng", "raw.dng: is a raw file, and a folder of image sets", "develop")]
fn the_kind_is_said(#[case] arguments: &str, #[case] message: &str, #[case] help: &str) {
    folder().fail(arguments, 1, &[message, help]);
}
