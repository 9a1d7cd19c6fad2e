//! A scene file given directly: a camera that frames it, daylight, the default lens and sensor, automatic exposure.

use glam::{DVec2, DVec3};
use rstest::rstest;
use serde_json::json;

use crate::folder::Folder;
use crate::gltf::triangle;
use crate::report::project;

const TO_THE_SKY: &str = "--set camera.position_m=[0,1,9] --set camera.look_at_m=[0,9,9.5]";
const SMALL: &str = "--set sensor.resolution_px=[48,32] --set render.samples_per_pixel=64";

/// The triangle of `gltf::triangle`.
const CORNERS: [DVec3; 3] = [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(1.0, 0.0, 0.0), DVec3::new(0.0, 1.5, 0.0)];

fn folder() -> Folder {
    Folder::new([
        ("sail.obj", b"v -1 0 0\nv 1 0 0\nv 0 1.5 0\nf 1 2 3\n".to_vec()),
        (
            "sail.ply",
            b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
              property list uchar int vertex_indices\nend_header\n-1 0 0\n1 0 0\n0 1.5 0\n3 0 1 2\n"
                .to_vec(),
        ),
        (
            "sail.stl",
            b"solid sail\nfacet normal 0 0 1\nouter loop\nvertex -1 0 0\nvertex 1 0 0\nvertex 0 1.5 0\nendloop\nendfacet\n\
              endsolid sail\n"
                .to_vec(),
        ),
        ("sail.gltf", triangle().text()),
        ("sail.glb", triangle().binary()),
    ])
}

#[rstest]
fn everything_else_takes_its_default(#[values("obj", "ply", "stl", "gltf", "glb")] kind: &str) {
    let folder = folder();
    folder.succeed(&format!("render sail.{kind} {SMALL}"));
    let report = folder.report("sail");
    let sensor = |key: &str| report["sensor"][key].clone();
    assert_eq!((sensor("name"), sensor("bits")), (json!("generic-cmos-color"), json!(12)));
    assert_eq!((&report["lens"]["focal_length_mm"], &report["lens"]["f_number"]), (&json!(16.0), &json!(8.0)));
    assert_eq!(report["exposure"]["auto"], true);

    // The circle around the triangle's bounding box touches 90 % of the shorter side, so all corners are in the
    // picture, and they take up a good part of it.
    let pixels = CORNERS.map(|corner| project(&report["camera"], corner));
    let (low, high) = (pixels[0].min(pixels[1]).min(pixels[2]), pixels[0].max(pixels[1]).max(pixels[2]));
    assert!(low.cmpge(DVec2::ZERO).all() && high.cmple(DVec2::new(47.0, 31.0)).all(), "{low} to {high}");
    assert!((high - low).max_element() > 0.5 * 32.0, "{low} to {high}");
    // It is in focus: the distance along the axis to the middle of the bounding box.
    let focus = report["lens"]["focus_distance_m"].as_f64().expect("a distance");
    let position: [f64; 3] = serde_json::from_value(report["camera"]["position_m"].clone()).expect("a position");
    let distance = (DVec3::from_array(position) - DVec3::new(0.0, 0.75, 0.0)).length();
    assert!((focus / distance - 1.0).abs() < 1e-9, "{focus} m, not {distance} m");
}

#[test]
fn the_light_is_d65() {
    let folder = folder();
    // Facing the sky, without a surface in the way of most of the picture.
    folder
        .succeed(&format!("render sail.obj {SMALL} --set camera.position_m=[0,1,9] --set camera.look_at_m=[0,9,9.5]"));
    let report = folder.report("sail");
    let electrons = folder.electrons("sail");
    let total = |plane: &[f32]| plane.iter().map(|&v| f64::from(v)).sum::<f64>();
    let [r, g, b] = ["R", "G", "B"].map(|name| {
        let mean = total(electrons.mean.plane(name).expect(name));
        (mean, total(electrons.variance.plane(name).expect(name)).sqrt() / mean)
    });
    let neutral: [f64; 3] = serde_json::from_value(report["sensor"]["as_shot_neutral"].clone()).expect("three numbers");
    // Relative errors of a ratio at most add, whatever the channels have in common.
    for (channel, expected) in [(r, neutral[0] / neutral[1]), (b, neutral[2] / neutral[1])] {
        let (ratio, error) = (channel.0 / g.0, 4.0 * (channel.1 + g.1));
        assert!(error < 0.05 && (ratio / expected - 1.0).abs() < error, "{ratio} is not {expected} ± {error}");
    }
    // It gives 500 lux: what a capture file that says so records.
    folder.add(
        "capture.toml",
        format!(
            "[scene]\ngeometry = ['sail.obj']\nenvironment = {{ illuminant = 'D65', illuminance_lux = 500 }}\n\
             [lens]\nfocus_distance_m = 'infinity'\n[exposure]\ntime_s = {}\n",
            report["exposure"]["time_s"]
        ),
    );
    folder.succeed(&format!("render capture.toml {SMALL} {TO_THE_SKY}"));
    let said = total(folder.electrons("capture").mean.plane("G").expect("G"));
    assert!((said / g.0 - 1.0).abs() < 4.0 * 2f64.sqrt() * g.1, "{said} e⁻, not {}", g.0);
}

#[test]
fn a_scene_with_a_camera_and_lights_keeps_them() {
    let document = triangle()
        .with("/cameras", json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]))
        .with("/extensions", json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 500 }] } }))
        .with("/extensionsUsed", json!(["KHR_lights_punctual"]))
        .with(
            "/nodes",
            json!([
                { "mesh": 0 },
                { "camera": 0, "translation": [0, 0.5, 6] },
                { "extensions": { "KHR_lights_punctual": { "light": 0 } }, "translation": [1, 2, 3] }
            ]),
        )
        .with("/scenes/0/nodes", json!([0, 1, 2]));
    let folder = Folder::new([("a.gltf", document.text())]);
    folder.succeed(&format!("render a.gltf -o out {SMALL}"));
    let report = folder.report("out");
    assert_eq!(report["camera"]["position_m"], json!([0.0, 0.5, 6.0]));
    assert_eq!(report["render"]["lights"], 1, "no sky besides the lamp");
    // Half the height over the distance of the sensor is the tangent of half the field of view.
    let fy = report["camera"]["camera_matrix"][1][1].as_f64().expect("fy");
    assert!((16.0 / fy / 0.25f64.tan() - 1.0).abs() < 1e-9, "{fy}");
}
