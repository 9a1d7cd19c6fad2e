//! How far a data set is, as its folder tells it.

use std::fs;
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::Duration;

use rstest::rstest;
use serde_json::Value;

use crate::dataset::{files, folder as board};
use crate::folder::{Folder, Outcome};
use crate::signals::send;

const SIX: &str = "frames = 6\n[poses.random]\ntarget = 'board'\ndistance_m = [0.6, 0.9]\nmargin_px = 1\n";
/// Two frames can be made, of the two others the sensor's amplifier gives less gain than they ask for.
const HALF_BAD: &str = "frames = 4\n[[vary]]\nkey = 'exposure.gain_db'\nsweep = [0, 60]\n";
const SLOW: &str = "--set render.samples_per_pixel=400000 --set output.checkpoint_interval_s=0.05";

/// The lines of `status --json`: those of the images, and that of the whole.
fn told(outcome: &Outcome) -> (Vec<Value>, Value) {
    let mut lines: Vec<Value> =
        outcome.stdout.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect();
    let whole = lines.pop().expect("the whole");
    assert_eq!(whole["event"], "end", "{}", outcome.stderr);
    assert!(lines.iter().all(|line| line["event"] == "picture"));
    (lines, whole)
}

fn states(images: &[Value]) -> Vec<&str> {
    images.iter().map(|image| image["state"].as_str().expect("a state")).collect()
}

#[test]
fn it_tells_what_is_done_and_what_is_missing() {
    let folder = board(SIX);
    folder.succeed("dataset set.toml -o out --frames 1..3,4 --set exposure.gain_db=6");
    let before = files(&folder, "out");
    let outcome = folder.run("status out --json");
    assert_eq!(outcome.status, Some(3), "{outcome:?}");
    let (images, whole) = told(&outcome);
    assert_eq!(states(&images), ["missing", "done", "done", "missing", "done", "missing"]);
    assert_eq!((&images[1]["camera"], &images[1]["folder"]), (&"camera".into(), &"camera/000001".into()));
    assert_eq!((&whole["pictures"], &whole["done"], &whole["missing"]), (&6.into(), &3.into(), &3.into()));
    assert_eq!((&whole["to_make"], &whole["complete"]), (&"0,3,5".into(), &false.into()));
    assert_eq!(whole["command"], "photosite dataset FILE.toml -o out --set exposure.gain_db=6 --frames 0,3,5");
    let text = folder.run("status out");
    assert_eq!(text.status, Some(3));
    assert!(text.stdout.starts_with("out: 3 of 6 images done (6 frames, 1 camera), 3 missing\n"), "{text:?}");
    assert!(files(&folder, "out") == before, "nothing is changed");
    // What it says to run makes the rest.
    folder.succeed("dataset set.toml -o out --set exposure.gain_db=6 --frames 0,3,5");
    let outcome = folder.succeed("status out --json");
    assert_eq!(told(&outcome).1["complete"], true);
    assert_eq!(folder.succeed("status out").stdout, "out: 6 of 6 images done (6 frames, 1 camera)\n");
}

/// A folder's description is that of earlier versions, but for how many frames there are; a longer set says so anew.
#[test]
fn how_many_frames_there_are_is_no_part_of_what_they_are() {
    let folder = board(SIX);
    folder.succeed("dataset set.toml -o out --frames 0..2");
    let mut identity = folder.json("out/dataset.json");
    let keys = identity.as_object_mut().expect("an object");
    assert_eq!((keys.remove("frames"), keys.remove("cameras")), (Some(6.into()), Some(vec!["camera"].into())));
    folder.add("out/dataset.json", identity.to_string());
    // The manifest has it, too.
    assert_eq!(states(&told(&folder.run("status out --json")).0).len(), 6);
    fs::remove_file(folder.path("out/manifest.jsonl")).expect("removed");
    folder.fail("status out", 1, &["dataset.json: does not say how many frames there are", "--index-only"]);
    folder.add("set.toml", format!("capture = 'board.toml'\n{}", SIX.replacen('6', "8", 1)));
    folder.run("dataset set.toml -o out --index-only");
    assert_eq!(states(&told(&folder.run("status out --json")).0).len(), 8);
    assert_eq!(identity["fingerprint"], folder.json("out/dataset.json")["fingerprint"]);
}

#[test]
fn failures_are_told_with_their_messages_until_the_image_is_made() {
    let folder = board(HALF_BAD);
    folder.run("dataset set.toml -o out --keep-going --quiet");
    let outcome = folder.run("status out --json");
    assert_eq!(outcome.status, Some(1), "{outcome:?}");
    let (images, whole) = told(&outcome);
    assert_eq!(states(&images), ["done", "done", "failed", "failed"]);
    let message = images[2]["message"].as_str().expect("a message");
    assert!(message.contains("set.toml:3: vary[0]: in frame 2: exposure.gain_db: 40 dB"), "{message}");
    assert!(images[2]["host"].is_string() && images[2]["time_s"].as_f64().is_some_and(|time| time > 1e9));
    assert_eq!((&images[2]["temporary"], &whole["failed"]), (&false.into(), &2.into()));
    let text = folder.run("status out");
    assert!(text.stdout.contains("failed   camera/000002 on ") && text.stdout.contains("40 dB"), "{}", text.stdout);
    // As if it had been another machine's fault.
    let record = folder.path("out/camera/.000001.failed");
    fs::copy(folder.path("out/camera/.000002.failed"), &record).expect("copied");
    fs::remove_dir_all(folder.path("out/camera/000001")).expect("removed");
    assert_eq!(states(&told(&folder.run("status out --json")).0)[1], "failed");
    folder.succeed("dataset set.toml -o out --frames 0..2");
    assert!(!record.exists());
    assert_eq!(states(&told(&folder.run("status out --json")).0)[1], "done");
}

/// Without --keep-going, too, and of poses that cannot be had.
#[rstest]
#[case::first_to_fail(HALF_BAD, "--frames 1..4", 2, "failed")]
#[case::no_pose("frames = 2\n[poses.random]\ntarget = 'board'\ndistance_m = [0.1, 0.2]\n", "--keep-going", 0, "failed")]
fn every_failure_is_kept(#[case] set: &str, #[case] arguments: &str, #[case] frame: usize, #[case] state: &str) {
    let folder = board(set);
    assert_eq!(folder.run(&format!("dataset set.toml -o out --quiet {arguments}")).status, Some(1));
    let (images, _) = told(&folder.run("status out --json"));
    assert_eq!(states(&images)[frame], state);
}

#[test]
fn damage_is_told() {
    let folder = board(SIX);
    folder.succeed("dataset set.toml -o out");
    fs::remove_file(folder.path("out/camera/000004/raw.dng")).expect("removed");
    let outcome = folder.run("status out --json");
    assert_eq!(outcome.status, Some(1));
    let (images, whole) = told(&outcome);
    assert_eq!((&images[4]["state"], &images[4]["message"]), (&"damaged".into(), &"raw.dng is missing".into()));
    assert_eq!(whole["to_make"], "4");
    folder.succeed("dataset set.toml -o out --frames 4");
    folder.succeed("status out");
}

/// Starts the command, and waits until it makes an image.
fn begun(folder: &Folder, arguments: &str) -> Child {
    let mut command = folder.command(arguments);
    let mut process = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the binary runs");
    while !folder.path("out/camera/.000000.lock").exists() {
        assert!(process.try_wait().expect("a child").is_none(), "it ended early");
        sleep(Duration::from_millis(1));
    }
    sleep(Duration::from_millis(200));
    process
}

#[test]
fn who_is_at_work_is_told_until_it_is_killed() {
    let folder = board("frames = 2\n");
    let mut process = begun(&folder, &format!("dataset set.toml -o out {SLOW}"));
    let outcome = folder.run("status out --json");
    assert_eq!(outcome.status, Some(4), "{outcome:?}");
    let (images, whole) = told(&outcome);
    assert_eq!(states(&images), ["running", "missing"]);
    assert_eq!(images[0]["process"], process.id());
    assert!(images[0]["host"].as_str().is_some_and(|host| !host.is_empty()));
    for age in ["age_s", "silence_s"] {
        assert!(images[0][age].as_f64().is_some_and(|age| age < 60.0), "{}", images[0]);
    }
    assert_eq!((&whole["running"], &whole["to_make"]), (&1.into(), &"1".into()), "nobody else is to make it");
    // One that is held on lives.
    send("STOP", process.id());
    assert_eq!(folder.run("status out").status, Some(4));
    process.kill().expect("still ours");
    process.wait().expect("ended");
    let outcome = folder.run("status out --json");
    assert_eq!((outcome.status, states(&told(&outcome).0)), (Some(3), vec!["missing", "missing"]));
}

/// The writer writes to the lock every 5 s, however long an image takes.
#[test]
fn a_process_gives_signs_of_life() {
    let folder = board("frames = 1\n");
    let mut process =
        begun(&folder, &format!("dataset set.toml -o out {SLOW} --set render.samples_per_pixel=4000000000"));
    let lock = folder.path("out/camera/.000000.lock");
    let written = || fs::metadata(&lock).and_then(|file| file.modified()).expect("there");
    let first = written();
    let mut waited = 0;
    while written() == first {
        assert!(waited < 600, "no sign of life within a minute");
        waited += 1;
        sleep(Duration::from_millis(100));
    }
    process.kill().expect("still ours");
    process.wait().expect("ended");
}

/// On another machine, whose locks are not seen here: its signs of life count, by the clock of the file system.
#[test]
fn of_other_machines_the_last_sign_of_life_counts() {
    let folder = board("frames = 2\n");
    folder.succeed("dataset set.toml -o out --frames 1");
    let lock = folder.path("out/camera/.000000.lock");
    let state = |folder: &Folder| told(&folder.run("status out --json")).0[0]["state"].clone();
    fs::write(&lock, r#"{"host": "elsewhere", "process": 7}"#).expect("written");
    assert_eq!(state(&folder), "running");
    let earlier =
        |s: u64| fs::metadata(&lock).and_then(|file| file.modified()).expect("there") - Duration::from_secs(s);
    let file = fs::File::options().write(true).open(&lock).expect("opened");
    file.set_modified(earlier(45)).expect("set");
    assert_eq!(state(&folder), "missing");
}

/// A machine whose clock is an hour fast looks at the folder, and one whose clock is slow makes an image in it.
/// libfaketime lets programs see such clocks, while times of files stay those of the file system.
#[cfg(target_os = "linux")]
#[test]
fn clocks_of_machines_may_differ() {
    let library = ["x86_64-linux-gnu", "aarch64-linux-gnu"]
        .map(|machine| format!("/usr/lib/{machine}/faketime/libfaketime.so.1"))
        .into_iter()
        .find(|path| fs::exists(path).unwrap_or(false));
    let Some(library) = library else {
        println!("libfaketime is not installed: not tested");
        return;
    };
    let folder = board("frames = 2\n");
    let with_clock = |arguments: &str, hours: &str| {
        let mut command = folder.command(arguments);
        command.env("LD_PRELOAD", &library).env("FAKETIME", format!("{hours}h")).env("NO_FAKE_STAT", "1");
        command.env("FAKETIME_DONT_FAKE_MONOTONIC", "1");
        command
    };
    let log = fs::File::create(folder.path("log")).expect("made");
    let arguments = format!("--log-json dataset set.toml -o out {SLOW} --set render.samples_per_pixel=4000000000");
    let mut process = with_clock(&arguments, "-1").stderr(log).spawn().expect("the binary runs");
    let lock = folder.path("out/camera/.000000.lock");
    while !fs::read_to_string(&lock).is_ok_and(|text| text.contains("since_s")) {
        assert!(process.try_wait().expect("a child").is_none(), "it ended early");
        sleep(Duration::from_millis(1));
    }
    // Its clock is one that is slow, and that of the lock is not.
    let said = folder.text("log");
    let first: Value = serde_json::from_str(said.lines().next().expect("a line")).expect("JSON");
    let since: Value = serde_json::from_slice(&fs::read(&lock).expect("read")).expect("JSON");
    let apart_s = since["since_s"].as_f64().expect("a time") - first["time_s"].as_f64().expect("a time");
    assert!((3500.0..3700.0).contains(&apart_s), "{apart_s}");
    for hours in ["-1", "+0", "+1"] {
        let output = with_clock("status out --json", hours).output().expect("the binary runs");
        assert_eq!(output.status.code(), Some(4), "{output:?}");
        let line = String::from_utf8(output.stdout).expect("text");
        let image: Value = serde_json::from_str(line.lines().next().expect("a line")).expect("JSON");
        for age in ["age_s", "silence_s"] {
            assert!(image[age].as_f64().is_some_and(|age| age < 100.0), "{hours}: {image}");
        }
    }
    process.kill().expect("still ours");
    process.wait().expect("ended");
    // Without a lock that would tell, either.
    fs::write(&lock, r#"{"host": "elsewhere", "process": 7}"#).expect("written");
    let output = with_clock("status out", "+1").output().expect("the binary runs");
    assert_eq!(output.status.code(), Some(4), "{output:?}");
}

/// As for somebody who may only look: a file system that is mounted read-only.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_is_read_only_tells_what_it_can() {
    let folder = board("frames = 3\n");
    folder.succeed("dataset set.toml -o out --frames 1");
    fs::write(folder.path("out/camera/.000000.lock"), r#"{"host": "elsewhere", "process": 7}"#).expect("written");
    let binary = env!("CARGO_BIN_EXE_photosite");
    let script = format!(
        "mount --bind out out && mount -o remount,ro,bind out || exit 99\n\
         {binary} status out; echo status $?; {binary} dataset set.toml -o out --frames 2 --quiet; echo dataset $?"
    );
    let Some(output) = crate::exit_status::with_mounts(&folder, &script) else { return };
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("status 4") && said.contains("camera/000000 on elsewhere, process 7\n"), "{said}");
    assert!(said.contains("warning: nothing can be written to out/camera, so it is not known for how long"), "{said}");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("dataset 1") && errors.contains("Read-only file system"), "{said}{errors}");
}

/// Who makes images cannot say so, and what fails cannot be kept: the work and its status stay what they are.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_no_worse_for_it() {
    let folder = board(SIX);
    folder.succeed("dataset set.toml -o whole");
    fs::create_dir(folder.path("disk")).expect("made");
    let binary = env!("CARGO_BIN_EXE_photosite");
    let script = format!(
        "mount -t tmpfs -o size=1m none disk || exit 99\n\
         {binary} dataset set.toml -o disk/out --frames 0..2 --quiet || exit 98\n\
         cat /dev/zero > disk/filler\n\
         {binary} dataset set.toml -o disk/out --quiet; echo dataset $?; {binary} status disk/out; echo status $?\n\
         rm disk/filler; {binary} dataset set.toml -o disk/out --quiet; echo dataset $?\n\
         {binary} status disk/out; echo status $?; diff -r disk/out whole && echo the same"
    );
    let Some(output) = crate::exit_status::with_mounts(&folder, &script) else { return };
    let (said, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(errors.contains("No space left on device"), "{said}{errors}");
    let lines: Vec<&str> = said.lines().filter(|line| !line.starts_with(' ') && !line.starts_with("failed")).collect();
    assert_eq!(lines[0], "dataset 75", "{said}{errors}");
    assert!(said.contains("2 of 6 images done"), "{said}{errors}");
    assert_eq!(
        lines[lines.len() - 4..],
        ["dataset 0", "disk/out: 6 of 6 images done (6 frames, 1 camera)", "status 0", "the same"]
    );
}

#[test]
fn what_is_no_data_set_is_refused() {
    let folder = board(SIX);
    folder.fail("status none", 2, &["none does not contain a data set", "the one after its -o"]);
    folder.add("other/notes.txt", "mine");
    folder.fail("status other", 2, &["other does not contain a data set"]);
    folder.add("other/dataset.json", "{");
    folder.fail("status other", 1, &["other/dataset.json: is damaged"]);
}

/// Parts of images that `photosite merge` takes, whose folder knows its data set file.
#[test]
fn parts_are_told_with_their_command() {
    let folder = board(SIX);
    folder.succeed("dataset set.toml -o part --samples 0..1 --frames 0..2");
    let outcome = folder.run("status part --json");
    assert_eq!(outcome.status, Some(3));
    let command = told(&outcome).1["command"].as_str().expect("a command").to_owned();
    let set = fs::canonicalize(folder.path("set.toml")).expect("there");
    assert_eq!(command, format!("photosite dataset {} -o part --samples 0..1 --frames 2..6", set.display()));
    folder.succeed(command.strip_prefix("photosite ").expect("the program"));
    folder.succeed("status part");
}
