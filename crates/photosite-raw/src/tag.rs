//! Tags and codes of DNG files that the TIFF library has no name for.

use tiff::tags::Tag;

pub(super) const YCBCR_SUBSAMPLING: Tag = Tag::Unknown(530);
pub(super) const YCBCR_POSITIONING: Tag = Tag::Unknown(531);
pub(super) const REFERENCE_BLACK_WHITE: Tag = Tag::Unknown(532);
pub(super) const XMP: Tag = Tag::Unknown(700);
pub(super) const CFA_REPEAT_PATTERN_DIM: Tag = Tag::Unknown(33421);
pub(super) const CFA_PATTERN: Tag = Tag::Unknown(33422);
pub(super) const EXPOSURE_TIME: Tag = Tag::Unknown(33434);
pub(super) const F_NUMBER: Tag = Tag::Unknown(33437);
pub(super) const PHOTOGRAPHIC_SENSITIVITY: Tag = Tag::Unknown(34855);
pub(super) const SENSITIVITY_TYPE: Tag = Tag::Unknown(34864);
pub(super) const STANDARD_OUTPUT_SENSITIVITY: Tag = Tag::Unknown(34865);
pub(super) const RECOMMENDED_EXPOSURE_INDEX: Tag = Tag::Unknown(34866);
pub(super) const ISO_SPEED: Tag = Tag::Unknown(34867);
pub(super) const EXIF_VERSION: Tag = Tag::ExifVersion;
pub(super) const FOCAL_LENGTH: Tag = Tag::Unknown(37386);
pub(super) const COLOR_SPACE: Tag = Tag::Unknown(40961);
pub(super) const FOCAL_PLANE_X_RESOLUTION: Tag = Tag::Unknown(41486);
pub(super) const FOCAL_PLANE_Y_RESOLUTION: Tag = Tag::Unknown(41487);
pub(super) const FOCAL_PLANE_RESOLUTION_UNIT: Tag = Tag::Unknown(41488);
pub(super) const BODY_SERIAL_NUMBER: Tag = Tag::Unknown(42033);
pub(super) const DNG_VERSION: Tag = Tag::Unknown(50706);
pub(super) const DNG_BACKWARD_VERSION: Tag = Tag::Unknown(50707);
pub(super) const UNIQUE_CAMERA_MODEL: Tag = Tag::Unknown(50708);
pub(super) const CFA_PLANE_COLOR: Tag = Tag::Unknown(50710);
pub(super) const CFA_LAYOUT: Tag = Tag::Unknown(50711);
pub(super) const RECTANGULAR: u16 = 1;
/// Staggered layout C: "even rows are offset right by 1/2 column", which DNG's SDK counts from 1.
pub(super) const EVEN_ROWS_TO_THE_RIGHT: u16 = 4;
pub(super) const LINEARIZATION_TABLE: Tag = Tag::Unknown(50712);
pub(super) const BLACK_LEVEL_REPEAT_DIM: Tag = Tag::Unknown(50713);
pub(super) const BLACK_LEVEL: Tag = Tag::Unknown(50714);
pub(super) const BLACK_LEVEL_DELTA_H: Tag = Tag::Unknown(50715);
pub(super) const BLACK_LEVEL_DELTA_V: Tag = Tag::Unknown(50716);
pub(super) const WHITE_LEVEL: Tag = Tag::Unknown(50717);
pub(super) const DEFAULT_SCALE: Tag = Tag::Unknown(50718);
pub(super) const DEFAULT_CROP_ORIGIN: Tag = Tag::Unknown(50719);
pub(super) const DEFAULT_CROP_SIZE: Tag = Tag::Unknown(50720);
pub(super) const COLOR_MATRIX_1: Tag = Tag::Unknown(50721);
pub(super) const COLOR_MATRIX_2: Tag = Tag::Unknown(50722);
pub(super) const CAMERA_CALIBRATION_1: Tag = Tag::Unknown(50723);
pub(super) const CAMERA_CALIBRATION_2: Tag = Tag::Unknown(50724);
pub(super) const ANALOG_BALANCE: Tag = Tag::Unknown(50727);
pub(super) const AS_SHOT_NEUTRAL: Tag = Tag::Unknown(50728);
pub(super) const AS_SHOT_WHITE_XY: Tag = Tag::Unknown(50729);
pub(super) const BASELINE_EXPOSURE: Tag = Tag::Unknown(50730);
pub(super) const CAMERA_SERIAL_NUMBER: Tag = Tag::Unknown(50735);
pub(super) const CALIBRATION_ILLUMINANT_1: Tag = Tag::Unknown(50778);
pub(super) const CALIBRATION_ILLUMINANT_2: Tag = Tag::Unknown(50779);
pub(super) const ACTIVE_AREA: Tag = Tag::Unknown(50829);
pub(super) const MASKED_AREAS: Tag = Tag::Unknown(50830);
pub(super) const CAMERA_CALIBRATION_SIGNATURE: Tag = Tag::Unknown(50931);
pub(super) const PROFILE_CALIBRATION_SIGNATURE: Tag = Tag::Unknown(50932);
pub(super) const FORWARD_MATRIX_1: Tag = Tag::Unknown(50964);
pub(super) const FORWARD_MATRIX_2: Tag = Tag::Unknown(50965);
pub(super) const PREVIEW_COLOR_SPACE: Tag = Tag::Unknown(50970);
pub(super) const OPCODE_LIST_1: Tag = Tag::Unknown(51008);
pub(super) const OPCODE_LIST_2: Tag = Tag::Unknown(51009);
pub(super) const OPCODE_LIST_3: Tag = Tag::Unknown(51022);
pub(super) const NOISE_PROFILE: Tag = Tag::Unknown(51041);
pub(super) const CALIBRATION_ILLUMINANT_3: Tag = Tag::Unknown(52529);
pub(super) const CAMERA_CALIBRATION_3: Tag = Tag::Unknown(52530);
pub(super) const COLOR_MATRIX_3: Tag = Tag::Unknown(52531);
pub(super) const FORWARD_MATRIX_3: Tag = Tag::Unknown(52532);

/// PhotometricInterpretation of a mosaic.
pub(super) const COLOR_FILTER_ARRAY: u16 = 32803;
/// PhotometricInterpretation of pixels that all see the same, or all colours.
pub(super) const LINEAR_RAW: u16 = 34892;

/// Compression: none.
pub(super) const UNCOMPRESSED: u16 = 1;
/// Compression: lossless JPEG in a DNG file.
pub(super) const JPEG: u16 = 7;
/// Compression: zlib.
pub(super) const DEFLATE: u16 = 8;

/// Predictor: differences to the pixel on the left.
pub(super) const HORIZONTAL: u16 = 2;
/// Predictor of floating-point numbers: differences between like bytes of neighbours.
pub(super) const FLOATING_POINT: u16 = 3;
/// Predictor of floating-point numbers: differences between like bytes of each number and the second or fourth of its
/// kind before it, as DNG adds them.
pub(super) const FLOATING_POINT_X2: u16 = 34894;
pub(super) const FLOATING_POINT_X4: u16 = 34895;
/// SampleFormat of floating-point numbers.
pub(super) const FLOAT: u16 = 3;

/// PreviewColorSpace of sRGB.
pub(super) const SRGB: u32 = 2;
/// NewSubfileType of an image of reduced resolution; 0 is the image itself.
pub(super) const REDUCED: u32 = 1;
/// SensitivityType of an ISO speed.
pub(super) const IS_ISO_SPEED: u16 = 3;
/// EXIF's number for resolutions per centimetre.
pub(super) const PER_CENTIMETRE: u16 = 3;
