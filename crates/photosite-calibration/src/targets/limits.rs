//! Which sizes a target can have.

use photosite_core::Invalid;

/// Lengths in files, mm: from what a nanometre still divides finely to what fits into a hall.
const LENGTHS_MM: std::ops::RangeInclusive<f64> = 0.01..=100_000.0;
/// Most elements (squares, circles, markers) of a target.
const MOST_ELEMENTS: u64 = 40_000;

/// A length in mm, as metres.
pub(super) fn length(key: &str, mm: f64) -> Result<f64, Invalid> {
    if LENGTHS_MM.contains(&mm) {
        return Ok(mm / 1e3);
    }
    let range = format!("write a length between {} and {} mm", LENGTHS_MM.start(), LENGTHS_MM.end());
    Err(Invalid::new(key, format!("{mm} mm cannot be made")).help(range))
}

/// A margin in mm, as metres: a length or 0. Left out: `default_m`.
pub(super) fn margin(mm: Option<f64>, default_m: f64) -> Result<f64, Invalid> {
    match mm {
        None => Ok(default_m),
        Some(0.0) => Ok(0.0),
        Some(mm) => length("margin_mm", mm),
    }
}

/// Numbers across and down, at least `least` each.
pub(super) fn counts(key: &str, counts: [u32; 2], least: u32) -> Result<[u32; 2], Invalid> {
    let [across, down] = counts;
    if across < least || down < least {
        let message = format!("{across} across and {down} down are too few");
        return Err(Invalid::new(key, message).help(format!("write at least {least} each, columns before rows")));
    }
    if u64::from(across) * u64::from(down) > MOST_ELEMENTS {
        let message = format!("{across} across and {down} down are too many");
        return Err(Invalid::new(key, message).help(format!("write at most {MOST_ELEMENTS} together")));
    }
    Ok(counts)
}

/// Refuses a part that is not smaller than what it must fit into.
pub(super) fn fits(key: &str, part_mm: f64, whole: &str, whole_mm: f64) -> Result<(), Invalid> {
    if part_mm < whole_mm {
        return Ok(());
    }
    let message = format!("{part_mm} mm does not fit into the {whole} of {whole_mm} mm");
    Err(Invalid::new(key, message).help(format!("write less than {whole_mm}, or make the {whole} larger")))
}
