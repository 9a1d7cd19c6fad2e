//! What a user or a file can get wrong, told so that it can be put right.
//!
//! Modules that never touch files report an [`Invalid`]: a key, what is wrong with it, what to write instead. The
//! modules that read files turn it into an [`Error`], which adds the file and the line.

use std::fmt;
use std::path::{Path, PathBuf};

use miette::{Diagnostic, NamedSource, SourceSpan};

/// The result of anything that a user or a file can make fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// A value that cannot be used, named by its key (`lens.f_number`), without knowledge of the file it came from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Invalid {
    /// Dotted path of the offending key; may be empty where no single key is at fault.
    pub key: String,
    /// What is wrong, with the value that was found.
    pub message: String,
    /// What to write instead.
    pub help: Option<String>,
}

impl Invalid {
    /// An invalid value at `key`.
    pub fn new(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { key: key.into(), message: message.into(), help: None }
    }

    /// Says what to write instead.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Places the key inside a table: `within("lens")` turns `f_number` into `lens.f_number`.
    #[must_use]
    pub fn within(mut self, table: &str) -> Self {
        self.key = if self.key.is_empty() { table.to_owned() } else { format!("{table}.{}", self.key) };
        self
    }

    /// The error of a file whose lines are not known (a binary file, or one already parsed).
    pub fn in_file(self, path: &Path) -> Error {
        Error::Input(Box::new(InputError {
            path: path.to_owned(),
            line: None,
            key: self.key,
            message: self.message,
            help: self.help,
            source_code: None,
            span: None,
        }))
    }
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.key.is_empty() { f.write_str(&self.message) } else { write!(f, "{}: {}", self.key, self.message) }
    }
}

impl std::error::Error for Invalid {}

/// A problem inside an input file: where it is, what it is, what to write instead.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[error("{}", self.describe())]
pub struct InputError {
    /// The file at fault.
    pub path: PathBuf,
    /// Line of the offending key or record, counted from 1.
    pub line: Option<usize>,
    /// Dotted key, glTF path (`materials[2]`) or record name; empty where the whole file is at fault.
    pub key: String,
    /// What is wrong.
    pub message: String,
    /// What to write instead.
    #[help]
    pub help: Option<String>,
    /// The text of the file, for underlining.
    #[source_code]
    pub source_code: Option<NamedSource<String>>,
    /// The bytes to underline.
    #[label("here")]
    pub span: Option<SourceSpan>,
}

impl InputError {
    fn describe(&self) -> String {
        let mut text = self.path.display().to_string();
        if let Some(line) = self.line {
            text += &format!(":{line}");
        }
        if !self.key.is_empty() {
            text += &format!(": {}", self.key);
        }
        text + ": " + &self.message
    }
}

/// Everything that can go wrong for a reason outside the program.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum Error {
    /// A file says something that cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Input(Box<InputError>),
    /// The operating system refused to read or write.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was attempted, as a verb: "read", "create the folder".
        action: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A command line whose parts do not fit together.
    #[error("{message}")]
    Usage {
        /// What does not fit.
        message: String,
        /// What to type instead.
        #[help]
        help: Option<String>,
    },
}

impl Error {
    /// A problem with a file as a whole or with one named part of it.
    pub fn in_file(path: &Path, key: impl Into<String>, message: impl Into<String>) -> Self {
        Invalid::new(key, message).in_file(path)
    }

    /// A refused read or write.
    pub fn io(path: &Path, action: &'static str, source: std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), action, source }
    }
}
