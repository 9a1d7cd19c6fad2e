//! Completion of a draft to a prescription that can be traced: glasses looked up, apertures completed, all of it
//! checked.

use photosite_core::Invalid;
use photosite_core::spectrum::Dispersion;
use photosite_core::spectrum::dispersion::lines;

use super::beam;
use super::draft::{Draft, Fault, Medium, Numbers, Opening, Read, Row};
use super::format::Format;
use super::report::{Reading, Report, glasses_of, rounded};
use super::rims;
use super::sanity;
use super::zoom;
use crate::glass::{self, Found};
use crate::prescription::{Glass, Position, Prescription, Surface};
use crate::{Lens, LensAt};

/// Puts a lens together.
pub(super) fn finish(format: Format, mut draft: Draft) -> Read<Reading> {
    let mut surfaces = Vec::new();
    let mut notes = Vec::new();
    for row in &draft.rows {
        let glass = medium(row, &mut notes)?;
        surfaces.push(Surface {
            radius_mm: row.radius_mm,
            thickness_mm: row.thickness_mm,
            glass,
            semi_aperture_mm: row.semi_aperture_mm,
            conic: row.conic,
            asphere: row.asphere.clone(),
            is_stop: row.is_stop,
            coating: row.coating.clone(),
        });
    }
    notes.into_iter().for_each(|note| draft.assume(note));
    let mut prescription = Prescription {
        name: draft.name.trim().to_owned(),
        source: draft.source.clone(),
        licence: draft.licence.clone(),
        patent: draft.patent.clone(),
        claims: draft.claims,
        surfaces,
        blades: draft.blades,
        positions: positions(&draft),
    };
    if draft.last_gap_is_unused {
        refocus(&mut prescription, &mut draft);
    }
    open(&mut prescription, &mut draft);
    let derived = if draft.derives_apertures { derive_apertures(&mut prescription, &mut draft)? } else { Vec::new() };
    if !draft.keeps_rims {
        rims::cut_back(&mut prescription, &mut draft, &derived);
    }
    if let Some(lens) = provisional(&prescription, None) {
        zoom::assign(&mut prescription, &lens, &mut draft)?;
    }
    let lens = Lens::new(&prescription).map_err(|invalid| of_surface(&draft, invalid))?;
    let Draft { assumed, ignored, mut warnings, .. } = draft;
    warnings.extend(sanity::warnings(&prescription, &lens));
    let report = Report { format, glasses: glasses_of(&prescription), assumed, ignored, warnings };
    Ok(Reading { prescription, lens, report })
}

/// Fault of a key `surfaces[3].semi_aperture_mm`, by line or key as the format has it.
fn of_surface(draft: &Draft, invalid: Invalid) -> Fault {
    let found = invalid.key.find("surfaces[").and_then(|at| {
        let (number, rest) = invalid.key[at + "surfaces[".len()..].split_once(']')?;
        let row = draft.rows.get(number.parse::<usize>().ok()?)?;
        Some((row, rest.trim_start_matches('.').trim_end_matches("_mm").to_owned()))
    });
    match found {
        Some((row, field)) => {
            // The other formats have no such keys.
            let is_own = row.key.starts_with("surfaces[");
            row.fault(if is_own { &field } else { "" }, invalid)
        }
        None => Fault { line: None, invalid },
    }
}

/// Medium of the gap behind a row.
fn medium(row: &Row, notes: &mut Vec<String>) -> Read<Option<Glass>> {
    let fault = |message: String, help: String| row.fault("glass", Invalid::new("", message).help(help));
    match &row.medium {
        Medium::Air => Ok(None),
        Medium::Defined(glass) => Ok(Some(glass.clone())),
        Medium::Index(index) => {
            if !(*index > 0.0 && index.is_finite()) {
                return Err(fault(format!("the index {index}"), "glasses have 1.4 to 2.1".to_owned()));
            }
            let dispersion = Dispersion::constant(*index);
            let source = "one index for all wavelengths".to_owned();
            Ok(Some(Glass { name: index.to_string(), source, dispersion, range_nm: None }))
        }
        Medium::Patent { nd, vd } => by_numbers(row, *nd, *vd, notes).map(Some),
        Medium::Model { nd, vd, deviation } => {
            let dispersion = glass::conrady(*nd, *vd, *deviation).map_err(|invalid| row.fault("glass", invalid))?;
            let source = format!("Conrady's formula through n_d, ν_d and ΔP_gF = {deviation}");
            Ok(Some(Glass { name: format!("{nd}/{vd}/{deviation}"), source, dispersion, range_nm: None }))
        }
        Medium::Named { name, catalogues, numbers } => match (glass::by_name(name, catalogues), numbers) {
            (Found::Glass(found, note), numbers) => {
                notes.extend(note);
                if let Numbers::OfGlass(nd, vd) = numbers {
                    let (index, abbe) = (found.dispersion.index(lines::D), found.dispersion.abbe_number());
                    if (index - nd).abs() > 1e-4 || (abbe - vd).abs() > 0.1 {
                        notes.push(format!(
                            "{name} has n_d {index:.5}, ν_d {abbe:.2} in the catalogue, but {}, {} in the file, which are used",
                            rounded(*nd),
                            rounded(*vd)
                        ));
                        return by_numbers(row, *nd, *vd, notes).map(Some);
                    }
                }
                Ok(Some(found))
            }
            (Found::Ambiguous(_) | Found::Unknown(_), Numbers::OfGlass(nd, vd)) => {
                notes.push(format!("{name} is not taken by its name, but by its n_d {nd} and ν_d {vd}"));
                by_numbers(row, *nd, *vd, notes).map(Some)
            }
            (Found::Ambiguous(makers), Numbers::None | Numbers::Spare(..)) => Err(fault(
                format!("several makers have a glass {name}, with different indices"),
                format!("say which: {}", makers.join(", ")),
            )),
            (Found::Unknown(nearest), numbers) => {
                let mut help = match &nearest[..] {
                    [] => "there is no similar name: give its n_d and ν_d".to_owned(),
                    nearest => format!("the nearest names are {}", nearest.join(", ")),
                };
                // OpticStudio writes 1.5 and 40 where there is no model glass.
                if let Numbers::Spare(nd, vd) = numbers
                    && (*nd, *vd) != (1.5, 40.0)
                {
                    help += &format!(
                        "; if its n_d and ν_d are {nd} and {vd}, make it a model glass: GLAS ___BLANK 1 0 {nd} {vd}"
                    );
                }
                Err(fault(format!("no catalogue has a glass {name}"), help))
            }
        },
    }
}

fn by_numbers(row: &Row, nd: f64, vd: f64, notes: &mut Vec<String>) -> Read<Glass> {
    let (glass, note) = glass::by_numbers(nd, vd).map_err(|invalid| row.fault("glass", invalid))?;
    notes.push(note);
    Ok(glass)
}

fn positions(draft: &Draft) -> Vec<Position> {
    let mut rows: Vec<usize> = draft.settings.iter().flat_map(|s| s.gaps.iter().map(|(row, _)| *row)).collect();
    rows.sort_unstable();
    rows.dedup();
    let position = |setting: &super::draft::Setting| {
        // What changes at all is said of each, so that one can follow another.
        let gap = |row: usize| {
            let own = draft.rows.get(row).map_or(f64::NAN, |row| row.thickness_mm);
            setting.gaps.iter().rev().find(|(known, _)| *known == row).map_or(own, |(_, gap)| *gap)
        };
        Position {
            label: setting.label.clone(),
            gaps: rows.iter().map(|&row| (row, gap(row))).collect(),
            half_field_deg: setting.half_field_deg,
            stop_semi_aperture_mm: setting.stop_semi_aperture_mm,
            object_distance_mm: setting.object_distance_mm,
            focal_length_mm: setting.focal_length_mm.filter(|_| setting.object_distance_mm.is_some()),
        }
    };
    draft.settings.iter().map(position).collect()
}

/// Lens whose missing apertures are wide enough for paraxial rays, which nothing cuts off; `None` where it has no stop
/// or no focal length.
fn provisional(prescription: &Prescription, position: Option<&Position>) -> Option<Lens> {
    let mut wide = prescription.clone();
    wide.surfaces.iter().position(|surface| surface.is_stop)?;
    wide.surfaces.iter_mut().for_each(|surface| {
        surface.semi_aperture_mm.get_or_insert(1.0);
    });
    let lens = Lens::unchecked(&wide);
    let lens = position.or(prescription.positions.first()).map_or(lens.clone(), |position| lens.in_position(position));
    let efl = lens.at(lines::D).first_order().efl_mm;
    (efl.is_finite() && efl > 0.0).then_some(lens)
}

/// Moves the sensor to the paraxial focus of parallel light.
fn refocus(prescription: &mut Prescription, draft: &mut Draft) {
    let Some(lens) = provisional(prescription, None) else { return };
    let focus = lens.at(lines::D).first_order().bfl_mm;
    if let Some(last) = prescription.surfaces.last_mut()
        && focus.is_finite()
        && focus > 0.0
    {
        let given = last.thickness_mm;
        draft.assume(format!("the last gap is {focus:.4} mm, where parallel light is sharp; the file has {given}, which pbrt does not use"));
        last.thickness_mm = focus;
    }
}

/// Opens the stop to the file's entrance pupil or f-number, where the file gives no radius.
fn open(prescription: &mut Prescription, draft: &mut Draft) {
    let Some(stop) = prescription.surfaces.iter().position(|surface| surface.is_stop) else { return };
    let Some(lens) = provisional(prescription, None) else { return };
    let radius = |at: &LensAt, opening: Opening| match opening {
        Opening::EntrancePupil(diameter) => {
            at.lens.stop_radius_mm() * diameter / at.first_order().entrance_pupil_diameter_mm
        }
        Opening::FNumber(f_number) => at.stop_radius_of_f_number(f_number),
    };
    let at = lens.at(lines::D);
    if let (None, Some(opening)) = (prescription.surfaces[stop].semi_aperture_mm, draft.opening) {
        let found = radius(&at, opening);
        if found.is_finite() && found > 0.0 {
            prescription.surfaces[stop].semi_aperture_mm = Some(found);
            let by = match opening {
                Opening::EntrancePupil(diameter) => format!("the entrance pupil of {} mm", rounded(diameter)),
                Opening::FNumber(f_number) => format!("f/{}", rounded(f_number)),
            };
            draft.assume(format!("the stop has the radius {found:.4} mm, which {by} gives at the d line"));
        }
    }
    if let Some(Opening::FNumber(f_number)) = draft.opening {
        prescription.claims.f_number.get_or_insert(f_number);
    }
    if let (None, Some(Opening::EntrancePupil(diameter))) = (prescription.claims.f_number, draft.opening) {
        prescription.claims.f_number = Some(at.first_order().efl_mm / diameter);
    }
    // The stop of a zoom opens differently from position to position.
    for (i, setting) in draft.settings.iter().enumerate() {
        let (Some(f_number), None) = (setting.f_number, setting.stop_semi_aperture_mm) else { continue };
        let Some(lens) = provisional(prescription, Some(&prescription.positions[i])) else { continue };
        let found = radius(&lens.at(lines::D), Opening::FNumber(f_number));
        if found.is_finite() && found > 0.0 {
            prescription.positions[i].stop_semi_aperture_mm = Some(found);
        }
    }
}

/// Gives surfaces the radius of the full beam, where the format leaves it to the beam. Returns their numbers.
fn derive_apertures(prescription: &mut Prescription, draft: &mut Draft) -> Read<Vec<usize>> {
    let missing: Vec<usize> =
        (0..prescription.surfaces.len()).filter(|&i| prescription.surfaces[i].semi_aperture_mm.is_none()).collect();
    if missing.is_empty() {
        return Ok(missing);
    }
    if let Some(&stop) = missing.iter().find(|&&i| prescription.surfaces[i].is_stop) {
        let message = "neither the radius of the stop, nor the entrance pupil or the f-number is given";
        let help = "give one of them: all other radii follow from the beam that it lets through";
        return Err(draft.rows[stop].fault("semi_aperture", Invalid::new("", message).help(help)));
    }
    let Some(lens) = provisional(prescription, None) else { return Ok(missing) };
    let part = beam::open_part(&lens);
    if part < 1.0 {
        let radius = lens.stop_radius_mm();
        draft.warnings.push(format!(
            "no light fills the stop of the radius {} mm: the beam on the axis reaches {:.4} mm there, where the glass ends",
            rounded(radius),
            part * radius
        ));
    }
    let radii = beam::radii(&lens.with_stop_radius(part * lens.stop_radius_mm()), &draft.fields);
    for &i in &missing {
        // Coarser than a hair's breadth, as radii are made.
        prescription.surfaces[i].semi_aperture_mm = radii[i].map(|radius| (radius * 1e4).ceil() / 1e4);
    }
    let fields: Vec<String> = draft.fields.iter().map(|field| format!("{}°", rounded(field.angle_deg))).collect();
    let of = if fields.is_empty() { "the axis".to_owned() } else { fields.join(", ") };
    draft.assume(format!(
        "the file has no apertures for {} of {} surfaces: they are as wide as the beams of {of} with the file's vignetting",
        missing.len(),
        prescription.surfaces.len()
    ));
    Ok(missing)
}
