//! What reading a file came to.

use super::format::Format;
use crate::Lens;
use crate::prescription::Prescription;

/// A glass of a lens, and where its index comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct GlassOf {
    /// Surfaces behind which it is, counted from 0.
    pub surfaces: Vec<usize>,
    /// Its name.
    pub name: String,
    /// Index at the d line.
    pub nd: f64,
    /// Abbe number.
    pub vd: f64,
    /// Where the index comes from.
    pub source: String,
    /// Wavelengths that its formula was fitted to, nm.
    pub range_nm: Option<[f64; 2]>,
}

/// What was read, assumed and ignored.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// What the file is written in.
    pub format: Format,
    /// Every glass.
    pub glasses: Vec<GlassOf>,
    /// What the file does not say, and what stands for it.
    pub assumed: Vec<String>,
    /// What the file says and is not used.
    pub ignored: Vec<String>,
    /// What looks wrong, with its likely cause.
    pub warnings: Vec<String>,
}

/// A lens that was read.
#[derive(Debug)]
pub struct Reading {
    /// The prescription, which a [`Lens`] can be made of.
    pub prescription: Prescription,
    /// The lens, in its first position.
    pub lens: Lens,
    /// What was read, assumed and ignored.
    pub report: Report,
}

/// The glasses of a prescription, each once.
pub(super) fn glasses_of(prescription: &Prescription) -> Vec<GlassOf> {
    let mut found: Vec<GlassOf> = Vec::new();
    for (number, surface) in prescription.surfaces.iter().enumerate() {
        let Some(glass) = &surface.glass else { continue };
        match found.iter_mut().find(|known| known.name == glass.name && known.source == glass.source) {
            Some(known) => known.surfaces.push(number),
            None => found.push(GlassOf {
                surfaces: vec![number],
                name: glass.name.clone(),
                nd: glass.dispersion.index(photosite_core::spectrum::dispersion::lines::D),
                vd: glass.dispersion.abbe_number(),
                source: glass.source.clone(),
                range_nm: glass.range_nm,
            }),
        }
    }
    found
}

/// A number for people: its first digits.
pub(super) fn rounded(x: f64) -> f64 {
    photosite_core::math::float::rounded(x, 7)
}
