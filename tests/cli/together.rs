//! Several processes at once in one place: none loses a file of another, and none mixes its files with those of
//! another.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rstest::rstest;

use crate::dataset::{files, folder as board, manifest};
use crate::folder::Folder;
use crate::room::room;
use crate::same_bytes::assert_same;
use crate::shared_work::last_line;
use crate::signals::send;

/// An image that takes some seconds, with a checkpoint as soon as there is something to keep.
const SLOW: &str = "--set render.samples_per_pixel=20000 --set output.checkpoint_interval_s=0.001";
/// Message of a process that finds another one at work, with its status.
const BUSY: (i32, &str) = (75, "another process is writing here");

fn start(folder: &Folder, arguments: &str) -> Child {
    let mut command = folder.command(arguments);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary runs")
}

/// Waits for a file whose path ends so, below a folder.
fn wait_for(process: &mut Child, root: &Path, suffix: &str) -> PathBuf {
    fn find(folder: &Path, suffix: &str) -> Option<PathBuf> {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        entries.into_iter().find_map(|path| {
            if path.is_dir() { find(&path, suffix) } else { path.to_string_lossy().ends_with(suffix).then_some(path) }
        })
    }
    loop {
        if let Some(path) = find(root, suffix) {
            return path;
        }
        assert!(process.try_wait().expect("a child").is_none(), "it ended before there was {suffix}");
        sleep(Duration::from_millis(1));
    }
}

fn status(output: &Output) -> i32 {
    output.status.code().unwrap_or_else(|| panic!("{output:?}"))
}

fn end(process: Child) -> Output {
    process.wait_with_output().expect("it ends")
}

/// Both are started before either is waited for.
fn at_once(folder: &Folder, commands: &[String]) -> Vec<Output> {
    let started: Vec<Child> = commands.iter().map(|arguments| start(folder, arguments)).collect();
    started.into_iter().map(end).collect()
}

#[test]
fn an_image_that_another_process_makes_is_waited_for() {
    let folder = board("frames = 2\n");
    folder.succeed(&format!("dataset set.toml -o whole {SLOW}"));
    let mut first = start(&folder, &format!("dataset set.toml -o out --json {SLOW}"));
    let checkpoint = wait_for(&mut first, &folder.path("out"), "checkpoint.film");
    send("STOP", first.id());
    // It makes the other image, and then has nothing to do.
    let mut second = start(&folder, &format!("dataset set.toml -o out --json {SLOW}"));
    while !folder.path("out/camera/000001").exists() {
        assert!(second.try_wait().expect("a child").is_none(), "it ended early");
        sleep(Duration::from_millis(10));
    }
    sleep(Duration::from_millis(300));
    assert!(second.try_wait().expect("a child").is_none(), "it did not wait");
    assert!(checkpoint.exists(), "what a living process writes is left alone");
    send("CONT", first.id());
    for output in [end(first), end(second)] {
        assert_eq!(status(&output), 0, "{output:?}");
        let made = last_line(&String::from_utf8_lossy(&output.stdout));
        assert_eq!((&made["made"], &made["complete"]), (&1.into(), &true.into()));
    }
    assert!(files(&folder, "whole") == files(&folder, "out"));
}

#[test]
fn an_image_of_a_process_that_dies_is_gone_on_with_by_one_that_waits() {
    let folder = board("frames = 1\n");
    folder.succeed(&format!("dataset set.toml -o whole {SLOW}"));
    let mut first = start(&folder, &format!("dataset set.toml -o out {SLOW}"));
    wait_for(&mut first, &folder.path("out"), "checkpoint.film");
    send("STOP", first.id());
    let mut second = start(&folder, &format!("dataset set.toml -o out --json {SLOW}"));
    sleep(Duration::from_millis(200));
    assert!(second.try_wait().expect("a child").is_none(), "it did not wait");
    first.kill().expect("still ours");
    first.wait().expect("ended");
    let output = end(second);
    assert_eq!(status(&output), 0, "{output:?}");
    assert!(files(&folder, "whole") == files(&folder, "out"), "and nothing of the dead one is left");
}

/// Started together and ending together, again and again.
#[test]
fn many_processes_make_one_data_set() {
    let folder = board("frames = 24\n[poses.random]\ntarget = 'board'\ndistance_m = [0.6, 0.9]\nmargin_px = 1\n");
    folder.succeed("dataset set.toml -o whole");
    for round in 0..4 {
        let name = format!("out{round}");
        let command = format!("dataset set.toml -o {name} --json --threads 1");
        let outputs = at_once(&folder, &vec![command; 6]);
        let mut made = 0;
        for output in &outputs {
            assert_eq!(status(output), 0, "{output:?}");
            let said = last_line(&String::from_utf8_lossy(&output.stdout));
            assert_eq!(said["complete"], true, "{said}");
            made += said["made"].as_u64().expect("a number");
        }
        assert_eq!(made, 24, "each image is made once");
        assert_eq!(manifest(&folder, &name).len(), 24);
        assert!(files(&folder, "whole") == files(&folder, &name), "round {round}");
    }
}

/// The first is held on in the middle of its work.
#[rstest]
#[case::another_seed("render capture.toml --seed 2 -o out --force")]
#[case::the_same("render capture.toml --seed 1 -o out")]
#[case::of_stored_light("expose light -o out --force")]
#[case::merged("merge part -o out --force")]
#[case::exported("export-mitsuba capture.toml --approximate -o out --force")]
fn a_folder_that_another_process_fills_is_refused(#[case] other: &str) {
    let folder = room("[render]\nsamples_per_pixel = 3000\n[output]\ncheckpoint_interval_s = 0.001\n");
    folder.succeed("render capture.toml --seed 1 -o whole");
    if other.starts_with("expose") {
        folder.succeed("render capture.toml -o light --set render.samples_per_pixel=1");
    } else if other.starts_with("merge") {
        folder.succeed("render capture.toml -o part --samples 0..1 --set render.samples_per_pixel=1");
    }
    let mut first = start(&folder, "render capture.toml --seed 1 -o out");
    wait_for(&mut first, &folder.path("out"), "checkpoint.film");
    send("STOP", first.id());
    folder.fail(other, BUSY.0, &["out: ", BUSY.1, "wait until that one has ended"]);
    send("CONT", first.id());
    let output = end(first);
    assert_eq!(status(&output), 0, "{output:?}");
    assert_same(&folder, "whole", "out");
}

/// Whichever comes first: its files are there, all of them, and no other.
#[rstest]
#[case::render("render capture.toml --quiet --seed", "", &["capture.json"])]
#[case::forced("render capture.toml --quiet --force --seed", "", &["capture.json"])]
#[case::expose("expose light --quiet --seed", "", &["capture.json"])]
#[case::emva1288("emva1288 sony-imx249-mono --size 8x8 --steps 5 --spatial 3 --quiet --seed", "", &[])]
#[case::develop("develop light/raw.dng --quiet --set develop.exposure_ev=", ".png", &[])]
#[case::target("target chessboard --quiet --set square_mm=", ".obj", &[])]
#[case::layout("layout set --quiet --format", "", &[])]
fn of_two_that_make_the_same_one_wins(#[case] command: &str, #[case] kind: &str, #[case] timed: &[&str]) {
    let folder = room("[render]\nsamples_per_pixel = 8\n");
    let choices = if command.starts_with("layout") {
        folder.add("board.toml", crate::dataset::BOARD);
        folder.add("set.toml", "capture = 'board.toml'\nframes = 2\n");
        folder.succeed("dataset set.toml -o set --quiet");
        ["colmap", "kalibr"]
    } else {
        ["1", "2"]
    };
    folder.succeed("render capture.toml -o light --quiet");
    let blank = if command.ends_with('=') { "" } else { " " };
    let arguments = |choice: &str, name: &str| format!("{command}{blank}{choice} -o {name}{kind}");
    // What is there under a name, and beside it with another ending.
    let made = |name: &str| {
        let with_name = |(path, bytes): (PathBuf, Option<Vec<u8>>)| {
            let path = path.strip_prefix(folder.path("")).expect("inside").to_string_lossy().into_owned();
            let rest = path.strip_prefix(name)?;
            let is_timed = timed.iter().any(|timed| rest.ends_with(timed));
            (rest.is_empty() || rest.starts_with(['/', '.'])).then(|| (rest.to_owned(), bytes.filter(|_| !is_timed)))
        };
        folder.contents().into_iter().filter_map(with_name).collect::<Vec<_>>()
    };
    let whole = choices.map(|choice| {
        let name = format!("whole-{choice}");
        folder.succeed(&arguments(choice, &name));
        let rename = |(rest, bytes): (String, Option<Vec<u8>>)| {
            // The mesh names the file of its materials.
            let bytes = bytes.map(|bytes| match String::from_utf8(bytes) {
                Ok(text) => text.replace(&name, "NAME").into_bytes(),
                Err(binary) => binary.into_bytes(),
            });
            (rest, bytes)
        };
        made(&name).into_iter().map(rename).collect::<Vec<_>>()
    });
    assert!(whole[0] != whole[1], "they can be told apart");
    for round in 0..6 {
        let name = format!("out-{round}");
        let outputs = at_once(&folder, &choices.map(|choice| arguments(choice, &name)));
        let done: Vec<usize> = (0..2).filter(|&i| status(&outputs[i]) == 0).collect();
        assert!(!done.is_empty(), "{outputs:?}");
        for output in outputs.iter().filter(|output| status(output) != 0) {
            // One that comes when the other has finished finds its results, as ever.
            assert!([BUSY.0, 2].contains(&status(output)), "{output:?}");
        }
        let found: Vec<_> = made(&name)
            .into_iter()
            .map(|(rest, bytes)| {
                let bytes = bytes.map(|bytes| match String::from_utf8(bytes) {
                    Ok(text) => text.replace(&name, "NAME").into_bytes(),
                    Err(binary) => binary.into_bytes(),
                });
                (rest, bytes)
            })
            .collect();
        assert!(done.iter().any(|&i| found == whole[i]), "a mixture in round {round}");
        assert!(command.contains("--force") || done.len() == 1, "one was overwritten unasked in round {round}");
    }
    let hidden = folder
        .contents()
        .into_keys()
        .find(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.')));
    assert_eq!(hidden, None, "nothing is left behind");
}

/// Damage that cannot be known without locks is found out before a report vouches for it.
#[test]
fn a_render_whose_files_another_one_replaced_does_not_vouch_for_them() {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    // So many frames that there is time between the first and the report.
    let mut render = start(&folder, "render capture.toml -o out --frames 200 --quiet");
    let first = wait_for(&mut render, &folder.path("out"), "raw-0000.dng");
    fs::write(&first, "of another process").expect("written");
    let output = end(render);
    assert_eq!(status(&output), BUSY.0, "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("was replaced by another process"), "{output:?}");
    assert!(!folder.path("out/capture.json").exists());
}

/// A lock whose process was killed is free.
#[test]
fn a_killed_process_leaves_no_lock() {
    let folder = room("[render]\nsamples_per_pixel = 3000\n[output]\ncheckpoint_interval_s = 0.001\n");
    let mut render = start(&folder, "render capture.toml --seed 1 -o out");
    wait_for(&mut render, &folder.path("out"), "checkpoint.film");
    render.kill().expect("still ours");
    render.wait().expect("ended");
    fs::write(folder.path("out/.photosite-a1b2c3.partial"), "half a file").expect("written");
    let start = Instant::now();
    folder.succeed("render capture.toml --seed 1 -o out --quiet");
    println!("went on for {:?}", start.elapsed());
    let names: Vec<String> = folder.results("out").into_keys().collect();
    assert_eq!(names, ["capture.json", "electrons.exr", "image.png", "raw.dng"]);
}
