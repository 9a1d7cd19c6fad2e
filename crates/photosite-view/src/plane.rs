//! Planes that can be looked at, by their names.

use hyper::StatusCode;

use super::answer::Failure;
use super::sent_image::SentImage;
use photosite_calibration::truth::{TruthLayer, Values};
use photosite_core::image::Planes;
use photosite_pipeline::{LightPlane, Shot};
use photosite_sensor::{MapUnit, NoiseMap, SensorModel};

/// Plane that can be looked at.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Plane {
    /// Developed image, `developed`: as image.png.
    Developed,
    /// Digital numbers, `raw`.
    Raw,
    /// Mean electrons of a channel, `electrons:R`.
    Electrons(String),
    /// Standard deviation of these that light transport leaves, `sigma:R`.
    Sigma(String),
    /// Noise that an effect of the sensor has added, `noise:read_noise_e`.
    Noise(NoiseMap),
    /// Light and ground truth, whatever the sensor makes of them: `irradiance:550`, `ideal`, `truth:depth`.
    OfLight(LightPlane),
}

impl Plane {
    /// Plane of this name.
    pub(super) fn parse(name: &str) -> Result<Self, Failure> {
        let map = |name: &str| NoiseMap::ALL.into_iter().find(|map| map.name() == name).map(Self::Noise);
        let layer = |name: &str| TruthLayer::named(name).map(LightPlane::Truth);
        let of_light = |plane: LightPlane| Some(Self::OfLight(plane));
        let plane = match name.split_once(':') {
            None => match name {
                "developed" => Some(Self::Developed),
                "raw" => Some(Self::Raw),
                "ideal" => of_light(LightPlane::Ideal),
                _ => None,
            },
            Some(("electrons", channel)) => Some(Self::Electrons(channel.to_owned())),
            Some(("sigma", channel)) => Some(Self::Sigma(channel.to_owned())),
            Some(("irradiance", band)) => of_light(LightPlane::Irradiance(band.to_owned())),
            Some(("noise", name)) => map(name),
            Some(("truth", name)) => layer(name).map(Self::OfLight),
            Some(_) => None,
        };
        plane.ok_or_else(|| no_plane(name))
    }

    /// Name of the plane.
    pub(super) fn name(&self) -> String {
        match self {
            Self::Developed => "developed".to_owned(),
            Self::Raw => "raw".to_owned(),
            Self::Electrons(channel) => format!("electrons:{channel}"),
            Self::Sigma(channel) => format!("sigma:{channel}"),
            Self::Noise(map) => format!("noise:{}", map.name()),
            Self::OfLight(LightPlane::Irradiance(band)) => format!("irradiance:{band}"),
            Self::OfLight(LightPlane::Ideal) => "ideal".to_owned(),
            Self::OfLight(LightPlane::Truth(layer)) => format!("truth:{}", layer.name()),
        }
    }

    /// The noise map that a shot has to be made with.
    pub(super) fn map(&self) -> Option<NoiseMap> {
        match self {
            Self::Noise(map) => Some(*map),
            Self::Developed | Self::Raw | Self::Electrons(_) | Self::Sigma(_) | Self::OfLight(_) => None,
        }
    }

    /// Names of all planes of a shot of a sensor, with those of its light and ground truth.
    pub(super) fn all(shot: &Shot, sensor: &SensorModel, beside: Vec<LightPlane>) -> Vec<String> {
        let channels = |planes: &Planes| planes.channels().iter().map(|c| c.name.clone()).collect::<Vec<_>>();
        let electrons = channels(&shot.electrons.mean).into_iter().map(Self::Electrons);
        let sigmas = channels(&shot.electrons.variance).into_iter().map(Self::Sigma);
        let noise = NoiseMap::ALL.into_iter().filter(|&map| sensor.has_map(map)).map(Self::Noise);
        let all = [Self::Developed, Self::Raw].into_iter().chain(electrons).chain(sigmas).chain(noise);
        let all = all.chain(beside.into_iter().map(Self::OfLight));
        all.map(|plane| plane.name()).collect()
    }

    /// Whether values of the plane are indices of things, which have no mean.
    pub(super) const fn is_numbered(&self) -> bool {
        matches!(self, Self::OfLight(LightPlane::Truth(layer)) if matches!(layer.values(), Values::Index))
    }

    /// The unit of planes of light and ground truth.
    pub(super) const fn unit(&self) -> &'static str {
        match self {
            Self::OfLight(LightPlane::Truth(layer)) => layer.unit(),
            Self::OfLight(LightPlane::Irradiance(_)) => "W·m⁻²·nm⁻¹",
            Self::Electrons(_) | Self::Sigma(_) => "e⁻",
            Self::Raw => "DN",
            Self::Developed | Self::Noise(_) | Self::OfLight(LightPlane::Ideal) => "",
        }
    }

    /// The plane of a shot, but for what is developed, and for light and ground truth.
    pub(super) fn of_shot(&self, shot: &Shot) -> Result<SentImage, Failure> {
        let missing = || no_plane(&self.name());
        let one = |planes: &Planes, name: &str, value: fn(f32) -> f32| {
            let size = [planes.width(), planes.height()];
            let channel = planes.channels().iter().find(|channel| channel.name == name);
            channel.map(|channel| SentImage::of_plane(size, channel, self.unit(), value)).ok_or_else(missing)
        };
        match self {
            Self::Raw => Ok(SentImage::of_raw(&shot.raw)),
            Self::Electrons(name) => one(&shot.electrons.mean, name, |mean| mean),
            Self::Sigma(name) => one(&shot.electrons.variance, name, f32::sqrt),
            Self::Noise(map) => {
                let unit = match map.unit() {
                    MapUnit::Electrons => "e⁻",
                    MapUnit::DigitalNumbers => "DN",
                    MapUnit::None => "",
                };
                Ok(SentImage::of_planes(&shot.noise_maps.planes, unit))
            }
            Self::Developed | Self::OfLight(_) => Err(missing()),
        }
    }
}

pub(super) fn no_plane(name: &str) -> Failure {
    Failure::new(StatusCode::NOT_FOUND, format!("there is no plane {name:?}"))
        .help("the description of each image lists its planes")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_and_written() {
        let fixed = ["developed", "raw", "ideal", "electrons:G", "sigma:R", "irradiance:550"].map(str::to_owned);
        let maps = NoiseMap::ALL.map(|map| format!("noise:{}", map.name()));
        let layers = TruthLayer::ALL.map(|layer| format!("truth:{}", layer.name()));
        for name in fixed.iter().chain(&maps).chain(&layers) {
            assert_eq!(Plane::parse(name).expect(name).name(), *name);
        }
        for name in ["", "Raw", "noise:x", "truth:", "x:y", "../raw"] {
            assert_eq!(Plane::parse(name).expect_err(name).status, StatusCode::NOT_FOUND);
        }
    }
}
