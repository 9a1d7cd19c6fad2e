//! Lens elements, main and supplementary: `lensmaker` and `supplementary` of `[lens]`.

use super::super::scene::materials::index;
use super::super::tables::spectra::Finder;
use super::super::tables::{IndexSource, LensmakerTable, Radius, SupplementaryTable};
use photosite_core::Invalid;
use photosite_transport::optics::{GroundLens, Power, SupplementaryLens};

/// The glass of the main lens.
pub(crate) fn ground_lens(finder: &Finder<'_>, table: &LensmakerTable) -> Result<GroundLens, Invalid> {
    let LensmakerTable { radii_mm, thickness_mm, glass, index, abbe_number } = table;
    ground(finder, radii_mm, *thickness_mm, Glass { name: glass.as_deref(), index: index.as_ref(), abbe: *abbe_number })
}

/// A lens before the main one.
pub(crate) fn supplementary_lens(
    finder: &Finder<'_>,
    table: &SupplementaryTable,
) -> Result<SupplementaryLens, Invalid> {
    let glass = Glass { name: table.glass.as_deref(), index: table.index.as_ref(), abbe: table.abbe_number };
    let given = [
        ("power_dpt", table.power_dpt.is_some()),
        ("focal_length_mm", table.focal_length_mm.is_some()),
        ("radii_mm", table.radii_mm.is_some()),
    ];
    let mut names = given.iter().filter(|(_, is_given)| *is_given).map(|(name, _)| *name);
    if let (Some(first), Some(second)) = (names.next(), names.next()) {
        return Err(Invalid::new(second, format!("cannot be combined with {first}")).help("keep one of them"));
    }
    let of_glass = [
        ("thickness_mm", table.thickness_mm.is_some()),
        ("glass", glass.name.is_some()),
        ("index", glass.index.is_some()),
        ("abbe_number", glass.abbe.is_some()),
    ];
    if let (None, Some((key, _))) = (&table.radii_mm, of_glass.iter().find(|(_, is_given)| *is_given)) {
        return Err(Invalid::new(*key, "only applies with radii_mm").help("write radii_mm = [R1, R2], or remove it"));
    }
    let power = match (table.power_dpt, table.focal_length_mm, &table.radii_mm) {
        (Some(power), ..) => Power::Constant(power),
        (None, Some(mm), _) if mm.is_finite() && mm != 0.0 => Power::Constant(1e3 / mm),
        (None, Some(mm), _) => {
            return Err(Invalid::new("focal_length_mm", format!("must not be 0, got {mm}")).help("for example 500"));
        }
        (None, None, Some(radii)) => Power::Ground(ground(finder, radii, table.thickness_mm, glass)?),
        (None, None, None) => {
            return Err(Invalid::new("", "the key `power_dpt` is missing")
                .help("write its power, power_dpt = 2, its focal_length_mm, or its radii_mm and glass"));
        }
    };
    Ok(SupplementaryLens { power, distance_m: table.distance_mm.unwrap_or(0.0) / 1e3 })
}

/// Keys that name the glass of a lens element.
struct Glass<'a> {
    name: Option<&'a str>,
    index: Option<&'a IndexSource>,
    abbe: Option<f64>,
}

fn ground(
    finder: &Finder<'_>,
    radii: &[Radius; 2],
    thickness_mm: Option<f64>,
    glass: Glass<'_>,
) -> Result<GroundLens, Invalid> {
    let radius_m = |radius: &Radius| match radius {
        Radius::Mm(mm) => Ok(mm / 1e3),
        Radius::Name(name) if name == "flat" => Ok(f64::INFINITY),
        Radius::Name(name) => {
            Err(Invalid::new("radii_mm", format!("unknown radius {name:?}")).help("write a number of mm, or \"flat\""))
        }
    };
    let ground = GroundLens {
        radii_m: [radius_m(&radii[0])?, radius_m(&radii[1])?],
        thickness_m: thickness_mm.unwrap_or(0.0) / 1e3,
        index: index(finder, glass.name, glass.index, glass.abbe)?,
    };
    ground.validate().map(|()| ground)
}
