//! Automatic gain control at a fixed time: the gain of the next image of a series follows the mean of this one.

use photosite_core::Invalid;
use photosite_core::units::Decibels;

use crate::SensorModel;
use photosite_raw::RawImage;

/// Automatic gain control: from image n to the next one the gain, dB, becomes
///
/// G_{n+1} = clamp(G_n + attack·20·log₁₀(target/m_n), limits)
///
/// with the mean m_n of its linear numbers from black to white, 0 to 1. Under steady light, and as long as nothing
/// saturates, each image has 1 − attack of the error, dB, of the one before it: an exponential attack with the time
/// constant −1/ln(1 − attack) images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GainControl {
    /// Mean of the image that it aims at, above 0 and below 1.
    pub target: f64,
    /// Part of the error that it makes up from one image to the next, above 0 up to 1.
    pub attack: f64,
    /// Smallest and largest analogue gain.
    pub limits: [Decibels; 2],
}

/// An image that is darker counts as this dark.
const DARKEST: f64 = 1e-3;

impl GainControl {
    /// Refuses what is no control of a sensor. Keys of errors are those of the capture file's
    /// `[exposure.gain_control]` table.
    pub fn validate(&self, sensor: &SensorModel) -> Result<(), Invalid> {
        if !(self.target > 0.0 && self.target < 1.0) {
            let message = format!("must lie between 0 and 1, got {}", self.target);
            return Err(Invalid::new("target", message).help("for example target = 0.18"));
        }
        if !(self.attack > 0.0 && self.attack <= 1.0) {
            let message = format!("must lie above 0 and up to 1, got {}", self.attack);
            return Err(Invalid::new("attack", message).help("for example attack = 0.3; 1 reaches the target at once"));
        }
        let [low, high] = self.limits.map(|limit| limit.0);
        let [least, most] = sensor.converter.gain_range.map(|limit| limit.0);
        if !(least <= low && low <= high && high <= most) {
            let message = format!("[{low}, {high}] dB are not among the gains of sensor {}", sensor.name);
            let help = format!("write the smaller one first, from {least} to {most} dB, or sensor.adc.gain_db_range");
            return Err(Invalid::new("limits_db", message).help(help));
        }
        Ok(())
    }

    /// The gain within the limits with which a series begins.
    pub fn first(&self, stated: Decibels) -> Decibels {
        Decibels(stated.0.clamp(self.limits[0].0, self.limits[1].0))
    }

    /// The gain of the image after one that was taken at a gain.
    pub fn next(&self, gain: Decibels, raw: &RawImage) -> Decibels {
        self.after(gain, mean_level(raw))
    }

    fn after(&self, gain: Decibels, level: f64) -> Decibels {
        let error_db = Decibels::of_factor(self.target / level.max(DARKEST)).0;
        self.first(Decibels(gain.0 + self.attack * error_db))
    }
}

/// Mean of the linear values of the pixels that see light, from black to white.
fn mean_level(raw: &RawImage) -> f64 {
    let linear = raw.linear();
    let active = if linear.active_area.is_some() { linear.cropped() } else { linear.into_owned() };
    let sum: f64 = active.data.iter().map(|&dn| f64::from(dn)).sum();
    let black = f64::from(active.black_level_dn.mean());
    (sum / active.data.len().max(1) as f64 - black) / (f64::from(active.white_level_dn) - black)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_fall_exponentially_up_to_the_limits() {
        let control = GainControl { target: 0.4, attack: 0.25, limits: [Decibels(0.0), Decibels(24.0)] };
        // A tenth of the target at 0 dB: 20 dB are missing.
        let mut gain = Decibels(0.0);
        for frame in 1..20 {
            gain = control.after(gain, 0.04 * gain.factor());
            let missing = 20.0 * 0.75f64.powi(frame);
            assert!((gain.0 - (20.0 - missing)).abs() < 1e-9, "{gain:?}");
        }
        // A hundredth of it needs 40 dB, and 24 is the end; darkness is a thousandth of white at least.
        assert_eq!(control.after(Decibels(20.0), 0.004), Decibels(24.0));
        assert!((control.after(Decibels(0.0), -3.0).0 - 0.25 * 20.0 * 400f64.log10()).abs() < 1e-9);
        assert_eq!(control.after(Decibels(1.0), 1.0), Decibels(0.0));
    }

    #[test]
    fn covered_pixels_and_black_do_not_count() {
        let raw = RawImage {
            width: 3,
            height: 1,
            data: vec![60_000, 100, 300],
            active_area: Some(photosite_raw::PixelArea { x: 1, y: 0, width: 2, height: 1 }),
            black_level_dn: 100.into(),
            white_level_dn: 500,
            ..RawImage::default()
        };
        assert_eq!(mean_level(&raw), 0.25);
    }
}
