//! ICC profiles: the meaning of an image's codes, for every viewer ([Icc4](photosite_core::references#icc4)).
//!
//! Profiles are of version 4 with a matrix and a parametric curve, or for grey with the curve alone. They have a fixed
//! date, so that the same image gives the same bytes. The clock is not read: an encoder that does so recurses without
//! end where it is set before 1970.

use photosite_core::colour::adaptation::{D50, bradford};
use photosite_core::colour::{ColourSpace, Transfer};
use photosite_develop::EncodedImage;

/// Bytes of the header with the number of tags, and of a tag in the table behind it.
const HEADER: usize = 132;
const TAG: usize = 12;
/// Date of all profiles: year, month, day, hour, minute, second.
const DATE: [u16; 6] = [2026, 1, 1, 0, 0, 0];

/// ICC profile of an image.
pub(super) fn icc_profile(image: &EncodedImage) -> Vec<u8> {
    profile(image.colour_space, image.transfer, image.components == 1)
}

fn profile(space: ColourSpace, transfer: Transfer, grey: bool) -> Vec<u8> {
    let adaptation = bradford(space.white(), D50);
    let name = match transfer {
        Transfer::Srgb => space.name().to_owned(),
        Transfer::Linear => format!("{}, linear", space.name()),
        Transfer::Gamma(gamma) => format!("{}, gamma {gamma}", space.name()),
    };
    let mut tags: Vec<(&[u8; 4], Vec<u8>)> = Vec::new();
    if !grey {
        let colorants = (adaptation * space.to_xyz()).to_cols_array_2d();
        tags.extend([b"rXYZ", b"gXYZ", b"bXYZ"].into_iter().zip(colorants.map(xyz)));
    }
    let rows = adaptation.transpose().to_cols_array();
    tags.push((b"chad", typed(b"sf32", &rows.map(fixed).concat())));
    let curves: &[&[u8; 4]] = if grey { &[b"kTRC"] } else { &[b"rTRC", b"gTRC", b"bTRC"] };
    tags.extend(curves.iter().map(|&tag| (tag, curve(transfer))));
    tags.push((b"wtpt", xyz(D50.to_array())));
    tags.push((b"desc", text(&if grey { format!("Grey, {name}") } else { name })));
    tags.push((b"cprt", text("No copyright")));

    let mut table = Vec::new();
    let mut values = Vec::new();
    for (tag, value) in &tags {
        let at = HEADER + TAG * tags.len() + values.len();
        table.extend_from_slice(&[**tag, (at as u32).to_be_bytes(), (value.len() as u32).to_be_bytes()].concat());
        values.extend_from_slice(value);
    }
    let size = HEADER + table.len() + values.len();
    let mut bytes = (size as u32).to_be_bytes().to_vec();
    bytes.extend([0; 4]);
    // Version, what it is for, the space of codes, the space between profiles.
    bytes.extend([4, 0x40, 0, 0]);
    bytes.extend_from_slice(b"mntr");
    bytes.extend_from_slice(if grey { b"GRAY" } else { b"RGB " });
    bytes.extend_from_slice(b"XYZ ");
    bytes.extend(DATE.iter().flat_map(|number| number.to_be_bytes()));
    bytes.extend_from_slice(b"acsp");
    // Nothing of platform, device and maker; relative colorimetry.
    bytes.extend([0; 24]);
    bytes.extend(1u32.to_be_bytes());
    bytes.extend(D50.to_array().map(fixed).concat());
    // Nor of who made it and of its checksum.
    bytes.extend([0; 48]);
    bytes.extend((tags.len() as u32).to_be_bytes());
    [bytes, table, values].concat()
}

/// Value with the signature of its type.
fn typed(kind: &[u8; 4], value: &[u8]) -> Vec<u8> {
    [&kind[..], &[0; 4], value].concat()
}

/// Number with 16 bits after the binary point (s15Fixed16Number).
fn fixed(number: f64) -> [u8; 4] {
    // The conversion saturates.
    ((number * 65_536.0 + 0.5).floor() as i32).to_be_bytes()
}

fn xyz(xyz: [f64; 3]) -> Vec<u8> {
    typed(b"XYZ ", &xyz.map(fixed).concat())
}

/// Text in English.
fn text(text: &str) -> Vec<u8> {
    let utf16: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    // One record of 12 bytes, whose text begins at byte 28.
    let numbers = |numbers: [u32; 2]| numbers.map(u32::to_be_bytes).concat();
    typed(b"mluc", &[&numbers([1, 12])[..], b"enUS", &numbers([utf16.len() as u32, 28]), &utf16].concat())
}

/// Curve from codes to linear values: parametric, of type 3 or 0.
fn curve(transfer: Transfer) -> Vec<u8> {
    let (kind, parameters): (u16, &[f64]) = match transfer {
        Transfer::Linear => (0, &[1.0]),
        Transfer::Gamma(gamma) => (0, &[gamma]),
        Transfer::Srgb => (3, &[2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.040_45]),
    };
    // In single precision, as curves are computed with.
    let parameters = parameters.iter().flat_map(|&parameter| fixed(f64::from(parameter as f32)));
    typed(b"para", &kind.to_be_bytes().into_iter().chain([0; 2]).chain(parameters).collect::<Vec<u8>>())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use moxcms::{
        ColorProfile, DataColorSpace, LocalizableString, Matrix3d, ProfileClass, ProfileText, RenderingIntent,
        ToneReprCurve, Xyzd,
    };

    use super::*;

    const SPACES: [ColourSpace; 4] =
        [ColourSpace::Srgb, ColourSpace::DisplayP3, ColourSpace::Rec2020, ColourSpace::Acescg];
    const TRANSFERS: [Transfer; 4] = [Transfer::Srgb, Transfer::Linear, Transfer::Gamma(2.2), Transfer::Gamma(1.8)];

    fn read(space: ColourSpace, transfer: Transfer, grey: bool) -> ColorProfile {
        ColorProfile::new_from_slice(&profile(space, transfer, grey)).expect("a profile")
    }

    /// Reference: the profile by the encoder of a crate, but for the date.
    fn encoded(space: ColourSpace, transfer: Transfer, grey: bool) -> Vec<u8> {
        let xyz = |[x, y, z]: [f64; 3]| Xyzd { x, y, z };
        let text =
            |text: String| Some(ProfileText::Localizable(vec![LocalizableString::new("en".into(), "US".into(), text)]));
        let curve = Some(ToneReprCurve::Parametric(match transfer {
            Transfer::Linear => vec![1.0],
            Transfer::Gamma(gamma) => vec![gamma as f32],
            Transfer::Srgb => vec![2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.040_45],
        }));
        let adaptation = bradford(space.white(), D50);
        let [red, green, blue] = (adaptation * space.to_xyz()).to_cols_array_2d().map(xyz);
        let name = match transfer {
            Transfer::Srgb => space.name().to_owned(),
            Transfer::Linear => format!("{}, linear", space.name()),
            Transfer::Gamma(gamma) => format!("{}, gamma {gamma}", space.name()),
        };
        let mut profile = ColorProfile::default();
        profile.profile_class = ProfileClass::DisplayDevice;
        profile.rendering_intent = RenderingIntent::RelativeColorimetric;
        profile.pcs = DataColorSpace::Xyz;
        profile.white_point = xyz(D50.to_array());
        profile.media_white_point = Some(xyz(D50.to_array()));
        profile.chromatic_adaptation = Some(Matrix3d { v: adaptation.transpose().to_cols_array_2d() });
        profile.description = text(if grey { format!("Grey, {name}") } else { name });
        profile.copyright = text("No copyright".to_owned());
        if grey {
            profile.color_space = DataColorSpace::Gray;
            profile.gray_trc = curve;
        } else {
            profile.color_space = DataColorSpace::Rgb;
            (profile.red_colorant, profile.green_colorant, profile.blue_colorant) = (red, green, blue);
            (profile.red_trc, profile.green_trc, profile.blue_trc) = (curve.clone(), curve.clone(), curve);
        }
        let mut bytes = profile.encode().expect("encoded");
        bytes[24..36].copy_from_slice(&DATE.map(u16::to_be_bytes).concat());
        bytes
    }

    #[test]
    fn another_encoder_writes_the_same_bytes() {
        for space in SPACES {
            for transfer in TRANSFERS {
                for grey in [false, true] {
                    let expected = encoded(space, transfer, grey);
                    assert!(profile(space, transfer, grey) == expected, "{space:?}, {transfer:?}, grey: {grey}");
                }
            }
        }
    }

    #[test]
    fn profiles_can_be_read_back_and_say_what_they_should() {
        for space in SPACES {
            for transfer in TRANSFERS {
                let read = read(space, transfer, false);
                let [r, g, b] = [read.red_colorant, read.green_colorant, read.blue_colorant];
                let white = DVec3::new(r.x + g.x + b.x, r.y + g.y + b.y, r.z + g.z + b.z);
                assert!(white.abs_diff_eq(D50, 3.0 / 65_536.0), "{space:?}: white is {white}");
            }
        }
    }

    #[test]
    fn srgb_is_the_srgb_of_everybody() {
        let (ours, theirs) = (read(ColourSpace::Srgb, Transfer::Srgb, false), ColorProfile::new_srgb());
        for (a, b) in [
            (ours.red_colorant, theirs.red_colorant),
            (ours.green_colorant, theirs.green_colorant),
            (ours.blue_colorant, theirs.blue_colorant),
        ] {
            // Their white is the rounded (0.3127, 0.3290).
            assert!([a.x - b.x, a.y - b.y, a.z - b.z].iter().all(|d| d.abs() < 4e-4), "{a:?} {b:?}");
        }
    }
}
