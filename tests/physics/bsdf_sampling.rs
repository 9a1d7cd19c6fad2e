//! Samplers against their densities: Pearson's χ² over the sphere, and estimates against numerical integrals.

use std::f64::consts::PI;

use glam::{Vec3, Vec4};
use photosite::bsdf::{Bsdf, Ggx};
use photosite::math::statistics::{Moments, chi_squared};
use photosite::spectrum::SampledSpectrum;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::bsdf_cases::{Case, SAMPLES, Uniform, drawn, gold, visible_from, wide};
use super::quadrature::{Cell, integrate_sphere};

pub(crate) const ROWS: usize = 24;
pub(crate) const COLUMNS: usize = 48;

/// Probability that all cases together fail though every sampler is right.
const SIGNIFICANCE: f64 = 0.01;

pub(crate) fn bin(w: Vec3) -> usize {
    let row = ((f64::from(w.z) + 1.0) * 0.5 * ROWS as f64) as usize;
    let turns = (f64::from(w.y).atan2(f64::from(w.x)) / (2.0 * PI)).rem_euclid(1.0);
    row.min(ROWS - 1) * COLUMNS + ((turns * COLUMNS as f64) as usize).min(COLUMNS - 1)
}

/// How many samples fall into each bin; one bin more for those that lead nowhere or into a single direction.
fn histogram(bsdf: &Bsdf, wo: Vec3, seed: usize) -> Vec<f64> {
    let mut uniform = Uniform::new(seed);
    let mut counts = vec![0.0; ROWS * COLUMNS + 1];
    for _ in 0..SAMPLES {
        let (u_lobe, u) = uniform.lobe_and_direction();
        let at = bsdf.sample(wo, u_lobe, u).filter(|s| !s.is_delta).map_or(ROWS * COLUMNS, |s| bin(s.wi));
        counts[at] += 1.0;
    }
    counts
}

/// How many are expected there, by integrating the density over each bin.
fn expectation(pdf: impl Fn(Vec3) -> f64) -> Vec<f64> {
    // A bin of which the support takes a rim only, as refraction does up to the critical angle, may come out as 0: its
    // slices do not. What is left out then has it pooled with others. 1e-6 a bin is 0.1 of 100 000 samples, below the
    // noise of any bin that counts (expectation 5, σ = 2.2).
    let integral = |cell: &Cell| match cell.integrate(&pdf, 1e-6) {
        0.0 => cell.slices(32).iter().map(|slice| slice.integrate(&pdf, 1e-7)).sum(),
        found => found,
    };
    let mut expected: Vec<f64> =
        Cell::sphere(ROWS, COLUMNS).iter().map(|cell| (SAMPLES as f64 * integral(cell)).max(1e-6)).collect();
    expected.push((SAMPLES as f64 - expected.iter().sum::<f64>()).max(1e-6));
    expected
}

/// Probability of a worse fit by chance.
pub(crate) fn p_value(observed: &[f64], expected: &[f64]) -> f64 {
    let (statistic, freedom) = chi_squared(observed, expected);
    if freedom == 0 {
        return 1.0;
    }
    ChiSquared::new(f64::from(freedom)).expect("degrees of freedom are positive").sf(statistic)
}

/// The smallest p-value that a right sampler is allowed when so many are tested (Šidák's correction).
fn threshold(tests: usize) -> f64 {
    1.0 - (1.0 - SIGNIFICANCE).powf(1.0 / tests as f64)
}

/// All BSDFs from all directions; layers, of which there are many, from the oblique ones, where every lobe counts.
fn views() -> Vec<(Case, String, Vec3)> {
    let views = |case: Case| {
        let is_layered = matches!(case.bsdf, Bsdf::Layered(_));
        let directions = visible_from(&case.bsdf).into_iter().filter(move |(_, wo)| !is_layered || wo.z < 0.6);
        directions.map(move |(from, wo)| (case.clone(), from, wo))
    };
    wide().into_iter().chain(drawn(3)).flat_map(views).collect()
}

#[test]
fn samples_are_distributed_as_the_density_says() {
    let views = views();
    let threshold = threshold(views.len());
    for (seed, (case, from, wo)) in views.iter().enumerate() {
        let observed = histogram(&case.bsdf, *wo, seed);
        let expected = expectation(|wi| f64::from(case.bsdf.eval(*wo, wi).pdf.0));
        let p = p_value(&observed, &expected);
        assert!(p > threshold, "{} {from}: p = {p:e}, {:?}", case.name, chi_squared(&observed, &expected));

        // ∫ pdf is what is not lost: 5σ of the binomial, and 1e-4 for the integral.
        let part = |counts: &[f64]| counts[..ROWS * COLUMNS].iter().sum::<f64>() / SAMPLES as f64;
        let (found, total) = (part(&observed), part(&expected));
        let sigma = (found * (1.0 - found) / SAMPLES as f64).sqrt();
        assert!(total < 1.0 + 1e-4, "{} {from}: ∫ pdf = {total}", case.name);
        assert!((found - total).abs() < 5.0 * sigma + 1e-4, "{} {from}: {found} drawn of {total}", case.name);
    }
}

#[test]
fn a_density_that_is_wrong_by_five_percent_is_caught() {
    let (right, rougher) = (gold(Ggx::new(0.3, 0.3)), gold(Ggx::new(0.315, 0.315)));
    let wo = Vec3::new(0.6, 0.0, 0.8);
    let observed = histogram(&right, wo, 0);
    let pdf = |bsdf: &Bsdf, wi| f64::from(bsdf.eval(wo, wi).pdf.0);
    let wrong: [(&str, Vec<f64>); 3] = [
        ("too large", expectation(|wi| 1.05 * pdf(&right, wi))),
        ("tilted", expectation(|wi| (1.0 + 0.05 * f64::from(wi.y).signum()) * pdf(&right, wi))),
        ("of a rougher surface", expectation(|wi| pdf(&rougher, wi))),
    ];
    assert!(p_value(&observed, &expectation(|wi| pdf(&right, wi))) > SIGNIFICANCE);
    for (name, expected) in wrong {
        let p = p_value(&observed, &expected);
        assert!(p < threshold(views().len()), "a density {name} goes unnoticed: p = {p}");
    }
}

/// A mean over the lanes with weights that tell them apart.
fn one_number(f: SampledSpectrum) -> f32 {
    f.0.dot(Vec4::new(0.1, 0.2, 0.3, 0.4))
}

#[test]
fn estimates_agree_with_the_integral_of_f_times_cosine() {
    // Two views a case: that values belong to their densities is checked sample by sample below.
    for (seed, (case, from, wo)) in
        views().into_iter().filter(|(_, _, wo)| (wo.z - 0.5).abs() < 0.1 || wo.z < -0.8).enumerate()
    {
        let mut uniform = Uniform::new(1000 + seed);
        let mut lobes = Moments::default();
        for _ in 0..SAMPLES {
            let (u_lobe, u) = uniform.lobe_and_direction();
            let sample = case.bsdf.sample(wo, u_lobe, u).filter(|sample| !sample.is_delta);
            lobes.add(f64::from(sample.map_or(0.0, |sample| one_number(sample.throughput()))));
        }
        let integral = integrate_sphere(|wi| f64::from(one_number(case.bsdf.eval(wo, wi).f) * wi.z.abs()));
        // 5σ of the estimate (chance of 6e-7, some 40 times), and the quadrature's 1e-4.
        let tolerance = 5.0 * lobes.variance_of_mean().sqrt() + 1e-4;
        assert!(
            (lobes.mean() - integral).abs() < tolerance,
            "{} {from}: {} is not {integral}",
            case.name,
            lobes.mean()
        );
    }
}

#[test]
fn a_sample_carries_the_value_and_density_of_its_direction() {
    for (seed, (case, from, wo)) in views().into_iter().enumerate() {
        let mut uniform = Uniform::new(2000 + seed);
        for _ in 0..1000 {
            let (u_lobe, u) = uniform.lobe_and_direction();
            let Some(sample) = case.bsdf.sample(wo, u_lobe, u).filter(|s| !s.is_delta) else { continue };
            let again = case.bsdf.eval(wo, sample.wi);
            // As for reciprocity: rounding of the half vector times the slope of D.
            let close = |a: f32, b: f32| (a - b).abs() <= 1e-3 * a.max(b) + 1e-6;
            let name = format!("{} {from}: {sample:?} {again:?}", case.name);
            assert!(close(sample.pdf.0, again.pdf.0) && (0..4).all(|i| close(sample.f[i], again.f[i])), "{name}");
            assert!((sample.wi.length() - 1.0).abs() < 1e-6, "{name}");
            assert_eq!(sample.is_transmission, wo.z * sample.wi.z < 0.0, "{name}");
        }
    }
}
