//! Renders under way: the preview, and what is left of one that is killed.

use std::fs;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::room::room;
use crate::same_bytes::timeless;

#[test]
fn a_preview_is_there_while_a_render_runs() {
    let folder =
        room("[render]\nsamples_per_pixel = 4_000_000_000\ntime_limit_s = 0.6\n[output]\npreview_interval_s = 0.01");
    let mut render = folder.command("render capture.toml --quiet -o out").spawn().expect("the binary runs");
    let mut seen = 0;
    let status = loop {
        if let Some(status) = render.try_wait().expect("a child") {
            break status;
        }
        if let Ok(bytes) = fs::read(folder.path("out/preview.png")) {
            // Whole whenever it is there.
            let picture = image::load_from_memory(&bytes).expect("a picture");
            assert_eq!((picture.width(), picture.height()), (32, 24));
            assert!(!folder.path("out/capture.json").exists(), "it is not finished");
            seen += 1;
        }
        sleep(Duration::from_millis(5));
    };
    assert!(status.success() && seen > 0, "seen {seen} times");
    let files: Vec<String> = folder.results("out").into_keys().collect();
    assert_eq!(files, ["capture.json", "electrons.exr", "image.png", "raw.dng"]);
}

/// Killed at any moment: every file that is there is whole, and `capture.json` is there only if all are.
#[test]
fn a_killed_render_leaves_no_half_written_file() {
    let folder = room(
        "[render]\nsamples_per_pixel = 1\n[output]\nraw = ['dng', 'tiff', 'npy']\nirradiance = true\npreview_interval_s = 0.001",
    );
    let arguments = "render capture.toml --quiet --set sensor.resolution_px=[200,150] -o";
    let start = Instant::now();
    folder.succeed(&format!("{arguments} whole"));
    let duration = start.elapsed();
    let whole = folder.results("whole");
    let mut killed = 0;
    for step in 0..12 {
        let name = format!("killed-{step}");
        let mut render = folder.command(&format!("{arguments} {name}")).spawn().expect("the binary runs");
        sleep(duration * step / 10);
        render.kill().expect("still ours");
        killed += u32::from(!render.wait().expect("ended").success());
        let Ok(entries) = fs::read_dir(folder.path(&name)) else { continue };
        let names = entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
        let names: Vec<String> = names.filter(|name| !name.starts_with('.') && name != "preview.png").collect();
        for file in names.iter().filter(|file| *file != "capture.json") {
            assert!(folder.results(&name)[file] == whole[file], "{file} is not whole after {step}");
        }
        if names.iter().any(|file| file == "capture.json") {
            assert_eq!(names.len(), whole.len(), "{names:?}");
            assert_eq!(timeless(folder.report(&name)), timeless(folder.report("whole")));
        } else {
            // Another try fills the folder.
            folder.succeed(&format!("{arguments} {name} --force"));
            assert_eq!(timeless(folder.report(&name)), timeless(folder.report("whole")));
            assert!(!folder.path(&name).join("preview.png").exists());
        }
    }
    assert!(killed > 2, "only {killed} were still running");
}
