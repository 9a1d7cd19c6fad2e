//! Tests of photometric levels, which are those of the light, whatever its colour.

use std::f64::consts::PI;

use super::*;
use photosite_core::spectrum::Spectrum;
use photosite_transport::scene::description::EnvironmentDescription;
use photosite_transport::scene::emission_spectrum;

const COLOURS: [&str; 10] = [
    "illuminant = 'A'",
    "illuminant = 'FL2'",
    "spectrum = 1",
    "rgb = [1, 1, 1]",
    "rgb = [0.5, 0.5, 0.5]",
    "rgb = [1, 0.2, 0.1]",
    "rgb = [0, 0, 1]",
    "linear_rgb = [2, 0.2, 0.1]",
    "linear_rgb = [0, 1e-3, 0]",
    "linear_rgb = [10, 20, 40]",
];

/// Luminaire that gives one candela in all directions of the lower half.
const IES: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0 1 1 1\n0 90\n0\n1 1\n";

/// V(λ) as the sum of two peaks whose sides have widths of their own: Wyman, Sloan, Shirley, "Simple analytic
/// approximations to the CIE XYZ color matching functions", JCGT 2 (2013) 1, eq. 4.
fn luminous(spectrum: &Spectrum) -> f64 {
    let peak = |nm: f64, [height, centre, below, above]: [f64; 4]| {
        let width = if nm < centre { below } else { above };
        height * (-0.5 * ((nm - centre) / width).powi(2)).exp()
    };
    let v = |nm: f64| peak(nm, [0.821, 568.8, 46.9, 40.5]) + peak(nm, [0.286, 530.9, 16.3, 31.1]);
    683.0 * spectrum.iter().map(|(nm, value)| v(nm) * value).sum::<f64>()
}

/// Spectra of a light, of a surface and of the surroundings that a capture has.
fn spectra(text: &str) -> Vec<Spectrum> {
    let files = Files::new(text);
    files.add("lamp.ies", IES.as_bytes());
    files.add("led.csv", b"840, 0\n850, 1\n860, 0\n");
    image::RgbImage::from_pixel(2, 2, image::Rgb([255; 3])).save(files.0.path().join("slide.png")).expect("written");
    let scene = files.read(&[]).unwrap_or_else(|error| panic!("{text}: {error}")).scene;
    let lamps = scene.lights.iter().map(|light| &light.emission);
    let surfaces = scene.materials.iter().filter_map(|material| material.emission.as_ref());
    let mut spectra: Vec<_> = lamps.chain(surfaces).map(|e| emission_spectrum(&e.colour, e.level)).collect();
    if let Some(EnvironmentDescription::Constant { colour, luminance_nit }) = &scene.environment {
        spectra.push(emission_spectrum(colour, *luminance_nit));
    }
    spectra
}

#[test]
fn every_light_has_the_level_that_it_states_whatever_its_colour() {
    let lamp = |keys: &str| format!("environment = 'none'\n[[lights]]\nposition_m = [0, 2, 0]\n{keys}\nCOLOUR");
    let lamps = [
        (lamp("type = 'point'\nintensity_cd = 100"), 100.0),
        (lamp("type = 'spot'\ndirection = [0, -1, 0]\nouter_angle_deg = 30\nintensity_cd = 70"), 70.0),
        (lamp("type = 'directional'\ndirection = [0, -1, 0]\nilluminance_lux = 1e4").replace("position_m = [0, 2, 0]", ""), 1e4),
        // Measured lamps carry what scales the file's candelas.
        (lamp("type = 'profile'\nfile = 'lamp.ies'"), 1.0),
        // What is drawn is one candela over the lower half: 2π lm.
        (lamp("type = 'profile'\nfile = 'lamp.ies'\nflux_lm = 50"), 50.0 / (2.0 * PI)),
        (lamp("type = 'projector'\nimage = 'slide.png'\nlook_at_m = [0, 0, 0.1]\nhorizontal_fov_deg = 40\nflux_lm = 300"), 300.0),
        (lamp("type = 'gaussian-beam'\ndirection = [0, -1, 0]\nwaist_radius_mm = [1, 1]\nflux_lm = 4"), 4.0),
        ("environment = { illuminance_lux = 500, COLOUR }".into(), 500.0 / PI),
        ("environment = { luminance_nit = 20, COLOUR }".into(), 20.0),
        (
            "environment = 'none'\n[materials.lamp]\ntype = 'diffuse'\nreflectance = 0\nemission = { luminance_nit = 900, COLOUR }".into(),
            900.0,
        ),
        ("environment = 'none'\n[materials.lamp]\nemission = { luminance_nit = 30, COLOUR }".into(), 30.0),
    ];
    for (keys, level) in lamps {
        for colour in COLOURS {
            let text = format!("[scene]\ngeometry = ['room.obj']\n{}", keys.replace("COLOUR", colour));
            let [spectrum] = &spectra(&text)[..] else { panic!("{text}: not one light") };
            let found = luminous(spectrum);
            // The fit of V(λ) is off by 0.016 at most, a part in 50 of what a line of a fluorescent lamp may hold, and
            // more than that at the end of blue, where V is small.
            let tolerance = if colour.contains("[0, 0, 1]") { 0.06 } else { 0.02 };
            assert!((found / level - 1.0).abs() < tolerance, "{text}: {found} is not {level}");
        }
    }
}

#[test]
fn watts_are_watts_whatever_the_colour() {
    let lamp = |keys: &str| {
        let scene = "[scene]\ngeometry = ['room.obj']\nenvironment = 'none'\n[[lights]]\nposition_m = [0, 2, 0]\npower_w = 0.25\n";
        format!("{scene}{keys}\n")
    };
    let beam = lamp("type = 'gaussian-beam'\ndirection = [0, -1, 0]\nwaist_radius_mm = [1, 1]");
    let projector = lamp("type = 'projector'\nimage = 'slide.png'\nlook_at_m = [0, 0, 0.1]\nhorizontal_fov_deg = 40");
    let infrared = "spectrum = { file = 'led.csv' }";
    let cases = COLOURS.iter().chain([&infrared]).flat_map(|colour| [(&beam, *colour), (&projector, *colour)]);
    for (light, colour) in cases {
        let [spectrum] = &spectra(&format!("{light}{colour}"))[..] else { panic!("{colour}: not one light") };
        // The trapezoidal rule, which is exact between the values; sums of f32: a part in 10⁶.
        let values: Vec<_> = spectrum.iter().collect();
        let watts: f64 = values.windows(2).map(|pair| 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0)).sum();
        assert!((watts / 0.25 - 1.0).abs() < 1e-6, "{colour}: {watts} W");
    }
}

#[test]
fn a_level_that_no_light_of_the_colour_can_have_is_refused() {
    for colour in ["rgb = [0, 0, 0]", "linear_rgb = [0, 0, 0]", "spectrum = 0"] {
        let keys = format!("environment = {{ illuminance_lux = 500, {colour} }}");
        let error = Files::new(&format!("[scene]\ngeometry = ['room.obj']\n{keys}")).read(&[]).expect_err(colour);
        assert!(error.to_string().contains("environment.illuminance_lux: cannot be reached"), "{error}");
    }
}
