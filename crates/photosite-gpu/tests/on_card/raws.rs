//! Raw images of tests: edges along rows, columns and diagonals, noise, and parts that are saturated.

use photosite_raw::{BlackLevel, Cfa, ColourCalibration, GainMap, LightSource, Opcode, RawImage, RawMetadata};

use crate::Numbers;

pub(crate) const BLACK_DN: f32 = 256.0;
const WHITE_DN: u16 = 4095;

/// A layout by its name.
pub(crate) fn cfa(text: &str) -> Cfa {
    Cfa::parse(text).expect("a layout")
}

/// A pattern of the brightness that a channel sees, white at 1.
fn pattern(channel: usize, x: usize, y: usize) -> f32 {
    let tint = [0.5, 1.0, 0.7][channel];
    let bars = if (x / 6).is_multiple_of(2) { 0.6 } else { 0.08 };
    let diagonal = if ((x + 2 * y) / 17).is_multiple_of(3) { 0.5 } else { 0.02 };
    let disc = (x as f32 % 50.0 - 24.0).hypot(y as f32 % 40.0 - 11.0) < 7.0;
    let ramp = 0.2 * (x as f32 / 300.0 + y as f32 / 140.0);
    if disc { 4.0 } else { tint * if y % 32 < 16 { bars + ramp } else { diagonal + ramp } }
}

/// A raw image with the noise of a sensor, black levels that differ between channels, and colours.
pub(crate) fn raw(layout: &str, [width, height]: [usize; 2]) -> RawImage {
    let cfa = cfa(layout);
    let (row_length, samples) = (width * cfa.samples_per_pixel(), cfa.samples_per_pixel());
    let mut numbers = Numbers(17);
    let number = |i: usize| {
        let (number, y) = (i % row_length, i / row_length);
        let channel = if cfa.is_mono() { 1 } else { cfa.channel_at(number, y) };
        let light = pattern(channel, number / samples, y);
        // Noise of about 60 electrons in 3000 where it is brightest, triangular
        let noise = (numbers.next() - numbers.next()) * (0.002 + 0.03 * light.sqrt());
        ((light + noise) * 3839.0 + BLACK_DN).round().clamp(0.0, f32::from(WHITE_DN)) as u16
    };
    let data = (0..row_length * height).map(number).collect();
    let levels = [BLACK_DN, BLACK_DN - 5.5, BLACK_DN + 4.0];
    let black = BlackLevel::of_channels(&cfa, &levels[..cfa.channels().len()]).expect("a level for each channel");
    RawImage {
        black_level_dn: black,
        metadata: if cfa.is_mono() { RawMetadata::default() } else { colours() },
        ..RawImage::bare(width, height, data, cfa, WHITE_DN)
    }
}

/// What a file says about the colours of three channels: matrices in two lights, and a response to white.
fn colours() -> RawMetadata {
    let of = |light, colour_matrix: [[f64; 3]; 3]| ColourCalibration {
        light,
        colour_matrix: colour_matrix.to_vec(),
        forward_matrix: None,
    };
    RawMetadata {
        calibrations: vec![
            of(LightSource::A, [[0.9, -0.35, -0.15], [-0.3, 1.1, 0.25], [0.0, 0.1, 0.7]]),
            of(LightSource::D65, [[0.8, -0.25, -0.1], [-0.4, 1.2, 0.2], [-0.05, 0.15, 0.6]]),
        ],
        as_shot_neutral: Some(vec![0.5, 1.0, 0.7]),
        ..RawMetadata::default()
    }
}

/// A map of gains that grow towards the corners, of all pixels.
pub(crate) fn falloff() -> Opcode {
    let gains = (0..7 * 5).map(|i| 1.0 + 0.05 * ((i % 7) as f32 - 3.0).powi(2) + 0.04 * ((i / 7) as f32 - 2.0).powi(2));
    Opcode::GainMap(GainMap::new(7, 5, gains.collect()).expect("a map"))
}
