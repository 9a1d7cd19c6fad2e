//! What raw files say of the lens, so that developers can correct it.

use glam::DVec2;
use photosite::optics::{Camera, Distortion, Falloff, Intrinsics, LensDescription};
use photosite::raw::{Area, GainMap, RawImage, Warp};

/// Points of the gain map along each side: cos⁴ changes by less than 3 % from one to the next at 50° from the axis, and
/// straight lines in between miss it by a hundredth of that.
const POINTS: [usize; 2] = [33, 25];

/// Puts the lens's falloff and distortion into the metadata.
pub(super) fn add(lens: &LensDescription, camera: &Camera, raw: &mut RawImage) {
    let area = raw.active();
    raw.metadata.gain_map = match lens.falloff {
        Falloff::None => None,
        Falloff::Cos4 => gain_map(camera, area),
    };
    raw.metadata.warp = match lens.distortion {
        Distortion::BrownConrady { k, p } if can_correct(camera) => {
            let Intrinsics { fx, cx, cy, .. } = camera.intrinsics();
            let centre = [cx - area.x as f64, cy - area.y as f64];
            Some(Warp::brown_conrady(k, p, fx, centre, [area.width, area.height]))
        }
        Distortion::BrownConrady { .. } | Distortion::None => None,
    };
}

/// A complaint about distortion that raw files cannot state.
pub(super) fn warning(lens: &LensDescription, camera: &Camera) -> Option<String> {
    (lens.distortion != Distortion::None && !can_correct(camera)).then(|| {
        "raw files do not tell of the distortion, which DNG can state for square pixels without skew only".to_owned()
    })
}

/// DNG's correction knows one focal length for both axes.
fn can_correct(camera: &Camera) -> bool {
    let Intrinsics { fx, fy, skew, .. } = camera.intrinsics();
    // What two roundings leave of equal numbers.
    (fx / fy - 1.0).abs() < 1e-12 && skew == 0.0
}

/// 1 over the relative illumination. Where distortion leaves a pixel without light, there is nothing to correct.
fn gain_map(camera: &Camera, area: Area) -> Option<GainMap> {
    let [columns, rows] = POINTS;
    let gain = |i: usize| {
        let part = [i % columns, i / columns].map(|n| n as f64);
        let x = area.x as f64 + part[0] / (columns - 1) as f64 * area.width as f64;
        let y = area.y as f64 + part[1] / (rows - 1) as f64 * area.height as f64;
        camera.relative_illumination(DVec2::new(x, y)).map_or(1.0, |illumination| 1.0 / illumination as f32)
    };
    GainMap::new(columns, rows, (0..columns * rows).map(gain).collect()).ok()
}
