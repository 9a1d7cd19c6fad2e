//! The files of `tests/gltf`, one for each feature of glTF: thumbnails against stored ones.
//!
//! Both are Monte Carlo estimates with the variance of each pixel, so the verdict is that of `photosite compare`: no
//! pixel and no mean is further off than noise explains (Šidák's correction, α = 0.01 for all pixels of a file). After
//! a change that is meant to change images, look at them, then store them anew with another seed than the test's:
//! `for f in tests/gltf/*.gltf; do photosite render tests/gltf/capture.toml …` as [`render`] has it, and the
//! `electrons.exr` of each as `tests/gltf/expected/NAME.exr`.

use std::path::{Path, PathBuf};

use super::folder::Folder;

fn folder_of_files() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gltf")
}

/// The arguments that render the file of that name into `out`. Animations are seen for half of their time.
fn render(name: &str, seed: u32, out: &str) -> String {
    let capture = folder_of_files().join("capture.toml");
    let moving = "--set scene.animation=move --set scene.animation_time_s=0.25 --set exposure.time_s=0.5 ";
    let moving = if name.starts_with("animation") { moving } else { "" };
    format!(
        "render {} {moving}--quiet --seed {seed} --set scene.geometry=[\"{name}.gltf\"] -o {out}",
        capture.to_str().expect("UTF-8")
    )
}

#[test]
fn every_feature_looks_as_it_did() {
    let files = folder_of_files();
    let mut names: Vec<String> = std::fs::read_dir(&files)
        .expect("the folder of files")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "gltf"))
        .map(|path| path.file_stem().expect("a name").to_str().expect("UTF-8").to_owned())
        .collect();
    names.sort();
    assert!(names.len() >= 31, "{names:?}");
    let folder = Folder::new([]);
    let mut wrong = Vec::new();
    for name in &names {
        let outcome = folder.run(&render(name, 1, name));
        if outcome.status != Some(0) {
            wrong.push(format!("{name}: {}", outcome.stderr));
            continue;
        }
        let expected = files.join("expected").join(format!("{name}.exr"));
        let expected = expected.to_str().expect("UTF-8");
        let outcome = folder.run(&format!("compare {name}/electrons.exr {expected}"));
        if outcome.status != Some(0) {
            wrong.push(format!("{name}: {}{}", outcome.stdout, outcome.stderr));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn features_are_told_apart() {
    // The test above would notice a feature that is ignored: each differs from the plain ball.
    let folder = Folder::new([]);
    folder.succeed(&render("plain", 1, "plain"));
    for name in ["sheen", "clearcoat", "iridescence", "transmission", "morph-target", "vertex-colours"] {
        let expected = folder_of_files().join("expected").join(format!("{name}.exr"));
        let outcome = folder.run(&format!("compare plain/electrons.exr {}", expected.to_str().expect("UTF-8")));
        assert_eq!(outcome.status, Some(1), "{name}: {}", outcome.stdout);
    }
}

/// The node goes from x = −0.8 to 0.8 m within a second, turns by 90° about z and changes its shape meanwhile.
#[test]
fn objects_that_move_are_told_where_they_are_halfway() {
    let folder = Folder::new([]);
    let truth = "--set output.truth=[\"instance\"] --set render.samples_per_pixel=1";
    folder.succeed(&format!("{} {truth}", render("animation-node", 1, "out")));
    let report = folder.report("out");
    let time = 0.25 + report["camera"]["pose_time_s"].as_f64().expect("a time");
    // With a global shutter; rows that follow each other are halfway somewhat later.
    assert!((0.5..0.52).contains(&time), "{time}");
    let truth = &report["truth"];
    let names = truth["instances"].as_array().expect("names");
    let moving = names.iter().position(|name| name == "ball").expect("the ball");
    let entry =
        |row: usize, column: usize| truth["instances_to_world"][moving][row][column].as_f64().expect("a number");
    // Between keys, of which an exposure has many, a turn at a constant rate and a shape on a straight line are exact.
    let (angle, [along, across]) = (time * std::f64::consts::FRAC_PI_2, [0.4 + 0.6 * time, 1.0 - 0.6 * time]);
    let expected = [
        [angle.cos() * along, -angle.sin() * across, 0.0, -0.8 + 1.6 * time],
        [angle.sin() * along, angle.cos() * across, 0.0, 1.0],
        [0.0, 0.0, 1.0, 0.0],
    ];
    for (row, column) in (0..3).flat_map(|row| (0..4).map(move |column| (row, column))) {
        // Keys come from numbers of single precision.
        assert!((entry(row, column) - expected[row][column]).abs() < 1e-6, "{row}, {column}: {}", entry(row, column));
    }
}
