//! `photosite fit`, and `photosite emva1288 --like`.

use rstest::rstest;
use serde_json::Value;

use crate::folder::Folder;

/// Set of a sensor with figures that a few small images tell.
const SET: &str = "emva1288 sony-imx249-mono --size 64x48 --steps 12 --spatial 8 -q -o set --set serial=7 \
                   --set noise.row_noise_e=3 --set noise.prnu_percent=1 --set noise.dsnu_e=4 --set charge.full_well_e=24000";

fn parameter(report: &Value, key: &str) -> [f64; 2] {
    let all = report["parameters"].as_array().expect("a list");
    let found = all.iter().find(|p| p["key"] == key).unwrap_or_else(|| panic!("{key} in {report}"));
    ["value", "standard_error"].map(|name| found[name].as_f64().expect("a number"))
}

fn reasons(report: &Value) -> String {
    let all = report["left_out"].as_array().expect("a list").iter();
    all.map(|n| format!("{}: {}\n", n["figure"].as_str().unwrap_or(""), n["reason"].as_str().unwrap_or(""))).collect()
}

#[test]
fn a_twin_takes_the_set_that_it_was_fitted_to() {
    let folder = Folder::new([]);
    folder.succeed(SET);
    let report = folder.succeed("fit set -o twin.toml --json --pixel-pitch-um 5.86").json();
    for (key, truth, most) in [
        // Errors of 3072 pixels in 8 points below 70 %, and in 12 pairs of dark images.
        ("adc.conversion_gain_dn_per_e", 0.1245, 0.02),
        ("noise.read_noise_e", 6.3, 0.03),
        ("noise.row_noise_e", 3.0, 0.05),
        ("noise.dsnu_e", 4.0, 0.04),
        ("noise.prnu_percent", 1.0, 0.03),
        ("charge.full_well_e", 24000.0, 0.02),
        ("adc.black_level_dn", 64.0, 0.001),
    ] {
        let [value, error] = parameter(&report, key);
        assert!((value - truth).abs() < 4.0 * error, "{key}: {value} ± {error} instead of {truth}");
        assert!(error < most * truth, "{key}: ± {error}");
    }
    let left_out = reasons(&report);
    for figure in
        ["column noise: not told apart from 0: below", "quantum efficiency at other wavelengths: the light had"]
    {
        assert!(left_out.contains(figure), "{left_out}");
    }
    let text = folder.text("twin.toml");
    assert!(text.contains("pixel_pitch_um = [5.86, 5.86]  # as stated"), "{text}");
    assert!(text.contains("black_level_dn = 64  # ") && text.contains("dark_current_reference_c = 25.0  # as stated"));
    folder.fail("fit set -o twin.toml", 2, &["twin.toml already exists", "--force"]);

    folder.succeed("emva1288 twin.toml --like set -o again -q --seed 3");
    let [first, second] = ["set", "again"].map(|name| {
        let path = format!("{name}/Y/emva1288.txt");
        let text = folder.text(&path);
        text.lines().filter(|line| !line.starts_with('i')).map(str::to_owned).collect::<Vec<_>>()
    });
    assert_eq!(first.len(), second.len());
    for (first, second) in first.iter().zip(&second) {
        for (a, b) in first.split(' ').zip(second.split(' ')) {
            // Seconds and nanoseconds round.
            let is_near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * a.abs();
            let same = a == b || matches!((a.parse(), b.parse()), (Ok(a), Ok(b)) if is_near(a, b));
            assert!(same, "exposure times, photons and bits: {first} and {second}");
        }
    }
    let again = folder.succeed("fit again -o third.toml --json").json();
    for key in ["adc.conversion_gain_dn_per_e", "noise.read_noise_e", "noise.prnu_percent", "quantum_efficiency"] {
        let ([a, a_error], [b, b_error]) = (parameter(&report, key), parameter(&again, key));
        assert!((a - b).abs() < 4.0 * a_error.hypot(b_error), "{key}: {a} and {b}");
    }
    folder.fail("emva1288 twin.toml --like set --steps 9 -o x", 2, &["--like", "cannot be used with"]);
}

/// Files of the set above as a folder of flats and darks, whose names say what they are.
fn plain_folder(folder: &Folder) {
    folder.succeed(SET);
    add_to_plain_folder(folder, "set", "");
}

/// Adds the files of a set to the folder, with another word in their names.
fn add_to_plain_folder(folder: &Folder, set: &str, word: &str) {
    let descriptor = folder.text(&format!("{set}/Y/emva1288.txt"));
    let mut head = (String::new(), String::new());
    for line in descriptor.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            ["d", ns] => head = ("dark".to_owned(), ns.to_owned()),
            ["b", ns, _] => head = ("flat".to_owned(), ns.to_owned()),
            ["i", path] => {
                let name = path.rsplit('\\').next().expect("a name");
                let bytes = folder.bytes(&format!("{set}/Y/images/{name}"));
                let us = head.1.parse::<f64>().expect("a time") / 1000.0;
                folder.add(&format!("frames/{}_{us}us_{word}{name}", head.0), bytes);
            }
            _ => {}
        }
    }
}

#[test]
fn a_folder_of_flats_and_darks_tells_all_but_the_quantum_efficiency() {
    let folder = Folder::new([]);
    plain_folder(&folder);
    let of_set = folder.succeed("fit set -o a.toml --json").json();
    let of_folder = folder.succeed("fit frames -o b.toml --json").json();
    for key in ["adc.conversion_gain_dn_per_e", "noise.read_noise_e", "noise.dark_current_e_per_s"] {
        let ([a, error], [b, _]) = (parameter(&of_set, key), parameter(&of_folder, key));
        assert!((a - b).abs() < error, "{key}: {a} and {b}");
    }
    let text = folder.text("b.toml");
    assert!(text.contains("quantum_efficiency = 1.0  # assumed: the number of photons"), "{text}");
    folder.succeed("info b.toml");
    folder.fail("emva1288 b.toml --like frames -o x", 1, &["does not state the photons", "frames.csv"]);
}

/// Case: a camera whose read noise falls and whose black level rises with gain, as images at two gains in one folder, makes a sensor that does so.
#[test]
fn images_of_several_gains_become_steps_of_gain() {
    const CAMERA: &str = "emva1288 sony-imx249-mono --size 64x64 -q --set noise.dsnu_e=4 --set adc.gain_db_range=[0,24] \
                          --set noise.gain_steps=[{gain_db=0,read_noise_e=20,row_noise_e=8,dsnu_e=16,black_level_dn=64},\
                          {gain_db=12,read_noise_e=12,row_noise_e=5,dsnu_e=10,black_level_dn=80}]";
    let folder = Folder::new([]);
    for gain in [0, 12] {
        folder.succeed(&format!("{CAMERA} --gain-db {gain} --seed {gain} -o set{gain}"));
        add_to_plain_folder(&folder, &format!("set{gain}"), &format!("{gain}dB_"));
    }
    let report = folder.succeed("fit frames -o twin.toml --json").json();
    let steps = report["gain_steps"].as_array().expect("steps");
    assert_eq!(steps.iter().map(|step| step["gain_db"].as_f64()).collect::<Vec<_>>(), [Some(0.0), Some(12.0)]);
    let keys = ["noise.read_noise_e", "noise.row_noise_e", "adc.black_level_dn"];
    for (step, figures) in steps.iter().zip([[20.0, 8.0, 64.0], [12.0, 5.0, 80.0]]) {
        for (key, wanted) in keys.into_iter().zip(figures) {
            let parameters = step["parameters"].as_array().expect("parameters");
            let found = parameters.iter().find(|p| p["key"] == key).unwrap_or_else(|| panic!("{key}: {step}"));
            let [value, error] = ["value", "standard_error"].map(|part| found[part].as_f64().expect("a number"));
            // 4 standard errors of a fixed seed, and no error that would let anything pass.
            assert!((value - wanted).abs() < 4.0 * error && error < 0.1 * wanted, "{key}: {value} ± {error}, {wanted}");
        }
    }
    let info = folder.succeed("info twin.toml --json").json();
    let blacks: Vec<_> = info["gain_steps"].as_array().expect("steps").iter().map(|s| &s["black_level_dn"]).collect();
    assert_eq!(blacks, [64, 80], "{info}");
    // The twin is taken at a gain between.
    folder.succeed("emva1288 twin.toml --gain-db 6 --size 32x32 -q -o between");
    folder.fail("emva1288 twin.toml --like frames -o x", 1, &["has images of several gains"]);
}

#[test]
fn dark_images_alone_tell_the_dark_noise() {
    let folder = Folder::new([]);
    plain_folder(&folder);
    std::fs::create_dir(folder.path("darks")).expect("a folder");
    for entry in std::fs::read_dir(folder.path("frames")).expect("a folder") {
        let name = entry.expect("an entry").file_name().to_string_lossy().into_owned();
        if name.starts_with("dark") {
            let [from, to] = ["frames", "darks"].map(|of| folder.path(&format!("{of}/{name}")));
            std::fs::rename(from, to).expect("moved");
        }
    }
    let report = folder.succeed("fit darks -o dn.toml --json").json();
    let [in_dn, _] = parameter(&report, "noise.read_noise_e");
    // 6.3 e⁻ of 0.1245 DN each.
    assert!((in_dn / (6.3 * 0.1245) - 1.0).abs() < 0.1, "{in_dn}");
    assert_eq!(report["assumed"][0]["key"], "adc.conversion_gain_dn_per_e");
    assert!(reasons(&report).contains("PRNU: there are no bright images"));
    let stated = folder.succeed("fit darks -o e.toml --json --system-gain 0.1245").json();
    let [in_e, _] = parameter(&stated, "noise.read_noise_e");
    assert!((in_e * 0.1245 / in_dn - 1.0).abs() < 1e-9, "{in_e}");
    folder.succeed("info dn.toml");
    // Without its darks, the rest is refused.
    folder.fail("fit frames -o x.toml", 1, &["no pair of dark images", "with the cap on"]);
}

#[rstest]
#[case::empty("", &["has no images", "DNG"])]
#[case::one_image("dark_1ms_a", &["no pair of dark images", "two images or more"])]
#[case::no_kind("holiday_1ms_a holiday_1ms_b", &["does not say whether it is a dark image or a flat", "frames.csv"])]
#[case::two_kinds_of_gain("dark_1ms_iso100_a dark_1ms_iso100_b dark_1ms_12dB_a dark_1ms_12dB_b", &["has ISO 100", "has 12 dB", "in the same way"])]
#[case::one_gain_unstated("dark_1ms_iso100_a dark_1ms_iso100_b dark_1ms_a dark_1ms_b", &["has no stated gain", "has ISO 100"])]
#[case::gains_without_scale("dark_1ms_gain1_a dark_1ms_gain1_b dark_1ms_gain9_a dark_1ms_gain9_b", &["nothing tells how many dB gain 9 is above gain 1", "add flats"])]
#[case::two_sizes("dark_1ms_a dark_1ms_b wide_dark_2ms_a wide_dark_2ms_b", &["20 × 16 pixels instead of 16 × 16"])]
#[case::two_black_levels("dark_1ms_a dark_1ms_b black90_dark_1ms_c", &["has a mean of 90", "which should be alike"])]
#[case::falling_darks("dark_2ms_a dark_2ms_b black90_dark_1ms_a black90_dark_1ms_b", &["has a dark level of 64", "do not fall with time"])]
#[case::two_lights("dark_1ms_a dark_1ms_b flat_1ms_a flat_1ms_b flat_1ms_c_500", &["which should be alike", "within a tenth"])]
fn what_does_not_belong_together_is_named(#[case] names: &str, #[case] said: &[&str]) {
    let folder = Folder::new([]);
    std::fs::create_dir(folder.path("frames")).expect("a folder");
    for (number, name) in names.split_whitespace().enumerate() {
        let width = if name.contains("wide") { 20 } else { 16 };
        let level = match name {
            name if name.contains("500") => 500,
            name if name.contains("black90") => 90,
            name if name.contains("flat") => 1000,
            _ => 64,
        };
        add_frame(&folder, name, number as u64, width, level);
    }
    folder.fail("fit frames -o x.toml", 1, said);
}

/// Writes frames/NAME.pgm of 12 bits and 16 rows: a level with noise of ±1 in an order of its own for each number.
fn add_frame(folder: &Folder, name: &str, number: u64, width: u64, level: u64) {
    let value = |i: u64| {
        let random =
            (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(number.wrapping_mul(0xd1b5_4a32_d192_ed03));
        (level + (random >> 33) % 3).saturating_sub(1).min(4095)
    };
    let numbers: Vec<String> = (0..width * 16).map(|i| value(i).to_string()).collect();
    folder.add(&format!("frames/{name}.pgm"), format!("P2\n{width} 16\n4095\n{}\n", numbers.join(" ")));
}

#[test]
fn light_that_drifts_and_images_that_nothing_goes_with_are_said() {
    let folder = Folder::new([]);
    for (number, (name, level)) in
        [("dark_1ms_a", 64), ("dark_1ms_b", 64), ("flat_1ms_a", 1000), ("flat_1ms_b", 1019), ("flat_2ms_a", 1900)]
            .into_iter()
            .enumerate()
    {
        add_frame(&folder, name, number as u64, 16, level);
    }
    let report = folder.succeed("fit frames -o x.toml --json").json();
    let notes: Vec<&str> = report["notes"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    // 19 of 945 DN, in single images known to some 0.05 DN.
    let drift = notes.iter().find(|note| note.contains("the light drifts")).unwrap_or_else(|| panic!("{notes:?}"));
    assert!(
        drift.contains("flat_1ms_b.pgm is 2.0") && drift.contains("% brighter than frames/flat_1ms_a.pgm"),
        "{drift}"
    );
    assert!(notes.iter().any(|note| note.contains("flat_2ms_a.pgm: nothing goes with this image")), "{notes:?}");
    // Noise of ±1 in the light as in the dark is none of light.
    let assumed = &report["assumed"][0];
    assert_eq!(assumed["key"], "adc.conversion_gain_dn_per_e");
    assert!(assumed["reason"].as_str().is_some_and(|r| r.contains("does not grow with their signal")), "{assumed}");
}

#[test]
fn saturated_flats_tell_no_gain() {
    let folder = Folder::new([]);
    let frames = [("dark_1ms_a", 64), ("dark_1ms_b", 64), ("flat_1ms_a", 5000), ("flat_1ms_b", 5000)];
    for (number, (name, level)) in frames.into_iter().enumerate() {
        add_frame(&folder, name, number as u64, 16, level);
    }
    let report = folder.succeed("fit frames -o x.toml --json").json();
    let reason = report["assumed"][0]["reason"].as_str().expect("a reason");
    assert!(reason.contains("all bright images are saturated"), "{reason}");
    assert!(reasons(&report).contains("PRNU: there are no bright images below saturation"));
    assert!(!report["parameters"].to_string().contains("prnu"));
    folder.succeed("info x.toml");
}

/// The twin with maps has the patterns of this very camera: averages of its dark images and flats deviate where those of the
/// original do, and as much.
#[test]
fn a_twin_with_maps_has_the_patterns_of_the_camera() {
    let folder = Folder::new([]);
    folder.succeed(&SET.replace("--spatial 8", "--spatial 32"));
    let said = folder.succeed("fit set -o twin.toml --maps --pixel-pitch-um 5.86").stdout;
    assert!(!said.contains("correlate by"), "{said}");
    let text = folder.text("twin.toml");
    assert!(text.contains("prnu_map = { file = \"twin.prnu.npy\" }") && !text.contains("prnu_percent"), "{text}");
    assert!(text.contains("dsnu_map = { file = \"twin.dsnu.npy\" }") && !text.contains("dsnu_e"), "{text}");
    folder.succeed("emva1288 twin.toml --like set -o again -q --seed 3");
    let reports = ["fit set -o first.toml --json", "fit again -o second.toml --maps --json"]
        .map(|command| folder.succeed(command).json());
    for (name, key) in [("prnu", "noise.prnu_percent"), ("dsnu", "noise.dsnu_e")] {
        let [first, second] = ["twin", "second"].map(|twin| {
            photosite::io::map_file::read_map(&folder.path(&format!("{twin}.{name}.npy")), None).expect("a map").values
        });
        // Read noise of 7 e- in 32 images and more beside a DSNU of 4 e-.
        assert!(correlation(&first, &second) > 0.93, "{name}: {}", correlation(&first, &second));
        let [[first, error], [second, other]] = reports.each_ref().map(|report| parameter(report, key));
        assert!((first - second).abs() < 3.0 * error.hypot(other), "{key}: {first} ± {error}, {second} ± {other}");
    }
    std::fs::write(folder.path("third.prnu.npy"), "mine").expect("written");
    folder.fail("fit set -o third.toml --maps", 2, &["third.prnu.npy already exists", "--force"]);
    assert!(!folder.path("third.toml").exists() && !folder.path("third.dsnu.npy").exists());
    // Four images at half of the saturation, with shot noise of 0.9 % of the signal, tell single pixels roughly.
    folder.succeed(&SET.replace("-o set", "-o few").replace("--spatial 8", "--spatial 4"));
    let said = folder.succeed("fit few -o few.toml --maps").stdout;
    assert!(said.contains("pixels of the map of response correlate by 0."), "{said}");
}

#[test]
fn a_response_that_bends_is_straightened() {
    let folder = Folder::new([]);
    folder.succeed(&format!("{SET} --set adc.amplifier_nonlinearity_percent=[-3]"));
    let report = folder.succeed("fit set -o twin.toml --json").json();
    // The standard's gain of such a response is 4 % off, and its full well 3 %.
    for (key, truth, most) in [
        ("adc.amplifier_nonlinearity_percent", -3.0, 0.05),
        ("adc.conversion_gain_dn_per_e", 0.1245, 0.02),
        ("charge.full_well_e", 24000.0, 0.02),
        ("noise.prnu_percent", 1.0, 0.03),
    ] {
        let [value, error] = parameter(&report, key);
        assert!((value - truth).abs() < 4.0 * error && error < f64::abs(most * truth), "{key}: {value} ± {error}");
    }
    let text = folder.text("twin.toml");
    assert!(text.contains("amplifier_nonlinearity_percent = [-"), "{text}");
    folder.succeed("info twin.toml");
}

#[test]
fn defective_pixels_are_none_of_the_maps() {
    let folder = Folder::new([]);
    let defects = "--set defects.dead_per_million=8000 --set defects.hot_per_million=8000 --set defects.hot_dark_current_e_per_s=300";
    folder.succeed(&format!("{SET} {defects}"));
    let report = folder.succeed("fit set -o twin.toml --maps --json").json();
    let count = report["defects"].as_array().expect("a list").len();
    assert!(count > 30, "{count}");
    assert!(report["notes"].to_string().contains(&format!("leave out {count} defective pixels")), "{report}");
    let text = folder.text("twin.toml");
    assert!(text.contains("pixels = { file = \"twin.defects.csv\" }") && !text.contains("per_million"), "{text}");
    folder.succeed("emva1288 twin.toml --like set -o again -q --seed 3");
    let again = folder.succeed("fit again -o second.toml --json").json();
    // The same pixels, but for those whose dark current lies near the threshold.
    let places = |report: &Value, kind: &str| -> Vec<(u64, u64)> {
        let defects = report["defects"].as_array().expect("a list").iter().filter(|defect| defect["kind"] == kind);
        defects.map(|d| (d["x"].as_u64().expect("a column"), d["y"].as_u64().expect("a row"))).collect()
    };
    assert_eq!(places(&report, "dead"), places(&again, "dead"));
    let [first, second] = [&report, &again].map(|report| places(report, "hot"));
    let shared = first.iter().filter(|place| second.contains(place)).count();
    assert!(shared * 10 >= first.len() * 9, "{shared} of {first:?} in {second:?}");
    let [[first, error], [second, _]] = [&report, &again].map(|report| parameter(report, "noise.dsnu_e"));
    assert!((first - second).abs() < 5.0 * error, "{first} ± {error}, {second}");
}

/// Correlation of two patterns about their means.
fn correlation(a: &[f32], b: &[f32]) -> f64 {
    let mean = |values: &[f32]| values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
    let of = |x: &[f32], y: &[f32]| {
        let (mx, my) = (mean(x), mean(y));
        x.iter().zip(y).map(|(&x, &y)| (f64::from(x) - mx) * (f64::from(y) - my)).sum::<f64>()
    };
    of(a, b) / (of(a, a) * of(b, b)).sqrt()
}
