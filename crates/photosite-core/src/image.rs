//! Images of a physical quantity: named channels of pixel values, and Monte Carlo estimates with their variance.

use std::fmt;

use rayon::prelude::*;

use crate::Invalid;

/// One named channel of an image, row by row from the top-left pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Channel name: "R", "Y", "550,0nm" …
    pub name: String,
    /// Pixel values, width × height of them.
    pub data: Vec<f32>,
}

/// Channels of one quantity on one pixel grid. The unit is that of the quantity and is stated where an image is passed
/// on.
#[derive(Clone, Debug, PartialEq)]
pub struct Planes {
    width: usize,
    height: usize,
    channels: Vec<Channel>,
}

impl Planes {
    /// Channels filled with zeros.
    pub fn zeros<S: Into<String>>(width: usize, height: usize, names: impl IntoIterator<Item = S>) -> Self {
        let channel = |name: S| Channel { name: name.into(), data: vec![0.0; width * height] };
        Self { width, height, channels: names.into_iter().map(channel).collect() }
    }

    /// An image of filled channels, each of which must hold width × height values.
    pub fn new(width: usize, height: usize, channels: Vec<Channel>) -> Result<Self, Invalid> {
        match channels.iter().find(|c| c.data.len() != width * height) {
            Some(c) => {
                let message = format!("channel {} holds {} values for {width} × {height} pixels", c.name, c.data.len());
                Err(Invalid::new("", message))
            }
            None => Ok(Self { width, height, channels }),
        }
    }

    /// Number of pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All channels.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// All channels, for writing.
    pub fn channels_mut(&mut self) -> &mut [Channel] {
        &mut self.channels
    }

    /// Unwraps the channels.
    pub fn into_channels(self) -> Vec<Channel> {
        self.channels
    }

    /// Pixel values of the channel called `name`.
    pub fn plane(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|c| c.name == name).map(|c| &c.data[..])
    }

    /// The image with every value multiplied by `factor`.
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
    /// Mean of the estimated quantity.
    pub mean: Planes,
    /// Variance of the mean, in the squared unit; channels whose variance is not known are missing. With a stratified
    /// sampler (Sobol) it is an upper bound in practice, since it is computed as if samples were independent.
    pub variance: Planes,
}

impl Estimate {
    /// Estimate of the quantity times `factor`; the variance is multiplied by its square.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self { mean: self.mean.scaled(factor), variance: self.variance.scaled(factor * factor) }
    }
}

/// Pixel values that are NaN or infinite: their number, and the first.
#[derive(Clone, Debug, PartialEq)]
pub struct NotFinite {
    /// Number of such values.
    pub count: usize,
    channel: String,
    value: f32,
    place: [usize; 2],
}

impl NotFinite {
    /// Pixel values that are NaN or infinite; `None` where all are finite.
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

    /// Refuses an image with NaN or infinite values, where a single one would spoil a figure or an emitter made of all
    /// pixels.
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
