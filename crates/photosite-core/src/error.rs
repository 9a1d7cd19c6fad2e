//! Errors that a user or a file can cause, with a message that says how to put each right.
//!
//! Modules that never touch files report an [`Invalid`]: its key, the fault, and the remedy. The modules that read
//! files turn it into an [`Error`], which adds the file and the line.

use std::fmt;
use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::help::{Help, Remedy};
use crate::shorten::shorten;
use miette::{Diagnostic, NamedSource, SourceSpan};

/// The result of anything that a user or a file can make fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// A value that cannot be used, named by its key (`lens.f_number`), without knowledge of the file it came from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Invalid {
    /// Dotted path of the offending key; may be empty where no single key is at fault.
    pub key: String,
    /// Message: the fault and the value that was found.
    pub message: String,
    /// Remedy: a value to write instead, or something else to do.
    pub help: Option<Help>,
}

impl Invalid {
    /// An invalid value at `key`.
    pub fn new(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { key: key.into(), message: shorten(message.into()), help: None }
    }

    /// Adds a remedy, in place of any before.
    #[must_use]
    pub fn help(mut self, help: impl Into<Help>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds an alternative to the remedy.
    #[must_use]
    pub fn or(mut self, remedy: Remedy) -> Self {
        self.help = Some(match self.help {
            Some(help) => help.or(remedy),
            None => remedy.into(),
        });
        self
    }

    /// Places the key inside a table: `within("lens")` turns `f_number` into `lens.f_number`.
    #[must_use]
    pub fn within(mut self, table: &str) -> Self {
        // Elements of lists need no dot.
        let dot = if self.key.is_empty() || self.key.starts_with('[') { "" } else { "." };
        self.key = format!("{table}{dot}{}", self.key);
        self
    }

    /// The error of a file whose lines are not known (a binary file, or one already parsed).
    pub fn in_file(self, path: &Path) -> Error {
        self.placed(path, None)
    }

    /// The error of a line of a text file, counted from 1.
    pub fn at_line(self, path: &Path, line: usize) -> Error {
        self.placed(path, Some(line))
    }

    /// The error of a range of bytes of a text file, whose line is found and shown.
    pub fn in_text(self, path: &Path, text: &str, span: Range<usize>) -> Error {
        let Range { start, end } = span;
        let mut error = self.input_error(path, Some(text[..start].matches('\n').count() + 1));
        if is_readable(text, start) {
            // A value of many lines is shown by its first.
            let end = text[start..end].find('\n').map_or(end, |newline| start + newline);
            error.source_code = Some(NamedSource::new(path.display().to_string(), text.to_owned()));
            error.span = Some((start..end).into());
        }
        Error::Input(Box::new(error))
    }

    /// The error of an override of a key, `key=value`, which is shortened as in all messages.
    pub fn in_override(self, argument: &str) -> Error {
        let error = self.input_error(argument.as_ref(), None);
        Error::Input(Box::new(InputError { is_override: true, ..error }))
    }

    fn placed(self, path: &Path, line: Option<usize>) -> Error {
        Error::Input(Box::new(self.input_error(path, line)))
    }

    fn input_error(self, path: &Path, line: Option<usize>) -> InputError {
        let Self { key, message, help } = self;
        InputError {
            path: path.to_owned(),
            line,
            key: shorten(key),
            message: shorten(message),
            help,
            source_code: None,
            is_override: false,
            span: None,
        }
    }
}

/// Whether the line around a byte and its neighbours are short enough to show: documents written by programs may
/// consist of a single line of megabytes.
fn is_readable(text: &str, at: usize) -> bool {
    const LONGEST_LINE: usize = 240;
    let (before, after) = text.split_at(at);
    before.rsplit('\n').take(2).chain(after.split('\n').take(2)).all(|part| part.len() <= LONGEST_LINE)
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.key.is_empty() { f.write_str(&self.message) } else { write!(f, "{}: {}", self.key, self.message) }
    }
}

impl std::error::Error for Invalid {}

/// A fault in an input file: place, message and remedy.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[error("{}", self.describe())]
pub struct InputError {
    /// File at fault.
    pub path: PathBuf,
    /// Line of the offending key or record, counted from 1.
    pub line: Option<usize>,
    /// Dotted key, glTF path (`materials[2]`) or record name; empty where the whole file is at fault.
    pub key: String,
    /// Message: the fault and the value that was found.
    pub message: String,
    /// Remedy: a value to write instead, or something else to do.
    #[help]
    pub help: Option<Help>,
    /// Text of the file, to underline the fault in.
    #[source_code]
    pub source_code: Option<NamedSource<String>>,
    /// Whether an override of a key, `key=value`, is at fault; `path` then holds the override instead of a file.
    pub is_override: bool,
    /// Bytes to underline.
    #[label("here")]
    pub span: Option<SourceSpan>,
}

impl InputError {
    fn describe(&self) -> String {
        let override_of = if self.is_override { "override " } else { "" };
        let mut text = shorten(format!("{override_of}{}", self.path.display()));
        if let Some(line) = self.line {
            text += &format!(":{line}");
        }
        if !self.key.is_empty() {
            text += &format!(": {}", self.key);
        }
        text + ": " + &self.message
    }
}

/// An error with a cause outside the program.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum Error {
    /// An input file, or an override of a key, with an unusable value.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Input(Box<InputError>),
    /// The operating system refused to read or write.
    #[error("{}: cannot {action}: {reason}", shorten(path.display().to_string()))]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Attempted action, as a verb: "read", "create the folder".
        action: &'static str,
        /// The system's reason. It is part of the message, hence there is no `source` besides.
        reason: std::io::Error,
    },
    /// A malformed override of a key, `key=value`.
    #[error("override {argument}: {message}")]
    Override {
        /// The override, shortened as in all messages.
        argument: String,
        /// Message: the fault of the override.
        message: String,
        /// Remedy.
        #[help]
        help: Option<Help>,
    },
    /// A request whose parts do not fit together.
    #[error("{message}")]
    Usage {
        /// Message: the parts that do not fit together.
        message: String,
        /// Remedy: a request that works.
        #[help]
        help: Option<Help>,
    },
    /// Threads or memory that the machine lacks for the work.
    #[error("{message}")]
    Resources {
        /// Message: the missing resource.
        message: String,
        /// Remedy.
        #[help]
        help: Option<Help>,
    },
    /// An error that another try may cure: a folder that another process fills, a file that was there and is gone.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Temporary(Box<Error>),
    /// Work that stopped because it was asked to.
    #[error("{message}")]
    Cancelled {
        /// Message: the source of the request to stop.
        message: String,
        /// Remedy: the way to resume.
        #[help]
        help: Option<Help>,
    },
}

impl Error {
    /// A fault of a file as a whole, or of one named part of it.
    pub fn in_file(path: &Path, key: impl Into<String>, message: impl Into<String>) -> Self {
        Invalid::new(key, message).in_file(path)
    }

    /// A refused read or write.
    pub fn io(path: &Path, action: &'static str, reason: std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), action, reason }
    }

    /// Marks the error as one that another try may cure.
    #[must_use]
    pub fn temporary(self) -> Self {
        if self.is_temporary() { self } else { Self::Temporary(Box::new(self)) }
    }

    /// Error of work that has begun: a missing file is temporary, because it was there when the work began.
    #[must_use]
    pub fn since_begun(self) -> Self {
        let is_gone = matches!(&self, Self::Io { reason, .. } if reason.kind() == ErrorKind::NotFound);
        if is_gone { self.temporary() } else { self }
    }

    /// The error in the words of a front end, which has its own names for remedies and for an override of a key.
    #[must_use]
    pub fn in_words(self, remedy: &dyn Fn(&Remedy) -> String, override_of: &str) -> Self {
        let words = |help: Option<Help>| help.map(|help| Help::from(help.in_words(remedy)));
        match self {
            Self::Input(mut error) => {
                error.help = words(error.help.take());
                if std::mem::take(&mut error.is_override) {
                    error.path = format!("{override_of} {}", error.path.display()).into();
                }
                Self::Input(error)
            }
            Self::Override { argument, message, help } => {
                Self::Usage { message: format!("{override_of} {argument}: {message}"), help: words(help) }
            }
            Self::Usage { message, help } => Self::Usage { message, help: words(help) },
            Self::Resources { message, help } => Self::Resources { message, help: words(help) },
            Self::Temporary(error) => Self::Temporary(Box::new(error.in_words(remedy, override_of))),
            Self::Cancelled { message, help } => Self::Cancelled { message, help: words(help) },
            error @ Self::Io { .. } => error,
        }
    }

    /// Whether another try, later or on another machine, may cure the error.
    pub fn is_temporary(&self) -> bool {
        match self {
            Self::Temporary(_) => true,
            Self::Io { reason, .. } => may_pass(reason),
            Self::Input(_)
            | Self::Override { .. }
            | Self::Usage { .. }
            | Self::Resources { .. }
            | Self::Cancelled { .. } => false,
        }
    }
}

/// Whether the operating system's reason may have passed by the next try: disks get space, servers come back.
fn may_pass(reason: &std::io::Error) -> bool {
    /// `EIO`, "Input/output error" of a disk or of a lost server; `std` has no kind for it.
    const EIO: i32 = 5;
    matches!(
        reason.kind(),
        ErrorKind::StorageFull
            | ErrorKind::QuotaExceeded
            | ErrorKind::StaleNetworkFileHandle
            | ErrorKind::ResourceBusy
            | ErrorKind::TimedOut
            | ErrorKind::NetworkDown
            | ErrorKind::NetworkUnreachable
            | ErrorKind::HostUnreachable
            | ErrorKind::NotConnected
    ) || cfg!(unix) && reason.raw_os_error() == Some(EIO)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Error numbers are those of Linux, errno(3).
    #[cfg(target_os = "linux")]
    #[test]
    fn another_try_may_cure_full_disks_and_lost_servers_but_no_missing_or_forbidden_file() {
        let of = |number| Error::io(Path::new("raw.dng"), "write", std::io::Error::from_raw_os_error(number));
        // ENOSPC, EDQUOT, ESTALE, EIO, ETIMEDOUT, EBUSY.
        for number in [28, 122, 116, 5, 110, 16] {
            assert!(of(number).is_temporary(), "{}", of(number));
        }
        // ENOENT, EACCES, EROFS, EISDIR.
        for number in [2, 13, 30, 21] {
            assert!(!of(number).is_temporary(), "{}", of(number));
        }
        assert!(of(2).since_begun().is_temporary() && !of(13).since_begun().is_temporary());
        assert_eq!(of(2).since_begun().to_string(), of(2).to_string());
    }
}
