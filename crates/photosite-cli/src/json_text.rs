//! Text of a JSON object for people: a line for each key, lists and tables indented behind it.

use photosite_core::shorten::shorten_name;
use serde_json::{Map, Value};

use super::print::rounded;

/// Longest list that is written on one line, characters.
const LONGEST_LINE: usize = 90;

/// Text of an object, without a line break at its end.
pub(super) fn listing(facts: &Map<String, Value>) -> String {
    let width = facts.keys().map(|key| shorten_name(key).chars().count()).max().unwrap_or(0);
    let indented = format!("\n{:width$}  ", "");
    let line = |(key, value): (&String, &Value)| {
        format!("{:width$}  {}", shorten_name(key), text(key, value).replace('\n', &indented))
    };
    facts.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn text(key: &str, value: &Value) -> String {
    match value {
        Value::Null => "none".to_owned(),
        Value::Bool(true) => "yes".to_owned(),
        Value::Bool(false) => "no".to_owned(),
        Value::Number(number) => match number.as_f64().filter(|_| number.is_f64()) {
            Some(x) if x == 0.0 || (1e-4..1e15).contains(&x.abs()) => rounded(x, 6).to_string(),
            Some(x) => format!("{:e}", rounded(x, 6)),
            None => number.to_string(),
        },
        Value::String(text) => text.trim_end().to_owned(),
        Value::Object(map) => listing(map),
        Value::Array(items) if items.is_empty() => "none".to_owned(),
        Value::Array(items) if items.iter().all(Value::is_object) => table(items),
        Value::Array(items) => {
            // Columns and rows, width and height.
            let separator = if key.ends_with("_px") || key.ends_with("_um") { " × " } else { ", " };
            let items: Vec<String> = items.iter().map(|item| text("", item)).collect();
            let line = items.join(separator);
            if line.chars().count() <= LONGEST_LINE { line } else { items.join("\n") }
        }
    }
}

/// Table of objects with the same keys, one per line below the keys.
fn table(rows: &[Value]) -> String {
    let rows: Vec<&Map<String, Value>> = rows.iter().filter_map(Value::as_object).collect();
    let columns = rows[0].keys().map(|key| {
        let cells = rows.iter().map(|row| row.get(key).map_or_else(String::new, |cell| shorten_name(&text("", cell))));
        let cells: Vec<String> = std::iter::once(shorten_name(key)).chain(cells).collect();
        let width = cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0);
        let is_number = rows.iter().all(|row| row.get(key).is_some_and(Value::is_number));
        let aligned = |cell: &String| if is_number { format!("{cell:>width$}") } else { format!("{cell:width$}") };
        cells.iter().map(aligned).collect::<Vec<_>>()
    });
    let columns: Vec<Vec<String>> = columns.collect();
    let line = |i: usize| columns.iter().map(|cells| cells[i].as_str()).collect::<Vec<_>>().join("  ");
    (0..=rows.len()).map(|i| line(i).trim_end().to_owned()).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn keys_are_aligned_and_nothing_is_left_empty() {
        let names: Vec<String> = (0..20).map(|i| format!("material-{i}")).collect();
        let facts = json!({
            "name": "two\nlines\n",
            "resolution_px": [800, 600],
            "cameras": [],
            "environment": null,
            "channels": [{"name": "R", "mean": 1.5}, {"name": "variance.R", "mean": 22.123456789}],
            "few": ["a", "b"],
            "many": names,
        });
        let text = listing(facts.as_object().expect("an object"));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines[..10],
            [
                "name           two",
                "               lines",
                "resolution_px  800 × 600",
                "cameras        none",
                "environment    none",
                "channels       name           mean",
                "               R               1.5",
                "               variance.R  22.1235",
                "few            a, b",
                "many           material-0",
            ]
        );
        assert_eq!(lines[28], "               material-19");
    }
}
