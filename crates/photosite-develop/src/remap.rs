//! An image that is taken from places of another one, as `cv2.remap` does, by the kernels of resizing.

use glam::DVec2;

use super::choices::ResizeFilter;
use super::resampling::{Taps, taken_from};
use super::resize::kernel;
use photosite_core::image::Planes;

/// Pixels that the widest kernel reaches.
const MOST: usize = 8;

/// Weights of as many pixels as a kernel reaches.
#[derive(Clone, Copy)]
struct Weights {
    of: [f32; MOST],
    count: usize,
}

impl AsRef<[f32]> for Weights {
    fn as_ref(&self) -> &[f32] {
        &self.of[..self.count]
    }
}

/// Image of `size_px` columns and rows, each pixel of which is found in `image` where `source` says; black where it
/// says nothing. Positions are continuous, from the corners; beyond the edges the last pixel repeats.
pub fn remap(
    image: &Planes,
    size_px: [usize; 2],
    filter: ResizeFilter,
    source: impl Fn(DVec2) -> Option<DVec2> + Sync,
) -> Planes {
    taken_from(image, false, size_px, source, |place| taps(filter, place))
}

/// Taps of a place, in coordinates that are whole at pixel centres.
fn taps(filter: ResizeFilter, place: f64) -> Taps<Weights> {
    let mut weights = Weights { of: [0.0; MOST], count: 1 };
    let Some((kernel, reach)) = kernel(filter) else {
        weights.of[0] = 1.0;
        return ((place + 0.5).floor() as i64, weights);
    };
    let first = place.floor() as i64 - reach as i64 + 1;
    weights.count = 2 * reach as usize;
    let at = |i: usize| kernel((first + i as i64) as f64 - place);
    let sum: f64 = (0..weights.count).map(at).sum();
    for i in 0..weights.count {
        weights.of[i] = (at(i) / sum) as f32;
    }
    (first, weights)
}

#[cfg(test)]
mod tests {
    use rstest::rstest;

    use super::*;
    use photosite_core::image::Channel;

    /// Values of a slope are those of a place nearby: of the nearest pixel, or by x(1 − x)(2x − 1)/2 px away under
    /// cubic convolution with a = −¾, at most 0.0481; by up to 0.0146 px under Lanczos' window.
    #[rstest]
    #[case(ResizeFilter::Nearest, 0.5)]
    #[case(ResizeFilter::Linear, 0.0)]
    #[case(ResizeFilter::Cubic, 0.0482)]
    #[case(ResizeFilter::Lanczos, 0.0147)]
    fn values_are_found_where_they_are_looked_for(#[case] filter: ResizeFilter, #[case] away_px: f64) {
        let value = |p: DVec2| 0.3 + 0.1 * p.x + 0.03 * p.y;
        let centre = |i: usize| DVec2::new((i % 20) as f64 + 0.5, (i / 20) as f64 + 0.5);
        let data = (0..20 * 16).map(|i| value(centre(i)) as f32).collect();
        let image = Planes::new(20, 16, vec![Channel { name: "Y".to_owned(), data }]).expect("right size");
        let source = |p: DVec2| (p.x < 8.0).then(|| DVec2::new(5.0 + 0.93 * p.x, 4.0 + 1.1 * p.y));
        let found = remap(&image, [9, 7], filter, source);
        for (i, found) in found.channels()[0].data.iter().enumerate() {
            let position = DVec2::new((i % 9) as f64 + 0.5, (i / 9) as f64 + 0.5);
            let wanted = source(position).map_or(0.0, value);
            // Sums of 64 products in f32 of values below 4.
            assert!(
                (f64::from(*found) - wanted).abs() <= away_px * (0.1 + 0.03) + 2e-6,
                "{position}: {found} {wanted}"
            );
        }
    }

    #[test]
    fn a_place_at_a_pixel_has_its_value() {
        let data = vec![0.25, 0.5, 0.125, 1.0];
        let image = Planes::new(2, 2, vec![Channel { name: "Y".to_owned(), data }]).expect("right size");
        for filter in [ResizeFilter::Nearest, ResizeFilter::Linear, ResizeFilter::Cubic, ResizeFilter::Lanczos] {
            let same = remap(&image, [2, 2], filter, Some);
            // sin π is 1e-16, not 0.
            let differs = same.channels()[0].data.iter().zip(&image.channels()[0].data);
            assert!(differs.into_iter().all(|(a, b)| (a - b).abs() < 1e-6), "{filter:?} {same:?}");
        }
    }
}
