//! Description of a raw file by its user: TIFF, PGM and NPY files hold nothing but numbers.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;
use photosite_raw::{BlackLevel, Cfa, ColourCalibration, LightSource, RawImage};

/// Facts that hold of a raw file whatever it says itself: TIFF, PGM and NPY files say nothing of this. What is left out
/// is what the file says, or of such files that of a monochrome or RGB image that goes from 0 to the largest number.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields, default)]
pub struct RawDescription {
    /// Colour filter array, as sensor.cfa has it: "RGGB", "x-trans". Left out: that of the
    /// file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cfa: Option<String>,
    /// Number of no light. Left out: that of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..65_535.0))]
    pub black_level_dn: Option<f32>,
    /// Smallest number at which a pixel counts as saturated. Left out: that of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub white_level_dn: Option<u16>,
    /// The camera's response to the scene's white, a number for each channel (DNG AsShotNeutral). Left
    /// out: that of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_shot_neutral: Option<Vec<f64>>,
    /// XYZ → camera under D65, a row for each channel (DNG ColorMatrix). Left out: that of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colour_matrix_d65: Option<Vec<[f64; 3]>>,
}

impl RawDescription {
    /// Refuses what cannot hold of any file.
    pub(super) fn validate(&self) -> Result<(), Invalid> {
        if let Some(cfa) = &self.cfa {
            Cfa::parse(cfa)?;
        }
        if self.black_level_dn.is_some_and(|dn| !(0.0..65_535.0).contains(&dn)) {
            let message = "must lie from 0 to below 65535";
            return Err(Invalid::new("black_level_dn", message).help("for example black_level_dn = 64"));
        }
        Ok(())
    }

    /// Image with the facts of the description.
    pub(super) fn apply<'a>(&self, raw: &'a RawImage) -> Result<Cow<'a, RawImage>, Invalid> {
        if *self == Self::default() {
            return Ok(Cow::Borrowed(raw));
        }
        let mut raw = raw.clone();
        if let Some(text) = &self.cfa {
            let cfa = Cfa::parse(text)?;
            let [given, stored] = [&cfa, &raw.cfa].map(Cfa::samples_per_pixel);
            if given != stored {
                let message = format!("{text:?} has {given} values per pixel, the file {stored}");
                return Err(Invalid::new("cfa", message).help("give the filters of the sensor that took it"));
            }
            if cfa.channels() != raw.cfa.channels() {
                // What the file says is of other channels.
                let metadata = &mut raw.metadata;
                metadata.noise_profile.clear();
                metadata.as_shot_neutral = None;
                metadata.calibrations.clear();
                raw.black_level_dn = BlackLevel::uniform(raw.black_level_dn.mean());
                raw.channel_whites_dn = None;
            }
            raw.cfa = cfa;
        }
        if let Some(dn) = self.black_level_dn {
            raw.black_level_dn = BlackLevel::uniform(dn);
        }
        if let Some(dn) = self.white_level_dn {
            (raw.white_level_dn, raw.channel_whites_dn) = (dn, None);
        }
        let (black, white) = (raw.black_level_dn.mean(), raw.white_level_dn);
        if black >= white.into() {
            let message = format!("white level {white} and black level {black} leave no range");
            return Err(Invalid::new("white_level_dn", message).help("give a white level above the black level"));
        }
        let channels = raw.cfa.channels().len();
        let of_channels = |key: &str, given: Option<usize>| match given {
            Some(count) if count != channels => {
                let message = format!("{count} entries for the channels {}", raw.cfa.channels().join(", "));
                Err(Invalid::new(key, message).help("give one for each channel"))
            }
            Some(_) | None => Ok(()),
        };
        of_channels("as_shot_neutral", self.as_shot_neutral.as_ref().map(Vec::len))?;
        of_channels("colour_matrix_d65", self.colour_matrix_d65.as_ref().map(Vec::len))?;
        if let Some(neutral) = &self.as_shot_neutral {
            raw.metadata.as_shot_neutral = Some(neutral.clone());
        }
        if let Some(matrix) = &self.colour_matrix_d65 {
            let (light, colour_matrix) = (LightSource::D65, matrix.clone());
            raw.metadata.calibrations = vec![ColourCalibration { light, colour_matrix, forward_matrix: None }];
        }
        Ok(Cow::Owned(raw))
    }

    /// Error about a fact of a file, under the key that stated the fact in place of the file.
    pub(super) fn blamed(&self, invalid: Invalid) -> Invalid {
        let [neutral, matrix] = [self.as_shot_neutral.is_some(), self.colour_matrix_d65.is_some()];
        let (key, help) = match invalid.key.as_str() {
            "AsShotNeutral" if neutral => ("as_shot_neutral", "give numbers above 0, for example [0.5, 1, 0.7]"),
            "AsShotNeutral" | "ColorMatrix1" if matrix => (
                "colour_matrix_d65",
                "give rows that tell the colours of three channels at least apart, or leave it out",
            ),
            "ColorMatrix1" if neutral => ("as_shot_neutral", "give what the camera of the file responds to white"),
            _ => return invalid,
        };
        Invalid { key: key.to_owned(), ..invalid }.help(help).within("raw")
    }
}

#[cfg(test)]
mod tests {
    use rstest::rstest;

    use super::*;
    use crate::{DevelopSettings, develop_linear};

    const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn what_is_given_holds_and_what_cannot_be_is_refused() {
        let raw = RawImage { width: 2, height: 2, data: vec![100; 4], ..RawImage::default() };
        let bayer = || RawDescription { cfa: Some("GRBG".to_owned()), ..RawDescription::default() };
        let given = RawDescription {
            black_level_dn: Some(64.0),
            white_level_dn: Some(4095),
            as_shot_neutral: Some(vec![0.5, 1.0, 0.7]),
            colour_matrix_d65: Some(vec![[1.0, 0.0, 0.0]; 3]),
            ..bayer()
        };
        assert_eq!(given.validate(), Ok(()));
        let found = given.apply(&raw).expect("possible");
        assert_eq!(
            (found.cfa.to_string(), found.white_level_dn, found.black_level_dn.mean()),
            ("GRBG".to_owned(), 4095, 64.0)
        );
        assert_eq!((&found.metadata.as_shot_neutral, &found.data), (&given.as_shot_neutral, &raw.data));
        for (given, key) in [
            (RawDescription { cfa: Some("full:RGB".to_owned()), ..given.clone() }, "cfa"),
            (RawDescription { white_level_dn: Some(64), ..given.clone() }, "white_level_dn"),
            (RawDescription { as_shot_neutral: Some(vec![1.0; 4]), ..bayer() }, "as_shot_neutral"),
            (RawDescription { colour_matrix_d65: Some(vec![[1.0; 3]; 2]), ..bayer() }, "colour_matrix_d65"),
        ] {
            assert_eq!(given.apply(&raw).expect_err(key).key, key);
        }
        assert_eq!(
            RawDescription { cfa: Some("RGBGR".to_owned()), ..given.clone() }.validate().expect_err("no tile").key,
            "cfa"
        );
        assert_eq!(
            RawDescription { black_level_dn: Some(f32::NAN), ..given }.validate().expect_err("none").key,
            "black_level_dn"
        );
    }

    #[rstest]
    #[case::one_channel("mono", None, vec![[1.0, 0.5, 0.2]], "raw.colour_matrix_d65")]
    #[case::alike("RGGB", None, vec![[1.0; 3]; 3], "raw.colour_matrix_d65")]
    #[case::blind("RGGB", None, vec![[0.0; 3]; 3], "raw.colour_matrix_d65")]
    #[case::no_number("RGGB", None, vec![[f64::NAN; 3]; 3], "raw.colour_matrix_d65")]
    #[case::no_response("RGGB", Some(vec![0.0; 3]), IDENTITY.to_vec(), "raw.as_shot_neutral")]
    #[case::negative("RGGB", Some(vec![-1.0; 3]), IDENTITY.to_vec(), "raw.as_shot_neutral")]
    fn facts_that_give_no_colour_are_refused_by_the_key_that_stated_them(
        #[case] cfa: &str,
        #[case] as_shot_neutral: Option<Vec<f64>>,
        #[case] matrix: Vec<[f64; 3]>,
        #[case] key: &str,
    ) {
        let raw = RawImage { width: 16, height: 16, data: vec![100; 256], ..RawImage::default() };
        let given = RawDescription {
            cfa: Some(cfa.to_owned()),
            as_shot_neutral,
            colour_matrix_d65: Some(matrix),
            ..RawDescription::default()
        };
        let settings = DevelopSettings { raw: given, ..DevelopSettings::default() };
        assert_eq!(develop_linear(&raw, &settings).expect_err(key).key, key);
    }
}
