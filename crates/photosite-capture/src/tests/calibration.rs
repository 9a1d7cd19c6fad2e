//! Tests of cameras from a calibration.

use glam::{DAffine3, DVec3};
use rstest::rstest;

use super::*;
use photosite_transport::optics::{BrownConrady, Focus, Intrinsics, Projection};

const CHAIN: &str = "cam0:\n  camera_model: pinhole\n  intrinsics: [800.0, 800.0, 319.5, 239.5]\n  distortion_model: radtan\n  \
                     distortion_coeffs: [-0.1, 0.02, 0.001, -0.001]\n  resolution: [640, 480]\n  rostopic: /cam0/image_raw\n\
                     cam1:\n  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.1]\n  - [0.0, 1.0, 0.0, 0.0]\n  - [0.0, 0.0, 1.0, 0.0]\n  \
                     - [0.0, 0.0, 0.0, 1.0]\n  camera_model: pinhole\n  intrinsics: [810.0, 810.0, 310.0, 230.0]\n  \
                     distortion_model: none\n  distortion_coeffs: []\n  resolution: [640, 480]\n";
const SENSOR: &str = "[sensor]\npreset = 'sony-imx249-mono'\nresolution_px = [640, 480]\npixel_pitch_um = [5.0, 5.0]\n";

fn files(more: &str) -> Files {
    let files = Files::new(&room(more));
    files.add("camchain.yaml", CHAIN.as_bytes());
    files.add("cameras.txt", b"1 PINHOLE 640 480 800 800 320 240\n2 PINHOLE 640 480 900 900 320 240\n");
    files.add("images.txt", b"# poses\n1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0 0 1 0 0 2 b.png\n1 2 3\n");
    files
}

fn read(more: &str) -> Capture {
    files(more).read(&[]).unwrap_or_else(|error| panic!("{error}"))
}

/// Warnings but for those of the room, whose materials nothing describes.
fn warnings(capture: &Capture) -> Vec<String> {
    capture.warnings().iter().filter(|words| !words.contains("nothing describes")).map(ToString::to_string).collect()
}

#[test]
fn a_camera_is_that_of_its_calibration() {
    let capture = read(&format!(
        "[camera]\ncalibration_pose = 'cam0'\n[lens]\ncalibration = 'camchain.yaml'\ncalibration_camera = 'cam1'\n{SENSOR}"
    ));
    let lens = capture.lens();
    assert_eq!(lens.projection, Projection::Perspective);
    assert_eq!(lens.intrinsics, Some(Intrinsics { fx: 810.0, fy: 810.0, cx: 310.5, cy: 230.5, skew: 0.0 }));
    // 810 px of 5 µm; autofocus finds the distance, which counts as infinite.
    assert!((lens.focal_length_m - 810.0 * 5e-6).abs() < 1e-12, "{}", lens.focal_length_m);
    assert!(matches!(lens.focus, Focus::Autofocus { .. }));
    // A point of cam0 is 0.1 m farther left in cam1: that stands to the right of it.
    let wanted = DAffine3::from_translation(DVec3::new(0.1, 0.0, 0.0));
    assert!(capture.camera_to_world().abs_diff_eq(wanted, 1e-15), "{:?}", capture.camera_to_world());
    assert!(capture.is_placed_by_calibration());
    assert_eq!(warnings(&capture), [""; 0]);
}

#[test]
fn a_focus_distance_makes_the_focal_length_shorter_than_the_image_distance() {
    let capture = read(&format!(
        "[lens]\ncalibration = 'camchain.yaml'\ncalibration_camera = 'cam0'\nfocus_distance_m = 0.5\n{SENSOR}"
    ));
    // 1/f = 1/0.5 m + 1/4 mm.
    let wanted = 1.0 / (1.0 / 0.5 + 1.0 / 4e-3);
    assert!((capture.lens().focal_length_m - wanted).abs() < 1e-15);
    let distortion = BrownConrady { k: [-0.1, 0.02, 0.0, 0.0, 0.0, 0.0], p: [1e-3, -1e-3], s: [0.0; 4] };
    assert_eq!(capture.lens().projection, Projection::BrownConrady(distortion));
}

#[test]
fn an_image_of_colmap_names_camera_and_pose() {
    let files = files(&format!("[camera]\ncalibration_pose = 'b.png'\n[lens]\ncalibration = 'cameras.txt'\n{SENSOR}"));
    let capture = files.read(&[]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(capture.lens().intrinsics.map(|i| (i.fx, i.cx)), Some((900.0, 320.0)));
    // x_camera = x_world + 1, with y down.
    let wanted = DVec3::new(-1.0, 0.0, 0.0);
    assert!((capture.camera_to_world().translation - wanted).length() < 1e-15, "{:?}", capture.camera_to_world());
    assert!((capture.camera_to_world().transform_vector3(-DVec3::Z) - DVec3::Z).length() < 1e-15);
    assert_eq!(capture.calibration_files(), [files.0.path().join("images.txt")]);
}

/// The calibration of what region and binning leave of the sensor is that of the sensor's pixels.
#[test]
fn a_calibration_of_the_delivered_image_is_taken_to_the_sensor() {
    let of = |exposure: &str| {
        let capture = read(&format!(
            "[lens]\ncalibration = 'camchain.yaml'\ncalibration_camera = 'cam0'\n[sensor]\npreset = 'sony-imx249-mono'\n\
             resolution_px = [1920, 1200]\npixel_pitch_um = [2.5, 2.5]\n[exposure]\ntime_s = 0.01\n{exposure}"
        ));
        assert_eq!(warnings(&capture), [""; 0]);
        capture.lens().intrinsics.expect("a matrix")
    };
    let same = |a: Intrinsics, b: Intrinsics| {
        let pairs = [(a.fx, b.fx), (a.fy, b.fy), (a.cx, b.cx), (a.cy, b.cy)];
        assert!(pairs.iter().all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} {b:?}");
    };
    same(of("region_px = [100, 40, 640, 480]"), Intrinsics { fx: 800.0, fy: 800.0, cx: 420.0, cy: 280.0, skew: 0.0 });
    same(
        of("region_px = [100, 40, 1280, 960]\nbinning = [2, 2]"),
        Intrinsics { fx: 1600.0, fy: 1600.0, cx: 740.0, cy: 520.0, skew: 0.0 },
    );
}

/// The report of light that is exposed anew, read as a capture, has the camera matrix of the light.
#[rstest]
fn a_stored_capture_rendered_anew_has_the_matrix_of_its_light(
    #[values("", "region_px = [100, 40, 640, 480]", "region_px = [100, 40, 1280, 960]\nbinning = [2, 2]")] light: &str,
    #[values(
        "exposure.region_px=[0, 0, 640, 480]",
        "exposure.region_px=[8, 100, 320, 240]",
        "exposure.binning=[2, 2]"
    )]
    exposed: &str,
) {
    let size = if light.is_empty() { "[640, 480]" } else { "[1920, 1200]" };
    let files = files(&format!(
        "[lens]\ncalibration = 'camchain.yaml'\ncalibration_camera = 'cam0'\n[sensor]\npreset = 'sony-imx249-mono'\n\
         resolution_px = {size}\npixel_pitch_um = [2.5, 2.5]\n[exposure]\ntime_s = 0.01\n{light}"
    ));
    let of_light = files.read(&[]).unwrap_or_else(|error| panic!("{error}"));
    let stored = of_light.for_traced_light(&[exposed.to_owned()]).unwrap_or_else(|error| panic!("{error}"));
    let keys = stored.to_json(files.0.path()).expect("keys");
    files.add("anew.toml", toml::to_string(&keys).expect("TOML").as_bytes());
    let anew = Capture::load(files.0.path().join("anew.toml")).unwrap_or_else(|error| panic!("{error}"));
    let matrices = [of_light.lens(), stored.lens(), anew.lens()].map(|lens| lens.intrinsics.expect("a matrix"));
    for matrix in &matrices[1..] {
        let pairs = [(matrix.fx, matrices[0].fx), (matrix.cx, matrices[0].cx), (matrix.cy, matrices[0].cy)];
        assert!(pairs.iter().all(|(a, b)| (a - b).abs() < 1e-9), "{matrices:?}");
    }
}

#[test]
fn a_stated_area_is_that_of_the_calibration() {
    let of = |area: &str| {
        files(&format!(
            "[lens]\ncalibration = 'camchain.yaml'\ncalibration_camera = 'cam0'\n{area}[sensor]\n\
             preset = 'sony-imx249-mono'\nresolution_px = [1920, 1200]\npixel_pitch_um = [2.5, 2.5]\n"
        ))
        .read(&[])
    };
    let capture = of("calibration_area_px = [100, 40, 1280, 960]\n").unwrap_or_else(|error| panic!("{error}"));
    let Intrinsics { fx, cx, cy, .. } = capture.lens().intrinsics.expect("a matrix");
    assert!((fx - 1600.0).abs() < 1e-9 && (cx - 740.0).abs() < 1e-9 && (cy - 520.0).abs() < 1e-9);
    for area in ["[100, 40, 1900, 960]", "[0, 0, 0, 480]", "[-1, 0, 640, 480]"] {
        let error = of(&format!("calibration_area_px = {area}\n")).expect_err(area).to_string();
        assert!(error.contains("lens.calibration_area_px: must lie on the sensor's 1920 × 1200 pixels"), "{error}");
    }
}

#[test]
fn contradictions_are_told() {
    let lens = "[lens]\ncalibration = 'camchain.yaml'\ncalibration_camera = 'cam0'\n";
    for (more, said) in [
        (
            format!("{lens}focal_length_mm = 25\n{SENSOR}"),
            "lens.focal_length_mm is 25, but lens.calibration camchain.yaml",
        ),
        (
            format!("{lens}{}", SENSOR.replace("[5.0, 5.0]", "[5.0, 10.0]")),
            "which should be one length; check sensor.pixel_pitch_um",
        ),
        (
            format!("{lens}{}", SENSOR.replace("[640, 480]", "[1280, 960]").replace("[5.0, 5.0]", "[2.5, 2.5]")),
            "is of 640 × 480 pixels, and the sensor has 1280 × 960",
        ),
    ] {
        let warnings = warnings(&read(&more));
        assert!(warnings.len() == 1 && warnings[0].contains(said), "{warnings:?}");
    }
    // Rounded as names of lenses are.
    assert_eq!(warnings(&read(&format!("{lens}focal_length_mm = 4.1\n{SENSOR}"))), [""; 0]);
    let half = read(&format!("{lens}{}", SENSOR.replace("[640, 480]", "[320, 240]")));
    let Intrinsics { fx, cx, .. } = half.lens().intrinsics.expect("a matrix");
    assert!((fx - 400.0).abs() < 1e-12 && (cx - 160.0).abs() < 1e-12);
}

#[rstest]
#[case(
    "[lens]\ncalibration = 'camchain.yaml'",
    "lens.calibration_camera: is missing, and the calibration has 2 cameras"
)]
#[case(
    "[lens]\ncalibration = 'camchain.yaml'\ncalibration_camera = 'cam3'",
    "lens.calibration_camera: the calibration has no camera \"cam3\""
)]
#[case("[lens]\ncalibration = 'none.yaml'", "lens.calibration: cannot read")]
#[case("[lens]\ncalibration = 'room.obj'", "room.obj: is no calibration that photosite reads")]
#[case("[lens]\ncalibration_camera = 'cam0'", "lens.calibration_camera: needs lens.calibration")]
#[case("[lens]\ncalibration_area_px = [0, 0, 1, 1]", "lens.calibration_area_px: needs lens.calibration")]
#[case("[camera]\ncalibration_pose = 'cam0'", "camera.calibration_pose: needs lens.calibration")]
#[case(
    "[camera]\ncalibration_pose = 'imu'\n[lens]\ncalibration = 'camchain.yaml'\ncalibration_camera = 'cam1'",
    "camera.calibration_pose: the calibration has no pose \"imu\" of cam1"
)]
#[case(
    "[camera]\ncalibration_pose = 'cam0'\nposition_m = [0, 0, 0]\nlook_at_m = [0, 0, 1]\n[lens]\ncalibration = 'camchain.yaml'\ncalibration_camera = 'cam1'",
    "camera.position_m: cannot be combined with calibration_pose"
)]
#[case(
    "[lens]\ncalibration = 'camchain.yaml'\nprescription = 'double-gauss'",
    "lens.prescription: cannot be combined with calibration"
)]
#[case(
    "[lens]\ncalibration = 'camchain.yaml'\nhorizontal_fov_deg = 40",
    "lens.horizontal_fov_deg: cannot be combined with calibration"
)]
#[case(
    "[lens]\ncalibration = 'camchain.yaml'\nintrinsics = { fx = 1, fy = 1, cx = 1, cy = 1 }",
    "lens.intrinsics: cannot be combined with calibration"
)]
#[case(
    "[lens]\ncalibration = 'camchain.yaml'\nprojection = 'fisheye'",
    "lens.projection: cannot be combined with calibration"
)]
#[case("[lens]\ncalibration = 3", "lens.calibration: expected a string")]
#[case(
    "[camera]\ncalibration_pose = 'c.png'\n[lens]\ncalibration = 'cameras.txt'\ncalibration_camera = '1'",
    "camera.calibration_pose: the calibration has no pose \"c.png\" of 1"
)]
fn what_does_not_go_together_is_an_error_that_names_the_key(#[case] keys: &str, #[case] said: &str) {
    let error = files(keys).read(&[]).expect_err(keys).to_string();
    assert!(error.contains(said), "{error}");
}

#[test]
fn another_shape_of_the_sensor_is_an_error_that_says_what_to_write() {
    let sensor = SENSOR.replace("[640, 480]", "[1920, 1200]");
    let text = format!("[lens]\ncalibration = 'camchain.yaml'\ncalibration_camera = 'cam0'\n{sensor}");
    let error = files(&text).read(&[]).expect_err("another shape");
    let message = "lens.calibration: is of 640 × 480 pixels, and the sensor has 1920 × 1200, of another shape";
    assert!(error.to_string().contains(message), "{error}");
    let help = miette::Diagnostic::help(&error).expect("help").to_string();
    assert!(help.contains("resolution_px = [640, 480]"), "{help}");
}

#[test]
fn an_argument_takes_the_place_of_a_calibration_and_says_so() {
    let files = files(&format!("[lens]\ncalibration = 'camchain.yaml'\ncalibration_camera = 'cam0'\n{SENSOR}"));
    let capture = files.read(&["lens.prescription=double-gauss"]).unwrap_or_else(|error| panic!("{error}"));
    let told = "lens.prescription=double-gauss replaces lens.calibration, lens.calibration_camera";
    assert!(capture.warnings().iter().any(|w| w.contains(told)), "{:?}", capture.warnings());
}
