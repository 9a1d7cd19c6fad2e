//! Wavelengths of a path, for hero-wavelength sampling ([Wilkie14](crate::references#wilkie14)).

use glam::Vec4;

use super::{LAMBDA_MAX_NM, LAMBDA_MIN_NM, LANES, SampledSpectrum, TABLE_LEN};

/// Four wavelengths with their densities. The first, the hero, decides wherever a direction depends on wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wavelengths {
    pub(super) lambda_nm: [f32; LANES],
    /// Density of each wavelength, nm⁻¹; zero for a lane that the path no longer carries.
    pub(super) pdf: [f32; LANES],
    /// Entry of a spectral table at or below each wavelength, at most the last but one.
    pub(super) entry: [u32; LANES],
    /// Fraction of the way of each wavelength from that entry to the next, 0 to 1.
    pub(super) part: [f32; LANES],
}

impl Wavelengths {
    /// Wavelengths in nm, 300 to 1100, and their densities in nm⁻¹.
    #[inline]
    pub fn new(lambda_nm: [f32; LANES], pdf: [f32; LANES]) -> Self {
        debug_assert!(lambda_nm.iter().all(|lambda| (LAMBDA_MIN_NM..=LAMBDA_MAX_NM).contains(lambda)));
        let places = lambda_nm.map(place_in_table);
        Self { lambda_nm, pdf, entry: places.map(|(entry, _)| entry), part: places.map(|(_, part)| part) }
    }

    /// Wavelength of a lane, nm.
    #[inline]
    pub fn lambda_nm(&self, lane: usize) -> f32 {
        self.lambda_nm[lane]
    }

    /// All four wavelengths, nm.
    #[inline]
    pub fn lambdas_nm(&self) -> [f32; LANES] {
        self.lambda_nm
    }

    /// Position of a lane's wavelength in a spectral table: the entry before it, at most the last but one, and the
    /// fraction of the way to the next.
    #[inline]
    pub fn place_in_table(&self, lane: usize) -> (usize, f32) {
        (self.entry[lane] as usize, self.part[lane])
    }

    /// Drops all but the hero, after a refraction whose direction is right for the hero alone. The hero then stands for
    /// all four: its density falls to a quarter ([pbrt4](crate::references#pbrt4) §4.5.4). A second call has no effect.
    pub fn terminate_secondary(&mut self) {
        if self.is_hero_alone() {
            return;
        }
        self.pdf = [self.pdf[0] / LANES as f32, 0.0, 0.0, 0.0];
    }

    /// Whether the path carries only the hero.
    #[inline]
    pub fn is_hero_alone(&self) -> bool {
        self.pdf[1..].iter().all(|&pdf| pdf == 0.0)
    }

    /// Densities of `other` over these, zero for dropped lanes, where these wavelengths are some of the other's. A
    /// value multiplied by the ratios goes with the other's weights instead of these.
    #[inline]
    pub fn densities_over(&self, other: &Self) -> SampledSpectrum {
        SampledSpectrum::from_lanes(|i| if self.pdf[i] > 0.0 { other.pdf[i] / self.pdf[i] } else { 0.0 })
    }

    /// Monte Carlo weights 1/(4·p(λᵢ)) in nm, zero for dropped lanes: Σᵢ wᵢ·g(λᵢ) estimates ∫ g dλ.
    #[inline]
    pub fn weights(&self) -> SampledSpectrum {
        let pdf = Vec4::from_array(self.pdf);
        let weights = Vec4::ONE / (LANES as f32 * pdf);
        SampledSpectrum(Vec4::select(pdf.cmpgt(Vec4::ZERO), weights, Vec4::ZERO))
    }
}

/// Position in a table of a wavelength of 300 to 1100 nm: the entry at or below it, at most the last but one, and the
/// fraction of the way to the next, 0 to 1.
#[inline]
pub(super) fn place_in_table(lambda_nm: f32) -> (u32, f32) {
    let x = lambda_nm - LAMBDA_MIN_NM;
    let entry = (x as u32).min(TABLE_LEN as u32 - 2);
    (entry, x - entry as f32)
}
