//! Data sets: rigs, poses, changes from frame to frame; that none is lost, made twice or mixed with another.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::thread::sleep;
use std::time::Duration;

use rstest::rstest;
use serde_json::Value;

use crate::folder::Folder;

/// A chessboard before a small camera.
pub(crate) const BOARD: &str = "\
[scene]
environment = { illuminant = 'D65', illuminance_lux = 500 }
[[targets]]
type = 'chessboard'
name = 'board'
squares = [9, 6]
square_mm = 30
[camera]
position_m = [0, 0, 0.6]
look_at_m = [0, 0, 0]
[lens]
type = 'pinhole'
f_number = 4
focal_length_mm = 6
focus_distance_m = 'infinity'
[sensor]
preset = 'sony-imx249-mono'
resolution_px = [32, 24]
pixel_pitch_um = [200, 200]
[exposure]
time_s = 0.004
[render]
samples_per_pixel = 1
max_depth = 2
[output]
electrons = false
";

/// The same under a sky that a file holds.
pub(crate) fn board_under_sky() -> String {
    BOARD.replace("illuminant = 'D65', illuminance_lux = 500", "image = 'sky.hdr', nit_per_unit = 100")
}

/// An image of the sky, grey of that value.
pub(crate) fn sky(value: u8) -> Vec<u8> {
    let mut file = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    file.extend([value, value, value, 129].repeat(8));
    file
}

pub(crate) fn folder(dataset: &str) -> Folder {
    Folder::new([("board.toml", BOARD.into()), ("set.toml", format!("capture = 'board.toml'\n{dataset}").into())])
}

/// All files below a folder, by their path in it.
pub(crate) fn files(folder: &Folder, name: &str) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
    let root = folder.path(name);
    let below = |(path, bytes): (PathBuf, _)| path.strip_prefix(&root).ok().map(|path| (path.to_owned(), bytes));
    folder.contents().into_iter().filter_map(below).collect()
}

pub(crate) fn manifest(folder: &Folder, name: &str) -> Vec<Value> {
    let text = std::fs::read_to_string(folder.path(name).join("manifest.jsonl")).expect("a manifest");
    text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

const STEREO: &str = "\
frames = 6
seed = 3
[[cameras]]
name = 'left'
disparity_to = 'right'
[[cameras]]
name = 'right'
position_m = [0.1, 0, 0]
disparity_to = 'left'
set = ['exposure.gain_db=6']
[poses.random]
target = 'board'
distance_m = [0.6, 0.9]
margin_px = 1
[[vary]]
key = 'exposure.time_s'
log_uniform = [0.002, 0.006]
[[vary]]
key = 'exposure.temperature_c'
sweep = [20, 45]
";

#[test]
fn a_rig_takes_images_from_many_poses() {
    let folder = folder(STEREO);
    let outcome = folder
        .succeed("dataset set.toml -o out --set output.truth=['disparity','depth'] --set lens.focal_length_mm=5.5");
    assert!(outcome.stderr.contains("made 12 images; 12 of 12"), "{}", outcome.stderr);
    let lines = manifest(&folder, "out");
    assert_eq!(lines.len(), 12);
    for (i, line) in lines.iter().enumerate() {
        let (frame, camera) = (i / 2, ["left", "right"][i % 2]);
        assert_eq!((line["frame"].as_u64(), line["camera"].as_str()), (Some(frame as u64), Some(camera)));
        let report = folder.report(&format!("out/{camera}/{frame:06}"));
        assert_eq!(report["exposure"]["temperature_c"], 20.0 + 5.0 * frame as f64);
        assert_eq!(report["exposure"]["gain_db"], [0.0, 6.0][i % 2]);
        let time = report["exposure"]["time_s"].as_f64().expect("a number");
        assert!((0.002..0.006).contains(&time));
        assert_eq!(report["exposure"]["time_s"], lines[i ^ 1]["exposure"]["time_s"], "the same for the whole rig");
        assert!(report["timings"].is_null() && report["paths_per_s"].is_null());
        let visible = report["targets"][0]["points_visible"].as_array().expect("a list");
        assert!(visible.iter().all(|v| v == true), "frame {frame} {camera}: {visible:?}");
        // The right camera is 0.1 m to the right of the left one: x_right = x_left − 0.1 in their common axes.
        let t = |line: &Value, axis: usize| line["pose"]["translation_m"][axis].as_f64().expect("a number");
        let offset = [0, 1, 2].map(|axis| t(&lines[2 * frame + 1], axis) - t(&lines[2 * frame], axis));
        assert!((offset[0] + 0.1).abs() < 1e-12 && offset[1].abs() < 1e-12 && offset[2].abs() < 1e-12, "{offset:?}");
    }
    let seeds: std::collections::BTreeSet<_> = lines.iter().map(|line| line["seed"].as_u64()).collect();
    assert_eq!(seeds.len(), 12, "every image has noise of its own");
}

#[test]
fn disparity_leads_to_where_the_partner_sees_the_corners() {
    let folder = folder(STEREO);
    folder.succeed("dataset set.toml -o out --frames 0..2 --set output.truth=['disparity']");
    for frame in 0..2 {
        let report = |camera: &str| folder.report(&format!("out/{camera}/{frame:06}"));
        let px =
            |report: &Value, i: usize, axis: usize| report["targets"][0]["points_px"][i][axis].as_f64().expect("px");
        let results = folder.results(&format!("out/left/{frame:06}"));
        let truth = photosite::io::exr::read_exr(std::io::Cursor::new(&results["truth.exr"])).expect("EXR").planes;
        let (left, right) = (report("left"), report("right"));
        let count = left["targets"][0]["points_px"].as_array().expect("a list").len();
        assert_eq!(count, 8 * 5);
        for i in 0..count {
            // The board is flat, so that disparity is linear over it: within a pixel it differs from that of the corner
            // by no more than from one pixel to the next.
            let pixel = (px(&left, i, 1).round() * 32.0 + px(&left, i, 0).round()) as usize;
            let d = truth.plane("disparity.X").expect("a plane");
            let (here, slope) = (
                f64::from(d[pixel]),
                f64::from((d[pixel + 1] - d[pixel - 1]).abs()).max(f64::from((d[pixel + 32] - d[pixel - 32]).abs())),
            );
            let corner = px(&left, i, 0) - px(&right, i, 0);
            assert!((here - corner).abs() <= slope + 1e-3, "{frame} {i}: {here}, {corner} ± {slope}");
        }
    }
}

#[test]
fn frames_made_apart_are_those_made_together() {
    let folder = folder(STEREO);
    folder.succeed("dataset set.toml -o whole --threads 2");
    let first = folder.succeed("dataset set.toml -o parts --frames 4..6 --threads 1");
    assert!(first.stderr.contains("made 4 images; 4 of 12"), "{}", first.stderr);
    folder.succeed("dataset set.toml -o parts --frames 0..5");
    assert_eq!(files(&folder, "whole"), files(&folder, "parts"));
    let again = folder.succeed("dataset set.toml -o parts");
    assert!(again.stderr.contains("made 0 images; 12 of 12"), "{}", again.stderr);
    assert_eq!(files(&folder, "whole"), files(&folder, "parts"));
}

/// Each run makes some images before it is killed, at another place each time.
#[test]
fn a_set_that_is_killed_again_and_again_ends_as_one_that_is_not() {
    let folder = folder("frames = 20\n[poses.random]\ntarget = 'board'\ndistance_m = [0.6, 0.9]\nmargin_px = 1\n");
    folder.succeed("dataset set.toml -o whole");
    for round in 1..=2 {
        for point in ["picture-begun", "pass-ended", "file-written", "file-named", "picture-complete"] {
            assert!(folder.killed_at(point, round, "dataset set.toml -o killed --quiet"), "{point} {round}");
        }
    }
    folder.succeed("dataset set.toml -o killed --quiet");
    assert!(files(&folder, "whole") == files(&folder, "killed"));
}

/// Taken away while the set is made, `dataset.json` is written again with the manifest.
#[test]
fn a_set_that_loses_its_description_has_it_again_in_the_end() {
    let folder = folder("frames = 40\n");
    let mut making =
        folder.command("dataset set.toml -o out --quiet --set render.samples_per_pixel=64").spawn().expect("started");
    while !folder.path("out/camera/000000").exists() {
        assert_eq!(making.try_wait().expect("a child"), None, "it ends before it begins");
        sleep(Duration::from_millis(1));
    }
    fs::remove_file(folder.path("out/dataset.json")).expect("removed");
    assert!(making.wait().expect("a child").success());
    folder.succeed("status out");
    folder.succeed("dataset set.toml -o out --quiet --verify --set render.samples_per_pixel=64");
}

#[test]
fn a_longer_set_goes_on_where_a_shorter_one_ended() {
    let folder = folder("frames = 2\n[poses.random]\nlook_at_m = [0, 0, 0]\ndistance_m = [0.6, 0.9]\n");
    folder.succeed("dataset set.toml -o out");
    let longer = "capture = 'board.toml'\nframes = 3\n[poses.random]\nlook_at_m = [0, 0, 0]\ndistance_m = [0.6, 0.9]\n";
    folder.add("set.toml", longer);
    let outcome = folder.succeed("dataset set.toml -o out");
    assert!(outcome.stderr.contains("made 1 image; 3 of 3"), "{}", outcome.stderr);
}

#[test]
fn images_of_two_sets_are_not_mixed() {
    let folder = folder("frames = 1\n");
    folder.succeed("dataset set.toml -o out");
    folder.fail(
        "dataset set.toml -o out --set exposure.gain_db=3",
        2,
        &["contains another data set: its overrides say", "-o"],
    );
    folder.add("set.toml", "capture = 'board.toml'\nframes = 1\nseed = 2\n");
    folder.fail("dataset set.toml -o out", 2, &["the data set file says something else"]);
    folder.add("set.toml", "capture = 'board.toml'\nframes = 1\n");
    folder.add("board.toml", BOARD.replace("500", "600"));
    folder.fail("dataset set.toml -o out", 2, &["the capture says something else"]);
    folder.add("other/notes.txt", "mine");
    folder.fail("dataset set.toml -o other", 2, &["is not empty and does not contain a data set"]);
}

#[test]
fn a_trajectory_moves_the_rig_while_it_records() {
    let poses = "frames = 3\n[poses.trajectory]\nframe_rate_hz = 10\nposes = [\n\
        { time_s = 0, position_m = [0, 0, 1], look_at_m = [0, 0, 0] },\n\
        { time_s = 1, position_m = [1, 0, 1], look_at_m = [1, 0, 0] } ]\n";
    let folder = folder(poses);
    folder.succeed("dataset set.toml -o out --set output.truth=['flow','depth']");
    let lines = manifest(&folder, "out");
    assert_eq!(lines.iter().map(|line| line["time_s"].as_f64()).collect::<Vec<_>>(), [Some(0.0), Some(0.1), Some(0.2)]);
    let results = folder.results("out/camera/000001");
    let truth = photosite::io::exr::read_exr(std::io::Cursor::new(&results["truth.exr"])).expect("EXR").planes;
    let (flow, depth) = (truth.plane("flow.X").expect("flow"), truth.plane("depth").expect("depth"));
    // 1 m/s at 10 Hz with f = 30 px: things go to the left by 30·0.1/z.
    for (flow, depth) in flow.iter().zip(depth).filter(|(_, depth)| depth.is_finite()) {
        assert!((flow + 3.0 / depth).abs() < 1e-4, "{flow} at {depth} m");
    }
}

#[test]
fn a_trajectory_zooms() {
    let poses = "frames = 3\n[poses.trajectory]\nframe_rate_hz = 2\nmoving = false\nposes = [\n\
        { time_s = 0, position_m = [0, 0, 1], look_at_m = [0, 0, 0], focal_length_mm = 10 },\n\
        { time_s = 1, position_m = [0, 0, 1], look_at_m = [0, 0, 0], focal_length_mm = 20 } ]\n";
    let folder = folder(poses);
    folder.succeed("dataset set.toml -o out");
    let focal_length = |frame: u32| {
        let report = folder.report(&format!("out/camera/00000{frame}"));
        report["lens"]["focal_length_mm"].as_f64().expect("a number")
    };
    assert_eq!([0, 1, 2].map(focal_length), [10.0, 15.0, 20.0]);
    folder.add("set.toml", format!("capture = 'board.toml'\n{poses}"));
    let matrix = "lens.intrinsics={fx=30,fy=30,cx=9,cy=9}";
    folder.fail(
        &format!("dataset set.toml -o other --set {matrix}"),
        1,
        &["lens.intrinsics: states the camera matrix"],
    );
    folder.add("set.toml", format!("capture = 'board.toml'\n{}", poses.replace(", focal_length_mm = 20", "")));
    folder.fail("dataset set.toml -o other", 1, &["poses[1].focal_length_mm: missing, where poses[0] has one"]);
}

#[rstest]
#[case::no_capture("", "the key `capture` is missing")]
#[case::unknown_key("capture = 'board.toml'\nframe = 3\n", "set.toml:2: frame: unknown key")]
#[case::no_such_target(
    "capture = 'board.toml'\n[poses.random]\ntarget = 'bord'\ndistance_m = [1, 2]\n",
    "set.toml:3: poses.random.target: the capture has no target \"bord\""
)]
#[case::too_near(
    "capture = 'board.toml'\n[poses.random]\ntarget = 'board'\ndistance_m = [0.1, 0.2]\n",
    "poses.random.distance_m: in none of 1000 views"
)]
#[case::two_laws(
    "capture = 'board.toml'\n[[vary]]\nkey = 'exposure.time_s'\nuniform = [1, 2]\nsweep = [1, 2]\n",
    "set.toml:5: vary[0].sweep: cannot be combined with uniform"
)]
#[case::two_kinds(
    "capture = 'board.toml'\n[poses]\nlist = []\n[poses.grid]\ndistance_m = [1]\n",
    "cannot be combined with list"
)]
#[case::name(
    "capture = 'board.toml'\n[[cameras]]\nname = 'a/b'\n",
    "set.toml:3: cameras[0].name: \"a/b\" is not a name for a folder"
)]
#[case::twins(
    "capture = 'board.toml'\n[[cameras]]\nname = 'a'\n[[cameras]]\nname = 'A'\n",
    "two cameras are called \"A\""
)]
#[case::partner(
    "capture = 'board.toml'\n[[cameras]]\nname = 'a'\ndisparity_to = 'b'\n",
    "the rig has no other camera \"b\""
)]
#[case::series(
    "capture = 'board.toml'\nset = ['exposure.frames=2']\n",
    "exposure.frames: a data set makes its own series"
)]
#[case::time(
    "capture = 'board.toml'\nset = ['render.time_limit_s=2']\n",
    "render.time_limit_s: would make another data set"
)]
#[case::bad_key("capture = 'board.toml'\n[[vary]]\nkey = 'exposure.tim_s'\nuniform = [1, 2]\n", "unknown key `tim_s`")]
fn errors_name_file_key_and_line(#[case] dataset: &str, #[case] message: &str) {
    let folder = Folder::new([("board.toml", BOARD.into()), ("set.toml", dataset.into())]);
    let outcome = folder.run("dataset set.toml -o out");
    assert_eq!(outcome.status, Some(1), "{}", outcome.stderr);
    assert!(outcome.text().contains(message), "{message:?} is missing in: {}", outcome.stderr);
    assert!(!folder.path("out").exists(), "nothing is left behind");
}

/// Errors of what a data set file asks for name its key, the frame and the camera, in a few lines.
#[rstest]
#[case::variation(
    "frames = 2\nseed = 1\n[[vary]]\nkey = 'exposure.gain_db'\nuniform = [90, 91]\n",
    &["set.toml:4: vary[0]: in frame 0: exposure.gain_db: 90.", "dB is not among the gains"]
)]
#[case::misspelt("[[vary]]\nkey = 'lens.f_numbr'\nuniform = [2, 4]\n", &["set.toml:2: vary[0]", "did you mean `f_number`?"])]
#[case::change("set = ['render.samples_per_pixel=2', 'exposure.gain_db=90']\n", &["set.toml:2: set[1]: exposure.gain_db: 90 dB"])]
#[case::no_value("set = ['exposure.gain_db']\n", &["set.toml:2: set[0]: there is no value"])]
#[case::camera(
    "[[cameras]]\nname = 'left'\n[[cameras]]\nname = 'right'\nset = ['exposure.gain_db=90']\n",
    &["set.toml:6: cameras[1].set[0]: of camera right: exposure.gain_db: 90 dB"]
)]
#[case::trajectory(
    "set = ['exposure.auto=true']\n[poses.trajectory]\nframe_rate_hz = 10\nposes = [\n\
     { time_s = 0, position_m = [0, 0, 0.6], look_at_m = [0, 0, 0] },\n\
     { time_s = 1, position_m = [0.1, 0, 0.6], look_at_m = [0, 0, 0] }]\n",
    &["set.toml:3: poses.trajectory: in frame 0: camera.motion: needs an exposure time"]
)]
fn errors_of_changes_name_what_asks_for_them(#[case] dataset: &str, #[case] wanted: &[&str]) {
    let outcome = folder(dataset).fail("dataset set.toml", 1, wanted);
    assert!(outcome.stderr.len() < 1000 && !outcome.stderr.contains("--set"), "{}", outcome.stderr);
}

/// Errors of values that the command line gives name the command line.
#[test]
fn errors_of_arguments_name_them() {
    let long = format!("lens.psf.kernel=[{}]", "0.125,".repeat(200));
    let outcome =
        folder("").fail(&format!("dataset set.toml --set {long}"), 1, &["--set lens.psf.kernel=[0.125,", "…"]);
    assert!(outcome.stderr.len() < 1500, "{}", outcome.stderr);
    folder("").fail("dataset set.toml --set exposure.gain_db=90", 1, &["--set exposure.gain_db=90: exposure.gain_db"]);
}
