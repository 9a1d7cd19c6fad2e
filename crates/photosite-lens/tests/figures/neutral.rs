//! The prescriptions and figures of `tests/reference`.

use glam::DVec3;
use photosite_core::spectrum::Dispersion;
use photosite_lens::prescription::{Blades, Claims, Glass, Position, Surface};
use photosite_lens::{Lens, Prescription};
use serde_json::Value;

/// The twelve lenses.
pub(crate) const LENSES: [&str; 12] = [
    "cooke-triplet",
    "double-gauss",
    "tessar",
    "telephoto",
    "retrofocus",
    "canon-ef50",
    "canon-ef85",
    "canon-rf24",
    "phone-us7535658",
    "nikkor-z14",
    "fisheye-170",
    "zoom-laikin",
];

/// A file of the folder.
pub(crate) fn read(name: &str) -> Value {
    let path = format!("{}/tests/reference/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Number of a value; null is NaN.
pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("not a number: {value}"))
}

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(number).collect()
}

pub(crate) fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("not a list: {value}"))
}

pub(crate) fn wavelengths(figures: &Value) -> Vec<f64> {
    numbers(&figures["wavelengths_nm"])
}

fn dispersion(glass: &Value) -> Dispersion {
    if let Some(b) = glass.get("sellmeier_b") {
        return Dispersion::Sellmeier { b: numbers(b), c_um2: numbers(&glass["sellmeier_c_um2"]) };
    }
    if let Some(terms) = glass.get("polynomial") {
        let pair = |term: &Value| [number(&term[0]), number(&term[1])];
        return Dispersion::Polynomial { terms: list(terms).iter().map(pair).collect() };
    }
    let [a, b_um, c_um35] = numbers(&glass["conrady"])[..] else { panic!("three numbers: {glass}") };
    Dispersion::Conrady { a, b_um, c_um35 }
}

/// The prescription of a file.
pub(crate) fn prescription(lens: &Value) -> Prescription {
    let glass = |name: &str| Glass {
        name: name.to_owned(),
        source: "the file".to_owned(),
        dispersion: dispersion(&lens["glasses"][name]),
        range_nm: None,
    };
    let asphere = |surface: &Value| {
        let terms = surface.get("asphere").and_then(Value::as_object);
        let term = |(order, a): (&String, &Value)| (order.parse().expect("an order"), number(a));
        terms.into_iter().flatten().map(term).collect()
    };
    let surface = |s: &Value| Surface {
        radius_mm: s["radius"].as_f64(),
        thickness_mm: number(&s["thickness"]),
        glass: s["glass"].as_str().map(glass),
        semi_aperture_mm: Some(number(&s["semi_aperture"])),
        conic: s["conic"].as_f64().unwrap_or(0.0),
        asphere: asphere(s),
        is_stop: s["stop"].as_bool().unwrap_or(false),
        ..Surface::default()
    };
    let position = |p: &Value| Position {
        label: p["label"].as_str().unwrap_or_default().to_owned(),
        gaps: p["gaps"]
            .as_object()
            .into_iter()
            .flatten()
            .map(|(i, gap)| (i.parse().expect("a surface"), number(gap)))
            .collect(),
        half_field_deg: p["half_field_deg"].as_f64(),
        ..Position::default()
    };
    Prescription {
        name: lens["name"].as_str().unwrap_or_default().to_owned(),
        claims: Claims {
            f_number: lens["f_number"].as_f64(),
            half_field_deg: lens["half_field_deg"].as_f64(),
            ..Claims::default()
        },
        surfaces: list(&lens["surfaces"]).iter().map(surface).collect(),
        positions: lens["positions"].as_array().into_iter().flatten().map(position).collect(),
        ..Prescription::default()
    }
}

/// A lens in one position with the figures of that position.
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) lens: Lens,
    pub(crate) wavelengths: Vec<f64>,
    pub(crate) figures: Value,
}

/// All lenses, the zoom in its four positions.
pub(crate) fn cases() -> Vec<Case> {
    cases_with(None)
}

/// All lenses, with blades.
pub(crate) fn cases_with(blades: Option<Blades>) -> Vec<Case> {
    let of_file = |name: &str| {
        let file = read(name);
        let prescription = Prescription { blades, ..prescription(&file) };
        let lens = Lens::new(&prescription).unwrap_or_else(|error| panic!("{name}: {error}"));
        let (figures, wavelengths) = (&file["figures"], wavelengths(&file["figures"]));
        let case = |name: String, lens, figures: &Value| Case {
            name,
            lens,
            wavelengths: wavelengths.clone(),
            figures: figures.clone(),
        };
        match figures.get("positions") {
            None => vec![case(name.to_owned(), lens, figures)],
            Some(positions) => {
                let each = list(positions).iter().zip(&prescription.positions);
                let of = |(figures, position): (&Value, &Position)| {
                    case(format!("{name} at {}", position.label), lens.in_position(position), figures)
                };
                each.map(of).collect()
            }
        }
    };
    LENSES.iter().flat_map(|name| of_file(name)).collect()
}

#[track_caller]
pub(crate) fn close(what: &str, found: f64, expected: f64, tolerance: f64) {
    let apart = found - expected;
    assert!(apart.abs() <= tolerance, "{what}: {found} in place of {expected}, {apart:e} apart");
}

pub(crate) fn vector(value: &Value) -> DVec3 {
    DVec3::from_slice(&numbers(value))
}
