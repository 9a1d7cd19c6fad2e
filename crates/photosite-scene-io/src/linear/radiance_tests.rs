use proptest::prelude::*;
use rstest::rstest;

use super::radiance::decode_radiance;
use super::{LinearImage, Mapping};
use photosite_core::Invalid;

/// A file with these header lines, size line and texels.
fn file(header: &str, size: &str, texels: &[[u8; 4]]) -> Vec<u8> {
    [header.as_bytes(), size.as_bytes(), b"\n", texels.as_flattened()].concat()
}

/// A file of one texel: mantissas over 256 times 2 to the exponent minus 128, so 1, 0.5 and 0.25.
fn one(header: &str) -> Result<LinearImage, Invalid> {
    decode_radiance(&file(header, "-Y 1 +X 1", &[[128, 64, 32, 129]]))
}

fn texel(light: &LinearImage, i: usize) -> [f32; 3] {
    ["R", "G", "B"].map(|name| light.planes.plane(name).expect("a colour")[i])
}

const RGBE: &str = "FORMAT=32-bit_rle_rgbe\n";

#[rstest]
#[case::radiance("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n")]
#[case::rgbe("#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n")]
#[case::another("#?AutoPano\nFORMAT=32-bit_rle_rgbe\n\n")]
#[case::without_format("#?RADIANCE\n\n")]
#[case::carriage_returns("#?RADIANCE\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n")]
fn headers_of_all_programs_are_read(#[case] header: &str) {
    assert_eq!(texel(&one(header).expect("read"), 0), [1.0, 0.5, 0.25]);
}

/// Variables of "The RADIANCE Image File Format" and those that other programs write.
#[rstest]
#[case::exposure("EXPOSURE=4.0", Ok([0.25, 0.125, 0.0625]))]
#[case::exposures("EXPOSURE=4\nEXPOSURE= 0.5", Ok([0.5, 0.25, 0.125]))]
#[case::exposure_of_an_input("\tEXPOSURE=4", Ok([1.0, 0.5, 0.25]))]
#[case::no_exposure("EXPOSURE=0", Err("EXPOSURE"))]
#[case::negative_exposure("EXPOSURE=-1", Err("EXPOSURE"))]
#[case::infinite_exposure("EXPOSURE=inf", Err("EXPOSURE"))]
#[case::exposure_in_words("EXPOSURE=bright", Err("EXPOSURE"))]
#[case::correction("COLORCORR=2 0.5 1", Ok([0.5, 1.0, 0.25]))]
#[case::corrections("COLORCORR=2 0.5 1\nCOLORCORR=0.5 0.5 0.5\nEXPOSURE=2", Ok([0.5, 1.0, 0.25]))]
#[case::half_a_correction("COLORCORR=2 0.5", Err("COLORCORR"))]
#[case::primaries("PRIMARIES=0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329", Ok([1.0, 0.5, 0.25]))]
// ITU-R BT.2087, annex 1.
#[case::wide_primaries("PRIMARIES=0.708 0.292 0.17 0.797 0.131 0.046 0.3127 0.329", Ok([1.3485, 0.4398, 0.2112]))]
#[case::primaries_on_a_line("PRIMARIES=0.64 0.33 0.64 0.33 0.15 0.06 0.3127 0.329", Err("PRIMARIES"))]
#[case::few_primaries("PRIMARIES=0.64 0.33 0.3", Err("PRIMARIES"))]
#[case::spectra("FORMAT=Radiance_spectra", Err("FORMAT"))]
#[case::floats("FORMAT=float", Err("FORMAT"))]
#[case::codes("GAMMA=2.2", Err("GAMMA"))]
#[case::linear("GAMMA=1.0", Ok([1.0, 0.5, 0.25]))]
#[case::components("NCOMP=3", Ok([1.0, 0.5, 0.25]))]
#[case::many_components("NCOMP=20", Err("NCOMP"))]
#[case::words("SOFTWARE=any\nCAPDATE=2026:01:01 00:00:00\nrpict -vtv scene.oct\n# EXPOSURE=4\nOWNER=me", Ok([1.0, 0.5, 0.25]))]
fn variables_are_used_or_refused(#[case] lines: &str, #[case] expected: Result<[f32; 3], &str>) {
    let found = one(&format!("#?RADIANCE\n{RGBE}{lines}\n\n"));
    match expected {
        Ok(expected) => {
            let found = texel(&found.expect("read"), 0);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{found:?}");
        }
        Err(key) => assert_eq!(found.expect_err("refused").key, key),
    }
}

#[test]
fn shapes_and_views_are_told() {
    let found = one("#?RADIANCE\nPIXASPECT=2\nPIXASPECT=2\nVIEW= -vtv -vh 40\n\n").expect("read");
    // A pixel four times as high as wide.
    assert_eq!((found.pixel_aspect, found.mapping), (0.25, Mapping::View("-vtv -vh 40".to_owned())));
}

/// Tristimulus values of D65 become white, as near as eight bits allow.
#[test]
fn xyz_becomes_srgb() {
    let bytes = file("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n", "-Y 1 +X 1", &[[122, 128, 139, 129]]);
    let found = texel(&decode_radiance(&bytes).expect("read"), 0);
    // Half a code of 128 in each, times the sum of the largest row of the matrix, 3.2 + 1.5 + 0.5.
    assert!(found.iter().all(|value| (value - 1.0).abs() < 0.5 / 128.0 * 5.3), "{found:?}");
}

/// An image of 3 × 2 texels in the eight orders: each scanline runs in the direction of the second axis.
#[rstest]
#[case("-Y 2 +X 3", [0, 1, 2, 3, 4, 5])]
#[case("-Y 2 -X 3", [2, 1, 0, 5, 4, 3])]
#[case("+Y 2 +X 3", [3, 4, 5, 0, 1, 2])]
#[case("+Y 2 -X 3", [5, 4, 3, 2, 1, 0])]
#[case("+X 3 -Y 2", [0, 3, 1, 4, 2, 5])]
#[case("+X 3 +Y 2", [3, 0, 4, 1, 5, 2])]
#[case("-X 3 -Y 2", [2, 5, 1, 4, 0, 3])]
#[case("-X 3 +Y 2", [5, 2, 4, 1, 3, 0])]
fn images_are_turned_upright(#[case] size: &str, #[case] stored: [u8; 6]) {
    // Mantissas from 128 on are those of normal numbers; an exponent of 136 makes them whole.
    let texels = stored.map(|number| [128 + number, 0, 0, 136]);
    let found = decode_radiance(&file("#?RADIANCE\n\n", size, &texels)).expect("read");
    assert_eq!([found.planes.width(), found.planes.height()], [3, 2]);
    assert_eq!(found.planes.plane("R").expect("red"), [128.0, 129.0, 130.0, 131.0, 132.0, 133.0]);
}

#[rstest]
#[case::no_size("1 1")]
#[case::the_same_axis_twice("-Y 1 +Y 1")]
#[case::nothing("-Y 0 +X 1")]
#[case::not_a_number("-Y one +X 1")]
fn sizes_that_are_none_are_refused(#[case] size: &str) {
    let error = decode_radiance(&file("#?RADIANCE\n\n", size, &[[128; 4]])).expect_err("refused");
    assert!(error.message.contains("is not the size of an image"), "{error:?}");
}

#[test]
fn scanlines_of_both_kinds_of_runs_are_read() {
    // Eight texels of one value. New: 2, 2, the length, and a run of each component; old: a texel and its repetitions.
    let new: Vec<u8> = [&[2, 2, 0, 8][..], &[128 + 8, 128, 128 + 8, 64, 128 + 8, 32, 128 + 8, 129]].concat();
    let old = [[128, 64, 32, 129], [1, 1, 1, 7]].concat();
    for scanline in [new, old] {
        let bytes = [b"#?RADIANCE\n\n-Y 1 +X 8\n".to_vec(), scanline].concat();
        let found = decode_radiance(&bytes).expect("read");
        assert!((0..8).all(|i| texel(&found, i) == [1.0, 0.5, 0.25]), "{found:?}");
    }
}

proptest! {
    /// Pixel values of a file are those before its exposures, whatever these are.
    #[test]
    fn exposures_of_all_lines_are_taken_back(factors in prop::collection::vec(-8i32..8, 0..5)) {
        let lines: String = factors.iter().map(|power| format!("EXPOSURE={}\n", 2f64.powi(*power))).collect();
        let found = texel(&one(&format!("#?RADIANCE\n{lines}\n")).expect("read"), 0);
        let factor = 2f32.powi(-factors.iter().sum::<i32>());
        prop_assert_eq!(found, [factor, 0.5 * factor, 0.25 * factor]);
    }

    #[test]
    fn whatever_the_bytes_nothing_panics(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
        let _ = decode_radiance(&[b"#?RADIANCE\n", &bytes[..]].concat());
        let _ = decode_radiance(&[b"#?RADIANCE\n\n-Y 2 +X 9\n", &bytes[..]].concat());
    }
}
