//! "Did you mean …?"

/// The candidate that a misspelt word was most likely meant to be, if any is close.
pub(crate) fn closest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Half the letters in place is the least that looks like the same word: `focal_length` is 0.8 of
    // `focal_length_mm`, `aperture` 0.1 of `f_number`.
    const LEAST_SIMILARITY: f64 = 0.5;
    let similarity = |candidate: &str| {
        let [word, candidate] = [word, candidate].map(str::to_lowercase);
        strsim::normalized_damerau_levenshtein(&word, &candidate)
    };
    candidates
        .into_iter()
        .map(|candidate| (similarity(candidate), candidate))
        .filter(|(similarity, _)| *similarity >= LEAST_SIMILARITY)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

/// "; did you mean `x`?" or nothing.
pub(crate) fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    closest(word, candidates).map_or_else(String::new, |candidate| format!("; did you mean `{candidate}`?"))
}

/// The first few of many names, for a help text.
pub(crate) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const SHOWN: usize = 12;
    let names: Vec<&str> = names.into_iter().collect();
    let rest = names.len().saturating_sub(SHOWN);
    let shown = names[..names.len() - rest].join(", ");
    if rest == 0 { shown } else { format!("{shown} and {rest} more") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspelt_words_find_their_like_and_strangers_do_not() {
        let keys = ["focal_length_mm", "f_number", "focus_distance_m"];
        assert_eq!(closest("focl_length_mm", keys), Some("focal_length_mm"));
        assert_eq!(closest("focal_length", keys), Some("focal_length_mm"));
        assert_eq!(closest("F-Number", keys), Some("f_number"));
        assert_eq!(closest("shutter", keys), None);
        assert_eq!(did_you_mean("fnumber", keys), "; did you mean `f_number`?");
    }

    #[test]
    fn long_lists_are_cut() {
        let names: Vec<String> = (0..15).map(|i| i.to_string()).collect();
        assert!(list(names.iter().map(String::as_str)).ends_with("11 and 3 more"));
        assert_eq!(list(["a", "b"]), "a, b");
    }
}
