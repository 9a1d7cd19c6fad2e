//! Colour filter arrays: which channel a pixel belongs to.

use crate::Invalid;

/// A tile of channel indices that repeats over the sensor. Monochrome sensors have one channel and a tile of 1 × 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cfa {
    width: usize,
    height: usize,
    tile: Vec<u8>,
    channels: Vec<String>,
}

impl Cfa {
    /// A monochrome sensor, whose only channel is called `Y`.
    pub fn mono() -> Self {
        Self { width: 1, height: 1, tile: vec![0], channels: vec!["Y".to_owned()] }
    }

    /// From a sensor file's text: `mono`, or the four letters of a Bayer tile, top-left, top-right, bottom-left,
    /// bottom-right. Channels are ordered R, G, B.
    pub fn parse(text: &str) -> Result<Self, Invalid> {
        match text {
            "mono" => Ok(Self::mono()),
            "RGGB" | "BGGR" | "GRBG" | "GBRG" => {
                let channels = ["R", "G", "B"].map(str::to_owned).to_vec();
                let index = |letter: char| "RGB".find(letter).unwrap_or(0) as u8;
                Ok(Self { width: 2, height: 2, tile: text.chars().map(index).collect(), channels })
            }
            other => Err(Invalid::new("cfa", format!("unknown colour filter array {other:?}"))
                .help("write \"RGGB\", \"BGGR\", \"GRBG\", \"GBRG\" or \"mono\"")),
        }
    }

    /// Names of the channels.
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// Tile size in pixels (width, height).
    pub fn tile_size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Index into [`Self::channels`] of the pixel at column x, row y.
    #[inline]
    pub fn channel_at(&self, x: usize, y: usize) -> usize {
        usize::from(self.tile[y % self.height * self.width + x % self.width])
    }

    /// Whether there is only one channel.
    pub fn is_mono(&self) -> bool {
        self.channels.len() == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bayer_phases_put_red_and_blue_where_they_say() {
        for (text, red) in [("RGGB", (0, 0)), ("GRBG", (1, 0)), ("GBRG", (0, 1)), ("BGGR", (1, 1))] {
            let cfa = Cfa::parse(text).expect("a Bayer phase");
            assert_eq!(cfa.channel_at(red.0, red.1), 0, "{text}");
            assert_eq!(cfa.channel_at(red.0 + 3, red.1 + 5), 2, "{text}: blue is diagonal to red");
            assert_eq!(cfa.channel_at(red.0 + 1, red.1), 1, "{text}");
        }
        assert!(Cfa::parse("RGBG").is_err());
    }
}
