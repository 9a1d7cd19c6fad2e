//! The planes of a picture that can be looked at, by their names.

use hyper::StatusCode;

use super::answer::Failure;
use super::picture::Picture;
use crate::calibration::truth::TruthLayer;
use crate::image::Planes;
use crate::pipeline::Shot;
use crate::sensor::{MapUnit, NoiseMap, SensorModel};

/// What can be looked at.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Plane {
    /// `developed`: as image.png.
    Developed,
    /// `raw`: digital numbers.
    Raw,
    /// `electrons:R`: mean electrons of a channel.
    Electrons(String),
    /// `sigma:R`: what light transport leaves uncertain of them.
    Sigma(String),
    /// `noise:read_noise_e`: what an effect of the sensor has added.
    Noise(NoiseMap),
    /// `irradiance:550`: in the band around so many nm.
    Irradiance(String),
    /// `ideal`: what an observer with the eyes of the CIE would see.
    Ideal,
    /// `truth:depth`: a layer of ground truth.
    Truth(TruthLayer),
}

impl Plane {
    /// By its name.
    pub(super) fn parse(name: &str) -> Result<Self, Failure> {
        let map = |name: &str| NoiseMap::ALL.into_iter().find(|map| map.name() == name).map(Self::Noise);
        let layer = |name: &str| TruthLayer::ALL.into_iter().find(|layer| layer.name() == name).map(Self::Truth);
        let plane = match name.split_once(':') {
            None => match name {
                "developed" => Some(Self::Developed),
                "raw" => Some(Self::Raw),
                "ideal" => Some(Self::Ideal),
                _ => None,
            },
            Some(("electrons", channel)) => Some(Self::Electrons(channel.to_owned())),
            Some(("sigma", channel)) => Some(Self::Sigma(channel.to_owned())),
            Some(("irradiance", band)) => Some(Self::Irradiance(band.to_owned())),
            Some(("noise", name)) => map(name),
            Some(("truth", name)) => layer(name),
            Some(_) => None,
        };
        plane.ok_or_else(|| no_plane(name))
    }

    /// Its name.
    pub(super) fn name(&self) -> String {
        match self {
            Self::Developed => "developed".to_owned(),
            Self::Raw => "raw".to_owned(),
            Self::Electrons(channel) => format!("electrons:{channel}"),
            Self::Sigma(channel) => format!("sigma:{channel}"),
            Self::Noise(map) => format!("noise:{}", map.name()),
            Self::Irradiance(band) => format!("irradiance:{band}"),
            Self::Ideal => "ideal".to_owned(),
            Self::Truth(layer) => format!("truth:{}", layer.name()),
        }
    }

    /// The noise map that a shot has to be made with.
    pub(super) fn map(&self) -> Option<NoiseMap> {
        match self {
            Self::Noise(map) => Some(*map),
            Self::Developed
            | Self::Raw
            | Self::Electrons(_)
            | Self::Sigma(_)
            | Self::Irradiance(_)
            | Self::Ideal
            | Self::Truth(_) => None,
        }
    }

    /// All that there are of a shot of a sensor: those that light and ground truth have, too.
    pub(super) fn all(shot: &Shot, sensor: &SensorModel, beside: Vec<Self>) -> Vec<String> {
        let channels = |planes: &Planes| planes.channels().iter().map(|c| c.name.clone()).collect::<Vec<_>>();
        let electrons = channels(&shot.electrons.mean).into_iter().map(Self::Electrons);
        let sigmas = channels(&shot.electrons.variance).into_iter().map(Self::Sigma);
        let noise = NoiseMap::ALL.into_iter().filter(|&map| sensor.has_map(map)).map(Self::Noise);
        let all = [Self::Developed, Self::Raw].into_iter().chain(electrons).chain(sigmas).chain(noise).chain(beside);
        all.map(|plane| plane.name()).collect()
    }

    /// Whether its values are names of things, between which there is nothing.
    pub(super) const fn is_numbered(&self) -> bool {
        matches!(self, Self::Truth(TruthLayer::Instance | TruthLayer::Material))
    }

    /// The unit of planes of light and ground truth.
    pub(super) const fn unit(&self) -> &'static str {
        match self {
            Self::Truth(layer) => unit_of(*layer),
            Self::Irradiance(_) => "W·m⁻²·nm⁻¹",
            Self::Electrons(_) | Self::Sigma(_) => "e⁻",
            Self::Raw => "DN",
            Self::Developed | Self::Noise(_) | Self::Ideal => "",
        }
    }

    /// The plane of a shot, but for what is developed, and for light and ground truth.
    pub(super) fn of_shot(&self, shot: &Shot) -> Result<Picture, Failure> {
        let missing = || no_plane(&self.name());
        let one = |planes: &Planes, name: &str, value: fn(f32) -> f32| {
            let size = [planes.width(), planes.height()];
            let channel = planes.channels().iter().find(|channel| channel.name == name);
            channel.map(|channel| Picture::of_plane(size, channel, self.unit(), value)).ok_or_else(missing)
        };
        match self {
            Self::Raw => Ok(Picture::of_raw(&shot.raw)),
            Self::Electrons(name) => one(&shot.electrons.mean, name, |mean| mean),
            Self::Sigma(name) => one(&shot.electrons.variance, name, f32::sqrt),
            Self::Noise(map) => {
                let unit = match map.unit() {
                    MapUnit::Electrons => "e⁻",
                    MapUnit::DigitalNumbers => "DN",
                    MapUnit::None => "",
                };
                Ok(Picture::of_planes(&shot.noise_maps.planes, unit))
            }
            Self::Developed | Self::Irradiance(_) | Self::Ideal | Self::Truth(_) => Err(missing()),
        }
    }
}

/// The unit of a layer of ground truth.
const fn unit_of(layer: TruthLayer) -> &'static str {
    match layer {
        TruthLayer::Depth | TruthLayer::Distance | TruthLayer::Position | TruthLayer::ObjectPosition => "m",
        TruthLayer::Flow | TruthLayer::Disparity => "px",
        TruthLayer::Normal
        | TruthLayer::ShadingNormal
        | TruthLayer::Uv
        | TruthLayer::Albedo
        | TruthLayer::Nocs
        | TruthLayer::Instance
        | TruthLayer::Material => "",
    }
}

pub(super) fn no_plane(name: &str) -> Failure {
    Failure::new(StatusCode::NOT_FOUND, format!("there is no plane {name:?}"))
        .help("the description of each picture lists its planes")
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
