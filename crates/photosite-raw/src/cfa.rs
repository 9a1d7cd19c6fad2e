//! Colour filter arrays: the channel that each value of a raw image belongs to.

use std::fmt;

use photosite_core::Invalid;
use serde::{Deserialize, Serialize};

/// A tile of channels that repeats over the sensor from its top-left pixel.
///
/// Two kinds of layout are said in one way, since numbers lie in rows: a *mosaic* has one number a pixel, and its tile
/// counts pixels; a *full* layout (stacked pixels, three chips, remosaiced images) has a number of every channel at
/// every pixel, one beside the other, and its tile is that one pixel. So `tile_size` and `channel_at` count numbers
/// along a row, which are pixels where [`Self::samples_per_pixel`] is 1.
///
/// | text | meaning |
/// |---|---|
/// | `mono` | one channel, `Y` |
/// | `RGGB`, `RGRGIBGB…` | a square tile, row by row from the top-left pixel |
/// | `RGRG/GBGB` | rows of a tile of any shape |
/// | `x-trans`, `quad-bayer`, … | a tile of [`NAMED`] |
/// | `full:RGB` | these channels at every pixel |
///
/// Channels are named by their letters, any of A to Z, and ordered R, G, B as far as there are such, then the others as
/// they first appear.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cfa {
    width: usize,
    height: usize,
    samples_per_pixel: usize,
    tile: Vec<u8>,
    channels: Vec<String>,
}

/// Tiles that have a name, with their rows.
///
/// `C` is cyan in `cygm` and clear in `rccb` and `rccc`, as makers write it; `W` is white, which sees all light, `I`
/// infrared, `E` emerald. `rgbw` is Kodak's pattern of half white pixels
/// ([Compton07](photosite_core::references#compton07)); `rgb-ir` is that of the OmniVision and onsemi sensors for cars.
pub const NAMED: [(&str, &str); 9] = [
    ("quad-bayer", "RRGG/RRGG/GGBB/GGBB"),
    ("nona-bayer", "RRRGGG/RRRGGG/RRRGGG/GGGBBB/GGGBBB/GGGBBB"),
    ("x-trans", "GBGGRG/RGRBGB/GBGGRG/GRGGBG/BGBRGR/GRGGBG"),
    ("rgbw", "WGWR/GWRW/WBWG/BWGW"),
    ("rgb-ir", "BGRG/GIGI/RGBG/GIGI"),
    ("rccb", "RC/CB"),
    ("rccc", "RC/CC"),
    ("ryyb", "RY/YB"),
    ("cygm", "CY/GM"),
];

/// Most pixels along a side of a tile.
const MAX_TILE: usize = 64;
/// Begins the text of a full layout.
const FULL: &str = "full:";

impl Default for Cfa {
    fn default() -> Self {
        Self::mono()
    }
}

impl Cfa {
    /// A monochrome sensor, whose only channel is called `Y`.
    pub fn mono() -> Self {
        Self { width: 1, height: 1, samples_per_pixel: 1, tile: vec![0], channels: vec!["Y".to_owned()] }
    }

    /// Full layout: all of these channels at every pixel. Each name is one letter from A to Z, and no two are the same.
    pub fn full<'a>(channels: impl IntoIterator<Item = &'a str>) -> Result<Self, Invalid> {
        let text: String = channels.into_iter().collect();
        let letters: Vec<char> = text.chars().collect();
        if letters.is_empty() {
            return Err(invalid("a layout of no channels").help("for example \"full:RGB\""));
        }
        readable(&letters)?;
        if let Some(i) = (1..letters.len()).find(|&i| letters[..i].contains(&letters[i])) {
            let message = format!("channel {} appears twice in \"{FULL}{text}\"", letters[i]);
            return Err(invalid(message).help("write each channel once"));
        }
        let channels = channels_of(&letters);
        let samples_per_pixel = channels.len();
        Ok(Self { width: samples_per_pixel, height: 1, samples_per_pixel, tile: indices(samples_per_pixel), channels })
    }

    /// Reads the text that sensor files hold; see [`Cfa`].
    pub fn parse(text: &str) -> Result<Self, Invalid> {
        if text == "mono" {
            return Ok(Self::mono());
        }
        if let Some(channels) = text.strip_prefix(FULL) {
            return Self::full([channels]);
        }
        if let Some((_, tile)) = NAMED.iter().find(|(name, _)| *name == text) {
            return Self::tile(&tile.split('/').collect::<Vec<_>>());
        }
        if text.is_empty() {
            return Err(invalid("an empty colour filter array").help(HELP));
        }
        if text.contains('/') {
            // A tile of one row ends with a slash, which tells it from a square.
            return Self::tile(&text.strip_suffix('/').unwrap_or(text).split('/').collect::<Vec<_>>());
        }
        let letters: Vec<char> = text.chars().collect();
        readable(&letters).map_err(|error| {
            // A word that is no tile was meant to be a name.
            Invalid { message: format!("unknown colour filter array {text:?}: {}", error.message), ..error }
        })?;
        let side = letters.len().isqrt();
        if side * side != letters.len() {
            let message = format!("the {} letters of {text:?} do not form a square tile", letters.len());
            return Err(invalid(message).help("write the rows with a slash between them, for example \"RGRG/GBGB\""));
        }
        Self::tile(&letters.chunks(side).map(String::from_iter).collect::<Vec<_>>())
    }

    /// A mosaic from the rows of its tile.
    fn tile<S: AsRef<str>>(rows: &[S]) -> Result<Self, Invalid> {
        let rows: Vec<Vec<char>> = rows.iter().map(|row| row.as_ref().chars().collect()).collect();
        let (width, height) = (rows[0].len(), rows.len());
        if let Some(row) = rows.iter().position(|row| row.len() != width || row.is_empty()) {
            let message = format!("row {} of the tile has {} letters, the first {width}", row + 1, rows[row].len());
            return Err(invalid(message).help("write rows of the same length, for example \"RGRG/GBGB\""));
        }
        if width > MAX_TILE || height > MAX_TILE {
            let message = format!("a tile of {width} × {height} pixels is too large");
            return Err(invalid(message).help(format!("write at most {MAX_TILE} × {MAX_TILE}, which repeat")));
        }
        let letters = rows.concat();
        readable(&letters)?;
        let channels = channels_of(&letters);
        let index = |letter: &char| channels.iter().position(|name| name.starts_with(*letter)).unwrap_or(0) as u8;
        Ok(Self { width, height, samples_per_pixel: 1, tile: letters.iter().map(index).collect(), channels })
    }

    /// A mosaic of `width` indices of channels in a row of its tile, which are kept in this order.
    pub(super) fn of_indices(width: usize, tile: Vec<u8>, channels: &[&str]) -> Result<Self, Invalid> {
        let height = tile.len() / width.max(1);
        let known = tile.iter().all(|&channel| usize::from(channel) < channels.len());
        if width == 0 || height == 0 || width > MAX_TILE || height > MAX_TILE || width * height != tile.len() || !known
        {
            return Err(invalid(format!("{} filters do not form a tile of {width} columns", tile.len())));
        }
        let channels = channels.iter().map(|&name| name.to_owned()).collect();
        Ok(Self { width, height, samples_per_pixel: 1, tile, channels })
    }

    /// Tile whose first pixel is that at column x, row y of this one: the layout of a part of the image that begins
    /// there.
    pub fn from(&self, x: usize, y: usize) -> Self {
        let mut cfa = self.clone();
        let first = x * self.samples_per_pixel;
        for (i, channel) in cfa.tile.iter_mut().enumerate() {
            *channel = self.channel_at(first + i % self.width, y + i / self.width) as u8;
        }
        cfa
    }

    /// Layout of bins of `factor` columns and rows of pixels of one colour, and how far apart along both sides the
    /// pixels of a bin are: neighbours where whole blocks of that size have one colour, else pixels of the same place
    /// in neighbouring tiles.
    pub fn binned(&self, factor: [usize; 2]) -> (Self, [usize; 2]) {
        let samples = self.samples_per_pixel;
        let tile = [self.width / samples, self.height];
        let divides = (0..2).all(|axis| tile[axis] == 1 || tile[axis].is_multiple_of(factor[axis]));
        let first = |position: usize, axis: usize| position / factor[axis] * factor[axis];
        let one_colour = (0..self.tile.len()).map(|i| [i % self.width, i / self.width]).all(|[x, y]| {
            let (pixel, sample) = (x / samples, x % samples);
            self.channel_at(x, y) == self.channel_at(first(pixel, 0) * samples + sample, first(y, 1))
        });
        if !(divides && one_colour) {
            return (self.clone(), tile);
        }
        let [width, height] = [0, 1].map(|axis| tile[axis].div_ceil(factor[axis]));
        let channel = |i: usize| {
            let (x, y) = (i % (width * samples), i / (width * samples));
            self.channel_at(x / samples * factor[0] * samples + x % samples, y * factor[1]) as u8
        };
        let tile = (0..width * samples * height).map(channel).collect();
        (Self { width: width * samples, height, tile, ..self.clone() }, [1, 1])
    }

    /// Names of the channels.
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// Number of values a pixel has: 1 in a mosaic, as many as channels in a full layout.
    pub fn samples_per_pixel(&self) -> usize {
        self.samples_per_pixel
    }

    /// Tile size in values along a row, and rows.
    pub fn tile_size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Index into [`Self::channels`] of the x-th value of row y.
    #[inline]
    pub fn channel_at(&self, x: usize, y: usize) -> usize {
        usize::from(self.tile[y % self.height * self.width + x % self.width])
    }

    /// Whether there is only one channel.
    pub fn is_mono(&self) -> bool {
        self.channels.len() == 1
    }

    /// Whether every pixel has a value of every channel, and more than one.
    pub fn is_full(&self) -> bool {
        self.samples_per_pixel > 1
    }

    /// Whether pixels lack channels that others have.
    pub fn is_mosaic(&self) -> bool {
        !(self.is_mono() || self.is_full())
    }

    /// Whether the tile is one of the four phases of a Bayer filter.
    pub fn is_bayer(&self) -> bool {
        let corners = [0, 1, 2, 3].map(|i| self.channel_at(i % 2, i / 2));
        let green_across = [[0, 1, 1, 2], [2, 1, 1, 0]].contains(&corners);
        let green_down = [[1, 0, 2, 1], [1, 2, 0, 1]].contains(&corners);
        self.tile_size() == (2, 2) && self.channels == ["R", "G", "B"] && (green_across || green_down)
    }
}

/// The text that [`Cfa::parse`] reads.
impl fmt::Display for Cfa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let letters: Vec<&str> =
            self.tile.iter().map(|&channel| self.channels[usize::from(channel)].as_str()).collect();
        if self.is_full() {
            return write!(f, "{FULL}{}", letters.concat());
        }
        if *self == Self::mono() {
            return f.write_str("mono");
        }
        let rows: Vec<String> = letters.chunks(self.width).map(<[&str]>::concat).collect();
        let text = rows.join("/");
        if let Some((name, _)) = NAMED.iter().find(|(name, rows)| *rows == text && name.contains('-')) {
            return f.write_str(name);
        }
        match self.tile_size() {
            (width, 1) if width > 1 => write!(f, "{text}/"),
            (2, 2) => f.write_str(&rows.concat()),
            _ => f.write_str(&text),
        }
    }
}

const HELP: &str = "write a Bayer tile such as \"RGGB\", \"mono\", \"quad-bayer\", \"x-trans\", \"rgbw\", the rows of a \
     tile such as \"RGRG/GBGB\", or \"full:RGB\" for all channels at every pixel";

fn invalid(message: impl Into<String>) -> Invalid {
    Invalid::new("cfa", message)
}

/// Refuses what is no letter from A to Z.
fn readable(letters: &[char]) -> Result<(), Invalid> {
    match letters.iter().find(|letter| !letter.is_ascii_uppercase()) {
        Some(other) => Err(invalid(format!("{other:?} is not a channel, which has a letter from A to Z")).help(HELP)),
        None => Ok(()),
    }
}

/// The channels of these letters: R, G and B first, then the others as they appear.
fn channels_of(letters: &[char]) -> Vec<String> {
    let mut channels: Vec<char> = ['R', 'G', 'B'].into_iter().filter(|letter| letters.contains(letter)).collect();
    for &letter in letters {
        if !channels.contains(&letter) {
            channels.push(letter);
        }
    }
    channels.into_iter().map(String::from).collect()
}

/// 0, 1, 2, …: at most 26 channels have names.
fn indices(count: usize) -> Vec<u8> {
    (0..count as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cfa(text: &str) -> Cfa {
        Cfa::parse(text).expect("a layout")
    }

    #[test]
    fn bayer_phases_put_red_and_blue_where_they_say() {
        for (text, red) in [("RGGB", (0, 0)), ("GRBG", (1, 0)), ("GBRG", (0, 1)), ("BGGR", (1, 1))] {
            let cfa = cfa(text);
            assert_eq!(cfa.channel_at(red.0, red.1), 0, "{text}");
            assert_eq!(cfa.channel_at(red.0 + 3, red.1 + 5), 2, "{text}: blue is diagonal to red");
            assert_eq!(cfa.channel_at(red.0 + 1, red.1), 1, "{text}");
            assert!(cfa.is_bayer() && !cfa.is_full() && !cfa.is_mono());
        }
        for text in ["RGBG", "mono", "x-trans", "full:RGB", "RYYB", "RRRR"] {
            assert!(!cfa(text).is_bayer(), "{text}");
        }
    }

    #[test]
    fn channels_come_as_red_green_blue_and_then_as_they_appear() {
        for (text, channels) in [
            ("BGGR", "RGB"),
            ("rgbw", "RGBW"),
            ("WBGR", "RGBW"),
            ("rgb-ir", "RGBI"),
            ("rccb", "RBC"),
            ("ryyb", "RBY"),
            ("cygm", "GCYM"),
            ("mono", "Y"),
            ("Y", "Y"),
            ("full:BGR", "RGB"),
            ("full:IR", "RI"),
        ] {
            assert_eq!(cfa(text).channels().concat(), channels, "{text}");
        }
    }

    #[test]
    fn tiles_of_any_shape_lie_as_they_are_written() {
        let stripes = cfa("RGB/");
        assert_eq!((stripes.tile_size(), stripes.channel_at(4, 7)), ((3, 1), 1));
        let tall = cfa("RG/GB/GR/BG");
        assert_eq!((tall.tile_size(), tall.channel_at(1, 6)), ((2, 4), 0));
        // Fujifilm's tile has 8 red, 20 green and 8 blue pixels, and red and blue in every row and column.
        let x_trans = cfa("x-trans");
        let at = |x, y| x_trans.channel_at(x, y);
        let count = |channel| (0..36).filter(|i| at(i % 6, i / 6) == channel).count();
        assert_eq!([0, 1, 2].map(count), [8, 20, 8]);
        for line in 0..6 {
            for channel in [0, 2] {
                assert!((0..6).any(|i| at(i, line) == channel) && (0..6).any(|i| at(line, i) == channel));
            }
        }
    }

    #[test]
    fn every_pixel_of_a_full_layout_has_all_channels() {
        let cfa = cfa("full:RGB");
        assert_eq!(Cfa::full(["R", "G", "B"]).as_ref(), Ok(&cfa));
        assert_eq!((cfa.samples_per_pixel(), cfa.tile_size()), (3, (3, 1)));
        assert_eq!((0..7).map(|x| cfa.channel_at(x, 5)).collect::<Vec<_>>(), [0, 1, 2, 0, 1, 2, 0]);
        assert!(cfa.is_full() && !cfa.is_mono());
        assert_eq!(cfa.from(1, 1), cfa, "a pixel further on it begins anew");
    }

    #[test]
    fn texts_come_back() {
        let square = "ABCD/EFGH/IJKL/MNOP";
        for text in ["mono", "RGGB", "RGB/", "RG/GB/GR/BG", "full:RGB", "x-trans", "rgbw", "CYGM", "R", square] {
            assert_eq!(cfa(&cfa(text).to_string()), cfa(text), "{text}");
        }
        assert_eq!(
            ["x-trans", "RG/GB", "Y", "RCCB"].map(|text| cfa(text).to_string()),
            ["x-trans", "RGGB", "mono", "RCCB"]
        );
    }

    #[test]
    fn a_part_of_an_image_begins_elsewhere_in_the_tile() {
        assert_eq!(cfa("RGGB").from(1, 0), cfa("GRBG"));
        let (whole, part) = (cfa("x-trans"), cfa("x-trans").from(8, 3));
        assert!((0..36).all(|i| part.channel_at(i % 6, i / 6) == whole.channel_at(8 + i % 6, 3 + i / 6)));
    }

    #[test]
    fn what_is_no_layout_is_refused() {
        let wide = "RG".repeat(40) + "/" + &"GB".repeat(40);
        for (text, complaint) in [
            ("", "empty"),
            ("bayer", "unknown colour filter array \"bayer\""),
            ("rggb", "'r' is not a channel"),
            ("RGG", "3 letters"),
            ("RG/GBG", "row 2 of the tile has 3 letters, the first 2"),
            ("RG//GB", "row 2 of the tile has 0 letters"),
            ("/", "row 1 of the tile has 0 letters"),
            ("R1/GB", "'1' is not a channel"),
            ("RГGB", "'Г' is not a channel"),
            (&wide, "80 × 2 pixels is too large"),
            ("full:", "no channels"),
            ("full:RGR", "channel R appears twice"),
            ("full:rgb", "'r' is not a channel"),
        ] {
            let error = Cfa::parse(text).expect_err(text);
            assert!(error.key == "cfa" && error.message.contains(complaint) && error.help.is_some(), "{error}");
        }
    }
}
