//! A raw file of any camera becomes a picture: DNG, TIFF, PGM or NPY.
//!
//! `cargo run --release --example raw_to_png -- raw.dng image.png`

use std::path::Path;

use photosite::develop::{DevelopSettings, ToneCurve};
use photosite::{Picture, raw};

fn main() -> photosite::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let from = arguments.next().unwrap_or_else(|| "raw.dng".to_owned());
    let to = arguments.next().unwrap_or_else(|| "image.png".to_owned());

    let raw = raw::read(Path::new(&from))?;
    // Half a stop brighter, in proportion to light: no tone curve.
    let settings = DevelopSettings { exposure_ev: 0.5, tone_curve: ToneCurve::Linear, ..DevelopSettings::default() };
    let picture = Picture::develop(&raw, &settings)?;
    picture.save(&to)?;

    let [width, height] = [picture.linear.width(), picture.linear.height()];
    println!("{to}: {width} × {height} pixels, white of {:?} K", picture.development.temperature_k.map(f64::round));
    Ok(())
}
