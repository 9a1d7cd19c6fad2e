//! Whole images against those of the processor with other random numbers: z-tests.

use std::ops::ControlFlow;

use glam::DVec3;
use photosite_core::image::Estimate;
use photosite_core::spectrum::Spectrum;
use photosite_transport::film::{FilmResponses, Response};
use photosite_transport::integrator::{Device, LoadedDevice, RenderJob, RenderSettings, render};
use photosite_transport::optics::{Camera, Focus, LensDescription, PixelGrid, Recording};
use photosite_transport::scene::Scene;
use photosite_transport::scene::description::look_at;

use crate::scenes::{everything, lamps_behind_panes, layers, moving, outdoors, panes, under_lamps};

const SIDE: u32 = 40;

fn image(scene: &Scene, is_moving: bool, device: Option<&dyn Device>, seed: u64) -> Estimate {
    // Random numbers that know nothing of each other: their variance is exact.
    let sampler = photosite_transport::sampler::SamplerKind::Independent;
    let settings = RenderSettings { samples_per_pixel: 48, max_depth: 6, seed, sampler, ..RenderSettings::default() };
    let lens = LensDescription::thin(0.016, 2.8, Focus::Distance(3.0));
    let grid = PixelGrid { resolution: [SIDE; 2], pitch_m: [0.012 / f64::from(SIDE); 2] };
    let to_world = look_at(DVec3::new(0.3, 1.6, 3.6), DVec3::new(0.0, 0.7, 0.0), DVec3::Y).expect("a pose");
    let camera = Camera::new(&lens, &grid, to_world, f64::NAN).expect("a valid lens");
    // Paths start at times of their own.
    let recording = Recording {
        motion: None,
        start_s: 0.0,
        exposure_s: 1.0,
        row_time_s: 0.0,
        first_row: 0.0,
        duration_s: 1.0,
        frame_interval_s: 1.0,
    };
    let camera = if is_moving { camera.recording(recording) } else { camera };
    let band = |from: f64, to: f64| Spectrum::from_fn(|l| if (from..=to).contains(&l) { 1.0 } else { 0.0 });
    let responses = [Response::new("blue", band(400.0, 500.0)), Response::new("red", band(580.0, 700.0))];
    let clear = Spectrum::constant(1.0);
    let loaded = device.map(|device| LoadedDevice::new(device, scene, &settings).expect("a scene that cards render"));
    let job = RenderJob {
        scene,
        camera: &camera,
        transmittance: &clear,
        responses: &responses,
        filters: None,
        importance: None,
        resolution: [SIDE; 2],
        settings: &settings,
        device: loaded.as_ref(),
    };
    let film = render(&job, FilmResponses::new(&responses), &|_| ControlFlow::Continue(()));
    assert_eq!(loaded.and_then(|loaded| loaded.failure()), None);
    assert_eq!(film.samples(), 48);
    film.estimate(["blue", "red"])
}

/// Mean and root mean square of the differences of pixels over their standard deviations.
fn z(a: &Estimate, b: &Estimate) -> [f64; 2] {
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
    for channel in 0..2 {
        let [means, variances] = [[&a.mean, &b.mean], [&a.variance, &b.variance]]
            .map(|both| both.map(|planes| &planes.channels()[channel].data));
        for i in 0..means[0].len() {
            let variance = f64::from(variances[0][i]) + f64::from(variances[1][i]);
            if variance > 0.0 {
                let z = (f64::from(means[0][i]) - f64::from(means[1][i])) / variance.sqrt();
                (sum, squares, count) = (sum + z, squares + z * z, count + 1.0);
            }
        }
    }
    [sum / f64::sqrt(count), (squares / count).sqrt()]
}

#[test]
fn images_are_those_of_the_processor() {
    let Some(card) = crate::card() else { return };
    for (name, scene) in [
        ("everything", everything()),
        ("layers", layers()),
        ("outdoors", outdoors()),
        ("panes", panes()),
        ("moving", moving()),
        ("lamps", under_lamps()),
        ("lamps behind panes", lamps_behind_panes()),
    ] {
        let (scene, is_moving) = (scene.build(), name == "moving");
        let [of_card, again] = [image(&scene, is_moving, Some(card), 1), image(&scene, is_moving, Some(card), 1)];
        assert!(of_card.mean.channels()[0].data == again.mean.channels()[0].data, "{name}: another time other bytes");
        let [mean, spread] = z(&of_card, &image(&scene, is_moving, None, 2));
        println!("{name}: z of the mean {mean:.2}, spread {spread:.3}");
        // 3200 pixels and channels, whose variances are estimated from 48 samples with long tails; channels of a pixel
        // share paths, so that the mean counts for half as many.
        assert!(mean.abs() < 4.5 * 2f64.sqrt() && (0.85..1.15).contains(&spread), "{name}: {mean}, {spread}");
    }
}
