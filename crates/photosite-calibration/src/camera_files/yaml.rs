//! Numbers and lists as every reader of YAML takes them.

/// A number that reads back as the same f64, and as no whole number or text: with a point and without an exponent.
pub(crate) fn number(x: f64) -> String {
    let text = x.to_string();
    if text.contains('.') { text } else { text + ".0" }
}

/// A list in brackets.
pub(crate) fn list(numbers: &[f64]) -> String {
    format!("[{}]", numbers.iter().copied().map(number).collect::<Vec<_>>().join(", "))
}

/// A text in double quotes.
pub(crate) fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}
