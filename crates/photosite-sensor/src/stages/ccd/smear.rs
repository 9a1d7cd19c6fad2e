//! Smear: light that reaches a column while its charge is on the move draws a line through every bright spot.
//!
//! A packet passes every row of its column once for each image: those on its way out after the exposure, the others
//! as an empty well on its way in. If it collects for the time τ in each row that it passes, row y of an exposure of
//! length t holds
//!
//! μ'(y) = μ(y) + τ/t · Σ μ(y'),  y' over all other rows of the column
//!
//! ([Ruyten99](photosite_core::references#ruyten99), eq. 1). In a frame-transfer CCD τ is the time that one row shift
//! takes. In an interline CCD light leaks into the shielded register beside the pixels; there the own row is passed,
//! too, and τ is the time to read a line times the leaking part of the light.
//!
//! The added light has shot noise like any other, so this acts on mean electrons.

/// Adds smear to mean electrons, `width` in a row, of an exposure of which each passed row takes the part `ratio` =
/// τ/t. `own_row`: whether the row of a packet itself counts among those that it passes. Returns, for each column, what
/// a well collects that passes all rows.
pub(crate) fn add(mean_electrons: &mut [f32], width: usize, ratio: f64, own_row: bool) -> Vec<f32> {
    let mut sums = vec![0.0f64; width];
    for row in mean_electrons.chunks_exact(width.max(1)) {
        sums.iter_mut().zip(row).for_each(|(sum, &mean)| *sum += f64::from(mean));
    }
    for row in mean_electrons.chunks_exact_mut(width.max(1)) {
        for (mean, sum) in row.iter_mut().zip(&sums) {
            let own = f64::from(*mean);
            let passed = if own_row { *sum } else { sum - own };
            *mean = (own + ratio * passed) as f32;
        }
    }
    sums.into_iter().map(|sum| (ratio * sum) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Ccd, CcdDescription};

    const WIDTH: usize = 5;
    const HEIGHT: usize = 40;

    fn spot() -> Vec<f32> {
        let mut plane = vec![0.0; WIDTH * HEIGHT];
        plane[17 * WIDTH + 2] = 4096.0;
        plane[18 * WIDTH + 2] = 2048.0;
        plane[3 * WIDTH + 4] = 512.0;
        plane
    }

    #[test]
    fn a_spot_draws_a_line_through_its_column_alone() {
        let mut plane = spot();
        // A power of two, so that f32 holds every value.
        let passing = add(&mut plane, WIDTH, 1.0 / 1024.0, false);
        assert_eq!(passing, [0.0, 0.0, 6.0, 0.0, 0.5]);
        for (i, &e) in plane.iter().enumerate() {
            let expected = match (i % WIDTH, i / WIDTH) {
                (2, 17) => 4096.0 + 2.0,
                (2, 18) => 2048.0 + 4.0,
                (2, _) => 6.0,
                (4, 3) => 512.0,
                (4, _) => 0.5,
                _ => 0.0,
            };
            assert_eq!(e, expected, "pixel {i}");
        }
        // What was added is the light of the time on the move: every row collects in all rows but its own.
        let total = |plane: &[f32]| plane.iter().map(|&e| f64::from(e)).sum::<f64>();
        assert_eq!(total(&plane), total(&spot()) * (1.0 + (HEIGHT - 1) as f64 / 1024.0));
    }

    #[test]
    fn the_figure_of_a_data_sheet_comes_back() {
        // Its measurement: a tenth of the rows lit, read in the time of the exposure.
        let description =
            CcdDescription { smear_db: Some(-60.0), line_time_us: Some(30.0), ..CcdDescription::default() };
        let row_time = Ccd::new(&description).expect("an interline CCD").smear_row_time;
        let exposure = 30e-6 * HEIGHT as f64;
        let mut plane = vec![0.0; WIDTH * HEIGHT];
        plane[16 * WIDTH..20 * WIDTH].fill(10_000.0);
        add(&mut plane, WIDTH, row_time.0 / exposure, true);
        // −60 dB of 10 000 e⁻; f32 rounds to 2⁻²⁴ of it.
        assert!((plane[0] - 10.0).abs() < 1e-5, "{}", plane[0]);
    }
}
