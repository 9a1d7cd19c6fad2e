//! photosite's own form of a prescription, as TOML or JSON with the same keys.

use crate::checks::MOST_SURFACES;
use crate::files::draft::MOST_POSITIONS;
use crate::files::draft::too_many;
use crate::files::text::mm_of;
use std::collections::BTreeMap;
use std::ops::Range;

use photosite_core::Invalid;
use photosite_core::spectrum::{Dispersion, Spectrum, library};
use photosite_core::{suggest, toml_text};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;
use toml::Spanned;
use toml::de::DeValue;

use super::draft::{Draft, Fault, Medium, Numbers, Opening, Read, Row, Setting};
use super::format::json_formats;
use super::json_value;
use crate::glass;
use crate::prescription::{Blades, Coating, Glass, Layer, LayerIndex};

/// A lens file. Lengths are in `unit`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LensFile {
    #[serde(default)]
    name: String,
    source: Option<String>,
    licence: Option<String>,
    patent: Option<String>,
    note: Option<String>,
    /// Source of the semi-apertures.
    semi_apertures: Option<String>,
    unit: Option<String>,
    focal_length: Option<f64>,
    f_number: Option<f64>,
    entrance_pupil_diameter: Option<f64>,
    half_field_deg: Option<f64>,
    image_half_diagonal: Option<f64>,
    surfaces: Vec<SurfaceFile>,
    #[serde(default)]
    glasses: BTreeMap<String, GlassFile>,
    blades: Option<BladesFile>,
    #[serde(default)]
    positions: Vec<PositionFile>,
    /// Figures of the lens by other programs, in files that tests compare with.
    figures: Option<IgnoredAny>,
    largest_differences: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SurfaceFile {
    radius: Option<f64>,
    thickness: f64,
    glass: Option<String>,
    semi_aperture: Option<f64>,
    #[serde(default)]
    conic: f64,
    #[serde(default)]
    asphere: BTreeMap<String, f64>,
    #[serde(default)]
    stop: bool,
    coating: Option<CoatingFile>,
}

/// Coating: `"none"` for bare glass, or layers from the air side.
#[derive(Deserialize)]
#[serde(untagged)]
enum CoatingFile {
    Word(String),
    Layers(Vec<LayerFile>),
}

/// Layer of a coating: its index, or a table of it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerFile {
    index: Option<IndexFile>,
    #[serde(default)]
    k: f64,
    table: Option<TableFile>,
    thickness_nm: f64,
}

/// Index of a layer: a number, or the name of a medium or a metal of the library.
#[derive(Deserialize)]
#[serde(untagged)]
enum IndexFile {
    Number(f64),
    Name(String),
}

/// Table of n and k at wavelengths.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TableFile {
    wavelength_nm: Vec<f64>,
    n: Vec<f64>,
    k: Option<Vec<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GlassFile {
    sellmeier_b: Option<Vec<f64>>,
    sellmeier_c_um2: Option<Vec<f64>>,
    polynomial: Option<Vec<[f64; 2]>>,
    conrady: Option<[f64; 3]>,
    cauchy: Option<[f64; 3]>,
    table: Option<TableFile>,
    n: Option<f64>,
    nd: Option<f64>,
    vd: Option<f64>,
    range_nm: Option<[f64; 2]>,
    source: Option<String>,
}

/// Blades of the stop: their number, or that and the angle of the first corner.
#[derive(Deserialize)]
#[serde(untagged)]
enum BladesFile {
    Count(u32),
    Turned { count: u32, rotation_deg: f64 },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PositionFile {
    #[serde(default)]
    label: String,
    #[serde(default)]
    gaps: BTreeMap<String, f64>,
    half_field_deg: Option<f64>,
    f_number: Option<f64>,
    stop_semi_aperture: Option<f64>,
    object_distance: Option<f64>,
    focal_length: Option<f64>,
}

/// Reads a TOML file.
pub(super) fn read_toml(text: &str) -> Read<Draft> {
    let file: LensFile = toml_text::read(text).map_err(|error| {
        let line = error.span.map(|span| 1 + text[..span.start].matches('\n').count());
        Fault { line, invalid: Invalid::new("", error.message) }
    })?;
    draft(file)
}

/// Reads a JSON file.
pub(super) fn read_json(text: &str) -> Read<Draft> {
    if let Ok(value) = json_value::parsed(text) {
        check_is_own(&value)?;
    }
    let file: LensFile = serde_json::from_str(text).map_err(|error| {
        let whole = error.to_string();
        // Its place is said by the line.
        let message = whole.split(" at line ").next().unwrap_or(&whole).to_owned();
        Fault { line: Some(error.line()), invalid: Invalid::new("", message) }
    })?;
    draft(file)
}

/// Refuses JSON of other programs by characteristic keys, before any of its keys is called unknown.
fn check_is_own(value: &Value) -> Read<()> {
    let surface = value.get("surfaces").and_then(|surfaces| surfaces.get(0));
    if surface.is_some_and(|surface| surface.get("thickness").is_some()) {
        return Ok(());
    }
    let keys = |value: &Value| match value.as_object().filter(|keys| !keys.is_empty()) {
        Some(keys) => {
            let more = keys.len().saturating_sub(MOST_KEYS_TOLD);
            let told: Vec<String> = keys.keys().take(MOST_KEYS_TOLD).map(|key| format!("`{key}`")).collect();
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            format!("the keys {}{more}", told.join(", "))
        }
        None => "no keys".to_owned(),
    };
    let has = match (value.get("surfaces"), surface) {
        (None, _) => {
            let others: Vec<String> = json_formats().map(|(_, key)| format!("`{key}`")).collect();
            format!("it has {}, and none of `surfaces`, {}", keys(value), others.join(", "))
        }
        (Some(_), None) => format!("it has {}, and `surfaces` is no list with a surface in it", keys(value)),
        (Some(_), Some(surface)) => {
            format!("it has {}; its first surface has {}, and no `thickness`", keys(value), keys(surface))
        }
    };
    let others: Vec<String> = json_formats().map(|(name, key)| format!("{name} (`{key}`)")).collect();
    let help = format!(
        "JSON is read as photosite's own (`unit`, and `surfaces` with `radius`, `thickness`, `glass`, `semi_aperture`, \
         one with `stop`) or as {}",
        others.join(", ")
    );
    Err(Fault::of_file(format!("not a lens in a form that is read: {has}")).help(help))
}

/// Largest number of keys that a message lists.
const MOST_KEYS_TOLD: usize = 8;

/// Bytes of the value at a path of a TOML text, or of the innermost value around it.
pub(super) fn toml_span(text: &str, path: &str) -> Option<Range<usize>> {
    let table = toml_text::parse(text).ok()?;
    let mut steps = path.split(['.', '[']).map(|step| step.trim_end_matches(']')).filter(|step| !step.is_empty());
    let mut current: &Spanned<DeValue> = table.get_ref().get(steps.next()?)?;
    for step in steps {
        let next = match current.get_ref() {
            DeValue::Table(table) => table.get(step),
            DeValue::Array(array) => step.parse::<usize>().ok().and_then(|i| array.get(i)),
            DeValue::String(_)
            | DeValue::Integer(_)
            | DeValue::Float(_)
            | DeValue::Boolean(_)
            | DeValue::Datetime(_) => None,
        };
        let Some(next) = next else { break };
        current = next;
    }
    Some(current.span())
}

fn draft(file: LensFile) -> Read<Draft> {
    let LensFile { name, source, licence, patent, unit, surfaces, glasses, blades, positions, .. } = file;
    let mm = match unit.as_deref() {
        None => {
            return Err(Fault::of_file("no `unit` says what the lengths are in")
                .help("write unit = \"mm\" before the surfaces"));
        }
        Some(unit) => mm_of(unit)
            .ok_or_else(|| at("unit", format!("{unit:?} is not a known unit")).help("write mm, cm, in or m"))?,
    };
    let mut draft = Draft { name, source, licence, patent, keeps_rims: true, ..Draft::default() };
    draft.claims.focal_length_mm = file.focal_length;
    draft.claims.f_number = file.f_number;
    draft.claims.half_field_deg = file.half_field_deg;
    draft.claims.image_half_diagonal_mm = file.image_half_diagonal;
    if file.figures.is_some() || file.largest_differences.is_some() {
        draft.ignore("`figures`, what other programs compute of the lens");
    }
    if let Some(origin) = file.semi_apertures {
        draft.assume(format!("semi-apertures: {origin}"));
    }
    if let Some(note) = file.note {
        draft.assume(format!("the file notes: {note}"));
    }
    // Where the stop has a radius, that holds.
    let pupil = file.entrance_pupil_diameter.map(Opening::EntrancePupil);
    draft.opening = pupil.or(file.f_number.map(Opening::FNumber));
    draft.blades = match blades {
        None => None,
        Some(BladesFile::Count(count)) => Some(Blades { count, rotation_deg: 0.0 }),
        Some(BladesFile::Turned { count, rotation_deg }) => Some(Blades { count, rotation_deg }),
    };
    if surfaces.len() > MOST_SURFACES {
        return Err(at("surfaces", too_many(surfaces.len())));
    }
    let mut defined = BTreeMap::new();
    for (name, glass) in glasses {
        let key = format!("glasses.{name}");
        let glass = defined_glass(&name, glass, &mut draft).map_err(|invalid| Fault::from(invalid.within(&key)))?;
        defined.insert(name, glass);
    }
    for (i, surface) in surfaces.into_iter().enumerate() {
        draft.rows.push(row(i, surface, &defined)?);
    }
    if positions.len() > MOST_POSITIONS {
        return Err(at("positions", format!("{} positions: more than {}", positions.len(), MOST_POSITIONS)));
    }
    for (i, position) in positions.into_iter().enumerate() {
        draft.settings.push(setting(i, position, draft.rows.len())?);
    }
    draft.scale(mm);
    Ok(draft)
}

fn at(key: &str, message: impl Into<String>) -> Fault {
    Invalid::new(key, message).into()
}

fn row(number: usize, surface: SurfaceFile, glasses: &BTreeMap<String, Glass>) -> Read<Row> {
    let key = format!("surfaces[{number}]");
    let mut asphere = Vec::new();
    for (order, coefficient) in surface.asphere {
        let order = order.parse::<u32>().map_err(|_| {
            at(&format!("{key}.asphere"), format!("{order:?} is not an order"))
                .help("write each order and its coefficient: { 4 = 1.2e-5, 6 = -3e-8 }")
        })?;
        if coefficient != 0.0 {
            asphere.push((order, coefficient));
        }
    }
    asphere.sort_by_key(|(order, _)| *order);
    let medium = match surface.glass {
        None => Medium::Air,
        Some(name) => match (glasses.get(&name), glass::code(&name), name.split_once('/')) {
            (Some(glass), ..) => Medium::Defined(glass.clone()),
            (None, Some((nd, vd)), _) => Medium::Patent { nd, vd },
            (None, None, Some((maker, name))) => {
                Medium::Named { name: name.to_owned(), catalogues: vec![maker.to_owned()], numbers: Numbers::None }
            }
            (None, None, None) => Medium::Named { name, catalogues: Vec::new(), numbers: Numbers::None },
        },
    };
    let coating = match surface.coating {
        None => Coating::Unknown,
        Some(CoatingFile::Word(word)) if word == "none" => Coating::Uncoated,
        Some(CoatingFile::Word(word)) => {
            return Err(at(&format!("{key}.coating"), format!("{word:?} is not a coating"))
                .help("write \"none\" for bare glass, or the layers from the air side: [{ index = 1.38, thickness_nm = 99.6 }]"));
        }
        Some(CoatingFile::Layers(layers)) => Coating::Layers(
            layers.into_iter().map(|layer| self::layer(layer, &format!("{key}.coating"))).collect::<Read<Vec<_>>>()?,
        ),
    };
    Ok(Row {
        line: None,
        name: format!("surface {number}"),
        key,
        radius_mm: surface.radius,
        thickness_mm: surface.thickness,
        medium,
        semi_aperture_mm: surface.semi_aperture,
        conic: surface.conic,
        asphere,
        is_stop: surface.stop,
        coating,
    })
}

fn layer(layer: LayerFile, key: &str) -> Read<Layer> {
    let index = match (layer.index, layer.table) {
        (Some(IndexFile::Number(n)), None) => LayerIndex::Constant { n, k: layer.k },
        (Some(IndexFile::Name(name)), None) => named(&name, key)?,
        (None, Some(table)) => {
            let zeros = vec![0.0; table.n.len()];
            let [n, k] =
                [&table.n, table.k.as_ref().unwrap_or(&zeros)].map(|values| interpolated(&table.wavelength_nm, values));
            let (Some(n), Some(k)) = (n, k) else {
                return Err(at(key, "a table whose lists differ in length, or whose wavelengths do not rise")
                    .help("write as many n (and k) as wavelengths in nm, from short to long"));
            };
            LayerIndex::Table { n, k }
        }
        (None, None) | (Some(_), Some(_)) => {
            return Err(
                at(key, "a layer has either an index or a table").help("write { index = 1.38, thickness_nm = 99.6 }")
            );
        }
    };
    Ok(Layer { index, thickness_nm: layer.thickness_nm })
}

fn named(name: &str, key: &str) -> Read<LayerIndex> {
    if let Some(metal) = library::conductor(name) {
        return Ok(LayerIndex::Table { n: metal.eta, k: metal.k });
    }
    if let Some(medium) = library::glass(name) {
        return Ok(LayerIndex::Table { n: medium.to_spectrum(), k: Spectrum::constant(0.0) });
    }
    let known: Vec<&str> = library::glasses().chain(library::conductors()).collect();
    Err(at(key, format!("no medium is called {name:?}"))
        .help(format!("write its index, or one of {}", suggest::list(name, known))))
}

/// Spectrum that is linear between values, and constant beyond the ends.
fn interpolated(wavelengths_nm: &[f64], values: &[f64]) -> Option<Spectrum> {
    let rises =
        wavelengths_nm.windows(2).all(|pair| pair[0] < pair[1]) && wavelengths_nm.iter().all(|nm| nm.is_finite());
    if !rises || wavelengths_nm.is_empty() || wavelengths_nm.len() != values.len() {
        return None;
    }
    Some(Spectrum::from_fn(|nm| {
        let after = wavelengths_nm.partition_point(|&known| known <= nm);
        match (after.checked_sub(1), wavelengths_nm.get(after)) {
            (None, _) => values[0],
            (Some(before), None) => values[before],
            (Some(before), Some(&next)) => {
                let part = (nm - wavelengths_nm[before]) / (next - wavelengths_nm[before]);
                values[before] + part * (values[after] - values[before])
            }
        }
    }))
}

/// Glass defined in the file, by the most exact form that it has.
fn defined_glass(name: &str, file: GlassFile, draft: &mut Draft) -> Result<Glass, Invalid> {
    let source = file.source.unwrap_or_else(|| "the file".to_owned());
    let glass = |dispersion: Dispersion| -> Result<Glass, Invalid> {
        let dispersion = dispersion.validated()?;
        Ok(Glass { name: name.to_owned(), source: source.clone(), dispersion, range_nm: file.range_nm })
    };
    if let Some(TableFile { wavelength_nm, n, k }) = file.table {
        let spectrum = interpolated(&wavelength_nm, &n).filter(|_| k.is_none()).ok_or_else(|| {
            Invalid::new("", "a table whose lists differ in length, whose wavelengths do not rise, or with k")
                .help("write as many n as wavelengths in nm, from short to long; glasses have no k here")
        })?;
        return glass(Dispersion::Table(spectrum));
    }
    match (file.conrady, file.sellmeier_b.zip(file.sellmeier_c_um2), file.polynomial, file.cauchy, file.n) {
        (Some([a, b_um, c_um35]), ..) => glass(Dispersion::Conrady { a, b_um, c_um35 }),
        (None, Some((b, c_um2)), ..) => glass(Dispersion::Sellmeier { b, c_um2 }),
        (None, None, Some(terms), ..) => glass(Dispersion::Polynomial { terms }),
        (None, None, None, Some([a, b_um2, c_um4]), _) => glass(Dispersion::Cauchy { a, b_um2, c_um4 }),
        (None, None, None, None, Some(n)) => glass(Dispersion::constant(n)),
        (None, None, None, None, None) => {
            let Some((nd, vd)) = file.nd.zip(file.vd) else {
                let help = "write sellmeier_b and sellmeier_c_um2, polynomial, conrady, cauchy, table, nd and vd, or n";
                return Err(Invalid::new("", "nothing says what its index is").help(help));
            };
            let (found, note) = glass::by_numbers(nd, vd)?;
            draft.assume(note);
            Ok(Glass { name: name.to_owned(), ..found })
        }
    }
}

fn setting(number: usize, position: PositionFile, rows: usize) -> Read<Setting> {
    let key = format!("positions[{number}].gaps");
    let mut gaps = Vec::new();
    for (surface, gap) in position.gaps {
        let row = surface.parse::<usize>().ok().filter(|row| *row < rows).ok_or_else(|| {
            at(&key, format!("there is no gap behind surface {surface}: there are {rows} surfaces, counted from 0"))
        })?;
        gaps.push((row, gap));
    }
    gaps.sort_by_key(|(row, _)| *row);
    let label = if position.label.is_empty() { format!("position {number}") } else { position.label };
    Ok(Setting {
        label,
        gaps,
        half_field_deg: position.half_field_deg,
        stop_semi_aperture_mm: position.stop_semi_aperture,
        object_distance_mm: position.object_distance,
        focal_length_mm: position.focal_length,
        f_number: position.f_number,
    })
}
