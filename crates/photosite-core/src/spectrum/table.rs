//! A function of wavelength at rest: one value every nanometre.

use super::planck::planck;
use super::wavelengths::place_in_table;
use super::{LAMBDA_MAX_NM, LAMBDA_MIN_NM, SampledSpectrum, TABLE_LEN, Wavelengths};
use crate::Invalid;

/// Extrapolation of a spectrum beyond its measured wavelengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// Zero: emission, quantum efficiency, colour-matching functions.
    Zero,
    /// The value at the nearest measured wavelength: reflectance, refractive index.
    Hold,
    /// A blackbody of this temperature in kelvin, scaled to the last value beyond it, and zero before the first:
    /// daylight, whose tables end at 830 nm.
    Blackbody(u32),
}

/// A function of wavelength, tabulated every nanometre from 300 to 1100 nm and linear in between; zero outside.
///
/// The unit is that of whatever the table stands for: dimensionless (reflectance, quantum efficiency, index), or
/// W·m⁻²·sr⁻¹·nm⁻¹ (radiance), W·m⁻²·nm⁻¹ (irradiance), W·sr⁻¹·nm⁻¹ (intensity). Structure finer than 1 nm, as that of
/// gas-discharge lines, is lost when a table is made, but not its energy if the data come as 1 nm bins.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    values: Box<[f32; TABLE_LEN]>,
    /// First and last stated wavelength, see [`known_nm`](Self::known_nm).
    known_nm: [f32; 2],
}

impl Spectrum {
    /// The whole range of a table, nm.
    pub const EVERYWHERE_NM: [f32; 2] = [LAMBDA_MIN_NM, LAMBDA_MAX_NM];

    /// A constant spectrum.
    pub fn constant(value: f32) -> Self {
        Self { values: Box::new([value; TABLE_LEN]), known_nm: Self::EVERYWHERE_NM }
    }

    /// Tabulates `f`, a function of the wavelength in nm.
    pub fn from_fn(mut f: impl FnMut(f64) -> f64) -> Self {
        let mut values = Box::new([0.0; TABLE_LEN]);
        for (i, value) in values.iter_mut().enumerate() {
            *value = f(f64::from(LAMBDA_MIN_NM) + i as f64) as f32;
        }
        Self { values, known_nm: Self::EVERYWHERE_NM }
    }

    /// Interpolates measured samples linearly. Wavelengths in nm, finite and strictly increasing; values finite.
    pub fn from_samples(lambda_nm: &[f64], values: &[f64], outside: Outside) -> Result<Self, Invalid> {
        if lambda_nm.is_empty() || lambda_nm.len() != values.len() {
            let counts = format!("{} wavelengths and {} values", lambda_nm.len(), values.len());
            return Err(Invalid::new("", counts).help("give as many values as wavelengths, at least one"));
        }
        if let Some(i) = (0..values.len()).find(|&i| !lambda_nm[i].is_finite() || !values[i].is_finite()) {
            return Err(Invalid::new("", format!("sample {} is not a finite number", i + 1)));
        }
        if let Some(pair) = lambda_nm.windows(2).find(|pair| pair[0] >= pair[1]) {
            let message = format!("wavelength {} nm does not come after {} nm", pair[1], pair[0]);
            return Err(Invalid::new("", message).help("sort the rows by wavelength and remove repeated ones"));
        }
        let last = values.len() - 1;
        let spectrum = Self::from_fn(|lambda| {
            let above = lambda_nm.partition_point(|&l| l < lambda);
            if above <= last && lambda_nm[above] == lambda {
                return values[above];
            }
            if above == 0 || above > last {
                return match outside {
                    Outside::Zero => 0.0,
                    Outside::Hold => values[above.min(last)],
                    Outside::Blackbody(_) if above == 0 => 0.0,
                    Outside::Blackbody(temperature_k) => {
                        let [here, end] = [lambda, lambda_nm[last]].map(|l| planck(l, f64::from(temperature_k)));
                        values[last] * here / end
                    }
                };
            }
            let t = (lambda - lambda_nm[above - 1]) / (lambda_nm[above] - lambda_nm[above - 1]);
            values[above - 1] * (1.0 - t) + values[above] * t
        });
        Ok(spectrum.known_within([lambda_nm[0] as f32, lambda_nm[last] as f32]))
    }

    /// First and last wavelength that the source of the spectrum states, nm; beyond them a rule such as [`Outside`] has
    /// been applied. A product is known where all its factors are; the first may exceed the last, then it is known
    /// nowhere.
    pub fn known_nm(&self) -> [f32; 2] {
        self.known_nm
    }

    /// Spectrum of the same values, known between these wavelengths (nm) at most.
    #[must_use]
    pub fn known_within(self, [first, last]: [f32; 2]) -> Self {
        let known_nm = [self.known_nm[0].max(first), self.known_nm[1].min(last)];
        Self { known_nm, ..self }
    }

    /// Value at a wavelength in nm; zero outside 300–1100 nm.
    #[inline]
    pub fn eval(&self, lambda_nm: f32) -> f32 {
        if !(LAMBDA_MIN_NM..=LAMBDA_MAX_NM).contains(&lambda_nm) {
            return 0.0;
        }
        let (entry, part) = place_in_table(lambda_nm);
        let [value, next] = [0, 1].map(|i| self.values[entry as usize + i]);
        value + (next - value) * part
    }

    /// Values at the wavelengths of a path.
    #[inline]
    pub fn sample(&self, wavelengths: &Wavelengths) -> SampledSpectrum {
        SampledSpectrum::from_lanes(|i| self.eval(wavelengths.lambda_nm(i)))
    }

    /// The table: value at 300 nm, 301 nm, … 1100 nm.
    pub fn values(&self) -> &[f32; TABLE_LEN] {
        &self.values
    }

    /// (wavelength in nm, value) for every entry.
    pub fn iter(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.values.iter().enumerate().map(|(i, &v)| (f64::from(LAMBDA_MIN_NM) + i as f64, f64::from(v)))
    }

    /// ∫ over 300–1100 nm, in the table's unit times nm; exact for the piecewise linear function.
    pub fn integral(&self) -> f64 {
        let sum: f64 = self.values.iter().map(|&v| f64::from(v)).sum();
        sum - 0.5 * f64::from(self.values[0] + self.values[TABLE_LEN - 1])
    }

    /// Spectrum of `f(wavelength in nm, value)` at every entry.
    #[must_use]
    pub fn map(&self, mut f: impl FnMut(f64, f64) -> f64) -> Self {
        let mut i = 0;
        let mapped = Self::from_fn(|lambda| {
            i += 1;
            f(lambda, f64::from(self.values[i - 1]))
        });
        mapped.known_within(self.known_nm)
    }

    /// Every value times `factor`.
    #[must_use]
    pub fn scale(&self, factor: f64) -> Self {
        self.map(|_, v| v * factor)
    }

    /// Product with another spectrum, entry by entry.
    #[must_use]
    pub fn product(&self, other: &Self) -> Self {
        self.map_with(other, |a, b| a * b)
    }

    /// Spectrum of `f(value, value of other)` at every entry.
    #[must_use]
    pub fn map_with(&self, other: &Self, mut f: impl FnMut(f64, f64) -> f64) -> Self {
        let mut others = other.values.iter();
        let mapped = self.map(|_, value| f(value, f64::from(*others.next().unwrap_or(&0.0))));
        mapped.known_within(other.known_nm)
    }

    /// Smallest value.
    pub fn min(&self) -> f32 {
        self.values.iter().copied().fold(f32::INFINITY, f32::min)
    }

    /// Largest value.
    pub fn max(&self) -> f32 {
        self.values.iter().copied().fold(f32::NEG_INFINITY, f32::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_interpolated_and_extended_as_asked() {
        let held = Spectrum::from_samples(&[400.0, 500.0], &[1.0, 3.0], Outside::Hold).expect("valid");
        assert_eq!([held.eval(300.0), held.eval(425.5), held.eval(500.0), held.eval(1100.0)], [1.0, 1.51, 3.0, 3.0]);
        let zero = Spectrum::from_samples(&[400.0, 500.0], &[1.0, 3.0], Outside::Zero).expect("valid");
        assert_eq!([zero.eval(399.0), zero.eval(400.0), zero.eval(500.0), zero.eval(501.0)], [0.0, 1.0, 3.0, 0.0]);
        assert_eq!(zero.eval(1101.0), 0.0);
    }

    #[test]
    fn integral_of_a_ramp_is_exact() {
        let ramp = Spectrum::from_fn(|lambda| lambda - 300.0);
        assert!((ramp.integral() - 0.5 * 800.0 * 800.0).abs() < 1e-6);
    }

    #[test]
    fn unsorted_missing_and_infinite_samples_are_refused() {
        for (lambda, values) in [
            (vec![500.0, 400.0], vec![1.0, 1.0]),
            (vec![400.0, 400.0], vec![1.0, 1.0]),
            (vec![400.0], vec![]),
            (vec![], vec![]),
            (vec![400.0, f64::NAN], vec![1.0, 1.0]),
            (vec![400.0, 500.0], vec![1.0, f64::INFINITY]),
        ] {
            assert!(Spectrum::from_samples(&lambda, &values, Outside::Hold).is_err(), "{lambda:?} {values:?}");
        }
    }
}
