//! `electrons.exr`: the mean photo-electrons of an exposure, noise-free, and the variance that Monte Carlo noise leaves
//! in them.
//!
//! One channel for each of the sensor's (`R`, `G`, `B` or `Y`): mean electrons of that filter at every pixel, e⁻.
//! Beside each its variance, `variance.R` …, (e⁻)². The attribute `unit` says `e-`, `exposureTime` the seconds that the
//! electrons were collected for. The variance is that of independent samples. Sobol points leave less: it is 1.2 to 1.9
//! times the variance over renders with other seeds.

use std::io::{self, BufRead, Seek, Write};

use photosite_core::Invalid;
use photosite_core::image::{Channel, Estimate, Planes};
use photosite_core::units::Seconds;

use super::exr::{Attribute, ExrImage, NamedPlane, Values, read_exr, write_planes};

/// Prefix of the name of a channel's variance.
pub(super) const VARIANCE: &str = "variance.";
const UNIT: &str = "e-";

/// Writes electrons with their variance.
pub fn write_electrons<W: Write + Seek>(electrons: &Estimate, time: Seconds, to: W) -> io::Result<()> {
    let Estimate { mean, variance } = electrons;
    let planes = named(mean, "").chain(named(variance, VARIANCE));
    let attributes = [("unit", Attribute::Text(UNIT.to_owned())), ("exposureTime", Attribute::Number(time.0))];
    write_planes(Values::Noisy, [mean.width(), mean.height()], planes, &attributes, to)
}

/// Planes with `prefix` before their names.
fn named<'a>(planes: &'a Planes, prefix: &'static str) -> impl Iterator<Item = NamedPlane<'a>> {
    let named = move |(plane, channel): (usize, &Channel)| {
        let name = format!("{prefix}{}", channel.name);
        NamedPlane { name, of: planes, plane }
    };
    planes.channels().iter().enumerate().map(named)
}

/// Reads electrons with their variance, for the channels that the file has it for.
pub fn read_electrons<R: BufRead + Seek>(from: R) -> Result<(Estimate, Seconds), Invalid> {
    electrons(read_exr(from)?.whole()?)
}

/// Electrons of an EXR image that is in memory, as [`read_electrons`] reads them from a file.
pub fn electrons(image: ExrImage) -> Result<(Estimate, Seconds), Invalid> {
    if image.text("unit") != Some(UNIT) {
        return Err(Invalid::new("unit", "the file does not say that it holds electrons")
            .help("give the electrons.exr that photosite render wrote"));
    }
    let Some(time) = image.number("exposureTime").filter(|time| time.is_finite() && *time > 0.0) else {
        return Err(Invalid::new("exposureTime", "the file does not say how long the electrons were collected"));
    };
    let (width, height) = (image.planes.width(), image.planes.height());
    let (mut mean, mut variance) = (Vec::new(), Vec::new());
    for channel in image.planes.into_channels() {
        match channel.name.strip_prefix(VARIANCE) {
            Some(name) => variance.push(Channel { name: name.to_owned(), data: channel.data }),
            None => mean.push(channel),
        }
    }
    let planes = |channels| Planes::new(width, height, channels);
    Ok((Estimate { mean: planes(mean)?, variance: planes(variance)? }, Seconds(time)))
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::exr::write_exr;

    #[test]
    fn electrons_come_back_with_variance_and_time() {
        let mut mean = Planes::zeros(4, 3, ["B", "G", "R"]);
        mean.channels_mut()[1].data[5] = 123.5;
        let mut variance = Planes::zeros(4, 3, ["B", "G", "R"]);
        variance.channels_mut()[2].data[7] = 0.25;
        let electrons = Estimate { mean, variance };
        let mut file = Vec::new();
        write_electrons(&electrons, Seconds(0.01), Cursor::new(&mut file)).expect("written");
        assert_eq!(read_electrons(Cursor::new(&file)).expect("read"), (electrons, Seconds(0.01)));
    }

    #[test]
    fn other_images_are_refused() {
        let planes = Planes::zeros(2, 2, ["R", "G", "B"]);
        let unit = |unit: &str| ("unit", Attribute::Text(unit.to_owned()));
        for (attributes, key) in [
            (vec![], "unit"),
            (vec![unit("lux")], "unit"),
            (vec![unit("e-")], "exposureTime"),
            (vec![unit("e-"), ("exposureTime", Attribute::Number(f64::NAN))], "exposureTime"),
        ] {
            let mut file = Vec::new();
            write_exr(&planes, &attributes, Cursor::new(&mut file)).expect("written");
            assert_eq!(read_electrons(Cursor::new(&file)).expect_err("refused").key, key);
        }
    }
}
