//! Colour filters as DNG files number them (TIFF/EP, CFAPlaneColor).

use crate::Cfa;
use photosite_core::Invalid;

/// Letters of the codes 0–6: red, green, blue, cyan, magenta, yellow, white.
const LETTERS: [&str; 7] = ["R", "G", "B", "C", "M", "Y", "W"];
const CYAN: u8 = 3;
const WHITE: u8 = 6;

/// The codes of a mosaic's channels; an error for what DNG has no word for.
///
/// `C` is cyan beside magenta or yellow, and else clear, which DNG calls white.
pub(crate) fn codes(cfa: &Cfa) -> Result<Vec<u8>, Invalid> {
    if cfa.is_mono() {
        return Ok(Vec::new());
    }
    let has = |letter: &str| cfa.channels().iter().any(|name| name == letter);
    if cfa.is_full() {
        return if cfa.channels() == ["R", "G", "B"] {
            Ok(vec![0, 1, 2])
        } else {
            let message = format!("DNG has no pixels of the channels {}", cfa.channels().join(", "));
            Err(Invalid::new("cfa", message).help("write raw = [\"tiff\"] or [\"npy\"], which hold any channels"))
        };
    }
    let code = |name: &String| match LETTERS.iter().position(|letter| letter == name) {
        Some(code) if code == usize::from(CYAN) && !has("M") && !has("Y") && !has("W") => Ok(WHITE),
        Some(code) => Ok(code as u8),
        None => {
            let message = format!("DNG has no filters called {name}; it knows {}", LETTERS.join(", "));
            Err(Invalid::new("cfa", message).help("write raw = [\"tiff\"] or [\"npy\"], which hold any channels"))
        }
    };
    cfa.channels().iter().map(code).collect()
}

/// The mosaic of these codes, `width` of them in a row; its channels are those of `planes`, in that order.
pub(super) fn mosaic(width: usize, codes: &[u8], planes: &[u8]) -> Result<Cfa, Invalid> {
    let refused = |message: &str| Invalid::new("CFAPattern", message).help("the file is damaged");
    let channels: Option<Vec<&str>> = planes.iter().map(|&code| LETTERS.get(usize::from(code)).copied()).collect();
    let channels = channels.ok_or_else(|| refused("a filter of no known colour"))?;
    let index = |code: &u8| planes.iter().position(|plane| plane == code).map(|i| i as u8);
    let tile: Option<Vec<u8>> = codes.iter().map(index).collect();
    let tile = tile.ok_or_else(|| refused("a filter that CFAPlaneColor does not list"))?;
    Cfa::of_indices(width, tile, &channels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clear_is_white_and_cyan_is_cyan() {
        for (text, expected) in [
            ("BGGR", vec![0, 1, 2]),
            ("rccb", vec![0, 2, 6]),
            ("cygm", vec![1, 3, 5, 4]),
            ("rgbw", vec![0, 1, 2, 6]),
            ("ryyb", vec![0, 2, 5]),
        ] {
            assert_eq!(codes(&Cfa::parse(text).expect("known")), Ok(expected), "{text}");
        }
        for text in ["rgb-ir", "RGEB", "full:RI", "full:RGBW"] {
            assert!(codes(&Cfa::parse(text).expect("known")).expect_err(text).help.is_some());
        }
    }
}
