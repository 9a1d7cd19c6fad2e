//! Brighter-fatter effect: the charge that a pixel has collected repels what comes after, so that the boundary to a
//! neighbour with less charge moves inwards. Bright spots grow, and neighbours on a flat field share some of their shot
//! noise: variance stays below the mean and neighbours are correlated.
//!
//! While an image builds up, the boundary between pixels p and q is displaced in proportion to the difference of the
//! charges that they hold and so hands over that part of what falls near it, (Q_p + Q_q)/2. A pixel holds no more than
//! its full well F: what it holds on average over the exposure, h/2, is half of the light's charge Q up to F, and tends to
//! F beyond:
//!
//! ΔQ(p → q) = a/4 · (h_p − h_q) · (Q_p + Q_q),  h = Q up to F, 2F − F²/Q beyond
//!
//! which is a/4 · (Q_p² − Q_q²) below saturation
//! ([Antilogus14](photosite_core::references#antilogus14), restricted to nearest neighbours;
//! [Guyonnet15](photosite_core::references#guyonnet15) eq. 10). What one pixel loses its neighbour gains. A boundary takes
//! at most a·F of a pixel's charge, and sensors have (a_x + a_y)·F ≤ ½, so that light of any strength leaves charge in
//! each pixel, and more light more of it. On a flat field of mean μ with shot noise, to first order in a·μ,
//!
//! neighbours along x are correlated by a_x·μ, along y by a_y·μ, and Var(Q) = μ·(1 − 2·(a_x + a_y)·μ),
//!
//! so that variance and all covariances together are still μ.

use photosite_core::rows::for_each_row;

use super::frame::Frame;
use crate::signal::charge_plane::ChargePlane;
use crate::signal::effects::Stage;

/// Lets the boundaries of a whole image move.
pub(crate) fn apply(frame: &Frame<'_>, charge: &mut ChargePlane) {
    let per_e = frame.sensor.brighter_fatter_per_e;
    if per_e != [0.0; 2] && frame.stages.has(Stage::BrighterFatter) {
        spread(&mut charge.electrons, charge.width, charge.samples, per_e, frame.sensor.full_well.0);
    }
}

/// Hands charge (e⁻, `width` in a row, neighbours `samples` apart) over the boundaries. `per_e`: a_x and a_y, the
/// correlation of neighbours along x and along y for each electron of a flat field, 1/e⁻; (a_x + a_y)·`full_well_e` is
/// at most ½.
fn spread(charges: &mut [f32], width: usize, samples: usize, per_e: [f64; 2], full_well_e: f64) {
    let [along_x, along_y] = per_e.map(|a| a / 4.0);
    let held = |q: f64| if q <= full_well_e { q } else { 2.0 * full_well_e - full_well_e * full_well_e / q };
    let flow = |a: f64, from: f64, to: f64| a * (held(from) - held(to)) * (from + to);
    let before = charges.to_vec();
    let rows: Vec<&[f32]> = before.chunks_exact(width.max(1)).collect();
    for_each_row(charges, width, |y, row| {
        let above = y.checked_sub(1).map(|y| rows[y]);
        let below = rows.get(y + 1);
        for (x, charge) in row.iter_mut().enumerate() {
            let own = f64::from(rows[y][x]);
            let gain = |a: f64, neighbour: Option<&f32>| neighbour.map_or(0.0, |&q| flow(a, f64::from(q), own));
            let left = x.checked_sub(samples).and_then(|x| rows[y].get(x));
            // A boundary's flow is computed alike on both of its sides, so that one gains what the other loses.
            let gained = gain(along_x, left)
                + gain(along_x, rows[y].get(x + samples))
                + gain(along_y, above.map(|row| &row[x]))
                + gain(along_y, below.map(|row| &row[x]));
            *charge = (own + gained) as f32;
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::shot_noise::poisson;
    use photosite_core::math::philox::Philox;
    use photosite_core::math::statistics::Moments;

    #[test]
    fn a_spot_grows_and_keeps_its_charge() {
        let mut plane = vec![0.0f32; 49];
        plane[24] = 40_000.0;
        spread(&mut plane, 7, 1, [1e-6, 2e-6], 1e5);
        // a/4·Q²: 400 e⁻ to either side and 800 e⁻ up and down.
        assert_eq!([plane[23], plane[25], plane[17], plane[31]], [400.0, 400.0, 800.0, 800.0]);
        assert_eq!(plane[24], 40_000.0 - 2400.0);
        assert_eq!(plane.iter().sum::<f32>(), 40_000.0);
    }

    /// Integrates a lamp and its dark neighbours in steps of time, each pixel holding no more than its full well.
    #[test]
    fn a_lamp_beyond_saturation_loses_what_the_equation_of_motion_says() {
        const STEPS: u32 = 20_000;
        let (full_well_e, per_e) = (60_000.0, [3e-6, 5e-6]);
        for lamp_e in [50_000.0, 100_000.0, 1e6, 1e9] {
            let mut plane = vec![0.0f32; 25];
            plane[12] = lamp_e as f32;
            spread(&mut plane, 5, 1, per_e, full_well_e);
            for (neighbour, a) in [(11, per_e[0]), (7, per_e[1])] {
                let arrives = lamp_e / f64::from(STEPS);
                let held = |step: u32| (arrives * (f64::from(step) + 0.5)).min(full_well_e);
                let handed_over: f64 = (0..STEPS).map(|step| a * held(step) * arrives / 2.0).sum();
                // The midpoint rule misses the bend of `held` by less than a step, 1/20 000; f32 rounds to 6e-8.
                let found = f64::from(plane[neighbour]);
                assert!((found / handed_over - 1.0).abs() < 1e-4, "{lamp_e}: {found} for {handed_over}");
            }
            assert!(f64::from(plane[12]) > 0.5 * lamp_e, "{lamp_e}: {} left", plane[12]);
        }
    }

    #[test]
    fn a_flat_field_is_left_alone_and_charge_conserved() {
        let mut flat = vec![12_345.0f32; 60];
        spread(&mut flat, 6, 2, [1e-6, 1e-6], 1e4);
        assert!(flat.iter().all(|&q| q == 12_345.0));
        let mut plane: Vec<f32> = (0..600).map(|i| (i * 7919 % 30_011) as f32).collect();
        let total = |plane: &[f32]| plane.iter().map(|&q| f64::from(q)).sum::<f64>();
        let before = total(&plane);
        spread(&mut plane, 20, 1, [2e-6, 1e-6], 1e4);
        // f32 rounds each of 600 pixels to 2⁻²⁴ of at most 2¹⁵.
        assert!((total(&plane) - before).abs() < 600.0 * 2f64.powi(-10), "{}", total(&plane) - before);
    }

    #[test]
    fn noise_of_a_flat_field_is_shared_with_neighbours() {
        const SIDE: usize = 500;
        let (mean_e, per_e) = (20_000.0, [1e-6, 2e-6]);
        let mut plane: Vec<f32> =
            (0..SIDE * SIDE).map(|i| poisson(mean_e, &mut Philox::new(5, i as u64)) as f32).collect();
        spread(&mut plane, SIDE, 1, per_e, 1e5);
        let inner = |x: usize, y: usize| f64::from(plane[y * SIDE + x]) - mean_e;
        let covariance = |dx: usize, dy: usize| -> f64 {
            let all = (1..SIDE - 2).flat_map(|y| (1..SIDE - 2).map(move |x| (x, y)));
            let products: Moments = all.map(|(x, y)| inner(x, y) * inner(x + dx, y + dy)).collect();
            products.mean() / mean_e
        };
        let spread_of_one = 1.0 / (SIDE as f64);
        // The exact linear response, of which the model states the first order: the pixel keeps 1 − 4b, b_x = a_x·μ/2
        // goes to each neighbour. Variance over mean is (1 − 2b_x − 2b_y)² + 2b_x² + 2b_y²; √2/500 is the standard
        // deviation of a sample variance of 500² numbers, 1/500 that of a correlation; 5 σ.
        let [bx, by] = per_e.map(|a| a * mean_e / 2.0);
        let keep = 1.0 - 2.0 * (bx + by);
        let variance = keep * keep + 2.0 * (bx * bx + by * by);
        assert!((covariance(0, 0) - variance).abs() < 5.0 * 2f64.sqrt() * spread_of_one, "{}", covariance(0, 0));
        for (dx, dy, b) in [(1, 0, bx), (0, 1, by)] {
            let expected = 2.0 * b * keep;
            let found = covariance(dx, dy);
            assert!((found - expected).abs() < 5.0 * spread_of_one, "{found} for {expected}");
            assert!(expected > 8.0 * spread_of_one, "the test could not tell it from nothing");
        }
    }
}
