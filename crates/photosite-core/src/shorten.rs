//! Messages of a length that can be read, whatever the files hold that they quote.

/// Characters that are left of a word that is cut.
const KEPT: usize = 60;
/// Bytes of the longest word that stays: paths are long, and of use only as a whole.
const LONGEST_WORD: usize = 400;
/// Bytes of the longest message.
const LONGEST: usize = 4000;

/// Cuts words that no message needs as a whole down to their beginning and "…", and what is too long to be read.
pub(crate) fn shorten(message: String) -> String {
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

/// What closes a quotation, and the space, after a word.
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
    fn no_text_makes_a_long_message() {
        for text in
            ["w".repeat(100_000), "w ".repeat(50_000), ")".repeat(100_000), "\u{a0}".repeat(50_000), "é\n".repeat(9999)]
        {
            let message = shorten(format!("'{text}' is no number"));
            assert!(message.len() <= LONGEST + "…".len() && message.contains('…'), "{}", message.len());
        }
    }
}
