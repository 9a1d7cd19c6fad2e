//! Matches of the patterns of a `[[vary]]`: keys of the capture, names of its materials, files beside the data set.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;

use super::file_pattern::files_of;
use photosite_calibration::dataset::{Found, VariationDescription};
use photosite_capture::{Capture, DatasetFile};
use photosite_core::key_path::{is_pattern, keys, matches, path};
use photosite_core::suggest::list;
use photosite_core::{Invalid, Result, Sandbox};

/// Matches of each variation of a data set. Files are relative to the folder of the capture, as its own are.
pub(super) fn find(file: &DatasetFile, sandbox: &Sandbox, capture: &Capture) -> Result<Vec<Found>> {
    let folder = capture.source().path().parent().unwrap_or(Path::new(""));
    let tree = capture.to_json(folder)?;
    let find = |(i, d): (usize, &VariationDescription)| {
        let at = |invalid: Invalid| file.error(invalid.within(&format!("vary[{i}]")));
        let keys = d.key.as_deref().map(|key| keys_of(key, &tree, capture)).transpose();
        let files = d.files.as_deref().map(|pattern| files_of(pattern, file.path(), folder, sandbox)).transpose();
        Ok(Found {
            keys: keys.map_err(|invalid| at(invalid.within("key")))?.unwrap_or_default(),
            files: files.map_err(|invalid| at(invalid.within("files")))?.unwrap_or_default(),
        })
    };
    file.description.vary.iter().enumerate().map(find).collect()
}

/// Keys that match a pattern, in the order of the capture. A key without wildcards matches itself.
fn keys_of(key: &str, tree: &Value, capture: &Capture) -> Result<Vec<String>, Invalid> {
    let parts = keys(key);
    if !parts.iter().any(|part| is_pattern(part)) {
        return Ok(vec![key.to_owned()]);
    }
    // What was found so far: names, and the values there, if there are any.
    let mut found: Vec<(Vec<String>, Option<&Value>)> = vec![(Vec::new(), Some(tree))];
    for (i, part) in parts.iter().enumerate() {
        // Materials that the capture does not describe can be varied, too.
        let of_geometry = || capture.scene().materials.iter().map(|material| material.name.clone());
        let more: Vec<String> = if i == 1 && parts[0] == "materials" { of_geometry().collect() } else { Vec::new() };
        let mut next = Vec::new();
        for (names, value) in &found {
            for (name, value) in elements(*value, part, &more) {
                next.push(([&names[..], &[name]].concat(), value));
            }
        }
        if next.is_empty() {
            let known = found.iter().flat_map(|(_, value)| named_elements(*value, &more)).map(|(name, _)| name);
            let known: BTreeSet<String> = known.collect();
            let message = format!("{key:?} matches nothing: no name in {} matches {part:?}", path(&parts[..i]));
            let help = match list(part, known.iter().map(String::as_str)) {
                names if names.is_empty() => "there are none; remove it".to_owned(),
                names => format!("there are {names}"),
            };
            return Err(Invalid::new("", message).help(help));
        }
        found = next;
    }
    Ok(found.into_iter().map(|(names, _)| path(&names)).collect())
}

/// Elements of a value whose names match a part of a key, with their values. A part that is no pattern need not be
/// there.
fn elements<'a>(value: Option<&'a Value>, part: &str, more: &[String]) -> Vec<(String, Option<&'a Value>)> {
    if !is_pattern(part) {
        let number = |items: &'a Vec<Value>| {
            let by_name = || items.iter().find(|item| item.get("name").is_some_and(|name| name == part));
            part.parse::<usize>().map_or_else(|_| by_name(), |index| items.get(index))
        };
        let there = value.and_then(|value| match value {
            Value::Array(items) => number(items),
            Value::Object(table) => table.get(part),
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => None,
        });
        return vec![(part.to_owned(), there)];
    }
    let named = named_elements(value, more);
    named.into_iter().filter(|(name, _)| matches(part, name)).collect()
}

/// All named elements of a value. List elements without a unique name, or with a number for a name, go by index.
fn named_elements<'a>(value: Option<&'a Value>, more: &[String]) -> Vec<(String, Option<&'a Value>)> {
    let mut all: Vec<(String, Option<&Value>)> = match value {
        Some(Value::Array(items)) => {
            let name = |item: &Value| item.get("name").and_then(Value::as_str).map(str::to_owned);
            let is_alone = |name: &String| {
                name.parse::<usize>().is_err()
                    && items.iter().filter(|item| item.get("name").is_some_and(|other| *other == **name)).count() == 1
            };
            let items = items.iter().enumerate().filter(|(_, item)| item.is_object());
            items.map(|(i, item)| (name(item).filter(is_alone).unwrap_or(i.to_string()), Some(item))).collect()
        }
        Some(Value::Object(table)) => table.iter().map(|(key, value)| (key.clone(), Some(value))).collect(),
        Some(Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_)) | None => Vec::new(),
    };
    for name in more {
        if !all.iter().any(|(known, _)| known == name) {
            all.push((name.clone(), None));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn capture() -> Capture {
        let text = "[scene]\nenvironment = { illuminance_lux = 1 }\n[camera]\nposition_m = [0, 0, 1]\nlook_at_m = [0, 0, 0]\n\
                    [[targets]]\ntype = 'chessboard'\nname = 'board'\nsquares = [5, 4]\nsquare_mm = 20\n\
                    [[lights]]\ntype = 'point'\nname = 'key'\nposition_m = [0, 1, 0]\nintensity_cd = 1\n\
                    [[lights]]\ntype = 'point'\nposition_m = [0, 1, 0]\nintensity_cd = 1\n\
                    [[lights]]\ntype = 'point'\nname = 'kicker.a'\nposition_m = [0, 1, 0]\nintensity_cd = 1\n";
        Capture::parse(text, Path::new(""), &[]).expect("a capture")
    }

    #[test]
    fn patterns_of_keys_stand_for_names_of_the_capture() {
        let capture = capture();
        let tree = capture.to_json(Path::new("")).expect("JSON");
        let found = |key: &str| keys_of(key, &tree, &capture);
        for (key, expected) in [
            ("lens.f_number", &["lens.f_number"][..]),
            (
                "lights.*.intensity_cd",
                &["lights.key.intensity_cd", "lights.1.intensity_cd", "lights.\"kicker.a\".intensity_cd"],
            ),
            ("lights.k*.on", &["lights.key.on", "lights.\"kicker.a\".on"]),
            ("lights.?.on", &["lights.1.on"]),
            ("materials.board-*.roughness", &["materials.board-white.roughness", "materials.board-black.roughness"]),
            ("targets.b*.position_m", &["targets.board.position_m"]),
        ] {
            assert_eq!(found(key), Ok(expected.iter().map(|key| (*key).to_owned()).collect()), "{key}");
        }
        for (key, part) in
            [("lights.x*.on", "there are"), ("materials.wood-*.x", "board-white"), ("scene.objects.*.x", "none")]
        {
            let invalid = found(key).expect_err(key);
            let help = invalid.help.map(|help| help.to_string()).unwrap_or_default();
            assert!(invalid.message.contains("matches nothing") && help.contains(part), "{}: {help}", invalid.message);
        }
    }

    #[test]
    fn patterns_of_files_stand_for_files_in_order() {
        let place = tempfile::tempdir().expect("a folder");
        let at = |name: &str| place.path().join(name);
        fs::create_dir_all(at("set[1]/textures/deep.png")).expect("made");
        fs::create_dir_all(at("scene")).expect("made");
        for name in ["b.png", "a.png", "c.jpg", ".hidden.png", "deep.png/d.png"] {
            fs::write(at("set[1]/textures").join(name), "").expect("written");
        }
        let found = |pattern: &str, sandbox: &Sandbox| files_of(pattern, &at("set[1]/set.toml"), &at("scene"), sandbox);
        let free = Sandbox::default();
        let [a, b, d] = ["a.png", "b.png", "deep.png/d.png"].map(|name| format!("../set[1]/textures/{name}"));
        assert_eq!(found("textures/*.png", &free), Ok(vec![a.clone(), b.clone()]));
        assert_eq!(found("**/?.png", &free), Ok(vec![a.clone(), b.clone(), d]));
        assert!(found("textures/*.tif", &free).expect_err("none").message.contains("no file matches"));
        assert!(found("textures/[.png", &free).expect_err("a bracket").message.contains("is not a pattern"));
        let outside = Sandbox::new(&at("scene")).expect("a folder");
        assert!(found("textures/*.png", &outside).expect_err("outside").message.contains("not in the sandbox"));
        assert_eq!(found("textures/*.png", &Sandbox::new(place.path()).expect("a folder")), Ok(vec![a, b]));
    }
}
