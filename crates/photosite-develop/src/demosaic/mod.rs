//! Demosaicking: the channels that each pixel of a mosaic did not see are found from its neighbours. One file a method.
//!
//! In: a mosaic, white-balanced, since most methods take differences between channels for smooth. Out: a plane for each
//! channel in the same unit, in the order of the filter array's channels; measured values stay as they are, but for
//! Menon's and Markesteijn's. Images that have all channels at every pixel are taken apart.

mod bilinear;
mod channels;
mod guided;
mod lmmse;
mod malvar;
mod markesteijn;
mod menon;
mod nearest;
mod staggered;

use rayon::prelude::*;

use super::choices::Demosaic;
pub(super) use bilinear::Tent;
use channels::{planes, together};
pub(super) use menon::{MARGIN, red_place};
use photosite_core::Invalid;
use photosite_core::image::Planes;
use photosite_raw::{Cfa, RawImage};

/// Planes of all channels of an image.
pub(super) fn demosaic(mosaic: &[f32], raw: &RawImage, method: Demosaic) -> Result<Planes, Invalid> {
    let size = [raw.width, raw.height];
    if !(raw.cfa.is_mosaic() && raw.metadata.is_staggered) {
        return of_rows_and_columns(mosaic, size, &raw.cfa, method);
    }
    method_for(raw, method)?;
    Ok(staggered::demosaic(mosaic, size, &raw.cfa, 1.0 / raw.metadata.pixel_aspect()))
}

/// Method that `method` stands for on an image; an error where it cannot be used there.
pub(super) fn method_for(raw: &RawImage, method: Demosaic) -> Result<Demosaic, Invalid> {
    if !raw.metadata.is_staggered {
        return method_of_array(&raw.cfa, method);
    }
    match method {
        Demosaic::Auto | Demosaic::Bilinear => Ok(Demosaic::Bilinear),
        Demosaic::Nearest
        | Demosaic::Guided
        | Demosaic::Malvar
        | Demosaic::Menon
        | Demosaic::Markesteijn
        | Demosaic::Lmmse => {
            let message = "works for filters in rows and columns, and those of hexagonal cells are staggered";
            Err(Invalid::new("demosaic", message).help("write \"auto\" or \"bilinear\""))
        }
    }
}

/// Planes of all channels of filters in rows and columns.
fn of_rows_and_columns(
    mosaic: &[f32],
    [width, height]: [usize; 2],
    cfa: &Cfa,
    method: Demosaic,
) -> Result<Planes, Invalid> {
    let method = method_of_array(cfa, method)?;
    if !cfa.is_mosaic() {
        return Ok(apart(mosaic, [width, height], cfa));
    }
    Ok(match method {
        Demosaic::Nearest => nearest::demosaic(mosaic, width, height, cfa),
        Demosaic::Bilinear => bilinear::demosaic(mosaic, width, height, cfa),
        Demosaic::Auto | Demosaic::Lmmse => lmmse::demosaic(mosaic, width, height, cfa),
        Demosaic::Guided => guided::demosaic(mosaic, width, height, cfa),
        Demosaic::Malvar => malvar::demosaic(mosaic, width, height, cfa),
        Demosaic::Menon => menon::demosaic(mosaic, width, height, cfa),
        Demosaic::Markesteijn => markesteijn::demosaic(mosaic, width, height, cfa),
    })
}

/// Method that `method` stands for on a filter array; an error where it cannot be used there.
fn method_of_array(cfa: &Cfa, method: Demosaic) -> Result<Demosaic, Invalid> {
    let fits = match method {
        Demosaic::Auto => {
            return Ok(if cfa.is_bayer() {
                Demosaic::Menon
            } else if markesteijn::fits(cfa) {
                Demosaic::Markesteijn
            } else if lmmse::fits(cfa) {
                Demosaic::Lmmse
            } else {
                Demosaic::Guided
            });
        }
        Demosaic::Nearest | Demosaic::Bilinear | Demosaic::Guided => true,
        Demosaic::Malvar | Demosaic::Menon => cfa.is_bayer(),
        Demosaic::Markesteijn => markesteijn::fits(cfa),
        Demosaic::Lmmse => lmmse::fits(cfa),
    };
    if fits {
        return Ok(method);
    }
    let name = format!("{method:?}").to_lowercase();
    let message = if cfa.is_mosaic() {
        format!("{name} does not work for the filter array {cfa}")
    } else {
        format!("{name} does nothing for pixels without a mosaic of filters ({cfa})")
    };
    Err(Invalid::new("demosaic", message)
        .help("write \"auto\", \"nearest\", \"bilinear\" or \"guided\", which work for any"))
}

/// Separates values that lie side by side into channels.
fn apart(numbers: &[f32], [width, height]: [usize; 2], cfa: &Cfa) -> Planes {
    let samples = cfa.samples_per_pixel();
    let mut channels = planes(width, height, cfa);
    for sample in 0..samples {
        let to = &mut channels[cfa.channel_at(sample, 0)].data;
        to.par_iter_mut().zip(numbers.par_chunks_exact(samples)).for_each(|(to, pixel)| *to = pixel[sample]);
    }
    together(width, height, channels)
}

#[cfg(test)]
mod tests {
    use super::*;

    const METHODS: [Demosaic; 8] = [
        Demosaic::Auto,
        Demosaic::Nearest,
        Demosaic::Bilinear,
        Demosaic::Guided,
        Demosaic::Malvar,
        Demosaic::Menon,
        Demosaic::Markesteijn,
        Demosaic::Lmmse,
    ];
    const ARRAYS: [&str; 11] =
        ["RGGB", "BGGR", "GRBG", "GBRG", "x-trans", "quad-bayer", "nona-bayer", "rgbw", "ryyb", "mono", "full:RGB"];

    /// Mosaic that a sensor with this filter array sees of an image given as functions of (channel, x, y).
    fn mosaic(cfa: &Cfa, width: usize, height: usize, colour: impl Fn(usize, f64, f64) -> f64) -> Vec<f32> {
        let samples = cfa.samples_per_pixel();
        let number = |i: usize| {
            let (x, y) = (i % (width * samples), i / (width * samples));
            colour(cfa.channel_at(x, y), (x / samples) as f64, y as f64) as f32
        };
        (0..width * samples * height).map(number).collect()
    }

    #[test]
    fn even_colours_come_out_of_every_method_and_array_at_any_size() {
        for text in ARRAYS {
            let cfa = Cfa::parse(text).expect("known");
            for method in METHODS.into_iter().filter(|&method| method_of_array(&cfa, method).is_ok()) {
                for [width, height] in [[12, 12], [37, 23], [300, 140]] {
                    let seen = mosaic(&cfa, width, height, |c, _, _| 0.2 + 0.2 * c as f64);
                    let planes = of_rows_and_columns(&seen, [width, height], &cfa, method).expect("fits");
                    for (c, channel) in planes.channels().iter().enumerate() {
                        let expected = 0.2 + 0.2 * c as f32;
                        let wrong = channel.data.iter().position(|v| (v - expected).abs() > 1e-5);
                        assert_eq!(wrong, None, "{text} {method:?} {width} × {height} {}", channel.name);
                    }
                }
                for [width, height] in [[0, 0], [0, 3], [1, 1], [1, 9], [9, 1], [2, 2], [5, 3]] {
                    let planes =
                        of_rows_and_columns(&mosaic(&cfa, width, height, |_, _, _| 0.5), [width, height], &cfa, method);
                    let planes = planes.expect("fits");
                    assert!(planes.channels().iter().all(|c| c.data.len() == width * height));
                    assert!(planes.channels().iter().flat_map(|c| &c.data).all(|v| v.is_finite()));
                }
            }
        }
    }

    /// Peak signal-to-noise ratio, dB, of a grey zone plate whose frequency grows to 0.35 cycles a pixel at the sides.
    fn zone_plate(text: &str, method: Demosaic) -> f64 {
        let n = 192;
        let cfa = Cfa::parse(text).expect("known");
        let half = n as f64 / 2.0;
        let plate = |_: usize, x: f64, y: f64| {
            0.5 + 0.4 * (std::f64::consts::PI * 0.35 / half * ((x - half).powi(2) + (y - half).powi(2))).cos()
        };
        let planes = of_rows_and_columns(&mosaic(&cfa, n, n, plate), [n, n], &cfa, method).expect("fits");
        let (mut squares, mut count) = (0.0, 0);
        for i in (0..n * n).filter(|i| (10..n - 10).contains(&(i % n)) && (10..n - 10).contains(&(i / n))) {
            for channel in planes.channels() {
                squares += (f64::from(channel.data[i]) - plate(0, (i % n) as f64, (i / n) as f64)).powi(2);
                count += 1;
            }
        }
        -10.0 * (squares / f64::from(count)).log10()
    }

    /// Mean squares of what bilinear interpolation of a grey sinusoid of frequencies φ and ψ (rad/px) along x and y
    /// misses on a Bayer mosaic, over its amplitude's. A channel that is interpolated from both neighbours along x
    /// passes a part cos φ, along y cos ψ, from the four at the corners cos φ·cos ψ, and green from the four at the
    /// sides (cos φ + cos ψ)/2. Green is missing at half of the pixels, red and blue at a quarter each way.
    fn bilinear_loss([x, y]: [f64; 2]) -> f64 {
        let square = |passed: f64| (1.0 - passed).powi(2);
        let green = 0.5 * square(0.5 * (x.cos() + y.cos()));
        let other = 0.25 * (square(x.cos()) + square(y.cos()) + square(x.cos() * y.cos()));
        0.5 * (green + 2.0 * other) / 3.0
    }

    #[test]
    fn bilinear_interpolation_loses_of_a_zone_plate_what_its_transfer_function_says() {
        // The frequency at (x, y) from the middle is 0.35/96·(x, y) cycles/px, of which 86 px each way count.
        let (mut loss, mut count) = (0.0, 0);
        for (i, j) in (-86..86).flat_map(|i| (-86..86).map(move |j| (i, j))) {
            let frequency = [i, j].map(|k| 2.0 * std::f64::consts::PI * 0.35 / 96.0 * f64::from(k));
            loss += 0.16 * bilinear_loss(frequency);
            count += 1;
        }
        let expected = -10.0 * (loss / f64::from(count)).log10();
        let found = zone_plate("RGGB", Demosaic::Bilinear);
        // Frequencies change by 0.0036 cycles/px in a pixel, a phase of 0.011 rad: cos 0.011 of the amplitude. Rings
        // pass through all phases some 30 times on the way outwards, so that the mean of their squares is a half to a
        // few thousandths: 1 %, 0.05 dB.
        assert!((found - expected).abs() < 0.05, "{found} dB for {expected} dB");
    }

    /// Margins between the methods, which no theory gives: the figures are what they have reached, less 1 dB or so,
    /// against changes for the worse.
    #[test]
    fn what_auto_takes_is_as_far_ahead_of_simpler_methods_on_a_zone_plate_as_it_was() {
        for (text, ahead_db) in [("RGGB", 8.0), ("x-trans", 3.0), ("quad-bayer", 6.0), ("rgbw", 1.0)] {
            let [auto, bilinear, nearest] =
                [Demosaic::Auto, Demosaic::Bilinear, Demosaic::Nearest].map(|method| zone_plate(text, method));
            println!("{text}: auto {auto:.2} dB, bilinear {bilinear:.2} dB, nearest {nearest:.2} dB");
            assert!(auto > bilinear + ahead_db && bilinear > nearest, "{text}: {auto:.2} {bilinear:.2} {nearest:.2}");
        }
        let malvar = zone_plate("RGGB", Demosaic::Malvar);
        assert!(malvar > zone_plate("RGGB", Demosaic::Bilinear) + 3.0, "{malvar}");
    }

    #[test]
    fn methods_are_refused_where_they_do_not_work() {
        for (text, method) in [
            ("x-trans", Demosaic::Menon),
            ("rgbw", Demosaic::Markesteijn),
            ("mono", Demosaic::Lmmse),
            ("mono", Demosaic::Menon),
            ("full:RGB", Demosaic::Markesteijn),
        ] {
            let cfa = Cfa::parse(text).expect("known");
            let error =
                of_rows_and_columns(&mosaic(&cfa, 12, 12, |_, _, _| 0.5), [12, 12], &cfa, method).expect_err(text);
            assert_eq!(error.key, "demosaic");
        }
    }
}
