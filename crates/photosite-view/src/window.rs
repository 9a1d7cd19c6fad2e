//! Window of an image that is sent: the pixels that are seen, as fine as the screen shows them.

use hyper::StatusCode;
use rayon::prelude::*;
use serde::Serialize;

use super::answer::Failure;
use super::sent_image::{SentImage, Values};

/// Most pixels of an image that is sent whole to a screen.
const WHOLE: usize = 1 << 20;

/// Window of an image: the pixels that are seen, and how fine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Window {
    /// First columns and rows, and those behind the last; all of them where it is left out.
    pub(super) view: Option<[usize; 4]>,
    /// Columns and rows of the screen that shows it: pixels of an image that is larger are averaged.
    pub(super) screen: Option<[usize; 2]>,
    /// Step in columns and rows between the pixels that are sent, without averaging.
    pub(super) step: Option<usize>,
}

/// Place in the image of the pixels that are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(super) struct SentPixels {
    /// Columns and rows of the whole image.
    pub(super) full: [usize; 2],
    /// First column and row that are sent.
    pub(super) at: [usize; 2],
    /// Columns and rows from one pixel to the next.
    pub(super) step: usize,
    /// Whether a pixel that is sent is the mean of all that it stands for.
    pub(super) is_mean: bool,
}

impl Window {
    /// Pixels of an image that are sent. `is_numbered` says that its values are indices, of which there is no mean.
    pub(super) fn of(&self, image: SentImage, is_numbered: bool) -> Result<(SentImage, SentPixels), Failure> {
        let full = image.size;
        let [width, height] = full;
        let is_small = width * height <= WHOLE;
        let [x0, y0, x1, y1] = match (self.view, self.screen) {
            (Some([x0, y0, x1, y1]), None) => [x0, y0, x1.min(width), y1.min(height)],
            (Some([x0, y0, x1, y1]), Some(_)) if !is_small => [x0, y0, x1.min(width), y1.min(height)],
            (Some(_), Some(_)) | (None, _) => [0, 0, width, height],
        };
        if x0 >= x1 || y0 >= y1 {
            let message = format!("view: there is no pixel of {width} × {height} in it");
            return Err(Failure::new(StatusCode::BAD_REQUEST, message));
        }
        let (step, is_mean) = match (self.step, self.screen) {
            (Some(step), _) => (step, false),
            (None, Some(screen)) if !is_small => (step_for([x1 - x0, y1 - y0], screen), !is_numbered),
            (None, Some(_) | None) => (1, false),
        };
        // Means are those of the same pixels, wherever the view begins.
        let at = if is_mean { [x0 / step * step, y0 / step * step] } else { [x0, y0] };
        let place = SentPixels { full, at, step, is_mean: is_mean && step > 1 };
        if place.at == [0, 0] && [x1, y1] == full && step == 1 {
            return Ok((image, place));
        }
        let size = [(x1 - at[0]).div_ceil(step), (y1 - at[1]).div_ceil(step)];
        let n = image.channels.len();
        let values = match image.values {
            // Codes are not negative, so that adding a half and cutting rounds them.
            Values::U8(values) => Values::U8(place.take(&values, n, size, |sum, count| (sum / count + 0.5) as u8)),
            Values::U16(values) => Values::U16(place.take(&values, n, size, |sum, count| (sum / count + 0.5) as u16)),
            Values::F32(values) => Values::F32(place.take(&values, n, size, |sum, count| (sum / count) as f32)),
        };
        Ok((SentImage { size, values, ..image }, place))
    }
}

/// Columns and rows that share a pixel of the screen: a power of two, in which the filters of mosaics repeat, too.
fn step_for(view: [usize; 2], screen: [usize; 2]) -> usize {
    let ratio = |i: usize| view[i] as f64 / screen[i].max(1) as f64;
    let exponent = ratio(0).max(ratio(1)).log2().round().max(0.0);
    1 << exponent.min(12.0) as usize
}

impl SentPixels {
    /// The values of `n` channels, row by row; `mean` makes one of a sum and the number of values in it.
    fn take<T: Copy + Into<f64> + Send + Sync>(
        &self,
        values: &[T],
        n: usize,
        [columns, rows]: [usize; 2],
        mean: impl Fn(f64, f64) -> T + Sync,
    ) -> Vec<T> {
        let Self { full: [width, height], at: [x0, y0], step, is_mean } = *self;
        let mut taken = vec![values[0]; columns * rows * n];
        taken.par_chunks_mut(columns * n).enumerate().for_each_init(Vec::new, |sums, (row, to)| {
            let row = y0 + row * step;
            let of_row = |y: usize| &values[y * width * n..(y + 1) * width * n];
            for (pixel, to) in of_row(row)[x0 * n..].chunks(step * n).zip(to.chunks_mut(n)) {
                to.copy_from_slice(&pixel[..n]);
            }
            if !is_mean {
                return;
            }
            // The sum of each value and how many are in it.
            sums.clear();
            sums.resize(columns * n, (0.0, 0.0));
            for y in row..(row + step).min(height) {
                for (pixels, sums) in of_row(y)[x0 * n..].chunks(step * n).zip(sums.chunks_mut(n)) {
                    for pixel in pixels.chunks(n) {
                        for ((sum, count), &value) in sums.iter_mut().zip(pixel) {
                            let value: f64 = value.into();
                            // Depth is infinite where there is nothing.
                            if value.is_finite() {
                                (*sum, *count) = (*sum + value, *count + 1.0);
                            }
                        }
                    }
                }
            }
            for (to, &(sum, count)) in to.iter_mut().zip(&*sums) {
                if count > 0.0 {
                    *to = mean(sum, count);
                }
            }
        });
        taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Image of two channels whose values are those of their places.
    fn image([width, height]: [usize; 2]) -> SentImage {
        let values = (0..width * height).flat_map(|i| [(i % width) as f32, (i / width) as f32]).collect();
        let channels = vec!["x".to_owned(), "y".to_owned()];
        SentImage { size: [width, height], channels, unit: "", values: Values::F32(values) }
    }

    fn taken(size: [usize; 2], window: Window, is_numbered: bool) -> ([usize; 2], SentPixels, Vec<f32>) {
        let (image, place) = window.of(image(size), is_numbered).expect("pixels");
        let Values::F32(values) = image.values else { panic!("another type") };
        assert_eq!(values.len(), image.size[0] * image.size[1] * 2);
        (image.size, place, values)
    }

    #[test]
    fn small_images_are_sent_whole_and_parts_as_they_are() {
        let screen = Some([10, 10]);
        let (size, place, _) = taken([400, 300], Window { screen, view: Some([5, 5, 9, 9]), step: None }, false);
        assert_eq!((size, place.at, place.step, place.is_mean), ([400, 300], [0, 0], 1, false));
        let part = Window { view: Some([398, 7, 500, 9]), ..Window::default() };
        let (size, place, values) = taken([400, 300], part, false);
        assert_eq!((size, place.at), ([2, 2], [398, 7]));
        assert_eq!(values, [398.0, 7.0, 399.0, 7.0, 398.0, 8.0, 399.0, 8.0]);
        let few = Window { view: Some([1, 0, 400, 300]), step: Some(199), ..Window::default() };
        let (size, _, values) = taken([400, 300], few, false);
        assert_eq!((size, &values[..6]), ([3, 2], &[1.0, 0.0, 200.0, 0.0, 399.0, 0.0][..]));
        for empty in [[400, 0, 401, 1], [5, 5, 5, 6], [0, 9, 1, 8]] {
            assert!(Window { view: Some(empty), ..Window::default() }.of(image([400, 300]), false).is_err());
        }
    }

    #[test]
    fn large_images_are_as_fine_as_the_screen() {
        let window = |view, screen| Window { view, screen: Some(screen), step: None };
        // 4 columns share a pixel of the screen; the last ones are few.
        let (size, place, values) = taken([2050, 1026], window(None, [512, 400]), false);
        assert_eq!((size, place.step, place.is_mean), ([513, 257], 4, true));
        assert_eq!(values[..4], [1.5, 1.5, 5.5, 1.5]);
        assert_eq!(values[values.len() - 2..], [2048.5, 1024.5]);
        // The view begins where means do.
        let (size, place, values) = taken([2050, 1026], window(Some([7, 9, 1031, 521]), [512, 300]), false);
        assert_eq!((size, place.at, place.step), ([513, 257], [6, 8], 2));
        assert_eq!(values[..2], [6.5, 8.5]);
        // Nothing is finer than the image, and names have no mean.
        assert_eq!(taken([2050, 1026], window(Some([7, 9, 27, 29]), [512, 300]), false).1.step, 1);
        let (_, place, values) = taken([2050, 1026], window(Some([7, 9, 1031, 521]), [512, 300]), true);
        assert_eq!((place.at, place.is_mean, &values[..4]), ([7, 9], false, &[7.0, 9.0, 9.0, 9.0][..]));
    }
}
