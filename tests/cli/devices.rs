//! Devices that trace light, expose and develop: those that there are, and what is said where there is none.

use crate::folder::Folder;
use crate::room::room;

#[test]
fn the_processor_is_a_device() {
    let folder = Folder::new([]);
    let rows = folder.succeed("devices --json").json();
    assert_eq!(rows[0]["device"], "cpu");
    assert!(folder.succeed("devices").stdout.contains("the processor"));
}

#[test]
fn the_processor_renders_where_it_is_named_as_where_it_is_not() {
    let folder = room("[render]\nsamples_per_pixel = 2\n");
    folder.succeed("render capture.toml -o one");
    folder.succeed("render capture.toml --device cpu -o two");
    assert_eq!(folder.results("one")["raw.dng"], folder.results("two")["raw.dng"]);
    folder.fail("render capture.toml --device cuda -o three", 2, &["photosite devices"]);
}

/// Without graphics cards built in, `gpu` is refused with the way to them, and `auto` is the processor with a warning.
#[cfg(not(feature = "gpu"))]
#[test]
fn a_build_without_graphics_cards_says_so() {
    let folder = room("[render]\nsamples_per_pixel = 2\n");
    let words = ["built without graphics cards", "--features gpu"];
    folder.fail("render capture.toml --device gpu -o card", 2, &words);
    folder.fail("render capture.toml --device gpu:1 -o card", 2, &words);
    let done = folder.succeed("render capture.toml --device auto -o auto");
    assert!(words.iter().all(|words| done.stderr.contains(words)), "{}", done.stderr);
}

/// A data set takes the device as a render does: the processor goes without saying, and is what `auto` falls back to.
#[cfg(not(feature = "gpu"))]
#[test]
fn data_sets_take_devices_as_renders_do() {
    let folder = room("[render]\nsamples_per_pixel = 2\n");
    folder.add("set.toml", "capture = \"capture.toml\"\nframes = 2\n");
    folder.succeed("dataset set.toml -o one");
    folder.succeed("dataset set.toml --device cpu -o one");
    let words = ["built without graphics cards", "--features gpu"];
    folder.fail("dataset set.toml --device gpu -o card", 2, &words);
    let done = folder.succeed("dataset set.toml --device auto -o auto");
    assert!(words.iter().all(|words| done.stderr.contains(words)), "{}", done.stderr);
    let identity = |name: &str| folder.text(&format!("{name}/dataset.json"));
    assert_eq!(identity("one"), identity("auto"));
}

/// Light that is there takes the device as a render does; the processor makes what it makes without being named.
#[test]
fn exposures_take_devices_as_renders_do() {
    let folder = room("[render]\nsamples_per_pixel = 2\n");
    folder.succeed("render capture.toml -o light");
    folder.succeed("expose light -o one");
    folder.succeed("expose light --device cpu -o two");
    assert_eq!(folder.results("one")["raw.dng"], folder.results("two")["raw.dng"]);
    folder.fail("expose light --device cuda -o three", 2, &["photosite devices"]);
    #[cfg(not(feature = "gpu"))]
    {
        let words = ["built without graphics cards", "--features gpu"];
        folder.fail("expose light --device gpu -o card", 2, &words);
        let done = folder.succeed("expose light --device auto -o auto");
        assert!(
            done.stderr.contains("the processor exposes: ") && words.iter().all(|words| done.stderr.contains(words))
        );
        assert_eq!(folder.results("one")["raw.dng"], folder.results("auto")["raw.dng"]);
    }
}

/// The live view takes the device as a render does, and refuses it where no light is traced or exposed.
#[test]
fn the_view_takes_a_device_for_what_it_traces_and_exposes() {
    let folder = room("[render]\nsamples_per_pixel = 2\n");
    folder.succeed("render capture.toml -o one");
    folder.fail("view one/raw.dng --device auto", 2, &["--device", "capture file, a scene or the folder of a render"]);
    folder.fail("view capture.toml --device cuda", 2, &["photosite devices"]);
    #[cfg(not(feature = "gpu"))]
    for input in ["capture.toml", "one"] {
        let words = ["built without graphics cards", "--features gpu"];
        folder.fail(&format!("view {input} --device gpu"), 2, &words);
    }
}

/// Parts of a device and of the processor are not of one render, by the device that stands in their provenance.
#[test]
fn parts_of_two_devices_are_not_merged() {
    let folder = room("[render]\nsamples_per_pixel = 4\n");
    folder.succeed("render capture.toml --samples 0..2 -o one");
    folder.succeed("render capture.toml --samples 2..4 -o two");
    let part = folder.text("two/part.json");
    let fingerprint = part.split("\"fingerprint\": \"").nth(1).expect("a fingerprint")[..64].to_owned();
    let changed = part.replace(&fingerprint, &"0".repeat(64)).replacen(
        "\"photosite_version\"",
        "\"device\": \"a card\",\n  \"photosite_version\"",
        1,
    );
    folder.add("two/part.json", changed);
    folder.fail("merge one two -o both", 2, &["not parts of the same render", "another device"]);
}
