//! Signals that ask the program to end: what is done is kept, nothing half done is left, and the status tells of it.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rstest::rstest;

use crate::dataset::{files, folder as board};
use crate::folder::Folder;
use crate::room::room;
use crate::same_bytes::assert_same;

/// Every shell can.
pub(crate) fn send(signal: &str, process: u32) {
    let status = Command::new("sh").arg("-c").arg(format!("kill -{signal} {process}")).status();
    assert!(status.expect("a shell").success(), "cannot send {signal}");
}

/// Sends a signal once a file is there, and returns the status and what was said on standard error. What ends within a
/// second here may take somewhat longer on a busy machine; left alone it takes far longer.
fn interrupt(folder: &Folder, arguments: &str, signal: &str, once: &dyn Fn(&Folder) -> bool) -> (Option<i32>, String) {
    let mut process: Child =
        folder.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary runs");
    while !once(folder) {
        assert!(process.try_wait().expect("a child").is_none(), "it ended before it was interrupted");
        sleep(Duration::from_millis(1));
    }
    let start = Instant::now();
    send(signal, process.id());
    let output = process.wait_with_output().expect("it ends");
    println!("{signal} ended it after {:?}", start.elapsed());
    assert!(start.elapsed() < Duration::from_secs(15), "{:?}", start.elapsed());
    let text = String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
    (output.status.code(), text)
}

/// Far more light than anybody waits for.
const ENDLESS: &str = "--set render.samples_per_pixel=4000000000 --set output.preview_interval_s=0.01";

#[rstest]
#[case("TERM", 143, "SIGTERM")]
#[case("INT", 130, "SIGINT")]
#[case("HUP", 129, "SIGHUP")]
fn a_signal_ends_a_render_with_a_checkpoint(#[case] signal: &str, #[case] status: i32, #[case] name: &str) {
    let folder = room("");
    let arguments = format!("render capture.toml --quiet -o out {ENDLESS}");
    let begun = |folder: &Folder| folder.path("out/preview.png").exists();
    let (code, said) = interrupt(&folder, &arguments, signal, &begun);
    assert_eq!(code, Some(status), "{said}");
    let help = "run the same command again, and it continues from out/checkpoint.film";
    assert!(said.contains(&format!("stopped by {name}")) && said.contains(help), "{said}");
    // A minute has not passed, after which there would be one anyway; and the rest is gone.
    assert_eq!(folder.results("out").into_keys().collect::<Vec<_>>(), ["checkpoint.film"]);
}

/// Starts a render that goes on until it is interrupted, and waits until it traces.
fn begun(folder: &Folder) -> Child {
    let mut process = folder
        .command(&format!("render capture.toml --quiet -o out {ENDLESS}"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    while !folder.path("out/preview.png").exists() {
        assert!(process.try_wait().expect("a child").is_none(), "it ended before it was interrupted");
        sleep(Duration::from_millis(1));
    }
    process
}

/// Both come before the render has kept anything: it is held on until both are there. Which of two waiting signals the
/// system delivers first is not specified (POSIX, 2.4.1), so that the status is either's.
#[test]
fn a_second_signal_ends_a_render_at_once() {
    let folder = room("");
    let process = begun(&folder);
    for signal in ["STOP", "INT", "TERM", "CONT"] {
        send(signal, process.id());
    }
    let output = process.wait_with_output().expect("it ends");
    // No word of a checkpoint.
    assert!([Some(130), Some(143)].contains(&output.status.code()), "{output:?}");
    assert_eq!(output.stderr, b"", "{output:?}");
    assert!(!folder.path("out").exists(), "nothing is left behind");
}

/// As of a scheduler that signals all processes of a job, whose script passes the signal on.
#[test]
fn the_same_signal_twice_at_once_is_one() {
    let folder = room("");
    let process = begun(&folder);
    send("TERM", process.id());
    // By then it listens to the next.
    sleep(Duration::from_millis(20));
    // It may have ended.
    let _ = Command::new("kill").arg("-TERM").arg(process.id().to_string()).status();
    let output = process.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(143), "{output:?}");
    assert_eq!(folder.results("out").into_keys().collect::<Vec<_>>(), ["checkpoint.film"]);
}

/// Broken off again and again, after some part of the time that it takes when it is left alone.
#[rstest]
#[case::uniform("")]
#[case::by_noise("--set render.noise_target=0.1")]
#[case::of_lamps("--set render.light_paths=1")]
#[case::in_strips("--film-memory 0.004")]
#[case::part("--samples 3..90")]
fn what_was_broken_off_ends_with_the_bytes_of_one_that_was_not(#[case] settings: &str) {
    let folder = room("[render]\nsamples_per_pixel = 96\nseed = 7\n");
    let arguments = format!("render capture.toml --quiet --set sensor.resolution_px=[160,120] {settings} -o");
    let start = Instant::now();
    folder.succeed(&format!("{arguments} whole"));
    let alone = start.elapsed();
    // The signal may come when all is written.
    let is_done = || ["capture.json", "part.json"].iter().any(|name| folder.path("out").join(name).exists());
    let mut interrupted = 0;
    for attempt in 0..40 {
        let mut process = folder.command(&format!("{arguments} out")).spawn().expect("the binary runs");
        sleep(alone.mul_f64(0.3 + 0.1 * f64::from(attempt % 5)));
        send("TERM", process.id());
        let code = process.wait().expect("it ends").code();
        assert!(code == Some(0) || code == Some(143), "ended with {code:?}");
        if is_done() {
            break;
        }
        interrupted += 1;
    }
    println!("interrupted {interrupted} times");
    if is_done() {
        // The last signal may have come between the report and the end of the checkpoint, which goes after it.
        for name in ["checkpoint.film", "checkpoint.film.before"] {
            let _ = fs::remove_file(folder.path("out").join(name));
        }
    } else {
        folder.succeed(&format!("{arguments} out"));
    }
    assert!(interrupted > 0, "too quick to be interrupted");
    if settings.contains("samples") {
        assert!(folder.results("whole")["film.npy.gz"] == folder.results("out")["film.npy.gz"]);
    } else {
        assert_same(&folder, "whole", "out");
    }
}

#[test]
fn a_signal_ends_a_data_set_which_goes_on() {
    let folder = board("frames = 3\n");
    let arguments = "dataset set.toml --quiet --set render.samples_per_pixel=20000 -o";
    folder.succeed(&format!("{arguments} whole"));
    let begun = |folder: &Folder| folder.path("out/camera/000000").exists();
    // The second image takes as long as the first.
    let (code, said) = interrupt(&folder, &format!("{arguments} out"), "TERM", &begun);
    assert_eq!(code, Some(143), "{said}");
    assert!(!folder.path("out/camera/000002").exists(), "it stopped");
    folder.succeed(&format!("{arguments} out"));
    assert!(files(&folder, "whole") == files(&folder, "out"));
}

#[test]
fn without_checkpoints_nothing_is_left() {
    let folder = room("[output]\ncheckpoint_interval_s = 0\n");
    let before = folder.contents();
    let begun = |folder: &Folder| folder.path("out/preview.png").exists();
    let (code, said) = interrupt(&folder, &format!("render capture.toml -o out {ENDLESS}"), "TERM", &begun);
    assert_eq!(code, Some(143), "{said}");
    assert!(said.contains("nothing of it is kept"), "{said}");
    assert_eq!(folder.contents(), before);
}

#[test]
fn commands_without_checkpoints_leave_nothing() {
    let folder = Folder::new([]);
    let arguments = "emva1288 sony-imx249-mono --steps 1000 --spatial 1000 -o deep/sets --quiet";
    let begun = |folder: &Folder| folder.contents().keys().any(|path| path.extension().is_some_and(|e| e == "tiff"));
    let (code, said) = interrupt(&folder, arguments, "TERM", &begun);
    assert_eq!((code, &*said), (Some(143), ""));
    assert!(folder.contents().values().all(Option::is_none), "{:?}", folder.contents().keys());
    assert_eq!(fs::read_dir(folder.path("deep")).expect("a folder").count(), 0);
}

/// As under nohup, and of commands in the background of a script.
#[cfg(target_os = "linux")]
#[test]
fn signals_that_were_ignored_stay_so() {
    let folder = room("");
    let mut command = Command::new("sh");
    let binary = env!("CARGO_BIN_EXE_photosite");
    let script = format!("trap '' HUP INT; exec {binary} render capture.toml --quiet -o out {ENDLESS}");
    let mut process = command.current_dir(folder.path("")).arg("-c").arg(script).spawn().expect("a shell");
    while !folder.path("out/preview.png").exists() {
        assert!(process.try_wait().expect("a child").is_none());
        sleep(Duration::from_millis(1));
    }
    send("HUP", process.id());
    send("INT", process.id());
    sleep(Duration::from_millis(500));
    assert!(process.try_wait().expect("a child").is_none(), "it goes on");
    send("TERM", process.id());
    assert_eq!(process.wait().expect("it ends").code(), Some(143));
}
