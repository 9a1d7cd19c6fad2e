//! What is said on standard error: lines for people, or with `--log-json` an object per line for programs.
//!
//! Nobody may be listening: a log that is closed or full changes neither the work nor the exit status.

use std::fmt::{self, Write as _};
use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use photosite::Error;
use serde_json::{Map, Value, json};

static IS_JSON: AtomicBool = AtomicBool::new(false);

/// From now on lines are objects.
pub(super) fn speak_json() {
    IS_JSON.store(true, Ordering::Relaxed);
}

/// Whether lines are objects.
pub(super) fn is_json() -> bool {
    IS_JSON.load(Ordering::Relaxed)
}

/// Says a line that is for people; in a log for programs it is an event named `message`.
macro_rules! say {
    ($($words:tt)*) => {
        $crate::cli::log::message("message", format_args!($($words)*))
    };
}

/// Says a warning.
macro_rules! warning {
    ($($words:tt)*) => {
        $crate::cli::log::message("warning", format_args!($($words)*))
    };
}

pub(super) use {say, warning};

/// Says an event with its words.
pub(super) fn message(event: &str, words: fmt::Arguments<'_>) {
    if is_json() {
        return object(event, json!({ "message": words.to_string() }));
    }
    match event {
        "message" => line(&words.to_string()),
        kind => line(&format!("{kind}: {words}")),
    }
}

/// Says an event that is for programs alone.
pub(super) fn object(event: &str, what: Value) {
    let since = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or_else(|before| -before.duration().as_secs_f64(), |t| t.as_secs_f64());
    let mut object = Map::new();
    object.insert("time_s".to_owned(), json!((since * 1e3).round() / 1e3));
    object.insert("event".to_owned(), json!(event));
    if let Value::Object(what) = what {
        object.extend(what);
    }
    line(&Value::Object(object).to_string());
}

/// Says why the program fails.
pub(super) fn error(error: Error, status: u8) {
    if !is_json() {
        let mut text = String::new();
        // Only a formatter that fails by itself could fail here.
        let _ = write!(text, "{:?}", miette::Report::new(error));
        return line(&text);
    }
    let (path, place, key) = match &error {
        Error::Input(input) => (Some(input.path.display().to_string()), input.line, Some(input.key.clone())),
        Error::Io { path, .. } => (Some(path.display().to_string()), None, None),
        Error::Override { .. } | Error::Usage { .. } | Error::Temporary(_) | Error::Cancelled { .. } => {
            (None, None, None)
        }
    };
    let help = miette::Diagnostic::help(&error).map(|help| help.to_string());
    let message = error.to_string();
    object(
        "error",
        json!({ "message": message, "help": help, "file": path, "line": place, "key": key, "status": status }),
    );
}

fn line(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}
