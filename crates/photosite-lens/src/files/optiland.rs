//! Optiland's lens files, as written by `save_optiland_file`.

use crate::checks::MOST_SURFACES;
use crate::files::draft::too_many;
use serde_json::Value;

use super::draft::{Draft, Field, Medium, Numbers, Opening, Read, Row};
use super::json_value::{At, asphere};

/// Reads a file.
pub(super) fn read(value: &Value) -> Read<Draft> {
    let root = At::root(value);
    let mut draft = Draft { derives_apertures: true, ..Draft::default() };
    root.text_of("name").clone_into(&mut draft.name);
    let group = root.needed("surface_group")?;
    let surfaces = group.needed("surfaces")?;
    let items = surfaces.items()?;
    if items.len() < 3 {
        return Err(surfaces.fault(format!("{} surfaces, the object and the image among them", items.len())));
    }
    if items.len() > MOST_SURFACES + 2 {
        return Err(surfaces.fault(too_many(items.len())));
    }
    let last = items.len() - 1;
    let z = items.iter().map(position).collect::<Read<Vec<f64>>>()?;
    for (i, surface) in items.iter().enumerate().take(last).skip(1) {
        let thickness = z[i + 1] - z[i];
        if !thickness.is_finite() {
            return Err(surface.fault(format!("its vertex is at {}, the next at {}", z[i], z[i + 1])));
        }
        if let Some(given) = surface.get("thickness") {
            let stated = given.number()?;
            // What Optiland keeps beside cs.z is infinite or 0 where it was never set.
            let is_set = stated.is_finite() && stated != 0.0;
            if is_set && (stated - thickness).abs() > 1e-6 * (1.0 + thickness.abs()) {
                return Err(
                    given.fault(format!("the thickness {stated} is not the {thickness} between the vertices (cs.z)"))
                );
            }
        }
        let row = row(surface, thickness, &mut draft)?;
        draft.rows.push(row);
    }
    let object = z[1] - z[0];
    if object.is_finite() && object.abs() < 1e9 {
        draft.assume(format!(
            "the file focuses on an object {object} mm before the first surface; its last gap is for that"
        ));
    }
    draft.assume("lengths are mm, as in Optiland");
    opening(&root, &mut draft)?;
    fields(&root, &mut draft)?;
    // Unless it is limited, the stop's radius follows from the opening.
    let limits: Vec<bool> = draft.rows.iter().map(|row| row.semi_aperture_mm.is_some()).collect();
    draft.drop_dummies(&limits);
    Ok(draft)
}

/// Position of a surface's vertex on the axis.
fn position(surface: &At) -> Read<f64> {
    let cs = surface.needed("geometry")?.needed("cs")?;
    for key in ["x", "y", "rx", "ry", "rz"] {
        if cs.finite_of(key)?.is_some_and(|value| value != 0.0) {
            return Err(cs.fault(format!("{key} is not 0: the surface is tilted or beside the axis")));
        }
    }
    cs.needed("z")?.number()
}

fn row(surface: &At, thickness_mm: f64, draft: &mut Draft) -> Read<Row> {
    let geometry = surface.needed("geometry")?;
    let is_mirror = surface.is_true("is_reflective")
        || surface.get("interaction_model").is_some_and(|model| model.is_true("is_reflective"));
    if is_mirror {
        return Err(surface.fault("a mirror, where lenses refract at every surface"));
    }
    let kind = geometry.text_of("type");
    // The order of the first coefficient, and the step to the next.
    let orders = match kind {
        "Plane" | "StandardGeometry" => None,
        "EvenAsphere" => Some([2, 2]),
        "OddAsphere" => Some([1, 1]),
        other => {
            let message = format!("the geometry {other} is not a sphere, conic or asphere of revolution");
            let mut fault = geometry.fault(message);
            fault.invalid = fault.invalid.help("only Plane, StandardGeometry, EvenAsphere and OddAsphere can be read");
            return Err(fault);
        }
    };
    let radius = geometry.get("radius").map_or(Ok(f64::INFINITY), |radius| radius.number())?;
    let asphere = match (orders, geometry.get("coefficients")) {
        (Some(orders), Some(coefficients)) => asphere(&coefficients, orders)?,
        (None, _) | (_, None) => Vec::new(),
    };
    if surface.get("coating").or_else(|| surface.get("interaction_model")?.get("coating")).is_some() {
        draft.ignore("coatings");
    }
    Ok(Row {
        key: surface.path.clone(),
        name: surface.path.clone(),
        radius_mm: radius.is_finite().then_some(radius).filter(|radius| *radius != 0.0),
        thickness_mm,
        medium: medium(&surface.needed("material_post")?, draft)?,
        semi_aperture_mm: aperture(surface, draft)?,
        conic: geometry.finite_of("conic")?.unwrap_or(0.0),
        asphere,
        is_stop: surface.is_true("is_stop"),
        ..Row::default()
    })
}

/// Radius of a radial aperture.
fn aperture(surface: &At, draft: &mut Draft) -> Read<Option<f64>> {
    let Some(aperture) = surface.get("aperture") else { return Ok(None) };
    if aperture.get("r_min").is_some_and(|r| r.number().is_ok_and(|r| r > 0.0)) {
        draft.ignore(format!("{}: the obscured middle", aperture.path));
    }
    match aperture.get("r_max") {
        Some(radius) => {
            let radius = radius.number()?;
            Ok(radius.is_finite().then_some(radius))
        }
        None => {
            draft.ignore(format!("{}: {}, no circle around the axis", aperture.path, aperture.text_of("type")));
            Ok(None)
        }
    }
}

fn medium(material: &At, draft: &mut Draft) -> Read<Medium> {
    let named = |name: &str, catalogue: &str| Medium::Named {
        name: name.to_owned(),
        catalogues: if catalogue.is_empty() { Vec::new() } else { vec![catalogue.to_owned()] },
        numbers: Numbers::None,
    };
    match material.text_of("type") {
        "IdealMaterial" => {
            let index = material.needed("index")?;
            // Arrays of one number in some versions.
            let index = match index.items() {
                Ok(items) => items.first().map_or(Ok(1.0), |item| item.finite())?,
                Err(_) => index.finite()?,
            };
            Ok(if index == 1.0 { Medium::Air } else { Medium::Index(index) })
        }
        "Material" => {
            let reference = material.text_of("reference");
            // The file's path ends in …/glass/MAKER/NAME.yml.
            let filename = material.text_of("filename").replace('\\', "/");
            let maker = filename.rsplit('/').nth(1).unwrap_or_default().to_owned();
            if reference.is_empty() && !maker.is_empty() {
                draft.assume(format!(
                    "{} is that of {maker}, from the path of a file beside it",
                    material.text_of("name")
                ));
            }
            Ok(named(material.text_of("name"), if reference.is_empty() { &maker } else { reference }))
        }
        "MaterialFile" => {
            let filename = material.text_of("filename").replace('\\', "/");
            let mut parts = filename.rsplit('/');
            let name = parts.next().unwrap_or_default().trim_end_matches(".yml").to_owned();
            Ok(named(&name, parts.next().unwrap_or_default()))
        }
        "AbbeMaterial" => {
            let nd = material.needed("index")?.finite()?;
            let vd = material.needed("abbe")?.finite()?;
            Ok(Medium::Patent { nd, vd })
        }
        "Mirror" => Err(material.fault("a mirror, where lenses refract at every surface")),
        other => Err(material.fault(format!("the material {other} is not one that can be read"))),
    }
}

fn opening(root: &At, draft: &mut Draft) -> Read<()> {
    let Some(aperture) = root.get("aperture") else { return Ok(()) };
    let kind = aperture.text_of("type").to_owned();
    // Some versions write `ap_type`.
    let kind = if kind.is_empty() { aperture.text_of("ap_type").to_owned() } else { kind };
    let Some(value) = aperture.finite_of("value")?.filter(|value| *value > 0.0) else { return Ok(()) };
    match kind.as_str() {
        "EPD" => draft.opening = Some(Opening::EntrancePupil(value)),
        "imageFNO" => draft.opening = Some(Opening::FNumber(value)),
        // A diameter.
        "float_by_stop_size" => {
            if let Some(stop) = draft.rows.iter_mut().find(|row| row.is_stop) {
                stop.semi_aperture_mm = Some(value / 2.0);
            }
        }
        other => draft.ignore(format!("the aperture {other}")),
    }
    Ok(())
}

fn fields(root: &At, draft: &mut Draft) -> Read<()> {
    let Some(group) = root.get("fields") else { return Ok(()) };
    let Some(list) = group.get("fields") else { return Ok(()) };
    let mut kind = group.text_of("field_type").to_owned();
    let mut largest: f64 = 0.0;
    let mut fields = Vec::new();
    for field in list.items()? {
        let y = field.finite_of("y")?.unwrap_or(0.0);
        let vignetting = field.finite_of("vy")?.unwrap_or(0.0);
        if kind.is_empty() {
            field.text_of("field_type").clone_into(&mut kind);
        }
        largest = largest.max(y.abs());
        fields.push(Field { angle_deg: y, vignetting: [vignetting; 2] });
    }
    if kind.to_ascii_lowercase().contains("angle") {
        draft.claims.half_field_deg = (largest > 0.0).then_some(largest);
        draft.fields = fields;
    } else if kind.contains("image") {
        draft.claims.image_half_diagonal_mm = (largest > 0.0).then_some(largest);
    } else {
        draft.ignore(format!("the fields, which are of the type {kind}"));
    }
    Ok(())
}
