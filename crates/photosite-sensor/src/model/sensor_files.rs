//! Finder of the files that a sensor file names.

use photosite_core::Invalid;
use photosite_core::spectrum::Spectrum;

use super::defects::DefectFile;
use super::measured_pattern::{MeasuredPattern, PatternFile};
use super::spectrum_source::SpectrumSource;

/// Finder of what a sensor file names.
pub trait SensorFiles {
    /// A function of wavelength.
    fn spectrum(&mut self, source: &SpectrumSource) -> Result<Spectrum, Invalid>;

    /// A measured pattern.
    fn pattern(&mut self, file: &PatternFile) -> Result<MeasuredPattern, Invalid>;

    /// Text of a table of defective pixels.
    fn defects(&mut self, file: &DefectFile) -> Result<String, Invalid>;
}

/// A finder of spectra alone.
impl<F: FnMut(&SpectrumSource) -> Result<Spectrum, Invalid>> SensorFiles for F {
    fn spectrum(&mut self, source: &SpectrumSource) -> Result<Spectrum, Invalid> {
        self(source)
    }

    fn pattern(&mut self, file: &PatternFile) -> Result<MeasuredPattern, Invalid> {
        Err(does_not_ship(&file.file))
    }

    fn defects(&mut self, file: &DefectFile) -> Result<String, Invalid> {
        Err(does_not_ship(&file.file))
    }
}

fn does_not_ship(file: &str) -> Invalid {
    Invalid::new("file", format!("{file:?} does not ship with photosite"))
}
