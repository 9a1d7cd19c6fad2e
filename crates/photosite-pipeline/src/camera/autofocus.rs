//! Autofocus by contrast, as cameras do it: a part of the image is traced at one place of the sensor after the other,
//! and the place at which it is sharpest is kept.

use std::ops::ControlFlow;

use glam::DAffine3;

use super::capture_camera::{camera_of, pixels};
use photosite_capture::Capture;
use photosite_capture::report::FocusStepReport;
use photosite_core::spectrum::Spectrum;
use photosite_core::{Invalid, Result};
use photosite_transport::film::{FilmResponses, Response};
use photosite_transport::integrator::{RenderJob, RenderSettings, render};
use photosite_transport::optics::{Camera, ContrastAutofocus, Focus, LensDescription, PixelGrid, Sharpness};
use photosite_transport::scene::Scene;

/// Samples of each pixel of the window: the same random numbers at every place of the sensor, so that noise hardly
/// differs from one to the next.
const SAMPLES: u32 = 32;
/// Largest magnification of a lens that does not state its nearest focus distance.
const LARGEST_IMAGE: f64 = 0.1;
/// Largest change of blur between neighbouring places in the first round, px: fine patterns are washed out by more, and
/// would be missed between two places.
const COARSEST_PX: f64 = 3.0;
/// Least change of blur between neighbouring places, px, at which the search ends.
const FINEST_PX: f64 = 0.25;
/// Least contrast that counts, over the contrast that noise alone would show, which is known to a few hundredths.
const LEAST_CONTRAST: f64 = 0.2;
/// Most places that are tried in a round.
const MOST_STEPS: u32 = 1000;
/// Most rounds of a search: each narrows it by half of its steps at least, so that more are never needed.
const MOST_ROUNDS: u32 = 12;

/// Result of a search by contrast: the place of the sensor at which it ends, and the places tried.
pub(crate) struct Search {
    /// Distance of the sensor behind the lens, m.
    pub(crate) image_distance_m: f64,
    /// All places that were tried, in the order of the search.
    pub(crate) steps: Vec<FocusStepReport>,
    /// Whether this is the nearest focus that the lens has, so that the subject may be nearer still.
    pub(crate) is_nearest: bool,
}

/// Looks for the place of the sensor at which the part of the image about a pixel is sharpest, between the focus at
/// infinity and the nearest that the lens has.
pub(crate) fn search(
    capture: &Capture,
    to_world: DAffine3,
    scene: &Scene,
    pixel: [f64; 2],
    how: &ContrastAutofocus,
) -> Result<Search> {
    let refuse = |key: &str, message: &str, help: &str| {
        Err(capture.source().error(Invalid::new(format!("lens.{key}"), message).help(help)))
    };
    let lens = capture.lens();
    if capture.sensor().shutter.scans() {
        return refuse("autofocus", "a line camera has no image whose contrast counts", "write focus_distance_m");
    }
    let f = lens.focal_length_m;
    if f < 0.0 {
        return refuse("autofocus", "a diverging lens has no focus", "write image_distance_mm");
    }
    let nearest_m = lens.min_focus_distance_m.unwrap_or(f * (1.0 + 1.0 / LARGEST_IMAGE));
    let at_nearest = 1.0 / (1.0 / f - 1.0 / nearest_m);
    let [mut low, mut high] = [f, at_nearest];
    // The blur of a place of the sensor that is off by δ is δ/N.
    let pixel_m = capture.sensor().pixel_pitch_m[0] * lens.f_number;
    let coarse = ((high - low) / (COARSEST_PX * pixel_m)).ceil() as u32 + 1;
    let mut count = how.steps.max(coarse.min(MOST_STEPS));
    let window = Window::new(capture, pixel, how.window_px);
    let mut steps = Vec::new();
    let mut best = (f64::NEG_INFINITY, low);
    for round in 0..MOST_ROUNDS {
        let step = (high - low) / f64::from(count - 1);
        let mut is_seen = round > 0;
        for i in 0..count {
            let image_distance_m = low + step * f64::from(i);
            let image = window.trace(capture, to_world, scene, image_distance_m)?;
            let (sharpness, of_noise) = image.sharpness(how.measure);
            is_seen |= sharpness > LEAST_CONTRAST * of_noise;
            steps.push(FocusStepReport { focus_distance_m: image.focus_distance_m, sharpness });
            if sharpness > best.0 {
                best = (sharpness, image_distance_m);
            }
        }
        if !is_seen {
            let message = "what is seen there has no contrast at any focus";
            return refuse("autofocus_px", message, "name another pixel, a larger autofocus.window_px, or a distance");
        }
        if step <= FINEST_PX * pixel_m {
            break;
        }
        [low, high] = [(best.1 - step).max(low), (best.1 + step).min(high)];
        count = how.steps;
    }
    Ok(Search { image_distance_m: best.1, steps, is_nearest: best.1 > at_nearest - FINEST_PX * pixel_m })
}

/// A part of the image, about the pixel that is focused on.
struct Window {
    /// Column and row of its first pixel.
    first: [f64; 2],
    size: [u32; 2],
}

struct WindowImage {
    /// Light of the window's pixels, weighted by the sum of the sensor's responses, row by row.
    values: Vec<f64>,
    /// Mean of the variances that light transport leaves in the values.
    variance: f64,
    width: usize,
    /// Focus distance, m; `None` at infinity.
    focus_distance_m: Option<f64>,
}

impl Window {
    fn new(capture: &Capture, pixel: [f64; 2], window_px: u32) -> Self {
        let image = pixels(capture);
        let size = image.map(|n| n.min(window_px));
        let first = [0, 1].map(|i| {
            let last = f64::from(image[i] - size[i]);
            (pixel[i] - f64::from(size[i]) / 2.0).round().clamp(0.0, last)
        });
        Self { first, size }
    }

    /// Traces the window with the sensor at a distance, without the point spread of the lens, which is the same
    /// everywhere.
    fn trace(
        &self,
        capture: &Capture,
        to_world: DAffine3,
        scene: &Scene,
        image_distance_m: f64,
    ) -> Result<WindowImage> {
        let at = |invalid: Invalid| capture.source().error(invalid.within("lens"));
        let focus = Focus::ImageDistance(image_distance_m);
        let mut lens = LensDescription { focus, point_spread: None, ..capture.lens().clone() };
        let whole = camera_of(&lens, capture.sensor(), to_world, f64::NAN).map_err(at)?;
        lens.intrinsics = Some(whole.intrinsics().on_grid(self.first, [1.0; 2]));
        let grid = PixelGrid { resolution: self.size, pitch_m: capture.sensor().pixel_pitch_m };
        let camera = Camera::new(&lens, &grid, to_world, f64::NAN).map_err(at)?;
        let settings = RenderSettings {
            samples_per_pixel: SAMPLES,
            max_depth: capture.render().max_depth,
            roulette_depth: capture.render().roulette_depth,
            seed: capture.render().seed,
            ..RenderSettings::default()
        };
        let channels = capture.sensor().responses();
        let sum = |lambda| channels.iter().map(|(_, response)| f64::from(response.eval(lambda as f32))).sum();
        let responses = [Response::new("all", Spectrum::from_fn(sum))];
        let job = RenderJob {
            scene,
            camera: &camera,
            transmittance: &capture.lens().transmittance,
            responses: &responses,
            filters: None,
            importance: None,
            resolution: self.size,
            settings: &settings,
            device: None,
        };
        let film = render(&job, FilmResponses::new(&responses), &|_| ControlFlow::Continue(()));
        let [width, height] = self.size.map(|n| n as usize);
        let all = || 0..width * height;
        let variances = film.variances(0, all()).filter(|v| v.is_finite()).map(f64::from);
        let u = whole.focus_distance_m();
        Ok(WindowImage {
            values: film.means(0, all()).map(f64::from).collect(),
            variance: variances.sum::<f64>() / (width * height) as f64,
            width,
            focus_distance_m: u.is_finite().then_some(u),
        })
    }
}

impl WindowImage {
    /// Sharpness of the window at a focus, over the square of its mean, without the contribution of noise; and that
    /// contribution.
    fn sharpness(&self, measure: Sharpness) -> (f64, f64) {
        let mean = self.values.iter().sum::<f64>() / self.values.len() as f64;
        if mean <= 0.0 {
            return (0.0, 0.0);
        }
        // The sum of the squares of the masks' numbers.
        let gain = match measure {
            Sharpness::Variance => 1.0,
            Sharpness::Laplacian => 20.0,
            Sharpness::Gradient => 24.0,
        };
        let of_noise = gain * self.variance / (mean * mean);
        (contrast(&self.values, self.width, measure) / (mean * mean) - of_noise, of_noise)
    }
}

/// Contrast of an image by a measure of sharpness.
fn contrast(values: &[f64], width: usize, measure: Sharpness) -> f64 {
    let height = values.len() / width;
    let variance = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len().max(1) as f64
    };
    let inner = || (1..height.saturating_sub(1)).flat_map(|y| (1..width.saturating_sub(1)).map(move |x| y * width + x));
    match measure {
        Sharpness::Variance => variance(values),
        Sharpness::Laplacian => {
            let at = |i: usize| values[i - 1] + values[i + 1] + values[i - width] + values[i + width] - 4.0 * values[i];
            variance(&inner().map(at).collect::<Vec<_>>())
        }
        Sharpness::Gradient => {
            let at = |i: usize| {
                let [above, below] = [i - width, i + width];
                let across = |row: usize| values[row + 1] - values[row - 1];
                let down =
                    |shift: isize| values[below.wrapping_add_signed(shift)] - values[above.wrapping_add_signed(shift)];
                let x = across(above) + 2.0 * across(i) + across(below);
                let y = down(-1) + 2.0 * down(0) + down(1);
                x * x + y * y
            };
            inner().map(at).sum::<f64>() / inner().count().max(1) as f64
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Case: an edge of the height 1 in six columns: all three measures by hand.
    #[test]
    fn measures_of_an_edge() {
        let values: Vec<f64> = (0..36).map(|i| if i % 6 < 3 { 1.0 } else { 2.0 }).collect();
        let of = |measure| contrast(&values, 6, measure);
        assert!((of(Sharpness::Variance) - 0.25).abs() < 1e-12);
        // Of four inner columns, the two beside the edge have a Laplacian of 1 and −1, and a gradient of 4.
        assert!((of(Sharpness::Laplacian) - 0.5).abs() < 1e-12);
        assert!((of(Sharpness::Gradient) - 8.0).abs() < 1e-12);
    }
}
