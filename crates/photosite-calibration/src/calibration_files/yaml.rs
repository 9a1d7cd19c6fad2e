//! The part of YAML that calibration files are written in, and JSON, which is a part of that: tables and lists by
//! indentation and in brackets, plain and quoted words, comments, tags. Anchors and texts of several lines are refused.
//!
//! The first line `%YAML:1.0` of OpenCV is none of YAML, so that most readers refuse its files.

use super::tree::{Fault, Node, Value};

/// Deepest nesting; that of calibrations is 4.
const DEEPEST: usize = 32;

/// Values of a text of YAML or JSON.
pub(super) fn parse(text: &str) -> Result<Node, Fault> {
    let mut parser = Parser { text, at: 0, line: 1, line_start: 0 };
    parser.skip_head()?;
    let node = parser.block(0, 0)?;
    parser.skip_space();
    if parser.rest().starts_with("---") || parser.rest().starts_with("...") {
        parser.skip_line();
        parser.skip_space();
    }
    match parser.peek() {
        None => Ok(node),
        Some(_) => Err(parser.fault("expected the end of the file, or a key with the indentation of those before")),
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    line: usize,
    line_start: usize,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    fn column(&self) -> usize {
        self.at - self.line_start
    }

    fn fault(&self, message: impl Into<String>) -> Fault {
        Fault::new(self.line, "", message)
    }

    fn advance(&mut self) {
        let Some(c) = self.peek() else { return };
        self.at += c.len_utf8();
        if c == '\n' {
            self.line += 1;
            self.line_start = self.at;
        }
    }

    fn advance_by(&mut self, bytes: usize) {
        let end = self.at + bytes;
        while self.at < end {
            self.advance();
        }
    }

    fn skip_line(&mut self) {
        let end = self.rest().find('\n').unwrap_or(self.rest().len());
        self.advance_by(end);
    }

    /// Skips white space, line ends and comments.
    fn skip_space(&mut self) {
        loop {
            match self.peek() {
                Some(c) if c.is_whitespace() => self.advance(),
                Some('#') if self.at == self.line_start || self.text[..self.at].ends_with(char::is_whitespace) => {
                    self.skip_line();
                }
                Some(_) | None => return,
            }
        }
    }

    /// Skips spaces of this line.
    fn skip_blanks(&mut self) {
        while matches!(self.peek(), Some(' ' | '\t' | '\r')) {
            self.advance();
        }
    }

    /// Skips directives and the line that begins a document.
    fn skip_head(&mut self) -> Result<(), Fault> {
        self.skip_space();
        while self.peek() == Some('%') {
            self.skip_line();
            self.skip_space();
        }
        if self.rest().starts_with("---") {
            self.advance_by(3);
            self.skip_space();
        }
        if self.peek().is_none() { Err(Fault::of_file("is empty")) } else { Ok(()) }
    }

    /// Whether a list in brackets, a document or the text ends here.
    fn is_at_dash(&self) -> bool {
        let rest = self.rest();
        rest.starts_with('-') && rest[1..].chars().next().is_none_or(char::is_whitespace)
    }

    fn is_at_document_end(&self) -> bool {
        self.column() == 0 && (self.rest().starts_with("---") || self.rest().starts_with("..."))
    }

    /// Value that begins at the next word, whose column is at least `indent`.
    fn block(&mut self, indent: usize, depth: usize) -> Result<Node, Fault> {
        self.skip_space();
        if depth > DEEPEST {
            return Err(self.fault(format!("tables and lists are nested more than {DEEPEST} deep")));
        }
        let (line, column) = (self.line, self.column());
        if self.peek().is_none() || column < indent || self.is_at_document_end() {
            return Ok(Node { line, value: Value::Scalar(String::new()) });
        }
        self.check_indentation()?;
        if self.is_at_dash() {
            return self.block_list(column, depth);
        }
        if matches!(self.peek(), Some('[' | '{')) {
            return self.in_brackets(depth);
        }
        let is_quoted = matches!(self.peek(), Some('"' | '\''));
        let word = self.word(false)?;
        if self.is_at_colon(is_quoted) { self.block_table(column, word, line, depth) } else { self.scalar(word, line) }
    }

    fn check_indentation(&self) -> Result<(), Fault> {
        let before = &self.text[self.line_start..self.at];
        if before.contains('\t') && before.trim().is_empty() {
            return Err(self.fault("is indented with a tab").help("indent with spaces"));
        }
        Ok(())
    }

    fn scalar(&mut self, word: String, line: usize) -> Result<Node, Fault> {
        self.skip_blanks();
        match self.peek() {
            None | Some('\n' | '#') => Ok(Node { line, value: Value::Scalar(word) }),
            Some(_) => Err(self.fault(format!("expected the end of the line after {word:?}"))),
        }
    }

    fn is_at_colon(&self, is_quoted: bool) -> bool {
        let rest = self.rest().trim_start_matches([' ', '\t']);
        rest.starts_with(':') && (is_quoted || rest[1..].chars().next().is_none_or(char::is_whitespace))
    }

    fn block_list(&mut self, column: usize, depth: usize) -> Result<Node, Fault> {
        let line = self.line;
        let mut nodes = Vec::new();
        while self.peek().is_some() && self.column() == column && self.is_at_dash() && !self.is_at_document_end() {
            self.advance();
            self.skip_tag();
            nodes.push(self.block(column + 1, depth + 1)?);
            self.skip_space();
        }
        Ok(Node { line, value: Value::List(nodes) })
    }

    /// Table whose first key has been read.
    fn block_table(&mut self, column: usize, first: String, line: usize, depth: usize) -> Result<Node, Fault> {
        let mut entries: Vec<(String, Node)> = Vec::new();
        let mut key = first;
        loop {
            if entries.iter().any(|(name, _)| *name == key) {
                return Err(Fault::new(self.line, key, "stands there twice").help("keep one of them"));
            }
            self.skip_blanks();
            self.advance();
            self.skip_tag();
            let of_key = self.line;
            self.skip_space();
            // A list may begin in the column of its key.
            let indent = if self.line > of_key && self.is_at_dash() { column } else { column + 1 };
            let is_here = self.peek().is_some() && self.column() >= indent && !self.is_at_document_end();
            let node = if self.line == of_key || is_here {
                self.block(indent, depth + 1)?
            } else {
                Node { line: of_key, value: Value::Scalar(String::new()) }
            };
            entries.push((key, node));
            self.skip_space();
            if self.peek().is_none() || self.column() != column || self.is_at_document_end() || self.is_at_dash() {
                return Ok(Node { line, value: Value::Table(entries) });
            }
            self.check_indentation()?;
            let is_quoted = matches!(self.peek(), Some('"' | '\''));
            key = self.word(false)?;
            if !self.is_at_colon(is_quoted) {
                return Err(self.fault(format!("expected a key with a colon, found {key:?}")));
            }
        }
    }

    /// Skips tags, such as !!opencv-matrix.
    fn skip_tag(&mut self) {
        self.skip_blanks();
        while self.peek() == Some('!') {
            let end = self.rest().find(char::is_whitespace).unwrap_or(self.rest().len());
            self.advance_by(end);
            self.skip_blanks();
        }
    }

    fn in_brackets(&mut self, depth: usize) -> Result<Node, Fault> {
        let line = self.line;
        if depth > DEEPEST {
            return Err(self.fault(format!("tables and lists are nested more than {DEEPEST} deep")));
        }
        let is_table = self.peek() == Some('{');
        let end = if is_table { '}' } else { ']' };
        self.advance();
        let (mut nodes, mut entries) = (Vec::new(), Vec::<(String, Node)>::new());
        loop {
            self.skip_space();
            if self.peek() == Some(end) {
                self.advance();
                let value = if is_table { Value::Table(entries) } else { Value::List(nodes) };
                return Ok(Node { line, value });
            }
            if is_table {
                let is_quoted = matches!(self.peek(), Some('"' | '\''));
                let key = self.word(true)?;
                if !self.is_at_colon(is_quoted) {
                    return Err(self.fault(format!("expected a colon after {key:?}")));
                }
                self.skip_blanks();
                self.advance();
                self.skip_space();
                if entries.iter().any(|(name, _)| *name == key) {
                    return Err(Fault::new(self.line, key, "stands there twice").help("keep one of them"));
                }
                entries.push((key, self.element(depth)?));
            } else {
                nodes.push(self.element(depth)?);
            }
            self.skip_space();
            match self.peek() {
                Some(',') => self.advance(),
                Some(c) if c == end => {}
                Some(c) if self.line == line => {
                    return Err(self.fault(format!("expected a comma or {end}, found {c:?}")));
                }
                Some(c) => {
                    let message = format!(
                        "the bracket of this line has no {end}, or a comma is missing before {c:?} in line {}",
                        self.line
                    );
                    return Err(Fault::new(line, "", message));
                }
                None => return Err(Fault::new(line, "", format!("the bracket of this line has no {end}"))),
            }
        }
    }

    fn element(&mut self, depth: usize) -> Result<Node, Fault> {
        self.skip_tag();
        match self.peek() {
            Some('[' | '{') => self.in_brackets(depth + 1),
            Some(_) | None => {
                let line = self.line;
                Ok(Node { line, value: Value::Scalar(self.word(true)?) })
            }
        }
    }

    /// Quoted or plain word; a plain one ends before a colon with a space, a comment, the line's end and, in brackets,
    /// at what divides their elements.
    fn word(&mut self, in_brackets: bool) -> Result<String, Fault> {
        match self.peek() {
            Some(quote @ ('"' | '\'')) => self.quoted(quote),
            Some(c @ ('&' | '*' | '|' | '>' | '@' | '`')) => {
                Err(self.fault(format!("{c} of YAML is not read in calibrations")).help("write the value itself"))
            }
            Some(_) | None => {
                let rest = self.rest();
                let mut end = rest.len();
                let mut before = ' ';
                for (i, c) in rest.char_indices() {
                    let next = rest[i + c.len_utf8()..].chars().next();
                    let is_colon = c == ':' && next.is_none_or(char::is_whitespace);
                    let is_comment = c == '#' && before.is_whitespace();
                    if c == '\n' || is_colon || is_comment || in_brackets && ",[]{}".contains(c) {
                        end = i;
                        break;
                    }
                    before = c;
                }
                let word = rest[..end].trim_end();
                if word.is_empty() {
                    return Err(self.fault("expected a value"));
                }
                self.advance_by(word.len());
                Ok(word.to_owned())
            }
        }
    }

    fn quoted(&mut self, quote: char) -> Result<String, Fault> {
        let line = self.line;
        self.advance();
        let mut word = String::new();
        while let Some(c) = self.peek() {
            self.advance();
            match c {
                '\\' if quote == '"' => {
                    let Some(c) = self.peek() else { break };
                    self.advance();
                    word.push(match c {
                        'n' => '\n',
                        't' => '\t',
                        c => c,
                    });
                }
                '\'' if quote == '\'' && self.peek() == Some('\'') => {
                    self.advance();
                    word.push('\'');
                }
                c if c == quote => return Ok(word),
                c => word.push(c),
            }
        }
        Err(Fault::new(line, "", format!("the text of this line has no {quote} at its end")))
    }
}
