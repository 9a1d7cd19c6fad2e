//! Words to the user about a data set: how noisy its images are, and each kind of warning once.

use serde_json::Value;

use crate::dataset::{BOARD, folder, manifest};
use crate::folder::Folder;

/// Three frames, of which the later ones are saturated.
const BRIGHTER: &str = "frames = 3\n[[vary]]\nkey = 'exposure.time_s'\nsweep = [0.000001, 0.004]\n";

/// The number of frames whose reports warn with these words.
fn frames_told(folder: &Folder, words: &str) -> usize {
    let told = |frame: &u32| {
        let report = folder.report(&format!("out/camera/{frame:06}"));
        let said = report["warnings"].as_array().expect("a list");
        said.iter().any(|said| said.as_str().is_some_and(|said| said.contains(words)))
    };
    (0..3).filter(told).count()
}

#[test]
fn each_kind_of_warning_is_said_once_with_its_number_of_frames() {
    let folder = folder(BRIGHTER);
    let told = folder.succeed("dataset set.toml -o out --set render.samples_per_pixel=4").text();
    let card = folder.text("out/README.md");
    let saturated = frames_told(&folder, "is saturated");
    assert!((1..3).contains(&saturated), "{saturated}: some frames, not all");
    for (words, frames) in [("is saturated", saturated), ("spectra of the scene are not known", 3)] {
        assert_eq!(frames_told(&folder, words), frames);
        assert_eq!(told.matches(words).count(), 1, "{told}");
        let after = &told[told.find(words).expect("said")..];
        let until = after.find("frames").expect("with frames");
        assert!(after[..until].ends_with(&format!("(in {frames} of 3 ")), "{after}");
        assert_eq!(card.matches(words).count(), 1, "{card}");
    }
    let tried = folder.succeed("dataset set.toml -o other --dry-run").text();
    assert_eq!(tried.matches("is saturated").count(), 1, "{tried}");
}

/// Losses by autofocus in a data set are said where they occur, with what to write instead.
#[test]
fn files_of_cameras_that_autofocus_moves_are_told_of() {
    let focused = folder("frames = 2\n[poses.random]\ntarget = 'board'\ndistance_m = [0.6, 0.9]\nmargin_px = 1\n");
    let board = focused.text("board.toml");
    focused.add("board.toml", board.replace("'pinhole'", "'thin'").replace("focus_distance_m = 'infinity'\n", ""));
    let told = focused.succeed("dataset set.toml -o out").text();
    for words in ["calibration/ lacks all of its files", "autofocus", "write lens.focus_distance_m"] {
        assert!(told.contains(words), "{words}: {told}");
    }
    let told = focused.succeed("dataset set.toml -o stated --set lens.focus_distance_m=0.7").text();
    assert!(!told.contains("lacks all"), "{told}");
    assert!(focused.path("stated/calibration/opencv/camera.yaml").exists());
}

#[test]
fn noise_is_said_in_the_closing_line_the_manifest_and_the_card() {
    let folder = folder(&BRIGHTER.replace("0.004", "0.000004"));
    let told = folder.succeed("dataset set.toml -o out --set render.samples_per_pixel=4").text();
    let mut ratios: Vec<f64> = Vec::new();
    for (frame, line) in manifest(&folder, "out").iter().enumerate() {
        let report = folder.report(&format!("out/camera/{frame:06}"));
        assert_eq!(line["noise_ratio"], report["render"]["noise_ratio"]);
        ratios.push(line["noise_ratio"].as_f64().expect("a ratio"));
    }
    let noisiest = (0..3).max_by(|a, b| ratios[*a].total_cmp(&ratios[*b])).expect("three");
    let worst = ratios[noisiest];
    ratios.sort_by(f64::total_cmp);
    let median = ratios[1];
    let start = told.find("Monte Carlo noise is ").expect("said");
    let said: Vec<&str> = told[start..].split_whitespace().collect();
    let near = |word: &str, value: f64| {
        let number: f64 = word.parse().expect(word);
        // Two digits are at most 5 % off.
        assert!((number / value - 1.0).abs() < 0.05, "{number} for {value}: {told}");
    };
    near(said[4], median);
    let [_, of_worst] = [4, said.iter().position(|word| *word == "and").expect("the worst") + 1];
    near(said[of_worst], worst);
    assert!(told.contains(&format!("in camera/{noisiest:06}")), "{told}");
    // Variance goes with one over the samples: 4 of them leave the median.
    let (_, wanted) = told[start..].split_once("render.samples_per_pixel=").expect("what would do");
    let wanted = wanted.split_whitespace().next().expect("a number");
    let equal = 4.0 * median * median;
    near(wanted, if median > 1.0 { equal } else { equal * 25.0 });
    let card = folder.text("out/README.md");
    let card: Vec<&str> = card.split_whitespace().collect();
    assert!(card.join(" ").contains("## Noise Monte Carlo noise is "), "{card:?}");

    let outcome = folder.succeed("dataset set.toml -o out --json --set render.samples_per_pixel=4");
    let end: Value = serde_json::from_str(outcome.stdout.lines().last().expect("an end")).expect("JSON");
    assert_eq!(
        (end["noise_ratio"]["median"].as_f64(), end["noise_ratio"]["worst"].as_f64()),
        (Some(median), Some(worst))
    );
    assert_eq!(end["noise_ratio"]["worst_picture"], format!("camera/{noisiest:06}"));
}

#[test]
fn noise_that_a_single_sample_cannot_tell_is_said_to_be_unknown() {
    let folder = folder(BRIGHTER);
    let told = folder.succeed("dataset set.toml -o out").text();
    assert!(told.contains("Monte Carlo noise is not known: a single sample"), "{told}");
    let alone = Folder::new([("board.toml", BOARD.into())]);
    let told = alone.succeed("render board.toml -o out").text();
    assert!(told.contains("Monte Carlo noise is not known: a single sample"), "{told}");
}
