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
    assert!(outcome.stderr.contains("laid out 6 pictures in laid"), "{}", outcome.stderr);
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
    let wanted = ["manifest.jsonl: 4 of 6 pictures exist", "the command that makes the data set again"];
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
fn pictures_show_things_where_ground_truth_has_them() {
    let distortion = "--set lens.distortion={model='brown-conrady',k=[-0.1,0,0],p=[0,0]}";
    let folder = made(SET, distortion);
    // What the raw file says of the lens is not applied.
    folder.succeed("develop out/left/000001/raw.dng -o as-taken.png --quiet --set develop.distortion=false");
    let file = |name: &str| std::fs::read(folder.path(name)).expect("a file");
    assert!(file("as-taken.png") == file("out/left/000001/image.png"));
    let folder = made(SET, &format!("{distortion} --set develop.distortion=true"));
    let wanted = ["capture.develop", "was developed in another size, or without the distortion", "000000/capture.json"];
    folder.fail("layout out --format colmap -o laid", 1, &wanted);
    // Of a lens for which DNG has no words as well.
    let folder = made(SET, "--set lens.distortion={model='division',k=[-0.1]} --set develop.distortion=true");
    folder.fail("layout out --format colmap -o laid", 1, &wanted);
}

/// Whatever changes the pixels, the camera of a layout has those of its pictures.
#[rstest]
#[case::kept_wide("--set sensor.pixel_pitch_um=[200,150]", [32, 24])]
#[case::squared("--set sensor.pixel_pitch_um=[200,150] --set develop.square_pixels=true", [43, 24])]
#[case::binned("--set exposure.binning=[2,2]", [16, 12])]
#[case::region("--set exposure.region_px=[4,2,24,16]", [24, 16])]
#[case::resized("--set develop.resize_px=[48,40]", [48, 40])]
fn cameras_of_layouts_have_the_pixels_of_their_pictures(#[case] change: &str, #[case] size: [u32; 2]) {
    let folder = made(SET, change);
    folder.succeed("layout out --format colmap -o laid");
    let picture = image::open(folder.path("laid/images/left/000000.png")).expect("a picture");
    assert_eq!([picture.width(), picture.height()], size);
    let cameras = std::fs::read_to_string(folder.path("laid/sparse/0/cameras.txt")).expect("a file");
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
    let objects = |folder: &Folder, out: &str| -> serde_json::Value {
        let bytes = std::fs::read(folder.path(out).join("cam/000000/objects.json")).expect("a file");
        serde_json::from_slice(&bytes).expect("JSON")
    };
    folder.succeed("dataset set.toml -o out --quiet");
    folder.succeed("layout out --format coco -o laid");
    let text = std::fs::read(folder.path("laid/annotations/instances.json")).expect("a file");
    let coco: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
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
    let text = std::fs::read_to_string(folder.path("out/calibration/opencv/left.yaml")).expect("a file");
    assert!(text.contains("camera_name: \"left\""), "{text}");
    let zoomed = made(&format!("{SET}[[vary]]\nkey = 'lens.focal_length_mm'\nsweep = [5, 6]\n"), "");
    assert!(!zoomed.path("out/calibration").exists());
}

/// Reports have the pose of the middle of the picture; earlier ones had that of its start, without saying when it is.
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
    let text = std::fs::read_to_string(folder.path("out/calibration/opencv/stereo/left-right.yaml")).expect("a file");
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
    let card = std::fs::read_to_string(folder.path("out/README.md")).expect("a card");
    assert!(card.contains("`ros/left-up/up.yaml`: ROS files have no model for the division lens of up"), "{card}");
}

/// The names in a folder, in order.
fn names(folder: &Folder, name: &str) -> Vec<String> {
    let entries = std::fs::read_dir(folder.path(name)).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[rstest]
#[case::webdataset("webdataset", &["index.json", "layout.json", "shard-000000.tar", "shard-000001.tar"])]
#[case::parquet("parquet", &["layout.json", "part-000000.parquet", "part-000001.parquet"])]
#[case::mcap("mcap", &["layout.json", "part-000000.mcap", "part-000001.mcap"])]
fn shards_are_written_while_the_set_grows_with_the_bytes_of_later(#[case] format: &str, #[case] files: &[&str]) {
    let folder = described(SET);
    let grow = format!("dataset set.toml -o out --layout {format}=grown --shard-frames 2 --set output.truth=['depth']");
    let said = folder.succeed(&format!("{grow} --frames 0..2"));
    assert!(said.stderr.contains("1 of 2 shards are in grown"), "{}", said.stderr);
    let said = folder.succeed(&format!("layout out --format {format} -o grown --growing"));
    assert!(said.stderr.contains("wrote 0 shards; 1 of 2 are in grown"), "{}", said.stderr);
    // Not before the set is finished, unless it is asked for.
    folder.fail(&format!("layout out --format {format} -o later"), 1, &["4 of 6 pictures exist"]);
    folder.succeed(&format!("{grow} --quiet"));
    assert_eq!(names(&folder, "grown"), files);
    folder.succeed(&format!("layout out --format {format} -o later --shard-frames 2 --quiet"));
    for file in files {
        let bytes = |name: &str| std::fs::read(folder.path(name).join(file)).expect("a file");
        assert!(bytes("grown") == bytes("later"), "{file}");
    }
    // What was lost is written again.
    let lost = folder.path("grown").join(files[files.len() - 1]);
    std::fs::remove_file(&lost).expect("removed");
    let said = folder.succeed(&format!("layout out --format {format} -o grown --json"));
    assert!(said.stdout.contains("\"written\": 1") && lost.exists(), "{}", said.stdout);
}

#[test]
fn the_size_of_shards_is_decided_by_their_limit() {
    let folder = made(SET, "--set output.truth=['depth','normal','position']");
    folder.succeed("layout out --format webdataset -o laid --quiet");
    let settings = std::fs::read_to_string(folder.path("laid/layout.json")).expect("settings");
    assert!(settings.contains("\"frames_per_shard\": 3") && settings.contains("\"limit_mb\": 256"), "{settings}");
}

#[test]
fn folders_of_other_shards_are_refused() {
    let folder = made(SET, "");
    folder.succeed("layout out --format mcap -o laid --shard-frames 2 --quiet");
    folder.fail("layout out --format parquet -o laid", 2, &["laid holds mcap files, and not parquet", "a new folder"]);
    folder.fail("layout out --format mcap -o laid --shard-frames 3", 2, &["shards of 2 frames, and not of 3"]);
    folder.fail("layout out --format mcap -o laid --shard-mb 9", 2, &["2 frames, and not of at most 9 MiB"]);
    folder.fail("layout out --format mcap -o out", 2, &["out is not empty and does not contain layout.json"]);
    folder.succeed("dataset set.toml -o other --set exposure.time_s=0.002 --quiet");
    folder.fail("layout other --format mcap -o laid", 2, &["laid contains shards of another data set"]);
    folder.fail("dataset set.toml -o out --layout parquet=laid", 2, &["laid holds mcap files"]);
    folder.fail("layout out --format colmap -o new --growing", 2, &["--growing", "webdataset, parquet and mcap"]);
    folder.fail("dataset set.toml -o out --shard-mb 9", 2, &["no --layout asks for any"]);
    folder.fail("dataset set.toml -o out --layout colmap=new", 2, &["webdataset=DIR, parquet=DIR or mcap=DIR"]);
}

#[test]
fn shards_say_what_they_leave_out() {
    let folder = made(SET, "--set output.truth=['depth','normal'] --set lens.distortion={model='division',k=[-0.1]}");
    let said = folder.succeed("layout out --format parquet -o rows");
    assert!(said.stderr.contains("are without normal, which webdataset holds"), "{}", said.stderr);
    let said = folder.succeed("layout out --format mcap -o messages");
    let count =
        said.stderr.matches("there is no /left/camera_info: ROS files have no model for the division lens").count();
    assert_eq!(count, 1, "{}", said.stderr);
    let folder = made(SET, "--set output.raw=[] --set output.truth=['depth'] --set output.truth_formats=['npy']");
    folder.fail("layout out --format webdataset -o laid", 1, &["no truth.exr", "truth_formats = [\"exr\"]"]);
}

#[test]
fn a_shard_that_cannot_be_written_ends_the_work() {
    let folder = described(SET);
    let distortion = "--set lens.distortion={model='brown-conrady',k=[-0.1,0,0],p=[0,0]} --set develop.distortion=true";
    let command = format!("dataset set.toml -o out --layout webdataset=laid --shard-frames 1 {distortion}");
    let said = folder.run(&command);
    assert!(
        said.status == Some(1) && said.stderr.contains("was developed in another size, or without the distortion"),
        "{said:?}"
    );
    assert!(names(&folder, "laid").is_empty() && !folder.path("out/manifest.jsonl").exists());
}

/// Each shard is whole or not there, and the next run writes those that are missing.
#[rstest]
fn shards_that_were_broken_off_are_written_anew(#[values("file-written", "file-named")] point: &str) {
    let folder = made(SET, "");
    folder.succeed("layout out --format webdataset -o whole --shard-frames 1 --quiet");
    let mut round = 1;
    while folder.killed_at(point, round, "layout out --format webdataset -o killed --shard-frames 1 --quiet") {
        for name in names(&folder, "killed").iter().filter(|name| !name.starts_with('.')) {
            let bytes = |of: &str| std::fs::read(folder.path(of).join(name)).expect("a file");
            assert!(bytes("killed") == bytes("whole"), "{name}, {round}");
        }
        round += 1;
        if round > 2 {
            // What is there is not written again, so that other files are the first.
            folder.succeed("layout out --format webdataset -o killed --shard-frames 1 --quiet");
            assert_eq!(names(&folder, "killed"), names(&folder, "whole"), "nothing else is left");
            std::fs::remove_dir_all(folder.path("killed")).expect("removed");
        }
    }
    // The settings, which get their name in another way; three shards, the index.
    assert_eq!(round, if point == "file-written" { 6 } else { 5 });
}

#[test]
fn damaged_sets_and_shards_are_noticed() {
    let folder = made(SET, "");
    std::fs::remove_file(folder.path("out/left/000001/raw.dng")).expect("removed");
    let message = "has damaged or missing pictures: 1 of the shards cannot be written";
    folder.run("layout out --format webdataset -o shards --shard-frames 1");
    folder.fail("layout out --format webdataset -o shards --shard-frames 1", 1, &[message]);
    folder.succeed("dataset set.toml -o out --quiet");
    folder.succeed("layout out --format webdataset -o shards --quiet");
    // As a file of a shard that goes on in others may be.
    std::fs::write(folder.path("shards/shard-000002.tar"), [0; 1024]).expect("written");
    folder.fail("layout out --format webdataset -o shards", 1, &["holds 4 samples, of 6: a file of a shard is lost"]);
    let settings = std::fs::read_to_string(folder.path("shards/layout.json")).expect("settings");
    folder.add("shards/layout.json", settings.replace("\"frames_per_shard\": 1", "\"frames_per_shard\": 0"));
    folder.fail("layout out --format webdataset -o shards", 1, &["layout.json", "is damaged: a shard without frames"]);
}
