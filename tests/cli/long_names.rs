//! Names of 100 kB in files of strangers: what commands print of them for people stays short, and none panics.

use rstest::rstest;
use serde_json::json;

use crate::folder::Folder;

const OWN: &str = include_str!("../../crates/photosite-sensor/assets/sensors/andor-zyla-55.toml");

/// Files that name everything they can name with a word of so many letters, or with so many words.
fn folder(name: &str) -> Folder {
    let word = name.replace(' ', "_");
    let obj = format!(
        "mtllib {word}.mtl\nmtllib room.mtl\no {name}\ng {name}\nusemtl {name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n\
         o second\nusemtl second\nf 1 3 2\n"
    );
    let zero = "AAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAA==";
    let gltf = json!({
        "asset": { "version": "2.0", "generator": name },
        "extensionsUsed": [name],
        "scene": 0,
        "scenes": [{ "nodes": [0], "name": name }],
        "nodes": [{ "name": name, "mesh": 0 }],
        "meshes": [{ "name": name, "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "materials": [{ "name": name, "extensions": { name: {} } }],
        "cameras": [{ "name": name, "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36, "uri": format!("data:application/octet-stream;base64,{zero}") }],
    });
    let capture = |geometry: &str, more: &str| {
        format!(
            "[scene]\ngeometry = [{geometry}]\nenvironment = {{ illuminant = 'D65' }}\n[camera]\nposition_m = [0.3, 0.3, 3]\n\
             look_at_m = [0.3, 0.3, 0]\n[sensor]\npreset = 'generic-cmos-color'\nresolution_px = [8, 6]\n[render]\n\
             samples_per_pixel = 1\nmax_depth = 1\n[output]\nobjects = true\ntruth = ['depth']\n{more}"
        )
    };
    let zmx = format!(
        "MODE SEQ\nNAME {name}\nNOTE 0 {name}\nUNIT MM X W X CM MR CPMM\nENPD 5\nWAVM 1 0.5876 1\nPWAV 1\nSURF 0\n  CURV 0\n  \
         DISZ INFINITY\nSURF 1\n  COMM {name}\n  STOP\n  CURV 0.02\n  DISZ 4\n  GLAS N-BK7 0 0 1.5168 64.17\n  DIAM 10\nSURF 2\n  \
         CURV -0.02\n  DISZ 48\n  DIAM 10\nSURF 3\n  CURV 0\n  DISZ 0\n"
    );
    Folder::new([
        ("room.obj", obj.into_bytes()),
        ("room.mtl", format!("newmtl {name}\nKd 1 0 0\nnewmtl second\nKd 0 1 0\n").into_bytes()),
        ("room.gltf", gltf.to_string().into_bytes()),
        ("capture.toml", capture("'room.obj'", "").into_bytes()),
        ("gltf.toml", capture("'room.gltf'", "").into_bytes()),
        ("file.toml", capture(&format!("'{name}'"), "").into_bytes()),
        ("key.toml", capture("'room.obj'", &format!("['{name}']\na = 1\n")).into_bytes()),
        ("value.toml", capture("'room.obj'", &format!("raw = ['{name}']\n")).into_bytes()),
        ("capture.json", json!({ "photosite_version": name, name: { name: 1 } }).to_string().into_bytes()),
        ("lens.zmx", zmx.into_bytes()),
        ("sensor.toml", OWN.replacen("description = \"", &format!("description = \"{name} "), 1).into_bytes()),
    ])
}

#[rstest]
fn names_in_texts_for_people_are_cut(#[values("word", "words")] kind: &str) {
    let folder = folder(&if kind == "word" { "n".repeat(100_000) } else { "n ".repeat(50_000).trim_end().to_owned() });
    for command in [
        "info room.obj",
        "info room.gltf",
        "info capture.toml",
        "info gltf.toml",
        "info file.toml",
        "info key.toml",
        "info value.toml",
        "info capture.json",
        "info sensor.toml",
        "init room.obj -o of-obj.toml",
        "init room.gltf -o of-gltf.toml",
        "lens lens.zmx",
        "lens lens.zmx -o lens.toml",
        "lens lens.toml",
        "render capture.toml -o r",
        "render gltf.toml -o g",
        "info r/capture.json",
        "info r/objects.json",
        "info r/truth.exr",
        "expose r -o e",
        "expose r -o e2 --set sensor.preset=sensor.toml",
        "export-mitsuba capture.toml -o m --approximate",
        "export-mitsuba gltf.toml -o mg --approximate",
        "camera capture.toml --format opencv",
        "measure histogram r/image.png",
        "compare r/image.png g/image.png",
        "emva1288 sensor.toml --size 12x8 --steps 5 --spatial 3 -o sets",
        "emva1288-report sets",
    ] {
        let outcome = folder.run(command);
        assert!(
            [Some(0), Some(1), Some(2), Some(3)].contains(&outcome.status),
            "{command} of a {kind}: {:?}",
            outcome.status
        );
        let (stdout, stderr) = (outcome.stdout.len(), outcome.stderr.len());
        let begins = |text: &str| text.chars().take(300).collect::<String>();
        assert!(stdout < 20_000, "{command} of a {kind} prints {stdout} bytes: {}", begins(&outcome.stdout));
        assert!(stderr < 20_000, "{command} of a {kind} says {stderr} bytes: {}", begins(&outcome.stderr));
    }
}
