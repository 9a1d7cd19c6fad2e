//! Variation from frame to frame of a data set: lights, materials, files, several keys at once; each frame alone.

use std::collections::BTreeSet;

use rstest::rstest;
use serde_json::Value;

use crate::dataset::{BOARD, files, manifest, sky};
use crate::folder::Folder;

/// The board with two lamps and a ball.
fn lit_board() -> String {
    let scene =
        "[scene]\nspheres = [{ name = 'ball', material = 'paint=a', position_m = [0, 0, 0.1], radius_m = 0.03 }]\n";
    BOARD.replace("[scene]\n", scene)
        + "\
[materials.'paint=a']
type = 'plastic'
reflectance = 0.5
[[lights]]
type = 'point'
name = 'key'
position_m = [0, 1, 1]
intensity_cd = 100
[[lights]]
type = 'spot'
name = 'fill'
position_m = [1, 1, 1]
look_at_m = [0, 0, 0]
outer_angle_deg = 60
intensity_cd = 100
"
}

const VARIED: &str = "\
frames = 6
seed = 3
[[vary]]
choices = [
    { 'scene.environment' = { image = 'skies/day.hdr', nit_per_unit = 100 }, 'exposure.time_s' = 0.004 },
    { 'scene.environment' = { image = 'skies/night.hdr', nit_per_unit = 10 }, 'exposure.time_s' = 0.008 },
]
weights = [2, 1]
[[vary]]
key = 'scene.environment.rotation_deg'
uniform = [0, 360]
[[vary]]
key = 'lights.*.on'
count = [0, 2]
[[vary]]
key = 'lights.key.position_m'
sphere = { center_m = [0, 0, 0], radius_m = [1, 2], up = [0, 0, 1], angle_deg = [0, 90] }
[[vary]]
key = 'lights.*.intensity_cd'
log_uniform = [10, 1000]
[[vary]]
key = 'lights.fill.direction'
sphere = { up = [0, 0, -1], angle_deg = [0, 30] }
[[vary]]
key = 'materials.paint*.reflectance'
hsv = { hue_deg = [0, 120], saturation = [0.5, 1] }
[[vary]]
key = 'materials.paint*.roughness'
uniform = [0, 1]
[[vary]]
key = 'targets.board.position_m'
box = [[-0.02, -0.02, -0.1], [0.02, 0.02, 0]]
";

fn folder(dataset: &str) -> Folder {
    // Of the environment only what the set gives stays.
    let board = lit_board().replace("environment = { illuminant = 'D65', illuminance_lux = 500 }\n", "");
    Folder::new([
        ("board.toml", board.into()),
        ("set.toml", format!("capture = 'board.toml'\n{dataset}").into()),
        ("skies/day.hdr", sky(200)),
        ("skies/night.hdr", sky(20)),
    ])
}

/// The files of an image that do not depend on where and how long it was made.
fn image(folder: &Folder, name: &str) -> [Vec<u8>; 2] {
    let results = folder.results(name);
    ["raw.dng", "image.png"].map(|file| results[file].clone())
}

#[test]
fn each_frame_is_rendered_alone_from_what_the_manifest_says() {
    let folder = folder(VARIED);
    folder.succeed("dataset set.toml -o out --quiet");
    let lines = manifest(&folder, "out");
    assert_eq!(lines.len(), 6);
    for (i, line) in lines.iter().enumerate() {
        let name = format!("out/camera/{i:06}");
        let original = image(&folder, &name);
        let mut command = folder.command(&format!("render board.toml -o alone-{i} --quiet"));
        for change in line["overrides"].as_array().expect("a list") {
            command.arg("--set").arg(change.as_str().expect("a text"));
        }
        assert!(command.status().expect("run").success());
        assert!(image(&folder, &format!("alone-{i}")) == original, "frame {i} by its changes");
        folder.succeed(&format!("render {name}/capture.json -o again-{i} --quiet"));
        assert!(image(&folder, &format!("again-{i}")) == original, "frame {i} by its report");
    }
    let images: BTreeSet<_> = (0..6).map(|i| image(&folder, &format!("out/camera/{i:06}"))).collect();
    assert_eq!(images.len(), 6);
    // What was drawn stands in the manifest as values.
    for line in &lines {
        let varied = line["varied"].as_object().expect("a table");
        assert_eq!(varied.len(), 2 + 1 + 2 + 1 + 2 + 1 + 1 + 1 + 1, "{varied:?}");
        let is_lit = |name: &str| varied[&format!("lights.{name}.on")].as_bool().expect("a switch");
        let report =
            folder.report(line["folder"].as_str().map(|name| format!("out/{name}")).as_deref().expect("a folder"));
        let lights = report["capture"]["lights"].as_array().expect("lights");
        assert_eq!([lights[0]["on"].as_bool(), lights[1]["on"].as_bool()], [Some(is_lit("key")), Some(is_lit("fill"))]);
        assert_eq!(report["capture"]["lights"][0]["intensity_cd"], varied["lights.key.intensity_cd"]);
        assert!(lights[1].get("look_at_m").is_none() && lights[1]["direction"] == varied["lights.fill.direction"]);
        assert_eq!(report["capture"]["materials"]["paint=a"]["roughness"], varied["materials.\"paint=a\".roughness"]);
        assert!(varied["scene.environment"]["image"].as_str().expect("a file").starts_with("skies/"));
        let height = varied["lights.key.position_m"][2].as_f64().expect("a number");
        assert!((0.0..=2.0).contains(&height));
    }
}

#[test]
fn frames_made_apart_are_those_made_together() {
    let folder = folder(&VARIED.replace("seed = 3", "seed = 3\nsampling = 'latin-hypercube'"));
    folder.succeed("dataset set.toml -o whole --quiet");
    folder.succeed("dataset set.toml -o parts --quiet --frames 3..6");
    folder.succeed("dataset set.toml -o parts --quiet");
    assert_eq!(files(&folder, "whole"), files(&folder, "parts"));
}

#[test]
fn a_latin_hypercube_hits_every_stratum_of_every_number_once() {
    const FRAMES: usize = 12;
    let distributions = "[[vary]]\nkey = 'exposure.time_s'\nuniform = [0.001, 0.013]\n\
                [[vary]]\nkey = 'lights.*.intensity_cd'\nlog_uniform = [1, 4096]\n\
                [[vary]]\nkey = 'targets.board.position_m'\nbox = [[0, 0, -0.12], [0.12, 0.12, 0]]\n\
                [[vary]]\nkey = 'lights.key.illuminant'\nchoice = ['A', 'D65', 'D50']\n";
    let set = |more: &str| format!("frames = {FRAMES}\n{more}\n{distributions}");
    let folder = folder(&set("sampling = 'latin-hypercube'"));
    folder.succeed("dataset set.toml -o out --quiet --set output.image=false");
    let lines = manifest(&folder, "out");
    let number = |line: &Value, key: &str, index: Option<usize>| {
        let value = &line["varied"][key];
        index.map_or(value, |i| &value[i]).as_f64().expect("a number")
    };
    let strata = |of: &dyn Fn(&Value) -> f64| {
        let mut strata: Vec<usize> = lines.iter().map(|line| (of(line) * FRAMES as f64) as usize).collect();
        let order = strata.clone();
        strata.sort_unstable();
        assert_eq!(strata, (0..FRAMES).collect::<Vec<_>>());
        order
    };
    let orders = [
        strata(&|line| (number(line, "exposure.time_s", None) - 0.001) / 0.012),
        strata(&|line| number(line, "lights.key.intensity_cd", None).log2() / 12.0),
        strata(&|line| number(line, "lights.fill.intensity_cd", None).log2() / 12.0),
        strata(&|line| number(line, "targets.board.position_m", Some(0)) / 0.12),
        strata(&|line| number(line, "targets.board.position_m", Some(1)) / 0.12),
        strata(&|line| number(line, "targets.board.position_m", Some(2)) / 0.12 + 1.0),
    ];
    assert_eq!(orders.iter().collect::<BTreeSet<_>>().len(), orders.len(), "each has an order of its own");
    for illuminant in ["A", "D65", "D50"] {
        let of_it = lines.iter().filter(|line| line["varied"]["lights.key.illuminant"] == illuminant);
        assert_eq!(of_it.count(), FRAMES / 3);
    }
    // Strata are those of so many frames: another number of them is another set.
    folder.add(
        "set.toml",
        format!("capture = 'board.toml'\n{}", set("sampling = 'latin-hypercube'").replace("12\n", "13\n")),
    );
    folder.fail("dataset set.toml -o out", 2, &["the data set file says something else"]);
}

#[test]
fn files_of_a_folder_are_drawn_by_name_and_are_part_of_the_set() {
    let vary = "frames = 8\n[[vary]]\nkey = 'scene.environment.image'\nfiles = 'skies/*.hdr'\n\
                [[vary]]\nkey = 'scene.environment.nit_per_unit'\nlog_uniform = [10, 100]\n";
    let folder = folder(vary);
    folder.succeed("dataset set.toml -o out --quiet");
    let drawn: BTreeSet<String> =
        manifest(&folder, "out").iter().map(|l| l["varied"]["scene.environment.image"].to_string()).collect();
    assert_eq!(drawn, BTreeSet::from(["\"skies/day.hdr\"".to_owned(), "\"skies/night.hdr\"".to_owned()]));
    let identity = folder.json("out/dataset.json");
    assert!(
        identity["files_sha256"]["skies/day.hdr"].is_string()
            && identity["files_sha256"]["skies/night.hdr"].is_string()
    );
    // A file that changes makes another set, and so does one that comes to be.
    folder.add("skies/dawn.hdr", sky(90));
    folder.fail("dataset set.toml -o out", 2, &["a file that the capture names has changed"]);
    folder.fail("dataset set.toml -o other --sandbox skies", 1, &["not in the sandbox"]);
}

#[test]
fn materials_of_the_geometry_change_without_being_described_anew() {
    let vary = "frames = 3\n[[vary]]\nkey = 'materials.board-*.base_colour'\nhsv = {}\ntogether = true\n\
                [[vary]]\nkey = 'scene.environment.illuminance_lux'\nuniform = [100, 200]\n";
    let folder = folder(vary);
    folder.succeed("dataset set.toml -o out --quiet");
    for line in manifest(&folder, "out") {
        let [white, black] =
            ["white", "black"].map(|name| line["varied"][format!("materials.board-{name}.base_colour")].clone());
        assert!(white.is_array() && white == black, "{white} {black}");
    }
    folder.fail(
        "render board.toml -o x --set materials.board-white.metallic=1",
        1,
        &["materials.board-white.metallic: is not a key of this material", "type = \"metallic-roughness\""],
    );
}

#[rstest]
#[case::no_name("[[vary]]\nkey = 'lights.x*.on'\ncount = [0, 1]\n", &["set.toml:3: vary[0].key: \"lights.x*.on\" matches nothing", "fill, key"])]
#[case::no_material("[[vary]]\nkey = 'materials.wood*.roughness'\nuniform = [0, 1]\n", &["set.toml:3: vary[0].key", "board-white"])]
#[case::no_file("[[vary]]\nkey = 'scene.environment.image'\nfiles = 'skies/*.exr'\n", &["set.toml:4: vary[0].files: no file matches"])]
#[case::tables("[[vary]]\nchoices = [{ 'a.b' = 1 }, { 'a.c' = 1 }]\n", &["vary[0].choices[1]: has no \"a.b\""])]
#[case::too_many("[[vary]]\nkey = 'lights.*.on'\ncount = [0, 3]\n", &["set.toml:4: vary[0].count: asks for 3, but the key matches 2"])]
#[case::weights("[[vary]]\nkey = 'lens.f_number'\nchoice = [2, 4]\nweights = [1]\n", &["set.toml:5: vary[0].weights: has 1 entry, but there are 2 choices"])]
#[case::misspelt("[[vary]]\nkey = 'lights.*.intensity'\nuniform = [1, 2]\n", &["set.toml:2: vary[0]", "did you mean `intensity_cd`?"])]
#[case::in_table("[[vary]]\nchoices = [{ 'exposure.gain_db' = 90 }]\n", &["set.toml:2: vary[0]: in frame 0: exposure.gain_db: 90 dB"])]
#[case::no_such_light("[[vary]]\nkey = 'lights.kex.on'\nchoice = [true]\n", &["set.toml:2: vary[0]", "has no element called \"kex\"; did you mean `key`?"])]
#[case::sampling("sampling = 'sobol'\n", &["set.toml:2: sampling: unknown value \"sobol\""])]
fn errors_name_file_key_and_line(#[case] dataset: &str, #[case] wanted: &[&str]) {
    let folder = folder(dataset);
    let outcome = folder.fail("dataset set.toml -o out", 1, wanted);
    assert!(!outcome.stderr.contains("--set"), "{}", outcome.stderr);
    assert!(!folder.path("out").exists(), "nothing is left behind");
}

/// Elements of lists go by their names in overrides, too.
#[test]
fn lights_and_targets_are_changed_by_name() {
    let folder = Folder::new([("board.toml", lit_board().into())]);
    let report = |change: &str| {
        folder.succeed(&format!("render board.toml -o {change} --force --quiet --set {change}"));
        folder.report(change)["capture"].clone()
    };
    assert_eq!(report("lights.fill.intensity_cd=7")["lights"][1]["intensity_cd"], 7);
    assert_eq!(report("lights.1.intensity_cd=8")["lights"][1]["intensity_cd"], 8);
    assert_eq!(report("targets.board.position_m=[0,0,-0.1]")["targets"][0]["position_m"][2], -0.1);
    assert_eq!(report("scene.spheres.ball.radius_m=0.02")["scene"]["spheres"][0]["radius_m"], 0.02);
    for (change, wanted) in [
        (
            "lights.fil.intensity_cd=7",
            ["lights: has no element called \"fil\"; did you mean `fill`?", "or go by number from 0 to 1"],
        ),
        ("lights.2.intensity_cd=7", ["lights: has no element 2", "there are 2, numbered from 0"]),
    ] {
        folder.fail(&format!("render board.toml -o x --set {change}"), 1, &wanted);
    }
}
