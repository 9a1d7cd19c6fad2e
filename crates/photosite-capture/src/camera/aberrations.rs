//! Aberrations of a lens: `psf`, `lateral_colour` and `stops` of `[lens]`.

use std::sync::Arc;

use glam::DVec2;

use super::super::tables::spectra::Finder;
use super::super::tables::{KernelOrigin, LateralColourTable, PointSpreadTable, StopTable};
use super::super::tree::numbers::positive_number;
use photosite_core::Invalid;
use photosite_core::input;
use photosite_core::warnings::Warnings;
use photosite_transport::optics::{Kernel, KernelField, LateralColour, PointSpread, Stop};

/// Largest shift of the image by a kernel, px, that passes without a warning: corners are found as well as that.
const SEEN_SHIFT_PX: f64 = 0.05;

pub(crate) fn point_spread(
    finder: &Finder<'_>,
    table: &PointSpreadTable,
    pixel_pitch_m: [f64; 2],
    warnings: &mut Warnings,
) -> Result<PointSpread, Invalid> {
    match table {
        PointSpreadTable::Gaussian { sigma_um } => {
            Ok(PointSpread::Gaussian { sigma_m: positive_number("sigma_um", *sigma_um, "1.5")? * 1e-6 })
        }
        PointSpreadTable::Airy => Ok(PointSpread::Airy),
        PointSpreadTable::Wave => Ok(PointSpread::Wave),
        PointSpreadTable::Kernel { pitch_um, kernels: tables, origin } => {
            let pitch_m = positive_number("pitch_um", *pitch_um, "0.5")? * 1e-6;
            let kernels = tables.iter().enumerate().map(|(i, kernel)| {
                let measured = measured(finder, &kernel.file, pitch_m);
                let measured = measured.map_err(|invalid| invalid.within(&format!("kernels[{i}]")))?;
                let placed = match origin {
                    None | Some(KernelOrigin::Centre) => measured,
                    Some(KernelOrigin::Centroid) => measured.about_centroid(),
                };
                Ok((DVec2::from_array(kernel.at), placed))
            });
            let kernels = kernels.collect::<Result<Vec<_>, Invalid>>()?;
            if origin.is_none() {
                shift_warning(&kernels, pixel_pitch_m).into_iter().for_each(|warning| warnings.once(warning));
            }
            Ok(PointSpread::Measured(Arc::new(KernelField::new(kernels)?)))
        }
    }
}

/// A warning about kernels whose light is not about their middle, by the one that shifts the image most.
fn shift_warning(kernels: &[(DVec2, Kernel)], pixel_pitch_m: [f64; 2]) -> Option<String> {
    let shifts = kernels.iter().map(|(_, kernel)| kernel.centroid_m() / DVec2::from_array(pixel_pitch_m));
    let (number, shift) = shifts.enumerate().max_by(|(_, a), (_, b)| a.length().total_cmp(&b.length()))?;
    let part = |px: f64, [forward, back]: [&str; 2]| {
        let way = if px > 0.0 { forward } else { back };
        (px.abs() >= 0.005).then(|| format!("{:.2} px {way}", px.abs()))
    };
    let parts = [part(shift.x, ["to the right of", "to the left of"]), part(shift.y, ["below", "above"])];
    let place = parts.into_iter().flatten().collect::<Vec<_>>().join(" and ");
    (shift.length() > SEEN_SHIFT_PX).then(|| {
        format!(
            "lens.psf: the light of kernels[{number}] is on average {place} its middle, which shifts the image by as much relative to ground truth; write origin = \"centroid\" for an image \
             that stays in its place, or origin = \"centre\" if this is meant"
        )
    })
}

/// A kernel from a CSV file.
fn measured(finder: &Finder<'_>, file: &str, pitch_m: f64) -> Result<Kernel, Invalid> {
    let path = finder.path(file).map_err(|invalid| invalid.within("file"))?;
    let wrong = |message: String| Invalid::new("file", format!("{}: {message}", path.display()));
    let text = input::read_text(&path, input::TABLE_BYTES).map_err(|reason| {
        wrong(format!("cannot be read: {reason}")).help("paths are relative to the file that contains them")
    })?;
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.split('#').next().unwrap_or_default().trim()));
    let row = |(number, line): (usize, &str)| {
        let values: Result<Vec<f32>, _> = line.split(',').map(|value| value.trim().parse()).collect();
        values.map_err(|_| wrong(format!("line {number} is not a row of numbers: {line}")).help("write 0.1, 0.5, 0.1"))
    };
    let rows = lines.filter(|(_, line)| !line.is_empty()).map(row).collect::<Result<Vec<_>, _>>()?;
    Kernel::new(&rows, pitch_m).map_err(|invalid| Invalid {
        message: wrong(invalid.message).message,
        key: "file".to_owned(),
        ..invalid
    })
}

pub(crate) fn lateral_colour(table: &LateralColourTable) -> Result<LateralColour, Invalid> {
    let LateralColourTable { wavelength_nm, magnification } = table;
    if wavelength_nm.is_empty() || wavelength_nm.len() != magnification.len() {
        let message = format!("{} wavelengths have {} magnifications", wavelength_nm.len(), magnification.len());
        let help = "write as many of each, such as wavelength_nm = [450, 650] and magnification = [0.9995, 1.0005]";
        return Err(Invalid::new("magnification", message).help(help));
    }
    if !wavelength_nm.is_sorted_by(|a, b| a < b) {
        return Err(Invalid::new("wavelength_nm", "must rise from each to the next"));
    }
    magnification.iter().try_for_each(|m| positive_number("magnification", *m, "[0.9995, 1.0005]").map(drop))?;
    Ok(LateralColour { points: wavelength_nm.iter().copied().zip(magnification.iter().copied()).collect() })
}

pub(crate) fn stops(tables: &[StopTable]) -> Result<Vec<Stop>, Invalid> {
    let stop = |table: &StopTable| {
        if !table.distance_mm.is_finite() {
            return Err(Invalid::new("distance_mm", format!("must be finite, got {}", table.distance_mm)));
        }
        let radius_mm = positive_number("radius_mm", table.radius_mm, "12")?;
        Ok(Stop { distance_m: table.distance_mm / 1e3, radius_m: radius_mm / 1e3 })
    };
    let at = |i: usize| move |invalid: Invalid| invalid.within(&format!("stops[{i}]"));
    tables.iter().enumerate().map(|(i, table)| stop(table).map_err(at(i))).collect()
}
