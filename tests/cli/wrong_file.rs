//! Files of one kind that are given to a command for another: the error says which command takes them.

use rstest::rstest;

use crate::dataset::{BOARD, sky};
use crate::folder::Folder;

fn folder() -> Folder {
    let sensor = include_str!("../../crates/photosite-sensor/assets/sensors/sony-imx249-mono.toml");
    Folder::new([
        ("board.toml", BOARD.into()),
        ("set.toml", b"capture = 'board.toml'\nframes = 1\n".to_vec()),
        ("sensor.toml", sensor.into()),
        ("model.glb", crate::gltf::triangle().binary()),
        ("raw.dng", b"II*\0".to_vec()),
        ("raw.npy", b"\x93NUMPY".to_vec()),
        ("picture.png", b"\x89PNG".to_vec()),
        ("sky.hdr", sky(1)),
        ("capture.json", b"{}".to_vec()),
        ("named.toml", b"[sensor]\npreset = 'board.toml'\n".to_vec()),
    ])
}

#[rstest]
#[case::data_set("render set.toml", "set.toml: is a data set file", "photosite dataset")]
#[case::sensor("render sensor.toml", "sensor.toml: is a sensor file", "[sensor] preset = \"sensor.toml\"")]
#[case::raw("render raw.dng", "raw.dng: is a raw file", "photosite develop")]
#[case::numbers("render raw.npy", "is a raw file, or an image", "photosite develop")]
#[case::image("render picture.png", "is an image", "photosite expose` takes it with --unit")]
#[case::light("render sky.hdr", "is an image of light", "photosite expose")]
#[case::of_camera("camera set.toml --format opencv", "is a data set file", "photosite dataset")]
#[case::of_mitsuba("export-mitsuba set.toml -o x", "is a data set file", "photosite dataset")]
#[case::of_info("info set.toml", "is a data set file", "photosite dataset")]
#[case::capture("dataset board.toml", "board.toml: is a capture file", "photosite render")]
#[case::sensor_of_set("dataset sensor.toml", "is a sensor file", "[sensor] preset = \"sensor.toml\"")]
#[case::model("dataset model.glb", "is a scene", "capture = \"model.glb\"")]
#[case::report("dataset capture.json", "is the report of a render", "photosite render")]
#[case::raw_of_set("dataset raw.dng", "is a raw file", "photosite develop")]
#[case::folder("dataset .", "is a folder", "data set file (.toml)")]
#[case::exposed_capture("expose board.toml", "is a capture file", "photosite render")]
#[case::exposed_set("expose set.toml", "is a data set file", "photosite dataset")]
#[case::exposed_raw("expose raw.dng", "is a raw file", "photosite develop")]
#[case::exposed_model("expose model.glb", "is a scene", "photosite render")]
#[case::developed_capture("develop board.toml", "is a capture file", "photosite render")]
#[case::developed_set("develop set.toml", "is a data set file", "photosite dataset")]
#[case::developed_model("develop model.glb", "is a scene", "photosite render")]
#[case::measured_capture("emva1288 board.toml", "board.toml: is a capture file", "photosite render")]
#[case::measured_set("emva1288 set.toml", "is a data set file", "photosite dataset")]
#[case::preset("render named.toml", "named.toml:2: sensor.preset: board.toml is a capture file", "photosite render")]
fn the_command_that_takes_it_is_named(#[case] arguments: &str, #[case] message: &str, #[case] help: &str) {
    folder().fail(arguments, 1, &[message, help]);
}

#[test]
fn files_of_the_right_kind_are_taken() {
    let folder = folder();
    for arguments in ["info board.toml", "info model.glb", "dataset set.toml -o out --quiet"] {
        folder.succeed(arguments);
    }
    // What a name alone does not decide is read.
    for arguments in ["develop raw.npy", "develop picture.png", "develop raw.dng", "expose sky.hdr"] {
        let outcome = folder.run(arguments);
        assert!(!outcome.stderr.contains("is expected here"), "{arguments}: {}", outcome.stderr);
    }
}
