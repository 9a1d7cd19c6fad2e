//! The figures that a photographer asks of a lens in front of a sensor: depth of field, hyperfocal distance, angle of
//! view, scale.

use glam::{DVec2, DVec3};

use super::Camera;
use crate::optics::Seen;

/// Wavelength that the diffraction spot is stated at, m: where the eye sees best.
const DIFFRACTION_M: f64 = 550e-9;
/// The circle of confusion that nobody states is the diagonal of the sensor over this: 30 µm of 36 × 24 mm.
const DIAGONAL_OVER_CIRCLE: f64 = 1440.0;

/// Figures of a lens, focused, in front of a sensor. Distances count from the entrance pupil, m.
///
/// With the diameter D of the entrance pupil, the distance v of the sensor (of a lone lens) and the distance u in
/// focus, a point at the distance u' becomes a circle of the diameter c = D·v·|1/u − 1/u'|. What is acceptable of it
/// bounds the depth of field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensFigures {
    /// The acceptable circle of confusion c, m.
    pub circle_of_confusion_m: f64,
    /// Nearest and farthest distance within depth of field, 1/u' = 1/u ± c/(D·v), which are u·(H − f)/(H + u − 2f) and
    /// u·(H − f)/(H − u) with the hyperfocal distance H; the second is infinite from u = H on. `None` where nothing is
    /// as sharp, and where everything is, behind a pinhole.
    pub depth_of_field_m: Option<[f64; 2]>,
    /// Hyperfocal distance, m: with the lens focused on it, depth of field reaches to infinity, H = f²/(N·c) + f of a
    /// lone lens; `None` of what cannot be focused at infinity.
    pub hyperfocal_m: Option<f64>,
    /// Diameter D of the entrance pupil, m.
    pub entrance_pupil_m: f64,
    /// Angle of view from left to right, from top to bottom and from corner to corner, rad; `None` where one of the two
    /// sees nothing.
    pub angle_of_view_rad: [Option<f64>; 3],
    /// Width and height of the field that is seen at the focus distance, m; `None` where that is infinite or there is
    /// none, and of lenses whose image is not flat.
    pub field_at_focus_m: Option<[f64; 2]>,
    /// Magnification: size of the image over that of an object at the focus distance; `None` where that distance is
    /// infinite or there is none, and for lenses whose image is not flat.
    pub magnification: Option<f64>,
    /// Diameter of the first dark ring of Airy's pattern, 2.44·λ·v/D at 550 nm, m.
    pub diffraction_spot_m: f64,
}

impl Camera {
    /// Figures of the camera's lens for an acceptable circle of confusion, m: left out, the diagonal of the sensor over
    /// 1440. `None` without a lens.
    pub fn figures(&self, circle_of_confusion_m: Option<f64>) -> Option<LensFigures> {
        let entrance_pupil_m = self.entrance_pupil_m()?;
        let size_m = DVec2::from_array([0, 1].map(|i| f64::from(self.resolution[i]) * self.pitch_m[i]));
        let c = circle_of_confusion_m.unwrap_or(size_m.length() / DIAGONAL_OVER_CIRCLE);
        let in_focus = self.focus_distance_m();
        let is_focused = self.has_focus() && in_focus > 0.0;
        let [width, height] = self.resolution.map(f64::from);
        let seen = |x, y| self.seen(DVec2::new(x, y));
        let ends = [
            [seen(0.0, height / 2.0), seen(width, height / 2.0)],
            [seen(width / 2.0, 0.0), seen(width / 2.0, height)],
            [seen(0.0, 0.0), seen(width, height)],
        ];
        let angle = |a: DVec3, b: DVec3| a.cross(b).length().atan2(a.dot(b));
        let between = |[a, b]: [Option<Seen>; 2]| Some((a?, b?));
        let at_focus = (is_focused && in_focus.is_finite() && self.projection().is_flat()).then_some(in_focus);
        let field_at_focus_m = at_focus.and_then(|u| {
            let across = |i: usize| between(ends[i]).map(|(a, b)| (b.chief - a.chief).length() * u);
            Some([across(0)?, across(1)?])
        });
        Some(LensFigures {
            circle_of_confusion_m: c,
            depth_of_field_m: if self.has_focus() { self.depth_of_field(c) } else { None },
            hyperfocal_m: self.hyperfocal(c),
            entrance_pupil_m,
            angle_of_view_rad: ends.map(|pair| between(pair).map(|(a, b)| angle(a.direction, b.direction))),
            field_at_focus_m,
            magnification: at_focus.map(|u| self.intrinsics().fx * self.pitch_m[0] / u),
            diffraction_spot_m: 2.44 * DIFFRACTION_M * self.working_f_number()?,
        })
    }

    fn depth_of_field(&self, c: f64) -> Option<[f64; 2]> {
        let sharp = 1.0 / self.focus_distance_m();
        let reach = c / (self.entrance_pupil_m()? * self.perspective_distance_m());
        let [near, far] = [sharp + reach, sharp - reach];
        (near > 0.0).then(|| [1.0 / near, if far > 0.0 { 1.0 / far } else { f64::INFINITY }])
    }

    /// Hyperfocal distance, m. With the lens focused on it, v = v∞·(1 + c/D) with the distance v∞ of the sensor at
    /// which the lens is focused at infinity.
    fn hyperfocal(&self, c: f64) -> Option<f64> {
        let v_infinity = self.image_distance_at_infinity_m?;
        let opening = self.entrance_pupil_m()? * self.chief_slope;
        // 1/u = c/(D·v), as D and v are those of the entrance pupil.
        Some(opening * v_infinity * (1.0 + c / opening) / (c * self.chief_slope.powi(2)))
    }
}
