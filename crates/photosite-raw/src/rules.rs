//! Treatment of every tag of DNG and TIFF files that changes pixels or figures.
//!
//! A tag is followed, or says what nobody depends on, or is left out with a warning where it says anything but what is
//! done anyway, or the file is refused by its name. Numbers of DNG's own that the table does not know are named in a
//! warning, too, since they may be any of these. Texts, dates, makers' notes and the like are not listed.

use tiff::Directory;
use tiff::tags::Tag;

use super::tags::Tags;
use photosite_core::Invalid;

/// Treatment of a tag.
#[derive(Clone, Copy, Debug)]
pub enum Treatment {
    /// The reader follows it, or refuses the file where it cannot.
    Followed,
    /// Nothing that is developed or measured depends on the tag.
    Neutral,
    /// The tag is left out with a warning unless its value is one of these; where there are none, always. The text
    /// names what stays as it is.
    LeftOut(&'static [&'static [f64]], &'static str),
    /// The file is refused where it does not say this.
    Refused(&'static [f64]),
}

use Treatment::{Followed, LeftOut, Neutral, Refused};

/// Rule: a tag's number, its name and its treatment.
pub type Rule = (u16, &'static str, Treatment);

const NO_LOOK: &str = "the look of its colour profile is not applied";
const NOT_SRGB: &str = "its pixel values are taken to be in proportion to light";

/// Tags of TIFF files, in every directory of an image, which are those of DNG files, too.
const COMMON: [Rule; 25] = [
    (254, "NewSubfileType", Followed),
    (255, "SubfileType", Followed),
    (256, "ImageWidth", Followed),
    (257, "ImageLength", Followed),
    (258, "BitsPerSample", Followed),
    (259, "Compression", Followed),
    (262, "PhotometricInterpretation", Followed),
    (266, "FillOrder", Refused(&[1.0])),
    (273, "StripOffsets", Followed),
    (274, "Orientation", Followed),
    (277, "SamplesPerPixel", Followed),
    (278, "RowsPerStrip", Followed),
    (279, "StripByteCounts", Followed),
    (284, "PlanarConfiguration", Followed),
    (290, "GrayResponseUnit", Neutral),
    (291, "GrayResponseCurve", LeftOut(&[], NOT_SRGB)),
    (301, "TransferFunction", LeftOut(&[], NOT_SRGB)),
    (317, "Predictor", Followed),
    (322, "TileWidth", Followed),
    (323, "TileLength", Followed),
    (324, "TileOffsets", Followed),
    (325, "TileByteCounts", Followed),
    (330, "SubIFDs", Followed),
    (339, "SampleFormat", Followed),
    (32997, "ImageDepth", Refused(&[1.0])),
];

/// Tags of TIFF files alone.
const OF_TIFF: [Rule; 18] = [
    (280, "MinSampleValue", LeftOut(&[&[0.0]], "0 is taken for black; develop.raw.black_level_dn says otherwise")),
    (
        281,
        "MaxSampleValue",
        LeftOut(
            &[&[255.0], &[65_535.0]],
            "white is taken for the largest number of all bits; develop.raw.white_level_dn says otherwise",
        ),
    ),
    (318, "WhitePoint", LeftOut(&[], "its colours are taken for those of sRGB or of no meaning")),
    (319, "PrimaryChromaticities", LeftOut(&[], "its colours are taken for those of sRGB or of no meaning")),
    (320, "ColorMap", Followed),
    (338, "ExtraSamples", LeftOut(&[&[0.0], &[2.0]], "its colours stay multiplied by their transparency")),
    (340, "SMinSampleValue", LeftOut(&[&[0.0]], "0 is taken for black; develop.raw.black_level_dn says otherwise")),
    (
        341,
        "SMaxSampleValue",
        LeftOut(
            &[&[1.0], &[255.0], &[65_535.0]],
            "white is taken for the largest number of all bits; develop.raw.white_level_dn says otherwise",
        ),
    ),
    (342, "TransferRange", LeftOut(&[], NOT_SRGB)),
    (529, "YCbCrCoefficients", Followed),
    (530, "YCbCrSubSampling", Followed),
    (531, "YCbCrPositioning", Followed),
    (532, "ReferenceBlackWhite", LeftOut(&[], "black is taken for 0 and white for the largest number of all bits")),
    (33421, "CFARepeatPatternDim", LeftOut(&[], "its pixel values are taken for grey; develop.raw.cfa says otherwise")),
    (33422, "CFAPattern", LeftOut(&[], "its pixel values are taken for grey; develop.raw.cfa says otherwise")),
    (34675, "ICCProfile", Followed),
    (50838, "IJMetadataByteCounts", Neutral),
    (50839, "IJMetadata", Neutral),
];

/// Tags of DNG files alone, by their names in its specification.
const OF_DNG: [Rule; 152] = [
    (33421, "CFARepeatPatternDim", Followed),
    (33422, "CFAPattern", Followed),
    (33434, "ExposureTime", Followed),
    (33437, "FNumber", Followed),
    (34855, "ISOSpeedRatings", Followed),
    (34675, "ICCProfile", Neutral),
    (50706, "DNGVersion", Followed),
    (50707, "DNGBackwardVersion", Followed),
    (50708, "UniqueCameraModel", Neutral),
    (50709, "LocalizedCameraModel", Neutral),
    (50710, "CFAPlaneColor", Followed),
    (50711, "CFALayout", LeftOut(&[&[1.0], &[4.0]], "its staggered pixels are taken for straight rows and columns")),
    (50712, "LinearizationTable", Followed),
    (50713, "BlackLevelRepeatDim", Followed),
    (50714, "BlackLevel", Followed),
    (50715, "BlackLevelDeltaH", Followed),
    (50716, "BlackLevelDeltaV", Followed),
    (50717, "WhiteLevel", Followed),
    (50718, "DefaultScale", Followed),
    (50719, "DefaultCropOrigin", Followed),
    (50720, "DefaultCropSize", Followed),
    (50721, "ColorMatrix1", Followed),
    (50722, "ColorMatrix2", Followed),
    (50723, "CameraCalibration1", Followed),
    (50724, "CameraCalibration2", Followed),
    (50725, "ReductionMatrix1", LeftOut(&[], "its more than three colours become XYZ by least squares")),
    (50726, "ReductionMatrix2", LeftOut(&[], "its more than three colours become XYZ by least squares")),
    (50727, "AnalogBalance", Followed),
    (50728, "AsShotNeutral", Followed),
    (50729, "AsShotWhiteXY", Followed),
    (50730, "BaselineExposure", Followed),
    // Hints for filters of noise and for sharpening, of which there are others here.
    (50731, "BaselineNoise", Neutral),
    (50732, "BaselineSharpness", Neutral),
    (50733, "BayerGreenSplit", LeftOut(&[&[0.0]], "its two greens are taken for alike")),
    (50734, "LinearResponseLimit", LeftOut(&[&[1.0]], "its pixel values are taken for linear up to the white level")),
    (50735, "CameraSerialNumber", Followed),
    (50736, "LensInfo", Neutral),
    (50737, "ChromaBlurRadius", Neutral),
    (50738, "AntiAliasStrength", Neutral),
    (50739, "ShadowScale", Neutral),
    (50740, "DNGPrivateData", Neutral),
    (50741, "MakerNoteSafety", Neutral),
    (50778, "CalibrationIlluminant1", Followed),
    (50779, "CalibrationIlluminant2", Followed),
    (50780, "BestQualityScale", Neutral),
    (50781, "RawDataUniqueID", Neutral),
    (50827, "OriginalRawFileName", Neutral),
    (50828, "OriginalRawFileData", Neutral),
    (50829, "ActiveArea", Followed),
    (50830, "MaskedAreas", Followed),
    (50831, "AsShotICCProfile", LeftOut(&[], NO_LOOK)),
    (50832, "AsShotPreProfileMatrix", LeftOut(&[], NO_LOOK)),
    (50833, "CurrentICCProfile", LeftOut(&[], NO_LOOK)),
    (50834, "CurrentPreProfileMatrix", LeftOut(&[], NO_LOOK)),
    (
        50879,
        "ColorimetricReference",
        LeftOut(&[&[0.0]], "its pixel values, which are made for display, are taken for light"),
    ),
    (50931, "CameraCalibrationSignature", Followed),
    (50932, "ProfileCalibrationSignature", Followed),
    (50933, "ExtraCameraProfiles", Neutral),
    (50934, "AsShotProfileName", Neutral),
    (50935, "NoiseReductionApplied", LeftOut(&[&[0.0]], "the noise that is measured is what its filter left")),
    (50936, "ProfileName", Neutral),
    (50937, "ProfileHueSatMapDims", Neutral),
    (50938, "ProfileHueSatMapData1", LeftOut(&[], NO_LOOK)),
    (50939, "ProfileHueSatMapData2", LeftOut(&[], NO_LOOK)),
    (50940, "ProfileToneCurve", LeftOut(&[&[0.0, 0.0, 1.0, 1.0]], NO_LOOK)),
    (50941, "ProfileEmbedPolicy", Neutral),
    (50942, "ProfileCopyright", Neutral),
    (50964, "ForwardMatrix1", Followed),
    (50965, "ForwardMatrix2", Followed),
    (50966, "PreviewApplicationName", Neutral),
    (50967, "PreviewApplicationVersion", Neutral),
    (50968, "PreviewSettingsName", Neutral),
    (50969, "PreviewSettingsDigest", Neutral),
    (50970, "PreviewColorSpace", Neutral),
    (50971, "PreviewDateTime", Neutral),
    (50972, "RawImageDigest", Neutral),
    (50973, "OriginalRawFileDigest", Neutral),
    (50974, "SubTileBlockSize", Refused(&[1.0, 1.0])),
    (50975, "RowInterleaveFactor", Refused(&[1.0])),
    (50981, "ProfileLookTableDims", Neutral),
    (50982, "ProfileLookTableData", LeftOut(&[], NO_LOOK)),
    (51008, "OpcodeList1", Followed),
    (51009, "OpcodeList2", Followed),
    (51022, "OpcodeList3", Followed),
    (51041, "NoiseProfile", Followed),
    (51043, "TimeCodes", Neutral),
    (51044, "FrameRate", Neutral),
    (51058, "TStop", Neutral),
    (51081, "ReelName", Neutral),
    (51089, "OriginalDefaultFinalSize", Neutral),
    (51090, "OriginalBestQualityFinalSize", Neutral),
    (51091, "OriginalDefaultCropSize", Neutral),
    (51105, "CameraLabel", Neutral),
    (51107, "ProfileHueSatMapEncoding", Neutral),
    (51108, "ProfileLookTableEncoding", Neutral),
    (51109, "BaselineExposureOffset", LeftOut(&[&[0.0]], NO_LOOK)),
    (51110, "DefaultBlackRender", Neutral),
    (51111, "NewRawImageDigest", Neutral),
    (51112, "RawToPreviewGain", Neutral),
    (51113, "CacheBlob", Neutral),
    (51114, "CacheVersion", Neutral),
    (51125, "DefaultUserCrop", LeftOut(&[&[0.0, 0.0, 1.0, 1.0]], "the image stays whole")),
    (51177, "DepthFormat", Neutral),
    (51178, "DepthNear", Neutral),
    (51179, "DepthFar", Neutral),
    (51180, "DepthUnits", Neutral),
    (51181, "DepthMeasureType", Neutral),
    (51182, "EnhanceParams", Neutral),
    (52525, "ProfileGainTableMap", LeftOut(&[], "the parts that it brightens or darkens stay as they are")),
    (52526, "SemanticName", Neutral),
    (52528, "SemanticInstanceID", Neutral),
    (52529, "CalibrationIlluminant3", Followed),
    (52530, "CameraCalibration3", Followed),
    (52531, "ColorMatrix3", Followed),
    (52532, "ForwardMatrix3", Followed),
    (52533, "IlluminantData1", LeftOut(&[], "its light is taken for that of CalibrationIlluminant1, or D65")),
    (52534, "IlluminantData2", LeftOut(&[], "its light is taken for that of CalibrationIlluminant2, or D65")),
    (52535, "IlluminantData3", LeftOut(&[], "its light is taken for that of CalibrationIlluminant3, or D65")),
    (52536, "MaskSubArea", Neutral),
    (52537, "ProfileHueSatMapData3", LeftOut(&[], NO_LOOK)),
    (52538, "ReductionMatrix3", LeftOut(&[], "its more than three colours become XYZ by least squares")),
    (52539, "RGBTables", LeftOut(&[], NO_LOOK)),
    (52543, "RGBTables", LeftOut(&[], NO_LOOK)),
    (52544, "ProfileGainTableMap2", LeftOut(&[], "the parts that it brightens or darkens stay as they are")),
    (52547, "ColumnInterleaveFactor", Refused(&[1.0])),
    (52548, "ImageSequenceInfo", Neutral),
    (52549, "ProfileToneMethod", LeftOut(&[], NO_LOOK)),
    (52550, "ImageStats", Neutral),
    (52551, "ProfileDynamicRange", Neutral),
    (52552, "ProfileGroupName", Neutral),
    (52553, "JXLDistance", Neutral),
    (52554, "JXLEffort", Neutral),
    (52555, "JXLDecodeSpeed", Neutral),
    // Of the EXIF directory, or of the first one in its place.
    (34864, "SensitivityType", Neutral),
    (34865, "StandardOutputSensitivity", Followed),
    (34866, "RecommendedExposureIndex", Followed),
    (34867, "ISOSpeed", Followed),
    (37377, "ShutterSpeedValue", Neutral),
    (37378, "ApertureValue", Neutral),
    (37386, "FocalLength", Followed),
    (41486, "FocalPlaneXResolution", Followed),
    (41487, "FocalPlaneYResolution", Followed),
    (41488, "FocalPlaneResolutionUnit", Followed),
    (42033, "BodySerialNumber", Followed),
    // Of TIFF, where a raw image has no use for them.
    (280, "MinSampleValue", Neutral),
    (281, "MaxSampleValue", Neutral),
    (338, "ExtraSamples", Neutral),
    (532, "ReferenceBlackWhite", Neutral),
    (529, "YCbCrCoefficients", Neutral),
    (530, "YCbCrSubSampling", Neutral),
    (531, "YCbCrPositioning", Neutral),
    (700, "XMP", Followed),
];

/// Tag numbers that Adobe has for DNG.
const OF_ADOBE: [std::ops::RangeInclusive<u16>; 2] = [50706..=51182, 52525..=52600];

/// A kind of file that says something by tags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The directory of the raw image in a DNG file.
    Dng,
    /// The first directory of a DNG file whose raw image is in another one.
    DngMain,
    /// TIFF.
    Tiff,
}

impl Kind {
    /// Rules of all tags that change pixels or figures.
    pub fn rules(self) -> impl Iterator<Item = &'static Rule> {
        let (common, own): (&[Rule], &[Rule]) = match self {
            Self::Dng => (&COMMON, &OF_DNG),
            // What is common is of the small image that it shows.
            Self::DngMain => (&[], &OF_DNG),
            Self::Tiff => (&COMMON, &OF_TIFF),
        };
        common.iter().chain(own)
    }
}

/// Warnings about what a directory says that is left out; an error where a file of the kind is not to be read because
/// of it.
pub(crate) fn left_out(file: &mut Tags<'_>, directory: &Directory, kind: Kind) -> Result<Vec<String>, Invalid> {
    let mut warnings = Vec::new();
    let mut looks = Vec::new();
    let there: Vec<u16> = directory.iter().map(|(tag, _)| tag.to_u16()).collect();
    for &(number, name, treatment) in kind.rules().filter(|(number, ..)| there.contains(number)) {
        let says = |file: &mut Tags<'_>, allowed: &[f64]| {
            file.numbers(directory, Tag::from_u16_exhaustive(number)).is_ok_and(|numbers| numbers == allowed)
        };
        match treatment {
            Followed | Neutral => {}
            LeftOut(harmless, so) => {
                if !harmless.iter().any(|allowed| says(file, allowed)) {
                    if so == NO_LOOK {
                        looks.push(name);
                    } else {
                        warnings.push(format!("{name} is left out: {so}"));
                    }
                }
            }
            Refused(allowed) => {
                if !says(file, allowed) {
                    let numbers = file.numbers(directory, Tag::from_u16_exhaustive(number)).unwrap_or_default();
                    let message = format!("{numbers:?} is a way of storing pixels that photosite does not read");
                    return Err(
                        Invalid::new(name, message).help("write it without, for example with Adobe's DNG Converter")
                    );
                }
            }
        }
    }
    if !looks.is_empty() {
        warnings.push(format!("{} are left out: {NO_LOOK}", looks.join(", ")));
    }
    let is_known = |number: u16| kind.rules().any(|(known, ..)| *known == number);
    let is_adobes = |number: u16| OF_ADOBE.iter().any(|range| range.contains(&number));
    let unknown: Vec<String> = there
        .into_iter()
        .filter(|number| kind != Kind::Tiff && is_adobes(*number) && !is_known(*number))
        .map(|number| number.to_string())
        .collect();
    if !unknown.is_empty() {
        warnings.push(format!("tags that photosite does not know are left out: {}", unknown.join(", ")));
    }
    Ok(warnings)
}
