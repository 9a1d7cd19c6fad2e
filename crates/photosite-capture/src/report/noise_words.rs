//! Monte Carlo noise relative to the noise of the sensor, in words.

use super::traced::RenderReport;
use photosite_core::math::float::rounded;

/// Ratio below which rendering adds less than a hundredth to the noise of the sensor.
pub const UNSEEN: f64 = 0.14;

/// Part of saturated pixels from which on the rest is said to be what the noise ratio is of.
const MANY: f64 = 0.1;

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
        let saturated = render.saturated_part.unwrap_or(0.0);
        let Some(ratio) = render.noise_ratio else {
            if saturated == 1.0 {
                let words = "Monte Carlo noise is not known: all pixels are saturated, and no pixel tells it";
                return Some(Self { words: words.to_owned(), is_seen: false });
            }
            let words = format!(
                "Monte Carlo noise is not known: a single sample of each pixel does not tell it; {} does",
                samples(2)
            );
            return (render.samples_per_pixel == 1).then_some(Self { words, is_seen: true });
        };
        let of_the_rest = if saturated > MANY {
            format!(" in the {} % of pixels that are not saturated", rounded(100.0 * (1.0 - saturated), 2))
        } else {
            String::new()
        };
        let said = format!("Monte Carlo noise is {} that of the sensor{of_the_rest}", times(ratio));
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

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn noise(noise_ratio: Option<f64>, saturated_part: Option<f64>) -> Option<RenderNoise> {
        let render = json!({
            "seed": 0, "samples_per_pixel": 16, "max_depth": 8, "roulette_depth": 4, "splitting": 1, "light_paths": 0.0,
            "wavelengths": "all-filters", "sampler": "sobol", "triangles": 2, "lights": 1,
            "noise_ratio": noise_ratio, "saturated_part": saturated_part,
        });
        RenderNoise::new(&serde_json::from_value(render).expect("a report"), |n| format!("--spp {n}"))
    }

    #[test]
    fn where_many_pixels_are_saturated_the_ratio_is_said_to_be_of_the_others() {
        let words = |saturated| noise(Some(2.0), saturated).expect("known").words;
        let rest = ": both together are 2.2 times the sensor's alone; --spp 64 would halve it";
        for few in [None, Some(0.05)] {
            assert_eq!(words(few), format!("Monte Carlo noise is 2 times that of the sensor{rest}"));
        }
        let of_the_others =
            "Monte Carlo noise is 2 times that of the sensor in the 4 % of pixels that are not saturated";
        assert_eq!(words(Some(0.96)), format!("{of_the_others}{rest}"));
    }

    #[test]
    fn no_pixel_tells_where_all_are_saturated() {
        let RenderNoise { words, is_seen } = noise(None, Some(1.0)).expect("words");
        assert!(words.ends_with("all pixels are saturated, and no pixel tells it") && !is_seen, "{words}");
        assert_eq!(noise(None, None), None);
    }
}
