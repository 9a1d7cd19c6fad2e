//! Photographs a colour checker, from its spectra, with every colour sensor that ships, and develops it, for programs
//! that nobody here wrote to do the same (`tests/judges/developed_colours.py`).
//!
//! `cargo run --release --example photograph_colour_checker -- FOLDER`

use std::path::PathBuf;

use photosite::colour::ColourSpace;
use photosite::develop::camera_colour::camera_colour;
use photosite::develop::{DevelopSettings, ToneCurve, develop};
use photosite::image::Planes;
use photosite::io::developed::{write_encoded, write_png};
use photosite::io::formats::TIFF;
use photosite::io::output::{create_folder, write_whole};
use photosite::raw::{RawImage, write_dng};
use photosite::sensor::{Exposure, NoiseKey, SensorModel, Stages, expose, presets};
use photosite::spectrum::{Spectrum, illuminant, library};
use photosite::units::Seconds;

/// Pixels along a patch; six patches in a row, four rows.
const PATCH: usize = 48;
const COLUMNS: usize = 6;
const ROWS: usize = 4;

fn main() -> miette::Result<()> {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        return Err(miette::miette!("usage: photograph_colour_checker FOLDER"));
    };
    for sensor in presets::names().filter_map(presets::model).filter(|sensor| !sensor.cfa.is_mono()) {
        for light in ["D65", "D50", "A"] {
            let spectrum = illuminant::illuminant(light).ok_or_else(|| miette::miette!("{light} is unknown"))?;
            let raw = photograph(&sensor, &spectrum).map_err(|error| miette::miette!("{error}"))?;
            let developed = |settings| develop(&raw, &settings).map_err(|error| miette::miette!("{error}"));
            let image = developed(DevelopSettings::default())?;
            // A space wide enough that no patch is clipped.
            let wide = developed(DevelopSettings {
                colour_space: ColourSpace::Rec2020,
                tone_curve: ToneCurve::Linear,
                bits: 16,
                ..DevelopSettings::default()
            })?;
            let folder = folder.join(format!("{}-{light}", sensor.name));
            create_folder(&folder)?;
            write_whole(&folder.join("raw.dng"), |to| write_dng(&raw, to))?;
            write_whole(&folder.join("image.png"), |to| write_png(&image, to))?;
            write_whole(&folder.join("wide.tiff"), |to| write_encoded(&wide, &TIFF, to))?;
        }
    }
    Ok(())
}

/// A noise-free image in which white would just saturate.
fn photograph(sensor: &SensorModel, light: &Spectrum) -> Result<RawImage, photosite::Invalid> {
    let exposure = Exposure::of(Seconds(0.01));
    let responses = sensor.responses();
    let electrons = |reflectance: &Spectrum| -> Vec<f64> {
        responses.iter().map(|(_, r)| r.product(&light.product(reflectance)).integral()).collect()
    };
    let white = electrons(&Spectrum::constant(1.0)).into_iter().fold(0.0, f64::max);
    let scale = sensor.saturation_capacity(&exposure).0 / white;
    let patches: Vec<Vec<f64>> = library::colour_checker().map(|(_, patch)| electrons(&patch)).collect();
    let (width, height) = (COLUMNS * PATCH, ROWS * PATCH);
    let mut light_on_sensor = Planes::zeros(width, height, sensor.cfa.channels());
    for (c, channel) in light_on_sensor.channels_mut().iter_mut().enumerate() {
        for (i, value) in channel.data.iter_mut().enumerate() {
            let (x, y) = (i % width / PATCH, i / width / PATCH);
            *value = (patches[y * COLUMNS + x][c] * scale) as f32;
        }
    }
    let mut raw = expose(&light_on_sensor, sensor, &exposure, Stages::NONE, NoiseKey::default())?;
    if let Some(colour) = camera_colour(&responses, light)? {
        colour.write_to(&mut raw.metadata);
    }
    Ok(raw)
}
