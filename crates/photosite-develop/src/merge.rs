//! Merging a bracket: raw images of the same light that were exposed for different times become one signal that
//! reaches further than any of them.
//!
//! Every image i gives an estimate x_i/t_i of the light on a pixel, with the signal x_i (0 for no light, 1 for
//! saturation) and the time t_i. They are weighted by the inverse of their variance,
//!
//! L = Σ t_i·x_i/v_i / Σ t_i²/v_i,  v_i = S_i·L·t_i + O_i
//!
//! with the noise S·x + O that the raw files state: shot noise, and that of dark current, read-out and quantisation
//! ([Granados10](photosite_core::references#granados10), after [Robertson03](photosite_core::references#robertson03)).
//! The variance is that of the common estimate L, found in a few rounds, and not that of each noisy x_i: low samples
//! would get more weight than high ones, and the result would be too dark.
//!
//! Signals within 5 σ of saturation are left out, those that noise took below included ([`LEFT_OUT_SIGMA`]). Where that
//! is all of a pixel's, the shortest exposure stands for it.

use rayon::prelude::*;

use super::{black_level, opcodes};
use photosite_core::Invalid;
use photosite_raw::RawImage;

/// Distance below saturation that a signal must have to count, in standard deviations of its noise there.
pub const LEFT_OUT_SIGMA: f64 = 5.0;
/// Noise of images that state none, (S, O): shot noise of 10 000 electrons at saturation, and as much read noise as
/// the shot noise of 100 of them. Assumed.
const ASSUMED_NOISE: [f64; 2] = [1e-4, 1e-6];
/// Rounds in which weights and estimate follow each other. The weights of the second are right to the noise of the
/// first estimate, and what a weight is wrong by counts in the result by its square only.
const ROUNDS: usize = 3;
/// Most images of a bracket.
const MOST: usize = 32;

/// The light of a bracket as one signal.
#[derive(Clone, Debug)]
pub struct Merged {
    /// Signal: a value for each of the raw image, 1 being saturation in the shortest exposure, where it ends.
    pub signal: Vec<f32>,
    /// Layout and metadata of the shortest exposure, without pixel values.
    pub raw: RawImage,
    /// The shortest and the longest time, s.
    pub times_s: [f64; 2],
    /// Number of values that are saturated in every exposure.
    pub saturated: usize,
    /// Whether every image stated its noise.
    pub noise_is_stated: bool,
}

/// Exposure of a bracket.
struct Shot {
    /// Time over the shortest.
    time: f64,
    signal: Vec<f32>,
    /// (S, O) of each channel.
    noise: Vec<[f64; 2]>,
    /// Signals from here on are left out, for each channel.
    limit: Vec<f32>,
}

/// Merges two or more raw images, in any order. Keys of errors are those of the images' metadata, after the number
/// of the image: `1.ExposureTime`.
pub fn merge(images: &[RawImage]) -> Result<Merged, Invalid> {
    check(images)?;
    let mut sorted: Vec<&RawImage> = images.iter().collect();
    sorted.sort_by(|a, b| a.metadata.exposure_time_s.total_cmp(&b.metadata.exposure_time_s));
    let times_s = [sorted[0], sorted[sorted.len() - 1]].map(|raw| raw.metadata.exposure_time_s);
    let mut reference = opcodes::on_stored(sorted[0], true).linear().cropped();
    let others = sorted[1..].iter().map(|raw| Shot::new(&opcodes::on_stored(raw, true).linear().cropped(), times_s[0]));
    let shots: Vec<Shot> = std::iter::once(Shot::new(&reference, times_s[0])).chain(others).collect();
    reference.data = Vec::new();
    let (cfa, row_length) = (&reference.cfa, reference.row_length());
    let mut signal = vec![0.0f32; shots[0].signal.len()];
    let rows = signal.par_chunks_mut(row_length.max(1)).enumerate();
    let saturated = rows
        .map(|(y, row)| {
            let mut saturated = 0;
            for (x, to) in row.iter_mut().enumerate() {
                let merged = merge_number(&shots, y * row_length + x, cfa.channel_at(x, y));
                saturated += usize::from(merged.is_none());
                *to = merged.unwrap_or_else(|| shots[0].signal[y * row_length + x]);
            }
            saturated
        })
        .sum();
    let noise_is_stated = images.iter().all(|raw| stated_noise(raw).is_some());
    let mut raw = reference;
    // The noise of the merged signal is no longer of that form.
    raw.metadata.noise_profile.clear();
    Ok(Merged { signal, raw, times_s, saturated, noise_is_stated })
}

/// The common estimate of one number, in signal of the shortest time; `None` where all are saturated.
#[inline]
fn merge_number(shots: &[Shot], i: usize, channel: usize) -> Option<f32> {
    let usable = || shots.iter().filter(|shot| shot.signal[i] < shot.limit[channel]);
    // Best for shot noise alone, and good enough to tell variances.
    let (signal, time) = usable().fold((0.0, 0.0), |(x, t), shot| (x + f64::from(shot.signal[i]), t + shot.time));
    if time == 0.0 {
        return None;
    }
    let mut light: f64 = signal / time;
    for _ in 0..ROUNDS {
        let (mut weighted, mut weights) = (0.0, 0.0);
        for shot in usable() {
            let [slope, offset] = shot.noise[channel];
            let weight = shot.time / (slope * (light * shot.time).max(0.0) + offset);
            weighted += weight * f64::from(shot.signal[i]);
            weights += weight * shot.time;
        }
        light = weighted / weights;
    }
    Some(light as f32)
}

impl Shot {
    /// Exposure from a linear image without masked pixels.
    fn new(raw: &RawImage, shortest_s: f64) -> Self {
        let channels = raw.cfa.channels().len();
        let noise = stated_noise(raw).map_or_else(|| vec![ASSUMED_NOISE; channels], <[_]>::to_vec);
        // Where a sensor holds few electrons, half of its range at least is left.
        let limit = |[slope, offset]: &[f64; 2]| (1.0 - LEFT_OUT_SIGMA * (slope + offset).sqrt()).max(0.5) as f32;
        Self {
            time: raw.metadata.exposure_time_s / shortest_s,
            signal: black_level::subtract(raw, true),
            limit: noise.iter().map(limit).collect(),
            noise,
        }
    }
}

/// The noise of each channel, if the image states it and it can be.
fn stated_noise(raw: &RawImage) -> Option<&[[f64; 2]]> {
    let noise = &raw.metadata.noise_profile;
    let is_noise =
        |[slope, offset]: &[f64; 2]| *slope >= 0.0 && *offset > 0.0 && slope.is_finite() && offset.is_finite();
    (noise.len() == raw.cfa.channels().len() && noise.iter().all(is_noise)).then_some(noise)
}

/// Refuses images that are no bracket.
fn check(images: &[RawImage]) -> Result<(), Invalid> {
    if !(2..=MOST).contains(&images.len()) {
        let message = format!("a bracket has 2 to {MOST} images, not {}", images.len());
        return Err(Invalid::new("", message).help("give raw images of the same light, exposed for different times"));
    }
    let first = &images[0];
    for (number, raw) in images.iter().enumerate() {
        raw.validate().map_err(|invalid| invalid.within(&number.to_string()))?;
        let differ = |key: &str, what: String| Err(Invalid::new(format!("{number}.{key}"), what));
        let time = raw.metadata.exposure_time_s;
        if !(time.is_finite() && time > 0.0) {
            return differ("ExposureTime", "the file does not say for how long it was exposed".to_owned());
        }
        let size = |raw: &RawImage| [raw.active().width, raw.active().height];
        if size(raw) != size(first) || raw.active_cfa() != first.active_cfa() {
            let [[width, height], [w, h]] = [size(raw), size(first)];
            let (cfa, other) = (&raw.cfa, &first.cfa);
            return differ(
                "",
                format!("has {width} × {height} pixels behind {cfa}, the first image {w} × {h} behind {other}"),
            );
        }
        let of = |raw: &RawImage| (raw.metadata.iso, raw.metadata.f_number);
        if of(raw) != of(first) {
            let say = |(iso, f): (Option<u32>, Option<f64>)| {
                let text = |value: Option<String>| value.unwrap_or_else(|| "unknown".to_owned());
                format!("ISO {}, f-number {}", text(iso.map(|iso| iso.to_string())), text(f.map(|f| f.to_string())))
            };
            return differ("ISO", format!("was taken at {}, the first image at {}", say(of(raw)), say(of(first))));
        }
    }
    let times = || images.iter().map(|raw| raw.metadata.exposure_time_s);
    if times().all(|time| time == first.metadata.exposure_time_s) {
        let message = format!("all images were exposed for {} s", first.metadata.exposure_time_s);
        return Err(Invalid::new("ExposureTime", message).help("a bracket has different times"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_raw::{Cfa, RawMetadata};

    fn image(time_s: f64, numbers: &[u16]) -> RawImage {
        RawImage {
            width: numbers.len(),
            height: 1,
            data: numbers.to_vec(),
            cfa: Cfa::mono(),
            bits: 12,
            black_level_dn: 100.into(),
            white_level_dn: 4100,
            metadata: RawMetadata {
                exposure_time_s: time_s,
                noise_profile: vec![[1e-4, 1e-6]],
                ..RawMetadata::default()
            },
            ..RawImage::default()
        }
    }

    #[test]
    fn two_images_by_hand() {
        // Signals 0.02 and 0.1 of times 1 and 4: L₀ = 0.12/5 = 0.024. Variances at it: 3.4e-6 and 1.06e-5. Weights t/v:
        // 294118 and 377358; L = (294118·0.02 + 377358·0.1)/(294118 + 4·377358) = 43618.2/1803552 = 0.0241846.
        // Again, from 3.41846e-6 and 1.067384e-5: 292529 and 374748; 43325.4/1791521 = 0.0241836.
        // And once more: 3.41836e-6, 1.067344e-5: 292538 and 374762; 43327.0/1791586 = 0.0241836.
        let bracket = [image(0.04, &[500, 4100, 4100, 100]), image(0.01, &[180, 1100, 4100, 100])];
        let merged = merge(&bracket).expect("a bracket");
        assert!((merged.signal[0] - 0.024_183_6).abs() < 2e-7, "{}", merged.signal[0]);
        // Saturated in the long one, in both, and dark in both.
        assert_eq!(merged.signal[1..], [0.25, 1.0, 0.0]);
        assert_eq!((merged.saturated, merged.times_s, merged.noise_is_stated), (1, [0.01, 0.04], true));
    }

    #[test]
    fn what_is_no_bracket_is_refused() {
        let good = image(0.01, &[200, 300]);
        let longer = image(0.02, &[300, 500]);
        let with = |change: fn(&mut RawImage)| {
            let mut raw = longer.clone();
            change(&mut raw);
            vec![good.clone(), raw]
        };
        for (images, key) in [
            (vec![good.clone()], ""),
            (vec![good.clone(), good.clone()], "ExposureTime"),
            (vec![good.clone(), image(0.0, &[200, 300])], "1.ExposureTime"),
            (vec![good.clone(), image(0.02, &[200])], "1."),
            (with(|raw| raw.cfa = Cfa::parse("RGGB").expect("known")), "1."),
            (with(|raw| raw.metadata.iso = Some(400)), "1.ISO"),
            (with(|raw| raw.data.clear()), "1"),
        ] {
            let error = merge(&images).expect_err(key);
            assert_eq!(error.key, key, "{error}");
        }
        let silent = merge(&with(|raw| raw.metadata.noise_profile.clear())).expect("noise is assumed");
        assert!(!silent.noise_is_stated);
    }
}
