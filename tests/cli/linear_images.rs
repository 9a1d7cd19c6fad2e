//! Messages about images of linear light, EXR and Radiance HDR, by every command that reads them.

use photosite::image::{Channel, Planes};
use photosite::io::exr::{Attribute, write_exr};

use crate::folder::Folder;

const REC2020: [[f64; 2]; 4] = [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], [0.3127, 0.329]];

fn exr(values: [[f32; 4]; 3], attributes: &[(&str, Attribute)]) -> Vec<u8> {
    let channel = |(name, data): (&str, [f32; 4])| Channel { name: name.to_owned(), data: data.to_vec() };
    let planes = Planes::new(2, 2, ["B", "G", "R"].into_iter().zip(values).map(channel).collect()).expect("right");
    let mut file = std::io::Cursor::new(Vec::new());
    write_exr(&planes, attributes, &mut file).expect("written");
    file.into_inner()
}

/// Four texels of 1, the last of another exponent.
fn hdr(lines: &str, exponent: u8) -> Vec<u8> {
    let texels = [[128, 128, 128, 129], [128, 128, 128, 129], [128, 128, 128, 129], [128, 128, 128, exponent]];
    [format!("#?RGBE\r\n{lines}\r\n-Y 2 +X 2\r\n").as_bytes(), texels.as_flattened()].concat()
}

/// The figures are those of the finite numbers, of which the mean of 1, 2 and 3 is 2.
#[test]
fn numbers_that_are_not_finite_are_counted_and_named() {
    let values = [[1.0, 2.0, 3.0, f32::NAN], [f32::INFINITY, 1.0, 2.0, 3.0], [1.0; 4]];
    let folder = Folder::new([("a.exr", exr(values, &[]))]);
    let found = folder.succeed("info a.exr --json").json();
    for (channel, not_finite, mean) in [(0, 1, 2.0), (1, 1, 2.0), (2, 0, 1.0)] {
        let channel = &found["channels"][channel];
        assert_eq!((&channel["not_finite"], &channel["mean"]), (&not_finite.into(), &mean.into()));
    }
    let words = "2 numbers are not finite: the first is NaN, of B in column 1, row 1";
    assert!(found["warnings"][0].as_str().expect("a warning").starts_with(words), "{found}");
    let said = folder.succeed("develop a.exr -o a.npy").stderr;
    assert!(said.contains("a.exr: 2 numbers are not finite: the first is inf, of G in column 0, row 0"), "{said}");
}

#[test]
fn colours_that_one_file_states_are_said_where_numbers_are_compared() {
    let values = [[0.5; 4]; 3];
    let stated = [("chromaticities", Attribute::Chromaticities(REC2020))];
    let folder = Folder::new([("a.exr", exr(values, &stated)), ("b.exr", exr(values, &[]))]);
    let said = folder.succeed("compare a.exr b.exr").stderr;
    assert!(said.contains("a.exr states chromaticities") && said.contains("compared as they are"), "{said}");
    assert_eq!(folder.succeed("compare a.exr a.exr").stderr, "");
}

#[test]
fn degenerate_primaries_are_refused() {
    let points = [REC2020[0], REC2020[0], REC2020[2], REC2020[3]];
    let folder = Folder::new([("a.exr", exr([[0.5; 4]; 3], &[("chromaticities", Attribute::Chromaticities(points))]))]);
    folder.fail("develop a.exr -o a.png", 1, &["a.exr: chromaticities", "span no colours"]);
}

#[test]
fn radiance_images_are_read_wherever_images_are() {
    // Half of 1 is half as bright once the exposure is taken back.
    let folder = Folder::new([("a.hdr", hdr("EXPOSURE=2\r\n", 129)), ("b.hdr", hdr("", 128))]);
    let found = folder.succeed("info a.hdr --json").json();
    assert_eq!(found["channels"][0]["mean"], 0.5);
    folder.succeed("develop a.hdr -o a.npy");
    folder.succeed("compare a.hdr a.hdr");
    let histogram = folder.succeed("measure histogram b.hdr --json").json();
    assert_eq!(histogram[0]["mean"], 0.875);
}

#[test]
fn surroundings_too_bright_for_floats_are_refused_before_they_are_traced() {
    let capture = "[scene]\ngeometry = ['a.obj']\nenvironment = { image = 'sky.hdr', nit_per_unit = 1000 }\n";
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let folder = Folder::new([("a.obj", obj.into()), ("capture.toml", capture.into()), ("sky.hdr", hdr("", 200))]);
    let words =
        ["capture.toml:3: scene.environment.image: sky.hdr: the texel in column 1, row 1", "brighter than 1e15"];
    folder.fail("render capture.toml -o out", 1, &words);
}

/// An image of 64 × 48 pixels with an edge, two of whose values are another, as EXR, NPY and float TIFF.
fn with_two_of(value: f32, channels: usize) -> [(&'static str, Vec<u8>); 3] {
    const SIZE: [usize; 2] = [64, 48];
    let edge = |i: usize| {
        let (x, y) = ((i % SIZE[0]) as f32, (i / SIZE[0]) as f32);
        0.2 + 0.6 / (1.0 + (-2.0 * (x - 32.0 + 0.1 * (y - 24.0))).exp())
    };
    let mut plane: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(edge).collect();
    [20 * 64 + 33, 21 * 64 + 30].into_iter().for_each(|i| plane[i] = value);
    let names = if channels == 1 { &["Y"][..] } else { &["R", "G", "B"] };
    let even: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(edge).collect();
    let data = |i: usize| if i == 0 { plane.clone() } else { even.clone() };
    let channel = |(i, name): (usize, &&str)| Channel { name: (*name).to_owned(), data: data(i) };
    let planes = Planes::new(SIZE[0], SIZE[1], names.iter().enumerate().map(channel).collect()).expect("right");
    let mut exr = std::io::Cursor::new(Vec::new());
    write_exr(&planes, &[], &mut exr).expect("written");
    let pixels: Vec<f32> =
        (0..SIZE[0] * SIZE[1]).flat_map(|i| planes.channels().iter().map(move |c| c.data[i])).collect();
    let shape = if channels == 1 { "48, 64" } else { "48, 64, 3" };
    let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({shape}), }}");
    let header = format!("{header:<117}\n");
    let bytes: Vec<u8> = pixels.iter().flat_map(|value| value.to_le_bytes()).collect();
    let npy = [&b"\x93NUMPY\x01\0"[..], &(header.len() as u16).to_le_bytes(), header.as_bytes(), &bytes].concat();
    let mut tiff = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut tiff).expect("begun");
    if channels == 1 {
        encoder.write_image::<tiff::encoder::colortype::Gray32Float>(64, 48, &pixels).expect("written");
    } else {
        encoder.write_image::<tiff::encoder::colortype::RGB32Float>(64, 48, &pixels).expect("written");
    }
    [("exr", exr.into_inner()), ("npy", npy), ("tiff", tiff.into_inner())]
}

/// Commands that read an image `A`, with another, `B`.
const COMMANDS: [&str; 9] = [
    "measure histogram A",
    "measure similarity A B",
    "measure similarity B A",
    "measure mtf A",
    "compare A B",
    "compare B A",
    "noise A",
    "noise add A -o out.npy --force --set gaussian.sigma=0.1",
    "expose A --unit lux --one 10 --set exposure.time_s=0.001 -o out --force -q",
];

/// Every command names the file, how many values are not finite, and where the first is; none has NaN for a result.
#[test]
fn values_that_are_not_finite_are_named_by_every_command() {
    for (value, word) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf"), (f32::NEG_INFINITY, "-inf")] {
        for channels in [1, 3] {
            for ((kind, bad), (_, good)) in with_two_of(value, channels).into_iter().zip(with_two_of(0.5, channels)) {
                let (a, b) = (format!("a.{kind}"), format!("b.{kind}"));
                let folder = Folder::new([(&a[..], bad), (&b[..], good)]);
                for command in COMMANDS {
                    let arguments = command.replace('A', &a).replace('B', &b);
                    let found = folder.run(&arguments);
                    let text = found.text();
                    assert!([Some(0), Some(1), Some(2)].contains(&found.status), "{arguments}: {found:?}");
                    for words in [&format!("{a}: 2 "), "are not finite", "the first", word, "column 33, row 20"] {
                        assert!(text.contains(words), "{arguments}: {words}: {text}");
                    }
                    // The comparison lists the pixels that differ most, as they are.
                    let is_result = !command.starts_with("compare");
                    assert!(!(is_result && found.stdout.contains("NaN")), "{arguments}: {}", found.stdout);
                    assert!(!(is_result && found.stdout.contains("inf")), "{arguments}: {}", found.stdout);
                }
            }
        }
    }
}

#[test]
fn values_of_any_size_and_sign_have_finite_figures() {
    for value in [-0.5, -3e38, 3e38, 0.0] {
        for ((kind, odd), (_, good)) in with_two_of(value, 3).into_iter().zip(with_two_of(0.5, 3)) {
            let (a, b) = (format!("a.{kind}"), format!("b.{kind}"));
            let folder = Folder::new([(&a[..], odd), (&b[..], good)]);
            for command in COMMANDS {
                let arguments = command.replace('A', &a).replace('B', &b);
                let found = folder.run(&arguments);
                assert!([Some(0), Some(1), Some(2)].contains(&found.status), "{arguments}: {found:?}");
                // The PSNR of channels that are the same is infinite.
                let is_infinite = found.stdout.contains("inf") && !command.starts_with("compare");
                assert!(!found.stdout.contains("NaN") && !is_infinite, "{arguments}: {}", found.stdout);
                let named = found.status == Some(0) || command.starts_with("compare") || found.text().contains("help:");
                assert!(named, "{arguments}: {found:?}");
            }
        }
    }
}

/// A reference without light has no white for a PSNR, and is like itself all the same.
#[test]
fn references_without_light_are_refused_or_alike() {
    let folder = Folder::new([("a.exr", exr([[0.5; 4]; 3], &[])), ("dark.exr", exr([[0.0; 4]; 3], &[]))]);
    folder.fail("measure similarity a.exr dark.exr", 1, &["dark.exr: channel R has no value above 0"]);
    let same = folder.succeed("measure similarity dark.exr dark.exr --json").json();
    assert!(same["channels"][0]["psnr_db"].is_null() && same["mean_delta_e_2000"] == 0.0, "{same}");
}

#[test]
fn a_stated_luminance_of_white_is_said_to_have_no_effect_where_another_level_is_given() {
    let capture = "[scene]\ngeometry = ['a.obj']\nenvironment = { image = 'sky.exr', illuminance_lux = 1000 }\n";
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    // The library writes no standard attribute under its own name.
    let white = ::exr::meta::attribute::AttributeValue::F32(100.0);
    let mut sky = exr([[0.5; 4]; 3], &[("whiteLuminancX", Attribute::Other(Box::new(white)))]);
    let at = sky.windows(14).position(|part| part == b"whiteLuminancX").expect("its name");
    sky[at..at + 14].copy_from_slice(b"whiteLuminance");
    let folder = Folder::new([("a.obj", obj.into()), ("capture.toml", capture.into()), ("sky.exr", sky)]);
    let found = folder.succeed("info capture.toml --json").json();
    let words = "its whiteLuminance, 100 cd/m², has no effect: illuminance_lux, 1000, is the level";
    assert!(found["warnings"].to_string().contains(words), "{}", found["warnings"]);
    let said = folder.succeed("expose sky.exr --unit lux --one 10 --set exposure.time_s=0.001 -o out").text();
    assert!(said.contains("sky.exr: its whiteLuminance, 100 cd/m², has no effect"), "{said}");
}
