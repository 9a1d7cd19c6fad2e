//! `photosite expose` on images of other programs: what their numbers are has to be said.

use std::io::Cursor;

use image::{DynamicImage, ImageFormat, RgbImage};
use photosite::image::{Channel, Planes};
use photosite::io::exr::write_exr;
use photosite::math::statistics::Moments;
use rstest::rstest;

use crate::folder::Folder;

/// Even images: a linear EXR file of three planes, one of one, and an sRGB image.
fn folder() -> Folder {
    let planes = |channels: &[(&str, f32)]| {
        let channel = |&(name, value): &(&str, f32)| Channel { name: name.to_owned(), data: vec![value; 64 * 48] };
        let planes = Planes::new(64, 48, channels.iter().map(channel).collect()).expect("right sizes");
        let mut file = Cursor::new(Vec::new());
        write_exr(&planes, &[], &mut file).expect("written");
        file.into_inner()
    };
    let mut coded = Cursor::new(Vec::new());
    let image = DynamicImage::from(RgbImage::from_pixel(64, 48, [188, 188, 188].into()));
    image.write_to(&mut coded, ImageFormat::Png).expect("encoded");
    Folder::new([
        ("colour.exr", planes(&[("R", 0.25), ("G", 0.5), ("B", 1.0)])),
        ("negative.exr", planes(&[("R", -0.25), ("G", 0.5), ("B", 1.0)])),
        ("dark.exr", planes(&[("Y", f32::NAN)])),
        ("grey.exr", planes(&[("Y", 0.5)])),
        ("coded.png", coded.into_inner()),
    ])
}

const TIME: &str = "--set exposure.time_s=0.01";

fn means(folder: &Folder, name: &str) -> Vec<f64> {
    folder.electrons(name).mean.channels().iter().map(|channel| f64::from(channel.data[100])).collect()
}

#[test]
fn electrons_are_those_of_the_channels_and_the_sensor_adds_its_noise() {
    let folder = folder();
    let said = folder.succeed(&format!("expose colour.exr -o out --unit electrons --one 8000 {TIME}"));
    assert!(said.text().contains("1 is 8000 mean photo-electrons"), "{}", said.stderr);
    // EXR sorts by name: B, G, R.
    assert_eq!(means(&folder, "out"), [8000.0, 4000.0, 2000.0]);
    let raw = folder.raw("out/raw.dng");
    assert_eq!((raw.width, raw.height, raw.cfa.to_string().as_str()), (64, 48, "RGGB"));
    // Shot noise of the green pixels: σ² = K²·μ.
    let report = folder.report("out");
    let gain = report["sensor"]["system_gain_dn_per_e"].as_f64().expect("a number");
    let green = raw.data.iter().enumerate().filter(|(i, _)| (i % 64 + i / 64) % 2 == 1).map(|(_, &dn)| f64::from(dn));
    let green: Moments = green.collect();
    assert!(((green.mean() - f64::from(raw.black_level_dn.mean())) / gain - 4000.0).abs() < 40.0, "{green:?}");
    let shot = gain * gain * 4000.0;
    // Read noise, rounding and PRNU of 1 % come on top.
    assert!((0.9 * shot..1.8 * shot).contains(&green.variance()), "{} for {shot}", green.variance());
    folder.succeed(&format!("expose grey.exr -o well --unit full-well {TIME}"));
    let well = report["capture"]["sensor"]["charge"]["full_well_e"].as_f64().expect("a number");
    assert!(means(&folder, "well").iter().all(|e| (e / well - 0.5).abs() < 1e-6));
    // Other times leave the electrons of the exposure as they are.
    folder.succeed("expose grey.exr -o longer --unit full-well --set exposure.time_s=0.5");
    assert_eq!(means(&folder, "longer"), means(&folder, "well"));
}

#[test]
fn lux_takes_time_and_coded_images_are_decoded() {
    let folder = folder();
    folder.succeed("expose grey.exr -o short --unit lux --one 20 --set exposure.time_s=0.001");
    folder.succeed("expose grey.exr -o long --unit lux --one 20 --set exposure.time_s=0.002");
    for (short, long) in means(&folder, "short").into_iter().zip(means(&folder, "long")) {
        assert!((long / short - 2.0).abs() < 1e-6);
    }
    // The code 188 of sRGB is 0.5029 of white.
    let said = folder.succeed("expose coded.png -o coded --unit lux --one 20 --set exposure.time_s=0.001");
    assert!(said.text().contains("coded.png, which says nothing of them, are decoded to linear light as sRGB"));
    for (grey, coded) in means(&folder, "short").into_iter().zip(means(&folder, "coded")) {
        assert!((coded / grey - 0.502_886 / 0.5).abs() < 1e-4, "{coded} for {grey}");
    }
    let said = folder.succeed("expose coded.png -o linear --unit lux --one 20 --linear --set exposure.time_s=0.001");
    assert!(said.text().contains("taken to be proportional to light"));
    for (grey, linear) in means(&folder, "short").into_iter().zip(means(&folder, "linear")) {
        assert!((linear / grey - 188.0 / 255.0 / 0.5).abs() < 1e-4);
    }
    // White of D65 needs no warning of its balance, and a time that nobody gave is found.
    let said = folder.succeed("expose coded.png -o auto --unit lux --one 20");
    assert!(!said.text().contains("white balance"), "{}", said.stderr);
    assert_eq!(folder.report("auto")["exposure"]["auto"], true);
    // The developed image is as grey as the one that was exposed.
    let image = image::open(folder.path("auto/image.png")).expect("an image").into_rgb8();
    let mean = |i: usize| image.pixels().map(|p| f64::from(p.0[i])).sum::<f64>() / f64::from(64 * 48);
    assert!((mean(0) - mean(1)).abs() < 2.0 && (mean(2) - mean(1)).abs() < 2.0);
}

#[test]
fn the_size_of_an_image_is_no_key_that_stays_over_a_preset() {
    let folder = folder();
    let said =
        folder.succeed(&format!("expose grey.exr -o out --unit full-well --set sensor.preset=sony-imx249-mono {TIME}"));
    assert!(!said.text().contains("stay over it"), "{}", said.text());
}

#[test]
fn irradiance_of_one_wavelength_serves_any_sensor() {
    let folder = folder();
    let arguments = "--unit irradiance --wavelength-nm 550 --one 0.01 --set sensor.preset=sony-imx249-mono";
    folder.succeed(&format!("expose grey.exr -o out {arguments} {TIME}"));
    // 0.005 W/m² on (5.86 µm)² for 10 ms at 3.6117e-19 J a photon, and the sensor's quantum efficiency of 550 nm.
    let photons = 0.005 * 5.86e-6f64.powi(2) * 0.01 / 3.611_720e-19;
    let efficiency = means(&folder, "out")[0] / photons;
    assert!((0.6..0.85).contains(&efficiency), "{efficiency}");
    folder.fail(&format!("expose colour.exr -o x {arguments} {TIME}"), 1, &["colour.exr", "no colours"]);
}

#[rstest]
#[case::no_unit("coded.png", 1, "does not say what its pixel values are")]
#[case::no_unit_exr("grey.exr", 1, "--unit electrons")]
#[case::no_time("grey.exr --unit electrons", 1, "add --set exposure.time_s=0.01")]
#[case::one("grey.exr --unit lux --one 0", 2, "write a number above 0")]
#[case::one_alone("grey.exr --one 3", 2, "--unit")]
#[case::no_wavelength("grey.exr --unit irradiance", 2, "--wavelength-nm")]
#[case::wavelength("grey.exr --unit irradiance --wavelength-nm 100", 2, "must lie from 300 to 1100 nm")]
#[case::other_unit("grey.exr --unit lux --wavelength-nm 500", 2, "goes with --unit irradiance alone")]
#[case::no_number(
    "dark.exr --unit lux",
    1,
    "dark.exr: 3072 numbers are not finite: the first is NaN, of Y in column 0, row 0"
)]
#[case::size("grey.exr --unit lux --set sensor.resolution_px=[8,8]", 1, "64 × 48 pixels, not 8 × 8")]
#[case::table("grey.exr --unit lux --set lens.f_number=2", 2, "can no longer change it")]
fn what_is_no_light_is_refused(#[case] arguments: &str, #[case] status: i32, #[case] message: &str) {
    let folder = folder();
    folder.fail(&format!("expose {arguments} -o x"), status, &[message]);
    assert!(!folder.path("x/capture.json").exists());
}

#[test]
fn numbers_below_0_are_said_to_be_none_and_stored_light_needs_no_unit() {
    let folder = folder();
    let said = folder.succeed(&format!("expose negative.exr -o out --unit electrons --one 1000 {TIME}"));
    assert!(said.text().contains("3072 pixel values below 0 cannot be light"), "{}", said.stderr);
    folder.fail("expose out/electrons.exr -o x --unit lux", 1, &["states itself what it contains"]);
    folder.fail("expose out -o x --unit lux", 2, &["remove --unit"]);
    // What was exposed can be exposed again.
    folder.succeed("expose out -o again --set exposure.gain_db=6");
    assert_eq!(means(&folder, "again"), means(&folder, "out"));
}
