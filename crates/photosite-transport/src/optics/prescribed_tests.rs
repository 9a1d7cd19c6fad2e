//! Cameras whose lens is traced: a Cooke triplet of 50 mm and f/5 (Optiland's sample, MIT licence).

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use super::*;
use photosite_core::spectrum::{Dispersion, Wavelengths};
use photosite_lens::Lens;
use photosite_lens::prescription::{Glass, Prescription, Surface};
use photosite_lens::profile::Travel;
use photosite_lens::trace::{Apertures, Step};

/// Sensor of 36 × 24 mm.
const GRID: PixelGrid = PixelGrid { resolution: [900, 600], pitch_m: [40e-6, 40e-6] };

fn triplet() -> Prescription {
    let sellmeier = |name: &str, b: [f64; 3], c_um2: [f64; 3]| Glass {
        name: name.to_owned(),
        source: "Schott".to_owned(),
        dispersion: Dispersion::Sellmeier { b: b.to_vec(), c_um2: c_um2.to_vec() },
        range_nm: None,
    };
    let sk16 = || {
        let (b, c) = ([1.34317774, 0.241144399, 0.994317969], [0.00704687339, 0.0229005, 92.7508526]);
        Some(sellmeier("N-SK16", b, c))
    };
    let f2 = || {
        let (b, c) = ([1.34533359, 0.209073176, 0.937357162], [0.00997743871, 0.0470450767, 111.886764]);
        Some(sellmeier("F2", b, c))
    };
    let surface = |radius_mm: f64, thickness_mm, glass, semi_aperture_mm| Surface {
        radius_mm: Some(radius_mm),
        thickness_mm,
        glass,
        semi_aperture_mm: Some(semi_aperture_mm),
        ..Surface::default()
    };
    Prescription {
        surfaces: vec![
            surface(22.01359, 3.25896, sk16(), 7.762),
            surface(-435.76044, 6.00755, None, 7.23),
            surface(-22.21328, 0.99997, f2(), 4.18),
            Surface { is_stop: true, ..surface(20.29192, 4.75041, None, 3.80456) },
            surface(79.6836, 2.95208, sk16(), 5.863),
            surface(-18.39533, 42.20778, None, 6.236),
        ],
        ..Prescription::default()
    }
}

fn described(f_number: f64, focus: Focus) -> LensDescription {
    let focal_length_m = Lens::new(&triplet()).expect("a lens").at(587.5618).first_order().efl_mm * 1e-3;
    LensDescription {
        kind: LensKind::Prescription,
        prescription: Some(Arc::new(triplet())),
        ..LensDescription::thin(focal_length_m, f_number, focus)
    }
}

fn camera(f_number: f64, focus: Focus) -> Camera {
    Camera::new(&described(f_number, focus), &GRID, DAffine3::IDENTITY, f64::NAN).expect("a lens")
}

/// Weights of drawn rays against a regular grid over all directions to the last surface, traced and attenuated surface by
/// surface: in uniform light both are the irradiance over the radiance.
#[test]
fn uniform_light_gives_the_projected_solid_angle_less_the_losses_of_the_surfaces() {
    for f_number in [5.0, 8.0, 16.0] {
        let camera = camera(f_number, Focus::ImageDistance(0.04220778));
        let lens = Lens::new(&triplet()).expect("a lens");
        let lens = lens.with_stop_radius(lens.at(587.5618).stop_radius_of_f_number(f_number));
        for pixel in [DVec2::new(450.0, 300.0), DVec2::new(600.0, 250.0), DVec2::new(10.0, 590.0)] {
            for nm in [450.0, 640.0] {
                let point = DVec2::new((450.0 - pixel.x) * 0.04, (pixel.y - 300.0) * 0.04);
                let n = 128;
                let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
                let (mut sum, mut squares) = (0.0, 0.0);
                for i in 0..n * n {
                    let sample = CameraSample {
                        pixel,
                        aperture: [at(i % n) as f32, at(i / n) as f32],
                        time: 0.0,
                        spread: [0.0; 2],
                    };
                    let mut wavelengths = Wavelengths::new([nm as f32; 4], [1.0; 4]);
                    let weight = camera
                        .generate_spectral(&sample, &mut wavelengths)
                        .map_or(0.0, |(ray, _)| f64::from(ray.weight));
                    sum += weight;
                    squares += weight * weight;
                }
                let count = f64::from(n * n);
                let (mean, square) = (sum / count, squares / count);
                let sigma = ((square - mean * mean) / count).sqrt();
                let expected = irradiance(&lens, point, nm);
                // The drawn grid is finer than chance; that of the reference leaves its rim, 4·600 cells of 600²·π/4.
                let bound = 3.0 * sigma + 5e-4 * expected;
                assert!((mean - expected).abs() < bound, "f/{f_number} {pixel} {nm} nm: {mean} {expected} ± {bound}");
            }
        }
    }
}

/// ∬ T dp dq by the midpoint rule over the directions to the last surface.
fn irradiance(lens: &Lens, point: DVec2, nm: f64) -> f64 {
    let at = lens.at(nm);
    let n = 600;
    let (half, middle) = (0.15, -point / 42.2 * 0.9);
    let place = |i: i32| half * (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0);
    let cell = (2.0 * half / f64::from(n)).powi(2);
    let through = |i: i32| {
        let cosines = middle + DVec2::new(place(i % n), place(i / n));
        let ray = at.ray_from_sensor(point, cosines);
        let (mut passed, steps) = (1.0, (0..6).rev().map(Step::refract));
        let whole = at
            .trace(ray, Travel::ToScene, steps, Apertures::Clip, |hit| passed *= at.split_at(hit).mean_transmittance());
        if whole.is_ok() { passed * cell } else { 0.0 }
    };
    (0..n * n).map(through).sum()
}

#[test]
fn places_and_what_they_see_agree_at_all_distances() {
    let camera = camera(8.0, Focus::Distance(2.0));
    for pixel in [DVec2::new(450.0, 300.0), DVec2::new(455.3, 300.2), DVec2::new(3.0, 4.0), DVec2::new(880.0, 300.0)] {
        let ray = camera.chief_ray(pixel).expect("seen");
        for t in [0.2_f32, 1.0, 30.0, 1000.0] {
            let back = camera.project(ray.at(t)).expect("seen");
            // f32 rays.
            assert!(back.distance(pixel) < 0.02, "{pixel} at {t} m: {back}");
            // The parameter counts along the axis from the entrance pupil.
            assert!((ray.at(t).z + t).abs() < 1e-5 * t, "{} {t}", ray.at(t).z);
        }
        let seen = camera.seen(pixel).expect("seen");
        assert!(seen.direction.as_vec3().distance(ray.direction.normalize()) < 1e-6);
    }
    let top_right = camera.chief_ray(DVec2::new(800.0, 20.0)).expect("seen").direction;
    assert!(top_right.x > 0.0 && top_right.y > 0.0 && top_right.z < 0.0, "{top_right}");
    // Near the axis a pixel is as large as by the pinhole matrix.
    let place = camera.project_camera(DVec3::new(0.01, 0.0, -2.0)).expect("seen");
    assert!((place.x - 450.0 - camera.intrinsics().fx * 0.005).abs() < 1e-3, "{place}");
}

/// Rays of a pixel come together at the distance, which counts from the sensor, and nowhere else; the whole beam is as
/// wide there as its aberrations leave it, 24 µm of spot on the sensor by Optiland at f/5.
#[test]
fn rays_of_a_pixel_meet_where_the_lens_is_focused() {
    let camera = camera(5.6, Focus::Distance(2.0));
    // The focus of the whole lens leaves the pupil where it is from the first vertex.
    let lens = Lens::new(&triplet()).expect("a lens");
    let to_last_mm = triplet().surfaces[..5].iter().map(|surface| surface.thickness_mm).sum::<f64>();
    let pupil_to_last_mm = to_last_mm - lens.at(587.5618).first_order().entrance_pupil_mm;
    let to_sensor = camera.image_distance_m() + pupil_to_last_mm * 1e-3;
    assert!((camera.focus_distance_m() - (2.0 - to_sensor)).abs() < 1e-9, "{} {to_sensor}", camera.focus_distance_m());
    let width_at = |z: f64| {
        let crossing = |i: u32| {
            let sample = [(i % 16) as f32 / 16.0, (i / 16) as f32 / 16.0];
            let ray = camera.generate(DVec2::new(450.0, 300.0), sample)?.ray;
            let at = ray.at(((-z - f64::from(ray.origin.z)) / f64::from(ray.direction.z)) as f32);
            Some(f64::from(at.x).hypot(at.y.into()))
        };
        let all: Vec<f64> = (0..256).filter_map(crossing).collect();
        assert!(all.len() > 200);
        (all.iter().map(|r| r * r).sum::<f64>() / all.len() as f64).sqrt()
    };
    let u = camera.focus_distance_m();
    let [before, there, behind] = [0.9 * u, u, 1.1 * u].map(width_at);
    // 25 µm on the sensor are 1 mm at 2 m; the beam of 9 mm is 10 % of it wide at 10 % before and behind.
    assert!(there < 0.4e-3 && before > 2.0 * there && behind > 2.0 * there, "{before} {there} {behind}");
}

#[test]
fn the_image_gets_darker_outwards_as_the_apertures_say() {
    let camera = camera(5.0, Focus::Infinity);
    let at = |x: f64| camera.relative_illumination(DVec2::new(x, 300.0)).expect("light");
    assert!((at(450.0) - 1.0).abs() < 1e-12);
    assert!(at(600.0) < 1.0 && at(880.0) < at(600.0) && at(880.0) > 0.2);
    assert!(camera.on_axis_sr() > 0.02 && camera.entrance_pupil_m().is_some_and(|d| (d - 0.01).abs() < 1e-4));
    assert!((camera.working_f_number().expect("a lens") - 5.0).abs() < 0.1);
}

#[test]
fn what_the_glass_decides_and_what_it_cannot_be_is_refused() {
    let refused = |change: &dyn Fn(&mut LensDescription)| {
        let mut lens = described(8.0, Focus::Infinity);
        change(&mut lens);
        Camera::new(&lens, &GRID, DAffine3::IDENTITY, f64::NAN).expect_err("refused").to_string()
    };
    let distorted = Projection::BrownConrady(BrownConrady::default());
    let pixels = Intrinsics { fx: 1.0, fy: 1.0, cx: 0.0, cy: 0.0, skew: 0.0 };
    type Change<'a> = (&'a dyn Fn(&mut LensDescription), &'a str);
    let changes: [Change<'_>; 9] = [
        (&|l| l.f_number = 4.0, "f_number: the lens opens to f/5.0"),
        (&|l| l.focus = Focus::Distance(0.09), "focus_distance_m: the lens cannot be focused at 90"),
        (&|l| l.focal_length_m = 0.06, "focal_length_mm: the lens has one focal length"),
        (&|l| l.prescription = None, "prescription: is missing"),
        (&|l| l.projection = distorted, "distortion: cannot be combined with lens.prescription"),
        (&|l| l.intrinsics = Some(pixels), "intrinsics: cannot be combined with lens.prescription"),
        (&|l| l.falloff = Falloff::None, "falloff: cannot be combined with lens.prescription"),
        (&|l| l.point_spread = Some(PointSpread::Airy), "psf: cannot be combined with lens.prescription"),
        (&|l| l.max_angle_rad = Some(0.3), "max_angle_deg: cannot be combined with lens.prescription"),
    ];
    for (change, start) in changes {
        let error = refused(change);
        assert!(error.starts_with(start), "{error}");
    }
    let wave = described(8.0, Focus::Infinity);
    let wave = LensDescription { point_spread: Some(PointSpread::Wave), ..wave };
    assert_eq!(wave.validate(), Ok(()));
    let error = LensDescription { kind: LensKind::Thin, prescription: None, ..wave }.validate().expect_err("refused");
    assert!(error.to_string().starts_with("psf: a point spreads by the wave fronts of a prescription"), "{error}");
    let mut no_stop = triplet();
    no_stop.surfaces[3].is_stop = false;
    let error = refused(&|l| l.prescription = Some(Arc::new(no_stop.clone())));
    assert!(error.starts_with("prescription.surfaces: none of the 6 surfaces is the stop"), "{error}");
}
