//! Warnings about a data set's images, each kind once: warnings that differ in digits alone are of one kind.

use std::collections::{BTreeMap, BTreeSet};

use super::image_folder::name;

/// Warnings by kind.
#[derive(Debug, Default)]
pub(super) struct WarningsByKind {
    kinds: BTreeMap<String, Kind>,
    /// Frames that were looked at.
    frames: BTreeSet<u32>,
}

/// Kind of warning.
#[derive(Debug)]
struct Kind {
    /// Warning of the first image, and that image.
    words: String,
    first: (u32, String),
    frames: BTreeSet<u32>,
}

impl WarningsByKind {
    /// Counts a frame that may have warnings.
    pub(super) fn frame(&mut self, number: u32) {
        self.frames.insert(number);
    }

    /// Keeps a warning about an image.
    pub(super) fn warning(&mut self, camera: &str, number: u32, words: &str) {
        self.frame(number);
        let image = (number, camera.to_owned());
        let kind = self.kinds.entry(without_numbers(words)).or_insert_with(|| Kind {
            words: words.to_owned(),
            first: image.clone(),
            frames: BTreeSet::new(),
        });
        kind.frames.insert(number);
        if image < kind.first {
            (kind.words, kind.first) = (words.to_owned(), image);
        }
    }

    /// Each kind of warning with its number of frames and an example image.
    pub(super) fn in_words(&self) -> Vec<String> {
        let all = self.frames.len();
        let told = |Kind { words, first: (number, camera), frames }: &Kind| {
            format!("{words} (in {} of {all} frames, such as {})", frames.len(), name(camera, *number))
        };
        self.kinds.values().map(told).collect()
    }
}

/// Text with `#` in place of each number.
fn without_numbers(words: &str) -> String {
    let mut kind = String::with_capacity(words.len());
    let mut in_number = false;
    for letter in words.chars() {
        let goes_on = letter.is_ascii_digit() || in_number && letter == '.';
        match (goes_on, in_number) {
            (true, false) => kind.push('#'),
            (true, true) => {}
            (false, _) => kind.push(letter),
        }
        in_number = goes_on;
    }
    kind
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_is_said_once_with_its_frames_and_the_words_of_the_first() {
        let mut said = WarningsByKind::default();
        (0..5).for_each(|frame| said.frame(frame));
        said.warning("right", 3, "12 % of 7.5 is black");
        said.warning("left", 1, "9 % of 10 is black");
        said.warning("right", 1, "31 % of 0.25 is black");
        said.warning("left", 4, "dark");
        assert_eq!(
            said.in_words(),
            [
                "9 % of 10 is black (in 2 of 5 frames, such as left/000001)",
                "dark (in 1 of 5 frames, such as left/000004)"
            ]
        );
    }
}
