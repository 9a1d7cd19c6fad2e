//! Projection by a camera: places of points in its image, and lines of sight of its pixels, in OpenCV's coordinates: pixels
//! are column and row with integers at the centres, those of ground truth (`pixel_grid` in reports); those of a camera
//! are x right, y down, z forward.

use glam::{DVec2, DVec3};
use photosite_core::image_grid::ImageGrid;

use crate::{image_grid, standalone_recording_camera};
use photosite_calibration::truth::{NotFound, project};
use photosite_capture::Capture;
use photosite_core::{Invalid, Result};
use photosite_transport::optics::{Camera, LensKind};

/// Frame that points and directions are measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// The world: glTF's axes, m.
    World,
    /// The camera.
    Camera,
}

/// Camera of a capture as it takes the first image. One that moves sees each point, and each pixel, in the middle of
/// the exposure of its row.
pub struct CameraProjection {
    camera: Camera,
    grid: ImageGrid,
    space: Space,
    not_found: NotFound,
}

impl CameraProjection {
    /// Projection by a capture's camera.
    ///
    /// # Errors
    ///
    /// A bare sensor; a lens that cannot be.
    pub fn new(capture: &Capture, space: Space) -> Result<Self> {
        if capture.lens().kind == LensKind::Bare {
            let message = "no point has a place on a bare sensor: each of its pixels sees everything";
            return Err(capture.source().error(Invalid::new("lens.type", message).help("use a lens")));
        }
        let camera = standalone_recording_camera(capture)?;
        let grid = image_grid(capture, &camera);
        Ok(Self { camera, grid, space, not_found: NotFound::default() })
    }

    /// Place of a point in the image; not-a-number where the lens does not show it.
    pub fn pixel(&self, point: [f64; 3]) -> [f64; 2] {
        let point = DVec3::from_array(point);
        let pixel = match self.space {
            Space::Camera => self.camera.project_camera(flipped(point)),
            Space::World => project(&self.camera, point, &self.not_found),
        };
        (self.grid.in_image(pixel.unwrap_or(DVec2::NAN)) - 0.5).to_array()
    }

    /// Warning about points that the lens shows, but that are in no row at its own time: they have no known place.
    pub fn warning(&self) -> Option<String> {
        self.not_found.warning()
    }

    /// Direction in which a pixel looks, a unit vector; not-a-number where it sees nothing.
    pub fn direction(&self, pixel: [f64; 2]) -> [f64; 3] {
        self.line(pixel)[1]
    }

    /// Line along which a pixel looks: a point of it, m, and its direction, a unit vector; not-a-number where it sees
    /// nothing. Lines go through the camera's place, but for those of a lens from a prescription, each of which goes
    /// through the entrance pupil of its own field.
    pub fn line(&self, pixel: [f64; 2]) -> [[f64; 3]; 2] {
        let pixel = self.grid.on_sensor(DVec2::from_array(pixel) + 0.5);
        let line = match (self.camera.line_of_sight(pixel), self.space) {
            (None, _) => [DVec3::NAN; 2],
            (Some((origin, direction)), Space::Camera) => [flipped(origin), flipped(direction)],
            (Some((origin, direction)), Space::World) => {
                let (to_world, _) = self.camera.pose_at_row(pixel.y - 0.5);
                [to_world.transform_point3(origin), to_world.transform_vector3(direction)]
            }
        };
        line.map(|vector| vector.to_array())
    }
}

/// Turns a vector between the axes of OpenCV and those of glTF.
fn flipped(v: DVec3) -> DVec3 {
    // Adding zero makes zeros of negative ones.
    DVec3::new(v.x, -v.y, -v.z) + 0.0
}
