//! Renders and data sets of which several runs trace a part each: put together they are those of one run.

use std::fs;

use rstest::rstest;
use serde_json::{Map, Value};

use crate::dataset::{files, folder as board, manifest};
use crate::folder::Folder;
use crate::room::room;
use crate::same_bytes::{assert_same, timeless};

/// Parts of 8 samples, of unequal size and cut at no power of two.
const PARTS: [&str; 3] = ["0..1", "1..6", "6..8"];

fn render_parts(folder: &Folder, input: &str) {
    for (i, samples) in PARTS.into_iter().enumerate() {
        let outcome = folder.succeed(&format!("render {input} --samples {samples} -o part{i}"));
        assert!(
            outcome.text().contains(&format!("traced the samples {samples} of 8; part{i} is a part")),
            "{outcome:?}"
        );
    }
}

/// Asserts that the parts of a render, merged, have the bytes of the whole.
fn assert_parts_make_the_whole(folder: &Folder, input: &str) {
    folder.succeed(&format!("render {input} -o whole"));
    render_parts(folder, input);
    folder.succeed("merge part0 part1 part2 -o merged");
    assert_same(folder, "whole", "merged");
}

#[rstest]
#[case::usual("", "")]
#[case::independent("", "sampler = 'independent'")]
#[case::frames("frames = 2", "")]
#[case::bracket("bracket_ev = [-1, 1]", "")]
#[case::moving("frames = 2\nframe_interval_s = 0.01\n[camera.motion]\nvelocity_m_per_s = [20, 0, 0]", "")]
fn parts_make_the_bytes_of_one_render(#[case] exposure: &str, #[case] more: &str) {
    let folder = room(&format!(
        "{exposure}\n[render]\nsamples_per_pixel = 8\nseed = 7\n{more}\n\
         [output]\nraw = ['dng', 'npy']\nirradiance = true\nideal = true\ntruth = ['depth', 'instance']\n"
    ));
    folder.succeed("render capture.toml -o whole");
    render_parts(&folder, "capture.toml");
    let moves = exposure.contains("motion");
    let part: Vec<String> = folder.results("part1").into_keys().collect();
    let films: &[&str] =
        if moves { &["film-0000.npy.gz", "film-0001.npy.gz", "part.json"] } else { &["film.npy.gz", "part.json"] };
    assert_eq!(part, films);
    // In any order, on any number of threads.
    folder.succeed("merge part2 part0 part1 -o merged --threads 2");
    assert_same(&folder, "whole", "merged");
}

/// A file that a capture names by an absolute path is the same from wherever the capture is read.
#[test]
fn parts_of_a_capture_with_an_absolute_path_are_merged() {
    let folder = room("[render]\nsamples_per_pixel = 8");
    let absolute = folder.path("room.obj");
    assert!(absolute.is_absolute());
    folder.change("capture.toml", "\"room.obj\"", &format!("'{}'", absolute.display()));
    assert_parts_make_the_whole(&folder, "capture.toml");
}

#[test]
fn what_is_chosen_by_the_light_is_chosen_by_all_of_it() {
    let folder = room("[render]\nsamples_per_pixel = 8");
    folder.change("capture.toml", "time_s = 0.0002", "auto = true");
    assert_parts_make_the_whole(&folder, "capture.toml");
}

#[test]
fn a_scene_without_a_capture_file_and_changed_keys_are_merged() {
    let folder = room("");
    let input = "sails.gltf --set render.samples_per_pixel=8 --set sensor.resolution_px=[24,16] --seed 4";
    assert_parts_make_the_whole(&folder, input);
    assert_eq!(folder.report("merged")["input"], "../sails.gltf", "from the folder of the report");
    // The file of the scene is hashed although no capture names it.
    let scene = folder.text("sails.gltf");
    folder.add("sails.gltf", scene.replace("0.1,", "0.2,"));
    folder.fail("merge part0 part1 part2 -o other", 2, &["part0 is a part of something else than", "has changed"]);
    folder.add("there/sails.gltf", scene);
    folder.succeed("merge part0 part1 part2 --input there/sails.gltf -o there/merged --quiet");
    assert!(folder.results("there/merged")["raw.dng"] == folder.results("whole")["raw.dng"]);
}

/// A folder with the parts of a render of 8 samples.
fn parts() -> Folder {
    let folder = room("[render]\nsamples_per_pixel = 8\n");
    render_parts(&folder, "capture.toml");
    folder
}

#[rstest]
#[case::gap("", "part0 part2", 2, &["samples 1..6 are missing between part0 and part2", "--samples 1..6"])]
#[case::beginning("", "part1 part2", 2, &["samples 0..1 are missing before those of part1"])]
#[case::end("", "part1 part0", 2, &["samples 6..8 are missing after those of part1"])]
#[case::twice("", "part0 part1 part1 part2", 2, &["part1 and part1 both hold the samples 1..6"])]
#[case::overlap(
    "--samples 4..7 -o between",
    "part0 part1 between part2",
    2,
    &["part1 and between both hold the samples 4..6"]
)]
#[case::another_seed(
    "--samples 6..8 --seed 5 -o seed",
    "part0 part1 seed",
    2,
    &["part1 and seed are not parts of the same render: in seed, the capture says"]
)]
#[case::whole("-o whole", "part0 whole", 1, &["whole", "contains a whole image, not a part"])]
#[case::nowhere("", "part0 nowhere", 1, &["nowhere", "there is no part.json", "broken off"])]
#[case::nothing("", "", 2, &["<DIR>"])]
fn parts_that_make_no_whole_are_refused(
    #[case] rendered: &str,
    #[case] merged: &str,
    #[case] status: i32,
    #[case] wanted: &[&str],
) {
    let folder = parts();
    if !rendered.is_empty() {
        folder.succeed(&format!("render capture.toml {rendered}"));
    }
    folder.fail(&format!("merge {merged} -o merged"), status, wanted);
}

#[rstest]
#[case::exposed("expose part0", 1, &["part0", "has no capture.json", "photosite merge"])]
#[case::rendered_over("render capture.toml -o part0", 2, &["part0 contains a part of a render", "--force"])]
#[case::merged_over_a_render(
    "merge part0 part1 part2 -o whole",
    2,
    &["whole contains the results of an earlier render", "--force"]
)]
#[case::merged_over_a_part("merge part0 part1 part2 -o part0", 2, &["part0 contains a part of a render"])]
fn parts_and_renders_are_not_taken_for_each_other(#[case] command: &str, #[case] status: i32, #[case] wanted: &[&str]) {
    let folder = parts();
    if command.contains("whole") {
        folder.succeed("render capture.toml --seed 5 -o whole");
    }
    folder.fail(command, status, wanted);
}

fn cut_film(folder: &Folder) {
    let film = folder.results("part1")["film.npy.gz"].clone();
    folder.add("part1/film.npy.gz", &film[..film.len() / 2]);
}

fn flip_bits_of_film(folder: &Folder) {
    let mut film = folder.results("part1")["film.npy.gz"].clone();
    let whole = film.clone();
    for place in [3, 60, film.len() / 2, film.len() - 1] {
        film[place] ^= 1;
        folder.add("part1/film.npy.gz", &film);
        folder.fail("merge part0 part1 part2 -o merged", 1, &["part1/film.npy.gz", "is damaged: its checksum"]);
        film[place] = whole[place];
    }
    film[200] ^= 0x80;
    folder.add("part1/film.npy.gz", &film);
}

fn remove_film(folder: &Folder) {
    fs::remove_file(folder.path("part1/film.npy.gz")).expect("removed");
}

fn cut_report(folder: &Folder) {
    folder.add("part1/part.json", "{ \"samples\": ");
}

fn state_samples_backwards(folder: &Folder) {
    let text = String::from_utf8(folder.results("part0")["part.json"].clone()).expect("UTF-8");
    let text: String = text.split_whitespace().collect();
    folder.add("part1/part.json", text.replace("\"samples\":[0,1]", "\"samples\":[3,1]"));
}

fn render_another_capture(folder: &Folder) {
    folder.change("capture.toml", "roughness = 0.3", "roughness = 0.2");
    folder.succeed("render capture.toml --samples 1..6 -o part1 --force");
}

#[rstest]
#[case::film_cut(cut_film, 1, &["part1/film.npy.gz", "render that part again"])]
#[case::film_flipped(flip_bits_of_film, 1, &["part1/film.npy.gz", "is damaged: its checksum", "render that part again"])]
#[case::film_missing(remove_film, 1, &["part1/film.npy.gz", "cannot read"])]
#[case::report_cut(cut_report, 1, &["part1/part.json", "is damaged"])]
#[case::samples_backwards(state_samples_backwards, 1, &["part1/part.json", "is damaged", "[3, 1] of 8"])]
#[case::another_capture(
    render_another_capture,
    2,
    &["part0 and part1 are not parts", "the capture says something else"]
)]
fn damaged_and_foreign_parts_are_refused(#[case] damage: fn(&Folder), #[case] status: i32, #[case] wanted: &[&str]) {
    let folder = parts();
    damage(&folder);
    folder.fail("merge part0 part1 part2 -o merged", status, wanted);
}

/// Whatever a part has lost, it is told in words.
#[test]
fn parts_without_one_of_their_keys_are_refused_or_merged() {
    let folder = parts();
    let whole = folder.json("part1/part.json");
    let keys = |value: &Value| value.as_object().into_iter().flat_map(Map::keys).cloned().collect::<Vec<_>>();
    let mut pointers: Vec<[String; 2]> = Vec::new();
    for key in keys(&whole) {
        pointers.extend(keys(&whole[&key]).into_iter().map(|inner| [format!("/{key}"), inner]));
        pointers.push([String::new(), key]);
    }
    assert!(pointers.contains(&[String::new(), "fingerprint".to_owned()]), "{pointers:?}");
    for [table, key] in pointers {
        let mut part = whole.clone();
        part.pointer_mut(&table).and_then(Value::as_object_mut).expect("a table").remove(&key);
        folder.add("part1/part.json", part.to_string());
        let outcome = folder.run("merge part0 part1 part2 -o merged --force --quiet");
        assert!(
            matches!(outcome.status, Some(0..=2)) && !outcome.stderr.contains("panicked"),
            "{table}/{key}: {}",
            outcome.stderr
        );
        if key == "fingerprint" {
            assert!(outcome.status == Some(1) && outcome.stderr.contains("is damaged"), "{}", outcome.stderr);
        }
    }
}

#[rstest]
#[case::beyond("--samples 4..9", 2, "the samples 4..9: there are 8 samples per pixel")]
#[case::backwards("--samples 4..4", 2, "the first number must be below the second")]
#[case::noise(
    "--samples 0..4 --set render.noise_target=0.5",
    1,
    "render.noise_target: cannot be combined with a part of the samples"
)]
#[case::time(
    "--samples 0..4 --set render.time_limit_s=3",
    1,
    "render.time_limit_s: cannot be combined with a part of the samples"
)]
fn impossible_parts_are_refused(#[case] arguments: &str, #[case] status: i32, #[case] message: &str) {
    let folder = room("[render]\nsamples_per_pixel = 8\n");
    folder.fail(&format!("render capture.toml -o out {arguments}"), status, &[message]);
}

/// Killed at any file, a part is there as a whole or not at all, and can be made again.
#[rstest]
fn a_part_that_is_killed_is_not_merged(#[values("file-written", "file-named")] point: &str) {
    let folder = room("[render]\nsamples_per_pixel = 2\n");
    folder.succeed("render capture.toml -o whole --quiet");
    folder.succeed("render capture.toml --samples 0..1 -o first --quiet");
    let second = "render capture.toml --samples 1..2 -o second --force --quiet";
    let mut killed = 0;
    while folder.killed_at(point, killed + 1, second) {
        killed += 1;
        if folder.path("second/part.json").exists() {
            folder.succeed("merge first second -o merged --force --quiet");
            assert_same(&folder, "whole", "merged");
            fs::remove_dir_all(folder.path("second")).expect("removed");
        } else {
            assert_eq!(folder.run("merge first second -o merged --force").status, Some(1));
        }
    }
    // The rows that are done, the sums and what they are sums of.
    assert!(killed >= 2, "{killed}");
    folder.succeed("merge first second -o merged --force --quiet");
    assert_eq!(timeless(folder.report("whole")), timeless(folder.report("merged")));
}

const SET: &str = "frames = 12\n[[cameras]]\nname = 'left'\n[[cameras]]\nname = 'right'\nposition_m = [0.1, 0, 0]\n\
    [poses.random]\ntarget = 'board'\ndistance_m = [0.6, 0.9]\nmargin_px = 1\n\
    [[vary]]\nkey = 'exposure.time_s'\nlog_uniform = [0.002, 0.006]\n";

#[test]
fn parts_of_a_data_set_make_the_whole_even_if_they_are_killed() {
    let folder = board(SET);
    let set = "--set render.samples_per_pixel=5 --set output.truth=['depth']";
    folder.succeed(&format!("dataset set.toml -o whole {set}"));
    // One job has all frames, two share them; all are killed again and again.
    let jobs = ["--samples 0..2 -o a", "--samples 2..5 --frames 0..7 -o b", "--samples 2..5 --frames 7..12 -o c"];
    // Each run goes on where the one before was killed.
    let points = ["picture-begun", "pass-ended", "file-written", "file-named", "picture-complete"];
    for job in jobs {
        for point in points {
            assert!(folder.killed_at(point, 2, &format!("dataset set.toml {job} {set} -q")), "{job} {point}");
        }
        folder.succeed(&format!("dataset set.toml {job} {set}"));
    }
    for point in ["picture-begun", "file-written", "file-named", "picture-complete"] {
        assert!(folder.killed_at(point, 3, "merge a b c -o merged -q"), "{point}");
    }
    let outcome = folder.succeed("merge a b c -o merged");
    assert!(outcome.text().contains("24 of 24 are in merged"), "{outcome:?}");
    assert_eq!(manifest(&folder, "merged").len(), 24);
    assert!(files(&folder, "whole") == files(&folder, "merged"));
    let again = folder.succeed("merge a b c -o merged");
    assert!(again.text().contains("made 0 images"), "{again:?}");
}

#[test]
fn parts_of_data_sets_are_not_mixed() {
    let folder = board("frames = 2\n");
    let set = "--set render.samples_per_pixel=4";
    folder.succeed(&format!("dataset set.toml {set} --samples 0..2 -o a"));
    let fail = |arguments: &str, wanted: &[&str]| {
        folder.fail(arguments, 2, wanted);
    };
    fail(&format!("dataset set.toml {set} --samples 2..4 -o a"), &["a holds the samples 0..2 of each pixel", "-o"]);
    fail(&format!("dataset set.toml {set} -o a"), &["a holds the samples 0..2 of each pixel"]);
    fail(&format!("dataset set.toml {set} --samples 2..5 -o b"), &["the samples 2..5: there are 4 samples per pixel"]);
    fail("merge a -o merged", &["samples 2..4 are missing after those of a/camera/000000"]);
    folder.succeed(&format!("dataset set.toml {set} --samples 2..4 --frames 0..1 -o b"));
    fail("merge a b -o merged", &["samples 2..4 are missing after those of a/camera/000001"]);
    fail("merge b -o merged", &["samples 0..2 are missing before those of b/camera/000000"]);
    fail("merge a b -o a", &["missing"]);
    folder.succeed(&format!("dataset set.toml {set} --samples 2..4 -o b"));
    fail("merge a b -o a", &["a holds the samples 0..2 of each pixel"]);
    fail("merge a b -o merged --force", &["--force", "nothing is overwritten"]);
    folder.succeed("dataset set.toml --set render.samples_per_pixel=4 --set exposure.gain_db=3 --samples 2..4 -o c");
    fail("merge a c -o merged", &["c is a part of another data set: its overrides say something else"]);
    folder.succeed(&format!("dataset set.toml {set} -o whole"));
    folder.fail("merge a whole -o merged", 1, &["whole", "contains a whole data set"]);
    folder.fail("merge a set.toml -o merged", 1, &["set.toml", "does not contain a part of a data set"]);
    fail(&format!("dataset set.toml {set} --samples 0..2 -o whole"), &["whole contains the whole of this data set"]);
    folder.succeed("merge b a -o merged");
    assert!(files(&folder, "whole") == files(&folder, "merged"));
    // What the parts were made from has changed.
    folder.change("board.toml", "500", "600");
    fail("merge a b -o other", &["a is a part of another data set: the capture says something else"]);
}
