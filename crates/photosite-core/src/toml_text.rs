//! Parsing of TOML texts from any source, within a thread's stack.
//!
//! `toml` bounds how deep values nest while a text is well-formed, but neither while it recovers from errors nor in
//! dotted keys, and each level takes a part of the stack. So the structure of a text is walked first, without values:
//! up to [`MOST_LEVELS`], and up to the first error, after which nothing is entered any more.

use std::fmt::Write as _;
use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::DeTable;
use toml_parser::decoder::Encoding;
use toml_parser::parser::{EventReceiver, parse_document};
use toml_parser::{ErrorSink, Expected, ParseError, Source, Span};

/// Largest depth of tables and lists, dotted keys included. The deepest key of a capture file has seven levels.
pub const MOST_LEVELS: usize = 64;

/// A fault in a TOML text, and the bytes at fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TomlError {
    /// Bytes at fault, where they are known.
    pub span: Option<Range<usize>>,
    /// Message: the fault.
    pub message: String,
}

impl From<toml::de::Error> for TomlError {
    fn from(error: toml::de::Error) -> Self {
        Self { span: error.span(), message: error.message().to_owned() }
    }
}

impl From<ParseError> for TomlError {
    fn from(error: ParseError) -> Self {
        let mut message = error.description().to_owned();
        if error.expected().is_some_and(<[_]>::is_empty) {
            message.push_str(", expected nothing");
        }
        for (i, expected) in error.expected().unwrap_or_default().iter().enumerate() {
            message.push_str(if i == 0 { ", expected " } else { ", " });
            let _infallible = match expected {
                Expected::Literal("\n") => write!(message, "newline"),
                Expected::Literal(literal) => write!(message, "`{literal}`"),
                Expected::Description(words) => write!(message, "{words}"),
                _ => write!(message, "something else"),
            };
        }
        Self { span: error.unexpected().map(|span| span.start()..span.end()), message }
    }
}

/// Parses a text into values with their places.
///
/// # Errors
///
/// The first thing that is no TOML, or nests deeper than [`MOST_LEVELS`].
pub fn parse(text: &str) -> Result<Spanned<DeTable<'_>>, TomlError> {
    check(text)?;
    Ok(DeTable::parse(text)?)
}

/// Reads a value from a text.
///
/// # Errors
///
/// Errors of [`parse`], and a text that is no such value.
pub fn read<T: DeserializeOwned>(text: &str) -> Result<T, TomlError> {
    check(text)?;
    Ok(toml::from_str(text)?)
}

/// Parses a single value; `None` where the text is none.
pub fn value(text: &str) -> Option<toml::Value> {
    check(&format!("value = {text}")).ok()?;
    text.parse().ok()
}

/// Walks the structure of a text up to its first error.
fn check(text: &str) -> Result<(), TomlError> {
    let tokens = Source::new(text).lex().into_vec();
    let (mut walk, mut first) = (Walk::default(), None::<ParseError>);
    parse_document(&tokens, &mut walk, &mut first);
    first.map_or(Ok(()), |error| Err(error.into()))
}

/// Depth of the walk in the structure.
#[derive(Default)]
struct Walk {
    /// Levels of the current table's header, and of each enclosing value with the keys before it.
    around: Vec<usize>,
    level: usize,
    /// Whether an error was met, after which nothing is entered: closing brackets need not match opening ones from
    /// there on.
    is_lost: bool,
}

impl Walk {
    fn header(&mut self) {
        self.around.clear();
        self.level = 0;
    }

    fn end_of_header(&mut self) {
        self.around = vec![self.level];
    }

    fn deeper(&mut self, span: Span, errors: &mut dyn ErrorSink) {
        self.level += 1;
        if self.level > MOST_LEVELS && !self.is_lost {
            self.is_lost = true;
            errors.report_error(ParseError::new("tables, lists and dotted keys nest too deep").with_unexpected(span));
        }
    }

    fn open(&mut self, span: Span, errors: &mut dyn ErrorSink) -> bool {
        self.deeper(span, errors);
        self.around.push(self.level);
        !self.is_lost
    }

    fn close(&mut self) {
        self.around.pop();
        self.next();
    }

    /// Moves to another key of a table, or value of a list.
    fn next(&mut self) {
        self.level = self.around.last().copied().unwrap_or(0);
    }
}

impl EventReceiver for Walk {
    fn std_table_open(&mut self, _: Span, _: &mut dyn ErrorSink) {
        self.header();
    }

    fn std_table_close(&mut self, _: Span, _: &mut dyn ErrorSink) {
        self.end_of_header();
    }

    fn array_table_open(&mut self, _: Span, _: &mut dyn ErrorSink) {
        self.header();
    }

    fn array_table_close(&mut self, _: Span, _: &mut dyn ErrorSink) {
        self.end_of_header();
    }

    fn inline_table_open(&mut self, span: Span, errors: &mut dyn ErrorSink) -> bool {
        self.open(span, errors)
    }

    fn inline_table_close(&mut self, _: Span, _: &mut dyn ErrorSink) {
        self.close();
    }

    fn array_open(&mut self, span: Span, errors: &mut dyn ErrorSink) -> bool {
        self.open(span, errors)
    }

    fn array_close(&mut self, _: Span, _: &mut dyn ErrorSink) {
        self.close();
    }

    fn key_sep(&mut self, span: Span, errors: &mut dyn ErrorSink) {
        self.deeper(span, errors);
    }

    fn scalar(&mut self, _: Span, _: Option<Encoding>, _: &mut dyn ErrorSink) {
        self.next();
    }

    fn error(&mut self, _: Span, _: &mut dyn ErrorSink) {
        self.is_lost = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    /// Stack of a thread on systems that give it little, in bytes.
    const STACK: usize = 256 << 10;

    fn on_a_small_stack(text: &str) -> Result<(), TomlError> {
        std::thread::scope(|scope| {
            let parsing = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, || {
                let tables: toml::Table = read(text)?;
                let written = toml::to_string(&tables).expect("TOML");
                assert_eq!(parse(text)?.get_ref().len(), tables.len(), "{written}");
                Ok(())
            });
            parsing.expect("a thread").join().expect("no panic")
        })
    }

    #[rstest]
    #[case::recovery("a={b,c{d=1}\n", "")]
    #[case::one_line("a={b,c{d=1} ", "")]
    #[case::no_comma("a=[1 [2] ", "")]
    #[case::no_key("a={[ ", "")]
    #[case::wrong_close("a=[{]", "")]
    #[case::no_equals("{x", "a=")]
    #[case::tables("{a=", "a=")]
    #[case::lists("[", "a=")]
    #[case::mixed("[{a=", "a=")]
    #[case::dots("a.", "")]
    #[case::header_dots("a.", "[")]
    #[case::array_header_dots("a.", "[[")]
    #[case::dots_in_tables("{a.a.a.a.a.a.a.a=", "a=")]
    #[case::closes("a=]}", "")]
    #[case::strings("'''", "a=")]
    fn no_text_takes_the_stack(#[case] repeated: &str, #[case] before: &str, #[values(1000, 30_000)] times: usize) {
        let text = format!("{before}{}", repeated.repeat(times));
        let error = on_a_small_stack(&text).expect_err("no TOML");
        assert!(!error.message.is_empty() && error.message.len() < 200, "{error:?}");
    }

    #[rstest]
    #[case(format!("a={}1{}", "[".repeat(MOST_LEVELS), "]".repeat(MOST_LEVELS)), true)]
    #[case(format!("a={}1{}", "[".repeat(MOST_LEVELS + 1), "]".repeat(MOST_LEVELS + 1)), false)]
    #[case(format!("{}a=1", "a.".repeat(MOST_LEVELS)), true)]
    #[case(format!("{}a=1", "a.".repeat(MOST_LEVELS + 1)), false)]
    #[case(format!("[a.b]\n{}a=[1]", "a.".repeat(MOST_LEVELS - 2)), true)]
    #[case(format!("[a.b]\n{}a=[1]", "a.".repeat(MOST_LEVELS - 1)), false)]
    #[case(format!("[a.b]\n{}", (0..300).map(|i| format!("k{i} = {{ x.y = [[1, 2], [3]] }}\n")).collect::<String>()), true)]
    #[case(format!("a = [{}]", "{ x.y.z = 1 }, ".repeat(300)), true)]
    fn levels_are_counted_along_one_path(#[case] text: String, #[case] is_read: bool) {
        let read = on_a_small_stack(&text);
        assert_eq!(read.is_ok(), is_read, "{read:?}");
    }

    /// Structural errors have the wording of `toml`.
    #[rstest]
    #[case("b = = 2")]
    #[case("a = [1")]
    #[case("a = {b = 1, c")]
    #[case("[a\nb = 1")]
    #[case("a = 1\na = 2")]
    #[case("a")]
    #[case("a = 1 b = 2")]
    #[case("a = \"x")]
    fn errors_are_those_of_the_library(#[case] text: &str) {
        assert_eq!(parse(text).expect_err("no TOML"), DeTable::parse(text).expect_err("no TOML").into());
    }
}
