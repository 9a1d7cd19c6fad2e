//! A raw file of any camera becomes an image: DNG, TIFF, PGM, NPY or EXR.
//!
//! `cargo run --release --example raw_to_png -- raw.dng image.png`

use std::path::Path;

use photosite::develop::{DevelopSettings, ToneCurve};
use photosite::{DevelopedImage, read_raw};

fn main() -> photosite::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let from = arguments.next().unwrap_or_else(|| "raw.dng".to_owned());
    let to = arguments.next().unwrap_or_else(|| "image.png".to_owned());

    let raw = read_raw(Path::new(&from))?;
    // Half a stop brighter, in proportion to light: no tone curve.
    let settings = DevelopSettings { exposure_ev: 0.5, tone_curve: ToneCurve::Linear, ..DevelopSettings::default() };
    let image = DevelopedImage::develop(&raw, &settings)?;
    image.save(&to)?;

    let [width, height] = [image.linear.width(), image.linear.height()];
    println!("{to}: {width} × {height} pixels, white of {:?} K", image.development.temperature_k.map(f64::round));
    Ok(())
}
