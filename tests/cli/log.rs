//! Messages on standard error, to which nobody need listen.

use std::fs::File;
use std::process::Command;

use rstest::rstest;
use serde_json::Value;

use crate::room::room;

/// A program whose log cannot be written ends as it would have.
#[cfg(target_os = "linux")]
#[rstest]
#[case::done("render capture.toml -o out", 0)]
#[case::with_a_warning("render capture.toml -o out --set render.light_paths=1 --set scene.environment=\"none\"", 0)]
#[case::failed("render nowhere.toml -o out", 1)]
#[case::wrong_usage("render capture.toml -o out --thread 1", 2)]
fn a_log_that_nobody_reads_changes_no_exit_status(#[case] arguments: &str, #[case] status: i32) {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    let full = File::options().write(true).open("/dev/full").expect("a full device");
    let ended = folder.command(arguments).stderr(full).status().expect("the binary runs");
    assert_eq!(ended.code(), Some(status), "a full log");
    let _ = std::fs::remove_dir_all(folder.path("out"));
    let script = format!("exec {} {arguments} 2>&-", env!("CARGO_BIN_EXE_photosite"));
    let ended = Command::new("sh").current_dir(folder.path("")).args(["-c", &script]).status().expect("a shell");
    assert_eq!(ended.code(), Some(status), "a closed log");
}

fn events(log: &str) -> Vec<Value> {
    let event = |line: &str| {
        let event: Value = serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"));
        assert!(event["time_s"].is_number() && event["event"].is_string(), "{line}");
        event
    };
    log.lines().map(event).collect()
}

#[test]
fn a_log_for_programs_has_an_object_per_line() {
    let folder = room("[render]\nsamples_per_pixel = 2\nlight_paths = 1\n[output]\ntruth = ['depth']\n");
    let arguments = "render capture.toml -o out --log-json --set scene.environment=\"none\"";
    let outcome = folder.succeed(arguments);
    let events = events(&outcome.stderr);
    let names: Vec<&str> = events.iter().filter_map(|event| event["event"].as_str()).collect();
    let of = |name: &str| names.iter().filter(|found| **found == name).count();
    assert_eq!([of("trace_begins"), of("trace_ends"), of("message")], [1, 1, 2], "{}", outcome.stderr);
    let begun = events.iter().find(|event| event["event"] == "trace_begins").expect("a beginning");
    assert_eq!(begun["paths"], 32 * 24 * 2);
    // Warnings are those of the report.
    let warnings: Vec<&Value> = events.iter().filter(|event| event["event"] == "warning").collect();
    let said: Vec<&str> = warnings.iter().filter_map(|event| event["message"].as_str()).collect();
    let stated = folder.report("out")["warnings"].clone();
    assert_eq!(serde_json::json!(said), stated);
}

#[test]
fn an_error_in_a_log_for_programs_names_file_line_key_and_status() {
    let folder = room("[render]\nsamples_per_pixle = 2\n");
    let output = folder.command("render capture.toml -o out --log-json").output().expect("the binary runs");
    let log = String::from_utf8(output.stderr).expect("UTF-8");
    let [error] = &events(&log)[..] else { panic!("{log}") };
    assert_eq!((&error["event"], &error["status"]), (&"error".into(), &1.into()));
    assert!(error["file"].as_str().is_some_and(|file| file.ends_with("capture.toml")), "{log}");
    assert!(error["line"].is_number() && error["key"].as_str().is_some_and(|key| key.contains("render")), "{log}");
    assert!(error["message"].as_str().is_some_and(|words| words.contains("samples_per_pixel")), "{log}");
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn counts_beyond_sense_are_answered_at_once() {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    folder.fail("render capture.toml -o out --threads 65535", 2, &["--threads 65535: at most", "would not be faster"]);
    let frames = "render capture.toml -o out --frames 100000000";
    folder.fail(frames, 1, &["frames", "must be at most 1000000, got 100000000", "a data set"]);
    assert!(!folder.path("out").exists());
}
