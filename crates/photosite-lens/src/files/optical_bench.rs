//! The text format of the Optical Bench (photonstophotos.net): sections in brackets, cells between tabs.

use crate::checks::MOST_SURFACES;
use crate::files::draft::MOST_POSITIONS;
use crate::files::draft::too_many_surfaces;
use crate::files::patent::patent_in;
use std::collections::BTreeMap;

use super::draft::{Draft, Fault, Medium, Numbers, Read, Row, Setting};
use super::text::number;

/// A line of a section: its number, and its cells.
type Cells<'a> = (usize, Vec<&'a str>);

/// Sections that are ignored.
const UNUSED: [&str; 3] = ["figure", "notes", "trial"];

/// Keys of `[constants]` that are understood, or only matter for drawings.
const CONSTANTS: [&str; 2] = ["AsphericalA2", "AsphericalOddCount"];

/// Reads a file.
pub(super) fn read(text: &str) -> Read<Draft> {
    let mut draft = Draft::default();
    let sections = sections(text, &mut draft)?;
    let section = |name: &str| sections.get(name).map_or(&[][..], Vec::as_slice);
    for (_, cells) in section("descriptive data") {
        let value = cells.get(1).copied().unwrap_or_default().to_owned();
        match cells[0].to_ascii_lowercase().as_str() {
            "title" | "lens name" => draft.name = value,
            "patent" => draft.patent = Some(value),
            "author" | "source" => draft.source = Some(value),
            _ => {}
        }
    }
    if draft.patent.is_none() {
        draft.patent = patent_in(&draft.name);
    }
    let distances = distances(section("variable distances"))?;
    claims(&mut draft, &distances);
    let mut names = Vec::new();
    for (line, cells) in section("lens data") {
        if draft.rows.len() >= MOST_SURFACES {
            return Err(too_many_surfaces(*line));
        }
        names.push(cells[0]);
        let row = row(*line, cells, &distances, &mut draft)?;
        draft.rows.push(row);
    }
    if draft.rows.is_empty() {
        return Err(Fault::of_file("there is no section [lens data] with surfaces")
            .help("an Optical Bench file has [variable distances] and [lens data], with cells between tabs"));
    }
    let orders = Orders::of(section("constants"), &mut draft)?;
    for (line, cells) in section("aspherical data") {
        asphere(*line, cells, &names, &orders, &mut draft)?;
    }
    settings(&mut draft, &names, section("lens data"), &distances)?;
    draft.assume("the diameters of the Optical Bench are its author's estimates: patents do not give them");
    Ok(draft)
}

/// Lines of each section, by its name in lower case.
fn sections<'a>(text: &'a str, draft: &mut Draft) -> Read<BTreeMap<String, Vec<Cells<'a>>>> {
    let mut sections: BTreeMap<String, Vec<Cells>> = BTreeMap::new();
    let mut current: Option<String> = None;
    for (i, line) in text.lines().enumerate() {
        let trimmed = line.trim();
        if trimmed.is_empty() || trimmed.starts_with('#') {
            continue;
        }
        if let Some(name) = trimmed.strip_prefix('[').and_then(|rest| rest.split(']').next()) {
            let name = name.trim().to_ascii_lowercase();
            let known = ["descriptive data", "constants", "variable distances", "lens data", "aspherical data"]
                .contains(&name.as_str());
            if !known && !UNUSED.iter().any(|unused| name.starts_with(unused)) {
                draft.ignore(format!("the section [{name}]"));
            }
            current = known.then_some(name);
        } else if let Some(name) = &current {
            let cells: Vec<&str> = line.trim_end().split('\t').map(str::trim).collect();
            if cells.len() < 2 && name != "descriptive data" && name != "constants" {
                return Err(
                    Fault::at(i + 1, format!("[{name}]: {trimmed:?} is one cell")).help("cells stand between tabs")
                );
            }
            sections.entry(name.clone()).or_default().push((i + 1, cells));
        }
    }
    Ok(sections)
}

/// A variable distance, or another figure that varies by position: its line, and a column for each position.
#[derive(Debug)]
struct Distance {
    line: usize,
    /// Values by position; `None` is infinity, or undefined in the file.
    columns: Vec<Option<f64>>,
}

fn distances(lines: &[Cells]) -> Read<BTreeMap<String, Distance>> {
    let mut found = BTreeMap::new();
    for (line, cells) in lines {
        let column =
            |cell: &&str| match *cell {
                "" => None,
                text if text.eq_ignore_ascii_case("infinity") || text == "∞" || text == "undefined" => Some(Ok(None)),
                text => Some(number(text).map(Some).ok_or_else(|| {
                    Fault::at(*line, format!("[variable distances] {}: {text} is not a number", cells[0]))
                })),
            };
        // Labels of positions stand in the same section.
        let columns = cells[1..].iter().filter_map(column).collect::<Read<Vec<_>>>();
        match columns {
            Ok(columns) if columns.len() <= MOST_POSITIONS => {
                found.insert(cells[0].to_owned(), Distance { line: *line, columns });
            }
            Ok(columns) => return Err(Fault::at(*line, format!("{}: {} positions", cells[0], columns.len()))),
            Err(_) if is_label(cells[0]) => {}
            Err(fault) => return Err(fault),
        }
    }
    Ok(found)
}

/// Whether a row is a label.
fn is_label(name: &str) -> bool {
    ["names", "scenarios", "label", "labels", "position"].contains(&name.to_ascii_lowercase().as_str())
}

fn figure<'a>(distances: &'a BTreeMap<String, Distance>, name: &str) -> Option<&'a Distance> {
    distances.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|(_, distance)| distance)
}

fn first(distances: &BTreeMap<String, Distance>, name: &str) -> Option<f64> {
    figure(distances, name)?.columns.first().copied().flatten().filter(|value| *value > 0.0)
}

/// Claims of the file for its first position.
fn claims(draft: &mut Draft, distances: &BTreeMap<String, Distance>) {
    draft.claims.focal_length_mm = first(distances, "Focal Length");
    draft.claims.f_number = first(distances, "F-Number");
    draft.claims.half_field_deg = first(distances, "Angle of View").map(|full| full / 2.0);
    draft.claims.image_half_diagonal_mm = first(distances, "Image Height").map(|diameter| diameter / 2.0);
}

/// Row of a surface, `5 ⇥ 15.83 ⇥ d5 ⇥ 1.6727 ⇥ 20.0 ⇥ 32.1 ⇥ S-TIM25 ⇥ Ohara`: id, radius, thickness, n_d, diameter,
/// ν_d, name, maker.
fn row(line: usize, cells: &[&str], distances: &BTreeMap<String, Distance>, draft: &mut Draft) -> Read<Row> {
    let cell = |i: usize| cells.get(i).copied().filter(|cell| !cell.is_empty() && *cell != "undefined");
    let name = format!("surface {}", cells[0]);
    let needed = |i: usize, what: &str| {
        let text = cell(i).ok_or_else(|| Fault::at(line, format!("{name}: there is no {what}")))?;
        number(text).ok_or_else(|| Fault::at(line, format!("{name}: the {what} {text} is not a number")))
    };
    let (mut is_stop, mut radius_mm) = (false, None);
    match cell(1) {
        Some("AS") => is_stop = true,
        Some("FS" | "CG") | None => {}
        Some(text) if text.eq_ignore_ascii_case("infinity") => {}
        Some(_) => radius_mm = Some(needed(1, "radius")?).filter(|radius| *radius != 0.0),
    }
    let thickness_mm = match cell(2) {
        None => 0.0,
        Some(text) => match (number(text), distances.get(text)) {
            (Some(thickness), _) => thickness,
            (None, Some(distance)) => distance.columns.first().copied().flatten().ok_or_else(|| {
                Fault::at(distance.line, format!("{text}: the gap behind {name} is infinite, undefined or missing"))
            })?,
            (None, None) => {
                return Err(Fault::at(line, format!("{name}: the thickness {text} is not in [variable distances]"))
                    .help("give it there, with a column for each position"));
            }
        },
    };
    let medium = match cell(3) {
        None => Medium::Air,
        Some(_) => {
            let nd = needed(3, "index")?;
            let vd = cell(5).map(|_| needed(5, "Abbe number")).transpose()?;
            match (nd, vd, cell(6)) {
                (1.0, ..) => Medium::Air,
                (_, vd, Some(glass)) => Medium::Named {
                    name: glass.to_owned(),
                    catalogues: cell(7).map(|maker| maker.to_ascii_lowercase()).into_iter().collect(),
                    numbers: vd.map_or(Numbers::None, |vd| Numbers::OfGlass(nd, vd)),
                },
                (_, Some(vd), None) => Medium::Patent { nd, vd },
                (_, None, None) => {
                    draft.assume(format!("{name}: no Abbe number, so the index is {nd} at all wavelengths"));
                    Medium::Index(nd)
                }
            }
        }
    };
    // The column is the diameter.
    let semi_aperture_mm = cell(4).map(|_| needed(4, "diameter")).transpose()?.map(|diameter| diameter / 2.0);
    Ok(Row { line: Some(line), name, radius_mm, thickness_mm, medium, semi_aperture_mm, is_stop, ..Row::default() })
}

/// Orders of the columns of an asphere.
enum Orders {
    /// Even orders from r⁴.
    FromFour,
    /// Even orders from r².
    FromTwo,
    /// Odd orders from r³, this number of them, between the even ones; then even orders alone.
    Odd(usize),
}

impl Orders {
    fn of(constants: &[Cells], draft: &mut Draft) -> Read<Self> {
        let mut orders = Self::FromFour;
        for (line, cells) in constants {
            match cells[0] {
                "AsphericalA2" => orders = Self::FromTwo,
                "AsphericalOddCount" => {
                    let text = cells.get(1).copied().unwrap_or("1");
                    let count = text.parse().ok().filter(|count| *count <= 15).ok_or_else(|| {
                        Fault::at(*line, format!("AsphericalOddCount {text}"))
                            .help("how many odd orders there are: 1 to 14")
                    })?;
                    orders = Self::Odd(count);
                }
                other if CONSTANTS.contains(&other) => {}
                other => draft.ignore(format!("the constant {other}")),
            }
        }
        Ok(orders)
    }

    /// Order of a column, counted from 0.
    fn of_column(&self, column: usize) -> usize {
        match *self {
            Self::FromFour => 4 + 2 * column,
            Self::FromTwo => 2 + 2 * column,
            // 3, 4, 5, 6, … as long as odd ones stand between; one more for each that is left out.
            Self::Odd(count) if column < 2 * count => 3 + column,
            Self::Odd(count) => 2 * (column - count) + 4,
        }
    }
}

/// Row of an asphere: id, radius, k, coefficients.
fn asphere(line: usize, cells: &[&str], names: &[&str], orders: &Orders, draft: &mut Draft) -> Read<()> {
    let id = cells[0];
    let Some(row) = names.iter().position(|name| *name == id) else {
        return Err(Fault::at(line, format!("[aspherical data]: there is no surface {id}")));
    };
    let value = |i: usize| match cells.get(i).copied().unwrap_or_default() {
        "" | "undefined" => Ok(0.0),
        text => number(text).ok_or_else(|| Fault::at(line, format!("asphere {id}: {text} is not a number"))),
    };
    let radius = match cells.get(1).copied().unwrap_or_default() {
        text if text.eq_ignore_ascii_case("infinity") => None,
        _ => Some(value(1)?).filter(|radius| *radius != 0.0),
    };
    let of_surface = draft.rows[row].radius_mm;
    let differs = |a: f64, b: f64| (a - b).abs() > 1e-6 * a.abs();
    if radius.zip(of_surface).is_some_and(|(a, b)| differs(a, b)) {
        let (radius, other) = (radius.unwrap_or(0.0), of_surface.unwrap_or(0.0));
        return Err(Fault::at(line, format!("asphere {id}: its radius is {radius}, but {other} in [lens data]")));
    }
    draft.rows[row].conic = value(2)?;
    let mut terms = Vec::new();
    for column in 0..cells.len().saturating_sub(3) {
        let coefficient = value(3 + column)?;
        if coefficient != 0.0 {
            let order = u32::try_from(orders.of_column(column)).unwrap_or(u32::MAX);
            terms.push((order, coefficient));
        }
    }
    draft.rows[row].asphere = terms;
    Ok(())
}

/// Position for each column.
fn settings(draft: &mut Draft, names: &[&str], rows: &[Cells], distances: &BTreeMap<String, Distance>) -> Read<()> {
    let variable: Vec<(usize, &str, &Distance)> = rows
        .iter()
        .enumerate()
        .filter_map(|(row, (_, cells))| {
            let name = *cells.get(2)?;
            Some((row, name, distances.get(name)?))
        })
        .collect();
    // Of other rows, such as diameters of the stop, it does not matter how many columns they have.
    let figures = ["Focal Length", "Angle of View", "F-Number", "d0"].map(|name| figure(distances, name));
    let read = variable.iter().map(|(.., distance)| *distance).chain(figures.into_iter().flatten());
    let count = read.map(|distance| distance.columns.len()).max().unwrap_or(1);
    if count <= 1 {
        return Ok(());
    }
    let column =
        |name: &str, i: usize| figure(distances, name).and_then(|figure| figure.columns.get(i).copied().flatten());
    let object = |i: usize| column("d0", i).filter(|distance| *distance > 0.0 && *distance < 1e9);
    // Of a position at a distance it may be that of its setting at infinity, or that at the distance.
    let is_of_zoom = |focal_length: f64| {
        let mut at_infinity = (0..count).filter(|i| object(*i).is_none()).filter_map(|i| column("Focal Length", i));
        at_infinity.any(|known| known == focal_length)
    };
    for i in 0..count {
        let focal_length = column("Focal Length", i);
        let object = object(i);
        let label = match (focal_length, object) {
            (Some(f), None) => format!("{f} mm"),
            (Some(f), Some(distance)) => format!("{f} mm, object at {distance} mm"),
            (None, Some(distance)) => format!("object at {distance} mm"),
            (None, None) => format!("position {}", i + 1),
        };
        let mut gaps = Vec::new();
        for &(row, name, distance) in &variable {
            let gap = *distance.columns.get(i).ok_or_else(|| {
                let message = format!("{name}: {} columns, where others have {count}", distance.columns.len());
                Fault::at(distance.line, message).help("give a column for each position")
            })?;
            let gap = gap.ok_or_else(|| {
                Fault::at(
                    distance.line,
                    format!("{name}: the gap behind surface {} is infinite or undefined", names[row]),
                )
            })?;
            gaps.push((row, gap));
        }
        draft.settings.push(Setting {
            label,
            gaps,
            half_field_deg: column("Angle of View", i).filter(|full| *full > 0.0).map(|full| full / 2.0),
            object_distance_mm: object,
            focal_length_mm: focal_length.filter(|f| is_of_zoom(*f)),
            f_number: column("F-Number", i).filter(|n| *n > 0.0),
            ..Setting::default()
        });
    }
    Ok(())
}
