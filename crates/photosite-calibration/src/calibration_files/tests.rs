//! Tests of calibrations: what photosite writes is read back, formats that others write, and faults.

use std::path::Path;

use glam::{DAffine3, DQuat, DVec3};
use rstest::rstest;

use super::*;
use crate::camera_files::{
    CalibratedCamera, ColmapImage, StereoPair, colmap_cameras, colmap_images, euroc, kalibr, opencv, opencv_pair, ros,
};
use photosite_core::projection::{BrownConrady, Intrinsics, Projection};

/// Largest difference of numbers that went through a file, by the issue that asked for it.
const SAME: f64 = 1e-9;

fn camera(name: &str, projection: Projection) -> CalibratedCamera {
    let turned = DQuat::from_euler(glam::EulerRot::YXZ, 0.3, -0.2, 0.1);
    CalibratedCamera {
        name: name.to_owned(),
        intrinsics: Intrinsics { fx: 501.123_456_789, fy: 502.25, cx: 321.3, cy: 238.7, skew: 0.0 },
        projection,
        resolution: [640, 480],
        to_world: DAffine3::from_rotation_translation(turned, DVec3::new(0.1, -0.2, 0.3)),
    }
}

fn brown_conrady(k: [f64; 6], s: [f64; 4]) -> Projection {
    Projection::BrownConrady(BrownConrady { k, p: [1e-3, -2e-3], s })
}

fn lenses() -> Vec<Projection> {
    let short = BrownConrady { k: [-0.1, 0.02, 0.0, 0.0, 0.0, 0.0], p: [1e-3, -2e-3], s: [0.0; 4] };
    vec![
        Projection::Perspective,
        Projection::BrownConrady(short),
        brown_conrady([-0.1, 0.02, 0.01, 0.0, 0.0, 0.0], [0.0; 4]),
        brown_conrady([0.1, 0.02, 0.01, 0.3, 0.1, 0.02], [0.0; 4]),
        brown_conrady([0.1, 0.02, 0.01, 0.3, 0.1, 0.02], [1e-3, 2e-3, -1e-3, 5e-4]),
        Projection::KannalaBrandt { k: [0.05, 0.01, -0.002, 0.0004] },
        Projection::Omnidirectional { xi: 1.1, distortion: short },
    ]
}

fn read(name: &str, text: &str) -> Vec<Calibration> {
    CalibrationFile::parse(text, Path::new(name)).unwrap_or_else(|error| panic!("{error}\n{text}")).cameras
}

fn assert_same(found: &Calibration, wanted: &CalibratedCamera) {
    let numbers = |i: &Intrinsics| [i.fx, i.fy, i.cx, i.cy, i.skew];
    for (a, b) in numbers(&found.intrinsics).into_iter().zip(numbers(&wanted.intrinsics)) {
        assert!((a - b).abs() < SAME, "{found:?} {wanted:?}");
    }
    assert_eq!((found.projection, found.resolution), (wanted.projection, Some(wanted.resolution)));
}

fn assert_same_pose(found: &DAffine3, wanted: &DAffine3) {
    let difference = found.to_cols_array().into_iter().zip(wanted.to_cols_array()).map(|(a, b)| (a - b).abs());
    assert!(difference.fold(0.0, f64::max) < SAME, "{found:?} {wanted:?}");
}

fn pose_of<'c>(camera: &'c Calibration, name: &str) -> &'c DAffine3 {
    &camera.poses.iter().find(|pose| pose.name == name).unwrap_or_else(|| panic!("{name}: {camera:?}")).to_frame
}

#[test]
fn every_lens_that_a_format_has_words_for_comes_back_from_it() {
    let mut read_back = [0; 5];
    for projection in lenses() {
        let wanted = camera("left eye", projection);
        let files = [
            ("a.yaml", opencv(&wanted)),
            ("b.yaml", ros(&wanted)),
            ("camchain.yaml", kalibr(std::slice::from_ref(&wanted))),
            ("cameras.txt", colmap_cameras(std::slice::from_ref(&wanted))),
            ("sensor.yaml", euroc(&wanted, &DAffine3::IDENTITY, 20.0)),
        ];
        for (i, (name, text)) in files.into_iter().enumerate() {
            let Ok(text) = text else { continue };
            let cameras = read(name, &text);
            assert_eq!(cameras.len(), 1, "{text}");
            assert_same(&cameras[0], &wanted);
            assert_eq!(cameras[0].warnings, [] as [&str; 0], "{text}");
            read_back[i] += 1;
            match name {
                "a.yaml" => assert_same_pose(pose_of(&cameras[0], "world"), &wanted.to_world),
                "sensor.yaml" => assert_same_pose(pose_of(&cameras[0], "body"), &wanted.to_world),
                _ => {}
            }
        }
    }
    // OpenCV all lenses, ROS without thin prisms and mirrors, Kalibr and EuRoC without k₃.
    assert_eq!(read_back, [7, 5, 4, 5, 3]);
}

#[test]
fn poses_of_a_rig_come_back_from_kalibr_opencv_and_colmap() {
    let first = camera("left", Projection::Perspective);
    let by = |shift: f64, turn: f64| CalibratedCamera {
        to_world: first.to_world
            * DAffine3::from_rotation_translation(DQuat::from_rotation_y(turn), DVec3::new(shift, 0.01, 0.0)),
        name: format!("cam{shift}"),
        ..first.clone()
    };
    let rig = [first.clone(), by(0.1, 0.05), by(0.2, -0.1)];
    let chain = read("camchain.yaml", &kalibr(&rig).expect("pinholes"));
    for (i, found) in chain.iter().enumerate() {
        for (j, other) in rig.iter().enumerate() {
            let wanted = other.to_world.inverse() * rig[i].to_world;
            assert_same_pose(pose_of(found, &format!("cam{j}")), &wanted);
        }
    }
    let pair = StereoPair::new(&rig[0], &rig[1]).expect("side by side");
    let pair = read("stereo.yml", &opencv_pair(&pair).expect("pinholes"));
    assert_same_pose(pose_of(&pair[0], "left"), &DAffine3::IDENTITY);
    assert_same_pose(pose_of(&pair[1], "left"), &(rig[0].to_world.inverse() * rig[1].to_world));

    let mut file = CalibrationFile::parse(&colmap_cameras(&rig).expect("pinholes"), Path::new("cameras.txt"));
    let file = file.as_mut().expect("cameras");
    assert_eq!(file.file_of_poses(Path::new("sparse/cameras.txt")).as_deref(), Some(Path::new("sparse/images.txt")));
    let images: Vec<ColmapImage> = (0..3)
        .map(|i| ColmapImage { name: format!("a b/{i}.png"), camera: i, to_world: rig[i].to_world, points: Vec::new() })
        .collect();
    file.add_poses(&colmap_images(&images), Path::new("images.txt")).expect("poses");
    for (i, found) in file.cameras.iter().enumerate() {
        assert_same_pose(pose_of(found, &format!("a b/{i}.png")), &rig[i].to_world);
    }
}

/// Case: T_cam_imu takes points of the IMU to the camera; here the camera's axes are turned by a quarter about z.
#[test]
fn the_pose_from_an_imu_is_that_of_its_matrix() {
    let text = "cam0:\n  T_cam_imu:\n  - - 0.0\n    - 1.0\n    - 0.0\n    - 0.5\n  - [-1.0, 0.0, 0.0, 0.0]\n  - [0.0, 0.0, 1.0,\n    0.0]\n  \
                - [0.0, 0.0, 0.0, 1.0]\n  cam_overlaps: [1]\n  camera_model: pinhole\n  distortion_coeffs: []\n  distortion_model: none\n  \
                intrinsics: [500, 500, 320, 240]\n  resolution: [640, 480]\n  rostopic: /cam0/image_raw\n  timeshift_cam_imu: 0.001\n";
    let cameras = read("camchain-imucam.yaml", text);
    assert!(cameras[0].warnings.is_empty(), "{cameras:?}");
    let to_imu = pose_of(&cameras[0], "imu");
    // The camera's centre is where R·x + t = 0: x = −Rᵀt = (0, −0.5, 0).
    assert!((to_imu.translation - DVec3::new(0.0, -0.5, 0.0)).length() < SAME, "{to_imu:?}");
    // It looks along the IMU's z, and its image's right is the IMU's y.
    assert!((to_imu.transform_vector3(-DVec3::Z) - DVec3::Z).length() < SAME, "{to_imu:?}");
    assert!((to_imu.transform_vector3(DVec3::X) - DVec3::Y).length() < SAME, "{to_imu:?}");
}

/// OpenCV's own files of one camera, as its versions 4 and 5 write them, and lists that scripts dump.
#[rstest]
#[case::yaml(
    "a.yml",
    "%YAML:1.0\n---\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 5.0e+02, 0., 3.2e+02, 0., 501.,\n       \
     240., 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   data: [ -1.0e-01, 0.02, 0., 0., \
     0.01 ]\nimage_width: 640\nimage_height: 480\navg_reprojection_error: 2.5e-01\n"
)]
#[case::xml(
    "a.xml",
    "<?xml version=\"1.0\"?>\n<opencv_storage>\n<camera_matrix type_id=\"opencv-matrix\">\n  <rows>3</rows>\n  <cols>3</cols>\n  \
     <dt>d</dt>\n  <data>\n    500. 0. 320. 0. 501. 240. 0. 0.\n    1.</data></camera_matrix>\n<distortion_coefficients \
     type_id=\"opencv-matrix\"><rows>1</rows><cols>5</cols><dt>d</dt><data>-0.1 2e-2 0. 0. \
     0.01</data></distortion_coefficients>\n<image_width>640</image_width>\n<image_height>480</image_height>\n</opencv_storage>\n"
)]
#[case::json(
    "a.json",
    "{\n    \"camera_matrix\": {\n        \"type_id\": \"opencv-matrix\",\n        \"rows\": 3,\n        \"cols\": 3,\n        \"dt\": \
     \"d\",\n        \"data\": [ 500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0 ]\n    },\n    \"distortion_coefficients\": \
     [[-0.1,0.02,0,0,0.01]],\n\t\"image_size\":[640,480]\n}\n"
)]
#[case::lists(
    "a.yaml",
    "mtx:\n- [500, 0, 320]\n- [0, 501, 240]\n- [0, 0, 1]\ndist:\n- [-0.1, 0.02, 0, 0, 0.01]  # five\nimage_size: [640, 480]"
)]
fn opencv_writes_the_same_camera_in_many_ways(#[case] name: &str, #[case] text: &str) {
    let cameras = read(name, text);
    let intrinsics = Intrinsics { fx: 500.0, fy: 501.0, cx: 320.5, cy: 240.5, skew: 0.0 };
    let distortion = BrownConrady { k: [-0.1, 0.02, 0.01, 0.0, 0.0, 0.0], ..BrownConrady::default() };
    assert_eq!(cameras[0].intrinsics, intrinsics);
    assert_eq!(cameras[0].projection, Projection::BrownConrady(distortion));
    assert_eq!((cameras[0].resolution, cameras[0].warnings.len()), (Some([640, 480]), 0), "{cameras:?}");
}

#[rstest]
#[case("SIMPLE_PINHOLE 640 480 500 320 240", Projection::Perspective)]
#[case("SIMPLE_RADIAL 640 480 500 320 240 -0.1", brown([-0.1, 0.0]))]
#[case("RADIAL 640 480 500 320 240 -0.1 0.02", brown([-0.1, 0.02]))]
#[case("SIMPLE_FISHEYE 640 480 500 320 240", Projection::KannalaBrandt { k: [0.0; 4] })]
#[case("RADIAL_FISHEYE 640 480 500 320 240 0.1 0.02", Projection::KannalaBrandt { k: [0.1, 0.02, 0.0, 0.0] })]
#[case("DIVISION 640 480 500 500 320 240 -0.1", Projection::Division { lambda: -0.1 })]
fn models_of_colmap_are_those_of_photosite(#[case] line: &str, #[case] projection: Projection) {
    let cameras = read("cameras.txt", &format!("# Camera list\n# Number of cameras: 1\n\n7 {line}\n"));
    assert_eq!((cameras[0].name.as_str(), cameras[0].projection), ("7", projection));
    assert_eq!(cameras[0].intrinsics, Intrinsics { fx: 500.0, fy: 500.0, cx: 320.0, cy: 240.0, skew: 0.0 });
}

fn brown([k1, k2]: [f64; 2]) -> Projection {
    Projection::BrownConrady(BrownConrady { k: [k1, k2, 0.0, 0.0, 0.0, 0.0], ..BrownConrady::default() })
}

const CHAIN: &str = "cam0:\n  camera_model: pinhole\n  intrinsics: [500, 500, 320, 240]\n  distortion_model: radtan\n  \
                     distortion_coeffs: [-0.1, 0.02, 0, 0]\n  resolution: [640, 480]\n";
const MATRIX: &str = "camera_matrix: [500, 0, 320, 0, 500, 240, 0, 0, 1]\ndistortion_coefficients: [0, 0, 0, 0, 0]\n";

/// Faults are told with file, line and key.
#[rstest]
#[case("a.yaml", CHAIN.replace("pinhole", "ds"), "a.yaml:2: cam0.camera_model: photosite has no camera model \"ds\"")]
#[case("a.yaml", CHAIN.replace("radtan", "fov"), "a.yaml:4: cam0.distortion_model: photosite has no distortion model \"fov\"")]
#[case("a.yaml", CHAIN.replace("radtan", "radtn"), "did you mean `radtan`?")]
#[case("a.yaml", CHAIN.replace("[500, 500, ", "[500, "), "a.yaml:3: cam0.intrinsics: expected 4 numbers, fu, fv, pu, pv, found 3")]
#[case("a.yaml", CHAIN.replace("[500,", "[-500,"), "a.yaml:3: cam0.intrinsics: fx must be above 0 px, found -500")]
#[case("a.yaml", CHAIN.replace("[500,", "[.nan,"), "a.yaml:3: cam0.intrinsics: expected a number, found \".nan\"")]
#[case("a.yaml", CHAIN.replace("[500,", "[NaN,"), "a.yaml:3: cam0.intrinsics: must be finite, found NaN")]
#[case("a.yaml", CHAIN.replace("[500,", "[1e999,"), "a.yaml:3: cam0.intrinsics: must be finite, found 1e999")]
#[case("a.yaml", CHAIN.replace("[640, 480]", "[640, 480.5]"), "a.yaml:6: cam0.resolution: expected whole numbers")]
#[case("a.yaml", CHAIN.replace("  resolution: [640, 480]\n", ""), "a.yaml:2: cam0: the key `resolution` is missing")]
#[case("a.yaml", CHAIN.replace("240]", "240"), "a.yaml:3: the bracket of this line has no ]")]
#[case("a.yaml", CHAIN.replace("  intrinsics", "\tintrinsics"), "a.yaml:3:")]
#[case("a.yaml", format!("{CHAIN}cam0:\n  camera_model: pinhole\n"), "a.yaml:7: cam0: stands there twice")]
#[case("a.yaml", format!("{CHAIN}  T_cam_imu: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]\n"), "a.yaml:7: cam0.T_cam_imu: is no rotation")]
#[case("a.yaml", format!("{CHAIN}  T_cam_imu: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1]\n"), "a.yaml:7: cam0.T_cam_imu: mirrors")]
#[case("a.yaml", format!("x: &a 1\n{CHAIN}"), "a.yaml:1: & of YAML is not read")]
#[case("a.yaml", "[".repeat(100_000), "nested more than 32 deep")]
#[case("a.yaml", "- ".repeat(100_000), "nested more than 32 deep")]
#[case("a.xml", "<a>".repeat(100_000), "nested more than 32 deep")]
#[case("a.yaml", String::new(), "a.yaml: is empty")]
#[case("a.yaml", "name: value\n".to_owned(), "a.yaml: holds no camera that photosite knows")]
#[case("a.xml", "<opencv_storage><a>".to_owned(), "the file ends before its last element does")]
#[case("a.json", "{\"camera_matrix\": [1, 2}".to_owned(), "expected a comma or ]")]
#[case("a.toml", CHAIN.to_owned(), "a.toml: is no calibration that photosite reads")]
#[case("a.bin", CHAIN.to_owned(), "COLMAP's binary models are not read")]
#[case("a.yaml", MATRIX.replace("[500, 0,", "[500, 2,"), "a.yaml:1: camera_matrix: states a skew of 2 px")]
#[case("a.yaml", MATRIX.replace("0, 1]", "0, 2]"), "a.yaml:1: camera_matrix: is no camera matrix")]
#[case("a.yaml", MATRIX.replace("[0, 0, 0, 0, 0]", "[0, 0, 0, 0, 0, 0]"), "a.yaml:2: distortion_coefficients: expected 4, 5, 8, 12 or 14")]
#[case("a.yaml", MATRIX.replace("[0, 0, 0, 0, 0]", "[0,0,0,0,0,0,0,0,0,0,0,0,0.01,0]"), "the tilted sensor model")]
#[case("a.yaml", format!("{MATRIX}distortion_model: ftheta\n"), "photosite has no model of OpenCV \"ftheta\"")]
#[case("a.yaml", format!("{MATRIX}distortion_model: omnidir\n"), "the key `xi` is missing")]
#[case("a.yaml", format!("{MATRIX}image_width: 640\n"), "the key `image_height` is missing")]
#[case("a.yaml", format!("{MATRIX}distortion_model: thin_prism\nprojection_matrix: [1]\n"), "photosite has no distortion model of ROS \"thin_prism\"")]
#[case("a.yaml", format!("{MATRIX}distortion_model: plumb_bob\n"), "the key `image_width` is missing")]
#[case("a.txt", "1 FOV 640 480 500 500 320 240 0.9\n".to_owned(), "a.txt:1: 1: photosite has no camera model \"FOV\"")]
#[case("a.txt", "# c\n1 PINHOLE 640 480 500 320 240\n".to_owned(), "a.txt:2: PINHOLE: expected 4 parameters, fx, fy, cx, cy, found 3")]
#[case("a.txt", "1 PINHOLE 640 0 500 500 320 240\n".to_owned(), "a.txt:1: HEIGHT: expected a whole number of pixels above 0, found 0")]
#[case("a.txt", "\n".to_owned(), "a.txt: holds no camera")]
#[case("a.txt", "cam0:\n".to_owned(), "a.txt:1: expected CAMERA_ID")]
fn faults_name_file_line_and_key(#[case] name: &str, #[case] text: String, #[case] said: &str) {
    let error = CalibrationFile::parse(&text, Path::new(name)).expect_err(said).to_string();
    assert!(error.contains(said), "{error}");
}

#[rstest]
#[case("1 1 0 0 0 0 0 0 3 a.png\n\n", "images.txt:1: CAMERA_ID: cameras.txt has no camera \"3\"")]
#[case("1 1 0 0 0 0 0 0 1\n\n", "images.txt:1: expected IMAGE_ID")]
#[case("# c\n1 2 0 0 0 0 0 0 1 a.png\n\n", "images.txt:2: pose: the quaternion has the length 2")]
fn faults_of_images_name_their_line(#[case] text: &str, #[case] said: &str) {
    let mut file =
        CalibrationFile::parse("1 PINHOLE 640 480 500 500 320 240", Path::new("cameras.txt")).expect("a camera");
    let error = file.add_poses(text, Path::new("images.txt")).expect_err(said).to_string();
    assert!(error.contains(said), "{error}");
}

/// Poses of views in another form.
const VIEWS: &str = "extrinsic_parameters are not used: expected rows of six numbers";

#[test]
fn views_are_poses_of_the_target() {
    let row = "[0, 0, 0, 1, 2, 3], [0.1, 0.2, 0.3, 4, 5, 6]";
    let flat = row.replace("], [", ", ");
    for matrix in [format!("[{row}]"), format!("{{rows: 2, cols: 6, data: {flat}}}")] {
        let camera = &read("a.yaml", &format!("{MATRIX}extrinsic_parameters: {matrix}\n"))[0];
        let names: Vec<&str> = camera.poses.iter().map(|pose| &pose.name[..]).collect();
        assert_eq!((names, &camera.warnings), (vec!["view 0", "view 1"], &Vec::new()));
        // The camera of the first stands upright at minus its translation.
        let position = camera.poses[0].to_frame.translation;
        assert!((position - glam::DVec3::new(-1.0, -2.0, -3.0)).length() < 1e-12, "{position}");
    }
}

#[test]
fn what_is_assumed_and_what_is_not_used_is_told() {
    let four = MATRIX.replace("0, 0, 0, 0, 0]", "0.1, 0, 0, 0]");
    for (name, text, said) in [
        ("a.yaml", format!("{MATRIX}tilt: 3\nimage_width: 640\nimage_height: 480\n"), "not used of it: tilt"),
        ("a.yaml", four.clone(), "the file does not name its model"),
        ("a.yaml", format!("{MATRIX}extrinsic_parameters: [1]\n"), VIEWS),
        ("a.yaml", format!("{MATRIX}extrinsic_parameters: [[1,0,0,5],[0,1,0,6],[0,0,1,7]]\n"), VIEWS),
        ("a.yaml", format!("{MATRIX}extrinsic_parameters: [[1,0,0,5,6,.nan]]\n"), VIEWS),
        (
            "a.yaml",
            format!("{MATRIX}extrinsic_parameters: {{rows: 3, cols: 4, data: [1,0,0,5,0,1,0,6,0,0,1,7]}}\n"),
            VIEWS,
        ),
        ("a.yaml", format!("{MATRIX}extrinsic_parameters: {{R: [1], t: [2]}}\n"), VIEWS),
        ("a.yaml", format!("{CHAIN}  line_delay: 1e-5\n"), "not used of it: cam0.line_delay"),
    ] {
        let warnings = &read(name, &text)[0].warnings;
        assert!(warnings.len() == 1 && warnings[0].contains(said), "{warnings:?}");
    }
    assert!(read("a.yaml", &format!("{four}fisheye_model: 1\n"))[0].warnings.is_empty());
}
