//! `photosite noise`: what it says of pictures whose noise is known.

use rstest::rstest;
use serde_json::Value;

use crate::folder::Folder;

fn flats(folder: &Folder) {
    folder.succeed("emva1288 sony-imx249-mono --size 64x48 --steps 5 --spatial 6 --format dng -o flats -q");
}

fn planes(folder: &Folder, arguments: &str) -> Value {
    let report: Value =
        serde_json::from_str(&folder.succeed(&format!("noise {arguments} --json")).stdout).expect("JSON");
    report["planes"].clone()
}

#[test]
fn of_several_pictures_and_of_one() {
    let folder = Folder::new([]);
    flats(&folder);
    let images: Vec<String> = (0..6).map(|i| format!("flats/Y/images/stack-bright-{i}.dng")).collect();
    let found = &planes(&folder, &images.join(" "))[0];
    assert_eq!((found["pictures"].as_u64(), found["size"][1].as_u64()), (Some(6), Some(48)));
    // K²·(μ_e + dark noise²) + 1/12 by the mean itself: K·(μ − black) and the dark part, 5 of √(2/(5·3072)).
    let mean = found["mean"].as_f64().expect("a number");
    let temporal = found["temporal"]["noise"]["variance"].as_f64().expect("a number");
    let expected = 0.1245 * (mean - 64.0) + 0.1245f64.powi(2) * 6.3f64.powi(2) + 1.0 / 12.0;
    assert!((temporal / expected - 1.0).abs() < 5.0 * (2.0f64 / (5.0 * 3072.0)).sqrt(), "{temporal} {expected}");
    // The pattern of 0.6 %.
    let pattern = found["temporal"]["pattern"]["sigma"].as_f64().expect("a number");
    assert!((pattern / (0.006 * (mean - 64.0)) - 1.0).abs() < 0.15, "{pattern}");

    let one = &planes(&folder, &format!("{} --patch 8,8,32,32 --sigma 16", images[0]))[0];
    assert!(one["temporal"].is_null());
    assert_eq!(one["plane"]["chi_squared"]["freedom"].as_f64(), Some(32.0 * 32.0 - 3.0));
    let text = folder.succeed(&format!("noise {}", images.join(" "))).stdout;
    for words in ["temporal noise", "fixed pattern", "effective bits", "correlation along rows", "q²/12 = 0.083333"] {
        assert!(text.contains(words), "{words} in {text}");
    }
}

#[test]
fn places_of_a_mosaic_are_looked_at_one_by_one() {
    let folder = crate::room::room("[render]\nsamples_per_pixel = 1");
    folder.succeed("render capture.toml -o out");
    let found = planes(&folder, "out/raw.dng");
    let names: Vec<&str> = found.as_array().expect("planes").iter().filter_map(|p| p["name"].as_str()).collect();
    assert_eq!(names, ["R at column 0, row 0", "G at column 1, row 0", "G at column 0, row 1", "B at column 1, row 1"]);
    assert_eq!(found[0]["size"], serde_json::json!([16, 12]));
}

#[rstest]
#[case::missing("noise nowhere.dng", 1, "nowhere.dng: cannot read")]
#[case::kind("noise a.txt", 2, "no picture of a kind")]
#[case::patch("noise flats/Y/images/stack-dark-0.dng --patch 60,0,8,8", 2, "reaches beyond the 64 × 48 pixels")]
#[case::small("noise flats/Y/images/stack-dark-0.dng --patch 0,0,1,8", 2, "no patch")]
#[case::rectangle("noise flats/Y/images/stack-dark-0.dng --patch 1,2,3", 2, "write left, top, width and height")]
fn what_cannot_be_done_is_refused(#[case] arguments: &str, #[case] status: i32, #[case] message: &str) {
    let folder = Folder::new([("a.txt", b"text".to_vec())]);
    if arguments.contains("flats") {
        flats(&folder);
    }
    folder.fail(arguments, status, &[message]);
}
