//! Every key of MTL files is felt: a ball with it and without it look different, as `photosite compare` judges.

use std::fmt::Write;
use std::io::Cursor;

use image::{ImageFormat, Rgba, RgbaImage};

use crate::folder::Folder;

const CAPTURE: &str = "\
[scene]
geometry = [\"ball.obj\"]
environment = { illuminant = \"D65\", illuminance_lux = 100 }

[[lights]]
type = \"directional\"
direction = [-1, -2, -2]
illuminance_lux = 1000

[camera]
position_m = [0.0, 0.0, 3.0]
look_at_m = [0.0, 0.0, 0.0]

[lens]
type = \"pinhole\"
focal_length_mm = 10.0

[sensor]
preset = \"generic-cmos-color\"
resolution_px = [16, 16]
pixel_pitch_um = [500.0, 500.0]

[exposure]
time_s = 0.0001

[render]
samples_per_pixel = 64
";

/// A ball with normals and UVs before a dark wall.
fn ball() -> Vec<u8> {
    const BANDS: u32 = 12;
    let mut text = "mtllib ball.mtl\nv -9 -9 -4\nv 9 -9 -4\nv 0 18 -4\nusemtl wall\nf 1 2 3\nusemtl ball\n".to_owned();
    for band in 0..=BANDS {
        for sector in 0..=2 * BANDS {
            let (u, v) = (sector as f32 / (2 * BANDS) as f32, band as f32 / BANDS as f32);
            let (theta, phi) = (std::f32::consts::PI * v, std::f32::consts::TAU * u);
            let [x, y, z] = [theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin()];
            writeln!(text, "v {x} {y} {z}\nvn {x} {y} {z}\nvt {u} {}", 1.0 - v).expect("a string");
        }
    }
    for band in 0..BANDS {
        for sector in 0..2 * BANDS {
            let corner = |band: u32, sector: u32| {
                let i = band * (2 * BANDS + 1) + sector + 1;
                format!("{}/{i}/{i}", i + 3)
            };
            let (a, b) = (corner(band, sector), corner(band, sector + 1));
            let (c, d) = (corner(band + 1, sector), corner(band + 1, sector + 1));
            writeln!(text, "f {a} {c} {d} {b}").expect("a string");
        }
    }
    text.into_bytes()
}

fn image(texel: impl Fn(u32, u32) -> [u8; 4]) -> Vec<u8> {
    let mut png = Cursor::new(Vec::new());
    RgbaImage::from_fn(16, 8, |x, y| Rgba(texel(x, y))).write_to(&mut png, ImageFormat::Png).expect("encoded");
    png.into_inner()
}

fn folder() -> Folder {
    let checks = |x: u32, y: u32| if (x / 2 + y / 2).is_multiple_of(2) { 230 } else { 25 };
    let grey = |x, y| [checks(x, y), checks(x, y), checks(x, y), 255];
    let tilted = |x: u32, _| if x % 4 < 2 { [190, 128, 220, 255] } else { [66, 128, 220, 255] };
    Folder::new([
        ("capture.toml", CAPTURE.into()),
        ("ball.obj", ball()),
        ("grey.png", image(grey)),
        ("colours.png", image(|x, y| [checks(x, y), 128, 255 - checks(x, y), 255])),
        ("normals.png", image(tilted)),
    ])
}

/// Renders the ball with that material.
fn render(folder: &Folder, lines: &str, seed: u32, out: &str) {
    folder.add("ball.mtl", format!("newmtl wall\nKd 0.05 0.1 0.2\nnewmtl ball\n{lines}\n"));
    let outcome = folder.succeed(&format!("render capture.toml --seed {seed} -o {out}"));
    let mut said = outcome.stderr.lines().filter(|line| !line.contains("caustics"));
    assert!(!said.any(|line| line.contains("material")), "{lines}: {}", outcome.stderr);
}

const MATT: &str = "Kd 0.5 0.4 0.3";
// Dark, so that what their surfaces reflect is most of their light.
const SHINY: &str = "Kd 0.02\nKs 0.5 0.5 0.5\nNs 40";
const MODERN: &str = "Kd 0.02\nPr 0.4";

#[test]
fn every_key_is_felt() {
    let folder = folder();
    let mut wrong = Vec::new();
    for (base, changed) in [
        (MATT, vec!["Kd 0.3 0.4 0.5", "Ke 100 50 20", "d 0.5", "map_Kd colours.png", "map_d grey.png"]),
        (MATT, vec!["map_Ke colours.png\nKe 100 100 100", "Ni 1.5\nillum 7", "norm normals.png"]),
        (MATT, vec!["bump -bm 2 grey.png", "map_Bump normals.png", "Ks 0.9\nillum 3", "Kd 0 0 0\nKs 0.9\nillum 5"]),
        ("Kd 0.02", vec!["Ks 0.5 0.5 0.5\nNs 40"]),
        ("Kd 0.5\nd 0.4", vec!["Tf 1 0.2 0.1", "d 0.7"]),
        ("Kd 0.5\nNi 1.5\nillum 7", vec!["Tf 1 0.2 0.1", "Ni 1.2", "Pr 0.5"]),
        (
            SHINY,
            vec!["Ks 1 0.2 0.2", "Ns 400", "Ni 2.2", "map_Ks colours.png", "map_Ns grey.png", "illum 1", "illum 8"],
        ),
        (MODERN, vec!["Pr 0.9", "Pm 1", "Ps 1", "Pc 1", "Pc 1\nPcr 0.8", "aniso 0.9", "Ks 1 1 1", "Ni 2.2"]),
        (
            MODERN,
            vec!["map_Pr grey.png", "map_Pm grey.png", "map_Ps grey.png", "map_Pc grey.png", "map_ORM colours.png"],
        ),
        ("Pm 1\nPr 0.3\naniso 0.9", vec!["anisor 0.25"]),
        ("Kd 0\nPc 1\nPr 1", vec!["Pcr 0.5", "map_Pcr grey.png"]),
        (
            "map_Kd colours.png",
            vec!["map_Kd -s 3 1 colours.png", "map_Kd -o 0.2 0 colours.png", "map_Kd -mm 0 0.5 colours.png"],
        ),
        ("map_Kd -s 2 2 colours.png", vec!["map_Kd -s 2 2 -clamp on colours.png"]),
        ("map_d -imfchan r colours.png", vec!["map_d -imfchan b colours.png"]),
        ("Kd 0.5\nnorm normals.png", vec!["norm -bm 0.2 normals.png"]),
    ] {
        render(&folder, base, 1, "base");
        for lines in changed {
            // What comes later counts.
            render(&folder, &format!("{base}\n{lines}"), 2, "changed");
            let outcome = folder.run("compare base/electrons.exr changed/electrons.exr");
            if outcome.status != Some(1) {
                wrong.push(format!("{base:?} and {lines:?} look the same: {}", outcome.stdout));
            }
            std::fs::remove_dir_all(folder.path("changed")).expect("removed");
        }
        // And noise alone is no difference.
        render(&folder, base, 3, "again");
        folder.succeed("compare base/electrons.exr again/electrons.exr");
        for name in ["base", "again"] {
            std::fs::remove_dir_all(folder.path(name)).expect("removed");
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
