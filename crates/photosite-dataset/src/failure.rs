//! Failures: why an image could not be made, kept as `.NUMBER.failed` in place of its folder until it is made.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use miette::Diagnostic;
use photosite_core::input;
use serde::{Deserialize, Serialize};

use super::heartbeat::host;
use photosite_core::Error;
use photosite_core::output::write_whole;
use photosite_files::pretty_json::pretty_json;

/// Error that kept an image from being made, with the machine and the time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// Message of the error.
    pub message: String,
    /// Advice of the error.
    pub help: Option<String>,
    /// Whether another try may succeed.
    pub temporary: bool,
    /// Machine of the attempt.
    pub host: String,
    /// Process number on that machine.
    pub process: u32,
    /// Time of the failure by the clock of that machine, in seconds since 1970.
    pub time_s: f64,
}

impl Failure {
    /// Failure of an attempt that this process has just made.
    pub(super) fn of(error: &Error) -> Self {
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self {
            message: error.to_string(),
            help: error.help().map(|help| help.to_string()),
            temporary: error.is_temporary(),
            host: host().to_owned(),
            process: std::process::id(),
            time_s: (since_1970.as_secs_f64() * 1e3).round() / 1e3,
        }
    }

    /// Writes the failure to `path`. An error of writing is ignored: the failure was reported already, and nothing else
    /// depends on the file.
    pub(super) fn write(&self, path: &Path) {
        let _ = write_whole(path, |to| writeln!(to, "{}", pretty_json(self)));
    }

    /// Reads the failure at `path`; `None` where there is none.
    pub(super) fn read(path: &Path) -> Option<Self> {
        let unreadable = |reason: String| Self {
            message: format!("it could not be made, and why cannot be read: {reason}"),
            help: None,
            temporary: true,
            host: "unknown".to_owned(),
            process: 0,
            time_s: 0.0,
        };
        match input::read_text(path, input::TABLE_BYTES) {
            Ok(text) => Some(serde_json::from_str(&text).unwrap_or_else(|e| unreadable(e.to_string()))),
            Err(reason) if reason.kind() == ErrorKind::NotFound => None,
            Err(reason) => Some(unreadable(reason.to_string())),
        }
    }
}

/// Removes the failure once its image was made. A file that stays is ignored where the image is there.
pub(super) fn forget(path: &Path) {
    let _ = fs::remove_file(path);
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::Invalid;

    #[test]
    fn failures_are_read_as_they_were_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(".000007.failed");
        assert_eq!(Failure::read(&path), None);
        let error = Invalid::new("exposure.gain_db", "60 dB is too much").help("write 24").in_file("set.toml".as_ref());
        let failure = Failure::of(&error);
        failure.write(&path);
        assert_eq!(Failure::read(&path), Some(failure.clone()));
        assert_eq!(failure.message, "set.toml: exposure.gain_db: 60 dB is too much");
        assert_eq!((failure.help.as_deref(), failure.temporary), (Some("write 24"), false));
        assert!(Failure::of(&error.temporary()).temporary);
        forget(&path);
        assert_eq!(Failure::read(&path), None);
        std::fs::write(&path, "{").expect("written");
        assert!(Failure::read(&path).is_some_and(|failure| failure.message.contains("cannot be read")));
    }
}
