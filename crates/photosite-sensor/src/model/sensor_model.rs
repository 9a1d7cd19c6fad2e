//! A sensor, checked and in SI units, and what light makes of it: its spectral responses.

use photosite_core::Invalid;
use photosite_core::cells::CellLayout;
use photosite_core::spectrum::Spectrum;
use photosite_core::units::{Decibels, Electrons, PLANCK, SPEED_OF_LIGHT, Seconds};
use photosite_raw::Cfa;

use super::architecture::Architecture;
use super::black_level::BlackLevelByGain;
use super::cells::{cell_layout, warnings};
use super::checks::{MAX_RESOLUTION, fraction, positive};
use super::converter::Converter;
use super::crosstalk::Kernel;
use super::description::SensorDescription;
use super::frame_grabber::FrameGrabber;
use super::image_lag::ImageLag;
use super::logarithmic::Logarithmic;
use super::masked_pixels::MaskedPixels;
use super::noise::Noise;
use super::pixels::{
    brighter_fatter, check_cells, check_shutter, crosstalk, image_lag, logarithmic, margins, own_name, pixel_pitch_m,
    quantum_efficiency,
};
use super::sensor_files::SensorFiles;
use super::shutter::Shutter;
use super::spectrum_source::SpectrumSource;
use super::video::{Video, check_analogue};

/// An image sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorModel {
    /// Preset or file name; becomes the camera model of raw files.
    pub name: String,
    /// Description of the sensor, in a sentence.
    pub description: String,
    /// Source of the sensor's figures, such as a data sheet.
    pub source: String,
    /// Serial number: the fixed pattern of the sensor is a function of it alone.
    pub serial: u64,
    /// Technology of the pixels.
    pub architecture: Architecture,
    /// Shutter: the times at which each row sees light.
    pub shutter: Shutter,
    /// Columns and rows of an image.
    pub resolution: [usize; 2],
    /// Masked columns and rows around the image, which see no light.
    pub masked: MaskedPixels,
    /// Pixel pitch along x and y, m.
    pub pixel_pitch_m: [f64; 2],
    /// Shape of the pixels, and which of them see light.
    pub cells: CellLayout,
    /// Sensitive part of a pixel's area, above 0 up to 1.
    pub fill_factor: f64,
    /// Colour filter array.
    pub cfa: Cfa,
    /// Transmittance of all filters in front of the pixels together, 0–1.
    pub filter: Spectrum,
    /// Quantum efficiency η(λ), 0–1, one for each of the CFA's channels in their order.
    pub quantum_efficiency: Vec<Spectrum>,
    /// Crosstalk kernels, one for each of the CFA's channels in their order; `None` where each pixel collects its own
    /// electrons.
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
    /// Video line: the way of the signal to the converter.
    pub video: Video,
    /// Frame grabber of an analogue sensor; `None` for one sample for each pixel.
    pub frame_grabber: Option<FrameGrabber>,
}

impl SensorModel {
    /// Checks a description. `files` finds what it names. Keys of errors are those of the sensor file.
    pub fn new(name: &str, description: &SensorDescription, mut files: impl SensorFiles) -> Result<Self, Invalid> {
        let mut resolve = |source: &SpectrumSource| files.spectrum(source);
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
            let message =
                format!("the colour filter array {:?} has no channel {surplus:?}, as its key cfa says", d.cfa);
            let channels = cfa.channels().join(", ");
            let help = format!("its channels are {channels}; for a preset, write without = [\"channels.{surplus}\"]");
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
        check_shutter(&shutter, d, &cfa)?;
        let resolution = d.resolution_px.map(|n| n as usize);
        let cells = cell_layout(d.cells, d.image_circle_mm, resolution, pixel_pitch_m)?;
        check_cells(&cells, &shutter, d)?;
        let mut converter = Converter::new(&d.adc).map_err(|e| e.within("adc"))?;
        // Checks that the gains of the steps rise, too.
        let noise = Noise::new(&d.noise, &d.defects)?;
        converter.black_level =
            BlackLevelByGain::new(converter.black_level_dn(Decibels(0.0)), converter.max_dn(), &d.noise.gain_steps)
                .map_err(|e| e.within("noise"))?;
        let logarithmic = logarithmic(d, &converter)?;
        let video = Video::new(&d.video, d.kind, &converter)?;
        let frame_grabber = d.frame_grabber.as_ref().map(|grabber| {
            check_analogue("frame_grabber", d.kind, &converter)?;
            FrameGrabber::new(grabber, &cfa, &cells, &shutter)
        });
        let frame_grabber = frame_grabber.transpose()?;
        let mut sensor = Self {
            name: own_name(d)?.unwrap_or(name).to_owned(),
            description: d.description.clone(),
            source: d.source.clone(),
            serial: d.serial,
            architecture,
            shutter,
            resolution,
            masked: MaskedPixels {
                columns: margins("masked_columns", d.masked_columns)?,
                rows: margins("masked_rows", d.masked_rows)?,
            },
            pixel_pitch_m,
            cells,
            fill_factor: d.fill_factor,
            crosstalk: crosstalk(d, &cfa)?,
            cfa,
            filter,
            quantum_efficiency,
            noise,
            full_well: Electrons(d.charge.full_well_e),
            brighter_fatter_per_e: brighter_fatter(d)?,
            image_lag: image_lag(d, &shutter)?,
            logarithmic,
            converter,
            video,
            frame_grabber,
        };
        sensor.take_patterns(&d.noise, &mut files)?;
        sensor.take_defects(d, &mut files)?;
        Ok(sensor)
    }

    /// Warnings about the cells of the sensor.
    pub(crate) fn cell_warnings(&self) -> Vec<String> {
        warnings(&self.cells, self.resolution, self.pixel_pitch_m)
    }

    /// Width and height of all pixels that make an image, m.
    pub fn size_m(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.pixel_array()[axis] as f64 * self.pixel_pitch_m[axis])
    }

    /// Columns and rows of pixels that there are: of a scanning sensor one row, whatever the lines of an image.
    pub fn pixel_array(&self) -> [usize; 2] {
        let [columns, rows] = self.resolution;
        [columns, if self.shutter.scans() { 1 } else { rows }]
    }

    /// Rows of an image as it is read out, covered ones among them.
    pub fn rows_read_out(&self) -> usize {
        self.masked.rows[0] + self.resolution[1] + self.masked.rows[1]
    }

    /// Time from the start of one image of a series to that of the next: as stated, else as short as the exposure and
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
