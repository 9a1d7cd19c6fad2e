//! Changes for which light has to be traced anew: to camera, lens and sensor; and all changes so far.

use hyper::StatusCode;
use photosite_core::toml_text;
use serde_json::{Map, Value};

use super::answer::Failure;
use photosite_sensor::presets;

/// Keys that a trace may begin with, none of which names a file, and the kinds of their values.
const KEYS: [(&str, Holds); 12] = [
    ("camera.position_m", Holds::Numbers(3)),
    ("camera.look_at_m", Holds::Numbers(3)),
    ("camera.up", Holds::Numbers(3)),
    ("lens.focal_length_mm", Holds::Number),
    ("lens.f_number", Holds::Number),
    ("lens.focus_distance_m", Holds::Number),
    ("lens.autofocus_px", Holds::Numbers(2)),
    ("render.samples_per_pixel", Holds::Number),
    ("sensor.preset", Holds::Preset),
    ("sensor.resolution_px", Holds::Numbers(2)),
    ("output.irradiance", Holds::Flag),
    ("output.ideal", Holds::Flag),
];

/// Kind of value that a key holds.
#[derive(Clone, Copy)]
enum Holds {
    Number,
    Numbers(usize),
    Flag,
    Preset,
}

impl Holds {
    fn is(self, value: &Value) -> bool {
        match self {
            Self::Number => value.is_number(),
            Self::Numbers(count) => {
                value.as_array().is_some_and(|all| all.len() == count && all.iter().all(Value::is_number))
            }
            Self::Flag => value.is_boolean(),
            Self::Preset => value.as_str().is_some_and(|name| presets::names().any(|known| known == name)),
        }
    }
}

/// Changes, `key=value`, of an object of the page.
pub(super) fn for_trace(changes: &Map<String, Value>) -> Result<Vec<String>, Failure> {
    let change = |(key, value): (&String, &Value)| {
        let wrong = |what: &str| Failure::new(StatusCode::BAD_REQUEST, format!("{key}: {what}"));
        let known = KEYS.iter().find(|(known, _)| known == key);
        let (_, holds) = known.ok_or_else(|| {
            wrong("light is not traced again for that")
                .help(format!("there are {}", KEYS.map(|(key, _)| key).join(", ")))
        })?;
        // Numbers, lists of them and words are written alike in JSON and in TOML.
        if holds.is(value) { Ok(format!("{key}={value}")) } else { Err(wrong("this is not one of these values")) }
    };
    changes.iter().map(change).collect()
}

/// Changes, `key=value`, as tables, of which a later one takes the place of an earlier one.
pub(super) fn tables(changes: &[String]) -> toml::Table {
    let mut all = toml::Table::new();
    for change in changes {
        let Some((key, value)) = change.split_once('=') else { continue };
        if let Ok(one) = toml_text::read::<toml::Table>(&format!("{key} = {value}")) {
            lay_over(&mut all, one);
        }
    }
    all
}

/// A capture file of these tables, with what was changed at its head. `command` does the same of the input with all
/// overrides, those that it was opened with before those of the page.
pub(super) fn to_toml(
    name: &str,
    tables: &toml::Table,
    command: &str,
    [before, changes]: [&[String]; 2],
    notes: &[&str],
) -> String {
    // A file may be called anything.
    let name = &name.replace(char::is_control, " ");
    let lines: String = changes.iter().map(|change| format!("#   {}\n", change.replacen('=', " = ", 1))).collect();
    let what = if changes.is_empty() { "# Nothing is changed.\n".to_owned() } else { format!("# Changed:\n{lines}") };
    let notes: String = notes.iter().map(|note| format!("# {note}\n")).collect();
    let options: String = before.iter().chain(changes).map(|change| format!(" --set {}", in_shell(change))).collect();
    format!(
        "# {name}, as photosite view shows it.\n{what}{notes}# On the command line: photosite {command} {}{options}\n\n{tables}",
        in_shell(name)
    )
}

fn lay_over(all: &mut toml::Table, changes: toml::Table) {
    for (key, value) in changes {
        match (all.get_mut(&key), value) {
            (Some(toml::Value::Table(old)), toml::Value::Table(new)) => lay_over(old, new),
            (_, value) => drop(all.insert(key, value)),
        }
    }
}

/// Word quoted for a shell, on a line.
fn in_shell(word: &str) -> String {
    let is_plain = word.chars().all(|c| c.is_ascii_alphanumeric() || "_-./=,:".contains(c)) && !word.is_empty();
    if is_plain { word.to_owned() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn traced(changes: &Value) -> Result<Vec<String>, String> {
        for_trace(changes.as_object().expect("an object")).map_err(|failure| failure.message)
    }

    #[test]
    fn cameras_move_and_nothing_names_a_file() {
        let moved = traced(&json!({ "camera.position_m": [0, 1.5, 2], "lens.f_number": 8, "output.ideal": true }));
        assert_eq!(
            moved,
            Ok(vec!["camera.position_m=[0,1.5,2]".into(), "lens.f_number=8".into(), "output.ideal=true".into()])
        );
        for wrong in [
            json!({ "scene.geometry": ["/etc/passwd"] }),
            json!({ "sensor.preset": "/etc/passwd" }),
            json!({ "camera.position_m": [0, 1] }),
            json!({ "camera.position_m": ["a", 1, 2] }),
            json!({ "lens.f_number": "8\n[scene]" }),
            json!({ "lens.f_number": { "file": "x" } }),
        ] {
            assert!(traced(&wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn changes_are_keys_of_a_capture_file() {
        let changes =
            ["exposure.time_s=0.02", "lens.f_number=8", "exposure.time_s=0.04", "develop.tone_curve=\"filmic\""];
        let (changes, before) = (changes.map(str::to_owned), ["render.samples_per_pixel=4".to_owned()]);
        let text = to_toml("a b.toml", &tables(&changes), "render", [&before, &changes], &["A note."]);
        let table: toml::Table = text.parse().expect("TOML");
        assert_eq!(table["exposure"]["time_s"].as_float(), Some(0.04));
        assert_eq!(table["lens"]["f_number"].as_integer(), Some(8));
        let command = "photosite render 'a b.toml' --set render.samples_per_pixel=4 --set exposure.time_s=0.02";
        assert!(text.contains(command) && text.contains("\n# A note.\n"), "{text}");
        assert!(text.contains("--set 'develop.tone_curve=\"filmic\"'"), "{text}");
        // A name cannot add keys.
        let named = to_toml("a\n[scene]", &toml::Table::new(), "render", [&[], &[]], &[]);
        assert_eq!(named.parse::<toml::Table>().expect("TOML").len(), 0);
    }
}
