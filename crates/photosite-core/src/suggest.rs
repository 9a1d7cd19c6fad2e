//! Suggestions for misspelt words: "did you mean …?"

/// Least similarity of a suggestion: half the letters in place. `focal_length` is 0.8 of `focal_length_mm`, `aperture`
/// 0.1 of `f_number`.
const LEAST_SIMILARITY: f64 = 0.5;

/// Similarity of a suggestion whose beginning alone is alike: one slip in five letters.
const LEAST_SIMILARITY_TO_BEGINNING: f64 = 0.8;

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

/// Similarity of a word to the beginning of a longer key, as many words joined by `_` as it has: of `sampels` to the
/// `samples` of `samples_per_pixel`. 0 where the key goes on with nothing.
fn similarity_to_beginning(word: &str, key: &str) -> f64 {
    let words = word.split('_').count();
    match key.match_indices('_').nth(words - 1) {
        Some((end, _)) => strsim::normalized_damerau_levenshtein(&word.to_lowercase(), &key[..end].to_lowercase()),
        None => 0.0,
    }
}

/// The candidate of the greatest similarity, if that is at least `least`.
fn most_similar<'a>(
    candidates: impl IntoIterator<Item = &'a str>,
    similarity: impl Fn(&str) -> f64,
    least: f64,
) -> Option<(f64, &'a str)> {
    let rated = candidates.into_iter().map(|candidate| (similarity(candidate), candidate));
    rated.filter(|(similarity, _)| *similarity >= least).max_by(|a, b| a.0.total_cmp(&b.0))
}

/// The candidate that a misspelt word was most likely meant to be, if any is close.
pub fn closest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    most_similar(candidates, |candidate| similarity(word, candidate), LEAST_SIMILARITY).map(|(_, candidate)| candidate)
}

/// Suggestion for a message, "; did you mean `x`?", or an empty text. A key whose beginning is more like the word than
/// any whole candidate is named before that one.
pub fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let whole = most_similar(candidates.iter().copied(), |candidate| similarity(word, candidate), LEAST_SIMILARITY);
    let least = whole.map_or(LEAST_SIMILARITY_TO_BEGINNING, |(similarity, _)| similarity);
    let begun = most_similar(candidates, |key| similarity_to_beginning(word, key), least);
    match (begun, whole) {
        (Some((similarity, begun)), Some((_, whole))) if similarity > similarity_to_beginning(word, whole) => {
            format!("; did you mean `{begun}` or `{whole}`?")
        }
        (_, Some((_, found))) | (Some((_, found)), None) => format!("; did you mean `{found}`?"),
        (None, None) => String::new(),
    }
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
    fn keys_that_begin_with_the_word_are_named_too() {
        let keys = ["sampler", "seed", "samples_per_pixel"];
        for word in ["sampels", "samples", "Samples"] {
            assert_eq!(did_you_mean(word, keys), "; did you mean `samples_per_pixel` or `sampler`?");
        }
        assert_eq!(did_you_mean("sampels", keys[1..].iter().copied()), "; did you mean `samples_per_pixel`?");
        assert_eq!(did_you_mean("samplr", keys), "; did you mean `sampler`?");
        assert_eq!(did_you_mean("size", ["size_m", "size_scale"]), "; did you mean `size_m`?");
        assert_eq!(did_you_mean("samples_per_pxel", keys), "; did you mean `samples_per_pixel`?");
        assert_eq!(did_you_mean("focl", ["focal_length_mm", "focus_distance_m"]), "; did you mean `focal_length_mm`?");
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
