//! `photosite measure mtf`: the edges of a chart that photosite renders, in pixels and in mm, with their noise.

use std::f64::consts::PI;
use std::fs;

use serde_json::Value;

use crate::folder::Folder;

/// The dark square of the target, 100 mm, seen by a pinhole at f/d = 10 mm/m with pixels of 10 µm: 100 px.
const CHART: &str = "\
[scene]
environment = { illuminant = 'D65', illuminance_lux = 1000 }
[[targets]]
type = 'slanted-edge'
square_mm = 100.0
angle_deg = 5.0
[camera]
position_m = [0, 0, 1]
look_at_m = [0, 0, 0]
[lens]
type = 'pinhole'
f_number = 8
focal_length_mm = 10
focus_distance_m = 'infinity'
falloff = 'none'
[sensor]
preset = 'sony-imx249-mono'
resolution_px = [180, 170]
pixel_pitch_um = [10, 10]
charge = { full_well_e = 1e6 }
[exposure]
auto = true
stages = ['full-well']
[render]
samples_per_pixel = 256
max_depth = 2
";

fn folder() -> Folder {
    Folder::new([("chart.toml", CHART.into())])
}

fn edges(folder: &Folder, arguments: &str) -> Vec<Value> {
    serde_json::from_value(folder.succeed(arguments).json()).expect("a list")
}

fn number(edge: &Value, key: &str) -> f64 {
    edge[key].as_f64().unwrap_or_else(|| panic!("{key}: {edge}"))
}

#[test]
fn all_edges_of_a_chart_have_the_transfer_function_of_a_pixel_in_both_units() {
    let folder = folder();
    folder.succeed("render chart.toml -o out --quiet");
    // A raw file says the pitch itself, the image by the report beside it.
    for file in ["out/raw.dng", "out/image.png"] {
        let found = edges(&folder, &format!("measure mtf {file} --all --json"));
        assert_eq!(found.len(), 4, "{file}: {found:?}");
        for edge in &found {
            let angle = number(edge, "angle_deg").to_radians();
            assert!((angle.to_degrees().abs() - 5.0).abs() < 0.1, "{edge}");
            let mtf: Vec<f64> = serde_json::from_value(edge["mtf"].clone()).expect("numbers");
            let errors: Vec<f64> = serde_json::from_value(edge["standard_error"].clone()).expect("numbers");
            let sinc = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
            for i in [10, 25, 40] {
                let f = i as f64 / 100.0;
                // A pixel of 100 % and a pinhole alone: 65 lines of the region lie about 0.015 px apart, half as far again
                // as those of the test of edges, whose bound is 0.01.
                let expected = sinc(f * angle.cos()) * sinc(f * angle.sin());
                let bound = 0.015 + 4.0 * errors[i];
                assert!((mtf[i] - expected).abs() < bound, "{file} at {f}: {} for {expected}, {}", mtf[i], errors[i]);
            }
            for key in ["mtf50", "mtf10"] {
                if let Some(per_px) = edge[format!("{key}_cy_per_px")].as_f64() {
                    let per_mm = number(edge, &format!("{key}_cy_per_mm"));
                    assert!((per_mm - 100.0 * per_px).abs() < 1e-6 * per_mm, "{key}: {edge}");
                }
            }
            assert!((number(edge, "nyquist_cy_per_mm") - 50.0).abs() < 1e-6, "{edge}");
        }
    }
    let text = folder.succeed("measure mtf out/raw.dng --all").stdout;
    assert!(text.contains("lp/mm") && text.lines().count() == 5, "{text}");
    // What is stated comes before what files say; without either there are no figures in mm, and a way to have them.
    let found = edges(&folder, "measure mtf out/raw.dng --all --json --pitch-um 5,5");
    assert!((number(&found[0], "nyquist_cy_per_mm") - 100.0).abs() < 1e-6);
    fs::copy(folder.path("out/image.png"), folder.path("alone.png")).expect("copied");
    let found = edges(&folder, "measure mtf alone.png --all --json");
    assert!(found.len() == 4 && found[0]["nyquist_cy_per_mm"].is_null() && found[0]["pixel_pitch_um"].is_null());
    assert!(folder.succeed("measure mtf alone.png --all").stdout.contains("--pitch-um"));
}

#[test]
fn plots_are_written_and_asked_for_again() {
    let folder = folder();
    folder.succeed("render chart.toml -o out --quiet");
    folder.succeed("measure mtf out/raw.dng --all --json --plot mtf.svg");
    folder.succeed("measure mtf out/raw.dng --all --json --plot mtf.png");
    let svg = folder.text("mtf.svg");
    assert!(svg.contains("<svg") && svg.contains("cycles per mm") && svg.contains("edges along rows"), "{svg:.300}");
    assert!(folder.bytes("mtf.png").starts_with(b"\x89PNG"));
    folder.fail("measure mtf out/raw.dng --all --plot mtf.svg", 2, &["mtf.svg already exists", "--force"]);
    folder.fail("measure mtf out/raw.dng --all --plot mtf.pdf", 2, &["mtf.pdf", ".svg or a .png"]);
    folder.succeed("measure mtf out/raw.dng --all --json --plot mtf.svg --force");
}

#[test]
fn noise_that_makes_the_curve_ragged_is_said() {
    let folder = folder();
    folder.succeed("render chart.toml -o clean --quiet");
    let quiet = folder.succeed("measure mtf clean/raw.dng --all --json");
    assert!(!quiet.stderr.contains("standard error"), "{}", quiet.stderr);
    folder.succeed("render chart.toml -o noisy --quiet --set exposure.auto=false --set exposure.time_s=0.0005 --set exposure.stages=[\"shot-noise\",\"read-noise\"]");
    let noisy = folder.succeed("measure mtf noisy/raw.dng --all --json");
    assert!(noisy.text().contains("noise of the pixels leaves a standard error of 0."), "{}", noisy.stderr);
}

#[test]
fn wrong_usage_is_told() {
    let folder = folder();
    folder.succeed("render chart.toml -o out --quiet");
    for (arguments, words) in [
        ("--pitch-um 0", "must be above 0"),
        ("--pitch-um nan", "must be above 0 and finite"),
        ("--pitch-um 1,2,3", "3 numbers instead of 1 or 2"),
        ("--all --region 0,0,20,20", "cannot be used with"),
        ("--region 0,0,20,20", "edge"),
    ] {
        folder.fail(&format!("measure mtf out/raw.dng {arguments}"), 2, &[words]);
    }
    folder.succeed("render chart.toml -o flat --quiet --set targets=[] --spp 2");
    folder.fail("measure mtf flat/raw.dng --all", 2, &["no slanted edge is found", "--region"]);
}
