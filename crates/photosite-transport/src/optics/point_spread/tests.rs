//! Point spreads by their transforms: the mean of cos(2πf·x) over the offsets is the MTF.

use std::f64::consts::PI;

use super::*;

const N: u32 = 400;

/// The MTF along x at each frequency (per m) for each wavelength, from N² stratified offsets.
fn mtf(spread: &PointSpread, wavelengths: &Wavelengths, f_number: f64, frequencies: &[f64]) -> Vec<[f64; LANES]> {
    let mut sums = vec![[0.0; LANES]; frequencies.len()];
    for i in 0..N * N {
        let at = |i: u32| (i as f32 + 0.5) / N as f32;
        let (offset, weights) = spread.sample([at(i % N), at(i / N)], wavelengths, f_number, DVec2::ZERO);
        for (sums, f) in sums.iter_mut().zip(frequencies) {
            for (lane, sum) in sums.iter_mut().enumerate() {
                *sum += f64::from(weights[lane]) * (2.0 * PI * f * offset.x).cos() / f64::from(N * N);
            }
        }
    }
    sums
}

/// MTF of diffraction at a round aperture (M. Born, E. Wolf, §9.5.2) at a part of the cut-off frequency 1/(λN).
fn diffraction(part: f64) -> f64 {
    if part >= 1.0 { 0.0 } else { 2.0 / PI * (part.acos() - part * (1.0 - part * part).sqrt()) }
}

fn alone(lambda_nm: f32) -> Wavelengths {
    let mut wavelengths = Wavelengths::new([lambda_nm; LANES], [1.0; LANES]);
    wavelengths.terminate_secondary();
    wavelengths
}

#[test]
fn the_transform_of_airys_pattern_is_that_of_diffraction() {
    let (lambda, f_number) = (550e-9, 8.0);
    let cut_off = 1.0 / (lambda * f_number);
    let parts = [0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 1.2];
    let found = mtf(&PointSpread::Airy, &alone(550.0), f_number, &parts.map(|part| part * cut_off));
    for (part, found) in parts.iter().zip(found) {
        // The outermost of 400 radii stands for 1/400 of the light, wherever that is: an error of that size at most.
        assert!(
            (found[0] - diffraction(*part)).abs() < 1.0 / f64::from(N),
            "{part}: {} {}",
            found[0],
            diffraction(*part)
        );
    }
}

#[test]
fn every_wavelength_gets_its_own_pattern_from_the_heros_offsets() {
    let wavelengths = [450.0, 520.0, 590.0, 660.0];
    let f_number = 5.6;
    let frequency = 0.3 / (550e-9 * f_number);
    // Over all four as the hero, as in a render, where each is as often.
    let mut mean = [0.0; LANES];
    for hero in 0..LANES {
        let turned = Wavelengths::new(std::array::from_fn(|i| wavelengths[(i + hero) % LANES]), [1.0; LANES]);
        let found = mtf(&PointSpread::Airy, &turned, f_number, &[frequency])[0];
        for (i, found) in found.iter().enumerate() {
            mean[(i + hero) % LANES] += found / LANES as f64;
        }
    }
    for (lambda, found) in wavelengths.iter().zip(mean) {
        let expected = diffraction(frequency * f64::from(*lambda) * 1e-9 * f_number);
        assert!((found - expected).abs() < 2.0 / f64::from(N), "{lambda}: {found} {expected}");
    }
}

#[test]
fn the_first_dark_ring_is_at_1_22_wavelengths_times_the_f_number() {
    let ring = 3.831_705_970_207_512;
    // 1.2197 in units of λN, and 83.8 % of the light within: tabulated figures ([Born99] table 8.2).
    assert!((ring / PI - 1.22).abs() < 1e-3 && airy::intensity(ring) < 1e-25);
    assert!((airy::enclosed(ring) - 0.838).abs() < 5e-4);
    let radii: Vec<f64> = (0..100_000).map(|i| airy::radius((f64::from(i) + 0.5) / 1e5)).collect();
    // Light per area in rings of 2 % of the first dark one: none as dark within, and none as bright just outside.
    let density = |part: f64| {
        let ring_of = |x: &&f64| (**x / ring - part).abs() < 0.01;
        radii.iter().filter(ring_of).count() as f64 / part
    };
    let darkest = (80..130).map(f64::from).min_by(|a, b| density(a / 100.0).total_cmp(&density(b / 100.0)));
    assert!((darkest.expect("fifty rings") - 100.0).abs() <= 2.0, "{darkest:?}");
}

#[test]
fn enclosed_light_rises_to_all_of_it() {
    for u in [0.0, 1e-6, 0.1, 0.5, 0.838, 0.9, 0.98, 0.995, 0.9999, 1.0 - f64::from(f32::EPSILON) / 2.0] {
        let x = airy::radius(u);
        // The remainder is 2/(πx) in the mean; of the last digits of 1 − J₀² − J₁² some are lost.
        assert!((airy::enclosed(x) - u).abs() < 1e-9, "{u}: {x}");
    }
    let ratio = (1.0 - airy::enclosed(1e4)) * PI * 1e4 / 2.0;
    assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
}

#[test]
fn gaussians_and_measured_kernels_have_their_transforms() {
    let sigma_m = 3e-6;
    let frequencies = [2e4, 5e4, 1e5];
    let found = mtf(&PointSpread::Gaussian { sigma_m }, &alone(550.0), 1.0, &frequencies);
    for (f, found) in frequencies.iter().zip(found) {
        let expected = (-2.0 * (PI * f * sigma_m).powi(2)).exp();
        assert!((found[0] - expected).abs() < 1.0 / f64::from(N), "{f}: {} {expected}", found[0]);
    }
    // Two cells of 2 µm with light 1 : 3 along x, and one with all of it elsewhere.
    let cells = Kernel::new(&[vec![1.0, 3.0]], 2e-6).expect("light").about_centroid();
    let sharp = Kernel::new(&[vec![0.0, 0.0], vec![0.0, 1.0]], 1e-12).expect("light").about_centroid();
    let field = KernelField::new(vec![(DVec2::ZERO, cells), (DVec2::ONE, sharp)]).expect("two kernels");
    let spread = PointSpread::Measured(Arc::new(field));
    let mut mean = DVec2::ZERO;
    for i in 0..N * N {
        let at = |i: u32| (i as f32 + 0.5) / N as f32;
        let u = [at(i % N), at(i / N)];
        let (offset, _) = spread.sample(u, &alone(550.0), 1.0, DVec2::new(0.1, -0.2));
        mean += offset / f64::from(N * N);
        assert!(spread.sample(u, &alone(550.0), 1.0, DVec2::new(0.9, 0.8)).0.length() < 1e-11);
        // The centroid lies at 2.5 of 4 µm. Light of a point goes to the right, so a pixel gathers it from the left.
        assert!((-1.5e-6 - 1e-12..=2.5e-6 + 1e-12).contains(&offset.x), "{offset}");
    }
    assert!(mean.length() < 1e-9, "{mean}");
    assert!(Kernel::new(&[vec![1.0], vec![1.0, 2.0]], 1e-6).is_err() && Kernel::new(&[vec![0.0]], 1e-6).is_err());
}

#[test]
fn the_middle_of_a_kernel_stays_in_its_place() {
    // Rows of values, and where their light is from the middle, in cells: to the right and down.
    for (rows, centroid) in [
        (vec![vec![0.0, 0.0, 1.0], vec![0.0; 3], vec![0.0; 3]], [1.0, -1.0]),
        (vec![vec![1.0, 2.0, 1.0], vec![2.0, 4.0, 2.0], vec![1.0, 2.0, 1.0]], [0.0, 0.0]),
        // With an even number, the middle is between two cells.
        (vec![vec![1.0, 3.0]], [0.25, 0.0]),
        (vec![vec![0.0, 0.0], vec![0.0, 0.0], vec![0.0, 0.0], vec![2.0, 2.0]], [0.0, 1.5]),
    ] {
        let pitch_m = 3e-6;
        let kernel = Kernel::new(&rows, pitch_m).expect("light");
        let expected = DVec2::from_array(centroid) * pitch_m;
        assert!((kernel.centroid_m() - expected).length() < 1e-18, "{rows:?}: {}", kernel.centroid_m());
        let moved = kernel.clone().about_centroid();
        assert!(moved.centroid_m().length() < 1e-18 && (moved == kernel) == (centroid == [0.0, 0.0]));
        for (kernel, expected) in [(kernel, expected), (moved, DVec2::ZERO)] {
            let at = |i: u32| (i as f32 + 0.5) / N as f32;
            let all = (0..N * N).map(|i| kernel.sample([at(i % N), at(i / N)]));
            // A pixel gathers light from where it would be without: the other way. Of each cell the samples are even to
            // a part in N.
            let mean = all.sum::<DVec2>() / f64::from(N * N);
            assert!((mean + expected).length() < 2.0 * pitch_m / f64::from(N), "{rows:?}: {mean} {expected}");
        }
    }
}
