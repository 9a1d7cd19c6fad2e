//! Tone: how scene light becomes the light of a display, one file a curve.
//!
//! Filmic bends every component. The others find what luminance is shown of a pixel's luminance, and scale its
//! components by the ratio of both, so that chromaticities stay.

mod fast_bilateral;
mod filmic;
mod local;
mod logarithmic;
mod luminances;
mod reinhard;

use rayon::prelude::*;

use super::choices::ToneCurve;
use super::colour_model::luminance;
use super::settings::DevelopSettings;
use photosite_core::image::Planes;

/// Applies the part of the tone curve that changes linear light; the encoding of codes comes after it.
pub(super) fn apply(picture: &mut Planes, settings: &DevelopSettings) {
    match settings.tone_curve {
        ToneCurve::Linear | ToneCurve::Srgb | ToneCurve::Gamma => {}
        ToneCurve::Filmic => {
            for channel in picture.channels_mut() {
                channel.data.par_iter_mut().for_each(|value| *value = filmic::curve(*value));
            }
        }
        ToneCurve::Reinhard => {
            by_luminance(picture, settings, |light, _| reinhard::shown(light, settings.tone_key(), settings.tone_white))
        }
        ToneCurve::Log => by_luminance(picture, settings, |light, _| logarithmic::shown(light, settings.tone_bias())),
        ToneCurve::Local => by_luminance(picture, settings, |light, size| {
            let sigma_px = settings.tone_sigma_px.unwrap_or(0.02 * size[0].max(size[1]) as f64);
            local::shown(light, size, sigma_px, settings.tone_sigma_range(), settings.tone_contrast())
        }),
    }
}

/// Scales every pixel by what `shown` makes of its luminance. What is dark or no number is black.
fn by_luminance(picture: &mut Planes, settings: &DevelopSettings, shown: impl FnOnce(&[f32], [usize; 2]) -> Vec<f32>) {
    let size = [picture.width(), picture.height()];
    let mut light = luminance(picture, settings.colour_space);
    // Not-a-number becomes 0, too.
    light.par_iter_mut().for_each(|value| *value = if *value > 0.0 { value.min(1e30) } else { 0.0 });
    let shown = shown(&light, size);
    for channel in picture.channels_mut() {
        channel.data.par_iter_mut().zip(&light).zip(&shown).for_each(|((value, light), shown)| {
            *value = if *light > 0.0 { *value * (shown / light) } else { 0.0 };
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::colour::ColourSpace;
    use photosite_core::image::Channel;

    /// A picture of four decades, with a black pixel and one that is no number.
    fn picture() -> Planes {
        let plane = |name: &str, factor: f32| {
            let value = |i: i32| factor * 10f32.powf(i as f32 / 10.0 - 3.0);
            let data = (0..40).map(value).chain([0.0, f32::NAN]).collect();
            Channel { name: name.to_owned(), data }
        };
        Planes::new(7, 6, vec![plane("R", 1.0), plane("G", 0.5), plane("B", 0.25)]).expect("right sizes")
    }

    #[test]
    fn curves_rise_keep_chromaticities_and_end_at_white() {
        for tone_curve in [ToneCurve::Reinhard, ToneCurve::Log, ToneCurve::Local] {
            let settings = DevelopSettings { tone_curve, ..DevelopSettings::default() };
            let mut found = picture();
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
