//! Distortion and pixels that are not square: moves every pixel to where a lens without distortion shows it on a grid
//! of square pixels, in one step.
//!
//! The grid of square pixels has the pitch of the finer side, as DNG's DefaultScale and dcraw have it: pixels of p_x ×
//! p_y make an image of ⌊columns·p_x/p + ½⌋ × ⌊rows·p_y/p + ½⌋ pixels with p = min(p_x, p_y). Its top-left corner is
//! that of the active area; it ends up to half a pixel within or beyond the opposite one.
//!
//! Staggered rows, those of hexagonal cells, are brought to the columns of that grid in the same step; where it is not
//! asked for, the image has staggered rows, too. Splines of each row come before those across rows, so that every row is
//! taken where its pixels are.
//!
//! What lies beyond the edge of the sensor's image takes its nearest pixel; what a lens cannot see is black.
//!
//! What the settings resize is resized after that, in a step of its own.

use std::array::from_fn;

use glam::DVec2;
use rayon::prelude::*;

use super::resize::Resize;
use super::settings::DevelopSettings;
use photosite_core::cells::shift;
use photosite_core::image::{Channel, Planes};
use photosite_raw::{Distortion, PixelArea, RawMetadata, Undistortion, Warp};

/// Most pixels along a side of an image.
const LARGEST_SIDE: f64 = 65_535.0;

/// Resampling of an image from the grid of the sensor to that of the developed image.
#[derive(Clone, Copy, Debug)]
pub struct Resampling {
    /// Columns and rows of the active area.
    from: [usize; 2],
    /// Columns and rows of the grid of square pixels.
    grid: [usize; 2],
    /// Pixels of the square grid in one of the sensor, across and down.
    scale: [f64; 2],
    lens: Lens,
    /// Whether every second row lies half a pixel farther to the right: of the sensor's grid, and of the image's.
    staggered: [bool; 2],
    /// The part of that grid that is shown.
    shown: PixelArea,
    /// Resizing of that part; `None` where the image is the part itself.
    resize: Option<Resize>,
}

/// Distortion by the lens.
#[derive(Clone, Copy, Debug)]
enum Lens {
    Straight,
    Model(Undistortion),
    /// Warp, with the aspect of pixels.
    Warp(Warp, f64),
}

impl Resampling {
    /// Resampling that the settings ask for, of an image whose active area has these columns and rows; `None` where it
    /// stays as it is.
    pub fn new(metadata: &RawMetadata, size_px: [usize; 2], settings: &DevelopSettings) -> Option<Self> {
        let aspect = metadata.pixel_aspect();
        let lens = match metadata.distortion.filter(|_| settings.distortion) {
            Some(Distortion::Lens(lens)) => Lens::Model(lens.undistortion()),
            Some(Distortion::Warp(warp)) => Lens::Warp(warp, aspect),
            None => Lens::Straight,
        };
        let scale = [aspect.max(1.0), (1.0 / aspect).max(1.0)];
        // A damaged file may say anything.
        let fits = (0..2).all(|axis| size_px[axis] as f64 * scale[axis] <= LARGEST_SIDE);
        let is_staggered = metadata.is_staggered;
        let is_stretched = settings.square_pixels && (aspect != 1.0 || is_staggered) && fits;
        let scale = if is_stretched { scale } else { [1.0; 2] };
        let grid: [usize; 2] = from_fn(|axis| (size_px[axis] as f64 * scale[axis] + 0.5) as usize);
        let shown = metadata.default_crop.filter(|_| settings.default_crop).map_or(
            PixelArea { x: 0, y: 0, width: grid[0], height: grid[1] },
            |PixelArea { x, y, width, height }| {
                // Of an image that is read from a file the crop lies within it.
                let on_grid = |n: usize, axis: usize| ((n as f64 * scale[axis] + 0.5) as usize).min(grid[axis]);
                let [left, right] = [x, x + width].map(|n| on_grid(n, 0));
                let [top, bottom] = [y, y + height].map(|n| on_grid(n, 1));
                PixelArea { x: left, y: top, width: right - left, height: bottom - top }
            },
        );
        let size = [shown.width, shown.height];
        let resize = Resize::new(size, settings);
        if let (Lens::Straight, false, None, true) = (&lens, is_stretched, &resize, size == grid) {
            return None;
        }
        let staggered = [is_staggered, is_staggered && !is_stretched];
        Some(Self { from: size_px, grid, scale, lens, staggered, shown, resize })
    }

    /// Columns and rows of the image.
    pub fn size_px(&self) -> [usize; 2] {
        self.resize.map_or([self.shown.width, self.shown.height], |resize| resize.to)
    }

    /// Whether the resampling undoes the distortion of a lens, so that no scale and shift say where its pixels lie.
    pub fn undistorts(&self) -> bool {
        !matches!(self.lens, Lens::Straight)
    }

    /// The part of the image that is shown as it is; `None` where any of its pixels is moved.
    pub(super) fn as_part(&self) -> Option<PixelArea> {
        let is_straight = matches!(self.lens, Lens::Straight) && self.scale == [1.0; 2] && self.staggered == [false; 2];
        (is_straight && self.resize.is_none()).then_some(self.shown)
    }

    /// Whether every second row of the image lies half a pixel farther to the right.
    pub fn is_staggered(&self) -> bool {
        self.staggered[1] && self.resize.is_none()
    }

    /// Place of the image's corner on the grid of the sensor, and the number of its pixels in one of the image, across
    /// and down.
    pub fn on_sensor(&self) -> ([f64; 2], [f64; 2]) {
        let (first, per_pixel) = self.resize.map_or(([0.0; 2], [1.0; 2]), |resize| (resize.first, resize.per_pixel));
        let first = [first[0] + self.shown.x as f64, first[1] + self.shown.y as f64];
        let in_pixels_of_sensor = |grid: [f64; 2]| [0, 1].map(|axis| grid[axis] / self.scale[axis]);
        (in_pixels_of_sensor(first), in_pixels_of_sensor(per_pixel))
    }

    /// Position on the grid of the sensor of a position of the image, both in continuous coordinates from the corner of
    /// the active area; `None` where the lens sees nothing.
    #[inline]
    pub fn source_px(&self, position: DVec2) -> Option<DVec2> {
        let of_grid = self.resize.map_or(position, |resize| {
            DVec2::from_array(resize.first) + position * DVec2::from_array(resize.per_pixel)
        });
        self.source_of_grid(of_grid + DVec2::new(self.shown.x as f64, self.shown.y as f64))
    }

    /// Position on the grid of the sensor of a position on the grid of square pixels.
    #[inline]
    fn source_of_grid(&self, position: DVec2) -> Option<DVec2> {
        let on_grid = position / DVec2::from_array(self.scale);
        match &self.lens {
            Lens::Straight => Some(on_grid),
            Lens::Model(way) => way.source(on_grid),
            Lens::Warp(warp, aspect) => {
                let source = warp.source_px((on_grid - 0.5).to_array(), self.from, *aspect);
                Some(DVec2::from_array(source) + 0.5)
            }
        }
    }

    /// The image of planes on the grid of the sensor.
    pub fn apply(&self, image: Planes) -> Planes {
        let [from_staggered, to_staggered] = self.staggered;
        let is_regridded = self.scale != [1.0; 2] || from_staggered != to_staggered;
        let is_moved = !matches!(self.lens, Lens::Straight) || is_regridded;
        let image = if is_moved { self.on_grid(&image) } else { image };
        let image = if [self.shown.width, self.shown.height] == self.grid { image } else { part(image, self.shown) };
        match &self.resize {
            Some(resize) => resize.apply(image),
            None => image,
        }
    }

    /// Takes every plane by Catmull–Rom splines ([Catmull74](photosite_core::references#catmull74)) at the places that
    /// the grid of square pixels names.
    fn on_grid(&self, image: &Planes) -> Planes {
        let [from_staggered, to_staggered] = self.staggered;
        let source = |position: DVec2| {
            let right = if to_staggered { shift(position.y - 0.5) } else { 0.0 };
            self.source_of_grid(position + DVec2::new(right, 0.0))
        };
        taken_from(image, from_staggered, self.grid, source, taps)
    }
}

/// A part that lies within an image.
fn part(image: Planes, PixelArea { x, y, width, height }: PixelArea) -> Planes {
    let columns = image.width();
    let cut = |channel: Channel| {
        let rows = channel.data.chunks_exact(columns.max(1)).skip(y).take(height);
        Channel { data: rows.flat_map(|row| &row[x..x + width]).copied().collect(), ..channel }
    };
    let channels = image.into_channels().into_iter().map(cut).collect();
    Planes::new(width, height, channels).expect("planes have the size of the part")
}

/// Image of `size_px` columns and rows, each pixel of which is found in another one where `source` says; black where it
/// says nothing. Positions are continuous, from the corners. `taps` are those of a place along an axis; of an image
/// that is staggered, odd rows stand half a pixel to the right.
pub(super) fn taken_from<W: AsRef<[f32]> + Copy>(
    image: &Planes,
    is_staggered: bool,
    [width, height]: [usize; 2],
    source: impl Fn(DVec2) -> Option<DVec2> + Sync,
    taps: impl Fn(f64) -> Taps<W> + Sync,
) -> Planes {
    let (from, channels) = ([image.width(), image.height()], image.channels());
    let mut data = vec![vec![0.0; width * height]; channels.len()];
    // The planes' parts of each row, so that a place is found once for all of them.
    let mut rows: Vec<Vec<&mut [f32]>> = (0..height).map(|_| Vec::with_capacity(channels.len())).collect();
    for plane in &mut data {
        rows.iter_mut().zip(plane.chunks_mut(width.max(1))).for_each(|(row, part)| row.push(part));
    }
    rows.par_iter_mut().enumerate().for_each(|(y, row)| {
        for x in 0..width {
            let Some(source) = source(DVec2::new(x as f64 + 0.5, y as f64 + 0.5)) else { continue };
            let across = taps(source.x - 0.5);
            let across_odd = if is_staggered { taps(source.x - 0.5 - shift(1.0)) } else { across };
            let (across, down) = ([across, across_odd], taps(source.y - 0.5));
            row.iter_mut().zip(channels).for_each(|(to, channel)| to[x] = sample(&channel.data, from, &across, &down));
        }
    });
    drop(rows);
    let named = |(channel, data): (&Channel, Vec<f32>)| Channel { name: channel.name.clone(), data };
    let channels = channels.iter().zip(data).map(named).collect();
    Planes::new(width, height, channels).expect("planes have the size of the image")
}

/// The first of the pixels around a place along an axis, and their weights.
pub(super) type Taps<W> = (i64, W);

/// The value at a place between pixels, whose taps across are those of even and of odd rows.
fn sample<W: AsRef<[f32]>>(plane: &[f32], [width, height]: [usize; 2], across: &[Taps<W>; 2], down: &Taps<W>) -> f32 {
    let clamped = |i: i64, n: usize| i.clamp(0, n as i64 - 1) as usize;
    let (top, weights_y) = down;
    let mut sum = 0.0;
    for (k, weight_y) in (0..).zip(weights_y.as_ref()) {
        let y = clamped(top + k, height);
        let (left, weights_x) = &across[y % 2];
        let row = &plane[y * width..][..width];
        let along: f32 = (0..).zip(weights_x.as_ref()).map(|(k, weight)| weight * row[clamped(left + k, width)]).sum();
        sum += weight_y * along;
    }
    sum
}

/// Taps of a place, in coordinates that are whole at pixel centres.
fn taps(place: f64) -> Taps<[f32; 4]> {
    // A warp that a damaged file gives may lead anywhere; a cast keeps it within the integers.
    let first = place.floor().clamp(-1e9, 1e9);
    let t = (place - first).clamp(0.0, 1.0) as f32;
    let weights = [
        t * (-0.5 + t * (1.0 - 0.5 * t)),
        1.0 + t * t * (-2.5 + 1.5 * t),
        t * (0.5 + t * (2.0 - 1.5 * t)),
        t * t * (-0.5 + 0.5 * t),
    ];
    (first as i64 - 1, weights)
}

#[cfg(test)]
mod tests {
    use rstest::rstest;

    use super::super::choices::ResizeFilter;
    use super::*;
    use photosite_core::projection::{BrownConrady, FisheyeProjection, Intrinsics, Projection};
    use photosite_raw::{LensModel, WarpKind};

    const SIZE: [usize; 2] = [60, 40];

    /// Catmull–Rom splines reproduce parabolas exactly.
    fn value(p: DVec2) -> f64 {
        0.2 + 0.01 * p.x - 0.005 * p.y + 1e-4 * p.x * p.x - 5e-5 * p.x * p.y
    }

    fn plane() -> Planes {
        let centre = |i: usize| DVec2::new((i % 60) as f64 + 0.5, (i / 60) as f64 + 0.5);
        let data = (0..60 * 40).map(|i| value(centre(i)) as f32).collect();
        Planes::new(60, 40, vec![Channel { name: "Y".to_owned(), data }]).expect("right size")
    }

    fn metadata(distortion: Option<Distortion>, pitch_m: [f64; 2]) -> RawMetadata {
        RawMetadata { distortion, pixel_pitch_m: Some(pitch_m), ..RawMetadata::default() }
    }

    fn resampling(metadata: &RawMetadata) -> Resampling {
        Resampling::new(metadata, SIZE, &DevelopSettings::default()).expect("something to do")
    }

    /// Every pixel whose four neighbours are there holds the value of where the resampling says it comes from, which
    /// lies where `place` computes it.
    fn check(metadata: &RawMetadata, size: [usize; 2], place: impl Fn(DVec2) -> DVec2) {
        let resampling = resampling(metadata);
        assert_eq!(resampling.size_px(), size);
        let found = resampling.apply(plane());
        assert_eq!([found.width(), found.height()], size);
        let mut inside = 0;
        for (i, found) in found.channels()[0].data.iter().enumerate() {
            let wanted = place(DVec2::new((i % size[0]) as f64 + 0.5, (i / size[0]) as f64 + 0.5));
            if wanted.cmpgt(DVec2::splat(2.0)).all() && wanted.cmplt(DVec2::new(58.0, 38.0)).all() {
                inside += 1;
                // Sixteen products in f32 of values below 1.
                assert!((f64::from(*found) - value(wanted)).abs() < 2e-6, "pixel {i}: {found} {wanted}");
            }
        }
        assert!(inside > 1000, "{inside}");
    }

    #[test]
    fn pixels_come_from_where_an_opcode_says() {
        let warp = Warp {
            kind: WarpKind::Rectilinear,
            radial: [1.0, -0.08, 0.02, 0.0],
            tangential: [0.002, -0.001],
            centre: [0.48, 0.53],
        };
        check(&metadata(Some(Distortion::Warp(warp)), [2e-6; 2]), SIZE, |p| {
            // DNG's formula by hand: the centre at 28.32, 20.67, the farthest corner at 59, 0.
            let (centre, unit) = (DVec2::new(28.32, 20.67), 30.68_f64.hypot(20.67));
            let DVec2 { x, y } = (p - 0.5 - centre) / unit;
            let r2 = x * x + y * y;
            let radial = 1.0 - 0.08 * r2 + 0.02 * r2 * r2;
            let moved = DVec2::new(
                x * radial + 0.004 * x * y - 0.001 * (r2 + 2.0 * x * x),
                y * radial - 0.002 * x * y + 0.002 * (r2 + 2.0 * y * y),
            );
            centre + unit * moved + 0.5
        });
    }

    /// The places of every lens in closed form, with the pixels of a CCD that are wider than high, and with skew.
    #[rstest]
    #[case::rational(
        Projection::BrownConrady(BrownConrady { k: [-0.3, 0.1, 0.0, 0.1, 0.0, 0.0], ..BrownConrady::default() }),
        |r: f64| r * (1.0 - 0.3 * r * r + 0.1 * r.powi(4)) / (1.0 + 0.1 * r * r)
    )]
    #[case::polynomial(Projection::Polynomial { k: [0.0, 0.0] }, |r: f64| r)]
    #[case::division(Projection::Division { lambda: -0.5 }, |r: f64| ((1.0 + 2.0 * r * r).sqrt() - 1.0) / r)]
    #[case::equisolid(Projection::ClassicalFisheye(FisheyeProjection::Equisolid), |r: f64| 2.0 * (0.5 * r.atan()).sin())]
    #[case::stereographic(Projection::ClassicalFisheye(FisheyeProjection::Stereographic), |r: f64| 2.0 * (0.5 * r.atan()).tan())]
    #[case::orthographic(Projection::ClassicalFisheye(FisheyeProjection::Orthographic), |r: f64| r / (1.0 + r * r).sqrt())]
    #[case::fisheye(Projection::KannalaBrandt { k: [0.1, 0.0, 0.0, 0.0] }, |r: f64| r.atan() + 0.1 * r.atan().powi(3))]
    #[case::omnidirectional(
        Projection::Omnidirectional { xi: 1.0, distortion: BrownConrady::default() },
        // tan(θ/2), which is half as large as tan θ on the axis.
        |r: f64| 2.0 * (r.atan() / 2.0).tan()
    )]
    fn pixels_come_from_where_the_lens_has_put_them(
        #[case] projection: Projection,
        #[case] radius: fn(f64) -> f64,
        #[values([4e-6, 4e-6], [16.6e-6, 12.4e-6], [5e-6, 10e-6])] pitch_m: [f64; 2],
        #[values(0.0, 3.0)] skew: f64,
    ) {
        // 60 pixels of 16.6 on pixels of 12.4 are 80.32, 40 of 10 on 5 are 80.
        let (size, scale) = match pitch_m {
            [x, y] if x == y => (SIZE, DVec2::ONE),
            [x, y] if x > y => ([80, 40], DVec2::new(x / y, 1.0)),
            [x, y] => ([60, 80], DVec2::new(1.0, y / x)),
        };
        let (fx, fy, centre) = (70.0, 70.0 * pitch_m[0] / pitch_m[1], DVec2::new(31.0, 18.0));
        // An omnidirectional lens shows the middle half as large as its matrix.
        let size_of_middle = 1.0 / projection.magnification();
        let intrinsics = Intrinsics {
            fx: fx * size_of_middle,
            fy: fy * size_of_middle,
            cx: centre.x,
            cy: centre.y,
            skew: skew * size_of_middle,
        };
        let lens = LensModel { intrinsics, projection, max_angle_rad: None };
        check(&metadata(Some(Distortion::Lens(lens)), pitch_m), size, |p| {
            let from_centre = p / scale - centre;
            let y = from_centre.y / fy;
            let ideal = DVec2::new((from_centre.x - skew * y) / fx, y);
            let r = ideal.length();
            let place = if r > 0.0 { ideal * (radius(r) / r) } else { ideal };
            centre + DVec2::new(fx * place.x + skew * place.y, fy * place.y)
        });
    }

    #[test]
    fn wide_pixels_become_square_ones() {
        check(&metadata(None, [16.6e-6, 12.4e-6]), [80, 40], |p| DVec2::new(p.x * 12.4 / 16.6, p.y));
        check(&metadata(None, [3e-6, 6e-6]), [60, 80], |p| DVec2::new(p.x, p.y / 2.0));
    }

    /// Images of parabolas are taken to the square grid and, with a lens in the way, to a staggered one.
    #[test]
    fn staggered_rows_are_taken_where_their_pixels_are() {
        let pitch_m = [4e-6, 4e-6 * photosite_core::cells::REGULAR_ROWS];
        let metadata = RawMetadata { is_staggered: true, ..metadata(None, pitch_m) };
        let centre = |i: usize| DVec2::new((i % 60) as f64 + 0.5 + shift((i / 60) as f64), (i / 60) as f64 + 0.5);
        let data = (0..60 * 40).map(|i| value(centre(i)) as f32).collect();
        let staggered = Planes::new(60, 40, vec![Channel { name: "Y".to_owned(), data }]).expect("right size");
        let square = resampling(&metadata).apply(staggered.clone());
        // 60 pitches are 69.28 distances of rows.
        assert_eq!([square.width(), square.height()], [69, 40]);
        for (i, found) in square.channels()[0].data.iter().enumerate() {
            let place =
                DVec2::new(((i % 69) as f64 + 0.5) * photosite_core::cells::REGULAR_ROWS, (i / 69) as f64 + 0.5);
            if place.cmpgt(DVec2::splat(2.5)).all() && place.cmplt(DVec2::new(57.0, 38.0)).all() {
                // Sixteen products in f32 of values below 1.
                assert!((f64::from(*found) - value(place)).abs() < 2e-6, "pixel {i}: {found}");
            }
        }
        let settings = DevelopSettings { square_pixels: false, ..DevelopSettings::default() };
        assert!(Resampling::new(&metadata, SIZE, &settings).is_none());
        let lens = LensModel {
            intrinsics: Intrinsics { fx: 70.0, fy: 70.0, cx: 30.0, cy: 20.0, skew: 0.0 },
            projection: Projection::Division { lambda: 0.0 },
            max_angle_rad: None,
        };
        let seen = RawMetadata { distortion: Some(Distortion::Lens(lens)), ..metadata };
        let same = Resampling::new(&seen, SIZE, &settings).expect("a lens").apply(staggered.clone());
        for (found, wanted) in same.channels()[0].data.iter().zip(&staggered.channels()[0].data) {
            assert!((found - wanted).abs() < 2e-6, "{found} {wanted}");
        }
    }

    #[test]
    fn a_zoomed_image_tells_where_its_pixels_come_from() {
        let settings = DevelopSettings {
            digital_zoom: 2.0,
            resize_px: Some([90, 80]),
            resize_filter: Some(ResizeFilter::Linear),
            ..DevelopSettings::default()
        };
        let of_ccd = metadata(None, [6e-6, 3e-6]);
        let resampling = Resampling::new(&of_ccd, SIZE, &settings).expect("something to do");
        assert_eq!(resampling.size_px(), [90, 80]);
        // The middle 30 × 20 of the sensor's 60 × 40 pixels.
        assert_eq!(resampling.on_sensor(), ([15.0, 10.0], [30.0 / 90.0, 20.0 / 80.0]));
        let found = resampling.apply(plane());
        for (i, found) in found.channels()[0].data.iter().enumerate() {
            let centre = DVec2::new((i % 90) as f64 + 0.5, (i / 90) as f64 + 0.5);
            let source = resampling.source_px(centre).expect("seen");
            // Straight lines are off by up to ⅛ of the curvature of 2e-4, and 5e-5 across.
            assert!((f64::from(*found) - value(source)).abs() < 5e-5, "pixel {i}: {found} {source}");
        }
    }

    #[test]
    fn nothing_is_done_where_nothing_is_asked_for() {
        let of = |metadata: &RawMetadata, distortion: bool, square_pixels: bool| {
            let settings = DevelopSettings { distortion, square_pixels, ..DevelopSettings::default() };
            Resampling::new(metadata, SIZE, &settings).map(|resampling| resampling.size_px())
        };
        let lens = LensModel {
            intrinsics: Intrinsics { fx: 70.0, fy: 70.0, cx: 30.0, cy: 20.0, skew: 0.0 },
            projection: Projection::Division { lambda: -0.1 },
            max_angle_rad: None,
        };
        let both = metadata(Some(Distortion::Lens(lens)), [6e-6, 3e-6]);
        assert_eq!(of(&both, false, false), None);
        assert_eq!(of(&both, true, false), Some(SIZE));
        assert_eq!(of(&both, false, true), Some([120, 40]));
        assert_eq!(of(&metadata(None, [3e-6; 2]), true, true), None);
        assert_eq!(of(&RawMetadata::default(), true, true), None);
    }

    #[test]
    fn what_the_lens_cannot_see_is_black() {
        let lens = LensModel {
            intrinsics: Intrinsics { fx: 40.0, fy: 40.0, cx: 30.0, cy: 20.0, skew: 0.0 },
            projection: Projection::Division { lambda: -0.1 },
            max_angle_rad: Some(0.5),
        };
        let found = resampling(&metadata(Some(Distortion::Lens(lens)), [3e-6; 2])).apply(plane());
        for (i, value) in found.channels()[0].data.iter().enumerate() {
            let from_axis = (DVec2::new((i % 60) as f64 + 0.5, (i / 60) as f64 + 0.5) - DVec2::new(30.0, 20.0)) / 40.0;
            assert_eq!(*value == 0.0, from_axis.length() > 0.5_f64.tan(), "pixel {i}");
        }
    }
}
