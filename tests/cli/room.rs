//! A room with something of everything: textures, a sky, lamps, metal, glass, instances, an open lens with blades.

use std::io::Cursor;

use image::{DynamicImage, ImageFormat, Rgb, Rgb32FImage, RgbImage};
use serde_json::json;

use crate::folder::Folder;
use crate::gltf::triangle;

/// Floor with a texture, wall, lamp, a glass and a golden tent.
const OBJ: &str = "\
mtllib room.mtl
v -1 0 -1
v 1 0 -1
v 1 0 1
v -1 0 1
v -1 2 -1
v 1 2 -1
v -0.3 1.9 -0.3
v 0.3 1.9 -0.3
v 0.3 1.9 0.3
v -0.3 1.9 0.3
v -0.7 0 0
v -0.1 0 0.3
v -0.4 0 -0.4
v -0.4 0.7 0
v 0.1 0 0.3
v 0.7 0 0.2
v 0.4 0 -0.4
v 0.4 0.7 0
vt 0 0
vt 3 0
vt 3 3
vt 0 3
usemtl floor
f 1/1 4/4 3/3 2/2
usemtl wall
f 1 2 6 5
usemtl lamp
f 7 8 9 10
usemtl glass
f 11 12 14
f 12 13 14
f 13 11 14
f 11 13 12
usemtl gold
f 15 16 18
f 16 17 18
f 17 15 18
";

const MTL: &str = "\
newmtl floor
Kd 0.9 0.9 0.9
map_Kd tiles.png
newmtl wall
Kd 0.7 0.3 0.2
newmtl lamp
Kd 0 0 0
Ke 400 360 300
newmtl glass
newmtl gold
";

/// A capture of it, without tables `[render]` and `[output]`.
pub(crate) const CAPTURE: &str = "\
[scene]
geometry = [\"room.obj\", \"sails.gltf\"]
environment = { image = \"sky.hdr\", illuminance_lux = 800 }

[materials.glass]
type = \"dielectric\"
glass = \"BK7\"

[materials.gold]
type = \"conductor\"
metal = \"Au\"
roughness = 0.3

[[lights]]
type = \"spot\"
position_m = [0.9, 1.8, 0.9]
look_at_m = [0, 0, 0]
intensity_cd = 120
outer_angle_deg = 30
illuminant = \"A\"

[camera]
position_m = [0.2, 1.1, 3.2]
look_at_m = [0, 0.7, 0]

[lens]
focal_length_mm = 4
f_number = 1.4
blades = 6
distortion = { model = \"brown-conrady\", k = [-0.1, 0.02, 0], p = [0.001, 0] }

[sensor]
resolution_px = [32, 24]
pixel_pitch_um = [100, 100]

[exposure]
time_s = 0.0002
";

/// The room in a folder of its own, with more lines behind its `capture.toml`.
pub(crate) fn room(more: &str) -> Folder {
    let tiles = RgbImage::from_fn(4, 4, |x, y| Rgb(if (x + y) % 2 == 0 { [200, 180, 150] } else { [40, 60, 90] }));
    let sky = Rgb32FImage::from_fn(16, 8, |x, y| {
        let sun = if (x, y) == (11, 2) { 300.0 } else { 0.0 };
        Rgb([sun + 0.2 * y as f32, sun + 0.5, sun * 0.8 + 1.5 - 0.15 * y as f32])
    });
    let sails = triangle()
        .with("/nodes", json!([
            { "name": "left", "mesh": 0, "translation": [-0.5, 1.0, -0.6], "scale": [0.2, 0.2, 0.2] },
            { "name": "right", "mesh": 0, "translation": [0.5, 1.0, -0.6], "rotation": [0, 0, 1, 0], "scale": [0.2, 0.3, 0.2] }
        ]))
        .with("/scenes/0/nodes", json!([0, 1]))
        .with("/materials/0/pbrMetallicRoughness", json!({
            "baseColorFactor": [0.1, 0.3, 0.6, 1], "metallicFactor": 0.2, "roughnessFactor": 0.4
        }));
    Folder::new([
        ("room.obj", OBJ.into()),
        ("room.mtl", MTL.into()),
        ("sails.gltf", sails.text()),
        ("tiles.png", encoded(&tiles.into(), ImageFormat::Png)),
        ("sky.hdr", encoded(&sky.into(), ImageFormat::Hdr)),
        ("capture.toml", format!("{CAPTURE}\n{more}").into()),
    ])
}

pub(crate) fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).expect("encoded");
    bytes.into_inner()
}
