//! `photosite compare` as its users call it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use photosite::develop::EncodedImage;
use photosite::image::{Channel, Estimate, Planes};
use photosite::io::developed::write_png;
use photosite::io::electrons::write_electrons;
use photosite::io::exr::{Attribute, write_exr};
use photosite::io::output::write_whole;
use photosite::raw::{Cfa, RawImage, write_dng, write_npy};
use photosite::units::Seconds;
use rstest::rstest;
use serde_json::Value;
use tempfile::TempDir;

const WIDTH: usize = 20;
const HEIGHT: usize = 10;

/// A folder of images to compare.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// `electrons.exr` of channels that hold `value(channel, pixel)` with the variance 4.
    fn electrons(&self, name: &str, channels: &[&str], value: impl Fn(usize, usize) -> f32) -> String {
        let plane = |(index, &name): (usize, &&str)| Channel {
            name: name.to_owned(),
            data: (0..WIDTH * HEIGHT).map(|pixel| value(index, pixel)).collect(),
        };
        let mean = Planes::new(WIDTH, HEIGHT, channels.iter().enumerate().map(plane).collect()).expect("right sizes");
        let mut variance = Planes::zeros(WIDTH, HEIGHT, channels.iter().copied());
        variance.channels_mut().iter_mut().for_each(|c| c.data.fill(4.0));
        let electrons = Estimate { mean, variance };
        write_whole(&self.path(name), |to| write_electrons(&electrons, Seconds(1.0), to)).expect("written");
        name.to_owned()
    }

    /// An EXR file of electrons as other programs write it: means, or whatever else its channels are called.
    fn exr(&self, name: &str, channels: &[(&str, f32)], noise: f32) -> String {
        let plane = |&(name, level): &(&str, f32)| Channel {
            name: name.to_owned(),
            data: (0..WIDTH * HEIGHT).map(|pixel| level + if pixel % 3 == 0 { 2.0 * noise } else { -noise }).collect(),
        };
        let planes = Planes::new(WIDTH, HEIGHT, channels.iter().map(plane).collect()).expect("right sizes");
        let unit = [("unit", Attribute::Text("e-".to_owned()))];
        write_whole(&self.path(name), |to| write_exr(&planes, &unit, to)).expect("written");
        name.to_owned()
    }

    fn png(&self, name: &str, [width, height]: [usize; 2], code: u8) -> String {
        let image = EncodedImage::srgb8(width, height, 3, vec![code; 3 * width * height]);
        write_whole(&self.path(name), |to| write_png(&image, to)).expect("written");
        name.to_owned()
    }

    /// Runs the command in the folder.
    fn compare(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_photosite"));
        command.current_dir(self.0.path()).arg("compare").args(arguments).output().expect("the command starts")
    }

    /// Exit status and standard output; nothing must be on standard error.
    fn said(&self, arguments: &[&str]) -> (i32, String) {
        let output = self.compare(arguments);
        assert_eq!(String::from_utf8_lossy(&output.stderr), "");
        (status(&output), String::from_utf8(output.stdout).expect("UTF-8"))
    }

    fn json(&self, arguments: &[&str]) -> (i32, Value) {
        let (status, text) = self.said(&[arguments, &["--json"]].concat());
        (status, serde_json::from_str(&text).expect("JSON"))
    }

    /// Exit status and standard error in one line; nothing must be on standard output.
    fn complaint(&self, arguments: &[&str]) -> (i32, String) {
        let output = self.compare(arguments);
        assert_eq!(String::from_utf8_lossy(&output.stdout), "");
        let words = String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        (status(&output), words)
    }
}

fn status(output: &Output) -> i32 {
    output.status.code().expect("no signal")
}

fn bytes(path: &Path) -> Vec<u8> {
    fs::read(path).expect("there")
}

/// Two images whose difference has the standard deviation √8 and is +√8 and −√8 by turns.
fn agreeing(folder: &Folder) -> [String; 2] {
    let swing = 8f32.sqrt();
    [
        folder.electrons("a.exr", &["R", "G"], |_, pixel| if pixel % 2 == 0 { 100.0 + swing } else { 100.0 - swing }),
        folder.electrons("b.exr", &["R", "G"], |_, _| 100.0),
    ]
}

#[test]
fn images_that_noise_explains_agree() {
    let folder = Folder::new();
    let [a, b] = agreeing(&folder);
    let (status, text) = folder.said(&[&a, &b]);
    assert_eq!(status, 0);
    assert!(text.contains("a.exr: 20 × 10, R G, e-, with variances"), "{text}");
    assert!(text.trim_end().ends_with("402 tests)") && text.contains("\nagree\n"), "{text}");
    let (status, report) = folder.json(&[&a, &b]);
    assert_eq!((status, &report["outcome"]), (0, &Value::from("agree")));
    let channel = &report["channels"][1];
    assert_eq!((&channel["channel"], &channel["pixels"]), (&Value::from("G"), &Value::from(200)));
    // z is ±1: a spread of √(200/199), but for the rounding of 102.8 to 24 bits, which is 1.4e-6 of √8.
    let spread = channel["z_scores"]["spread"].as_f64().expect("a number");
    assert!((spread - (200f64 / 199.0).sqrt()).abs() < 2e-6, "{spread}");
    assert!((channel["rmse"].as_f64().expect("a number") - 8f64.sqrt()).abs() < 1e-5);
    assert_eq!(report["verdict"]["tests"], 402);
    assert_eq!((&report["resolution_px"], &report["epsilon"]), (&serde_json::json!([20, 10]), &Value::from(0.01)));
    assert_eq!((&report["a"]["file"], &report["a"]["unit"]), (&Value::from("a.exr"), &Value::from("e-")));
}

#[test]
fn one_pixel_that_noise_does_not_explain_makes_images_differ() {
    let folder = Folder::new();
    let a = folder.electrons("a.exr", &["R", "G"], |c, pixel| if (c, pixel) == (1, 47) { 120.0 } else { 100.0 });
    let b = folder.electrons("b.exr", &["R", "G"], |_, _| 100.0);
    let (status, text) = folder.said(&[&a, &b]);
    assert_eq!(status, 1);
    assert!(text.contains("\ndiffer\n  noise does not explain 1 pixel: |z| > 4.2"), "{text}");
    let worst = text.lines().find(|line| line.starts_with("(7, 2)")).expect("the pixel is listed");
    assert_eq!(
        worst.split_whitespace().skip(2).take(5).collect::<Vec<_>>(),
        ["G", "120.000", "100.000", "20.0000", "+7.07"]
    );
    assert_eq!(folder.said(&[&a, &b, "--channels", "R"]).0, 0);
    assert_eq!(folder.said(&[&a, &b, "--alpha", "1e-12"]).0, 0, "7.07 σ happens to one in 6·10¹¹");
    assert_eq!(folder.said(&[&a, &b, "--quiet"]), (1, String::new()));
    let (_, report) = folder.json(&[&a, &b, "--worst", "1"]);
    assert_eq!(report["worst"].as_array().map(Vec::len), Some(1));
    assert_eq!(report["verdict"]["pixels_past_bound"], 1);
    assert_eq!(report["failures"].as_array().map(Vec::len), Some(1));
}

/// Differences of 14 and 7: seven standard deviations of the first image alone, 1.4 of both.
#[test]
fn a_variance_that_only_one_side_has_judges_nothing() {
    let folder = Folder::new();
    let a = folder.electrons("a.exr", &["R", "G"], |_, _| 100.0);
    let b = folder.exr("b.exr", &[("R", 100.0), ("G", 100.0)], 7.0);
    for (files, letter) in [([&a[..], &b], "B"), ([&b, &a], "A")] {
        let (status, text) = folder.said(&files);
        assert!(status == 0 && text.contains(&format!("not judged: the variance of {letter} is unknown")), "{text}");
        assert!(
            !text.contains("z-scores") && text.contains(&format!("--variance-{}", letter.to_lowercase())),
            "{text}"
        );
        let (status, report) = folder.json(&files);
        assert_eq!((status, &report["outcome"], &report["verdict"]), (0, &Value::from("not judged"), &Value::Null));
        assert_eq!(report["untested"][0]["channels"], serde_json::json!(["R", "G"]));
        let known = if letter == "B" { "a" } else { "b" };
        assert_eq!(
            (&report["channels"][0]["variance_of"], &report["channels"][0]["z_scores"]),
            (&Value::from(known), &Value::Null)
        );
    }
    // Limits judge all the same: 67 pixels differ by 14 and 133 by 7, an RMSE of 9.912.
    assert_eq!(folder.said(&[&a, &b, "--max-rmse", "9.95", "--quiet"]).0, 0);
    let (status, text) = folder.said(&[&a, &b, "--max-rmse", "9.85"]);
    assert!(
        status == 1 && text.contains("not tested against noise: R, G, since the variance of B is unknown"),
        "{text}"
    );
    // An exact B differs, one with noise of its own does not.
    assert_eq!(folder.said(&[&a, &b, "--variance-b", "0", "--quiet"]).0, 1);
    assert_eq!(folder.said(&[&a, &b, "--variance-b", "98", "--quiet"]).0, 0);
    let variances = folder.exr("variances.exr", &[("R", 98.0), ("G", 98.0)], 0.0);
    let (status, report) = folder.json(&[&a, &b, "--variance-b", &variances]);
    assert_eq!((status, &report["outcome"]), (0, &Value::from("agree")));
    // A variance of 4 + 98, and differences of a mean square of 98.245 about their mean: √(98.244·200/199/102).
    let spread = report["channels"][0]["z_scores"]["spread"].as_f64().expect("known");
    assert!((spread / (98.244f64 * 200.0 / 199.0 / 102.0).sqrt() - 1.0).abs() < 1e-4, "{spread}");
    // One channel's variance is missing: the other is judged.
    let red = folder.exr("red.exr", &[("variance.R", 98.0)], 0.0);
    let (status, report) = folder.json(&[&a, &b, "--variance-b", &red]);
    assert_eq!(
        (status, &report["outcome"], &report["verdict"]["tests"]),
        (0, &Value::from("agree"), &Value::from(201))
    );
    assert_eq!(report["untested"][0]["channels"], serde_json::json!(["G"]));
    for (arguments, complaint) in [
        (["--variance-b", "-1"], "-1 is not a variance"),
        (["--variance-b", "nowhere.exr"], "cannot read"),
        (["--variance-b", "grey.exr"], "holds no variances for the channels of b.exr"),
        (["--samples-b", "64"], "b.exr holds no second moments"),
        (["--samples-b", "1"], "is not in 2.."),
    ] {
        folder.exr("grey.exr", &[("Y", 1.0)], 0.0);
        let (status, said) = folder.complaint(&[&[&a[..], &b], &arguments[..]].concat());
        assert!((1..=2).contains(&status) && said.contains(complaint), "{arguments:?}: {said}");
    }
}

#[test]
fn second_moments_give_variances() {
    let folder = Folder::new();
    // The mean of 50 samples with the variance 98 has 98/49: m2 = 98 + 100.1².
    let moments = [("nested.Y", 100.1), ("m2_nested.Y", 98.0 + 100.1 * 100.1)];
    let a = folder.exr("a.exr", &moments, 0.0);
    let b = folder.exr(
        "b.exr",
        &[moments[0], moments[1]].map(|(name, x)| (name, x + if name == "nested.Y" { 1.0 } else { 200.0 + 1.0 + 0.2 })),
        0.0,
    );
    let (status, text) = folder.said(&[&a, &b]);
    assert!(status == 0 && text.contains("not judged"), "{text}");
    let (_, report) = folder.json(&[&a, &b, "--samples-a", "50", "--samples-b", "50"]);
    let channel = &report["channels"][0];
    assert_eq!((&channel["channel"], &channel["variance_of"]), (&Value::from("nested.Y"), &Value::from("both")));
    assert_eq!(report["channels"].as_array().map(Vec::len), Some(1));
    // A difference of −1 with the variance 2·98/49 everywhere. m2 is about 10 000 and rounded to 1e-3.
    let z = report["worst"][0]["z"].as_f64().expect("known");
    assert!((z + 0.5).abs() < 1e-4, "{z}");
    let (_, report) = folder.json(&[&a, &b, "--samples-a", "50", "--channels", "nested.Y"]);
    assert!(report["untested"][0]["help"].as_str().expect("help").contains("--samples-b"), "{report}");
}

#[rstest]
#[case::mean_difference("--max-mean-difference", "10.0", "9.9", "mean difference")]
#[case::rmse("--max-rmse", "10.0", "9.9", "RMSE")]
#[case::relative_mse("--max-relative-mse", "0.0100", "0.0098", "relative MSE")]
fn limits_judge_images_without_variances(
    #[case] option: &str,
    #[case] kept: &str,
    #[case] passed: &str,
    #[case] name: &str,
) {
    let folder = Folder::new();
    let (a, b) = (folder.png("a.png", [3, 2], 110), folder.png("b.png", [3, 2], 100));
    let (status, text) = folder.said(&[&a, &b]);
    assert!(status == 0 && text.contains("not judged"), "{text}");
    assert_eq!(folder.json(&[&a, &b]).1["outcome"], "not judged");
    // The relative MSE is 10²/(100² + 0.01·100²) = 0.0099.
    let (status, text) = folder.said(&[&a, &b, option, kept]);
    assert!(status == 0 && text.trim_end().ends_with("agree"), "{text}");
    let (status, text) = folder.said(&[&a, &b, option, passed]);
    assert!(status == 1 && text.contains(&format!("\n  R: {name} ")), "{text}");
}

#[test]
fn a_raw_file_is_compared_with_the_same_numbers_of_another_kind() {
    let folder = Folder::new();
    let raw = RawImage {
        width: 4,
        height: 2,
        data: (0..8).map(|i| 100 + 50 * i).collect(),
        cfa: Cfa::parse("RGGB").expect("known"),
        bits: 12,
        black_level_dn: 64.into(),
        white_level_dn: 4095,
        ..RawImage::default()
    };
    write_whole(&folder.path("a.dng"), |to| write_dng(&raw, to)).expect("written");
    let mut brighter = raw.clone();
    brighter.data[5] += 3;
    write_whole(&folder.path("b.npy"), |to| write_npy(&brighter, to)).expect("written");
    let (status, report) = folder.json(&["a.dng", "b.npy"]);
    assert_eq!(status, 0);
    let rows: Vec<_> = report["channels"]
        .as_array()
        .expect("channels")
        .iter()
        .map(|c| (&c["channel"], &c["pixels"], &c["mae"]))
        .collect();
    let row = |name: &str, pixels: i64, mae: f64| (Value::from(name), Value::from(pixels), Value::from(mae));
    let expected = [row("raw", 8, 3.0 / 8.0), row("R", 2, 0.0), row("G", 4, 0.0), row("B", 2, 1.5)];
    assert_eq!(rows, expected.each_ref().map(|(name, pixels, mae)| (name, pixels, mae)));
    assert_eq!((&report["worst"][0]["x"], &report["worst"][0]["y"]), (&Value::from(1), &Value::from(1)));
    assert_eq!(folder.said(&["a.dng", "a.dng", "--max-rmse", "0"]).0, 0);
}

#[test]
fn the_image_of_differences_is_written_once() {
    let folder = Folder::new();
    let [a, b] = agreeing(&folder);
    let (_, report) = folder.json(&[&a, &b, "--picture", "z.png", "--range", "1"]);
    assert_eq!(report["picture"], serde_json::json!({"file": "z.png", "shows": "z-scores", "range": 1.0}));
    let image = image::load_from_memory(&bytes(&folder.path("z.png"))).expect("a PNG file").into_rgb8();
    assert_eq!(image.dimensions(), (20 + 4 + 20, 10));
    // The ends of the map, blue where a lies below.
    assert_eq!([image[(0, 0)].0, image[(25, 0)].0], [[103, 0, 31], [5, 48, 97]]);
    let (status, complaint) = folder.complaint(&[&a, &b, "--picture", "z.png"]);
    assert!(status == 2 && complaint.contains("--force"), "{complaint}");
    assert_eq!(folder.said(&[&a, &b, "--picture", "z.png", "--force"]).0, 0);
    let (status, complaint) = folder.complaint(&[&a, &b, "--picture", "z.exr"]);
    assert!(status == 2 && complaint.contains("ends with .png"), "{complaint}");
}

#[test]
fn numbers_that_are_none_make_images_differ_and_keep_json_whole() {
    let folder = Folder::new();
    let a = folder.electrons("a.exr", &["Y"], |_, pixel| if pixel == 3 { f32::NAN } else { 0.0 });
    let output = folder.compare(&[&a, &a, "--json"]);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(told, "warning: a.exr: 1 number is not finite: it is NaN, of Y in column 3, row 0\n");
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!((status(&output), &report["outcome"]), (1, &Value::from("differ")));
    let channel = &report["channels"][0];
    assert_eq!((&channel["non_finite"], &channel["psnr_db"]), (&Value::from(1), &Value::Null));
    assert_eq!((&report["worst"][0]["x"], &report["worst"][0]["a"]), (&Value::from(3), &Value::Null));
    let text = folder.compare(&[&a, &a]).stdout;
    assert!(String::from_utf8_lossy(&text).contains("Y: 1 of 200 pixels are not finite"));
}

#[test]
fn images_that_do_not_fit_together_are_wrong_usage() {
    let folder = Folder::new();
    let colour = folder.electrons("colour.exr", &["R", "G", "B"], |_, _| 1.0);
    let other = folder.electrons("other.exr", &["R", "G"], |_, _| 1.0);
    let grey = folder.electrons("grey.exr", &["Y"], |_, _| 1.0);
    let small = folder.png("small.png", [2, 2], 0);
    let wide = folder.png("wide.png", [20, 10], 0);
    fs::write(folder.path("picture.docx"), "PK").expect("written");
    for (arguments, complaint) in [
        (vec![&colour[..], &small], "colour.exr has 20 × 10 pixels, small.png has 2 × 2"),
        (vec![&colour, &wide], "colour.exr holds e-, wide.png holds codes up to 255"),
        (vec![&colour, &grey], "have no channel in common"),
        (vec![&colour, &other], "other.exr lacks B, which the other has"),
        (vec![&colour, &other, "--channels", "R,B"], "other.exr has no channel \"B\""),
        (vec![&colour, &other, "--channels", "R,g"], "there is no channel \"g\""),
        (vec![&colour, &colour, "--alpha", "1"], "between 0 and 1"),
        (vec![&colour, &colour, "--max-rmse", "nan"], "of at least 0"),
        (vec![&colour, &colour, "--range", "1"], "--picture"),
        (vec![&colour, "picture.docx"], "picture.docx is not an image of a kind that photosite knows"),
        (vec![&colour], "<B>"),
    ] {
        let (status, said) = folder.complaint(&arguments);
        assert!(status == 2 && said.contains(complaint), "{arguments:?}: {said}");
    }
    assert_eq!(folder.said(&[&colour, &other, "--channels", "R,G"]).0, 0);
}

#[test]
fn broken_files_are_errors_that_name_the_file() {
    let folder = Folder::new();
    let whole = folder.electrons("whole.exr", &["Y"], |_, _| 1.0);
    let png = folder.png("whole.png", [5, 5], 9);
    fs::write(folder.path("torn.exr"), &bytes(&folder.path(&whole))[..300]).expect("written");
    fs::write(folder.path("torn.png"), &bytes(&folder.path(&png))[..40]).expect("written");
    for extension in ["dng", "tiff", "pgm", "npy", "exr", "png"] {
        fs::write(folder.path(&format!("empty.{extension}")), b"").expect("written");
        let (status, said) = folder.complaint(&[&whole, &format!("empty.{extension}")]);
        assert!(status == 1 && said.contains(&format!("empty.{extension}: ")), "{said}");
    }
    for (file, complaint) in [("torn.exr", "torn.exr: "), ("torn.png", "torn.png: "), ("missing.exr", "cannot read")] {
        let (status, said) = folder.complaint(&[file, &whole]);
        assert!(status == 1 && said.contains(complaint), "{said}");
    }
}
