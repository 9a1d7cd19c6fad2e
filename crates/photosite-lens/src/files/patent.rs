//! Patent numbers in titles.

/// Patent named in a title: `US 7,535,658`, `JP 2019-008031 example 1`.
pub(super) fn patent_in(text: &str) -> Option<String> {
    let lower = text.to_ascii_lowercase();
    let words: Vec<&str> = text.split_whitespace().collect();
    let is_number = |word: &str| word.chars().filter(char::is_ascii_digit).count() >= 5;
    let offices = ["US", "JP", "EP", "WO", "DE", "GB", "FR", "CN", "KR"];
    for (i, word) in words.iter().enumerate() {
        let bare = word.trim_matches(|c: char| !c.is_ascii_alphanumeric());
        let office = offices.iter().find(|office| bare.starts_with(**office));
        if let Some(office) = office {
            let rest = &bare[office.len()..];
            if is_number(rest) {
                return Some(bare.to_owned());
            }
            if rest.is_empty()
                && let Some(next) = words.get(i + 1).filter(|next| is_number(next))
            {
                return Some(format!("{office} {}", next.trim_end_matches([',', ';', '.', ')'])));
            }
        }
    }
    // "Patent 583336".
    let at = lower.find("patent")?;
    let word = text.get(at + "patent".len()..)?.split_whitespace().find(|word| is_number(word))?;
    Some(word.trim_matches(|c: char| !c.is_ascii_alphanumeric()).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patents_are_found_in_titles() {
        for (title, patent) in [
            ("US 7,277,232 Example 4 (Nikon)", Some("US 7,277,232")),
            ("JP2019-008031 Example 1", Some("JP2019-008031")),
            ("Cell Phone Lens - U.S. Patent 7,535,658", Some("7,535,658")),
            ("From U.S. Patent 583336, example 2.", Some("583336")),
            ("a patent of mine", None),
            ("US army 50 mm", None),
            ("", None),
        ] {
            assert_eq!(patent_in(title).as_deref(), patent, "{title}");
        }
    }
}
