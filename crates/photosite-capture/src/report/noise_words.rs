//! Monte Carlo noise relative to the noise of the sensor, in words.

use super::traced::RenderReport;
use photosite_core::math::float::rounded;

/// Ratio below which rendering adds less than a hundredth to the noise of the sensor.
pub const UNSEEN: f64 = 0.14;

/// Ratio of standard deviations as a multiple in words: `0.5`, `2.4 times`.
pub fn times(ratio: f64) -> String {
    format!("{}{}", rounded(ratio, 2), if ratio < 1.0 { "" } else { " times" })
}

/// Excess of both kinds of noise together over that of the sensor, in words.
pub fn together(ratio: f64) -> String {
    // Of independent errors, squares add.
    let both = ratio.hypot(1.0);
    if both < 2.0 {
        format!("both together are {} % more than the sensor's alone", rounded(100.0 * (both - 1.0), 2))
    } else {
        format!("both together are {} times the sensor's alone", rounded(both, 2))
    }
}

/// Comparison of Monte Carlo noise with the sensor's own, in words.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderNoise {
    /// Words on the noise, and on settings that would lessen it.
    pub words: String,
    /// Whether the noise may be visible: it is not small relative to that of the sensor, or not known.
    pub is_seen: bool,
}

impl RenderNoise {
    /// Noise of a render. `samples` writes the setting for a number of samples per pixel. `None` in the dark.
    pub fn new(render: &RenderReport, samples: impl Fn(u32) -> String) -> Option<Self> {
        let Some(ratio) = render.noise_ratio else {
            let words = format!(
                "Monte Carlo noise is not known: a single sample of each pixel does not tell it; {} does",
                samples(2)
            );
            return (render.samples_per_pixel == 1).then_some(Self { words, is_seen: true });
        };
        let said = format!("Monte Carlo noise is {} that of the sensor", times(ratio));
        if ratio <= UNSEEN {
            return Some(Self { words: format!("{said}: it is not seen"), is_seen: false });
        }
        let remedy = match &render.noise {
            // As many as its target asks for, or as its limits allow.
            Some(_) => String::new(),
            None => format!("; {} would halve it", samples(render.samples_per_pixel.saturating_mul(4))),
        };
        Some(Self { words: format!("{said}: {}{remedy}", together(ratio)), is_seen: true })
    }
}
