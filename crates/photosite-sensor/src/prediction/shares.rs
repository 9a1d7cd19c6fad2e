//! The part that each stage has in the variance of a number, and their sum over the stages of an exposure.

use photosite_core::units::Electrons;

use crate::stages::converter::dnl_variance_dn2;
use crate::{Converter, Exposure, SensorModel, Stage, Stages};

/// Temporal noise of a stage, by the place where it is added: a bin has it as often as that says.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Share {
    /// Electrons that light frees one by one: their variance is their mean.
    Light,
    /// Electrons that heat frees one by one in a pixel, on average over all pixels, whose variance is this, too.
    Heat(Electrons),
    /// Variance of each charge that is read out, (e⁻)².
    Pixel(f64),
    /// Variance of an amplifier, (e⁻)²: the only one, or with two gains that of the high one.
    Amplifier(f64),
    /// Variance of the amplifier of the low gain, (e⁻)².
    LowGain(f64),
    /// Variance that the pixels of a row share, (e⁻)².
    Row(f64),
    /// Variance that the pixels of a column share, (e⁻)².
    Column(f64),
    /// Variance of the converter's steps on top of rounding, DN².
    Steps(fn(&Converter) -> f64),
    /// Electrons that stay or go one by one: as many as are there vary as much as before.
    Moved,
    /// No noise: the same change of a flat field in every pixel and frame.
    Mean,
    /// No noise: each pixel, row or column has its own change, the same in every frame.
    Fixed,
    /// Noise that has no closed form, or no useful variance; the prediction leaves it out.
    Untold,
}

impl SensorModel {
    /// The share of a stage at an exposure below saturation.
    pub(crate) fn share(&self, stage: Stage, exposure: &Exposure) -> Share {
        let (noise, temperature, time) = (&self.noise, exposure.temperature, exposure.time);
        let squared = |noise: Electrons| noise.0 * noise.0;
        let read_out = || noise.read_out.at(exposure.gain);
        match stage {
            Stage::ShotNoise => Share::Light,
            Stage::DarkCurrent => Share::Heat(noise.dark_electrons(temperature, time)),
            Stage::HotPixels => Share::Heat(Electrons(noise.defects.hot * noise.hot_electrons(temperature, time).0)),
            Stage::Flicker => Share::Pixel(squared(noise.flicker.noise)),
            Stage::ResetNoise => Share::Pixel(squared(noise.reset.standard_deviation(temperature))),
            Stage::Telegraph => Share::Pixel(noise.telegraph.variance()),
            Stage::ReadNoise => Share::Amplifier(squared(read_out().read)),
            Stage::LowGainReadNoise => {
                Share::LowGain(self.converter.dual_gain.as_ref().map_or(0.0, |dual| squared(dual.low_read_noise)))
            }
            Stage::RowNoise => Share::Row(squared(read_out().row)),
            Stage::ColumnNoise => Share::Column(squared(read_out().column)),
            Stage::ConverterNonlinearity => Share::Steps(|converter| dnl_variance_dn2(converter.dnl_dn)),
            Stage::ImageLag | Stage::VerticalTransfer | Stage::HorizontalTransfer => Share::Moved,
            Stage::Crosstalk
            | Stage::Smear
            | Stage::BrighterFatter
            | Stage::Blooming
            | Stage::FullWell
            // These take as much of all noise as of the light's, so that the ratio of both stays.
            | Stage::AmplifierNonlinearity
            | Stage::VideoBandwidth => Share::Mean,
            Stage::PhotoResponse
            | Stage::DeadPixels
            | Stage::DarkCurrentNonuniformity
            | Stage::DarkOffset
            | Stage::ColumnAmplifiers
            | Stage::StuckPixels => Share::Fixed,
            Stage::PhotonCounting | Stage::TransmissionErrors => Share::Untold,
        }
    }
}

/// Shares of some stages, summed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shares {
    stages: Stages,
    /// Electrons that heat frees in a pixel on average, those of hot ones shared by all, which is their variance, too.
    pub(crate) heat_e: f64,
    /// Variance of what each pixel's read-out adds by itself, (e⁻)²: with the only or the high gain, and with the low one.
    pub(crate) pixel_e2: [f64; 2],
    /// Variance that the conversion to a number adds, (e⁻)², likewise.
    pub(crate) conversion_e2: [f64; 2],
    row_e2: f64,
    column_e2: f64,
}

impl Shares {
    pub(crate) fn new(sensor: &SensorModel, exposure: &Exposure, stages: Stages) -> Self {
        let converter = &sensor.converter;
        let dual = converter.dual_gain.as_deref();
        let branches = dual.map_or([None; 2], |dual| [Some(&dual.high), Some(&dual.low)]);
        let mut sum = Self { stages, ..Self::default() };
        let (mut pixel, mut amplifiers) = (0.0, [0.0; 2]);
        let (mut steps, mut steps_of_branches) = (0.0, [0.0; 2]);
        for stage in Stage::ALL.into_iter().filter(|&stage| stages.has(stage)) {
            match sensor.share(stage, exposure) {
                Share::Heat(electrons) => sum.heat_e += electrons.0,
                Share::Pixel(variance) => pixel += variance,
                Share::Amplifier(variance) => amplifiers[0] += variance,
                Share::LowGain(variance) => amplifiers[1] += variance,
                Share::Row(variance) => sum.row_e2 += variance,
                Share::Column(variance) => sum.column_e2 += variance,
                Share::Steps(of) => {
                    steps += of(converter);
                    steps_of_branches = [0, 1].map(|i| steps_of_branches[i] + branches[i].map_or(0.0, of));
                }
                Share::Light | Share::Moved | Share::Mean | Share::Fixed | Share::Untold => {}
            }
        }
        let rounded =
            |converter: &Converter, steps: f64| (1.0 / 12.0 + steps) / converter.system_gain(exposure.gain).powi(2);
        let before_merging = [0, 1].map(|i| branches[i].map_or(0.0, |branch| rounded(branch, steps_of_branches[i])));
        sum.pixel_e2 = amplifiers.map(|amplifier| amplifier + pixel);
        sum.conversion_e2 = before_merging.map(|before| before + rounded(converter, steps));
        sum
    }

    /// Variance of the light's electrons, of which there are `mean_e` on average, (e⁻)².
    pub(crate) fn light_e2(&self, mean_e: f64) -> f64 {
        if self.stages.has(Stage::ShotNoise) { mean_e } else { 0.0 }
    }

    /// Variance that digital numbers share with others, (e⁻)², in a bin of so many pixels across and down: those of a
    /// row have its noise, which all of them add.
    pub(crate) fn shared_e2(&self, [across, down]: [f64; 2]) -> f64 {
        across * across * self.row_e2 * down + down * down * self.column_e2 * across
    }
}
