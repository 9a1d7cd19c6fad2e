//! `photosite develop`: settings, formats and what goes wrong.

use serde_json::{Value, json};

use crate::folder::Folder;
use crate::room::room;

fn bytes(folder: &Folder, name: &str) -> Vec<u8> {
    std::fs::read(folder.path(name)).expect("readable")
}

fn rendered(more: &str) -> Folder {
    let folder = room(&format!("[render]\nsamples_per_pixel = 2\n{more}"));
    folder.succeed("render capture.toml -o out");
    folder
}

fn report(folder: &Folder, arguments: &str) -> Value {
    serde_json::from_str(&folder.succeed(&format!("develop {arguments} --json")).stdout).expect("JSON")
}

#[test]
fn the_same_settings_give_the_picture_of_render() {
    for table in ["", "[develop]\ndemosaic = 'bilinear'\nexposure_ev = 1.0\ntone_curve = 'filmic'\n"] {
        let folder = rendered(table);
        folder.succeed("develop out/raw.dng -o again.png --capture capture.toml");
        assert_eq!(bytes(&folder, "again.png"), bytes(&folder, "out/image.png"), "{table}");
        let plain = if table.is_empty() { "again.png" } else { "plain.png" };
        folder.succeed(&format!("develop out/raw.dng -o {plain} --force"));
        assert_eq!(bytes(&folder, plain) == bytes(&folder, "out/image.png"), table.is_empty());
    }
}

#[test]
fn every_format_and_setting_can_be_chosen() {
    let folder = rendered("");
    for (i, setting) in [
        "demosaic=nearest",
        "demosaic=malvar",
        "white_balance=grey-world",
        "white_balance=white-patch",
        "highlights=blend",
        "highlights=reconstruct",
        "noise_filter=non-local-means",
        "defects=median",
        "colour_space=rec2020",
        "tone_curve=linear",
        "sharpening=0.5",
        "dither=true",
        "bits=16",
        "colour_matrix=false",
    ]
    .iter()
    .enumerate()
    {
        let picture = format!("{i}.png");
        let found = report(&folder, &format!("out/raw.dng -o {picture} --set develop.{setting}"));
        let (key, value) = setting.split_once('=').expect("a key and a value");
        let shown = found["settings"][key].to_string();
        assert_eq!(shown.trim_matches('"').trim_end_matches(".0"), value, "{found}");
        assert!(bytes(&folder, &picture) != bytes(&folder, "out/image.png"), "{setting}");
    }
    for picture in ["a.png", "a.tiff", "a.jpg", "a.ppm", "a.exr"] {
        let found = report(&folder, &format!("out/raw.dng -o {picture}"));
        assert_eq!((&found["resolution_px"], &found["demosaic"]), (&json!([32, 24]), &json!("menon")));
    }
    folder.succeed("compare a.tiff a.png");
    let warm = report(
        &folder,
        "out/raw.dng -o warm.png --set develop.white_balance=temperature --set develop.temperature_k=4000",
    );
    assert!((warm["temperature_k"].as_f64().expect("known") / 4000.0 - 1.0).abs() < 0.02, "{warm}");
}

#[test]
fn what_goes_wrong_is_told() {
    let folder = rendered("");
    folder.add("torn.dng", &bytes(&folder, "out/raw.dng")[..2000]);
    folder.add("notes.txt", b"no raw file");
    for (arguments, status, wanted) in [
        ("out/raw.dng -o p.gif", 2, &["p.gif", ".png, .tiff, .jpg, .ppm or .exr"][..]),
        ("out/raw.dng -o out/image.png", 2, &["exists already", "--force"]),
        ("missing.dng", 1, &["missing.dng", "cannot read"]),
        ("torn.dng", 1, &["torn.dng"]),
        ("notes.txt", 1, &["notes.txt", "no raw file", "DNG"]),
        ("out/raw.dng -o p.png --set develop.demosaic=menan", 1, &["menan", "did you mean", "menon"]),
        ("out/raw.dng -o p.png --set develop.demosaik=menon", 1, &["demosaik", "demosaic"]),
        ("out/raw.dng -o p.png --set demosaic=menon", 2, &["[develop]", "develop.demosaic=menon"]),
        ("out/raw.dng -o p.png --set lens.f_number=4", 2, &["[lens]", "develop."]),
        ("out/raw.dng -o p.png --set develop.demosaic=markesteijn", 1, &["markesteijn", "RGGB"]),
        ("out/raw.dng -o p.png --set develop.temperature_k=5000", 1, &["white_balance = \"temperature\""]),
        ("out/raw.dng -o p.png --set develop.colour_space=xyz", 1, &["colour_space", ".exr"]),
        ("out/raw.dng -o p.jpg --set develop.bits=16", 1, &["bits", "JPEG"]),
        (
            "out/raw.dng -o p.png --set develop.white_balance=patch --set develop.patch_px=[30,0,9,9]",
            1,
            &["patch_px", "32 × 24"],
        ),
    ] {
        folder.fail(&format!("develop {arguments}"), status, wanted);
    }
}

#[test]
fn measures_of_pictures() {
    let folder = rendered("");
    let value = |arguments: &str| -> Value {
        serde_json::from_str(&folder.succeed(&format!("measure {arguments} --json")).stdout).expect("JSON")
    };
    let histograms = value("histogram out/image.png --bins 16");
    let counts = histograms[0]["counts"].as_array().expect("a list").iter().filter_map(Value::as_u64);
    assert_eq!(counts.sum::<u64>(), 32 * 24);
    let same = value("similarity out/image.png out/image.png");
    assert_eq!((&same["channels"][1]["psnr_db"], &same["mean_delta_e_2000"]), (&Value::Null, &json!(0.0)));
    assert!((same["channels"][0]["ssim"].as_f64().expect("large enough") - 1.0).abs() < 1e-9);
    folder.fail("measure mtf out/image.png --channel W", 2, &["no channel W", "R, G, B"]);
    folder.fail("measure mtf out/image.png --region 1,2,3", 2, &["3 numbers instead of 4"]);
    folder.fail("measure checker out/image.png --capture capture.toml", 1, &["no patch"]);
}

#[test]
fn the_ideal_picture_lies_beside_the_developed_one() {
    let folder = room("[render]\nsamples_per_pixel = 16\n[output]\nideal = true\n");
    folder.succeed("render capture.toml -o out");
    folder.succeed("develop out/raw.dng -o out/developed.exr");
    let found: Value =
        serde_json::from_str(&folder.succeed("measure similarity out/developed.exr out/ideal.exr --json").stdout)
            .expect("JSON");
    // The same light and scale; noise of a few electrons and a mosaic of 32 × 24 pixels lie between them. Pictures of
    // different things, values even from 0 to the largest, would differ by its sixth in the mean square, 7.8 dB; 12 dB
    // are a quarter of it as root mean square, the step that edges take where a pixel is half covered.
    for channel in found["channels"].as_array().expect("a list") {
        let psnr = channel["psnr_db"].as_f64().expect("they differ");
        assert!(psnr > 12.0, "{found}");
    }
    assert!(bytes(&folder, "out/ideal.png").starts_with(b"\x89PNG"));
}
