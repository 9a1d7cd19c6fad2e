//! Colours of linear images: from the primaries and white of a file to linear sRGB.

use glam::{DMat3, DVec3};

use photosite_core::Invalid;
use photosite_core::colour::ColourSpace;

/// CIE x and y of red, green, blue and white.
pub type Chromaticities = [[f64; 2]; 4];

/// Linear RGB → linear sRGB, white to white ([Bradford](photosite_core::colour::adaptation)).
///
/// # Errors
///
/// Points that are no primaries, because they lie on a line, or white has no luminance.
pub fn to_srgb(stated: Chromaticities) -> Result<DMat3, Invalid> {
    // Files round what they say; those of sRGB are meant to be it.
    if are_alike(stated, ColourSpace::Srgb.chromaticities()) {
        return Ok(DMat3::IDENTITY);
    }
    let white = xyz(stated[3]) / stated[3][1];
    let to_srgb = ColourSpace::Srgb.from_xyz(white) * to_xyz(stated)?;
    if to_srgb.is_finite() { Ok(to_srgb) } else { Err(no_primaries(stated)) }
}

/// Weights of R, G and B of these primaries in luminance, 1 in all.
pub(super) fn luminance_weights(stated: Chromaticities) -> Result<DVec3, Invalid> {
    Ok(to_xyz(stated)?.row(1))
}

/// Linear RGB → XYZ, Y = 1 for white. Primaries may have no luminance, as those of XYZ itself.
fn to_xyz(stated: Chromaticities) -> Result<DMat3, Invalid> {
    let [red, green, blue, white] = stated.map(xyz);
    let primaries = DMat3::from_cols(red, green, blue);
    let parts = primaries.inverse() * (white / white.y);
    let is_fit = primaries.determinant().abs() > LEAST_AREA && white.y > 0.0 && parts.is_finite();
    if is_fit { Ok(primaries * DMat3::from_diagonal(parts)) } else { Err(no_primaries(stated)) }
}

/// Smallest doubled area of a triangle of primaries in x and y: below it, a header's 24-bit numbers no longer tell the
/// triangle from a line. That of sRGB is 0.22.
const LEAST_AREA: f64 = 1e-6;

fn no_primaries(stated: Chromaticities) -> Invalid {
    let message = format!("red, green, blue and white at {stated:?} (CIE x, y) span no colours");
    Invalid::new("chromaticities", message).help("correct them, or leave them out where the image is linear sRGB")
}

/// Tristimulus values of a chromaticity, with X + Y + Z = 1.
fn xyz([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x, y, 1.0 - x - y)
}

/// Whether chromaticities agree up to the rounding of files.
pub(crate) fn are_alike(a: Chromaticities, b: Chromaticities) -> bool {
    a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-3)
}

/// Meaning of an identifier of the Color Interop Forum.
pub(super) enum Interop {
    /// Linear light of these primaries.
    Linear(Chromaticities),
    /// Linear X, Y and Z relative to D65.
    Xyz,
    /// Unknown identifier.
    Unknown,
    /// Non-colour data, codes of a display, or an unsupported space.
    Other,
}

const D65: [f64; 2] = [0.3127, 0.329];
const ACES_WHITE: [f64; 2] = [0.321_68, 0.337_67];
/// Primaries and white of named spaces (SMPTE ST 2065-1, ACEScg, SMPTE EG 432-1, BT.2020, Adobe RGB (1998)).
const LINEAR: [(&str, Chromaticities); 6] = [
    ("rec709", [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], D65]),
    ("ap0", [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], ACES_WHITE]),
    ("ap1", [[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], ACES_WHITE]),
    ("p3d65", [[0.68, 0.32], [0.265, 0.69], [0.15, 0.06], D65]),
    ("rec2020", [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], D65]),
    ("adobergb", [[0.64, 0.33], [0.21, 0.71], [0.15, 0.06], D65]),
];
/// The primaries of ACES containers.
pub(super) const ACES: Chromaticities = LINEAR[1].1;

impl Interop {
    pub(super) fn of(id: &str) -> Self {
        let name = id.strip_prefix("lin_").map(|name| name.strip_suffix("_scene").unwrap_or(name));
        match name {
            Some("ciexyzd65") => Self::Xyz,
            Some(name) => {
                LINEAR.iter().find(|(known, _)| *known == name).map_or(Self::Other, |(_, points)| Self::Linear(*points))
            }
            None if id == "unknown" => Self::Unknown,
            None => Self::Other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_primaries_of_xyz_are_its_axes() {
        let axes = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0; 2]];
        assert!(to_xyz(axes).expect("a space").abs_diff_eq(DMat3::IDENTITY, 1e-12));
        let white = to_srgb(axes).expect("a space") * DVec3::ONE;
        assert!(white.abs_diff_eq(DVec3::ONE, 1e-12), "{white}");
    }

    #[test]
    fn points_that_span_nothing_are_refused() {
        let [red, green, blue, white] = LINEAR[0].1;
        for points in [
            [red, red, blue, white],
            [red, [0.35, 0.38], [0.06, 0.43], white],
            [red, green, blue, [0.3, 0.0]],
            [[0.0; 2]; 4],
            [[f64::NAN, 0.3], green, blue, white],
            [red, green, [f64::INFINITY, 0.0], white],
        ] {
            assert_eq!(to_srgb(points).expect_err("refused").key, "chromaticities", "{points:?}");
        }
    }

    #[test]
    fn matrices_are_the_published_ones() {
        // ITU-R BT.2087, annex 1: BT.2020 to BT.709, to four decimals.
        let rows = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
        let found = to_srgb(LINEAR[4].1).expect("a space");
        for (i, row) in rows.into_iter().enumerate() {
            // White is that of the tabulated D65, which differs in the fifth decimal.
            assert!(found.row(i).abs_diff_eq(DVec3::from_array(row), 3e-4), "{found}");
        }
    }
}
