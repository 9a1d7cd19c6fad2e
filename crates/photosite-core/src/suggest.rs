//! Suggestions for misspelt words: "did you mean …?"

/// Least similarity of a suggestion: half the letters in place. `focal_length` is 0.8 of `focal_length_mm`, `aperture`
/// 0.1 of `f_number`.
const LEAST_SIMILARITY: f64 = 0.5;

/// Similarity of two words, 0–1, regardless of case: the fraction of letters in place. For a word that is contained
/// whole in the other, as `samples` in `samples_per_pixel`, the rest counts by half.
fn similarity(word: &str, candidate: &str) -> f64 {
    /// Shortest contained word that counts; shorter ones are in many words.
    const SHORTEST_PART: usize = 3;
    let [word, candidate] = [word, candidate].map(str::to_lowercase);
    let in_place = strsim::normalized_damerau_levenshtein(&word, &candidate);
    let (short, long) = if word.len() < candidate.len() { (word, candidate) } else { (candidate, word) };
    if short.len() >= SHORTEST_PART && long.contains(&short) { (1.0 + in_place) / 2.0 } else { in_place }
}

/// The candidate that a misspelt word was most likely meant to be, if any is close.
pub fn closest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    candidates
        .into_iter()
        .map(|candidate| (similarity(word, candidate), candidate))
        .filter(|(similarity, _)| *similarity >= LEAST_SIMILARITY)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

/// Suggestion for a message, "; did you mean `x`?", or an empty text.
pub fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    closest(word, candidates).map_or_else(String::new, |candidate| format!("; did you mean `{candidate}`?"))
}

/// Names for a help text: those similar to `word` first, the most similar at the head, then all others in their order.
pub fn list<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    /// Largest number of names shown: more than any table has keys, but a scene may have thousands of materials.
    const SHOWN: usize = 60;
    let with_similarity = names.into_iter().map(|name| (similarity(word, name), name));
    let (mut near, others): (Vec<_>, Vec<_>) =
        with_similarity.partition(|(similarity, _)| *similarity >= LEAST_SIMILARITY);
    // Names that are as near as each other stay in their order.
    near.sort_by(|a, b| b.0.total_cmp(&a.0));
    let names: Vec<&str> = near.into_iter().chain(others).map(|(_, name)| name).collect();
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
        assert_eq!(closest("focus", keys), Some("focus_distance_m"));
        assert_eq!(closest("shutter", keys), None);
        assert_eq!(did_you_mean("fnumber", keys), "; did you mean `f_number`?");
    }

    #[test]
    fn lists_begin_with_what_is_alike_and_leave_nothing_out() {
        let names: Vec<String> = (0..40).map(|i| format!("key_{i}")).chain(["gain_db".to_owned()]).collect();
        let shown = list("gain", names.iter().map(String::as_str));
        assert!(shown.starts_with("gain_db, key_0, key_1, "), "{shown}");
        assert_eq!(shown.split(", ").count(), names.len());
        assert_eq!(list("", ["a", "b"]), "a, b");
        assert_eq!(list("focus", ["f_number", "focus_distance_m", "blades"]), "focus_distance_m, f_number, blades");
    }

    #[test]
    fn endless_lists_are_cut_behind_what_is_alike() {
        let names: Vec<String> = (0..1000).map(|i| format!("{i:04}")).chain(["wall".to_owned()]).collect();
        let shown = list("wal", names.iter().map(String::as_str));
        assert!(shown.starts_with("wall, 0000, ") && shown.ends_with("0058 and 941 more"), "{shown}");
    }
}
