//! What is said of pictures of linear light, EXR and Radiance HDR, by every command that reads them.

use photosite::image::{Channel, Planes};
use photosite::io::exr::{Attribute, write_exr};
use serde_json::Value;

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
    let found: Value = serde_json::from_str(&folder.succeed("info a.exr --json").stdout).expect("JSON");
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
fn radiance_pictures_are_read_wherever_pictures_are() {
    // Half of 1 is half as bright once the exposure is taken back.
    let folder = Folder::new([("a.hdr", hdr("EXPOSURE=2\r\n", 129)), ("b.hdr", hdr("", 128))]);
    let found: Value = serde_json::from_str(&folder.succeed("info a.hdr --json").stdout).expect("JSON");
    assert_eq!(found["channels"][0]["mean"], 0.5);
    folder.succeed("develop a.hdr -o a.npy");
    folder.succeed("compare a.hdr a.hdr");
    let histogram: Value =
        serde_json::from_str(&folder.succeed("measure histogram b.hdr --json").stdout).expect("JSON");
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
