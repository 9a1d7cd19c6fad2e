//! Results that a render leaves in its folder, and output that it prints.

use rstest::rstest;
use serde_json::{Value, json};

use crate::folder::Folder;
use crate::gltf::triangle;
use crate::room::room;

fn names(folder: &Folder, results: &str) -> Vec<String> {
    folder.results(results).into_keys().collect()
}

/// Makes a pane of the glass in the room, so that there is nothing to warn of.
const PANE: &str = "--set materials.glass={type='thin-dielectric',index=1.5}";

#[test]
fn the_usual_files_appear_and_two_lines_say_so() {
    let folder = room("[render]\nsamples_per_pixel = 2");
    let outcome = folder.succeed(&format!("render capture.toml -o out {PANE}"));
    assert_eq!(names(&folder, "out"), ["capture.json", "electrons.exr", "image.png", "raw.dng"]);
    assert_eq!(outcome.stdout, "");
    // Progress is for people at a terminal: no bar, no control characters.
    assert_eq!(outcome.stderr.lines().count(), 2, "{}", outcome.stderr);
    assert!(!outcome.stderr.contains(['\r', '\u{1b}']), "{:?}", outcome.stderr);
    for words in [
        "traced 1536 paths",
        "exposed for 0.2 ms",
        "raw.dng, electrons.exr, image.png, capture.json to out",
        "Monte Carlo",
    ] {
        assert!(outcome.stderr.contains(words), "{words:?} in {}", outcome.stderr);
    }
    let image = image::load_from_memory(&folder.results("out")["image.png"]).expect("an image");
    assert_eq!((image.width(), image.height()), (32, 24));
}

#[test]
fn other_formats_appear_on_request() {
    let folder = room(
        "[render]\nsamples_per_pixel = 2\n[output]\nraw = ['npy', 'dng', 'tiff', 'pgm', 'npy']\nelectrons = false\n\
         irradiance = { bands_nm = [400, 700, 100] }\n",
    );
    folder.succeed("render capture.toml -o out");
    let files = ["capture.json", "image.png", "irradiance.exr", "raw.dng", "raw.npy", "raw.pgm", "raw.tiff"];
    assert_eq!(names(&folder, "out"), files);
    let mut listed: Vec<Value> = folder.report("out")["files"].as_array().expect("a list").clone();
    listed.push(json!("capture.json"));
    listed.sort_by_key(Value::to_string);
    assert_eq!(listed, files);
    // The same mosaic in each of them: the numbers are the last bytes of PGM (big-endian) and NPY (little-endian).
    let raw = folder.raw("out/raw.dng").data;
    let results = folder.results("out");
    let tiff = image::load_from_memory(&results["raw.tiff"]).expect("an image").into_luma16();
    assert_eq!(tiff.into_raw(), raw);
    let tail = |name: &str| results[name][results[name].len() - 2 * raw.len()..].to_vec();
    assert_eq!(tail("raw.pgm"), raw.iter().flat_map(|dn| dn.to_be_bytes()).collect::<Vec<_>>());
    assert_eq!(tail("raw.npy"), raw.iter().flat_map(|dn| dn.to_le_bytes()).collect::<Vec<_>>());
    let none = room("[render]\nsamples_per_pixel = 2\n[output]\nraw = []\n");
    none.succeed("render capture.toml -o out");
    assert_eq!(names(&none, "out"), ["capture.json", "electrons.exr", "image.png"]);
}

#[test]
fn quiet_prints_nothing_not_even_warnings() {
    let folder = Folder::new([("a.gltf", triangle().with("/extensionsUsed", json!(["KHR_unheard_of"])).text())]);
    let small = "--set sensor.resolution_px=[8,8] --set render.samples_per_pixel=2";
    let outcome = folder.succeed(&format!("render a.gltf --quiet -o out {small}"));
    assert_eq!((outcome.stdout.as_str(), outcome.stderr.as_str()), ("", ""));
    assert_eq!(folder.report("out")["warnings"].as_array().map(Vec::len), Some(1));
}

#[test]
fn json_is_what_capture_json_holds() {
    let folder = room("[render]\nsamples_per_pixel = 2");
    let outcome = folder.succeed("render capture.toml --json -o out --set render.max_depth=3 --seed 5");
    assert_eq!(outcome.stdout.as_bytes(), folder.results("out")["capture.json"]);
    // Of glass before a light without a surface.
    assert!(
        outcome.stderr.starts_with("warning: caustics") && outcome.stderr.lines().count() == 1,
        "{}",
        outcome.stderr
    );
    let report = outcome.json();
    let seconds = |key: &str| report["timings"][key].as_f64().expect(key);
    for key in ["load_s", "build_s", "trace_s", "expose_s", "develop_s", "write_s"] {
        assert!((0.0..60.0).contains(&seconds(key)), "{key} is {}", seconds(key));
    }
    assert_eq!(report["paths"], 32 * 24 * 2);
    let rate = report["paths_per_s"].as_f64().expect("a rate");
    assert!((rate * seconds("trace_s") / 1536.0 - 1.0).abs() < 1e-9, "{rate}");
    assert_eq!(report["overrides"], json!(["render.max_depth=3", "render.seed=5"]));
    assert_eq!((&report["seed"], &report["render"]["max_depth"]), (&json!(5), &json!(3)));
}

#[test]
fn set_changes_any_key() {
    let folder = room("[render]\nsamples_per_pixel = 2");
    folder.succeed(
        "render capture.toml -o out --set lens.f_number=5.6 --set sensor.resolution_px=[20,10] --set sensor.adc.bits=10 \
         --set exposure.time_s=0.05 --set render.sampler=independent --set lights.0.intensity_cd=1e3 \
         --set materials.gold.metal=Cu --set camera.look_at_m=[0.0,0.5,0.1] --set lens.focus_distance_m=infinity",
    );
    let report = folder.report("out");
    assert_eq!(report["lens"]["f_number"], 5.6);
    assert_eq!(report["lens"]["focus_distance_m"], Value::Null);
    assert_eq!(report["sensor"]["resolution_px"], json!([20, 10]));
    assert_eq!(report["sensor"]["bits"], 10);
    assert_eq!(report["exposure"]["time_s"], 0.05);
    assert_eq!(report["render"]["sampler"], "independent");
    assert_eq!(report["overrides"].as_array().map(Vec::len), Some(9));
    // What the report does not name shows in the light.
    for (key, value) in [("materials.gold.metal", "Cu"), ("lights.0.intensity_cd", "1e3"), ("lens.f_number", "5.6")] {
        let name = format!("out-{key}");
        folder.succeed(&format!("render capture.toml -o {name} --set {key}={value}"));
        folder.succeed("render capture.toml -o plain --force");
        assert!(folder.electrons(&name) != folder.electrons("plain"), "{key}");
    }
}

/// A later render with other formats must leave nothing of the earlier one, but what is not a render's.
#[test]
fn force_replaces_all_of_the_earlier_results() {
    let folder = room("[render]\nsamples_per_pixel = 2");
    folder.succeed("render capture.toml -o out --set output.raw=['tiff','npy'] --set exposure.frames=2");
    folder.add("out/notes.txt", "mine");
    folder.succeed("render capture.toml -o out --force");
    assert_eq!(names(&folder, "out"), ["capture.json", "electrons.exr", "image.png", "notes.txt", "raw.dng"]);

    // An edited report must not lead out of the folder.
    folder.add("precious.txt", "mine");
    folder.add("out/capture.json", "{ \"files\": [\"../precious.txt\", \"..\", \"/etc/hosts\", 3] }");
    folder.succeed("render capture.toml -o out --force");
    assert!(folder.path("precious.txt").exists());
    folder.add("out/capture.json", "no JSON");
    folder.succeed("render capture.toml -o out --force");
    assert_eq!(folder.report("out")["render"]["samples_per_pixel"], 2);
}

#[test]
fn without_a_folder_the_input_names_it() {
    let folder = room("[render]\nsamples_per_pixel = 1");
    let capture = folder.results(".")["capture.toml"].clone();
    let capture = String::from_utf8(capture).expect("UTF-8").replace("[\"", "[\"../").replace(", \"", ", \"../");
    let capture = capture.replace("\"sky.hdr", "\"../sky.hdr");
    folder.add("box/capture.toml", &capture);
    folder.add("box/capture-night.toml", &capture);
    folder.add("box/other.toml", &capture);
    for (input, output) in [
        ("capture.toml", "capture"),
        ("box/capture.toml", "box"),
        ("box/capture-night.toml", "box-night"),
        ("box/other.toml", "other"),
    ] {
        folder.succeed(&format!("render {input}"));
        assert!(folder.path(output).join("capture.json").is_file(), "{input}");
    }
}

/// Infrared behind a filter that blocks it: there is light, but none that could balance the channels.
#[test]
fn light_that_the_sensor_does_not_see_leaves_a_dark_image() {
    let folder = room("[render]\nsamples_per_pixel = 2");
    folder.add("infrared.csv", "950,0\n960,1\n970,0\n");
    folder.add(
        "capture.toml",
        "[scene]\ngeometry = ['sails.gltf']\nenvironment = { spectrum = { file = 'infrared.csv' } }\n\
         [sensor]\nresolution_px = [32, 24]\n[exposure]\ntime_s = 0.01\n",
    );
    let outcome = folder.succeed("render capture.toml -o out");
    let warning = "does not see the light of the scene, so the white balance is that of D65";
    assert_eq!(outcome.stderr.matches(warning).count(), 1, "{}", outcome.stderr);
    // Read noise and offset are a few electrons, less than one digital number each.
    let raw = folder.raw("out/raw.dng");
    assert!(raw.data.iter().all(|dn| (f32::from(*dn) - raw.black_level_dn.mean()).abs() < 8.0));
}

#[test]
fn curves_of_a_sensor_lie_beside_the_capture_wherever_that_is() {
    let folder = room("[render]\nsamples_per_pixel = 2");
    folder.add("sub/line.csv", "549,0\n550,1\n551,0\n");
    folder.add(
        "sub/capture.toml",
        "[scene]\ngeometry = ['../sails.gltf']\nenvironment = { illuminant = 'D65', illuminance_lux = 100 }\n[sensor]\npreset = 'sony-imx249-mono'\nresolution_px = [32, 24]\n\
         channels.Y.quantum_efficiency = { file = 'line.csv' }\n",
    );
    folder.succeed("render sub/capture.toml -o out");
}

#[test]
fn images_that_do_not_lie_on_ground_truth_are_warned_of() {
    let folder = room("[render]\nsamples_per_pixel = 1\n[output]\ntruth = ['depth']\n");
    let barrel = "--set lens.distortion={model='brown-conrady',k=[-0.05]}";
    let warned = |options: &str| {
        folder.succeed(&format!("render capture.toml {barrel} {options}")).stderr.contains("freed of the distortion")
    };
    assert!(warned("-o both"));
    assert!(!warned("-o alike --set develop.distortion=false"));
    assert!(!warned("-o image --set output.truth=[]"));
}

#[test]
fn ground_truth_appears_in_the_formats_that_are_asked_for() {
    let folder = room(
        "[render]\nsamples_per_pixel = 1\n[output]\ntruth = ['depth', 'normal', 'instance', 'flow']\n\
         truth_formats = ['exr', 'npy', 'png']\ntruth_depth_unit_mm = 0.5\n",
    );
    folder.succeed("render capture.toml -o out");
    let layer_files = |kind: &str| ["depth", "normal", "instance", "flow"].map(|layer| format!("truth-{layer}.{kind}"));
    let results = folder.results("out");
    for name in layer_files("npy").iter().chain(&layer_files("png")).chain(&["truth.exr".to_owned()]) {
        assert!(results.contains_key(name), "{name} in {:?}", results.keys());
    }
    let truth = &folder.report("out")["truth"];
    assert_eq!(truth["depth_unit_mm"], 0.5);
    let names: Vec<_> = truth["instances"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    assert!(names.contains(&"left") && names.contains(&"right"), "{names:?}");

    // The same depths in all of them: 32-bit floats at the end of the NPY file, half millimetres in the PNG file.
    let exr = photosite::io::exr::read_exr(std::io::Cursor::new(&results["truth.exr"])).expect("an EXR file").planes;
    let depths = exr.plane("depth").expect("a plane of depths");
    let npy = &results["truth-depth.npy"];
    let tail: Vec<u8> = depths.iter().flat_map(|depth| depth.to_le_bytes()).collect();
    assert_eq!(npy[npy.len() - tail.len()..], tail);
    let png = image::load_from_memory(&results["truth-depth.png"]).expect("an image").into_luma16();
    for (code, &depth) in png.iter().zip(depths) {
        let expected = if depth.is_finite() { (f64::from(depth) / 0.5e-3).round() } else { 0.0 };
        assert_eq!(f64::from(*code), expected);
    }
    // The camera stands 3.2 m before the middle of the room, and nothing of it is farther away than its corner.
    assert!(depths.iter().any(|d| (2.0..4.0).contains(d)) && depths.iter().all(|d| *d < 5.0 || d.is_infinite()));
    folder.fail("render capture.toml --seed 2 -o out", 2, &["contains the results of an earlier render", "--force"]);
}

#[rstest]
#[case::layer(
    "output.truth=['depths']",
    "output.truth: expected true, false, or a list such as [\"depth\", \"normal\"]"
)]
#[case::no_room("output.truth=['uv'] --set output.truth_formats=['png']", "16-bit PNG files have no room for uv")]
#[case::nothing("output.truth_formats=['npy']", "truth_formats: has no meaning without layers")]
#[case::too_far(
    "output.truth=['depth'] --set output.truth_formats=['png'] --set output.truth_depth_unit_mm=0.01",
    "does not fit into 16 bits of 0.01 mm"
)]
fn impossible_ground_truth_is_refused(#[case] set: &str, #[case] message: &str) {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    folder.fail(&format!("render capture.toml -o out --set {set}"), 1, &[message]);
}

#[test]
fn noise_maps_appear_on_request_and_sum_to_the_raw_image() {
    let folder = room("frames = 2\n[render]\nsamples_per_pixel = 4\n[output]\nraw = ['npy']\nnoise = true\n");
    folder.succeed("render capture.toml -o out");
    folder.succeed("expose out -o again --set output.noise=['dsnu_e','saturated'] --set output.noise_formats=['npy']");
    for frame in 0..2 {
        let read = |name: &str, results: &str| folder.results(results)[&format!("{name}-{frame:04}.exr")].clone();
        let maps = photosite::io::exr::read_exr(std::io::Cursor::new(read("noise", "out"))).expect("EXR");
        let (gain, black) = (maps.number("systemGain").expect("K"), maps.number("blackLevel").expect("a level"));
        let raw = &folder.results("out")[&format!("raw-{frame:04}.npy")];
        let raw = photosite::raw::read_npy(&raw[..]).expect("numbers");
        for (i, &number) in raw.data.iter().enumerate() {
            let part = |channel: &photosite::image::Channel| match channel.name.rsplit_once('_') {
                Some((_, "e")) => gain * f64::from(channel.data[i]),
                Some((_, "dn")) => f64::from(channel.data[i]),
                Some(_) | None => 0.0,
            };
            let sum: f64 = black + maps.planes.channels().iter().map(part).sum::<f64>();
            // Of 34 maps, each no larger than 4095 DN, as 32-bit floats.
            assert!((sum - f64::from(number)).abs() < 34.0 * 4095.0 * (-24f64).exp2(), "{sum} for {number}");
        }
        // The same pattern in each frame and after exposing again, as NumPy has it.
        let npy = &folder.results("again")[&format!("noise-dsnu_e-{frame:04}.npy")];
        let values: Vec<f32> = npy[npy.len() - 4 * raw.data.len()..]
            .chunks(4)
            .map(|bytes| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
            .collect();
        assert_eq!(maps.planes.plane("dsnu_e"), Some(&values[..]));
    }
    let files: Vec<String> = folder.results("again").into_keys().filter(|name| name.starts_with("noise")).collect();
    let names =
        ["noise-dsnu_e-0000.npy", "noise-dsnu_e-0001.npy", "noise-saturated-0000.npy", "noise-saturated-0001.npy"];
    assert_eq!(files, names);
    folder.fail("render capture.toml -o x --set output.noise=['read_noise']", 1, &["output.noise", "read_noise_e"]);
    folder.fail(
        "render capture.toml -o x --set output.noise=false --set output.noise_formats=['npy']",
        1,
        &["output.noise_formats: has no meaning without maps"],
    );
    folder.fail("render capture.toml -o x --set output.noise_formats=['png']", 1, &["output.noise_formats", "png"]);
}
