//! Plan of a characterisation: the exposure times and photons of its images.

use photosite_core::Invalid;
use photosite_core::units::{Celsius, Decibels, Electrons, Seconds};
use photosite_sensor::{Exposure, SensorModel, Use};

use super::camera_fit::{FrameGroup, FrameLight};
use super::descriptor::Light;
use super::efficiency::quantum_efficiency;

/// Operating point: one channel of the sensor, in light of one wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatingPoint {
    /// Number of the channel, in the order of the sensor's colour filter array.
    pub channel: usize,
    /// Wavelength of the light, nm.
    pub wavelength_nm: f64,
    /// Gain of the exposures.
    pub gain: Decibels,
    /// Temperature of the sensor.
    pub temperature: Celsius,
}

impl OperatingPoint {
    /// Refuses what this sensor cannot do, and single-photon counters, of which the standard's linear model does not
    /// hold: their counts bend with the light, and the noise of counts that saturate falls to nothing.
    pub fn validate(&self, sensor: &SensorModel) -> Result<(), Invalid> {
        self.exposure(USUAL_TIME).validate(sensor)?;
        if sensor.architecture.spad().is_some() {
            let message = format!("{} counts single photons, and EMVA 1288 (linear) does not apply to it", sensor.name);
            return Err(Invalid::new("", message).help(
                "its counts saturate as 1 − exp(−H) or n/(1 + n·τ), so that neither K nor a line describes them; photosite \
                 noise takes the figures of its images",
            ));
        }
        let refused = [
            ("charge.logarithmic_reference_e_per_s", sensor.logarithmic.is_some()),
            ("adc.companding", sensor.converter.companding.is_some()),
        ];
        match refused.iter().find(|(_, is_there)| *is_there) {
            Some((key, _)) => Err(Invalid::new(*key, "produces pixel values that are not proportional to light")
                .help("EMVA 1288 measures linear sensors whose pixels are alike and independent; leave it out")),
            None => sensor.allows(Use::Emva1288),
        }
    }

    /// An exposure of this time.
    pub(super) fn exposure(&self, time: Seconds) -> Exposure {
        let Self { gain, temperature, .. } = *self;
        Exposure { gain, temperature, ..Exposure::of(time) }
    }
}

/// Images to be taken of the same light.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// Name of the images, which are numbered after it.
    pub name: String,
    /// Exposure time.
    pub time: Seconds,
    /// Photons on each pixel.
    pub light: Light,
    /// Number of images.
    pub images: u32,
}

/// All images of one set.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Shots, in the order in which they are taken.
    pub shots: Vec<Shot>,
    /// Exposure time at which a sweep of wavelengths or the stacks are taken, about half way to saturation.
    pub half_time: Seconds,
}

/// Factor by which the longest exposure goes past saturation.
const OVERSHOOT: f64 = 1.1;
/// Exposure time that saturates a sensor without any dark current.
const USUAL_TIME: Seconds = Seconds(0.02);
/// Bounds for the time that saturates other sensors, s.
const TIMES: [f64; 2] = [1e-3, 86_400.0];
/// Photons per pixel beyond which a channel counts as blind.
const MOST_PHOTONS: f64 = 1e9;

impl Plan {
    /// The set of the linear camera model: pairs of bright and dark images at `steps` exposure times under constant
    /// light, evenly spaced from dark to 10 % past saturation, and stacks of `stack` bright and dark images half way to
    /// saturation.
    ///
    /// `saturation_time` is the exposure time that saturates; left to choose, it is that at which the dark current's
    /// shot noise equals the rest of the dark noise, so that both can be told apart, and 20 ms without dark current.
    pub fn linear(
        sensor: &SensorModel,
        point: &OperatingPoint,
        steps: u32,
        stack: u32,
        saturation_time: Option<Seconds>,
    ) -> Result<Self, Invalid> {
        let saturation_time = match saturation_time {
            Some(time) => time,
            None => telling_time(sensor, point, 1.0),
        };
        let flux = saturating_flux(sensor, point, saturation_time)?;
        let at = |part: f64| Seconds(OVERSHOOT * saturation_time.0 * part);
        let mut shots = Vec::new();
        for step in 1..=steps {
            let time = at(f64::from(step) / f64::from(steps));
            shots.extend(pair(&format!("step-{step:02}"), time, flux * time.0));
        }
        // One of the steps, that nearest to half of saturation.
        let half = (0.5 / OVERSHOOT * f64::from(steps)).round().max(1.0);
        let half_time = at(half / f64::from(steps));
        shots.extend(both("stack", half_time, flux * half_time.0, stack));
        Ok(Self { shots, half_time })
    }

    /// The set of a camera's images: the same exposure times, photons and numbers of images.
    ///
    /// # Errors
    ///
    /// Bright images of which nobody counted the photons.
    pub fn like(groups: &[FrameGroup]) -> Result<Self, Invalid> {
        let shot = |(i, group): (usize, &FrameGroup)| {
            let name = format!("group-{:03}-{}", i + 1, if group.is_dark() { "dark" } else { "bright" });
            let light = match group.light {
                FrameLight::Dark => Light::Dark,
                FrameLight::Bright { photons: Some(photons) } => Light::Bright { photons },
                FrameLight::Bright { photons: None } => {
                    let message = format!("{} does not state the photons on a pixel", group.name);
                    return Err(
                        Invalid::new("", message).help("give an EMVA 1288 set, or a column photons in frames.csv")
                    );
                }
            };
            Ok(Shot { name, time: group.time.unwrap_or(Seconds(0.0)), light, images: group.images.len() as u32 })
        };
        let shots: Vec<Shot> = groups.iter().enumerate().map(shot).collect::<Result<_, _>>()?;
        let bright = shots.iter().filter(|shot| shot.light != Light::Dark);
        let half_time = bright.max_by_key(|shot| shot.images).map_or(Seconds(0.0), |shot| shot.time);
        Ok(Self { shots, half_time })
    }

    /// A set for the quantum efficiency at one more wavelength: pairs at 20, 40 and 60 % of saturation with one
    /// exposure time; with fewer, programs that look for saturation find no point below 70 % of it. `None` where the
    /// channel is blind at this wavelength.
    pub fn spectral(sensor: &SensorModel, point: &OperatingPoint, time: Seconds) -> Option<Self> {
        let flux = saturating_flux(sensor, point, time).ok()?;
        let [dark, _] = pair("level-0", time, 0.0);
        let bright = [1.0, 2.0, 3.0].map(|level| {
            let [_, bright] = pair(&format!("level-{level}"), time, flux * time.0 * level / 5.0);
            bright
        });
        Some(Self { shots: std::iter::once(dark).chain(bright).collect(), half_time: time })
    }

    /// A set for the dark current at one temperature: pairs of bright and dark images at `steps` exposure times up to
    /// that at which the dark current's shot noise is four times the variance of the rest. The light reaches 60 % of
    /// saturation.
    pub fn dark_current(sensor: &SensorModel, point: &OperatingPoint, steps: u32) -> Result<Self, Invalid> {
        let last = telling_time(sensor, point, 4.0);
        let flux = 0.6 * saturating_flux(sensor, point, last)?;
        let time = |step: u32| Seconds(last.0 * f64::from(step) / f64::from(steps));
        let shots =
            (1..=steps).flat_map(|step| pair(&format!("step-{step:02}"), time(step), flux * time(step).0)).collect();
        Ok(Self { shots, half_time: Seconds(0.5 * last.0) })
    }
}

fn pair(name: &str, time: Seconds, photons: f64) -> [Shot; 2] {
    both(name, time, photons, 2)
}

/// Dark and bright images of the same exposure time.
fn both(name: &str, time: Seconds, photons: f64, images: u32) -> [Shot; 2] {
    [("dark", Light::Dark), ("bright", Light::Bright { photons })].map(|(light_name, light)| Shot {
        name: format!("{name}-{light_name}"),
        time,
        light,
        images,
    })
}

/// The time at which the dark current's variance is `ratio` times that of all other dark noise, but its mean no more
/// than a hundredth of saturation.
fn telling_time(sensor: &SensorModel, point: &OperatingPoint, ratio: f64) -> Seconds {
    let start = point.exposure(Seconds(0.0));
    let current = sensor.noise.dark_current(point.temperature);
    let electrons =
        (ratio * sensor.noise_variance(Electrons(0.0), &start)).min(0.01 * sensor.saturation_capacity(&start).0);
    if current > 0.0 { Seconds((electrons / current).clamp(TIMES[0], TIMES[1])) } else { USUAL_TIME }
}

/// Photons per pixel and second that saturate it in that time, together with the dark current.
fn saturating_flux(sensor: &SensorModel, point: &OperatingPoint, time: Seconds) -> Result<f64, Invalid> {
    let dark = sensor.noise.dark_electrons(point.temperature, time);
    let free = sensor.saturation_capacity(&point.exposure(time)).0 - dark.0;
    if free <= 0.0 {
        let message =
            format!("the dark current alone fills the pixels within {} s at {} °C", time.0, point.temperature.0);
        return Err(Invalid::new("", message).help("choose a lower temperature or a shorter saturation time"));
    }
    let photons = free / quantum_efficiency(sensor, point.channel, point.wavelength_nm);
    if photons > MOST_PHOTONS {
        let channel = &sensor.cfa.channels()[point.channel];
        let message = format!("channel {channel} is blind at {} nm", point.wavelength_nm);
        return Err(Invalid::new("", message).help("choose a wavelength at which it has a quantum efficiency"));
    }
    Ok(photons / time.0)
}
