//! A sensor, checked and in SI units, and what light makes of it: its spectral responses.
//!
//! In: a [`SensorDescription`] and a way to find the spectra that it names. Out: a [`SensorModel`] whose numbers can be
//! relied on. Reading files is left to the caller.

mod checks;
mod converter;
mod noise;

use crate::Invalid;
use crate::raw::Cfa;
use crate::spectrum::Spectrum;
use crate::units::{Electrons, PLANCK, SPEED_OF_LIGHT};

use super::description::{SensorDescription, SensorKind, SpectrumSource};
use checks::{fraction, positive};
pub use converter::Converter;
pub use noise::{FixedPattern, Noise};

/// An image sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorModel {
    /// Preset or file name; becomes the camera model of raw files.
    pub name: String,
    /// What it is, in a sentence.
    pub description: String,
    /// Where its numbers come from.
    pub source: String,
    /// Technology of the pixels.
    pub kind: SensorKind,
    /// Columns and rows.
    pub resolution: [usize; 2],
    /// Pixel pitch along x and y, m.
    pub pixel_pitch_m: [f64; 2],
    /// Sensitive part of a pixel's area, above 0 up to 1.
    pub fill_factor: f64,
    /// Colour filter array.
    pub cfa: Cfa,
    /// Transmittance of the filter in front of all pixels, 0–1.
    pub filter: Spectrum,
    /// Quantum efficiency η(λ), 0–1, one for each of the CFA's channels in their order.
    pub quantum_efficiency: Vec<Spectrum>,
    /// Noise sources.
    pub noise: Noise,
    /// Most electrons that a pixel can hold.
    pub full_well: Electrons,
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
        for pitch in d.pixel_pitch_um {
            positive("pixel_pitch_um", pitch, "[3.45, 3.45]")?;
        }
        positive("fill_factor", d.fill_factor, "1.0")?;
        if d.fill_factor > 1.0 {
            return Err(Invalid::new("fill_factor", format!("must be at most 1, got {}", d.fill_factor))
                .help("it is the part of a pixel's area that is sensitive to light"));
        }
        let cfa = Cfa::parse(&d.cfa)?;
        let filter = match &d.filter.transmittance {
            Some(source) => fraction("filter.transmittance", source, &mut resolve)?,
            None => Spectrum::constant(1.0),
        };
        if let Some(surplus) = d.channels.keys().find(|name| !cfa.channels().contains(name)) {
            let message = format!("the colour filter array {:?} has no channel {surplus:?}", d.cfa);
            let help = format!("its channels are {}", cfa.channels().join(", "));
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
                let key = format!("channels.{letter}.quantum_efficiency");
                fraction(&key, &channel.quantum_efficiency, &mut resolve)
            })
            .collect::<Result<_, _>>()?;
        positive("charge.full_well_e", d.charge.full_well_e, "10000.0")?;
        Ok(Self {
            name: name.to_owned(),
            description: d.description.clone(),
            source: d.source.clone(),
            kind: d.kind,
            resolution: d.resolution_px.map(|n| n as usize),
            pixel_pitch_m: d.pixel_pitch_um.map(|um| um * 1e-6),
            fill_factor: d.fill_factor,
            cfa,
            filter,
            quantum_efficiency,
            noise: Noise::new(&d.noise).map_err(|e| e.within("noise"))?,
            full_well: Electrons(d.charge.full_well_e),
            converter: Converter::new(&d.adc).map_err(|e| e.within("adc"))?,
        })
    }

    /// Area of a pixel, m².
    pub fn pixel_area_m2(&self) -> f64 {
        self.pixel_pitch_m[0] * self.pixel_pitch_m[1]
    }

    /// Spectral response of every channel: electrons per second for each W·m⁻²·nm⁻¹ of irradiance and nm of bandwidth,
    ///
    /// R_c(λ) = A · FF · η_c(λ) · T(λ) · λ/(h·c),
    ///
    /// with the pixel's area A in m², the fill factor FF, the quantum efficiency η_c and the filter's transmittance T.
    /// ∫ R_c(λ)·E(λ) dλ, λ in nm, is the rate of photo-electrons in e⁻/s
    /// (the sensitivity model of [Emva1288](crate::references#emva1288), integrated over wavelength).
    pub fn responses(&self) -> Vec<(String, Spectrum)> {
        let area = self.pixel_area_m2() * self.fill_factor;
        let response = |quantum_efficiency: &Spectrum| {
            quantum_efficiency.product(&self.filter).map(|lambda_nm, electrons_per_photon| {
                let photons_per_joule = lambda_nm * 1e-9 / (PLANCK * SPEED_OF_LIGHT);
                area * electrons_per_photon * photons_per_joule
            })
        };
        self.cfa.channels().iter().cloned().zip(self.quantum_efficiency.iter().map(response)).collect()
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
            ("full_well_e = 10000.0", "full_well_e = 0", "charge.full_well_e"),
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
