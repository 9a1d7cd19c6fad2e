//! The sheet of a fitted sensor: parameters in the units of its file, what is assumed, and what is left out.

use photosite_core::math::float::rounded;

use super::defects::{Defect, DefectKind};
use super::frame_group::CameraFrames;
use super::frame_stack::Parts;
use super::lines::MeasuredLine;
use super::measured::Measured;
use super::parameters::{Assumption, KnownFacts, Parameter};
use super::pattern::Pattern;
use super::patterns::Patterns;
use super::photon_transfer::Saturation;
use super::read_noise_shape::{Found, ReadNoiseShape};
use super::survey::Survey;
use crate::characterisation::NotMeasured;

/// Sheet that is filled figure by figure.
pub(super) struct Sheet {
    pub(super) parameters: Vec<Parameter>,
    pub(super) assumed: Vec<Assumption>,
    pub(super) left_out: Vec<NotMeasured>,
    /// K, DN/e⁻; 1 where nobody knows it.
    gain: Measured,
    /// Whether electrons are known, or DN stand for them.
    in_electrons: bool,
    known: KnownFacts,
}

/// Least variance of numbers that quantisation leaves to be seen, DN², as EMVA 1288 has it.
const LEAST_VARIANCE: f64 = 0.24;
/// Key of the bend of the response, whose value is a list.
pub(super) const NONLINEARITY: &str = "adc.amplifier_nonlinearity_percent";
/// Key of the read noise.
const READ_NOISE: &str = "noise.read_noise_e";
/// Name of the shape where it is left out.
pub(super) const SHAPE_OF_READ_NOISE: &str = "shape of the read noise";
/// Squared differences of the pixels' read noise over its mean beyond which the averages of the noisiest lie far from all
/// others.
const MOST_SQUARED_SPREAD: f64 = 0.5;
/// Variance of rounding to whole numbers, DN².
const QUANTISATION: f64 = 1.0 / 12.0;

impl Sheet {
    pub(super) fn new(known: &KnownFacts, survey: &Survey) -> Self {
        let mut sheet = Self {
            parameters: Vec::new(),
            assumed: Vec::new(),
            left_out: Vec::new(),
            gain: Measured::new(1.0, 0.0),
            in_electrons: true,
            known: known.clone(),
        };
        const KEY: &str = "adc.conversion_gain_dn_per_e";
        match (&survey.transfer.gain, known.system_gain) {
            (Ok(gain), _) => {
                sheet.gain = *gain;
                sheet.tell(KEY, "DN/e-", *gain);
            }
            (Err(reason), Some(gain)) => {
                sheet.gain.value = gain;
                sheet.state(KEY, format!("{gain:?}"), &format!("as stated; {reason}"));
            }
            (Err(reason), None) => {
                sheet.in_electrons = false;
                let reason =
                    format!("{reason}: DN stand for electrons, so that dark images are right and light is not");
                sheet.assume(KEY, "1.0".to_owned(), &reason);
            }
        }
        sheet
    }

    /// System gain K in DN/e⁻, where it is known.
    pub(super) fn system_gain(&self) -> Option<f64> {
        self.in_electrons.then_some(self.gain.value)
    }

    /// Fills in what the images tell.
    pub(super) fn fill(
        &mut self,
        survey: &Survey,
        shape: Found,
        patterns: &Patterns,
        defects: &[Defect],
        hot: Result<[Measured; 2], usize>,
        frames: &CameraFrames<'_>,
    ) {
        self.efficiency(survey, patterns);
        self.black_level(survey, patterns);
        self.dark_noise(survey, shape.as_ref().ok(), frames.size);
        self.read_noise_shape(shape);
        let dark_current = self.dark_current(survey, patterns);
        self.uneven_dark_current(patterns, dark_current);
        self.dark_pattern(patterns);
        self.response_pattern(survey, patterns);
        self.defective(defects, hot, dark_current.is_some(), patterns, frames);
        let full_well_dn = self.full_well(survey, frames);
        self.linearity(survey, full_well_dn);
        self.optics();
    }

    fn tell(&mut self, key: &'static str, unit: &'static str, measured: Measured) {
        // DN stand for electrons where these are not known.
        let unit = match unit {
            "e-" if !self.in_electrons => "DN",
            "e-/s" if !self.in_electrons => "DN/s",
            unit => unit,
        };
        self.parameters.push(Parameter { key, unit, measured });
    }

    fn assume(&mut self, key: &'static str, value: String, reason: &str) {
        self.assumed.push(Assumption { key, value, is_stated: false, reason: reason.to_owned() });
    }

    fn state(&mut self, key: &'static str, value: String, reason: &str) {
        self.assumed.push(Assumption { key, value, is_stated: true, reason: reason.to_owned() });
    }

    fn leave(&mut self, figure: &'static str, reason: &str) {
        self.left_out.push(NotMeasured { figure, reason: reason.to_owned() });
    }

    /// Tells the root of a variance, DN² or the square of another unit, over a scale; or its bound.
    fn tell_root(
        &mut self,
        key: &'static str,
        name: &'static str,
        unit: &'static str,
        variance: Measured,
        scale: Measured,
    ) {
        match variance.root() {
            Ok(root) => self.tell(key, unit, root.over(scale)),
            Err(bound) => {
                let unit = if unit == "e-" && !self.in_electrons { "DN" } else { unit };
                let bound = rounded(bound / scale.value, 3);
                self.leave(name, &format!("not told apart from 0: below {bound} {unit} at 95 %"));
            }
        }
    }

    fn efficiency(&mut self, survey: &Survey, patterns: &Patterns) {
        const KEY: &str = "quantum_efficiency";
        let transfer = &survey.transfer;
        let (Some(mut responsivity), Ok(gain)) = (transfer.responsivity, &transfer.gain) else {
            let reason = match &transfer.gain {
                Err(reason) => format!("{reason}; 1 stands for it"),
                Ok(_) => {
                    "the number of photons on a pixel is not known; 1 stands for it, so that photons mean electrons"
                        .to_owned()
                }
            };
            self.assume(KEY, "1.0".to_owned(), &reason);
            return;
        };
        // The pixels of the image are some of those that the sensor could have.
        if let Some(response) = &patterns.response {
            let relative = response.mean.relative_error();
            responsivity.standard_error = responsivity.standard_error.hypot(responsivity.value * relative);
        }
        self.tell(KEY, "", responsivity.over(*gain));
        let reason = match self.known.wavelength_nm {
            Some(nm) => format!("the light had {} nm alone; the file takes it for all", rounded(nm, 6)),
            None => "the light had one wavelength or mixture, which the images do not state; the file takes it for all"
                .to_owned(),
        };
        self.leave("quantum efficiency at other wavelengths", &reason);
    }

    fn black_level(&mut self, survey: &Survey, patterns: &Patterns) {
        let mut black = survey.dark.black();
        black.standard_error = black.standard_error.hypot(patterns.dark.mean.standard_error);
        self.tell("adc.black_level_dn", "DN", black);
    }

    fn dark_noise(&mut self, survey: &Survey, shape: Option<&ReadNoiseShape>, [width, height]: [usize; 2]) {
        let Parts { pixel, row, column } = survey.dark_variances();
        if pixel.value < LEAST_VARIANCE {
            let bound = rounded((LEAST_VARIANCE - QUANTISATION).sqrt() / self.gain.value, 3);
            self.leave(
                "read noise",
                &format!("quantisation hides it: all that is known is that it is below {bound} e-"),
            );
        } else {
            let variance = Measured::new(pixel.value - QUANTISATION, pixel.standard_error);
            self.tell_root(READ_NOISE, "read noise", "e-", variance, self.gain);
            // Of unequal pixels, those of the image are some that the sensor could have.
            if let (Some(shape), Some(Parameter { key: READ_NOISE, measured, .. })) =
                (shape.filter(|shape| shape.squared_spread.root().is_ok()), self.parameters.last_mut())
            {
                let of_sample = 0.5 * measured.value * shape.error_of_sample(width * height);
                measured.standard_error = measured.standard_error.hypot(of_sample);
            }
        }
        self.tell_root("noise.row_noise_e", "row noise", "e-", row, self.gain);
        self.tell_root("noise.column_noise_e", "column noise", "e-", column, self.gain);
        if survey.dark.variance.is_none() {
            self.leave(
                "read noise at no exposure time",
                "dark images of two exposure times would tell it; that of the shortest stands for it",
            );
        }
    }

    /// Tells how unequal the pixels' read noise is, and how heavy its tails are.
    fn read_noise_shape(&mut self, shape: Found) {
        let is_told = self.parameters.iter().any(|parameter| parameter.key == READ_NOISE);
        let found = shape.and_then(|shape| if is_told { Ok(shape) } else { Err("there is no read noise".to_owned()) });
        let ReadNoiseShape { squared_spread, tails } = match found {
            Ok(shape) => shape,
            Err(reason) => {
                let stands = "a normal distribution, the same in all pixels, stands for it";
                return self.leave(SHAPE_OF_READ_NOISE, &format!("{reason}; {stands}"));
            }
        };
        let (spread, percent) = ("differences of the pixels' read noise", Measured::new(0.01, 0.0));
        self.tell_root("noise.read_noise_spread_percent", spread, "%", squared_spread, percent);
        if squared_spread.value > MOST_SQUARED_SPREAD {
            self.leave("the noisiest pixels", "they count as defects: read noise and its differences are lower bounds");
        }
        if tails.value > 3.0 * tails.standard_error && tails.value > 0.0 {
            self.tell("noise.read_noise_degrees_of_freedom", "", Measured::new(1.0, 0.0).over(tails));
            return;
        }
        let least = 1.0 / (tails.value.max(0.0) + 1.645 * tails.standard_error);
        let bound = if least > 3.0 {
            format!("more than {} degrees of freedom at 95 %", rounded(least, 2))
        } else {
            "there are too few images or pixels".to_owned()
        };
        let reason = format!("not told apart from those of a normal distribution: {bound}");
        self.leave("tails of the read noise", &reason);
    }

    /// Tells the dark current with what it depends on, and returns its mean, DN/s.
    fn dark_current(&mut self, survey: &Survey, patterns: &Patterns) -> Option<Measured> {
        const NAME: &str = "dark current";
        let (Some(mean), Some(variance)) = (survey.dark.mean, survey.dark.variance) else {
            self.leave(NAME, "dark images of at least two known exposure times would tell it");
            return None;
        };
        let scale = self.gain.value;
        // Noise of electrons in DN² is K times their mean in DN, whether or not a camera subtracts that mean.
        let of_noise = self.in_electrons.then(|| variance.slope.times(1.0 / scale));
        let is_seen = |m: Measured| m.value > 3.0 * m.standard_error;
        let is_hidden = of_noise.is_some_and(|noise| {
            is_seen(noise.minus(mean.slope)) && is_seen(noise) && noise.value > 2.0 * mean.slope.value
        });
        let slope = match (is_hidden, of_noise) {
            (true, Some(noise)) => {
                self.leave(
                    "rise of the dark signal with time",
                    "the camera subtracts it: the dark current is that of the noise",
                );
                noise
            }
            _ if is_seen(mean.slope) => mean.slope,
            _ => {
                let bound = rounded((mean.slope.value.abs() + 1.96 * mean.slope.standard_error) / scale, 3);
                self.leave(NAME, &format!("not told apart from 0: below {bound} e-/s at 95 %"));
                return None;
            }
        };
        // The pixels of the image are some of those that the sensor could have.
        let of_pixels = patterns.rise.as_ref().map_or(0.0, |rise| rise.mean.standard_error);
        let of_sensor = Measured::new(slope.value, slope.standard_error.hypot(of_pixels));
        self.tell("noise.dark_current_e_per_s", "e-/s", of_sensor.over(self.gain));
        self.temperatures(survey);
        Some(slope)
    }

    fn temperatures(&mut self, survey: &Survey) {
        const KEY: &str = "noise.dark_current_reference_c";
        match survey.temperature.or(self.known.temperature) {
            Some(celsius) => self.state(KEY, format!("{:?}", celsius.0), "as stated of the images"),
            None => self.assume(KEY, "25.0".to_owned(), "the images do not state the temperature of the sensor"),
        }
        let log = |(celsius, current): (Option<photosite_core::units::Celsius>, Measured)| {
            let is_seen = current.value > 3.0 * current.standard_error;
            let error = current.relative_error() / std::f64::consts::LN_2;
            Some((celsius.filter(|_| is_seen)?.0, Measured::new(current.value.log2(), error)))
        };
        let points: Vec<_> = survey.dark_currents().into_iter().filter_map(log).collect();
        match MeasuredLine::through(&points).map(|line| line.slope).filter(|s| s.value > 3.0 * s.standard_error) {
            Some(slope) => {
                let doubling = Measured::new(1.0 / slope.value, slope.relative_error() / slope.value);
                self.tell("noise.dark_current_doubling_k", "K", doubling);
            }
            None => self.assume(
                "noise.dark_current_law",
                "\"arrhenius\"".to_owned(),
                "that of silicon; dark images at two temperatures or more would tell",
            ),
        }
    }

    /// Tells how uneven the dark current is.
    fn uneven_dark_current(&mut self, patterns: &Patterns, current: Option<Measured>) {
        const NAME: &str = "dark current non-uniformity";
        let (Some(current), Some(rise)) = (current, &patterns.rise) else {
            return self.leave(NAME, "there is no dark current that it could be told of");
        };
        let variance = rise.variances.pixel;
        self.tell_root("noise.dark_current_nonuniformity_percent", NAME, "%", variance, current.times(0.01));
    }

    fn dark_pattern(&mut self, patterns: &Patterns) {
        let Parts { pixel, row, column } = patterns.offsets();
        let gain = self.gain;
        self.tell_root("noise.dsnu_e", "DSNU of pixels", "e-", pixel, gain);
        self.tell_root("noise.dsnu_row_e", "DSNU of rows", "e-", row, gain);
        self.tell_root("noise.dsnu_column_e", "DSNU of columns", "e-", column, gain);
    }

    fn response_pattern(&mut self, survey: &Survey, patterns: &Patterns) {
        let Some(response) = &patterns.response else {
            return self.leave("PRNU", "there are no bright images below saturation");
        };
        let mean = response.mean.value;
        let scale = survey.transfer.told_bend().map_or(mean, |bend| bend.scale_of_deviations(mean));
        let mean = Measured::new(scale / 100.0, 0.0);
        let Parts { pixel, row, column } = response.variances;
        self.tell_root("noise.prnu_percent", "PRNU of pixels", "%", pixel, mean);
        self.tell_root("noise.prnu_row_percent", "PRNU of rows", "%", row, mean);
        self.tell_root("noise.prnu_column_percent", "PRNU of columns", "%", column, mean);
    }

    fn defective(
        &mut self,
        defects: &[Defect],
        hot: Result<[Measured; 2], usize>,
        has_current: bool,
        patterns: &Patterns,
        frames: &CameraFrames<'_>,
    ) {
        let pixels = (frames.size[0] * frames.size[1]) as f64;
        let count = |kind| defects.iter().filter(|d| d.kind == kind).count() as f64;
        match hot {
            Ok([part, more]) if has_current => {
                self.tell("defects.hot_per_million", "", part.times(1e6));
                self.tell("defects.hot_dark_current_e_per_s", "e-/s", more.over(self.gain));
            }
            Ok(_) | Err(0) if patterns.rise.is_none() => {
                self.leave("hot pixels", "dark images of at least two known exposure times would tell them");
            }
            Err(0) => {}
            Ok(_) => self.leave("hot pixels", "there is no dark current beside theirs"),
            Err(few) => {
                self.leave("hot pixels", &format!("{few} are too few to tell how their dark currents are distributed"))
            }
        }
        for (key, kind) in
            [("defects.dead_per_million", DefectKind::Dead), ("defects.stuck_per_million", DefectKind::Stuck)]
        {
            let found = count(kind);
            if found > 0.0 {
                self.tell(key, "", Measured::new(found, found.sqrt()).times(1e6 / pixels));
            }
        }
        if patterns.response.is_none() {
            self.leave("dead and stuck pixels", "there are no bright images below saturation");
        }
        let odd = count(DefectKind::Odd);
        if odd > 0.0 {
            self.leave("other odd pixels", &format!("{odd} deviate by more than 8 standard deviations of the pattern"));
        }
    }

    /// Tells the full well, or what stands for it, and returns the signal that a linear response would give there, DN.
    fn full_well(&mut self, survey: &Survey, frames: &CameraFrames<'_>) -> f64 {
        const KEY: &str = "charge.full_well_e";
        let black = survey.dark.black();
        let range_dn = f64::from(frames.largest()) - black.value;
        let bend = survey.transfer.told_bend();
        let linear = |signal: f64| bend.map_or(signal, |bend| bend.linear(signal));
        let range = rounded((linear(range_dn) / self.gain.value).max(1.0), 6);
        let reason = match survey.transfer.saturation {
            Saturation::Well(level) if self.in_electrons => {
                let level = level.minus(black);
                let of_linear = Measured::new(linear(level.value), level.standard_error);
                self.tell(KEY, "e-", of_linear.over(self.gain));
                return of_linear.value;
            }
            Saturation::Converter => "the range of the converter ends first, so pixels hold this or more",
            Saturation::Well(_) | Saturation::NotReached(_) => {
                "no image is saturated: the range of the converter stands for it"
            }
        };
        self.assume(KEY, range.to_string(), reason);
        range * self.gain.value
    }

    /// Tells the bend of the response as the key of amplifiers has it: c₁ of q·(1 + c₁·q/F), in percent.
    fn linearity(&mut self, survey: &Survey, full_well_dn: f64) {
        const NAME: &str = "nonlinearity of the response";
        let Some(bend) = survey.transfer.bend else {
            return self.leave(
                NAME,
                "flats of four exposures or more over a factor of 3, in light that is known, would tell it",
            );
        };
        /// Part of the bend that its error is at least: dark charge passes through the same amplifiers, which the light of the
        /// line does not count.
        const LEAST_ERROR: f64 = 0.0025;
        let mut percent = bend.per_dn.times(100.0 * full_well_dn);
        percent.standard_error = percent.standard_error.hypot(LEAST_ERROR * percent.value);
        if bend.is_told() {
            return self.tell(NONLINEARITY, "%", percent);
        }
        let bound = rounded(percent.value.abs() + 1.96 * percent.standard_error, 2);
        self.leave(NAME, &format!("not told apart from 0: below {bound} % at the full well at 95 %"));
    }

    fn optics(&mut self) {
        const KEY: &str = "pixel_pitch_um";
        match self.known.pixel_pitch_um {
            Some([x, y]) => self.state(KEY, format!("[{x:?}, {y:?}]"), "as stated"),
            None => self.assume(KEY, "[5.0, 5.0]".to_owned(), "images do not tell it: write the pitch of your pixels"),
        }
        self.leave("split of the read noise", "reset noise, 1/f noise and telegraph signals count as read noise");
    }

    /// Names the shading of the images, which is no pattern of the sensor.
    pub(super) fn tell_shading(&mut self, dark: &Pattern, response: Option<&Pattern>) {
        if let Some(response) = response.filter(|pattern| pattern.is_shaded) {
            let percent = rounded(100.0 * response.shading / response.mean.value, 3);
            self.leave(
                "shading",
                &format!("the bright images vary smoothly by {percent} %, which lens and light may be the cause of"),
            );
        }
        if dark.is_shaded {
            let level = rounded(dark.shading, 3);
            self.leave(
                "shading of the dark signal",
                &format!("it varies smoothly by {level} DN, for which a sensor file has no key"),
            );
        }
    }
}
