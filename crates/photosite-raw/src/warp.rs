//! Distortion as DNG's opcodes state it ([Dng16](photosite_core::references#dng16), chapter 7).

use std::array::from_fn;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::LensModel;
use photosite_core::math::linear::solve;
use photosite_core::projection::{BrownConrady, Intrinsics, Projection};

/// Warp: the place in the distorted image of each pixel of the corrected one.
///
/// With the offset (x, y) from the centre in units of the distance from the centre to the farthest corner, both
/// measured in widths of pixels whatever their height, and r² = x² + y², WarpRectilinear is
///
/// x' = x·(k₀ + k₁r² + k₂r⁴ + k₃r⁶) + t₀·2xy + t₁·(r² + 2x²)
///
/// y' = y·(k₀ + k₁r² + k₂r⁴ + k₃r⁶) + t₁·2xy + t₀·(r² + 2y²)
///
/// and WarpFisheye, with θ = arctan r,
///
/// (x', y') = (x, y)/r·(k₀θ + k₁θ³ + k₂θ⁵ + k₃θ⁷).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Warp {
    /// Polynomial: that of WarpRectilinear or of WarpFisheye.
    pub kind: WarpKind,
    /// k₀ … k₃.
    pub radial: [f64; 4],
    /// t₀, t₁; 0 of a fisheye.
    pub tangential: [f64; 2],
    /// The centre: 0, 0 is the centre of the active area's top-left pixel, 1, 1 that of the opposite one.
    pub centre: [f64; 2],
}

/// Opcodes that undo distortion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum WarpKind {
    /// WarpRectilinear.
    Rectilinear,
    /// WarpFisheye.
    Fisheye,
}

/// Coefficients that a fit may choose.
const UNKNOWNS: usize = 6;
/// Columns and rows of places at which a model is fitted, and then more at which it is judged.
const FITTED: [usize; 2] = [33, 25];
const JUDGED: [usize; 2] = [97, 73];

impl Warp {
    /// Largest error of an opcode against a lens, px.
    pub const LARGEST_ERROR_PX: f64 = 0.1;

    /// The opcode that says what a lens does to an image of these columns and rows of pixels that are `aspect` times
    /// as wide as high: exactly where it has the lens's own polynomial, else one that comes as near as
    /// [`LARGEST_ERROR_PX`](Self::LARGEST_ERROR_PX) wherever the image shows something. `None` where there is none.
    pub fn of_lens(lens: &LensModel, size_px: [usize; 2], aspect: f64) -> Option<Self> {
        let Intrinsics { fx, fy, cx, cy, skew } = lens.intrinsics;
        let centre: [f64; 2] = from_fn(|axis| ([cx, cy][axis] - 0.5) / (size_px[axis] as f64 - 1.0).max(1.0));
        // Opcodes have their centre within the image.
        if !centre.iter().all(|c| (0.0..=1.0).contains(c)) {
            return None;
        }
        let blank = |kind| Self { kind, radial: [0.0; 4], tangential: [0.0; 2], centre };
        // What a few roundings leave of equal numbers.
        let is_square = (fy / (fx * aspect) - 1.0).abs() < 1e-12 && skew == 0.0;
        if let (true, Projection::BrownConrady(BrownConrady { k: [k1, k2, k3, 0.0, 0.0, 0.0], p, s })) =
            (is_square, lens.projection)
            && s == [0.0; 4]
        {
            // Both go from the ideal to the distorted image and are the same polynomial in other units.
            let unit = unit(centre, size_px, aspect) / fx;
            let radial = [1.0, k1 * unit.powi(2), k2 * unit.powi(4), k3 * unit.powi(6)];
            return Some(Self { radial, tangential: p.map(|p| p * unit), ..blank(WarpKind::Rectilinear) });
        }
        let fits = [WarpKind::Rectilinear, WarpKind::Fisheye].into_iter().filter_map(|kind| {
            let warp = blank(kind).fitted(lens, size_px, aspect)?;
            Some((warp.error_px(lens, size_px, aspect), warp))
        });
        let (error, warp) = fits.min_by(|(a, _), (b, _)| a.total_cmp(b))?;
        (error < Self::LARGEST_ERROR_PX).then_some(warp)
    }

    /// Place in the distorted image of a corrected pixel (integer coordinates at centres), in an image of that size
    /// whose pixels are `aspect` times as wide as high.
    pub fn source_px(&self, pixel: [f64; 2], size_px: [usize; 2], aspect: f64) -> [f64; 2] {
        let (centre, unit) = (centre_px(self.centre, size_px), unit(self.centre, size_px, aspect));
        let terms = self.terms(offset(self.centre, pixel, size_px, aspect));
        let coefficients = self.coefficients();
        let moved = terms.map(|terms| terms.iter().zip(coefficients).map(|(term, c)| term * c).sum::<f64>());
        [centre[0] + unit * moved[0], centre[1] + unit * aspect * moved[1]]
    }

    fn coefficients(&self) -> [f64; UNKNOWNS] {
        let ([k0, k1, k2, k3], [t0, t1]) = (self.radial, self.tangential);
        [k0, k1, k2, k3, t0, t1]
    }

    /// Terms that each coefficient is multiplied by in x' and y'.
    fn terms(&self, [x, y]: [f64; 2]) -> [[f64; UNKNOWNS]; 2] {
        let r2 = x * x + y * y;
        let (powers, mixed) = match self.kind {
            WarpKind::Rectilinear => ([1.0, r2, r2 * r2, r2 * r2 * r2], 2.0 * x * y),
            WarpKind::Fisheye => {
                let r = r2.sqrt();
                let theta = r.atan();
                let first = if r > 0.0 { theta / r } else { 1.0 };
                (from_fn(|i| first * (theta * theta).powi(i as i32)), 0.0)
            }
        };
        let [across, down] = match self.kind {
            WarpKind::Rectilinear => [r2 + 2.0 * x * x, r2 + 2.0 * y * y],
            WarpKind::Fisheye => [0.0; 2],
        };
        let [p0, p1, p2, p3] = powers;
        [[x * p0, x * p1, x * p2, x * p3, mixed, across], [y * p0, y * p1, y * p2, y * p3, down, mixed]]
    }

    /// The coefficients of least squares of what is off.
    fn fitted(&self, lens: &LensModel, size_px: [usize; 2], aspect: f64) -> Option<Self> {
        let count = match self.kind {
            WarpKind::Rectilinear => UNKNOWNS,
            WarpKind::Fisheye => 4,
        };
        let (mut a, mut b) = (vec![vec![0.0; count]; count], vec![0.0; count]);
        let (centre, unit) = (centre_px(self.centre, size_px), unit(self.centre, size_px, aspect));
        for (pixel, source) in places(lens, size_px, FITTED) {
            let normalised = |[x, y]: [f64; 2]| [(x - centre[0]) / unit, (y - centre[1]) / (unit * aspect)];
            for (terms, target) in self.terms(normalised(pixel)).iter().zip(normalised(source)) {
                for i in 0..count {
                    (0..count).for_each(|j| a[i][j] += terms[i] * terms[j]);
                    b[i] += terms[i] * target;
                }
            }
        }
        let mut found = solve(a, b)?;
        found.resize(UNKNOWNS, 0.0);
        let [k0, k1, k2, k3, t0, t1] = <[f64; UNKNOWNS]>::try_from(found).ok()?;
        let whole = [k0, k1, k2, k3, t0, t1].iter().all(|c| c.is_finite());
        whole.then_some(Self { radial: [k0, k1, k2, k3], tangential: [t0, t1], ..*self })
    }

    /// Largest distance between the places that the warp and the lens lead to, px.
    fn error_px(&self, lens: &LensModel, size_px: [usize; 2], aspect: f64) -> f64 {
        let errors = places(lens, size_px, JUDGED).map(|(pixel, [x, y])| {
            let found = self.source_px(pixel, size_px, aspect);
            (found[0] - x).abs().max((found[1] - y).abs())
        });
        errors.fold(0.0, f64::max)
    }
}

/// Places of the corrected image, evenly, and where the lens has put what they show, of those that lie in its
/// image; integer coordinates at pixel centres.
fn places(
    lens: &LensModel,
    size_px: [usize; 2],
    [columns, rows]: [usize; 2],
) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
    let (way, [width, height]) = (lens.undistortion(), size_px.map(|n| n as f64));
    (0..columns * rows).filter_map(move |i| {
        let part = [(i % columns) as f64 / (columns - 1) as f64, (i / columns) as f64 / (rows - 1) as f64];
        let pixel = DVec2::new(part[0] * (width - 1.0), part[1] * (height - 1.0));
        let source = way.source(pixel + 0.5)?;
        let inside = (0.0..=width).contains(&source.x) && (0.0..=height).contains(&source.y);
        inside.then(|| (pixel.to_array(), (source - 0.5).to_array()))
    })
}

fn centre_px(centre: [f64; 2], size_px: [usize; 2]) -> [f64; 2] {
    from_fn(|axis| centre[axis] * (size_px[axis] as f64 - 1.0))
}

/// The distance from a centre to the farthest corner, in widths of pixels.
fn unit(centre: [f64; 2], size_px: [usize; 2], aspect: f64) -> f64 {
    let centre = centre_px(centre, size_px);
    let farthest = |axis: usize| centre[axis].abs().max((size_px[axis] as f64 - 1.0 - centre[axis]).abs());
    farthest(0).hypot(farthest(1) / aspect).max(f64::MIN_POSITIVE)
}

/// The offset of a pixel from a centre, both as opcodes state them, in units of the distance from the centre to the
/// farthest corner.
pub(super) fn offset(centre: [f64; 2], pixel: [f64; 2], size_px: [usize; 2], aspect: f64) -> [f64; 2] {
    let (from, unit) = (centre_px(centre, size_px), unit(centre, size_px, aspect));
    [(pixel[0] - from[0]) / unit, (pixel[1] - from[1]) / (unit * aspect)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::projection::FisheyeProjection;

    const SIZE: [usize; 2] = [640, 480];

    fn lens(projection: Projection, fx: f64, fy: f64, skew: f64) -> LensModel {
        let intrinsics = Intrinsics { fx, fy, cx: 322.0, cy: 236.5, skew };
        LensModel { intrinsics, projection, max_angle_rad: None }
    }

    #[test]
    fn the_warp_of_a_polynomial_is_that_of_opencv() {
        let (k, p) = ([-0.1, 0.03, -0.01], [2e-3, -1e-3]);
        let [k1, k2, k3] = k;
        let projection =
            Projection::BrownConrady(BrownConrady { k: [k1, k2, k3, 0.0, 0.0, 0.0], p, ..BrownConrady::default() });
        // Square pixels, and such as are 16.6 × 12.4.
        for aspect in [1.0, 16.6 / 12.4] {
            let warp =
                Warp::of_lens(&lens(projection, 500.0, 500.0 * aspect, 0.0), SIZE, aspect).expect("the same model");
            for pixel in [[321.5, 236.0], [80.0, 10.0], [0.0, 0.0], [639.0, 479.0]] {
                // OpenCV's projectPoints by hand.
                let [x, y] = [(pixel[0] - 321.5) / 500.0, (pixel[1] - 236.0) / (500.0 * aspect)];
                let r2: f64 = x * x + y * y;
                let radial = 1.0 + k[0] * r2 + k[1] * r2.powi(2) + k[2] * r2.powi(3);
                let distorted = [
                    x * radial + 2.0 * p[0] * x * y + p[1] * (r2 + 2.0 * x * x),
                    y * radial + p[0] * (r2 + 2.0 * y * y) + 2.0 * p[1] * x * y,
                ];
                let found = warp.source_px(pixel, SIZE, aspect);
                assert!((found[0] - 321.5 - 500.0 * distorted[0]).abs() < 1e-10, "{found:?}");
                assert!((found[1] - 236.0 - 500.0 * aspect * distorted[1]).abs() < 1e-10, "{found:?}");
            }
        }
    }

    #[test]
    fn other_lenses_are_told_to_a_tenth_of_a_pixel_or_not_at_all() {
        let rational =
            BrownConrady { k: [0.6, -0.2, 0.05, 0.8, -0.1, 0.02], p: [1e-3, 2e-3], ..BrownConrady::default() };
        let barrel = BrownConrady { k: [-0.2, 0.05, 0.0, 0.0, 0.0, 0.0], ..BrownConrady::default() };
        let fisheye = Projection::KannalaBrandt { k: [0.04, -0.01, 0.002, -0.0005] };
        for (what, lens, aspect) in [
            ("rational", lens(Projection::BrownConrady(rational), 600.0, 600.0, 0.0), 1.0),
            ("polynomial", lens(Projection::Polynomial { k: [0.1, 0.02] }, 600.0, 600.0, 0.0), 1.0),
            ("division", lens(Projection::Division { lambda: -0.2 }, 600.0, 600.0, 0.0), 1.0),
            ("fisheye", lens(fisheye, 500.0, 500.0, 0.0), 1.0),
            ("equisolid", lens(Projection::ClassicalFisheye(FisheyeProjection::Equisolid), 500.0, 500.0, 0.0), 1.0),
            (
                "stereographic",
                lens(Projection::ClassicalFisheye(FisheyeProjection::Stereographic), 500.0, 500.0, 0.0),
                1.0,
            ),
            (
                "orthographic",
                lens(Projection::ClassicalFisheye(FisheyeProjection::Orthographic), 500.0, 500.0, 0.0),
                1.0,
            ),
            ("fisheye of wide pixels", lens(fisheye, 500.0, 700.0, 0.0), 1.4),
        ] {
            let warp = Warp::of_lens(&lens, SIZE, aspect).unwrap_or_else(|| panic!("{what}"));
            let way = lens.undistortion();
            // Between the places at which it was judged.
            for i in 0..900 {
                let pixel = DVec2::new((i % 30) as f64 * 22.0 + 0.37, (i / 30) as f64 * 16.5 + 0.21);
                let source = way.source(pixel + 0.5).expect("seen") - 0.5;
                let found = DVec2::from_array(warp.source_px(pixel.to_array(), SIZE, aspect));
                let inside = source.cmpgt(DVec2::ZERO).all() && source.cmplt(DVec2::new(639.0, 479.0)).all();
                assert!(!inside || (found - source).abs().max_element() < 0.1, "{what} at {pixel}: {found} {source}");
            }
        }
        for (what, lens) in [
            ("ellipses", lens(Projection::BrownConrady(barrel), 600.0, 800.0, 0.0)),
            ("skew", lens(Projection::BrownConrady(barrel), 600.0, 600.0, 60.0)),
        ] {
            assert_eq!(Warp::of_lens(&lens, SIZE, 1.0), None, "{what}");
        }
        let mut beside = lens(Projection::BrownConrady(barrel), 600.0, 600.0, 0.0);
        beside.intrinsics.cx = -20.0;
        assert_eq!(Warp::of_lens(&beside, SIZE, 1.0), None, "the centre is not in the image");
    }
}
