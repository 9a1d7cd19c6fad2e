//! Sanity checks: properties that hint at a misread or mistyped file.

use photosite_core::spectrum::dispersion::lines;

use crate::Lens;
use crate::prescription::Prescription;

/// Largest relative deviation of the focal length from the file's claim.
const FOCAL_LENGTH: f64 = 0.02;
/// Largest relative deviation of the f-number from the file's claim: apertures in tables are often estimates.
const F_NUMBER: f64 = 0.1;
/// Largest distortion at the edge of a field that is not wide, per cent.
const DISTORTION_PERCENT: f64 = 20.0;
/// Half field that counts as wide, degrees: such lenses distort on purpose.
const WIDE_DEG: f64 = 45.0;
/// Largest axial colour from F to C, relative to the focal length.
const AXIAL_COLOUR: f64 = 0.005;
/// Wavelengths that silicon responds to, nm.
const SENSOR_NM: [f64; 2] = [300.0, 1100.0];

/// Warnings, each with its likely cause.
pub(super) fn warnings(prescription: &Prescription, lens: &Lens) -> Vec<String> {
    let mut warnings = Vec::new();
    let at = lens.at(lines::D);
    let first_order = at.first_order();
    let efl = first_order.efl_mm;
    let claims = &prescription.claims;
    if let Some(claimed) = claims.focal_length_mm.filter(|claimed| (efl / claimed - 1.0).abs() > FOCAL_LENGTH) {
        warnings.push(format!(
            "the focal length is {efl:.3} mm, where the file claims {claimed} mm: look for a wrong radius, index or gap"
        ));
    }
    if let Some(claimed) = claims.f_number.filter(|claimed| (first_order.f_number / claimed - 1.0).abs() > F_NUMBER) {
        warnings.push(format!(
            "the stop opens the lens to f/{:.2}, where the file claims f/{claimed:.2}: look at the radius of the stop",
            first_order.f_number
        ));
    }
    let half_field = prescription.positions.first().and_then(|first| first.half_field_deg).or(claims.half_field_deg);
    if let Some(half_field) = half_field.filter(|angle| *angle > 0.0 && *angle < WIDE_DEG)
        && let Some(chief) = at.chief_ray(half_field.to_radians())
    {
        let distortion = chief.distortion_percent(efl);
        if distortion.abs() > DISTORTION_PERCENT {
            let cause = if prescription.surfaces.iter().any(|surface| !surface.asphere.is_empty()) {
                "look at the orders of the aspheres, and whether the table gives k or 1 + k"
            } else {
                "look at the field and the position of the stop"
            };
            warnings.push(format!("distortion is {distortion:.1} % at {half_field}°: {cause}"));
        }
    }
    let [f, c] = [lines::F, lines::C].map(|line| lens.at(line).first_order().bfl_mm);
    // A lens of a single glass cannot do better.
    let mut glasses: Vec<&str> =
        prescription.surfaces.iter().filter_map(|s| s.glass.as_ref()).map(|glass| glass.name.as_str()).collect();
    glasses.sort_unstable();
    glasses.dedup();
    if (f - c).abs() > AXIAL_COLOUR * efl && glasses.len() > 1 {
        let colour = c - f;
        warnings.push(format!(
            "the foci of F and C are {colour:.3} mm apart, {:.2} % of the focal length, more than most lenses leave: look for a wrong Abbe number",
            100.0 * colour.abs() / efl
        ));
    }
    extrapolated(prescription, &mut warnings);
    warnings
}

/// Warns of glasses whose formula was fitted to less than a sensor's wavelengths.
fn extrapolated(prescription: &Prescription, warnings: &mut Vec<String>) {
    let mut names: Vec<&str> = Vec::new();
    let mut fitted = [0.0, f64::INFINITY];
    for glass in prescription.surfaces.iter().filter_map(|surface| surface.glass.as_ref()) {
        let Some([from, to]) = glass.range_nm else { continue };
        if from > SENSOR_NM[0] || to < SENSOR_NM[1] {
            fitted = [f64::max(fitted[0], from), f64::min(fitted[1], to)];
            if !names.contains(&glass.name.as_str()) {
                names.push(&glass.name);
            }
        }
    }
    if !names.is_empty() {
        warnings.push(format!(
            "the indices of {} are fitted to {} to {} nm; beyond, their formulas go on as they stand",
            names.join(", "),
            fitted[0],
            fitted[1]
        ));
    }
}
