//! `photosite info` and `photosite sensors`: what they say of every kind of file, as text and as JSON.

use serde_json::{Value, json};

use crate::folder::Folder;
use crate::gltf::triangle;
use crate::room::room;

fn facts(folder: &Folder, name: &str) -> Value {
    folder.succeed(&format!("info {name} --json")).json()
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
    assert_eq!(line(&text, "environment"), "the image sky.hdr, 16 × 8 pixels");
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
        folder.fail(
            &format!("info {name}"),
            1,
            &[&format!("{name}: is not a raw file of a kind that photosite knows")],
        );
    }
}

#[test]
fn of_sensors() {
    let assets = concat!(env!("CARGO_MANIFEST_DIR"), "/crates/photosite-sensor/assets/sensors");
    let folder = Folder::new([]);
    let rows = folder.succeed("sensors --json").json();
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

#[test]
fn how_large_a_scene_is() {
    let capture = "[scene]\ngeometry = ['a.obj', 'a.gltf', 'b.ply']\nmeters_per_unit = 0.5\n\
        [[scene.spheres]]\nmaterial = 'paper'\nposition_m = [0, 5, 0]\nradius_m = 0.5\n\
        [[scene.disks]]\nname = 'lid'\nmaterial = 'paper'\nposition_m = [0, 0, 0]\nnormal = [0, 2, 0]\nradius_m = 3\n\
        [[scene.cylinders]]\nname = 'stick'\nmaterial = 'paper'\nposition_m = [1, 0, 0]\naxis = [1, 0, 0]\nradius_m = 0.25\nlength_m = 4\n";
    let moved = triangle().with("/nodes/0/translation", json!([0, 0, -2])).with("/nodes/0/scale", json!([2, 1, 1]));
    let folder = Folder::new([
        // The last vertex is no corner of anything.
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 99 99 99\nusemtl paper\nf 1 2 3\n".to_vec()),
        ("a.gltf", moved.text()),
        (
            "b.ply",
            b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
              property list uchar int vertex_indices\nend_header\n0 0 -1\n4 0 -1\n0 4 -1\n50 50 50\n3 0 1 2\n"
                .to_vec(),
        ),
        ("capture.toml", capture.into()),
    ]);
    let found = facts(&folder, "capture.toml");
    let object = |name: &str, min: [f64; 3], max: [f64; 3]| {
        let size: Vec<f64> = max.iter().zip(min).map(|(high, low)| high - low).collect();
        json!({ "name": name, "min_m": min, "max_m": max, "size_m": size })
    };
    let objects = [
        object("paper", [0.0, 0.0, 0.0], [0.5, 0.5, 0.0]),
        object("sail", [-2.0, 0.0, -2.0], [2.0, 1.5, -2.0]),
        object("b", [0.0, 0.0, -0.5], [2.0, 2.0, -0.5]),
        object("sphere-0", [-0.5, 4.5, -0.5], [0.5, 5.5, 0.5]),
        object("lid", [-3.0, 0.0, -3.0], [3.0, 0.0, 3.0]),
        object("stick", [-1.0, -0.25, -0.25], [3.0, 0.25, 0.25]),
    ];
    let close = |a: &Value, b: &Value| (a.as_f64().expect("a number") - b.as_f64().expect("a number")).abs() < 1e-12;
    let same = |found: &Value, expected: &Value| {
        ["min_m", "max_m", "size_m"].iter().all(|key| (0..3).all(|i| close(&found[key][i], &expected[key][i])))
    };
    let list = found["objects"].as_array().expect("a list");
    assert_eq!(list.len(), objects.len());
    for (found, expected) in list.iter().zip(&objects) {
        assert!(found["name"] == expected["name"] && same(found, expected), "{found} is not {expected}");
    }
    assert!(
        same(&found["bounding_box"], &object("", [-3.0, -0.25, -3.0], [3.0, 5.5, 3.0])),
        "{}",
        found["bounding_box"]
    );
    let unit = |file: &str, unit_m: f64, from: &str| json!({ "file": file, "unit_m": unit_m, "unit_from": from });
    let units =
        [unit("a.obj", 0.5, "meters_per_unit"), unit("a.gltf", 1.0, "glTF"), unit("b.ply", 0.5, "meters_per_unit")];
    assert_eq!(found["geometry"], json!(units));
    let text = folder.succeed("info capture.toml").stdout;
    for words in ["b.ply      0.5  meters_per_unit", "size_m  6, 5.75, 6", "sail", "-2, 0, -2"] {
        assert!(text.contains(words), "{words} in\n{text}");
    }
}

#[test]
fn many_objects_are_cut_off_for_people() {
    let nodes: Vec<Value> = (0..50).map(|i| json!({ "mesh": 0, "translation": [i, 0, 0] })).collect();
    let indices: Vec<usize> = (0..50).collect();
    let folder = Folder::new([(
        "a.gltf",
        triangle().with("/nodes", json!(nodes)).with("/scenes/0/nodes", json!(indices)).text(),
    )]);
    assert_eq!(facts(&folder, "a.gltf")["objects"].as_array().map(Vec::len), Some(50));
    assert!(folder.succeed("info a.gltf").stdout.contains("and 10 more, which --json lists"));
}

/// A triangle of 30 × 40 units.
const LARGE: &str = "v 0 0 0\nv 30 0 0\nv 0 40 0\nf 1 2 3\n";

#[test]
fn units_that_are_hardly_metres_are_told_of() {
    let facet = |x: f32| {
        format!(
            "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex {x} 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n"
        )
    };
    let long = |x: f32| triangle().with("/nodes/0/scale", json!([x, 1, 1])).text();
    let folder = Folder::new([
        ("large.obj", LARGE.into()),
        ("part.stl", facet(20.5).into()),
        ("small.stl", facet(20.0).into()),
        ("hall.gltf", long(50.0)),
        ("train.gltf", long(50.5)),
        ("capture.toml", b"[scene]\ngeometry = ['small.stl', 'large.obj']\n[camera]\nposition_m = [0, 0, 9]\nlook_at_m = [0, 0, 0]\n".to_vec()),
        ("stated.toml", b"[scene]\ngeometry = ['large.obj']\nmeters_per_unit = 1\n".to_vec()),
    ]);
    let doubts = |name: &str| {
        let found = facts(&folder, name)["warnings"].clone();
        let doubtful = |warning: &&Value| warning.as_str().is_some_and(|text| text.contains(" m in size, as "));
        found.as_array().expect("a list").iter().filter(doubtful).cloned().collect::<Vec<_>>()
    };
    assert_eq!(
        doubts("large.obj"),
        ["the scene is 30 × 40 × 0 m in size, as large.obj states no unit and is taken to be in metres: write \
          scene.meters_per_unit = 0.001 for millimetres, 0.01 for centimetres, 0.0254 for inches, or 1 if this is right"]
    );
    assert_eq!(doubts("part.stl").len(), 1);
    assert_eq!(doubts("small.stl").len(), 0);
    assert_eq!(doubts("hall.gltf").len(), 0);
    assert_eq!(
        doubts("train.gltf"),
        ["the scene is 101 × 1.5 × 0 m in size, as glTF is in metres: if it is not, export it in metres"]
    );
    assert_eq!(doubts("capture.toml").len(), 1);
    assert_eq!(doubts("stated.toml").len(), 0);

    // Whoever renders such a model alone is told, too; who has placed a camera knows.
    let small = "--set sensor.resolution_px=[8,6] --set render.samples_per_pixel=1";
    let told =
        |arguments: &str| folder.succeed(&format!("render {arguments} {small}")).stderr.contains("states no unit");
    assert!(told("large.obj -o a"));
    assert!(!told("large.obj -o b --set scene.meters_per_unit=1"));
    assert!(!told(
        "capture.toml -o c --set scene.environment.illuminant=D65 --set scene.environment.illuminance_lux=500"
    ));
}
