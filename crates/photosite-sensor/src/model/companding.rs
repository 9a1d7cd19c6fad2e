//! `[adc.companding]`: numbers of many bits leave the sensor as numbers of fewer, along a curve that is steep where
//! shot noise is small.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;

use super::checks::positive;

/// Companding: pixel values of the converter become values of fewer bits that leave the sensor. Raw files in the DNG
/// format tell how to make them linear again.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct CompandingDescription {
    /// Bits of the numbers that leave the sensor, 1 to those of the converter.
    #[schemars(transform = within(1.0..=16.0))]
    pub bits: u32,
    /// Straight lines: both ends and the knees in between, each as [number of the converter, number that leaves the
    /// sensor], such as [[0, 0], [1024, 1024], [65535, 4095]].
    #[schemars(transform = within(0.0..=65_535.0))]
    pub knee_points_dn: Option<Vec<[u32; 2]>>,
    /// In their place: numbers are x^(1/gamma), 1 to 5.
    #[schemars(transform = within(1.0..=5.0))]
    pub gamma: Option<f64>,
}

/// Companding: the curve from the converter's numbers to those that leave the sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Companding {
    /// Bits of the numbers that leave the sensor, 1–16.
    pub bits: u32,
    /// Along what.
    pub curve: CompandingCurve,
}

/// A curve that rises from 0 to the largest numbers of both sides.
#[derive(Clone, Debug, PartialEq)]
pub enum CompandingCurve {
    /// Straight in between these points, from numbers of the converter to numbers that leave the sensor; both rise.
    KneePoints(Vec<[u16; 2]>),
    /// y = x^(1/γ), both as parts of their largest numbers, with this γ from 1 on.
    Gamma(f64),
}

/// Beyond this, most numbers would stand for the darkest hundredth of the range.
const MAX_GAMMA: f64 = 5.0;

impl Companding {
    /// Keys of errors are those of the table `[adc.companding]`. `from_bits` are those of the converter.
    pub(super) fn new(d: &CompandingDescription, from_bits: u32) -> Result<Self, Invalid> {
        if !(1..=from_bits).contains(&d.bits) {
            let message = format!("must lie between 1 and the converter's {from_bits}, got {}", d.bits);
            return Err(Invalid::new("bits", message).help("for example bits = 12"));
        }
        let curve = match (&d.knee_points_dn, d.gamma) {
            (Some(_), Some(_)) => {
                return Err(Invalid::new("gamma", "cannot be combined with knee_points_dn").help("keep one of them"));
            }
            (None, None) => {
                let help = "for example gamma = 2.2, or knee_points_dn = [[0, 0], [1024, 1024], [65535, 4095]]";
                return Err(Invalid::new("gamma", "is missing, and so is knee_points_dn").help(help));
            }
            (None, Some(gamma)) => CompandingCurve::Gamma(checked_gamma(gamma)?),
            (Some(points), None) => CompandingCurve::KneePoints(checked_points(points, [from_bits, d.bits])?),
        };
        Ok(Self { bits: d.bits, curve })
    }

    /// The place on the curve of a number of the converter whose largest is `max_dn`.
    fn forward(&self, dn: f64, max_dn: f64) -> f64 {
        match &self.curve {
            CompandingCurve::Gamma(gamma) => self.max_dn() * (dn / max_dn).powf(1.0 / gamma),
            CompandingCurve::KneePoints(points) => interpolate(points, dn, [0, 1]),
        }
    }

    /// The number of the converter that lies on the curve at `dn`, not rounded.
    fn inverse(&self, dn: f64, max_dn: f64) -> f64 {
        match &self.curve {
            CompandingCurve::Gamma(gamma) => max_dn * (dn / self.max_dn()).powf(*gamma),
            CompandingCurve::KneePoints(points) => interpolate(points, dn, [1, 0]),
        }
    }

    /// Step between neighbouring numbers that leave the sensor, in DN of the converter, at a number of the converter;
    /// never less than 1, as the converter's own steps remain.
    pub(crate) fn step_dn(&self, dn: f64, max_dn: f64) -> f64 {
        let code = self.forward(dn.clamp(0.0, max_dn), max_dn);
        let [below, above] = [code - 0.5, code + 0.5].map(|c| self.inverse(c.clamp(0.0, self.max_dn()), max_dn));
        (above - below).max(1.0)
    }

    /// Largest number that leaves the sensor.
    fn max_dn(&self) -> f64 {
        f64::from((1u32 << self.bits) - 1)
    }

    /// The number that leaves the sensor for a level at the converter, DN, not rounded.
    pub(crate) fn level(&self, dn: f64, max_dn: u16) -> f64 {
        self.forward(dn, max_dn.into())
    }

    /// The number that leaves the sensor for one of the converter.
    pub(crate) fn code(&self, dn: u16, max_dn: u16) -> u16 {
        self.forward(dn.into(), max_dn.into()).round() as u16
    }

    /// Table of the numbers that leave the sensor, one for each number of the converter.
    pub(crate) fn table(&self, max_dn: u16) -> Vec<u16> {
        (0..=max_dn).map(|dn| self.code(dn, max_dn)).collect()
    }

    /// Table of the converter's numbers, one for each number that leaves the sensor.
    pub(crate) fn inverse_table(&self, max_dn: u16) -> Vec<f64> {
        (0..1u32 << self.bits).map(|dn| self.inverse(dn.into(), max_dn.into())).collect()
    }
}

/// The straight piece in between two points in which a coordinate lies, evaluated for the other.
fn interpolate(points: &[[u16; 2]], at: f64, [from, to]: [usize; 2]) -> f64 {
    let last = points.len().saturating_sub(2);
    let piece = points.windows(2).position(|pair| at <= f64::from(pair[1][from])).unwrap_or(last);
    let [a, b] = [points[piece], points[piece + 1]].map(|point| [point[from], point[to]].map(f64::from));
    a[1] + (b[1] - a[1]) * (at - a[0]) / (b[0] - a[0])
}

fn checked_gamma(gamma: f64) -> Result<f64, Invalid> {
    positive("gamma", gamma, "2.2")?;
    if !(1.0..=MAX_GAMMA).contains(&gamma) {
        return Err(Invalid::new("gamma", format!("must lie between 1 and {MAX_GAMMA}, got {gamma}"))
            .help("numbers are x^(1/gamma): for example gamma = 2.2"));
    }
    Ok(gamma)
}

fn checked_points(points: &[[u32; 2]], bits: [u32; 2]) -> Result<Vec<[u16; 2]>, Invalid> {
    let ends = [[0, 0], bits.map(|bits| (1u32 << bits) - 1)];
    let rise = points.windows(2).all(|pair| pair[0][0] < pair[1][0] && pair[0][1] < pair[1][1]);
    if !rise || points.len() < 2 || [points[0], points[points.len() - 1]] != ends {
        let message = format!("must rise from [0, 0] to {:?} in both columns, got {points:?}", ends[1]);
        let help = "write [number of the converter, number that leaves the sensor] for every knee and both ends";
        return Err(Invalid::new("knee_points_dn", message).help(help));
    }
    // Between the ends, which 16 bits hold.
    Ok(points.iter().map(|point| point.map(|dn| dn as u16)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The curve of a 20-bit sensor for cars scaled to 16 bits, a gamma, and no curve at all.
    fn compandings() -> [Companding; 3] {
        let points = vec![[0, 0], [512, 512], [2048, 1280], [16_384, 2688], [65_535, 4095]];
        [
            Companding { bits: 12, curve: CompandingCurve::KneePoints(points) },
            Companding { bits: 10, curve: CompandingCurve::Gamma(2.2) },
            Companding { bits: 16, curve: CompandingCurve::KneePoints(vec![[0, 0], [65_535, 65_535]]) },
        ]
    }

    #[test]
    fn the_way_back_is_good_to_half_a_step() {
        for companding in compandings() {
            let (table, inverse) = (companding.table(u16::MAX), companding.inverse_table(u16::MAX));
            assert_eq!((table[0], table[65_535]), (0, ((1u32 << companding.bits) - 1) as u16));
            assert_eq!((inverse[0], inverse[inverse.len() - 1]), (0.0, 65_535.0));
            for dn in 0..=u16::MAX {
                let code = usize::from(table[usize::from(dn)]);
                let back = inverse[code];
                // Half way to the neighbours, which lie a step away on each side.
                let below = if code > 0 { back - inverse[code - 1] } else { 0.0 };
                let above = if code + 1 < inverse.len() { inverse[code + 1] - back } else { 0.0 };
                // The upper neighbour is further away on a convex curve; the last number has none, and 1/4·γ/1023 more.
                let error = (f64::from(dn) - back).abs();
                assert!(error <= 0.501 * below.max(above) + 1e-9, "{dn} → {code} → {back}");
                let step = companding.step_dn(dn.into(), 65_535.0);
                assert!(step >= 1.0 && step <= below.max(above).max(1.0) + 1e-9, "{step} at {dn}");
            }
        }
    }

    #[test]
    fn knees_by_hand() {
        let [pieces, gamma, _] = compandings();
        let table = pieces.table(u16::MAX);
        // 512 + 768·(1024 − 512)/1536 = 768; 1280 + 1408·(9216 − 2048)/14336 = 1984.
        assert_eq!([100, 512, 1024, 2048, 9216].map(|dn: usize| table[dn]), [100, 512, 768, 1280, 1984]);
        // 1023·(6554/65535)^(1/2.2) = 1023·0.100008^0.454545 = 1023·0.351133 = 359.2.
        assert_eq!(gamma.table(u16::MAX)[6554], 359);
    }
}
