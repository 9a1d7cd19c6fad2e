//! `capture.json` tells where things are in the image, in OpenCV's conventions.

use glam::{DMat3, DVec2, DVec3};
use photosite::io::exr::read_exr;
use rstest::rstest;
use serde_json::Value;

use crate::folder::Folder;
use crate::room::room;

pub(crate) fn vector(value: &Value) -> DVec3 {
    DVec3::from_array(serde_json::from_value(value.clone()).expect("three numbers"))
}

fn matrix(value: &Value) -> DMat3 {
    let rows: [[f64; 3]; 3] = serde_json::from_value(value.clone()).expect("nine numbers");
    DMat3::from_cols_array_2d(&rows).transpose()
}

/// The pixel at which a point appears: `cv2.projectPoints`.
pub(crate) fn project(camera: &Value, point: DVec3) -> DVec2 {
    let in_camera = matrix(&camera["rotation"]) * point + vector(&camera["translation_m"]);
    assert!(in_camera.z > 0.0, "{point} lies behind the camera");
    let (x, y) = (in_camera.x / in_camera.z, in_camera.y / in_camera.z);
    let [k1, k2, p1, p2, k3]: [f64; 5] = serde_json::from_value(camera["distortion"].clone()).expect("five numbers");
    let r2 = x * x + y * y;
    let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    let distorted = DVec3::new(
        x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
        y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        1.0,
    );
    (matrix(&camera["camera_matrix"]) * distorted).truncate()
}

/// A lamp of a few pixels in the dark is where the camera's parameters put it.
#[rstest]
#[case::plain("")]
#[case::distorted("distortion = { model = 'brown-conrady', k = [-0.2, 0.05, -0.01], p = [0.004, -0.003] }")]
#[case::calibrated("intrinsics = { fx = 85, fy = 80, cx = 33.5, cy = 20, skew = 1.5 }")]
#[case::pinhole("type = 'pinhole'")]
fn a_lamp_is_where_the_parameters_put_it(#[case] lens: &str, #[values([0.55, 0.35], [-0.7, -0.4])] place: [f64; 2]) {
    // Position, axes across the view and its depth, for a camera that looks askew.
    let position = DVec3::new(2.0, 1.5, 3.0);
    let depth = (DVec3::new(0.2, 0.4, -0.1) - position).normalize();
    let right = depth.cross(DVec3::Y).normalize();
    let up = right.cross(depth);
    let lamp = position + 3.0 * (depth + 0.5 * (place[0] * right + place[1] * up));
    let corner = |x: f64, y: f64| lamp + 0.06 * (x * right + y * up);
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let vertices: String = corners.iter().map(|c| format!("v {} {} {}\n", c.x, c.y, c.z)).collect();
    let target = position + depth;
    let folder = Folder::new([
        ("lamp.obj", format!("mtllib lamp.mtl\n{vertices}usemtl lamp\nf 1 2 3 4\n").into()),
        ("lamp.mtl", b"newmtl lamp\nKe 1000 1000 1000\n".to_vec()),
        (
            "capture.toml",
            format!(
                "[scene]\ngeometry = ['lamp.obj']\n[camera]\nposition_m = [{}, {}, {}]\nlook_at_m = [{}, {}, {}]\n\
                 [lens]\nfocal_length_mm = 8\nf_number = 16\nfocus_distance_m = 3\n{lens}\n\
                 [sensor]\nresolution_px = [64, 48]\npixel_pitch_um = [100, 105]\n\
                 [exposure]\ntime_s = 0.01\n[render]\nsamples_per_pixel = 256\n",
                position.x, position.y, position.z, target.x, target.y, target.z
            )
            .into(),
        ),
    ]);
    folder.succeed("render capture.toml -o out");
    let report = folder.report("out");
    assert!((vector(&report["camera"]["position_m"]) - position).length() < 1e-12);
    let expected = project(&report["camera"], lamp);

    let file = std::fs::File::open(folder.path("out/electrons.exr")).expect("electrons.exr");
    let planes = read_exr(std::io::BufReader::new(file)).expect("readable").planes;
    let pixels = |name: &str| {
        let plane = planes.plane(name).expect(name).to_vec();
        plane.into_iter().enumerate().map(|(i, v)| (DVec2::new((i % 64) as f64, (i / 64) as f64), f64::from(v)))
    };
    let sum: f64 = pixels("G").map(|(_, value)| value).sum();
    let centroid: DVec2 = pixels("G").map(|(at, value)| at * value).sum::<DVec2>() / sum;
    // The variance of a centroid: Σ (at − centroid)²·σ² / (Σ e)², along each axis.
    let variance = pixels("variance.G").map(|(at, variance)| (at - centroid).powf(2.0) * variance).sum::<DVec2>();
    let sigma = (variance / (sum * sum)).powf(0.5);
    assert!(sigma.max_element() < 0.02, "{sigma}");
    // The lamp is about 3 pixels wide; over that, cos⁴ and perspective move its centroid by less than 0.03 pixels, a
    // twentieth of what a wrong convention for pixel centres would.
    let off = (centroid - expected).abs();
    let tolerance = 4.0 * sigma + 0.03;
    assert!(off.x < tolerance.x && off.y < tolerance.y, "at {centroid}, not {expected}: more than {tolerance} off");
}

/// The capture of the file, written as a capture file, gives the same image.
#[test]
fn the_report_is_a_capture_file_again() {
    let folder = room("[render]\nsamples_per_pixel = 2");
    folder
        .succeed("render capture.toml -o first --seed 5 --set lens.f_number=5.6 --set sensor.preset=sony-imx249-color");
    let capture = folder.report("first")["capture"].clone();
    assert_eq!(capture["lens"]["f_number"], 5.6);
    // Its paths are relative to where it lies.
    folder.add("first/again.toml", toml::to_string(&capture).expect("a capture file has nothing that TOML has not"));
    folder.succeed("render first/again.toml -o again");
    for (name, bytes) in
        folder.results("first").iter().filter(|(name, _)| !["again.toml", "capture.json"].contains(&name.as_str()))
    {
        assert!(folder.results("again")[name] == *bytes, "{name}");
    }
}

#[test]
fn autofocus_on_nothing_is_told() {
    let folder = room("[render]\nsamples_per_pixel = 1");
    let capture = folder.text("capture.toml");
    // Above the room there is only sky.
    let upwards = capture.replace("look_at_m = [0, 0.7, 0]", "look_at_m = [0.2, 9, 3.1]");
    folder.add("capture.toml", upwards.replace("blades = 6", "blades = 6\nautofocus_px = [8, 9]"));
    let outcome = folder.succeed("render capture.toml -o out");
    assert!(outcome.text().contains("warning: autofocus: pixel 8, 9 sees nothing"), "{}", outcome.stderr);
    assert_eq!(folder.report("out")["lens"]["focus_distance_m"], Value::Null);
}
