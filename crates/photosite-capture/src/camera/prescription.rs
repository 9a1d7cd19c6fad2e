//! Prescription of a lens, `lens.prescription`: its surfaces, by the name of one that ships or from a file.

use std::sync::Arc;

use super::super::tables::LensTable;
use super::super::tables::file_kind::FileKind;
use super::super::tables::spectra::Finder;
use photosite_core::Invalid;
use photosite_core::input;
use photosite_core::spectrum::dispersion::lines;
use photosite_core::spectrum::{LAMBDA_MAX_NM, LAMBDA_MIN_NM, Spectrum};
use photosite_core::suggest::{did_you_mean, list};
use photosite_core::warnings::Warnings;
use photosite_lens::files::{self, Reading};
use photosite_lens::paraxial::FirstOrder;
use photosite_lens::{Lens, Prescription};
use photosite_sensor::SensorModel;

const KEY: &str = "prescription";
/// Largest size of the file of a lens, bytes.
const MOST_BYTES: u64 = 1 << 20;
/// Number of wavelengths that a lens is focused by.
const FOCUS_WAVELENGTHS: usize = 9;

/// The prescription of a lens, and the lens as it is in its first position.
pub(crate) struct Prescribed {
    pub(crate) prescription: Arc<Prescription>,
    lens: Lens,
}

impl Prescribed {
    /// Prescription that a table names; `None` where it names none. Assumptions of reading a file become warnings.
    pub(crate) fn of(finder: &Finder<'_>, table: &LensTable, warnings: &mut Warnings) -> Result<Option<Self>, Invalid> {
        let Some(name) = &table.prescription else { return Ok(None) };
        if table.kind.is_some() {
            let message = "cannot be combined with prescription, which is a kind of lens of its own";
            return Err(Invalid::new("type", message).help("remove type"));
        }
        if let Some(Reading { prescription, lens, .. }) = files::shipped(name) {
            return Ok(Some(Self { prescription: Arc::new(prescription), lens }));
        }
        let Reading { prescription, lens, report } = read(finder, name)?;
        for said in report.assumed.iter().chain(&report.warnings) {
            warnings.once(format!("lens.prescription {name}: {said}"));
        }
        if !report.ignored.is_empty() {
            warnings.once(format!("lens.prescription {name} has what is not used: {}", report.ignored.join("; ")));
        }
        Ok(Some(Self { prescription: Arc::new(prescription), lens }))
    }

    /// The lens to first order at the d line, in its first position, with the stop open.
    pub(crate) fn first_order(&self) -> FirstOrder {
        self.lens.at(lines::D).first_order()
    }

    /// Distance from the entrance pupil to the sensor, m.
    pub(crate) fn pupil_to_sensor_m(&self) -> f64 {
        (self.lens.sensor_z_mm() - self.first_order().entrance_pupil_mm) * 1e-3
    }
}

/// Wavelengths, nm, that a sensor sees as much light between as between any others, in light that has the same power at
/// each wavelength: the focus is that in which their spots are least, all counting the same. Empty for a sensor that
/// sees nothing.
pub(crate) fn focus_spectrum(sensor: &SensorModel, transmittance: &Spectrum) -> Vec<(f64, f64)> {
    let responses = sensor.responses();
    let seen = |nm: f32| responses.iter().map(|(_, response)| f64::from(response.eval(nm))).sum::<f64>();
    let (first, last) = (LAMBDA_MIN_NM as u32, LAMBDA_MAX_NM as u32);
    let of_each: Vec<f64> =
        (first..=last).map(|nm| seen(nm as f32) * f64::from(transmittance.eval(nm as f32))).collect();
    let all: f64 = of_each.iter().sum();
    let mut sum = 0.0;
    let mut wavelengths = Vec::new();
    for (nm, part) in (first..).zip(&of_each) {
        sum += part / all;
        while sum >= (wavelengths.len() as f64 + 0.5) / FOCUS_WAVELENGTHS as f64
            && wavelengths.len() < FOCUS_WAVELENGTHS
        {
            wavelengths.push((f64::from(nm), 1.0));
        }
    }
    wavelengths
}

fn read(finder: &Finder<'_>, name: &str) -> Result<Reading, Invalid> {
    if !name.contains('.') {
        let near = did_you_mean(name, files::names());
        let message = format!("no lens {name:?} ships with photosite{near}");
        let help = format!("write a file that ends in .toml, .zmx, .seq …, or one of {}", list(name, files::names()));
        return Err(Invalid::new(KEY, message).help(help));
    }
    let path = finder.path(name).map_err(|invalid| invalid.within(KEY))?;
    // Lenses have JSON files, too.
    FileKind::check_named(&path, &[FileKind::Lens, FileKind::Report], "a lens file")
        .map_err(|invalid| invalid.within(KEY))?;
    let bytes = input::read_at_most(&path, MOST_BYTES).map_err(|source| {
        Invalid::new(KEY, format!("cannot read {}: {source}", path.display()))
            .help("paths are relative to the file that contains them")
    })?;
    files::read(&bytes, &path).map_err(|error| {
        let help = miette::Diagnostic::help(&error).map(|help| help.to_string());
        let invalid = Invalid::new(KEY, error.to_string());
        match help {
            Some(help) => invalid.help(help),
            None => invalid,
        }
    })
}
