//! Semi-apertures that the whole beam needs.

use crate::lens::Lens;
use crate::prescription::Prescription;

/// Semi-aperture of a surface, mm, that passes the beam of the claimed f-number on the axis and at the edge of the
/// claimed field, to first order at the d line: |y| + |ȳ| of marginal and chief ray. `None` where the prescription
/// claims neither or cannot be traced.
pub(crate) fn semi_aperture_mm(prescription: &Prescription, surface: usize) -> Option<f64> {
    let mut whole = prescription.clone();
    whole.positions.clear();
    // Wide enough for paraxial rays, which nothing cuts off.
    whole.surfaces.iter_mut().for_each(|surface| surface.semi_aperture_mm = Some(1.0));
    let lens = Lens::unchecked(&whole);
    let at = lens.at(photosite_core::spectrum::dispersion::lines::D);
    let first_order = at.first_order();
    let marginal = first_order.efl_mm / (2.0 * prescription.claims.f_number?);
    let slope = prescription.claims.half_field_deg?.to_radians().tan();
    let marginal = at.paraxial_heights(marginal, 0.0).nth(surface)?;
    let chief = at.paraxial_heights(-first_order.entrance_pupil_mm * slope, slope).nth(surface)?;
    let is_stop = prescription.surfaces[surface].is_stop;
    let size = marginal.abs() + if is_stop { 0.0 } else { chief.abs() };
    (size.is_finite() && size > 0.0).then_some(size)
}
