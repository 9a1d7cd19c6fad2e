//! Table of what the places of an image see, for devices: lenses with distortion, fisheyes and panoramas all alike.
//!
//! Nodes stand at every few pixels; between them what is seen is the polynomial of third degree in either direction
//! that passes through four nodes. How far apart they may stand is measured, not assumed.

use rayon::prelude::*;

use glam::{DVec2, DVec4};

use super::Camera;
use super::turned;
use crate::optics::Reach;

/// Largest error of the direction that a place sees, in pixels, before numbers are rounded to 32 bits.
pub(super) const LARGEST_ERROR_PX: f64 = 1e-5;

/// Largest error of the solid angle that a place sees, as a part of it.
const LARGEST_PART: f64 = 1e-5;

/// Steps that are tried, in pixels.
const STEPS: [u32; 6] = [32, 16, 8, 4, 2, 1];

/// Number of nodes that an interpolation takes along a row, and along a column.
pub const NODES_ALONG: usize = 4;

/// Table of a lens; see the module.
#[derive(Clone, Debug, PartialEq)]
pub struct LensTable {
    /// Number of pixels from one node to the next. The first stands at the corner of the image.
    pub step: u32,
    /// Number of nodes in a row, at least [`NODES_ALONG`].
    pub columns: u32,
    /// Number of nodes in a column, at least [`NODES_ALONG`].
    pub rows: u32,
    /// Numbers of the nodes, row by row, in camera space of glTF. Those of a lens that is focused on a plane are: the
    /// point of the plane z = −1, and the solid angle over cos³θ; of others: the direction and the solid angle.
    pub nodes: Vec<[f32; 4]>,
}

impl LensTable {
    /// Makes the table of a camera; `None` where places of the image see nothing, and where no step is fine enough.
    pub(super) fn new(camera: &Camera) -> Option<Self> {
        STEPS.into_iter().find_map(|step| Self::of_step(camera, step))
    }

    /// Makes the table of a step; `None` where places see nothing, and where the step is too wide.
    fn of_step(camera: &Camera, step: u32) -> Option<Self> {
        let reach = camera.projection.reach(None);
        let [columns, rows] = camera.resolution.map(|n| (n.div_ceil(step) + 1).max(NODES_ALONG as u32));
        let seen_at = |node: [u32; 2]| numbers_at(camera, &reach, DVec2::from_array(node.map(|n| f64::from(n * step))));
        let nodes: Option<Vec<DVec4>> =
            (0..rows * columns).into_par_iter().map(|i| seen_at([i % columns, i / columns])).collect();
        let exact = ExactTable { step, columns, rows, nodes: nodes? };
        let is_close = (0..(rows - 1) * (columns - 1)).into_par_iter().all(|i| {
            let middle = DVec2::new(f64::from(i % (columns - 1)), f64::from(i / (columns - 1))) + 0.5;
            let pixel = middle * f64::from(step);
            numbers_at(camera, &reach, pixel).is_some_and(|seen| exact.is_close(camera, pixel, seen))
        });
        let nodes = exact.nodes.into_iter().map(|node| node.as_vec4().to_array()).collect();
        is_close.then_some(Self { step, columns, rows, nodes })
    }
}

/// Table before its numbers are rounded to 32 bits.
struct ExactTable {
    step: u32,
    columns: u32,
    rows: u32,
    nodes: Vec<DVec4>,
}

impl ExactTable {
    /// Whether the table sees at a place what the camera does.
    fn is_close(&self, camera: &Camera, pixel: DVec2, seen: DVec4) -> bool {
        let error = self.interpolated(pixel) - seen;
        let (of_direction, of_angle, angle) = if camera.projection.is_flat() {
            (error.truncate().truncate().length(), error.z, seen.z)
        } else {
            (error.truncate().length(), error.w, seen.w)
        };
        let pixels = camera.intrinsics.fx.abs().max(camera.intrinsics.fy.abs());
        of_direction * pixels <= LARGEST_ERROR_PX && of_angle.abs() <= LARGEST_PART * angle.abs()
    }

    /// Numbers of a place by the polynomial through the nodes about it.
    fn interpolated(&self, pixel: DVec2) -> DVec4 {
        let last = [self.columns, self.rows].map(|n| f64::from(n) - NODES_ALONG as f64);
        let at = pixel / f64::from(self.step);
        let start = (at.floor() - 1.0).max(DVec2::ZERO).min(DVec2::from_array(last));
        let [across, down] = (at - start).to_array().map(weights);
        let [column, row] = start.to_array().map(|n| n as usize);
        let mut sum = DVec4::ZERO;
        for (j, down) in down.into_iter().enumerate() {
            for (i, across) in across.into_iter().enumerate() {
                sum += self.nodes[(row + j) * self.columns as usize + column + i] * (across * down);
            }
        }
        sum
    }
}

/// Weights of four nodes at 0, 1, 2 and 3 (Lagrange) at a place between them.
fn weights(t: f64) -> [f64; NODES_ALONG] {
    let [a, b, c] = [t - 1.0, t - 2.0, t - 3.0];
    [-a * b * c / 6.0, t * b * c / 2.0, -t * a * c / 2.0, t * a * b / 6.0]
}

/// Numbers of a place, as [`LensTable::nodes`] has them, within the reach of the model whatever the lens is said to
/// see.
fn numbers_at(camera: &Camera, reach: &Reach, pixel: DVec2) -> Option<DVec4> {
    let seen = turned(camera.projection.unproject(camera.place(pixel), reach)?);
    Some(if camera.projection.is_flat() {
        let cos = -seen.direction.z;
        DVec4::new(seen.chief.x, seen.chief.y, seen.solid_angle / (cos * cos * cos), 0.0)
    } else {
        seen.direction.extend(seen.solid_angle)
    })
}
