//! Messages of readable length, whatever the quoted files hold.

/// Number of characters that a cut word keeps.
const KEPT: usize = 60;
/// Longest word, in bytes, that stays whole: paths are long, and of use only as a whole.
const LONGEST_WORD: usize = 400;
/// Longest name in a table, in characters: that of a file.
const LONGEST_NAME: usize = 255;
/// Longest message, in bytes.
const LONGEST: usize = 4000;

/// Cuts overlong words down to their beginning and "…", and an overlong message to a readable length.
pub fn shorten(message: String) -> String {
    if message.len() <= LONGEST_WORD {
        return message;
    }
    let short = |word: &str| match word.char_indices().nth(KEPT) {
        Some((end, _)) if word.len() > LONGEST_WORD => format!("{}…{}", &word[..end], closing(word)),
        _ => word.to_owned(),
    };
    let words: String = message.split_inclusive(char::is_whitespace).map(short).collect();
    if words.len() <= LONGEST {
        return words;
    }
    format!("{}…", &words[..words.floor_char_boundary(LONGEST)])
}

/// Cuts each line of a text like a message.
pub fn shorten_lines(text: &str) -> String {
    text.split('\n').map(|line| shorten(line.to_owned())).collect::<Vec<_>>().join("\n")
}

/// Name in a table, whose column becomes as wide; the end of an overlong name is cut.
pub fn shorten_name(name: &str) -> String {
    match name.char_indices().nth(LONGEST_NAME).and_then(|_| name.char_indices().nth(KEPT)) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.to_owned(),
    }
}

/// Closing quotation mark and space after a word.
fn closing(word: &str) -> &str {
    let end = word.trim_end_matches(|c: char| c.is_whitespace() || "\"'`,;:.)]}".contains(c)).len();
    // A word of such signs alone has no end.
    if word.len() - end > KEPT { "" } else { &word[end..] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_words_lose_their_end() {
        let word = "ä".repeat(50_000);
        let message = shorten(format!("the key \"{word}\", is not known"));
        assert_eq!(message, format!("the key \"{}…\", is not known", "ä".repeat(KEPT - 1)));
        let path = "a/".repeat(150);
        for whole in [String::new(), "short".to_owned(), format!("{path} is not there: {path}")] {
            assert_eq!(shorten(whole.clone()), whole);
        }
    }

    #[test]
    fn long_names_lose_their_end_whatever_they_are_made_of() {
        for name in ["w".repeat(100_000), "w ".repeat(50_000), "ä".repeat(256)] {
            assert_eq!(shorten_name(&name).chars().count(), KEPT + 1);
        }
        assert_eq!(shorten_name(&"ä".repeat(255)), "ä".repeat(255));
        assert_eq!(shorten_lines(&format!("a\n{}\n", "w".repeat(500))), format!("a\n{}…\n", "w".repeat(KEPT)));
    }

    #[test]
    fn no_text_makes_a_long_message() {
        for text in
            ["w".repeat(100_000), "w ".repeat(50_000), ")".repeat(100_000), "\u{a0}".repeat(50_000), "é\n".repeat(9999)]
        {
            let message = shorten(format!("'{text}' is no number"));
            assert!(message.len() <= LONGEST + "…".len() && message.contains('…'), "{}", message.len());
        }
    }
}
