//! Captures made of bytes: the schema says which keys there are and what they take, the bytes say the rest.

use std::sync::OnceLock;

use arbitrary::{Arbitrary, Result, Unstructured};
use photosite::sensor::RegionOfInterest;
use photosite::{Capture, Options};
use serde_json::Value as Schema;
use toml::{Table, Value};

use crate::files;

/// Tables in tables, at most: materials are made of materials.
const DEEPEST: usize = 8;

/// Names of files, materials, spectra, sensors, filters, and what is none of them.
const WORDS: [&str; 40] = [
    "white",
    "lamp",
    "quad.obj",
    "triangle.gltf",
    "curve.csv",
    "kernel.csv",
    "lamp.ies",
    "sky.hdr",
    "pixels.png",
    "sensor.toml",
    "D65",
    "A",
    "cornell/red",
    "cornell/light",
    "BK7",
    "Au",
    "generic-cmos-color",
    "generic-line-scan",
    "generic-three-chip-ccd",
    "generic-stacked-color",
    "automotive-hdr-color",
    "swissspad2",
    "none",
    "scene",
    "infinity",
    "eye",
    "R",
    "G",
    "W",
    "RGGB",
    "x-trans",
    "mono",
    "quad-bayer",
    "full:RGB",
    "noise.read_e",
    "filter",
    "2026-06-21T12:00:00Z",
    "1/2",
    "",
    "é\"\n",
];

const NUMBERS: [f64; 16] =
    [0.0, 1.0, 0.5, 2.0, 10.0, 100.0, 0.1, 0.001, 550.0, -1.0, 1e-9, 1e9, 1e300, 5e-324, f64::NAN, f64::INFINITY];

fn schema() -> &'static Schema {
    static SCHEMA: OnceLock<Schema> = OnceLock::new();
    SCHEMA.get_or_init(|| serde_json::from_str(include_str!("../../assets/capture.schema.json")).expect("a schema"))
}

/// The keys of a capture.
#[derive(Debug)]
pub(crate) struct Captures(Table);

impl Captures {
    /// Captures of any bytes; `None` where there are too few.
    pub(crate) fn of(data: &[u8]) -> Option<Self> {
        Self::arbitrary_take_rest(Unstructured::new(data)).ok()
    }

    /// As a file has them.
    pub(crate) fn text(&self) -> String {
        self.0.to_string()
    }
}

impl<'a> Arbitrary<'a> for Captures {
    fn arbitrary(bytes: &mut Unstructured<'a>) -> Result<Self> {
        Ok(Self(table(schema(), bytes, 0)?))
    }
}

fn one<'s>(all: &'s [Schema], bytes: &mut Unstructured<'_>) -> Result<&'s Schema> {
    bytes.choose(all)
}

fn value(schema: &Schema, bytes: &mut Unstructured<'_>, depth: usize) -> Result<Value> {
    if let Some(name) = schema["$ref"].as_str() {
        let pointer = name.strip_prefix('#').unwrap_or_default();
        let target = self::schema().pointer(pointer).expect("a schema that refers to what it has");
        return value(target, bytes, depth);
    }
    if let Some(text) = schema["const"].as_str() {
        return Ok(text.into());
    }
    if let Some(all) = schema["oneOf"].as_array().or(schema["anyOf"].as_array()) {
        return value(one(all, bytes)?, bytes, depth);
    }
    Ok(match schema["type"].as_str().unwrap_or_default() {
        "object" => table(schema, bytes, depth)?.into(),
        "array" => {
            let least = schema["minItems"].as_u64().unwrap_or(0);
            let most = schema["maxItems"].as_u64().unwrap_or(least + 3).min(16);
            let count = bytes.int_in_range(least..=most.max(least))?;
            (0..count).map(|_| value(&schema["items"], bytes, depth + 1)).collect::<Result<Vec<_>>>()?.into()
        }
        "number" => match bytes.int_in_range(0..=7u8)? {
            0..=3 => NUMBERS[usize::from(bytes.arbitrary::<u8>()?) % NUMBERS.len()],
            4 | 5 => f64::from(bytes.arbitrary::<i16>()?) / 64.0,
            6 => f64::from(bytes.arbitrary::<u8>()?),
            _ => bytes.arbitrary()?,
        }
        .into(),
        "integer" => match bytes.int_in_range(0..=7u8)? {
            0..=5 => i64::from(bytes.arbitrary::<u8>()? % 17),
            6 => i64::from(bytes.arbitrary::<u16>()?),
            _ => bytes.arbitrary()?,
        }
        .into(),
        "boolean" => bytes.arbitrary::<bool>()?.into(),
        _ => (*bytes.choose(&WORDS)?).into(),
    })
}

/// All keys that must be there, and some others.
fn table(schema: &Schema, bytes: &mut Unstructured<'_>, depth: usize) -> Result<Table> {
    let mut table = Table::new();
    let required = schema["required"].as_array().map_or(&[][..], Vec::as_slice);
    for (key, of) in schema["properties"].as_object().into_iter().flatten() {
        let is_required = required.iter().any(|name| name == key);
        // Sections are there more often than keys are.
        if is_required || depth < DEEPEST && bytes.ratio(1, if depth == 0 { 2 } else { 6 })? {
            table.insert(key.clone(), value(of, bytes, depth + 1)?);
        }
    }
    if schema["additionalProperties"].is_object() && depth < DEEPEST {
        for _ in 0..bytes.int_in_range(0..=2)? {
            table
                .insert((*bytes.choose(&WORDS)?).to_owned(), value(&schema["additionalProperties"], bytes, depth + 1)?);
        }
    }
    Ok(table)
}

/// Lays the values of one table over those of another.
fn lay_over(below: &mut Table, above: &Table) {
    for (key, value) in above {
        match (below.get_mut(key), value) {
            (Some(Value::Table(below)), Value::Table(above)) => lay_over(below, above),
            (_, value) => drop(below.insert(key.clone(), value.clone())),
        }
    }
}

/// Lays a capture over that of `files/capture.toml`, and renders what can be read: 8 × 8 pixels, one sample each, developed to 9 × 7. A raw
/// image that comes out is whole.
pub(crate) fn render(capture: &Captures) {
    let mut table: Table = include_str!("../files/capture.toml").parse().expect("a table");
    lay_over(&mut table, &capture.0);
    let small = ["sensor.resolution_px=[8, 8]", "develop.resize_px=[9, 7]", "render.samples_per_pixel=1"];
    let small = small.map(str::to_owned);
    let Ok(capture) = Capture::parse(&table.to_string(), files(), &small) else { return };
    if let Ok(shot) = photosite::render(&capture, Options::default()) {
        shot.raw.validate().expect("whole");
        if capture.exposure().region == RegionOfInterest::WHOLE {
            let area = shot.raw.active_area;
            let size = area.map_or([shot.raw.width, shot.raw.height], |area| [area.width, area.height]);
            assert_eq!(size, capture.sensor().resolution);
        }
    }
}
