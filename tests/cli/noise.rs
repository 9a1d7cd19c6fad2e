//! `photosite noise`: what it says of images whose noise is known.

use photosite::io::output::write_whole;
use photosite::io::raw_exr::write_raw_exr;
use photosite::raw::{Cfa, PixelArea, RawImage, write_dng, write_npy};
use rstest::rstest;
use serde_json::Value;

use crate::folder::Folder;

fn flats(folder: &Folder) {
    folder.succeed("emva1288 sony-imx249-mono --size 64x48 --steps 5 --spatial 6 --format dng -o flats -q");
}

fn planes(folder: &Folder, arguments: &str) -> Value {
    let report = folder.succeed(&format!("noise {arguments} --json")).json();
    report["planes"].clone()
}

#[test]
fn of_several_images_and_of_one() {
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
fn sigma_maps_pages_and_plots_are_written_on_request() {
    let folder = Folder::new([]);
    flats(&folder);
    let images: Vec<String> = (0..6).map(|i| format!("flats/Y/images/stack-bright-{i}.dng")).collect();
    let images = images.join(" ");
    let said = folder.succeed(&format!("noise {images} --sigma-map s.exr --page page.html --plots plots"));
    assert!(said.text().contains("wrote s.exr"), "{}", said.stderr);
    // The mean square of the map is the temporal noise, and its largest value the worst pixel's.
    let temporal = &planes(&folder, &images)[0]["temporal"];
    let file = folder.bytes("s.exr");
    let map = photosite::io::exr::read_exr(std::io::Cursor::new(file)).expect("an EXR file");
    assert_eq!((map.text("unit"), map.planes.width(), map.planes.height()), (Some("DN"), 64, 48));
    let sigmas = &map.planes.channels()[0].data;
    let mean_square = sigmas.iter().map(|&s| f64::from(s).powi(2)).sum::<f64>() / sigmas.len() as f64;
    assert!((mean_square / temporal["noise"]["variance"].as_f64().expect("a number") - 1.0).abs() < 1e-6);
    assert_eq!(temporal["map"]["freedom"], 5.0);
    let page = folder.text("page.html");
    for words in ["Standard deviations of the pixels", "Autocovariance", "of the noisiest pixel", "<svg"] {
        assert!(page.contains(words), "{words}");
    }
    for name in ["sigma-map", "neighbourhoods", "autocovariance", "correlation"] {
        let plot = image::open(folder.path(&format!("plots/raw-{name}.png"))).expect("an image");
        assert_eq!((plot.width(), plot.height()), (720, 480));
    }
    for (arguments, status, message) in [
        ("--sigma-map s.exr", 2, "already exists"),
        ("--page page.html", 2, "already exists"),
        ("--plots plots", 2, "already exists"),
        ("--sigma-map s.png", 2, "ends with .tiff, .npy or .exr"),
        ("--square 1", 2, "--square"),
    ] {
        folder.fail(&format!("noise {images} {arguments}"), status, &[message]);
    }
    folder.succeed(&format!("noise {images} --page page.html --plots plots --force"));
    let one = images.split(' ').next().expect("six");
    folder.fail(&format!("noise {one} --sigma-map one.npy"), 2, &["two or more images"]);
    assert!(!folder.path("one.npy").exists());
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
#[case::kind("noise a.txt", 2, "not an image of a kind")]
#[case::patch("noise flats/Y/images/stack-dark-0.dng --patch 60,0,8,8", 2, "reaches beyond the 64 × 48 pixels")]
#[case::small("noise flats/Y/images/stack-dark-0.dng --patch 0,0,1,8", 2, "do not form a patch")]
#[case::rectangle("noise flats/Y/images/stack-dark-0.dng --patch 1,2,3", 2, "write left, top, width and height")]
fn what_cannot_be_done_is_refused(#[case] arguments: &str, #[case] status: i32, #[case] message: &str) {
    let folder = Folder::new([("a.txt", b"text".to_vec())]);
    if arguments.contains("flats") {
        flats(&folder);
    }
    folder.fail(arguments, status, &[message]);
}

/// A raw image of 45 × 34 pixels, of which 36 × 26 from column 5, row 3, see light. Half of the pixels of each
/// channel lie 50 DN above 1000 and the others as much below; masked pixels show 64 or 65.
fn masked(folder: &Folder, cfa: &str) {
    let area = PixelArea { x: 5, y: 3, width: 36, height: 26 };
    let cfa = Cfa::parse(cfa).expect("a layout");
    let (width, height, samples) = (45, 34, cfa.samples_per_pixel());
    let number = |i: usize| {
        let (pixel, sample) = (i / samples, i % samples);
        let (x, y) = (pixel % width, pixel / width);
        let sees_light = (area.x..area.x + area.width).contains(&x) && (area.y..area.y + area.height).contains(&y);
        if !sees_light {
            return 64 + (x % 2) as u16;
        }
        // By squares of 2 × 2 pixels in turns, each of which has a pixel of every place of a Bayer tile.
        let swing = if ((x - area.x) / 2 + (y - area.y) / 2).is_multiple_of(2) { 950 } else { 1050 };
        swing + 100 * sample as u16
    };
    let raw = RawImage {
        width,
        height,
        data: (0..width * height * samples).map(number).collect(),
        cfa,
        active_area: Some(area),
        bits: 12,
        black_level_dn: 64.into(),
        white_level_dn: 4095,
        ..RawImage::default()
    };
    write_whole(&folder.path("masked.dng"), |to| write_dng(&raw, to)).expect("written");
    write_whole(&folder.path("masked.exr"), |to| write_raw_exr(&raw, to)).expect("written");
    write_whole(&folder.path("masked.npy"), |to| write_npy(&raw, to)).expect("written");
}

#[rstest]
#[case::mono("mono", 1)]
#[case::bayer("RGGB", 4)]
#[case::three_chips("full:RGB", 3)]
fn masked_pixels_are_left_out_unless_asked_for(#[case] cfa: &str, #[case] planes_of_cfa: usize) {
    let folder = Folder::new([]);
    masked(&folder, cfa);
    let number = |value: &Value| value.as_f64().expect("a number");
    for file in ["masked.dng", "masked.exr"] {
        let report = folder.succeed(&format!("noise {file} --json")).json();
        assert_eq!(report["active_area_px"], serde_json::json!([5, 3, 36, 26]));
        let found = report["planes"].as_array().expect("planes");
        if file.ends_with("dng") {
            assert_eq!(found.len(), planes_of_cfa);
        }
        for (i, plane) in found.iter().enumerate() {
            let (mean, sigma) = (number(&plane["mean"]), number(&plane["uniform"]["sigma"]));
            let level = if cfa.starts_with("full") { 1000.0 + 100.0 * i as f64 } else { 1000.0 };
            // A deviation of 50 everywhere, of so many pixels.
            let n = number(&plane["size"][0]) * number(&plane["size"][1]);
            let expected = 50.0 * (n / (n - 1.0)).sqrt();
            assert!(mean == level && (sigma / expected - 1.0).abs() < 1e-9, "{file}: {mean} {sigma}");
        }
        let histograms = folder.succeed(&format!("measure histogram {file} --json")).json();
        assert_eq!((number(&histograms[0]["mean"]), number(&histograms[0]["standard_deviation"])), (1000.0, 50.0));
        // Patches count from the first pixel that sees light, and with --masked from the corner of the file.
        let mean = |arguments: &str| number(&planes(&folder, &format!("{file} {arguments}"))[0]["mean"]);
        assert_eq!(mean("--patch 0,0,4,4"), 1000.0);
        assert!([64.0, 64.5].contains(&mean("--masked --patch 0,0,4,34")));
        folder.fail(&format!("noise {file} --patch 30,0,8,8"), 2, &["beyond the 36 × 26 pixels of the active area"]);
        folder.succeed(&format!("noise {file} --patch 30,0,8,8 --masked"));
    }
    let whole = folder.succeed("measure histogram masked.dng --masked --json").json();
    assert!(number(&whole[0]["standard_deviation"]) > 300.0, "with the masked pixels");
    folder.succeed("compare masked.dng masked.exr --max-rmse 0");
    folder.fail("compare masked.dng masked.npy", 2, &["36 × 26 pixels", "36 × 26 at 5, 3", "--masked"]);
    folder.succeed("compare masked.dng masked.npy --masked --max-rmse 0");
}
