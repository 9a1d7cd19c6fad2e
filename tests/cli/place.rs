//! Objects that get other places in each frame of a data set.

use std::collections::BTreeSet;

use rstest::rstest;
use serde_json::Value;

use crate::dataset::{BOARD, manifest};
use crate::folder::Folder;
use crate::kept_scenes::assert_same_however_made;

/// A block of 0.2 × 0.1 × 0.12 m around its origin.
const BLOCK: &str = "\
v -.1 -.05 -.06\nv .1 -.05 -.06\nv .1 -.05 .06\nv -.1 -.05 .06\nv -.1 .05 -.06\nv .1 .05 -.06\nv .1 .05 .06\nv -.1 .05 .06
f 1 2 3 4\nf 5 8 7 6\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";

fn placed(place: &str) -> Folder {
    let scene = "\
[scene]
ground = { height_m = -0.3 }
[[scene.objects]]
file = 'block.obj'
name = 'table'
position_m = [0, -0.3, 0]
scale = [4, 1, 4]
";
    let light = "environment = { illuminant = 'D65', illuminance_lux = 500 }\n";
    let capture =
        BOARD.replace(light, "").replace("[scene]\n", &scene.replace("[scene]\n", &format!("[scene]\n{light}")));
    let capture = capture + "truth = ['depth', 'instance']\nobjects = true\n";
    Folder::new([
        ("block.obj", BLOCK.into()),
        ("base.toml", capture.into()),
        ("set.toml", format!("capture = 'base.toml'\nframes = 3\nseed = 7\n{place}").into()),
    ])
}

const DROPPED: &str = "\
[[place]]
objects = ['block.obj']
count = [2, 4]
category = 'part'
method = 'drop'
surface = 'table'
scale = [0.4, 0.8]
[[place]]
objects = ['block.obj']
count = 2
method = 'box'
category = 'distractor'
region = { min_m = [-0.4, 0.3, -0.4], max_m = [0.4, 0.6, 0.4] }
rotation = 'any'
";

#[test]
fn a_frame_is_the_same_alone_at_once_and_from_its_manifest() {
    let folder = placed(DROPPED);
    assert_same_however_made(&folder, 3);
    let lines = manifest(&folder, "together");
    assert_eq!(lines.iter().map(|line| line["overrides"].to_string()).collect::<BTreeSet<_>>().len(), 3);
    // What stands in the manifest makes the image again.
    let mut command = folder.command("render base.toml -o again --quiet --set output.electrons=false");
    for change in lines[1]["overrides"].as_array().expect("a list") {
        command.arg("--set").arg(change.as_str().expect("a text"));
    }
    assert!(command.status().expect("the binary runs").success());
    for file in ["raw.dng", "truth.exr", "objects.json"] {
        let read = |path: &str| std::fs::read(folder.path(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
        assert!(read(&format!("again/{file}")) == read(&format!("together/camera/000001/{file}")), "{file}");
    }
}

/// Lowest height of the box of each placed object, which for a block is its own, with its category.
fn lowest(folder: &Folder, image: &str) -> Vec<(String, f64)> {
    let objects = folder.json(&format!("{image}/objects.json"));
    let placed = objects["objects"].as_array().expect("a list").iter().filter(|o| o["name"] != "table");
    let of_object = |object: &Value| {
        let corners = object["box_corners_world_m"].as_array().expect("corners");
        let lowest = corners.iter().map(|corner| corner[1].as_f64().expect("a number")).fold(f64::INFINITY, f64::min);
        (object["category"].as_str()?.to_owned(), lowest).into()
    };
    placed.filter_map(of_object).collect()
}

#[rstest]
#[case::rest("method = 'rest'\nregion = { min_m = [-1, 0, -1], max_m = [1, 0, 1] }", -0.3)]
#[case::rest_on_the_table("method = 'rest'\nsurface = 'table'", -0.25)]
#[case::one_dropped("method = 'drop'\nsurface = 'table'\nscale = [0.5, 0.5]", -0.25)]
fn single_objects_touch_what_they_stand_on(#[case] keys: &str, #[case] height_m: f64) {
    let folder = placed(&format!("[[place]]\nobjects = ['block.obj']\n{keys}\n"));
    folder.succeed("dataset set.toml -o out");
    for frame in 0..3 {
        let found = lowest(&folder, &format!("out/camera/00000{frame}"));
        assert_eq!(found.len(), 1, "{found:?}");
        // At rest means a gap of at most 0.1 mm, and no overlap.
        let gap = found[0].1 - height_m;
        assert!((-1e-5..=1e-4).contains(&gap), "{keys}: {gap} m above");
    }
}

/// The block is twice as long as high; the unit of its file does not matter.
#[rstest]
#[case("size_m = 0.05", [0.05, 0.05])]
#[case("size_m = 0.05\nmeters_per_unit = 0.001", [0.05, 0.05])]
#[case("size_m = [0.05, 0.1]", [0.05, 0.1])]
fn sizes_are_those_of_the_longest_side(#[case] keys: &str, #[case] range_m: [f64; 2]) {
    let [least, most] = range_m;
    let region = "region = { min_m = [-0.4, 0.3, -0.4], max_m = [0.4, 0.6, 0.4] }";
    let folder = placed(&format!("[[place]]\nobjects = ['block.obj']\ncount = 2\nmethod = 'box'\n{region}\n{keys}\n"));
    folder.succeed("dataset set.toml -o out");
    let objects = folder.json("out/camera/000000/objects.json");
    let placed: Vec<&Value> = objects["objects"]
        .as_array()
        .expect("a list")
        .iter()
        .filter(|o| o["category"] == "block" && o["name"] != "table")
        .collect();
    assert_eq!(placed.len(), 2, "{objects}");
    for object in placed {
        let corner = |i: usize| -> [f64; 3] {
            serde_json::from_value(object["box_corners_world_m"][i].clone()).expect("a corner")
        };
        let length = corner(0).iter().zip(corner(1)).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        // Corners of single precision
        assert!((least * (1.0 - 1e-6)..=most * (1.0 + 1e-6)).contains(&length), "{length} m");
    }
}

#[rstest]
#[case::two_sizes(
    "objects = ['block.obj']\nmethod = 'rest'\nscale = [1, 2]\nsize_m = 1",
    "cannot be combined with size_m"
)]
#[case::no_size("objects = ['block.obj']\nmethod = 'rest'\nsize_m = 0", "must be a length, or two, above 0")]
#[case::sizes_in_disorder("objects = ['block.obj']\nmethod = 'rest'\nsize_m = [2, 1]", "must be a length, or two,")]
#[case::no_file("objects = ['none-*.obj']\nmethod = 'rest'", "place[0].objects")]
#[case::no_surface("objects = ['block.obj']\nmethod = 'drop'\nsurface = 'tabel'", "table")]
#[case::too_many(
    "objects = ['block.obj']\ncount = 60\nmethod = 'box'\nregion = { min_m = [0, 0, 0], max_m = [0.1, 0.1, 0.1] }",
    "place[0]"
)]
#[case::no_method("objects = ['block.obj']\nmethod = 'throw'", "throw")]
fn what_cannot_be_placed_is_an_error_of_its_key(#[case] keys: &str, #[case] message: &str) {
    let folder = placed(&format!("[[place]]\n{keys}\n"));
    let output = folder.command("dataset set.toml -o out").output().expect("the binary runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains(message) && errors.contains("set.toml") && !errors.contains("panicked"), "{errors}");
}
