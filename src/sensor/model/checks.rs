//! What numbers and spectra of a sensor file must be.

use crate::Invalid;
use crate::sensor::description::SpectrumSource;
use crate::spectrum::Spectrum;

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

pub(super) fn finite(key: &str, value: f64) -> Result<(), Invalid> {
    if value.is_finite() { Ok(()) } else { Err(Invalid::new(key, format!("must be a finite number, got {value}"))) }
}

pub(super) fn positive(key: &str, value: f64, example: &str) -> Result<(), Invalid> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(Invalid::new(key, format!("must be above 0, got {value}")).help(format!("for example {key} = {example}")))
}

pub(super) fn not_negative(key: &str, value: f64) -> Result<(), Invalid> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(Invalid::new(key, format!("must not be negative, got {value}")).help("write 0 to leave this noise out"))
}
