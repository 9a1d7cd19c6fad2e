//! Warnings of the pictures of a data set, each kind once: what differs in numbers alone is of one kind.

use std::collections::{BTreeMap, BTreeSet};

use super::presence::name;

/// Warnings by their kinds.
#[derive(Debug, Default)]
pub(super) struct SaidOfPictures {
    kinds: BTreeMap<String, Kind>,
    /// The frames that were looked at.
    frames: BTreeSet<u32>,
}

/// A kind of warning.
#[derive(Debug)]
struct Kind {
    /// The words of the first picture, and which it is.
    words: String,
    first: (u32, String),
    frames: BTreeSet<u32>,
}

impl SaidOfPictures {
    /// Counts a frame of which there may be warnings.
    pub(super) fn frame(&mut self, number: u32) {
        self.frames.insert(number);
    }

    /// Keeps a warning about a picture.
    pub(super) fn warning(&mut self, camera: &str, number: u32, words: &str) {
        self.frame(number);
        let picture = (number, camera.to_owned());
        let kind = self.kinds.entry(without_numbers(words)).or_insert_with(|| Kind {
            words: words.to_owned(),
            first: picture.clone(),
            frames: BTreeSet::new(),
        });
        kind.frames.insert(number);
        if picture < kind.first {
            (kind.words, kind.first) = (words.to_owned(), picture);
        }
    }

    /// Each kind with the number of frames that it is said of, and the picture whose words these are.
    pub(super) fn in_words(&self) -> Vec<String> {
        let all = self.frames.len();
        let told = |Kind { words, first: (number, camera), frames }: &Kind| {
            format!("{words} (in {} of {all} frames, such as {})", frames.len(), name(camera, *number))
        };
        self.kinds.values().map(told).collect()
    }
}

/// A text with `#` for each number in it.
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
        let mut said = SaidOfPictures::default();
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
