//! Features that few sensors have: what each stands in the way of, and what is told of it. Others ask for the obstacles
//! to their use of a sensor, and need not know the features.

use photosite_core::Invalid;
use photosite_core::math::float::rounded;
use serde::Serialize;

use super::sensor_model::SensorModel;

/// Use of a sensor that some features stand in the way of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Binning of any kind.
    Binning,
    /// Binning after the converter.
    BinningOfNumbers,
    /// A region of interest.
    Region,
    /// A region of interest that begins in the second row, or any other second one.
    RegionFromOddRow,
    /// Images of a data set, which are on the pixels of the sensor.
    DataSet,
    /// Camera files of other programs.
    CameraFile,
    /// Export to Mitsuba.
    Mitsuba,
    /// Characterisation by [Emva1288](photosite_core::references#emva1288).
    Emva1288,
}

/// Uncommon feature.
#[derive(Clone, Copy)]
enum Feature {
    HexagonalCells,
    ImageCircle,
    VideoCurve,
    VideoBandwidth,
    FrameGrabber,
}

/// Obstacle to a use: the key that is refused (none of an export, which leaves the feature out), the reason, and what to
/// do instead.
pub type Obstacle = [&'static str; 3];

const LINEAR: &str = "EMVA 1288 measures linear sensors whose pixels are alike and independent; leave it out";

/// Obstacles of all features; of several to one use the first is told.
#[rustfmt::skip]
const OBSTACLES: [(Use, Feature, Obstacle); 13] = [
    (Use::Binning, Feature::HexagonalCells, ["binning",
        "cannot be combined with sensor.cells = \"hexagonal\", whose rows do not form columns", "remove it"]),
    (Use::Binning, Feature::FrameGrabber, ["binning",
        "cannot be combined with sensor.frame_grabber, which samples the pixels as it will", "remove it"]),
    (Use::BinningOfNumbers, Feature::VideoCurve, ["binning",
        "cannot be combined with sensor.video.gamma, as numbers that are bent do not add up: write \
         binning_method = \"charge\"", "remove it"]),
    (Use::Region, Feature::FrameGrabber, ["region_px",
        "cannot be combined with sensor.frame_grabber, which samples the whole image", "keep one of them"]),
    (Use::RegionFromOddRow, Feature::HexagonalCells, ["region_px",
        "is one of those that lie half a pitch farther to the right",
        "begin with an even row, as the image of hexagonal cells does"]),
    (Use::DataSet, Feature::HexagonalCells, ["sensor.cells",
        "the images of a data set have the pixels of the sensor, and its tools want them in columns",
        "render captures of hexagonal cells one by one"]),
    (Use::CameraFile, Feature::HexagonalCells, ["sensor.cells",
        "camera formats only describe pixels in rows and columns",
        "take the camera of image.png, whose pixels are square, from capture.json"]),
    (Use::Mitsuba, Feature::HexagonalCells, ["", "hexagonal cells of [sensor]: those of Mitsuba are square", ""]),
    (Use::Mitsuba, Feature::ImageCircle, ["", "image_circle_mm of [sensor]: all pixels see light", ""]),
    (Use::Emva1288, Feature::VideoCurve, ["video.gamma",
        "produces pixel values that are not proportional to light", LINEAR]),
    (Use::Emva1288, Feature::VideoBandwidth, ["video.bandwidth_mhz",
        "correlates the noise of neighbouring pixels", LINEAR]),
    (Use::Emva1288, Feature::FrameGrabber, ["frame_grabber",
        "makes samples that share the noise of pixels", LINEAR]),
    (Use::Emva1288, Feature::ImageCircle, ["image_circle_mm", "leaves pixels without light", LINEAR]),
];

/// Facts about uncommon features; `None` of those that the sensor lacks.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs, reason = "the facts of `photosite info`, which have the names of keys")]
pub struct UncommonFacts {
    pub cells: Option<&'static str>,
    pub image_circle_mm: Option<f64>,
    pub video_gamma: Option<f64>,
    pub video_correlation_of_neighbours: Option<f64>,
    pub video_delay_px: Option<f64>,
    pub frame_grabber_px: Option<[usize; 2]>,
}

impl SensorModel {
    /// Obstacles to a use of this sensor.
    pub fn obstacles(&self, wanted: Use) -> impl Iterator<Item = Obstacle> {
        let of_use = OBSTACLES.iter().filter(move |(barred, feature, _)| *barred == wanted && self.has(*feature));
        of_use.map(|(_, _, obstacle)| *obstacle)
    }

    /// Refuses a use for the first of its [`obstacles`](Self::obstacles).
    pub fn allows(&self, wanted: Use) -> Result<(), Invalid> {
        match self.obstacles(wanted).next() {
            Some([key, why, help]) => Err(Invalid::new(key, why).help(help)),
            None => Ok(()),
        }
    }

    /// Facts about the features of this sensor that few have.
    pub fn uncommon_facts(&self) -> UncommonFacts {
        let round = |x| rounded(x, 6);
        let low_pass = self.video.low_pass;
        UncommonFacts {
            cells: self.has(Feature::HexagonalCells).then_some("hexagonal"),
            image_circle_mm: self.cells.image_circle.map(|c| round(2e3 * c.radii_px.x * self.pixel_pitch_m[0])),
            video_gamma: self.video.curve.map(|curve| curve.gamma),
            video_correlation_of_neighbours: low_pass.map(|low_pass| round(low_pass.missing)),
            video_delay_px: low_pass.map(|low_pass| round(low_pass.delay_px())),
            frame_grabber_px: self.frame_grabber.map(|grabber| grabber.size),
        }
    }

    fn has(&self, feature: Feature) -> bool {
        match feature {
            Feature::HexagonalCells => self.cells.is_staggered(),
            Feature::ImageCircle => self.cells.image_circle.is_some(),
            Feature::VideoCurve => self.video.curve.is_some(),
            Feature::VideoBandwidth => self.video.low_pass.is_some(),
            Feature::FrameGrabber => self.frame_grabber.is_some(),
        }
    }
}
