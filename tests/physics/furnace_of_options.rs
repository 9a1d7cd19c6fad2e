//! Materials with options drawn at random from the schema, in an even environment: none gives back more than arrives.

use std::fs;
use std::path::Path;

use photosite::capture::capture_schema;
use photosite::pipeline::Prepared;
use photosite::{Capture, Error, Options};
use serde_json::{Value, json};

use crate::drawn_options::Draw;
use crate::option_pairs::BALL;

const MATERIALS: u64 = 120;

/// Keys by which a material shines, or that are files.
const LEFT_OUT: [&str; 4] = ["emission", "normal_map", "metallic_roughness_map", "double_sided"];

const SCENE: &str = "
[scene]
environment = { illuminant = 'D65', illuminance_lux = 500 }
objects = [{ file = 'ball.obj' }]
[camera]
position_m = [0, 0, 2]
look_at_m = [0, 0, 0]
[lens]
type = 'pinhole'
focal_length_mm = 12
[sensor]
preset = 'sony-imx249-mono'
resolution_px = [12, 12]
pixel_pitch_um = [300, 300]
[exposure]
time_s = 0.01
[render]
samples_per_pixel = 64
max_depth = 12
";

/// The sum of mean electrons of all pixels, and its variance.
fn electrons(values: &Value, folder: &Path) -> Result<[f64; 2], Error> {
    let prepared = Prepared::new(Capture::of_values(values, &folder.join("capture.toml"), &[])?)?;
    let shot = prepared.trace(Options::default())?.frame(0, &[])?;
    let estimate = &shot.electrons;
    Ok([&estimate.mean, &estimate.variance].map(|planes| planes.channels()[0].data.iter().map(|&v| f64::from(v)).sum()))
}

/// A material of one of the types of the schema.
fn material(draw: Draw<'_>, path: &str, without: &[&str]) -> Value {
    let all = draw.schema["$defs"]["TypedMaterialTable"]["oneOf"].as_array().expect("types");
    let is_wanted = |of: &Value| !without.iter().any(|name| of["properties"]["type"]["const"] == *name);
    let mut material = draw.value_of(path, "material", all, is_wanted);
    LEFT_OUT.iter().for_each(|key| drop(material.as_object_mut().expect("a table").remove(*key)));
    material
}

#[test]
fn materials_of_any_options_give_back_no_more_than_arrives() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("ball.obj"), BALL).expect("written");
    let schema = capture_schema();
    let scene = serde_json::to_value(SCENE.parse::<toml::Table>().expect("TOML")).expect("JSON");
    let mut empty = scene.clone();
    empty["scene"]["objects"][0]["visible"] = json!(false);
    let [arrives, _] = electrons(&empty, folder.path()).expect("an empty scene");
    let (mut told, mut taken) = (Vec::new(), 0);
    for seed in 0..MATERIALS {
        let draw = Draw::new(&schema, seed);
        let mut values = scene.clone();
        let drawn = material(draw, "/material", &[]);
        if drawn["type"] == "mix" {
            values["materials"] = json!({ "a": material(draw, "/a", &["mix"]), "b": material(draw, "/b", &["mix"]) });
        }
        values["materials"]["ball"] = drawn;
        let case = format!("{seed}: {}", values["materials"]);
        match electrons(&values, folder.path()) {
            Ok([found, variance]) => {
                taken += 1;
                // 5 σ of the light, and the roundings of sums of single precision.
                let room = 5.0 * variance.sqrt() + 1e-5 * arrives;
                if !found.is_finite() || found > arrives + room {
                    told.push(format!("{case}: {} of what arrives, ± {}", found / arrives, room / arrives));
                }
            }
            Err(error) if error.to_string().contains("materials.") => {}
            Err(error) => told.push(format!("{case}: {error}")),
        }
    }
    assert!(told.is_empty(), "{} of {MATERIALS}, {taken} taken\n{}", told.len(), told.join("\n"));
    assert!(taken > MATERIALS / 4, "{taken} are taken: the test says little");
}
