//! Writing of a prescription in photosite's own form, as TOML.

use std::fmt::Write;

use photosite_core::spectrum::Dispersion;

use crate::prescription::{Coating, Glass, Layer, LayerIndex, Prescription, Surface};

/// TOML text of a prescription. Reading it gives the same prescription: numbers are written with all their digits, and
/// glasses with the formula of their index.
pub fn to_toml(prescription: &Prescription) -> String {
    let mut toml = String::new();
    let Prescription { name, source, licence, patent, claims, surfaces, blades, positions } = prescription;
    let texts =
        [("name", Some(name)), ("source", source.as_ref()), ("licence", licence.as_ref()), ("patent", patent.as_ref())];
    for (key, text) in texts {
        if let Some(text) = text.filter(|text| !text.is_empty()) {
            let _ = writeln!(toml, "{key} = {}", quoted(text));
        }
    }
    toml += "unit = \"mm\"\n";
    for (key, value) in [
        ("focal_length", claims.focal_length_mm),
        ("f_number", claims.f_number),
        ("half_field_deg", claims.half_field_deg),
        ("image_half_diagonal", claims.image_half_diagonal_mm),
    ] {
        if let Some(value) = value {
            let _ = writeln!(toml, "{key} = {}", number(value));
        }
    }
    if let Some(blades) = blades {
        let _ =
            writeln!(toml, "blades = {{ count = {}, rotation_deg = {} }}", blades.count, number(blades.rotation_deg));
    }
    let glasses = named_glasses(surfaces);
    toml += "surfaces = [\n";
    for surface in surfaces {
        let glass = surface.glass.as_ref().and_then(|glass| glasses.iter().find(|(_, known)| *known == glass));
        let _ = writeln!(toml, "  {{ {} }},", fields(surface, glass.map(|(name, _)| name.as_str())).join(", "));
    }
    toml += "]\n";
    for (name, glass) in &glasses {
        toml += &glass_table(name, glass);
    }
    for position in positions {
        toml += "\n[[positions]]\n";
        let _ = writeln!(toml, "label = {}", quoted(&position.label));
        for (key, value) in [
            ("half_field_deg", position.half_field_deg),
            ("stop_semi_aperture", position.stop_semi_aperture_mm),
            ("object_distance", position.object_distance_mm),
            ("focal_length", position.focal_length_mm),
        ] {
            if let Some(value) = value {
                let _ = writeln!(toml, "{key} = {}", number(value));
            }
        }
        let gaps: Vec<String> = position.gaps.iter().map(|(row, gap)| format!("{row} = {}", number(*gap))).collect();
        if !gaps.is_empty() {
            let _ = writeln!(toml, "gaps = {{ {} }}", gaps.join(", "));
        }
    }
    toml
}

/// Distinct glasses of some surfaces, under distinct names: two makers may have a glass of the same name.
fn named_glasses(surfaces: &[Surface]) -> Vec<(String, &Glass)> {
    let mut glasses: Vec<(String, &Glass)> = Vec::new();
    for glass in surfaces.iter().filter_map(|surface| surface.glass.as_ref()) {
        if glasses.iter().any(|(_, known)| *known == glass) {
            continue;
        }
        let mut name = glass.name.clone();
        for number in 2.. {
            if !glasses.iter().any(|(known, _)| *known == name) {
                break;
            }
            name = format!("{} ({number})", glass.name);
        }
        glasses.push((name, glass));
    }
    glasses
}

fn fields(surface: &Surface, glass: Option<&str>) -> Vec<String> {
    let mut fields = Vec::new();
    if let Some(radius) = surface.radius_mm {
        fields.push(format!("radius = {}", number(radius)));
    }
    fields.push(format!("thickness = {}", number(surface.thickness_mm)));
    if let Some(glass) = glass {
        fields.push(format!("glass = {}", quoted(glass)));
    }
    if let Some(semi_aperture) = surface.semi_aperture_mm {
        fields.push(format!("semi_aperture = {}", number(semi_aperture)));
    }
    if surface.conic != 0.0 {
        fields.push(format!("conic = {}", number(surface.conic)));
    }
    if !surface.asphere.is_empty() {
        let terms: Vec<String> = surface.asphere.iter().map(|(order, a)| format!("{order} = {}", number(*a))).collect();
        fields.push(format!("asphere = {{ {} }}", terms.join(", ")));
    }
    if surface.is_stop {
        fields.push("stop = true".to_owned());
    }
    match &surface.coating {
        Coating::Unknown => {}
        Coating::Uncoated => fields.push("coating = \"none\"".to_owned()),
        Coating::Layers(layers) => {
            let layers: Vec<String> = layers.iter().map(layer).collect();
            fields.push(format!("coating = [{}]", layers.join(", ")));
        }
    }
    fields
}

fn layer(layer: &Layer) -> String {
    let thickness = number(layer.thickness_nm);
    match &layer.index {
        LayerIndex::Constant { n, k } => {
            format!("{{ index = {}, k = {}, thickness_nm = {thickness} }}", number(*n), number(*k))
        }
        LayerIndex::Table { n, k } => {
            // Thin films hardly disperse: their tables have steps of 10 nm or more.
            let nm: Vec<f32> = (0..=80).map(|i| 300.0 + 10.0 * i as f32).collect();
            let list = |value: &dyn Fn(f32) -> f32| {
                nm.iter().map(|&nm| number(f64::from(value(nm)))).collect::<Vec<_>>().join(", ")
            };
            let [wavelengths, n, k] = [list(&|nm| nm), list(&|nm| n.eval(nm)), list(&|nm| k.eval(nm))];
            format!(
                "{{ table = {{ wavelength_nm = [{wavelengths}], n = [{n}], k = [{k}] }}, thickness_nm = {thickness} }}"
            )
        }
    }
}

fn glass_table(name: &str, glass: &Glass) -> String {
    let list = |numbers: &[f64]| numbers.iter().map(|&x| number(x)).collect::<Vec<_>>().join(", ");
    let mut toml = format!("\n[glasses.{}]\n", quoted(name));
    let formula = match &glass.dispersion {
        Dispersion::Sellmeier { b, c_um2 } => {
            format!("sellmeier_b = [{}]\nsellmeier_c_um2 = [{}]", list(b), list(c_um2))
        }
        Dispersion::Polynomial { terms } => {
            let pairs: Vec<String> = terms.iter().map(|pair| format!("[{}]", list(pair))).collect();
            format!("polynomial = [{}]", pairs.join(", "))
        }
        Dispersion::Conrady { a, b_um, c_um35 } => format!("conrady = [{}]", list(&[*a, *b_um, *c_um35])),
        Dispersion::Cauchy { a, b_um2, c_um4 } if *b_um2 == 0.0 && *c_um4 == 0.0 => format!("n = {}", number(*a)),
        Dispersion::Cauchy { a, b_um2, c_um4 } => format!("cauchy = [{}]", list(&[*a, *b_um2, *c_um4])),
        Dispersion::Table(spectrum) => {
            // All that a spectrum holds, with the digits of its single precision.
            let row = |part: &dyn Fn((f64, f64)) -> String| spectrum.iter().map(part).collect::<Vec<_>>().join(", ");
            let (wavelengths, n) = (row(&|(nm, _)| number(nm)), row(&|(_, n)| format!("{:?}", n as f32)));
            format!("table = {{ wavelength_nm = [{wavelengths}], n = [{n}] }}")
        }
    };
    toml += &formula;
    toml.push('\n');
    if let Some(range) = glass.range_nm {
        let _ = writeln!(toml, "range_nm = [{}]", list(&range));
    }
    let _ = writeln!(toml, "source = {}", quoted(&glass.source));
    toml
}

/// Text of a number with all digits that tell it from its neighbours.
fn number(x: f64) -> String {
    let size = x.abs();
    if size != 0.0 && !(1e-4..1e9).contains(&size) { format!("{x:e}") } else { format!("{x:?}") }
}

fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}
