//! Scenes that images of a data set share are made once, which changes none of their bytes, whatever varies, and
//! however many are made at once.

use std::collections::BTreeSet;
use std::fs;
use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

use rstest::rstest;
use serde_json::Value;

use crate::dataset::{BOARD, board_under_sky, files, folder, manifest, sky};
use crate::folder::Folder;

/// Variations of all that decides whether something can be kept: scene, lights, materials, targets, sensor, lens,
/// exposure, development, output.
#[rstest]
#[case::exposure("exposure.time_s", "[0.002, 0.004]")]
#[case::light_of_scene("scene.environment.illuminance_lux", "[300, 500]")]
#[case::target("targets.0.square_mm", "[25, 30]")]
#[case::lens("lens.f_number", "[4, 5.6]")]
#[case::focal_length("lens.focal_length_mm", "[6, 5.5]")]
#[case::transmittance("lens.transmittance", "[0.9, 0.5]")]
#[case::sensor("sensor.preset", "['sony-imx249-mono', 'generic-cmos-color']")]
#[case::mosaic("sensor.cfa", "['GRBG', 'RGGB']")]
#[case::pixels("sensor.resolution_px", "[[32, 24], [24, 24]]")]
#[case::serial("sensor.serial", "[7, 9]")]
#[case::samples("render.samples_per_pixel", "[1, 2]")]
#[case::development("develop.exposure_ev", "[0, 1]")]
#[case::truth("output.truth", "[['depth'], ['flow']]")]
#[case::object("scene.objects.0.position_m", "[[0, 0, 0], [0, 0, 0.05]]")]
#[case::object_turned("scene.objects.1.rotation_deg", "[[0, 0, 0], [0, 30, 0]]")]
#[case::object_of_another_file("scene.objects.1.file", "['cube.obj', 'tile.obj']")]
#[case::object_of_another_material("scene.objects.0.material", "['red', 'lamp']")]
#[case::object_visible("scene.objects.1.visible", "[true, false]")]
#[case::material("materials.red.reflectance", "[0.2, 0.6]")]
#[case::material_that_shines("materials.lamp.emission.luminance_nit", "[100, 2000]")]
fn images_are_those_of_a_process_of_their_own(#[case] key: &str, #[case] choice: &str) {
    let preset = if key == "sensor.cfa" { "set = ['sensor.preset=generic-cmos-color']\n" } else { "" };
    let folder = folder(&format!(
        "{preset}frames = 5\nseed = 2\n[poses.random]\ntarget = 'board'\ndistance_m = [0.7, 1.2]\nmargin_px = 1\n\
         [[vary]]\nkey = '{key}'\nchoice = {choice}\n"
    ));
    if !key.starts_with("targets") {
        add_objects(&folder);
    }
    assert_same_however_made(&folder, 5);
    let values: BTreeSet<String> =
        manifest(&folder, "together").iter().map(|line| line["overrides"].to_string()).collect();
    assert!(values.len() >= 2, "{key} varies");
}

/// Makes a set of so many frames in one process, several images at once, and each frame in a process of its own: all
/// files must be the same. They are in `together` then.
pub(crate) fn assert_same_however_made(folder: &Folder, frames: u32) {
    folder.succeed("dataset set.toml -o together --jobs 1");
    folder.succeed("dataset set.toml -o at-once --jobs 3 --threads 2");
    for frame in (0..frames).rev() {
        folder.succeed(&format!("dataset set.toml -o apart --frames {frame}"));
    }
    let of = |name: &str| {
        let mut files = files(folder, name);
        // Folders that are empty by now say nothing.
        files.retain(|_, bytes| bytes.is_some());
        files
    };
    let together = of("together");
    for other in ["apart", "at-once"] {
        let found = of(other);
        let names = together.keys().chain(found.keys());
        let differ: BTreeSet<_> = names.filter(|name| together.get(*name) != found.get(*name)).collect();
        assert_eq!(differ, BTreeSet::new(), "{other}");
    }
}

/// Objects of two files before the board; a shared one, one with a material of its own, and one that no pose moves.
fn add_objects(folder: &Folder) {
    let cube = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    folder.add("cube.obj", cube);
    folder.add("tile.obj", "v 0 0 0\nv .1 0 0\nv .1 .1 0\nv 0 .1 0\nvn 0 0 1\nf 1//1 2//1 3//1 4//1\n");
    let objects = "
        [[scene.objects]]
        file = 'cube.obj'
        position_m = [0.02, 0.01, 0.03]
        material = 'red'
        [[scene.objects]]
        file = 'cube.obj'
        position_m = [-0.1, 0, 0.02]
        scale = [1, 0.5, 2]
        [[scene.objects]]
        file = 'tile.obj'
        [[scene.objects]]
        file = 'tile.obj'
        material = 'lamp'
        visible = false
        [materials.red]
        type = 'diffuse'
        reflectance = 0.3
        [materials.lamp]
        type = 'diffuse'
        reflectance = 0
        emission = { illuminant = 'D65', luminance_nit = 500 }";
    let board = folder.text("board.toml");
    folder.add("board.toml", format!("{board}{objects}"));
}

#[test]
fn a_file_that_changes_while_images_are_made_of_it_is_noticed() {
    let folder = Folder::new([
        ("board.toml", board_under_sky().into()),
        ("sky.hdr", sky(100)),
        ("set.toml", "capture = 'board.toml'\nframes = 2\n".into()),
    ]);
    let command = "dataset set.toml -o out --quiet --jobs 1 --set render.samples_per_pixel=20000";
    let process = folder.command(command).stderr(Stdio::piped()).spawn().expect("the binary runs");
    // It has begun the first image.
    while !folder.path("out/camera").exists() || fs::read_dir(folder.path("out/camera")).expect("a folder").count() < 2
    {
        sleep(Duration::from_millis(1));
    }
    folder.add("sky.hdr", sky(120));
    let output = process.wait_with_output().expect("it ends");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("sky.hdr") && errors.contains("has changed while images were made of it"), "{errors}");
    // Another process finds another data set.
    folder.fail("dataset set.toml -o out", 2, &["contains another data set"]);
}

#[test]
fn lines_of_json_tell_of_each_image() {
    let folder = folder("frames = 3\n[[cameras]]\nname = 'a'\n[[cameras]]\nname = 'b'\nposition_m = [0.1, 0, 0]\n");
    folder.succeed("dataset set.toml -o out --frames 1");
    let outcome = folder.succeed("dataset set.toml -o out --json --jobs 2");
    let lines: Vec<Value> = outcome.stdout.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let (end, images) = lines.split_last().expect("lines");
    assert_eq!(images.len(), 4);
    for (i, line) in images.iter().enumerate() {
        assert_eq!(
            (&line["event"], &line["made"], line["done"].as_u64()),
            (&"picture".into(), &true.into(), Some(i as u64 + 1))
        );
        assert_eq!(line["of"], 4);
        assert!(line["seconds"].as_f64().is_some_and(|s| s > 0.0));
        let name = line["folder"].as_str().expect("a name");
        let frame = line["frame"].as_u64().expect("a number");
        assert_eq!(name, format!("{}/{frame:06}", line["camera"].as_str().expect("a name")));
        assert!(folder.path("out").join(name).join("capture.json").exists());
    }
    assert_eq!(
        (&end["event"], &end["made"], &end["present"], &end["complete"]),
        (&"end".into(), &4.into(), &6.into(), &true.into())
    );
    let again = folder.succeed("dataset set.toml -o out --json").stdout;
    assert_eq!(again.lines().count(), 1, "{again}");
}

#[rstest]
#[case::usual("", &["capture.json", "image.png", "raw.dng"])]
#[case::electrons(" --set output.electrons=true", &["capture.json", "electrons.exr", "image.png", "raw.dng"])]
#[case::raw_and_truth(" --set output.image=false --set output.truth=['depth']", &["capture.json", "raw.dng", "truth.exr"])]
fn a_frame_keeps_what_is_asked_for(#[case] arguments: &str, #[case] wanted: &[&str]) {
    let board = BOARD.replace("electrons = false\n", "");
    let folder =
        Folder::new([("board.toml", board.into()), ("set.toml", "capture = 'board.toml'\nframes = 1\n".into())]);
    folder.succeed(&format!("dataset set.toml -o out{arguments}"));
    let results = folder.results("out/camera/000000");
    assert_eq!(results.keys().map(String::as_str).collect::<Vec<_>>(), wanted);
    // What is said of the image stands for itself: rendered again from that, it is the same.
    folder.succeed("render out/camera/000000/capture.json -o again");
    let again = folder.results("again");
    assert_eq!(again.keys().collect::<Vec<_>>(), results.keys().collect::<Vec<_>>());
    assert!(again["raw.dng"] == results["raw.dng"]);
}

#[test]
fn images_without_image_png_have_no_image_in_their_report() {
    let folder = Folder::new([("board.toml", BOARD.into())]);
    folder.succeed("render board.toml -o out --set output.image=false");
    assert!(folder.report("out")["image"].is_null());
    folder.fail("layout out --format colmap -o laid", 1, &["manifest.jsonl"]);
}
