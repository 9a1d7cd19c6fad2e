//! Rectified images: whole or not at all, with their truth; depth from disparity and back.

use rstest::rstest;
use serde_json::Value;

use crate::dataset::BOARD;
use crate::folder::Folder;

const SET: &str = "\
capture = 'board.toml'
frames = 2
[[cameras]]
name = 'left'
[[cameras]]
name = 'right'
position_m = [0.1, 0.01, 0]
look_at_m = [0.05, 0, -1]
";

/// A folder with a data set in `out`, made with these arguments.
fn made(dataset: &str, arguments: &str) -> Folder {
    let board = BOARD.replace("max_depth = 2", "max_depth = 1");
    let folder = Folder::new([("board.toml", board.into()), ("set.toml", dataset.into())]);
    folder.succeed(&format!("dataset set.toml -o out --quiet {arguments}"));
    folder
}

#[test]
fn images_truth_and_lines_are_made_and_the_data_set_left_as_it_is() {
    let folder = made(SET, "--set output.truth=['depth','normal']");
    let before = folder.results("out/left/000000");
    let report = folder.succeed("rectify out -o rectified --lines 3 --frames 1 --json").json();
    assert_eq!(report["frames"], serde_json::json!([1]));
    assert_eq!(report["truth"], true);
    for file in [
        "left/000001/image.png",
        "left/000001/truth.exr",
        "right/000001/image.png",
        "right/000001/truth.exr",
        "epipolar/000001-original.png",
        "epipolar/000001-rectified.png",
        "stereo.yaml",
        "rectify.json",
    ] {
        assert!(folder.path("rectified").join(file).is_file(), "{file} of {:?}", folder.contents().keys());
    }
    assert!(!folder.path("rectified/left/000000").exists());
    assert_eq!(before, folder.results("out/left/000000"));
    folder.fail("rectify out -o rectified", 2, &["rectified is not empty", "-o"]);

    let truth = "rectified/left/000001/truth.exr";
    folder.succeed(&format!("depth {truth} --channel disparity --rectified rectified -o z.exr --quiet"));
    folder.succeed("depth z.exr --rectified rectified --inverse -o d.exr --quiet");
    let plane = |path: &str, name: &str| {
        let file = std::fs::File::open(folder.path(path)).expect(path);
        let planes = photosite::io::exr::read_exr(std::io::BufReader::new(file)).expect("EXR").planes;
        planes.plane(name).expect(name).to_vec()
    };
    let is_close = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| a == b || (a - b).abs() <= 1e-6 * b.abs());
    assert!(is_close(&plane("z.exr", "depth"), &plane(truth, "depth")));
    let disparity = plane(truth, "disparity");
    assert!(is_close(&plane("d.exr", "disparity"), &disparity) && disparity.iter().any(|&d| d > 0.0));
}

#[test]
fn a_pair_of_three_is_chosen() {
    let third = format!("{SET}[[cameras]]\nname = 'below'\nposition_m = [0, -0.1, 0]\n");
    let folder = made(&third, "");
    folder.fail("rectify out -o rectified", 2, &["has the cameras left, right, below", "--pair left,right"]);
    folder.fail("rectify out -o rectified --pair left,other", 2, &["has no camera other"]);
    folder.fail("rectify out -o rectified --pair left,left", 2, &["names left twice"]);
    folder.fail("rectify out -o rectified --pair left,right --frames 7", 2, &["names none of the frames 0..2"]);
    let report = folder.succeed("rectify out -o rectified --pair left,below --json").json();
    assert_eq!((&report["is_vertical"], &report["truth"]), (&Value::Bool(true), &Value::Bool(false)));
}

#[rstest]
#[case("map.exr --rectified nowhere -o z.exr", 1, &["nowhere/rectify.json: cannot read"])]
#[case("map.exr --focal-length-px 0 --baseline-m 1 -o z.exr", 2, &["--focal-length-px: 0 is not above 0"])]
#[case("map.exr --focal-length-px 9 --baseline-m 0 -o z.exr", 2, &["--baseline-m: 0 is not a length other than 0"])]
#[case("map.exr --focal-length-px 9 --baseline-m 1 -o z.jpg", 2, &["z.jpg is not the name of a map", ".npy"])]
#[case("map.exr --focal-length-px 9 --baseline-m 1 -o map.exr", 2, &["map.exr already exists", "--force"])]
#[case("map.exr --focal-length-px 9 --baseline-m 1 -o z.exr", 1, &["map.exr: cannot read it as OpenEXR"])]
fn what_cannot_be_turned_into_depth_is_said(#[case] arguments: &str, #[case] status: i32, #[case] wanted: &[&str]) {
    let folder = Folder::new([("map.exr", b"no image".to_vec())]);
    folder.fail(&format!("depth {arguments}"), status, wanted);
}
