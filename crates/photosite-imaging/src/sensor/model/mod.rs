//! A sensor, checked and in SI units, and what light makes of it: its spectral responses.
//!
//! In: a [`SensorDescription`] and a way to find the spectra that it names. Out: a [`SensorModel`] whose numbers can be
//! relied on. Reading files is left to the caller.

mod architecture;
pub(super) mod checks;
mod converter;
mod noise;

use crate::raw::Cfa;
use photosite_core::Invalid;
use photosite_core::spectrum::Spectrum;
use photosite_core::units::{Electrons, PLANCK, SPEED_OF_LIGHT, Seconds};

use super::ccd::margin;
use super::crosstalk::Kernel;
use super::description::{ChannelDescription, SensorDescription, SensorKind, SpectrumSource};
use super::format;
use super::layers;
use super::{ImageLag, Logarithmic, MaskedPixels, Shutter};
pub use architecture::Architecture;
use checks::{fraction, not_negative, positive};
pub use converter::Converter;
pub(super) use converter::converter_range;
pub use noise::{DarkCurrentLaw, Defects, FixedPattern, Flicker, Noise, ResetNoise, Telegraph};

/// An image sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorModel {
    /// Preset or file name; becomes the camera model of raw files.
    pub name: String,
    /// What it is, in a sentence.
    pub description: String,
    /// Where its numbers come from.
    pub source: String,
    /// Serial number: the fixed pattern of the sensor is a function of it alone.
    pub serial: u64,
    /// Technology of the pixels.
    pub architecture: Architecture,
    /// When each row sees light.
    pub shutter: Shutter,
    /// Columns and rows of a picture.
    pub resolution: [usize; 2],
    /// Pixels around these that see no light.
    pub masked: MaskedPixels,
    /// Pixel pitch along x and y, m.
    pub pixel_pitch_m: [f64; 2],
    /// Sensitive part of a pixel's area, above 0 up to 1.
    pub fill_factor: f64,
    /// Colour filter array.
    pub cfa: Cfa,
    /// Transmittance of all filters in front of the pixels together, 0–1.
    pub filter: Spectrum,
    /// Quantum efficiency η(λ), 0–1, one for each of the CFA's channels in their order.
    pub quantum_efficiency: Vec<Spectrum>,
    /// Where electrons are collected, one for each of the CFA's channels in their order; `None` for each in its own pixel.
    pub crosstalk: Option<Vec<Kernel>>,
    /// Noise sources.
    pub noise: Noise,
    /// Most electrons that a pixel can hold.
    pub full_well: Electrons,
    /// Brighter-fatter effect: correlation of neighbours along x and y for each electron of a flat field, 1/e⁻.
    pub brighter_fatter_per_e: [f64; 2],
    /// Charge that stays in the pixel when it is read out; `None` for none.
    pub image_lag: Option<ImageLag>,
    /// Response of the pixels where it is logarithmic; `None` for linear ones.
    pub logarithmic: Option<Logarithmic>,
    /// Gain and converter.
    pub converter: Converter,
}

impl SensorModel {
    /// Checks a description. `resolve` finds the spectra that it names. Keys of errors are those of the sensor file.
    pub fn new(
        name: &str,
        description: &SensorDescription,
        mut resolve: impl FnMut(&SpectrumSource) -> Result<Spectrum, Invalid>,
    ) -> Result<Self, Invalid> {
        let d = description;
        if let Some(axis) = (0..2).find(|&axis| d.resolution_px[axis] == 0 || d.resolution_px[axis] > MAX_RESOLUTION) {
            let message = format!("must lie between 1 and {MAX_RESOLUTION}, got {}", d.resolution_px[axis]);
            return Err(Invalid::new("resolution_px", message).help("for example resolution_px = [1920, 1200]"));
        }
        let pixel_pitch_m = pixel_pitch_m(d)?;
        positive("fill_factor", d.fill_factor, "1.0")?;
        if d.fill_factor > 1.0 {
            return Err(Invalid::new("fill_factor", format!("must be at most 1, got {}", d.fill_factor))
                .help("it is the part of a pixel's area that is sensitive to light"));
        }
        let cfa = Cfa::parse(&d.cfa)?;
        let mut filter = Spectrum::constant(1.0);
        for (key, source) in [
            ("filter.transmittance", &d.filter.transmittance),
            ("filter.cover_glass", &d.filter.cover_glass),
            ("filter.microlenses", &d.filter.microlenses),
        ] {
            if let Some(source) = source {
                filter = filter.product(&fraction(key, source, &mut resolve)?);
            }
        }
        if let Some(surplus) = d.channels.keys().find(|name| !cfa.channels().contains(name)) {
            let message = format!("the colour filter array {:?} has no channel {surplus:?}", d.cfa);
            let channels = cfa.channels().join(", ");
            let help = format!("its channels are {channels}; of a preset, write without = [\"channels.{surplus}\"]");
            return Err(Invalid::new(format!("channels.{surplus}"), message).help(help));
        }
        let quantum_efficiency = cfa
            .channels()
            .iter()
            .map(|letter| {
                let Some(channel) = d.channels.get(letter) else {
                    let message = format!("missing; the colour filter array {:?} needs it", d.cfa);
                    return Err(Invalid::new(format!("channels.{letter}"), message)
                        .help(format!("write [channels.{letter}] with a quantum_efficiency")));
                };
                quantum_efficiency(channel, &mut resolve).map_err(|e| e.within(&format!("channels.{letter}")))
            })
            .collect::<Result<_, _>>()?;
        positive("charge.full_well_e", d.charge.full_well_e, "10000.0")?;
        let architecture = Architecture::new(d)?;
        let shutter = Shutter::new(&d.shutter).map_err(|e| e.within("shutter"))?;
        shutter.check(d, &cfa)?;
        let converter = Converter::new(&d.adc).map_err(|e| e.within("adc"))?;
        let logarithmic = logarithmic(d, &converter)?;
        Ok(Self {
            name: own_name(d)?.unwrap_or(name).to_owned(),
            description: d.description.clone(),
            source: d.source.clone(),
            serial: d.serial,
            architecture,
            shutter,
            resolution: d.resolution_px.map(|n| n as usize),
            masked: MaskedPixels {
                columns: margins("masked_columns", d.masked_columns)?,
                rows: margins("masked_rows", d.masked_rows)?,
            },
            pixel_pitch_m,
            fill_factor: d.fill_factor,
            crosstalk: crosstalk(d, &cfa)?,
            cfa,
            filter,
            quantum_efficiency,
            noise: Noise::new(&d.noise, &d.defects)?,
            full_well: Electrons(d.charge.full_well_e),
            brighter_fatter_per_e: brighter_fatter(d)?,
            image_lag: ImageLag::new(d, &shutter)?,
            logarithmic,
            converter,
        })
    }

    /// Columns and rows of pixels that there are: of a scanning sensor one row, whatever the lines of a picture.
    pub fn pixel_array(&self) -> [usize; 2] {
        let [columns, rows] = self.resolution;
        [columns, if self.shutter.scans() { 1 } else { rows }]
    }

    /// Rows of a picture as it is read out, covered ones among them.
    pub fn rows_read_out(&self) -> usize {
        self.masked.rows[0] + self.resolution[1] + self.masked.rows[1]
    }

    /// Time from the start of one picture of a series to that of the next: as stated, else as short as the exposure and
    /// rows that follow each other allow.
    pub fn frame_interval(&self, exposure: Seconds, stated: Option<Seconds>) -> Seconds {
        stated.unwrap_or(Seconds(exposure.0.max(self.shutter.duration(self.rows_read_out()).0)))
    }

    /// Width of a pixel over its height.
    pub fn pixel_aspect(&self) -> f64 {
        self.pixel_pitch_m[0] / self.pixel_pitch_m[1]
    }

    /// Area of a pixel, m².
    pub fn pixel_area_m2(&self) -> f64 {
        self.pixel_pitch_m[0] * self.pixel_pitch_m[1]
    }

    /// Quantum efficiency of every channel behind the filter, η_c(λ)·T(λ).
    pub fn efficiencies(&self) -> Vec<Spectrum> {
        self.quantum_efficiency.iter().map(|qe| qe.product(&self.filter)).collect()
    }

    /// Spectral response of every channel: electrons per second for each W·m⁻²·nm⁻¹ of irradiance and nm of bandwidth,
    ///
    /// R_c(λ) = A · FF · η_c(λ) · T(λ) · λ/(h·c),
    ///
    /// with the pixel's area A in m², the fill factor FF, the quantum efficiency η_c and the filter's transmittance T.
    /// ∫ R_c(λ)·E(λ) dλ, λ in nm, is the rate of photo-electrons in e⁻/s
    /// (the sensitivity model of [Emva1288](photosite_core::references#emva1288), integrated over wavelength).
    pub fn responses(&self) -> Vec<(String, Spectrum)> {
        let area = self.pixel_area_m2() * self.fill_factor;
        let response = |efficiency: Spectrum| {
            efficiency.map(|lambda_nm, electrons_per_photon| {
                let photons_per_joule = lambda_nm * 1e-9 / (PLANCK * SPEED_OF_LIGHT);
                area * electrons_per_photon * photons_per_joule
            })
        };
        self.cfa.channels().iter().cloned().zip(self.efficiencies().into_iter().map(response)).collect()
    }
}

/// The name that a description gives.
fn own_name(d: &SensorDescription) -> Result<Option<&str>, Invalid> {
    match d.name.as_deref() {
        Some(name) if name.trim().is_empty() || name.contains(char::is_control) => {
            let help = "for example name = \"my camera\", or leave it out";
            Err(Invalid::new("name", format!("{name:?} is no name")).help(help))
        }
        name => Ok(name),
    }
}

/// The pitch as stated, or that of a format.
fn pixel_pitch_m(d: &SensorDescription) -> Result<[f64; 2], Invalid> {
    match (&d.pixel_pitch_um, &d.format) {
        (Some(_), Some(_)) => {
            Err(Invalid::new("format", "cannot go with pixel_pitch_um").help("keep the one that is known better"))
        }
        (None, None) => Err(Invalid::new("pixel_pitch_um", "is missing")
            .help("for example pixel_pitch_um = [3.45, 3.45], or format = \"2/3\"")),
        (Some(pitch), None) => {
            for &um in pitch {
                positive("pixel_pitch_um", um, "[3.45, 3.45]")?;
            }
            Ok(pitch.map(|um| um * 1e-6))
        }
        (None, Some(name)) => {
            let [width, height] = format::format_m(name).ok_or_else(|| {
                Invalid::new("format", format!("there is no sensor format {name:?}"))
                    .help(format!("known are {} inch; any other size is given by pixel_pitch_um", format::names()))
            })?;
            Ok([width / f64::from(d.resolution_px[0]), height / f64::from(d.resolution_px[1])])
        }
    }
}

/// Logarithmic pixels are those of CMOS sensors with one converter range.
fn logarithmic(d: &SensorDescription, converter: &Converter) -> Result<Option<Logarithmic>, Invalid> {
    const KEY: &str = "charge.logarithmic_reference_e_per_s";
    let Some(reference_e_per_s) = d.charge.logarithmic_reference_e_per_s else { return Ok(None) };
    positive(KEY, reference_e_per_s, "100.0")?;
    let clash = match d.kind {
        SensorKind::Cmos => converter.dual_gain.as_ref().map(|_| "adc.dual_gain".to_owned()),
        SensorKind::Ccd | SensorKind::Spad => Some(format!("kind = {:?}", d.kind.name())),
    };
    match clash {
        Some(other) => Err(Invalid::new(KEY, format!("cannot go with {other}")).help("keep one of them")),
        None => Ok(Some(Logarithmic { reference_e_per_s })),
    }
}

/// The kernel of each channel, if any has one.
fn crosstalk(d: &SensorDescription, cfa: &Cfa) -> Result<Option<Vec<Kernel>>, Invalid> {
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

fn margins(key: &str, [before, after]: [u32; 2]) -> Result<[usize; 2], Invalid> {
    Ok([margin(key, before)?, margin(key, after)?])
}

fn brighter_fatter(d: &SensorDescription) -> Result<[f64; 2], Invalid> {
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

/// What a channel says of its quantum efficiency, in one of two ways.
fn quantum_efficiency(
    channel: &ChannelDescription,
    resolve: &mut impl FnMut(&SpectrumSource) -> Result<Spectrum, Invalid>,
) -> Result<Spectrum, Invalid> {
    let help = "write a quantum_efficiency, or the depths between which silicon absorbs, depth_um = [0.0, 3.0]";
    match (&channel.quantum_efficiency, channel.depth_um) {
        (Some(source), None) => fraction("quantum_efficiency", source, resolve),
        (None, Some(depth_um @ [upper, lower])) => {
            if !(upper.is_finite() && lower.is_finite() && 0.0 <= upper && upper < lower) {
                let message = format!("{upper} to {lower} is no range of depths");
                return Err(Invalid::new("depth_um", message).help("for example depth_um = [0.0, 3.0]"));
            }
            Ok(layers::quantum_efficiency(depth_um))
        }
        (Some(_), Some(_)) => Err(Invalid::new("depth_um", "says the same as quantum_efficiency").help(help)),
        (None, None) => Err(Invalid::new("quantum_efficiency", "missing").help(help)),
    }
}

/// Columns or rows beyond this are a slip of the pen: the largest sensors made have some 30 000.
const MAX_RESOLUTION: u32 = 65_535;

#[cfg(test)]
mod tests {
    use super::*;

    const TOML: &str = r#"
        resolution_px = [64, 48]
        pixel_pitch_um = [5.0, 4.0]
        fill_factor = 0.5
        cfa = "RGGB"
        filter.transmittance = 0.8
        channels.R.quantum_efficiency = 0.6
        channels.G.quantum_efficiency = 0.7
        channels.B.quantum_efficiency = 0.5
        noise = { read_noise_e = 2.0, dark_current_e_per_s = 1.0, dark_current_reference_c = 25.0, dark_current_doubling_k = 8.0, prnu_percent = 1.0, dsnu_e = 0.5 }
        charge.full_well_e = 10000.0
        adc = { bits = 12, conversion_gain_dn_per_e = 0.4, black_level_dn = 64, gain_db_range = [0.0, 24.0] }
    "#;

    fn number(source: &SpectrumSource) -> Result<Spectrum, Invalid> {
        match source {
            SpectrumSource::Number(value) => Ok(Spectrum::constant(*value as f32)),
            SpectrumSource::Name(_) | SpectrumSource::File(_) => Err(Invalid::new("", "no such spectrum")),
        }
    }

    fn model(text: &str) -> Result<SensorModel, Invalid> {
        let description: SensorDescription = toml::from_str(text).expect("right keys and types");
        SensorModel::new("test", &description, number)
    }

    #[test]
    fn photons_of_a_monochromatic_flux_by_hand() {
        // 1e-3 W/m² in a band of 1 nm at 500 nm, on 20 µm² of which half is sensitive, through a filter of 0.8:
        // 1e-3 W/m² · 1e-11 m² · 0.8 = 8e-15 W; a photon carries 6.62607015e-34 · 299792458 / 500e-9 = 3.972891714e-19 J,
        // so 20136.466 photons/s arrive, and 0.6 of them become 12081.88 electrons/s.
        let sensor = model(TOML).expect("valid");
        let (name, red) = &sensor.responses()[0];
        assert_eq!(name, "R");
        let rate = f64::from(red.eval(500.0)) * 1e-3;
        // The table holds f32: 2⁻²⁴ relative, three roundings.
        assert!((rate / 12_081.88 - 1.0).abs() < 1e-6, "{rate}");
    }

    #[test]
    fn the_response_integrates_a_broad_spectrum_to_its_photon_count() {
        // The number of photons grows with λ: for E = 1 W/m²/nm from 300 to 1100 nm, ∫ λ dλ = (1100² − 300²)/2 nm².
        let sensor = model(TOML).expect("valid");
        let integral = sensor.responses()[1].1.integral();
        let photons = 1e-9 / (PLANCK * SPEED_OF_LIGHT) * (1100.0f64.powi(2) - 300.0f64.powi(2)) / 2.0;
        assert!((integral / (1e-11 * 0.8 * 0.7 * photons) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn what_no_sensor_can_be_is_refused_by_key() {
        for (from, to, key) in [
            ("[64, 48]", "[64, 0]", "resolution_px"),
            ("[5.0, 4.0]", "[5.0, -4.0]", "pixel_pitch_um"),
            ("fill_factor = 0.5", "fill_factor = 1.5", "fill_factor"),
            ("\"RGGB\"", "\"RGG\"", "cfa"),
            ("\"RGGB\"", "\"mono\"", "channels.B"),
            ("channels.G.quantum_efficiency = 0.7", "", "channels.G"),
            ("quantum_efficiency = 0.6", "quantum_efficiency = 60", "channels.R.quantum_efficiency"),
            ("quantum_efficiency = 0.5", "quantum_efficiency = -0.1", "channels.B.quantum_efficiency"),
            ("quantum_efficiency = 0.5", "quantum_efficiency = \"nowhere\"", "channels.B.quantum_efficiency"),
            ("transmittance = 0.8", "transmittance = 1.1", "filter.transmittance"),
            ("read_noise_e = 2.0", "read_noise_e = -2.0", "noise.read_noise_e"),
            ("dark_current_doubling_k = 8.0", "dark_current_doubling_k = 0", "noise.dark_current_doubling_k"),
            ("prnu_percent = 1.0", "prnu_percent = nan", "noise.prnu_percent"),
            ("dsnu_e = 0.5", "dsnu_e = inf", "noise.dsnu_e"),
            ("dark_current_doubling_k = 8.0, ", "", "noise.dark_current_doubling_k"),
            ("dsnu_e = 0.5", "dsnu_e = 0.5, row_noise_e = -1", "noise.row_noise_e"),
            ("dsnu_e = 0.5", "dsnu_e = 0.5, reset = { noise_e = 3, capacitance_ff = 1 }", "noise.reset.capacitance_ff"),
            ("dsnu_e = 0.5", "dsnu_e = 0.5, flicker.exponent = 3", "noise.flicker.exponent"),
            ("dsnu_e = 0.5", "dsnu_e = 0.5, telegraph.high_s = 0", "noise.telegraph.high_s"),
            ("dsnu_e = 0.5", "dsnu_e = 0.5, read_noise_degrees_of_freedom = 2", "noise.read_noise_degrees_of_freedom"),
            (
                "dsnu_e = 0.5",
                "dsnu_e = 0.5, transmission_errors_per_million = 2e6",
                "noise.transmission_errors_per_million",
            ),
            ("fill_factor = 0.5", "defects.hot_per_million = -1", "defects.hot_per_million"),
            ("fill_factor = 0.5", "format = \"2/3\"", "format"),
            ("pixel_pitch_um = [5.0, 4.0]", "", "pixel_pitch_um"),
            ("pixel_pitch_um = [5.0, 4.0]", "format = \"3/2\"", "format"),
            ("fill_factor = 0.5", "crosstalk = [[0.5, 0.4, 0.0]]", "crosstalk"),
            ("fill_factor = 0.5", "channels.R.crosstalk = [[0.5, 0.5]]", "channels.R.crosstalk"),
            ("bits = 12", "bits = 12, inl_dn = 2000", "adc.inl_dn"),
            ("bits = 12", "bits = 12, dnl_dn = 0.5", "adc.dnl_dn"),
            ("bits = 12", "bits = 12, amplifier_nonlinearity_percent = [-60]", "adc.amplifier_nonlinearity_percent"),
            ("bits = 12", "bits = 12, column_gain_percent = nan", "adc.column_gain_percent"),
            ("full_well_e = 10000.0", "full_well_e = 0", "charge.full_well_e"),
            (
                "full_well_e = 10000.0",
                "full_well_e = 10000.0\ncharge.image_lag.percent = 100",
                "charge.image_lag.percent",
            ),
            (
                "full_well_e = 10000.0",
                "full_well_e = 10000.0\ncharge.image_lag = { percent = 1, decay = 1 }",
                "charge.image_lag.decay",
            ),
            (
                "full_well_e = 10000.0",
                "full_well_e = 10000.0\ncharge.image_lag.electrons = -1",
                "charge.image_lag.electrons",
            ),
            (
                "full_well_e = 10000.0",
                "full_well_e = 10000.0\ncharge.image_lag.percent = 1\ncharge.logarithmic_reference_e_per_s = 100",
                "charge.image_lag",
            ),
            ("bits = 12", "bits = 0", "adc.bits"),
            ("bits = 12", "bits = 40", "adc.bits"),
            ("gain_dn_per_e = 0.4", "gain_dn_per_e = 0", "adc.conversion_gain_dn_per_e"),
            ("black_level_dn = 64", "black_level_dn = 4095", "adc.black_level_dn"),
            ("[0.0, 24.0]", "[24.0, 0.0]", "adc.gain_db_range"),
        ] {
            assert!(TOML.contains(from), "{from}");
            let error = model(&TOML.replacen(from, to, 1)).expect_err(to);
            assert_eq!(error.key, key, "{error}");
        }
    }

    #[test]
    fn a_format_over_the_resolution_is_the_pitch() {
        let sensor = model(&TOML.replace("pixel_pitch_um = [5.0, 4.0]", "format = '2/3\"'")).expect("valid");
        assert_eq!(sensor.pixel_pitch_m, [8.8e-3 / 64.0, 6.6e-3 / 48.0]);
        assert_eq!(sensor.pixel_aspect(), 1.0);
    }

    #[test]
    fn filters_follow_one_another() {
        let text = TOML.replace("filter.transmittance = 0.8", "filter = { cover_glass = 0.5, microlenses = 0.25 }");
        assert_eq!(model(&text).expect("valid").filter.eval(500.0), 0.125);
    }

    #[test]
    fn figures_of_other_kinds_of_sensors_are_refused_by_key() {
        let interline = "kind = 'ccd'\nccd = { smear_db = -80.0, line_time_us = 30.0 }";
        let one_bit = "kind = 'spad'\nspad = { counting = 'one-bit', one_bit_frames = 16 }";
        let dual = "adc.dual_gain = { bits = 11, black_level_dn = 20, high_gain_dn_per_e = 4.0, low_gain_dn_per_e = 0.1, \
                    low_gain_read_noise_e = 5.0 }";
        let toml = TOML.replace(
            "adc = { bits = 12, conversion_gain_dn_per_e = 0.4, black_level_dn = 64, \
                                 gain_db_range = [0.0, 24.0] }",
            "",
        );
        let adc =
            "adc.bits = 16\nadc.conversion_gain_dn_per_e = 4.0\nadc.black_level_dn = 64\nadc.gain_db_range = [0, 0]";
        for (lines, from, to, key) in [
            (interline, "'ccd'", "'cmos'", "ccd"),
            (interline, "'ccd'", "'spad'", "ccd"),
            (interline, "-80.0", "80.0", "ccd.smear_db"),
            (interline, ", line_time_us = 30.0", "", "ccd.line_time_us"),
            (interline, "smear_db = -80.0", "row_shift_time_us = 1.0", "ccd.row_shift_time_us"),
            (interline, "smear_db = -80.0", "vertical_cti = 1.0", "ccd.vertical_cti"),
            (interline, "smear_db = -80.0", "horizontal_cti = -1e-6", "ccd.horizontal_cti"),
            (interline, "smear_db = -80.0", "anti_blooming_factor = 0.5", "ccd.anti_blooming_factor"),
            (interline, "smear_db = -80.0", "overscan_rows = 70000", "ccd.overscan_rows"),
            (interline, "ccd =", "masked_rows = [0, 5000]\nccd =", "masked_rows"),
            (one_bit, "'spad'", "'cmos'", "spad"),
            (one_bit, "\nspad = { counting = 'one-bit', one_bit_frames = 16 }", "", "spad"),
            (one_bit, ", one_bit_frames = 16", "", "spad.one_bit_frames"),
            (one_bit, "16", "0", "spad.one_bit_frames"),
            (one_bit, "one-bit", "free-running", "spad.one_bit_frames"),
            (one_bit, "one_bit_frames = 16", "dead_time_ns = 50.0", "spad.dead_time_ns"),
            (one_bit, "16", "16, afterpulsing_percent = 100.0", "spad.afterpulsing_percent"),
            (dual, "bits = 11", "bits = 40", "adc.dual_gain.bits"),
            (dual, "black_level_dn = 20", "black_level_dn = 2047", "adc.dual_gain.black_level_dn"),
            (dual, "high_gain_dn_per_e = 4.0", "high_gain_dn_per_e = 0.05", "adc.dual_gain.low_gain_dn_per_e"),
            (dual, "noise_e = 5.0", "noise_e = -5.0", "adc.dual_gain.low_gain_read_noise_e"),
        ] {
            // Keys of the whole sensor come before any table.
            let text = |lines: &str| format!("{lines}\n{adc}\n{toml}");
            model(&text(lines)).expect("valid");
            assert!(lines.contains(from), "{from}");
            let error = model(&text(&lines.replacen(from, to, 1))).expect_err(to);
            assert_eq!(error.key, key, "{error}");
        }
        for (from, to, key) in [
            ("full_well_e = 10000.0", "brighter_fatter_per_e = [1e-3, 0.0]", "charge.brighter_fatter_per_e"),
            ("R.quantum_efficiency = 0.6", "R.depth_um = [0.5, 0.2]", "channels.R.depth_um"),
            ("R.quantum_efficiency = 0.6", "R = {}", "channels.R.quantum_efficiency"),
            (
                "G.quantum_efficiency = 0.7",
                "G = { quantum_efficiency = 0.7, depth_um = [0, 1] }",
                "channels.G.depth_um",
            ),
        ] {
            let to = if key.starts_with("charge") {
                format!("full_well_e = 10000.0\n        charge.{to}")
            } else {
                to.to_owned()
            };
            let error = model(&TOML.replacen(from, &to, 1)).expect_err(&to);
            assert_eq!(error.key, key, "{error}");
        }
    }

    /// A sensor of which nothing is said but what there must be.
    const BARE: &str = r#"
        resolution_px = [64, 48]
        pixel_pitch_um = [5.0, 4.0]
        cfa = "mono"
        channels.Y.quantum_efficiency = 0.6
        charge.full_well_e = 10000.0
        adc = { bits = 12, conversion_gain_dn_per_e = 0.4, black_level_dn = 64 }
    "#;

    #[test]
    fn what_is_left_out_is_not_there() {
        let bare = model(BARE).expect("valid");
        assert_eq!(bare.noise, Noise::NONE);
        assert_eq!(bare.converter.gain_range.map(|gain| gain.0), [0.0, 0.0]);
        assert_eq!(model(&format!("{BARE}noise = {{}}")).expect("valid"), bare);
        // Any one key can stand alone.
        let read = model(&format!("{BARE}noise.read_noise_e = 3")).expect("valid");
        assert_eq!(read.noise, Noise { read: Electrons(3.0), ..Noise::NONE });
        let prnu = model(&format!("{BARE}noise.prnu_percent = 1")).expect("valid");
        assert_eq!(prnu.noise, Noise { prnu: FixedPattern::of_pixels(0.01), ..Noise::NONE });
    }

    #[test]
    fn dark_current_needs_a_temperature_and_a_law() {
        let key = |noise: &str| model(&format!("{BARE}{noise}")).expect_err(noise).key;
        assert_eq!(key("noise.dark_current_e_per_s = 2"), "noise.dark_current_reference_c");
        let celsius = "noise.dark_current_reference_c = 20";
        assert_eq!(key(&format!("noise.dark_current_e_per_s = 2\n{celsius}")), "noise.dark_current_doubling_k");
        let hot = "defects = { hot_per_million = 10, hot_dark_current_e_per_s = 100 }";
        assert_eq!(key(hot), "noise.dark_current_reference_c");
        model(&format!("{BARE}{hot}\n{celsius}\nnoise.dark_current_law = 'arrhenius'")).expect("valid");
    }

    #[test]
    fn a_sensor_can_have_a_name_of_its_own() {
        assert_eq!(model(&format!("name = 'mine'\n{BARE}")).expect("valid").name, "mine");
        assert_eq!(model(&format!("name = ' '\n{BARE}")).expect_err("blank").key, "name");
    }

    #[test]
    fn an_error_tells_the_wavelength_of_an_impossible_efficiency() {
        let description: SensorDescription = toml::from_str(TOML).expect("valid");
        let peak = |_: &SpectrumSource| Ok(Spectrum::from_fn(|lambda| if lambda == 612.0 { 1.25 } else { 0.5 }));
        let error = SensorModel::new("test", &description, peak).expect_err("above 1");
        assert!(error.message.contains("1.25 at 612 nm"), "{error}");
    }

    #[test]
    fn a_misspelt_key_is_refused() {
        let error =
            toml::from_str::<SensorDescription>(&TOML.replace("prnu_percent", "prnu_pct")).expect_err("misspelt");
        assert!(error.to_string().contains("prnu_pct"), "{error}");
    }
}
