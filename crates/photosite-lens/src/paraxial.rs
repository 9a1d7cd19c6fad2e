//! First-order optics: focal length, pupils and images, by paraxial rays at one wavelength.

use crate::trace::LensAt;

/// First-order figures of a lens, object at infinity, at one wavelength. Lengths are mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstOrder {
    /// Effective focal length.
    pub efl_mm: f64,
    /// Back focal length: distance from the last vertex to the focus.
    pub bfl_mm: f64,
    /// Position of the entrance pupil from the first vertex; infinite for a lens that is telecentric in object space.
    pub entrance_pupil_mm: f64,
    /// Position of the exit pupil from the last vertex; infinite for a lens that is telecentric in image space.
    pub exit_pupil_mm: f64,
    /// Diameter of the entrance pupil.
    pub entrance_pupil_diameter_mm: f64,
    /// Diameter of the exit pupil.
    pub exit_pupil_diameter_mm: f64,
    /// f-number: EFL over the diameter of the entrance pupil.
    pub f_number: f64,
}

/// First-order image of a point on the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Image {
    /// Distance from the last vertex, mm.
    pub distance_mm: f64,
    /// Transverse magnification, below 0 for an inverted image.
    pub magnification: f64,
}

/// Ray transfer matrix: height y and slope u of a paraxial ray, mm and rad, before some surfaces → those behind them.
#[derive(Clone, Copy, Debug)]
struct Matrix {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
}

impl Matrix {
    const IDENTITY: Self = Self { a: 1.0, b: 0.0, c: 0.0, d: 1.0 };

    /// Product with the transfer over a distance: y′ = y + u·t.
    fn then_over(self, t: f64) -> Self {
        Self { a: self.a + t * self.c, b: self.b + t * self.d, ..self }
    }

    /// Product with refraction at a surface: u′ = (n·u − y·c·(n′ − n))/n′.
    fn then_refracted(self, curvature: f64, n: f64, behind: f64) -> Self {
        let (ratio, power) = (n / behind, curvature * (behind - n) / behind);
        Self { c: ratio * self.c - power * self.a, d: ratio * self.d - power * self.b, ..self }
    }
}

impl LensAt<'_> {
    /// Matrix of a range of surfaces and the gaps between them, without the gap behind the last.
    fn matrix(&self, surfaces: std::ops::Range<usize>) -> Matrix {
        surfaces.clone().fold(Matrix::IDENTITY, |matrix, i| {
            let over = if i == surfaces.start { matrix } else { matrix.then_over(self.lens.gap_mm(i - 1)) };
            let curvature = self.lens.surfaces()[i].profile.vertex_curvature();
            over.then_refracted(curvature, self.index_before(i), self.index_before(i + 1))
        })
    }

    /// Matrix from before the first surface to before the stop.
    fn to_stop(&self) -> Matrix {
        let stop = self.lens.stop();
        let before = self.matrix(0..stop);
        if stop == 0 { before } else { before.then_over(self.lens.gap_mm(stop - 1)) }
    }

    /// First-order figures, object at infinity. The pupils are the images of the stop through the surfaces before and
    /// behind it ([Welford86](photosite_core::references#welford86) §3.5).
    pub fn first_order(&self) -> FirstOrder {
        let surfaces = self.lens.surfaces().len();
        let (stop, radius) = (self.lens.stop(), self.lens.stop_radius_mm());
        let whole = self.matrix(0..surfaces);
        let efl_mm = -1.0 / whole.c;
        // The chief ray meets the stop at its centre: A·y + B·u = 0.
        let before = self.to_stop();
        let behind = self.matrix(stop..surfaces);
        let entrance_pupil_diameter_mm = 2.0 * radius / before.a.abs();
        FirstOrder {
            efl_mm,
            bfl_mm: -whole.a / whole.c,
            entrance_pupil_mm: before.b / before.a,
            exit_pupil_mm: -behind.b / behind.d,
            entrance_pupil_diameter_mm,
            // The matrix has the determinant n of the medium before the stop over that of air.
            exit_pupil_diameter_mm: 2.0 * radius * self.index_before(stop) / behind.d.abs(),
            f_number: efl_mm / entrance_pupil_diameter_mm,
        }
    }

    /// Image of a point on the axis at `object_distance_mm` before the first vertex, which may be infinite.
    pub fn image(&self, object_distance_mm: f64) -> Image {
        let matrix = self.matrix(0..self.lens.surfaces().len());
        if object_distance_mm.is_infinite() {
            return Image { distance_mm: -matrix.a / matrix.c, magnification: 0.0 };
        }
        // A ray of slope 1 from the point; its slope behind the lens is one over the magnification.
        let (y, u) = (matrix.a * object_distance_mm + matrix.b, matrix.c * object_distance_mm + matrix.d);
        Image { distance_mm: -y / u, magnification: 1.0 / u }
    }

    /// Distance before the first vertex, mm, of the point on the axis whose image is `image_distance_mm` behind the
    /// last one; infinite for the focus, below 0 for a point behind the vertex.
    pub fn object_distance_mm(&self, image_distance_mm: f64) -> f64 {
        let Matrix { a, b, .. } = self.matrix(0..self.lens.surfaces().len()).then_over(image_distance_mm);
        // The ray of slope 1 from the point, at the height s at the vertex, comes to the axis: a·s + b = 0.
        if a == 0.0 { f64::INFINITY } else { -b / a }
    }

    /// The radius of the stop, mm, for the f-number N, with the lens focused at infinity as it is set: EFL/(2·N·|m|),
    /// where m is the magnification from the stop to the entrance pupil.
    pub fn stop_radius_of_f_number(&self, f_number: f64) -> f64 {
        let first_order = self.first_order();
        self.lens.stop_radius_mm() * first_order.f_number / f_number
    }

    /// Heights at the surfaces, mm, of a paraxial ray with the height y and the slope u before the first one.
    pub(crate) fn paraxial_heights(&self, y: f64, u: f64) -> impl Iterator<Item = f64> {
        (0..self.lens.surfaces().len()).map(move |i| {
            let to = self.matrix(0..i);
            let to = if i == 0 { to } else { to.then_over(self.lens.gap_mm(i - 1)) };
            to.a * y + to.b * u
        })
    }
}
