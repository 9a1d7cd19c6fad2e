//! Memory that there is not: refused beforehand with figures, and never waited for.

use std::io::Read;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rstest::rstest;

use crate::folder::Folder;
use crate::room::room;
use crate::same_bytes::assert_same;

/// Longer than any of these commands takes, were it not to wait for ever.
const LONGEST: Duration = Duration::from_secs(60);

/// A command under `ulimit -v` of so many kilobytes: its status, and what it says in one line.
fn limited(folder: &Folder, kilobytes: u32, backtrace: &str, arguments: &str) -> (Option<i32>, String) {
    let shell = format!("ulimit -v {kilobytes}; exec {} {arguments}", env!("CARGO_BIN_EXE_photosite"));
    let mut command = Command::new("sh");
    command.args(["-c", &shell]).current_dir(folder.path("")).env("RUST_BACKTRACE", backtrace);
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("sh");
    let begun = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child") {
            break status;
        }
        if begun.elapsed() > LONGEST {
            child.kill().expect("still ours");
            panic!("{arguments} does not end");
        }
        sleep(Duration::from_millis(10));
    };
    let mut text = String::new();
    child.stderr.take().expect("a pipe").read_to_string(&mut text).expect("UTF-8");
    (status.code(), text.split_whitespace().collect::<Vec<_>>().join(" "))
}

#[rstest]
fn a_sensor_that_does_not_fit_is_refused_with_figures(#[values("0", "1", "full")] backtrace: &str) {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    let arguments = "render capture.toml --set sensor.resolution_px=[4000,4000] -o out";
    let (status, text) = limited(&folder, 400_000, backtrace, arguments);
    assert_eq!(status, Some(1), "{text}");
    for words in ["sensor.resolution_px: an image of 4000 × 4000 pixels takes", "0.38 GiB of ulimit -v", "lower"] {
        assert!(text.contains(words), "{words:?} is missing in: {text}");
    }
    assert!(!folder.path("out/capture.json").exists());
}

/// Whatever it is that is too much then, it ends, and with words.
#[rstest]
fn no_limit_lets_a_command_hang_or_abort(
    #[values(45_000, 50_000, 52_000, 55_000, 60_000, 65_000, 70_000, 80_000, 90_000, 150_000)] kilobytes: u32,
) {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    let (status, text) = limited(&folder, kilobytes, "1", "render capture.toml --threads 8 --quiet -o out");
    let is_told = text.contains("memory") || text.contains("cannot start") || text.contains("cannot allocate");
    // The loader of the system may be what fails.
    assert!(matches!(status, Some(0 | 127)) || status == Some(1) && is_told, "{status:?}: {text}");
    assert!(!text.contains("panicked"), "{text}");
}

#[test]
fn what_is_allowed_is_kept_to() {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    let large = "render capture.toml --set sensor.resolution_px=[4000,4000] -o out";
    folder.fail(
        &format!("{large} --memory 0.1"),
        1,
        &["takes", "102 MiB of the limit that was set", "with --memory 0."],
    );
    for (value, wrong) in [
        ("0", "0 GiB is not an amount of memory"),
        ("-1", "-1 GiB is not an amount of memory"),
        ("inf", "inf GiB is not an amount of memory"),
    ] {
        folder.fail(&format!("render capture.toml -o out --memory {value}"), 2, &[wrong, "above 0"]);
    }
    folder.fail("render capture.toml -o out --memory much", 2, &["invalid value 'much' for '--memory <GIB>'"]);
}

/// 33 channels of 320 × 240 pixels take 78 MiB; what follows takes a few.
#[test]
fn a_film_that_does_not_fit_is_traced_in_strips_by_itself() {
    let folder = room("[render]\nsamples_per_pixel = 1\n[output]\nirradiance = true\npreview_interval_s = 0\n");
    let render = "render capture.toml --set sensor.resolution_px=[320,240] --quiet -o";
    folder.succeed(&format!("{render} whole"));
    folder.succeed(&format!("{render} strips --memory 0.08"));
    assert_same(&folder, "whole", "strips");
    let limits = [("noise_target=0.5", "render.noise_target"), ("time_limit_s=3", "render.time_limit_s")];
    for (setting, key) in limits {
        let arguments = format!("{render} out --memory 0.08 --set render.{setting}");
        folder.fail(&arguments, 1, &[key, "the film of the whole image takes", "--memory", "samples_per_pixel"]);
    }
}

#[test]
fn raw_files_and_stored_light_that_do_not_fit_are_refused() {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    folder.succeed("render capture.toml --set sensor.resolution_px=[640,480] --quiet -o out");
    let [width, height] = [3000usize, 3000];
    let header = format!("P5 {width} {height} 255\n").into_bytes();
    folder.add("large.pgm", [header, vec![7; width * height]].concat());
    for command in ["develop large.pgm -o p.png", "info large.pgm", "noise large.pgm", "compare large.pgm large.pgm"] {
        folder.fail(&format!("{command} --memory 0.03"), 1, &["large.pgm", "3000 × 3000", "MiB", "--memory"]);
    }
    folder.fail("expose out -o again --memory 0.015", 1, &["takes", "MiB", "--memory"]);
}

/// Light that lands in other rows waits for them: that of 16 samples of 320 pixels in 102 rows and in 48 above and below,
/// of four wavelengths of 20 bytes, is 77 MiB.
#[test]
fn light_on_its_way_through_a_prescription_counts() {
    let folder = room("[render]\nsamples_per_pixel = 16\n[output]\npreview_interval_s = 0\n");
    let render = "render capture.toml --set sensor.resolution_px=[320,240] --quiet";
    let glass = "--set lens.prescription=double-gauss --set lens.f_number=4";
    folder.succeed(&format!("{render} -o thin --memory 0.06"));
    folder.fail(&format!("{render} {glass} -o glass --memory 0.06"), 1, &["320 × 240", "takes", "MiB", "--memory"]);
    // So does one sample of them.
    folder.succeed(&format!("{render} {glass} -o glass --memory 0.06 --spp 1"));
}
