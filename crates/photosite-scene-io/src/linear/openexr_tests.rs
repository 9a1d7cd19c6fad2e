use std::io::Cursor;

use rstest::rstest;

use super::openexr::of_exr;
use super::{LinearImage, Mapping};
use crate::exr::made_for_tests::{Part, file, floats};
use crate::exr::read_exr;
use photosite_core::Invalid;
use photosite_core::image::NotFinite;

const ORANGE: [f32; 3] = [1.0, 0.5, 0.25];

fn rgb() -> Part {
    let [r, g, b] = ORANGE;
    Part::row(&[("B", &[b, 0.2]), ("G", &[g, 0.2]), ("R", &[r, 0.2])])
}

fn light(part: Part) -> Result<LinearImage, Invalid> {
    read_exr(Cursor::new(file(&[part]))).and_then(of_exr)
}

fn texel(light: &LinearImage, i: usize) -> [f32; 3] {
    ["R", "G", "B"].map(|name| light.planes.plane(name).expect("a colour")[i])
}

/// Treatment of an attribute.
enum Outcome {
    /// Colour of the first pixel, to three decimals; grey stays grey.
    Colour([f32; 3]),
    /// Statement of the image.
    Says(fn(&LinearImage) -> bool),
    /// Refusal of the file, with this in the message or its key.
    Refused(&'static str),
    /// Unchanged image, with this in a warning.
    Warned(&'static str),
    /// Unchanged image without a warning, as the attribute does not concern pixel values.
    Beside,
}
use Outcome::{Beside, Colour, Refused, Says, Warned};

/// Matrix row of ITU-R BT.2087, annex 1: BT.2020 to BT.709.
const OF_REC2020: [f32; 3] = [1.6605 - 0.2938 - 0.0182, -0.1246 + 0.566_45 - 0.0021, -0.0182 - 0.0503 + 0.2797];
/// Conversion of ACES2065-1 to linear BT.709 with white adapted by Bradford, as in OpenColorIO's ACES configuration.
const OF_ACES: [f32; 3] =
    [2.521_69 - 0.567_07 - 0.096_89, -0.276_48 + 0.686_36 - 0.024_06, -0.015_38 - 0.076_49 + 0.292_13];

fn ints(values: &[i32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// Standard attributes of OpenEXR 3.5 (ImfStandardAttributes.h and the header's own), except those that every file has:
/// windows, order of lines and shape of pixels have tests of their own.
#[test]
fn every_standard_attribute_is_used_refused_or_warned_of_unless_it_says_nothing_of_the_numbers() {
    let text = |text: &str| text.as_bytes().to_vec();
    let rec2020 = floats(&[0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329]);
    let on_a_line = floats(&[0.64, 0.33, 0.64, 0.33, 0.15, 0.06, 0.3127, 0.329]);
    let srgb = floats(&[0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329]);
    let views = [ints(&[4]), text("left"), ints(&[5]), text("right")].concat();
    let table: Vec<(&str, &str, Vec<u8>, Outcome)> = vec![
        ("chromaticities", "chromaticities", rec2020, Colour(OF_REC2020)),
        ("chromaticities", "chromaticities", srgb, Beside),
        ("chromaticities", "chromaticities", on_a_line, Refused("chromaticities")),
        ("colorInteropID", "string", text("lin_rec2020_scene"), Colour(OF_REC2020)),
        ("colorInteropID", "string", text("lin_ap0_scene"), Colour(OF_ACES)),
        ("colorInteropID", "string", text("lin_rec709_scene"), Beside),
        ("colorInteropID", "string", text("unknown"), Beside),
        ("colorInteropID", "string", text("srgb_rec709_scene"), Refused("colorInteropID")),
        ("colorInteropID", "string", text("pq_rec2020_display"), Refused("colorInteropID")),
        ("colorInteropID", "string", text("data"), Refused("colorInteropID")),
        ("acesImageContainerFlag", "int", ints(&[1]), Colour(OF_ACES)),
        ("acesImageContainerFlag", "int", ints(&[0]), Beside),
        ("whiteLuminance", "float", floats(&[120.0]), Says(|light| light.white_luminance_nit == Some(120.0))),
        ("pixelAspectRatio", "float", floats(&[2.0]), Says(|light| light.pixel_aspect == 2.0)),
        ("envmap", "envmap", vec![0], Says(|light| light.mapping == Mapping::LatitudeLongitude)),
        ("envmap", "envmap", vec![1], Says(|light| light.mapping == Mapping::Cube)),
        (
            "adoptedNeutral",
            "v2f",
            floats(&[0.345_67, 0.3585]),
            Warned("its adoptedNeutral (0.34567, 0.3585) is left out"),
        ),
        ("adoptedNeutral", "v2f", floats(&[0.3127, 0.329]), Beside),
        ("renderingTransform", "string", text("ODT"), Warned("its renderingTransform is left out")),
        ("lookModTransform", "string", text("LMT"), Warned("its lookModTransform is left out")),
        ("originalDataWindow", "box2i", ints(&[0, 0, 9, 9]), Warned("its originalDataWindow is left out")),
        ("oiio:ColorSpace", "string", text("ARRI LogC"), Warned("its oiio:ColorSpace \"ARRI LogC\" is not known")),
        ("oiio:ColorSpace", "string", text("lin_rec709"), Beside),
        ("multiView", "stringvector", views, Beside),
        ("view", "string", text("left"), Beside),
        ("name", "string", text("beauty"), Beside),
        ("wrapmodes", "string", text("black"), Beside),
        ("deepImageState", "deepImageState", vec![1], Beside),
        ("dwaCompressionLevel", "float", floats(&[45.0]), Beside),
        ("idManifest", "idmanifest", ints(&[0, 0]), Beside),
        ("preview", "preview", [ints(&[1, 1]), vec![9; 4]].concat(), Beside),
        ("keyCode", "keycode", ints(&[1, 2, 3, 4, 5, 4, 64]), Beside),
        ("timeCode", "timecode", ints(&[0, 0]), Beside),
        ("framesPerSecond", "rational", ints(&[24, 1]), Beside),
        ("captureRate", "rational", ints(&[24, 1]), Beside),
        ("worldToCamera", "m44f", floats(&[0.5; 16]), Beside),
        ("worldToNDC", "m44f", floats(&[0.5; 16]), Beside),
        ("sensorAcquisitionRectangle", "box2i", ints(&[0, 0, 9, 9]), Beside),
        ("imageCounter", "int", ints(&[7]), Beside),
    ];
    let floating = [
        "altitude",
        "aperture",
        "cameraCCTSetting",
        "cameraTintSetting",
        "effectiveFocalLength",
        "entrancePupilOffset",
        "expTime",
        "focus",
        "isoSpeed",
        "latitude",
        "longitude",
        "nominalFocalLength",
        "pinholeFocalLength",
        "sensorPhotositePitch",
        "shutterAngle",
        "tStop",
        "utcOffset",
        "xDensity",
    ];
    let pairs = ["cameraColorBalance", "sensorCenterOffset", "sensorOverallDimensions"];
    let texts = [
        "ascFramingDecisionList",
        "cameraFirmwareVersion",
        "cameraLabel",
        "cameraMake",
        "cameraModel",
        "cameraSerialNumber",
        "cameraUuid",
        "capDate",
        "comments",
        "lensFirmwareVersion",
        "lensMake",
        "lensModel",
        "lensSerialNumber",
        "owner",
        "reelName",
    ];
    let numbers = floating.into_iter().map(|name| (name, "float", floats(&[2.0]), Beside));
    let pairs = pairs.into_iter().map(|name| (name, "v2f", floats(&[2.0; 2]), Beside));
    let texts = texts.into_iter().map(|name| (name, "string", text("a text"), Beside));
    let plain = light(rgb()).expect("an image");
    assert!(plain.warnings.is_empty());
    for (name, kind, value, outcome) in table.into_iter().chain(numbers).chain(pairs).chain(texts) {
        let found = light(rgb().with(name, kind, value.clone()));
        let case = format!("{name} {value:?}: {found:?}");
        match outcome {
            Refused(words) => {
                let error = found.expect_err(&case);
                assert!(error.key.contains(words) || error.message.contains(words), "{case}");
            }
            Colour(expected) => {
                let found = found.expect(&case);
                let is_near = |a: f32, b: f32| (a - b).abs() < 1e-3;
                assert!(texel(&found, 0).into_iter().zip(expected).all(|(a, b)| is_near(a, b)), "{case}");
                assert!(texel(&found, 1).into_iter().all(|value| (value - 0.2).abs() < 1e-6), "{case}");
            }
            Says(check) => {
                let found = found.expect(&case);
                assert!(check(&found) && found.planes == plain.planes && found.warnings.is_empty(), "{case}");
            }
            Warned(words) => {
                let found = found.expect(&case);
                assert!(found.warnings.len() == 1 && found.warnings[0].starts_with(words), "{case}");
                assert_eq!(found.planes, plain.planes, "{case}");
            }
            Beside => assert_eq!(found.expect(&case), plain, "{case}"),
        }
    }
}

#[test]
fn of_two_statements_of_colours_the_identifier_holds_and_is_said_to() {
    let srgb = floats(&[0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329]);
    let part = rgb().with("chromaticities", "chromaticities", srgb);
    let found = light(part.with("colorInteropID", "string", b"lin_rec2020_scene".to_vec())).expect("an image");
    assert!((texel(&found, 0)[0] - OF_REC2020[0]).abs() < 1e-3);
    assert!(found.warnings[0].contains("lin_rec2020_scene, which is used"), "{found:?}");
}

/// Primaries of XYZ as R, G and B, as in the sample images of OpenEXR: equal energy is white.
#[test]
fn red_green_and_blue_may_be_the_axes_of_xyz() {
    let axes = floats(&[1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0 / 3.0, 1.0 / 3.0]);
    let found = light(rgb().with("chromaticities", "chromaticities", axes)).expect("an image");
    assert!(texel(&found, 1).into_iter().all(|value| (value - 0.2).abs() < 1e-6), "{found:?}");
}

#[rstest]
#[case::colours(&[("B", 3.0), ("G", 2.0), ("R", 1.0)], &[1.0, 2.0, 3.0], &[], "")]
#[case::grey(&[("Y", 0.5)], &[0.5], &[], "")]
// (R − Y)/Y = 1, (B − Y)/Y = −0.5; G = (Y − 0.2126·R − 0.0722·B)/0.7152.
#[case::luminance_and_chroma(&[("BY", -0.5), ("RY", 1.0), ("Y", 0.5)], &[1.0, (0.5 - 0.212_64 - 0.018_05) / 0.715_17, 0.25], &[], "")]
// IEC 61966-2-1: D65 is white.
#[case::xyz(&[("X", 0.950_47), ("Y", 1.0), ("Z", 1.088_83)], &[1.0, 1.0, 1.0], &[], "X, Y and Z are taken to be relative to D65")]
#[case::opaque(&[("A", 1.0), ("B", 3.0), ("G", 2.0), ("R", 1.0)], &[1.0, 2.0, 3.0], &[], "")]
#[case::transparent(&[("A", 0.5), ("B", 3.0), ("G", 2.0), ("R", 1.0)], &[1.0, 2.0, 3.0], &["A"], "")]
#[case::beside_a_layer(&[("B", 3.0), ("G", 2.0), ("R", 1.0), ("right.B", 6.0), ("right.G", 5.0), ("right.R", 4.0)], &[1.0, 2.0, 3.0], &["right.B", "right.G", "right.R"], "")]
#[case::only_layer(&[("View.Combined.B", 3.0), ("View.Combined.G", 2.0), ("View.Combined.R", 1.0), ("View.Depth.Z", 9.0)], &[1.0, 2.0, 3.0], &["View.Depth.Z"], "the image is its layer View.Combined")]
#[case::beside_normals(&[("N.X", 0.1), ("N.Y", 0.2), ("N.Z", 0.3), ("a.B", 3.0), ("a.G", 2.0), ("a.R", 1.0)], &[1.0, 2.0, 3.0], &["N.X", "N.Y", "N.Z"], "the image is its layer a")]
#[case::of_two_layers_none(&[("a.B", 3.0), ("a.G", 2.0), ("a.R", 1.0), ("b.B", 3.0), ("b.G", 2.0), ("b.R", 1.0)], &[], &["a.B", "a.G", "a.R", "b.B", "b.G", "b.R"], "")]
#[case::depth(&[("Z", 9.0)], &[], &["Z"], "")]
#[case::two_colours(&[("G", 9.0), ("R", 9.0)], &[], &["G", "R"], "")]
#[case::lower_case(&[("b", 9.0), ("g", 9.0), ("r", 9.0)], &[], &["b", "g", "r"], "")]
fn channels_are_known_by_their_names(
    #[case] channels: &[(&'static str, f32)],
    #[case] expected: &[f32],
    #[case] others: &[&str],
    #[case] warning: &str,
) {
    let planes: Vec<(&str, [f32; 1])> = channels.iter().map(|&(name, value)| (name, [value])).collect();
    let planes: Vec<(&'static str, &[f32])> =
        channels.iter().zip(&planes).map(|((name, _), (_, value))| (*name, &value[..])).collect();
    let found = light(Part::row(&planes)).expect("read");
    let image: Vec<f32> = found.planes.channels()[..found.components].iter().map(|c| c.data[0]).collect();
    // The tabulated D65 differs from the rounded one in the fourth decimal.
    assert!(image.len() == expected.len() && image.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3));
    assert_eq!(found.others(), others);
    assert!(found.warnings.concat().contains(warning), "{found:?}");
    assert_eq!(found.warnings.is_empty(), warning.is_empty(), "{found:?}");
}

#[test]
fn numbers_that_are_not_finite_are_counted_and_the_first_is_named() {
    let rec2020 = floats(&[0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329]);
    let part = Part::row(&[("B", &[0.1, 0.2]), ("G", &[0.1, f32::NAN]), ("R", &[0.1, f32::NEG_INFINITY])]);
    let found = light(part.with("chromaticities", "chromaticities", rec2020)).expect("read");
    let not_finite = NotFinite::of(&found.planes).expect("two of them");
    assert_eq!(not_finite.to_string(), "2 numbers are not finite: the first is -inf, of R in column 1, row 0");
    assert_eq!(NotFinite::of(&light(rgb()).expect("read").planes), None);
}
