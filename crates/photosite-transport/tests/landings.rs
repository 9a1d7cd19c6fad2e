//! Paths of four wavelengths that part in the lens, against paths of one: the same image with less noise.

use std::ops::ControlFlow;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use photosite_core::spectrum::{Dispersion, Spectrum};
use photosite_lens::prescription::{Glass, Surface};
use photosite_lens::{Lens, Prescription};
use photosite_transport::bsdf::Dielectric;
use photosite_transport::film::{Film, FilmResponses, Response};
use photosite_transport::geometry::Trajectory;
use photosite_transport::integrator::{COARSE_STEP, RenderJob, RenderSettings, Step, render, render_coarse, render_on};
use photosite_transport::optics::{Camera, Focus, LensDescription, LensKind, PixelGrid, Recording};
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::description::{
    Colour, Diffuse, EmissionDescription, EnvironmentDescription, InstanceDescription, MaterialDescription,
    MaterialModel, MeshDescription, Roughness, SceneDescription, TexturedColour,
};
use photosite_transport::scene::{Scene, build};

const GRID: PixelGrid = PixelGrid { resolution: [40, 28], pitch_m: [80e-6, 80e-6] };
const D_NM: f64 = 587.5618;
/// Bands of wavelengths, nm.
const BANDS: [[f64; 2]; 3] = [[420.0, 480.0], [520.0, 580.0], [620.0, 680.0]];

/// A lens of one piece of heavy flint, 50 mm and f/5: between blue and red its focus moves by 3 mm, which is 8 pixels of
/// blur, and its image grows.
fn singlet() -> LensDescription {
    let sf11 = Glass {
        name: "SF11".to_owned(),
        source: "Schott".to_owned(),
        dispersion: Dispersion::Sellmeier {
            b: vec![1.737_596_95, 0.313_747_346, 1.898_781_01],
            c_um2: vec![0.013_188_707, 0.062_306_814_2, 155.236_29],
        },
        range_nm: None,
    };
    let surface = |radius_mm, thickness_mm, glass, semi_aperture_mm| Surface {
        radius_mm,
        thickness_mm,
        glass,
        semi_aperture_mm: Some(semi_aperture_mm),
        ..Surface::default()
    };
    let surfaces = vec![
        surface(Some(78.5), 3.0, Some(sf11), 5.2),
        surface(Some(-78.5), 4.0, None, 5.2),
        Surface { is_stop: true, ..surface(None, 45.0, None, 4.5) },
    ];
    let prescription = Prescription { surfaces, ..Prescription::default() };
    let efl_mm = Lens::new(&prescription).expect("a lens").at(D_NM).first_order().efl_mm;
    LensDescription {
        kind: LensKind::Prescription,
        prescription: Some(Arc::new(prescription)),
        ..LensDescription::thin(efl_mm * 1e-3, 6.0, Focus::Distance(1.0))
    }
}

/// Bright squares before a dim sky, up to the edge of the image.
fn scene() -> Scene {
    let flat = |value: f32| Colour::Spectrum(Spectrum::constant(value));
    let mut scene = SceneDescription {
        environment: Some(EnvironmentDescription::Constant { colour: flat(0.1), luminance_nit: None }),
        ..SceneDescription::default()
    };
    for (i, (x, y, half, radiance)) in
        [(-0.01, 0.0, 0.008, 5.0), (0.02, 0.012, 0.006, 3.0), (0.03, -0.02, 0.01, 2.0)].into_iter().enumerate()
    {
        let emission = EmissionDescription { colour: flat(radiance), level: None, texture: None };
        let black = MaterialModel::Diffuse(Diffuse { reflectance: TexturedColour::plain(flat(0.0)) });
        let material =
            MaterialDescription { emission: Some(emission), ..MaterialDescription::new(format!("{i}"), black) };
        scene.materials.push(material);
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let mesh = MeshDescription {
            positions: corners.map(|[a, b]: [f32; 2]| Vec3::new(x + half * a, y + half * b, -0.95)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: i,
            ..MeshDescription::default()
        };
        scene.meshes.push(mesh.into());
        scene.instances.push(InstanceDescription::of_mesh(format!("{i}"), i, DAffine3::IDENTITY));
    }
    // Out of sight: a branch that it sent on alone would lose its wavelengths.
    let index = Dispersion::Cauchy { a: 1.5, b_um2: 0.01, c_um4: 0.0 };
    let glass =
        MaterialModel::Dielectric(Dielectric { index, distribution: Roughness::SMOOTH, energy_compensation: false });
    scene.meshes.push(
        MeshDescription {
            positions: vec![Vec3::new(0.0, 0.0, 9.0), Vec3::new(1.0, 0.0, 9.0), Vec3::new(0.0, 1.0, 9.0)],
            triangles: vec![[0, 1, 2]],
            material: scene.materials.len(),
            ..MeshDescription::default()
        }
        .into(),
    );
    scene.materials.push(MaterialDescription::new("glass", glass));
    scene.instances.push(InstanceDescription::of_mesh("glass", scene.meshes.len() - 1, DAffine3::IDENTITY));
    build(scene, &Spectrum::constant(1.0))
}

fn responses() -> Vec<Response> {
    let band = |[low, high]: [f64; 2]| {
        let spectrum = Spectrum::from_fn(move |l| if (low..=high).contains(&l) { 1.0 } else { 0.0 });
        Response::new(format!("{low}"), spectrum)
    };
    BANDS.into_iter().map(band).collect()
}

fn settings(samples_per_pixel: u32, seed: u64, sampler: SamplerKind) -> RenderSettings {
    RenderSettings { samples_per_pixel, seed, sampler, ..RenderSettings::default() }
}

/// The film of a render, or of some rows of it.
fn film(scene: &Scene, camera: &Camera, settings: &RenderSettings, rows: Option<std::ops::Range<usize>>) -> Film {
    let go_on = |_: Step<'_>| ControlFlow::Continue(());
    with_job(scene, camera, settings, |job, of_film| match rows {
        None => render(job, of_film, &go_on),
        Some(rows) => {
            let mut film = Film::of_rows(GRID.resolution[0] as usize, rows, of_film);
            render_on(job, &mut film, &go_on);
            film
        }
    })
}

fn with_job<T>(
    scene: &Scene,
    camera: &Camera,
    settings: &RenderSettings,
    run: impl FnOnce(&RenderJob<'_>, FilmResponses) -> T,
) -> T {
    let (responses, clear) = (responses(), Spectrum::constant(1.0));
    let job = RenderJob {
        scene,
        camera,
        transmittance: &clear,
        responses: &responses,
        filters: None,
        importance: None,
        resolution: GRID.resolution,
        settings,
        device: None,
    };
    run(&job, FilmResponses::new(&responses))
}

fn camera() -> Camera {
    Camera::new(&singlet(), &GRID, DAffine3::IDENTITY, f64::NAN).expect("a lens")
}

/// Settings with which paths carry the hero alone, since they split and the scene disperses. Nothing in sight reflects,
/// so that none does split.
fn hero_alone(settings: &RenderSettings) -> RenderSettings {
    RenderSettings { splitting: Some(2), ..settings.clone() }
}

/// Images of which each row takes its own time while the camera flies by: from one to the next the scene moves on by
/// 1.2 pixels at 1 m, and light of one path lands in rows that lie up to 8 of them apart.
fn moving(row_time_s: f64, exposure_s: f64) -> Camera {
    let velocity_m_per_s = DVec3::new(0.2, 0.05, 0.0);
    camera().recording(Recording {
        motion: Some(Trajectory::Steady { velocity_m_per_s, angular_velocity_rad_per_s: DVec3::ZERO }),
        start_s: -0.5 * (row_time_s * f64::from(GRID.resolution[1]) + exposure_s),
        exposure_s,
        row_time_s,
        first_row: 0.0,
        duration_s: row_time_s * f64::from(GRID.resolution[1] - 1) + exposure_s,
        frame_interval_s: 1.0,
    })
}

#[test]
fn four_landings_give_the_image_of_the_hero_alone_with_less_noise() {
    check_against_hero_alone(&camera(), 0.4);
}

#[test]
fn so_they_do_where_all_rows_see_a_scene_that_moves_at_the_same_times() {
    check_against_hero_alone(&moving(0.0, 0.05), 0.4);
}

/// Light that lands in a row that is not exposed when its path started is not seen there.
#[test]
fn so_they_do_where_each_row_has_times_of_its_own() {
    check_against_hero_alone(&moving(0.01, 0.025), 0.8);
    // Neighbours are never exposed at the same time.
    check_against_hero_alone(&moving(0.01, 0.008), 0.95);
}

fn check_against_hero_alone(camera: &Camera, most_noise: f64) {
    let scene = scene();
    let of = |settings: &RenderSettings| film(&scene, camera, settings, None);
    let four = of(&settings(256, 1, SamplerKind::Independent));
    let one = of(&hero_alone(&settings(1024, 2, SamplerKind::Independent)));
    for (channel, [low, _]) in BANDS.into_iter().enumerate() {
        let pixels = 0..four.counts().len();
        let of = |film: &Film| -> Vec<(f64, f64)> {
            let means = film.means(channel, pixels.clone());
            means.zip(film.variances(channel, pixels.clone())).map(|(m, v)| (m.into(), v.into())).collect()
        };
        let (four, one) = (of(&four), of(&one));
        let z = |i: usize| (four[i].0 - one[i].0) / (four[i].1 + one[i].1).sqrt();
        let count = pixels.len() as f64;
        let mean_z = pixels.clone().map(z).sum::<f64>() / count;
        let mean_square = pixels.clone().map(|i| z(i).powi(2)).sum::<f64>() / count;
        // 1120 z-scores: their mean has a σ of 0.03, that of their squares of 0.042; landings of neighbouring pixels come
        // along the same paths, up to 64 of them, which makes the former 0.24 at most.
        assert!(mean_z.abs() < 4.0 * 0.24, "{low} nm: {mean_z}");
        assert!((mean_square - 1.0).abs() < 0.25, "{low} nm: {mean_square}");
        assert!(pixels.clone().all(|i| z(i).abs() < 5.5), "{low} nm");
        // A sample of one wavelength meets the band with probability 1/5 or so, one of four nearly always.
        let noise = |of: &[(f64, f64)], samples: f64| of.iter().map(|(_, v)| v * samples).sum::<f64>();
        let ratio = noise(&four, 256.0) / noise(&one, 1024.0);
        assert!(ratio < most_noise, "{low} nm: {ratio}");
    }
}

#[test]
fn landings_do_not_depend_on_strips_parts_and_threads() {
    let scene = scene();
    let camera = camera();
    let settings = settings(6, 1, SamplerKind::Sobol);
    let whole = film(&scene, &camera, &settings, None);
    let (width, channels) = (GRID.resolution[0] as usize, BANDS.len());
    for rows in [0..9, 9..10, 10..28] {
        let strip = film(&scene, &camera, &settings, Some(rows.clone()));
        assert!(strip.sums() == &whole.sums()[rows.start * width * channels..rows.end * width * channels], "{rows:?}");
    }
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    assert!(one_thread.install(|| film(&scene, &camera, &settings, None)).sums() == whole.sums());
    let part = |samples| film(&scene, &camera, &RenderSettings { part: Some(samples), ..settings.clone() }, None);
    let (mut sum, second) = (part(0..2), part(2..6));
    sum.add(second.sums().iter().copied(), second.counts().iter().copied());
    assert!(sum.sums() == whole.sums() && sum.counts() == whole.counts());
}

/// Coarse images of renders that land wavelengths apart or follow light from emitters.
#[test]
fn coarse_images_are_of_the_same_light_and_leave_none_of_it() {
    let scene = scene();
    let (camera, width) = (camera(), GRID.resolution[0] as usize);
    for light_paths in [None, Some(1.0)] {
        let of = |samples, seed| RenderSettings { light_paths, ..settings(samples, seed, SamplerKind::Independent) };
        let full = film(&scene, &camera, &of(256, 1), None);
        let seeds = 100;
        let mut coarse = Film::new(width, GRID.resolution[1] as usize, FilmResponses::new(&responses()));
        for seed in 2..2 + seeds {
            let sum = std::sync::Mutex::new(&mut coarse);
            let step = |step: Step<'_>| {
                let Step::Coarse { film } = step else { return ControlFlow::Continue(()) };
                let mut sum = sum.lock().expect("nobody panics");
                sum.add(film.sums().iter().copied(), film.counts().iter().copied());
                ControlFlow::Continue(())
            };
            with_job(&scene, &camera, &of(4, seed), |job, of_film| {
                let mut film = job.empty_film(of_film);
                render_coarse(job, &mut film, &step);
                let empty = job.empty_film(FilmResponses::new(&responses()));
                assert!(film.sums() == empty.sums() && film.counts() == empty.counts());
            });
        }
        for (pixel, &count) in coarse.counts().iter().enumerate() {
            let is_seen = pixel % width % COARSE_STEP == 0 && pixel / width % COARSE_STEP == 0;
            assert_eq!(count, if is_seen { 4 * seeds as u32 } else { 0 }, "{pixel}");
            for channel in (0..BANDS.len()).filter(|_| is_seen) {
                let of = |film: &Film| {
                    let mean = film.means(channel, pixel..pixel + 1).next().expect("a pixel");
                    (f64::from(mean), f64::from(film.variances(channel, pixel..pixel + 1).next().expect("a pixel")))
                };
                let (coarse, full) = (of(&coarse), of(&full));
                let z = (coarse.0 - full.0) / (coarse.1 + full.1).sqrt();
                // 60 of them in each case.
                assert!(z.abs() < 4.5, "{light_paths:?}, pixel {pixel}, channel {channel}: {z}");
            }
        }
    }
}
