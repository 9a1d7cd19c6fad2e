//! Calibration targets: as files, and in front of a camera.

use rstest::rstest;

use crate::folder::Folder;
use crate::room::room;

#[test]
fn a_target_is_printed_photographed_and_handed_on() {
    let folder = Folder::new([]);
    let set = "--set squares=[6,4] --set square_mm=20";
    for file in ["board.svg", "board.pdf", "board.obj", "board.json", "board.toml"] {
        let outcome = folder.succeed(&format!("target chessboard {set} -o {file}"));
        assert_eq!(outcome.stdout, format!("{file}: chessboard, 160 × 120 mm, points: 15\n"));
    }
    assert!(folder.text("board.svg").contains("width=\"160mm\" height=\"120mm\""));
    assert!(folder.bytes("board.pdf").starts_with(b"%PDF-1."));
    folder.fail("target chessboard -o board.svg", 2, &["board.svg already exists", "--force"]);
    folder.fail("target chessboard -o board.obj", 2, &["board.mtl already exists"]);

    // The capture file says the same target, and the image's report where its points are.
    folder.succeed("render board.toml -o out --set render.samples_per_pixel=1 --set sensor.resolution_px=[40,30]");
    let report = folder.report("out");
    let target = &report["targets"][0];
    assert_eq!((&target["name"], &target["target"]["squares"][0]), (&"chessboard".into(), &6.into()));
    assert_eq!(target["points"][6]["xy_mm"], serde_json::json!([20.0, 20.0]));
    // The first inner corner lies two squares left of the middle and one above it.
    let first: Vec<f64> =
        target["points_world_m"][0].as_array().expect("x, y, z").iter().filter_map(|x| x.as_f64()).collect();
    assert!(first.iter().zip([-0.04, 0.02, 0.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{first:?}");
    // Light exposed again still knows its targets.
    folder.succeed("expose out -o again");
    assert_eq!(folder.report("again")["targets"], report["targets"]);
    // The mesh is one that is read.
    folder.succeed("render board.obj -o mesh --set render.samples_per_pixel=1 --set sensor.resolution_px=[40,30]");
}

/// Points are stated in the raw image; the developed one shows them elsewhere where it undoes the distortion.
#[test]
fn an_image_that_shows_the_points_elsewhere_is_warned_of() {
    let folder = Folder::new([]);
    folder.succeed("target chessboard -o board.toml");
    let render =
        "render board.toml -o out --force --spp 1 --size 40x30 --set lens.distortion={model='brown-conrady',k=[-0.1]}";
    let warning = "the points of targets in capture.json are not; write develop.distortion = false";
    let outcome = folder.succeed(render);
    assert!(outcome.stderr.contains(warning), "{}", outcome.stderr);
    let outcome = folder.succeed(&format!("{render} --set develop.distortion=false"));
    assert!(!outcome.stderr.contains(warning), "{}", outcome.stderr);
}

#[rstest]
#[case::kind("target chesboard -o a.svg", 2, "a similar value exists: 'chessboard'")]
#[case::format("target flat -o a.png", 2, "a.png does not tell which format")]
#[case::key("target flat -o a.svg --set sze_mm=3", 1, "unknown key `sze_mm` in [target]; did you mean `size_mm`?")]
#[case::value(
    "target charuco -o a.svg --set marker_mm=40",
    1,
    "marker_mm: 40 mm does not fit into the square of 30 mm"
)]
#[case::page("target flat -o a.pdf --set size_mm=[6000,10]", 1, "a.pdf: 6.00 m is longer than a PDF page can be")]
#[case::folder("target flat -o no/a.svg", 1, "no: does not exist, or is not a folder")]
fn wrong_targets_are_told(#[case] arguments: &str, #[case] status: i32, #[case] message: &str) {
    Folder::new([]).fail(arguments, status, &[message]);
}

#[rstest]
#[case::no_type("squares = [2, 3]", "targets[0]: the key `type` is missing")]
#[case::unknown_type("type = 'chesboard'", "targets[0].type: unknown value \"chesboard\"; did you mean `chessboard`?")]
#[case::placement_key(
    "type = 'flat'\npositon_m = [0, 0, 0]",
    "unknown key `positon_m` in [targets[0]]; did you mean `position_m`?"
)]
#[case::size("type = 'chessboard'\nsquare_mm = -3", "capture.toml:3: targets[0].square_mm: -3 mm cannot be made")]
#[case::pose("type = 'flat'\nlook_at_m = [0, 0, 0]", "targets[0].look_at_m: is where the target stands")]
#[case::up("type = 'flat'\nup = [0, 0, 1]", "targets[0].up: the target faces along [0, 0, 1]")]
#[case::far("type = 'flat'\nposition_m = [1e30, 0, 0]", "targets[0].position_m: lies farther out than")]
#[case::twice("type = 'flat'\n[[targets]]\ntype = 'flat'", "targets[1]: there is already a target \"flat\"")]
#[case::material(
    "type = 'flat'\n[materials.flat-shet]\ntype = 'diffuse'\nreflectance = 1",
    "did you mean `flat-sheet`?"
)]
fn wrong_targets_of_captures_are_told(#[case] table: &str, #[case] message: &str) {
    let folder = Folder::new([("capture.toml", format!("[[targets]]\n{table}\n").into_bytes())]);
    folder.fail("render capture.toml", 1, &[message]);
}

/// Each point of a target is a few lines of the report: some 18 MB for three large ones.
#[test]
fn a_report_of_a_hundred_thousand_points_is_read_again() {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    let target = |i: u32| {
        format!(
            "[[targets]]\ntype = \"chessboard\"\nname = \"t{i}\"\nsquares = [200, 200]\nsquare_mm = 0.1\n\
             position_m = [0, 0, 0.{i}]\n"
        )
    };
    let capture = folder.text("capture.toml");
    folder.add("capture.toml", capture + &[1, 2, 3].map(target).concat());
    folder.succeed("render capture.toml -o out");
    assert!(std::fs::metadata(folder.path("out/capture.json")).expect("a report").len() > 16 << 20);
    folder.succeed("expose out -o again");
    folder.succeed("info out/capture.json");
}
