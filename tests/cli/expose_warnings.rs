//! Warnings of a render that its light bears with it: `expose` gives them again.

use rstest::rstest;
use serde_json::Value;

use crate::dataset::BOARD;
use crate::folder::Folder;
use crate::room::room;

/// Warnings that the user got, in any order.
fn said(report: &Value) -> Vec<String> {
    let list = report["warnings"].as_array().expect("a list");
    let mut said: Vec<String> = list.iter().map(|text| text.as_str().expect("a text").to_owned()).collect();
    said.sort_unstable();
    said
}

/// Light that nothing is changed of gets every warning again, on standard error and in the report, and once more from
/// what that wrote.
fn is_said_again(folder: &Folder, capture: &str, set: &str, words: &str) {
    let rendered = folder.succeed(&format!("render {capture} -o out {set}"));
    let told = said(&folder.report("out"));
    assert_eq!(told.iter().filter(|warning| warning.contains(words)).count(), 1, "{words}: {told:#?}");
    assert!(rendered.text().contains(words), "{}", rendered.stderr);
    for (from, to) in [("out", "again"), ("again", "third")] {
        let exposed = folder.succeed(&format!("expose {from} -o {to}"));
        assert_eq!(said(&folder.report(to)), told, "{words} {to}");
        assert_eq!(exposed.text().matches(words).count(), 1, "{}", exposed.stderr);
    }
}

#[rstest]
#[case::glass_before_a_lamp("", "caustics of lights without a surface")]
#[case::rough_metal("--set materials.gold.roughness=0.9", "the microfacets of the material \"gold\" lose")]
#[case::idle_key_of_a_lens(
    "--set lens.blades=0 --set lens.blade_rotation_deg=3",
    "lens.blade_rotation_deg has no effect"
)]
#[case::autofocus_on_nothing(
    "--set lens.autofocus_px=[1,1] --set camera.look_at_m=[0.2,9,3.2] --set camera.up=[1,0,0]",
    "autofocus"
)]
#[case::light_paths_from_nowhere(
    "--set render.light_paths=1 --set materials.lamp={type=\"diffuse\",reflectance=0.5}",
    "render.light_paths: no surface shines"
)]
#[case::wavelengths_of_no_filter(
    "--set render.wavelengths=own-filter --set sensor.preset=sony-imx249-mono",
    "render.wavelengths: all pixels see the same"
)]
#[case::full_well("--set sensor.charge.full_well_e=1000000", "sensor.charge.full_well_e: 1000000 e⁻ are never reached")]
#[case::short_counter("--set sensor.preset=swissspad2 --set sensor.adc.bits=1", "sensor.adc.bits: 1 bits count")]
#[case::larger_pixels("--set sensor.scaled_to_px=[8,6]", "sensor.scaled_to_px: pixels")]
#[case::counting_pixels(
    "--set sensor.preset=swissspad2 --set sensor.scaled_to_px=[8,6]",
    "sensor.scaled_to_px: each pixel"
)]
fn warnings_of_a_scene_are_said_again(#[case] set: &str, #[case] words: &str) {
    let folder = room("[render]\nsamples_per_pixel = 1\n[output]\nraw = ['npy']\n");
    is_said_again(&folder, "capture.toml", set, words);
}

#[rstest]
#[case::points_beside_the_image(
    "lens.focal_length_mm=6",
    "type = 'pinhole'",
    "type = 'pinhole'\ndistortion = { model = 'brown-conrady', k = [-0.1, 0, 0], p = [0, 0] }",
    "the points of targets in capture.json are not"
)]
#[case::darkness(
    "exposure.time_s=1",
    "environment = { illuminant = 'D65', illuminance_lux = 500 }",
    "",
    "nothing in the scene emits light"
)]
#[case::bare_sensor(
    "lights=[{type=\"point\",position_m=[0,1,1],intensity_cd=9}]",
    "type = 'pinhole'\nf_number = 4\nfocal_length_mm = 6\nfocus_distance_m = 'infinity'",
    "type = 'none'",
    "a bare sensor sees what they shine on"
)]
fn warnings_of_a_target_are_said_again(
    #[case] set: &str,
    #[case] line: &str,
    #[case] other: &str,
    #[case] words: &str,
) {
    let capture = BOARD.replace("electrons = false", "electrons = true");
    assert!(capture.contains(line));
    let folder = Folder::new([("board.toml", capture.replace(line, other).into())]);
    is_said_again(&folder, "board.toml", &format!("--set {set}"), words);
}

/// Warnings about a sensor are not said of another one; those about the scene stay.
#[test]
fn warnings_of_a_sensor_go_with_it() {
    let folder = room("[render]\nsamples_per_pixel = 1\n[output]\nraw = ['npy']\n");
    folder.succeed("render capture.toml -o out --set sensor.scaled_to_px=[8,6]");
    let told = folder.succeed("expose out -o other --set sensor.charge.full_well_e=20000").text();
    assert!(told.contains("caustics") && !told.contains("sensor.scaled_to_px"), "{told}");
}
