//! `photosite expose`: stored light exposed again.

use std::io::Cursor;

use photosite::io::exr::{Attribute, read_exr, write_exr};
use photosite::math::statistics::Moments;
use rstest::rstest;
use serde_json::json;

use crate::folder::Folder;
use crate::room::room;
use crate::same_bytes::timeless;

/// The room, rendered into `out` with irradiance from 300 to 1100 nm.
fn rendered(more: &str) -> Folder {
    let folder = room(&format!(
        "{more}\n[render]\nsamples_per_pixel = 8\nseed = 3\n[output]\nraw = ['dng', 'npy']\n\
         irradiance = {{ bands_nm = [300, 1100, 5] }}\n"
    ));
    folder.succeed("render capture.toml -o out");
    folder
}

/// Sums of the channels of `electrons.exr`.
fn sums(folder: &Folder, name: &str) -> Vec<f64> {
    let planes = folder.electrons(name).mean;
    planes.channels().iter().map(|c| c.data.iter().map(|&e| f64::from(e)).sum()).collect()
}

#[rstest]
#[case::most("exposure.time_s=1", true)]
#[case::little("exposure.time_s=0.0001", false)]
#[case::automatic("exposure.auto=true", false)]
fn an_image_that_is_mostly_saturated_is_told_of(#[case] set: &str, #[case] is_told: bool) {
    let folder = room("[render]\nsamples_per_pixel = 8\n[output]\nraw = ['dng']\n");
    let told = folder.succeed(&format!("render capture.toml -o out --set {set}")).stderr;
    assert_eq!(told.contains("% of the image is saturated: shorten exposure.time_s"), is_told, "{told}");
    let raw = folder.raw("out/raw.dng");
    let saturated = raw.data.iter().filter(|&&dn| dn >= raw.white_level_dn).count();
    assert_eq!(saturated > raw.data.len() / 2, is_told, "{saturated} of {}", raw.data.len());
}

/// A bright thing too small for automatic exposure to mind is clipped, which is said with what to write; so written, it
/// is not clipped.
#[test]
fn small_bright_things_that_automatic_exposure_clips_are_told_of() {
    let capture = "[scene]\nenvironment = 'even'\nground = { reflectance = 0.02 }\n\
                   spheres = [{ material = 'white', position_m = [0, 0.1, 0], radius_m = 0.03 }]\n\
                   [materials.white]\ntype = 'diffuse'\nreflectance = 0.9\n\
                   [camera]\nposition_m = [0, 1, 0.01]\nlook_at_m = [0, 0, 0]\n[lens]\ntype = 'pinhole'\n\
                   focal_length_mm = 6\n[sensor]\npreset = 'sony-imx249-mono'\nresolution_px = [96, 72]\n\
                   pixel_pitch_um = [80, 80]\n[exposure]\nauto = true\n[render]\nsamples_per_pixel = 16\n";
    let folder = Folder::new([("capture.toml", capture.into())]);
    let words = "% of the image is saturated, which automatic exposure allows";
    let saturated = |name: &str| {
        let raw = folder.raw(&format!("{name}/raw.dng"));
        raw.data.iter().filter(|&&dn| dn >= raw.white_level_dn).count()
    };
    let told = folder.succeed("render capture.toml -o out").stderr;
    assert!(told.contains(words) && told.contains("exposure.auto_brighter_part = 0"), "{told}");
    assert!(saturated("out") > 7);
    let told = folder.succeed("render capture.toml -o whole --set exposure.auto_brighter_part=0").stderr;
    assert!(!told.contains(words), "{told}");
    assert_eq!(saturated("whole"), 0);
}

/// The search for the matrices of a sensor takes longer than to expose a small image: a number in the report that no
/// search would find must arrive in the raw file.
#[test]
fn the_colours_of_a_sensor_are_not_fitted_again() {
    let folder = room("[render]\nsamples_per_pixel = 1\n[output]\nraw = ['dng']\n");
    folder.succeed("render capture.toml -o out");
    let mut report = folder.report("out");
    let calibration = &mut report["sensor"]["calibration"]["lights"][1];
    assert_eq!(calibration["light"], 21, "D65 is EXIF's light source 21");
    calibration["colour_matrix"][0][0] = json!(0.8125);
    folder.add("out/capture.json", report.to_string());
    let red = |name: &str| folder.raw(&format!("{name}/raw.dng")).metadata.colour_matrix_d65().expect("colours")[0][0];
    assert_ne!(red("out"), 0.8125);
    folder.succeed("expose out -o same");
    assert_eq!(red("same"), 0.8125);
    // Behind another filter array of the same channels, too; not where the channels are others.
    folder.succeed("expose out -o array --set sensor.cfa=BGGR");
    assert_eq!(red("array"), 0.8125);
    let sharper = "--set sensor.channels.G.quantum_efficiency=0.5";
    folder.succeed(&format!("render capture.toml -o other {sharper}"));
    let mut other = folder.report("other");
    let found = other["sensor"]["calibration"]["lights"].clone();
    other["sensor"]["calibration"] = report["sensor"]["calibration"].clone();
    folder.add("other/capture.json", other.to_string());
    folder.succeed("expose other -o fitted");
    assert_eq!(folder.report("fitted")["sensor"]["calibration"]["lights"], found);
}

#[rstest]
#[case::fixed_time("")]
#[case::automatic("auto = true")]
#[case::frames("frames = 2")]
fn what_is_not_changed_gives_the_same_bytes_as_render(#[case] exposure: &str, #[values(1, 2)] threads: usize) {
    let folder = room("[render]\nsamples_per_pixel = 4\nseed = 3\n[output]\nraw = ['dng', 'npy']\n");
    let time = if exposure.starts_with("auto") { exposure.to_owned() } else { format!("time_s = 0.0002\n{exposure}") };
    folder.change("capture.toml", "time_s = 0.0002", &time);
    folder.succeed("render capture.toml -o out");
    folder.succeed(&format!("expose out -o again --threads {threads}"));
    let (mut first, mut again) = (folder.results("out"), folder.results("again"));
    for results in [&mut first, &mut again] {
        results.remove("capture.json");
    }
    assert!(first.keys().eq(again.keys()), "{:?}", again.keys());
    for (name, bytes) in &first {
        assert!(*bytes == again[name], "{name} differs");
    }
    let [mut first, again] = ["out", "again"].map(|name| timeless(folder.report(name)));
    // Of what decides a render, which an exposure of its light is not.
    assert!(first.as_object_mut().is_some_and(|keys| keys.shift_remove("fingerprint").is_some()));
    let keys = |report: &serde_json::Value| report.as_object().expect("an object").keys().cloned().collect::<Vec<_>>();
    assert_eq!(keys(&first), keys(&again));
    for key in keys(&first).iter().filter(|key| *key != "input") {
        assert_eq!(first[key], again[key], "{key}");
    }
    // And what was exposed can be exposed again.
    folder.succeed("expose again/electrons.exr -o third");
    assert!(folder.results("third")["image.png"] == first_image(&folder));
}

#[test]
fn what_automatic_gain_control_chose_gives_the_same_bytes_when_it_is_written_down() {
    let folder = room("[render]\nsamples_per_pixel = 4\nseed = 3\n[output]\nraw = ['dng', 'npy']\n");
    let capture = folder.text("capture.toml");
    let automatic = "auto_mean = 0.5\nmax_time_s = 0.0000063\nmax_gain_db = 30.0\n";
    folder.add("auto.toml", capture.replace("time_s = 0.0002", automatic));
    folder.succeed("render auto.toml -o auto");
    let chosen = &folder.report("auto")["exposure"];
    assert_eq!(
        (&chosen["time_s"], &chosen["auto"], &chosen["gain_db"]),
        (&json!(0.0000063), &json!(true), &json!(24.0))
    );
    let digital = chosen["digital_gain_db"].as_f64().expect("a number");
    assert!(digital > 0.0 && digital <= 6.0, "{chosen}");
    let iso = folder.raw("auto/raw.dng").metadata.iso.expect("a speed");
    assert_eq!(Some(f64::from(iso)), chosen["iso"].as_f64().map(f64::round));

    let explicit =
        format!("time_s = {}\ngain_db = {}\ndigital_gain_db = {digital}\n", chosen["time_s"], chosen["gain_db"]);
    folder.add("explicit.toml", capture.replace("time_s = 0.0002", &explicit));
    folder.succeed("render explicit.toml -o explicit");
    // And exposed again from the stored electrons.
    folder.succeed("expose auto -o again");
    for name in ["raw.dng", "raw.npy", "image.png", "electrons.exr"] {
        let first = &folder.results("auto")[name];
        assert!(*first == folder.results("explicit")[name], "{name} differs when written down");
        assert!(*first == folder.results("again")[name], "{name} differs when exposed again");
    }
}

#[test]
fn what_is_set_takes_the_place_of_what_says_the_same() {
    let folder = room("gain_db = 6\n[render]\nsamples_per_pixel = 1\n");
    folder.succeed("render capture.toml -o out");
    let exposure = |arguments: &str| {
        folder.succeed(&format!("expose out -o again --force {arguments}"));
        folder.report("again")["exposure"].clone()
    };
    let fast = exposure("--set exposure.iso=100000");
    // Rounding of logarithms and powers.
    assert!((fast["iso"].as_f64().expect("a number") - 1e5).abs() < 1e-4, "{fast}");
    assert_eq!(exposure("--set exposure.auto=true")["auto"], true);
    assert_eq!(exposure("--set exposure.auto_mean=0.2 --set exposure.max_time_s=0.001")["auto"], true);
    assert_eq!(exposure("--set exposure.auto=true --set exposure.time_s=0.002")["time_s"], 0.002);
    let bracket = exposure("--set exposure.bracket_times_s=[0.004,0.001,0.002]");
    assert_eq!((&bracket["time_s"], &bracket["bracket_s"]), (&json!(0.002), &json!([0.004, 0.001, 0.002])));
}

fn first_image(folder: &Folder) -> Vec<u8> {
    folder.results("out")["image.png"].clone()
}

#[test]
fn a_sensor_of_files_is_kept_wherever_the_command_is_given() {
    let folder = room("[render]\nsamples_per_pixel = 2\n");
    folder.add("sensors/flat.csv", "wavelength_nm,value\n300,0.5\n1100,0.5\n");
    folder.add(
        "sensors/mine.toml",
        "resolution_px = [8, 6]\npixel_pitch_um = [100, 100]\ncfa = 'mono'\n\
         channels.Y.quantum_efficiency = { file = 'flat.csv' }\ncharge.full_well_e = 1e6\n\
         noise = { read_noise_e = 2, dark_current_e_per_s = 1, dark_current_reference_c = 25, \
         dark_current_doubling_k = 8, prnu_percent = 1, dsnu_e = 1 }\n\
         adc = { bits = 12, conversion_gain_dn_per_e = 0.004, black_level_dn = 64, gain_db_range = [0, 20] }\n",
    );
    let capture = folder.text("capture.toml");
    folder.add(
        "scene/capture.toml",
        capture
            .replace("[sensor]", "[sensor]\npreset = '../sensors/mine.toml'")
            .replace("\"room.obj\"", "\"../room.obj\"")
            .replace("\"sails.gltf\"", "\"../sails.gltf\"")
            .replace("\"sky.hdr\"", "\"../sky.hdr\""),
    );
    folder.succeed("render scene/capture.toml -o out");
    let status = folder.command("expose ../out -o ../again -q").current_dir(folder.path("sensors")).status();
    assert!(status.expect("runs").success());
    assert!(folder.results("out")["raw.dng"] == folder.results("again")["raw.dng"]);
    assert_eq!(folder.raw("again/raw.dng").metadata.camera_model, "mine");
}

#[test]
fn time_scales_the_electrons_and_the_seed_the_noise() {
    let folder = rendered("");
    folder.succeed("expose out -o longer --set exposure.time_s=0.0006");
    folder.succeed("expose out -o other --seed 9");
    let (one, three) = (sums(&folder, "out"), sums(&folder, "longer"));
    for (one, three) in one.iter().zip(&three) {
        // Each of 768 numbers is rounded to 2⁻²⁴ of itself.
        assert!((three / one / 3.0 - 1.0).abs() < 1e-7);
    }
    let variance = |name: &str| folder.electrons(name).variance.channels()[0].data[100];
    assert!((variance("longer") / variance("out") / 9.0 - 1.0).abs() < 1e-6);
    assert_eq!(folder.report("longer")["exposure"]["time_s"], 0.0006);
    assert_eq!(folder.report("longer")["overrides"], json!(["exposure.time_s=0.0006"]));
    assert!(folder.results("other")["electrons.exr"] == folder.results("out")["electrons.exr"]);
    let (first, other) = (folder.raw("out/raw.dng"), folder.raw("other/raw.dng"));
    assert!(first.data != other.data);
    assert_eq!((&folder.report("other")["seed"], &folder.report("other")["render"]["seed"]), (&9.into(), &3.into()));
}

#[test]
fn frames_have_noise_of_their_own_and_the_same_patterns() {
    let folder = rendered("");
    // Fixed patterns far above temporal noise: what frames have in common is the pattern.
    folder.succeed("expose out -o out2 --frames 3 --set sensor.noise.dsnu_e=200 --set exposure.time_s=0.000001");
    let [a, b, c] = [0, 1, 2].map(|frame| folder.raw(&format!("out2/raw-{frame:04}.dng")).data);
    assert!(a != b && b != c);
    let spread = |values: &mut dyn Iterator<Item = f64>| values.collect::<Moments>().variance().sqrt();
    let pattern = spread(&mut a.iter().map(|&a| f64::from(a)));
    let change = spread(&mut a.iter().zip(&b).map(|(&a, &b)| f64::from(a) - f64::from(b)));
    assert!(change > 0.0 && change < 0.25 * pattern, "{change} of {pattern}");
}

#[test]
fn irradiance_gives_what_the_film_counted() {
    let folder = rendered("");
    folder.succeed("expose out/irradiance.exr -o from-irradiance");
    for (traced, banded) in sums(&folder, "out").iter().zip(sums(&folder, "from-irradiance")) {
        // Bands of 5 nm count as flat; lamps with sharp lines there are none. A response that changes by its height
        // within some 50 nm, under light that does the same: (5/50)²/12 ≈ 1e-3.
        assert!((banded / traced - 1.0).abs() < 2e-3, "{banded} for {traced}");
    }
    // Nothing is known of its variance.
    assert_eq!(folder.electrons("from-irradiance").variance.channels().len(), 0);
}

#[test]
fn any_sensor_can_be_exposed_to_irradiance() {
    let folder = rendered("");
    let outcome = folder.succeed("expose out -o mono --set sensor.preset=sony-imx249-mono");
    assert!(outcome.text().contains("pixels of 100 × 100 µm; those of 5.86 × 5.86 µm"), "{}", outcome.stderr);
    let raw = folder.raw("mono/raw.dng");
    assert!(raw.cfa.is_mono() && (raw.width, raw.height) == (32, 24));
    assert_eq!(folder.report("mono")["sensor"]["name"], "sony-imx249-mono");
    // The same through a render of that sensor's own, up to noise of light.
    folder.succeed(
        "render capture.toml -o own --set sensor.preset=sony-imx249-mono --set sensor.pixel_pitch_um=[100,100]",
    );
    folder.succeed(
        "expose out -o same --set sensor.preset=sony-imx249-mono --set sensor.pixel_pitch_um=[100,100] \
         --set exposure.gain_db=0",
    );
    let (own, same) = (folder.electrons("own"), sums(&folder, "same")[0]);
    let sum: f64 = own.mean.channels()[0].data.iter().map(|&e| f64::from(e)).sum();
    let sigma = own.variance.channels()[0].data.iter().map(|&v| f64::from(v)).sum::<f64>().sqrt();
    // Two renders of the same noise, and the bands' 2e-3.
    assert!((same - sum).abs() < 4.5 * 1.5 * sigma + 2e-3 * sum, "{same} for {sum} ± {sigma}");
}

#[test]
fn an_image_without_a_report_takes_its_sensor_from_the_arguments() {
    let folder = rendered("");
    folder.add("light.exr", folder.results("out")["electrons.exr"].clone());
    let outcome = folder.succeed("expose light.exr --set exposure.time_s=0.0002");
    assert!(outcome.text().contains("white balance is that of D65"), "{}", outcome.stderr);
    let raw = folder.raw("light-exposed/raw.dng");
    assert_eq!((raw.width, raw.height, raw.cfa.channels().len()), (32, 24, 3));
}

#[test]
fn the_report_is_printed_on_request_and_nothing_when_quiet() {
    let folder = rendered("");
    let outcome = folder.succeed("expose out -o a --json");
    let report = outcome.json();
    assert_eq!(report, folder.report("a"));
    assert_eq!(report["camera"], folder.report("out")["camera"]);
    let outcome = folder.succeed("expose out -o a --quiet --force");
    assert_eq!((outcome.stdout.as_str(), outcome.stderr.as_str()), ("", ""));
}

#[test]
fn what_cannot_be_exposed_is_told() {
    let folder = rendered("");
    let electrons = folder.results("out")["electrons.exr"].clone();
    let fail = |arguments: &str, status, wanted: &[&str]| {
        folder.fail(arguments, status, wanted);
    };
    fail("expose nowhere", 1, &["nowhere", "cannot read"]);
    fail("expose .", 1, &["has no capture.json", "photosite render filled"]);
    fail("expose capture.toml", 1, &["capture.toml: is a capture file", "photosite render"]);
    folder.add("half.exr", &electrons[..electrons.len() / 2]);
    fail("expose half.exr", 1, &["half.exr", "OpenEXR"]);
    folder.add("bare/capture.json", folder.results("out")["capture.json"].clone());
    fail("expose bare", 1, &["bare", "neither electrons.exr nor irradiance.exr", "output.irradiance"]);
    folder.add("bare/electrons.exr", &electrons);
    let mono = "--set sensor.preset=sony-imx249-mono";
    fail(&format!("expose bare {mono}"), 1, &["electrons.exr counts", "output.irradiance=true"]);
    fail(&format!("expose out/electrons.exr {mono}"), 1, &["electrons.exr counts"]);
    folder.add("light.exr", &electrons);
    fail(&format!("expose light.exr {mono}"), 1, &["sensor.cfa", "channel Y", "B, G, R", "irradiance.exr"]);
    fail("expose out --set sensor.resolution_px=[8,8]", 1, &["resolution_px", "32 × 24", "8 × 8"]);
    fail("expose out --set lens.f_number=4", 2, &["lens.f_number=4", "already been traced", "render again"]);
    fail("expose out --set exposure.tim_s=4", 1, &["tim_s", "time_s"]);
    fail("expose out --set exposure.gain_db=999", 1, &["gain_db", "999"]);
    fail("expose out -o out --force", 2, &["take the place of the light", "-o"]);
    folder.add("bare/capture.json", "{ \"capture\": ");
    fail("expose bare", 1, &["capture.json", "is damaged"]);
    folder.add("bare/capture.json", "{}");
    fail("expose bare", 1, &["capture.json", "holds no capture"]);
}

#[test]
fn images_of_something_else_are_refused() {
    let folder = rendered("");
    let file = folder.results("out")["electrons.exr"].clone();
    let planes = read_exr(Cursor::new(&file)).expect("readable").planes;
    let write = |attributes: &[(&str, Attribute)]| {
        let mut bytes = Vec::new();
        write_exr(&planes, attributes, Cursor::new(&mut bytes)).expect("written");
        bytes
    };
    let text = |value: &str| Attribute::Text(value.to_owned());
    folder.add("rgb.exr", write(&[]));
    folder.fail("expose rgb.exr", 1, &["rgb.exr", "neither electrons nor spectral irradiance"]);
    folder.add("lux.exr", write(&[("unit", text("lux"))]));
    folder.fail("expose lux.exr", 1, &["lux.exr", "unit"]);
    let radiance = [("spectralLayoutVersion", text("1.0")), ("emissiveUnits", text("W.m^-2.sr^-1.nm^-1"))];
    folder.add("radiance.exr", write(&radiance));
    folder.fail("expose radiance.exr", 1, &["radiance.exr", "emissiveUnits"]);
}

/// A grey wall under an even sky, exposed automatically.
fn wall(lux: f64, exposure: &str) -> Folder {
    let capture = format!(
        "[scene]\ngeometry = ['wall.obj']\nenvironment = {{ illuminant = 'A', illuminance_lux = {lux} }}\n\
         [materials.wall]\ntype = 'diffuse'\nreflectance = 0.5\n[camera]\nposition_m = [0, 0, 2]\nlook_at_m = [0, 0, 0]\n\
         [lens]\ntype = 'pinhole'\n[sensor]\npreset = 'sony-imx249-mono'\nresolution_px = [8, 8]\n[exposure]\n{exposure}\n\
         [render]\nsamples_per_pixel = 16\n"
    );
    let obj = "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nusemtl wall\nf 1 2 3 4\n";
    Folder::new([("wall.obj", obj.into()), ("capture.toml", capture.into())])
}

#[rstest]
#[case::time_in_its_place("time_s = 0.01", "--set exposure.auto=true", "exposure.auto=true replaces exposure.time_s")]
#[case::limit_in_its_place("time_s = 0.01", "--set exposure.max_time_s=9", "replaces exposure.time_s")]
#[case::limits_lost("max_time_s = 9", "--set exposure.time_s=0.01", "replaces exposure.max_time_s")]
#[case::gain_lost("gain_db = 3", "--set exposure.iso=1000", "replaces exposure.gain_db")]
#[case::two_arguments(
    "",
    "--set exposure.auto=true --set exposure.time_s=0.01",
    "exposure.time_s=0.01 replaces exposure.auto"
)]
#[case::a_time_for_none("auto = true", "--set exposure.time_s=0.01", "")]
#[case::another_time("time_s = 0.01", "--set exposure.time_s=0.02", "")]
fn keys_that_an_argument_makes_void_are_named(#[case] exposure: &str, #[case] arguments: &str, #[case] warning: &str) {
    let folder = wall(500.0, exposure);
    for command in [format!("render capture.toml -o out {arguments}"), format!("expose plain -o again {arguments}")] {
        if command.starts_with("expose") {
            folder.succeed("render capture.toml -o plain --quiet");
        }
        let outcome = folder.succeed(&command);
        let name = command.split(' ').nth(3).expect("a folder");
        let warnings = folder.report(name)["warnings"].clone();
        let warnings = warnings.as_array().expect("a list");
        if warning.is_empty() {
            assert!(warnings.is_empty(), "{warnings:?}");
        } else {
            assert!(warnings.len() == 1 && outcome.text().contains(warning), "{command}: {}", outcome.stderr);
        }
    }
}

#[test]
fn both_keys_in_a_file_are_an_error() {
    let folder = wall(500.0, "time_s = 0.01\nauto = true");
    folder.fail(
        "render capture.toml -o out",
        1,
        &["exposure.auto: cannot be combined with time_s", "keep one of them"],
    );
}

#[test]
fn automatic_exposure_says_where_it_ends() {
    let time = |folder: &Folder, name: &str| folder.report(name)["exposure"]["time_s"].as_f64().expect("a time");
    let warnings = |folder: &Folder, name: &str| folder.report(name)["warnings"].as_array().expect("a list").len();
    let folder = wall(500.0, "");
    folder.succeed("render capture.toml -o out");
    let free = time(&folder, "out");
    assert!((1e-6..10.0).contains(&free) && warnings(&folder, "out") == 0, "{free}");
    // Of a time that is a fifth, gain makes up for all; of a thousandth, for 24 dB or whatever the sensor has.
    let gain_db = "--set exposure.gain_db=0";
    let limited = |part: f64, more: &str| {
        let limit = free * part;
        let outcome =
            folder.succeed(&format!("expose out -o limited --force --set exposure.max_time_s={limit:e} {more}"));
        assert!((time(&folder, "limited") / limit - 1.0).abs() < 1e-12 && warnings(&folder, "limited") == 1);
        outcome.text()
    };
    let said = limited(0.2, "");
    assert!(said.contains("(exposure.max_time_s), at a gain of 13.98 dB, which makes up for the rest"), "{said}");
    // Nothing but the time counts where the gain is stated: a fifth of the brightness.
    let said = limited(0.2, gain_db);
    assert!(
        said.contains(
            "at a gain of 0.00 dB, and the image is 2.3 EV darker than it should be: write exposure.max_time_s = "
        ),
        "{said}"
    );
    let needed = said.split("write exposure.max_time_s = ").nth(1).and_then(|rest| rest.split(',').next());
    let needed: f64 = needed.expect("a time").parse().expect("a number");
    // Rounded up to two digits, of which the first is at least 1.
    assert!((1.0 - 1e-9..=1.1).contains(&(needed / free)), "{needed} s for {free} s");
    // 10 dB are √10.
    let said = limited(0.01, "--set exposure.max_gain_db=10");
    assert!(said.contains("at a gain of 10.00 dB, and the image is 5.0 EV darker than it should be"), "{said}");

    // Times are in inverse proportion to light, but for the dark current. Where none is stated, 4 s are the longest, and
    // the gain rises as far as it can.
    for (lux, more, count, words) in [
        (500.0 * free / 60.0, "--set exposure.max_time_s=90", 1, ["there is little light", "exposure.max_time_s"]),
        (500.0 * free / 60.0, "", 1, ["longest time, 4 s (exposure.max_time_s)", "which makes up for the rest"]),
        (
            500.0 * free / 4096.0,
            "",
            // At this gain the noise reaches below black, too.
            2,
            ["longest time, 4 s (exposure.max_time_s)", "at a gain of 30.00 dB, and the image is 4.9 EV darker"],
        ),
        (500.0 * free * 1e7, "", 1, ["shorter than shutters are", "lens.f_number"]),
    ] {
        let folder = wall(lux, "");
        let outcome = folder.succeed(&format!("render capture.toml -o out {more}"));
        let said = outcome.text();
        assert!(words.iter().all(|words| said.contains(words)) && warnings(&folder, "out") == count, "{said}");
        // Again from the stored light.
        assert!(folder.succeed(&format!("expose out -o again {more}")).text().contains(words[0]));
    }
}

#[test]
fn compensation_makes_an_automatic_exposure_longer_and_goes_with_no_other() {
    let folder = wall(500.0, "");
    folder.succeed("render capture.toml -o out");
    let time = |name: &str| folder.report(name)["exposure"]["time_s"].as_f64().expect("a time");
    for (metering, ev) in [("", 1.0), ("", -3.0), (" --set exposure.auto_mean=0.2", 0.5)] {
        folder.succeed(&format!("expose out -o without --force{metering}"));
        folder.succeed(&format!("expose out -o with --force{metering} --set exposure.compensation_ev={ev}"));
        let factor = time("with") / time("without");
        // Stored electrons are single precision.
        assert!((factor / f64::exp2(ev) - 1.0).abs() < 1e-6, "{metering} {ev}: {factor}");
    }
    let wrong = [("time_s=0.01", "only applies with automatic exposure"), ("auto=true", "must lie between -20 and 20")];
    for ((other, words), ev) in wrong.into_iter().zip([1, 30]) {
        let more = format!("--set exposure.compensation_ev={ev} --set exposure.{other}");
        let folder = wall(500.0, if ev == 1 { "time_s = 0.01" } else { "" });
        let more = if ev == 1 { "--set exposure.compensation_ev=1" } else { &more };
        folder.fail(&format!("render capture.toml -o out {more}"), 1, &["exposure.compensation_ev", words]);
    }
}
