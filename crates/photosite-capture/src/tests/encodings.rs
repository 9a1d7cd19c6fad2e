//! Tests of texts in the encodings that programs write.

use rstest::rstest;

use super::*;

const SENSOR: &str = include_str!("../../../photosite-sensor/assets/sensors/sony-imx249-mono.toml");
const SPECTRUM: &str = "# µ\nwavelength_nm,value\n400,0.25\n700,0.25\n";

/// A text in UTF-8 or UTF-16, with an end of lines.
fn encoded(text: &str, encoding: &str, end: &str) -> Vec<u8> {
    let text = text.replace('\n', end);
    let wide = |unit: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(unit).collect::<Vec<u8>>();
    match encoding {
        "utf-8" => text.into_bytes(),
        "utf-8-mark" => [b"\xef\xbb\xbf", text.as_bytes()].concat(),
        "utf-16-le" => [b"\xff\xfe", &wide(u16::to_le_bytes)[..]].concat(),
        "utf-16-be" => [b"\xfe\xff", &wide(u16::to_be_bytes)[..]].concat(),
        other => panic!("{other}"),
    }
}

#[rstest]
fn captures_and_what_they_name_are_read_in_every_encoding(
    #[values("utf-8", "utf-8-mark", "utf-16-le", "utf-16-be")] encoding: &str,
    #[values("\n", "\r\n", "\r")] end: &str,
) {
    let text = room(
        "[sensor]\npreset = \"small.toml\"\nresolution_px = [8, 8]\n[materials.wall]\ntype = \"diffuse\"\nreflectance = { file = \"a.csv\" }\n",
    );
    let sensor = format!(
        "# größe\n{}",
        SENSOR.replace("../../../photosite-core/assets/spectra/quantum-efficiency/sony-imx249-mono.csv", "a.csv")
    );
    let files = Files::new("");
    for (name, text) in [("capture.toml", &*text), ("small.toml", &*sensor), ("a.csv", SPECTRUM), ("room.obj", OBJ)] {
        files.add(name, &encoded(text, encoding, end));
    }
    let capture = files.read(&[]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(capture.sensor.resolution, [8, 8]);
    // The line of an error is that of the text.
    files.add("capture.toml", &encoded(&format!("{text}[scene]\n"), encoding, end));
    let error = files.read(&[]).map(|_| ()).expect_err("twice").to_string();
    assert!(error.contains(&format!("capture.toml:{}", text.lines().count() + 1)), "{error}");
}
