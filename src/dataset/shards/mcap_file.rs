//! MCAP files of ROS 2 messages ([RosMessages](photosite_core::references#rosmessages)), as `ros2 bag` and Foxglove read
//! them.
//!
//! | topic | type | holds |
//! |---|---|---|
//! | `/CAMERA/camera_info` | `CameraInfo` | matrix and lens: `plumb_bob`, `rational_polynomial`, `equidistant` |
//! | `/CAMERA/image_raw` | `Image` | digital numbers: `bayer_rggb16` …, `mono16`, `rgb16` |
//! | `/CAMERA/image/compressed` | `CompressedImage` | the developed picture |
//! | `/CAMERA/truth/LAYER` | `Image` | `32SC1` of numbers of things, `32FC1` to `32FC3` of others; depth along the axis in m, ∞ where nothing is (REP 117) |
//! | `/tf` | `TFMessage` | `CAMERA_optical` in `world` |
//! | `/tf_static` | `TFMessage` | `world` in `map` |
//!
//! `CAMERA_optical` has x right, y down, z forward (REP 103). `world` is that of glTF, whose y points up, so that poses
//! are those of the reports; `map` is the same turned so that z does, as ROS has it. Stamps are the middle of the
//! exposure of the middle row, as in the other layouts.

use std::collections::BTreeMap;
use std::io;

use glam::DAffine3;
use mcap::records::MessageHeader;

use super::container::Container;
use super::ros_messages::{MessageType, Stamp, camera_info, compressed_image, image, raw_encoding, transform};
use super::sample::Sample;
use crate::calibration::camera_files::ros_name;
use crate::image::Planes;
use crate::io::output::Sink;
use crate::{Invalid, Result};

/// The world of glTF.
const WORLD: &str = "world";
/// The same with z up.
const MAP: &str = "map";
/// What a message takes besides its data.
const MESSAGE_BYTES: u64 = 64;
/// Those who join late get the last message of this topic.
const STATIC_QOS: &str = "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 9223372036\n    nsec: 854775807\n  \
    lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  liveliness_lease_duration:\n    sec: 9223372036\n    \
    nsec: 854775807\n  avoid_ros_namespace_conventions: false\n";

/// MCAP files.
pub(super) struct McapFile;

/// The messages of a picture.
pub(super) struct Messages {
    stamp_ns: u64,
    frame: u32,
    all: Vec<(String, MessageType, Vec<u8>)>,
}

impl Container for McapFile {
    type Item = Messages;

    fn item(sample: Sample, warn: &dyn Fn(&str)) -> Result<Messages> {
        let camera = &sample.shot.calibrated;
        let name = topic_name(&camera.name);
        let optical = format!("{name}_optical");
        let stamp = Stamp { ns: sample.shot.stamp_ns, frame_id: &optical };
        let mut all = Vec::new();
        let mut add = |topic: &str, kind, data| all.push((topic.to_owned(), kind, data));
        match camera_info(&stamp, camera) {
            Ok(info) => add(&format!("/{name}/camera_info"), MessageType::CameraInfo, info),
            Err(invalid) => warn(&format!("there is no /{name}/camera_info: {}", invalid.message)),
        }
        if let Some(raw) = &sample.raw {
            match raw_encoding(raw) {
                Some(encoding) => {
                    let data: Vec<u8> = raw.data.iter().flat_map(|value| value.to_le_bytes()).collect();
                    let pixel_bytes = 2 * raw.cfa.samples_per_pixel();
                    let message = image(&stamp, [raw.width, raw.height], encoding, pixel_bytes, &data);
                    add(&format!("/{name}/image_raw"), MessageType::Image, message);
                }
                None => warn(&format!("there is no /{name}/image_raw: ROS has no name for the filters {}", raw.cfa)),
            }
        }
        if let Some(png) = &sample.image {
            add(&format!("/{name}/image/compressed"), MessageType::CompressedImage, compressed_image(&stamp, png));
        }
        for (layer, planes) in &sample.truth {
            let topic = format!("/{name}/truth/{}", ros_name(layer));
            add(&topic, MessageType::Image, truth_image(&stamp, layer, planes));
        }
        // The camera's axes are OpenCV's.
        let in_world = camera.from_world().inverse();
        let stamp = Stamp { ns: stamp.ns, frame_id: WORLD };
        add("/tf", MessageType::TfMessage, transform(&stamp, &optical, &in_world));
        Ok(Messages { stamp_ns: stamp.ns, frame: sample.shot.frame, all })
    }

    fn bytes(messages: &Messages) -> u64 {
        messages.all.iter().map(|(_, _, data)| data.len() as u64 + MESSAGE_BYTES).sum()
    }

    fn write(items: &mut dyn Iterator<Item = io::Result<Messages>>, to: &mut dyn Sink) -> io::Result<()> {
        let options = mcap::WriteOptions::new().compression(None).profile("ros2");
        let mut writer =
            options.library(format!("photosite {}", env!("CARGO_PKG_VERSION"))).create(to).map_err(io::Error::other)?;
        let (mut schemas, mut channels) = (BTreeMap::new(), BTreeMap::new());
        let mut is_first = true;
        for messages in items {
            let Messages { stamp_ns, frame, mut all } = messages?;
            if std::mem::take(&mut is_first) {
                let stamp = Stamp { ns: stamp_ns, frame_id: MAP };
                let turned = DAffine3::from_rotation_x(std::f64::consts::FRAC_PI_2);
                all.insert(0, ("/tf_static".to_owned(), MessageType::TfMessage, transform(&stamp, WORLD, &turned)));
            }
            for (topic, kind, data) in all {
                let schema = match schemas.get(&kind) {
                    Some(&schema) => schema,
                    None => {
                        let definition = kind.definition();
                        let schema = writer.add_schema(kind.name(), "ros2msg", definition.as_bytes());
                        *schemas.entry(kind).or_insert(schema.map_err(io::Error::other)?)
                    }
                };
                let channel = match channels.get(&topic) {
                    Some(&channel) => channel,
                    None => {
                        let qos = ("offered_qos_profiles".to_owned(), STATIC_QOS.to_owned());
                        let about: BTreeMap<String, String> =
                            if topic == "/tf_static" { BTreeMap::from([qos]) } else { BTreeMap::new() };
                        let channel = writer.add_channel(schema, &topic, "cdr", &about).map_err(io::Error::other)?;
                        *channels.entry(topic).or_insert(channel)
                    }
                };
                let header =
                    MessageHeader { channel_id: channel, sequence: frame, log_time: stamp_ns, publish_time: stamp_ns };
                writer.write_to_known_channel(&header, &data).map_err(io::Error::other)?;
            }
        }
        writer.finish().map(drop).map_err(io::Error::other)
    }
}

/// A camera's name as topics have it, which begin with a letter.
fn topic_name(camera: &str) -> String {
    let name = ros_name(camera);
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) { name } else { format!("camera_{name}") }
}

/// Refuses cameras whose topics would be the same.
pub(super) fn check_cameras(cameras: &[String]) -> Result<(), Invalid> {
    for (i, camera) in cameras.iter().enumerate() {
        if let Some(other) = cameras[..i].iter().find(|other| topic_name(other) == topic_name(camera)) {
            let message = format!("the cameras {other} and {camera} would both be /{} in ROS", topic_name(camera));
            let help = "give one of them another name, of letters, digits and _, or choose another format";
            return Err(Invalid::new("", message).help(help));
        }
    }
    Ok(())
}

/// A layer of ground truth.
fn truth_image(stamp: &Stamp<'_>, layer: &str, planes: &Planes) -> Vec<u8> {
    let (size, channels) = ([planes.width(), planes.height()], planes.channels());
    let values = (0..size[0] * size[1]).flat_map(|i| channels.iter().map(move |channel| channel.data[i]));
    let (encoding, data): (String, Vec<u8>) = if ["instance", "material"].contains(&layer) {
        ("32SC1".to_owned(), values.flat_map(|id| (id as i32).to_le_bytes()).collect())
    } else {
        (format!("32FC{}", channels.len()), values.flat_map(f32::to_le_bytes).collect())
    };
    image(stamp, size, &encoding, 4 * channels.len(), &data)
}
