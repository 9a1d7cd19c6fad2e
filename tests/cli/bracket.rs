//! Brackets: the same light exposed for different times, and merged.

use photosite::io::exr::{Attribute, ExrImage, read_exr};
use photosite::raw::write_dng;
use rstest::rstest;
use serde_json::json;

use crate::folder::Folder;
use crate::room::room;

fn exr(folder: &Folder, name: &str) -> ExrImage {
    let file = std::fs::File::open(folder.path(name)).expect("a file");
    read_exr(std::io::BufReader::new(file)).expect("an EXR file")
}

#[test]
fn a_bracket_is_a_raw_file_for_each_time_and_their_light() {
    let folder = room("bracket_ev = [0, -3, 4]\n[render]\nsamples_per_pixel = 4\n[output]\nraw = ['dng', 'npy']\n");
    folder.succeed("render capture.toml -o out");
    let names: Vec<String> = folder.results("out").into_keys().collect();
    let raws = ["raw-0000.dng", "raw-0000.npy", "raw-0001.dng", "raw-0001.npy", "raw-0002.dng", "raw-0002.npy"];
    assert_eq!(names[..4], ["capture.json", "electrons.exr", "hdr.exr", "image.png"]);
    assert_eq!(names[4..], raws);
    let exposure = &folder.report("out")["exposure"];
    assert_eq!((&exposure["time_s"], &exposure["bracket_s"]), (&json!(0.0002), &json!([0.0002, 0.000025, 0.0032])));
    for (frame, time) in [0.0002, 0.000025, 0.0032].into_iter().enumerate() {
        let raw = folder.raw(&format!("out/raw-{frame:04}.dng"));
        assert!((raw.metadata.exposure_time_s / time - 1.0).abs() < 1e-6);
    }
    // The image is that of the time that was asked for, which comes first here, and so has the noise of a single one.
    let capture = folder.text("capture.toml");
    folder.add("single.toml", capture.replace("bracket_ev = [0, -3, 4]", ""));
    folder.succeed("render single.toml -o single");
    let (bracket, single) = (folder.results("out"), folder.results("single"));
    assert!(bracket["raw-0000.dng"] == single["raw.dng"] && bracket["image.png"] == single["image.png"]);
    assert!(bracket["electrons.exr"] == single["electrons.exr"]);
    // The same times written down.
    folder.add(
        "times.toml",
        capture
            .replace("bracket_ev = [0, -3, 4]", "bracket_times_s = [0.0002, 0.000025, 0.0032]")
            .replace("time_s = 0.0002\n", ""),
    );
    folder.succeed("render times.toml -o times");
    for name in raws.iter().chain(&["hdr.exr", "image.png"]) {
        assert!(folder.results("times")[*name] == bracket[*name], "{name}");
    }
}

#[test]
fn files_and_render_merge_to_the_same_light() {
    let folder = room("bracket_ev = [-3, 0, 3]\n[render]\nsamples_per_pixel = 64\n");
    folder.succeed("render capture.toml -o out");
    folder.succeed("merge-hdr out/raw-0002.dng out/raw-0000.dng out/raw-0001.dng -o merged.exr");
    folder.succeed("merge-hdr out/raw-0001.dng out/raw-0002.dng out/raw-0000.dng -o single.exr --threads 1");
    let [many, single] = ["merged.exr", "single.exr"].map(|name| folder.bytes(name));
    assert!(many == single, "order of files and number of threads make no difference");
    let [ours, merged] = ["out/hdr.exr", "merged.exr"].map(|name| exr(&folder, name));
    let time = |image: &ExrImage| image.attributes.iter().find(|(name, _)| name == "exposureTime").cloned();
    let of_longest =
        |(_, time): (String, Attribute)| matches!(time, Attribute::Number(s) if (s / 0.0016 - 1.0).abs() < 1e-6);
    assert!(time(&ours).is_some_and(of_longest) && time(&merged).is_some_and(of_longest));
    for (a, b) in ours.planes.channels().iter().zip(merged.planes.channels()) {
        // What files state of times and colours is rounded to fractions of 32 bits.
        assert!(a.data.iter().zip(&b.data).all(|(a, b)| (a - b).abs() <= 1e-5 * a.abs().max(1e-3)), "{}", a.name);
    }
    // Light has no tone curve, whatever images are made of it.
    folder.succeed(
        "merge-hdr out/raw-0002.dng out/raw-0000.dng out/raw-0001.dng -o toned.exr --set develop.tone_curve=filmic",
    );
    assert!(folder.bytes("toned.exr") == many);
    let shown = folder.succeed("merge-hdr out/raw-0002.dng out/raw-0000.dng -o two.exr --set develop.colour_model=lab");
    assert!(shown.stderr.contains("develop.colour_model does not affect merged light"), "{}", shown.stderr);
    // It reaches further than any of its images: 1 saturates the longest of them.
    let brightest = merged.planes.channels()[0].data.iter().copied().fold(0.0, f32::max);
    assert!(brightest > 4.0, "{brightest}");
    // The same bytes on any number of threads.
    folder.succeed("expose out -o two --threads 2");
    folder.succeed("expose out -o one --threads 1");
    for (name, bytes) in folder.results("one").iter().filter(|(name, _)| *name != "capture.json") {
        assert!(folder.results("two")[name] == *bytes && folder.results("out")[name] == *bytes, "{name}");
    }
    let outcome = folder.succeed("merge-hdr out/raw-0000.dng out/raw-0001.dng -o merged.exr --force --json");
    let report = outcome.json();
    assert_eq!(report["resolution_px"], json!([32, 24]));
    folder.fail(
        "merge-hdr out/raw-0000.dng out/raw-0001.dng -o merged.exr",
        2,
        &["merged.exr already exists", "--force"],
    );
}

#[rstest]
#[case::one("out/raw-0000.dng", 2, &["a bracket has 2 to 32 images, not 1", "same light"])]
#[case::same("out/raw-0000.dng out/raw-0000.dng", 2, &["all images were exposed for", "different times"])]
#[case::missing("out/raw-0000.dng nothing.dng", 1, &["nothing.dng"])]
#[case::no_raw("out/raw-0000.dng out/image.png", 1, &["out/image.png"])]
#[case::speed("out/raw-0000.dng faster/raw.dng", 1, &["faster/raw.dng: ISO: was taken at ISO", "the first image at ISO"])]
#[case::untimed("out/raw-0000.dng untimed.dng", 1, &["untimed.dng: ExposureTime: the file does not say"])]
#[case::format("out/raw-0000.dng out/raw-0001.dng -o merged.png", 2, &["merged.png cannot hold the range", ".exr"])]
fn what_is_no_bracket_is_refused_by_file(#[case] arguments: &str, #[case] status: i32, #[case] words: &[&str]) {
    let folder = room("bracket_ev = [0, 2]\n[render]\nsamples_per_pixel = 1\n");
    folder.succeed("render capture.toml -o out");
    folder.succeed("render capture.toml -o faster --set exposure.gain_db=12 --set exposure.bracket_ev=[0,1]");
    std::fs::rename(folder.path("faster/raw-0001.dng"), folder.path("faster/raw.dng")).expect("renamed");
    let mut untimed = folder.raw("out/raw-0001.dng");
    untimed.metadata.exposure_time_s = 0.0;
    let mut file = std::io::Cursor::new(Vec::new());
    write_dng(&untimed, &mut file).expect("written");
    folder.add("untimed.dng", file.into_inner());
    folder.fail(&format!("merge-hdr {arguments}"), status, words);
    assert!(!folder.path("hdr.exr").exists() && !folder.path("merged.png").exists());
}
