//! The lines of OBJ and MTL files: comments dropped, continued lines joined, numbers parsed.

use std::borrow::Cow;
use std::path::Path;
use std::str::{FromStr, SplitWhitespace};

use photosite_core::{Error, Invalid};

/// A statement: its keyword and the rest, with the line it begins on, counted from 1.
#[derive(Debug, PartialEq)]
pub(super) struct Statement<'a> {
    pub(super) line: usize,
    text: Cow<'a, str>,
    keyword_len: usize,
}

impl Statement<'_> {
    /// First word of the statement.
    pub(super) fn keyword(&self) -> &str {
        &self.text[..self.keyword_len]
    }

    /// Text after the keyword, trimmed.
    pub(super) fn rest(&self) -> &str {
        self.text[self.keyword_len..].trim()
    }

    /// The words after the keyword, up to a comment.
    pub(super) fn words(&self) -> Words<'_> {
        Words { words: self.text[self.keyword_len..].split_whitespace() }
    }

    /// Parses the words as numbers: at least `least`, at most `N`. Missing ones are zero. Returns the number of those
    /// present.
    pub(super) fn numbers<const N: usize>(&self, least: usize) -> Result<([f32; N], usize), Invalid> {
        let mut values = [0.0; N];
        let mut count = 0;
        for (value, word) in values.iter_mut().zip(self.words()) {
            *value = number(word)?;
            count += 1;
        }
        if count < least {
            return Err(Invalid::new("", format!("{:?} needs {least} numbers, found {count}", self.keyword())));
        }
        Ok((values, count))
    }

    /// Places an error at this statement.
    pub(super) fn at(&self, invalid: Invalid, path: &Path) -> Error {
        let key = if invalid.key.is_empty() { self.keyword().to_owned() } else { invalid.key };
        Invalid { key, ..invalid }.at_line(path, self.line)
    }
}

/// Words up to a comment.
pub(super) struct Words<'a> {
    words: SplitWhitespace<'a>,
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        self.words.next().filter(|word| !word.starts_with('#'))
    }
}

/// Parses a finite number.
pub(super) fn number(word: &str) -> Result<f32, Invalid> {
    match f32::from_str(word) {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(Invalid::new("", format!("{word:?} is not finite"))
            .help("the program that wrote the file divided by zero; fix the line and export again")),
        Err(_) => Err(Invalid::new("", format!("{word:?} is not a number"))),
    }
}

/// The statements of a file. A line that ends in a backslash goes on in the next.
pub(super) fn statements(text: &str) -> impl Iterator<Item = Statement<'_>> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        loop {
            let (number, line) = lines.next()?;
            let mut joined = Cow::Borrowed(line.trim());
            while let Some(begun) = joined.strip_suffix('\\') {
                let next = lines.next().map_or("", |(_, line)| line.trim());
                joined = Cow::Owned(format!("{begun} {next}").trim().to_owned());
            }
            // Comments in which ZBrush has colours are statements.
            if joined.is_empty() || joined.starts_with('#') && !joined.starts_with("#MRGB") {
                continue;
            }
            let keyword_len = joined.find(char::is_whitespace).unwrap_or(joined.len());
            return Some(Statement { line: number + 1, text: joined, keyword_len });
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_joined_and_comments_dropped() {
        let text = "# head\r\nv 1 2 \\\r\n  3 # tail\r\n\r\n  usemtl red #2\r\nf 1 \\";
        let found: Vec<_> = statements(text).collect();
        assert_eq!(
            found.iter().map(|s| (s.line, s.keyword())).collect::<Vec<_>>(),
            [(2, "v"), (5, "usemtl"), (6, "f")]
        );
        assert_eq!(found[0].words().collect::<Vec<_>>(), ["1", "2", "3"]);
        assert_eq!(found[0].numbers::<3>(3).expect("three").0, [1.0, 2.0, 3.0]);
        assert_eq!(found[1].rest(), "red #2");
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for (text, message) in
            [("v 1 2", "needs 3"), ("v 1 2 x", "\"x\""), ("v 1 2 nan", "not finite"), ("v 1 1e99 0", "not finite")]
        {
            let statement = statements(text).next().expect("a line");
            let error = statement.at(statement.numbers::<3>(3).expect_err(text), Path::new("a.obj"));
            assert!(error.to_string().starts_with("a.obj:1: v: ") && error.to_string().contains(message), "{error}");
        }
    }
}
