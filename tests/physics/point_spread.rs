//! The image of a slanted edge through Airy's pattern against the same edge in closed form, read by the same tool.

use std::f64::consts::PI;

use glam::{DAffine3, DVec2};
use photosite::measure::slanted_edge;
use photosite::optics::{Camera, CameraSample, Falloff, Focus, LensDescription, PixelGrid, PointSpread};
use photosite::sampler::{Sampler, SamplerKind};
use photosite::spectrum::{LANES, Wavelengths};

const SIZE: [usize; 2] = [64, 128];
const PITCH_M: f64 = 2e-6;
const F_NUMBER: f64 = 8.0;
const LAMBDA_NM: f32 = 550.0;
const SAMPLES: u32 = 512;

/// Distance of a position in the image from an edge 5° off the columns, px.
fn distance(pixel: DVec2) -> f64 {
    (pixel - DVec2::new(32.0, 64.0)).dot(normal())
}

fn normal() -> DVec2 {
    DVec2::from_angle(5.0_f64.to_radians())
}

/// The value of the pixel at a distance from the edge: the transform of the pattern (Born, Wolf §9.5.2), times that of
/// a square pixel, through that of a step.
fn analytic(pixel: DVec2) -> f64 {
    let cut_off = PITCH_M / (f64::from(LAMBDA_NM) * 1e-9 * F_NUMBER);
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    let steps = 400;
    let sum: f64 = (0..steps)
        .map(|i| {
            let part = (f64::from(i) + 0.5) / f64::from(steps);
            let f = part * cut_off;
            let pattern = 2.0 / PI * (part.acos() - part * (1.0 - part * part).sqrt());
            let box_pixel = sinc(f * normal().x) * sinc(f * normal().y);
            pattern * box_pixel * (2.0 * PI * f * distance(pixel)).sin() / (PI * f) * cut_off / f64::from(steps)
        })
        .sum();
    0.5 + sum
}

#[test]
fn a_slanted_edge_through_airys_pattern_has_the_mtf_of_diffraction() {
    let mut lens = LensDescription::thin(0.01, F_NUMBER, Focus::Infinity);
    (lens.falloff, lens.point_spread) = (Falloff::None, Some(PointSpread::Airy));
    let grid = PixelGrid { resolution: SIZE.map(|n| n as u32), pitch_m: [PITCH_M; 2] };
    let camera = Camera::new(&lens, &grid, DAffine3::IDENTITY, f64::NAN).expect("a lens");
    let mut alone = Wavelengths::new([LAMBDA_NM; LANES], [1.0; LANES]);
    alone.terminate_secondary();
    let pixels = || (0..SIZE[0] * SIZE[1]).map(|i| ((i % SIZE[0]) as f64, (i / SIZE[0]) as f64));
    let traced = |(i, (x, y)): (usize, (f64, f64))| {
        let mut sampler = Sampler::new(SamplerKind::Sobol, 3);
        let lit = (0..SAMPLES).filter(|&index| {
            sampler.start(i as u64, index);
            let [dx, dy] = sampler.next_2d().map(f64::from);
            let spread = sampler.next_2d();
            let pixel = DVec2::new(x + dx, y + dy);
            let sample = CameraSample { pixel, aperture: [0.5; 2], time: 0.0, spread };
            let ray = camera.generate_spectral(&sample, &mut { alone });
            let direction = ray.expect("in reach").0.ray.direction;
            distance(camera.project_camera(direction.as_dvec3()).expect("in reach")) > 0.0
        });
        lit.count() as f32 / SAMPLES as f32
    };
    let traced: Vec<f32> = pixels().enumerate().map(traced).collect();
    let expected: Vec<f32> = pixels().map(|(x, y)| analytic(DVec2::new(x + 0.5, y + 0.5)) as f32).collect();
    let read = |plane: &[f32]| slanted_edge(plane, SIZE, [0, 0, SIZE[0], SIZE[1]]).expect("an edge");
    let (found, wanted) = (read(&traced), read(&expected));
    for ((f, found), wanted) in found.frequency_cy_per_px.iter().zip(&found.mtf).zip(&wanted.mtf) {
        // Values near the edge are known to 0.5/√512 = 0.02, or better as the points are stratified; a bin of a quarter
        // of a pixel gathers 32 of them, and some 40 bins about the edge differ: 0.02/√32·√40/2 ≈ 0.01 at most.
        assert!(*f > 0.5 || (found - wanted).abs() < 0.01, "{f} cycles per pixel: {found} {wanted}");
    }
}
