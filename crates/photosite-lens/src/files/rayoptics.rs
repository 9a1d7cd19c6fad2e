//! ray-optics' lens models, `.roa`.

use crate::checks::MOST_SURFACES;
use crate::files::draft::too_many;
use crate::files::patent::patent_in;
use crate::files::text::mm_of;
use serde_json::Value;

use super::draft::{Draft, Field, Medium, Numbers, Opening, Read, Row};
use super::json_value::{At, asphere};

/// Value of `max_aperture` where none was set.
const NOT_SET: f64 = 1.0;

/// Reads a file.
pub(super) fn read(value: &Value) -> Read<Draft> {
    let root = At::root(value);
    let model = attributes(&root.needed("optical_model")?);
    let sequence = attributes(&model.needed("seq_model")?);
    let mut draft = Draft { derives_apertures: true, ..Draft::default() };
    let mut mm = 1.0;
    if let Some(system) = model.get("system_spec").map(|system| attributes(&system)) {
        system.text_of("title").clone_into(&mut draft.name);
        draft.patent = patent_in(&draft.name);
        let unit = [system.text_of("_dimensions"), system.text_of("dimensions")].concat();
        if !unit.is_empty() {
            mm = mm_of(&unit).ok_or_else(|| system.fault(format!("the unit {unit} is not known")))?;
        }
    }
    let surfaces = sequence.needed("ifcs")?;
    let (items, gaps) = (surfaces.items()?, sequence.needed("gaps")?.items()?);
    if items.len() < 3 || gaps.len() + 1 != items.len() {
        let message =
            format!("{} surfaces and {} gaps: there is one gap between two surfaces", items.len(), gaps.len());
        return Err(surfaces.fault(message));
    }
    if items.len() > MOST_SURFACES + 2 {
        return Err(surfaces.fault(too_many(items.len())));
    }
    let stop = sequence.get("stop_surface").map(|stop| stop.finite()).transpose()?.map(|stop| stop as usize);
    let profiles = model.get("profile_dict");
    let mut limits = Vec::new();
    for i in 1..items.len() - 1 {
        let mut row = row(&items[i], profiles.as_ref(), &mut draft)?;
        let gap = attributes(&gaps[i]);
        row.thickness_mm = gap.needed("thi")?.finite()?;
        row.medium = medium(&gap.needed("medium")?, &mut draft)?;
        row.is_stop = stop == Some(i);
        limits.push(
            attributes(&items[i]).get("clear_apertures").is_some_and(|list| list.items().is_ok_and(|l| !l.is_empty())),
        );
        draft.rows.push(row);
    }
    let object = attributes(&gaps[0]).needed("thi")?.number()?;
    if object.abs() < 1e9 && object != 0.0 {
        let distance = object * mm;
        draft.assume(format!(
            "the file focuses on an object {distance} mm before the first surface; its last gap is for that"
        ));
    }
    if let Some(spec) = model.get("optical_spec").map(|spec| attributes(&spec)) {
        optical_spec(&spec, &mut draft)?;
    }
    let unset = draft.rows.iter().filter(|row| row.semi_aperture_mm.is_none()).count();
    if unset > 0 {
        draft.assume(format!("a max_aperture of 1.0 is not set: {unset} surfaces"));
    }
    draft.drop_dummies(&limits);
    draft.scale(mm);
    Ok(draft)
}

/// The attributes of an instance of a class.
fn attributes<'a>(at: &At<'a>) -> At<'a> {
    at.get("attributes").unwrap_or_else(|| at.clone())
}

/// The class of an instance.
fn class<'a>(at: &At<'a>) -> &'a str {
    at.value.get("__instance_type__").and_then(|kind| kind.get(1)).and_then(Value::as_str).unwrap_or_default()
}

fn row(surface: &At, profiles: Option<&At>, draft: &mut Draft) -> Read<Row> {
    let kind = class(surface);
    if kind != "Surface" {
        return Err(surface.fault(format!("{kind}, which is not a surface of glass")));
    }
    let of = attributes(surface);
    let mode = of.text_of("interact_mode");
    if mode == "reflect" {
        return Err(surface.fault("a mirror (interact_mode reflect), where lenses refract at every surface"));
    }
    if of.get("phase_element").is_some() {
        return Err(surface.fault("a phase element, as gratings and holograms are"));
    }
    if of.get("decenter").is_some() {
        return Err(surface.fault("a decentre: only lenses whose surfaces share one axis can be read"));
    }
    let profile = match (of.get("profile"), profiles) {
        (Some(profile), _) => profile,
        (None, Some(profiles)) => profiles.needed(of.text_of("profile_id"))?,
        (None, None) => return Err(surface.fault("there is neither a profile nor a profile_dict")),
    };
    let shape = attributes(&profile);
    let curvature = shape.finite_of("cv")?.unwrap_or(0.0);
    let orders = match class(&profile) {
        "Spherical" | "Conic" => None,
        // From r² and from r¹.
        "EvenPolynomial" => Some([2, 2]),
        "RadialPolynomial" => Some([1, 1]),
        other => {
            return Err(profile.fault(format!("the profile {other} is not a sphere, conic or asphere of revolution")));
        }
    };
    // Either k or 1 + k.
    let conic = match (shape.finite_of("cc")?, shape.finite_of("ec")?) {
        (Some(cc), _) => cc,
        (None, Some(ec)) => ec - 1.0,
        (None, None) => 0.0,
    };
    let asphere = match (orders, shape.get("coefs")) {
        // Arrays of NumPy are instances, too.
        (Some(orders), Some(list)) => asphere(&list.get("__ndarray__").unwrap_or(list), orders)?,
        (None, _) | (_, None) => Vec::new(),
    };
    let clear = of.get("clear_apertures").map_or(Ok(Vec::new()), |list| list.items())?;
    let mut semi_aperture_mm = of.finite_of("max_aperture")?.filter(|radius| *radius != NOT_SET);
    if let [aperture] = &clear[..]
        && class(aperture) == "Circular"
    {
        semi_aperture_mm = attributes(aperture).finite_of("radius")?.or(semi_aperture_mm);
    } else if !clear.is_empty() {
        draft.ignore(format!("{}: clear apertures that are not a single circle", of.path));
    }
    Ok(Row {
        key: surface.path.clone(),
        name: surface.path.clone(),
        radius_mm: (curvature != 0.0).then(|| 1.0 / curvature),
        conic,
        asphere,
        semi_aperture_mm,
        ..Row::default()
    })
}

fn medium(medium: &At, draft: &mut Draft) -> Read<Medium> {
    let of = attributes(medium);
    let kind = class(medium);
    if let Some(maker) = kind.strip_suffix("Glass").filter(|maker| !["Model", "Robb1983"].contains(maker)) {
        let name =
            [of.text_of("gname"), of.text_of("label")].into_iter().find(|name| !name.is_empty()).unwrap_or_default();
        return Ok(Medium::Named {
            name: name.to_owned(),
            catalogues: vec![maker.to_ascii_lowercase()],
            numbers: Numbers::None,
        });
    }
    match kind {
        "Air" => Ok(Medium::Air),
        "ModelGlass" => {
            let nd = of.needed("n")?.finite()?;
            let vd = of.needed("v")?.finite()?;
            Ok(Medium::Patent { nd, vd })
        }
        "ConstantIndex" | "OpticalMedium" | "Medium" | "Glass" => match of.finite_of("n")? {
            Some(1.0) => Ok(Medium::Air),
            Some(index) => Ok(Medium::Index(index)),
            None => Err(medium.fault("a medium without an index `n`")),
        },
        other => {
            let name = of.text_of("gname");
            if name.is_empty() {
                return Err(medium.fault(format!("the medium {other} is not one that can be read")));
            }
            draft.assume(format!("{name} is looked up in all catalogues: the medium is of the class {other}"));
            Ok(Medium::Named { name: name.to_owned(), catalogues: Vec::new(), numbers: Numbers::None })
        }
    }
}

/// Pupil and fields.
fn optical_spec(spec: &At, draft: &mut Draft) -> Read<()> {
    if let Some(pupil) = spec.get("pupil").map(|pupil| attributes(&pupil)) {
        let key = key(&pupil);
        match (key.as_str(), pupil.finite_of("value")?.filter(|value| *value > 0.0)) {
            ("object epd" | "object pupil", Some(value)) => draft.opening = Some(Opening::EntrancePupil(value)),
            ("image f/#", Some(value)) => draft.opening = Some(Opening::FNumber(value)),
            (_, Some(_)) => draft.ignore(format!("the pupil by {key}")),
            (_, None) => {}
        }
    }
    let Some(view) = spec.get("field_of_view").map(|view| attributes(&view)) else { return Ok(()) };
    let value = view.finite_of("value")?;
    let scale = if view.is_true("is_relative") { value.unwrap_or(0.0) } else { 1.0 };
    let mut fields = Vec::new();
    for field in view.get("fields").map_or(Ok(Vec::new()), |fields| fields.items())? {
        let of = attributes(&field);
        let y = of.finite_of("y")?.unwrap_or(0.0) * scale;
        let vignetting = [of.finite_of("vuy")?.unwrap_or(0.0), of.finite_of("vly")?.unwrap_or(0.0)];
        fields.push(Field { angle_deg: y, vignetting });
    }
    let largest = fields.iter().fold(value.unwrap_or(0.0).abs(), |most, field| most.max(field.angle_deg.abs()));
    let largest = (largest > 0.0).then_some(largest);
    match key(&view).as_str() {
        "object angle" => {
            draft.claims.half_field_deg = largest;
            draft.fields = fields;
        }
        "image height" | "image real height" => draft.claims.image_half_diagonal_mm = largest,
        other => draft.ignore(format!("the fields by {other}")),
    }
    Ok(())
}

/// Text of a key such as `["aperture", "image", "f/#"]` or `["image", "f/#"]`.
fn key(of: &At) -> String {
    let list = of.get("key").or_else(|| of.get("_key"));
    let words: Vec<&str> = list
        .iter()
        .filter_map(|list| list.value.as_array())
        .flatten()
        .filter_map(Value::as_str)
        .filter(|word| !["aperture", "field"].contains(word))
        .collect();
    words.join(" ")
}
