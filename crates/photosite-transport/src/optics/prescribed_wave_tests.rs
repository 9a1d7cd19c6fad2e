//! Cameras whose lens spreads points as waves are: a double Gauss of 100 mm and f/2.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use super::*;
use photosite_core::spectrum::Wavelengths;
use photosite_lens::files;

/// Sensor of 36 × 24 mm.
const GRID: PixelGrid = PixelGrid { resolution: [3600, 2400], pitch_m: [10e-6, 10e-6] };
const NM: f32 = 550.0;

fn described(f_number: f64, focus: Focus, is_wave: bool) -> LensDescription {
    let reading = files::shipped("double-gauss").expect("ships");
    let focal_length_m = reading.lens.at(587.5618).first_order().efl_mm * 1e-3;
    LensDescription {
        kind: LensKind::Prescription,
        prescription: Some(Arc::new(reading.prescription)),
        focus_spectrum: vec![(f64::from(NM), 1.0)],
        point_spread: is_wave.then_some(PointSpread::Wave),
        ..LensDescription::thin(focal_length_m, f_number, focus)
    }
}

fn camera(f_number: f64, focus: Focus, is_wave: bool) -> Camera {
    Camera::new(&described(f_number, focus, is_wave), &GRID, DAffine3::IDENTITY, f64::NAN).expect("a lens")
}

/// Rays of a pixel position by a Sobol-like grid over the pupil, with the point spread by golden ratios.
fn rays(camera: &Camera, pixel: DVec2, side: u32) -> Vec<Option<CameraRay>> {
    let at = |i: u32| (i as f32 + 0.5) / side as f32;
    let ray = |i: u32| {
        let spread = [0.754_877_67, 0.569_840_3].map(|step: f64| (f64::from(i) * step).fract() as f32);
        let sample = CameraSample { pixel, aperture: [at(i % side), at(i / side)], time: 0.0, spread };
        camera.generate_spectral(&sample, &mut Wavelengths::new([NM; 4], [1.0; 4])).map(|(ray, _)| ray)
    };
    (0..side * side).map(ray).collect()
}

/// The paths of samples that come out of the lens, of light of one wavelength four times over, with where each lands.
fn land(
    camera: &Camera,
    samples: &[CameraSample],
    rays: &mut LensRays,
    mut take: impl FnMut(&CameraSample, LandingRay),
) {
    let wavelengths = vec![Wavelengths::new([NM; 4], [1.0; 4]); samples.len()];
    let starts = |_: usize, _: [u32; 2]| true;
    camera.land_each(samples, &wavelengths, rays, 48, starts, |i, ray| {
        if let Some(ray) = ray {
            take(&samples[i], ray);
        }
    });
}

/// Position of a ray at a distance along the axis.
fn at_distance(ray: &CameraRay, distance: f64) -> DVec3 {
    let (origin, direction) = (ray.ray.origin.as_dvec3(), ray.ray.direction.as_dvec3());
    origin + direction * ((-distance - origin.z) / direction.z)
}

/// Frames of a data set and moves of a view place a camera anew.
#[test]
fn cameras_of_one_lens_share_its_images_of_points_wherever_they_stand() {
    let placed = |f_number: f64, focus: f64, x: f64| {
        let to_world = DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
        let lens = described(f_number, Focus::Distance(focus), true);
        Camera::new(&lens, &GRID, to_world, f64::NAN).expect("a lens")
    };
    let first = placed(4.0, 1.7, 0.0);
    assert!(first.shares_images_of_points(&placed(4.0, 1.7, 3.0)));
    assert!(!first.shares_images_of_points(&placed(4.0, 1.8, 0.0)));
    assert!(!first.shares_images_of_points(&placed(5.6, 1.7, 0.0)));
}

#[test]
fn uniform_light_gives_the_irradiance_of_the_rays_of_the_glass() {
    for f_number in [2.0, 5.6] {
        let focus = Focus::Distance(1.5);
        let [wave, glass] = [true, false].map(|is_wave| camera(f_number, focus, is_wave));
        for pixel in [DVec2::new(1800.0, 1200.0), DVec2::new(2700.0, 900.0), DVec2::new(300.0, 2200.0)] {
            let sum = |camera: &Camera| -> f64 {
                rays(camera, pixel, 128).iter().flatten().map(|ray| f64::from(ray.weight)).sum()
            };
            // The same numbers in the pupil; its edge crosses some 4·128 of 128² cells, and the spread moves it a little.
            let ratio = sum(&wave) / sum(&glass);
            assert!((ratio - 1.0).abs() < 3e-3, "f/{f_number} {pixel}: {ratio}");
        }
    }
}

/// Light of a position comes from places of the plane of focus whose images reach it: with coma, on one side. The
/// offsets from their chief rays are those of rays of the glass from such a place in the mean.
#[test]
fn light_comes_from_where_the_image_of_a_point_reaches() {
    let camera = camera(2.8, Focus::Distance(1.5), true);
    let glass = self::camera(2.8, Focus::Distance(1.5), false);
    let pixel = DVec2::new(1800.0 + 1000.0, 1200.0);
    let u = camera.focus_distance_m();
    // Of the image of a point: this position less that of the point in focus, as its chief ray has it. Its 40 px about
    // the middle, since diffraction's tails have no mean.
    let gathered: Vec<DVec2> = rays(&camera, pixel, 192)
        .iter()
        .flatten()
        .filter_map(|ray| Some(pixel - camera.project(at_distance(ray, u).as_vec3())?))
        .filter(|offset| offset.length() < 40.0)
        .collect();
    // Where rays of the glass land, backwards: those of positions around that go through the point in focus which is seen
    // at the middle, by the slope of what they see.
    let line = glass.chief_ray(pixel).expect("seen");
    let point = line.origin.as_dvec3()
        + line.direction.as_dvec3() * ((-u - f64::from(line.origin.z)) / f64::from(line.direction.z));
    let px_per_m = {
        let beside = glass.project((point + DVec3::X * 1e-3).as_vec3()).expect("seen");
        (beside - glass.project(point.as_vec3()).expect("seen")).x / 1e-3
    };
    let landed: Vec<f64> = rays(&glass, pixel, 192)
        .iter()
        .flatten()
        .map(|ray| -(at_distance(ray, u) - point).x * px_per_m)
        .filter(|offset| offset.abs() < 40.0)
        .collect();
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    let gathered: Vec<f64> = gathered.iter().map(|offset| offset.x).collect();
    let cubes = |all: &[f64]| {
        let middle = mean(all);
        let moments = [2, 3].map(|power| all.iter().map(|x| (x - middle).powi(power)).sum::<f64>() / all.len() as f64);
        moments[1] / moments[0].powf(1.5)
    };
    assert!(mean(&landed).abs() > 0.5, "coma: {}", mean(&landed));
    assert!(
        (mean(&gathered) - mean(&landed)).abs() < 0.15 * mean(&landed).abs(),
        "{} {}",
        mean(&gathered),
        mean(&landed)
    );
    assert!(cubes(&gathered) * cubes(&landed) > 0.0, "{} {}", cubes(&gathered), cubes(&landed));
}

#[test]
fn far_out_of_focus_a_point_is_as_large_as_by_rays() {
    for focus in [Focus::Distance(1.5), Focus::Infinity] {
        let [wave, glass] = [true, false].map(|is_wave| camera(2.8, focus, is_wave));
        for pixel in [DVec2::new(1800.0, 1200.0), DVec2::new(2900.0, 1500.0)] {
            let spread = |camera: &Camera| {
                let places: Vec<DVec2> =
                    rays(camera, pixel, 96).iter().flatten().map(|ray| at_distance(ray, 0.7).truncate()).collect();
                let middle = places.iter().sum::<DVec2>() / places.len() as f64;
                let square = places.iter().map(|place| place.distance_squared(middle)).sum::<f64>();
                (middle, (square / places.len() as f64).sqrt())
            };
            let [(middle, size), (expected_middle, expected)] = [&wave, &glass].map(spread);
            // Blurs of some 20 mm, to which aberrations and diffraction add hundredths of mm.
            assert!(expected > 4e-3 && (size / expected - 1.0).abs() < 0.01, "{focus:?} {pixel}: {size} {expected} m");
            assert!(
                middle.distance(expected_middle) < 0.01 * expected,
                "{focus:?} {pixel}: {middle} {expected_middle}"
            );
        }
    }
}

/// A path's other wavelengths land about where their chief rays of the same point in focus do. Of the hero's own wavelength
/// they come to where the path started, in the plane of focus by any point of the pupil, and by the way in as well: all but
/// a seventh whose image is drawn from another node, as nodes are chosen by where light comes from and where it lands.
#[test]
fn wavelengths_land_about_the_chief_rays_of_one_point() {
    const SAMPLES: usize = 64;
    let camera = camera(2.0, Focus::Distance(1.5), true);
    let wavelengths = Wavelengths::new([NM; 4], [1.0; 4]);
    for pixel in [DVec2::new(1803.5, 1200.5), DVec2::new(2900.5, 1700.5)] {
        let u = |i: usize, step: f64| (i as f64 * step).fract() as f32;
        let sample = |i: usize| CameraSample {
            pixel,
            aperture: [u(i, 0.618_034), 0.5],
            time: 0.0,
            spread: [u(i, 0.754_877_67), u(i, 0.569_840_3)],
        };
        let samples: Vec<CameraSample> = (0..SAMPLES).map(sample).collect();
        let (mut landed, mut arrived, mut all) = (0, 0, 0);
        let mut points = Vec::new();
        let mut rays = LensRays::default();
        land(&camera, &samples, &mut rays, |sample, LandingRay { of_hero, landings }| {
            let point = at_distance(&of_hero, camera.focus_distance_m()).as_vec3();
            points.push(TowardsLens { point, sample: [0.5, 0.4], spread: sample.spread, wavelengths });
            let is_here = |landing: &Landing| landing.weight > 0.0 && landing.cell == [pixel.x as u32, pixel.y as u32];
            landed += usize::from(landings.iter().all(is_here));
            all += 1;
        });
        camera.arrive_each(&points, &mut rays, |_, arrival| {
            arrived += usize::from(arrival.landings[0].cell == [pixel.x as u32, pixel.y as u32]);
        });
        assert!(all > SAMPLES / 2 && landed * 4 > all * 3 && arrived * 4 > all * 3, "{landed} {arrived} {all}");
    }
}

/// Light of a point on the axis, as paths of the hero gather it and as the other wavelengths of these paths land.
#[test]
fn on_the_axis_landings_have_the_size_of_what_is_gathered() {
    const HALF: i32 = 12;
    const SAMPLES: usize = 96;
    let camera = camera(4.0, Focus::ImageDistance(0.065), true);
    let centre = DVec2::new(1800.0, 1200.0);
    let (mut sums, mut squares) = ([0.0; 4], [0.0; 4]);
    let mut rays = LensRays::default();
    for cell in 0..(2 * HALF) * (2 * HALF) {
        let corner = centre + DVec2::new(f64::from(cell % (2 * HALF) - HALF), f64::from(cell / (2 * HALF) - HALF));
        let u = |i: usize, step: f64| ((f64::from(cell) * 0.324_717 + i as f64 * step).fract()) as f32;
        let sample = |i: usize| CameraSample {
            pixel: corner + DVec2::new(u(i, 0.618_034).into(), u(i, 0.414_214).into()),
            aperture: [u(i, 0.732_051), u(i, 0.236_068)],
            time: 0.0,
            spread: [u(i, 0.754_877_67), u(i, 0.569_840_3)],
        };
        let samples: Vec<CameraSample> = (0..SAMPLES).map(sample).collect();
        land(&camera, &samples, &mut rays, |_, LandingRay { of_hero, landings }| {
            let point = at_distance(&of_hero, camera.focus_distance_m());
            let Some(place) = camera.project(point.as_vec3()) else { return };
            // A lamp of two pixels
            if place.distance(centre) > 1.0 {
                return;
            }
            for (lane, landing) in landings.iter().enumerate() {
                let weight = f64::from(landing.weight);
                let off = DVec2::from_array(landing.cell.map(|n| f64::from(n) + 0.5)) - centre;
                sums[lane] += weight;
                squares[lane] += weight * off.length_squared().min(f64::from(HALF * HALF));
            }
        });
    }
    // Some hundreds of 55,000 paths find the lamp.
    let [gathered, others] = [0, 1].map(|lane| (squares[lane] / sums[lane]).sqrt());
    assert!((others / gathered - 1.0).abs() < 0.1 && gathered > 1.0, "{gathered} {others} px");
}
