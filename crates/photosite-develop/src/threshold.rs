//! Thresholding: pixels above a level become white, the others black.

use photosite_core::rows::for_each_value;

use super::choices::Thresholding;
use super::settings::DevelopSettings;
use photosite_core::image::Planes;

/// Classes of values that Otsu's method counts: the codes of 8 bits.
const CLASSES: usize = 256;

/// Makes every plane binary, if that is asked for.
pub(super) fn apply(image: &mut Planes, settings: &DevelopSettings) {
    for channel in image.channels_mut() {
        match settings.threshold {
            Thresholding::None => {}
            Thresholding::Level => {
                let level = settings.threshold_level() as f32;
                binary(&mut channel.data, |value| value > level);
            }
            Thresholding::Otsu => {
                let level = otsu(&channel.data);
                binary(&mut channel.data, |value| class(value) > level);
            }
        }
    }
}

fn binary(plane: &mut [f32], is_white: impl Fn(f32) -> bool + Sync) {
    for_each_value(plane, |value| *value = f32::from(u8::from(is_white(*value))));
}

/// ⌊255·v + ½⌋ of values from 0 to 1.
fn class(value: f32) -> usize {
    // A cast takes not-a-number and all below 0 to 0.
    usize::from((value * (CLASSES - 1) as f32 + 0.5) as u8)
}

/// The largest class of the darker group, where the variance between both groups, ω₀·ω₁·(μ₁ − μ₀)², is largest
/// ([Otsu79](photosite_core::references#otsu79)); the first of several.
fn otsu(plane: &[f32]) -> usize {
    let mut counts = [0u64; CLASSES];
    plane.iter().for_each(|&value| counts[class(value)] += 1);
    let total = plane.len() as f64;
    let sum: f64 = counts.iter().enumerate().map(|(i, &n)| i as f64 * n as f64).sum();
    let (mut below, mut sum_below) = (0.0, 0.0);
    let (mut best, mut largest) = (0, 0.0);
    for (i, &n) in counts.iter().enumerate() {
        below += n as f64;
        sum_below += i as f64 * n as f64;
        let above = total - below;
        if below > 0.0 && above > 0.0 {
            let between = below * above * ((sum - sum_below) / above - sum_below / below).powi(2);
            if between > largest {
                (best, largest) = (i, between);
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::image::Channel;

    fn applied(values: &[f32], settings: &DevelopSettings) -> Vec<f32> {
        let channel = Channel { name: "Y".to_owned(), data: values.to_vec() };
        let mut image = Planes::new(values.len(), 1, vec![channel]).expect("right size");
        apply(&mut image, settings);
        image.channels()[0].data.clone()
    }

    #[test]
    fn what_is_above_the_level_is_white() {
        let settings = DevelopSettings {
            threshold: Thresholding::Level,
            threshold_level: Some(0.25),
            ..DevelopSettings::default()
        };
        assert_eq!(applied(&[0.0, 0.25, 0.250_01, 7.0, f32::NAN, -1.0], &settings), [0.0, 0.0, 1.0, 1.0, 0.0, 0.0]);
        assert_eq!(applied(&[0.3, 7.0], &DevelopSettings::default()), [0.3, 7.0]);
    }

    #[test]
    fn otsu_parts_two_groups() {
        let settings = DevelopSettings { threshold: Thresholding::Otsu, ..DevelopSettings::default() };
        let values: Vec<f32> = (0..100).map(|i| if i % 3 == 0 { 0.6 } else { 0.2 } + 0.001 * (i % 7) as f32).collect();
        let expected: Vec<f32> = (0..100).map(|i| if i % 3 == 0 { 1.0 } else { 0.0 }).collect();
        assert_eq!(applied(&values, &settings), expected);
        assert_eq!(applied(&[0.4; 5], &settings), [1.0; 5], "nothing to part");
    }
}
