//! Quoting of words for a shell.

/// Word in quotes, where a shell would take it for something else.
pub(super) fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=+:,@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

/// Several words, quoted and separated by spaces.
pub(super) fn all_quoted(words: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    words.into_iter().map(|word| quoted(word.as_ref())).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Test: a shell reads the words back.
    #[cfg(unix)]
    #[test]
    fn a_shell_reads_words_as_they_were() {
        let words =
            ["", "a b", "it's", "\"$HOME\"", "`ls`\\", "a\nb", "*", "set=['x', \"y\"]", "ü/1..4,9", "-o", "~", "#"];
        let script = format!("for word in {}; do printf '%s|' \"$word\"; done", all_quoted(words));
        let output = std::process::Command::new("sh").arg("-c").arg(script).output().expect("a shell");
        assert_eq!(String::from_utf8(output.stdout).expect("text"), words.map(|word| format!("{word}|")).concat());
    }
}
