//! Ground truth of a rectified image: depth along the rectified axis and disparity.
//!
//! A pixel has the surface that the nearest pixel of the camera's image sees, so that nothing is mixed over edges.
//! Where the normal of that surface is known, its tangent plane is followed to the pixel's own centre: exact on planes.
//! Without normals, the depth is that of the point half a pixel away at most.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use photosite_calibration::camera_files::{CalibratedCamera, DisparityScale, RectifiedView};
use photosite_calibration::truth::TruthLayer;
use photosite_core::image::{Channel, Planes};

/// Largest relative change of the depth by the tangent plane: that of a surface seen almost edge on may lead anywhere.
const MOST_CHANGE: f64 = 0.05;

/// Planes of the camera's own truth.
struct Truth<'a> {
    width: usize,
    depth: &'a [f32],
    normal: Option<[&'a [f32]; 3]>,
    /// Whether the other camera sees the same point.
    is_seen: Option<&'a [f32]>,
}

/// Planes `depth` (m, ∞ for nothing), `disparity` (d = f·b/Z in px, 0 for nothing), and `disparity.visible` where the
/// camera's truth has that; `None` where it has no depth. `camera` took the image, with its pose.
pub(super) fn rectified_truth(
    truth: &Planes,
    camera: &CalibratedCamera,
    view: &RectifiedView<'_>,
    scale: DisparityScale,
    [width, height]: [usize; 2],
) -> Option<Planes> {
    let [x, y, z] = ["normal.X", "normal.Y", "normal.Z"].map(|name| truth.plane(name));
    let truth = Truth {
        width: truth.width(),
        depth: truth.plane(TruthLayer::Depth.name())?,
        normal: x.zip(y).zip(z).map(|((x, y), z)| [x, y, z]),
        is_seen: truth.plane("disparity.visible"),
    };
    let from_world = camera.from_world();
    let pixel = |i: usize| {
        let position = DVec2::new((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
        let nothing = [f32::INFINITY, 0.0, 0.0];
        let Some(source) = view.source_px(position) else { return nothing };
        let nearest = source.floor();
        let at = nearest.y as usize * truth.width + nearest.x as usize;
        let normal = truth
            .normal
            .map(|planes| from_world.transform_vector3(DVec3::from_array(planes.map(|plane| f64::from(plane[at])))));
        let depth = depth_m(view, position, nearest + 0.5, f64::from(truth.depth[at]), normal);
        let Some((depth, disparity)) = depth.and_then(|depth| Some((depth, scale.disparity_px(depth)?))) else {
            return nothing;
        };
        [depth as f32, disparity as f32, truth.is_seen.map_or(0.0, |plane| plane[at])]
    };
    let pixels: Vec<[f32; 3]> = (0..width * height).into_par_iter().map(pixel).collect();
    let names = ["depth", "disparity", "disparity.visible"];
    let count = if truth.is_seen.is_some() { 3 } else { 2 };
    let plane = |(i, name): (usize, &str)| Channel {
        name: name.to_owned(),
        data: pixels.iter().map(|values| values[i]).collect(),
    };
    let channels = names.into_iter().enumerate().take(count).map(plane).collect();
    Some(Planes::new(width, height, channels).expect("planes have the size of the image"))
}

/// Depth in the rectified image of the point that the camera sees at the centre of a pixel, at this depth along its own
/// axis.
fn depth_m(view: &RectifiedView<'_>, position: DVec2, pixel: DVec2, depth: f64, normal: Option<DVec3>) -> Option<f64> {
    let seen = view.seen_from(pixel)?;
    let point = seen * (depth / seen.z);
    let nearest = view.depth_m(point);
    if !(nearest.is_finite() && nearest > 0.0) {
        return None;
    }
    // n·(Z·d − P) = 0 for the direction d that is 1 long along the rectified axis.
    let on_plane = normal.map(|n| n.dot(point) / n.dot(view.direction(position)));
    Some(on_plane.filter(|depth| (depth / nearest - 1.0).abs() <= MOST_CHANGE).unwrap_or(nearest))
}
