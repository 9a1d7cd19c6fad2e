//! No number of a capture or a data set is without end, or none at all, but where its key allows it: one rule for all.

use serde_json::{Value, json};

use photosite::Capture;
use photosite::capture::DatasetFile;

use super::ranges::{documents, files};
use super::*;

/// Stands for the number that is tried.
const MARK: f64 = 31_415_926.531_25;

/// Pointers to all numbers of a document.
fn numbers(value: &Value, place: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(place.to_owned()),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, item)| numbers(item, &format!("{place}/{i}"), found));
        }
        Value::Object(table) => {
            table.iter().for_each(|(key, value)| numbers(value, &format!("{place}/{key}"), found));
        }
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

/// Documents with another text in place of each of their numbers, and the key of that number.
fn spoilt(beginning: &str) -> Vec<(String, String)> {
    let mut all = Vec::new();
    for (_, document) in documents(beginning) {
        let mut places = Vec::new();
        numbers(&document, "", &mut places);
        for place in places {
            let mut marked = document.clone();
            *marked.pointer_mut(&place).expect("a place of it") = json!(MARK);
            let text = toml::to_string(&marked).expect("TOML");
            let key = place.split('/').rfind(|step| step.parse::<usize>().is_err()).expect("a key").to_owned();
            let tries = ["inf", "-inf", "nan", "1e999"].map(|number| text.replace(&MARK.to_string(), number));
            all.extend(tries.map(|text| (key.clone(), text)));
        }
    }
    all
}

fn refused(key: &str, error: Option<String>) {
    let error = error.unwrap_or_else(|| format!("{key}: is taken"));
    assert!(key == "tone_white" || error.contains("must be finite, got") && error.contains(key), "{key}: {error}");
}

#[test]
fn captures_have_finite_numbers() {
    let files = files();
    let all = spoilt("capture-");
    assert!(all.len() > 1000, "{}", all.len());
    for (key, text) in all {
        refused(&key, Capture::parse(&text, files.0.path(), &[]).err().map(|error| error.to_string()));
    }
}

#[test]
fn data_sets_and_changes_have_finite_numbers() {
    let files = Files::new("");
    let path = files.0.path().join("set.toml");
    for (key, text) in spoilt("set-") {
        fs::write(&path, text).expect("written");
        refused(&key, DatasetFile::read(&path).err().map(|error| error.to_string()));
    }
    let text =
        "[scene]\nenvironment = { illuminance_lux = 1 }\n[camera]\nposition_m = [0, 0, 1]\nlook_at_m = [0, 0, 0]\n";
    for change in ["exposure.time_s=1e999", "lens.f_number=nan", "camera.position_m=[0, -inf, 1]"] {
        let key = change.split('=').next().expect("a key");
        let error = Capture::parse(text, Path::new(""), &[change.to_owned()]).err();
        refused(key, error.map(|error| error.to_string()));
    }
}
