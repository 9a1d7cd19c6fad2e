//! Commands that are given again: what is finished is left as it is, with status 0, and what is not the same is refused.

use std::fs;

use rstest::rstest;

use crate::folder::Folder;
use crate::room::room;

const FEW: &str = "[render]\nsamples_per_pixel = 2\n";

/// Command that makes a folder `out`, after the commands before it.
fn commands(what: &str) -> (&'static [&'static str], &'static str) {
    const PARTS: [&str; 2] =
        ["render capture.toml --samples 0..1 -o part0", "render capture.toml --samples 1..2 -o part1"];
    match what {
        "render" => (&[], "render capture.toml -o out"),
        "part" => (&[], "render capture.toml --samples 0..1 -o out"),
        _ => (&PARTS, "merge part0 part1 -o out"),
    }
}

fn made(what: &str) -> (Folder, &'static str) {
    let folder = room(FEW);
    let (before, command) = commands(what);
    before.iter().for_each(|command| drop(folder.succeed(command)));
    folder.succeed(command);
    (folder, command)
}

#[rstest]
fn what_is_finished_is_left_as_it_is(#[values("render", "part", "merge")] what: &str) {
    let (folder, command) = made(what);
    let before = folder.contents();
    let outcome = folder.succeed(command);
    assert!(
        outcome.text().contains("out already contains this render; --force renders it again"),
        "{}",
        outcome.stderr
    );
    assert!(before == folder.contents());
    let report = if what == "part" { "out/part.json" } else { "out/capture.json" };
    let printed = folder.succeed(&format!("{command} --json")).json();
    assert_eq!(printed, folder.json(report));
    folder.succeed(&format!("{command} --force"));
}

#[rstest]
fn what_has_lost_a_file_is_made_again(#[values("render", "part", "merge")] what: &str) {
    let (folder, command) = made(what);
    let lost = if what == "part" { "out/film.npy.gz" } else { "out/raw.dng" };
    let whole = folder.bytes(lost);
    fs::remove_file(folder.path(lost)).expect("removed");
    let outcome = folder.succeed(command);
    let name = lost.trim_start_matches("out/");
    assert!(outcome.text().contains(&format!("warning: out is made again: {name} is missing")), "{}", outcome.stderr);
    assert!(whole == folder.bytes(lost));
}

/// Each decides what the image is: keys, and files that the capture, its scene and its materials name.
#[rstest]
#[case::another_seed("render capture.toml --seed 3 -o out", "")]
#[case::another_key("render capture.toml --set exposure.gain_db=6 -o out", "")]
#[case::another_part("render capture.toml --samples 1..2 -o out", "")]
#[case::the_capture("render capture.toml -o out", "capture.toml")]
#[case::geometry("render capture.toml -o out", "room.obj")]
#[case::a_material_library("render capture.toml -o out", "room.mtl")]
#[case::a_texture("render capture.toml -o out", "tiles.png")]
fn what_is_not_the_same_is_refused(#[case] command: &str, #[case] changed: &str) {
    let folder = room(FEW);
    folder.succeed("render capture.toml -o out");
    change(&folder, changed);
    if command.contains("--samples") {
        // A part leaves the image as it is: it has other files.
        folder.fail(command, 2, &["out contains the results of an earlier render"]);
        return;
    }
    folder.fail(command, 2, &["out contains the results of an earlier render", "--force"]);
}

/// A checkpoint is of the files as they were, too, whoever names them.
#[rstest]
fn a_checkpoint_of_other_files_is_refused(#[values("room.mtl", "tiles.png")] changed: &str) {
    let folder = room("[render]\nsamples_per_pixel = 64\n[output]\ncheckpoint_interval_s = 0.0001\n");
    assert!(folder.killed_at("pass-ended", 2, "render capture.toml -o out"));
    change(&folder, changed);
    folder.fail("render capture.toml -o out", 1, &["a file that the capture names has changed"]);
}

/// Something that changes the file and not its meaning is enough.
fn change(folder: &Folder, name: &str) {
    if name.is_empty() {
        return;
    }
    let path = folder.path(name);
    let mut bytes = fs::read(&path).unwrap_or_else(|_| panic!("{name} is there"));
    match name.rsplit('.').next() {
        Some("png") => {
            let image = image::load_from_memory(&bytes).expect("an image").adjust_contrast(10.0);
            image.save(&path).expect("written");
            return;
        }
        Some("toml") => {
            bytes =
                String::from_utf8(bytes).expect("text").replace("samples_per_pixel = 2", "samples_per_pixel = 3").into()
        }
        _ => bytes.extend(b"\n# changed\n"),
    }
    fs::write(path, bytes).expect("written");
}
