//! A lens with what depends on the wavelength tabulated, for many rays of many wavelengths.

use std::borrow::Cow;

use photosite_core::spectrum::{LAMBDA_MAX_NM, LAMBDA_MIN_NM, TABLE_LEN};

use crate::coating::transmittance_of;
use crate::lens::Lens;
use crate::profile::Travel;
use crate::trace::{Apertures, LensAt, Ray, Step, Stopped};

/// Cosines of the angle of incidence, from 0 to 1, and wavelengths at which transmittances are tabulated.
const COSINES: usize = 65;
const STEP_NM: f64 = 10.0;
const WAVELENGTHS: usize = 81;

/// A lens, its indices at each nanometre from 300 to 1100 nm, and what its surfaces let through.
#[derive(Clone, Debug)]
pub struct TabulatedLens {
    lens: Lens,
    /// By wavelength, those before each surface and behind the last.
    indices: Vec<f64>,
    /// By surface, wavelength and cosine in the thinner medium.
    transmittance: Vec<f32>,
}

impl TabulatedLens {
    /// Tabulates a lens.
    pub fn new(lens: Lens) -> Self {
        let first = f64::from(LAMBDA_MIN_NM);
        let mut indices = Vec::new();
        for i in 0..TABLE_LEN {
            let at = lens.at(first + i as f64);
            indices.extend((0..=lens.surfaces().len()).map(|surface| at.index_before(surface)));
        }
        let mut transmittance = Vec::new();
        for surface in 0..lens.surfaces().len() {
            for i in 0..WAVELENGTHS {
                let at = lens.at(first + STEP_NM * i as f64);
                let cosine = |j: usize| j as f64 / (COSINES - 1) as f64;
                transmittance.extend((0..COSINES).map(|j| transmittance_of(&at, surface, cosine(j)) as f32));
            }
        }
        Self { lens, indices, transmittance }
    }

    /// The lens.
    pub fn lens(&self) -> &Lens {
        &self.lens
    }

    /// The lens at the nearest whole nanometre, from 300 to 1100 nm.
    pub fn at(&self, wavelength_nm: f64) -> LensAt<'_> {
        let nm = wavelength_nm.round().clamp(LAMBDA_MIN_NM.into(), LAMBDA_MAX_NM.into());
        let (row, width) = ((nm - f64::from(LAMBDA_MIN_NM)) as usize, self.lens.surfaces().len() + 1);
        let index = Cow::Borrowed(&self.indices[row * width..(row + 1) * width]);
        LensAt { lens: &self.lens, wavelength_nm: nm, index }
    }

    /// The ray out into the scene of one from the sensor, and which part of the light of a wavelength the surfaces let
    /// through along it, unpolarised.
    pub fn trace_out(&self, ray: Ray, wavelength_nm: f64) -> Result<(Ray, f64), Stopped> {
        let at = self.at(wavelength_nm);
        let place = (at.wavelength_nm - f64::from(LAMBDA_MIN_NM)) / STEP_NM;
        let steps = (0..self.lens.surfaces().len()).rev().map(Step::refract);
        let mut passed = 1.0;
        let out = at.trace(ray, Travel::ToScene, steps, Apertures::Clip, |hit| {
            // On the side of the thinner medium, where the angle is larger.
            let ratio = hit.index / hit.index_behind;
            let cosine = if ratio > 1.0 { hit.turned.dot(hit.normal) } else { hit.cos_incidence };
            passed *= self.transmittance(hit.surface, place, cosine);
        })?;
        Ok((out, passed))
    }

    /// Bilinear in wavelength and cosine.
    fn transmittance(&self, surface: usize, wavelength: f64, cosine: f64) -> f64 {
        let i = (wavelength as usize).min(WAVELENGTHS - 2);
        let across = cosine.clamp(0.0, 1.0) * (COSINES - 1) as f64;
        let j = (across as usize).min(COSINES - 2);
        let (u, v) = (wavelength - i as f64, across - j as f64);
        let at = |i: usize, j: usize| f64::from(self.transmittance[(surface * WAVELENGTHS + i) * COSINES + j]);
        let row = |i: usize| at(i, j) + v * (at(i, j + 1) - at(i, j));
        row(i) + u * (row(i + 1) - row(i))
    }
}
