//! Cameras that move while they record, and line cameras.

use glam::{DMat3, DVec3};
use photosite::io::exr::read_exr;
use photosite::math::statistics::Moments;
use rstest::rstest;
use serde_json::Value;

use crate::folder::Folder;
use crate::room::room;
use crate::same_bytes::assert_same;

const MOVING: &str = "frames = 2\nframe_interval_s = 0.01\n[camera.motion]\nvelocity_m_per_s = [20, 0, 0]\n\
    [sensor.shutter]\nkind = 'rolling'\nrow_time_us = 100\n";
const RENDER: &str = "[render]\nsamples_per_pixel = 4\nseed = 3\n";

#[test]
fn each_frame_has_light_of_its_own_which_can_be_exposed_again() {
    let folder =
        room(&format!("{MOVING}{RENDER}[output]\nraw = ['npy']\nirradiance = {{ bands_nm = [300, 1100, 5] }}\n"));
    folder.succeed("render capture.toml -o out --threads 1");
    folder.succeed("render capture.toml -o two --threads 2");
    assert_same(&folder, "out", "two");
    let results = folder.results("out");
    let names = ["capture.json", "electrons-0000.exr", "electrons-0001.exr", "image-0000.png", "image-0001.png"];
    let more = ["irradiance-0000.exr", "irradiance-0001.exr", "raw-0000.npy", "raw-0001.npy"];
    assert_eq!(results.keys().collect::<Vec<_>>(), names.iter().chain(&more).collect::<Vec<_>>());
    let report = folder.report("out");
    assert_eq!(report["camera"]["motion"]["velocity_m_per_s"][0], 20.0);
    assert_eq!(report["camera"]["motion"]["row_time_s"], 1e-4);

    folder.succeed("expose out -o again");
    folder.succeed("expose out -o one --set exposure.frames=1");
    let (again, one) = (folder.results("again"), folder.results("one"));
    for name in ["raw-0000.npy", "raw-0001.npy", "electrons-0001.exr", "image-0001.png"] {
        assert!(again[name] == results[name], "{name}");
    }
    assert!(one["raw.npy"] == results["raw-0000.npy"], "{:?}", one.keys());
    // Gain, seed and noise are open; what decides which light was seen is not.
    folder.succeed("expose out -o brighter --set exposure.gain_db=6 --set render.seed=4");
}

#[rstest]
#[case::time("exposure.time_s=0.001", "exposure.time_s: the camera moves")]
#[case::interval("exposure.frame_interval_s=0.02", "exposure.frame_interval_s: the camera moves")]
#[case::frames("exposure.frames=3", "exposure.frames: the camera moves, and the light of 2 images is stored")]
#[case::row_time("sensor.shutter.row_time_us=50", "sensor.shutter: the rows of this sensor see light at other times")]
#[case::sensor("sensor.preset=sony-imx249-mono", "sensor.shutter: the rows of this sensor see light at other times")]
fn stored_light_of_a_moving_camera_serves_its_own_times_only(#[case] set: &str, #[case] message: &str) {
    let folder = room(&format!("{MOVING}{RENDER}"));
    folder.succeed("render capture.toml -o out");
    folder.fail(&format!("expose out --set {set}"), 1, &[message, "render"]);
    folder.fail("expose out/electrons-0001.exr", 1, &["one of a series", "give the folder"]);
}

#[test]
fn stored_light_serves_any_shutter_where_nothing_moves() {
    let folder = room(RENDER);
    folder.succeed("render capture.toml -o out");
    folder.succeed("expose out -o rolling --set sensor.shutter.kind=rolling --set sensor.shutter.row_time_us=10");
    assert!(folder.results("rolling")["raw.dng"] == folder.results("out")["raw.dng"]);
    folder.fail(
        "expose out --set sensor.shutter.kind=scanning --set sensor.shutter.row_time_us=1000 --set sensor.cfa=mono",
        1,
        &["sensor"],
    );
}

#[test]
fn a_single_image_of_a_moving_camera_has_plain_names() {
    let folder = room(&format!(
        "[[camera.motion.poses]]\ntime_s = 0\nposition_m = [0, 1, 3]\nlook_at_m = [0, 1, 0]\n\
        [[camera.motion.poses]]\ntime_s = 0.0002\nposition_m = [0.5, 1, 3]\nlook_at_m = [0, 0.5, 0]\n{RENDER}"
    ));
    let capture = folder.text("capture.toml");
    let camera = "position_m = [0.2, 1.1, 3.2]\nlook_at_m = [0, 0.7, 0]\n";
    assert!(capture.contains(camera));
    folder.fail(
        "render capture.toml",
        1,
        &["camera.motion.poses: cannot be combined with position_m of [camera]", "remove"],
    );
    folder.add("capture.toml", capture.replace(camera, ""));
    folder.succeed("render capture.toml -o out");
    assert_eq!(
        folder.results("out").keys().collect::<Vec<_>>(),
        ["capture.json", "electrons.exr", "image.png", "raw.dng"]
    );
    assert_eq!(folder.report("out")["camera"]["motion"]["poses"][1]["position_m"][0], 0.5);
    folder.succeed("expose out -o again");
    assert!(folder.results("again")["raw.dng"] == folder.results("out")["raw.dng"]);
}

/// Lines of an image of even light differ by new noise, but have their pattern in common.
#[test]
fn a_line_camera_sees_every_line_with_the_same_pixels() {
    let folder = Folder::new([
        ("wall.obj", b"v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nusemtl wall\nf 1 2 3 4\n".to_vec()),
        (
            "capture.toml",
            b"[scene]\ngeometry = ['wall.obj']\nenvironment = { illuminant = 'D65', illuminance_lux = 500 }\n\
              [camera]\nposition_m = [0, 0, 2]\nlook_at_m = [0, 0, 0]\nmotion.velocity_m_per_s = [0, -1, 0]\n\
              [sensor]\npreset = 'generic-line-scan'\nresolution_px = [64, 48]\nnoise.prnu_percent = 5\n\
              [exposure]\ntime_s = 2e-5\n[render]\nsamples_per_pixel = 2\n[output]\nraw = ['npy', 'dng']\n"
                .to_vec(),
        ),
    ]);
    folder.succeed("render capture.toml -o out");
    let raw = folder.raw("out/raw.dng");
    assert_eq!((raw.width, raw.height), (64, 48));
    let rows: Vec<Vec<f64>> = raw.data.chunks(64).map(|row| row.iter().map(|&dn| f64::from(dn)).collect()).collect();
    let column = |x: usize| rows.iter().map(|row| row[x]).collect::<Moments>();
    let means: Moments = (0..64).map(|x| column(x).mean()).collect();
    let within = (0..64).map(|x| column(x).variance()).sum::<f64>() / 64.0;
    // Were the pattern new in each line, means of columns would vary by what is within them over 48 lines.
    assert!(within > 0.0 && means.variance() > 5.0 * within / 48.0, "{} {within}", means.variance());
    folder.fail(
        "render capture.toml --set exposure.time_s=0.1",
        1,
        &["exposure.time_s: 0.1 s is longer than", "row_time_us"],
    );
}

#[rstest]
#[case::automatic("[camera.motion]\nvelocity_m_per_s = [1, 0, 0]", "camera.motion: needs an exposure time", "time_s")]
#[case::one_pose(
    "[camera.motion]\nposes = [{ time_s = 0, position_m = [0, 0, 1], look_at_m = [0, 0, 0] }]",
    "camera.motion.poses: a motion needs at least two",
    "stands still"
)]
#[case::order(
    "[camera.motion]\nposes = [{ time_s = 1, position_m = [0, 0, 1], look_at_m = [0, 0, 0] }, \
     { time_s = 1, position_m = [0, 0, 1], look_at_m = [0, 0, 0] }]",
    "camera.motion.poses[1].time_s: 1 s is not after 1 s",
    "order"
)]
#[case::both(
    "[camera.motion]\nvelocity_m_per_s = [1, 0, 0]\nposes = []",
    "velocity_m_per_s: cannot be combined with poses",
    ""
)]
#[case::no_row_time("[sensor.shutter]\nkind = 'rolling'", "sensor.shutter.row_time_us: missing", "row_time_us = 20.0")]
#[case::negative("[sensor.shutter]\nkind = 'rolling'\nrow_time_us = -1", "row_time_us: must be above 0", "20.0")]
#[case::global("[sensor.shutter]\nkind = 'global'\nrow_time_us = 10", "does not apply to a global shutter", "rolling")]
#[case::ccd(
    "[sensor]\npreset = 'textbook-ccd'\nshutter = { kind = 'rolling', row_time_us = 1 }",
    "all its rows at once",
    ""
)]
#[case::line_of_a_tile(
    "[sensor.shutter]\nkind = 'scanning'\nrow_time_us = 100",
    "sensor.cfa: reaches over several",
    "one row"
)]
#[case::interval(
    "[sensor.shutter]\nkind = 'rolling'\nrow_time_us = 100\n[exposure]\ntime_s = 1e-3\nframe_interval_s = 2e-3",
    "exposure.frame_interval_s: 0.002 s is shorter than",
    "leave it out"
)]
fn impossible_motions_are_refused(#[case] more: &str, #[case] message: &str, #[case] help: &str) {
    let scene = "[scene]\ngeometry = ['room.obj']\nenvironment = { illuminant = 'D65', illuminance_lux = 500 }\n";
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl wall\nf 1 2 3\n";
    let folder = Folder::new([("room.obj", obj.into()), ("capture.toml", format!("{scene}{more}\n").into())]);
    folder.fail("render capture.toml", 1, &["capture.toml", message, help]);
}

/// A board that a fast camera comes nearer to, and turns.
fn passing(shutter: &str) -> Folder {
    let capture = format!(
        "[scene]\nenvironment = {{ illuminant = 'D65', illuminance_lux = 500 }}\n[[targets]]\ntype = 'chessboard'\n\
         name = 'board'\nsquares = [9, 6]\nsquare_mm = 30\n[camera]\nposition_m = [0.02, -0.03, 0.6]\nlook_at_m = [0, 0, 0]\n\
         motion = {{ velocity_m_per_s = [3, 1, -8], angular_velocity_deg_per_s = [0, 40, 300] }}\n\
         [lens]\nfocal_length_mm = 6\nfocus_distance_m = 'infinity'\n[sensor]\npreset = 'sony-imx249-mono'\n\
         resolution_px = [64, 48]\npixel_pitch_um = [100, 100]\n{shutter}[exposure]\ntime_s = 0.004\n\
         [render]\nsamples_per_pixel = 1\nmax_depth = 1\n[output]\ntruth = ['depth', 'position']\n"
    );
    Folder::new([("capture.toml", capture.into())])
}

/// Parts of a report that are needed to project: rotation, translation, and the matrix, rows first.
fn pose(report: &Value) -> (DMat3, DVec3, DMat3) {
    let camera = &report["camera"];
    let numbers = |value: &Value| -> Vec<f64> {
        value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
    };
    let matrix = |value: &Value| {
        let rows = value.as_array().expect("rows").iter().flat_map(numbers).collect::<Vec<f64>>();
        DMat3::from_cols_slice(&rows).transpose()
    };
    let rotation = matrix(&camera["rotation"]);
    (rotation, DVec3::from_slice(&numbers(&camera["translation_m"])), matrix(&camera["camera_matrix"]))
}

/// Column and row, and the depth.
fn seen((rotation, translation, matrix): &(DMat3, DVec3, DMat3), world: DVec3) -> [f64; 3] {
    let p = *rotation * world + *translation;
    let pixel = *matrix * (p / p.z);
    [pixel.x, pixel.y, p.z]
}

fn points(report: &Value) -> Vec<(DVec3, [f64; 2])> {
    let target = &report["targets"][0];
    let numbers = |value: &Value| -> Vec<f64> {
        value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
    };
    let lists = |key: &str| target[key].as_array().expect("a list").iter().map(numbers).collect::<Vec<_>>();
    let both = lists("points_world_m").into_iter().zip(lists("points_px"));
    both.map(|(world, px)| (DVec3::from_slice(&world), [px[0], px[1]])).collect()
}

/// Where `photosite project` puts points.
fn projected(folder: &Folder, points: &[(DVec3, [f64; 2])]) -> Vec<[f64; 2]> {
    let lines = points.iter().map(|(p, _)| format!("{}, {}, {}\n", p.x, p.y, p.z));
    folder.add("points.csv", lines.collect::<String>());
    let answer = folder.succeed("project capture.toml --points points.csv").stdout;
    let numbers = |line: &str| -> Vec<f64> { line.split(',').map(|x| x.parse().expect("a number")).collect() };
    answer.lines().map(numbers).map(|px| [px[0], px[1]]).collect()
}

#[test]
fn pose_truth_and_targets_of_a_moving_camera_are_of_the_middle_of_the_exposure() {
    let folder = passing("");
    folder.succeed("render capture.toml -o out --quiet");
    let report = folder.report("out");
    assert_eq!(report["camera"]["pose_time_s"], 0.002);
    let place = report["camera"]["position_m"].as_array().expect("three numbers");
    for (axis, (start, velocity)) in [(0.02, 3.0), (-0.03, 1.0), (0.6, -8.0)].into_iter().enumerate() {
        let expected = start + velocity * 0.002;
        assert!((place[axis].as_f64().expect("a number") - expected).abs() < 1e-12, "{place:?}");
    }
    let info = folder.succeed("info out/capture.json --json").json();
    assert_eq!(info["camera_position_m"], report["camera"]["position_m"]);
    let pose = pose(&report);
    // Both sides calculate in double precision, from numbers that are written with all digits.
    let points = points(&report);
    assert_eq!(points.len(), 40);
    for ((world, px), by_command) in points.iter().zip(projected(&folder, &points)) {
        let [column, row, _] = seen(&pose, *world);
        assert!((column - px[0]).abs() < 1e-8 && (row - px[1]).abs() < 1e-8, "{column}, {row}: {px:?}");
        assert!((by_command[0] - px[0]).abs() < 1e-8 && (by_command[1] - px[1]).abs() < 1e-8, "{by_command:?}: {px:?}");
    }
    let file = std::fs::File::open(folder.path("out/truth.exr")).expect("truth.exr");
    let truth = read_exr(std::io::BufReader::new(file)).expect("an image").planes;
    let plane = |name: &str| truth.plane(name).unwrap_or_else(|| panic!("no {name}"));
    let mut told = 0;
    for i in 0..64 * 48 {
        let [x, y, z] = ["position.X", "position.Y", "position.Z"].map(|name| f64::from(plane(name)[i]));
        if x.is_nan() {
            continue;
        }
        let [column, row, depth] = seen(&pose, DVec3::new(x, y, z));
        // f32 positions and rays over 0.6 m, at 60 px a radian: some 1e-6 · 60/0.6.
        let (x, y) = ((i % 64) as f64, (i / 64) as f64);
        assert!((column - x).abs() < 2e-4 && (row - y).abs() < 2e-4, "{column}, {row}: pixel {x}, {y}");
        assert!((depth - f64::from(plane("depth")[i])).abs() < 2e-6, "{depth}: {}", plane("depth")[i]);
        told += 1;
    }
    assert!(told > 500, "the board fills {told} pixels");
    // What other tools are told is that pose, too.
    let ours = folder.succeed("camera capture.toml --format colmap -o model").stderr;
    let images = std::fs::read_to_string(folder.path("model/images.txt")).unwrap_or_else(|e| panic!("{e}: {ours}"));
    let line = images.lines().find(|line| !line.starts_with('#')).expect("an image");
    let numbers: Vec<f64> = line.split(' ').skip(5).take(3).map(|x| x.parse().expect("a number")).collect();
    assert!((DVec3::from_slice(&numbers) - pose.1).length() < 1e-12, "{line}");
}

#[test]
fn rows_that_follow_each_other_have_their_pose_at_the_middle_one() {
    let folder = passing("shutter = { kind = 'rolling', row_time_us = 50 }\n");
    folder.succeed("render capture.toml -o out --quiet");
    let report = folder.report("out");
    // 47 rows later the last one starts.
    let middle = (47.0 * 50e-6 + 0.004) / 2.0;
    let told = report["camera"]["pose_time_s"].as_f64().expect("a time");
    assert!((told - middle).abs() < 1e-15, "{told}");
    let (at_middle, points) = (pose(&report), points(&report));
    for ((world, px), by_command) in points.iter().zip(projected(&folder, &points)) {
        assert!((by_command[0] - px[0]).abs() < 1e-8 && (by_command[1] - px[1]).abs() < 1e-8, "{by_command:?}: {px:?}");
        // Every point is seen when its row is: the camera is later by 50 µs a row, by the motion that the report tells.
        let later = (px[1] - 23.5) * 50e-6;
        let (rotation, _, matrix) = at_middle;
        let position = rotation.transpose() * (DVec3::ZERO - at_middle.1) + DVec3::new(3.0, 1.0, -8.0) * later;
        // Axes of OpenCV: y and z are turned about.
        let turn = DVec3::new(0.0, -40.0, -300.0) * (std::f64::consts::PI / 180.0) * later;
        let turned = DMat3::from_axis_angle(turn.try_normalize().unwrap_or(DVec3::X), turn.length());
        let rotation = turned.transpose() * rotation;
        let [column, row, _] = seen(&(rotation, DVec3::ZERO - rotation * position, matrix), *world);
        assert!((column - px[0]).abs() < 1e-8 && (row - px[1]).abs() < 1e-8, "{column}, {row}: {px:?}");
    }
}

/// Things that sink by a row in a row's time are below each row by as much, in all of them but for what rounding makes equal.
#[test]
fn points_that_outrun_the_rows_are_counted() {
    let capture = |v: f64| {
        format!(
            "[scene]\ngeometry = ['wall.obj']\nenvironment = {{ illuminant = 'D65', illuminance_lux = 500 }}\n\
             [camera]\nposition_m = [0, 0, 2]\nlook_at_m = [0, 0, 0]\nmotion.velocity_m_per_s = [0, {v}, 0]\n\
             [lens]\ntype = 'pinhole'\nfocal_length_mm = 4\n[sensor]\npreset = 'sony-imx249-mono'\n\
             resolution_px = [64, 48]\npixel_pitch_um = [125, 125]\nshutter = {{ kind = 'rolling', row_time_us = 1000 }}\n\
             [exposure]\ntime_s = 2e-5\n"
        )
    };
    let wall = b"v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n".to_vec();
    let points = b"0, -0.3, 0\n0.1, 0.2, 0\n0, 0, 3\n".to_vec();
    let folder = Folder::new([("wall.obj", wall), ("points.csv", points)]);
    // 32 px per radian from 2 m: 16 px for a metre, a row in a thousandth of 62.5 m/s. The last point is behind the camera.
    for (v, lost) in [(62.5, 2), (31.25, 0)] {
        folder.add("capture.toml", capture(v));
        let answer = folder.succeed("project capture.toml --points points.csv");
        let nan = answer.stdout.lines().filter(|line| *line == "nan,nan").count();
        assert_eq!(nan, lost + 1, "{v}: {}", answer.stdout);
        assert_eq!(answer.stderr.contains(&format!("{lost} points of ground truth")), lost > 0, "{}", answer.stderr);
    }
}
