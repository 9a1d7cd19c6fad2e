//! Epipolar lines, drawn over the images of a stereo pair side by side.
//!
//! An epipolar plane goes through both cameras; what it holds appears on one line of each image: in rectified ones in
//! the same row (the same column, of cameras one above the other), in the cameras' own on two curves, which their
//! lenses bend. Lines of one colour belong together.

use std::f64::consts::FRAC_PI_2;
use std::io;

use glam::DVec2;

use photosite_calibration::camera_files::StereoPair;
use photosite_core::image::Planes;
use photosite_core::output::Sink;
use photosite_files::plain_png::write_rgb8;

/// Steps along a curve, px: so small that no pixel near it is missed.
const STEP_PX: f64 = 0.1;

/// Dots drawn over an image.
#[derive(Default)]
struct Overlay(Vec<Dot>);

/// Coverage of a pixel by a colour.
struct Dot {
    pixel: usize,
    part: f32,
    colour: [f32; 3],
}

/// Epipolar lines over the images of both cameras, and over the rectified ones.
pub(super) struct EpipolarLines {
    original: [Overlay; 2],
    rectified: [Overlay; 2],
}

/// Image with its largest code value.
pub(super) struct Shown<'a> {
    pub(super) planes: &'a Planes,
    pub(super) full_scale: f32,
}

impl EpipolarLines {
    /// Lines of `count` epipolar planes, evenly spaced over the rows of the rectified images.
    pub(super) fn new(pair: &StereoPair<'_>, count: u32) -> Self {
        let mut lines = Self { original: Default::default(), rectified: Default::default() };
        let [columns, rows] = pair.resolution().map(f64::from);
        let along = if pair.is_vertical { rows } else { columns };
        for number in 0..count {
            let (line, colour) = (line(pair, number, count), colour(number, count));
            let points = steps(0.0, along, STEP_PX)
                .map(|place| Some(if pair.is_vertical { DVec2::new(line, place) } else { DVec2::new(place, line) }));
            let points: Vec<_> = points.collect();
            for overlay in &mut lines.rectified {
                overlay.stroke(pair.resolution(), points.iter().copied(), colour);
            }
            for (i, overlay) in lines.original.iter_mut().enumerate() {
                overlay.stroke(pair.cameras[i].resolution, original_curve(pair, i, line, STEP_PX), colour);
            }
        }
        lines
    }

    /// Writes the cameras' images side by side, with their lines.
    pub(super) fn write_original(&self, images: [Shown<'_>; 2], to: &mut dyn Sink) -> io::Result<()> {
        write_side_by_side(images, &self.original, to)
    }

    /// Writes the rectified images side by side, with their lines.
    pub(super) fn write_rectified(&self, images: [Shown<'_>; 2], to: &mut dyn Sink) -> io::Result<()> {
        write_side_by_side(images, &self.rectified, to)
    }
}

/// Row (or column, for a vertical pair) of the rectified images on which an epipolar plane appears.
fn line(pair: &StereoPair<'_>, number: u32, count: u32) -> f64 {
    let [columns, rows] = pair.resolution().map(f64::from);
    let across = if pair.is_vertical { columns } else { rows };
    (f64::from(number) + 0.5) * across / f64::from(count)
}

/// Points of an epipolar plane in the image of camera `number` of a pair, about `step_px` apart; `None` where the
/// camera does not see them.
fn original_curve<'a>(
    pair: &'a StereoPair<'_>,
    number: usize,
    line: f64,
    step_px: f64,
) -> impl Iterator<Item = Option<DVec2>> + use<'a> {
    let (camera, view) = (pair.cameras[number], pair.views()[number]);
    let [columns, rows] = camera.resolution.map(f64::from);
    // An angle of 1/f is a pixel in the middle, and less than some pixels at the edge.
    let f = [camera.intrinsics.fy.abs(), columns, rows].into_iter().fold(camera.intrinsics.fx.abs(), f64::max);
    let angles = steps(-FRAC_PI_2, FRAC_PI_2, step_px / f);
    angles.map(move |angle| view.source_of(pair.in_epipolar_plane(line, angle)))
}

/// Curves of `count` epipolar planes, evenly spaced over the rows of the rectified images, as points one pixel apart in
/// the image of camera `number` of a pair.
pub(super) fn original_curves(pair: &StereoPair<'_>, number: usize, count: u32) -> Vec<Vec<Option<DVec2>>> {
    (0..count).map(|plane| original_curve(pair, number, line(pair, plane, count), 1.0).collect()).collect()
}

impl Overlay {
    /// Draws a line one pixel wide along points that follow each other closely.
    fn stroke(&mut self, resolution: [u32; 2], points: impl Iterator<Item = Option<DVec2>>, colour: [f32; 3]) {
        let [width, height] = resolution.map(|n| n as usize);
        let mut covered = std::collections::BTreeMap::<usize, f32>::new();
        for point in points.flatten() {
            let corner = (point - 0.5).floor();
            for (right, below) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                let pixel = corner + DVec2::new(right, below);
                if pixel.x < 0.0 || pixel.y < 0.0 || pixel.x >= width as f64 || pixel.y >= height as f64 {
                    continue;
                }
                let part = (1.0 - (pixel + 0.5 - point).length()).max(0.0) as f32;
                let most = covered.entry(pixel.y as usize * width + pixel.x as usize).or_default();
                *most = most.max(part);
            }
        }
        self.0.extend(covered.into_iter().map(|(pixel, part)| Dot { pixel, part, colour }));
    }
}

/// Values from `first` to `last` in equal steps of at most `step`.
fn steps(first: f64, last: f64, step: f64) -> impl Iterator<Item = f64> {
    let count = ((last - first) / step).ceil().max(1.0) as u64;
    (0..=count).map(move |i| first + (last - first) * i as f64 / count as f64)
}

/// Colour `number` of `count` hues around the circle, R, G and B from 0 to 1.
fn colour(number: u32, count: u32) -> [f32; 3] {
    let hue = 6.0 * number as f32 / count as f32;
    [5.0, 3.0, 1.0].map(|n| {
        let k: f32 = (n + hue) % 6.0;
        1.0 - k.min(4.0 - k).clamp(0.0, 1.0)
    })
}

fn write_side_by_side(images: [Shown<'_>; 2], overlays: &[Overlay; 2], to: &mut dyn Sink) -> io::Result<()> {
    let width: usize = images.iter().map(|shown| shown.planes.width()).sum();
    let height = images.iter().map(|shown| shown.planes.height()).max().unwrap_or(0);
    let mut bytes = vec![0; 3 * width * height];
    let mut left = 0;
    for (Shown { planes, full_scale }, overlay) in images.iter().zip(overlays) {
        let channels = planes.channels();
        let mut colours: Vec<[f32; 3]> = (0..planes.width() * planes.height())
            // Grey is the same in all three.
            .map(|i| [0, 1, 2].map(|c| channels[c.min(channels.len() - 1)].data[i] / full_scale))
            .collect();
        for Dot { pixel, part, colour } in &overlay.0 {
            let shown = &mut colours[*pixel];
            *shown = [0, 1, 2].map(|c| shown[c] + part * (colour[c] - shown[c]));
        }
        for (y, row) in colours.chunks(planes.width()).enumerate() {
            let start = 3 * (y * width + left);
            let codes = row.as_flattened().iter().map(|value| (255.0 * value).round().clamp(0.0, 255.0) as u8);
            bytes[start..start + 3 * row.len()].iter_mut().zip(codes).for_each(|(byte, code)| *byte = code);
        }
        left += planes.width();
    }
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    write_rgb8([side(width)?, side(height)?], &bytes, to)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hues_go_around_the_circle() {
        let hues: Vec<[f32; 3]> = (0..6).map(|number| colour(number, 6)).collect();
        let wanted = [[1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1], [1, 0, 1]];
        assert_eq!(hues, wanted.map(|hue| hue.map(|part: u8| f32::from(part))));
    }

    #[test]
    fn a_line_covers_what_it_goes_through() {
        let mut overlay = Overlay::default();
        let points = steps(0.0, 8.0, STEP_PX).map(|x| Some(DVec2::new(x, 2.75)));
        overlay.stroke([8, 6], points, [1.0; 3]);
        // Between the centres of rows 2 and 3, nearer to the former by three to one.
        let part = |x: usize, y: usize| overlay.0.iter().find(|dot| dot.pixel == y * 8 + x).map_or(0.0, |dot| dot.part);
        for x in 0..8 {
            assert!((part(x, 2) - 0.75).abs() < 0.01 && (part(x, 3) - 0.25).abs() < 0.01, "{x}");
            assert_eq!((part(x, 1), part(x, 4)), (0.0, 0.0));
        }
    }
}
