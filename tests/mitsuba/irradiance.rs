//! The irradiance behind our lens in a uniform environment against what Mitsuba measures behind a round hole
//! (`irradiance.py`, `irradiance.json`).

use std::ops::ControlFlow;
use std::path::Path;

use glam::DAffine3;
use photosite::film::{FilmResponses, Response};
use photosite::integrator::{RenderJob, RenderSettings, render};
use photosite::optics::{Camera, Focus, Intrinsics, LensDescription, PixelGrid};
use photosite::scene::description::{Colour, EnvironmentDescription, SceneDescription};
use photosite::scene::{Scene, build};
use photosite::spectrum::Spectrum;
use serde::Deserialize;

#[derive(Deserialize)]
struct Stored {
    radiance: f64,
    image_distance: f64,
    measured: Vec<Measurement>,
}

/// One measurement by Mitsuba.
#[derive(Debug, Deserialize)]
struct Measurement {
    /// "hole" or "lamp".
    way: String,
    f_number: f64,
    angle_deg: f64,
    irradiance: f64,
    standard_error: f64,
}

/// An environment of radiance 1 at every wavelength.
fn uniform_sky() -> Scene {
    let colour = Colour::Spectrum(Spectrum::constant(1.0));
    let environment = Some(EnvironmentDescription::Constant { colour, luminance_nit: None });
    build(SceneDescription { environment, ..Default::default() }, &Spectrum::constant(1.0))
}

/// Irradiance on a small pixel at an angle to the axis of a lens of 1 m that is focused at infinity.
fn behind_our_lens(sky: &Scene, f_number: f64, angle_deg: f64) -> f64 {
    let mut lens = LensDescription::thin(1.0, f_number, Focus::Infinity);
    // A pixel of 1 mm, over which cos⁴ varies by a thousandth and evenly.
    let (fx, tangent) = (1e3, angle_deg.to_radians().tan());
    lens.intrinsics = Some(Intrinsics { fx, fy: fx, cx: 0.5 - tangent * fx, cy: 0.5, skew: 0.0 });
    let grid = PixelGrid { resolution: [1, 1], pitch_m: [1e-3; 2] };
    let camera = Camera::new(&lens, &grid, DAffine3::IDENTITY, f64::NAN).expect("a valid lens");
    let band = Spectrum::from_fn(|l| if (400.0..=700.0).contains(&l) { 1.0 } else { 0.0 });
    let responses = [Response::new("E", band.scale(1.0 / band.integral()))];
    let job = RenderJob {
        scene: sky,
        camera: &camera,
        transmittance: &Spectrum::constant(1.0),
        responses: &responses,
        filters: None,
        importance: None,
        resolution: [1, 1],
        settings: &RenderSettings { samples_per_pixel: 1 << 14, ..Default::default() },
        device: None,
    };
    let film = render(&job, FilmResponses::new(&responses), &|_| ControlFlow::Continue(()));
    f64::from(film.estimate(["E"]).mean.channels()[0].data[0])
}

#[test]
fn a_lens_lets_through_what_mitsuba_measures_behind_a_hole() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mitsuba/irradiance.json");
    let text = std::fs::read_to_string(&path).expect("the stored measurements");
    let stored: Stored = serde_json::from_str(&text).expect("what irradiance.py writes");
    assert_eq!((stored.radiance, stored.image_distance), (1.0, 1.0));
    let sky = uniform_sky();
    let (mut stops, mut ways) = (Vec::new(), Vec::new());
    for entry in &stored.measured {
        let ours = behind_our_lens(&sky, entry.f_number, entry.angle_deg);
        assert!((ours / entry.irradiance - 1.0).abs() < 0.005, "{entry:?}: ours is {ours}");
        assert!(entry.standard_error < 0.0025 * entry.irradiance, "{entry:?} is too uncertain to tell");
        stops.push(entry.f_number);
        ways.push(&entry.way[..]);
    }
    // A file that lost its entries would pass unseen.
    let range = [stops.iter().copied().fold(f64::MAX, f64::min), stops.iter().copied().fold(0.0, f64::max)];
    assert!(range == [1.4, 16.0] && ways.contains(&"hole") && ways.contains(&"lamp") && stops.len() == 50, "{stops:?}");
}
