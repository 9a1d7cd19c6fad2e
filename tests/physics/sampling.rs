//! Points of the aperture and wavelengths against their densities, by Pearson's χ².

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DVec2};
use photosite::optics::{Camera, Focus, LensDescription, PixelGrid};
use photosite::spectrum::{Spectrum, WavelengthSampler, illuminant};
use rstest::rstest;

use crate::bsdf_cases::{SAMPLES, Uniform};
use crate::bsdf_sampling::p_value;

/// Probability that a test fails though the sampler is right.
const SIGNIFICANCE: f64 = 0.001;

/// Where a point of the opening lies, as two numbers that are uniform and independent where the point is uniform over
/// the area: the square of how far out it is, and how far along its blade's edge (the disk: along its circle). And the
/// blade.
fn place(point: DVec2, radius: f64, blades: u32, rotation_rad: f64) -> (usize, f64, f64) {
    let turns = |angle: f64| (angle / TAU).rem_euclid(1.0);
    let angle = point.y.atan2(point.x) - rotation_rad;
    if blades == 0 {
        return (0, point.length_squared() / (radius * radius), turns(angle));
    }
    let n = f64::from(blades);
    let blade = (turns(angle) * n) as usize;
    let from_middle = angle - (blade as f64 + 0.5) * TAU / n;
    let outwards = point.length() * from_middle.cos() / (radius * (PI / n).cos());
    (blade, outwards * outwards, 0.5 * (1.0 + from_middle.tan() / (PI / n).tan()))
}

#[rstest]
fn points_of_the_aperture_are_uniform_over_its_area(#[values(0, 3, 6, 7)] blades: u32, #[values(0.0, 25.0)] turn: f64) {
    const CELLS: usize = 8;
    // The lens is 20 mm wide.
    let mut lens = LensDescription::thin(0.05, 2.5, Focus::Infinity);
    (lens.blades, lens.blade_rotation_deg) = (blades, turn);
    let grid = PixelGrid { resolution: [1, 1], pitch_m: [1e-5; 2] };
    let camera = Camera::new(&lens, &grid, DAffine3::IDENTITY, f64::NAN).expect("a lens");
    let sectors = blades.max(1) as usize;
    let mut observed = vec![0.0; sectors * CELLS * CELLS];
    let mut uniform = Uniform::new(100 + blades as usize);
    for _ in 0..SAMPLES {
        let (_, u) = uniform.lobe_and_direction();
        let origin = camera.generate(DVec2::splat(0.5), u).expect("a ray").ray.origin.as_dvec3();
        let (blade, out, along) = place(origin.truncate(), 0.01, blades, turn.to_radians());
        assert!(out <= 1.0 + 1e-5 && (-1e-5..=1.0 + 1e-5).contains(&along), "{origin} is not in the opening");
        let cell = |t: f64| ((t * CELLS as f64) as usize).min(CELLS - 1);
        observed[(blade * CELLS + cell(out)) * CELLS + cell(along)] += 1.0;
    }
    let expected = vec![SAMPLES as f64 / observed.len() as f64; observed.len()];
    let p = p_value(&observed, &expected);
    assert!(p > SIGNIFICANCE, "p = {p:.2e}");
}

#[rstest]
#[case::flat(Spectrum::constant(1.0))]
#[case::daylight(illuminant::d65().clone())]
#[case::two_bands(Spectrum::from_fn(|l| if (l - 450.0).abs() < 20.0 || (l - 900.0).abs() < 60.0 { l } else { 0.0 }))]
fn wavelengths_are_distributed_as_their_density_says(#[case] importance: Spectrum, #[values(0, 1, 2, 3)] lane: usize) {
    let sampler = WavelengthSampler::new(&importance);
    // The density is constant between whole nanometres; what it is there, the samples say.
    let (mut observed, mut expected) = (vec![0.0; 801], vec![0.0; 801]);
    let mut uniform = Uniform::new(200 + lane);
    for _ in 0..SAMPLES {
        let wavelengths = sampler.sample(uniform.next());
        let piece = ((wavelengths.lambda_nm(lane) - 300.0) as usize).min(799);
        observed[piece] += 1.0;
        expected[piece] = SAMPLES as f64 / (4.0 * f64::from(wavelengths.weights()[lane]));
    }
    // Where nothing was drawn nothing is known, and little may be missing.
    expected[800] = (SAMPLES as f64 - expected.iter().sum::<f64>()).max(1e-6);
    let p = p_value(&observed, &expected);
    assert!(p > SIGNIFICANCE, "p = {p:.2e}");
}
