//! Samples of pixels whose paths start and end on the card, against the same samples of the processor.

use std::ops::ControlFlow;

use glam::DVec3;
use photosite_core::spectrum::Spectrum;
use photosite_transport::film::{Film, FilmResponses, Response};
use photosite_transport::integrator::{
    Device, FilterTile, LoadedDevice, RenderJob, RenderSettings, WavelengthChoice, render,
};
use photosite_transport::optics::{Camera, Falloff, Focus, Intrinsics, LensDescription, LensKind, PixelGrid, Stop};
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::Scene;
use photosite_transport::scene::description::look_at;

use crate::scenes::outdoors;

/// Columns and rows, no multiples of a square of pixels that share random numbers.
const RESOLUTION: [u32; 2] = [75, 70];

fn band(from: f64, to: f64) -> Spectrum {
    Spectrum::from_fn(|l| if (from..=to).contains(&l) { 1.0 } else { 0.0 })
}

fn film(scene: &Scene, lens: &LensDescription, settings: &RenderSettings, device: Option<&dyn Device>) -> Film {
    let grid = PixelGrid { resolution: RESOLUTION, pitch_m: [0.012 / 75.0, 0.009 / 70.0] };
    let to_world = look_at(DVec3::new(0.3, 1.6, 3.6), DVec3::new(0.0, 0.7, 0.0), DVec3::Y).expect("a pose");
    let camera = Camera::new(lens, &grid, to_world, f64::NAN).expect("a valid lens");
    // Five channels are two groups of four.
    let edges = [400.0, 470.0, 530.0, 580.0, 640.0, 700.0];
    let responses: Vec<Response> =
        edges.windows(2).map(|ends| Response::new(ends[0].to_string(), band(ends[0], ends[1]))).collect();
    let tile = FilterTile {
        responses: vec![band(400.0, 500.0), band(580.0, 700.0)],
        filters: vec![0, 1, 1, 1, 0, 1],
        width: 3,
    };
    let transmittance = Spectrum::from_fn(|l| 0.4 + 0.0005 * (l - 300.0));
    let loaded = device.map(|device| LoadedDevice::new(device, scene, settings).expect("a scene that cards render"));
    let job = RenderJob {
        scene,
        camera: &camera,
        transmittance: &transmittance,
        responses: &responses,
        filters: Some(&tile),
        importance: None,
        resolution: RESOLUTION,
        settings,
        device: loaded.as_ref(),
    };
    let film = render(&job, FilmResponses::new(&responses), &|_| ControlFlow::Continue(()));
    assert_eq!(loaded.and_then(|loaded| loaded.failure()), None);
    film
}

#[test]
fn samples_of_pixels_are_those_of_the_processor() {
    let Some(card) = crate::card() else { return };
    let scene = outdoors().build();
    let thin = || LensDescription::thin(0.016, 2.8, Focus::Distance(3.0));
    let shifted = LensDescription {
        intrinsics: Some(Intrinsics { fx: 100.0, fy: 140.0, cx: 30.0, cy: 40.0, skew: 5.0 }),
        ..thin()
    };
    let stops = vec![Stop { distance_m: 0.01, radius_m: 0.004 }, Stop { distance_m: -0.01, radius_m: 0.004 }];
    let settings = RenderSettings { samples_per_pixel: 20, max_depth: 2, seed: 7, ..RenderSettings::default() };
    let own = RenderSettings { wavelengths: WavelengthChoice::OwnFilter, ..settings.clone() };
    let independent = RenderSettings { sampler: SamplerKind::Independent, ..settings.clone() };
    for (name, lens, settings) in [
        ("thin lens", thin(), &settings),
        ("independent numbers", thin(), &independent),
        ("wavelengths of each filter", thin(), &own),
        ("pinhole", LensDescription { kind: LensKind::Pinhole, ..thin() }, &settings),
        ("hole", LensDescription { kind: LensKind::Hole, ..thin() }, &settings),
        ("blades", LensDescription { blades: 5, blade_rotation_deg: 10.0, ..thin() }, &settings),
        ("focus at infinity", LensDescription { focus: Focus::Infinity, ..thin() }, &settings),
        ("shifted", shifted, &settings),
        ("stops", LensDescription { stops, ..thin() }, &settings),
        ("no falloff", LensDescription { falloff: Falloff::None, ..thin() }, &settings),
        ("narrow reach", LensDescription { max_angle_rad: Some(0.3), ..thin() }, &settings),
    ] {
        let [of_card, of_processor] =
            [Some(card as &dyn Device), None].map(|device| film(&scene, &lens, settings, device));
        assert_eq!(of_card.counts(), of_processor.counts(), "{name}");
        let names: Vec<&str> = of_card.channels().iter().map(String::as_str).collect();
        let [of_card, of_processor] = [&of_card, &of_processor].map(|film| film.estimate(names.iter().copied()));
        for (what, card, processor) in
            [("mean", &of_card.mean, &of_processor.mean), ("variance", &of_card.variance, &of_processor.variance)]
        {
            let (mut others, mut all) = (0, 0);
            for (card, processor) in card.channels().iter().zip(processor.channels()) {
                let largest = processor.data.iter().fold(0.0f32, |all, value| all.max(*value));
                assert!(largest > 0.0, "{name}: no {what}");
                all += card.data.len();
                let differs = |(a, b): &(&f32, &f32)| (*a - *b).abs() > 1e-4 * b.abs() + 1e-6 * largest;
                others += card.data.iter().zip(&processor.data).filter(differs).count();
            }
            println!("{name}: {what} differs in {others} of {all}");
            // A path in thousands takes another turn where numbers of 32 bits round otherwise, and a pixel has 20 paths.
            assert!(others * 200 <= all, "{name}: {what} differs in {others} of {all}");
        }
    }
}
