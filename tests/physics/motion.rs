//! What a moving camera records: the skew of a rolling shutter, and motion blur.

use glam::{DAffine3, DVec3, Vec3};
use photosite::integrator::RenderSettings;
use photosite::optics::{Camera, CameraMotion, Falloff, Focus, LensDescription, LensKind, PixelGrid, Recording};
use photosite::scene::Scene;
use rstest::rstest;

use crate::stage::{Stage, camera, irradiance};

const RESOLUTION: [u32; 2] = [96, 120];
/// Focal length in pixels.
const FX: f64 = 200.0;
const SAMPLES: u32 = 64;
const SETTINGS: RenderSettings = RenderSettings {
    samples_per_pixel: SAMPLES,
    time_limit: None,
    noise_target: None,
    max_depth: 1,
    roulette_depth: 1,
    sampler: photosite::sampler::SamplerKind::Sobol,
    seed: 1,
};

/// A bright half-plane x > 0, 1 m in front of a pinhole camera at `x`.
fn scene() -> Scene {
    let corner = |x: f32, y: f32| Vec3::new(x, y, -1.0);
    let (a, b, c, d) = (corner(0.0, -3.0), corner(3.0, -3.0), corner(3.0, 3.0), corner(0.0, 3.0));
    Stage::default().diffuse(vec![[a, b, c], [a, c, d]], 0.0, 1.0).build()
}

fn pinhole(x: f64) -> Camera {
    let mut lens = LensDescription::thin(2e-3, 8.0, Focus::Infinity);
    (lens.kind, lens.falloff) = (LensKind::Pinhole, Falloff::None);
    let grid = PixelGrid { resolution: RESOLUTION, pitch_m: [2e-3 / FX; 2] };
    camera(&lens, &grid, DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)))
}

/// How much of each pixel is bright.
fn coverage(camera: &Camera) -> Vec<Vec<f64>> {
    let estimate = irradiance(&scene(), camera, RESOLUTION, &SETTINGS);
    let rows = estimate.mean.channels()[0].data.chunks(RESOLUTION[0] as usize);
    let rows: Vec<Vec<f64>> = rows.map(|row| row.iter().map(|&e| f64::from(e)).collect()).collect();
    // The last ten columns are bright throughout.
    let bright: Vec<f64> = rows.iter().flat_map(|row| &row[86..]).copied().collect();
    let level = bright.iter().sum::<f64>() / bright.len() as f64;
    assert!(level > 0.0);
    rows.into_iter().map(|row| row.into_iter().map(|e| e / level).collect()).collect()
}

#[rstest]
#[case::passing_by(CameraMotion { velocity_m_per_s: DVec3::X, angular_velocity_rad_per_s: DVec3::ZERO }, -0.06)]
#[case::panning(CameraMotion { velocity_m_per_s: DVec3::ZERO, angular_velocity_rad_per_s: DVec3::Y }, 0.06)]
fn a_rolling_shutter_skews_a_moving_edge(#[case] motion: CameraMotion, #[case] x: f64) {
    let (row_time_s, exposure_s) = (1e-3, 1e-5);
    let camera = pinhole(x).recording(Recording { motion, start_s: 0.0, exposure_s, row_time_s });
    let rows = coverage(&camera);
    let (width, centre) = (f64::from(RESOLUTION[0]), f64::from(RESOLUTION[0]) / 2.0);
    let expected = |row: usize| {
        let t = row as f64 * row_time_s + 0.5 * exposure_s;
        // The edge at x = 0, seen from x + v·t, and by a camera that has turned to the left by ω·t: to its right.
        let seen = (-(x + motion.velocity_m_per_s.x * t)).atan() + motion.angular_velocity_rad_per_s.y * t;
        centre + FX * seen.tan()
    };
    let pairs: Vec<(f64, f64)> =
        rows.iter().enumerate().map(|(y, row)| (expected(y), width - row.iter().sum::<f64>())).collect();
    let n = pairs.len() as f64;
    let (mean_x, mean_y) = (pairs.iter().map(|p| p.0).sum::<f64>() / n, pairs.iter().map(|p| p.1).sum::<f64>() / n);
    let spread: f64 = pairs.iter().map(|p| (p.0 - mean_x).powi(2)).sum();
    let slope = pairs.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum::<f64>() / spread;
    // Were the 64 samples of the pixel at the edge independent, its coverage would have a standard deviation of up to
    // 0.5/√64, and the slope that over √spread; 24 pixels of skew over 120 rows make a spread of 120·24²/12. 5 σ.
    let sigma = 0.5 / f64::from(SAMPLES).sqrt();
    assert!((spread / 5760.0 - 1.0).abs() < 0.1, "{spread}");
    assert!((slope - 1.0).abs() < 5.0 * sigma / spread.sqrt(), "the skew is {slope} of what it should be");
    assert!((mean_y - mean_x).abs() < 5.0 * sigma / n.sqrt(), "at {mean_y}, not {mean_x}");
}

#[test]
fn an_exposure_blurs_what_moves_over_its_way() {
    // Over 0.1 s at 1 m/s an edge 1 m away moves by 20 pixels.
    let motion = CameraMotion { velocity_m_per_s: DVec3::X, angular_velocity_rad_per_s: DVec3::ZERO };
    let recording = Recording { motion, start_s: 0.0, exposure_s: 0.1, row_time_s: 0.0 };
    let rows = coverage(&pinhole(-0.05).recording(recording));
    let n = rows.len() as f64;
    let profile: Vec<f64> =
        (0..RESOLUTION[0] as usize).map(|x| rows.iter().map(|row| row[x]).sum::<f64>() / n).collect();
    // A ramp of width w has ∫ p·(1 − p) = w/6, less 1/(12·w) for the width of pixels, here 0.1 %; its noise is that of
    // 20 columns of 120 · 64 samples, 0.5/√7680 each: (1 − 2p) of it, summed, 0.015 of 3.33. 4 σ.
    let width = 6.0 * profile.iter().map(|p| p * (1.0 - p)).sum::<f64>();
    assert!((width / 20.0 - 1.0).abs() < 0.02, "{width}");
}

#[test]
fn nothing_changes_where_nothing_moves() {
    let still = Recording { motion: CameraMotion::default(), start_s: 5.0, exposure_s: 1.0, row_time_s: 1e-3 };
    assert_eq!(coverage(&pinhole(0.01).recording(still)), coverage(&pinhole(0.01)));
}
