//! CODE V's sequences of commands, `.seq`: commands of three letters with values, separated by line ends or `;`.

mod commands;
mod private;

use crate::checks::MOST_SURFACES;
use crate::files::draft::MOST_POSITIONS;
use crate::files::draft::too_many_surfaces;
use std::collections::BTreeMap;

use self::commands::{Command, commands};
use super::draft::{Draft, Fault, Field, Medium, Numbers, Opening, Read, Row, Setting};
use super::text::number;
use crate::glass;
use crate::prescription::Glass;

/// Commands that draw, optimise, weigh or name, and change no ray. Codes of variables (CCY, THC, GLC, KC, AC …) are
/// those of the optimiser.
const WITHOUT_EFFECT: &[&str] = &[
    "LEN", "INI", "WTF", "WTW", "TEM", "WL", "REF", "XAN", "XOB", "XIM", "XRI", "VUX", "VLX", "CCY", "CCX", "THC",
    "GLC", "KC", "AC", "BC", "CC", "DC", "EC", "FC", "GC", "HC", "JC", "SLB", "DER", "GO", "PIM", "SPH", "ASP", "CON",
    "TIT", "DIM", "RDM", "SO", "SI", "IC", "PRE", "CRV", "END", "WRX", "WRY", "COM", "OUT", "PWL", "MFL", "CUM", "RSI",
    "FRI", "FRC", "FRO", "COF",
];

/// Commands of anything but centred refracting surfaces of revolution.
const REFUSED: &[(&str, &str)] = &[
    ("SPS", "a special surface"),
    ("DIF", "a diffractive surface"),
    ("GRT", "a diffraction grating"),
    ("HOE", "a holographic element"),
    ("CYL", "a cylinder, which is not a surface of revolution"),
    ("YTO", "a toroid, which is not a surface of revolution"),
    ("XTO", "a toroid, which is not a surface of revolution"),
    ("AAS", "an anamorphic asphere, which is not a surface of revolution"),
    ("NSS", "a non-sequential range"),
    ("GRA", "a glass whose index varies in it"),
];

/// Tilts and decentres, which may be present as 0.
const TILTS: [&str; 6] = ["XDE", "YDE", "ZDE", "ADE", "BDE", "CDE"];

/// Meaning of the first number of a surface of a sequence, given by its RDM command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FirstNumber {
    /// The radius R, mm.
    Radius,
    /// The curvature 1/R.
    Curvature,
}

/// State of the reader.
#[derive(Default)]
struct Reader {
    draft: Draft,
    mm: f64,
    has_unit: bool,
    first_number: Option<FirstNumber>,
    without_rdm: Option<FirstNumber>,
    /// First numbers of the surfaces, whose meaning may be given later.
    first_numbers: Vec<f64>,
    /// Glasses that the file defines, by name.
    glasses: BTreeMap<String, Glass>,
    object_gap: Option<f64>,
    defocus: f64,
    has_image: bool,
    angles: Vec<f64>,
    upper: Vec<f64>,
    lower: Vec<f64>,
}

/// Reads a file.
///
/// `without_rdm` gives the meaning of first numbers in a file without RDM; an RDM of the file takes precedence.
pub(super) fn read(text: &str, without_rdm: Option<FirstNumber>) -> Read<Draft> {
    let commands = commands(text);
    let private::Catalogue { glasses, ignored, warnings } = private::glasses(&commands)?;
    let mut reader = Reader { mm: 1.0, glasses, without_rdm, ..Reader::default() };
    ignored.into_iter().for_each(|what| reader.draft.ignore(what));
    reader.draft.warnings = warnings;
    for command in commands.iter().filter(|command| !command.is_private) {
        reader.command(command)?;
    }
    reader.finish()
}

impl Reader {
    fn command(&mut self, command: &Command) -> Read<()> {
        let Command { line, words, .. } = command;
        let line = *line;
        let values = || words[1..].iter().filter_map(|word| number(word)).collect::<Vec<f64>>();
        match command.key.as_str() {
            "TIT" => self.draft.name = words[1..].join(" "),
            "DIM" => {
                self.mm = match words.get(1).and_then(|word| word.chars().next()).map(|c| c.to_ascii_uppercase()) {
                    Some('M') => 1.0,
                    Some('C') => 10.0,
                    Some('I') => 25.4,
                    _ => {
                        let message = format!("DIM {}: not a known unit", words[1..].join(" "));
                        return Err(Fault::at(line, message).help("write DIM M for mm, DIM C for cm, DIM I for inches"));
                    }
                };
                self.has_unit = true;
            }
            "RDM" => {
                let is_off = words.get(1).is_some_and(|word| word.to_ascii_uppercase().starts_with('N'));
                self.first_number = Some(if is_off { FirstNumber::Curvature } else { FirstNumber::Radius });
            }
            "EPD" => self.draft.opening = Some(Opening::EntrancePupil(command.positive(1)?)),
            "FNO" => self.draft.opening = Some(Opening::FNumber(command.positive(1)?)),
            "NA" | "NAO" => self.draft.ignore(format!("{}, an aperture by an angle", command.key)),
            "YAN" => self.angles = values(),
            "VUY" => self.upper = values(),
            "VLY" => self.lower = values(),
            "YIM" | "YRI" => self.draft.claims.image_half_diagonal_mm = largest(&values()),
            "YOB" => self.draft.ignore("YOB, fields as heights of the object"),
            "SO" => self.object_gap = values().get(1).copied(),
            "SI" => {
                self.has_image = true;
                if let [curvature, rest @ ..] = &values()[..] {
                    if *curvature != 0.0 {
                        self.draft.ignore("the curvature of SI: sensors are flat");
                    }
                    self.defocus = rest.first().copied().unwrap_or(0.0);
                }
            }
            "S" => self.surface(command)?,
            "ZOO" => self.zoom(command)?,
            key if TILTS.contains(&key) => {
                if values().iter().any(|&value| value != 0.0) {
                    let message = format!("{key} {}: a tilt or a decentre", words[1..].join(" "));
                    return Err(Fault::at(line, message).help("only lenses whose surfaces share one axis can be read"));
                }
            }
            key => {
                if let Some((_, what)) = REFUSED.iter().find(|(refused, _)| *refused == key) {
                    return Err(Fault::at(line, format!("{}: {what}", words.join(" ")))
                        .help("lenses are spheres, conics and aspheres (ASP) of revolution"));
                }
                self.of_surface(command)?;
            }
        }
        Ok(())
    }

    /// Surface of `S 23.5 9.0 SLAL8_OHARA`: the first number, the thickness, the glass.
    fn surface(&mut self, command: &Command) -> Read<()> {
        let Command { line, words, .. } = command;
        if self.draft.rows.len() >= MOST_SURFACES {
            return Err(too_many_surfaces(*line));
        }
        let name = format!("surface {}", self.draft.rows.len() + 1);
        let value = |i: usize| match words.get(i) {
            None => Ok(0.0),
            Some(word) => number(word).ok_or_else(|| Fault::at(*line, format!("{name}: {word} is not a number"))),
        };
        let (first, thickness) = (value(1)?, value(2)?);
        let medium = match words.get(3) {
            Some(word) => self.glass(word, *line, &name)?,
            None => Medium::Air,
        };
        self.first_numbers.push(first);
        self.draft.rows.push(Row { line: Some(*line), name, thickness_mm: thickness, medium, ..Row::default() });
        Ok(())
    }

    fn glass(&mut self, word: &str, line: usize, surface: &str) -> Read<Medium> {
        let upper = word.to_ascii_uppercase();
        if upper == "REFL" {
            return Err(Fault::at(line, format!("{surface}: REFL, a mirror"))
                .help("lenses refract at every surface; catadioptric ones cannot be read"));
        }
        if upper == "AIR" {
            return Ok(Medium::Air);
        }
        if let Some(glass) = self.glasses.get(&upper) {
            return Ok(Medium::Defined(glass.clone()));
        }
        if let Some((nd, vd)) = glass::code(word) {
            return Ok(Medium::Patent { nd, vd });
        }
        if let Some(index) = number(word) {
            let message = format!("{surface}: the glass {index} is not a code of n_d and ν_d");
            return Err(Fault::at(line, message).help("517000.520000 is n_d 1.517, ν_d 52.0; so is 1.517:52.0"));
        }
        let (name, catalogues) = match word.split_once('_') {
            Some((name, catalogue)) => (name, vec![catalogue.to_owned()]),
            None => (word, Vec::new()),
        };
        Ok(Medium::Named { name: name.to_owned(), catalogues, numbers: Numbers::None })
    }

    /// Applies a command to the surface before it, or to the one that it names, as `STO S5`.
    fn of_surface(&mut self, command: &Command) -> Read<()> {
        let Command { line, key, .. } = command;
        let row = match command.surface {
            // Surfaces count from 1; 0 is the object.
            Some(number) => number.checked_sub(1),
            None => self.draft.rows.len().checked_sub(1),
        };
        let order = asphere_order(key);
        if order.is_none() && !matches!(key.as_str(), "STO" | "CIR" | "K" | "THI" | "RDY" | "CUY" | "CUF" | "GLA") {
            if !WITHOUT_EFFECT.contains(&key.as_str()) {
                self.draft.ignore(ignored_command(key));
            }
            return Ok(());
        }
        if self.has_image && command.surface.is_none() {
            // It belongs to the image surface, which limits nothing.
            return Ok(());
        }
        let Some(row) = row.filter(|&row| row < self.draft.rows.len()) else {
            return Err(Fault::at(*line, format!("{}: there is no such surface", command.words.join(" "))));
        };
        let name = self.draft.rows[row].name.clone();
        let arguments = command.arguments();
        let value = || {
            let word = arguments.first().copied().unwrap_or_default();
            number(word).ok_or_else(|| Fault::at(*line, format!("{name}: {key} {word}: not a number")))
        };
        match key.as_str() {
            "STO" => self.draft.rows[row].is_stop = true,
            // The mechanical edge, holes and obscurations are no clear aperture.
            "CIR" => match arguments.first().map(|word| word.to_ascii_uppercase()).as_deref() {
                Some("EDG") => {}
                Some("OBS" | "HOL") => self.draft.ignore(format!("{name}: CIR OBS, an obscured middle")),
                _ => self.draft.rows[row].semi_aperture_mm = Some(value()?),
            },
            "K" => self.draft.rows[row].conic = value()?,
            // A solve instead of a number keeps the number that the surface has.
            "THI" if arguments.first().is_some_and(|word| number(word).is_none()) => {}
            "THI" => {
                let gap = value()?;
                match command.zoom {
                    Some(zoom) => self.zoomed(row, zoom, gap, *line)?,
                    None => self.draft.rows[row].thickness_mm = gap,
                }
            }
            "RDY" | "CUY" => {
                let given = value()?;
                let wanted = self.first_number.or(self.without_rdm).unwrap_or(FirstNumber::Radius);
                let is_as_wanted = (key == "RDY") == (wanted == FirstNumber::Radius);
                self.first_numbers[row] = if is_as_wanted || given == 0.0 { given } else { 1.0 / given };
                self.first_number.get_or_insert(wanted);
            }
            "CUF" => {
                if value()? != 0.0 {
                    return Err(Fault::at(*line, format!("{name}: CUF, a Fresnel surface")));
                }
            }
            "GLA" => {
                let word = arguments.first().copied().unwrap_or_default().to_owned();
                self.draft.rows[row].medium = self.glass(&word, *line, &name)?;
            }
            _ => {
                let (order, coefficient) = (order.unwrap_or(4), value()?);
                let asphere = &mut self.draft.rows[row].asphere;
                asphere.retain(|(known, _)| *known != order);
                if coefficient != 0.0 {
                    asphere.push((order, coefficient));
                }
            }
        }
        Ok(())
    }

    /// Applies a zoom command: `ZOO 4`, `ZOO THI S5 2.29 61.27 101.8 130.05`, `ZOO YAN F2 …`.
    fn zoom(&mut self, command: &Command) -> Read<()> {
        let Command { line, words, .. } = command;
        if let Some(count) = words.get(1).and_then(|word| word.parse::<usize>().ok()) {
            return self.zoom_positions(count, *line);
        }
        let what = words.get(1).map(|word| word.to_ascii_uppercase()).unwrap_or_default();
        let values: Vec<f64> = words[2.min(words.len())..].iter().filter_map(|word| number(word)).collect();
        let (row, count) = (command.surface.and_then(|number| number.checked_sub(1)), self.draft.settings.len());
        match what.as_str() {
            "THI" => {
                let Some(row) = row.filter(|&row| row < self.draft.rows.len()) else {
                    return Err(Fault::at(*line, format!("{}: there is no such surface", words.join(" "))));
                };
                if values.len() != count {
                    let message =
                        format!("{}: {} thicknesses of {count} zoom positions", words.join(" "), values.len());
                    return Err(
                        Fault::at(*line, message).help("write one for each position, after ZOO and their number")
                    );
                }
                for (zoom, gap) in values.into_iter().enumerate() {
                    self.zoomed(row, zoom + 1, gap, *line)?;
                }
            }
            "YAN" => {
                for (setting, angle) in self.draft.settings.iter_mut().zip(values) {
                    let most = setting.half_field_deg.unwrap_or(0.0).max(angle.abs());
                    setting.half_field_deg = (most > 0.0).then_some(most);
                }
            }
            "FNO" => {
                for (setting, f_number) in self.draft.settings.iter_mut().zip(values) {
                    setting.f_number = (f_number > 0.0).then_some(f_number);
                }
            }
            "TIT" => {
                for (setting, label) in self.draft.settings.iter_mut().zip(&words[2..]) {
                    setting.label.clone_from(label);
                }
            }
            "THC" | "VUY" | "VLY" | "VUX" | "VLX" => {}
            _ => self.draft.ignore(format!("ZOO {what}, which differs from position to position")),
        }
        Ok(())
    }

    fn zoom_positions(&mut self, count: usize, line: usize) -> Read<()> {
        if count > MOST_POSITIONS {
            let message = format!("ZOO {count}: more than {} positions", MOST_POSITIONS);
            return Err(Fault::at(line, message));
        }
        let named = |number| Setting { label: format!("zoom {number}"), ..Setting::default() };
        self.draft.settings = if count > 1 { (1..=count).map(named).collect() } else { Vec::new() };
        Ok(())
    }

    fn zoomed(&mut self, row: usize, zoom: usize, gap: f64, line: usize) -> Read<()> {
        let count = self.draft.settings.len();
        let Some(setting) = zoom.checked_sub(1).and_then(|i| self.draft.settings.get_mut(i)) else {
            return Err(Fault::at(line, format!("zoom position {zoom} of {count}"))
                .help("write ZOO and the number of positions before their values"));
        };
        setting.gaps.retain(|(known, _)| *known != row);
        setting.gaps.push((row, gap));
        Ok(())
    }

    fn finish(self) -> Read<Draft> {
        let Some(first_number) = self.first_number.or(self.without_rdm) else {
            return Err(Fault::of_file("RDM does not say whether surfaces have radii or curvatures").help(
                "write RDM Y before the surfaces if the first number of each is its radius, RDM N if it is 1/R; or \
                 convert it by `photosite lens FILE --radii -o lens.toml`, or --curvatures",
            ));
        };
        if !self.has_image {
            return Err(Fault::of_file("there is no SI, the image surface").help("end the surfaces with SI 0 0"));
        }
        let mut draft = self.draft;
        match (self.first_number, self.without_rdm) {
            (None, _) => draft.assume(match first_number {
                FirstNumber::Radius => {
                    "the first number of each surface is its radius, as you say: the file has no RDM"
                }
                FirstNumber::Curvature => "the first number of each surface is 1/R, as you say: the file has no RDM",
            }),
            (Some(own), Some(wanted)) if own != wanted => {
                draft.warnings.push("the RDM of the file holds, which says otherwise than you do".to_owned());
            }
            (Some(_), _) => {}
        }
        for (row, &first) in draft.rows.iter_mut().zip(&self.first_numbers) {
            row.radius_mm = match first_number {
                _ if first == 0.0 => None,
                FirstNumber::Radius => Some(first),
                FirstNumber::Curvature => Some(1.0 / first),
            };
        }
        if !self.has_unit {
            draft.assume("lengths are mm: the file has no DIM");
        }
        if self.defocus != 0.0 {
            let last = draft.rows.len().wrapping_sub(1);
            if let Some(row) = draft.rows.last_mut() {
                row.thickness_mm += self.defocus;
            }
            for (_, gap) in
                draft.settings.iter_mut().flat_map(|setting| &mut setting.gaps).filter(|(row, _)| *row == last)
            {
                *gap += self.defocus;
            }
            draft.assume(format!(
                "the thickness on SI, a defocus of {} mm, counts to the last gap",
                self.defocus * self.mm
            ));
        }
        if let Some(gap) = self.object_gap.filter(|gap| gap.abs() < 1e9 && *gap != 0.0) {
            let gap = gap * self.mm;
            draft.assume(format!(
                "the file focuses on an object {gap} mm before the first surface; its last gap is for that"
            ));
        }
        draft.claims.half_field_deg = largest(&self.angles);
        let at = |list: &Vec<f64>, i: usize| list.get(i).copied().unwrap_or(0.0);
        draft.fields = self
            .angles
            .iter()
            .enumerate()
            .map(|(i, &angle_deg)| Field { angle_deg, vignetting: [at(&self.upper, i), at(&self.lower, i)] })
            .collect();
        draft.derives_apertures = true;
        let limits: Vec<bool> = draft.rows.iter().map(|row| row.semi_aperture_mm.is_some()).collect();
        draft.drop_dummies(&limits);
        draft.scale(self.mm);
        Ok(draft)
    }
}

fn ignored_command(key: &str) -> String {
    match key {
        "REX" | "REY" | "ELX" | "ELY" | "ADX" | "ADY" => {
            format!("{key}, an aperture that is not a circle around the axis")
        }
        "PIK" => "PIK, which ties values to others: they are taken as they stand".to_owned(),
        _ => format!("{key}, a command that is not known"),
    }
}

/// Order of a coefficient's letter: A is r⁴, B r⁶ and so on; there is no I.
fn asphere_order(key: &str) -> Option<u32> {
    let at = ["A", "B", "C", "D", "E", "F", "G", "H", "J"].iter().position(|letter| *letter == key)?;
    Some(4 + 2 * at as u32)
}

fn largest(values: &[f64]) -> Option<f64> {
    let most = values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    (most > 0.0).then_some(most)
}
