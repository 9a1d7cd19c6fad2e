//! Finder of the files that a sensor file names.

use photosite_core::Invalid;
use photosite_core::spectrum::Spectrum;

use super::measured_pattern::{MeasuredPattern, PatternFile};
use super::spectrum_source::SpectrumSource;

/// Finder of what a sensor file names.
pub trait SensorFiles {
    /// A function of wavelength.
    fn spectrum(&mut self, source: &SpectrumSource) -> Result<Spectrum, Invalid>;

    /// A measured pattern.
    fn pattern(&mut self, file: &PatternFile) -> Result<MeasuredPattern, Invalid>;
}

/// A finder of spectra alone.
impl<F: FnMut(&SpectrumSource) -> Result<Spectrum, Invalid>> SensorFiles for F {
    fn spectrum(&mut self, source: &SpectrumSource) -> Result<Spectrum, Invalid> {
        self(source)
    }

    fn pattern(&mut self, file: &PatternFile) -> Result<MeasuredPattern, Invalid> {
        Err(Invalid::new("file", format!("{:?} does not ship with photosite", file.file)))
    }
}
