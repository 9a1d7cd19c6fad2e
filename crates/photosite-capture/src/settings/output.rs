//! Settings of the files to write, from the table `[output]`.

use std::time::Duration;

use glam::DAffine3;

use super::super::tables::{
    IrradianceSource, NextSource, NoiseSource, OutputTable, PartnerSource, PartnerTable, RawFormat, TruthSource,
};
use super::super::tree::numbers::{duration, positive_number};
use photosite_calibration::truth::{Needs, TruthLayer};
use photosite_core::Invalid;
use photosite_core::spectrum::{LAMBDA_MAX_NM, LAMBDA_MIN_NM};
use photosite_develop::RawLayout;
use photosite_files::noise_maps::NoiseFormat;
use photosite_files::truth::TruthFormat;
use photosite_raw::{Cfa, DngCompression};
use photosite_sensor::{NoiseMap, SensorModel};
use photosite_transport::scene::description::looking;

/// Settings of the files to write.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputSettings {
    /// Formats of the raw image.
    pub raw: Vec<RawFormat>,
    /// Compression of DNG files.
    pub dng_compression: DngCompression,
    /// Brightening of DNG files that developers apply unasked, EV.
    pub dng_baseline_exposure_ev: f64,
    /// The colour filter array that raw files state.
    pub raw_layout: RawLayout,
    /// Whether the developed image is written.
    pub image: bool,
    /// Whether the mean electrons are written.
    pub electrons: bool,
    /// The bands in which the spectral irradiance is written, if it is.
    pub irradiance: Option<SpectralBands>,
    /// Whether the image of an ideal observer is written.
    pub ideal: bool,
    /// Settings of ground truth of the surfaces that pixels see.
    pub truth: TruthOutput,
    /// Whether the facts known of each object are written.
    pub objects: bool,
    /// Settings of maps of the sensor's noise.
    pub noise: NoiseOutput,
    /// Time between images of a render that is under way; `None` for no such images.
    pub preview_interval: Option<Duration>,
    /// Time between checkpoints of a render that is under way; `None` for none.
    pub checkpoint_interval: Option<Duration>,
}

/// Settings of ground truth: the layers that are written, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct TruthOutput {
    /// Layers, none twice.
    pub layers: Vec<TruthLayer>,
    /// Formats of each layer.
    pub formats: Vec<TruthFormat>,
    /// Depth for one step in files of integers, m.
    pub depth_unit_m: f64,
    /// Partner → camera of a stereo pair, m.
    pub partner: Option<DAffine3>,
    /// Next image, which flow leads to.
    pub next: FlowTarget,
}

/// Next image, which flow leads to.
#[derive(Clone, Debug, PartialEq)]
pub enum FlowTarget {
    /// The next image of the same series, in which what moves has moved on.
    OfSeries,
    /// The image of the capture with these overrides.
    Changed(Vec<String>),
    /// No next image.
    None,
}

/// Settings of noise maps: those that are written, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseOutput {
    /// Noise maps, none twice.
    pub maps: Vec<NoiseMap>,
    /// Formats of each noise map.
    pub formats: Vec<NoiseFormat>,
}

/// Spectral bands of equal width next to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralBands {
    /// Lower edge of the first band, nm.
    pub first_nm: f64,
    /// Width of each band, nm.
    pub width_nm: f64,
    /// Number of bands.
    pub count: usize,
}

impl Default for SpectralBands {
    /// Spectral bands: 30 of 10 nm from 400 to 700 nm.
    fn default() -> Self {
        Self { first_nm: 400.0, width_nm: 10.0, count: 30 }
    }
}

impl SpectralBands {
    /// Lower and upper edge of a band, nm.
    pub fn edges_nm(&self, band: usize) -> [f64; 2] {
        [band, band + 1].map(|edge| self.first_nm + edge as f64 * self.width_nm)
    }

    /// Centre of a band, nm.
    pub fn centre_nm(&self, band: usize) -> f64 {
        self.first_nm + (band as f64 + 0.5) * self.width_nm
    }
}

/// Reads `[output]`.
pub(crate) fn output(table: &OutputTable, sensor: &SensorModel) -> Result<OutputSettings, Invalid> {
    let raw_layout = table.raw_layout.unwrap_or_default();
    raw_layout.check(&sensor.cfa)?;
    let full = Cfa::full(["R", "G", "B"])?;
    let cfa = if raw_layout == RawLayout::Linear { &full } else { &sensor.cfa };
    let baseline = table.dng_baseline_exposure_ev.unwrap_or(0.0);
    if !(-10.0..=10.0).contains(&baseline) {
        let message = format!("must be from -10 to 10, got {baseline}");
        return Err(
            Invalid::new("dng_baseline_exposure_ev", message).help("for example dng_baseline_exposure_ev = 0.5")
        );
    }
    let raw = without_repetition(table.raw.as_deref().unwrap_or(&[RawFormat::Dng]));
    for format in &raw {
        format.format().check_raw(cfa).map_err(|invalid| Invalid { key: "raw".to_owned(), ..invalid })?;
    }
    let interval = |key: &str, value: Option<f64>, usual: f64| match value.unwrap_or(usual) {
        0.0 => Ok(None),
        seconds => duration(key, seconds).map(Some),
    };
    Ok(OutputSettings {
        raw,
        dng_compression: table.dng_compression.unwrap_or_default(),
        dng_baseline_exposure_ev: baseline,
        raw_layout,
        image: table.image.unwrap_or(true),
        electrons: table.electrons.unwrap_or(true),
        ideal: table.ideal.unwrap_or(false),
        truth: truth(table)?,
        objects: table.objects.unwrap_or(false),
        noise: noise(table)?,
        irradiance: match table.irradiance {
            None | Some(IrradianceSource::Flag(false)) => None,
            Some(IrradianceSource::Flag(true)) => Some(SpectralBands::default()),
            Some(IrradianceSource::Bands(bands)) => {
                Some(spectral_bands(bands.bands_nm).map_err(|e| e.within("bands_nm").within("irradiance"))?)
            }
        },
        preview_interval: interval("preview_interval_s", table.preview_interval_s, 10.0)?,
        checkpoint_interval: interval("checkpoint_interval_s", table.checkpoint_interval_s, 60.0)?,
    })
}

fn truth(table: &OutputTable) -> Result<TruthOutput, Invalid> {
    let mut layers = match &table.truth {
        None | Some(TruthSource::Flag(false)) => Vec::new(),
        Some(TruthSource::Flag(true)) => {
            // Without a partner there is no disparity.
            let is_there = |layer: &TruthLayer| layer.needs() != Needs::Partner || table.truth_partner.is_some();
            TruthLayer::ALL.into_iter().filter(is_there).collect()
        }
        Some(TruthSource::Layers(layers)) => without_repetition(layers),
    };
    let is_asked = !layers.is_empty();
    let place = match table.truth_partner {
        None => None,
        Some(PartnerSource::Place(place)) => Some(place),
        Some(PartnerSource::Flag(false)) => {
            layers.retain(|layer| layer.needs() != Needs::Partner);
            None
        }
        Some(PartnerSource::Flag(true)) => {
            let invalid = Invalid::new("truth_partner", "does not say where the other camera is");
            return Err(invalid.help("for example truth_partner = { position_m = [0.1, 0, 0] }"));
        }
    };
    let next = match &table.truth_next {
        None => FlowTarget::OfSeries,
        Some(NextSource::Flag(false)) => FlowTarget::None,
        Some(NextSource::Changes(changes)) => FlowTarget::Changed(changes.clone()),
        Some(NextSource::Flag(true)) => {
            let invalid = Invalid::new("truth_next", "does not say what the next image is");
            return Err(invalid.help("for example truth_next = [\"camera.position_m=[0.1, 0, 1]\"]"));
        }
    };
    let others = [
        ("truth_formats", table.truth_formats.is_some()),
        ("truth_depth_unit_mm", table.truth_depth_unit_mm.is_some()),
    ];
    if let (false, Some((key, _))) = (is_asked, others.iter().find(|(_, is_given)| *is_given)) {
        return Err(
            Invalid::new(*key, "has no meaning without layers").help("write truth = [\"depth\"] or the like, too")
        );
    }
    if let (Some(layer), None) = (layers.iter().find(|layer| layer.needs() == Needs::Partner), place) {
        let message = format!("{:?} is that of a pair of cameras, and the other one is missing", layer.name());
        return Err(Invalid::new("truth", message)
            .help("add truth_partner = { position_m = [0.1, 0, 0] }; to a camera of a data set, disparity_to"));
    }
    let partner = place.map(|table| partner(&table).map_err(|e| e.within("truth_partner")));
    let formats = without_repetition(table.truth_formats.as_deref().unwrap_or(&[TruthFormat::Exr]));
    for format in &formats {
        // All layers are those that the format holds.
        if let Some(TruthSource::Layers(layers)) = &table.truth {
            layers.iter().try_for_each(|layer| format.check(*layer))?;
        }
    }
    let unit_mm = table.truth_depth_unit_mm.map(|mm| positive_number("truth_depth_unit_mm", mm, "0.1"));
    let depth_unit_m = unit_mm.transpose()?.unwrap_or(1.0) * 1e-3;
    Ok(TruthOutput { layers, formats, depth_unit_m, partner: partner.transpose()?, next })
}

fn noise(table: &OutputTable) -> Result<NoiseOutput, Invalid> {
    let maps = match &table.noise {
        None | Some(NoiseSource::Flag(false)) => Vec::new(),
        Some(NoiseSource::Flag(true)) => NoiseMap::ALL.to_vec(),
        Some(NoiseSource::Maps(maps)) => without_repetition(maps),
    };
    if maps.is_empty() && table.noise_formats.is_some() {
        return Err(Invalid::new("noise_formats", "has no meaning without maps").help("write noise = true, too"));
    }
    let formats = without_repetition(table.noise_formats.as_deref().unwrap_or(&[NoiseFormat::Exr]));
    Ok(NoiseOutput { maps, formats })
}

/// Partner → camera.
fn partner(table: &PartnerTable) -> Result<DAffine3, Invalid> {
    let [x, y, z] = table.position_m;
    looking(table.position_m, table.look_at_m.unwrap_or([x, y, z - 1.0]), table.up)
}

fn without_repetition<T: Copy + PartialEq>(values: &[T]) -> Vec<T> {
    let first = |(i, value): (usize, &T)| (!values[..i].contains(value)).then_some(*value);
    values.iter().enumerate().filter_map(first).collect()
}

fn spectral_bands([first, last, width]: [f64; 3]) -> Result<SpectralBands, Invalid> {
    let range = f64::from(LAMBDA_MIN_NM)..=f64::from(LAMBDA_MAX_NM);
    if !(range.contains(&first) && range.contains(&last) && first < last) {
        let message = format!("{first} to {last} nm does not rise within 300 to 1100 nm");
        return Err(Invalid::new("", message).help("for example bands_nm = [400, 700, 10]"));
    }
    let count = ((last - first) / width).round();
    // Edges are written with few digits; a thousandth of a band is nothing.
    if !(width > 0.0 && (1.0..=801.0).contains(&count) && ((last - first) / width - count).abs() < 1e-3) {
        let message = format!("bands of {width} nm do not fill {first} to {last} nm");
        return Err(Invalid::new("", message).help("write first edge, last edge and width: [400, 700, 10]"));
    }
    Ok(SpectralBands { first_nm: first, width_nm: width, count: count as usize })
}
