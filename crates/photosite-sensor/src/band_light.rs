//! Electrons from irradiance that is known in spectral bands.

use rayon::prelude::*;

use photosite_core::Invalid;
use photosite_core::image::{Channel, Planes};
use photosite_core::spectrum::Spectrum;

use super::SensorModel;

/// Electron rates, with warnings.
#[derive(Clone, Debug, PartialEq)]
pub struct BandRates {
    /// e⁻/s, a plane for each of the sensor's channels.
    pub rates: Planes,
    /// Warnings about light that the bands leave out.
    pub warnings: Vec<String>,
}

/// Part of a channel's signal that may lie outside the bands without a warning.
const UNSEEN: f64 = 0.01;

/// Electron rates, e⁻/s, that irradiance in bands, W·m⁻²·nm⁻¹, frees in each channel:
///
/// rate_c = Σ_b E_b · ∫_b R_c(λ) dλ
///
/// with the response R_c of [`SensorModel::responses`] over the band b, in which the irradiance counts as constant.
/// Planes are named by the central wavelengths of their bands in nm and sorted by them; bands reach half way to their
/// neighbours. `light`, in any unit, tells how much of the signal lies outside all bands: that is missing, and
/// reported.
pub fn electron_rates(bands: &Planes, sensor: &SensorModel, light: &Spectrum) -> Result<BandRates, Invalid> {
    let edges = edges_nm(bands)?;
    let mut warnings = Vec::new();
    let mut channels = Vec::new();
    for (name, response) in sensor.responses() {
        let (first, last) = (edges[0], edges[edges.len() - 1]);
        let unseen = 1.0 - share(&response.product(light), [first, last]);
        if unseen > UNSEEN {
            let percent = (unseen * 100.0).round();
            warnings.push(format!(
                "the stored irradiance spans {first} to {last} nm; about {percent} % of what channel {name} sees lies outside \
                 and is missing"
            ));
        }
        let total = response.integral();
        let weights: Vec<f32> =
            edges.windows(2).map(|edge| (total * share(&response, [edge[0], edge[1]])) as f32).collect();
        channels.push(Channel { name, data: weighted_sum(bands, &weights) });
    }
    Ok(BandRates { rates: Planes::new(bands.width(), bands.height(), channels)?, warnings })
}

/// Edges of the bands, one more than there are bands.
fn edges_nm(bands: &Planes) -> Result<Vec<f64>, Invalid> {
    let centres: Option<Vec<f64>> = bands.channels().iter().map(|c| c.name.parse().ok()).collect();
    let centres = centres.filter(|c| c.iter().all(|l| l.is_finite()) && c.is_sorted_by(|a, b| a < b));
    let Some(centres) = centres.filter(|centres| centres.len() > 1) else {
        let invalid = Invalid::new("", "does not hold two or more spectral bands at different wavelengths");
        return Err(invalid.help("write bands with output.irradiance = { bands_nm = [400, 700, 10] }"));
    };
    let between: Vec<f64> = centres.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let n = centres.len();
    let mut edges = vec![2.0 * centres[0] - between[0]];
    edges.extend(&between);
    edges.push(2.0 * centres[n - 1] - between[n - 2]);
    Ok(edges)
}

/// Part of the integral of a spectrum that lies between two wavelengths. The table is linear in between its entries.
fn share(spectrum: &Spectrum, [low, high]: [f64; 2]) -> f64 {
    let total = spectrum.integral();
    if total <= 0.0 {
        return 1.0;
    }
    let values: Vec<(f64, f64)> = spectrum.iter().collect();
    let pieces = values.windows(2).map(|pair| {
        let [(l0, v0), (l1, v1)] = [pair[0], pair[1]];
        let (from, to) = (low.max(l0), high.min(l1));
        if from >= to {
            return 0.0;
        }
        let at = |l: f64| v0 + (v1 - v0) * (l - l0) / (l1 - l0);
        0.5 * (at(from) + at(to)) * (to - from)
    });
    pieces.sum::<f64>() / total
}

fn weighted_sum(bands: &Planes, weights: &[f32]) -> Vec<f32> {
    /// Short enough that the sums stay in the cache while all bands are added to them.
    const BLOCK: usize = 1 << 12;
    let mut sums = vec![0.0f32; bands.width() * bands.height()];
    sums.par_chunks_mut(BLOCK).enumerate().for_each(|(block, sums)| {
        let first = block * BLOCK;
        for (band, &weight) in bands.channels().iter().zip(weights) {
            let values = &band.data[first..first + sums.len()];
            sums.iter_mut().zip(values).for_each(|(sum, &value)| *sum += weight * value);
        }
    });
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::presets;

    fn planes(centres: impl Iterator<Item = f64>, value: impl Fn(f64) -> f64) -> Planes {
        let channel = |l: f64| Channel { name: l.to_string(), data: vec![value(l) as f32; 6] };
        Planes::new(3, 2, centres.map(channel).collect()).expect("right sizes")
    }

    #[test]
    fn bands_of_equal_light_give_the_integral_of_the_response() {
        let sensor = presets::model(presets::DEFAULT).expect("a preset");
        for width in [1.0, 10.0, 16.0] {
            let count = (800.0 / width) as u32;
            let bands = planes((0..count).map(|i| 300.0 + width * (f64::from(i) + 0.5)), |_| 2e-3);
            let rates = electron_rates(&bands, &sensor, &Spectrum::constant(1.0)).expect("bands");
            assert_eq!(rates.warnings, [""; 0]);
            for (plane, (name, response)) in rates.rates.channels().iter().zip(sensor.responses()) {
                // Up to 800 sums in single precision, each rounded to 2⁻²⁴.
                let expected = 2e-3 * response.integral();
                assert!((f64::from(plane.data[5]) / expected - 1.0).abs() < 800.0 / 16_777_216.0, "{name}");
            }
        }
    }

    #[test]
    fn light_of_a_slope_is_exact_where_the_response_is_flat() {
        // ∫ R·(a + b·λ) over bands in which R·λ is a parabola: the midpoint rule errs by (Δλ)²/12 · R′·b a band.
        let sensor = presets::model(presets::DEFAULT).expect("a preset");
        let slope = |l: f64| 1e-3 * (1.0 + (l - 300.0) / 800.0);
        let bands = planes((0..160).map(|i| 302.5 + 5.0 * f64::from(i)), slope);
        let rates = electron_rates(&bands, &sensor, &Spectrum::constant(1.0)).expect("bands");
        for (plane, (name, response)) in rates.rates.channels().iter().zip(sensor.responses()) {
            let expected = response.product(&Spectrum::from_fn(slope)).integral();
            // |Σ R′·b·Δλ³/12| ≤ 2·R_max · b · Δλ²/12 for a response with one maximum; b/E ≈ 1/800 per nm, and the
            // integral is at least 40 nm of R_max·E: 2 · 25/12/800/40 = 1.3e-4.
            assert!((f64::from(plane.data[0]) / expected - 1.0).abs() < 1.3e-4, "{name}");
        }
    }

    #[test]
    fn missing_wavelengths_are_reported_and_single_bands_refused() {
        let sensor = presets::model(presets::DEFAULT).expect("a preset");
        let narrow = planes([555.0, 565.0].into_iter(), |_| 1.0);
        let rates = electron_rates(&narrow, &sensor, &Spectrum::constant(1.0)).expect("bands");
        assert_eq!(rates.warnings.len(), 3);
        assert!(rates.warnings[0].contains("550 to 570 nm"), "{}", rates.warnings[0]);
        for bad in [planes([555.0].into_iter(), |_| 1.0), planes([565.0, 555.0].into_iter(), |_| 1.0)] {
            assert!(electron_rates(&bad, &sensor, &Spectrum::constant(1.0)).is_err());
        }
    }
}
