//! Standard illuminants of the CIE, and blackbodies.
//!
//! Names and colour temperatures become spectra per nm. CIE illuminants are relative and keep the scale they are
//! published with (A and the D series are 100 at 560 nm); only [`blackbody`] is absolute. Callers scale a spectrum to a
//! luminance or an illuminance, see [`cie::luminous`](super::cie::luminous).
//!
//! The CIE tabulates daylight up to 830 nm, where silicon still sees. Beyond, it is assumed to go on as the blackbody
//! of its correlated colour temperature T, without the bands in which water vapour absorbs:
//!
//! S(λ) = S(830 nm)·B(λ, T)/B(830 nm, T), 830 nm < λ ≤ 1100 nm, B by [`planck`].
//!
//! Fluorescent lamps and LEDs end where their tables end, at 780 or 830 nm. [`Spectrum::known_nm`] tells which is
//! which.

use std::sync::OnceLock;

pub use super::planck::planck;
use super::{Outside, Spectrum, library};
use crate::Invalid;
use crate::suggest::{did_you_mean, list};

/// Ratio of today's second radiation constant to the one by which D50, D55, D65 and D75 were named: D65 has a
/// correlated colour temperature of 6500 K × 1.4388/1.4380 (CIE 015:2018, 4.1.2).
const NOMINAL_TO_CCT: f64 = 1.4388 / 1.4380;

/// CIE standard illuminant D65, 300–830 nm as tabulated and a blackbody of 6504 K beyond, 100 at 560 nm.
pub fn d65() -> &'static Spectrum {
    static D65: OnceLock<Spectrum> = OnceLock::new();
    D65.get_or_init(|| library::spectrum("illuminants/d65").expect("D65 is part of the library"))
}

/// Illuminant by name, whatever its case:
///
/// - `A`, `E` (equal energy);
/// - `D50`, `D65` as tabulated; `D55`, `D75` and every other D40 to D250 computed for that nominal colour temperature;
/// - `F1`–`F12` or `FL1`–`FL12`, fluorescent lamps; `LED-B1`–`LED-B5`, `LED-BH1`, `LED-RGB1`, `LED-V1`, `LED-V2`;
/// - `3000K` or `blackbody-3000K`, a blackbody of that temperature, W·m⁻²·sr⁻¹·nm⁻¹.
pub fn illuminant(name: &str) -> Option<Spectrum> {
    let name = name.trim().to_ascii_lowercase();
    match &name[..] {
        "a" => return Some(a()),
        "e" => return Some(Spectrum::constant(100.0)),
        _ => {}
    }
    let file = match name.strip_prefix('f') {
        Some(number) if !number.starts_with('l') => format!("illuminants/fl{number}"),
        Some(_) | None => format!("illuminants/{name}"),
    };
    if let Some(tabulated) = library::spectrum(&file) {
        return Some(tabulated);
    }
    let digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit()).then(|| text.parse::<f64>().ok()).flatten();
    if let Some(hundreds) = name.strip_prefix('d').and_then(digits) {
        return daylight(hundreds * 100.0 * NOMINAL_TO_CCT);
    }
    let temperature = name.strip_prefix("blackbody-").unwrap_or(&name).strip_suffix('k')?.trim();
    let temperature = temperature.parse::<f64>().ok()?;
    blackbody(temperature)
}

/// Illuminant by name, as [`illuminant`] has it.
///
/// # Errors
///
/// A name that no illuminant has, with those that are near.
pub fn named(name: &str) -> Result<Spectrum, Invalid> {
    illuminant(name).ok_or_else(|| {
        let known: Vec<String> = names().collect();
        let known = known.iter().map(String::as_str);
        Invalid::new("illuminant", format!("there is no illuminant {name:?}{}", did_you_mean(name, known.clone())))
            .help(format!("known names are {}, daylight as D40–D250 and blackbodies as 3000K", list(name, known)))
    })
}

/// The names of the fixed illuminants, for lists and suggestions.
pub fn names() -> impl Iterator<Item = String> {
    let computed = ["A", "E", "D50", "D55", "D65", "D75"].into_iter().map(str::to_owned);
    let lamps = library::names().filter_map(|name| {
        let name = name.strip_prefix("illuminants/")?;
        (name.starts_with("fl") || name.starts_with("led-")).then(|| name.to_uppercase())
    });
    computed.chain(lamps)
}

/// CIE standard illuminant A, incandescent light, 100 at 560 nm (CIE 015:2018, eq. 4.1):
///
/// S(λ) = 100·(560/λ)⁵·(exp(c₂/(2848·560)) − 1)/(exp(c₂/(2848·λ)) − 1), λ in nm, c₂ = 1.435e7 nm·K, 300–830 nm. It is
/// a blackbody at 2856 K on today's temperature scale, and so goes on to 1100 nm here.
pub fn a() -> Spectrum {
    let exponential = |lambda: f64| (1.435e7 / (2848.0 * lambda)).exp_m1();
    Spectrum::from_fn(|lambda| 100.0 * (560.0 / lambda).powi(5) * exponential(560.0) / exponential(lambda))
}

/// CIE daylight of a correlated colour temperature of 4000–25000 K, 300–830 nm and a blackbody beyond, 100 at 560 nm
/// (CIE 015:2018, eqs. 4.7–4.12): S = S₀ + M₁·S₁ + M₂·S₂. `None` outside that range.
pub fn daylight(cct_k: f64) -> Option<Spectrum> {
    let [x, y] = daylight_chromaticity(cct_k)?;
    let m = 0.0241 + 0.2562 * x - 0.7341 * y;
    // The CIE rounds the factors to three decimals before they are used.
    let rounded = |factor: f64| (factor * 1e3).round() / 1e3;
    let m1 = rounded((-1.3515 - 1.7703 * x + 5.9114 * y) / m);
    let m2 = rounded((0.0300 - 31.4424 * x + 30.0717 * y) / m);
    let table = library::table("illuminants/d-series")?;
    let [s0, s1, s2] = ["s0", "s1", "s2"].map(|name| table.values(name).expect("the D series has these columns"));
    let values: Vec<f64> = s0.iter().zip(s1).zip(s2).map(|((s0, s1), s2)| s0 + m1 * s1 + m2 * s2).collect();
    let beyond = Outside::Blackbody(cct_k.round() as u32);
    Some(Spectrum::from_samples(table.lambda_nm(), &values, beyond).expect("the D series is sorted and finite"))
}

/// Chromaticity (x, y) of daylight of a correlated colour temperature of 4000–25000 K (CIE 015:2018, eqs. 4.7–4.9).
pub fn daylight_chromaticity(cct_k: f64) -> Option<[f64; 2]> {
    if !(4000.0..=25_000.0).contains(&cct_k) {
        return None;
    }
    let t = 1e3 / cct_k;
    let x = if cct_k <= 7000.0 {
        0.244063 + t * (0.09911 + t * (2.9678 - t * 4.6070))
    } else {
        0.237040 + t * (0.24748 + t * (1.9018 - t * 2.0064))
    };
    Some([x, -3.0 * x * x + 2.87 * x - 0.275])
}

/// Spectral radiance of a blackbody at `temperature_k`, W·m⁻²·sr⁻¹·nm⁻¹, from 300 to 1100 nm; see [`planck`]. `None`
/// unless the temperature is a number from 1 to 10⁶ K.
pub fn blackbody(temperature_k: f64) -> Option<Spectrum> {
    (1.0..=1e6).contains(&temperature_k).then(|| Spectrum::from_fn(|lambda| planck(lambda, temperature_k)))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::spectrum::cie;

    #[test]
    fn chromaticities_are_the_published_ones() {
        for (name, x, y) in [
            ("A", 0.44758, 0.40745),
            ("D50", 0.34567, 0.35851),
            ("D55", 0.33243, 0.34744),
            ("D65", 0.31272, 0.32903),
            ("D75", 0.29903, 0.31488),
            ("E", 1.0 / 3.0, 1.0 / 3.0),
            ("F1", 0.3131, 0.3371),
            ("F2", 0.3721, 0.3751),
            ("F3", 0.4091, 0.3941),
            ("F4", 0.4402, 0.4031),
            ("F5", 0.3138, 0.3452),
            ("F6", 0.3779, 0.3882),
            ("F7", 0.3129, 0.3292),
            ("F8", 0.3458, 0.3586),
            ("F9", 0.3741, 0.3727),
            ("FL10", 0.3458, 0.3588),
            ("FL11", 0.3805, 0.3769),
            ("fl12", 0.4370, 0.4042),
            ("LED-B1", 0.4560, 0.4078),
            ("LED-B2", 0.4357, 0.4012),
            ("LED-B3", 0.3756, 0.3723),
            ("LED-B4", 0.3422, 0.3502),
            ("LED-B5", 0.3118, 0.3236),
            ("LED-BH1", 0.4474, 0.4066),
            ("LED-RGB1", 0.4557, 0.4211),
            ("LED-V1", 0.4548, 0.4044),
            ("LED-V2", 0.3781, 0.3775),
        ] {
            let spectrum = illuminant(name).expect("known");
            // Published figures are sums over 380–780 nm in steps of 5 nm, rounded to five decimals (A, D) or four.
            let at_5_nm = |bar: &Spectrum| -> f64 {
                (380..=780).step_by(5).map(|l| f64::from(bar.eval(l as f32) * spectrum.eval(l as f32))).sum()
            };
            let [tx, ty, tz] = cie::observer().each_ref().map(at_5_nm);
            let rounding = if name.len() <= 3 && !name.starts_with('F') { 0.51e-5 } else { 0.51e-4 };
            for (sum, published) in [(tx, x), (ty, y)] {
                let found = sum / (tx + ty + tz);
                assert!((found - published).abs() < rounding, "{name}: {found} instead of {published}");
            }
            // Interpolating to 1 nm moves lamps with lines by up to 2.5e-4.
            let [cx, cy] = cie::chromaticity(&spectrum).expect("not black");
            assert!((cx - x).abs() < 3e-4 && (cy - y).abs() < 3e-4, "{name}: {cx:.5} {cy:.5}");
        }
    }

    #[test]
    fn computed_daylight_is_the_tabulated_one() {
        // D65's table has four decimals of about 100; the components have one, the factors three.
        let computed = daylight(6500.0 * NOMINAL_TO_CCT).expect("in range");
        for lambda in (300..=780).step_by(5) {
            let difference = computed.eval(lambda as f32) - d65().eval(lambda as f32);
            assert!(difference.abs() < 0.06, "{lambda} nm: {difference}");
        }
        assert!((computed.eval(560.0) - 100.0).abs() < 1e-4);
        // The two branches of the chromaticity meet at 7000 K.
        let [[x0, _], [x1, _]] = [7000.0, 7000.001].map(|t| daylight_chromaticity(t).expect("in range"));
        assert!((x0 - x1).abs() < 1e-4);
        assert!(daylight(3999.0).is_none() && daylight(25_001.0).is_none() && daylight(f64::NAN).is_none());
    }

    #[test]
    fn daylight_goes_on_beyond_its_tables_as_a_blackbody() {
        for (name, cct_k) in [("D65", 6504.0), ("D50", 5003.0), ("D75", 7504.0), ("D120", 12_007.0)] {
            let daylight = illuminant(name).expect("known");
            assert_eq!(daylight.known_nm(), [300.0, 830.0], "{name}");
            // Wien's form with what the −1 of Planck's law changes, c₂ = 1.438777e7 nm·K.
            let shape = |lambda: f64| lambda.powi(-5) / (1.438_777e7 / (lambda * cct_k)).exp_m1();
            for lambda in [831.0, 850.0, 940.0, 1064.0, 1100.0] {
                let wanted = f64::from(daylight.eval(830.0)) * shape(lambda) / shape(830.0);
                // Temperatures are rounded to a kelvin, values to f32.
                assert!((f64::from(daylight.eval(lambda as f32)) / wanted - 1.0).abs() < 1e-4, "{name} at {lambda} nm");
            }
        }
        // The table of D65 and what its components give have been rounded to 0.06, of 60.
        let [tabulated, computed] = [d65().clone(), daylight(6504.0).expect("in range")].map(|s| s.eval(1000.0));
        assert!((tabulated / computed - 1.0).abs() < 2e-3, "{tabulated} {computed}");
        // Fluorescent lamps are not known beyond their tables.
        let lamp = illuminant("FL2").expect("known");
        assert_eq!([lamp.eval(1000.0), lamp.known_nm()[1]], [0.0, 780.0]);
    }

    #[test]
    fn planck_obeys_wien_and_stefan_boltzmann() {
        const WIEN: f64 = 2.897_771_955e-3; // m·K, CODATA 2018
        const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8; // W·m⁻²·K⁻⁴, CODATA 2018
        for t in [300.0, 2856.0, 5772.0, 20_000.0] {
            let peak = WIEN * 1e9 / t;
            let b = planck(peak, t);
            // Flat at the top: 0.01 % aside changes it by less than 1e-7, 1 % aside by more than 1e-5.
            assert!(planck(peak * 1.01, t) < b * (1.0 - 1e-5) && planck(peak * 0.99, t) < b * (1.0 - 1e-5));
            assert!((planck(peak * 1.0001, t) / planck(peak * 0.9999, t) - 1.0).abs() < 1e-7);
            // ∫ B dλ = σT⁴/π, midpoints in ln λ from 0.02 to 1000 times the peak. The tail beyond, about
            // 1e-9 of the whole by Rayleigh–Jeans (∝ λ⁻³), is below the tolerance.
            let n = 4000;
            let (low, high) = ((0.02 * peak).ln(), (1000.0 * peak).ln());
            let step = (high - low) / f64::from(n);
            let lambda = |i: i32| (low + (f64::from(i) + 0.5) * step).exp();
            let integral: f64 = (0..n).map(|i| planck(lambda(i), t) * lambda(i) * step).sum();
            let expected = STEFAN_BOLTZMANN * t.powi(4) / PI;
            assert!((integral / expected - 1.0).abs() < 1e-6, "{t} K: {integral} instead of {expected}");
        }
    }

    #[test]
    fn illuminant_a_is_a_blackbody_at_2856_kelvin() {
        // c₂ = 1.4388e7 nm·K gives 2848 × 1.4388/1.435 = 2855.5 K.
        let ratio = blackbody(2848.0 * 1.438_777 / 1.435).expect("in range");
        let scale = f64::from(a().eval(560.0) / ratio.eval(560.0));
        assert!(a().iter().zip(ratio.scale(scale).iter()).all(|((_, a), (_, b))| (a / b - 1.0).abs() < 1e-5));
    }

    #[test]
    fn names_are_understood_whatever_their_case_and_others_refused() {
        for name in names() {
            assert!(illuminant(&name).is_some() && illuminant(&name.to_lowercase()).is_some(), "{name}");
        }
        assert_eq!(illuminant("3000K"), blackbody(3000.0));
        assert_eq!(illuminant("blackbody-2700.5k"), blackbody(2700.5));
        for name in
            ["", "K", "0K", "-5K", "nanK", "infK", "D", "D3", "D999", "D6 5", "F", "F0", "F13", "LED", "B", "x/y"]
        {
            assert!(illuminant(name).is_none(), "{name}");
        }
    }
}
