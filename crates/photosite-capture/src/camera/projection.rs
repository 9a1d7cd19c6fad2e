//! Projection of a lens: from `projection`, `xi` and `distortion` of `[lens]` to a [`Projection`].

use super::super::tables::{DistortionModel, DistortionTable, LensTable, ProjectionKind};
use photosite_core::Invalid;
use photosite_core::projection::FisheyeProjection;
use photosite_transport::optics::{BrownConrady, Projection};

pub(crate) fn projection(table: &LensTable) -> Result<Projection, Invalid> {
    let distortion = table.distortion.as_ref();
    let model = distortion.map_or(DistortionModel::None, |distortion| distortion.model);
    let name = match (table.projection, model, table.xi) {
        (Some(name), ..) => name,
        (None, DistortionModel::KannalaBrandt, _) => ProjectionKind::Fisheye,
        (None, _, Some(_)) => ProjectionKind::Omnidirectional,
        (None, _, None) => ProjectionKind::Perspective,
    };
    if table.xi.is_some() && name != ProjectionKind::Omnidirectional {
        let help = "remove it, or write projection = \"omnidirectional\"";
        return Err(Invalid::new("xi", "belongs to an omnidirectional lens").help(help));
    }
    let coefficients = match distortion {
        Some(distortion) => coefficients(distortion).map_err(|invalid| invalid.within("distortion"))?,
        None => BrownConrady::default(),
    };
    let BrownConrady { k, .. } = coefficients;
    let undistorted = |projection: Projection, what: &str| match model {
        DistortionModel::None => Ok(projection),
        DistortionModel::BrownConrady
        | DistortionModel::Polynomial
        | DistortionModel::Division
        | DistortionModel::KannalaBrandt => Err(misfit(&format!("{what} has no distortion"))),
    };
    let law = |law: FisheyeProjection, name: &str| {
        undistorted(Projection::ClassicalFisheye(law), &format!("the {name} fisheye follows its law exactly and"))
            .map_err(|invalid| {
                invalid
                    .help("remove lens.distortion, or write projection = \"fisheye\" with model = \"kannala-brandt\"")
            })
    };
    match name {
        ProjectionKind::Perspective => match model {
            DistortionModel::None => Ok(Projection::Perspective),
            DistortionModel::BrownConrady => Ok(Projection::BrownConrady(coefficients)),
            DistortionModel::Polynomial => Ok(Projection::Polynomial { k: [k[0], k[1]] }),
            DistortionModel::Division => Ok(Projection::Division { lambda: k[0] }),
            DistortionModel::KannalaBrandt => {
                Err(misfit("kannala-brandt is the distortion of a fisheye").help("write projection = \"fisheye\""))
            }
        },
        ProjectionKind::Fisheye => match model {
            DistortionModel::None | DistortionModel::KannalaBrandt => {
                Ok(Projection::KannalaBrandt { k: [k[0], k[1], k[2], k[3]] })
            }
            DistortionModel::BrownConrady | DistortionModel::Polynomial | DistortionModel::Division => {
                Err(misfit("a fisheye has no such distortion")
                    .help("write model = \"kannala-brandt\" with k = [k1, k2, k3, k4]"))
            }
        },
        ProjectionKind::Equisolid => law(FisheyeProjection::Equisolid, "equisolid"),
        ProjectionKind::Stereographic => law(FisheyeProjection::Stereographic, "stereographic"),
        ProjectionKind::Orthographic => law(FisheyeProjection::Orthographic, "orthographic"),
        ProjectionKind::Equirectangular => undistorted(Projection::Equirectangular, "an equirectangular panorama")
            .map_err(|invalid| invalid.help("remove lens.distortion")),
        ProjectionKind::Omnidirectional => match model {
            DistortionModel::None | DistortionModel::BrownConrady => omnidirectional(table.xi, coefficients),
            DistortionModel::Polynomial | DistortionModel::Division | DistortionModel::KannalaBrandt => {
                Err(misfit("an omnidirectional lens has no such distortion").help("write model = \"brown-conrady\""))
            }
        },
    }
}

fn omnidirectional(xi: Option<f64>, distortion: BrownConrady) -> Result<Projection, Invalid> {
    let xi = xi.ok_or_else(|| {
        Invalid::new("xi", "is missing, and projection = \"omnidirectional\" needs it")
            .help("write the mirror parameter, for example xi = 1.2")
    })?;
    if !(xi.is_finite() && xi >= 0.0) {
        return Err(Invalid::new("xi", format!("must be 0 or more, got {xi}")));
    }
    if distortion.k[2..] != [0.0; 4] || distortion.s != [0.0; 4] {
        let message = "an omnidirectional lens has k₁, k₂, p₁ and p₂ only";
        return Err(Invalid::new("distortion", message).help("write k = [k1, k2] and p = [p1, p2]"));
    }
    Ok(Projection::Omnidirectional { xi, distortion })
}

fn misfit(message: &str) -> Invalid {
    Invalid::new("distortion.model", message)
}

/// The coefficients in the slots of Brown and Conrady's model, whatever the model, checked.
fn coefficients(table: &DistortionTable) -> Result<BrownConrady, Invalid> {
    let ((k, p, s), example) = match table.model {
        DistortionModel::None => ((0, 0, 0), "write the model, for example model = \"brown-conrady\""),
        DistortionModel::BrownConrady => {
            ((6, 2, 4), "write k = [k1, k2, k3, k4, k5, k6], p = [p1, p2], s = [s1, s2, s3, s4]")
        }
        DistortionModel::Polynomial => ((2, 0, 0), "write k = [k1, k2]"),
        DistortionModel::Division => ((1, 0, 0), "write k = [λ]"),
        DistortionModel::KannalaBrandt => ((4, 0, 0), "write k = [k1, k2, k3, k4]"),
    };
    for (key, values, most) in [("k", &table.k, k), ("p", &table.p, p), ("s", &table.s, s)] {
        if values.len() > most {
            let message = match most {
                0 => "the model has no such coefficients".to_owned(),
                _ => format!("the model has {most} of these coefficients, not {}", values.len()),
            };
            return Err(Invalid::new(key, message).help(example));
        }
        if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            return Err(Invalid::new(key, format!("must be finite, got {value}")));
        }
    }
    Ok(BrownConrady { k: filled(&table.k), p: filled(&table.p), s: filled(&table.s) })
}

/// Coefficients with zeros for those that are left out.
fn filled<const N: usize>(values: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| values.get(i).copied().unwrap_or(0.0))
}
