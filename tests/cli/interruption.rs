//! Renders under way: the preview, and what is left of one that is killed.

use std::fs;
use std::path::PathBuf;
use std::thread::sleep;
use std::time::Duration;

use rstest::rstest;

use crate::folder::Folder;
use crate::room::room;
use crate::same_bytes::{assert_same, timeless};

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
        // Asked before, since the render may end between two looks.
        let is_finished = folder.path("out/capture.json").exists();
        if let Ok(bytes) = fs::read(folder.path("out/preview.png")) {
            // Whole whenever it is there.
            let image = image::load_from_memory(&bytes).expect("an image");
            assert_eq!((image.width(), image.height()), (32, 24));
            assert!(!is_finished, "a preview of what is finished");
            seen += 1;
        }
        sleep(Duration::from_millis(5));
    };
    assert!(status.success() && seen > 0, "seen {seen} times");
    let files: Vec<String> = folder.results("out").into_keys().collect();
    assert_eq!(files, ["capture.json", "electrons.exr", "image.png", "raw.dng"]);
}

/// Whatever is traced, in one go or from a checkpoint on.
#[rstest]
#[case::uniform("samples_per_pixel = 3000")]
#[case::by_noise("samples_per_pixel = 3000\nnoise_target = 0.2")]
fn a_killed_render_goes_on_from_its_checkpoint(#[case] settings: &str) {
    let folder = room(&format!(
        "[render]\n{settings}\nseed = 7\n[output]\nirradiance = true\ncheckpoint_interval_s = 0.001\npreview_interval_s = 0\n"
    ));
    folder.succeed("render capture.toml -o whole");
    assert!(!folder.path("whole/checkpoint.film").exists(), "it is done");
    let checkpoint = folder.path("out/checkpoint.film");
    for _ in 0..2 {
        let before = fs::read(&checkpoint).ok();
        let mut render = folder.command("render capture.toml --quiet -o out").spawn().expect("the binary runs");
        while fs::read(&checkpoint).ok() == before {
            assert!(render.try_wait().expect("a child").is_none(), "it ended before it was killed");
            sleep(Duration::from_millis(1));
        }
        render.kill().expect("still ours");
        render.wait().expect("ended");
    }
    assert!(!folder.path("out/capture.json").exists(), "it is not finished");
    let other = ["out/checkpoint.film", "another render: the capture says something else", "add --force"];
    folder.fail("render capture.toml -o out --seed 5", 1, &other);
    folder.fail("render capture.toml -o out --samples 0..9 --set render.noise_target=1", 1, &["noise_target"]);

    let bytes = fs::read(&checkpoint).expect("a checkpoint");
    let _ = fs::remove_file(folder.path("out/checkpoint.film.before"));
    for length in [10, bytes.len() / 2, bytes.len() - 1] {
        fs::write(&checkpoint, &bytes[..length]).expect("written");
        folder.fail("render capture.toml -o out", 1, &["out/checkpoint.film", "damaged checkpoint", "remove it"]);
    }
    let mut nothing =
        "{\"elapsed_s\":1,\"has_pilot\":false,\"is_part\":false,\"samples\":[0,1],\"rows\":[0,1],\"provenance\":{}}\n"
            .to_owned();
    nothing += &format!("crc32 {:08x}\n", crc32fast::hash(nothing.as_bytes()));
    fs::write(&checkpoint, nothing).expect("written");
    folder.fail("render capture.toml -o out", 1, &["out/checkpoint.film", "another render"]);
    fs::write(&checkpoint, &bytes).expect("written");
    let outcome = folder.succeed("render capture.toml -o out");
    assert!(outcome.text().contains("continuing from out/checkpoint.film at"), "{outcome:?}");
    assert_same(&folder, "whole", "out");
}

/// Disks flip bits. No flipped bit passes for light: the one before is gone on from, or the checkpoint is refused.
#[test]
fn a_damaged_checkpoint_gives_way_to_the_one_before() {
    let folder =
        room("[render]\nsamples_per_pixel = 800\n[output]\ncheckpoint_interval_s = 0.001\npreview_interval_s = 0\n");
    folder.succeed("render capture.toml -o whole");
    // The fourth checkpoint has its name, and the third is the one before.
    assert!(folder.killed_at("file-named", 4, "render capture.toml --quiet -o killed"));
    let names = ["checkpoint.film", "checkpoint.film.before"];
    let [last, before] = names.map(|name| fs::read(folder.path("killed").join(name)).expect("a checkpoint"));
    let damage = |name: &str, bytes: &[u8], place: usize| {
        let mut damaged = bytes.to_vec();
        damaged[place] ^= 0x10;
        folder.add(&format!("out/{name}"), damaged);
    };
    for eighth in 0..8 {
        let place = |bytes: &[u8]| (bytes.len() - 1) * eighth / 7;
        let _ = fs::remove_dir_all(folder.path("out"));
        damage(names[0], &last, place(&last));
        damage(names[1], &before, place(&before));
        folder.fail("render capture.toml -o out", 1, &["out/checkpoint.film", "damaged checkpoint", "remove it"]);
        folder.add("out/checkpoint.film.before", before.clone());
        let outcome = folder.succeed("render capture.toml -o out");
        let said = outcome.text();
        assert!(said.contains("checkpoint.film: is a damaged checkpoint") && said.contains("the one before"), "{said}");
        assert!(said.contains("continuing from out/checkpoint.film.before at"), "{said}");
        assert_same(&folder, "whole", "out");
        assert_eq!(
            folder.results("out").keys().collect::<Vec<_>>(),
            folder.results("whole").keys().collect::<Vec<_>>()
        );
    }
}

/// Killed at every file that it writes, before and after that has its name: every file that is there is whole, and
/// `capture.json` is there only if all are.
#[rstest]
fn a_killed_render_leaves_no_half_written_file(#[values("file-written", "file-named")] point: &str) {
    let folder = room("[render]\nsamples_per_pixel = 1\n[output]\nraw = ['dng', 'tiff', 'npy']\nirradiance = true\n");
    let arguments = "render capture.toml --quiet -o";
    folder.succeed(&format!("{arguments} whole"));
    let whole = folder.results("whole");
    let mut killed = 0;
    while folder.killed_at(point, killed + 1, &format!("{arguments} killed-{killed}")) {
        let name = format!("killed-{killed}");
        killed += 1;
        let entries = fs::read_dir(folder.path(&name)).expect("a folder");
        let names = entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
        let names: Vec<String> = names.filter(|name| !name.starts_with('.')).collect();
        for file in names.iter().filter(|file| *file != "capture.json") {
            assert!(folder.results(&name)[file] == whole[file], "{file} is not whole after {killed}");
        }
        if names.iter().any(|file| file == "capture.json") {
            assert_eq!(names.len(), whole.len(), "{names:?}");
        } else {
            // Another try fills the folder.
            folder.succeed(&format!("{arguments} {name} --force"));
        }
        assert_eq!(timeless(folder.report(&name)), timeless(folder.report("whole")));
    }
    // Three raw files, electrons, irradiance, the image and the report.
    assert_eq!(killed as usize, whole.len());
}

/// Whatever it is that dies half-way through a file, the next one that writes there sweeps what it leaves.
#[rstest]
#[case::develop("develop raw.dng -o p.png --force")]
#[case::merge_hdr("merge-hdr raw-0000.dng raw-0001.dng -o h.exr --force")]
#[case::target("target chessboard -o t.svg --force")]
#[case::camera("camera capture.toml --format opencv -o camera.yaml --force")]
fn what_a_killed_command_was_writing_is_swept(#[case] arguments: &str) {
    let folder = room("bracket_ev = [0, -2]\n[render]\nsamples_per_pixel = 1\n[output]\nraw = ['dng']\n");
    folder.succeed("render capture.toml -o out");
    for (from, to) in [("0000", "raw-0000.dng"), ("0001", "raw-0001.dng"), ("0000", "raw.dng")] {
        folder.add(to, folder.bytes(&format!("out/raw-{from}.dng")));
    }
    let partial = |folder: &Folder| {
        let is_partial = |path: &&PathBuf| path.to_string_lossy().ends_with(".partial");
        folder.contents().keys().filter(is_partial).count()
    };
    assert!(folder.killed_at("file-written", 1, arguments));
    assert_eq!(partial(&folder), 1, "killed at a bad moment");
    folder.succeed(arguments);
    assert_eq!(partial(&folder), 0, "{:?}", folder.contents().keys());
}
