//! Chief rays of all image heights at one wavelength: from scene points to image points and back.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};

use photosite_core::math::monotone_cubic::MonotoneCubic;

use crate::chief::ChiefRay;
use crate::trace::LensAt;

/// Number of angles at the stop at which chief rays are traced.
const ANGLES: u32 = 512;
/// Largest distance of traced chief rays from the axis, relative to the image corner: points beside the image have
/// places, too.
const BEYOND: f64 = 1.25;
/// Precision of the field angle of a point, rad, and the largest number of steps.
const PRECISION_RAD: f64 = 1e-13;
const MOST_STEPS: usize = 50;

/// Interpolated chief rays of a lens.
#[derive(Clone, Debug)]
pub struct ChiefMap {
    /// Field angle, rad, and crossing of the axis before the lens, mm from the first vertex, by image height.
    field: MonotoneCubic,
    pupil: MonotoneCubic,
    /// Image height, mm, and crossing of the axis, mm, by field angle.
    height_of_field: MonotoneCubic,
    pupil_of_field: MonotoneCubic,
    highest_mm: f64,
    widest_rad: f64,
    widest_stop_rad: f64,
}

/// Line of sight of an image point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Unit vector out into the scene.
    pub direction: DVec3,
    /// Crossing of the line of sight with the axis, mm from the first vertex.
    pub pupil_mm: f64,
}

impl ChiefMap {
    /// Chief rays up to an image height in mm, and a little beyond, as far as the lens has them. `None` where it has
    /// none off its axis.
    pub fn new(at: &LensAt<'_>, highest_mm: f64) -> Option<Self> {
        let mut rays: Vec<ChiefRay> = Vec::new();
        let rises = |rays: &[ChiefRay], next: &ChiefRay| {
            let (field, height) = rays.last().map_or((0.0, 0.0), |last| (last.field_rad, last.image_height_mm));
            next.field_rad > field && next.image_height_mm > height
        };
        let corner = at.chief_ray_at_height(highest_mm);
        let beyond = at.chief_ray_at_height(BEYOND * highest_mm).map(|chief| chief.stop_rad);
        let end = beyond.or(corner.map(|chief| BEYOND * chief.stop_rad)).unwrap_or(FRAC_PI_2);
        for i in 1..=ANGLES {
            match at.chief_ray_of_stop_angle(end * f64::from(i) / f64::from(ANGLES)) {
                Ok(chief) if rises(&rays, &chief) => rays.push(chief),
                // Beyond, there are none, or the lens folds its image.
                Ok(_) | Err(_) => break,
            }
        }
        rays.extend(corner.filter(|corner| rises(&rays, corner)));
        let column = |on_axis: f64, of: &dyn Fn(&ChiefRay) -> f64| -> Vec<f64> {
            std::iter::once(on_axis).chain(rays.iter().map(of)).collect()
        };
        let fields = column(0.0, &|chief| chief.field_rad);
        let heights = column(0.0, &|chief| chief.image_height_mm);
        let pupils = column(at.first_order().entrance_pupil_mm, &ChiefRay::entrance_pupil_mm);
        let last = rays.last()?;
        Some(Self {
            field: MonotoneCubic::new(heights.clone(), fields.clone())?,
            pupil: MonotoneCubic::new(heights.clone(), pupils.clone())?,
            height_of_field: MonotoneCubic::new(fields.clone(), heights)?,
            pupil_of_field: MonotoneCubic::new(fields, pupils)?,
            highest_mm: last.image_height_mm,
            widest_rad: last.field_rad,
            widest_stop_rad: last.stop_rad,
        })
    }

    /// Greatest image height of the map, mm.
    pub fn highest_mm(&self) -> f64 {
        self.highest_mm
    }

    /// Field angle at the greatest image height, rad.
    pub fn widest_rad(&self) -> f64 {
        self.widest_rad
    }

    /// Angle at the stop of the ray at the greatest image height, rad.
    pub fn widest_stop_rad(&self) -> f64 {
        self.widest_stop_rad
    }

    /// Field angle of an image height in mm, rad; `None` beyond the map.
    pub fn field_rad(&self, height_mm: f64) -> Option<f64> {
        (height_mm <= self.highest_mm).then(|| self.field.eval(height_mm))
    }

    /// Line of sight of a sensor point, mm from the axis; `None` beyond the map.
    pub fn sighting(&self, point: DVec2) -> Option<Sighting> {
        let height = point.length();
        let field = self.field_rad(height)?;
        // The image of what is on one side of the axis lies on the other.
        let outward = if height > 0.0 { -point / height } else { DVec2::ZERO };
        let (sin, cos) = field.sin_cos();
        Some(Sighting { direction: (outward * sin).extend(-cos), pupil_mm: self.pupil.eval(height) })
    }

    /// The sensor point, mm from the axis, whose chief ray passes through a point of the scene, mm, z = 0 at the first
    /// vertex; `None` where none in the map does.
    ///
    /// The ray of the field angle θ crosses the axis at z(θ), the entrance pupil, which moves: θ is where
    /// θ = atan2(ρ, z(θ) − z) of the point's distance ρ from the axis, by fixed-point steps and the secant method.
    pub fn place(&self, point: DVec3) -> Option<DVec2> {
        let from_axis = point.truncate().length();
        let aimed = |field: f64| from_axis.atan2(self.pupil_of_field.eval(field) - point.z);
        let mut last = aimed(0.0);
        let mut off_last = aimed(last) - last;
        let mut field = last + off_last;
        for _ in 0..MOST_STEPS {
            if (field - last).abs() <= PRECISION_RAD {
                break;
            }
            let off = aimed(field) - field;
            let slope = (off - off_last) / (field - last);
            (last, off_last) = (field, off);
            field -= if slope != 0.0 { off / slope } else { 0.0 };
        }
        let is_found = (aimed(field) - field).abs() < 1e3 * PRECISION_RAD && (0.0..=self.widest_rad).contains(&field);
        let outward = if from_axis > 0.0 { point.truncate() / from_axis } else { DVec2::ZERO };
        is_found.then(|| -outward * self.height_of_field.eval(field))
    }
}
