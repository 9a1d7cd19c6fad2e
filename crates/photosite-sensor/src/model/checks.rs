//! Checks of the numbers and spectra of a sensor file.

use photosite_core::Invalid;
use photosite_core::spectrum::Spectrum;
use photosite_core::units::Electrons;

use super::spectrum_source::SpectrumSource;

pub(super) fn fraction(
    key: &str,
    source: &SpectrumSource,
    resolve: &mut impl FnMut(&SpectrumSource) -> Result<Spectrum, Invalid>,
) -> Result<Spectrum, Invalid> {
    let spectrum = resolve(source).map_err(|e| e.within(key))?;
    let outside = spectrum.iter().find(|(_, value)| !(0.0..=1.0).contains(value));
    if let Some((lambda_nm, value)) = outside {
        let message = format!("must lie between 0 and 1, but is {} at {lambda_nm} nm", value as f32);
        return Err(Invalid::new(key, message).help("give a fraction, not a percentage"));
    }
    Ok(spectrum)
}

pub(super) fn finite(key: &str, value: f64) -> Result<f64, Invalid> {
    if value.is_finite() { Ok(value) } else { Err(Invalid::new(key, format!("must be a finite number, got {value}"))) }
}

pub(super) fn positive(key: &str, value: f64, example: &str) -> Result<f64, Invalid> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(Invalid::new(key, format!("must be above 0, got {value}")).help(format!("for example {key} = {example}")))
}

pub(super) fn not_negative(key: &str, value: f64) -> Result<f64, Invalid> {
    if value.is_finite() && value >= 0.0 {
        return Ok(value);
    }
    Err(Invalid::new(key, format!("must not be negative, got {value}")).help("write 0 to leave this out"))
}

/// Part of one of a number per million.
pub(super) fn in_a_million(key: &str, value: f64) -> Result<f64, Invalid> {
    if (0.0..=1e6).contains(&value) {
        return Ok(value * 1e-6);
    }
    Err(Invalid::new(key, format!("must lie between 0 and 1000000, got {value}"))
        .help("write how many of a million pixels, 0 for none"))
}

/// A part that is lost at each of many steps: 0 to below 1.
pub(super) fn fraction_below_one(key: &str, value: f64) -> Result<f64, Invalid> {
    if (0.0..1.0).contains(&value) {
        return Ok(value);
    }
    Err(Invalid::new(key, format!("must be at least 0 and below 1, got {value}"))
        .help(format!("for example {key} = 1e-5; write 0 for none")))
}

/// Columns or rows beyond this are a slip of the pen: the largest sensors made have some 30 000.
pub(super) const MAX_RESOLUTION: u32 = 65_535;

/// More wells than this are a slip of the pen.
const MAX_MARGIN: u32 = 4096;

/// A number of columns or rows beside the pixels.
pub(super) fn margin(key: &str, number: u32) -> Result<usize, Invalid> {
    if number > MAX_MARGIN {
        return Err(Invalid::new(key, format!("must be at most {MAX_MARGIN}, got {number}")));
    }
    Ok(number as usize)
}

/// A number of electrons, not negative.
pub(super) fn electrons(key: &str, value: f64) -> Result<Electrons, Invalid> {
    not_negative(key, value).map(Electrons)
}
