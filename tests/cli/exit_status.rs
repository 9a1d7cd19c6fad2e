//! The exit status by which schedulers know what another try may cure.

use std::fs;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use crate::dataset::{board_under_sky, folder as board, sky};
use crate::folder::Folder;
use crate::room::room;
use crate::signals::send;

const ANOTHER_TRY: Option<i32> = Some(75);

#[test]
fn the_help_tells_of_it() {
    let help = Folder::new([]).succeed("--help").stdout;
    for words in ["Exit status: 0 done", "2 wrong usage", "75 failed, but another try may succeed", "143"] {
        assert!(help.split_whitespace().collect::<Vec<_>>().join(" ").contains(words), "{words}: {help}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn standard_output_on_a_full_disk() {
    let folder = Folder::new([]);
    let full = fs::File::options().write(true).open("/dev/full").expect("a full device");
    let output = folder.command("sensors").stdout(full).stderr(Stdio::piped()).output().expect("the binary runs");
    assert_eq!(output.status.code(), ANOTHER_TRY, "{output:?}");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("standard output: cannot write: No space left on device"), "{text}");
}

/// Runs a script with a mount of its own, as who runs this, or else as a root of its own; `None` where nothing can be
/// mounted.
#[cfg(target_os = "linux")]
pub(crate) fn with_mounts(folder: &Folder, script: &str) -> Option<std::process::Output> {
    let run = |kind: &str| {
        let mut command = Command::new("unshare");
        command.current_dir(folder.path("")).args([kind, "sh", "-c", script]).output()
    };
    let can_mount = |output: &std::process::Output| output.status.code() == Some(0);
    let output = ["-m", "-Urm"].iter().filter_map(|kind| run(kind).ok()).find(can_mount);
    if output.is_none() {
        println!("nothing can be mounted here: not tested");
    }
    output
}

/// A disk of few kilobytes, which takes the checkpoint and some files but not all.
#[cfg(target_os = "linux")]
#[test]
fn results_on_a_full_disk() {
    let folder = room("[render]\nsamples_per_pixel = 1\n[output]\nraw = ['tiff', 'dng', 'npy']\nirradiance = true\n");
    fs::create_dir(folder.path("disk")).expect("made");
    let binary = env!("CARGO_BIN_EXE_photosite");
    let script = format!(
        "mount -t tmpfs -o size=16k none disk || exit 99\n\
         {binary} render capture.toml --quiet -o disk/out; echo $?; ls -A disk/out; echo again\n\
         mount -o remount,size=1m disk && {binary} render capture.toml --quiet -o disk/out; echo $?"
    );
    let Some(output) = with_mounts(&folder, &script) else { return };
    let (said, text) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let (first, again) = said.split_once("again\n").expect("two renders");
    let mut lines = first.lines();
    assert_eq!(lines.next(), Some("75"), "{said}{text}");
    // Where there is room, the same command is the other try.
    assert_eq!(again, "0\n", "{said}{text}");
    assert!(text.contains("disk/out/") && text.contains("No space left on device"), "{text}");
    assert!(lines.all(|name| name != "capture.json" && !name.starts_with('.')), "{said}");
}

/// The films of 32 × 24 pixels take 77 kB, the results half of that.
#[cfg(target_os = "linux")]
#[test]
fn a_checkpoint_for_which_the_disk_is_too_small_is_a_warning() {
    let folder =
        room("[render]\nsamples_per_pixel = 200\n[output]\ncheckpoint_interval_s = 0.001\npreview_interval_s = 0\n");
    fs::create_dir(folder.path("disk")).expect("made");
    let binary = env!("CARGO_BIN_EXE_photosite");
    let script = format!(
        "mount -t tmpfs -o size=64k none disk || exit 99\n\
         {binary} render capture.toml -o disk/out || exit 1; ls -A disk/out; {binary} render capture.toml -o whole"
    );
    let Some(output) = with_mounts(&folder, &script) else { return };
    let (said, text) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("capture.json") && !said.contains("checkpoint"), "{said}{text}");
    let warning = "disk/out/checkpoint.film: cannot write: No space left on device";
    assert_eq!(text.matches(warning).count(), 1, "{text}");
    assert!(text.contains("the render continues without it"), "{text}");
}

/// A process that is killed while it writes leaves a mark beside its files; what has none is somebody's.
#[test]
fn results_of_a_killed_process_are_written_anew() {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    folder.add("out/raw.dng", "half");
    folder.fail("render capture.toml --quiet -o out", 2, &["out already contains a file raw.dng"]);
    folder.add("out/.photosite.unfinished", "");
    folder.succeed("render capture.toml --quiet -o out");
    assert!(folder.raw("out/raw.dng").width > 0 && !folder.path("out/.photosite.unfinished").exists());
    folder.fail("render capture.toml --seed 2 --quiet -o out", 2, &["out contains the results of an earlier render"]);
}

#[test]
fn a_folder_that_vanished() {
    let folder = room("");
    let arguments = "render capture.toml --quiet -o out --set render.samples_per_pixel=4000000000 \
                     --set render.time_limit_s=1.5 --set output.preview_interval_s=0.01";
    let mut render = folder.command(arguments).stderr(Stdio::piped()).spawn().expect("the binary runs");
    while !folder.path("out/preview.png").exists() {
        assert!(render.try_wait().expect("a child").is_none(), "it ended early");
        sleep(Duration::from_millis(1));
    }
    // Out of its way at once, whatever it writes meanwhile.
    fs::rename(folder.path("out"), folder.path("elsewhere")).expect("renamed");
    let output = render.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), ANOTHER_TRY, "{output:?}");
    assert!(!folder.path("out").exists());
}

#[test]
fn an_input_that_vanished() {
    let folder = board("frames = 2\n");
    folder.add("board.toml", board_under_sky());
    folder.add("sky.hdr", sky(100));
    let command = "dataset set.toml -o out --quiet --jobs 1 --set render.samples_per_pixel=20000";
    let mut process = folder.command(command).stderr(Stdio::piped()).spawn().expect("the binary runs");
    while !folder.path("out/camera").exists() || fs::read_dir(folder.path("out/camera")).expect("a folder").count() < 2
    {
        assert!(process.try_wait().expect("a child").is_none(), "it ended early");
        sleep(Duration::from_millis(1));
    }
    // It has begun the first image.
    send("STOP", process.id());
    sleep(Duration::from_millis(50));
    fs::rename(folder.path("sky.hdr"), folder.path("elsewhere.hdr")).expect("renamed");
    send("CONT", process.id());
    let output = process.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), ANOTHER_TRY, "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("sky.hdr"), "{output:?}");
    // What never was there is no matter of trying again.
    folder.fail("dataset set.toml -o other", 1, &["sky.hdr"]);
}
