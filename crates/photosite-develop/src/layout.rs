//! Other layouts: a raw image as a sensor with other filters would have taken it, for developers that know few.
//!
//! In: a mosaic. Out: a raw image of its active area as a Bayer mosaic, or with red, green and blue at every pixel,
//! on the scale of digital numbers that it came on. What it says of noise holds for pixels that were measured; those
//! that were found from their neighbours are smoother.

use std::borrow::Cow;

use photosite_core::rows::for_each_row;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::choices::Demosaic;
use super::{black_level, demosaic, white_balance};
use photosite_core::Invalid;
use photosite_core::image::Planes;
use photosite_core::keys::Keys;
use photosite_raw::{Cfa, RawImage};

/// The filters that a raw file tells of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum RawLayout {
    /// Layout of the sensor.
    #[default]
    Sensor,
    /// A Bayer mosaic, from blocks of pixels of one colour as those of Quad Bayer.
    Bayer,
    /// Red, green and blue at every pixel, from any mosaic of them.
    Linear,
}

impl RawLayout {
    /// Refuses filters from which there is no way to this layout.
    pub fn check(self, cfa: &Cfa) -> Result<(), Invalid> {
        let refused = |wanted: &str| {
            let message = format!("the filters {cfa} are not {wanted}");
            Err(Invalid::new("raw_layout", message).help("write raw_layout = \"sensor\""))
        };
        match self {
            Self::Sensor => Ok(()),
            Self::Bayer if bayer_of(cfa).is_some() => Ok(()),
            Self::Bayer => refused("blocks of one colour each, as those of Quad Bayer are"),
            Self::Linear if cfa.channels() == ["R", "G", "B"] => Ok(()),
            Self::Linear => refused("red, green and blue alone"),
        }
    }
}

/// The image in another layout.
pub fn with_layout(raw: &RawImage, layout: RawLayout) -> Result<Cow<'_, RawImage>, Invalid> {
    layout.check(&raw.cfa)?;
    if layout == RawLayout::Sensor || raw.cfa.is_full() {
        return Ok(Cow::Borrowed(raw));
    }
    let raw = raw.linear().cropped();
    let neutral = raw.metadata.as_shot_neutral.clone().unwrap_or_else(|| vec![1.0; raw.cfa.channels().len()]);
    let mut signal = black_level::subtract(&raw, true);
    white_balance::apply(&mut signal, &raw, &neutral, f32::INFINITY);
    let planes = demosaic::demosaic(&signal, &raw, Demosaic::Auto)?;
    let cfa = match layout {
        RawLayout::Bayer => bayer_of(&raw.cfa).unwrap_or_else(|| raw.cfa.clone()),
        RawLayout::Sensor | RawLayout::Linear => Cfa::full(["R", "G", "B"])?,
    };
    let black = raw.black_level_dn.mean();
    let range = f32::from(raw.white_level_dn) - black;
    let factors: Vec<f32> = neutral.iter().map(|n| *n as f32 * range).collect();
    let number = |planes: &Planes, channel: usize, i: usize| {
        // A cast takes what is below 0 to 0. Interpolation must not pass what the converter can say.
        (planes.channels()[channel].data[i] * factors[channel] + black).round().min(largest(raw.bits)) as u16
    };
    let samples = cfa.samples_per_pixel();
    let mut data = vec![0; raw.width * raw.height * samples];
    let row_length = raw.width * samples;
    for_each_row(&mut data, row_length, |y, row| {
        for (x, dn) in row.iter_mut().enumerate() {
            *dn = number(&planes, cfa.channel_at(x, y), y * raw.width + x / samples);
        }
    });
    let black_level_dn = photosite_raw::BlackLevel::uniform(black);
    Ok(Cow::Owned(RawImage { data, cfa, black_level_dn, channel_whites_dn: None, ..raw }))
}

/// The Bayer filter whose pixels an array's blocks are; `None` where there are no such blocks.
fn bayer_of(cfa: &Cfa) -> Option<Cfa> {
    let (columns, rows) = cfa.tile_size();
    let block = columns / 2;
    if columns != rows || columns % 2 == 1 || block < 2 || cfa.is_full() {
        return None;
    }
    // A part of an image may begin anywhere within a block.
    (0..block * block).find_map(|i| {
        let (left, top) = (i % block, i / block);
        let corner = |x: usize, y: usize| cfa.channel_at(left + x * block, top + y * block);
        let fills = |i: usize| {
            let (x, y) = (i % columns, i / columns);
            cfa.channel_at(left + x, top + y) == corner(x / block, y / block)
        };
        let letters = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| cfa.channels()[corner(x, y)].as_str());
        let bayer = Cfa::parse(&letters.concat()).ok().filter(Cfa::is_bayer)?;
        (0..columns * rows).all(fills).then_some(bayer)
    })
}

/// Largest digital number of a converter.
fn largest(bits: u32) -> f32 {
    (1u32 << bits.min(16)) as f32 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_raw::{PixelArea, RawMetadata};

    fn even(cfa: &str) -> RawImage {
        let cfa = Cfa::parse(cfa).expect("known");
        let (width, height) = (40, 28);
        let number = |i: usize| 64 + [500, 1000, 700][cfa.channel_at(i % width, i / width)];
        RawImage {
            width,
            height,
            data: (0..width * height).map(number).collect(),
            bits: 12,
            black_level_dn: 64.into(),
            white_level_dn: 4000,
            active_area: Some(PixelArea { x: 3, y: 1, width: 33, height: 25 }),
            metadata: RawMetadata { as_shot_neutral: Some(vec![0.5, 1.0, 0.7]), ..RawMetadata::default() },
            cfa,
            ..RawImage::default()
        }
    }

    #[test]
    fn even_colours_keep_their_numbers() {
        for (cfa, layout) in [
            ("quad-bayer", RawLayout::Bayer),
            ("nona-bayer", RawLayout::Bayer),
            ("quad-bayer", RawLayout::Linear),
            ("x-trans", RawLayout::Linear),
            ("GBRG", RawLayout::Linear),
        ] {
            let taken = even(cfa);
            let raw = with_layout(&taken, layout).expect("possible");
            assert_eq!((raw.width, raw.height, raw.active_area), (33, 25, None));
            assert_eq!(raw.cfa.is_bayer(), layout == RawLayout::Bayer);
            raw.validate().expect("whole");
            let row_length = raw.row_length();
            for (i, dn) in raw.data.iter().enumerate() {
                let channel = &raw.cfa.channels()[raw.cfa.channel_at(i % row_length, i / row_length)];
                let expected = 64 + [500, 1000, 700]["RGB".find(channel.as_str()).expect("one of three")];
                assert_eq!(*dn, expected, "{cfa} {layout:?} {channel} at {i}");
            }
        }
    }

    #[test]
    fn measured_numbers_of_the_right_colour_stay() {
        let mut raw = even("quad-bayer");
        raw.data.iter_mut().enumerate().for_each(|(i, dn)| *dn += (i * 37 % 211) as u16);
        let bayer = with_layout(&raw, RawLayout::Bayer).expect("possible");
        let before = raw.cropped();
        let mut same = 0;
        for i in 0..bayer.data.len() {
            let (x, y) = (i % bayer.width, i / bayer.width);
            let name = |raw: &RawImage| raw.cfa.channels()[raw.cfa.channel_at(x, y)].clone();
            if name(&bayer) == name(&before) {
                assert_eq!(bayer.data[i], before.data[i], "at {x}, {y}");
                same += 1;
            }
        }
        // Six of the sixteen pixels of a Quad Bayer tile have the filter that Bayer has there, but for cut tiles.
        assert!(same * 3 > bayer.data.len(), "{same} of {}", bayer.data.len());
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for (cfa, layout) in [("RGGB", RawLayout::Bayer), ("rgbw", RawLayout::Linear), ("mono", RawLayout::Linear)] {
            let error = layout.check(&Cfa::parse(cfa).expect("known")).expect_err("refused");
            assert_eq!(error.key, "raw_layout");
        }
        assert!(RawLayout::Sensor.check(&Cfa::parse("rgbw").expect("known")).is_ok());
    }
}
