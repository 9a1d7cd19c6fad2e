//! Linearisation: nonlinear digital numbers of a sensor become linear again.

use std::borrow::Cow;

use photosite_raw::{BlackLevel, RawImage};

/// Image with linear values, by the table that its file has. Without that its values stay as they are, and the levels
/// become the values that stand for them.
pub(super) fn apply(raw: &RawImage, linearise: bool) -> Cow<'_, RawImage> {
    let Some(table) = raw.linearisation.as_ref().filter(|_| !linearise) else { return raw.linear() };
    let standing_for = |level: f32| table.iter().position(|&linear| f32::from(linear) >= level).unwrap_or(table.len());
    let number = |level: f32| u16::try_from(standing_for(level)).unwrap_or(u16::MAX);
    let mut raw = raw.clone();
    raw.black_level_dn = BlackLevel::uniform(number(raw.black_level_dn.mean()).into());
    raw.white_level_dn = number(raw.white_level_dn.into());
    raw.channel_whites_dn =
        raw.channel_whites_dn.map(|whites| whites.into_iter().map(|dn| number(dn.into())).collect());
    raw.linearisation = None;
    Cow::Owned(raw)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_follow_the_numbers() {
        let table: Vec<u16> = (0..256u16).map(|code| 16 + code * code / 16).collect();
        let raw = RawImage {
            width: 3,
            height: 1,
            data: vec![0, 128, 255],
            linearisation: Some(table),
            black_level_dn: 32.into(),
            white_level_dn: 3000,
            ..RawImage::default()
        };
        let linear = apply(&raw, true);
        assert_eq!((&linear.data[..], linear.white_level_dn), (&[16, 1040, 4080][..], 3000));
        let nonlinear = apply(&raw, false);
        // 16²/16 = 16 above the table's first, and 218.5² = 16·2984.
        assert_eq!(
            (&nonlinear.data[..], nonlinear.black_level_dn.as_uniform(), nonlinear.white_level_dn),
            (&[0, 128, 255][..], Some(16.0), 219)
        );
        assert_eq!(nonlinear.linearisation, None);
    }
}
