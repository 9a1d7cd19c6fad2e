//! The private catalogue of a sequence: wavelengths (PWL), then glasses by their indices there.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};
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
                    ignored.push(format!("{name} of the private catalogue, which is not a table of indices"));
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
    let terms = |nm: f64| {
        let um = nm * 1e-3;
        DVec3::new(1.0, 1.0 / um, um.powf(-3.5))
    };
    let dispersion = if indices.len() < 3 {
        Dispersion::constant(indices.iter().sum::<f64>() / indices.len() as f64)
    } else {
        // The normal equations of least squares.
        let (mut products, mut right) = (DMat3::ZERO, DVec3::ZERO);
        for (&nm, &n) in wavelengths_nm.iter().zip(indices) {
            let terms = terms(nm);
            products += DMat3::from_cols(terms * terms.x, terms * terms.y, terms * terms.z);
            right += terms * n;
        }
        let DVec3 { x: a, y: b_um, z: c_um35 } = products.inverse() * right;
        Dispersion::Conrady { a, b_um, c_um35 }
    };
    let error = |(&nm, &n): (&f64, &f64)| (dispersion.index(nm) - n).abs();
    let largest = wavelengths_nm.iter().zip(indices).map(error).fold(0.0, f64::max);
    let dispersion = dispersion.validated().ok()?;
    Some((dispersion, largest))
}
