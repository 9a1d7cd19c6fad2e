//! Whole digital numbers, of which an image consists, in the place of floating-point ones.
//!
//! Floating-point numbers that are whole and fit into 16 bits stay as they are. Others are put on a scale on which white
//! is a whole number and the largest of them at most 65 535:
//!
//! DN = (x − low)·s,  s = ⌊65 535·(white − low)/(high − low)⌋/(white − low)
//!
//! with the lowest of them, or 0 where none is below, for `low`; black and white levels follow. Each is then off by half
//! a step, 1/(2s), at most.

use rayon::prelude::*;

use super::read_pixel_values::PixelValues;
use crate::BlackLevel;
use photosite_core::Invalid;

/// Whole digital numbers with their black and white levels.
pub(super) struct Whole {
    pub(super) data: Vec<u16>,
    pub(super) black_level_dn: BlackLevel,
    /// A value of each channel.
    pub(super) whites: Vec<u16>,
    /// Warning, where numbers were rounded.
    pub(super) rounded: Option<String>,
}

const LARGEST: f64 = 65_535.0;

impl Whole {
    /// Turns the numbers of a file into whole ones, with its black level and the white level of each channel.
    pub(super) fn of(numbers: PixelValues, black: BlackLevel, whites: Vec<f64>) -> Result<Self, Invalid> {
        let lowest_white = whites.iter().copied().fold(f64::INFINITY, f64::min);
        let range = |most: f64| {
            if f64::from(black.mean()) < lowest_white && whites.iter().all(|white| *white <= most) {
                return Ok(());
            }
            let message = format!("white level {lowest_white} and black level {} leave no range", black.mean());
            Err(Invalid::new("WhiteLevel", message))
        };
        let floats = match numbers {
            PixelValues::Whole(data) => {
                range(LARGEST)?;
                let whites = whites.into_iter().map(|white| white as u16).collect();
                return Ok(Self { data, black_level_dn: black, whites, rounded: None });
            }
            PixelValues::Floats(floats) => floats,
        };
        range(f64::MAX)?;
        let is_whole = |x: f64| x.fract() == 0.0 && (0.0..=LARGEST).contains(&x);
        if whites.iter().copied().all(is_whole) && floats.par_iter().all(|&x| is_whole(x.into())) {
            let data = floats.into_par_iter().map(|x| x as u16).collect();
            let whites = whites.into_iter().map(|white| white as u16).collect();
            return Ok(Self { data, black_level_dn: black, whites, rounded: None });
        }
        let not_finite = floats.par_iter().filter(|x| !x.is_finite()).count();
        if not_finite > 0 {
            let message = format!("{not_finite} of its floating-point numbers are not finite");
            return Err(Invalid::new("", message).help("the file is damaged, or write them anew as finite ones"));
        }
        let low = floats.par_iter().copied().reduce(|| 0.0, f32::min);
        let high = floats.par_iter().copied().reduce(|| 0.0, f32::max);
        let (low, high) = (f64::from(low), whites.iter().copied().fold(f64::from(high), f64::max));
        // With one white level it becomes a whole number, and of several the largest.
        let white = whites.iter().copied().fold(lowest_white, f64::max);
        let scale = (LARGEST * (white - low) / (high - low)).floor() / (white - low);
        if !(scale.is_finite() && scale > 0.0 && (lowest_white - low) * scale >= 1.0) {
            let message = format!("its floating-point numbers from {low} to {high} are beyond white at {lowest_white}");
            return Err(
                Invalid::new("WhiteLevel", message).help("photosite reads a range of 65 535 times the white level")
            );
        }
        let step = 1.0 / scale;
        Ok(Self {
            data: floats.into_par_iter().map(|x| ((f64::from(x) - low) * scale).round() as u16).collect(),
            black_level_dn: black.on_scale(low, scale),
            whites: whites.into_iter().map(|white| ((white - low) * scale).round() as u16).collect(),
            rounded: Some(format!(
                "its floating-point numbers from {low} to {high} are rounded to 65 536 levels, {step:.3e} apart"
            )),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(floats: &[f32], black: f32, white: f64) -> Result<Whole, Invalid> {
        Whole::of(PixelValues::Floats(floats.to_vec()), BlackLevel::uniform(black), vec![white])
    }

    #[test]
    fn numbers_keep_their_share_of_white() {
        for (floats, black, white) in [
            (vec![0.0, 0.25, 0.5, 1.0], 0.0, 1.0),
            (vec![-0.125, 0.25, 0.5, 1.0], 0.0, 1.0),
            (vec![0.1, 7.25, 40.0], 0.1, 16.0),
            (vec![0.5, 2e5, 1e6], 512.0, 3e5),
        ] {
            let found = whole(&floats, black, white).expect("a range");
            let (level, top) = (f64::from(found.black_level_dn.mean()), f64::from(found.whites[0]));
            for (x, dn) in floats.iter().zip(&found.data) {
                let wanted = (f64::from(*x) - f64::from(black)) / (white - f64::from(black));
                // Half a step, and what f32 rounds of levels up to 2¹⁶.
                let tolerance = (0.5 + 2f64.powi(-8)) / (top - level);
                assert!(((f64::from(*dn) - level) / (top - level) - wanted).abs() < tolerance, "{x} of {white}");
            }
            assert!(found.rounded.is_some());
        }
    }

    #[test]
    fn whole_numbers_stay_and_what_is_no_number_is_refused() {
        let found = whole(&[0.0, 7.0, 65_535.0], 3.5, 4095.0).expect("whole");
        assert_eq!((found.data, found.whites, found.rounded), (vec![0, 7, 65_535], vec![4095], None));
        assert_eq!(found.black_level_dn, BlackLevel::uniform(3.5));
        assert!(whole(&[0.5, f32::NAN], 0.0, 1.0).is_err_and(|error| error.message.contains("1 of its")));
        assert!(whole(&[0.5, f32::INFINITY], 0.0, 1.0).is_err());
        assert!(whole(&[0.5, 1e38], 0.0, 1e-3).is_err());
        assert!(whole(&[0.5], 1.0, 1.0).is_err());
    }
}
