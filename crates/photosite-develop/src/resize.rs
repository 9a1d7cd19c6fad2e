//! Resizing: an image, or its middle, on more or fewer pixels.
//!
//! Pixel i of n takes the place s = a + (i + ½)·d − ½ of the image, in coordinates that are whole at pixel centres,
//! with d pixels of the image in one of its own from a on; OpenCV's `resize` has it so, too. The pixels around s are
//! weighted by k(j − s), with a sum of 1; beyond the edges the last pixel repeats. Along rows first, then along columns.
//!
//! | filter | k(x) | pixels | as OpenCV has it |
//! |---|---|---|---|
//! | nearest | the pixel ⌊s + ½⌋ | 1 | `INTER_NEAREST_EXACT` |
//! | linear | 1 − \|x\| | 2 | `INTER_LINEAR` |
//! | cubic | cubic convolution, a = −¾ ([Keys81](photosite_core::references#keys81)) | 4 | `INTER_CUBIC` |
//! | lanczos | sinc(x)·sinc(x/4) ([Duchon79](photosite_core::references#duchon79)) | 8 | `INTER_LANCZOS4` |
//!
//! Where an image gets smaller and is to have no aliases, k(x/d) takes the place of k(x), over d times as many pixels.

use std::f64::consts::PI;

use photosite_core::rows::for_each_row;

use super::choices::ResizeFilter;
use super::settings::DevelopSettings;
use photosite_core::image::{Channel, Planes};

/// Resizing of an image to other pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resize {
    /// Columns and rows of the image.
    from: [usize; 2],
    /// Columns and rows of the resized image.
    pub(super) to: [usize; 2],
    /// Corner of the part that is resized, pixels from the image's corner.
    pub(super) first: [f64; 2],
    /// Pixels of the image in one of the resized image, across and down.
    pub(super) per_pixel: [f64; 2],
    filter: ResizeFilter,
    antialias: bool,
}

impl Resize {
    /// Resizing that the settings ask for, of an image with these columns and rows; `None` where it stays as it is.
    pub(super) fn new(from: [usize; 2], settings: &DevelopSettings) -> Option<Self> {
        if !settings.resizes() {
            return None;
        }
        let to = settings.resize_px.unwrap_or(from);
        let part = from.map(|n| n as f64 / settings.digital_zoom);
        Some(Self {
            from,
            to,
            first: [0, 1].map(|axis| 0.5 * (from[axis] as f64 - part[axis])),
            per_pixel: [0, 1].map(|axis| part[axis] / to[axis] as f64),
            filter: settings.resize_filter.unwrap_or_default(),
            antialias: settings.resize_antialias.unwrap_or(true),
        })
    }

    /// The image on its new pixels.
    pub(super) fn apply(&self, image: Planes) -> Planes {
        let [across, down] = [0, 1].map(|axis| self.taps(axis));
        let resized = |channel: Channel| {
            let wide = along_rows(&channel.data, self.from[0], &across);
            Channel { data: along_columns(&wide, self.to[0], &down), ..channel }
        };
        let channels = image.into_channels().into_iter().map(resized).collect();
        Planes::new(self.to[0], self.to[1], channels).expect("planes have the size that is asked for")
    }

    /// Taps along an axis: for every new pixel, the pixels of the image that it takes, with their weights.
    fn taps(&self, axis: usize) -> Vec<Vec<(usize, f32)>> {
        let (n, first, step) = (self.from[axis], self.first[axis], self.per_pixel[axis]);
        let wider = if self.antialias { step.max(1.0) } else { 1.0 };
        let of = |i: usize| {
            let place = first + (i as f64 + 0.5) * step - 0.5;
            let Some((kernel, reach)) = kernel(self.filter) else {
                return vec![((place + 0.5).floor().clamp(0.0, (n - 1) as f64) as usize, 1.0)];
            };
            let reach = reach * wider;
            let (low, high) = ((place - reach).floor() as i64 + 1, (place + reach).ceil() as i64 - 1);
            // Of a place at a pixel centre, the last but one has no weight.
            let weights: Vec<f64> = (low..=high).map(|j| kernel((j as f64 - place) / wider)).collect();
            let sum: f64 = weights.iter().sum();
            let pixel = |j: i64| j.clamp(0, n as i64 - 1) as usize;
            (low..=high).zip(&weights).map(|(j, weight)| (pixel(j), (weight / sum) as f32)).collect()
        };
        (0..self.to[axis]).map(of).collect()
    }
}

/// Weight by distance.
pub(super) type Weight = fn(f64) -> f64;

/// Kernel: the weight by distance, and its reach; `None` of the nearest pixel.
pub(super) fn kernel(filter: ResizeFilter) -> Option<(Weight, f64)> {
    match filter {
        ResizeFilter::Nearest => None,
        ResizeFilter::Linear => Some((|x| 1.0 - x.abs(), 1.0)),
        ResizeFilter::Cubic => Some((cubic, 2.0)),
        ResizeFilter::Lanczos => Some((|x| sinc(x) * sinc(x / 4.0), 4.0)),
    }
}

fn cubic(x: f64) -> f64 {
    const A: f64 = -0.75;
    let x = x.abs();
    if x <= 1.0 { ((A + 2.0) * x - (A + 3.0)) * x * x + 1.0 } else { ((A * x - 5.0 * A) * x + 8.0 * A) * x - 4.0 * A }
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) }
}

fn along_rows(plane: &[f32], width: usize, taps: &[Vec<(usize, f32)>]) -> Vec<f32> {
    let mut result = vec![0.0; plane.len() / width.max(1) * taps.len()];
    for_each_row(&mut result, taps.len(), |y, to| {
        let from = &plane[y * width..][..width];
        for (to, taps) in to.iter_mut().zip(taps) {
            *to = taps.iter().map(|&(x, weight)| weight * from[x]).sum();
        }
    });
    result
}

fn along_columns(plane: &[f32], width: usize, taps: &[Vec<(usize, f32)>]) -> Vec<f32> {
    let mut result = vec![0.0; width * taps.len()];
    for_each_row(&mut result, width, |y, to| {
        for &(y, weight) in &taps[y] {
            to.iter_mut().zip(&plane[y * width..][..width]).for_each(|(to, from)| *to += weight * from);
        }
    });
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILTERS: [ResizeFilter; 4] =
        [ResizeFilter::Nearest, ResizeFilter::Linear, ResizeFilter::Cubic, ResizeFilter::Lanczos];

    fn resized(line: &[f32], width: usize, settings: &DevelopSettings) -> Vec<f32> {
        let channel = Channel { name: "Y".to_owned(), data: line.to_vec() };
        let image = Planes::new(line.len(), 1, vec![channel]).expect("right size");
        let settings = DevelopSettings { resize_px: Some([width, 1]), ..settings.clone() };
        let resize = Resize::new([line.len(), 1], &settings).expect("another size");
        resize.apply(image).channels()[0].data.clone()
    }

    #[test]
    fn even_images_stay_even_and_the_same_size_changes_nothing() {
        let line: Vec<f32> = (0..13).map(|i| ((i * 7) % 5) as f32).collect();
        for filter in FILTERS {
            let settings = DevelopSettings { resize_filter: Some(filter), ..DevelopSettings::default() };
            for width in [1, 5, 13, 40] {
                assert!(resized(&[0.7; 13], width, &settings).iter().all(|v| (v - 0.7).abs() < 1e-6), "{filter:?}");
            }
            let same = resized(&line, 13, &settings);
            // sin(π·n) of a whole n is as small as a double's last digit.
            assert!(same.iter().zip(&line).all(|(a, b)| (a - b).abs() < 1e-6), "{filter:?}: {same:?}");
        }
    }

    #[test]
    fn weights_are_those_of_the_definitions() {
        let point = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let at = |filter: ResizeFilter| {
            let settings = DevelopSettings { resize_filter: Some(filter), ..DevelopSettings::default() };
            // Pixel 9 of 20 lies at 4.25.
            resized(&point, 20, &settings)[9]
        };
        assert_eq!(at(ResizeFilter::Nearest), 1.0);
        assert!((at(ResizeFilter::Linear) - 0.75).abs() < 1e-6);
        // 1.25·¼³ − 2.25·¼² + 1.
        assert!((at(ResizeFilter::Cubic) - 0.878_906_25).abs() < 1e-6);
    }

    #[test]
    fn fine_stripes_become_grey_unless_aliases_are_wanted() {
        let stripes: Vec<f32> = (0..60).map(|i| (i % 2) as f32).collect();
        let settings = DevelopSettings { resize_filter: Some(ResizeFilter::Linear), ..DevelopSettings::default() };
        // Every third pixel of stripes of one is a stripe again.
        let aliases = resized(&stripes, 20, &DevelopSettings { resize_antialias: Some(false), ..settings.clone() });
        assert!(aliases.windows(2).all(|pair| (pair[0] - pair[1]).abs() == 1.0), "{aliases:?}");
        let smooth = resized(&stripes, 20, &settings);
        // Triangles of three pixels to either side weigh the stripes 4/9 and 5/9.
        assert!(smooth[1..19].iter().all(|v| (v - 0.5).abs() < 0.06), "{smooth:?}");
    }

    #[test]
    fn zooming_shows_the_middle() {
        let line: Vec<f32> = (0..16).map(|i| i as f32).collect();
        let settings = DevelopSettings {
            digital_zoom: 2.0,
            resize_filter: Some(ResizeFilter::Linear),
            ..DevelopSettings::default()
        };
        let zoomed = resized(&line, 16, &settings);
        let expected: Vec<f32> = (0..16).map(|i| 4.0 + (i as f32 + 0.5) / 2.0 - 0.5).collect();
        assert_eq!(zoomed, expected);
    }
}
