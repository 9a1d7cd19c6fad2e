//! Images as they are sent: a description and values.

use serde_json::{Value, json};

use photosite_core::image::{Channel, Planes};
use photosite_develop::{Codes, EncodedImage};
use photosite_raw::RawImage;

/// Image to send: rows of values, the channels of a pixel together.
pub(super) struct SentImage {
    pub(super) size: [usize; 2],
    pub(super) channels: Vec<String>,
    pub(super) unit: &'static str,
    pub(super) values: Values,
}

/// Pixel values, by their type.
pub(super) enum Values {
    U8(Vec<u8>),
    U16(Vec<u16>),
    F32(Vec<f32>),
}

impl SentImage {
    /// Image of the codes of a developed image.
    pub(super) fn of_codes(image: EncodedImage) -> Self {
        let names: &[&str] = if image.components == 3 { &["R", "G", "B"] } else { &["Y"] };
        let values = match image.codes {
            Codes::U8(codes) => Values::U8(codes),
            Codes::U16(codes) => Values::U16(codes),
        };
        let channels = names.iter().map(|&name| name.to_owned()).collect();
        Self { size: [image.width, image.height], channels, unit: "", values }
    }

    /// Image of digital numbers.
    pub(super) fn of_raw(raw: &RawImage) -> Self {
        let channels = match raw.cfa.samples_per_pixel() {
            1 => vec!["DN".to_owned()],
            _ => raw.cfa.channels().to_vec(),
        };
        Self { size: [raw.width, raw.height], channels, unit: "DN", values: Values::U16(raw.data.clone()) }
    }

    /// Image of a plane, each value made of one of a channel.
    pub(super) fn of_plane(size: [usize; 2], channel: &Channel, unit: &'static str, value: fn(f32) -> f32) -> Self {
        let values = channel.data.iter().map(|&of_channel| value(of_channel)).collect();
        Self { size, channels: vec![channel.name.clone()], unit, values: Values::F32(values) }
    }

    /// Image of planes side by side.
    pub(super) fn of_planes(planes: &Planes, unit: &'static str) -> Self {
        let channels = planes.channels();
        let [width, height] = [planes.width(), planes.height()];
        let values = (0..width * height).flat_map(|pixel| channels.iter().map(move |channel| channel.data[pixel]));
        let values = Values::F32(values.collect());
        let channels = channels.iter().map(|channel| channel.name.clone()).collect();
        Self { size: [width, height], channels, unit, values }
    }

    /// The values of a pixel, each with the name of its channel.
    pub(super) fn at(&self, [x, y]: [usize; 2]) -> Option<Vec<(&str, f64)>> {
        let [width, height] = self.size;
        if x >= width || y >= height {
            return None;
        }
        let first = (y * width + x) * self.channels.len();
        let value = |index: usize| match &self.values {
            Values::U8(values) => f64::from(values[index]),
            Values::U16(values) => f64::from(values[index]),
            Values::F32(values) => f64::from(values[index]),
        };
        Some(self.channels.iter().enumerate().map(|(i, name)| (name.as_str(), value(first + i))).collect())
    }

    /// Bytes as they are sent: the length of the description, the description with the facts in `more`, the values.
    pub(super) fn bytes<const N: usize>(&self, more: [Value; N]) -> Vec<u8> {
        let [width, height] = self.size;
        let kind = match &self.values {
            Values::U8(_) => "u8",
            Values::U16(_) => "u16",
            Values::F32(_) => "f32",
        };
        let mut description =
            json!({ "width": width, "height": height, "channels": self.channels, "type": kind, "unit": self.unit });
        for facts in more {
            if let (Value::Object(all), Value::Object(facts)) = (&mut description, facts) {
                all.extend(facts);
            }
        }
        let mut text = description.to_string();
        // Numbers of four bytes begin where they can be read in place.
        let padding = text.len().next_multiple_of(4) - text.len();
        text.extend(std::iter::repeat_n(' ', padding));
        let mut bytes = (text.len() as u32).to_le_bytes().to_vec();
        bytes.extend_from_slice(text.as_bytes());
        match &self.values {
            Values::U8(values) => bytes.extend_from_slice(values),
            Values::U16(values) => bytes.extend(values.iter().flat_map(|value| value.to_le_bytes())),
            Values::F32(values) => bytes.extend(values.iter().flat_map(|value| value.to_le_bytes())),
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_follow_their_description() {
        let image = SentImage {
            size: [2, 1],
            channels: vec!["DN".to_owned()],
            unit: "DN",
            values: Values::U16(vec![1, 0x0203]),
        };
        let bytes = image.bytes([json!({ "light": 7 })]);
        let length = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize;
        let description: Value = serde_json::from_slice(&bytes[4..4 + length]).expect("JSON");
        assert_eq!((length % 4, &description["type"], &description["light"]), (0, &json!("u16"), &json!(7)));
        assert_eq!((&description["width"], &description["height"]), (&json!(2), &json!(1)));
        assert_eq!(bytes[4 + length..], [1, 0, 3, 2]);
    }
}
