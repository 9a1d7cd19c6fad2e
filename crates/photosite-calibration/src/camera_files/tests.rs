//! Tests of the camera files, read back by hand where the judges of the command line do not.

use glam::{DQuat, DVec3};

use super::*;
use photosite_core::projection::FisheyeProjection;

fn camera(projection: Projection) -> CalibratedCamera {
    CalibratedCamera {
        name: "left \"eye\"".to_owned(),
        intrinsics: Intrinsics { fx: 1000.0, fy: 1e-7, cx: 320.5, cy: 240.0, skew: 0.0 },
        projection,
        resolution: [640, 480],
        to_world: DAffine3::IDENTITY,
    }
}

fn brown_conrady(k3: f64, s1: f64) -> Projection {
    let k = [0.1, -0.2, k3, 0.0, 0.0, 0.0];
    Projection::BrownConrady(BrownConrady { k, p: [1e-3, -1e-3], s: [s1, 0.0, 0.0, 0.0] })
}

#[test]
fn formats_refuse_what_they_have_no_words_for() {
    let all = |camera: &CalibratedCamera| {
        let one = std::slice::from_ref(camera);
        let files =
            [opencv(camera), ros(camera), kalibr(one), colmap_cameras(one), euroc(camera, &DAffine3::IDENTITY, 20.0)];
        files.map(|file| file.is_ok())
    };
    let mirror = Projection::Omnidirectional { xi: 1.1, distortion: BrownConrady::default() };
    for (projection, can) in [
        (Projection::Perspective, [true; 5]),
        (brown_conrady(0.0, 0.0), [true; 5]),
        (brown_conrady(0.1, 0.0), [true, true, false, true, false]),
        (brown_conrady(0.1, 0.2), [true, false, false, false, false]),
        (Projection::KannalaBrandt { k: [0.1; 4] }, [true; 5]),
        (mirror, [true, false, true, false, false]),
        (Projection::Polynomial { k: [0.1, 0.0] }, [false; 5]),
        (Projection::Division { lambda: -0.1 }, [false; 5]),
        (Projection::ClassicalFisheye(FisheyeProjection::Equisolid), [false; 5]),
        (Projection::ClassicalFisheye(FisheyeProjection::Stereographic), [false; 5]),
        (Projection::ClassicalFisheye(FisheyeProjection::Orthographic), [false; 5]),
        (Projection::Equirectangular, [false; 5]),
    ] {
        assert_eq!(all(&camera(projection)), can, "{projection:?}");
    }
    let mut skewed = camera(Projection::Perspective);
    skewed.intrinsics.skew = 1.0;
    assert_eq!(all(&skewed), [false; 5]);
}

#[test]
fn pairs_are_told_of_lenses_that_their_formats_know() {
    let fisheye = Projection::KannalaBrandt { k: [0.1, 0.0, 0.0, 0.0] };
    let mirror = Projection::Omnidirectional { xi: 1.1, distortion: BrownConrady::default() };
    for (lenses, can) in [
        ([Projection::Perspective, brown_conrady(0.1, 0.0)], [true, true]),
        ([brown_conrady(0.1, 0.2); 2], [false, true]),
        ([fisheye; 2], [true, true]),
        ([fisheye, Projection::Perspective], [true, false]),
        ([mirror; 2], [false, false]),
        ([Projection::Division { lambda: -0.1 }; 2], [false, false]),
    ] {
        let [first, mut second] = lenses.map(|projection| {
            let intrinsics = Intrinsics { fx: 1000.0, fy: 1000.0, cx: 320.5, cy: 240.0, skew: 0.0 };
            CalibratedCamera { intrinsics, ..camera(projection) }
        });
        second.to_world.translation.x = 0.1;
        let pair = StereoPair::new(&first, &second).expect("side by side");
        assert_eq!([ros_pair(&pair).is_ok(), opencv_pair(&pair).is_ok()], can, "{lenses:?}");
    }
}

#[test]
fn a_classical_fisheye_is_refused_with_the_series_that_comes_nearest() {
    for law in [FisheyeProjection::Equisolid, FisheyeProjection::Stereographic, FisheyeProjection::Orthographic] {
        let exact = CalibratedCamera {
            intrinsics: Intrinsics { fx: 200.0, fy: 200.0, cx: 320.5, cy: 240.0, skew: 0.0 },
            ..camera(Projection::ClassicalFisheye(law))
        };
        let help = ros(&exact).expect_err("no model").help.expect("what to write").to_string();
        let between = |from: &str, to: &str| help.split(from).nth(1).and_then(|rest| rest.split(to).next());
        let k: Vec<f64> = between("k = [", "]").expect("k").split(", ").map(|k| k.parse().expect("a number")).collect();
        let stated_px: f64 = between("same lens to ", " px").expect("px").parse().expect("a number");
        let series = Projection::KannalaBrandt { k: k.try_into().expect("four") };
        let near = CalibratedCamera { projection: series, ..exact.clone() };
        assert!(ros(&near).is_ok());
        // The same directions in both images, up to the corners or the rim of the lens.
        let reach = exact.projection.reach(None);
        let mut largest: f64 = 0.0;
        for i in 0..=500 {
            let place = exact.intrinsics.place(DVec2::new(0.64, 0.48) * f64::from(i * 2));
            let Some(seen) = exact.projection.unproject(place, &reach) else { continue };
            let found = series.project(seen.direction, &series.reach(None)).expect("beyond the image");
            largest = largest.max((found - place).length() * 200.0);
        }
        // Three digits are written, and the farthest corner is one of the places.
        assert!(largest <= stated_px * 1.01, "{law:?}: {largest} {help}");
        assert!(largest > 0.1 * stated_px, "{law:?}: {largest} {help}");
    }
}

#[test]
fn numbers_are_whole_and_never_in_exponents() {
    let text = kalibr(&[camera(Projection::Perspective)]).expect("a pinhole");
    assert!(text.contains("intrinsics: [1000.0, 0.0000001, 320.0, 239.5]"), "{text}");
}

#[test]
fn poses_lead_from_camera_to_camera() {
    let left = camera(Projection::Perspective);
    let turned = DQuat::from_rotation_y(0.3);
    let to_world = DAffine3::from_rotation_translation(turned, DVec3::new(0.1, 0.2, 0.3));
    let right = CalibratedCamera { to_world, ..left.clone() };
    let text = kalibr(&[left.clone(), right.clone()]).expect("pinholes");
    let rows: Vec<Vec<f64>> = text
        .lines()
        .filter_map(|line| line.strip_prefix("  - [")?.strip_suffix(']'))
        .map(|row| row.split(", ").map(|x| x.parse().expect("a number")).collect())
        .collect();
    // The left camera's centre as the right one sees it, with y down and z forward.
    let expected = turned.inverse() * -to_world.translation * DVec3::new(1.0, -1.0, -1.0);
    for (row, expected) in rows.iter().zip(expected.to_array()) {
        assert!((row[3] - expected).abs() < 1e-15, "{text}");
    }
    assert_eq!(rows[3], [0.0, 0.0, 0.0, 1.0]);
    let body = euroc(&right, &opencv_pose(&right.to_world), 20.0).expect("a pinhole");
    // The sensor is the body: the identity, to a rounding or two of the inverse.
    let data = body.lines().find_map(|line| line.strip_prefix("  data: [")?.strip_suffix(']')).expect("T_BS");
    for (i, x) in data.split(", ").enumerate() {
        let x: f64 = x.parse().expect("a number");
        assert!((x - if i % 5 == 0 { 1.0 } else { 0.0 }).abs() < 1e-15, "{body}");
    }
    let images = colmap_images(&[ColmapImage {
        name: "a.png".to_owned(),
        camera: 0,
        to_world: left.to_world,
        points: Vec::new(),
    }]);
    // Half a turn about x makes glTF's axes OpenCV's.
    let line = images.lines().nth(1).expect("an image");
    let parts: Vec<&str> = line.split(' ').collect();
    assert_eq!((parts[0], parts[8], parts[9]), ("1", "1", "a.png"));
    let q: Vec<f64> = parts[1..5].iter().map(|x| x.parse().expect("a number")).collect();
    assert!((q[1].abs() - 1.0).abs() < 1e-15 && q[0].abs() < 1e-15, "{line}");
}
