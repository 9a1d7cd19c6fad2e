//! What is recorded of things that move, the camera or what it sees: the skew of a rolling shutter, motion blur, and
//! the images of line cameras.

use glam::{DAffine3, DVec3, Vec3};
use photosite::geometry::Trajectory;
use photosite::integrator::{RenderSettings, StrategyChoice, WavelengthChoice};
use photosite::optics::{Camera, Falloff, Focus, LensDescription, LensKind, PixelGrid, Recording};
use photosite::scene::Scene;
use rstest::rstest;

use crate::stage::{Stage, camera, irradiance};

const RESOLUTION: [u32; 2] = [96, 120];
/// Focal length in pixels.
const FX: f64 = 200.0;
const SAMPLES: u32 = 64;
const SETTINGS: RenderSettings = RenderSettings {
    samples_per_pixel: SAMPLES,
    part: None,
    time_limit_s: None,
    noise_target: None,
    max_depth: 1,
    roulette_depth: 1,
    strategy: StrategyChoice::Plain,
    splitting: None,
    light_paths: None,
    light_path_kind: None,
    wavelengths: WavelengthChoice::AllFilters,
    sampler: photosite::sampler::SamplerKind::Sobol,
    seed: 1,
};

/// A bright half-plane x > 0, 1 m in front of a pinhole camera at `x`.
fn scene() -> Scene {
    half_plane(true, &[DAffine3::IDENTITY])
}

/// The same on the move through places at evenly spaced times: a lamp, or what a black plate leaves of a bright sky.
fn half_plane(is_lamp: bool, places: &[DAffine3]) -> Scene {
    let corner = |x: f32, y: f32| Vec3::new(x, y, -1.0);
    let side = if is_lamp { 3.0 } else { -3.0 };
    let (a, b, c, d) = (corner(0.0, -3.0), corner(side, -3.0), corner(side, 3.0), corner(0.0, 3.0));
    let plate = vec![[a, b, c], [a, c, d]];
    if is_lamp {
        return Stage::default().diffuse(plate, 0.0, 1.0).moving(places).build();
    }
    Stage::default().diffuse(plate, 0.0, 0.0).moving(places).environment(1.0).build()
}

/// A way along x of so many metres, at a constant speed.
fn along_x(way_m: f64) -> [DAffine3; 2] {
    [0.0, way_m].map(|x| DAffine3::from_translation(DVec3::X * x))
}

/// The time that a camera at rest takes for an image.
fn at_rest(exposure_s: f64, row_time_s: f64) -> Recording {
    let duration_s = exposure_s + f64::from(RESOLUTION[1] - 1) * row_time_s;
    Recording { motion: None, exposure_s, row_time_s, duration_s, ..steady(0.0, 0.0) }
}

fn pinhole(x: f64) -> Camera {
    let mut lens = LensDescription::thin(2e-3, 8.0, Focus::Infinity);
    (lens.kind, lens.falloff) = (LensKind::Pinhole, Falloff::None);
    let grid = PixelGrid { resolution: RESOLUTION, pitch_m: [2e-3 / FX; 2] };
    camera(&lens, &grid, DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)))
}

/// An image taken at once by a camera that moves to the right and turns to the left.
fn steady(speed_m_per_s: f64, pan_rad_per_s: f64) -> Recording {
    let motion = Trajectory::Steady {
        velocity_m_per_s: DVec3::X * speed_m_per_s,
        angular_velocity_rad_per_s: DVec3::Y * pan_rad_per_s,
    };
    Recording {
        motion: Some(motion),
        start_s: 0.0,
        exposure_s: 0.0,
        row_time_s: 0.0,
        first_row: 0.0,
        duration_s: 0.0,
        frame_interval_s: 0.0,
    }
}

/// How much of each pixel is bright.
fn coverage(scene: &Scene, camera: &Camera) -> Vec<Vec<f64>> {
    let estimate = irradiance(scene, camera, RESOLUTION, &SETTINGS);
    let rows = estimate.mean.channels()[0].data.chunks(RESOLUTION[0] as usize);
    let rows: Vec<Vec<f64>> = rows.map(|row| row.iter().map(|&e| f64::from(e)).collect()).collect();
    // The last ten columns are bright throughout.
    let bright: Vec<f64> = rows.iter().flat_map(|row| &row[86..]).copied().collect();
    let level = bright.iter().sum::<f64>() / bright.len() as f64;
    assert!(level > 0.0);
    rows.into_iter().map(|row| row.into_iter().map(|e| e / level).collect()).collect()
}

#[rstest]
#[case::passing_by(1.0, 0.0, -0.06)]
#[case::panning(0.0, 1.0, 0.06)]
fn a_rolling_shutter_skews_a_moving_edge(#[case] speed_m_per_s: f64, #[case] pan_rad_per_s: f64, #[case] x: f64) {
    let (row_time_s, exposure_s) = (1e-3, 1e-5);
    let recording = Recording { exposure_s, row_time_s, ..steady(speed_m_per_s, pan_rad_per_s) };
    let camera = pinhole(x).recording(recording);
    assert_skewed(&coverage(&scene(), &camera), row_time_s, exposure_s, speed_m_per_s, pan_rad_per_s, x);
}

#[rstest]
#[case::lamp(true)]
#[case::plate(false)]
fn a_rolling_shutter_skews_an_edge_that_moves(#[case] is_lamp: bool) {
    // The edge goes to the left as the camera went to the right.
    let recording = at_rest(1e-5, 1e-3);
    let scene = half_plane(is_lamp, &along_x(-recording.duration_s));
    let rows = coverage(&scene, &pinhole(-0.06).recording(recording));
    assert_skewed(&rows, 1e-3, 1e-5, 1.0, 0.0, -0.06);
}

/// Checks where each row sees the edge.
fn assert_skewed(rows: &[Vec<f64>], row_time_s: f64, exposure_s: f64, speed_m_per_s: f64, pan_rad_per_s: f64, x: f64) {
    let (width, centre) = (f64::from(RESOLUTION[0]), f64::from(RESOLUTION[0]) / 2.0);
    let expected = |row: usize| {
        let t = row as f64 * row_time_s + 0.5 * exposure_s;
        // The edge at x = 0, seen from x + v·t, and by a camera that has turned to the left by ω·t: to its right.
        let seen = (-(x + speed_m_per_s * t)).atan() + pan_rad_per_s * t;
        centre + FX * seen.tan()
    };
    let pairs: Vec<(f64, f64)> =
        rows.iter().enumerate().map(|(y, row)| (expected(y), width - row.iter().sum::<f64>())).collect();
    let n = pairs.len() as f64;
    let (mean_x, mean_y) = (pairs.iter().map(|p| p.0).sum::<f64>() / n, pairs.iter().map(|p| p.1).sum::<f64>() / n);
    let spread: f64 = pairs.iter().map(|p| (p.0 - mean_x).powi(2)).sum();
    let slope = pairs.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum::<f64>() / spread;
    // 200 pixels a second · 1 ms · 120 rows = 24 pixels of skew. Were the 64 samples of the pixel at the edge
    // independent, its coverage would have a standard deviation of up to 0.5/√64, and the slope that over √spread; a
    // skew of 24 pixels over 120 rows makes a spread of 120·24²/12. 5 σ are 0.4 %.
    let sigma = 0.5 / f64::from(SAMPLES).sqrt();
    assert!((spread / 5760.0 - 1.0).abs() < 0.1, "{spread}");
    assert!((slope - 1.0).abs() < 5.0 * sigma / spread.sqrt(), "the skew is {slope} of what it should be");
    assert!((mean_y - mean_x).abs() < 5.0 * sigma / n.sqrt(), "at {mean_y}, not {mean_x}");
}

#[test]
fn an_exposure_blurs_what_it_moves_over() {
    // Over 0.1 s at 1 m/s an edge 1 m away moves by 20 pixels.
    let camera = pinhole(-0.05).recording(Recording { exposure_s: 0.1, ..steady(1.0, 0.0) });
    assert_blurred(&coverage(&scene(), &camera));
}

#[rstest]
#[case::lamp(true)]
#[case::plate(false)]
fn an_exposure_blurs_what_moves_over_its_way(#[case] is_lamp: bool) {
    let scene = half_plane(is_lamp, &along_x(-0.1));
    assert_blurred(&coverage(&scene, &pinhole(-0.05).recording(at_rest(0.1, 0.0))));
}

/// An edge through the middle of the image turns by a right angle. A point at the angle φ from where it starts is
/// passed after the part φ/(π/2) of the time.
#[rstest]
// Lights move on straight lines between their places: with 32 of them the arc is cut short by 1 − cos(π/128) = 0.03 %.
#[case::lamp(true, 32)]
#[case::plate(false, 1)]
fn what_turns_passes_every_angle_in_its_time(#[case] is_lamp: bool, #[case] parts: u32) {
    let turned = |i: u32| DAffine3::from_rotation_z(std::f64::consts::FRAC_PI_2 * f64::from(i) / f64::from(parts));
    let places: Vec<DAffine3> = (0..=parts).map(turned).collect();
    let estimate =
        irradiance(&half_plane(is_lamp, &places), &pinhole(0.0).recording(at_rest(0.1, 0.0)), RESOLUTION, &SETTINGS);
    let values = &estimate.mean.channels()[0].data;
    let level = f64::from(values.iter().copied().fold(0.0, f32::max));
    let mut errors = photosite::math::statistics::Moments::default();
    for (i, value) in values.iter().enumerate() {
        let (x, y) = ((i % 96) as f64 + 0.5 - 48.0, 60.0 - (i / 96) as f64 - 0.5);
        if x.hypot(y) < 30.0 || x.hypot(y) > 45.0 {
            continue;
        }
        // The bright side is x > 0 first and y > 0 last, and the angle is that from the edge's ends at ±y.
        let angle = (-x).atan2(y);
        let part = angle / std::f64::consts::FRAC_PI_2;
        let bright = match part {
            p if p < -1.0 => p + 2.0,
            p if p < 0.0 => 1.0,
            p if p < 1.0 => 1.0 - p,
            _ => 0.0,
        };
        errors.add(f64::from(*value) / level - bright);
    }
    // Were the 64 samples of a pixel independent, its error would be 0.5/√64 at most; 3500 pixels, 5 σ.
    assert!(errors.mean().abs() < 5.0 * 0.0625 / 3500f64.sqrt(), "{}", errors.mean());
    assert!(errors.variance().sqrt() < 0.0625, "{}", errors.variance().sqrt());
}

fn assert_blurred(rows: &[Vec<f64>]) {
    let n = rows.len() as f64;
    let profile: Vec<f64> =
        (0..RESOLUTION[0] as usize).map(|x| rows.iter().map(|row| row[x]).sum::<f64>() / n).collect();
    // A ramp of width w has ∫ p·(1 − p) = w/6, less 1/(12·w) for the width of pixels, here 0.1 %; its noise is that of
    // 20 columns of 120 · 64 samples, 0.5/√7680 each: (1 − 2p) of it, summed, 0.015 of 3.33. 4 σ.
    let width = 6.0 * profile.iter().map(|p| p * (1.0 - p)).sum::<f64>();
    assert!((width / 20.0 - 1.0).abs() < 0.02, "{width}");
}

#[test]
fn later_images_are_taken_from_further_on() {
    // 0.05 s at 1 m/s are 10 pixels.
    let first = Recording { exposure_s: 1e-6, frame_interval_s: 0.05, ..steady(1.0, 0.0) };
    let bright = |recording| coverage(&scene(), &pinhole(-0.1).recording(recording)).iter().flatten().sum::<f64>();
    let moved = (bright(first.later(1)) - bright(first.clone())) / f64::from(RESOLUTION[1]);
    // The noise of 120 pixels at the edge, 0.5/√64 each, in two images: 0.008 pixels on average. 5 σ.
    assert!((moved - 10.0).abs() < 0.04, "{moved}");
}

#[test]
fn a_line_camera_that_moves_makes_an_ellipse_of_a_circle() {
    // A disk of radius 60 mm, 1 m away: 12 columns of 5 mm. The camera moves downwards by 2 mm from line to line: 30
    // lines.
    let (speed, line_time_s, radius) = (2.0, 1e-3, 0.06f32);
    let sectors: u16 = 720;
    let rim = |i: u16| {
        let angle = std::f32::consts::TAU * f32::from(i) / f32::from(sectors);
        Vec3::new(radius * angle.cos(), radius * angle.sin(), -1.0)
    };
    let disk = (0..sectors).map(|i| [Vec3::NEG_Z, rim(i), rim((i + 1) % sectors)]).collect();
    let scene = Stage::default().diffuse(disk, 0.0, 1.0).build();
    let mut lens = LensDescription::thin(2e-3, 8.0, Focus::Infinity);
    (lens.kind, lens.falloff) = (LensKind::Pinhole, Falloff::None);
    let grid = PixelGrid { resolution: [RESOLUTION[0], 1], pitch_m: [2e-3 / FX; 2] };
    // The disk is in the middle of 120 lines.
    let start = DAffine3::from_translation(DVec3::Y * (60.0 * line_time_s * speed));
    let motion = Trajectory::Steady { velocity_m_per_s: DVec3::NEG_Y * speed, angular_velocity_rad_per_s: DVec3::ZERO };
    let recording = Recording { motion: Some(motion), exposure_s: 1e-9, row_time_s: line_time_s, ..steady(0.0, 0.0) };
    let camera = camera(&lens, &grid, start).scanning().recording(recording);
    let image = irradiance(&scene, &camera, RESOLUTION, &SETTINGS);
    let values = &image.mean.channels()[0].data;
    // From the middle of the image; each line is seen at its start, by a pixel that is 2.5 lines high.
    let place = |i: usize| [(i % 96) as f64 + 0.5 - 48.0, (i / 96) as f64 - 60.0];
    let well_inside = |i: &usize| place(*i)[0].hypot(place(*i)[1] / 2.5) < 9.0;
    let inside: Vec<f64> = (0..values.len()).filter(well_inside).map(|i| f64::from(values[i])).collect();
    let level = inside.iter().sum::<f64>() / inside.len() as f64;
    let (mut area, mut x1, mut y1, mut x2, mut y2, mut xy) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (i, value) in values.iter().enumerate() {
        let part = f64::from(*value) / level;
        let [x, y] = place(i);
        area += part;
        (x1, y1) = (x1 + part * x, y1 + part * y);
        (x2, y2, xy) = (x2 + part * x * x, y2 + part * y * y, xy + part * x * y);
    }
    let (x1, y1) = (x1 / area, y1 / area);
    // An ellipse of semi-axes a, b has the area πab and the variances a²/4, b²/4. Pixels add those of a width of 1
    // column and of 2.5 lines.
    let (a, b) = (12.0, 30.0);
    let covered = std::f64::consts::PI * a * b;
    // Pixels at the rim, some 170 of them (two columns a line and what the ends have more), are wrong by up to 0.5/√64
    // each: 0.8 of 1131 pixels, and of the variances 2·0.07 % as these are 4 · (1/4 at most) times the rim's weight. 5
    // σ.
    assert!((area / covered - 1.0).abs() < 0.0036, "{area} of {covered}");
    let variances = [x2 / area - x1 * x1, y2 / area - y1 * y1];
    let expected = [a * a / 4.0 + 1.0 / 12.0, b * b / 4.0 + 2.5 * 2.5 / 12.0];
    for (found, expected) in variances.into_iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 0.0108, "{found} for {expected}");
    }
    assert!(x1.abs() < 0.05 && y1.abs() < 0.13 && (xy / area).abs() < 0.01 * a * b, "{x1} {y1} {xy}");
}
