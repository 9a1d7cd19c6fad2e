//! An estimate in words, for people.

use super::estimate::NoiseEstimate;
use super::patch::Variance;
use super::plane_fit::ChiSquared;
use super::sigma_distribution::SigmaDistribution;
use photosite_core::math::float::rounded;

/// Each figure of an estimate with its value, in the unit of the image, which may be empty.
pub fn figures(e: &NoiseEstimate, unit: &str) -> Vec<(&'static str, String)> {
    let variance = |v: &Variance| {
        format!("σ = {} {unit}, σ² = {} ± {}", number(v.sigma), number(v.variance), number(rounded(v.error, 2)))
    };
    let mut lines = vec![("mean", format!("{} {unit}", number(e.mean)))];
    if let Some(t) = &e.temporal {
        lines.push((
            "temporal noise",
            format!("{}; largest σ of a pixel {}", variance(&t.noise), number(t.largest_sigma)),
        ));
        lines.push(("σ of the pixels", distribution(&t.map)));
        let pattern = t.pattern.as_ref().map_or("hidden by the temporal noise".to_owned(), variance);
        lines.push(("fixed pattern", pattern));
    }
    lines.push(("as an even patch", variance(&e.uniform)));
    let [a, b] = e.plane.slope;
    lines.push((
        "after a plane",
        format!("{}; slope {} along x, {} along y per pixel", variance(&e.plane.noise), number(a), number(b)),
    ));
    if let Some(chi) = &e.plane.chi_squared {
        lines.push(("χ² of the plane", chi_squared(chi)));
    }
    if let Some(n) = &e.neighbourhoods {
        let side = n.side;
        lines.push(("planes in squares", format!("{}; squares of {side} × {side} pixels", variance(&n.noise))));
        lines.push(("σ of the squares", distribution(&n.sigmas)));
        lines.extend(n.chi_squared.as_ref().map(|chi| ("χ² of the squares", chi_squared(chi))));
    }
    let snr = &e.snr;
    if let (Some(ratio), Some(db), Some(bits)) = (snr.ratio, snr.db, snr.bits) {
        lines.push(("signal over noise", format!("{} = {} dB = {} bit", number(ratio), number(db), number(bits))));
    }
    if let (Some(ratio), Some(db)) = (snr.worst_ratio, snr.worst_db) {
        lines.push(("of the noisiest pixel", format!("{} = {} dB", number(ratio), number(db))));
    }
    if let Some(c) = &snr.contrast {
        let [signal, ratio, of_sigma, db] = [c.signal_sigma, c.ratio, c.db_of_sigma, c.db].map(number);
        lines.push((
            "σ of the signal over σ",
            format!("{signal} {unit} over noise: {ratio}, 10·log₁₀ of it {of_sigma} dB, 20·log₁₀ {db} dB"),
        ));
    }
    if let Some(bits) = snr.effective_bits {
        lines.push(("effective bits", number(bits)));
    }
    if let Some(q) = &e.quantisation {
        let part =
            q.part_percent.map_or(String::new(), |part| format!(", {} % of the variance", number(rounded(part, 3))));
        lines.push(("quantisation", format!("q²/12 = {}{part}", number(q.variance))));
    }
    let correlations = |lags: &[f64]| {
        let all: Vec<String> = lags[1..].iter().map(|c| format!("{:+.3}", c / lags[0])).collect();
        all.join(" ")
    };
    let c = &e.autocovariance;
    if c.along_rows[0] > 0.0 && c.along_rows.len() > 1 && c.along_columns.len() > 1 {
        lines.push((
            "correlation along rows",
            format!("{} (± {:.3})", correlations(&c.along_rows), c.correlation_error),
        ));
        lines.push(("correlation along columns", correlations(&c.along_columns)));
    }
    lines
}

fn number(x: f64) -> String {
    rounded(x, 5).to_string()
}

fn probability(p: f64) -> String {
    if p < 1e-4 { format!("{p:.0e}") } else { number(rounded(p, 3)) }
}

fn chi_squared(chi: &ChiSquared) -> String {
    let [value, reduced] = [chi.value, chi.reduced].map(number);
    format!("{value} for {} degrees of freedom, reduced {reduced}, p = {}", chi.freedom, probability(chi.p_value))
}

fn distribution(s: &SigmaDistribution) -> String {
    let [mean, median, spread, expected] = [s.mean, s.median, s.spread, s.expected_spread].map(number);
    format!(
        "mean {mean}, median {median}, spread {spread} (of one normal noise {expected}); from χ² of {} degrees of freedom \
         {} away, p = {}",
        s.freedom,
        number(rounded(s.distance, 3)),
        probability(s.p_value)
    )
}
