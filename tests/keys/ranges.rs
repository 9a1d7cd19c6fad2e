//! The ranges that the JSON Schemas state are those that the code checks: at each bound of every number a value is taken,
//! and just outside it is refused by the name of its key.
//!
//! The documents in `documents`, which use all keys with a range, are walked together with the schema. Each of their numbers
//! is replaced by others, one at a time, and the document is read again.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};

use photosite::capture::{DatasetFile, capture_schema, dataset_schema, noise_schema};
use photosite::dataset::DataSet;
use photosite::pipeline::{FilmMemory, Silent};
use photosite::{Capture, Sandbox};

use super::*;

/// A bound of a number: itself where it belongs to the range, and a number that does not.
struct Bound {
    keyword: &'static str,
    inside: Option<f64>,
    outside: f64,
}

/// The bounds of a schema of a number. What is just beyond them is so by a thousandth, of whole numbers by 1. That whole
/// numbers are not negative is left to the reader.
fn bounds(schema: &Value) -> Vec<Bound> {
    let is_whole = schema["type"] == "integer";
    let step = |bound: f64| match is_whole {
        true => 1.0,
        false => 1e-3 * if bound == 0.0 { 1.0 } else { bound.abs() },
    };
    let bound = |keyword: &'static str| {
        let bound = schema.get(keyword)?.as_f64()?;
        let upwards = if keyword.ends_with("inimum") { 1.0 } else { -1.0 };
        let (inside, outside) = match keyword.starts_with("exclusive") {
            true => (None, bound),
            false => (Some(bound), bound - upwards * step(bound)),
        };
        (!is_whole || outside >= 0.0).then_some(Bound { keyword, inside, outside })
    };
    ["minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum"].into_iter().filter_map(bound).collect()
}

/// A value with another number at a place.
fn changed(document: &Value, place: &str, number: f64, is_whole: bool) -> Value {
    let mut document = document.clone();
    *document.pointer_mut(place).expect("a place of it") = if is_whole { json!(number as i64) } else { json!(number) };
    document
}

/// All schemas of numbers with bounds, by where they stand in the schema of a file.
fn ranged<'a>(schema: &'a Value, path: &str, found: &mut BTreeMap<String, &'a Value>) {
    if !bounds(schema).is_empty() && ["number", "integer"].iter().any(|kind| schema["type"] == **kind) {
        found.insert(path.to_owned(), schema);
    }
    match schema {
        Value::Object(object) => object.iter().for_each(|(key, part)| ranged(part, &format!("{path}/{key}"), found)),
        Value::Array(parts) => {
            parts.iter().enumerate().for_each(|(i, part)| ranged(part, &format!("{path}/{i}"), found));
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

/// A schema with a document that it describes, walked together.
struct Walk<'a> {
    schema: &'a Value,
    /// Places of numbers in the document, with those of what describes them in the schema.
    found: Vec<(String, String)>,
}

impl Walk<'_> {
    fn at(&mut self, of: &str, document: &Value, place: &str) {
        let schema = self.schema.pointer(of).expect("a part of the schema");
        if let Some(definition) = schema.get("$ref").and_then(Value::as_str) {
            return self.at(definition.trim_start_matches('#'), document, place);
        }
        for alternatives in ["oneOf", "anyOf"] {
            let count = schema.get(alternatives).and_then(Value::as_array).map_or(0, Vec::len);
            for i in 0..count {
                let of = format!("{of}/{alternatives}/{i}");
                if self.describes(&of, document) {
                    self.at(&of, document, place);
                }
            }
        }
        match document {
            Value::Number(_) => self.found.push((place.to_owned(), of.to_owned())),
            Value::Array(items) if schema.get("items").is_some() => {
                for (i, item) in items.iter().enumerate() {
                    self.at(&format!("{of}/items"), item, &format!("{place}/{i}"));
                }
            }
            Value::Object(table) => {
                for (key, value) in table {
                    let place = format!("{place}/{key}");
                    if schema.pointer(&format!("/properties/{key}")).is_some() {
                        self.at(&format!("{of}/properties/{key}"), value, &place);
                    } else if schema.get("additionalProperties").is_some_and(Value::is_object) {
                        self.at(&format!("{of}/additionalProperties"), value, &place);
                    }
                }
            }
            Value::Array(_) | Value::Null | Value::Bool(_) | Value::String(_) => {}
        }
    }

    /// Whether one of several alternatives is that of a value: by its kind, and by the keys of a table.
    fn describes(&self, of: &str, value: &Value) -> bool {
        let schema = self.schema.pointer(of).expect("a part of the schema");
        if let Some(definition) = schema.get("$ref").and_then(Value::as_str) {
            return self.describes(definition.trim_start_matches('#'), value);
        }
        if let Some(alternatives) = schema.get("oneOf").or(schema.get("anyOf")).and_then(Value::as_array) {
            let keyword = if schema.get("oneOf").is_some() { "oneOf" } else { "anyOf" };
            return (0..alternatives.len()).any(|i| self.describes(&format!("{of}/{keyword}/{i}"), value));
        }
        match value {
            Value::Object(table) => schema.get("properties").and_then(Value::as_object).is_some_and(|properties| {
                let kind = properties.get("type").and_then(|kind| kind.get("const"));
                table.keys().all(|key| properties.contains_key(key)) && (kind.is_none() || kind == table.get("type"))
            }),
            Value::Number(_) => schema["type"] == "number" || schema["type"] == "integer",
            Value::Array(_) => schema["type"] == "array",
            Value::Bool(_) => schema["type"] == "boolean",
            Value::String(_) | Value::Null => false,
        }
    }
}

/// Tries the bounds of all numbers with a range. `read` reads a document; `exceptions` are bounds that another key moves.
fn check(
    schema: &Value,
    documents: &[(String, Value)],
    read: &dyn Fn(&Value) -> std::result::Result<(), String>,
    exceptions: &[&str],
) {
    let mut all = BTreeMap::new();
    ranged(schema, "", &mut all);
    let (mut seen, mut taken, mut told) = (BTreeSet::new(), BTreeMap::new(), Vec::new());
    for (name, document) in documents {
        told.extend(read(document).err().map(|error| format!("{name}: {error}")));
        let mut walk = Walk { schema, found: Vec::new() };
        walk.at("", document, "");
        for (place, of) in walk.found {
            let Some(number) = all.get(&of) else { continue };
            seen.insert(of.clone());
            let key = place.split('/').rfind(|step| step.parse::<usize>().is_err()).expect("a key");
            let is_whole = number["type"] == "integer";
            for Bound { keyword, inside, outside } in bounds(number) {
                let at = format!("{name}{place}");
                match read(&changed(document, &place, outside, is_whole)) {
                    Ok(()) => told.push(format!("{at}: {outside} is taken, beyond the {keyword}")),
                    Err(error) if !error.contains(key) => told.push(format!("{at}: {outside}: {error}")),
                    Err(_) => {}
                }
                let Some(inside) = inside else { continue };
                // What other elements of a list or other keys say may be in the way in one place.
                let refused = read(&changed(document, &place, inside, is_whole)).err();
                let before = taken.entry(format!("{of} {keyword}")).or_insert_with(|| refused.clone());
                *before = before.take().and(refused.map(|error| format!("{inside} at {at}: {error}")));
            }
        }
    }
    let refused = taken.iter().filter_map(|(bound, error)| Some(format!("{bound}: {}", error.as_ref()?)));
    told.extend(refused.filter(|text| !exceptions.iter().any(|exception| text.contains(exception))));
    told.extend(all.keys().filter(|of| !seen.contains(*of)).map(|of| format!("{of} is in no document")));
    assert!(told.is_empty(), "{}", told.join("\n"));
}

/// The documents in `documents` whose names begin so.
pub(crate) fn documents(beginning: &str) -> Vec<(String, Value)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/keys/documents");
    let mut paths: Vec<_> = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("read").path()).collect();
    paths.sort();
    let names = paths.iter().map(|path| (path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), path));
    names
        .filter(|(name, _)| name.starts_with(beginning))
        .map(|(name, path)| {
            let table: toml::Table = fs::read_to_string(path).expect("read").parse().expect(&name);
            (name, serde_json::to_value(table).expect("JSON"))
        })
        .collect()
}

/// Files that the documents refer to.
pub(crate) fn files() -> Files {
    let files = Files::new("");
    files.add("painted.obj", b"mtllib painted.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl paint\nf 1 2 3\n");
    files.add("painted.mtl", b"newmtl paint\nKd 0.5 0.5 0.5\nPr 0.5\nPm 0.5\n");
    files.add("psf.csv", b"0,1,0\n1,2,1\n0,1,0\n");
    files.add("lamp.ies", b"IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 100\n0 45 90\n0\n100 70 0\n");
    image::Rgb32FImage::from_pixel(4, 2, image::Rgb([1.0, 1.0, 1.0]))
        .save(files.0.path().join("sky.hdr"))
        .expect("written");
    image::RgbImage::from_pixel(4, 2, image::Rgb([200, 200, 200]))
        .save(files.0.path().join("slide.png"))
        .expect("written");
    files
}

#[test]
fn captures_take_what_their_schema_allows_and_nothing_beyond() {
    let files = files();
    let path = files.0.path().join("capture.toml");
    let read = |document: &Value| Capture::of_values(document, &path, &[]).map(drop).map_err(|e| e.to_string());
    // The marker of a board and the dots of a chart are smaller than what they stand in, and last steps darker than first.
    let narrower = [
        "TargetTable/oneOf/1/properties/square_mm minimum",
        "TargetTable/oneOf/4/properties/spacing_mm minimum",
        "TargetTable/oneOf/6/properties/spacing_mm minimum",
        "TargetTable/oneOf/8/properties/spacing_mm minimum",
        "TargetTable/oneOf/8/properties/square_mm maximum",
        "TargetTable/oneOf/11/properties/first_density maximum",
    ];
    check(&capture_schema(), &documents("capture-"), &read, &narrower);
}

#[test]
fn noise_takes_what_its_schema_allows_and_nothing_beyond() {
    let read = |document: &Value| {
        let noise: photosite::synthetic_noise::SyntheticNoise =
            serde_json::from_value(document.clone()).map_err(|e| e.to_string())?;
        noise.validate().map_err(|invalid| format!("{}: {}", invalid.key, invalid.message))
    };
    check(&noise_schema(), &documents("noise"), &read, &[]);
}

#[test]
fn data_sets_take_what_their_schema_allows_and_nothing_beyond() {
    let files = files();
    files.add(
        "board.toml",
        b"[[targets]]\ntype = 'chessboard'\nname = 'board'\nsquare_mm = 5\n[camera]\nposition_m = [0, 0, 1]\nlook_at_m = [0, 0, 0]\n",
    );
    files.add(
        "table.toml",
        room(
            "[camera]\nposition_m = [0, 1, 9]\nlook_at_m = [0, 0, 0]\n\
             [[lights]]\nname = 'lamp'\ntype = 'point'\nposition_m = [0, 2, 0]\nintensity_cd = 9\n",
        )
        .as_bytes(),
    );
    files.add("cube.obj", CUBE.as_bytes());
    let path = files.0.path().join("set.toml");
    let read = |document: &Value| {
        fs::write(&path, toml::to_string(document).expect("TOML")).expect("written");
        let set = || {
            let file = DatasetFile::read(&path)?;
            let set = DataSet::new(&Sandbox::default(), file, &[], FilmMemory::default())?;
            let frames = set.frames(0..1, false, &Silent)?;
            set.check_first(&frames)
        };
        set().map_err(|error: photosite::Error| error.to_string())
    };
    check(&dataset_schema(), &documents("set-"), &read, &[]);
}

/// A cube of 1 m.
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
