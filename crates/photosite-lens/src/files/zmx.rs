//! OpticStudio's (Zemax') sequential lens files, `.zmx`: a line for each value, `SURF n` begins a surface.

use crate::checks::MOST_SURFACES;
use crate::files::draft::MOST_POSITIONS;
use crate::files::draft::too_many_surfaces;
use crate::files::patent::patent_in;
use crate::files::text::mm_of;
use crate::files::text::positive;
use std::collections::BTreeMap;

use super::draft::{Draft, Fault, Field, Medium, Numbers, Opening, Read, Row, Setting};
use super::text::number;

/// Records that draw, optimise, tolerate or weigh, and change no ray.
const WITHOUT_EFFECT: &[&str] = &[
    "VERS", "LANG", "AUTH", "PFIL", "ENVD", "GFAC", "RAIM", "PUSH", "SDMA", "ROPD", "PICB", "FWGN", "POLS", "GLRS",
    "GSTD", "NSCD", "COFN", "HIDE", "MIRR", "SLAB", "POPS", "COMM", "FIMP", "MEMA", "OEMA", "MAZH", "VPAR", "VDSZ",
    "PZUP", "SSID", "BLNK", "TOL", "MOFF", "OMMA", "HYPR", "TRAC", "DBDT", "VANN", "XANG", "GLCB", "ACOS", "LUID",
    "IWDP", "EERA", "STUD", "DMFS", "SCBD", "RCMF", "WWGT", "WWGN", "WAVN", "PWAV", "WAVM", "WAVL", "XFLN", "VDXN",
    "VCXN", "ZVDX", "ZVDY", "ZVCX", "ZVCY", "ZVAN", "TOTR", "RSCE", "DLTT", "VCON", "EDGE", "GCRD", "MNCA", "MNEA",
    "MCOM", "MNCG", "MNEG", "MXCA", "MXCG", "NOTE", "MODE", "CONF", "PKUP", "PPAR",
];

/// Surface types other than refracting surfaces of revolution, with descriptions.
const REFUSED: &[(&str, &str)] = &[
    ("COORDBRK", "a coordinate break, which tilts or moves the axis"),
    ("PARAXIAL", "a paraxial lens, which has no glass"),
    ("DGRATING", "a diffraction grating"),
    ("BINARY_1", "a diffractive surface"),
    ("BINARY_2", "a diffractive surface"),
    ("BINARY_3", "a diffractive surface"),
    ("FRESNELS", "a Fresnel lens"),
    ("TOROIDAL", "a toroid, which is not a surface of revolution"),
    ("BICONICX", "a biconic, which is not a surface of revolution"),
    ("NONSEQCO", "a non-sequential component"),
    ("USERSURF", "a surface that a program of its own computes"),
];

/// Shape of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Shape {
    #[default]
    Standard,
    /// Even asphere: PARM n is the coefficient of r^(2n).
    Even,
    /// Odd asphere: PARM n is the coefficient of r^n.
    Odd,
    /// Extended even asphere: XDAT 1 is the number of terms, XDAT 2 the radius that r is divided by, the others follow
    /// from r² in steps of 2.
    ExtendedEven,
    /// Extended odd asphere: as the even one, but from r¹ in steps of 1.
    ExtendedOdd,
}

/// State of a surface while it is read.
#[derive(Debug, Default)]
struct Surface {
    row: Row,
    shape: Shape,
    /// PARM and XDAT by number, with their lines.
    parameters: BTreeMap<u32, (usize, f64)>,
    extra: BTreeMap<u32, (usize, f64)>,
    is_infinite: bool,
    /// Whether CLAP or FLAP declares that the surface cuts rays off.
    limits: bool,
}

/// Records before and behind the surfaces.
#[derive(Debug, Default)]
struct System {
    mm: Option<f64>,
    catalogues: Vec<String>,
    field_kind: Option<i64>,
    field_count: Option<usize>,
    fields: Vec<f64>,
    decentre: Vec<f64>,
    compression: Vec<f64>,
    configurations: usize,
    /// Thicknesses of the configurations: surface, configuration from 1, line, value.
    thicknesses: Vec<(usize, usize, usize, f64)>,
}

/// Reads a file.
pub(super) fn read(text: &str) -> Read<Draft> {
    let mut draft = Draft { derives_apertures: true, ..Draft::default() };
    let mut system = System::default();
    let mut surfaces: Vec<Surface> = Vec::new();
    let mut notes: Vec<String> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line_number = i + 1;
        let (key, rest) = line.trim().split_once(char::is_whitespace).unwrap_or((line.trim(), ""));
        let rest = rest.trim();
        if key == "SURF" {
            let name = format!("SURF {}", surfaces.len());
            surfaces
                .push(Surface { row: Row { line: Some(line_number), name, ..Row::default() }, ..Surface::default() });
            // The object and the image are the two more that a file has.
            if surfaces.len() > MOST_SURFACES + 2 {
                return Err(too_many_surfaces(line_number));
            }
        } else if key == "NOTE" {
            notes.push(rest.trim_start_matches(|c: char| c.is_ascii_digit()).trim().to_owned());
        } else if !of_system(key, rest, line_number, &mut system, &mut draft)? {
            let is_indented = line.starts_with(char::is_whitespace);
            match surfaces.last_mut() {
                Some(surface) => of_surface(key, rest, line_number, surface, &mut draft, is_indented)?,
                None => unknown(key, &mut draft),
            }
        }
    }
    let note = notes.join(" ");
    draft.patent = patent_in(&note);
    finish(draft, system, surfaces)
}

/// Reads a record of the system; false where it is none.
fn of_system(key: &str, rest: &str, line: usize, system: &mut System, draft: &mut Draft) -> Read<bool> {
    let words: Vec<&str> = rest.split_whitespace().collect();
    let numbers = || words.iter().map_while(|word| number(word)).collect::<Vec<f64>>();
    match key {
        "MODE" if words.first().is_some_and(|mode| *mode != "SEQ") => {
            let mode = words[0];
            return Err(Fault::at(line, format!("MODE {mode}: a lens of non-sequential objects"))
                .help("only sequential lenses, MODE SEQ, are a list of surfaces"));
        }
        "NAME" => draft.name = rest.trim_matches('"').to_owned(),
        "UNIT" => {
            let unit = words.first().copied().unwrap_or_default();
            system.mm = Some(mm_of(unit).ok_or_else(|| {
                Fault::at(line, format!("UNIT {unit}: not a known unit")).help("write MM, CM, IN or METER")
            })?);
        }
        "ENPD" => draft.opening = Some(Opening::EntrancePupil(positive(&words, key, line)?)),
        "FNUM" => draft.opening = Some(Opening::FNumber(positive(&words, key, line)?)),
        "OBNA" => draft.ignore("OBNA, an aperture by the angle at the object: the stop's own radius holds"),
        "FLOA" => draft.opening = None,
        "GCAT" => system.catalogues = words.iter().map(|&word| word.to_owned()).collect(),
        "FTYP" => {
            system.field_kind = numbers().first().map(|&kind| kind as i64);
            system.field_count = numbers().get(2).map(|&count| count.max(0.0) as usize);
        }
        "YFLN" => system.fields = numbers(),
        "VDYN" => system.decentre = numbers(),
        "VCYN" => system.compression = numbers(),
        "XFLN" if numbers().iter().any(|&x| x != 0.0) => {
            draft.ignore("XFLN, fields in x: a lens of revolution has them in y as well");
        }
        "MNUM" => system.configurations = words.first().and_then(|word| word.parse().ok()).unwrap_or(1),
        "THIC" => {
            let [surface, configuration, value] = [0, 1, 2].map(|i| words.get(i).and_then(|word| number(word)));
            let (Some(surface), Some(configuration), Some(value)) = (surface, configuration, value) else {
                return Err(Fault::at(line, format!("THIC {rest}: surface, configuration and thickness are needed")));
            };
            system.thicknesses.push((surface.max(0.0) as usize, configuration.max(0.0) as usize, line, value));
        }
        _ => return Ok(false),
    }
    Ok(true)
}

/// Reads a record of a surface.
fn of_surface(
    key: &str,
    rest: &str,
    line: usize,
    surface: &mut Surface,
    draft: &mut Draft,
    is_indented: bool,
) -> Read<()> {
    let words: Vec<&str> = rest.split_whitespace().collect();
    let name = surface.row.name.clone();
    let first = |what: &str| {
        let word = words.first().copied().unwrap_or_default();
        number(word).ok_or_else(|| Fault::at(line, format!("{name}: {key} {word}: not a number")).help(what))
    };
    match key {
        "TYPE" => {
            let kind = words.first().copied().unwrap_or("STANDARD");
            surface.shape = match kind {
                "STANDARD" => Shape::Standard,
                "EVENASPH" => Shape::Even,
                "ODDASPHE" => Shape::Odd,
                "XASPHERE" => Shape::ExtendedEven,
                "XOSPHERE" => Shape::ExtendedOdd,
                other => {
                    let known = REFUSED.iter().find(|(refused, _)| *refused == other);
                    let what = known.map_or("a type that is not supported", |(_, what)| what);
                    return Err(Fault::at(line, format!("{name}: TYPE {other}, {what}")).help(
                        "lenses are centred refracting surfaces: STANDARD, EVENASPH, ODDASPHE, XASPHERE, XOSPHERE",
                    ));
                }
            };
        }
        "CURV" => {
            let curvature = first("write 1/R, 0 where the surface is flat")?;
            surface.row.radius_mm = (curvature != 0.0).then(|| 1.0 / curvature);
        }
        "DISZ" => {
            surface.is_infinite = words.first().is_some_and(|word| word.eq_ignore_ascii_case("INFINITY"));
            if !surface.is_infinite {
                surface.row.thickness_mm = first("write the distance to the next surface, or INFINITY")?;
            }
        }
        "GLAS" => surface.row.medium = glass(&words, line, &name)?,
        "CONI" => surface.row.conic = first("write the conic constant k, 0 for a sphere")?,
        "PARM" | "XDAT" => {
            let index = words.first().and_then(|word| word.parse::<u32>().ok());
            let value = words.get(1).and_then(|word| number(word));
            let (Some(index), Some(value)) = (index, value) else {
                return Err(Fault::at(line, format!("{name}: {key} {rest} is not a number and its value")));
            };
            if index > 100 {
                return Err(Fault::at(line, format!("{name}: {key} {index}, where surfaces have at most 100")));
            }
            let list = if key == "PARM" { &mut surface.parameters } else { &mut surface.extra };
            list.insert(index, (line, value));
        }
        "DIAM" => {
            let drawn = first("write the semi-diameter")?;
            if !surface.limits {
                surface.row.semi_aperture_mm = (drawn > 0.0).then_some(drawn);
            }
        }
        // Inner and outer radius.
        "CLAP" | "FLAP" => {
            let [inner, outer] = [0, 1].map(|i| words.get(i).and_then(|word| number(word)));
            let Some(outer) = outer else {
                return Err(Fault::at(line, format!("{name}: {key} {rest} is no inner and outer radius")));
            };
            if inner.is_some_and(|inner| inner > 0.0) {
                draft.ignore(format!("{name}: the obscured middle of {key}"));
            }
            surface.row.semi_aperture_mm = Some(outer);
            surface.limits = true;
        }
        "SQAP" | "ELAP" | "SPID" | "UDAD" | "USAP" | "OBSC" | "OBSQ" | "OBEL" => {
            draft
                .ignore(format!("{name}: {key}, an aperture that is not a circle around the axis; DIAM stands for it"));
        }
        "OBDC" => draft.ignore(format!("{name}: OBDC, an aperture beside the axis")),
        "STOP" => surface.row.is_stop = true,
        "COAT" => draft.ignore("COAT, names of coatings, whose layers the file does not hold"),
        // Where the merit function begins, records are no longer those of surfaces.
        _ if is_indented || WITHOUT_EFFECT.contains(&key) => unknown(key, draft),
        _ => {}
    }
    Ok(())
}

/// Notes a record with an unknown effect.
fn unknown(key: &str, draft: &mut Draft) {
    let is_record = !key.is_empty() && key.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_');
    if is_record && !WITHOUT_EFFECT.contains(&key) {
        draft.ignore(format!("{key}, a record that is not known"));
    }
}

/// Medium of `GLAS name mode pickup nd vd dP …`: mode 1 is a model glass, of n_d, ν_d and the deviation of P_gF.
fn glass(words: &[&str], line: usize, surface: &str) -> Read<Medium> {
    let name = words.first().copied().unwrap_or_default();
    let value = |i: usize| words.get(i).and_then(|word| number(word));
    if name.eq_ignore_ascii_case("MIRROR") {
        return Err(Fault::at(line, format!("{surface}: GLAS MIRROR, a mirror"))
            .help("lenses refract at every surface; catadioptric ones cannot be read"));
    }
    if name.is_empty() {
        return Err(Fault::at(line, format!("{surface}: GLAS names no glass")));
    }
    let is_model = value(1) == Some(1.0) || name.starts_with("___");
    let numbers = value(3).zip(value(4)).filter(|(nd, _)| *nd != 0.0);
    if !is_model {
        let numbers = numbers.map_or(Numbers::None, |(nd, vd)| Numbers::Spare(nd, vd));
        return Ok(Medium::Named { name: name.to_owned(), catalogues: Vec::new(), numbers });
    }
    let Some((nd, vd)) = numbers else {
        return Err(Fault::at(line, format!("{surface}: GLAS {name} is a model glass without n_d and ν_d")));
    };
    if vd == 0.0 {
        return Ok(Medium::Index(nd));
    }
    match (value(5).unwrap_or(0.0), name.starts_with("___")) {
        (0.0, true) => Ok(Medium::Patent { nd, vd }),
        // The name is that of the glass if its numbers are.
        (0.0, false) => {
            let numbers = Numbers::OfGlass(nd, vd);
            Ok(Medium::Named { name: name.to_owned(), catalogues: Vec::new(), numbers })
        }
        (deviation, _) => Ok(Medium::Model { nd, vd, deviation }),
    }
}

/// Puts the draft together from system and surfaces.
fn finish(mut draft: Draft, system: System, surfaces: Vec<Surface>) -> Read<Draft> {
    let Some(mm) = system.mm else {
        return Err(Fault::of_file("no UNIT says what the lengths are in").help("write UNIT MM before the surfaces"));
    };
    if surfaces.len() < 3 {
        let message = format!("{} surfaces, the object and the image among them", surfaces.len());
        return Err(Fault::of_file(message).help("a lens has SURF 0 for the object, the last SURF for the image"));
    }
    let last = surfaces.len() - 1;
    let object = &surfaces[0];
    if !object.is_infinite && object.row.thickness_mm > 0.0 {
        let distance = object.row.thickness_mm * mm;
        draft.assume(format!("the file focuses on an object {distance} mm before SURF 1; its last gap is for that"));
    }
    if surfaces[last].row.radius_mm.is_some() {
        draft.ignore("the curvature of the image surface: sensors are flat");
    }
    if surfaces[last].row.is_stop || object.row.is_stop {
        return Err(
            Fault::of_file("the stop is the object or the image surface").help("put STOP into a surface of the lens")
        );
    }
    let mut limits = Vec::new();
    for surface in surfaces.into_iter().skip(1).take(last - 1) {
        limits.push(surface.limits);
        draft.rows.push(row(surface, &system.catalogues)?);
    }
    if limits.iter().any(|limits| !limits) {
        draft.assume(
            "DIAM, the radius that OpticStudio draws and that cuts no rays there, cuts rays off where neither CLAP nor \
             FLAP gives another",
        );
    }
    settings(&mut draft, &system)?;
    fields(&mut draft, &system);
    // The stop's radius follows from the opening, unless the file limits it.
    if let Some(stop) = draft.rows.iter().position(|row| row.is_stop)
        && draft.opening.is_some()
        && !limits[stop]
    {
        draft.rows[stop].semi_aperture_mm = None;
    }
    draft.drop_dummies(&limits);
    draft.scale(mm);
    Ok(draft)
}

/// Row of a surface.
fn row(surface: Surface, catalogues: &[String]) -> Read<Row> {
    let Surface { mut row, shape, parameters, extra, is_infinite, .. } = surface;
    if is_infinite {
        let message = format!("{}: DISZ INFINITY, where the next surface is part of the lens", row.name);
        return Err(Fault { line: row.line, invalid: photosite_core::Invalid::new("", message) });
    }
    if let Medium::Named { catalogues: wanted, .. } = &mut row.medium {
        *wanted = catalogues.to_vec();
    }
    let mut terms: Vec<(usize, u32, f64)> = Vec::new();
    match shape {
        Shape::Standard => {}
        Shape::Even | Shape::Odd => {
            let step = if shape == Shape::Even { 2 } else { 1 };
            let nonzero = parameters.into_iter().filter(|(n, (_, value))| *n > 0 && *value != 0.0);
            terms.extend(nonzero.map(|(n, (line, value))| (line, n * step, value)));
        }
        Shape::ExtendedEven | Shape::ExtendedOdd => {
            let step = if shape == Shape::ExtendedEven { 2 } else { 1 };
            let count = extra.get(&1).map_or(0, |(_, count)| count.max(0.0) as u32);
            let norm = extra.get(&2).map_or(1.0, |(_, norm)| *norm);
            for (n, (line, value)) in extra.into_iter().filter(|(n, (_, value))| *n > 2 && *value != 0.0) {
                if n - 2 > count {
                    continue;
                }
                let order = (n - 2) * step;
                let coefficient = value / norm.powi(order as i32);
                if !coefficient.is_finite() {
                    let message = format!("{}: XDAT 2, the radius that r is divided by, is {norm}", row.name);
                    return Err(Fault::at(line, message).help("write a radius above 0"));
                }
                terms.push((line, order, coefficient));
            }
        }
    }
    if let Some((line, ..)) = terms.iter().find(|(_, order, _)| *order < 2) {
        let message = format!("{}: a term r¹, which makes a cone with a tip", row.name);
        return Err(Fault::at(*line, message).help("leave it 0: surfaces are smooth on the axis"));
    }
    row.asphere = terms.into_iter().map(|(_, order, value)| (order, value)).collect();
    Ok(row)
}

/// Reads the configurations, each a position with its gaps.
fn settings(draft: &mut Draft, system: &System) -> Read<()> {
    if system.configurations <= 1 {
        return Ok(());
    }
    if system.configurations > MOST_POSITIONS {
        let message = format!("MNUM {}: more than {} configurations", system.configurations, MOST_POSITIONS);
        return Err(Fault::of_file(message));
    }
    draft.settings = (1..=system.configurations)
        .map(|number| Setting { label: format!("configuration {number}"), ..Setting::default() })
        .collect();
    for &(surface, configuration, line, value) in &system.thicknesses {
        let Some(setting) = configuration.checked_sub(1).and_then(|i| draft.settings.get_mut(i)) else {
            let message = format!("THIC of configuration {configuration} of {}", system.configurations);
            return Err(Fault::at(line, message));
        };
        match surface.checked_sub(1) {
            None => setting.object_distance_mm = (value < 1e9).then_some(value),
            Some(row) if row < draft.rows.len() => setting.gaps.push((row, value)),
            Some(_) => return Err(Fault::at(line, format!("THIC {surface}: no surface of the lens has that number"))),
        }
    }
    Ok(())
}

/// Reads fields of view, where the file gives them as angles; else the radius of the image.
fn fields(draft: &mut Draft, system: &System) {
    let count = system.field_count.unwrap_or(system.fields.len());
    let fields = || system.fields.iter().take(count.max(1));
    let largest = fields().fold(0.0, |most: f64, y| most.max(y.abs()));
    if largest == 0.0 {
        return;
    }
    match system.field_kind.unwrap_or(0) {
        0 => {
            draft.claims.half_field_deg = Some(largest);
            let at = |list: &Vec<f64>, i: usize| list.get(i).copied().unwrap_or(0.0);
            let with_vignetting = fields().enumerate().map(|(i, &angle)| {
                // The pupil is scaled by 1 − VCY and moved by VDY.
                let (decentre, compression) = (at(&system.decentre, i), at(&system.compression, i));
                Field { angle_deg: angle, vignetting: [compression - decentre, compression + decentre] }
            });
            draft.fields = with_vignetting.collect();
        }
        2 | 3 => draft.claims.image_half_diagonal_mm = Some(largest),
        _ => draft.ignore("the fields, which are heights of the object"),
    }
}
