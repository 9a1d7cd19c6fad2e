//! Pixels that are no plain grid, from the capture to the image: hexagonal cells, a round image area, the samples of a
//! frame grabber, a gain that follows the light.

use rstest::rstest;
use serde_json::Value;

use crate::dataset::BOARD;
use crate::folder::Folder;

fn folder(sensor: &str, rest: &str) -> Folder {
    let capture = BOARD
        .replace("pixel_pitch_um = [200, 200]\n", &format!("{sensor}\n"))
        .replace("[output]\n", &format!("{rest}\n[output]\n"))
        .replace("electrons = false\n", "");
    Folder::new([("board.toml", capture.into())])
}

const HEXAGONS: &str = "pixel_pitch_um = [200, 173.2]\ncells = 'hexagonal'";

#[test]
fn hexagons_become_square_pixels_in_the_image_and_from_the_file() {
    let folder = folder(HEXAGONS, "");
    let told = folder.succeed("render board.toml -o out").text();
    assert!(told.contains("CFALayout") && !told.contains("not regular"), "{told}");
    let raw = folder.raw("out/raw.dng");
    assert!(raw.metadata.is_staggered);
    assert_eq!([raw.width, raw.height], [32, 24]);
    folder.succeed("develop out/raw.dng -o again.png");
    let [of_render, of_file] = ["out/image.png", "again.png"].map(|name| folder.bytes(name));
    assert!(of_render == of_file);
    // 32 pitches of 200 on square pixels of 173.2.
    assert_eq!(folder.report("out")["image"]["resolution_px"], serde_json::json!([37, 24]));
    let regular = "sensor.pixel_pitch_um=[200,200]";
    let told = folder.succeed(&format!("render board.toml --set {regular} -o other")).text();
    assert!(told.contains("not regular") && told.contains("[200, 173.2051]"), "{told}");
}

#[rstest]
#[case::camera("camera board.toml --format opencv", "sensor.cells: camera formats")]
#[case::binning(
    "render board.toml --set exposure.binning=[2,2] -o x",
    "exposure.binning: cannot be combined with sensor.cells"
)]
#[case::odd_row("render board.toml --set exposure.region_px=[0,1,8,8] -o x", "exposure.region_px: row 1 is one of")]
#[case::smoothing("render board.toml --set develop.noise_filter=median -o x", "develop.noise_filter: works on rows")]
#[case::stored("expose out --set sensor.cells=rectangular -o x", "sensor.cells: cells of this shape")]
#[case::edge("measure mtf out/raw.dng", "raw.dng: has the staggered rows of hexagonal cells")]
#[case::across("render board.toml --set sensor.crosstalk=[[0.1],[0.8],[0.1]] -o x", "sensor.crosstalk: reaches over")]
fn what_needs_columns_is_refused(#[case] command: &str, #[case] message: &str) {
    let folder = folder(HEXAGONS, "");
    folder.succeed("render board.toml -o out --quiet");
    folder.fail(command, 1, &[message]);
}

#[test]
fn beyond_the_image_circle_there_is_nothing() {
    let folder = folder("pixel_pitch_um = [200, 200]\nimage_circle_mm = 3.2", "");
    folder.succeed(
        "render board.toml --set output.truth=[\'depth\'] --set output.truth_formats=[\'npy\'] -o out --quiet",
    );
    let file = folder.bytes("out/electrons.exr");
    let planes = photosite::io::exr::read_exr(std::io::Cursor::new(file)).expect("EXR").planes;
    // 16 pixels across about 16, 12.
    let is_lit = |i: usize| {
        (i % 32).abs_diff(15) < 20 && {
            let (x, y) = ((i % 32) as f64 - 15.5, (i / 32) as f64 - 11.5);
            x * x + y * y <= 64.0
        }
    };
    let data = &planes.channels()[0].data;
    assert!((0..data.len()).all(|i| (data[i] > 0.0) == is_lit(i)));
    folder.fail(
        "expose out --set sensor.image_circle_mm=4 -o x",
        1,
        &["sensor.image_circle_mm: the image was rendered"],
    );
    folder.succeed("expose out --set sensor.image_circle_mm=2 -o y --quiet");
}

/// Test of a pinhole of 6 mm: f is 6/0.2 = 30 pixels, and 24 columns and 36 rows of samples are ¾ and 3/2 of the pixels.
#[test]
fn the_camera_of_the_image_is_that_of_the_samples() {
    let folder = folder("pixel_pitch_um = [200, 200]\nframe_grabber.size_px = [24, 36]", "");
    folder.succeed("render board.toml --set develop.square_pixels=false -o out --quiet");
    let report = folder.report("out");
    let near = |of: &str, axis: usize, wanted: f64| {
        let found = report[of]["camera_matrix"][axis][axis].as_f64().expect("a number");
        assert!((found / wanted - 1.0).abs() < 1e-12, "{of} {axis}: {found}");
    };
    for (of, axis, f) in [("camera", 0, 30.0), ("camera", 1, 30.0), ("image", 0, 22.5), ("image", 1, 45.0)] {
        near(of, axis, f);
    }
    // The middle of 24 columns is 11.5 where whole numbers are centres.
    assert_eq!(report["image"]["camera_matrix"][0][2], 11.5);
    assert_eq!(report["image"]["pixel_aspect"], 2.0);
    assert_eq!(report["sensor"]["resolution_px"], serde_json::json!([24, 36]));
    // (200·32/24) × (200·24/36).
    assert_eq!(report["sensor"]["pixel_pitch_um"], serde_json::json!([266.667, 133.333]));
    folder.fail(
        "expose out --set exposure.region_px=[0,0,8,8] -o x",
        1,
        &["exposure.region_px: cannot be combined with"],
    );
}

#[test]
fn gain_control_follows_the_light_from_frame_to_frame() {
    let control = "gain_control = { target = 0.3, attack = 0.5 }";
    let folder = folder("pixel_pitch_um = [200, 200]", "");
    folder.add("agc.toml", BOARD.replace("time_s = 0.004\n", &format!("time_s = 2e-6\nframes = 8\n{control}\n")));
    folder.succeed("render agc.toml --set output.electrons=true -o out --quiet");
    let gains = |name: &str| -> Vec<f64> {
        let gains = folder.report(name)["exposure"]["frame_gains_db"].clone();
        serde_json::from_value(gains).expect("a list of numbers")
    };
    let found = gains("out");
    assert_eq!((found.len(), found[0]), (8, 0.0));
    // Each error is half of that before: so are the steps. Shot noise of 768 pixels moves each.
    for n in 1..6 {
        let [step, next] = [found[n] - found[n - 1], found[n + 1] - found[n]];
        assert!(step > 0.0 && (next - 0.5 * step).abs() < 0.15, "{found:?}");
    }
    let iso = |n: usize| folder.raw(&format!("out/raw-{n:04}.dng")).metadata.iso.expect("known");
    assert!(iso(7) > 2 * iso(0), "{found:?}");
    folder.succeed("expose out -o again --quiet");
    assert_eq!(gains("again"), found);
    let told = folder.succeed("render agc.toml --set exposure.frames=1 -o one").text();
    assert!(told.contains("exposure.gain_control: acts from one image"), "{told}");
}

#[test]
fn formats_have_names_and_pitches() {
    let folder = Folder::new([]);
    let rows = folder.succeed("sensors --formats 4000x3000 --json").json();
    let row = |name: &str| {
        let has = |row: &&Value| row["names"].as_array().is_some_and(|names| names.iter().any(|known| known == name));
        rows.as_array().expect("rows").iter().find(has).expect("known").clone()
    };
    assert_eq!(row("1/3.2")["pixel_pitch_um"], serde_json::json!([1.135, 1.14]));
    assert_eq!(row("full-frame")["diagonal_mm"], 43.27);
    assert_eq!(folder.succeed("sensors --formats").stdout.lines().count(), rows.as_array().expect("rows").len() + 1);
    folder.fail("sensors --formats many", 2, &["--formats: \"many\" is not a number of columns and rows", "1920x1200"]);
}
