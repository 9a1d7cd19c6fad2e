//! Data sets that many make and keep: shares of the frames, what is missing or damaged, frames that cannot be made,
//! what a data set will take.

use std::fs;
use std::io::{Seek, SeekFrom, Write};
use std::process::Command;

use rstest::rstest;
use serde_json::Value;

use crate::dataset::{files, folder, manifest};
use crate::folder::Folder;

const SIX: &str = "frames = 6\n[poses.random]\ntarget = 'board'\ndistance_m = [0.6, 0.9]\nmargin_px = 1\n";
/// A sensor whose amplifier gives at most 24 dB: the last two of four frames ask for more.
const HALF_BAD: &str = "frames = 4\n[[vary]]\nkey = 'exposure.gain_db'\nsweep = [0, 60]\n";

/// The last line of what `dataset --json` prints, which sums up.
pub(crate) fn last_line(text: &str) -> Value {
    serde_json::from_str(text.lines().last().expect("a line")).expect("JSON")
}

#[test]
fn lists_and_shards_of_frames_make_the_whole() {
    let folder = folder(SIX);
    folder.succeed("dataset set.toml -o whole");
    let made = |arguments: &str| last_line(&folder.succeed(&format!("dataset set.toml --json -o {arguments}")).stdout);
    assert_eq!(made("parts --frames 0..2,5")["made"], 3);
    assert_eq!(made("parts --shard 1/2")["made"], 2, "0, 2 and 4, of which the first is there");
    assert_eq!(made("parts --shard 2/2 --frames 2..6")["made"], 1, "3 and 5, of which the last is there");
    assert_eq!(made("parts --shard 1/1")["complete"], true);
    assert!(files(&folder, "whole") == files(&folder, "parts"));
}

/// As of an array of equal jobs, of which the last reach past the end.
#[rstest]
#[case::in_part("4..12", 2)]
#[case::wholly("6..12", 0)]
fn frames_past_the_end_are_left_out_with_a_warning(#[case] frames: &str, #[case] made: u64) {
    let folder = folder(SIX);
    let outcome = folder.succeed(&format!("dataset set.toml -o out --frames {frames}"));
    assert!(outcome.text().contains("warning: --frames names frames that do not exist: the data set has 6, 0..6"));
    assert!(outcome.stderr.contains(&format!("made {made} images")), "{}", outcome.stderr);
}

#[rstest]
#[case("--frames 4..2", "the first number must be below the second")]
#[case("--frames -1", "write frames, for example 0..4,9")]
#[case("--frames 1,,2", "write frames, for example 0..4,9")]
#[case("--shard 0/8", "workers are counted from 1: write 1/8 to 8/8")]
#[case("--shard 9/8", "workers are counted from 1: write 1/8 to 8/8")]
#[case("--shard 3", "for example 3/8")]
#[case("--dry-run --verify", "cannot be used with")]
#[case("--index-only --samples 0..1", "cannot be used with")]
fn what_is_no_share_is_refused(#[case] arguments: &str, #[case] message: &str) {
    folder(SIX).fail(&format!("dataset set.toml -o out {arguments}"), 2, &[message]);
}

#[test]
fn an_index_alone_tells_what_is_missing() {
    let folder = folder(SIX);
    let lacking = "out: lacks images of the frames 0,3..6";
    folder.fail("dataset set.toml -o out --index-only", 1, &["out: does not contain a data set"]);
    folder.succeed("dataset set.toml -o out --frames 1..3");
    fs::remove_file(folder.path("out/manifest.jsonl")).expect("removed");
    let outcome = folder.run("dataset set.toml -o out --index-only");
    assert_eq!(outcome.status, Some(1));
    assert!(outcome.text().contains(lacking), "{}", outcome.stderr);
    assert_eq!(manifest(&folder, "out").len(), 2);
    // Of those that are asked for none is missing.
    folder.succeed("dataset set.toml -o out --index-only --frames 1,2");
    folder.succeed("dataset set.toml -o out");
    let there = files(&folder, "out");
    folder.succeed("dataset set.toml -o out --index-only");
    assert!(there == files(&folder, "out"));
}

#[rstest]
fn an_image_that_lost_a_file_is_made_again(#[values("raw.dng", "capture.json")] lost: &str) {
    let folder = folder(SIX);
    folder.succeed("dataset set.toml -o out");
    let whole = files(&folder, "out");
    fs::remove_file(folder.path("out/camera/000004").join(lost)).expect("removed");
    let outcome = folder.succeed("dataset set.toml -o out");
    let text = outcome.text();
    let said = format!("warning: an image is made again: {lost} is missing (in 1 of 1 frames, such as camera/000004)");
    assert!(text.contains(&said), "{text}");
    assert!(text.contains("made 1 image; 6 of 6 are in"), "{text}");
    assert!(whole == files(&folder, "out"));
}

#[test]
fn a_file_that_was_cut_short_is_noticed_by_its_size() {
    let folder = folder(SIX);
    folder.succeed("dataset set.toml -o out");
    let whole = files(&folder, "out");
    let raw = fs::OpenOptions::new().write(true).open(folder.path("out/camera/000002/raw.dng")).expect("opened");
    raw.set_len(100).expect("cut");
    let outcome = folder.succeed("dataset set.toml -o out");
    let text = outcome.text();
    assert!(text.contains("an image is made again: raw.dng has 100 bytes instead of"), "{text}");
    assert!(text.contains("(in 1 of 1 frames, such as camera/000002)"), "{text}");
    assert!(whole == files(&folder, "out"));
}

/// One flipped bit, of which size and name tell nothing. Nobody but the manifest vouches for the report.
#[rstest]
fn a_flipped_bit_is_found_by_reading_every_file(#[values("raw.dng", "image.png", "capture.json")] name: &str) {
    let folder = folder(SIX);
    folder.succeed("dataset set.toml -o out");
    let whole = files(&folder, "out");
    let path = folder.path("out/camera/000002").join(name);
    let mut bytes = fs::read(&path).expect("read");
    // In the report, a digit of the position that is still one.
    let at = match name {
        "capture.json" => bytes.windows(13).position(|w| w == b"\"position_m\":").expect("a position"),
        _ => bytes.len() - 20,
    };
    let digit = (at..bytes.len()).find(|&i| name != "capture.json" || (b'2'..=b'8').contains(&bytes[i])).expect("one");
    bytes[digit] ^= 1;
    let mut file = fs::OpenOptions::new().write(true).open(&path).expect("opened");
    file.seek(SeekFrom::Start(digit as u64)).expect("there");
    file.write_all(&bytes[digit..=digit]).expect("written");
    drop(file);
    let damage = format!("warning: camera/000002 is damaged: {name} has a different checksum from when it was written");
    // Whoever looks at names and sizes notices nothing, and the damage does not become what is known of the file.
    folder.succeed("dataset set.toml -o out");
    for _ in 0..2 {
        let outcome = folder.run("dataset set.toml -o out --verify --index-only");
        assert_eq!(outcome.status, Some(1), "{}", outcome.stderr);
        assert!(outcome.text().contains(&damage), "{}", outcome.stderr);
        assert!(outcome.text().contains("out: has 1 damaged image"), "{}", outcome.stderr);
    }
    let outcome = folder.succeed("dataset set.toml -o out --verify");
    assert!(outcome.text().contains(&damage) && outcome.text().contains("made 1 image"), "{}", outcome.stderr);
    assert!(whole == files(&folder, "out"));
    folder.succeed("dataset set.toml -o out --verify --index-only");
}

/// By a program of other people.
#[test]
fn sums_of_the_manifest_are_those_of_sha256sum() {
    let folder = folder("frames = 1\n");
    folder.succeed("dataset set.toml -o out");
    let line = &manifest(&folder, "out")[0];
    let image = folder.path("out").join(line["folder"].as_str().expect("a name"));
    let sums = line["sums"].as_object().expect("sums");
    let there = fs::read_dir(&image).expect("a folder").count();
    assert_eq!(sums.len(), there, "every file has one");
    for (name, sum) in sums {
        let path = image.join(name);
        assert_eq!(sum["bytes"], fs::metadata(&path).expect("there").len());
        let output = Command::new("sha256sum").arg(&path).output().expect("coreutils are there");
        let said = String::from_utf8(output.stdout).expect("text");
        assert_eq!(sum["sha256"], said.split(' ').next().expect("a sum"), "{name}");
    }
}

#[test]
fn bad_frames_are_named_and_gone_past() {
    let folder = folder(HALF_BAD);
    folder.fail("dataset set.toml -o strict --quiet --frames 2..4", 1, &["in frame 2: exposure.gain_db: 40 dB"]);
    let outcome = folder.run("dataset set.toml -o out --keep-going --quiet");
    assert_eq!(outcome.status, Some(1));
    let text = outcome.text();
    for words in [
        "warning: frame 2 of camera is skipped: set.toml:3: vary[0]: in frame 2: exposure.gain_db: 40 dB",
        "warning: frame 3 of camera is skipped:",
        "out: lacks frames that could not be made: 2..4",
        "--frames 2..4",
    ] {
        assert!(text.contains(words), "{words:?} is missing in: {}", outcome.stderr);
    }
    let numbers: Vec<_> = manifest(&folder, "out").iter().map(|line| line["frame"].clone()).collect();
    assert_eq!(numbers, [0, 1]);
    folder.succeed("dataset set.toml -o out --keep-going --frames 0..2");
}

/// Poses are drawn before anything else: where none fits, no camera of the rig has one.
#[test]
fn frames_without_a_pose_are_gone_past() {
    let folder = folder("frames = 2\n[poses.random]\ntarget = 'board'\ndistance_m = [0.1, 0.2]\n");
    let outcome = folder.run("dataset set.toml -o out --keep-going");
    assert_eq!(outcome.status, Some(1));
    assert!(outcome.text().contains("warning: frame 1 is skipped: set.toml:"), "{}", outcome.stderr);
    assert!(outcome.text().contains("lacks frames that could not be made: 0..2"), "{}", outcome.stderr);
}

#[test]
fn a_dry_run_tells_what_the_rest_takes_and_makes_nothing() {
    let folder = folder(SIX);
    let tell = |folder: &Folder| folder.succeed("dataset set.toml -o out --dry-run --json").json();
    let before = tell(&folder);
    assert!(!folder.path("out").exists());
    folder.succeed("dataset set.toml -o out --frames 0..2");
    let there = files(&folder, "out");
    let after = tell(&folder);
    assert!(there == files(&folder, "out"));
    assert_eq!((&before["pictures"], &before["present"]), (&6.into(), &0.into()));
    assert_eq!((&after["pictures"], &after["present"]), (&6.into(), &2.into()));
    let number = |value: &Value| value.as_f64().expect("a number");
    assert!(number(&before["time_s"]) > 0.0 && number(&before["memory_bytes"]) > 1e6);
    // What is there is no guess: the disk that images take differs by how well their noise packs.
    let of_images = there.iter().filter(|(path, _)| path.components().count() == 3);
    let bytes: usize = of_images.map(|(_, bytes)| bytes.as_ref().map_or(0, Vec::len)).sum();
    let ratio = number(&before["disk_bytes"]) / (bytes as f64 / 2.0 * 6.0);
    assert!((0.8..1.25).contains(&ratio), "{ratio}");
    assert!((number(&after["disk_bytes"]) / number(&before["disk_bytes"]) - 4.0 / 6.0).abs() < 0.1);
    // A wrong key of the last frame is told before the first is made.
    folder.add("set.toml", format!("capture = 'board.toml'\n{HALF_BAD}"));
    folder.fail("dataset set.toml -o other --dry-run", 1, &["in frame 2: exposure.gain_db: 40 dB"]);
    let outcome = folder.run("dataset set.toml -o other --dry-run --keep-going");
    assert!(outcome.text().contains("frame 3 of camera is skipped"), "{}", outcome.stderr);
    assert!(outcome.text().contains("set.toml: frames cannot be made: 2..4"), "{}", outcome.stderr);
    assert_eq!(outcome.status, Some(1));
}
