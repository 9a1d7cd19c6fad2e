//! Monte Carlo noise beside the noise of the sensor, in words.

use super::traced::RenderReport;
use crate::math::float::rounded;

/// The ratio at which rendering adds less than a hundredth to the noise of the sensor.
pub(crate) const UNSEEN: f64 = 0.14;

/// A ratio of standard deviations as a multiple: `0.5`, `2.4 times`.
pub(crate) fn times(ratio: f64) -> String {
    format!("{}{}", rounded(ratio, 2), if ratio < 1.0 { "" } else { " times" })
}

/// How far both together exceed the noise of the sensor.
pub(crate) fn together(ratio: f64) -> String {
    // Of independent errors, squares add.
    let both = ratio.hypot(1.0);
    if both < 2.0 {
        format!("both together are {} % more than the sensor's alone", rounded(100.0 * (both - 1.0), 2))
    } else {
        format!("both together are {} times the sensor's alone", rounded(both, 2))
    }
}

/// How the noise that rendering leaves compares with the sensor's own, in words.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderNoise {
    /// What is said of it, and what would lessen it.
    pub words: String,
    /// Whether it may be seen: it is not small beside the noise of the sensor, or not known.
    pub is_seen: bool,
}

impl RenderNoise {
    /// Noise of a render, whose samples of each pixel are set by what `samples` writes for their number. `None` in the dark.
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
