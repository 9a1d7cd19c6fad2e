//! Paths of keys, as in `materials."oak.light".roughness`, alone and before the `=` of an override.
//!
//! Parts in quotes are TOML's strings: they may hold dots and equals signs.

use glob::Pattern;

use crate::toml_text;

/// Key and value of an override, `key=value`; `None` where it has no value.
pub fn split_change(change: &str) -> Option<(&str, &str)> {
    let equals = outside_quotes(change, '=').next().or_else(|| change.find('='))?;
    Some((change[..equals].trim(), change[equals + 1..].trim()))
}

/// The value of an override as TOML reads it; `None` for a bare word, which stands for itself.
pub fn toml_value(text: &str) -> Option<toml::Value> {
    // A value may not smuggle in lines of its own.
    toml_text::value(text).filter(|_| !text.contains(['\n', '\r']))
}

/// The keys of a path, without their quotes.
pub fn keys(path: &str) -> Vec<String> {
    let mut from = 0;
    let ends: Vec<usize> = outside_quotes(path, '.').chain([path.len()]).collect();
    let part = |end| {
        let part = path[from..end].trim();
        from = end + 1;
        unquoted(part).unwrap_or_else(|| part.to_owned())
    };
    ends.into_iter().map(part).collect()
}

/// The path of these keys, each in quotes where TOML wants them.
pub fn path(keys: &[String]) -> String {
    let is_bare = |key: &str| !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_');
    let written = |key: &String| if is_bare(key) { key.clone() } else { toml::Value::from(&**key).to_string() };
    keys.iter().map(written).collect::<Vec<_>>().join(".")
}

/// Whether a key is a pattern for several: `*` for any letters, `?` for one, `[ab]` for one of the enclosed, besides
/// other letters.
pub fn is_pattern(key: &str) -> bool {
    key.contains(['*', '?'])
}

/// Whether a key matches a pattern. A plain key matches itself alone.
pub fn matches(pattern: &str, key: &str) -> bool {
    let is_alike = || Pattern::new(pattern).is_ok_and(|pattern| pattern.matches(key));
    pattern == key || is_pattern(pattern) && is_alike()
}

/// Whether a path matches a path of patterns.
pub fn path_matches(pattern: &str, path: &str) -> bool {
    let (patterns, keys) = (keys(pattern), keys(path));
    patterns.len() == keys.len() && patterns.iter().zip(&keys).all(|(pattern, key)| matches(pattern, key))
}

/// Whether one of these letters stands outside of quotes.
pub fn has_outside_quotes(text: &str, letters: &[char]) -> bool {
    letters.iter().any(|letter| outside_quotes(text, *letter).next().is_some())
}

/// Positions of a letter outside quotes.
fn outside_quotes(text: &str, wanted: char) -> impl Iterator<Item = usize> {
    let (mut quote, mut is_escaped) = (None, false);
    text.char_indices().filter_map(move |(i, c)| {
        match quote {
            // Nothing is escaped in literal strings.
            Some('"') if is_escaped => is_escaped = false,
            Some('"') if c == '\\' => is_escaped = true,
            Some(open) if c == open => quote = None,
            Some(_) => {}
            None if c == '"' || c == '\'' => quote = Some(c),
            None => return (c == wanted).then_some(i),
        }
        None
    })
}

/// Content of a string in quotes.
fn unquoted(part: &str) -> Option<String> {
    if !part.starts_with(['"', '\'']) {
        return None;
    }
    match toml_value(part) {
        Some(toml::Value::String(text)) => Some(text),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overrides_are_split_at_the_first_equals_sign_of_their_own() {
        for (change, key, value) in [
            ("lens.f_number=4", "lens.f_number", "4"),
            (" a . b = { c = 1 } ", "a . b", "{ c = 1 }"),
            ("materials.\"a=b\".x=1", "materials.\"a=b\".x", "1"),
            ("materials.\"a\\\"=b\".x=1", "materials.\"a\\\"=b\".x", "1"),
            ("materials.'a=\\'.x=1", "materials.'a=\\'.x", "1"),
            ("materials.bob's.x=1", "materials.bob's.x", "1"),
            ("=1", "", "1"),
        ] {
            assert_eq!(split_change(change), Some((key, value)), "{change}");
        }
        assert_eq!(split_change("lens.f_number"), None);
    }

    #[test]
    fn values_are_tomls_and_words_are_not() {
        for text in ["4", "-1e3", "true", "\"a b\"", "[1, 2]", "{ a = 1 }", "2026-06-21", "inf"] {
            let table: toml::Table = format!("key = {text}").parse().expect(text);
            assert_eq!(toml_value(text).as_ref(), table.get("key"), "{text}");
        }
        for text in ["", "red", "a b", "4 # four", "4\nother = 5", "[1,\n2]", "lens.toml"] {
            assert_eq!(toml_value(text), None, "{text}");
        }
    }

    #[test]
    fn keys_in_quotes_are_read_and_written() {
        for (text, parts) in [
            ("lights.0.intensity_cd", &["lights", "0", "intensity_cd"][..]),
            ("materials.\"oak.light\".roughness", &["materials", "oak.light", "roughness"]),
            ("materials.\"a \\\"b\\\" #1\".x", &["materials", "a \"b\" #1", "x"]),
            ("a", &["a"]),
        ] {
            let found = keys(text);
            assert_eq!(found, parts, "{text}");
            assert_eq!(keys(&path(&found)), parts, "{}", path(&found));
        }
        assert_eq!(keys("materials.'a.b'.x"), ["materials", "a.b", "x"]);
        assert_eq!(path(&["a".to_owned(), "ö".to_owned(), String::new()]), "a.\"ö\".\"\"");
    }

    #[test]
    fn patterns_stand_for_the_keys_that_are_like_them() {
        assert!(path_matches("materials.paint-*.roughness", "materials.\"paint-a.b\".roughness"));
        assert!(path_matches("materials.?.x", "materials.a.x") && !path_matches("materials.?.x", "materials.ab.x"));
        assert!(!path_matches("materials.*", "materials.a.x"), "a star stands for one key");
        assert!(path_matches("lights.0.x", "lights.0.x") && !path_matches("lights.[0].x", "lights.0.x"));
        assert!(matches("wood[1]", "wood[1]"), "brackets alone make no pattern");
    }
}
