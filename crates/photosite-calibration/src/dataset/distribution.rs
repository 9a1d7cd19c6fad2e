//! Distributions of a variation's values.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use serde_json::{Map, Value};

use super::draws::Draws;
use super::toml_value::{list, number, toml};
use super::{HsvDescription, RotationDescription, SphereDescription, VariationDescription};
use photosite_core::{Invalid, counted};

/// Distribution of a variation.
#[derive(Clone, Debug)]
pub(super) enum VariationDistribution {
    /// A value for each of its keys.
    Value(ValueDistribution),
    /// Keys of a table, all at once.
    Choices(Choice<Map<String, Value>>),
    /// Number of its keys that are `true`, between these; the others are `false`.
    Count([u32; 2]),
}

/// Distribution of the value of a key.
#[derive(Clone, Debug)]
pub(super) enum ValueDistribution {
    Uniform([f64; 2]),
    LogUniform([f64; 2]),
    Normal([f64; 2]),
    Choice(Choice<Value>),
    Sweep([f64; 2]),
    /// Lists of numbers, drawn component by component between those of two corners.
    Box([Vec<f64>; 2]),
    Sphere(Sphere),
    Rotation(Rotation),
    /// Colours by hue in degrees, saturation and value.
    Hsv([[f64; 2]; 3]),
}

/// Discrete distribution over things.
#[derive(Clone, Debug)]
pub(super) struct Choice<T> {
    things: Vec<T>,
    /// Cumulative distribution function at each thing; `None` where all are equally likely.
    up_to: Option<Vec<f64>>,
}

/// Points of a sphere, or of a part of one.
#[derive(Clone, Debug)]
pub(super) struct Sphere {
    center: DVec3,
    radius_m: [f64; 2],
    up: DVec3,
    /// Cosines of the largest and the least angle from `up`.
    cosines: [f64; 2],
}

/// Rotations, all of them or those about an axis.
#[derive(Clone, Debug)]
pub(super) enum Rotation {
    Any,
    About { axis: DVec3, angle_deg: [f64; 2] },
}

impl VariationDistribution {
    /// Checks a description. `files` are the matches of its pattern.
    pub(super) fn new(d: &VariationDescription, files: &[String]) -> Result<Self, Invalid> {
        let values = |distribution: Result<ValueDistribution, Invalid>| distribution.map(Self::Value);
        let names = || files.iter().map(|file| Value::from(&**file)).collect();
        let given = [
            ("uniform", d.uniform.map(|range| values(in_order(range).map(ValueDistribution::Uniform)))),
            ("log_uniform", d.log_uniform.map(|range| values(above_zero(range).map(ValueDistribution::LogUniform)))),
            ("normal", d.normal.map(|normal| values(mean_and_deviation(normal).map(ValueDistribution::Normal)))),
            ("choice", d.choice.clone().map(|things| values(Choice::new(things).map(ValueDistribution::Choice)))),
            ("choices", d.choices.clone().map(|tables| checked(tables).and_then(Choice::new).map(Self::Choices))),
            ("files", d.files.as_ref().map(|_| values(Choice::new(names()).map(ValueDistribution::Choice)))),
            ("sweep", d.sweep.map(|range| values(finite(range).map(ValueDistribution::Sweep)))),
            ("box", d.r#box.as_ref().map(|corners| values(corners_in_order(corners).map(ValueDistribution::Box)))),
            ("sphere", d.sphere.as_ref().map(|sphere| values(Sphere::new(sphere).map(ValueDistribution::Sphere)))),
            (
                "rotation",
                d.rotation.as_ref().map(|rotation| values(Rotation::new(rotation).map(ValueDistribution::Rotation))),
            ),
            ("hsv", d.hsv.as_ref().map(|hsv| values(ranges_of_hsv(hsv).map(ValueDistribution::Hsv)))),
            ("count", d.count.map(|range| in_order(range.map(f64::from)).map(|_| Self::Count(range)))),
        ];
        let mut given = given.into_iter().filter_map(|(name, distribution)| Some((name, distribution?)));
        let Some((name, distribution)) = given.next() else {
            return Err(Invalid::new("", "does not say how the key varies").help("for example uniform = [0, 12]"));
        };
        if let Some((other, _)) = given.next() {
            return Err(Invalid::new(other, format!("cannot be combined with {name}")).help("keep one of them"));
        }
        let distribution = distribution.map_err(|invalid| invalid.within(name))?;
        let Some(weights) = &d.weights else { return Ok(distribution) };
        let weighted = match distribution {
            Self::Value(ValueDistribution::Choice(choice)) => {
                choice.weighted(weights).map(|choice| Self::Value(ValueDistribution::Choice(choice)))
            }
            Self::Choices(choice) => choice.weighted(weights).map(Self::Choices),
            Self::Value(
                ValueDistribution::Uniform(_)
                | ValueDistribution::LogUniform(_)
                | ValueDistribution::Normal(_)
                | ValueDistribution::Sweep(_)
                | ValueDistribution::Box(_)
                | ValueDistribution::Sphere(_)
                | ValueDistribution::Rotation(_)
                | ValueDistribution::Hsv(_),
            )
            | Self::Count(_) => {
                let help = "they apply to choice, choices and files; remove them";
                Err(Invalid::new("", format!("cannot be combined with {name}")).help(help))
            }
        };
        weighted.map_err(|invalid| invalid.within("weights"))
    }
}

impl ValueDistribution {
    /// Draws the value for frame `frame` of `frames`, as TOML.
    pub(super) fn draw(&self, draws: &mut Draws, frame: u32, frames: u32) -> String {
        match self {
            Self::Uniform(range) => number(between(*range, draws.unit())),
            Self::LogUniform([a, b]) => number(a * (b / a).powf(draws.unit())),
            Self::Normal([mean, deviation]) => number(mean + deviation * draws.normal()),
            Self::Choice(choice) => toml(choice.draw(draws)),
            Self::Sweep([first, last]) => {
                let part = f64::from(frame) / f64::from(frames.max(2) - 1);
                number(first + (last - first) * part)
            }
            Self::Box([low, high]) => list(low.iter().zip(high).map(|(a, b)| between([*a, *b], draws.unit()))),
            Self::Sphere(sphere) => list(sphere.draw(draws).to_array()),
            Self::Rotation(rotation) => {
                let DQuat { x, y, z, w } = rotation.draw(draws);
                list([w, x, y, z])
            }
            Self::Hsv(ranges) => list(rgb_of_hsv(ranges.map(|range| between(range, draws.unit())))),
        }
    }
}

impl<T> Choice<T> {
    fn new(things: Vec<T>) -> Result<Self, Invalid> {
        if things.is_empty() {
            return Err(Invalid::new("", "has no choices").help("for example [\"D65\", \"A\"]"));
        }
        Ok(Self { things, up_to: None })
    }

    fn weighted(self, weights: &[f64]) -> Result<Self, Invalid> {
        let sum: f64 = weights.iter().sum();
        if weights.len() != self.things.len() {
            let message = format!(
                "has {}, but there are {} choices",
                counted(weights.len(), ["entry", "entries"]),
                self.things.len()
            );
            return Err(Invalid::new("", message).help("write a number for each, in their order"));
        }
        if !(weights.iter().all(|weight| *weight >= 0.0) && sum > 0.0 && sum.is_finite()) {
            let message = format!("must not be negative, and one must be above 0, got {weights:?}");
            return Err(Invalid::new("", message).help("for example [3, 1]: the first three times as often"));
        }
        let up_to = weights.iter().scan(0.0, |so_far, weight| {
            *so_far += weight / sum;
            Some(*so_far)
        });
        Ok(Self { up_to: Some(up_to.collect()), ..self })
    }

    /// Draws one of the things.
    pub(super) fn draw(&self, draws: &mut Draws) -> &T {
        let Some(up_to) = &self.up_to else { return &self.things[draws.index(self.things.len())] };
        let u = draws.unit();
        // Where the parts add up to a last digit below 1, what lies beyond is that of the last one with a weight.
        let last = || up_to.windows(2).rposition(|pair| pair[0] < pair[1]).map_or(0, |i| i + 1);
        &self.things[up_to.iter().position(|part| u < *part).unwrap_or_else(last)]
    }

    /// All things.
    pub(super) fn things(&self) -> &[T] {
        &self.things
    }
}

/// Refuses tables that do not all set the same keys: a frame could not undo what another one has set.
fn checked(tables: Vec<Map<String, Value>>) -> Result<Vec<Map<String, Value>>, Invalid> {
    for (i, table) in tables.iter().enumerate() {
        let at = format!("[{i}]");
        if table.is_empty() {
            let help = "for example choices = [{ \"lens.f_number\" = 2, \"exposure.time_s\" = 0.01 }, …]";
            return Err(Invalid::new(at, "does not change any key").help(help));
        }
        let [lacking, odd] = [(&tables[0], table), (table, &tables[0])]
            .map(|(of, other)| of.keys().find(|key| !other.contains_key(*key)));
        let message = match (lacking, odd) {
            (Some(key), _) => format!("has no {key:?}, which the first table has"),
            (None, Some(key)) => format!("has {key:?}, which the first table does not have"),
            (None, None) => continue,
        };
        return Err(Invalid::new(at, message).help("write the same keys in all tables"));
    }
    Ok(tables)
}

fn finite(range: [f64; 2]) -> Result<[f64; 2], Invalid> {
    let [a, b] = range;
    if a.is_finite() && b.is_finite() {
        return Ok(range);
    }
    Err(Invalid::new("", format!("must be two numbers, got {a} and {b}")).help("for example [0, 12]"))
}

fn in_order(range: [f64; 2]) -> Result<[f64; 2], Invalid> {
    let [a, b] = finite(range)?;
    if a <= b {
        return Ok(range);
    }
    Err(Invalid::new("", format!("{a} is above {b}")).help("write the smaller number first"))
}

fn above_zero([a, b]: [f64; 2]) -> Result<[f64; 2], Invalid> {
    if a > 0.0 && a <= b && b.is_finite() {
        return Ok([a, b]);
    }
    let message = format!("must be two numbers above 0 in order, got {a} and {b}");
    Err(Invalid::new("", message).help("for example [100, 10000]"))
}

fn mean_and_deviation([mean, deviation]: [f64; 2]) -> Result<[f64; 2], Invalid> {
    if mean.is_finite() && deviation >= 0.0 && deviation.is_finite() {
        return Ok([mean, deviation]);
    }
    let message = format!("must be a mean and a deviation, got {mean} and {deviation}");
    Err(Invalid::new("", message).help("for example [20, 5]"))
}

/// Checks a range: two numbers in order within limits.
fn within(key: &str, range: [f64; 2], [low, high]: [f64; 2]) -> Result<[f64; 2], Invalid> {
    let [a, b] = in_order(range).map_err(|invalid| invalid.within(key))?;
    if low <= a && b <= high {
        return Ok(range);
    }
    let message = format!("must lie between {low:?} and {high:?}, got {a} and {b}");
    Err(Invalid::new(key, message).help("write two numbers within these"))
}

fn direction(key: &str, value: [f64; 3]) -> Result<DVec3, Invalid> {
    DVec3::from_array(value).try_normalize().ok_or_else(|| {
        Invalid::new(key, format!("must be a direction (not zero), got {value:?}"))
            .help(format!("for example {key} = [0, 1, 0]"))
    })
}

fn corners_in_order(corners: &[Vec<f64>; 2]) -> Result<[Vec<f64>; 2], Invalid> {
    let [low, high] = corners;
    let is_box = !low.is_empty()
        && low.len() == high.len()
        && low.iter().zip(high).all(|(a, b)| a.is_finite() && b.is_finite() && a <= b);
    if is_box {
        return Ok(corners.clone());
    }
    let message = format!("must be two corners, the second with larger numbers, got {low:?} and {high:?}");
    Err(Invalid::new("", message).help("for example [[-1, 0, -1], [1, 2, 1]]"))
}

fn ranges_of_hsv(hsv: &HsvDescription) -> Result<[[f64; 2]; 3], Invalid> {
    Ok([
        within("hue_deg", hsv.hue_deg.unwrap_or([0.0, 360.0]), [-360.0, 720.0])?,
        within("saturation", hsv.saturation.unwrap_or([0.0, 1.0]), [0.0, 1.0])?,
        within("value", hsv.value.unwrap_or([0.0, 1.0]), [0.0, 1.0])?,
    ])
}

fn between([a, b]: [f64; 2], part: f64) -> f64 {
    a + (b - a) * part
}

impl Sphere {
    fn new(d: &SphereDescription) -> Result<Self, Invalid> {
        let center = DVec3::from_array(d.center_m.unwrap_or_default());
        if !center.is_finite() {
            return Err(Invalid::new("center_m", format!("must be a point, got {:?}", center.to_array())));
        }
        let radius_m = d.radius_m.unwrap_or([1.0; 2]);
        within("radius_m", radius_m, [0.0, 1e18])?;
        let angles = within("angle_deg", d.angle_deg.unwrap_or([0.0, 180.0]), [0.0, 180.0])?;
        let [least, largest] = angles.map(|angle| angle.to_radians().cos());
        let up = direction("up", d.up.unwrap_or([0.0, 1.0, 0.0]))?;
        Ok(Self { center, radius_m, up, cosines: [largest, least] })
    }

    /// Draws a point, uniform over the surface, or over the volume between two radii.
    fn draw(&self, draws: &mut Draws) -> DVec3 {
        let (cosine, azimuth) = (between(self.cosines, draws.unit()), TAU * draws.unit());
        let [inner, outer] = self.radius_m;
        let radius = if inner < outer {
            between([inner.powi(3), outer.powi(3)], draws.unit()).cbrt().clamp(inner, outer)
        } else {
            inner
        };
        let (x, z) = self.up.any_orthonormal_pair();
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        self.center + radius * (sine * (azimuth.cos() * x + azimuth.sin() * z) + cosine * self.up)
    }
}

impl Rotation {
    fn new(d: &RotationDescription) -> Result<Self, Invalid> {
        match (d.axis, d.angle_deg) {
            (None, None) => Ok(Self::Any),
            (None, Some(_)) => {
                Err(Invalid::new("angle_deg", "only applies with an axis").help("for example axis = [0, 1, 0]"))
            }
            (Some(axis), angle_deg) => {
                let angle_deg = within("angle_deg", angle_deg.unwrap_or([0.0, 360.0]), [-360.0, 360.0])?;
                Ok(Self::About { axis: direction("axis", axis)?, angle_deg })
            }
        }
    }

    /// Draws a rotation, uniform over all of them ([Shoemake92](photosite_core::references#shoemake92)) or over the
    /// angles.
    fn draw(&self, draws: &mut Draws) -> DQuat {
        match self {
            Self::Any => {
                let (u, [a, b]) = (draws.unit(), [(); 2].map(|()| TAU * draws.unit()));
                let [s, c] = [1.0 - u, u].map(f64::sqrt);
                DQuat::from_xyzw(s * a.sin(), s * a.cos(), c * b.sin(), c * b.cos())
            }
            Self::About { axis, angle_deg } => {
                DQuat::from_axis_angle(*axis, between(*angle_deg, draws.unit()).to_radians())
            }
        }
    }
}

/// Conversion from hue in degrees, saturation and value to R, G and B ([Smith78](photosite_core::references#smith78)).
fn rgb_of_hsv([hue, saturation, value]: [f64; 3]) -> [f64; 3] {
    [5.0, 3.0, 1.0].map(|offset| {
        let k = (offset + hue / 60.0).rem_euclid(6.0);
        value - value * saturation * k.min(4.0 - k).clamp(0.0, 1.0)
    })
}

#[cfg(test)]
mod tests;
