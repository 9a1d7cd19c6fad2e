//! The clear sky and the sun, spectrally, by Hosek and Wilkie
//! ([HosekWilkie12](photosite_core::references#hosekwilkie12),
//! [HosekWilkie13](photosite_core::references#hosekwilkie13)).
//!
//! In: where the sun stands, how hazy the air is, how bright the ground. Out: radiance from every direction,
//! W·m⁻²·sr⁻¹·nm⁻¹. The model knows 320–720 nm. Beyond, where sensors of silicon still see, this is assumed: above 720
//! nm the sun goes on as a blackbody of 5778 K, and the sky as that scattered in proportion to λ⁻⁴; below 320 nm both
//! fall to nothing at 300 nm, where ozone absorbs. Bands of water vapour are not there. Below the horizon lies the ground
//! that the model has the sky lit by, a Lambertian plane at infinity: radiance ρ·E/π, with the albedo ρ and the irradiance
//! E of sky and sun on it.

use std::f32::consts::{PI, TAU};
use std::sync::OnceLock;

use glam::Vec3;

use super::above_mean::above_mean;
use crate::geometry::{NONE, Word, word};
use photosite_core::math::distribution::PiecewiseConstant2D;
use photosite_core::math::{Frame, Pdf, SolidAngle, warp};
use photosite_core::spectrum::{SampledSpectrum, Spectrum, SpectrumId, SpectrumTable, Wavelengths, cie, illuminant};

/// Wavelengths that the model has, nm.
pub(super) const FIRST_NM: f32 = 320.0;
pub(super) const STEP_NM: f32 = 40.0;
const LAST_NM: f32 = 720.0;
pub(super) const KNOTS: usize = 11;
/// Parameters of a knot, and its radiance after them.
const NUMBERS: usize = 10;
const TURBIDITIES: usize = 10;
const ELEVATIONS: usize = 6;
const SUN_SEGMENTS: usize = 45;
const SUN_POWERS: usize = 4;
const LIMB_POWERS: usize = 6;
/// Half the angle that the sun is seen under, rad.
const SUN_RADIUS_RAD: f64 = 0.5358 / 2.0 * std::f64::consts::PI / 180.0;
const SUN_TEMPERATURE_K: f64 = 5778.0;

/// The file: see `assets/sky/make.py`.
const FILE: &[u8] = include_bytes!("../../assets/sky/hosek-wilkie.bin");

/// Conditions that determine the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyConditions {
    /// Unit vector to the sun, not below the horizon (+Y is up).
    pub towards_sun: glam::DVec3,
    /// Linke turbidity, 1 (clear) to 10 (haze).
    pub turbidity: f64,
    /// Reflectance of the ground, 0–1, which the sky is lit by and which lies below the horizon.
    pub ground_albedo: f64,
    /// Whether the sun's disk is part of the sky.
    pub has_sun: bool,
}

/// Light that comes from sky, sun and ground together.
#[derive(Clone, Debug)]
pub struct SkyLight {
    /// Integral ∫ L dω over all directions, W·m⁻²·nm⁻¹.
    pub all: Spectrum,
    /// Radiance of the ground below the horizon, W·m⁻²·sr⁻¹·nm⁻¹.
    pub ground: Spectrum,
}

/// Sky, sun and ground as an environment.
#[derive(Clone, Debug)]
pub struct Sky {
    knots: [Knot; KNOTS],
    /// Radiance over that at the last wavelength of the model beyond it, and over that at the first one before it.
    tail: SpectrumId,
    towards_sun: Vec3,
    /// Mean radiance of the sun's disk.
    sun: Option<SpectrumId>,
    cos_sun_radius: f32,
    /// Radiance of the ground.
    ground: SpectrumId,
    /// Part of the samples that go to the sun.
    sun_part: f32,
    /// Distribution, over azimuth and angle from the zenith, of the excess over the mean of the sky above and the
    /// ground below.
    distribution: PiecewiseConstant2D,
    excess: f64,
}

/// The sky at a wavelength: parameters A–I and mean radiance of
/// [HosekWilkie12](photosite_core::references#hosekwilkie12) eq. 8.
type Knot = [f32; NUMBERS];

fn numbers() -> &'static [f32] {
    static NUMBERS: OnceLock<Vec<f32>> = OnceLock::new();
    NUMBERS.get_or_init(|| FILE.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect())
}

/// Index at which the sun's numbers begin.
const SUN_FROM: usize = TURBIDITIES * 2 * ELEVATIONS * KNOTS * NUMBERS;
const LIMB_FROM: usize = SUN_FROM + TURBIDITIES * SUN_SEGMENTS * KNOTS * SUN_POWERS;

/// The two neighbours of a turbidity with their weights.
fn turbidities(turbidity: f64) -> [(usize, f64); 2] {
    let at = (turbidity - 1.0).clamp(0.0, (TURBIDITIES - 1) as f64);
    let low = (at as usize).min(TURBIDITIES - 2);
    [(low, 1.0 - (at - low as f64)), (low + 1, at - low as f64)]
}

/// The parameters for a sun at an elevation, rad: a Bézier curve of degree 5 in ∛(elevation/90°), linear in turbidity
/// and albedo.
fn knots(conditions: &SkyConditions, elevation: f64) -> [Knot; KNOTS] {
    let x = (elevation / std::f64::consts::FRAC_PI_2).clamp(0.0, 1.0).cbrt();
    let binomials = [1.0, 5.0, 10.0, 10.0, 5.0, 1.0];
    let albedos = [(0, 1.0 - conditions.ground_albedo), (1, conditions.ground_albedo)];
    let mut sums = [[0.0; NUMBERS]; KNOTS];
    for (turbidity, weight) in turbidities(conditions.turbidity) {
        for (albedo, part) in albedos {
            for (i, binomial) in (0..).zip(binomials) {
                let weight = weight * part * binomial * x.powi(i) * (1.0 - x).powi(5 - i);
                let from = ((turbidity * 2 + albedo) * ELEVATIONS + i as usize) * KNOTS * NUMBERS;
                for (sum, number) in sums.as_flattened_mut().iter_mut().zip(&numbers()[from..]) {
                    *sum += weight * f64::from(*number);
                }
            }
        }
    }
    sums.map(|knot| knot.map(|number| number as f32))
}

/// Radiance of the sun's disk at the wavelengths of the model: a polynomial in the elevation for each of 45 segments,
/// times the mean of the darkening towards the limb, Σ cⱼ·μʲ, which over the disk is Σ cⱼ·2/(j + 2).
fn sun_knots(turbidity: f64, elevation: f64) -> [f64; KNOTS] {
    let half = std::f64::consts::FRAC_PI_2;
    let segment = (((elevation / half).max(0.0).cbrt() * SUN_SEGMENTS as f64) as usize).min(SUN_SEGMENTS - 1);
    let x = elevation - half * (segment as f64 / SUN_SEGMENTS as f64).powi(3);
    std::array::from_fn(|knot| {
        let mut centre = 0.0;
        for (turbidity, weight) in turbidities(turbidity) {
            let from = SUN_FROM + ((turbidity * SUN_SEGMENTS + segment) * KNOTS + knot) * SUN_POWERS;
            for (power, coefficient) in (0..).zip(&numbers()[from..from + SUN_POWERS]) {
                centre += weight * f64::from(*coefficient) * x.powi(power);
            }
        }
        let limb = &numbers()[LIMB_FROM + knot * LIMB_POWERS..][..LIMB_POWERS];
        let mean: f64 = (0..).zip(limb).map(|(power, c)| f64::from(*c) * 2.0 / (f64::from(power) + 2.0)).sum();
        (centre * mean).max(0.0)
    })
}

/// Radiance relative to that of the nearest wavelength of the model; 1 within it.
fn tail(lambda_nm: f64, scatters: bool) -> f64 {
    let (first, last) = (f64::from(FIRST_NM), f64::from(LAST_NM));
    if lambda_nm < first {
        return ((lambda_nm - 300.0) / (first - 300.0)).max(0.0);
    }
    if lambda_nm <= last {
        return 1.0;
    }
    let planck = |lambda| illuminant::planck(lambda, SUN_TEMPERATURE_K);
    planck(lambda_nm) / planck(last) * if scatters { (last / lambda_nm).powi(4) } else { 1.0 }
}

/// The part of the sun's disk above the horizon, and the mean of max(cos θ, 0) over the disk, θ from the zenith: by strips
/// of it, level as the horizon is.
fn disk_above_horizon(elevation: f64) -> [f64; 2] {
    const STRIPS: u32 = 64;
    let (mut all, mut above, mut cosines) = (0.0, 0.0, 0.0);
    for strip in 0..STRIPS {
        let height = (f64::from(2 * strip + 1) / f64::from(STRIPS)) - 1.0;
        let width = (1.0 - height * height).sqrt();
        let cosine = (elevation + height * SUN_RADIUS_RAD).sin().max(0.0);
        all += width;
        cosines += width * cosine;
        above += if cosine > 0.0 { width } else { 0.0 };
    }
    [above / all, cosines / all]
}

/// A spectrum through the wavelengths of the model and beyond.
fn spectrum(knots: &[f64; KNOTS], scatters: bool) -> Spectrum {
    Spectrum::from_fn(|lambda| {
        let (low, part) = knot_at(lambda as f32);
        (knots[low] * (1.0 - f64::from(part)) + knots[low + 1] * f64::from(part)) * tail(lambda, scatters)
    })
}

/// The knot below a wavelength, and how far it is to the next.
#[inline]
fn knot_at(lambda_nm: f32) -> (usize, f32) {
    let at = (lambda_nm.clamp(FIRST_NM, LAST_NM) - FIRST_NM) / STEP_NM;
    let low = (at as usize).min(KNOTS - 2);
    (low, at - low as f32)
}

/// Radiance of the sky at a knot ([HosekWilkie12](photosite_core::references#hosekwilkie12) eq. 8), θ from the zenith,
/// γ from the sun.
#[inline]
fn radiance_at([a, b, c, d, e, f, g, h, i, level]: &Knot, cos_theta: f32, gamma: f32, cos_gamma: f32) -> f32 {
    let chi = (1.0 + cos_gamma * cos_gamma) / (1.0 + i * i - 2.0 * i * cos_gamma).powf(1.5);
    let low = 1.0 + a * (b / (cos_theta + 0.01)).exp();
    let high = c + d * (e * gamma).exp() + f * cos_gamma * cos_gamma + g * chi + h * cos_theta.max(0.0).sqrt();
    (low * high * level).max(0.0)
}

impl Sky {
    /// First and last wavelength of the model, nm.
    pub const KNOWN_NM: [f32; 2] = [FIRST_NM, LAST_NM];

    /// Puts the sky into tables; returns also its light.
    pub fn new(conditions: &SkyConditions, spectra: &mut SpectrumTable) -> (Self, SkyLight) {
        let elevation = conditions.towards_sun.y.clamp(0.0, 1.0).asin();
        let knots = knots(conditions, elevation);
        let towards_sun = conditions.towards_sun.as_vec3();

        // Luminance over a grid of directions, with the horizon between two of its rows, and what each wavelength brings
        // in all, from every direction and onto the ground.
        const ROWS: usize = 128;
        const ABOVE: usize = ROWS / 2;
        const COLUMNS: usize = 128;
        const WITHIN: usize = 2;
        let hat = |knot: usize| spectrum(&std::array::from_fn(|k| f64::from(u8::from(k == knot))), true);
        let luminous: [f64; KNOTS] = std::array::from_fn(|knot| cie::luminous(&hat(knot)));
        // Of each cell the mean by solid angle, and of each row the mean sine.
        let mut luminances = vec![0.0; ABOVE * COLUMNS];
        let mut sines = [0.0; ROWS];
        let [mut totals, mut onto_ground] = [[0.0; KNOTS]; 2];
        for row in 0..ROWS * WITHIN {
            for column in 0..COLUMNS * WITHIN {
                let centre = |i: usize, n: usize| (i as f32 + 0.5) / (n * WITHIN) as f32;
                let (direction, sin_theta) = direction([centre(column, COLUMNS), centre(row, ROWS)]);
                let weight = f64::from(sin_theta) / (WITHIN * WITHIN) as f64;
                sines[row / WITHIN] += weight / COLUMNS as f64;
                if row >= ABOVE * WITHIN {
                    continue;
                }
                let cell = TAU * PI * sin_theta / (ROWS * COLUMNS * WITHIN * WITHIN) as f32;
                let gamma = direction.dot(towards_sun).clamp(-1.0, 1.0);
                let mut luminance = 0.0;
                for (i, knot) in knots.iter().enumerate() {
                    let radiance = f64::from(radiance_at(knot, direction.y, gamma.acos(), gamma));
                    totals[i] += radiance * f64::from(cell);
                    onto_ground[i] += radiance * f64::from(cell * direction.y);
                    luminance += radiance * luminous[i];
                }
                luminances[row / WITHIN * COLUMNS + column / WITHIN] += luminance * weight;
            }
        }
        luminances.iter_mut().enumerate().for_each(|(i, luminance)| *luminance /= sines[i / COLUMNS]);
        let sun = conditions.has_sun.then(|| spectrum(&sun_knots(conditions.turbidity, elevation), false));
        let cos_sun_radius = SUN_RADIUS_RAD.cos();
        let sun_angle = std::f64::consts::TAU * (1.0 - cos_sun_radius);
        let [sun_above, sun_cosine] = disk_above_horizon(elevation);
        let with_sun = |rest: Spectrum, factor: f64| match &sun {
            Some(sun) => rest.map_with(sun, |rest, sun| rest + factor * sun),
            None => rest,
        };
        let irradiance = with_sun(spectrum(&onto_ground, true), sun_angle * sun_cosine);
        let ground = irradiance.scale(conditions.ground_albedo / std::f64::consts::PI);
        luminances.resize(ROWS * COLUMNS, cie::luminous(&ground));
        let (weights, excess_of_rest) = above_mean(&luminances, &sines);
        let rest = spectrum(&totals, true).map_with(&ground, |sky, ground| sky + std::f64::consts::TAU * ground);
        let of_rest = cie::luminous(&rest);
        let of_sun = sun.as_ref().map_or(0.0, cie::luminous) * sun_angle * sun_above;
        let all = with_sun(rest, sun_angle * sun_above);
        let looked_at = of_sun + of_rest * excess_of_rest;
        let sky = Self {
            knots,
            tail: spectra.add(&Spectrum::from_fn(|lambda| tail(lambda, true))),
            towards_sun,
            sun: sun.map(|sun| spectra.add(&sun)),
            cos_sun_radius: cos_sun_radius as f32,
            ground: spectra.add(&ground),
            // Both deserve some, whatever their power: either can be hidden from a point.
            sun_part: if conditions.has_sun {
                (of_sun / looked_at.max(f64::MIN_POSITIVE)).clamp(0.25, 0.75) as f32
            } else {
                0.0
            },
            distribution: PiecewiseConstant2D::new(&weights, COLUMNS),
            excess: looked_at / (of_sun + of_rest).max(f64::MIN_POSITIVE),
        };
        (sky, SkyLight { all, ground })
    }

    /// Sky as plain data: direction of the sun with the cosine of its radius; spectra of the tail, the sun and the ground,
    /// with the part of the samples that go to the sun; the numbers of each knot in three words.
    pub(super) fn words(&self) -> Vec<Word> {
        let Self { knots, tail, towards_sun, sun, cos_sun_radius, ground, sun_part, .. } = self;
        let sun = sun.map_or(NONE, |sun| sun.number());
        let head =
            [word(*towards_sun, cos_sun_radius.to_bits()), [tail.number(), sun, ground.number(), sun_part.to_bits()]];
        let of_knot = |knot: &Knot| {
            let [a, b, c, d, e, f, g, h, i, level] = knot.map(f32::to_bits);
            [[a, b, c, d], [e, f, g, h], [i, level, 0, 0]]
        };
        head.into_iter().chain(knots.iter().flat_map(of_knot)).collect()
    }

    /// Distribution of the samples that do not go to the sun, over azimuth and angle from the zenith.
    pub(super) fn distribution(&self) -> &PiecewiseConstant2D {
        &self.distribution
    }

    /// Part of the sky's light, 0–1, that exceeds the mean of the sky above and the ground below; all of the sun's
    /// does.
    pub fn excess(&self) -> f64 {
        self.excess
    }

    /// Radiance from the unit direction `towards`.
    #[inline]
    pub fn radiance(&self, spectra: &SpectrumTable, towards: Vec3, wavelengths: &Wavelengths) -> SampledSpectrum {
        if towards.y <= 0.0 {
            return spectra.sample(self.ground, wavelengths);
        }
        let cos_gamma = towards.dot(self.towards_sun).clamp(-1.0, 1.0);
        let gamma = cos_gamma.acos();
        let sky = SampledSpectrum::from_lanes(|lane| {
            let (low, part) = knot_at(wavelengths.lambda_nm(lane));
            let at = |knot: usize| radiance_at(&self.knots[knot], towards.y, gamma, cos_gamma);
            at(low) * (1.0 - part) + at(low + 1) * part
        }) * spectra.sample(self.tail, wavelengths);
        match self.sun {
            Some(sun) if cos_gamma >= self.cos_sun_radius => sky + spectra.sample(sun, wavelengths),
            Some(_) | None => sky,
        }
    }

    /// A direction towards the sky, the sun or the ground with its density.
    #[inline]
    pub fn sample(&self, [u, v]: [f32; 2]) -> Option<(Vec3, Pdf<SolidAngle>)> {
        let towards = if u < self.sun_part {
            let local = warp::uniform_cone([u / self.sun_part, v], self.cos_sun_radius);
            Frame::from_normal(self.towards_sun).to_world(local)
        } else {
            let (uv, _) = self.distribution.sample([(u - self.sun_part) / (1.0 - self.sun_part), v]);
            direction(uv).0
        };
        let pdf = self.pdf(towards);
        (pdf.0 > 0.0).then_some((towards, pdf))
    }

    /// Density with which [`Self::sample`] chooses the unit direction `towards`.
    #[inline]
    pub fn pdf(&self, towards: Vec3) -> Pdf<SolidAngle> {
        let sin_theta = towards.x.hypot(towards.z);
        if sin_theta == 0.0 {
            return Pdf::new(0.0);
        }
        let u = (0.5 + towards.x.atan2(-towards.z) / TAU).clamp(0.0, 1.0 - f32::EPSILON);
        let v = (sin_theta.atan2(towards.y) / PI).min(1.0 - f32::EPSILON);
        let sky = self.distribution.pdf([u, v]) / (TAU * PI * sin_theta);
        let hits_sun = self.sun.is_some() && towards.dot(self.towards_sun) >= self.cos_sun_radius;
        let sun = if hits_sun { 1.0 / (TAU * (1.0 - self.cos_sun_radius)) } else { 0.0 };
        Pdf::new(self.sun_part * sun + (1.0 - self.sun_part) * sky)
    }
}

/// The direction of azimuth and angle from the zenith, both as parts of their ranges, and the sine of the latter.
#[inline]
fn direction([u, v]: [f32; 2]) -> (Vec3, f32) {
    let (sin_theta, cos_theta) = (PI * v).sin_cos();
    let (sin_phi, cos_phi) = (2.0 * PI * (u - 0.5)).sin_cos();
    (Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi), sin_theta)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn sky(turbidity: f64, elevation_deg: f64, ground_albedo: f64, has_sun: bool) -> (SpectrumTable, Sky, SkyLight) {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        let towards_sun = DVec3::new(0.0, sin, -cos);
        let mut spectra = SpectrumTable::default();
        let (sky, light) = Sky::new(&SkyConditions { towards_sun, turbidity, ground_albedo, has_sun }, &mut spectra);
        (spectra, sky, light)
    }

    /// Unit direction away from the sun by an azimuth.
    fn towards(zenith_deg: f32, azimuth_deg: f32) -> Vec3 {
        let ((sin, cos), (sin_phi, cos_phi)) = (zenith_deg.to_radians().sin_cos(), azimuth_deg.to_radians().sin_cos());
        Vec3::new(sin * sin_phi, cos, -sin * cos_phi)
    }

    fn at(wavelengths_nm: [f32; 4]) -> Wavelengths {
        Wavelengths::new(wavelengths_nm, [1.0; 4])
    }

    /// Values of the plugin `sunsky` of Mitsuba 3.9.1 at 400, 420, 550 and 633 nm.
    #[test]
    fn the_sky_is_that_of_mitsuba() {
        for (turbidity, elevation, albedo, zenith, azimuth, expected) in [
            (2.0, 60.0, 0.0, 0.0, 0.0, [0.0941598, 0.0896195, 0.0360882, 0.020894]),
            (2.0, 60.0, 0.0, 80.0, 180.0, [0.173511, 0.181273, 0.106303, 0.0622148]),
            (3.7, 25.0, 0.3, 40.0, 50.0, [0.0807471, 0.0856376, 0.0520549, 0.0327421]),
            (3.7, 25.0, 0.3, 70.0, 0.0, [0.249261, 0.318844, 0.457516, 0.401841]),
            (8.0, 5.0, 0.8, 40.0, 50.0, [0.0232314, 0.0272424, 0.0278695, 0.0212858]),
            (8.0, 5.0, 0.8, 70.0, 0.0, [0.0421752, 0.0628389, 0.198968, 0.256326]),
        ] {
            let (spectra, sky, _) = sky(turbidity, elevation, albedo, false);
            let found = sky.radiance(&spectra, towards(zenith, azimuth), &at([400.0, 420.0, 550.0, 633.0]));
            for (found, expected) in found.to_array().into_iter().zip(expected) {
                // Both compute in single precision, with exponentials of arguments up to 10 or so.
                assert!(
                    (found / expected - 1.0f32).abs() < 1e-4,
                    "{turbidity} {elevation} {zenith}: {found} {expected}"
                );
            }
        }
    }

    /// Values of Mitsuba for the sun, whose mean over the disk it tabulates at steps of the elevation.
    #[test]
    fn the_sun_is_that_of_mitsuba() {
        for (turbidity, elevation, expected) in
            [(2.0, 60.0, [1391.85, 8913.87, 17737.1, 15825.2]), (3.7, 25.0, [334.349, 4687.93, 13727.6, 13867.3])]
        {
            let (spectra, sky, _) = sky(turbidity, elevation, 0.0, true);
            let found =
                sky.radiance(&spectra, towards(90.0 - elevation as f32, 0.0), &at([320.0, 400.0, 550.0, 720.0]));
            for (found, expected) in found.to_array().into_iter().zip(expected) {
                assert!((found / expected - 1.0f32).abs() < 0.01, "{turbidity} {elevation}: {found} {expected}");
            }
        }
    }

    /// Integral ∫ f dω over the sphere by n² samples of the sky and as many even ones, by the balance heuristic: the
    /// sky's leave out what is darker than the mean.
    fn integral(sky: &Sky, n: u16, f: impl Fn(Vec3) -> [f64; 4]) -> [f64; 4] {
        let mut sums = [0.0; 4];
        let mut add = |towards: Vec3| {
            let density = f64::from(sky.pdf(towards).0) + 0.25 / std::f64::consts::PI;
            for (sum, value) in sums.iter_mut().zip(f(towards)) {
                *sum += value / density / f64::from(n).powi(2);
            }
        };
        for i in 0..u32::from(n).pow(2) {
            let u = [i % u32::from(n), i / u32::from(n)].map(|i| (i as f32 + 0.5) / f32::from(n));
            if let Some((towards, _)) = sky.sample(u) {
                add(towards);
            }
            add(warp::uniform_sphere(u));
        }
        sums
    }

    #[test]
    fn light_of_a_clear_day_is_as_bright_as_measured() {
        let horizontal = |turbidity, has_sun| {
            let (spectra, sky, _) = sky(turbidity, 60.0, 0.2, has_sun);
            let illuminance = |towards: Vec3| {
                let lanes = (0..10u8).map(|i| {
                    let l = 400.0 + 30.0 * f32::from(i);
                    f64::from(sky.radiance(&spectra, towards, &at([l; 4]))[0] * cie::y_bar().eval(l)) * 30.0
                });
                [683.0 * lanes.sum::<f64>() * f64::from(towards.y.max(0.0)); 4]
            };
            integral(&sky, 200, illuminance)[0]
        };
        // A sun 60° high on a clear day gives some 90 000 lux, the clear sky alone 10 000 to 20 000 (IES Lighting
        // Handbook, daylight availability: 127 500 lux outside the air, extinction 0.21 for the sun; 800 + 15 500·√sin
        // for the sky).
        let direct = 127_500.0 * (-0.21 / 60f64.to_radians().sin()).exp() * 60f64.to_radians().sin();
        let diffuse = 800.0 + 15_500.0 * 60f64.to_radians().sin().sqrt();
        let (all, alone) = (horizontal(3.0, true), horizontal(3.0, false));
        assert!(((all - alone) / direct - 1.0).abs() < 0.15, "{} {direct}", all - alone);
        assert!((alone / diffuse - 1.0).abs() < 0.25, "{alone} {diffuse}");
    }

    #[test]
    fn what_shines_evenly_is_not_looked_at_and_the_sun_is() {
        let alone = sky(3.0, 60.0, 0.2, false).1;
        let with_sun = sky(3.0, 60.0, 0.2, true).1;
        // Of a sky that would be even above the horizon with a ground of 0.2 below, (1 − 0.6)/1.2 exceeds the mean.
        assert!(alone.excess() > 0.3 && alone.excess() < 0.6, "{}", alone.excess());
        // Sun of some 80 000 lux on the ground, that ground of 0.2 and the sky of some 15 000 lux: of its light over all
        // directions, 80/sin 60° + 2·0.2·95 + 2·15 thousand lumens a square metre, the sun's exceeds the mean.
        assert!(with_sun.excess() > 0.5 && with_sun.excess() < 0.7, "{}", with_sun.excess());
        let brightest = alone.pdf(towards(30.0, 0.0)).0;
        assert!(brightest > 0.5 / PI, "{brightest}");
        // A sun in haze leaves the other side of the sky below the mean.
        let hazy = sky(8.0, 30.0, 0.2, false).1;
        assert_eq!(hazy.pdf(towards(40.0, 180.0)).0, 0.0);
    }

    /// A plane that faces down receives the albedo of the ground times what one that faces up does, with the sun at any
    /// height, and the ground is the same in all directions.
    #[test]
    fn the_ground_gives_back_what_falls_on_it() {
        let wavelengths = at([380.0, 550.0, 700.0, 900.0]);
        for (elevation, albedo, has_sun) in [
            (0.0, 0.5, true),
            (0.1, 1.0, true),
            (30.0, 0.0, true),
            (30.0, 0.3, true),
            (90.0, 1.0, true),
            (20.0, 0.8, false),
        ] {
            let (spectra, sky, SkyLight { ground, .. }) = sky(3.0, elevation, albedo, has_sun);
            let onto = |up: f32| {
                integral(&sky, 256, |towards| {
                    let cos = f64::from((towards.y * up).max(0.0));
                    sky.radiance(&spectra, towards, &wavelengths).to_array().map(|l| f64::from(l) * cos)
                })
            };
            let below = [towards(90.5, 10.0), towards(120.0, 200.0), Vec3::NEG_Y];
            let seen = below.map(|towards| sky.radiance(&spectra, towards, &wavelengths).to_array());
            assert_eq!(seen, [seen[0]; 3]);
            let (up, down) = (onto(1.0), onto(-1.0));
            for (i, lambda) in [380.0, 550.0, 700.0, 900.0].into_iter().enumerate() {
                assert_eq!(seen[0][i], ground.eval(lambda));
                // As for the whole light; below the horizon all is the same.
                let error = (down[i] - albedo * up[i]) / up[i];
                assert!(error.abs() < 0.01, "{elevation} {albedo} {lambda}: {} is not {albedo}·{}", down[i], up[i]);
                let closed = std::f64::consts::PI * f64::from(seen[0][i]);
                assert!((down[i] - closed).abs() <= 0.01 * closed, "{elevation} {lambda}: {} {closed}", down[i]);
            }
        }
    }

    /// Bright ground is sampled as the sky is: evenly, by what it exceeds the mean.
    #[test]
    fn ground_in_the_sun_is_looked_at() {
        let (_, bright, _) = sky(3.0, 60.0, 1.0, true);
        let density = bright.pdf(towards(100.0, 0.0)).0;
        assert!(density > 0.0);
        assert!((bright.pdf(towards(150.0, 120.0)).0 / density - 1.0).abs() < 0.01);
        assert_eq!(sky(3.0, 60.0, 0.1, false).1.pdf(towards(150.0, 120.0)).0, 0.0);
    }

    #[test]
    fn samples_estimate_the_whole_light_and_know_their_density() {
        let (spectra, sky, SkyLight { all, .. }) = sky(4.0, 30.0, 0.2, true);
        let wavelengths = at([380.0, 550.0, 700.0, 900.0]);
        let radiance = |towards| sky.radiance(&spectra, towards, &wavelengths).to_array().map(f64::from);
        let found = integral(&sky, 256, radiance);
        for (lambda, found) in [380.0, 550.0, 700.0, 900.0].into_iter().zip(found) {
            // 65 000 evenly spread points of each kind, over cells of 1/128 by 1/64 with the sky smooth in them.
            let ratio = found / f64::from(all.eval(lambda));
            assert!((ratio - 1.0).abs() < 0.01, "{lambda}: {ratio}");
        }
        let n = 256u16;
        let count = f64::from(n) * f64::from(n);
        let mut density = 0.0;
        for i in 0..u32::from(n) * u32::from(n) {
            let u = [i % u32::from(n), i / u32::from(n)].map(|i| (i as f32 + 0.5) / f32::from(n));
            let uniform = warp::uniform_sphere(u);
            if sky.towards_sun.dot(uniform) < sky.cos_sun_radius {
                density += f64::from(sky.pdf(uniform).0);
            }
        }
        // All but the part that goes to the sun.
        let rest = density / count * 4.0 * std::f64::consts::PI;
        assert!((rest - f64::from(1.0 - sky.sun_part)).abs() < 0.02, "{rest}");
    }
}
