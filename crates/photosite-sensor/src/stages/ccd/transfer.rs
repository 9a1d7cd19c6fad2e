//! Charge transfer: a packet of electrons is shifted from well to well until it reaches the end of its line, and at
//! every shift a few electrons stay behind and join the packet that follows.
//!
//! An electron stays behind at a shift with the probability ε, the charge-transfer inefficiency (CTI). One that starts
//! n shifts away from the end makes n shifts that succeed and k that do not, so it arrives in the k-th packet behind
//! its own with the probability
//!
//! P(k) = C(n + k − 1, k) · (1 − ε)ⁿ · εᵏ,
//!
//! the negative binomial distribution (the linear model of [Janesick01](photosite_core::references#janesick01), §5.3).
//! Every electron is drawn for itself, so charge is conserved to the electron and Poisson-distributed charge stays so.
//! Traps that fill up, whose inefficiency depends on the charge, are left out.

use photosite_core::math::philox::Philox;

use crate::stages::shot_noise::part_of;

/// Shifts the packets of a line, of which the first is next to its end, until all are out: `line` holds packets before,
/// and what arrives in their place after. Packet i is shifted `shifts + i` times, `shifts` of at least 1. Returns the
/// electrons that arrive after the last packet.
///
/// Only whole electrons stay behind: a fraction, or a negative charge, goes with its packet. Without random numbers
/// for a packet the mean of it stays behind.
pub(crate) fn shift_out(
    line: &mut [f64],
    inefficiency: f64,
    shifts: usize,
    random: impl Fn(usize) -> Option<Philox>,
) -> f64 {
    let mut late = 0.0;
    // From the far end, so that electrons which were left behind already are not shifted again.
    for i in (0..line.len()).rev() {
        let mut random = random(i);
        let electrons = if random.is_some() { line[i].floor() } else { line[i] }.max(0.0);
        if electrons == 0.0 {
            continue;
        }
        let n = (shifts + i) as f64;
        let log_all_succeed = n * (-inefficiency).ln_1p();
        let mut probability = log_all_succeed.exp();
        // Probability of arriving at k or later, and the electrons that do.
        let mut later = -log_all_succeed.exp_m1();
        let mut behind = part_of(electrons, later, random.as_mut());
        line[i] -= behind;
        for k in 1.. {
            if behind == 0.0 {
                break;
            }
            probability *= inefficiency * (n + k as f64 - 1.0) / k as f64;
            let arrive =
                if probability < later { part_of(behind, probability / later, random.as_mut()) } else { behind };
            later -= probability;
            behind -= arrive;
            match line.get_mut(i + k) {
                Some(packet) => *packet += arrive,
                None => {
                    late += arrive + behind;
                    break;
                }
            }
        }
    }
    late
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::math::statistics::Moments;

    const LENGTH: usize = 60;

    /// Shifts a line, with random numbers of its own for each `trial`.
    fn shifted(mut line: Vec<f64>, inefficiency: f64, shifts: usize, trial: u64) -> (Vec<f64>, f64) {
        let late = shift_out(&mut line, inefficiency, shifts, |i| Some(Philox::new(trial, i as u64)));
        (line, late)
    }

    #[test]
    fn every_electron_is_kept() {
        let line: Vec<f64> = (0..LENGTH).map(|i| (i * 731 % 997) as f64 * 40.0 + 0.25).chain([-3.5, 0.0]).collect();
        let total: f64 = line.iter().sum();
        for inefficiency in [0.0, 1e-6, 1e-3, 0.05, 0.3] {
            let (out, late) = shifted(line.clone(), inefficiency, 5, 1);
            // Quarters and halves are exact in f64.
            assert_eq!(out.iter().sum::<f64>() + late, total, "{inefficiency}");
            assert_eq!(out == line, inefficiency == 0.0);
        }
    }

    /// Shifts a line by definition: at each shift every packet leaves a part ε to the next, one shift at a time.
    fn one_shift_at_a_time(line: &[f64], inefficiency: f64, shifts: usize) -> Vec<f64> {
        let wells = shifts + line.len();
        let mut register = vec![0.0; wells];
        register[shifts - 1..shifts - 1 + line.len()].copy_from_slice(line);
        let mut out = vec![0.0; wells - 1];
        for arrived in &mut out {
            for well in 0..wells {
                let moved = register[well] * (1.0 - inefficiency);
                register[well] -= moved;
                match well {
                    0 => *arrived += moved,
                    _ => register[well - 1] += moved,
                }
            }
        }
        out.split_off(shifts - 1)
    }

    #[test]
    fn the_trail_is_that_of_single_shifts() {
        let mut line = vec![0.0; LENGTH];
        (line[3], line[20], line[21]) = (30_000.0, 50_000.0, 9_000.0);
        for (inefficiency, shifts) in [(1e-3, 1), (1e-3, 40), (0.02, 7)] {
            const TRIALS: u16 = 400;
            let mut means = vec![0.0; LENGTH];
            for trial in 0..TRIALS {
                let (out, _) = shifted(line.clone(), inefficiency, shifts, trial.into());
                means.iter_mut().zip(out).for_each(|(mean, e)| *mean += e / f64::from(TRIALS));
            }
            let expected = one_shift_at_a_time(&line, inefficiency, shifts);
            for (i, (mean, expected)) in means.iter().zip(&expected).enumerate() {
                // The variance of a binomial count is at most its mean, and at most what is missing from the packet:
                // √(e/n) for the mean of n, 5 σ, and 5/n for counts so rare that they are Poisson's.
                let spread = 5.0 * (expected / f64::from(TRIALS)).sqrt() + 5.0 / f64::from(TRIALS);
                assert!((mean - expected).abs() < spread, "ε = {inefficiency}, packet {i}: {mean} for {expected}");
            }
        }
    }

    #[test]
    fn flat_light_keeps_the_variance_of_shot_noise() {
        use crate::stages::shot_noise::poisson;
        let mean_e = 400.0;
        let mut all = Moments::default();
        for trial in 0..300 {
            let line = (0..200).map(|i| poisson(mean_e, &mut Philox::new(trial, 1 << 32 | i))).collect();
            // Packets that have had many before them, so that as much comes in as stays behind.
            shifted(line, 0.002, 100, trial).0[20..].iter().for_each(|&e| all.add(e));
        }
        // Packet i receives Σₖ C(n + i − 1, k)·(1 − ε)^(n + i − k)·εᵏ = 1 − ε of the mean: the line leaves a little
        // longer than it came. 54 000 numbers: relative standard deviations 1/√(400·n) of the mean and √(2/n) of the
        // variance; 5 σ. A model that moved mean charge would lose 2·ε·n = 48 % of the variance and more.
        let (n, expected) = (54_000f64, mean_e * (1.0 - 0.002));
        assert!((all.mean() / expected - 1.0).abs() < 5.0 / (400.0 * n).sqrt(), "{}", all.mean());
        assert!((all.variance() / expected - 1.0).abs() < 5.0 * (2.0 / n).sqrt(), "{}", all.variance());
    }
}
