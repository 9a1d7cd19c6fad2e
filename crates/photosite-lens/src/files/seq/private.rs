//! The private catalogue of a sequence: wavelengths (PWL), then glasses by their indices there.

use std::collections::BTreeMap;

use photosite_core::spectrum::{Dispersion, Spectrum};

use super::commands::{Command, fault, is_number};
use crate::files::draft::Read;
use crate::files::text::number;
use crate::prescription::Glass;

/// Largest number of wavelengths of a table.
const MOST: usize = 100;

/// Errors of a formula against the table above which the residuals are interpolated, and above which a warning is
/// given.
const PRECISION: f64 = 1e-5;
const POOR: f64 = 1e-4;

/// Exponents of λ in the terms of n²: Schott's, then one more at either end. The fewest terms that suffice are used.
const EXPONENTS: [f64; 8] = [0.0, -2.0, 2.0, -4.0, -6.0, -8.0, 4.0, -10.0];

/// Content of a private catalogue.
#[derive(Debug, Default)]
pub(super) struct Catalogue {
    /// Glasses by name in capitals.
    pub(super) glasses: BTreeMap<String, Glass>,
    /// Unused content.
    pub(super) ignored: Vec<String>,
    /// Warnings of tables that no formula fits.
    pub(super) warnings: Vec<String>,
}

/// Private catalogue of a sequence.
pub(super) fn glasses(commands: &[Command]) -> Read<Catalogue> {
    let mut found = Catalogue::default();
    let mut wavelengths: Vec<f64> = Vec::new();
    for command in commands.iter().filter(|command| command.is_private) {
        let numbers: Vec<f64> = command.words[1..].iter().filter_map(|word| number(word)).take(MOST + 1).collect();
        if numbers.len() > MOST {
            return Err(fault(command, "more than 100 wavelengths"));
        }
        match command.key.as_str() {
            "PRV" | "END" => {}
            "PWL" => {
                if numbers.iter().any(|&nm| nm <= 0.0) {
                    return Err(fault(command, "a wavelength of 0 nm or less"));
                }
                wavelengths = numbers;
            }
            _ => {
                let name = &command.words[0];
                if !command.words.get(1).is_some_and(|word| is_number(word)) {
                    found.ignored.push(format!("{name} of the private catalogue, which is not a table of indices"));
                    continue;
                }
                if numbers.len() != wavelengths.len() || numbers.is_empty() {
                    let message = format!("{} indices at {} wavelengths (PWL)", numbers.len(), wavelengths.len());
                    return Err(fault(command, &message));
                }
                let Fit { dispersion, formula, error } = fitted(&wavelengths, &numbers).ok_or_else(|| {
                    fault(command, "no formula goes through these indices").help("check them and the wavelengths")
                })?;
                if error > POOR {
                    found.warnings.push(format!(
                        "the glass {name} of the private catalogue is no smooth curve: a formula is off its table by up to \
                         {error:.1e}, so that it runs straight between; look for a mistyped index or wavelength"
                    ));
                }
                let source = format!(
                    "private catalogue of the file: {formula} through {} indices, off by {error:.1e} at most{}",
                    numbers.len(),
                    if error > PRECISION { ", which is added, straight from line to line" } else { "" }
                );
                let dispersion =
                    if error > PRECISION { interpolated(&dispersion, &wavelengths, &numbers) } else { dispersion };
                let ends = [f64::min, f64::max].map(|end| wavelengths.iter().copied().reduce(end).unwrap_or(0.0));
                let glass = Glass { name: name.clone(), source, dispersion, range_nm: Some(ends) };
                found.glasses.insert(name.to_ascii_uppercase(), glass);
            }
        }
    }
    Ok(found)
}

/// A formula of the index, its name, and its largest error at the given wavelengths.
struct Fit {
    dispersion: Dispersion,
    formula: String,
    error: f64,
}

/// Formula of fewest terms that is within 1e-5 of the table, else the best: Conrady's, then n² as a sum of powers of λ.
/// A glass of one index is constant.
fn fitted(wavelengths_nm: &[f64], indices: &[f64]) -> Option<Fit> {
    let of = |dispersion: Dispersion, formula: String| {
        let dispersion = dispersion.validated().ok()?;
        let error = |(&nm, &n): (&f64, &f64)| (dispersion.index(nm) - n).abs();
        let error = wavelengths_nm.iter().zip(indices).map(error).fold(0.0, f64::max);
        error.is_finite().then_some(Fit { dispersion, formula, error })
    };
    let micrometres: Vec<f64> = wavelengths_nm.iter().map(|nm| nm * 1e-3).collect();
    let conrady = || {
        let [a, b_um, c_um35] = least_squares(&micrometres, indices, &[0.0, -1.0, -3.5])?[..] else { return None };
        of(Dispersion::Conrady { a, b_um, c_um35 }, "Conrady's formula".to_owned())
    };
    let squares: Vec<f64> = indices.iter().map(|n| n * n).collect();
    let powers = |terms: usize| {
        let exponents = EXPONENTS.get(..terms)?;
        let factors = least_squares(&micrometres, &squares, exponents)?;
        let terms = factors.into_iter().zip(exponents).map(|(a, e)| [a, *e]).collect();
        of(Dispersion::Polynomial { terms }, format!("n² by powers of λ, {} terms,", exponents.len()))
    };
    let fewest = indices.len().min(4);
    let fits = conrady().into_iter().chain((fewest..=indices.len().min(EXPONENTS.len())).filter_map(powers));
    let mut best: Option<Fit> = None;
    for fit in fits {
        let is_better = best.as_ref().is_none_or(|best| fit.error < best.error);
        let is_enough = fit.error <= PRECISION;
        if is_better {
            best = Some(fit);
        }
        if is_enough {
            break;
        }
    }
    best
}

/// Formula plus its residuals at the tabulated wavelengths, interpolated linearly and constant beyond the ends.
fn interpolated(formula: &Dispersion, wavelengths_nm: &[f64], indices: &[f64]) -> Dispersion {
    let mut off: Vec<(f64, f64)> =
        wavelengths_nm.iter().zip(indices).map(|(&nm, n)| (nm, n - formula.index(nm))).collect();
    off.sort_by(|a, b| a.0.total_cmp(&b.0));
    let rest = |nm: f64| {
        let after = off.partition_point(|(known, _)| *known <= nm);
        match (after.checked_sub(1).map(|before| off[before]), off.get(after)) {
            (Some((from, a)), Some((to, b))) => a + (nm - from) / (to - from) * (b - a),
            (Some((_, a)), None) => a,
            (None, Some((_, b))) => *b,
            (None, None) => 0.0,
        }
    };
    Dispersion::Table(Spectrum::from_fn(|nm| formula.index(nm) + rest(nm)))
}

/// Factors of powers of x with the least sum of squared differences from `values`, by Gram and Schmidt's orthogonal
/// columns, twice for the sake of digits. `None` where there are fewer values than powers.
fn least_squares(x: &[f64], values: &[f64], exponents: &[f64]) -> Option<Vec<f64>> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let less = |from: &mut [f64], factor: f64, column: &[f64]| {
        from.iter_mut().zip(column).for_each(|(value, part)| *value -= factor * part);
    };
    let count = exponents.len();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    // Row by row, what of each power is along each column.
    let mut triangle = vec![vec![0.0; count]; count];
    for (j, exponent) in exponents.iter().enumerate() {
        let mut column: Vec<f64> = x.iter().map(|x| x.powf(*exponent)).collect();
        let size = dot(&column, &column).sqrt();
        for _ in 0..2 {
            for (i, known) in columns.iter().enumerate() {
                let part = dot(known, &column);
                triangle[i][j] += part;
                less(&mut column, part, known);
            }
        }
        let length = dot(&column, &column).sqrt();
        if x.len() < count || length.is_nan() || length <= 1e-13 * size {
            return None;
        }
        triangle[j][j] = length;
        column.iter_mut().for_each(|value| *value /= length);
        columns.push(column);
    }
    let mut rest = values.to_vec();
    let mut factors = vec![0.0; count];
    for (factor, column) in factors.iter_mut().zip(&columns) {
        *factor = dot(column, &rest);
        less(&mut rest, *factor, column);
    }
    for i in (0..count).rev() {
        let known: f64 = (i + 1..count).map(|j| triangle[i][j] * factors[j]).sum();
        factors[i] = (factors[i] - known) / triangle[i][i];
    }
    Some(factors)
}
