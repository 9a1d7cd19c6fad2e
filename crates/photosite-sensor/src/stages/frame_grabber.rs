//! The frame grabber: samples of the analogue image at places that need not be those of the pixels.

use photosite_raw::PixelArea;

use crate::model::{FrameGrabber, SensorModel, SignalInterpolation};

/// Pixels about a sample along an axis: the first one, how far it is past it, 0 to 1, and the next one.
type Taps = (usize, f64, usize);

impl FrameGrabber {
    /// Pixels in a sample, across and down, of an image with these columns and rows of pixels.
    pub fn pixels_per_sample(&self, pixels: [usize; 2]) -> [f64; 2] {
        [0, 1].map(|axis| pixels[axis] as f64 / self.size[axis] as f64)
    }

    /// Taps of the i-th of `count` samples of a row of `pixels` pixels, whose centres are at i + ½.
    fn taps(&self, i: usize, pixels: usize, count: usize) -> Taps {
        let place = (i as f64 + 0.5) * pixels as f64 / count as f64;
        let last = pixels - 1;
        match self.interpolation {
            SignalInterpolation::Nearest => {
                let pixel = (place as usize).min(last);
                (pixel, 0.0, pixel)
            }
            SignalInterpolation::Linear => {
                let from_first = (place - 0.5).clamp(0.0, last as f64);
                let first = from_first as usize;
                (first, from_first - first as f64, (first + 1).min(last))
            }
        }
    }
}

/// Sampling of the image that lies in an area of all that is read out.
pub(crate) struct Sampling<'a> {
    grabber: &'a FrameGrabber,
    area: PixelArea,
}

impl<'a> Sampling<'a> {
    /// Sampling by a sensor's frame grabber; `None` where the samples are the pixels.
    pub(crate) fn new(sensor: &'a SensorModel, area: PixelArea) -> Option<Self> {
        sensor.frame_grabber.as_ref().map(|grabber| Self { grabber, area })
    }

    /// Pixels in a sample, across and down.
    pub(crate) fn pixels_per_sample(&self) -> [f64; 2] {
        self.grabber.pixels_per_sample([self.area.width, self.area.height])
    }

    /// Samples values, and the length and number of their rows. Rows of `values` have `width` values, of which each
    /// pixel has `samples`.
    pub(crate) fn apply(&self, values: &[f32], [width, samples]: [usize; 2]) -> (Vec<f32>, [usize; 2]) {
        let Self { grabber, area } = self;
        let [columns, rows] = grabber.size;
        let across: Vec<Taps> = (0..columns).map(|i| grabber.taps(i, area.width, columns)).collect();
        let value = |x: usize, y: usize, sample: usize| {
            f64::from(values[(area.y + y) * width + (area.x + x) * samples + sample])
        };
        let mix = |(first, part, next): Taps, of: &dyn Fn(usize) -> f64| of(first) * (1.0 - part) + of(next) * part;
        let mut sampled = Vec::with_capacity(columns * rows * samples);
        for down in (0..rows).map(|j| grabber.taps(j, area.height, rows)) {
            for &across in &across {
                let of_detector = |sample| mix(down, &|y| mix(across, &|x| value(x, y, sample))) as f32;
                sampled.extend((0..samples).map(of_detector));
            }
        }
        (sampled, [columns * samples, rows])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AREA: PixelArea = PixelArea { x: 1, y: 0, width: 4, height: 2 };
    const VALUES: [f32; 10] = [99.0, 0.0, 4.0, 8.0, 12.0, 99.0, 100.0, 104.0, 108.0, 112.0];

    fn sample(size: [usize; 2], interpolation: SignalInterpolation) -> Vec<f32> {
        Sampling { grabber: &FrameGrabber { size, interpolation }, area: AREA }.apply(&VALUES, [5, 1]).0
    }

    #[test]
    fn as_many_samples_are_the_pixels() {
        for interpolation in [SignalInterpolation::Nearest, SignalInterpolation::Linear] {
            let pixels = sample([4, 2], interpolation);
            assert_eq!(pixels, [0.0, 4.0, 8.0, 12.0, 100.0, 104.0, 108.0, 112.0]);
        }
    }

    /// Expected by hand: places 0.25, 0.75 … of pixels 4 apart, whose centres are at 0.5, 1.5 …; rows at ⅓, 1 and 5/3
    /// of two.
    #[test]
    fn samples_lie_where_the_equation_says() {
        let linear = sample([8, 1], SignalInterpolation::Linear);
        assert_eq!(linear, [50.0, 51.0, 53.0, 55.0, 57.0, 59.0, 61.0, 62.0]);
        assert_eq!(sample([2, 1], SignalInterpolation::Linear), [52.0, 60.0]);
        assert_eq!(sample([8, 2], SignalInterpolation::Nearest)[..8], [0.0, 0.0, 4.0, 4.0, 8.0, 8.0, 12.0, 12.0]);
        assert_eq!(sample([3, 2], SignalInterpolation::Nearest)[..3], [0.0, 8.0, 12.0]);
        let rows: Vec<f32> = sample([4, 3], SignalInterpolation::Linear).into_iter().step_by(4).collect();
        assert_eq!(rows, [0.0, 50.0, 100.0]);
    }

    #[test]
    fn detectors_of_a_pixel_stay_apart() {
        let grabber = FrameGrabber { size: [4, 1], interpolation: SignalInterpolation::Linear };
        let area = PixelArea { x: 0, y: 0, width: 2, height: 1 };
        let (sampled, size) = Sampling { grabber: &grabber, area }.apply(&[0.0, 10.0, 4.0, 30.0], [4, 2]);
        assert_eq!((&sampled[..], size), (&[0.0, 10.0, 1.0, 15.0, 3.0, 25.0, 4.0, 30.0][..], [8, 1]));
    }
}
