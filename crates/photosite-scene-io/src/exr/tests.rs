use std::io::Cursor;

use proptest::prelude::*;

use super::made_for_tests::{Part, Samples, file, floats};
use super::*;

fn read(parts: &[Part]) -> Result<ExrImage, Invalid> {
    read_exr(Cursor::new(file(parts)))
}

fn plane(image: &ExrImage) -> &[f32] {
    &image.planes.channels()[0].data
}

#[test]
fn lines_in_either_order_and_values_of_every_type_are_the_same() {
    let window = [0, 0, 1, 2];
    let values = [0.0f32, 1.0, 2.0, 3.0, 4.0, 0.5];
    // Halves: 5 bits of exponent with a bias of 15, 10 of mantissa.
    let halves = vec![0x0000, 0x3c00, 0x4000, 0x4200, 0x4400, 0x3800];
    for samples in [Samples::F32(values.to_vec()), Samples::F16(halves)] {
        for decreasing in [false, true] {
            let channels = vec![("Y", samples.clone())];
            let part = Part { channels, data: window, display: window, decreasing, ..Part::row(&[]) };
            let image = read(&[part]).expect("an image");
            assert_eq!((plane(&image), image.warnings.len()), (&values[..], 0));
        }
    }
}

#[test]
fn whole_numbers_that_floats_do_not_hold_are_counted() {
    let channels = vec![("id", Samples::U32(vec![16_777_216, 16_777_217, u32::MAX, 5]))];
    let image = read(&[Part { channels, ..Part::row(&[("id", &[0.0; 4])]) }]).expect("an image");
    assert_eq!(plane(&image), [16_777_216.0, 16_777_216.0, 4_294_967_296.0, 5.0]);
    assert!(image.warnings[0].starts_with("2 whole numbers of its channel id are rounded"), "{image:?}");
}

#[test]
fn of_several_parts_the_first_image_is_read_and_the_others_named() {
    let named = |name: &'static str, part: Part| part.with("name", "string", name.into());
    let depth = named("depth", Part::row(&[("Z", &[7.0])]));
    let left = named("beauty", Part::row(&[("B", &[3.0]), ("G", &[2.0]), ("R", &[1.0])]));
    let left = left.with("view", "string", b"left".to_vec());
    let right = named("other", Part::row(&[("B", &[6.0]), ("G", &[5.0]), ("R", &[4.0])]));
    let image = read(&[depth, left, right]).expect("an image");
    assert_eq!(image.planes.plane("R"), Some(&[1.0][..]));
    assert_eq!(image.warnings, ["of its parts, beauty (view left) is read, and left out are depth, other"]);
    assert!(image.whole().is_err());
}

#[test]
fn subsampled_channels_are_refused() {
    let window = [0, 0, 1, 1];
    let whole = Part::row(&[("BY", &[0.0; 4]), ("RY", &[0.0; 4]), ("Y", &[0.0; 4])]);
    let part = Part { sampling: 2, data: window, display: window, ..whole };
    let error = read(&[part]).expect_err("refused");
    assert!(error.message.contains("subsampling") && error.help.is_some(), "{error:?}");
}

#[test]
fn maps_of_surroundings_fill_their_data_window() {
    let part = Part { display: [0, 0, 9, 9], ..Part::row(&[("Y", &[1.0, 2.0])]) };
    let image = read(&[part.clone().with("envmap", "envmap", vec![0])]).expect("an image");
    assert_eq!((plane(&image), image.warnings.len()), (&[1.0, 2.0][..], 0));
    assert_eq!(read(&[part]).expect("an image").planes.width(), 10);
}

#[test]
fn windows_without_a_common_pixel_or_without_end_are_refused() {
    let part = Part::row(&[("Y", &[1.0, 2.0])]);
    for (data, key) in [([5, 0, 6, 0], "dataWindow"), ([0, -1, 1, -1], "dataWindow")] {
        assert_eq!(read(&[Part { data, ..part.clone() }]).expect_err("refused").key, key);
    }
    let endless = Part { display: [0, 0, 1 << 20, 1 << 20], ..part };
    assert!(read(&[endless]).expect_err("refused").message.contains("display window"));
}

proptest! {
    /// Pixels lie at their column and row, whatever the windows.
    #[test]
    fn pixels_lie_where_the_windows_place_them(
        data in (-4i32..5, -4i32..5, 1i32..6, 1i32..6),
        display in (-4i32..5, -4i32..5, 1i32..6, 1i32..6),
    ) {
        let [data, display] = [data, display].map(|(x, y, width, height)| [x, y, x + width - 1, y + height - 1]);
        let rows = data[1]..=data[3];
        let number = |x: i32, y: i32| (1 + 100 * (y + 10) + x + 10) as f32;
        let values = rows.flat_map(|y| (data[0]..=data[2]).map(move |x| number(x, y))).collect::<Vec<_>>();
        let part = Part { channels: vec![("Y", Samples::F32(values))], data, display, ..Part::row(&[]) };
        let is_within = |[x0, y0, x1, y1]: [i32; 4], x: i32, y: i32| (x0..=x1).contains(&x) && (y0..=y1).contains(&y);
        let shown: Vec<[i32; 2]> =
            (display[1]..=display[3]).flat_map(|y| (display[0]..=display[2]).map(move |x| [x, y])).collect();
        let expected: Vec<f32> =
            shown.iter().map(|&[x, y]| if is_within(data, x, y) { number(x, y) } else { 0.0 }).collect();
        match read(&[part]) {
            Err(_) => prop_assert!(expected.iter().all(|&value| value == 0.0)),
            Ok(image) => {
                prop_assert_eq!(plane(&image), &expected[..]);
                let stored = (data[2] - data[0] + 1) * (data[3] - data[1] + 1);
                let common = expected.iter().filter(|&&value| value != 0.0).count();
                let said = usize::from(common < expected.len()) + usize::from(common < stored as usize);
                prop_assert_eq!(image.warnings.len(), said);
            }
        }
    }
}

#[test]
fn torn_files_are_refused() {
    let whole = file(&[Part::row(&[("Y", &[1.0, 2.0])]).with("whiteLuminance", "float", floats(&[100.0]))]);
    for length in 0..whole.len() {
        assert!(read_exr(Cursor::new(&whole[..length])).is_err(), "{length} of {} bytes", whole.len());
    }
}
