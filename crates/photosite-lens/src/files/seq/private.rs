//! The private catalogue of a sequence: wavelengths (PWL), then glasses by their indices there.

use std::collections::BTreeMap;

use photosite_core::spectrum::Dispersion;

use super::commands::{Command, fault, is_number};
use crate::files::draft::Read;
use crate::files::text::number;
use crate::prescription::Glass;

/// Most wavelengths of a table.
const MOST: usize = 100;

/// The glasses by name in capitals, and what is to be said of them.
pub(super) fn glasses(commands: &[Command]) -> Read<(BTreeMap<String, Glass>, Vec<String>)> {
    let (mut found, mut ignored) = (BTreeMap::new(), Vec::new());
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
                    ignored.push(format!("{name} of the private catalogue, which is no table of indices"));
                    continue;
                }
                if numbers.len() != wavelengths.len() || numbers.is_empty() {
                    let message = format!("{} indices at {} wavelengths (PWL)", numbers.len(), wavelengths.len());
                    return Err(fault(command, &message));
                }
                let (dispersion, error) = fitted(&wavelengths, &numbers).ok_or_else(|| {
                    fault(command, "no formula goes through these indices").help("check them and the wavelengths")
                })?;
                let source = format!(
                    "private catalogue of the file: Conrady's formula through {} indices, off by {error:.1e} at most",
                    numbers.len()
                );
                let ends = [f64::min, f64::max].map(|end| wavelengths.iter().copied().reduce(end).unwrap_or(0.0));
                let glass = Glass { name: name.clone(), source, dispersion, range_nm: Some(ends) };
                found.insert(name.to_ascii_uppercase(), glass);
            }
        }
    }
    Ok((found, ignored))
}

/// Conrady's formula by least squares, a constant where there are fewer than three indices, and the largest error at
/// the wavelengths given.
fn fitted(wavelengths_nm: &[f64], indices: &[f64]) -> Option<(Dispersion, f64)> {
    let row = |nm: f64| {
        let um = nm * 1e-3;
        [1.0, 1.0 / um, um.powf(-3.5)]
    };
    let dispersion = if indices.len() < 3 {
        Dispersion::constant(indices.iter().sum::<f64>() / indices.len() as f64)
    } else {
        // Normal equations, on a right-hand side.
        let mut m = [[0.0; 4]; 3];
        for (&nm, &n) in wavelengths_nm.iter().zip(indices) {
            let row = row(nm);
            for (i, line) in m.iter_mut().enumerate() {
                (0..3).for_each(|j| line[j] += row[i] * row[j]);
                line[3] += row[i] * n;
            }
        }
        let [a, b_um, c_um35] = solved(m)?;
        Dispersion::Conrady { a, b_um, c_um35 }
    };
    let error = |(&nm, &n): (&f64, &f64)| (dispersion.index(nm) - n).abs();
    let largest = wavelengths_nm.iter().zip(indices).map(error).fold(0.0, f64::max);
    let dispersion = dispersion.validated().ok()?;
    Some((dispersion, largest))
}

/// Three equations by elimination with pivots.
fn solved(mut m: [[f64; 4]; 3]) -> Option<[f64; 3]> {
    for i in 0..3 {
        let pivot = (i..3).max_by(|&a, &b| m[a][i].abs().total_cmp(&m[b][i].abs()))?;
        m.swap(i, pivot);
        for k in 0..3 {
            if k != i {
                let by = m[k][i] / m[i][i];
                for j in i..4 {
                    m[k][j] -= by * m[i][j];
                }
            }
        }
    }
    let solution = [0, 1, 2].map(|i| m[i][3] / m[i][i]);
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}
