//! Numbers and lists that every reader of YAML accepts.

/// Number as text that reads back as the same f64, and not as an integer or text: with a point and without an exponent.
pub(crate) fn number(x: f64) -> String {
    let text = x.to_string();
    if text.contains('.') { text } else { text + ".0" }
}

/// List in brackets.
pub(crate) fn list(numbers: &[f64]) -> String {
    format!("[{}]", numbers.iter().copied().map(number).collect::<Vec<_>>().join(", "))
}

/// Text in double quotes.
pub(crate) fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}
