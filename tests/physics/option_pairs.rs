//! Pairs of options, drawn at random from the schema that the program makes of its keys: either they are refused by the name
//! of one of them, or the image is whole: numbers within the converter's range, light finite, image, truth and camera of one
//! geometry. A new key takes part as soon as it is in the schema.

use std::collections::BTreeSet;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use photosite::calibration::truth::{TruthLayer, TruthObject, View};
use photosite::capture::capture_schema;
use photosite::pipeline::{LensSeen, Prepared, Silent, image_grid};
use photosite::report::ObjectsReport;
use photosite::{Capture, Error, Options};
use serde_json::{Value, json};

use crate::drawn_options::Draw;

const PAIRS: u64 = 400;

/// Tables whose keys are drawn; those of `[scene]`, lamps, targets and materials say what is there.
const TABLES: [&str; 7] = ["camera", "lens", "sensor", "exposure", "render", "develop", "output"];

/// A ball before a wall, seen by 16 × 12 pixels.
const BASE: &str = "
[scene]
environment = { illuminant = 'D65', illuminance_lux = 500 }
[[scene.objects]]
file = 'ball.obj'
name = 'ball'
position_m = [0.1, 0.05, 0]
keypoints = { middle = [0, 0, 0] }
[camera]
position_m = [0, 0, 2]
look_at_m = [0, 0, 0]
[lens]
focal_length_mm = 4
f_number = 4
focus_distance_m = 2
[sensor]
preset = 'PRESET'
resolution_px = [16, 12]
pixel_pitch_um = [200, 200]
[exposure]
time_s = 0.01
[render]
samples_per_pixel = 2
max_depth = 3
[output]
truth = ['depth', 'instance']
";

/// Sensors of the base: an array of colours, one without them, a CCD.
const PRESETS: [&str; 3] = ["generic-cmos-color", "sony-imx249-mono", "textbook-ccd"];

/// An octahedron of 0.3 m about the origin.
pub(crate) const BALL: &str = "v .3 0 0\nv -.3 0 0\nv 0 .3 0\nv 0 -.3 0\nv 0 0 .3\nv 0 0 -.3\nusemtl ball\nf 1 3 5\nf 3 2 5\nf 2 4 5\n\
                    f 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";

/// Puts a value at a place, into tables that are made where they are missing.
fn put(document: &mut Value, path: &str, value: Value) {
    let (table, key) = path.rsplit_once('/').expect("a path");
    let mut at = document;
    for step in table.split('/').skip(1) {
        if !at[step].is_object() {
            at[step] = json!({});
        }
        at = &mut at[step];
    }
    at[key] = value;
}

/// Invariants that an image of these values breaks; an error where they are refused.
fn broken(values: &Value, folder: &Path) -> Result<Option<String>, Error> {
    let capture = Capture::of_values(values, &folder.join("capture.toml"), &[])?;
    let objects = TruthObject::of_scene(capture.scene());
    let prepared = Prepared::new(capture)?;
    let light = prepared.trace(Options::default())?;
    let shot = light.frame(0, &light.settings().output.noise.maps)?;
    let capture = prepared.capture();
    let most = u32::MAX >> (32 - shot.raw.bits);
    if let Some(dn) = shot.raw.data.iter().find(|dn| u32::from(**dn) > most) {
        return Ok(Some(format!("{dn} DN of {} bits", shot.raw.bits)));
    }
    for estimate in [&shot.electrons.mean, &shot.electrons.variance] {
        if let Some(channel) =
            estimate.channels().iter().find(|channel| !channel.data.iter().all(|v| v.is_finite() && *v >= 0.0))
        {
            return Ok(Some(format!("electrons of {} are not finite", channel.name)));
        }
    }
    let camera = prepared.camera();
    let grid = image_grid(capture, &camera);
    let planes = prepared.truth(&[TruthLayer::Depth, TruthLayer::Instance], &Silent)?;
    let of_truth = [planes.width() as u32, planes.height() as u32];
    if of_truth != grid.resolution {
        return Ok(Some(format!("truth has {of_truth:?} pixels, its grid {:?}", grid.resolution)));
    }
    if capture.output().image {
        let image = shot.develop(capture.develop())?;
        let of_image = [image.linear.width() as u32, image.linear.height() as u32];
        // An image that is freed of a distortion has pixels of its own, and a warning tells so.
        let exposure = capture.exposure();
        let seen = LensSeen::new(capture.lens(), &camera, capture.sensor(), &exposure.region, exposure.stages);
        let is_straightened = seen.resampling(capture.develop()).is_some_and(|resampling| resampling.undistorts());
        if of_image != of_truth && !is_straightened {
            return Ok(Some(format!("the image has {of_image:?} pixels, truth {of_truth:?}")));
        }
        if !image.linear.channels().iter().all(|channel| channel.data.iter().all(|v| v.is_finite())) {
            return Ok(Some("the image is not finite".to_owned()));
        }
    }
    let report = ObjectsReport::new(&View::of(prepared.scene(), &camera, grid), &objects);
    let ball = &report.objects[0];
    let parts = ball.visible_part.is_none_or(|part| (0.0..=1.0).contains(&part));
    if !parts || ball.visible.pixels > ball.alone.pixels {
        return Ok(Some("more of the ball is seen than there is".to_owned()));
    }
    // The ball is as large to all sides of its middle, which therefore is in the middle of the pixels that see it, to the
    // half pixel by which either side may end; a lens that bends lines moves that by less than a quarter of the size.
    if let (Some([x, y, width, height]), Some([u, v]), false) =
        (ball.alone.box_px, ball.keypoints[0].px, ball.is_cut_off)
    {
        let [x, y, width, height] = [x, y, width, height].map(f64::from);
        let (dx, dy) = (x + (width - 1.0) / 2.0 - u, y + (height - 1.0) / 2.0 - v);
        if dx.abs() > 1.0 + width / 4.0 || dy.abs() > 1.0 + height / 4.0 {
            return Ok(Some(format!("the ball is seen {dx} × {dy} px from where its middle is")));
        }
    }
    Ok(None)
}

/// An error with what it says how to mend it.
fn said(error: &Error) -> String {
    let input = if let Error::Input(input) = error { Some(input) } else { None };
    let help = input.and_then(|input| input.help.as_ref()).map(ToString::to_string);
    format!("{error}: {}", help.unwrap_or_default())
}

/// Names of all keys in values.
fn keys(value: &Value, into: &mut BTreeSet<String>) {
    match value {
        Value::Object(table) => table.iter().for_each(|(key, value)| {
            into.insert(key.clone());
            keys(value, into);
        }),
        Value::Array(items) => items.iter().for_each(|item| keys(item, into)),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

#[test]
fn pairs_of_options_are_refused_by_name_or_give_a_whole_image() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("ball.obj"), BALL).expect("written");
    let schema = capture_schema();
    let (mut told, mut taken) = (Vec::new(), 0);
    // More of them, by hand.
    let count = std::env::var("PAIRS").map_or(PAIRS, |n| n.parse().expect("a number"));
    for seed in 0..count {
        let draw = Draw::new(&schema, seed);
        let preset = PRESETS[seed as usize % PRESETS.len()];
        let base: toml::Table = BASE.replace("PRESET", preset).parse().expect("TOML");
        let mut values = serde_json::to_value(base).expect("JSON");
        let options = [0, 1].map(|number| draw.option(number, &TABLES));
        for (path, value) in &options {
            put(&mut values, path, value.clone());
        }
        let case =
            || format!("{seed}: {preset}, {} = {}, {} = {}", options[0].0, options[0].1, options[1].0, options[1].1);
        match catch_unwind(AssertUnwindSafe(|| broken(&values, folder.path()))) {
            Ok(Ok(None)) => taken += 1,
            Ok(Ok(Some(what))) => told.push(format!("{}: {what}", case())),
            Ok(Err(error)) => {
                // Either key that was drawn, or the one of the base that it clashes with, at its head.
                let text = said(&error);
                let [mut drawn, mut written] = [const { BTreeSet::new() }; 2];
                for (path, value) in &options {
                    drawn.extend(path.split('/').skip(2).map(str::to_owned));
                    keys(value, &mut drawn);
                }
                TABLES.iter().for_each(|table| keys(&values[table], &mut written));
                let head =
                    text.split(": ").nth(1).and_then(|path| path.rsplit('.').find(|step| step.parse::<u32>().is_err()));
                let is_named = drawn.iter().any(|key| text.contains(key.as_str()));
                if !is_named && !head.is_some_and(|key| written.contains(key)) {
                    told.push(format!("{}: {text}", case()));
                }
            }
            Err(_) => told.push(format!("{}: panics", case())),
        }
    }
    assert!(told.is_empty(), "{} of {count}, {taken} taken\n{}", told.len(), told.join("\n"));
    assert!(taken > count / 4, "{taken} of {count} are taken: the test says little");
}
