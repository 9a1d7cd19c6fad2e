//! Every branch of the exporter against the scenes of the suite: what it can write into a scene file stands in the
//! exported file of a scene, so that a plugin or a mode that is added to it fails here until a scene has it.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// The sources of the exporter: all that it can write is written out in them.
const SOURCES: [&str; 5] = [
    include_str!("../../src/io/mitsuba/sensor.rs"),
    include_str!("../../src/io/mitsuba/shape.rs"),
    include_str!("../../src/io/mitsuba/material.rs"),
    include_str!("../../src/io/mitsuba/light.rs"),
    include_str!("../../src/io/mitsuba/picture.rs"),
];

/// What is not written out as an argument of `Element::object`: shapes by their name, and values of keys.
const OTHERS: [&str; 11] = [
    "sphere",
    "disk",
    "cylinder",
    "nearest",
    "bilinear",
    "repeat",
    "mirror",
    "clamp",
    "volpath",
    "path",
    "spectrum:uniform",
];

/// Combinations, each as pieces of text that one exported file has together.
const COMBINATIONS: [(&str, &[&str]); 15] = [
    ("a sky with its sun", &["\"sunsky\"", "name=\"sun_scale\" value=\"1\""]),
    ("a sky without its sun", &["\"sunsky\"", "name=\"sun_scale\" value=\"0\""]),
    ("holes before a point light", &["\"volpath\"", "\"mask\"", "\"point\""]),
    ("holes before a spot light", &["\"volpath\"", "\"mask\"", "\"spot\""]),
    ("holes before a directional light", &["\"volpath\"", "\"mask\"", "\"directional\""]),
    ("holes before an environment", &["\"volpath\"", "\"mask\"", "\"constant\""]),
    ("holes of one opacity", &["<float name=\"opacity\""]),
    ("holes of a texture", &["name=\"opacity\">"]),
    ("a normal map seen from behind", &["\"normalmap\"", "-normal-behind.exr"]),
    ("a normal map on tangents of the other hand", &["\"normalmap\"", "-left.ply"]),
    ("both", &["\"normalmap\"", "-normal-left-behind.exr"]),
    ("grooves", &["\"roughconductor\"", "name=\"alpha_u\""]),
    ("a smooth mesh", &["name=\"face_normals\" value=\"false\""]),
    ("a flat mesh", &["name=\"face_normals\" value=\"true\""]),
    ("an instance of a group", &["\"shapegroup\"", "\"instance\""]),
];

/// The scene files that the exporter makes of the suite.
fn exported() -> Vec<String> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mitsuba/scenes");
    let out = tempfile::tempdir().expect("a temporary folder");
    let export = |folder: std::io::Result<std::fs::DirEntry>| {
        let folder = folder.expect("an entry");
        let to = out.path().join(folder.file_name());
        let export = Command::new(env!("CARGO_BIN_EXE_photosite"))
            .args(["export-mitsuba", "--approximate", "--quiet", "-o"])
            .args([&to, &folder.path().join("capture.toml")])
            .output()
            .expect("the command starts");
        assert!(export.status.success(), "{}", String::from_utf8_lossy(&export.stderr));
        std::fs::read_to_string(to.join("scene.xml")).expect("a scene file")
    };
    std::fs::read_dir(scenes).expect("the suite").map(export).collect()
}

/// Types of plugins that the sources write out: the second argument of `Element::object`, both of a choice.
fn plugins() -> BTreeSet<&'static str> {
    let call = |text: &'static str| text.split_once(", ").map(|(_, kind)| kind).and_then(|kind| kind.strip_prefix('"'));
    let calls = SOURCES.iter().flat_map(|source| source.split("Element::object(").skip(1));
    calls.filter_map(call).filter_map(|kind| kind.split_once('"')).map(|(kind, _)| kind).collect()
}

#[test]
fn the_suite_has_every_branch_of_the_exporter() {
    let files = exported();
    let plugins = plugins();
    assert!(plugins.len() > 20, "the sources are read: {plugins:?}");
    let others = OTHERS.map(|name| name.rsplit(':').next().unwrap_or(name));
    let lacks = |name: &&str| !files.iter().any(|file| file.contains(&format!("\"{name}\"")));
    let missing: BTreeSet<&str> = plugins.into_iter().chain(others).filter(lacks).collect();
    assert!(missing.is_empty(), "no scene of the suite has {missing:?}");
}

#[test]
fn the_suite_has_combinations_of_branches() {
    let files = exported();
    for (what, pieces) in COMBINATIONS {
        let has_all = |file: &String| pieces.iter().all(|piece| file.contains(piece));
        assert!(files.iter().any(has_all), "no scene of the suite has {what}");
    }
}
