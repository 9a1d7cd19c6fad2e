//! DeepLens' lens files, as written by `write_lens_json` and found in its data sets.

use serde_json::Value;

use super::draft::{Draft, Medium, Numbers, Read, Row, too_many};
use super::json_value::{At, asphere};
use super::patent::patent_in;
use crate::checks::MOST_SURFACES;

/// Number of digits of the decimals that single-precision numbers come from.
const DIGITS: i32 = 6;

/// n_d and ν_d of DeepLens' own table of materials that no maker's catalogue has.
const MATERIALS: [(&str, f64, f64); 6] = [
    ("coc", 1.5337, 56.22),
    ("okp4", 1.6328, 23.34),
    ("okp4ht", 1.6328, 23.34),
    ("apl5014cl", 1.5445, 55.99),
    ("hk51", 1.5501, 58.64),
    ("b270", 1.5229, 58.5),
];

/// Reads a file. Keys in brackets, `(c)`, are comments.
pub(super) fn read(value: &Value) -> Read<Draft> {
    let root = At::root(value);
    let mut draft = Draft::default();
    let info = root.text_of("info");
    if info != "None" {
        info.clone_into(&mut draft.name);
    }
    draft.patent = patent_in(info);
    // foclen and fnum are what was worked out last, at times of another lens; sanity checks compare them.
    draft.claims.focal_length_mm = root.finite_of("foclen")?.filter(|f| *f > 0.0);
    draft.claims.f_number = root.finite_of("fnum")?.filter(|n| *n > 0.0);
    draft.claims.image_half_diagonal_mm = root.finite_of("r_sensor")?.filter(|r| *r > 0.0);
    if root.get("enpd").is_some() {
        draft.ignore("enpd, a diameter of the entrance pupil: the stop's own radius holds");
    }
    if let Some(element) = root.get("DOE") {
        return Err(element.fault(format!("{}, a diffractive element behind the lens", element.text_of("type"))));
    }
    let surfaces = root.needed("surfaces")?;
    let items = surfaces.items()?;
    if items.len() > MOST_SURFACES {
        return Err(surfaces.fault(too_many(items.len())));
    }
    items.iter().try_for_each(refuse)?;
    let gaps = items.iter().map(|surface| surface.needed("d_next")?.finite()).collect::<Read<Vec<f64>>>()?;
    let length: f64 = gaps.iter().map(|gap| gap.abs()).sum();
    for (surface, gap) in items.iter().zip(gaps) {
        // Gaps are differences of places along the axis, of which each has the precision.
        let row = row(surface, decimal(gap, length), &mut draft)?;
        draft.rows.push(row);
    }
    if let Some(sensor) = root.finite_of("d_sensor")?.filter(|sensor| (sensor - length).abs() > 1e-3 * length) {
        draft.ignore(format!("d_sensor, {sensor} mm: the gaps, d_next, end at {length:.4} mm"));
    }
    if !draft.rows.iter().any(|row| row.is_stop) {
        let radius = |row: &Row| row.semi_aperture_mm.unwrap_or(f64::INFINITY);
        if let Some(smallest) = draft.rows.iter_mut().min_by(|a, b| radius(a).total_cmp(&radius(b))) {
            smallest.is_stop = true;
            let note = format!("{} is the stop, as in DeepLens: the smallest, and there is no Aperture", smallest.name);
            draft.assume(note);
        }
    }
    draft.assume("lengths are mm, and numbers of single precision are the decimals of six digits that they come from");
    draft.assume("r is the radius in which a surface lets light through, which DeepLens draws and cuts rays off at");
    Ok(draft)
}

/// Decimal of six digits that a single-precision number comes from, or `x` itself; `whole` is the value that was
/// rounded to single precision.
fn decimal(x: f64, whole: f64) -> f64 {
    let rounded = photosite_core::math::float::rounded(x, DIGITS);
    if (rounded - x).abs() <= f64::from(f32::EPSILON) * whole.abs().max(x.abs()) { rounded } else { x }
}

/// Refuses a surface that is no refracting surface of revolution, by its type.
fn refuse(surface: &At) -> Read<()> {
    let kind = surface.text_of("type");
    if matches!(kind, "Spheric" | "Aspheric" | "Plane" | "Aperture" | "Stop") {
        return Ok(());
    }
    let mut fault = surface.fault(format!("{kind:?}, which is not a sphere, asphere or plane of glass"));
    fault.invalid = fault.invalid.help("only Spheric, Aspheric, Plane, Aperture and Stop can be read");
    Err(fault)
}

fn row(surface: &At, thickness_mm: f64, draft: &mut Draft) -> Read<Row> {
    let kind = surface.text_of("type");
    let is_stop = matches!(kind, "Aperture" | "Stop");
    if surface.is_true("is_square") {
        draft.ignore(format!("{}: is_square; the largest circle in the square stands for it", surface.path));
    }
    let semi_aperture_mm = match (surface.finite_of("r")?, surface.finite_of("l")?) {
        (Some(radius), _) => Some(radius),
        // The side of a square.
        (None, Some(side)) => Some(side / 2.0),
        (None, None) => return Err(surface.fault("there is neither a radius `r` nor a side `l`")),
    };
    let is_curved = matches!(kind, "Spheric" | "Aspheric");
    Ok(Row {
        key: surface.path.clone(),
        name: surface.path.clone(),
        radius_mm: if is_curved { radius(surface)? } else { None },
        thickness_mm,
        medium: medium(surface, draft)?,
        semi_aperture_mm,
        conic: if kind == "Aspheric" { decimal(surface.finite_of("k")?.unwrap_or(0.0), 0.0) } else { 0.0 },
        asphere: if kind == "Aspheric" { terms(surface)? } else { Vec::new() },
        is_stop,
        ..Row::default()
    })
}

/// Radius of curvature from `roc`, where 0 is flat, else from the curvature `c`.
fn radius(surface: &At) -> Read<Option<f64>> {
    let radius = match (surface.get("roc"), surface.finite_of("c")?) {
        (Some(radius), _) => radius.number()?,
        (None, Some(curvature)) => curvature.recip(),
        (None, None) => return Err(surface.fault("there is neither a radius `roc` nor a curvature `c`")),
    };
    Ok((radius.is_finite() && radius != 0.0).then(|| decimal(radius, 0.0)))
}

/// Aspheric terms of `ai`, from r² on in steps of 2, or from r⁴ on where `use_ai2` is false.
fn terms(surface: &At) -> Read<Vec<(u32, f64)>> {
    let begins_at_4 = surface.value.get("use_ai2").and_then(Value::as_bool) == Some(false);
    let Some(coefficients) = surface.get("ai") else { return Ok(Vec::new()) };
    let terms = asphere(&coefficients, [if begins_at_4 { 4 } else { 2 }, 2])?;
    Ok(terms.into_iter().map(|(order, a)| (order, decimal(a, 0.0))).collect())
}

/// Medium of `air`, of `1.6727/32.1`, or of the name of a glass, which DeepLens looks up at Schott, then at CDGM.
fn medium(surface: &At, draft: &mut Draft) -> Read<Medium> {
    let name = surface.text_of("mat2");
    if matches!(name.to_ascii_lowercase().as_str(), "" | "air" | "vacuum" | "occluder") {
        return Ok(Medium::Air);
    }
    if let Some((nd, vd)) = crate::glass::code(name).filter(|_| name.contains('/')) {
        return Ok(Medium::Patent { nd, vd });
    }
    if let Some((_, nd, vd)) = MATERIALS.iter().find(|(known, ..)| name.eq_ignore_ascii_case(known)) {
        draft.assume(format!("{name} has the n_d {nd} and ν_d {vd} of DeepLens' own table"));
        return Ok(Medium::Patent { nd: *nd, vd: *vd });
    }
    let catalogues = ["schott", "cdgm"].map(str::to_owned).to_vec();
    Ok(Medium::Named { name: name.to_owned(), catalogues, numbers: Numbers::None })
}
