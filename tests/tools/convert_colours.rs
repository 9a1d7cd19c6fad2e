//! Converts random colours between all spaces and prints them with their differences, for a program that nobody here
//! wrote to do the same (`tests/judges/colours.py`).
//!
//! `cargo run --release --example convert_colours > colours.json`

use glam::DVec3;
use photosite::colour::{ColourSpace, Transfer, adaptation, cielab, difference, hue, temperature};
use photosite::math::philox::Philox;
use rand::RngExt;
use serde_json::{Map, Value, json};

const COLOURS: usize = 2000;

fn main() {
    let mut random = Philox::new(1, 0);
    let mut unit = || DVec3::from_array(std::array::from_fn(|_| random.random::<f64>()));
    let rgb: Vec<DVec3> = (0..COLOURS).map(|_| unit()).collect();
    let others: Vec<DVec3> = (0..COLOURS).map(|_| unit()).collect();
    let white = ColourSpace::Srgb.white();
    let lab = |rgb: &DVec3| cielab::from_xyz(ColourSpace::Srgb.to_xyz() * *rgb, white);
    let xyz: Vec<DVec3> = rgb.iter().map(|rgb| ColourSpace::Srgb.to_xyz() * *rgb).collect();
    // Every other pair is of near colours, for which difference formulas were made.
    let pairs: Vec<(DVec3, DVec3)> = (rgb.iter().zip(&others).enumerate())
        .map(|(i, (a, b))| (lab(a), if i % 2 == 0 { lab(b) } else { lab(a) + (*b - DVec3::splat(0.5)) * 4.0 }))
        .collect();
    let list = |colours: &mut dyn Iterator<Item = DVec3>| -> Value { colours.map(|c| json!(c.to_array())).collect() };
    let each = |of: &dyn Fn(DVec3) -> DVec3| list(&mut rgb.iter().map(|c| of(*c)));
    let pair = |of: fn(DVec3, DVec3) -> f64| -> Value { pairs.iter().map(|(a, b)| json!(of(*a, *b))).collect() };
    let a = DVec3::new(1.098_5, 1.0, 0.355_85);
    let spaces: Map<String, Value> = ColourSpace::ALL
        .into_iter()
        .map(|space| (space.name().to_owned(), json!(space.to_xyz().transpose().to_cols_array_2d())))
        .collect();
    let lights: Vec<Value> = (0..200)
        .map(|i| {
            let (kelvin, tint) = (2000.0 + 50.0 * f64::from(i), f64::from(i % 13) - 6.0);
            json!({"temperature_k": kelvin, "tint": tint, "xy": temperature::chromaticity(kelvin, tint)})
        })
        .collect();
    let encoded =
        |transfer: Transfer| each(&|c| DVec3::from_array(c.to_array().map(|v| transfer.encode(v as f32).into())));
    let report = json!({
        "white": white.to_array(),
        "rgb": list(&mut rgb.iter().copied()),
        "xyz": list(&mut xyz.iter().copied()),
        "hsv": each(&hue::rgb_to_hsv),
        "rgb_of_hsv": each(&hue::hsv_to_rgb),
        "hsl": each(&hue::rgb_to_hsl),
        "rgb_of_hsl": each(&hue::hsl_to_rgb),
        "hsi": each(&hue::rgb_to_hsi),
        "rgb_of_hsi": each(&|c| hue::hsi_to_rgb(hue::rgb_to_hsi(c))),
        "lab": each(&|c| lab(&c)),
        "xyz_of_lab": list(&mut rgb.iter().map(|c| cielab::to_xyz(lab(c), white))),
        "xyy": list(&mut xyz.iter().map(|c| cielab::xyy_from_xyz(*c, white))),
        "xyz_of_xyy": list(&mut xyz.iter().map(|c| cielab::xyy_to_xyz(cielab::xyy_from_xyz(*c, white)))),
        "encoded_srgb": encoded(Transfer::Srgb),
        "pairs": pairs.iter().map(|(a, b)| json!([a.to_array(), b.to_array()])).collect::<Vec<_>>(),
        "delta_e_76": pair(difference::delta_e_76),
        "delta_e_94": pair(difference::delta_e_94),
        "delta_e_2000": pair(difference::delta_e_2000),
        "bradford_from": a.to_array(),
        "bradford": json!(adaptation::bradford(a, white).transpose().to_cols_array_2d()),
        "spaces": spaces,
        "aces_white": ColourSpace::Acescg.white().to_array(),
        "lights": lights,
    });
    println!("{report}");
}
