//! Commands of a CODE V sequence.

use crate::files::draft::{Fault, Read};
use crate::files::text::number;
use crate::files::text::positive;

/// A command of a sequence.
#[derive(Debug)]
pub(super) struct Command {
    /// Line, counted from 1.
    pub(super) line: usize,
    /// Key: the first three letters in capitals; `S` for every surface.
    pub(super) key: String,
    /// All words; texts without their quotes.
    pub(super) words: Vec<String>,
    /// Surface named by the command: 5 of `STO S5`.
    pub(super) surface: Option<usize>,
    /// Zoom position named by the command: 2 of `THI S5 Z2 1.5`.
    pub(super) zoom: Option<usize>,
    /// Whether the command is part of the private catalogue, between PRV and END.
    pub(super) is_private: bool,
}

impl Command {
    /// Words behind the key and the qualifiers.
    pub(super) fn arguments(&self) -> Vec<&str> {
        let is_qualifier = |word: &&String| qualifier(word, 'S').is_some() || qualifier(word, 'Z').is_some();
        self.words[1..].iter().skip_while(is_qualifier).map(String::as_str).collect()
    }

    /// Argument that must be a number above 0.
    pub(super) fn positive(&self, word: usize) -> Read<f64> {
        let words: Vec<&str> = self.words[word.min(self.words.len())..].iter().map(String::as_str).collect();
        positive(&words, &self.key, self.line)
    }
}

/// Number of a qualifier, 5 of `S5`.
fn qualifier(word: &str, letter: char) -> Option<usize> {
    let digits = word.strip_prefix(letter).or_else(|| word.strip_prefix(letter.to_ascii_lowercase()))?;
    digits.parse().ok()
}

/// Commands of a text. `!` begins a comment, `&` at the end of a line continues it, `;` ends a command.
pub(super) fn commands(text: &str) -> Vec<Command> {
    let mut found = Vec::new();
    let mut is_private = false;
    let mut lines = text.lines().enumerate();
    while let Some((i, first)) = lines.next() {
        let mut whole = without_comment(first).trim_end().to_owned();
        while whole.ends_with('&') {
            whole.pop();
            let Some((_, next)) = lines.next() else { break };
            whole.push(' ');
            whole.push_str(without_comment(next).trim_end());
        }
        for part in split_outside_quotes(&whole, ';') {
            let words = words(part);
            let Some(first) = words.first() else { continue };
            let key = key(first);
            if key == "PRV" {
                is_private = true;
            }
            let qualifiers = |letter| words[1..].iter().find_map(|word| qualifier(word, letter));
            found.push(Command {
                line: i + 1,
                surface: qualifiers('S'),
                zoom: qualifiers('Z'),
                is_private,
                key: key.clone(),
                words,
            });
            if key == "END" {
                is_private = false;
            }
        }
    }
    found
}

/// Key of a command: `S`, `SO`, `SI`, `S3`, or the first three letters of all others, in capitals.
fn key(word: &str) -> String {
    let upper = word.to_ascii_uppercase();
    if qualifier(&upper, 'S').is_some() {
        return "S".to_owned();
    }
    upper.chars().take(3).collect()
}

fn without_comment(line: &str) -> &str {
    split_outside_quotes(line, '!').next().unwrap_or_default()
}

/// Parts of a text between separators outside of quotes.
fn split_outside_quotes(text: &str, separator: char) -> impl Iterator<Item = &str> {
    let mut quote = None;
    text.split(move |c| {
        match quote {
            Some(end) if c == end => quote = None,
            None if c == '\'' || c == '"' => quote = Some(c),
            Some(_) | None => {}
        }
        quote.is_none() && c == separator
    })
}

/// Words of a command; a text in quotes is one.
fn words(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let (word, behind) = if first == '\'' || first == '"' {
            rest[1..].split_once(first).unwrap_or((&rest[1..], ""))
        } else {
            rest.split_once(char::is_whitespace).unwrap_or((rest, ""))
        };
        found.push(word.to_owned());
        rest = behind.trim_start();
    }
    found
}

/// Whether a word is a number.
pub(super) fn is_number(word: &str) -> bool {
    number(word).is_some()
}

/// Fault at a command.
pub(super) fn fault(command: &Command, message: &str) -> Fault {
    Fault::at(command.line, format!("{}: {message}", command.words.join(" ")))
}
