//! Glasses given by numbers alone: the index n_d and the Abbe number ν_d, as in patents.

use photosite_core::Invalid;
use photosite_core::math::float::rounded;
use photosite_core::spectrum::Dispersion;
use photosite_core::spectrum::dispersion::lines;

use super::catalogue::{Entry, entries};
use crate::prescription::Glass;

/// Fraunhofer line g, mercury blue, nm.
const G: f64 = 435.8343;

/// Largest difference of n_d and of ν_d between a patent and a matching catalogue glass.
const LARGEST_DIFFERENCE: [f64; 2] = [1e-4, 0.1];

/// Largest difference of n_d and of ν_d by a patent's rounding alone, within which all makers' glasses fit equally
/// well.
const ROUNDING: [f64; 2] = [5e-5, 0.06];

/// Finds the glass of a catalogue that has these n_d and ν_d up to rounding, else the nearest within 1e-4 and 0.1, else
/// Conrady's formula through them. The note states which.
///
/// # Errors
///
/// Numbers that no glass has.
pub fn by_numbers(nd: f64, vd: f64) -> Result<(Glass, String), Invalid> {
    let dispersion = conrady(nd, vd, 0.0)?;
    let off = |entry: &Entry, by: [f64; 2]| {
        // A patent's 1.5168 is 1e-4 from 1.5169 but for the rounding of the two.
        ((entry.nd - nd).abs() / by[0]).max((entry.vd - vd).abs() / by[1]) - 1e-9
    };
    // Glasses stand in the order of makers, and the first of those that are equally near is taken.
    let rounding = entries().iter().filter(|entry| off(entry, ROUNDING) <= 1.0);
    let nearest = match rounding.clone().next() {
        Some(first) => rounding
            .filter(|entry| entry.catalogue == first.catalogue)
            .min_by(|a, b| off(a, ROUNDING).total_cmp(&off(b, ROUNDING))),
        None => entries()
            .iter()
            .filter(|entry| off(entry, LARGEST_DIFFERENCE) <= 1.0)
            .min_by(|a, b| off(a, LARGEST_DIFFERENCE).total_cmp(&off(b, LARGEST_DIFFERENCE))),
    };
    let [nd_text, vd_text] = [nd, vd].map(|x| rounded(x, 7));
    let name = format!("{nd_text}/{vd_text}");
    Ok(match nearest {
        Some(entry) => {
            let how = format!(", for n_d {nd_text}, ν_d {vd_text}");
            let note =
                format!("{name} is taken for {}'s {} ({:.5}/{:.2})", entry.catalogue, entry.name, entry.nd, entry.vd);
            (Glass { name, ..entry.to_glass(&how) }, note)
        }
        None => {
            let note = format!("{name} is not in any catalogue: Conrady's formula through these numbers");
            let source = "Conrady's formula through n_d, ν_d and the normal line".to_owned();
            (Glass { name, source, dispersion, range_nm: None }, note)
        }
    })
}

/// Conrady's formula n = A + B/λ + C/λ^3.5 ([Conrady60](photosite_core::references#conrady60)), λ in µm, through n_d,
/// n_F − n_C = (n_d − 1)/ν_d and the partial dispersion P_gF = (n_g − n_F)/(n_F − n_C) of the normal line of glasses
/// plus what this one deviates from it, P_gF = 0.6438 − 0.001682·ν_d + ΔP_gF.
///
/// Its error against 450 real glasses is 5e-5 at F and C, 48e-5 at g and 22e-5 at 852 nm (root mean square).
///
/// # Errors
///
/// n_d outside of 1 to 4, ν_d outside of 5 to 200, a deviation above 0.5.
pub fn conrady(nd: f64, vd: f64, deviation: f64) -> Result<Dispersion, Invalid> {
    if !(nd > 1.0 && nd < 4.0) {
        let message = format!("index {nd} at the d line");
        return Err(Invalid::new("", message).help("glasses have 1.4 to 2.1, given as n_d"));
    }
    if !(5.0..=200.0).contains(&vd) {
        let message = format!("Abbe number {vd}");
        return Err(Invalid::new("", message).help("glasses have 17 to 95, given as ν_d = (n_d − 1)/(n_F − n_C)"));
    }
    if !(-0.5..=0.5).contains(&deviation) {
        let message = format!("deviation {deviation} of the partial dispersion P_gF");
        return Err(Invalid::new("", message).help("glasses deviate by less than 0.1 from the normal line"));
    }
    let (first, second) = (|nm: f64| 1e3 / nm, |nm: f64| (nm * 1e-3).powf(-3.5));
    let mean = (nd - 1.0) / vd;
    let partial = (0.6438 - 0.001682 * vd + deviation) * mean;
    // B and C from the two differences, then A from n_d.
    let [b1, c1] = [first(lines::F) - first(lines::C), second(lines::F) - second(lines::C)];
    let [b2, c2] = [first(G) - first(lines::F), second(G) - second(lines::F)];
    let determinant = b1 * c2 - b2 * c1;
    let b_um = (mean * c2 - partial * c1) / determinant;
    let c_um35 = (b1 * partial - b2 * mean) / determinant;
    Ok(Dispersion::Conrady { a: nd - b_um * first(lines::D) - c_um35 * second(lines::D), b_um, c_um35 })
}

/// n_d and ν_d of a glass given as numbers: `1.5168:64.17`, `1.5168/64.17`, CODE V's `517000.520000` (1.517 and 52.0),
/// the six digits `517642` of a glass code (1.517 and 64.2). `None` for any other text.
pub fn code(text: &str) -> Option<(f64, f64)> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    if let Some((nd, vd)) = text.split_once([':', '/']) {
        return Some((number(nd)?, number(vd)?));
    }
    let are_digits = |text: &str| !text.is_empty() && text.len() <= 9 && text.bytes().all(|b| b.is_ascii_digit());
    let (index, abbe, scale) = match text.split_once('.') {
        Some((index, abbe)) => (index, abbe, 100.0),
        None if text.len() == 6 && text.is_ascii() => (&text[..3], &text[3..], 100.0),
        None => return None,
    };
    if !are_digits(index) || !are_digits(abbe) || index.len() < 3 {
        return None;
    }
    let fraction = |digits: &str| number(&format!("0.{digits}"));
    // Rounded, as 0.642 · 100 is not 64.2 in binary.
    let vd = (fraction(abbe)? * scale * 1e7).round() / 1e7;
    Some((1.0 + fraction(index)?, vd))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conradys_formula_is_that_of_the_reference_figures() {
        // By NumPy; the coefficients of tests/reference/canon-rf24.json and nikkor-z14.json.
        for (nd, vd, expected) in [
            (1.51633, 64.1, [1.4971007793316, 0.01004129351596, 0.00033265233572299]),
            (1.85478, 24.8, [1.7926716082749, 0.02719909147339, 0.0024592901580439]),
            (1.49782, 82.57, [1.4817689871596, 0.0088118896914566, 0.00016382314429194]),
        ] {
            let Ok(Dispersion::Conrady { a, b_um, c_um35 }) = conrady(nd, vd, 0.0) else { panic!("valid") };
            for (found, expected) in [a, b_um, c_um35].into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12, "{nd}/{vd}: {found} instead of {expected}");
            }
        }
        for (nd, vd, deviation) in [(0.9, 50.0, 0.0), (1.5, 0.0, 0.0), (f64::NAN, 50.0, 0.0), (1.5, 50.0, f64::NAN)] {
            assert!(conrady(nd, vd, deviation).is_err());
        }
    }

    #[test]
    fn the_deviation_moves_the_index_at_g_alone() {
        let [plain, off] = [0.0, 0.01].map(|deviation| conrady(1.6, 40.0, deviation).expect("valid"));
        for line in [lines::F, lines::D, lines::C] {
            let moved = off.index(line) - plain.index(line);
            // F and C move together: only their difference is held.
            assert!(moved.abs() < 2e-4, "{line}: {moved}");
        }
        let partial = |d: &Dispersion| (d.index(G) - d.index(lines::F)) / (d.index(lines::F) - d.index(lines::C));
        assert!((partial(&off) - partial(&plain) - 0.01).abs() < 1e-12);
        assert!((partial(&plain) - (0.6438 - 0.001682 * 40.0)).abs() < 1e-12);
    }

    #[test]
    fn numbers_of_patents_find_the_glass_that_they_round() {
        for (nd, vd, expected) in
            [(1.5168, 64.2, "N-BK7"), (1.6727, 32.1, "S-TIM25"), (1.497, 81.5, "S-FPL51"), (1.883, 40.8, "N-LASF31A")]
        {
            let (glass, note) = by_numbers(nd, vd).expect("valid");
            assert!(glass.range_nm.is_some() && (glass.dispersion.index(lines::D) - nd).abs() <= 1e-4, "{note}");
            assert_eq!(glass.name, format!("{nd}/{vd}"));
            assert!(note.contains(expected), "{note}");
        }
        // No such glass; a typing error for 1.6727/32.1.
        let (glass, note) = by_numbers(1.6727, 25.6).expect("valid");
        assert!(note.contains("Conrady"), "{note}");
        assert!((glass.dispersion.abbe_number() - 25.6).abs() < 1e-9);
    }

    #[test]
    fn codes_are_read_as_the_programs_write_them() {
        assert_eq!(code("517000.520000"), Some((1.517, 52.0)));
        assert_eq!(code("500.700"), Some((1.5, 70.0)));
        assert_eq!(code("1.5168:64.17"), Some((1.5168, 64.17)));
        assert_eq!(code("1.6937/53.32"), Some((1.6937, 53.32)));
        assert_eq!(code("517642"), Some((1.517, 64.2)));
        for text in ["N-BK7", "", "1.5", "51.6", "é12345", "12345é", "1/x", "-17.64"] {
            assert_eq!(code(text), None, "{text}");
        }
    }
}
