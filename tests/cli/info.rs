//! `photosite info` and `photosite sensors`: what they say of every kind of file, as text and as JSON.

use serde_json::{Value, json};

use crate::folder::Folder;
use crate::gltf::triangle;
use crate::room::room;

fn facts(folder: &Folder, name: &str) -> Value {
    serde_json::from_str(&folder.succeed(&format!("info {name} --json")).stdout).expect("JSON")
}

/// The value behind a key in the text.
fn line<'a>(text: &'a str, key: &str) -> &'a str {
    let line = text.lines().find_map(|line| line.strip_prefix(key).filter(|rest| rest.starts_with("  ")));
    line.unwrap_or_else(|| panic!("no {key} in:\n{text}")).trim()
}

#[test]
fn of_a_capture() {
    let folder = room("frames = 2\n[render]\nsamples_per_pixel = 12\n");
    let found = facts(&folder, "capture.toml");
    assert_eq!(found["materials"], json!(["floor", "wall", "lamp", "glass", "gold", "cloth"]));
    assert_eq!(found["emitting_materials"], json!(["lamp"]));
    assert_eq!(found["lights"].as_array().map(Vec::len), Some(1));
    assert_eq!(found["lights"][0]["type"], "spot");
    // Quads are two triangles, the tents 4 and 3; the sail is placed twice.
    assert_eq!((&found["triangles"], &found["triangles_of_instances"]), (&json!(14), &json!(15)));
    assert_eq!((&found["frames"], &found["samples_per_pixel"], &found["textures"]), (&json!(2), &json!(12), &json!(1)));
    let text = folder.succeed("info capture.toml").stdout;
    assert_eq!(line(&text, "materials"), "floor, wall, lamp, glass, gold, cloth");
    assert_eq!(line(&text, "cameras"), "none");
    assert_eq!(line(&text, "environment"), "the picture sky.hdr, 16 × 8 pixels");
    assert_eq!(line(&text, "lens"), "4 mm f/1.4");
    assert_eq!(line(&text, "resolution_px"), "32 × 24");
    assert_eq!(line(&text, "exposure_time_s"), "0.0002");
    assert!(text.lines().all(|line| line.split_whitespace().count() > 1), "no key stands alone:\n{text}");
}

#[test]
fn of_scenes() {
    let camera = json!([{ "name": "front", "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]);
    let with_camera = || {
        let nodes = json!([{ "name": "sail", "mesh": 0 }, { "name": "front", "camera": 0, "translation": [0, 1, 5] }]);
        triangle().with("/cameras", camera.clone()).with("/nodes", nodes).with("/scenes/0/nodes", json!([0, 1]))
    };
    let folder = Folder::new([
        ("a.gltf", with_camera().text()),
        ("a.glb", with_camera().binary()),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl paper\nf 1 2 3\nusemtl ink\nf 3 2 1\n".to_vec()),
    ]);
    for name in ["a.gltf", "a.glb"] {
        let found = facts(&folder, name);
        assert_eq!(
            (&found["cameras"], &found["materials"]),
            (&json!(["front"]), &json!(["cloth", "ground"])),
            "{name}"
        );
        assert_eq!((&found["instances"], &found["camera_position_m"]), (&json!(2), &json!([0.0, 1.0, 5.0])));
        assert_eq!(found["environment"], "the sky by day");
        assert_eq!(line(&folder.succeed(&format!("info {name}")).stdout, "cameras"), "front");
    }
    assert_eq!(facts(&folder, "a.obj")["materials"], json!(["paper", "ink", "ground"]));
    let text = folder.succeed("info a.obj").stdout;
    assert_eq!((line(&text, "meshes"), line(&text, "exposure_time_s")), ("3", "automatic"));
}

#[test]
fn of_results() {
    let folder = room(
        "[render]\nsamples_per_pixel = 2\n[output]\nraw = ['dng', 'tiff']\nirradiance = { bands_nm = [400, 700, 100] }",
    );
    folder.succeed("render capture.toml -o out");
    let raw = folder.raw("out/raw.dng");
    let sum: f64 = raw.data.iter().map(|&dn| f64::from(dn)).sum();
    for name in ["out/raw.dng", "out/raw.tiff"] {
        let found = facts(&folder, name);
        assert_eq!(found["resolution_px"], json!([32, 24]), "{name}");
        assert_eq!(found["minimum_dn"], json!(raw.data.iter().min()), "{name}");
        assert_eq!(found["maximum_dn"], json!(raw.data.iter().max()), "{name}");
        assert_eq!(found["mean_dn"].as_f64(), Some(sum / raw.data.len() as f64), "{name}");
        let text = folder.succeed(&format!("info {name}")).stdout;
        assert_eq!(line(&text, "resolution_px"), "32 × 24", "{name}");
    }
    let dng = facts(&folder, "out/raw.dng");
    assert_eq!((&dng["cfa"], &dng["bits"], &dng["black_level_dn"]), (&json!("RGGB"), &json!(12), &json!(64.0)));
    let close = |key: &str, value: f64| (dng[key].as_f64().expect(key) / value - 1.0).abs() < 1e-6;
    assert!(close("exposure_time_s", 0.0002) && close("f_number", 1.4) && close("focal_length_mm", 4.0), "{dng}");

    let electrons = folder.electrons("out").mean;
    let found = facts(&folder, "out/electrons.exr");
    let names: Vec<&str> =
        found["channels"].as_array().expect("a list").iter().filter_map(|c| c["name"].as_str()).collect();
    assert_eq!(names, ["B", "G", "R", "variance.B", "variance.G", "variance.R"]);
    let greatest = electrons.plane("G").expect("green").iter().copied().fold(0.0, f32::max);
    assert_eq!(found["channels"][1]["maximum"].as_f64(), Some(f64::from(greatest)));
    assert_eq!((&found["unit"], &found["exposureTime"]), (&json!("e-"), &json!(0.0002)));
    let text = folder.succeed("info out/irradiance.exr").stdout;
    for words in ["S0.450,0nm", "S0.550,0nm", "S0.650,0nm", "emissiveUnits  ", "32 × 24"] {
        assert!(text.contains(words), "{words} in {text}");
    }
}

#[test]
fn of_damaged_results() {
    let folder = Folder::new([("a.exr", b"v/1\x01".to_vec()), ("a.dng", b"MM".to_vec()), ("a.tiff", vec![])]);
    folder.fail("info a.exr", 1, &["a.exr: cannot read it as "]);
    for name in ["a.dng", "a.tiff"] {
        folder.fail(&format!("info {name}"), 1, &[&format!("{name}: is no raw file of a kind that photosite knows")]);
    }
}

#[test]
fn of_sensors() {
    let assets = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/sensors");
    let folder = Folder::new([]);
    let rows: Value = serde_json::from_str(&folder.succeed("sensors --json").stdout).expect("JSON");
    let table = folder.succeed("sensors").stdout;
    let rows = rows.as_array().expect("a list");
    assert_eq!(table.lines().count(), rows.len() + 1, "{table}");
    assert_eq!(rows.len(), std::fs::read_dir(assets).expect("sensor files").count(), "{table}");
    for row in rows {
        let name = row["name"].as_str().expect("a name");
        let line = table.lines().find(|line| line.starts_with(name)).expect(name);
        let [columns, lines] = [0, 1].map(|i| row["resolution_px"][i].as_u64().expect("pixels"));
        assert!(line.contains(&format!(" {columns}×{lines} ")), "{line}");
        let found = facts(&folder, &format!("{assets}/{name}.toml"));
        for key in ["name", "resolution_px", "full_well_e", "read_noise_e", "bits", "source"] {
            assert!(!found[key].is_null());
            assert_eq!(found[key], row[key], "{name}: {key}");
        }
    }
}
