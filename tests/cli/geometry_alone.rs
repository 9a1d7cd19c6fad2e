//! A scene file given directly: a camera that frames it, a clear day, the default lens and sensor, automatic exposure;
//! and `photosite init`, which writes that out.

use glam::{DVec2, DVec3};
use rstest::rstest;
use serde_json::{Value, json};

use crate::folder::Folder;
use crate::gltf::{Document, triangle};
use crate::report::project;

const TO_THE_SKY: &str = "--set camera.position_m=[0,1,9] --set camera.look_at_m=[0,9,9.5]";
const SMALL: &str = "--set sensor.resolution_px=[48,32] --set render.samples_per_pixel=64";

/// The triangle of `gltf::triangle`.
const CORNERS: [DVec3; 3] = [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(1.0, 0.0, 0.0), DVec3::new(0.0, 1.5, 0.0)];

/// The triangle in files of every kind; z is up in that of STL.
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
            b"solid sail\nfacet normal 0 -1 0\nouter loop\nvertex -1 0 0\nvertex 1 0 0\nvertex 0 0 1.5\nendloop\nendfacet\n\
              endsolid sail\n"
                .to_vec(),
        ),
        ("sail.gltf", triangle().text()),
        ("sail.glb", triangle().binary()),
    ])
}

/// The triangle, a camera, and nodes beside the triangle's.
fn with_camera(nodes: &[Value]) -> Document {
    let nodes: Vec<Value> = [json!({ "mesh": 0 })].iter().chain(nodes).cloned().collect();
    triangle()
        .with("/cameras", json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]))
        .with("/scenes/0/nodes", (0..nodes.len()).collect())
        .with("/nodes", nodes.into())
}

/// The triangle in front of a camera, with a lamp.
fn with_camera_and_lamp() -> Document {
    let lamp = json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } }, "translation": [1, 2, 3] });
    with_camera(&[json!({ "camera": 0, "translation": [0, 0.5, 6] }), lamp])
        .with("/extensions", json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 500 }] } }))
        .with("/extensionsUsed", json!(["KHR_lights_punctual"]))
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
    // image, and they take up a good part of it.
    let pixels = CORNERS.map(|corner| project(&report["camera"], corner));
    let (low, high) = (pixels[0].min(pixels[1]).min(pixels[2]), pixels[0].max(pixels[1]).max(pixels[2]));
    assert!(low.cmpge(DVec2::ZERO).all() && high.cmple(DVec2::new(47.0, 31.0)).all(), "{low} to {high}");
    assert!((high - low).max_element() > 0.5 * 32.0, "{low} to {high}");
    // It is in focus: the distance along the axis to the middle of the bounding box.
    let focus = report["lens"]["focus_distance_m"].as_f64().expect("a distance");
    let position: [f64; 3] = serde_json::from_value(report["camera"]["position_m"].clone()).expect("a position");
    let distance = (DVec3::from_array(position) - DVec3::new(0.0, 0.75, 0.0)).length();
    // Places have six digits of the distance: along the axis, and in the direction of the axis, each to 1e-5 of it.
    assert!((focus / distance - 1.0).abs() < 2e-5, "{focus} m, not {distance} m");
}

#[test]
fn even_light_is_one_word() {
    let folder = folder();
    // Facing the sky, without a surface in the way of most of the image.
    folder.succeed(&format!("render sail.obj {SMALL} {TO_THE_SKY} --set scene.environment=even"));
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
    // In a capture file it is the same word.
    folder.succeed(&format!("render capture.toml -o word {SMALL} {TO_THE_SKY} --set scene.environment=even"));
    assert_eq!(folder.results("word")["electrons.exr"], folder.results("capture")["electrons.exr"]);
    // There is no ground with it.
    assert_eq!(report["capture"]["scene"].get("ground"), None);
    folder.fail("render sail.obj -o x --set scene.environment=evn", 1, &["unknown environment \"evn\"", "\"even\""]);
}

#[test]
fn a_scene_with_a_camera_and_lights_keeps_them() {
    let folder = Folder::new([("a.gltf", with_camera_and_lamp().text())]);
    folder.succeed(&format!("render a.gltf -o out {SMALL}"));
    let report = folder.report("out");
    assert_eq!(report["camera"]["position_m"], json!([0.0, 0.5, 6.0]));
    assert_eq!(report["render"]["lights"], 1, "no sky besides the lamp");
    assert_eq!(report["capture"]["scene"].get("ground"), None, "nor a ground");
    // Half the height over the distance of the sensor is the tangent of half the field of view.
    let fy = report["camera"]["camera_matrix"][1][1].as_f64().expect("fy");
    assert!((16.0 / fy / 0.25f64.tan() - 1.0).abs() < 1e-9, "{fy}");
}

/// Where the sun stands that lights a scene, seen from the camera: the angle to the left of the view, degrees.
fn sun_left_of_view(report: &Value) -> f64 {
    let azimuth = report["capture"]["scene"]["environment"]["sky"]["sun_azimuth_deg"].as_f64().expect("an azimuth");
    // The third row of world → camera is the axis, from the camera on; north is −Z, east +X.
    let axis: [f64; 3] = serde_json::from_value(report["camera"]["rotation"][2].clone()).expect("three numbers");
    let towards_camera = (-axis[0]).atan2(axis[2]).to_degrees();
    (azimuth - towards_camera).rem_euclid(360.0)
}

#[test]
fn a_scene_without_lights_gets_a_clear_day_from_the_left_of_its_camera_and_a_ground() {
    // Turned by 180° about y: it looks along +Z.
    let backwards = with_camera(&[json!({ "camera": 0, "translation": [0, 0.5, -6], "rotation": [0, 1, 0, 0] })]);
    let folder = folder();
    folder.add("back.gltf", backwards.text());
    for name in ["sail.obj", "back.gltf"] {
        folder.succeed(&format!("render {name} -o out --force {SMALL} --set output.truth=['instance']"));
        let report = folder.report("out");
        assert!((sun_left_of_view(&report) - 50.0).abs() <= 0.5, "{name}: {}", sun_left_of_view(&report));
        let sky = &report["capture"]["scene"]["environment"]["sky"];
        assert_eq!(sky["ground_albedo"], report["capture"]["scene"]["ground"]["reflectance"]);
        let instances = report["truth"]["instances"].as_array().expect("a list").clone();
        assert_eq!(instances.last(), Some(&json!("ground")), "{instances:?}");
        // Just below the lowest point, which is at 0.
        let height = report["truth"]["instances_to_world"][instances.len() - 1][1][3].as_f64().expect("a height");
        assert!((-4e-4..0.0).contains(&height), "{name}: {height} m");
    }
    // A time, another metering and an environment of its own stay.
    let keys = |more: &str| {
        folder.succeed(&format!("render sail.obj -o out --force {SMALL} {more}"));
        folder.report("out")["capture"].clone()
    };
    assert_eq!(keys("--set exposure.time_s=0.001")["exposure"], json!({ "time_s": 0.001 }));
    assert_eq!(keys("--set exposure.auto_target=0.5")["exposure"], json!({ "auto_target": 0.5 }));
    assert_eq!(keys("--set scene.ground=false")["scene"]["ground"], json!(false));
    let studio = keys("--set scene.backdrop={} --set output.truth=['instance']");
    assert_eq!(studio["scene"].get("ground"), None);
    assert_eq!(
        folder.report("out")["truth"]["instances"].as_array().and_then(|all| all.last()),
        Some(&json!("backdrop"))
    );
    assert_eq!(keys("--set scene.environment={illuminant='A',illuminance_lux=9}")["scene"].get("ground"), None);
    // A key of the sky changes that one alone; where the sun is placed, all else is that of captures.
    let scene = keys("--set scene.environment.sky.turbidity=6")["scene"].clone();
    let sky = json!({ "turbidity": 6, "sun_elevation_deg": 40.0, "ground_albedo": 0.3 });
    for (key, value) in sky.as_object().expect("a table") {
        assert_eq!(&scene["environment"]["sky"][key], value, "{key}");
    }
    assert_eq!(scene["ground"], json!({ "reflectance": 0.3 }));
    let scene = keys("--set scene.environment.sky.sun_elevation_deg=20")["scene"].clone();
    assert_eq!(scene["environment"]["sky"], json!({ "sun_elevation_deg": 20 }));
    assert_eq!(scene.get("ground"), None);
}

#[test]
fn what_init_writes_gives_the_same_images() {
    let folder = folder();
    let named = json!({ "camera": 0, "name": "a \"b\"", "translation": [0.1, 0.5, 6] });
    folder.add("camera.gltf", with_camera(&[named]).text());
    folder.add("both.gltf", with_camera_and_lamp().text());
    folder.add("models/far off.obj", "v 1e5 2e4 -3e5\nv 100047.3 2e4 -3e5\nv 1e5 20011.7 -300003.1\nf 1 2 3\n");
    for (model, capture) in [
        ("sail.obj", "sail.toml"),
        ("sail.glb", "new/sail.toml"),
        ("camera.gltf", "camera.toml"),
        ("both.gltf", "both.toml"),
        ("models/far off.obj", "models/off.toml"),
    ] {
        std::fs::create_dir_all(folder.path(capture).parent().expect("a folder")).expect("made");
        let mut init = folder.command("init");
        let said = init.arg(model).args(["-o", capture]).output().expect("the binary runs");
        let said = String::from_utf8_lossy(&said.stderr).into_owned();
        assert_eq!(model.ends_with("obj"), said.contains("metres are assumed"), "{said}");
        let small = ["--size", "48x36", "--spp", "4", "--force", "--set", "output.truth=['instance','depth']"];
        for (input, output) in [(model, "alone"), (capture, "file")] {
            let mut render = folder.command("render");
            let outcome = render.arg(input).args(["-o", output]).args(small).output().expect("the binary runs");
            assert!(outcome.status.success(), "{input}: {}", String::from_utf8_lossy(&outcome.stderr));
        }
        let [mut alone, mut file] = ["alone", "file"].map(|name| folder.results(name));
        for report in [&mut alone, &mut file] {
            assert!(report.remove("capture.json").is_some());
        }
        assert!(alone == file && alone.len() == 4, "{model}: {:?}", alone.keys());
        let text = folder.text(capture);
        let keys = text.lines().filter(|line| line.contains(" = "));
        assert!(
            keys.clone().count() > 20 && keys.clone().all(|line| line.contains("  # ")),
            "a comment on each key: {text}"
        );
    }
    // Without a file it is printed, for one in the current folder.
    let printed = folder.succeed("init sail.obj").stdout;
    assert_eq!(printed, folder.text("sail.toml"));
    folder.fail("init sail.obj -o sail.toml", 2, &["sail.toml already exists", "--force"]);
    folder.fail("init sail.toml", 1, &["sail.toml", "is not a scene file"]);
}
