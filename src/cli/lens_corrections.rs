//! What raw files say of the lens, so that developers can correct it.

use glam::DVec2;
use photosite::optics::{BrownConrady, Camera, Falloff, Intrinsics, LensDescription, Projection};
use photosite::raw::{Area, GainMap, RawImage, Warp};
use photosite::sensor::Window;

/// Points of the gain map along each side: straight lines between so many miss 1/cos⁴θ by less than 0.3 % up to 45° from
/// the axis.
const POINTS: [usize; 2] = [33, 25];

/// Puts the lens's falloff and distortion into the metadata of what a window of the camera's picture shows.
pub(super) fn add(lens: &LensDescription, camera: &Camera, window: &Window, raw: &mut RawImage) {
    let Area { width, height, .. } = raw.active();
    let [across, down] = window.binning.factor;
    let [x, y] = window.region.map_or([0, 0], |region| [region.x, region.y]);
    let seen = Area { x, y, width: width * across, height: height * down };
    raw.metadata.gain_map = match lens.falloff {
        Falloff::None if lens.stops.is_empty() => None,
        Falloff::None | Falloff::Cos4 => gain_map(camera, seen),
    };
    raw.metadata.warp = correction(lens, camera, window).map(|(k, p)| {
        let Intrinsics { fx, cx, cy, .. } = camera.intrinsics();
        let centre = [(cx - x as f64) / across as f64, (cy - y as f64) / down as f64];
        Warp::brown_conrady(k, p, fx / across as f64, centre, [width, height])
    });
}

/// A complaint about distortion that raw files cannot state.
pub(super) fn warning(lens: &LensDescription, camera: &Camera, window: &Window) -> Option<String> {
    if lens.projection == Projection::Perspective {
        return None;
    }
    let name = lens.projection.name();
    match polynomial(&lens.projection) {
        None => Some(format!("raw files do not tell of the {name} lens, which DNG's correction cannot state")),
        Some(_) if can_correct(camera, window) => None,
        Some(_) => Some(
            "raw files do not tell of the distortion, which DNG can state for square pixels without skew only"
                .to_owned(),
        ),
    }
}

/// Whether raw files tell of the distortion.
pub(super) fn tells_distortion(lens: &LensDescription, camera: &Camera, window: &Window) -> bool {
    correction(lens, camera, window).is_some()
}

/// The coefficients that DNG's correction takes, where it can.
fn correction(lens: &LensDescription, camera: &Camera, window: &Window) -> Option<([f64; 3], [f64; 2])> {
    polynomial(&lens.projection).filter(|_| can_correct(camera, window))
}

/// k₁ k₂ k₃ and p₁ p₂ of a lens that has no more than these, as DNG's correction of rectilinear lenses does.
fn polynomial(projection: &Projection) -> Option<([f64; 3], [f64; 2])> {
    match *projection {
        Projection::BrownConrady(BrownConrady { k: [k1, k2, k3, 0.0, 0.0, 0.0], p, s: [0.0, 0.0, 0.0, 0.0] }) => {
            Some(([k1, k2, k3], p))
        }
        Projection::BrownConrady(_)
        | Projection::Perspective
        | Projection::Polynomial { .. }
        | Projection::Division { .. }
        | Projection::KannalaBrandt { .. }
        | Projection::Equirectangular
        | Projection::Omnidirectional { .. } => None,
    }
}

/// DNG's correction knows one focal length for both axes.
fn can_correct(camera: &Camera, window: &Window) -> bool {
    let Intrinsics { fx, fy, skew, .. } = camera.intrinsics();
    let [across, down] = window.binning.factor.map(|n| n as f64);
    // What a few roundings leave of equal numbers.
    (fx / across / (fy / down) - 1.0).abs() < 1e-12 && skew == 0.0
}

/// 1 over the relative illumination. Where distortion leaves a pixel without light, there is nothing to correct.
fn gain_map(camera: &Camera, area: Area) -> Option<GainMap> {
    let [columns, rows] = POINTS;
    let gain = |i: usize| {
        let part = [i % columns, i / columns].map(|n| n as f64);
        let x = area.x as f64 + part[0] / (columns - 1) as f64 * area.width as f64;
        let y = area.y as f64 + part[1] / (rows - 1) as f64 * area.height as f64;
        let illumination = camera.relative_illumination(DVec2::new(x, y)).filter(|illumination| *illumination > 0.0);
        illumination.map_or(1.0, |illumination| 1.0 / illumination as f32)
    };
    GainMap::new(columns, rows, (0..columns * rows).map(gain).collect()).ok()
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;
    use photosite::optics::{Focus, PixelGrid};

    use super::*;

    const SIZE: [u32; 2] = [640, 480];

    fn brown_conrady([k1, k2]: [f64; 2], p: [f64; 2]) -> Projection {
        Projection::BrownConrady(BrownConrady { k: [k1, k2, 0.0, 0.0, 0.0, 0.0], p, ..BrownConrady::default() })
    }

    fn camera(projection: Projection, f_number: f64, pitch_m: [f64; 2]) -> (LensDescription, Camera) {
        let mut lens = LensDescription::thin(0.004, f_number, Focus::Infinity);
        lens.projection = projection;
        let grid = PixelGrid { resolution: SIZE, pitch_m };
        let camera = Camera::new(&lens, &grid, DAffine3::IDENTITY, 1.0).expect("a lens");
        (lens, camera)
    }

    fn corrected(lens: &LensDescription, camera: &Camera) -> RawImage {
        let (width, height) = (SIZE[0] as usize, SIZE[1] as usize);
        let mut raw = RawImage { width, height, ..RawImage::default() };
        add(lens, camera, &Window::WHOLE, &mut raw);
        raw
    }

    #[test]
    fn the_warp_finds_what_a_lens_without_distortion_sees() {
        let distortion = brown_conrady([-0.12, 0.03], [1e-3, -5e-4]);
        let (lens, distorting) = camera(distortion, 4.0, [6e-6; 2]);
        let (_, ideal) = camera(Projection::Perspective, 4.0, [6e-6; 2]);
        let warp = corrected(&lens, &distorting).metadata.warp.expect("square pixels");
        for pixel in [[320.0, 240.0], [500.0, 100.0], [60.0, 420.0], [0.0, 0.0]] {
            let [x, y] = warp.source_px(pixel, SIZE.map(|n| n as usize));
            let found = distorting.chief_ray(DVec2::new(x + 0.5, y + 0.5)).expect("light").direction.normalize();
            let wanted = ideal.chief_ray(DVec2::new(pixel[0] + 0.5, pixel[1] + 0.5)).expect("light");
            // Directions of rays are f32.
            assert!((found - wanted.direction.normalize()).length() < 1e-6, "{pixel:?}");
        }
    }

    #[test]
    fn the_gains_undo_cos4() {
        let (lens, camera) = camera(Projection::Perspective, 22.0, [6e-6; 2]);
        let map = corrected(&lens, &camera).metadata.gain_map.expect("falloff");
        for (x, y) in [(0.0, 0.0), (0.5, 0.5), (1.0, 0.25), (0.73, 0.4)] {
            let across = DVec2::new((x - 0.5) * 640.0, (y - 0.5) * 480.0) * 6e-6 / 0.004;
            let gain = (1.0 + across.length_squared()).powi(2);
            // Straight lines miss a function by its second derivative times the step² over 8. Here that is at most
            // 6.7/32²/8 along x and 3.4/24²/8 along y, 1.6e-3 together; the opening adds (D/2v)² = 5e-4 at most.
            assert!((f64::from(map.at(x, y)) - gain).abs() < 2.1e-3, "{x} {y}: {} {gain}", map.at(x, y));
        }
    }

    #[test]
    fn distortion_of_pixels_that_are_not_square_is_left_out_with_a_warning() {
        let distortion = brown_conrady([-0.12, 0.0], [0.0, 0.0]);
        let (lens, camera) = camera(distortion, 4.0, [6e-6, 3e-6]);
        assert!(warning(&lens, &camera, &Window::WHOLE).is_some() && corrected(&lens, &camera).metadata.warp.is_none());
    }
}
