//! Data sets laid out for other tools: whole or not at all, and what cannot be laid out is said.

use rstest::rstest;

use crate::dataset::BOARD;
use crate::folder::Folder;

const SET: &str = "\
capture = 'board.toml'
frames = 3
[[cameras]]
name = 'left'
[[cameras]]
name = 'right'
position_m = [0.1, 0, 0]
[poses.random]
target = 'board'
distance_m = [0.6, 0.9]
margin_px = 1
";

/// A folder with a data set file, of which nothing is made.
fn described(dataset: &str) -> Folder {
    // Large enough for its corners to be told apart, without light from one part to another.
    let board = BOARD.replace("[9, 6]", "[5, 4]").replace("max_depth = 2", "max_depth = 1");
    Folder::new([("board.toml", board.into()), ("set.toml", dataset.into())])
}

/// A folder with a data set in `out`, made with these arguments.
fn made(dataset: &str, arguments: &str) -> Folder {
    let folder = described(dataset);
    folder.succeed(&format!("dataset set.toml -o out --quiet {arguments}"));
    folder
}

#[rstest]
#[case("colmap", &["images/left/000000.png", "images/right/000002.png", "sparse/0/cameras.txt", "sparse/0/images.txt", "sparse/0/points3D.txt"])]
#[case("euroc", &["mav0/body.yaml", "mav0/cam1/data/1000000002000000000.png", "mav0/cam1/data.csv", "mav0/cam1/sensor.yaml", "mav0/state_groundtruth_estimate0/data.csv"])]
#[case("kalibr", &["cam0/1000000000000000000.png", "cam1/1000000002000000000.png", "camchain.yaml", "target-board.yaml"])]
#[case("bop", &["train/000001/gray/000002.png", "train/000001/depth/000002.png", "train/000001/mask/000002_000000.png", "train/000001/mask_visib/000002_000000.png", "train/000001/scene_gt.json", "models/obj_000001.ply", "models/models_info.json"])]
#[case("nerfstudio", &["images/right-000001.png", "depths/left-000002.npy", "transforms.json"])]
#[case("coco", &["images/right/000001.png", "annotations/instances.json"])]
fn every_layout_is_made_and_the_data_set_left_as_it_is(#[case] format: &str, #[case] files: &[&str]) {
    let folder = made(SET, "--set output.truth=['depth','instance']");
    std::fs::create_dir(folder.path("laid")).expect("an empty folder is no hindrance");
    let before = folder.results("out/left/000000");
    let outcome = folder.succeed(&format!("layout out --format {format} -o laid"));
    assert!(outcome.stderr.contains("laid out 6 images in laid"), "{}", outcome.stderr);
    for file in files {
        assert!(folder.path("laid").join(file).is_file(), "{file} of {:?}", folder.contents().keys());
    }
    assert_eq!(before, folder.results("out/left/000000"));
    folder.fail(&format!("layout out --format {format} -o laid"), 2, &["laid is not empty", "-o"]);
    // The folder can be moved: nothing in it leads back.
    std::fs::rename(folder.path("out"), folder.path("moved")).expect("moved");
    folder.succeed(&format!("layout moved --format {format} -o again --quiet"));
    assert_eq!(
        std::fs::read(folder.path("laid").join(files[0])).expect("a file"),
        std::fs::read(folder.path("again").join(files[0])).expect("a file")
    );
}

#[test]
fn a_part_of_a_data_set_is_refused() {
    let folder = made(SET, "--frames 0..2");
    let wanted = ["manifest.jsonl: 4 of 6 images exist", "the command that makes the data set again"];
    folder.fail("layout out --format colmap -o laid", 1, &wanted);
    folder.succeed("dataset set.toml -o out --quiet");
    folder.succeed("layout out --format colmap -o laid --quiet");
}

#[test]
fn ground_truth_that_a_layout_needs_is_asked_for() {
    let folder = made(SET, "");
    let wanted = ["truth.exr: is missing", "output.truth = [\"instance\"]", "truth_formats = [\"exr\"]"];
    folder.fail("layout out --format coco -o laid", 1, &wanted);
    let folder = made(SET, "--set output.truth=['instance']");
    folder.fail(
        "layout out --format bop -o laid",
        1,
        &["has no layer depth", "output.truth = [\"depth\", \"instance\"]"],
    );
    // Half-way through, all of it goes again.
    std::fs::remove_file(folder.path("out/right/000002/truth.exr")).expect("removed");
    folder.fail("layout out --format coco -o laid", 1, &["out/right/000002/truth.exr: is missing"]);
}

#[rstest]
#[case::zoom(
    "[[vary]]\nkey = 'lens.focal_length_mm'\nsweep = [5, 6]\n",
    "",
    "kalibr",
    &["the lens of left in frame 1 is not that in frame 0", "colmap"]
)]
#[case::distortion(
    "",
    "--set lens.distortion={model='brown-conrady',k=[-0.1,0,0],p=[0,0]}",
    "bop",
    &["BOP files have no model for the brown-conrady lens of left", "without lens.distortion"]
)]
#[case::model(
    "",
    "--set lens.distortion={model='brown-conrady',k=[-0.1,0,0.1],p=[0,0]}",
    "euroc",
    &["EuRoC files have no model for the brown-conrady lens of left"]
)]
fn what_a_layout_has_no_words_for_is_refused(
    #[case] more: &str,
    #[case] arguments: &str,
    #[case] format: &str,
    #[case] wanted: &[&str],
) {
    let folder = made(&format!("{SET}{more}"), &format!("--set output.truth=['depth','instance'] {arguments}"));
    folder.fail(&format!("layout out --format {format} -o laid"), 1, wanted);
    folder.succeed("layout out --format colmap -o laid");
}

#[test]
fn images_show_things_where_ground_truth_has_them() {
    let distortion = "--set lens.distortion={model='brown-conrady',k=[-0.1,0,0],p=[0,0]}";
    let folder = made(SET, distortion);
    // What the raw file says of the lens is not applied.
    folder.succeed("develop out/left/000001/raw.dng -o as-taken.png --quiet --set develop.distortion=false");
    let file = |name: &str| folder.bytes(name);
    assert!(file("as-taken.png") == file("out/left/000001/image.png"));
    let folder = made(SET, &format!("{distortion} --set develop.distortion=true"));
    let wanted = ["capture.develop", "was developed in another size, or without the distortion", "000000/capture.json"];
    folder.fail("layout out --format colmap -o laid", 1, &wanted);
    // Of a lens for which DNG has no words as well.
    let folder = made(SET, "--set lens.distortion={model='division',k=[-0.1]} --set develop.distortion=true");
    folder.fail("layout out --format colmap -o laid", 1, &wanted);
}

/// Whatever changes the pixels, the camera of a layout has those of its images.
#[rstest]
#[case::kept_wide("--set sensor.pixel_pitch_um=[200,150]", [32, 24])]
#[case::squared("--set sensor.pixel_pitch_um=[200,150] --set develop.square_pixels=true", [43, 24])]
#[case::binned("--set exposure.binning=[2,2]", [16, 12])]
#[case::region("--set exposure.region_px=[4,2,24,16]", [24, 16])]
#[case::resized("--set develop.resize_px=[48,40]", [48, 40])]
fn cameras_of_layouts_have_the_pixels_of_their_images(#[case] change: &str, #[case] size: [u32; 2]) {
    let folder = made(SET, change);
    folder.succeed("layout out --format colmap -o laid");
    let image = image::open(folder.path("laid/images/left/000000.png")).expect("an image");
    assert_eq!([image.width(), image.height()], size);
    let cameras = folder.text("laid/sparse/0/cameras.txt");
    let words = format!(" {} {} ", size[0], size[1]);
    assert_eq!(cameras.matches(&words).count(), 2, "{cameras}");
}

/// An object of 0.2 m at x = 0.3 m before a camera 1 m away, with f = 8 mm and pixels of 0.1 mm: a key point at its corner
/// x = 0.4, y = 0.1 lies at 80·0.4 + 47.5 and 23.5 − 80·0.1, from pixel centres.
#[test]
fn key_points_of_objects_are_laid_out_and_missing_ones_are_said() {
    let quad = "v -0.1 -0.1 0\nv 0.1 -0.1 0\nv 0.1 0.1 0\nv -0.1 0.1 0\nf 1 2 3 4\n";
    let capture = "[scene]\nenvironment = { illuminant = 'D65', illuminance_lux = 1000 }\n[[scene.objects]]\nfile = 'quad.obj'\n\
                   position_m = [0.3, 0, 0]\nkeypoints = { corner = [0.1, 0.1, 0] }\n[camera]\nposition_m = [0, 0, 1]\n\
                   look_at_m = [0, 0, 0]\n[lens]\ntype = 'pinhole'\nfocal_length_mm = 8\nf_number = 8\n\
                   focus_distance_m = 'infinity'\n[sensor]\npreset = 'sony-imx249-mono'\nresolution_px = [96, 48]\n\
                   pixel_pitch_um = [100, 100]\n[render]\nsamples_per_pixel = 1\nmax_depth = 2\n[output]\n\
                   truth = ['instance']\nobjects = true\n";
    let set = "capture = 'capture.toml'\nframes = 1\n[[cameras]]\nname = 'cam'\n";
    let folder = Folder::new([("quad.obj", quad.into()), ("capture.toml", capture.into()), ("set.toml", set.into())]);
    let objects = |folder: &Folder, out: &str| folder.json(&format!("{out}/cam/000000/objects.json"));
    folder.succeed("dataset set.toml -o out --quiet");
    folder.succeed("layout out --format coco -o laid");
    let coco = folder.json("laid/annotations/instances.json");
    assert_eq!(coco["categories"][0]["keypoints"], serde_json::json!(["corner"]));
    let points: Vec<f64> = serde_json::from_value(coco["annotations"][0]["keypoints"].clone()).expect("three numbers");
    // Vertices are single precision.
    assert!((points[0] - 79.5).abs() < 1e-3 && (points[1] - 15.5).abs() < 1e-3 && points[2] == 2.0, "{points:?}");
    assert_eq!(objects(&folder, "out")["objects"][0]["is_cut_off"], false);
    // 4 mm hold what lies within 0.25 m of the axis at 1 m.
    folder.succeed("dataset set.toml -o dark --quiet --set sensor.image_circle_mm=4");
    assert_eq!(objects(&folder, "dark")["objects"][0]["is_cut_off"], true);
    folder.succeed("dataset set.toml -o without --quiet --set output.objects=false");
    let outcome = folder.succeed("layout without --format coco -o bare");
    assert!(outcome.text().contains("output.objects = true"), "{}", outcome.stderr);
}

#[test]
fn wrong_usage_says_what_to_write() {
    let folder = Folder::new([("notes/a.txt", "mine".into())]);
    folder.fail("layout notes --format kalbr -o laid", 2, &["'kalbr'", "'kalibr'"]);
    folder.fail("layout notes --format kalibr -o laid", 1, &["notes: has no manifest.jsonl", "photosite dataset"]);
    folder.fail("layout notes --format kalibr -o notes", 2, &["notes is not empty"]);
    folder.fail("layout notes --format kalibr -o notes/a.txt", 2, &["notes/a.txt is a file"]);
    folder.add("notes/manifest.jsonl", "{\"frame\": 0}\n");
    folder.fail("layout notes --format kalibr -o laid", 1, &["manifest.jsonl:1: is damaged", "missing field"]);
}

#[test]
fn calibrations_come_with_the_data_set_where_lenses_keep() {
    let folder = made(SET, "");
    for file in ["opencv/left.yaml", "opencv/right.yaml", "ros/left.yaml", "ros/right.yaml", "camchain.yaml"] {
        assert!(folder.path("out/calibration").join(file).is_file(), "{file}");
    }
    // The first camera's own pose is none: the others' lead from it.
    let text = folder.text("out/calibration/opencv/left.yaml");
    assert!(text.contains("camera_name: \"left\""), "{text}");
    let zoomed = made(&format!("{SET}[[vary]]\nkey = 'lens.focal_length_mm'\nsweep = [5, 6]\n"), "");
    assert!(!zoomed.path("out/calibration").exists());
}

/// Reports have the pose of the middle of the image; earlier ones had that of its start, without saying when it is.
#[test]
fn data_sets_whose_poses_are_of_the_start_are_laid_out_as_before() {
    let poses = "[poses.trajectory]\nframe_rate_hz = 10\nposes = [\n\
        { time_s = 0, position_m = [-0.1, 0, 0.6], look_at_m = [0, 0, 0] },\n\
        { time_s = 1, position_m = [0.3, 0.2, 0.6], look_at_m = [0.1, 0, 0] },\n]\n";
    let set = SET.split("[poses").next().expect("the rig").to_owned() + poses;
    let folder = made(&set, "");
    folder.succeed("layout out --format euroc -o new --quiet");
    for (camera, frame) in ["left", "right"].into_iter().flat_map(|camera| (0..3).map(move |frame| (camera, frame))) {
        let name = format!("out/{camera}/{frame:06}");
        let mut report = folder.report(&name);
        let block = report["camera"].as_object_mut().expect("a table");
        let time = block.shift_remove("pose_time_s").and_then(|time| time.as_f64()).expect("a time");
        let numbers = |value: &serde_json::Value| -> Vec<f64> {
            value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
        };
        // Between poses the camera goes straight; the poses say how it turns.
        let first = numbers(&block["motion"]["poses"][0]["position_m"]);
        let second = numbers(&block["motion"]["poses"][1]["position_m"]);
        let of = |i: usize| block["motion"]["poses"][i]["time_s"].as_f64().expect("a time");
        let part = (0.0 - of(0)) / (of(1) - of(0));
        assert!(time > 0.0, "{time}");
        let start: Vec<f64> = first.iter().zip(&second).map(|(a, b)| a + (b - a) * part).collect();
        block["position_m"] = serde_json::json!(start);
        folder.add(&format!("{name}/capture.json"), serde_json::to_vec(&report).expect("JSON"));
    }
    folder.succeed("layout out --format euroc -o old --quiet");
    let states = |name: &str| {
        let path = folder.path(name).join("mav0/state_groundtruth_estimate0/data.csv");
        std::fs::read_to_string(path).expect("states")
    };
    assert_eq!(states("new"), states("old"));
}

/// The numbers of a matrix of a ROS file.
fn ros_matrix(folder: &Folder, file: &str, key: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(folder.path("out/calibration").join(file)).expect("a file");
    let (_, matrix) = text.split_once(key).expect("the matrix");
    let (numbers, _) = matrix.split_once("data: [").and_then(|(_, rest)| rest.split_once(']')).expect("a list");
    numbers.split(", ").map(|x| x.parse().expect("a number")).collect()
}

#[test]
fn files_of_a_rig_hold_the_rig() {
    let folder = made(SET, "--frames 0..1");
    let (left, right) =
        (ros_matrix(&folder, "ros/left.yaml", "projection"), ros_matrix(&folder, "ros/right.yaml", "projection"));
    // 6 mm on pixels of 200 µm are 30 px, and the cameras stand 0.1 m apart.
    assert!(left[3] == 0.0 && (right[3] + 30.0 * 0.1).abs() < 1e-9, "{left:?} {right:?}");
    let text = folder.text("out/calibration/opencv/stereo/left-right.yaml");
    for key in ["M1", "D1", "M2", "D2", "R", "T", "R1", "R2", "P1", "P2", "Q"] {
        assert!(text.contains(&format!("\n{key}: !!opencv-matrix")), "{key}: {text}");
    }
    // Of three, each pair with the first is rectified by itself; what a format has no words for is said.
    let third = SET.replace(
        "[poses.random]",
        "[[cameras]]\nname = 'up'\nposition_m = [0, 0.08, 0]\nset = [\"lens.distortion={model='division',k=[-0.1]}\"]\n[poses.random]",
    );
    let folder = made(&third, "--frames 0..1");
    let ros = |file: &str| ros_matrix(&folder, file, "projection");
    assert!((ros("ros/left-right/right.yaml")[3] + 3.0).abs() < 1e-9);
    let files = folder.path("out/calibration");
    assert!(!files.join("ros/left-up/up.yaml").exists() && !files.join("ros/left.yaml").exists());
    let card = folder.text("out/README.md");
    assert!(card.contains("`ros/left-up/up.yaml`: ROS files have no model for the division lens of up"), "{card}");
}

#[rstest]
fn formats_of_training_programs_name_what_writes_them(#[values("webdataset", "parquet", "mcap")] format: &str) {
    let folder = made(SET, "");
    let wanted = ["pip install \"photosite[train]\"", &format!("python -m photosite.train {format} DATASET -o DIR")];
    folder.fail(&format!("layout out --format {format} -o laid"), 2, &wanted);
    assert!(!folder.path("laid").exists());
}
