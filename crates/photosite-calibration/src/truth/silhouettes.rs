//! Silhouettes: the pixels that see each object, and those that would if nothing else were there.
//!
//! Rays are those of the other layers: through the whole lens, in the middle of the exposure of each row.

use std::ops::Range;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use super::{TruthObject, View};
use photosite_transport::geometry::Ray;

/// A set of pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mask {
    /// Runs of pixels: the row, and the columns in it. In the order of rows, then columns.
    runs: Vec<(u32, Range<u32>)>,
}

/// The pixels of an object.
#[derive(Clone, Debug, Default)]
pub struct Silhouettes {
    /// Pixels that see the object.
    pub visible: Mask,
    /// Pixels that would see it if nothing else were there.
    pub alone: Mask,
}

/// The pixels of all objects of the view's scene, which are those of its description in their order.
pub fn silhouettes(view: &View<'_>, objects: &[TruthObject]) -> Vec<Silhouettes> {
    let grid = &view.grid;
    let [width, height] = grid.resolution;
    let alone = view.scene.objects_alone();
    let still: Vec<DAffine3> = objects.iter().map(|object| object.to_world(0.0).inverse()).collect();
    let of_row = |row: u32| {
        let on_sensor = |column: u32| grid.on_sensor(grid.centre([column as usize, row as usize]));
        let camera = view.camera.at_row(on_sensor(0).y - 0.5);
        let mut found: Vec<[Runs; 2]> = vec![Default::default(); objects.len()];
        for column in 0..width {
            let Some(ray) = camera.chief_ray(on_sensor(column)) else { continue };
            let seen = view.scene.closest(&ray).map(|hit| view.scene.object(&hit) as usize);
            if let Some(seen) = seen {
                found[seen][0].add(column);
            }
            for (index, object) in objects.iter().enumerate() {
                let to_frame = if object.moves() { object.to_world(ray.time.into()).inverse() } else { still[index] };
                let meets = || meets_box(object, &to_frame, &ray) && view.scene.meets(&alone[index], &ray);
                // What is seen would be seen alone.
                if seen == Some(index) || meets() {
                    found[index][1].add(column);
                }
            }
        }
        found
    };
    let rows: Vec<Vec<[Runs; 2]>> = (0..height).into_par_iter().map(of_row).collect();
    let mut all = vec![Silhouettes::default(); objects.len()];
    for (row, found) in (0..).zip(rows) {
        for (silhouettes, [visible, alone]) in all.iter_mut().zip(found) {
            silhouettes.visible.runs.extend(visible.0.into_iter().map(|run| (row, run)));
            silhouettes.alone.runs.extend(alone.0.into_iter().map(|run| (row, run)));
        }
    }
    all
}

/// Runs of columns in a row.
#[derive(Clone, Debug, Default)]
struct Runs(Vec<Range<u32>>);

impl Runs {
    fn add(&mut self, column: u32) {
        match self.0.last_mut().filter(|last| last.end == column) {
            Some(last) => last.end += 1,
            None => self.0.push(column..column + 1),
        }
    }
}

/// Whether a ray passes the box of an object. The box is made a little larger, as surfaces are found with the rounding
/// of single precision.
fn meets_box(object: &TruthObject, to_frame: &DAffine3, ray: &Ray) -> bool {
    let origin = to_frame.transform_point3(ray.origin.as_dvec3());
    let direction = to_frame.transform_vector3(ray.direction.as_dvec3());
    let reach = (object.low - origin).abs().max((object.high - origin).abs()).max_element();
    let rounding = f64::from(f32::EPSILON) * to_frame.translation.length();
    let room = DVec3::splat(reach * 1e-5 + 4.0 * rounding);
    let to_low = (object.low - room - origin) / direction;
    let to_high = (object.high + room - origin) / direction;
    let near = to_low.min(to_high).max_element();
    let far = to_low.max(to_high).min_element();
    near <= far && far >= 0.0
}

impl Mask {
    /// Number of its pixels.
    pub fn count(&self) -> u64 {
        self.runs.iter().map(|(_, columns)| columns.len() as u64).sum()
    }

    /// Bounds of the mask: the first column and row, and how many there are of each up to the last; `None` without any
    /// pixel.
    pub fn bounds(&self) -> Option<[u32; 4]> {
        let (top, bottom) = (self.runs.first()?.0, self.runs.last()?.0);
        let left = self.runs.iter().map(|(_, columns)| columns.start).min()?;
        let right = self.runs.iter().map(|(_, columns)| columns.end).max()?;
        Some([left, top, right - left, bottom + 1 - top])
    }

    /// Lengths of runs down the columns one after the other, outside and inside in turns, outside first: COCO's
    /// ([Coco](photosite_core::references#coco)), in an image of this size, columns and rows.
    pub fn column_runs(&self, [width, height]: [u32; 2]) -> Vec<u32> {
        let mut inside = vec![false; width as usize * height as usize];
        for (row, columns) in &self.runs {
            columns.clone().for_each(|column| inside[(column * height + row) as usize] = true);
        }
        let mut runs = Vec::new();
        let (mut is_in, mut length) = (false, 0);
        for pixel in inside {
            if pixel != is_in {
                runs.push(length);
                (is_in, length) = (pixel, 0);
            }
            length += 1;
        }
        runs.push(length);
        runs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_go_down_the_columns() {
        // Of an image of four columns and three rows: . # # . / . # . . / # . . #
        let mask = Mask { runs: vec![(0, 1..3), (1, 1..2), (2, 0..1), (2, 3..4)] };
        assert_eq!(mask.column_runs([4, 3]), [2, 3, 1, 1, 4, 1]);
        assert_eq!(mask.count(), 5);
        assert_eq!(mask.bounds(), Some([0, 0, 4, 3]));
        assert_eq!(Mask::default().column_runs([4, 3]), [12]);
        assert_eq!(Mask::default().bounds(), None);
    }
}
