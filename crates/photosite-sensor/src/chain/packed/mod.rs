//! Exposure as plain data, for graphics cards: what the stages of one exposure need, as words.
//!
//! | part | holds |
//! |---|---|
//! | [`PackedLight`] | mean electrons of each value, which stay on a card from exposure to exposure |
//! | [`PackedExposure`] | the words of the stages, and the way from digital numbers to a [`RawImage`] |
//! | [`declarations`] | the structs of those words in WGSL, made of the same tables as Rust's |
//! | [`random_tables`] | tables by which random numbers are drawn, the same for all exposures |
//!
//! Each stage gives its own words, from the same facts that the processor exposes with. What a card does not do is
//! refused by key, so that the processor exposes instead.

mod light;
mod random_tables;
mod refusals;

use photosite_core::Invalid;
use photosite_raw::RawImage;

pub use light::{LightLayout, PackedLight};
pub use random_tables::{PLACES, random_tables};

use super::expose::{check, raw_image};
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::Stages;
use crate::signal::words::{LogNormalWords, NONE, NormalWords, StreamWords, Tables, Wide, Words, words};
use crate::stages::amplifiers::{AmplifierNonlinearity, AmplifierWords, ColumnAmplifiers, Gain};
use crate::stages::companding::Compander;
use crate::stages::converter::{Digitiser, DigitiserWords};
use crate::stages::crosstalk::{CrosstalkWords, crosstalk_words};
use crate::stages::dark_current::{DarkCurrent, DarkCurrentWords, HotPixels};
use crate::stages::dark_offset::DarkOffset;
use crate::stages::dead_pixels::DeadPixels;
use crate::stages::defective_numbers::{StuckPixels, TransmissionErrors};
use crate::stages::digital_gain::DigitalGain;
use crate::stages::dual_gain::{BranchWords, DualGainDigitiser, DualGainWords};
use crate::stages::fixed_pattern::PatternWords;
use crate::stages::frame::Frame;
use crate::stages::full_well::FullWell;
use crate::stages::line_noise::{ColumnNoise, RowNoise};
use crate::stages::photo_response::PhotoResponse;
use crate::stages::read_noise::{ReadNoise, ReadNoiseWords};
use crate::stages::reset_noise::ResetNoise;
use crate::stages::shot_noise::ShotNoise;
use crate::{Exposure, NoiseKey, SensorModel};

words! {
    /// All stages in the order of the chain. Places are those of lists in the tables, [`NONE`] for none.
    ExposureWords {
        /// 0, which no driver knows when it compiles.
        zero: u32,
        /// Values in a row, and rows, of all that is read out.
        width: u32,
        height: u32,
        /// Values and rows before the light, and its own.
        light_left: u32,
        light_top: u32,
        light_width: u32,
        light_height: u32,
        crosstalk: CrosstalkWords,
        photo_response: PatternWords,
        dead_pixels: u32,
        shot_noise: StreamWords,
        dark_current: DarkCurrentWords,
        hot_pixels: u32,
        full_well_e: f32,
        reset_noise: NormalWords,
        dark_offset: PatternWords,
        row_noise: u32,
        column_noise: u32,
        amplifiers: AmplifierWords,
        read_noise: ReadNoiseWords,
        gain: f32,
        column_gains: u32,
        column_offsets: u32,
        digitiser: DigitiserWords,
        dual_gain: DualGainWords,
        stuck_pixels: u32,
        /// Place of the number that each number of the converter becomes by digital gain and companding.
        processed: u32,
        transmission_errors: u32,
    }
}

/// Declarations in WGSL of all structs of words, and of the word `NONE` that stands for no list.
pub fn declarations() -> String {
    let structs = [
        Wide::WGSL,
        StreamWords::WGSL,
        NormalWords::WGSL,
        LogNormalWords::WGSL,
        CrosstalkWords::WGSL,
        PatternWords::WGSL,
        DarkCurrentWords::WGSL,
        AmplifierWords::WGSL,
        ReadNoiseWords::WGSL,
        DigitiserWords::WGSL,
        BranchWords::WGSL,
        DualGainWords::WGSL,
        ExposureWords::WGSL,
    ];
    structs.concat() + &format!("const NONE = {NONE}u;\n")
}

/// One exposure of a sensor for a card.
#[derive(Clone, Debug)]
pub struct PackedExposure<'a> {
    frame: Frame<'a>,
    layout: LightLayout,
    words: Vec<u32>,
    tables: Vec<u32>,
}

impl<'a> PackedExposure<'a> {
    /// Packs an exposure of light of `image` columns and rows, as [`expose`](crate::expose()) takes it.
    ///
    /// # Errors
    ///
    /// What [`expose`](crate::expose()) refuses, and by its key the first fact of sensor or exposure that a card does
    /// not have.
    pub fn new(
        image: [usize; 2],
        sensor: &'a SensorModel,
        exposure: &'a Exposure,
        stages: Stages,
        key: NoiseKey,
    ) -> Result<Self, Invalid> {
        check(sensor, exposure, image)?;
        if let Some(refusal) = refusals::refusal(sensor, exposure, stages) {
            return Err(refusal);
        }
        let samples = sensor.cfa.samples_per_pixel();
        let ([left, right], [above, below]) = (sensor.masked.columns, sensor.masked.rows);
        let size = [(left + image[0] + right) * samples, above + image[1] + below];
        let frame = Frame { sensor, exposure, stages, key, size, is_mean: false };
        let mut tables = Tables::default();
        let words = ExposureWords {
            width: size[0] as u32,
            height: size[1] as u32,
            light_left: (left * samples) as u32,
            light_top: above as u32,
            light_width: (image[0] * samples) as u32,
            light_height: image[1] as u32,
            ..stage_words(&frame, &mut tables)
        };
        let mut packed = Vec::new();
        words.append_to(&mut packed);
        let layout = LightLayout::new(image, sensor);
        Ok(Self { frame, layout, words: packed, tables: tables.into_words() })
    }

    /// Words of the struct `ExposureWords`.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Lists that the words name by their places.
    pub fn tables(&self) -> &[u32] {
        &self.tables
    }

    /// Layout of the light that is exposed.
    pub fn layout(&self) -> &LightLayout {
        &self.layout
    }

    /// Digital numbers in a row of all that is read out, and rows.
    pub fn size(&self) -> [usize; 2] {
        self.frame.size
    }

    /// Builds the raw image of digital numbers, row by row, of all that is read out ([`Self::size`]), with the metadata
    /// that [`expose`](crate::expose()) gives it.
    pub fn raw_image(&self, numbers: Vec<u16>) -> RawImage {
        let (whole, part) = raw_image(&self.frame, numbers, self.frame.size, self.layout.image());
        match part {
            None => whole,
            Some(part) => whole.part(part),
        }
    }
}

/// Words of all stages of a frame.
fn stage_words(frame: &Frame<'_>, tables: &mut Tables) -> ExposureWords {
    let Frame { sensor, stages, .. } = *frame;
    let [column_gains, column_offsets] =
        ColumnAmplifiers::new(frame).map_or([NONE; 2], |columns| columns.words(tables));
    ExposureWords {
        crosstalk: crosstalk_words(sensor, stages, tables),
        photo_response: pattern(PhotoResponse::new(frame).map(|stage| stage.words(frame, tables))),
        dead_pixels: DeadPixels::new(frame).map_or(NONE, |stage| stage.words(frame, tables)),
        shot_noise: ShotNoise::new(frame).map(|stage| stage.words()).unwrap_or_default(),
        dark_current: DarkCurrent::new(frame).map(|stage| stage.words()).unwrap_or_default(),
        hot_pixels: HotPixels::new(frame).map_or(NONE, |stage| stage.words(frame, tables)),
        full_well_e: FullWell::word(FullWell::new(frame).as_ref()),
        reset_noise: ResetNoise::new(frame).map(|stage| stage.words()).unwrap_or_default(),
        dark_offset: pattern(DarkOffset::new(frame).map(|stage| stage.words(frame, tables))),
        row_noise: RowNoise::new(frame).map_or(NONE, |stage| stage.words(frame, tables)),
        column_noise: ColumnNoise::new(frame).map_or(NONE, |stage| stage.words(tables)),
        amplifiers: AmplifierNonlinearity::new(frame).map(|stage| stage.words(tables)).unwrap_or_default(),
        read_noise: ReadNoise::new(frame).map(|stage| stage.words()).unwrap_or_default(),
        gain: Gain::new(frame).word(),
        column_gains,
        column_offsets,
        digitiser: Digitiser::new(frame).words(),
        dual_gain: DualGainDigitiser::new(frame).map(|stage| stage.words(tables)).unwrap_or_default(),
        stuck_pixels: StuckPixels::new(frame).map_or(NONE, |stage| stage.words(frame, tables)),
        processed: processed(frame, tables),
        transmission_errors: TransmissionErrors::new(frame).map_or(NONE, |stage| stage.words(frame, tables)),
        ..ExposureWords::default()
    }
}

/// Words of a pattern, or of none.
fn pattern(words: Option<PatternWords>) -> PatternWords {
    words.unwrap_or(PatternWords { rows: NONE, columns: NONE, measured: NONE, ..PatternWords::default() })
}

/// Place of what the stages behind the converter make of each of its numbers, where they change any.
fn processed(frame: &Frame<'_>, tables: &mut Tables) -> u32 {
    let (digital_gain, compander) = (DigitalGain::new(frame), Compander::new(frame));
    if digital_gain.is_none() && compander.is_none() {
        return NONE;
    }
    let mut numbers: Vec<u16> = (0..=frame.sensor.converter.max_dn()).collect();
    let mut row = Row { y: 0, values: &mut numbers };
    if let Some(digital_gain) = digital_gain {
        digital_gain.apply(&mut row);
    }
    compander.apply(&mut row);
    tables.add(numbers.into_iter().map(u32::from))
}
