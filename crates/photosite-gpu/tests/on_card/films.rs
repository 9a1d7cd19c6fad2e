//! Samples of pixels whose paths start and end on the card, against the same samples of the processor.

use std::ops::ControlFlow;

use glam::DVec3;
use photosite_core::Invalid;
use photosite_core::cells::{CellLayout, CellShape, ImageCircle};
use photosite_core::projection::FisheyeProjection;
use photosite_core::spectrum::Spectrum;
use photosite_transport::film::{Film, FilmResponses, Response};
use photosite_transport::geometry::Trajectory;
use photosite_transport::integrator::{
    Arrival, Device, FilterTile, LoadedDevice, PackedFilm, PathLimits, PathStart, PathTracer, PixelTracer, RenderJob,
    RenderSettings, WavelengthChoice, render,
};
use photosite_transport::optics::{
    BrownConrady, Camera, Falloff, Focus, Intrinsics, LensDescription, LensKind, PixelGrid, Projection, Recording, Stop,
};
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::Scene;
use photosite_transport::scene::description::look_at;

use crate::scenes::{moving, outdoors};

/// Columns and rows, no multiples of a square of pixels that share random numbers.
const RESOLUTION: [u32; 2] = [75, 70];

/// A device that traces no paths whose starts the processor has made.
#[derive(Debug)]
struct PixelsAlone<'a>(&'a dyn Device);

impl Device for PixelsAlone<'_> {
    fn name(&self) -> String {
        self.0.name()
    }

    fn load(&self, scene: &Scene, limits: PathLimits, sampler: SamplerKind) -> Result<Box<dyn PathTracer>, Invalid> {
        Ok(Box::new(PixelsOf(self.0.load(scene, limits, sampler)?)))
    }
}

struct PixelsOf(Box<dyn PathTracer>);

impl PathTracer for PixelsOf {
    fn trace(&self, _: &[PathStart], _: &mut Vec<Arrival>) -> Result<(), String> {
        Err("the processor has started these paths".to_owned())
    }

    fn batch_size(&self) -> usize {
        self.0.batch_size()
    }

    fn rays(&self) -> [u64; 2] {
        self.0.rays()
    }

    fn pixels<'a>(&'a self, film: &PackedFilm<'_>) -> Result<Option<Box<dyn PixelTracer + 'a>>, String> {
        self.0.pixels(film)
    }
}

fn band(from: f64, to: f64) -> Spectrum {
    Spectrum::from_fn(|l| if (from..=to).contains(&l) { 1.0 } else { 0.0 })
}

fn camera(lens: &LensDescription) -> Camera {
    let grid = PixelGrid { resolution: RESOLUTION, pitch_m: [0.012 / 75.0, 0.009 / 70.0] };
    let to_world = look_at(DVec3::new(0.3, 1.6, 3.6), DVec3::new(0.0, 0.7, 0.0), DVec3::Y).expect("a pose");
    Camera::new(lens, &grid, to_world, f64::NAN).expect("a valid lens")
}

fn film(scene: &Scene, camera: &Camera, settings: &RenderSettings, device: Option<&dyn Device>) -> Film {
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
        camera,
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

/// Compares films of the card and of the processor, of whose means and variances one in `one_in` may differ.
fn compare(name: &str, scene: &Scene, camera: &Camera, settings: &RenderSettings, one_in: usize) {
    let Some(card) = crate::card() else { return };
    let card = PixelsAlone(card);
    let devices: [Option<&dyn Device>; 2] = [Some(&card), None];
    let [of_card, of_processor] = devices.map(|device| film(scene, camera, settings, device));
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
            let differs = |(a, b): &(&f32, &f32)| (*a - *b).abs() > 1e-3 * b.abs() + 1e-5 * largest;
            others += card.data.iter().zip(&processor.data).filter(differs).count();
        }
        println!("{name}: {what} differs in {others} of {all}");
        assert!(others * one_in <= all, "{name}: {what} differs in {others} of {all}");
    }
}

fn thin() -> LensDescription {
    LensDescription::thin(0.016, 2.8, Focus::Distance(3.0))
}

fn settings() -> RenderSettings {
    RenderSettings { samples_per_pixel: 6, max_depth: 2, seed: 7, ..RenderSettings::default() }
}

#[test]
fn samples_of_pixels_are_those_of_the_processor() {
    let scene = outdoors().build();
    let intrinsics = Some(Intrinsics { fx: 100.0, fy: 140.0, cx: 30.0, cy: 40.0, skew: 5.0 });
    let stops = vec![Stop { distance_m: 0.01, radius_m: 0.004 }, Stop { distance_m: -0.01, radius_m: 0.004 }];
    let bent = BrownConrady { k: [-0.2, 0.05, 0.0, 0.0, 0.0, 0.0], p: [0.01, -0.005], s: [0.0; 4] };
    let fisheye = |projection| LensDescription { projection, focal_length_m: 0.012, ..thin() };
    let kannala_brandt = Projection::KannalaBrandt { k: [0.05, -0.01, 0.0, 0.0] };
    let omnidirectional = Projection::Omnidirectional { xi: 0.9, distortion: BrownConrady::default() };
    let own = RenderSettings { wavelengths: WavelengthChoice::OwnFilter, ..settings() };
    let independent = RenderSettings { sampler: SamplerKind::Independent, ..settings() };
    for (name, lens, settings) in [
        // More samples than one run has.
        ("thin lens", thin(), RenderSettings { samples_per_pixel: 20, ..settings() }),
        ("independent numbers", thin(), independent),
        ("wavelengths of each filter", thin(), own),
        ("pinhole", LensDescription { kind: LensKind::Pinhole, ..thin() }, settings()),
        ("hole", LensDescription { kind: LensKind::Hole, ..thin() }, settings()),
        ("blades", LensDescription { blades: 5, blade_rotation_deg: 10.0, ..thin() }, settings()),
        ("focus at infinity", LensDescription { focus: Focus::Infinity, ..thin() }, settings()),
        ("shifted", LensDescription { intrinsics, ..thin() }, settings()),
        ("stops", LensDescription { stops: stops.clone(), ..thin() }, settings()),
        ("no falloff", LensDescription { falloff: Falloff::None, ..thin() }, settings()),
        ("narrow reach", LensDescription { max_angle_rad: Some(0.3), ..thin() }, settings()),
        (
            "distortion",
            LensDescription { projection: Projection::BrownConrady(bent), intrinsics, ..thin() },
            settings(),
        ),
        (
            "division",
            LensDescription { projection: Projection::Division { lambda: -0.1 }, stops, ..thin() },
            settings(),
        ),
        ("fisheye", fisheye(kannala_brandt), settings()),
        ("narrow fisheye", LensDescription { max_angle_rad: Some(0.6), ..fisheye(kannala_brandt) }, settings()),
        ("equisolid", fisheye(Projection::ClassicalFisheye(FisheyeProjection::Equisolid)), settings()),
        ("mirror", fisheye(omnidirectional), settings()),
    ] {
        // A path in thousands takes another turn where numbers of 32 bits round otherwise, and a pixel has at most 20.
        compare(name, &scene, &camera(&lens), &settings, 200);
    }
    let circle = ImageCircle::new(0.008, RESOLUTION.map(|n| n as usize), [0.012 / 75.0, 0.009 / 70.0]);
    let cells = CellLayout { shape: CellShape::Rectangular, image_circle: Some(circle) };
    compare("image circle", &scene, &camera(&thin()).with_cells(cells), &settings(), 200);
}

#[test]
fn samples_of_pixels_have_the_times_of_their_rows() {
    let recording = Recording {
        motion: None,
        start_s: 3.0,
        exposure_s: 0.2,
        row_time_s: 0.02,
        first_row: 35.0,
        duration_s: 0.9,
        frame_interval_s: 1.0,
    };
    // Poses are of single precision: 12 of 16,384 paths came out otherwise, and a pixel has 6.
    compare("rolling shutter", &moving().build(), &camera(&thin()).recording(recording.clone()), &settings(), 80);
    let motion = Some(Trajectory::Steady {
        velocity_m_per_s: DVec3::new(0.5, 0.1, -0.3),
        angular_velocity_rad_per_s: DVec3::new(0.02, 0.3, 0.1),
    });
    let moves = camera(&thin()).recording(Recording { motion, ..recording.clone() });
    compare("a camera that moves", &moving().build(), &moves, &settings(), 80);
    // A still of one moment.
    let still = camera(&thin()).recording(Recording {
        duration_s: 1.0,
        exposure_s: 0.2,
        motion: None,
        start_s: 0.0,
        row_time_s: 0.01,
        first_row: 0.0,
        frame_interval_s: 1.0,
    });
    compare("a moment", &moving().build(), &still.at_row(40.0), &settings(), 80);
}

/// Parts have passes of their own, which cut samples into other runs: what they sum to is the same, bit for bit.
#[test]
fn parts_of_a_film_are_the_whole() {
    let Some(card) = crate::card() else { return };
    let (scene, camera, card) = (outdoors().build(), camera(&thin()), PixelsAlone(card));
    let of = |part| film(&scene, &camera, &RenderSettings { samples_per_pixel: 21, part, ..settings() }, Some(&card));
    let whole = of(None);
    let mut parts = of(Some(0..5));
    let rest = of(Some(5..21));
    parts.add(rest.sums().iter().copied(), rest.counts().iter().copied());
    assert_eq!(parts.counts(), whole.counts());
    assert!(parts.sums() == whole.sums());
}
