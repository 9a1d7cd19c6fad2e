//! Descriptions in JSON Schemas come from doc comments, in which links are those of rustdoc: they lead nowhere for
//! readers of a schema, of an editor's hints or of the book's reference.

use serde_json::Value;

/// Removes rustdoc's links from descriptions; their words stay.
pub(crate) fn remove_rustdoc_links(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            for (key, value) in object {
                if let (true, Value::String(text)) = (key == "description", &mut *value) {
                    *text = without_links(text);
                }
                remove_rustdoc_links(value);
            }
        }
        Value::Array(array) => array.iter_mut().for_each(remove_rustdoc_links),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

/// Text without rustdoc's links: `[Jain89](photosite_core::references#jain89)` becomes `Jain89`. Brackets without a
/// target, as of TOML, stay.
fn without_links(text: &str) -> String {
    let Some((before, words, after)) = first_link(text) else { return text.to_owned() };
    format!("{before}{words}{}", without_links(after))
}

/// First link of a text: what comes before it, its words, and what comes after it.
fn first_link(text: &str) -> Option<(&str, &str, &str)> {
    let middle = text.find("](")?;
    let start = text[..middle].rfind('[')?;
    let target = &text[middle + 2..];
    // A target may be the path of a function, which ends with brackets of its own.
    let mut depth = 1_usize;
    let end = target.find(|c| {
        depth = match c {
            '(' => depth + 1,
            ')' => depth - 1,
            _ => depth,
        };
        depth == 0
    })?;
    Some((&text[..start], &text[start + 1..middle], &target[end + 1..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_of_rustdoc_become_their_words() {
        let text = "After [Jain89](a::b#jain89) and\n[`expose`](photosite_sensor::expose()), in `[lens]`: [1, 2].";
        assert_eq!(without_links(text), "After Jain89 and\n`expose`, in `[lens]`: [1, 2].");
    }
}
