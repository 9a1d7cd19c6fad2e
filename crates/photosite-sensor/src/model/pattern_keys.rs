//! The keys of measured patterns, in place of those of statistical ones.

use photosite_core::Invalid;

use super::defective_pixels::DefectivePixels;
use super::description::SensorDescription;
use super::gain_steps::GainStepDescription;
use super::measured_pattern::{MeasuredPattern, PatternFile};
use super::noise::{Noise, NoiseDescription, needs_dark_current};
use super::sensor_files::SensorFiles;
use super::sensor_model::SensorModel;

/// Keys of the patterns.
const PRNU: &str = "noise.prnu_map";
const DSNU: &str = "noise.dsnu_map";
const DEFECTS: &str = "defects.pixels";

impl SensorModel {
    /// Reads the measured patterns that a description names, and puts them in the place of statistical ones.
    pub(super) fn take_patterns(&mut self, d: &NoiseDescription, files: &mut impl SensorFiles) -> Result<(), Invalid> {
        if let Some(file) = &d.prnu_map {
            let stated = [
                ("prnu_percent", d.prnu_percent),
                ("prnu_row_percent", d.prnu_row_percent),
                ("prnu_column_percent", d.prnu_column_percent),
            ];
            refuse_statistics(PRNU, &stated, false)?;
            let response = self.pattern(PRNU, file, files)?;
            let mean = response.mean();
            if mean.is_nan() || mean <= 0.0 {
                let message = format!("has a mean of {mean}");
                return Err(Invalid::new(PRNU, message).help("write the response of each pixel, about 1 of most"));
            }
            let pattern = response.map(|value| value / mean - 1.0);
            self.noise.prnu = pattern.statistics();
            self.noise.prnu_map = Some(pattern);
        }
        if let Some(file) = &d.dsnu_map {
            let stated = [("dsnu_e", d.dsnu_e), ("dsnu_row_e", d.dsnu_row_e), ("dsnu_column_e", d.dsnu_column_e)];
            let states = |step: &GainStepDescription| {
                [step.dsnu_e, step.dsnu_row_e, step.dsnu_column_e].iter().any(Option::is_some)
            };
            refuse_statistics(DSNU, &stated, d.gain_steps.iter().any(states))?;
            let offsets = self.pattern(DSNU, file, files)?;
            let mean = offsets.mean();
            let pattern = offsets.map(|value| value - mean);
            let statistics = pattern.statistics();
            self.noise.read_out.change(|noise| noise.dsnu = statistics);
            self.noise.dsnu_map = Some(pattern);
        }
        Ok(())
    }

    /// Reads the defective pixels that a description names, and puts them in the place of statistical ones.
    pub(super) fn take_defects(&mut self, d: &SensorDescription, files: &mut impl SensorFiles) -> Result<(), Invalid> {
        let (noise, d) = (&d.noise, &d.defects);
        let Some(file) = &d.pixels else { return Ok(()) };
        let stated = [
            ("hot_per_million", d.hot_per_million),
            ("hot_dark_current_e_per_s", d.hot_dark_current_e_per_s),
            ("dead_per_million", d.dead_per_million),
            ("stuck_per_million", d.stuck_per_million),
        ];
        refuse_statistics(DEFECTS, &stated, false)?;
        self.has_places(DEFECTS)?;
        let text = files.defects(file).map_err(|invalid| invalid.within(DEFECTS))?;
        let pixels = DefectivePixels::parse(&text, self.resolution, self.converter.max_dn()).map_err(|invalid| {
            let message = format!("{}: {}", file.file, invalid.message);
            Invalid { message, ..invalid }.within("file").within(DEFECTS)
        })?;
        self.noise.defects = pixels.statistics();
        if self.noise.defects.hot > 0.0 {
            needs_dark_current(noise).map_err(|invalid| invalid.within("noise"))?;
        }
        self.noise.defective_pixels = Some(pixels);
        Ok(())
    }

    /// Reads a pattern of all pixels.
    fn pattern(&self, key: &str, file: &PatternFile, files: &mut impl SensorFiles) -> Result<MeasuredPattern, Invalid> {
        self.has_places(key)?;
        let pattern = files.pattern(file).map_err(|invalid| invalid.within(key))?;
        fits(key, pattern.size(), self.resolution)?;
        Ok(pattern)
    }

    /// Refuses sensors whose pixels are not those of their images, place by place. `key` names what has places.
    fn has_places(&self, key: &str) -> Result<(), Invalid> {
        let has_masked = self.masked.columns != [0; 2] || self.masked.rows != [0; 2];
        let has_overscan = self.architecture.ccd().is_some_and(|ccd| ccd.overscan.prescan_columns > 0);
        for (is_there, what) in [
            (has_masked, "masked pixels, which a pattern of the image does not have"),
            (has_overscan, "prescan columns, which a pattern of the image does not have"),
            (self.cfa.samples_per_pixel() > 1, "several detectors in a pixel"),
            (self.shutter.scans(), "a single row of pixels that sees all lines"),
        ] {
            if is_there {
                let message = format!("cannot be combined with {what}");
                return Err(Invalid::new(key, message).help("leave it out, and state standard deviations"));
            }
        }
        Ok(())
    }

    /// Whether patterns of the pixels were measured, so that images are of the sensor's own size.
    pub fn has_measured_patterns(&self) -> bool {
        let Noise { prnu_map, dsnu_map, defective_pixels, .. } = &self.noise;
        prnu_map.is_some() || dsnu_map.is_some() || defective_pixels.is_some()
    }

    /// Refuses an image of another size than that of the measured patterns.
    pub(crate) fn patterns_fit(&self, size: [usize; 2]) -> Result<(), Invalid> {
        let Noise { prnu_map, dsnu_map, defective_pixels, .. } = &self.noise;
        let sizes = [
            (PRNU, prnu_map.as_ref().map(MeasuredPattern::size)),
            (DSNU, dsnu_map.as_ref().map(MeasuredPattern::size)),
            (DEFECTS, defective_pixels.as_ref().map(DefectivePixels::size)),
        ];
        sizes.into_iter().try_for_each(|(key, own)| own.map_or(Ok(()), |own| fits(key, own, size)))
    }
}

/// Refuses an image of another size than that of a pattern. `key` is that of the pattern.
fn fits(key: &str, [columns, rows]: [usize; 2], [width, height]: [usize; 2]) -> Result<(), Invalid> {
    if [columns, rows] == [width, height] {
        return Ok(());
    }
    let message = format!("is of {columns} × {rows} pixels, and the image of {width} × {height}");
    Err(Invalid::new(key, message).help("measure the pattern of all pixels, or leave it out"))
}

/// Refuses a measured pattern beside standard deviations of the same.
fn refuse_statistics(key: &str, stated: &[(&str, f64)], in_steps: bool) -> Result<(), Invalid> {
    let other = stated.iter().find(|(_, value)| *value != 0.0).map(|(other, _)| *other);
    match other.or(in_steps.then_some("dsnu_e of gain_steps")) {
        Some(other) => {
            let message = format!("cannot be combined with {other}: the pattern is the measured one");
            Err(Invalid::new(key, message).help(format!("remove {other}")))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use photosite_core::image::Planes;
    use photosite_core::spectrum::Spectrum;
    use photosite_core::units::Seconds;
    use photosite_raw::PixelArea;

    use super::super::defects::DefectFile;
    use super::super::spectrum_source::SpectrumSource;
    use super::*;
    use crate::signal::noise_key::NoiseKey;
    use crate::{Binning, BinningMethod, Exposure, RegionOfInterest, SensorDescription, Stages, expose, presets};

    const SIZE: [usize; 2] = [16, 8];
    const TABLE: &str = "column,row,kind,value\n3,1,dead,\n5,1,stuck,777\n9,6,hot,1e6\n";

    /// A finder of one pattern: what a pixel has rises by 8 from column to column and by 1 from row to row.
    struct Ramp(f32, f32);

    impl SensorFiles for Ramp {
        fn spectrum(&mut self, source: &SpectrumSource) -> Result<Spectrum, Invalid> {
            presets::library_spectrum(source)
        }

        fn defects(&mut self, _: &DefectFile) -> Result<String, Invalid> {
            Ok(TABLE.to_owned())
        }

        fn pattern(&mut self, _: &PatternFile) -> Result<MeasuredPattern, Invalid> {
            let Self(first, step) = *self;
            let value = |i: usize| first + step * (8 * (i % SIZE[0]) + i / SIZE[0]) as f32;
            MeasuredPattern::new(SIZE, (0..SIZE[0] * SIZE[1]).map(value).collect())
        }
    }

    fn description(noise: NoiseDescription) -> SensorDescription {
        let mut d: SensorDescription =
            presets::table("sony-imx249-mono").expect("listed").try_into().expect("keys of a sensor");
        d.resolution_px = SIZE.map(|n| n as u32);
        d.noise = noise;
        d
    }

    fn file() -> Option<PatternFile> {
        Some(PatternFile { file: "pattern.npy".to_owned() })
    }

    /// Deviations in all rows, all columns and single pixels are told apart, as standard deviations are that the pattern takes
    /// the place of.
    #[test]
    fn patterns_have_the_statistics_of_their_parts() {
        let size = [200, 150];
        let wave = |i: usize, step: usize| ((i * step) % 101) as f32 / 50.0 - 1.0;
        let value = |i: usize| 3.0 * wave(i % size[0], 37) + 2.0 * wave(i / size[0], 29) + wave(i, 7919);
        let values: Vec<f32> = (0..size[0] * size[1]).map(value).collect();
        let pattern = MeasuredPattern::new(size, values).expect("finite");
        let mean = pattern.mean();
        let found = pattern.map(|value| value - mean).statistics();
        // A wave of 1 has a standard deviation of 1/√3, by so many rows and columns to a few per cent.
        for (part, of_one) in [(found.column, 3.0), (found.row, 2.0), (found.pixel, 1.0)] {
            assert!((part * 3f64.sqrt() / of_one - 1.0).abs() < 0.07, "{found:?}");
        }
    }

    /// Digital numbers of even light, without shot noise.
    fn numbers(sensor: &SensorModel, electrons: f32, region: RegionOfInterest) -> Vec<u16> {
        let mut light = Planes::zeros(SIZE[0], SIZE[1], sensor.cfa.channels());
        light.channels_mut()[0].data.fill(electrons);
        let exposure = Exposure { region, ..Exposure::of(Seconds(0.01)) };
        let stages = Stages::ALL.without(crate::Stage::ShotNoise);
        let key = NoiseKey::default();
        expose(&light, sensor, &exposure, stages, key).expect("an image").data
    }

    /// Offsets of a ramp about their mean, and responses of a ramp about theirs, within rounding.
    #[test]
    fn images_have_the_measured_pattern() {
        let noise = NoiseDescription { dsnu_map: file(), ..NoiseDescription::default() };
        let sensor = SensorModel::new("ramp", &description(noise), Ramp(500.0, 1.0)).expect("a sensor");
        let (gain, black) = (
            sensor.converter.system_gain(Default::default()),
            f64::from(sensor.converter.black_level_dn(Default::default())),
        );
        let mean = |step: f64| step * (8.0 * 7.5 + 3.5);
        for (i, &dn) in numbers(&sensor, 1000.0, RegionOfInterest::WHOLE).iter().enumerate() {
            let offset = (8 * (i % SIZE[0]) + i / SIZE[0]) as f64 - mean(1.0);
            let wanted = black + gain * (1000.0 + offset);
            assert!((f64::from(dn) - wanted).abs() <= 0.51, "{i}: {dn} {wanted}");
        }
        let noise = NoiseDescription { prnu_map: file(), ..NoiseDescription::default() };
        let sensor = SensorModel::new("ramp", &description(noise), Ramp(1.0, 0.01)).expect("a sensor");
        for (i, &dn) in numbers(&sensor, 10_000.0, RegionOfInterest::WHOLE).iter().enumerate() {
            let response = 1.0 + 0.01 * (8 * (i % SIZE[0]) + i / SIZE[0]) as f64;
            let wanted = black + gain * 10_000.0 * response / (1.0 + mean(0.01));
            assert!((f64::from(dn) - wanted).abs() <= 0.51, "{i}: {dn} {wanted}");
        }
    }

    /// Pixels of the table do what it says at their places, in a region as in the whole, and all others nothing of it.
    #[test]
    fn defective_pixels_lie_where_the_table_says() {
        let mut d = description(NoiseDescription::default());
        d.noise.dark_current_reference_c = Some(25.0);
        d.noise.dark_current_doubling_k = Some(8.0);
        d.defects.pixels = Some(DefectFile { file: "camera.csv".to_owned() });
        let sensor = SensorModel::new("ramp", &d, Ramp(1.0, 1.0)).expect("a sensor");
        let (gain, black) = (sensor.converter.system_gain(Default::default()), 64.0);
        let pixels = Some(PixelArea { x: 2, y: 0, width: 8, height: 7 });
        let whole = numbers(&sensor, 1000.0, RegionOfInterest::WHOLE);
        let part = numbers(&sensor, 1000.0, RegionOfInterest { pixels, ..RegionOfInterest::WHOLE });
        for (i, &dn) in whole.iter().enumerate() {
            let (x, y) = (i % SIZE[0], i / SIZE[0]);
            // 10⁶ e⁻/s in 0.01 s are 10 000 e⁻; shot noise of them, 100 e⁻, is 4 % at 4 σ.
            let (wanted, bound) = match (x, y) {
                (3, 1) => (black, 0.51),
                (5, 1) => (777.0, 0.0),
                (9, 6) => (black + gain * 11_000.0, 400.0 * gain),
                _ => (black + gain * 1000.0, 0.51),
            };
            assert!((f64::from(dn) - wanted).abs() <= bound, "{x}, {y}: {dn} {wanted}");
            if (2..10).contains(&x) && y < 7 {
                assert_eq!(part[y * 8 + x - 2], dn);
            }
        }
        d.defects.dead_per_million = 5.0;
        let invalid = SensorModel::new("ramp", &d, Ramp(1.0, 1.0)).expect_err("both");
        assert!(invalid.key == DEFECTS && invalid.message.contains("dead_per_million"), "{invalid:?}");
    }

    /// A region has the part of the pattern that it is of, and bins have its means.
    #[test]
    fn regions_and_bins_have_their_part_of_the_pattern() {
        let noise = NoiseDescription { dsnu_map: file(), ..NoiseDescription::default() };
        let sensor = SensorModel::new("ramp", &description(noise), Ramp(500.0, 1.0)).expect("a sensor");
        let whole = numbers(&sensor, 1000.0, RegionOfInterest::WHOLE);
        let pixels = Some(PixelArea { x: 4, y: 2, width: 8, height: 4 });
        let part = numbers(&sensor, 1000.0, RegionOfInterest { pixels, ..RegionOfInterest::WHOLE });
        let at = |x: usize, y: usize| f64::from(whole[y * SIZE[0] + x]);
        for (i, &dn) in part.iter().enumerate() {
            assert_eq!(f64::from(dn), at(4 + i % 8, 2 + i / 8));
        }
        let binning = Binning { factor: [2, 2], method: BinningMethod::Mean };
        let bins = numbers(&sensor, 1000.0, RegionOfInterest { binning, ..RegionOfInterest::WHOLE });
        for (i, &dn) in bins.iter().enumerate() {
            let (x, y) = (2 * (i % 8), 2 * (i / 8));
            let mean = (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)) / 4.0;
            assert!((f64::from(dn) - mean).abs() <= 0.5, "{dn} {mean}");
        }
    }

    #[test]
    fn what_a_pattern_cannot_be_of_is_refused() {
        let several = |d: &mut SensorDescription| {
            d.cfa = "full:RGB".to_owned();
            let own = d.channels.values().next().cloned().expect("a channel");
            d.channels = ["R", "G", "B"].map(|name| (name.to_owned(), own.clone())).into_iter().collect();
        };
        type Change = fn(&mut SensorDescription);
        let cases: [(Change, &str); 4] = [
            (|d| d.noise.dsnu_row_e = 1.0, "dsnu_row_e"),
            (|d| d.masked_columns = [2, 0], "masked pixels"),
            (|d| d.resolution_px = [16, 9], "16 × 8 pixels"),
            (several, "several detectors"),
        ];
        for (change, said) in cases {
            let mut d = description(NoiseDescription { dsnu_map: file(), ..NoiseDescription::default() });
            change(&mut d);
            let invalid = SensorModel::new("ramp", &d, Ramp(1.0, 1.0)).expect_err(said);
            assert!(invalid.key == DSNU && invalid.message.contains(said), "{invalid:?}");
        }
    }

    #[test]
    fn charge_is_not_added_before_offsets_of_single_pixels() {
        let noise = NoiseDescription { dsnu_map: file(), ..NoiseDescription::default() };
        let sensor = SensorModel::new("ramp", &description(noise), Ramp(500.0, 1.0)).expect("a sensor");
        let binning = Binning { factor: [2, 2], method: BinningMethod::Charge };
        let region = RegionOfInterest { binning, ..RegionOfInterest::WHOLE };
        let exposure = Exposure { region, ..Exposure::of(Seconds(0.01)) };
        assert_eq!(exposure.validate(&sensor).expect_err("refused").key, "binning_method");
    }
}
