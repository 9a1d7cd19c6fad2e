//! Pixels of a sensor file, checked where several of its keys belong together.

use photosite_core::Invalid;
use photosite_core::cells::CellLayout;
use photosite_core::spectrum::Spectrum;
use photosite_raw::Cfa;

use super::checks::{fraction, margin, not_negative, positive};
use super::converter::Converter;
use super::crosstalk::Kernel;
use super::description::{ChannelDescription, SensorDescription};
use super::format::Format;
use super::image_lag::ImageLag;
use super::kind::SensorKind;
use super::layers;
use super::logarithmic::Logarithmic;
use super::shutter::Shutter;
use super::spectrum_source::SpectrumSource;

/// The name that a description gives.
pub(super) fn own_name(d: &SensorDescription) -> Result<Option<&str>, Invalid> {
    match d.name.as_deref() {
        Some(name) if name.trim().is_empty() || name.contains(char::is_control) => {
            let help = "for example name = \"my camera\", or leave it out";
            Err(Invalid::new("name", format!("{name:?} is not a name")).help(help))
        }
        name => Ok(name),
    }
}

/// The pitch as stated, or that of a format.
pub(super) fn pixel_pitch_m(d: &SensorDescription) -> Result<[f64; 2], Invalid> {
    match (&d.pixel_pitch_um, &d.format) {
        (Some(_), Some(_)) => {
            Err(Invalid::new("format", "cannot be combined with pixel_pitch_um").help("keep the one you know better"))
        }
        (None, None) => Err(Invalid::new("pixel_pitch_um", "is missing")
            .help("for example pixel_pitch_um = [3.45, 3.45], or format = \"2/3\"")),
        (Some(pitch), None) => {
            for &um in pitch {
                positive("pixel_pitch_um", um, "[3.45, 3.45]")?;
            }
            Ok(pitch.map(|um| um * 1e-6))
        }
        (None, Some(name)) => Ok(Format::named(name)?.pitch_m(d.resolution_px)),
    }
}

/// Logarithmic pixels are those of CMOS sensors with one converter range.
pub(super) fn logarithmic(d: &SensorDescription, converter: &Converter) -> Result<Option<Logarithmic>, Invalid> {
    const KEY: &str = "charge.logarithmic_reference_e_per_s";
    let Some(reference_e_per_s) = d.charge.logarithmic_reference_e_per_s else { return Ok(None) };
    positive(KEY, reference_e_per_s, "100.0")?;
    let clash = match d.kind {
        SensorKind::Cmos => converter.dual_gain.as_ref().map(|_| "adc.dual_gain".to_owned()),
        SensorKind::Ccd | SensorKind::Spad => Some(format!("kind = {:?}", d.kind.name())),
    };
    match clash {
        Some(other) => Err(Invalid::new(KEY, format!("cannot be combined with {other}")).help("keep one of them")),
        None => Ok(Some(Logarithmic { reference_e_per_s })),
    }
}

/// The kernel of each channel, if any has one.
pub(super) fn crosstalk(d: &SensorDescription, cfa: &Cfa) -> Result<Option<Vec<Kernel>>, Invalid> {
    let kernel = |key: &str, rows: &[Vec<f64>]| {
        let sum: f64 = rows.iter().flatten().sum();
        // Parts are written with few digits; what is missing to 1 is rounding.
        Kernel::new(rows).filter(|_| (sum - 1.0).abs() < 1e-6).ok_or_else(|| {
            let message = format!("must be an odd number of rows of equal, odd length and sum to 1, got {rows:?}");
            Invalid::new(key, message).help("for example [[0, 0.01, 0], [0.01, 0.96, 0.01], [0, 0.01, 0]]")
        })
    };
    let of_all = d.crosstalk.as_deref().map(|rows| kernel("crosstalk", rows)).transpose()?;
    let of_channel = |letter: &String| match d.channels.get(letter).and_then(|channel| channel.crosstalk.as_deref()) {
        Some(rows) => kernel(&format!("channels.{letter}.crosstalk"), rows).map(Some),
        None => Ok(of_all.clone()),
    };
    let kernels: Vec<Option<Kernel>> = cfa.channels().iter().map(of_channel).collect::<Result<_, _>>()?;
    let any = kernels.iter().any(Option::is_some);
    Ok(any.then(|| kernels.into_iter().map(|kernel| kernel.unwrap_or_else(Kernel::keep)).collect()))
}

pub(super) fn margins(key: &str, [before, after]: [u32; 2]) -> Result<[usize; 2], Invalid> {
    Ok([margin(key, before)?, margin(key, after)?])
}

pub(super) fn brighter_fatter(d: &SensorDescription) -> Result<[f64; 2], Invalid> {
    let per_e = d.charge.brighter_fatter_per_e;
    for a in per_e {
        not_negative("charge.brighter_fatter_per_e", a)?;
    }
    // The model is of first order: where half of the charge changes sides it says nothing, and no real sensor is near.
    let strongest = (per_e[0] + per_e[1]) * d.charge.full_well_e;
    if strongest > 0.5 {
        let message = format!("correlates neighbours at full well by {strongest}, which is beyond the model");
        return Err(Invalid::new("charge.brighter_fatter_per_e", message).help("for example [2e-7, 3e-7]"));
    }
    Ok(per_e)
}

/// Quantum efficiency of a channel, which a sensor file states in one of two ways.
pub(super) fn quantum_efficiency(
    channel: &ChannelDescription,
    resolve: &mut impl FnMut(&SpectrumSource) -> Result<Spectrum, Invalid>,
) -> Result<Spectrum, Invalid> {
    let help = "write a quantum_efficiency, or the depths between which silicon absorbs, depth_um = [0.0, 3.0]";
    match (&channel.quantum_efficiency, channel.depth_um) {
        (Some(source), None) => fraction("quantum_efficiency", source, resolve),
        (None, Some(depth_um @ [upper, lower])) => {
            if !(upper.is_finite() && lower.is_finite() && 0.0 <= upper && upper < lower) {
                let message = format!("{upper} to {lower} is not a range of depths");
                return Err(Invalid::new("depth_um", message).help("for example depth_um = [0.0, 3.0]"));
            }
            Ok(layers::quantum_efficiency(depth_um))
        }
        (Some(_), Some(_)) => Err(Invalid::new("depth_um", "says the same as quantum_efficiency").help(help)),
        (None, None) => Err(Invalid::new("quantum_efficiency", "missing").help(help)),
    }
}

/// Image lag, which some kinds of pixels do not have.
pub(super) fn image_lag(d: &SensorDescription, shutter: &Shutter) -> Result<Option<ImageLag>, Invalid> {
    let is_logarithmic = d.charge.logarithmic_reference_e_per_s.is_some();
    let lag = d.charge.image_lag.as_ref();
    lag.map_or(Ok(None), |lag| ImageLag::new(lag, d.kind, is_logarithmic, shutter))
}

/// Refuses what sensors with this shutter do not have. Keys of errors are those of the sensor file.
pub(super) fn check_shutter(shutter: &Shutter, d: &SensorDescription, cfa: &Cfa) -> Result<(), Invalid> {
    if *shutter != Shutter::Global && d.kind == SensorKind::Ccd {
        let message = "a CCD takes up the charge of all its rows at once";
        return Err(Invalid::new("shutter.kind", message).help("leave it out, or write kind = \"cmos\" for the sensor"));
    }
    if !shutter.scans() {
        return Ok(());
    }
    let of_rows = [("cfa", cfa.tile_size().1 > 1), ("masked_rows", d.masked_rows != [0, 0])];
    let of_rows = of_rows.iter().find(|(_, is_given)| *is_given).map(|(key, _)| *key);
    match of_rows.or_else(|| across_rows(d)) {
        None => Ok(()),
        Some(key) => Err(Invalid::new(key, "reaches over several rows, and a scanning sensor has one")
            .help("describe one row of pixels")),
    }
}

/// The key by which pixels of different rows touch each other, if there is one.
fn across_rows(d: &SensorDescription) -> Option<&'static str> {
    let mut kernels = d.crosstalk.iter().chain(d.channels.values().filter_map(|channel| channel.crosstalk.as_ref()));
    let across_rows = [
        ("crosstalk", kernels.any(|rows| rows.len() > 1)),
        ("charge.brighter_fatter_per_e", d.charge.brighter_fatter_per_e[1] > 0.0),
    ];
    across_rows.iter().find(|(_, is_given)| *is_given).map(|(key, _)| *key)
}

/// Refuses what staggered rows and a round image have no meaning for. Keys of errors are those of the sensor file.
pub(super) fn check_cells(cells: &CellLayout, shutter: &Shutter, d: &SensorDescription) -> Result<(), Invalid> {
    if shutter.scans() && cells.image_circle.is_some() {
        let message = "is that of an image that is seen at once, and a scanning sensor has one row";
        return Err(Invalid::new("image_circle_mm", message).help("remove it"));
    }
    if !cells.is_staggered() {
        return Ok(());
    }
    if shutter.scans() {
        let message = "a scanning sensor has one row, and nothing to stagger";
        return Err(Invalid::new("cells", message).help("leave it out"));
    }
    match across_rows(d) {
        Some(key) => {
            let message = "reaches over several rows, which lie half a pitch beside each other";
            let help = format!("state what neighbours along a row do to each other, or write without = [{key:?}]");
            Err(Invalid::new(key, message).help(help))
        }
        None => Ok(()),
    }
}
