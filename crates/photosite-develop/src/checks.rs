//! Checks of the keys of the `[develop]` table: values out of range, and keys of choices that were not made, are
//! refused.

use super::choices::{ColourModel, NoiseFilter, Thresholding, ToneCurve, WhiteBalance};
use super::convolution::Kernel;
use super::settings::DevelopSettings;
use photosite_core::Invalid;
use photosite_core::colour::ColourSpace;

/// Largest window of a noise filter: beyond it lies a slip of the pen.
const MAX_RADIUS: usize = 50;
/// Most pixels along a side of an image that is resized.
const LARGEST_SIDE: usize = 65_535;

impl DevelopSettings {
    /// Refuses values out of range, and keys that go with a choice that was not made.
    pub fn validate(&self) -> Result<(), Invalid> {
        self.raw.validate().map_err(|invalid| invalid.within("raw"))?;
        self.refuse_lonely_keys()?;
        self.check_ranges()?;
        if self.white_balance == WhiteBalance::Temperature && self.temperature_k.is_none() {
            let help = "for example temperature_k = 5000";
            return Err(Invalid::new("white_balance", "needs temperature_k").help(help));
        }
        if self.white_balance == WhiteBalance::Patch && self.patch_px.is_none() {
            let help = "for example patch_px = [100, 80, 20, 20]";
            return Err(Invalid::new("white_balance", "needs patch_px").help(help));
        }
        if self.noise_filter != NoiseFilter::None && !(1..=MAX_RADIUS).contains(&self.noise_radius_px()) {
            let message = format!("must lie from 1 to {MAX_RADIUS}, got {}", self.noise_radius_px());
            return Err(Invalid::new("noise_radius_px", message).help("for example noise_radius_px = 2"));
        }
        Kernel::of(self)?;
        if let Some(side) = self.resize_px.into_iter().flatten().find(|side| !(1..=LARGEST_SIDE).contains(side)) {
            let message = format!("must lie from 1 to {LARGEST_SIDE}, got {side}");
            return Err(Invalid::new("resize_px", message).help("for example resize_px = [640, 480]"));
        }
        let of_colours = matches!(self.colour_model, ColourModel::Hsv | ColourModel::Hsl | ColourModel::Hsi);
        if of_colours && self.colour_space == ColourSpace::Xyz {
            let message = format!("X, Y and Z have no {}", self.colour_model.name());
            return Err(Invalid::new("colour_model", message).help("choose another colour_space, for example \"srgb\""));
        }
        if self.threshold != Thresholding::None && !self.colour_model.is_shown() {
            let message = format!("a binary image has no {}", self.colour_model.name());
            return Err(Invalid::new("threshold", message).help("choose colour_model = \"grey\" or \"rgb\""));
        }
        match self.bits {
            8 | 16 => Ok(()),
            other => Err(Invalid::new("bits", format!("must be 8 or 16, got {other}")).help("for example bits = 16")),
        }
    }

    /// Refuses keys that say more of a choice that was not made.
    fn refuse_lonely_keys(&self) -> Result<(), Invalid> {
        let with_temperature = self.white_balance == WhiteBalance::Temperature;
        let with_patch = self.white_balance == WhiteBalance::Patch;
        let smooths = self.noise_filter != NoiseFilter::None;
        let is_bilateral = self.noise_filter == NoiseFilter::Bilateral;
        let is_gaussian = self.noise_filter == NoiseFilter::Gaussian;
        let by_noise =
            is_bilateral && self.noise_sigma_range.is_none() || self.noise_filter == NoiseFilter::NonLocalMeans;
        let resizes = self.resizes();
        let tone = self.tone_curve;
        let by_level = self.threshold == Thresholding::Level;
        for (key, is_given, fits, wanted) in [
            ("temperature_k", self.temperature_k.is_some(), with_temperature, "white_balance = \"temperature\""),
            ("tint", self.tint.is_some(), with_temperature, "white_balance = \"temperature\""),
            ("patch_px", self.patch_px.is_some(), with_patch, "white_balance = \"patch\""),
            ("noise_radius_px", self.noise_radius_px.is_some(), smooths, "a noise_filter"),
            (
                "noise_strength",
                self.noise_strength.is_some(),
                by_noise,
                "noise_filter = \"bilateral\" without noise_sigma_range, or \"non-local-means\"",
            ),
            (
                "noise_sigma_px",
                self.noise_sigma_px.is_some(),
                is_gaussian || is_bilateral,
                "noise_filter = \"gaussian\" or \"bilateral\"",
            ),
            ("noise_sigma_range", self.noise_sigma_range.is_some(), is_bilateral, "noise_filter = \"bilateral\""),
            ("kernel_normalised", self.kernel_normalised.is_some(), self.kernel.is_some(), "a kernel"),
            ("resize_filter", self.resize_filter.is_some(), resizes, "resize_px or digital_zoom"),
            ("resize_antialias", self.resize_antialias.is_some(), resizes, "resize_px or digital_zoom"),
            ("gamma", self.gamma.is_some(), tone == ToneCurve::Gamma, "tone_curve = \"gamma\""),
            ("tone_key", self.tone_key.is_some(), tone == ToneCurve::Reinhard, "tone_curve = \"reinhard\""),
            ("tone_white", self.tone_white.is_some(), tone == ToneCurve::Reinhard, "tone_curve = \"reinhard\""),
            ("tone_bias", self.tone_bias.is_some(), tone == ToneCurve::Log, "tone_curve = \"log\""),
            ("tone_contrast", self.tone_contrast.is_some(), tone == ToneCurve::Local, "tone_curve = \"local\""),
            ("tone_sigma_px", self.tone_sigma_px.is_some(), tone == ToneCurve::Local, "tone_curve = \"local\""),
            ("tone_sigma_range", self.tone_sigma_range.is_some(), tone == ToneCurve::Local, "tone_curve = \"local\""),
            ("threshold_level", self.threshold_level.is_some(), by_level, "threshold = \"level\""),
            ("sharpening_radius_px", self.sharpening_radius_px.is_some(), self.sharpening != 0.0, "sharpening above 0"),
        ] {
            if is_given && !fits {
                return Err(
                    Invalid::new(key, format!("only applies with {wanted}")).help(format!("add it, or remove {key}"))
                );
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::choices::ResizeFilter;
    use super::*;

    #[test]
    fn defaults_are_valid_and_slips_are_told() {
        let default = DevelopSettings::default;
        assert_eq!(default().validate(), Ok(()));
        let unbounded =
            DevelopSettings { tone_curve: ToneCurve::Reinhard, tone_white: Some(f64::INFINITY), ..default() };
        assert_eq!(unbounded.validate(), Ok(()));
        for (settings, key) in [
            (DevelopSettings { temperature_k: Some(5000.0), ..default() }, "temperature_k"),
            (DevelopSettings { gamma: Some(2.2), ..default() }, "gamma"),
            (DevelopSettings { white_balance: WhiteBalance::Temperature, ..default() }, "white_balance"),
            (DevelopSettings { white_balance: WhiteBalance::Patch, ..default() }, "white_balance"),
            (DevelopSettings { exposure_ev: f64::NAN, ..default() }, "exposure_ev"),
            (DevelopSettings { bits: 12, ..default() }, "bits"),
            (DevelopSettings { sharpening: -1.0, ..default() }, "sharpening"),
            (DevelopSettings { noise_radius_px: Some(2), ..default() }, "noise_radius_px"),
            (
                DevelopSettings { noise_filter: NoiseFilter::Mean, noise_radius_px: Some(0), ..default() },
                "noise_radius_px",
            ),
            (
                DevelopSettings { noise_filter: NoiseFilter::Mean, noise_strength: Some(2.0), ..default() },
                "noise_strength",
            ),
            (
                DevelopSettings { noise_filter: NoiseFilter::Median, noise_sigma_px: Some(1.0), ..default() },
                "noise_sigma_px",
            ),
            (
                DevelopSettings { noise_filter: NoiseFilter::Gaussian, noise_sigma_range: Some(0.1), ..default() },
                "noise_sigma_range",
            ),
            (
                DevelopSettings {
                    noise_filter: NoiseFilter::Bilateral,
                    noise_sigma_range: Some(0.1),
                    noise_strength: Some(2.0),
                    ..default()
                },
                "noise_strength",
            ),
            (DevelopSettings { kernel_normalised: Some(true), ..default() }, "kernel_normalised"),
            (DevelopSettings { kernel: Some(vec![vec![1.0, 2.0]]), ..default() }, "kernel"),
            (DevelopSettings { kernel: Some(vec![vec![1.0], vec![1.0, 2.0, 3.0], vec![1.0]]), ..default() }, "kernel"),
            (DevelopSettings { kernel: Some(vec![vec![f64::NAN]]), ..default() }, "kernel"),
            (
                DevelopSettings {
                    kernel: Some(vec![vec![-1.0, 0.0, 1.0]]),
                    kernel_normalised: Some(true),
                    ..default()
                },
                "kernel_normalised",
            ),
            (DevelopSettings { digital_zoom: 0.5, ..default() }, "digital_zoom"),
            (DevelopSettings { resize_px: Some([0, 20]), ..default() }, "resize_px"),
            (DevelopSettings { resize_filter: Some(ResizeFilter::Linear), ..default() }, "resize_filter"),
            (DevelopSettings { tone_key: Some(0.2), ..default() }, "tone_key"),
            (
                DevelopSettings { tone_curve: ToneCurve::Reinhard, tone_white: Some(f64::NAN), ..default() },
                "tone_white",
            ),
            (DevelopSettings { tone_curve: ToneCurve::Log, tone_bias: Some(0.0), ..default() }, "tone_bias"),
            (DevelopSettings { tone_curve: ToneCurve::Local, tone_contrast: Some(1.0), ..default() }, "tone_contrast"),
            (DevelopSettings { threshold_level: Some(0.5), ..default() }, "threshold_level"),
            (
                DevelopSettings { threshold: Thresholding::Otsu, colour_model: ColourModel::Hsv, ..default() },
                "threshold",
            ),
            (
                DevelopSettings { colour_space: ColourSpace::Xyz, colour_model: ColourModel::Hsi, ..default() },
                "colour_model",
            ),
            (DevelopSettings { jpeg_quality: 0, ..default() }, "jpeg_quality"),
        ] {
            assert_eq!(settings.validate().expect_err(key).key, key);
        }
    }
}
