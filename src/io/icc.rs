//! ICC profiles: what the codes of a picture mean, for every viewer ([Icc4](crate::references#icc4)).
//!
//! A profile of version 4 with a matrix and a parametric curve, or for grey with the curve alone. No date but a fixed
//! one is written, so that the same picture gives the same bytes.

use std::io;

use moxcms::{
    ColorProfile, DataColorSpace, LocalizableString, Matrix3d, ProfileClass, ProfileText, RenderingIntent,
    ToneReprCurve, Xyzd,
};

use crate::colour::adaptation::{D50, bradford};
use crate::colour::{ColourSpace, Transfer};
use crate::develop::EncodedPicture;

/// The profile of a picture.
pub(super) fn icc_profile(picture: &EncodedPicture) -> io::Result<Vec<u8>> {
    let profile = profile(picture.colour_space, picture.transfer, picture.components == 1);
    let mut bytes = profile.encode().map_err(io::Error::other)?;
    // The encoder writes the present time: year, month, day, hour, minute, second from byte 24 on.
    for (to, number) in bytes[24..36].chunks_exact_mut(2).zip([2026u16, 1, 1, 0, 0, 0]) {
        to.copy_from_slice(&number.to_be_bytes());
    }
    Ok(bytes)
}

fn profile(space: ColourSpace, transfer: Transfer, grey: bool) -> ColorProfile {
    let text = |text: &str| {
        Some(ProfileText::Localizable(vec![LocalizableString::new("en".into(), "US".into(), text.to_owned())]))
    };
    let curve = Some(curve(transfer));
    let adaptation = bradford(space.white(), D50);
    let [red, green, blue] = (adaptation * space.to_xyz()).to_cols_array_2d().map(xyz);
    let rows = adaptation.transpose().to_cols_array_2d();
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
    profile.chromatic_adaptation = Some(Matrix3d { v: rows });
    profile.description = text(&if grey { format!("Grey, {name}") } else { name });
    profile.copyright = text("No copyright");
    if grey {
        profile.color_space = DataColorSpace::Gray;
        profile.gray_trc = curve;
    } else {
        profile.color_space = DataColorSpace::Rgb;
        (profile.red_colorant, profile.green_colorant, profile.blue_colorant) = (red, green, blue);
        (profile.red_trc, profile.green_trc, profile.blue_trc) = (curve.clone(), curve.clone(), curve);
    }
    profile
}

/// From codes to linear values: the parametric curve of type 3 or 0.
fn curve(transfer: Transfer) -> ToneReprCurve {
    ToneReprCurve::Parametric(match transfer {
        Transfer::Linear => vec![1.0],
        Transfer::Gamma(gamma) => vec![gamma as f32],
        Transfer::Srgb => vec![2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.040_45],
    })
}

fn xyz([x, y, z]: [f64; 3]) -> Xyzd {
    Xyzd { x, y, z }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn profiles_can_be_read_back_and_say_what_they_should() {
        for space in [ColourSpace::Srgb, ColourSpace::DisplayP3, ColourSpace::Rec2020, ColourSpace::Acescg] {
            for transfer in [Transfer::Srgb, Transfer::Linear, Transfer::Gamma(2.2)] {
                for grey in [false, true] {
                    let bytes = profile(space, transfer, grey).encode().expect("encoded");
                    let read = ColorProfile::new_from_slice(&bytes).expect("a profile");
                    let trc = if grey { read.gray_trc.clone() } else { read.red_trc.clone() };
                    let Some(ToneReprCurve::Parametric(found)) = trc else { panic!("{space:?} {transfer:?}: {trc:?}") };
                    let ToneReprCurve::Parametric(expected) = curve(transfer) else { panic!("parametric") };
                    // Sixteen bits after the point.
                    assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1.0 / 65_536.0), "{found:?}");
                    if !grey {
                        let [r, g, b] = [read.red_colorant, read.green_colorant, read.blue_colorant];
                        let white = DVec3::new(r.x + g.x + b.x, r.y + g.y + b.y, r.z + g.z + b.z);
                        assert!(white.abs_diff_eq(D50, 3.0 / 65_536.0), "{space:?}: white is {white}");
                    }
                }
            }
        }
    }

    #[test]
    fn srgb_is_the_srgb_of_everybody() {
        let (ours, theirs) = (profile(ColourSpace::Srgb, Transfer::Srgb, false), ColorProfile::new_srgb());
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
