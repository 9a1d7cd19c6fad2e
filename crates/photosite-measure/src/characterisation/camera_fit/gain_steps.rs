//! Noise of the read-out and black level at several gains of a camera, each fitted alone.

use photosite_core::math::float::rounded;

use super::fit::CameraFit;
use super::parameters::{Assumption, FittedGainStep, Parameter};
use super::sensor_file::whole_number;
use super::sheet::SHAPE_OF_READ_NOISE;
use crate::characterisation::NotMeasured;

/// Figures that may change with gain: their keys, and their names in sentences.
const FIGURES: [(&str, &str); 7] = [
    ("noise.read_noise_e", "read noise by gain"),
    ("noise.row_noise_e", "row noise by gain"),
    ("noise.column_noise_e", "column noise by gain"),
    ("noise.dsnu_e", "DSNU of pixels by gain"),
    ("noise.dsnu_row_e", "DSNU of rows by gain"),
    ("noise.dsnu_column_e", "DSNU of columns by gain"),
    (BLACK_LEVEL, "black level by gain"),
];
const BLACK_LEVEL: &str = "adc.black_level_dn";
/// Figures of the shape of the read noise, which is the same at all gains.
const SHAPE: [&str; 2] = ["noise.read_noise_spread_percent", "noise.read_noise_degrees_of_freedom"];
const GAIN: &str = "adc.conversion_gain_dn_per_e";

impl CameraFit {
    /// System gain over that of another fit, dB, with its standard error; `None` where not both are measured.
    pub fn gain_over(&self, other: &Self) -> Option<[f64; 2]> {
        let [own, first] = [self, other].map(|fit| fit.parameter(GAIN).map(|parameter| parameter.measured));
        let (own, first) = (own?, first?);
        let per_part = 20.0 / std::f64::consts::LN_10;
        let error = per_part * own.relative_error().hypot(first.relative_error());
        Some([20.0 * (own.value / first.value).log10(), error])
    }

    /// Adds the noise of the read-out at this gain, called `name`, and at others: those of fits at higher gains, dB,
    /// with their names. A figure that is not told at each of them stays that of this fit at all gains.
    pub fn add_gains(&mut self, name: &str, others: &[(f64, String, Self)]) {
        self.take_shape(others);
        let at = |fit: &Self, key| fit.parameter(key).cloned();
        let mut steps = vec![FittedGainStep { gain_db: 0.0, name: name.to_owned(), parameters: Vec::new() }];
        let step = |(gain_db, name, _): &(f64, String, Self)| FittedGainStep {
            gain_db: rounded(*gain_db, 6),
            name: name.clone(),
            parameters: Vec::new(),
        };
        steps.extend(others.iter().map(step));
        for (key, figure) in FIGURES {
            let found: Vec<Option<Parameter>> =
                std::iter::once(at(self, key)).chain(others.iter().map(|(_, _, fit)| at(fit, key))).collect();
            if found.iter().all(Option::is_none) || key == BLACK_LEVEL && is_same_number(&found) {
                continue;
            }
            let missing: Vec<&str> =
                found.iter().zip(&steps).filter(|(found, _)| found.is_none()).map(|(_, step)| &*step.name).collect();
            if missing.is_empty() {
                steps.iter_mut().zip(found.into_iter().flatten()).for_each(|(step, p)| step.parameters.push(p));
            } else {
                let stands = if missing.contains(&name) { "it is none" } else { "that of the lowest gain stands" };
                let reason = format!("not told apart from 0 at {}; {stands} at all gains", missing.join(", "));
                self.left_out.push(NotMeasured { figure, reason });
            }
        }
        if steps[0].parameters.is_empty() {
            return;
        }
        let most = steps.last().map_or(0.0, |step| step.gain_db);
        self.assumed.push(Assumption {
            key: "adc.gain_db_range",
            value: format!("[0.0, {most:?}]"),
            is_stated: true,
            reason: format!("the gains of the images, of which {name} is 0 dB"),
        });
        self.gain_steps = steps;
    }

    /// Takes the shape of the read noise from the first gain that tells it, where this one does not: noise of more numbers is
    /// seen better.
    fn take_shape(&mut self, others: &[(f64, String, Self)]) {
        let is_left_out = |fit: &Self| fit.left_out.iter().any(|not| not.figure == SHAPE_OF_READ_NOISE);
        if !is_left_out(self) {
            return;
        }
        let Some((_, name, fit)) = others.iter().find(|(.., fit)| !is_left_out(fit)) else { return };
        let shape = SHAPE.iter().filter_map(|key| fit.parameter(key).cloned());
        self.parameters.extend(shape);
        self.left_out.retain(|not| not.figure != SHAPE_OF_READ_NOISE);
        self.notes.push(format!("the shape of the read noise is that of {name}; at the lowest gain it is not seen"));
    }

    /// Text of the steps in a sensor file.
    /// `is_told` says which keys stand in the file.
    pub(super) fn text_of_gain_steps(&self, is_told: impl Fn(&str) -> bool) -> String {
        let mut text = String::new();
        for FittedGainStep { gain_db, name, parameters } in &self.gain_steps {
            text +=
                &format!("\n[[noise.gain_steps]]\ngain_db = {gain_db:?}  # {}\n", name.replace(char::is_control, " "));
            for Parameter { key, unit, measured } in parameters.iter().filter(|p| is_told(p.key)) {
                let key = key.rsplit('.').next().unwrap_or(key);
                let error = rounded(measured.standard_error, 2);
                text += &match key {
                    "black_level_dn" => whole_number(key, measured, unit),
                    _ => format!("{key} = {:?}  # ± {error} {unit}", rounded(measured.value, 6)),
                };
                text.push('\n');
            }
        }
        text
    }
}

/// Whether figures of all gains are the same whole number, or one that is not told everywhere.
fn is_same_number(found: &[Option<Parameter>]) -> bool {
    let numbers: Vec<f64> = found.iter().flatten().map(|parameter| parameter.measured.value.round()).collect();
    numbers.iter().all(|number| *number == numbers[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characterisation::camera_fit::{DarkModel, Measured, PatternMaps, PhotonTransfer};

    fn fit(parameters: &[(&'static str, f64)]) -> CameraFit {
        let parameter = |&(key, value): &(&'static str, f64)| Parameter {
            key,
            unit: "e-",
            measured: Measured::new(value, 0.01 * value),
        };
        CameraFit {
            size: [8, 8],
            bits: 12,
            parameters: parameters.iter().map(parameter).collect(),
            assumed: Vec::new(),
            left_out: Vec::new(),
            notes: Vec::new(),
            defects: Vec::new(),
            maps: PatternMaps::default(),
            transfer: PhotonTransfer::new(&[], &DarkModel::new(Vec::new())),
            dark: DarkModel::new(Vec::new()),
            dark_currents: Vec::new(),
            gain_steps: Vec::new(),
        }
    }

    #[test]
    fn figures_that_all_gains_tell_become_steps_and_others_are_left_out() {
        let read = "noise.read_noise_e";
        let mut first = fit(&[(GAIN, 0.5), (read, 3.0), ("noise.row_noise_e", 1.0), (BLACK_LEVEL, 64.25)]);
        let second = fit(&[(GAIN, 2.0), (read, 2.0), (BLACK_LEVEL, 70.0)]);
        let [db, error] = second.gain_over(&first).expect("both have K");
        // 20·log₁₀ 4, and 1 % twice of 8.69 dB.
        assert!((db - 12.0412).abs() < 1e-4 && (error - 0.1228).abs() < 1e-3, "{db} {error}");
        first.add_gains("ISO 100", &[(12.0, "ISO 400".to_owned(), second)]);
        let text = first.text_of_gain_steps(|_| true);
        assert_eq!(
            text,
            "\n[[noise.gain_steps]]\ngain_db = 0.0  # ISO 100\nread_noise_e = 3.0  # ± 0.03 e-\n\
             black_level_dn = 64  # 64.25 ± 0.64 e-\n\
             \n[[noise.gain_steps]]\ngain_db = 12.0  # ISO 400\nread_noise_e = 2.0  # ± 0.02 e-\n\
             black_level_dn = 70  # 70 ± 0.7 e-\n"
        );
        assert_eq!(first.left_out.len(), 1);
        assert!(
            first.left_out[0].reason.contains("at ISO 400; that of the lowest gain stands"),
            "{:?}",
            first.left_out
        );
        assert_eq!(first.assumed[0].value, "[0.0, 12.0]");
    }

    #[test]
    fn the_shape_of_the_read_noise_is_that_of_the_first_gain_that_tells_it() {
        let hidden = || {
            let reason = "quantisation hides it".to_owned();
            let left_out = vec![NotMeasured { figure: SHAPE_OF_READ_NOISE, reason }];
            CameraFit { left_out, ..fit(&[(GAIN, 0.5), ("noise.read_noise_e", 3.0)]) }
        };
        let shape = fit(&[(GAIN, 2.0), ("noise.read_noise_e", 2.0), (SHAPE[1], 6.0)]);
        let mut first = hidden();
        first.add_gains(
            "ISO 100",
            &[(6.0, "ISO 200".to_owned(), hidden()), (12.0, "ISO 400".to_owned(), shape.clone())],
        );
        assert_eq!(first.parameter(SHAPE[1]), shape.parameter(SHAPE[1]));
        assert!(first.left_out.is_empty() && first.notes[0].contains("that of ISO 400"), "{:?}", first.notes);
        // One that this gain tells stays.
        let mut first = fit(&[(GAIN, 0.5), ("noise.read_noise_e", 3.0), (SHAPE[1], 5.0)]);
        first.add_gains("ISO 100", &[(12.0, "ISO 400".to_owned(), shape)]);
        assert_eq!(first.parameter(SHAPE[1]).map(|p| p.measured.value), Some(5.0));
    }
}
