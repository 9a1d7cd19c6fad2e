//! Messages of ROS 2 ([RosMessages](photosite_core::references#rosmessages)): their definitions, and their values as
//! [CDR](super::cdr).

use glam::{DAffine3, DQuat};

use super::cdr::Cdr;
use crate::Invalid;
use crate::calibration::camera_files::{CalibratedCamera, ros_distortion};
use crate::raw::RawImage;

/// A type of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum MessageType {
    CameraInfo,
    CompressedImage,
    Image,
    TfMessage,
}

const TIME: &str = "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
const HEADER: &str = "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n";
/// Between definitions.
const LINE: &str = "================================================================================";

impl MessageType {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::CameraInfo => "sensor_msgs/msg/CameraInfo",
            Self::CompressedImage => "sensor_msgs/msg/CompressedImage",
            Self::Image => "sensor_msgs/msg/Image",
            Self::TfMessage => "tf2_msgs/msg/TFMessage",
        }
    }

    /// Its definition with all that it depends on.
    pub(super) fn definition(self) -> String {
        let parts: &[&str] = match self {
            Self::CameraInfo => &[
                "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\n\
                 float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi\n",
                "\nMSG: sensor_msgs/RegionOfInterest\nuint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\n\
                 bool do_rectify\n",
                HEADER,
                TIME,
            ],
            Self::CompressedImage => &["std_msgs/Header header\nstring format\nuint8[] data\n", HEADER, TIME],
            Self::Image => &[
                "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\n\
                 uint8[] data\n",
                HEADER,
                TIME,
            ],
            Self::TfMessage => &[
                "geometry_msgs/TransformStamped[] transforms\n",
                "\nMSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n\
                 geometry_msgs/Transform transform\n",
                "\nMSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
                "\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n",
                "\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
                HEADER,
                TIME,
            ],
        };
        parts.join(LINE)
    }
}

/// When and where a message is of.
pub(super) struct Stamp<'a> {
    pub(super) ns: u64,
    pub(super) frame_id: &'a str,
}

impl Stamp<'_> {
    fn header(&self, cdr: &mut Cdr) {
        const NS: u64 = 1_000_000_000;
        let second = u32::try_from(self.ns / NS).unwrap_or(u32::MAX);
        cdr.u32(second).u32((self.ns % NS) as u32).text(self.frame_id);
    }
}

/// The camera on its own: rectification is the identity, and the projection matrix that of the camera. A lens that ROS
/// has no model for is an error.
pub(super) fn camera_info(stamp: &Stamp<'_>, camera: &CalibratedCamera) -> Result<Vec<u8>, Invalid> {
    let (model, coefficients) = ros_distortion(camera)?;
    let [fx, fy, cx, cy] = camera.at_centres();
    let [width, height] = camera.resolution;
    let mut cdr = Cdr::new();
    stamp.header(&mut cdr);
    cdr.u32(height).u32(width).text(model);
    cdr.u32(coefficients.len() as u32).f64s(&coefficients);
    cdr.f64s(&camera.matrix());
    cdr.f64s(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    cdr.f64s(&[fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]);
    // No binning; the region of interest is all of the picture.
    cdr.u32(0).u32(0).u32(0).u32(0).u32(0).u32(0).u8(0);
    Ok(cdr.finish())
}

/// A picture of numbers, little endian, so many bytes a pixel.
pub(super) fn image(
    stamp: &Stamp<'_>,
    [width, height]: [usize; 2],
    encoding: &str,
    pixel_bytes: usize,
    data: &[u8],
) -> Vec<u8> {
    let mut cdr = Cdr::new();
    stamp.header(&mut cdr);
    cdr.u32(height as u32).u32(width as u32).text(encoding).u8(0).u32((width * pixel_bytes) as u32).bytes(data);
    cdr.finish()
}

/// What ROS calls the numbers of a raw image; `None` where it has no name for its filters.
pub(super) fn raw_encoding(raw: &RawImage) -> Option<&'static str> {
    match raw.cfa.to_string().as_str() {
        "mono" => Some("mono16"),
        "RGGB" => Some("bayer_rggb16"),
        "BGGR" => Some("bayer_bggr16"),
        "GBRG" => Some("bayer_gbrg16"),
        "GRBG" => Some("bayer_grbg16"),
        "full:RGB" => Some("rgb16"),
        _ => None,
    }
}

/// A PNG file.
pub(super) fn compressed_image(stamp: &Stamp<'_>, png: &[u8]) -> Vec<u8> {
    let mut cdr = Cdr::new();
    stamp.header(&mut cdr);
    cdr.text("png").bytes(png);
    cdr.finish()
}

/// Where a frame stands in another, that of the stamp.
pub(super) fn transform(stamp: &Stamp<'_>, child: &str, in_parent: &DAffine3) -> Vec<u8> {
    let DQuat { x, y, z, w } = DQuat::from_mat3(&in_parent.matrix3).normalize();
    let mut cdr = Cdr::new();
    cdr.u32(1);
    stamp.header(&mut cdr);
    cdr.text(child).f64s(&in_parent.translation.to_array()).f64s(&[x, y, z, w]);
    cdr.finish()
}
