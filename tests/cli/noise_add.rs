//! `photosite noise add`: images of any program in and out.

use image::{DynamicImage, GrayImage, ImageFormat, RgbImage, RgbaImage};
use photosite::image::{Channel, Planes};
use photosite::io::exr::{Attribute, read_exr, write_exr};
use photosite::raw::{NpyValues, read_npy_image};
use rstest::rstest;
use serde_json::Value;
use std::io::Cursor;

use crate::folder::Folder;

const SIZE: [u32; 2] = [40, 30];

fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    image.into().write_to(&mut file, format).expect("encoded");
    file.into_inner()
}

fn even_exr(value: f32) -> Vec<u8> {
    let [width, height] = SIZE.map(|side| side as usize);
    let channel = Channel { name: "Y".to_owned(), data: vec![value; width * height] };
    let planes = Planes::new(width, height, vec![channel]).expect("right size");
    let mut file = Cursor::new(Vec::new());
    write_exr(&planes, &[("unit", Attribute::Text("lux".to_owned()))], &mut file).expect("written");
    file.into_inner()
}

/// Images of even grey in many formats.
fn folder() -> Folder {
    let [width, height] = SIZE;
    let grey = GrayImage::from_pixel(width, height, [100].into());
    let colour = RgbImage::from_pixel(width, height, [100, 50, 250].into());
    let with_alpha = RgbaImage::from_pixel(width, height, [100, 50, 250, 77].into());
    let profile = photosite::develop::EncodedImage::srgb8(1, 1, 1, vec![100]);
    let mut stated = Vec::new();
    photosite::io::developed::write_png(&profile, &mut stated).expect("written");
    Folder::new([
        ("grey.png", encoded(grey.clone(), ImageFormat::Png)),
        ("grey.tiff", encoded(grey.clone(), ImageFormat::Tiff)),
        ("grey.jpg", encoded(grey, ImageFormat::Jpeg)),
        ("colour.png", encoded(colour, ImageFormat::Png)),
        ("alpha.png", encoded(with_alpha, ImageFormat::Png)),
        ("stated.png", stated),
        ("even.pgm", [&b"P5\n40 30\n1023\n"[..], &[1, 0xf4].repeat(1200)].concat()),
        ("even.exr", even_exr(0.5)),
    ])
}

fn done(folder: &Folder, arguments: &str) -> Value {
    folder.succeed(&format!("noise add {arguments} --json")).json()
}

fn mean_and_sigma(folder: &Folder, file: &str) -> Vec<[f64; 2]> {
    let report = folder.succeed(&format!("noise {file} --json")).json();
    let number = |value: &Value| value.as_f64().expect("a number");
    let of_plane = |plane: &Value| [number(&plane["mean"]), number(&plane["uniform"]["sigma"])];
    report["planes"].as_array().expect("planes").iter().map(of_plane).collect()
}

#[rstest]
#[case::png("grey.png", "out.png", 100.0)]
#[case::tiff("grey.tiff", "out.tiff", 100.0)]
#[case::jpeg("grey.jpg", "out.pgm", 100.0)]
#[case::to_floats("grey.png", "out.exr", 100.0)]
#[case::to_numpy("grey.png", "out.npy", 100.0)]
#[case::ten_bits("even.pgm", "out.pgm", 500.0)]
#[case::colours("colour.png", "out.ppm", 100.0)]
fn every_format_goes_in_and_comes_out(#[case] from: &str, #[case] to: &str, #[case] level: f64) {
    let folder = folder();
    folder.succeed(&format!("noise add {from} -o {to} --set gaussian.sigma=4"));
    let [mean, sigma] = mean_and_sigma(&folder, to)[0];
    // 1200 pixels: 5 standard errors, and what rounding adds.
    assert!((mean - level).abs() < 5.0 * 4.0 / 1200f64.sqrt(), "{mean}");
    assert!((sigma - 4.0).abs() < 5.0 * 4.0 / 2400f64.sqrt() + 0.01, "{sigma}");
}

#[test]
fn floating_point_numbers_are_neither_rounded_nor_clipped_and_keep_what_their_file_says() {
    let folder = folder();
    let report = done(&folder, "even.exr -o out.exr --set laplacian.sigma=2");
    assert!(report["clipped"].is_null() && report["added_to"].as_str().expect("words").ends_with("in lux"), "{report}");
    let file = folder.bytes("out.exr");
    let image = read_exr(Cursor::new(file)).expect("an EXR file");
    assert_eq!(image.text("unit"), Some("lux"));
    assert!(image.planes.channels()[0].data.iter().any(|&v| v < -1.0));
    folder.succeed("noise add even.exr -o out.npy --set laplacian.sigma=2");
    let file = folder.bytes("out.npy");
    assert_eq!(
        read_npy_image(&file[..]).expect("an array").numbers,
        NpyValues::F32(image.planes.into_channels().remove(0).data)
    );
    for (arguments, message) in [
        ("--set salt_and_pepper.part=0.1", "full_scale: is not given"),
        ("--set levels=full-scale --set gaussian.sigma=0.1", "--set full_scale=1"),
        ("--linear --set gaussian.sigma=0.1", "not codes that could be decoded"),
    ] {
        let status = if arguments.contains("linear") { 2 } else { 1 };
        folder.fail(&format!("noise add even.exr -o x.exr {arguments}"), status, &[message]);
    }
}

#[test]
fn what_is_clipped_is_said_and_transparency_stays() {
    let folder = folder();
    let said = folder.succeed("noise add alpha.png -o out.png --set uniform.sigma=20");
    assert!(said.text().contains("transparency (A) gets no noise") && said.text().contains("codes as they are"));
    let image = image::open(folder.path("out.png")).expect("an image").into_rgba8();
    assert!(image.pixels().all(|pixel| pixel.0[3] == 77) && image.pixels().any(|pixel| pixel.0[0] != 100));
    let report = done(&folder, "alpha.png -o again.png --set uniform.sigma=20");
    assert_eq!(folder.bytes("out.png"), folder.bytes("again.png"));
    let [low, high] = ["low", "high"].map(|end| report["clipped"][end].as_u64().expect("a count"));
    // Blue 250 ± 34.6 rounds beyond 255 with (34.6 − 5.5)/69.3 = 42 %; red and green stay inside.
    assert!(low == 0 && (400..610).contains(&high), "{low} {high}");
    assert_eq!(report["clipped"]["values"], 4800);
    done(&folder, "alpha.png -o other.png --seed 1 --set uniform.sigma=20");
    assert_ne!(folder.bytes("out.png"), folder.bytes("other.png"));
}

#[test]
fn linear_light_and_profiles() {
    let folder = folder();
    let report = done(&folder, "colour.png -o out.png --linear --set gaussian.sigma=10");
    assert!(report["added_to"].as_str().expect("words").contains("decoded as sRGB since colour.png says nothing"));
    // Light of 100 is 32.3 of 255, where a code is dL/dc = 0.747 of light: σ = 10/0.747 = 13.4 codes; the curve bends.
    let [_, sigma] = mean_and_sigma(&folder, "out.png")[0];
    assert!((12.0..16.5).contains(&sigma), "{sigma}");
    let report = done(&folder, "stated.png -o stated.tiff --linear --set gaussian.sigma=1");
    assert!(report["added_to"].as_str().expect("words").contains("decoded as stated.png says"), "{report}");
    let profile = |name: &str| {
        let file = folder.bytes(name);
        let decoder: Box<dyn image::ImageDecoder> = if name.ends_with("png") {
            Box::new(image::codecs::png::PngDecoder::new(Cursor::new(file)).expect("PNG"))
        } else {
            Box::new(image::codecs::tiff::TiffDecoder::new(Cursor::new(file)).expect("TIFF"))
        };
        let mut decoder = decoder;
        decoder.icc_profile().expect("readable").expect("a profile")
    };
    assert_eq!(profile("stated.tiff"), profile("stated.png"));
    let report = done(&folder, "stated.png -o stated.pgm --set gaussian.sigma=1");
    let warning = report["warnings"][0].as_str().expect("words");
    assert!(["by its ICC profile", "is not carried over"].iter().all(|words| warning.contains(words)), "{report}");
}

#[test]
fn a_sigma_map_is_an_image_of_its_own() {
    let folder = folder();
    folder.succeed("noise add grey.png -o out.npy --set sigma_map.file=even.exr");
    let refused = "noise add grey.png -o x.png --set sigma_map.file=stated.png";
    folder.fail(refused, 1, &["stated.png", "has 1 × 1 pixels, the image 40 × 30"]);
    folder.fail("noise add grey.png -o x.png --set sigma_map.file=nowhere.exr", 1, &["nowhere.exr: cannot read"]);
    assert!(!folder.path("x.png").exists());
}

#[rstest]
#[case::nothing("grey.png -o x.png", 2, "there is no noise to add")]
#[case::key("grey.png -o x.png --set gaussian.sgma=1", 1, "did you mean `sigma`?")]
#[case::table("grey.png -o x.png --set gausian.sigma=1", 1, "did you mean `gaussian`?")]
#[case::negative("grey.png -o x.png --set gaussian.sigma=-1", 1, "gaussian.sigma: must be a finite number")]
#[case::nan("grey.png -o x.png --set gaussian.sigma=nan", 1, "gaussian.sigma: must be")]
#[case::part("grey.png -o x.png --set salt_and_pepper.part=2", 1, "must lie from 0 to 1, got 2")]
#[case::format(
    "grey.png -o x.jpg --set gaussian.sigma=1",
    2,
    "not the name of an image whose pixel values stay as they are"
)]
#[case::floats("even.exr -o x.png --set gaussian.sigma=1", 2, "holds whole numbers")]
#[case::channels("colour.png -o x.pgm --set gaussian.sigma=1", 2, "does not hold the channels R, G, B")]
#[case::ten_bits("even.pgm -o x.png --set gaussian.sigma=1", 2, "reach to 1023")]
#[case::kind("text.txt -o x.png --set gaussian.sigma=1", 2, "not an image of a kind")]
#[case::missing("missing.txt -o x.png --set gaussian.sigma=1", 1, "missing.txt: cannot read")]
#[case::exists("grey.png -o colour.png --set gaussian.sigma=1", 2, "already exists")]
fn what_cannot_be_done_is_refused(#[case] arguments: &str, #[case] status: i32, #[case] message: &str) {
    let folder = folder();
    folder.add("text.txt", "text");
    folder.fail(&format!("noise add {arguments}"), status, &[message]);
    assert!(!folder.path("x.png").exists());
}

#[test]
fn keys_without_effect_are_named_and_all_are_described() {
    let folder = folder();
    let said = folder.succeed("noise add grey.png -o x.png --set gaussian.sigma=1 --set film_grain.correlation_px=3");
    assert!(said.text().contains("film_grain changes nothing without film_grain.factor"), "{}", said.text());
    let schema = folder.succeed("schema noise").json();
    assert!(schema["properties"]["film_grain"].is_object());
}
