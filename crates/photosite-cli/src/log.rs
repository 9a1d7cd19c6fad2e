//! Messages on standard error: lines for people, or with `--log-json` one object per line for programs.
//!
//! A log that is closed or full changes neither the work nor the exit status.

use std::fmt;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Map, Value, json};

static IS_JSON: AtomicBool = AtomicBool::new(false);

/// Switches messages from lines to JSON objects.
pub(super) fn speak_json() {
    IS_JSON.store(true, Ordering::Relaxed);
    photosite_simd::Heap::set_message(
        r#"{"event":"error","status":1,"message":"out of memory: "#,
        " bytes could not be allocated\"}\n",
    );
}

/// Whether messages are JSON objects.
pub(super) fn is_json() -> bool {
    IS_JSON.load(Ordering::Relaxed)
}

/// Prints a line for people; in a log for programs it is an event named `message`.
macro_rules! say {
    ($($words:tt)*) => {
        $crate::log::message("message", format_args!($($words)*))
    };
}

/// Prints a warning.
macro_rules! warning {
    ($($words:tt)*) => {
        $crate::log::message("warning", format_args!($($words)*))
    };
}

pub(super) use {say, warning};

use photosite_core::Error;

/// Prints an event in words.
pub(super) fn message(event: &str, words: fmt::Arguments<'_>) {
    if is_json() {
        return object(event, json!({ "message": words.to_string() }));
    }
    match event {
        "message" => line(&words.to_string()),
        kind => line(&format!("{kind}: {words}")),
    }
}

/// Prints an event that is for programs alone.
pub(super) fn object(event: &str, what: Value) {
    let since = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or_else(|before| -before.duration().as_secs_f64(), |t| t.as_secs_f64());
    let time_s = json!((since * 1e3).round() / 1e3);
    let mut object = Map::from_iter([("time_s".to_owned(), time_s), ("event".to_owned(), json!(event))]);
    if let Value::Object(what) = what {
        object.extend(what);
    }
    line(&Value::Object(object).to_string());
}

/// Prints why the program fails.
pub(super) fn error(error: Error, status: u8) {
    if !is_json() {
        return line(&format!("{:?}", miette::Report::new(error)));
    }
    let (file, place, key) = place(&error);
    let help = miette::Diagnostic::help(&error).map(|help| help.to_string());
    let message = error.to_string();
    object(
        "error",
        json!({ "message": message, "help": help, "file": file, "line": place, "key": key, "status": status }),
    );
}

/// File, line and key at which an error occurred.
fn place(error: &Error) -> (Option<String>, Option<usize>, Option<&str>) {
    match error {
        Error::Input(input) => (Some(input.path.display().to_string()), input.line, Some(&input.key)),
        Error::Io { path, .. } => (Some(path.display().to_string()), None, None),
        Error::Temporary(error) => place(error),
        Error::Override { .. } | Error::Usage { .. } | Error::Resources { .. } | Error::Cancelled { .. } => {
            (None, None, None)
        }
    }
}

fn line(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}
