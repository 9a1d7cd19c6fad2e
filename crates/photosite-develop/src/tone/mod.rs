//! Tone: how scene light becomes the light of a display, one file a curve.
//!
//! Filmic bends every component. The others find what luminance is shown of a pixel's luminance, and scale its
//! components by the ratio of both, so that chromaticities stay. None of them shows less than black: what an image holds
//! below it is noise, or lies outside its colours.

mod fast_bilateral;
mod filmic;
mod local;
mod logarithmic;
mod luminances;
mod reinhard;

use photosite_core::rows::{for_each_row, for_each_value};

use super::choices::ToneCurve;
use super::colour_model::luminance;
use super::settings::DevelopSettings;
use luminances::noise_of_black;
use photosite_core::image::Planes;

/// Applies the part of the tone curve that changes linear light; the encoding of codes comes after it.
pub(super) fn apply(image: &mut Planes, settings: &DevelopSettings) {
    match settings.tone_curve {
        ToneCurve::Linear | ToneCurve::Srgb | ToneCurve::Gamma => {}
        ToneCurve::Filmic => {
            for channel in image.channels_mut() {
                for_each_value(&mut channel.data, |value| *value = filmic::curve(*value));
            }
        }
        ToneCurve::Reinhard => {
            let (key, white) = (settings.tone_key(), settings.tone_white);
            by_luminance(image, settings, |light, black, _| reinhard::shown(light, black, key, white));
        }
        ToneCurve::Log => {
            by_luminance(image, settings, |light, black, _| logarithmic::shown(light, black, settings.tone_bias()));
        }
        ToneCurve::Local => by_luminance(image, settings, |light, black, size| {
            let sigma_px = settings.tone_sigma_px.unwrap_or(0.02 * size[0].max(size[1]) as f64);
            local::shown(light, black, size, [sigma_px, settings.tone_sigma_range()], settings.tone_contrast())
        }),
    }
}

/// Scales every pixel by what `shown` makes of the luminances, given how far noise takes black. What is dark or no number
/// is black.
fn by_luminance(
    image: &mut Planes,
    settings: &DevelopSettings,
    shown: impl FnOnce(&[f32], f32, [usize; 2]) -> Vec<f32>,
) {
    let size = [image.width(), image.height()];
    let mut light = luminance(image, settings.colour_space);
    let black = noise_of_black(&light);
    // Not-a-number becomes 0, too.
    for_each_value(&mut light, |value| *value = if *value > 0.0 { value.min(1e30) } else { 0.0 });
    let shown = shown(&light, black, size);
    for channel in image.channels_mut() {
        for_each_row(&mut channel.data, size[0], |y, row| {
            let [light, shown] = [&light, &shown].map(|plane| &plane[y * size[0]..]);
            for ((value, light), shown) in row.iter_mut().zip(light).zip(shown) {
                *value = if *light > 0.0 { (*value * (shown / light)).max(0.0) } else { 0.0 };
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::colour::ColourSpace;
    use photosite_core::image::Channel;
    use photosite_core::math::philox::Philox;
    use rand::RngExt;
    use rand_distr::StandardNormal;

    /// An image of four decades, with a black pixel and one that is no number.
    fn image() -> Planes {
        let plane = |name: &str, factor: f32| {
            let value = |i: i32| factor * 10f32.powf(i as f32 / 10.0 - 3.0);
            let data = (0..40).map(value).chain([0.0, f32::NAN]).collect();
            Channel { name: name.to_owned(), data }
        };
        Planes::new(7, 6, vec![plane("R", 1.0), plane("G", 0.5), plane("B", 0.25)]).expect("right sizes")
    }

    /// An image of 64 × 64 pixels, a quarter of it white at `white`, the rest black with the noise σ of a sensor.
    fn noisy_black(sigma: f32, white: f32) -> Planes {
        let plane = |name: &str, key: u64| {
            let mut random = Philox::new(9, key);
            let value = |i: usize| {
                let noise: f32 = random.sample(StandardNormal);
                if i < 1024 { white } else { sigma * noise }
            };
            Channel { name: name.to_owned(), data: (0..4096).map(value).collect() }
        };
        Planes::new(64, 64, vec![plane("R", 0), plane("G", 1), plane("B", 2)]).expect("right sizes")
    }

    #[test]
    fn noisy_blacks_stay_black() {
        for tone_curve in [ToneCurve::Filmic, ToneCurve::Reinhard, ToneCurve::Log, ToneCurve::Local] {
            for sigma in [1e-4, 1e-3, 1e-2] {
                let settings = DevelopSettings { tone_curve, ..DevelopSettings::default() };
                let mut found = noisy_black(sigma, 1.0);
                apply(&mut found, &settings);
                let white = found.plane("G").expect("there")[500];
                for value in found.channels().iter().flat_map(|channel| &channel.data[1024..]) {
                    // Curves rise, so that nothing that is darker than white reaches it, and black is their least value.
                    assert!((0.0..white).contains(value), "{tone_curve:?}, σ = {sigma}: {value} of {white}");
                }
                let mean = found.plane("G").expect("there")[1024..].iter().sum::<f32>() / 3072.0;
                assert!(mean < 0.1 * white, "{tone_curve:?}, σ = {sigma}: black is {mean} of {white} on average");
            }
        }
    }

    #[test]
    fn curves_rise_keep_chromaticities_and_end_at_white() {
        for tone_curve in [ToneCurve::Reinhard, ToneCurve::Log, ToneCurve::Local] {
            let settings = DevelopSettings { tone_curve, ..DevelopSettings::default() };
            let mut found = image();
            apply(&mut found, &settings);
            let [r, g, b] = ["R", "G", "B"].map(|name| found.plane(name).expect("there"));
            for i in 0..40 {
                assert!((g[i] / r[i] - 0.5).abs() < 1e-5 && (b[i] / r[i] - 0.25).abs() < 1e-5, "{tone_curve:?} {i}");
                assert!(i == 0 || r[i] > r[i - 1], "{tone_curve:?} {i}: {} {}", r[i - 1], r[i]);
            }
            assert_eq!([r[40], r[41]], [0.0, 0.0], "{tone_curve:?}");
            if tone_curve != ToneCurve::Local {
                let white = luminance(&found, ColourSpace::Srgb)[39];
                assert!((white - 1.0).abs() < 1e-5, "{tone_curve:?}: {white}");
            }
        }
    }

    #[test]
    fn darkness_stays_dark() {
        for tone_curve in [ToneCurve::Filmic, ToneCurve::Reinhard, ToneCurve::Log, ToneCurve::Local] {
            let mut dark = Planes::zeros(3, 2, ["Y"]);
            apply(&mut dark, &DevelopSettings { tone_curve, ..DevelopSettings::default() });
            assert_eq!(dark, Planes::zeros(3, 2, ["Y"]), "{tone_curve:?}");
        }
    }
}
