//! Pictures of a physical quantity: named planes of numbers, and Monte Carlo estimates with their variance.

use std::fmt;

use rayon::prelude::*;

use crate::Invalid;

/// One named plane of a picture, row by row from the top-left pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// What the plane holds: "R", "Y", "550,0nm" …
    pub name: String,
    /// width × height values.
    pub data: Vec<f32>,
}

/// Planes of one quantity on one pixel grid. The unit is that of the quantity and named where a picture is passed on.
#[derive(Clone, Debug, PartialEq)]
pub struct Planes {
    width: usize,
    height: usize,
    channels: Vec<Channel>,
}

impl Planes {
    /// Planes filled with zeros.
    pub fn zeros<S: Into<String>>(width: usize, height: usize, names: impl IntoIterator<Item = S>) -> Self {
        let channel = |name: S| Channel { name: name.into(), data: vec![0.0; width * height] };
        Self { width, height, channels: names.into_iter().map(channel).collect() }
    }

    /// From filled channels; each must hold width × height values.
    pub fn new(width: usize, height: usize, channels: Vec<Channel>) -> Result<Self, Invalid> {
        match channels.iter().find(|c| c.data.len() != width * height) {
            Some(c) => {
                let message = format!("channel {} holds {} values for {width} × {height} pixels", c.name, c.data.len());
                Err(Invalid::new("", message))
            }
            None => Ok(Self { width, height, channels }),
        }
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The planes.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The planes, to be written.
    pub fn channels_mut(&mut self) -> &mut [Channel] {
        &mut self.channels
    }

    /// The planes, given away.
    pub fn into_channels(self) -> Vec<Channel> {
        self.channels
    }

    /// The values of the plane called `name`.
    pub fn plane(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|c| c.name == name).map(|c| &c.data[..])
    }

    /// Every value times `factor`.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        for channel in &mut self.channels {
            channel.data.par_iter_mut().for_each(|value| *value = (f64::from(*value) * factor) as f32);
        }
        self
    }
}

/// A Monte Carlo estimate: mean, and variance of that mean, on the same grid with the same channel names.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// The estimated quantity.
    pub mean: Planes,
    /// Variance of the mean, in the squared unit; channels of which it is not known are missing. With a stratified
    /// sampler (Sobol) this is an upper bound in practice, since it is computed as if samples were independent.
    pub variance: Planes,
}

impl Estimate {
    /// The estimate of the quantity times `factor`: the variance goes with its square.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self { mean: self.mean.scaled(factor), variance: self.variance.scaled(factor * factor) }
    }
}

/// Values of planes that are NaN or infinite.
#[derive(Clone, Debug, PartialEq)]
pub struct NotFinite {
    /// How many there are.
    pub count: usize,
    channel: String,
    value: f32,
    place: [usize; 2],
}

impl NotFinite {
    /// Values of the planes that are not finite; `None` where there are none.
    pub fn of(planes: &Planes) -> Option<Self> {
        let width = planes.width().max(1);
        let mut found: Option<Self> = None;
        for channel in planes.channels() {
            for (i, &value) in channel.data.iter().enumerate().filter(|(_, value)| !value.is_finite()) {
                let place = [i % width, i / width];
                let first = || Self { count: 0, channel: channel.name.clone(), value, place };
                found.get_or_insert_with(first).count += 1;
            }
        }
        found
    }

    /// Refuses planes that hold any, where they would make a figure or a light of all planes neither.
    pub fn refuse(planes: &Planes) -> Result<(), Invalid> {
        let refused = |found: Self| Invalid::new("", found.to_string()).help("write finite values in their place");
        Self::of(planes).map_or(Ok(()), |found| Err(refused(found)))
    }
}

impl fmt::Display for NotFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { count, channel, value, place: [x, y] } = self;
        let (are, them) = if *count == 1 { ("number is", "it is") } else { ("numbers are", "the first is") };
        write!(f, "{count} {are} not finite: {them} {value}, of {channel} in column {x}, row {y}")
    }
}
