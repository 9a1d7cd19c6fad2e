//! Assignment of positions at finite distances to zoom settings, where the file does not state it.

use photosite_core::spectrum::dispersion::lines;

use super::draft::{Draft, Fault, Read};
use crate::Lens;
use crate::prescription::{Position, Prescription};

/// Relative difference of focal lengths above which zoom settings are distinct.
const DISTINCT: f64 = 1e-6;

/// Gives positions at finite distances the focal length at infinity of their zoom setting, by their order: where all
/// positions at infinity come first, the others repeat them in turn; else each belongs to the one at infinity before
/// it.
pub(super) fn assign(prescription: &mut Prescription, lens: &Lens, draft: &mut Draft) -> Read<()> {
    let positions = &prescription.positions;
    let is_near = |position: &Position| position.object_distance_mm.is_some();
    let efl = |position: &Position| lens.in_position(position).at(lines::D).first_order().efl_mm;
    let at_infinity: Vec<(usize, f64)> =
        positions.iter().enumerate().filter(|(_, p)| !is_near(p)).map(|(i, p)| (i, efl(p))).collect();
    let Some(&(first, shortest)) = at_infinity.first() else { return Ok(()) };
    let is_zoom = at_infinity.iter().any(|(_, efl)| (efl / shortest - 1.0).abs() > DISTINCT);
    let lacks = |position: &Position| is_near(position) && position.focal_length_mm.is_none();
    if !is_zoom || !positions.iter().any(lacks) {
        return Ok(());
    }
    let zooms = at_infinity.len();
    let near = positions.len() - zooms;
    let come_first = at_infinity.iter().enumerate().all(|(i, (number, _))| i == *number);
    let of_position: Vec<Option<f64>> = if come_first && near.is_multiple_of(zooms) {
        (0..positions.len()).map(|i| (i >= zooms).then(|| at_infinity[i % zooms].1)).collect()
    } else if !come_first && first == 0 {
        let before = |i: usize| at_infinity.iter().rev().find(|(number, _)| *number < i).map(|(_, efl)| *efl);
        (0..positions.len()).map(|i| before(i).filter(|_| is_near(&positions[i]))).collect()
    } else {
        let message = format!(
            "the zoom has {zooms} positions at infinity and {near} at a distance, and nothing says which of those belong \
             together"
        );
        return Err(Fault::of_file(message).help(
            "give each focal length as many positions at a distance, in the order of those at infinity; or write the lens \
             as photosite's own file, with focal_length in each position at a distance",
        ));
    };
    let mut told = Vec::new();
    for (position, focal_length_mm) in prescription.positions.iter_mut().zip(of_position) {
        if let Some(focal_length_mm) = focal_length_mm.filter(|_| lacks(position)) {
            position.focal_length_mm = Some(focal_length_mm);
            told.push(format!("{} to {focal_length_mm:.4} mm", position.label));
        }
    }
    draft.assume(format!("positions at a distance belong to settings of the zoom by their order: {}", told.join(", ")));
    Ok(())
}
