//! Cameras that move while they record, and line cameras.

use photosite::math::statistics::Moments;
use rstest::rstest;

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
#[case::frames("exposure.frames=3", "exposure.frames: the camera moves, and the light of 2 pictures is stored")]
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
fn a_single_picture_of_a_moving_camera_has_plain_names() {
    let folder = room(&format!(
        "[[camera.motion.poses]]\ntime_s = 0\nposition_m = [0, 1, 3]\nlook_at_m = [0, 1, 0]\n\
        [[camera.motion.poses]]\ntime_s = 0.0002\nposition_m = [0.5, 1, 3]\nlook_at_m = [0, 0.5, 0]\n{RENDER}"
    ));
    let capture = std::fs::read_to_string(folder.path("capture.toml")).expect("a capture");
    let camera = "position_m = [0.2, 1.1, 3.2]\nlook_at_m = [0, 0.7, 0]\n";
    assert!(capture.contains(camera));
    folder.fail("render capture.toml", 1, &["camera.motion.poses: cannot go with position_m of [camera]", "remove"]);
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

/// Lines of a picture of even light differ by new noise, but have their pattern in common.
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
#[case::both("[camera.motion]\nvelocity_m_per_s = [1, 0, 0]\nposes = []", "velocity_m_per_s: cannot go with poses", "")]
#[case::no_row_time("[sensor.shutter]\nkind = 'rolling'", "sensor.shutter.row_time_us: missing", "row_time_us = 20.0")]
#[case::negative("[sensor.shutter]\nkind = 'rolling'\nrow_time_us = -1", "row_time_us: must be above 0", "20.0")]
#[case::global("[sensor.shutter]\nkind = 'global'\nrow_time_us = 10", "says nothing of a global shutter", "rolling")]
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
