//! Irradiance behind the lens, focus, and blur against closed forms.

use glam::{DAffine3, Vec3};
use photosite::integrator::RenderSettings;
use photosite::optics::{Falloff, Focus, LensDescription, LensKind, PixelGrid};

use crate::stage::{Stage, camera, irradiance, mean, square};

/// Irradiance of a disk of radiance 1 and half-angle with tan t, at a point from which the disk's axis is at an angle
/// of tangent a: P. D. Foote's formula (Bull. Bur. Standards 12, 583 (1915)), exact for any aperture.
pub(crate) fn disk_irradiance(t: f64, a: f64) -> f64 {
    let (t2, a2) = (t * t, a * a);
    std::f64::consts::FRAC_PI_2 * (1.0 - (1.0 + a2 - t2) / ((1.0 + a2 + t2).powi(2) - 4.0 * a2 * t2).sqrt())
}

/// The same as an integral over the opening, cos⁴θ/v² dA with v = 1, by the midpoint rule in polar coordinates.
fn disk_irradiance_by_quadrature(t: f64, a: f64) -> f64 {
    let n = 400;
    let mut sum = 0.0;
    for i in 0..n {
        let r = (f64::from(i) + 0.5) / f64::from(n) * t;
        for j in 0..n {
            let phi = (f64::from(j) + 0.5) / f64::from(n) * std::f64::consts::TAU;
            let d2 = 1.0 + (a + r * phi.cos()).powi(2) + (r * phi.sin()).powi(2);
            sum += r / (d2 * d2);
        }
    }
    sum * t / f64::from(n) * std::f64::consts::TAU / f64::from(n)
}

/// A one-pixel sensor, so small that the field angle hardly varies over it, `tangent` off the axis.
fn pixel_off_axis(lens: &mut LensDescription, v: f64, tangent: f64) -> PixelGrid {
    let pitch = v * 1e-3;
    lens.intrinsics =
        Some(photosite::optics::Intrinsics { fx: 1e3, fy: 1e3, cx: 0.5 - tangent * 1e3, cy: 0.5, skew: 0.0 });
    PixelGrid { resolution: [1, 1], pitch_m: [pitch; 2] }
}

#[test]
fn a_uniform_environment_gives_the_exact_aperture_integral() {
    let radiance = 2.5;
    let scene = Stage::default().environment(radiance).build();
    for focus in [Focus::Infinity, Focus::Distance(0.5)] {
        for f_number in [16.0, 4.0, 1.4] {
            for degrees in [0.0, 10.0, 20.0, 35.0f64] {
                let mut lens = LensDescription::thin(0.05, f_number, focus);
                let v = match focus {
                    Focus::Distance(u) => 0.05 * u / (u - 0.05),
                    Focus::Infinity | Focus::Autofocus { .. } | Focus::ImageDistance(_) => 0.05,
                };
                let tangent = degrees.to_radians().tan();
                let grid = pixel_off_axis(&mut lens, v, tangent);
                let settings = RenderSettings { samples_per_pixel: 1 << 14, ..Default::default() };
                let got = mean(&irradiance(&scene, &camera(&lens, &grid, DAffine3::IDENTITY), [1, 1], &settings));
                let t = 0.05 / f_number / 2.0 / v;
                let expected = f64::from(radiance) * disk_irradiance(t, tangent);
                let quadrature = f64::from(radiance) * disk_irradiance_by_quadrature(t, tangent);
                assert!((quadrature / expected - 1.0).abs() < 1e-4, "the two exact routes differ");
                // The bounds; 2¹⁴ Sobol points of cos⁴θ, which varies by a factor of two at most, do far
                // better, and the pixel's own width of 1 mrad changes cos⁴ by 1e-3 relative at its edges, evenly.
                let tolerance = if degrees == 0.0 { 0.002 } else { 0.005 };
                assert!(
                    (got / expected - 1.0).abs() < tolerance,
                    "f/{f_number} at {degrees}°, {focus:?}: {got} {expected}"
                );
            }
        }
    }
}

/// ∫_A cos⁴θ/v² dA from the axis over an opening whose corners lie on a circle of radius t, v = 1, by the midpoint rule
/// over the angle about the axis: in the direction φ it reaches out to ρ, and ∫₀^ρ r/(1 + r²)² dr = ρ²/(1 + ρ²)/2.
fn from_the_axis(t: f64, blades: u32) -> f64 {
    const STEPS: u32 = 100_000;
    let reach = |phi: f64| match blades {
        0 => t,
        n => {
            let half = std::f64::consts::PI / f64::from(n);
            t * half.cos() / (phi.rem_euclid(2.0 * half) - half).cos()
        }
    };
    let step = std::f64::consts::TAU / f64::from(STEPS);
    (0..STEPS).map(|i| reach((f64::from(i) + 0.5) * step).powi(2)).map(|rho2| step / 2.0 * rho2 / (1.0 + rho2)).sum()
}

#[test]
fn one_f_number_has_one_exposure_on_the_axis() {
    let scene = Stage::default().environment(1.0).build();
    let settings = RenderSettings { samples_per_pixel: 1 << 14, ..Default::default() };
    let kinds = [LensKind::Thin, LensKind::Pinhole];
    let lenses = kinds.into_iter().flat_map(|kind| [(kind, Falloff::Cos4), (kind, Falloff::None)]);
    for ((kind, falloff), f_number) in lenses.flat_map(|lens| [1.0, 1.4, 2.0, 8.0].map(|n| (lens, n))) {
        for (blades, focus) in [(0, Focus::Infinity), (5, Focus::Infinity), (0, Focus::Distance(0.4))] {
            let lens = LensDescription { kind, falloff, blades, ..LensDescription::thin(0.05, f_number, focus) };
            let v = match (kind, focus) {
                (LensKind::Thin, Focus::Distance(u)) => 0.05 * u / (u - 0.05),
                (LensKind::Thin | LensKind::Pinhole | LensKind::Hole | LensKind::Bare | LensKind::Prescription, _) => {
                    0.05
                }
            };
            // Wide pixels where all see the same, and one that is small on the axis.
            let (side, pitch_m) = if falloff == Falloff::None { (3, 0.02) } else { (1, 1e-4) };
            let grid = PixelGrid { resolution: [side; 2], pitch_m: [pitch_m; 2] };
            let estimate = irradiance(&scene, &camera(&lens, &grid, DAffine3::IDENTITY), [side; 2], &settings);
            let t = 0.05 / f_number / 2.0 / v;
            let expected = from_the_axis(t, blades);
            if blades == 0 {
                let closed = std::f64::consts::PI * t.atan().sin().powi(2);
                assert!((expected / closed - 1.0).abs() < 1e-9, "π·sin²θ' {closed}, not {expected}");
            }
            for value in &estimate.mean.channels()[0].data {
                // The noise is that of the two edges of the band, 2 of its 302 nm, where a sample is worth 0 to 2:
                // √(2/302 · 4/12)/√(4 · 2¹⁴) = 1.8e-4, and with cos⁴ that of the opening, less than that with Sobol's
                // points. Small apertures differ by (D/2v)², which is 3.9e-3 at f/8.
                let error = f64::from(*value) / expected - 1.0;
                assert!(error.abs() < 1e-3, "{kind:?} {falloff:?} f/{f_number} {blades} blades {focus:?}: {error}");
            }
        }
    }
}

/// Root-mean-square radius of the image about its centroid, and its sum, in pixels.
fn spread(data: &[f32], width: usize) -> (f64, f64) {
    let at = |i: usize| ((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
    let sum: f64 = data.iter().map(|&v| f64::from(v)).sum();
    let moment = |f: &dyn Fn((f64, f64)) -> f64| {
        data.iter().enumerate().map(|(i, &v)| f64::from(v) * f(at(i))).sum::<f64>() / sum
    };
    let (cx, cy) = (moment(&|p| p.0), moment(&|p| p.1));
    (moment(&|p| (p.0 - cx).powi(2) + (p.1 - cy).powi(2)).sqrt(), sum)
}

#[test]
fn a_point_out_of_focus_becomes_a_disk_of_the_thin_lens_diameter() {
    // A small square emitter on the axis, in front of and behind the plane of focus.
    let (f, n, u) = (0.05, 1.8, 1.0);
    for distance in [0.6f64, 2.5] {
        // Large enough to be hit some 30 000 times, which leaves 0.2 % of noise in the diameter.
        let half = 1.2e-3 * distance as f32;
        let emitter = square(Vec3::Z * -distance as f32, Vec3::X, Vec3::Y, half);
        let scene = Stage::default().diffuse(emitter, 0.0, 1.0).build();
        let mut lens = LensDescription::thin(f, n, Focus::Distance(u));
        // With cos⁴ the rim of the disk would be dimmer than its middle.
        lens.falloff = Falloff::None;
        let resolution = 88;
        let grid = PixelGrid { resolution: [resolution; 2], pitch_m: [1.5e-5; 2] };
        let settings = RenderSettings { samples_per_pixel: 512, max_depth: 1, ..Default::default() };
        let estimate = irradiance(&scene, &camera(&lens, &grid, DAffine3::IDENTITY), [resolution; 2], &settings);
        let v = u * f / (u - f);
        let sharp_at = distance * f / (distance - f);
        let blur_m = f / n * (v - sharp_at).abs() / sharp_at;
        // A disk of diameter c has a mean squared radius of c²/8; the emitter's image, of side s, and the pixel add
        // s²/6 and p²/6.
        let side_px = 2.0 * f64::from(half) / distance * v / 1.5e-5;
        let (rms, _) = spread(&estimate.mean.channels()[0].data, resolution as usize);
        let diameter_px = (8.0 * (rms * rms - side_px * side_px / 6.0 - 1.0 / 6.0)).sqrt();
        let expected_px = blur_m / 1.5e-5;
        assert!(
            (diameter_px / expected_px - 1.0).abs() < 0.01,
            "at {distance} m: {diameter_px} px, not {expected_px} px"
        );
    }
}

#[test]
fn in_focus_the_image_has_the_size_that_the_lens_equation_gives() {
    let (f, u) = (0.05, 0.4);
    let half = 0.004;
    let scene = Stage::default().diffuse(square(Vec3::Z * -u as f32, Vec3::X, Vec3::Y, half), 0.0, 1.0).build();
    let lens = LensDescription::thin(f, 2.0, Focus::Distance(u));
    let pitch = 2e-5;
    let grid = PixelGrid { resolution: [96; 2], pitch_m: [pitch; 2] };
    let settings = RenderSettings { samples_per_pixel: 256, max_depth: 1, ..Default::default() };
    let estimate = irradiance(&scene, &camera(&lens, &grid, DAffine3::IDENTITY), [96; 2], &settings);
    let magnification = f / (u - f);
    let expected_side_px = 2.0 * f64::from(half) * magnification / pitch;
    let (rms, _) = spread(&estimate.mean.channels()[0].data, 96);
    // A square of side s has a mean squared radius of s²/6, the pixel adds 1/6.
    let side_px = (6.0 * (rms * rms - 1.0 / 6.0)).sqrt();
    assert!((side_px / expected_side_px - 1.0).abs() < 0.01, "{side_px} {expected_side_px}");
}
