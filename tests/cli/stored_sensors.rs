//! Sensors of `capture.json` are whole: they give the same image again, and nothing else comes in. So do
//! sensors that begin from nothing, or from a preset without some of its keys.

use photosite::sensor::presets;
use rstest::rstest;
use serde_json::{Value, json};

use crate::folder::Folder;

/// A wall before a small camera.
const CAPTURE: &str = "\
[scene]
geometry = ['sail.obj']
environment = { illuminant = 'A', illuminance_lux = 2000 }
[camera]
position_m = [0.1, 0.7, 2.5]
look_at_m = [0, 0.6, 0]
[exposure]
time_s = 0.002
[render]
samples_per_pixel = 2
seed = 3
";

/// Keys that a sensor of the user's own has beside its filters and channels; no infrared-cut filter among it.
const OWN: &str = "\
resolution_px = [16, 12]
pixel_pitch_um = [9, 9]
charge.full_well_e = 20000
noise = { read_noise_e = 2, prnu_percent = 1 }
adc = { bits = 12, conversion_gain_dn_per_e = 0.2, black_level_dn = 64 }
";

fn curve(peak_nm: f64) -> String {
    let at = |nm: f64| 0.15 + 0.4 * (-((nm - peak_nm) / 70.0).powi(2)).exp();
    let lines = (300..=1100).step_by(20).map(|nm| format!("{nm},{}\n", at(f64::from(nm))));
    format!("wavelength_nm,value\n{}", lines.collect::<String>())
}

fn folder() -> Folder {
    let folder = Folder::new([
        ("sail.obj", b"v -1 0 0\nv 1 0 0\nv 0 1.5 0\nf 1 2 3\n".to_vec()),
        ("scenes/sail.obj", b"v -1 0 0\nv 1 0 0\nv 0 1.5 0\nf 1 2 3\n".to_vec()),
        ("scenes/capture.toml", CAPTURE.into()),
    ]);
    for (name, peak_nm) in [("r", 610.0), ("g", 540.0), ("b", 460.0), ("c", 550.0)] {
        folder.add(&format!("sensors/curves/{name}.csv"), curve(peak_nm));
    }
    let channel = |letter: &str, curve: &str| {
        format!("channels.{letter}.quantum_efficiency = {{ file = 'curves/{curve}.csv' }}\n")
    };
    let (r, b) = (channel("R", "r"), channel("B", "b"));
    folder.add("sensors/rgb.toml", format!("cfa = 'RGGB'\n{r}{b}{}{OWN}", channel("G", "g")));
    folder.add("sensors/rccb.toml", format!("cfa = 'rccb'\n{r}{b}{}{OWN}", channel("C", "c")));
    folder.add("sensors/mono.toml", format!("cfa = 'mono'\n{}{OWN}", channel("Y", "c")));
    folder
}

/// Asserts that two folders hold the same electrons and the same raw image.
fn assert_same(folder: &Folder, one: &str, other: &str) {
    let [one_s, others] = [one, other].map(|name| folder.results(name));
    for file in ["electrons.exr", "raw.dng"] {
        assert!(one_s[file] == others[file], "{file} of {one} and {other} differ");
    }
}

/// Renders, and renders and exposes again what `capture.json` says.
fn repeat(folder: &Folder, arguments: &str) -> Value {
    folder.succeed(&format!("render {arguments} -o out"));
    folder.succeed("render out/capture.json -o deeper/again");
    assert_same(folder, "out", "deeper/again");
    folder.succeed("expose out -o exposed");
    assert!(folder.results("out")["raw.dng"] == folder.results("exposed")["raw.dng"]);
    let [report, again] = ["out", "deeper/again"].map(|name| folder.report(name));
    assert_eq!(report["sensor"], again["sensor"]);
    report["capture"].clone()
}

#[test]
fn every_preset_gives_the_same_image_again() {
    for name in presets::names() {
        let folder = folder();
        // The lines of a line camera follow each other quickly.
        let time_s = if name == "generic-line-scan" { 1e-5 } else { 2e-3 };
        let set = format!("--set sensor.preset={name} --set sensor.resolution_px=[8,6] --set exposure.time_s={time_s}");
        let stored = repeat(&folder, &format!("scenes/capture.toml {set}"));
        assert_eq!((&stored["sensor"]["preset"], &stored["sensor"]["name"]), (&json!("none"), &json!(name)));
    }
}

#[rstest]
#[case::without_filter("rgb")]
#[case::other_channels("rccb")]
#[case::mono("mono")]
fn a_sensor_file_gives_the_same_image_again(#[case] name: &str) {
    let folder = folder();
    let stored = repeat(&folder, &format!("scenes/capture.toml --set sensor.preset=../sensors/{name}.toml"));
    assert!(stored["sensor"].get("filter").is_none(), "{stored}");
    assert_eq!(folder.raw("deeper/again/raw.dng").metadata.camera_model, name);
    folder.add("points.csv", "0,0.5,0\n0.2,0.1,0\n");
    // All that read captures read what is stored as they read what was written.
    for command in ["camera", "project"] {
        let points = if command == "project" { "--points points.csv" } else { "--format opencv" };
        let said = |input: &str| folder.run(&format!("{command} {input} {points}"));
        let written = said(&format!("scenes/capture.toml --set sensor.preset=../sensors/{name}.toml"));
        assert_eq!((said("out/capture.json").stdout, Some(0)), (written.stdout, written.status), "{command}");
    }
    folder.succeed("export-mitsuba out/capture.json -o mitsuba --approximate");
    let facts = |input: &str| {
        let found = folder.succeed(&format!("info {input} --json")).stdout;
        let mut found: Value = serde_json::from_str(&found).expect("JSON");
        // The same files have other paths from another folder.
        found.as_object_mut().expect("an object").remove("geometry").expect("files of geometry");
        found
    };
    folder.add("scenes/same.toml", format!("{CAPTURE}[sensor]\npreset = '../sensors/{name}.toml'\n"));
    assert_eq!(facts("out/capture.json"), facts("scenes/same.toml"));
    assert_eq!(facts("out/capture.json")["sensor"], name);
}

/// Files of before held the whole sensor too, with the name of its preset or without one.
#[rstest]
#[case::of_a_file(None)]
#[case::of_a_preset(Some("generic-cmos-color"))]
fn older_files_are_read_as_whole(#[case] preset: Option<&str>) {
    let folder = folder();
    folder.succeed("render scenes/capture.toml --set sensor.preset=../sensors/rgb.toml -o out");
    let mut report = folder.report("out");
    let sensor = report["capture"]["sensor"].as_object_mut().expect("a table");
    sensor.remove("name");
    match preset {
        Some(preset) => sensor.insert("preset".to_owned(), preset.into()),
        None => sensor.remove("preset"),
    };
    folder.add("out/older.json", report.to_string());
    folder.succeed("render out/older.json -o again");
    assert_same(&folder, "out", "again");
    folder.add("out/capture.json", report.to_string());
    folder.succeed("expose out -o exposed");
    assert!(folder.results("out")["raw.dng"] == folder.results("exposed")["raw.dng"]);
}

/// Changes are laid over a stored sensor as over a preset; another preset takes its place but for the number of pixels.
#[test]
fn a_stored_sensor_can_be_changed() {
    let folder = folder();
    folder.succeed("render scenes/capture.toml --set sensor.preset=../sensors/rgb.toml -o out");
    let saturation = |arguments: &str| {
        folder.succeed(&format!("render out/capture.json -o changed --force {arguments}"));
        folder.report("changed")["sensor"].clone()
    };
    let other = saturation("--set sensor.preset=sony-imx249-mono");
    assert_eq!((&other["name"], &other["resolution_px"]), (&json!("sony-imx249-mono"), &json!([16, 12])));
    folder.succeed(
        "render scenes/capture.toml -o own --set sensor.preset=sony-imx249-mono --set sensor.resolution_px=[16,12]",
    );
    assert_same(&folder, "changed", "own");
    // The gain follows the bits of a stored sensor, too: (1023 − 16) DN / 0.05 DN/e⁻.
    let coarse = saturation("--set sensor.adc.bits=10");
    assert_eq!((&coarse["black_level_dn"], &coarse["saturation_capacity_e"]), (&json!(16.0), &json!(20000.0)));
    let pitch = saturation("--set sensor.format=\"1/2\"")["pixel_pitch_um"].clone();
    assert_eq!(pitch, json!([6400.0 / 16.0, 4800.0 / 12.0]));
}

/// A preset that an override names is laid under the keys of the file, which is said of all that it would have set
/// otherwise, and of nothing else.
#[rstest]
#[case::none("", "", None)]
#[case::of_the_file("preset = 'sony-imx249-mono'\nresolution_px = [16, 12]", "", None)]
#[case::over_two(
    "resolution_px = [16, 12]\npixel_pitch_um = [9, 9]",
    "sony-imx249-mono",
    Some("pixel_pitch_um, resolution_px;")
)]
#[case::over_a_table("noise.read_noise_e = 77", "sony-imx249-mono", Some("noise.read_noise_e;"))]
#[case::without_some("without = ['noise.prnu_percent']", "sony-imx249-mono", Some("without;"))]
#[case::over_the_same("pixel_pitch_um = [5.86, 5.86]", "sony-imx249-mono", None)]
#[case::with_its_own("resolution_px = [16, 12]", "sony-imx249-mono --set sensor.resolution_px=[8,6]", None)]
fn keys_that_stay_over_another_preset_are_told(#[case] keys: &str, #[case] preset: &str, #[case] told: Option<&str>) {
    let folder = folder();
    folder.add("scenes/own.toml", format!("{CAPTURE}[sensor]\n{keys}\n"));
    let set = if preset.is_empty() { String::new() } else { format!("--set sensor.preset={preset}") };
    let said = folder.succeed(&format!("render scenes/own.toml -o out --size 16x12 --spp 1 {set}")).text();
    assert_eq!(said.contains("stay over it"), told.is_some(), "{said}");
    if let Some(told) = told {
        assert!(said.contains(told), "{said}");
    }
}

/// After `render sail.obj`, the surroundings, the camera and the focus of a scene alone are in `capture.json`.
#[rstest]
#[case::framed("")]
#[case::placed("--set camera.position_m=[0.3,0.4,3] --set camera.look_at_m=[0,0.5,0] --set lens.f_number=1.4")]
#[case::focused("--set lens.focus_distance_m=2")]
fn geometry_alone_gives_the_same_image_again(#[case] more: &str) {
    let folder = folder();
    let size = "--set sensor.resolution_px=[16,12] --set render.samples_per_pixel=2";
    let stored = repeat(&folder, &format!("scenes/sail.obj {size} {more}"));
    assert_eq!(stored["scene"]["geometry"], json!(["../scenes/sail.obj"]));
    assert_eq!(stored["scene"]["environment"]["sky"]["sun_elevation_deg"], 40.0);
    assert_eq!(
        (&stored["scene"]["ground"]["reflectance"], &stored["exposure"]["auto_mean"]),
        (&json!(0.3), &json!(0.2))
    );
    let [out, again] = ["out", "deeper/again"].map(|name| folder.report(name)["lens"].clone());
    assert_eq!(out, again);
    folder.succeed("info out/capture.json");
}

#[test]
fn files_that_hold_no_capture_are_refused() {
    let folder = folder();
    folder.add("other.json", "{ \"sensor\": {} }");
    folder.add("broken.json", "{ \"capture\": ");
    for command in ["info", "render", "camera --format opencv"] {
        folder.fail(
            &format!("{command} other.json"),
            1,
            &["other.json: is not a report of a render: it holds no capture"],
        );
        folder.fail(&format!("{command} broken.json"), 1, &["broken.json: is damaged"]);
    }
    folder.add("out/capture.json", "{}");
    folder.fail("render out", 1, &["out: is a folder", "give the capture file in it, for example out/capture.json"]);
}

/// A preset without some of its keys, and other ones over it, is the sensor that is written from nothing.
#[test]
fn presets_can_lose_keys_and_sensors_begin_from_nothing() {
    let folder = folder();
    let render = |name: &str, sensor: &str| {
        folder.add(&format!("scenes/{name}.toml"), format!("{CAPTURE}[sensor]\nname = 'mine'\n{sensor}"));
        folder.succeed(&format!("render scenes/{name}.toml -o {name}"));
    };
    render("nothing", &format!("preset = 'none'\ncfa = 'mono'\nchannels.Y.quantum_efficiency = 0.5\n{OWN}"));
    let take = "without = ['filter', 'channels', 'noise', 'fill_factor', 'adc', 'source', 'description']\n";
    render("mono", &format!("{take}cfa = 'mono'\nchannels.Y.quantum_efficiency = 0.5\n{OWN}"));
    assert_same(&folder, "nothing", "mono");
    assert_eq!(folder.raw("nothing/raw.dng").metadata.camera_model, "mine");
    assert_eq!(folder.report("nothing")["sensor"]["name"], "mine");

    // A colour preset as RCCB: green goes, clear comes; its filter and noise stay.
    let more = "cfa = 'rccb'\nresolution_px = [16, 12]\nchannels.C.quantum_efficiency = { file = '../sensors/curves/c.csv' }\n";
    render("rccb", &format!("without = ['channels.G']\n{more}"));
    let stored = folder.report("rccb")["capture"]["sensor"].clone();
    let channels: Vec<&String> = stored["channels"].as_object().expect("a table").keys().collect();
    assert_eq!(channels, ["B", "C", "R"]);
    assert!(stored["filter"]["transmittance"].is_string() && stored["noise"]["dsnu_e"] == 1.5, "{stored}");

    // A CCD as CMOS: what is said of charge transfer goes by itself with the kind, or when it is taken away.
    for (name, how) in [("by-kind", ""), ("taken", "without = ['ccd']\n")] {
        render(name, &format!("preset = 'textbook-ccd'\nkind = 'cmos'\nresolution_px = [16, 12]\n{how}"));
        assert!(folder.report(name)["capture"]["sensor"].get("ccd").is_none());
    }
    assert_same(&folder, "by-kind", "taken");
}

#[rstest]
#[case::misspelt(
    "without = ['noise.prnu']",
    "sensor.without[0]: sensor generic-cmos-color has no \"noise.prnu\"",
    "did you mean `noise.prnu_percent`?"
)]
#[case::second("without = ['filter', 'ccd']", "sensor.without[1]: sensor generic-cmos-color has no \"ccd\"", "it has")]
#[case::twice("without = ['filter', 'filter']", "sensor.without[1]", "has no \"filter\"")]
#[case::nothing("preset = 'none'\nwithout = ['filter']", "sensor.without[0]: sensor sensor has no", "nothing in it")]
#[case::no_list("without = 'filter'", "sensor.without: ", "a list")]
#[case::incomplete("preset = 'none'", "the key `resolution_px` is missing", "")]
#[case::needed("without = ['charge']", "the key `charge` is missing", "")]
#[case::no_name("name = ' '", "sensor.name: \" \" is not a name", "my camera")]
fn what_cannot_be_taken_away_is_told(#[case] sensor: &str, #[case] message: &str, #[case] more: &str) {
    let folder = folder();
    folder.add("scenes/bad.toml", format!("{CAPTURE}[sensor]\n{sensor}\n"));
    folder.fail("render scenes/bad.toml", 1, &["scenes/bad.toml", message, more]);
}

/// README's example: other bits, the same saturation.
#[test]
fn other_bits_hold_the_same_charge() {
    let folder = folder();
    let sensor = |arguments: &str| {
        let preset = "--set sensor.preset=sony-imx249-color --set sensor.resolution_px=[8,6]";
        let outcome = folder.succeed(&format!("render scenes/capture.toml -o out --force {preset} {arguments}"));
        (folder.report("out")["sensor"].clone(), outcome.text())
    };
    let number = |value: &Value| value.as_f64().expect("a number");
    let (twelve, _) = sensor("");
    let (ten, said) = sensor("--set sensor.adc.bits=10");
    assert!(!said.contains("warning: sensor"), "{said}");
    // One step of the coarser converter, 1/0.0311 e⁻, is what rounding can make of the ends of its range.
    let [fine, coarse] = [&twelve, &ten].map(|sensor| number(&sensor["saturation_capacity_e"]));
    assert!((fine - coarse).abs() < 1.0 / (0.1245 / 4.0), "{fine} and {coarse} e⁻");
    assert_eq!((&ten["black_level_dn"], &ten["bits"]), (&json!(16.0), &json!(10)));
    assert_eq!(number(&ten["system_gain_dn_per_e"]), 0.1245 / 4.0);
    // What is given stays as it is given.
    let given = "--set sensor.adc.conversion_gain_dn_per_e=0.03 --set sensor.adc.black_level_dn=20";
    let (given, _) = sensor(&format!("--set sensor.adc.bits=10 {given}"));
    assert_eq!((&given["black_level_dn"], number(&given["system_gain_dn_per_e"])), (&json!(20.0), 0.03));
    // So it is for the commands that take a sensor by its name.
    let set = "emva1288 sony-imx249-mono --set adc.bits=10 --size 8x8 -o set --json";
    let expected = folder.succeed(set).json();
    let gain = number(&expected["channels"][0]["expected"]["system_gain_dn_per_e"]);
    assert!((gain - 0.1245 / 4.0).abs() < 1e-9, "{expected}");
}

#[test]
fn what_cannot_follow_the_bits_is_told() {
    let folder = folder();
    folder.add("sensors/bent.toml", format!("cfa = 'mono'\nchannels.Y.quantum_efficiency = 0.5\n{}", OWN.replace(
        "black_level_dn = 64",
        "black_level_dn = 64, inl_dn = 2, dnl_dn = 0.2, column_offset_dn = 0.5, companding = { bits = 8, knee_points_dn = \
         [[0, 0], [400, 100], [4095, 255]] }",
    )));
    let render = |sensor: &str| {
        folder.add("scenes/other.toml", format!("{CAPTURE}[sensor]\npreset = '../sensors/bent.toml'\n{sensor}\n"));
        let outcome = folder.succeed("render scenes/other.toml -o out --force");
        (folder.report("out")["capture"]["sensor"]["adc"].clone(), outcome.text())
    };
    let (adc, said) = render("adc.bits = 10");
    assert!(said.contains("warning: sensor.adc.dnl_dn: 0.2 is that of a converter of other bits"), "{said}");
    assert_eq!((&adc["inl_dn"], &adc["dnl_dn"], &adc["column_offset_dn"]), (&json!(0.5), &json!(0.2), &json!(0.125)));
    assert_eq!(adc["companding"]["knee_points_dn"], json!([[0, 0], [100, 100], [1023, 255]]));
    let (_, said) = render("adc.bits = 10\nadc.dnl_dn = 0.1");
    assert!(!said.contains("dnl_dn"), "{said}");
    // A count is a count.
    let set = |bits: u32, more: &str| {
        let set =
            format!("--set sensor.preset=swissspad2 --set sensor.resolution_px=[8,6] --set sensor.adc.bits={bits}");
        let outcome = folder.succeed(&format!("render scenes/capture.toml -o out --force {set} {more}"));
        (
            folder.report("out")["sensor"]["system_gain_dn_per_e"].as_f64(),
            outcome.text().contains("warning: sensor.adc.bits"),
        )
    };
    assert_eq!(set(12, ""), (Some(1.0), false));
    let free = "--set sensor.spad.counting=free-running --set sensor.spad.dead_time_ns=50 --set sensor.charge.full_well_e=5000";
    assert_eq!(set(12, free), (Some(1.0), true));
}

/// A path typed on the command line leads to the file that it leads to there; one that does not counts from the capture,
/// as those in it.
#[test]
fn typed_paths_count_from_the_current_folder() {
    let folder = folder();
    let render = |name: &str, change: &str| {
        folder.succeed(&format!("render scenes/capture.toml --set {change} -o {name}"));
    };
    render("from-capture", "sensor.preset=../sensors/rgb.toml");
    render("from-here", "sensor.preset=sensors/rgb.toml");
    assert_same(&folder, "from-capture", "from-here");
    // As a part of a value, too, and quoted.
    render("quoted", "sensor.preset='sensors/rgb.toml'");
    assert_same(&folder, "from-capture", "quoted");
    let channel = "sensor.channels.R.quantum_efficiency={file='sensors/curves/c.csv'}";
    folder.succeed(&format!(
        "render scenes/capture.toml --set sensor.preset=sensors/rgb.toml --set {channel} -o changed"
    ));
    assert!(folder.results("changed")["raw.dng"] != folder.results("quoted")["raw.dng"]);
    // Of a data set the capture may lie in another folder than its file.
    folder.add("set.toml", "capture = 'scenes/capture.toml'\nframes = 1\n");
    folder.succeed("dataset set.toml --set sensor.preset=sensors/rgb.toml -o set");
    folder.fail("render scenes/capture.toml --set sensor.preset=sensors/none.toml", 1, &["cannot read", "none.toml"]);
}
