//! Image lag from frame to frame of a series, by whatever command the frames are made.

use rstest::rstest;

use crate::dataset::BOARD;
use crate::folder::Folder;

const LAG: &str = "charge.image_lag = { percent = 10, decay = 0.5 }";

fn folder(camera: &str, exposure: &str) -> Folder {
    let capture = BOARD
        .replace("look_at_m = [0, 0, 0]\n", &format!("look_at_m = [0, 0, 0]\n{camera}\n"))
        .replace("pixel_pitch_um = [200, 200]\n", &format!("pixel_pitch_um = [200, 200]\n{LAG}\n"))
        .replace("time_s = 0.004\n", &format!("time_s = 1e-6\n{exposure}\n"))
        .replace("samples_per_pixel = 1\n", "samples_per_pixel = 256\n")
        .replace("electrons = false\n", "");
    Folder::new([("board.toml", capture.into())])
}

fn mean_dn(folder: &Folder, file: &str) -> f64 {
    let raw = folder.raw(file);
    let sum: f64 = raw.data.iter().map(|&dn| f64::from(dn)).sum();
    sum / raw.data.len() as f64 - f64::from(raw.black_level_dn.at(0, 0))
}

#[rstest]
#[case::still("")]
#[case::moving("[camera.motion]\nvelocity_m_per_s = [0, 0, 0.001]")]
fn frames_of_a_series_leave_charge_to_each_other(#[case] motion: &str) {
    let folder = folder(motion, "frames = 5\nframe_interval_s = 0.01");
    folder.succeed("render board.toml -o out --quiet");
    // Of a signal q, frame n reads q·(1 − ℓ) + (1 − d)·s, where s has grown to ℓ·q·(1 − dⁿ)/(1 − d): q·(1 − ℓ·dⁿ).
    let found: Vec<f64> = (0..5).map(|n| mean_dn(&folder, &format!("out/raw-{n:04}.dng"))).collect();
    let q = found[4] / (1.0 - 0.1 * 0.5_f64.powi(4));
    assert!(q > 200.0, "{found:?}");
    for (n, found) in found.iter().enumerate() {
        let expected = q * (1.0 - 0.1 * 0.5_f64.powi(n as i32));
        // Shot noise of 768 pixels with more electrons than DN, in this frame and the last: 1/√(768·q) each. A moving
        // frame has samples of its own: 768·256 of them, whose spread is below their mean.
        let of_light = if motion.is_empty() { 0.0 } else { 1.0 / (768.0 * 256.0) };
        let spread = (2.0 * (1.0 / (768.0 * q) + of_light)).sqrt();
        assert!((found / expected - 1.0).abs() < 5.0 * spread, "frame {n}: {found} for {expected}");
    }
    // The same light gives the same frames again.
    folder.succeed("expose out -o again --quiet");
    for n in 0..5 {
        let [first, second] = ["out", "again"].map(|out| folder.raw(&format!("{out}/raw-{n:04}.dng")).data);
        assert!(first == second, "frame {n}");
    }
}

#[test]
fn a_data_set_says_that_its_images_start_empty() {
    let folder = folder("", "");
    folder.add("set.toml", "capture = 'board.toml'\nframes = 2\n");
    let told = folder.succeed("dataset set.toml -o set").text();
    assert_eq!(told.matches("image_lag").count(), 1, "{told}");
}
