//! Messages for the image viewer [tev](https://tom94.net/tev), which takes pictures over TCP and shows them as they grow.
//!
//! Numbers are little endian, names end with a zero byte. Each message begins with its length in bytes, these four
//! included, and its kind:
//!
//! | kind | what follows |
//! |---|---|
//! | 4, a new image | u8 whether it is selected, name, u32 columns, u32 rows, u32 channels, their names |
//! | 6, new pixels | u8 whether it is selected, name, u32 channels, their names, u32 left column, u32 upper row, u32 columns, u32 rows, for each channel u64 place of its first number, for each channel u64 numbers from pixel to pixel, f32 numbers |
//!
//! A new image takes the place of one of the same name. Source: version 3 of the protocol in tev's `src/Ipc.cpp`, as
//! `tevclient` 1.0.4 writes it, whose messages are compared with these (`tests/judges/tev.py`).

use std::io;
use std::ops::Range;

use crate::image::Planes;

const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE: u8 = 6;
/// Bytes of the numbers in a message, unless a single row has more: tev takes each message whole.
const MOST: usize = 1 << 22;

/// The message of a new black image for planes of this size and these names. tev selects it where `is_selected`.
pub fn new_image(name: &str, planes: &Planes, is_selected: bool) -> io::Result<Vec<u8>> {
    let mut message = begun(CREATE_IMAGE, name, is_selected);
    push(&mut message, [planes.width(), planes.height()])?;
    push_channels(&mut message, planes)?;
    with_length(message)
}

/// The rows that one message after the other takes of planes.
pub fn rows_of_messages(planes: &Planes) -> impl Iterator<Item = Range<usize>> + use<> {
    let height = planes.height();
    let row = (planes.width() * planes.channels().len() * size_of::<f32>()).max(1);
    let most = (MOST / row).max(1);
    (0..height).step_by(most).map(move |first| first..(first + most).min(height))
}

/// The message of new pixels in some rows of an image.
pub fn new_pixels(name: &str, planes: &Planes, rows: Range<usize>) -> io::Result<Vec<u8>> {
    let (width, channels) = (planes.width(), planes.channels());
    let mut message = begun(UPDATE_IMAGE, name, false);
    push_channels(&mut message, planes)?;
    push(&mut message, [0, rows.start, width, rows.len()])?;
    let strides = channels.iter().map(|_| channels.len());
    message.extend((0..channels.len()).chain(strides).flat_map(|number| (number as u64).to_le_bytes()));
    for pixel in rows.start * width..rows.end * width {
        message.extend(channels.iter().flat_map(|channel| channel.data[pixel].to_le_bytes()));
    }
    with_length(message)
}

/// A message but for its length.
fn begun(kind: u8, name: &str, is_selected: bool) -> Vec<u8> {
    let mut message = vec![0, 0, 0, 0, kind, u8::from(is_selected)];
    push_name(&mut message, name);
    message
}

fn push_name(message: &mut Vec<u8>, name: &str) {
    // A zero byte would end it.
    message.extend(name.bytes().filter(|&byte| byte != 0));
    message.push(0);
}

fn push_channels(message: &mut Vec<u8>, planes: &Planes) -> io::Result<()> {
    push(message, [planes.channels().len()])?;
    planes.channels().iter().for_each(|channel| push_name(message, &channel.name));
    Ok(())
}

fn push<const N: usize>(message: &mut Vec<u8>, numbers: [usize; N]) -> io::Result<()> {
    for number in numbers {
        message.extend(number_of_4_bytes(number)?);
    }
    Ok(())
}

fn with_length(mut message: Vec<u8>) -> io::Result<Vec<u8>> {
    let length = number_of_4_bytes(message.len())?;
    message[..4].copy_from_slice(&length);
    Ok(message)
}

fn number_of_4_bytes(number: usize) -> io::Result<[u8; 4]> {
    let number = u32::try_from(number).map_err(|_| io::Error::other("the picture is too large for tev's messages"))?;
    Ok(number.to_le_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What tevclient 1.0.4 sends of a picture of 2 × 2 pixels, and of its lower row:
    /// `packet.create_image("a", 2, 2, ["R", "G"])` and
    /// `packet.update_image("a", np.array([[[1, 2], [3, -0.5]]], np.float32), ["R", "G"], 0, 1)`.
    #[test]
    fn messages_are_those_of_tevclient() {
        let mut planes = Planes::zeros(2, 2, ["R", "G"]);
        planes.channels_mut()[0].data.copy_from_slice(&[9.0, 9.0, 1.0, 3.0]);
        planes.channels_mut()[1].data.copy_from_slice(&[9.0, 9.0, 2.0, -0.5]);
        let hex = |bytes: Vec<u8>| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        assert_eq!(hex(new_image("a", &planes, true).expect("short")), CREATED);
        assert_eq!(hex(new_pixels("a", &planes, 1..2).expect("short")), UPDATED);
    }

    const CREATED: &str = "180000000401610002000000020000000200000052004700";
    const UPDATED: &str = "500000000600610002000000520047000000000001000000020000000100000000000000000000000100000000000000020000000000000002000000000000000000803f0000004000004040000000bf";

    #[test]
    fn messages_hold_all_rows_once_and_at_most_4_mib() {
        for (width, height, channels) in [(7, 5, 3), (640, 480, 3), (4096, 3000, 4), (2_000_000, 3, 1)] {
            let names: Vec<String> = (0..channels).map(|channel| channel.to_string()).collect();
            let planes = Planes::zeros(width, height, names.iter().map(String::as_str));
            let mut next = 0;
            for rows in rows_of_messages(&planes) {
                assert_eq!(rows.start, next);
                assert!(!rows.is_empty());
                assert!(rows.len() == 1 || rows.len() * width * channels * 4 <= MOST, "{rows:?}");
                next = rows.end;
            }
            assert_eq!(next, height);
        }
    }
}
