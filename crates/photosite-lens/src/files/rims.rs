//! Rims that programs draw and authors estimate, cut back to the glass that exists.

use super::beam;
use super::draft::Draft;
use super::report::rounded;
use crate::Lens;
use crate::checks::{check_shape, crossing};
use crate::prescription::{Position, Prescription};

/// Number of bisections in the search for the largest rim.
const STEPS: u32 = 40;

/// Cuts semi-apertures back to where the surface exists and does not run through the next one, in any position, unless
/// that would cut the beam on the axis or a chief ray; then the check refuses the lens. `derived` are surfaces whose
/// semi-aperture the file does not give: they are bounded by the glass itself.
pub(super) fn cut_back(prescription: &mut Prescription, draft: &mut Draft, derived: &[usize]) {
    let count = prescription.surfaces.len();
    let is_whole = prescription.surfaces.iter().all(|surface| surface.semi_aperture_mm.is_some_and(|r| r > 0.0));
    let stops = prescription.surfaces.iter().filter(|surface| surface.is_stop).count();
    let is_known = |position: &Position| position.gaps.iter().all(|(row, _)| *row < count);
    if !is_whole || stops != 1 || !prescription.positions.iter().all(is_known) {
        return;
    }
    let mut needed: Option<Vec<f64>> = None;
    for number in 0..count {
        let given = rim(prescription, number);
        let fits = |radius: f64| check_shape(&prescription.surfaces[number], radius).is_ok();
        if let Some(radius) = largest(given, fits) {
            let needed = needed.get_or_insert_with(|| needed_radii(prescription, draft));
            let why = format!("{} has no surface", draft.rows[number].name);
            cut(prescription, draft, Cut { number, radius, needed: needed[number], why }, derived);
        }
    }
    for number in 0..count {
        for setting in 0..prescription.positions.len().max(1) {
            let Some(found) = crossing(&in_setting(prescription, setting), number) else { continue };
            if found.next >= count {
                continue;
            }
            // The smaller one, but a stop's radius is the f-number.
            let is_stop = |i: usize| prescription.surfaces[i].is_stop;
            let is_first = rim(prescription, number) <= rim(prescription, found.next);
            let cut_one = if (is_first && !is_stop(number)) || is_stop(found.next) { number } else { found.next };
            let mut tried = prescription.clone();
            let fits = |radius: f64| {
                tried.surfaces[cut_one].semi_aperture_mm = Some(radius);
                crossing(&in_setting(&tried, setting), number).is_none()
            };
            if let Some(radius) = largest(rim(prescription, cut_one), fits) {
                let needed = needed.get_or_insert_with(|| needed_radii(prescription, draft));
                let why = format!("{} runs through {}", draft.rows[number].name, draft.rows[found.next].name);
                cut(prescription, draft, Cut { number: cut_one, radius, needed: needed[cut_one], why }, derived);
            }
        }
    }
}

/// A cut of a rim: the surface, the radius, the least radius that the beam needs, and the reason; lengths in mm.
struct Cut {
    number: usize,
    radius: f64,
    needed: f64,
    why: String,
}

fn cut(prescription: &mut Prescription, draft: &mut Draft, cut: Cut, derived: &[usize]) {
    let Cut { number, radius, needed, why } = cut;
    let reaches_beam = radius < needed;
    if reaches_beam && !derived.contains(&number) {
        return;
    }
    let given = rim(prescription, number);
    let beam = if reaches_beam { ", which stops light of the beam on the axis or at the edge" } else { "" };
    let note = format!(
        "{why} beyond {radius:.4} mm from the axis: the semi-aperture of {}, {} mm, is cut back to that{beam}",
        draft.rows[number].name,
        rounded(given)
    );
    if reaches_beam {
        draft.warnings.push(note);
    } else {
        draft.assume(note);
    }
    prescription.surfaces[number].semi_aperture_mm = Some(radius);
}

fn rim(prescription: &Prescription, number: usize) -> f64 {
    prescription.surfaces[number].semi_aperture_mm.unwrap_or(0.0)
}

/// Lens in a position, or with its own gaps where it has no positions.
fn in_setting(prescription: &Prescription, setting: usize) -> Lens {
    let lens = Lens::unchecked(prescription);
    prescription.positions.get(setting).map_or(lens.clone(), |position| lens.in_position(position))
}

/// Least radius of each surface over all positions.
fn needed_radii(prescription: &Prescription, draft: &Draft) -> Vec<f64> {
    let mut needed = vec![0.0_f64; prescription.surfaces.len()];
    for setting in 0..prescription.positions.len().max(1) {
        let position = prescription.positions.get(setting);
        let claimed = position.and_then(|position| position.half_field_deg).or(draft.claims.half_field_deg);
        let angles: Vec<f64> = draft.fields.iter().map(|field| field.angle_deg).chain(claimed).collect();
        let in_position = beam::needed(&in_setting(prescription, setting), &angles);
        needed.iter_mut().zip(in_position).for_each(|(needed, here)| *needed = needed.max(here));
    }
    needed
}

/// Largest radius below `given` that fits, rounded down to 0.1 µm. `None` where `given` fits, or nothing does.
fn largest(given: f64, mut fits: impl FnMut(f64) -> bool) -> Option<f64> {
    if fits(given) {
        return None;
    }
    let (mut good, mut bad) = (0.0, given);
    for _ in 0..STEPS {
        let middle = 0.5 * (good + bad);
        *(if fits(middle) { &mut good } else { &mut bad }) = middle;
    }
    Some((good * 1e4).floor() / 1e4).filter(|radius| *radius > 0.0 && fits(*radius))
}
