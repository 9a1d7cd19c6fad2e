//! The settings of one exposure.

use photosite_core::Invalid;
use photosite_core::units::{Celsius, Decibels, Seconds};
use photosite_raw::PixelArea;

use crate::{Binning, SensorModel, Shutter, Use};

/// Beyond this, a single step of an 8-bit converter fills the range of digital numbers.
const MAX_DIGITAL_GAIN_DB: f64 = 48.0;

/// Settings of one exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// Exposure time, in which light and dark current are collected.
    pub time: Seconds,
    /// Analogue gain on top of the sensor's conversion gain.
    pub gain: Decibels,
    /// Gain of the digital numbers that leave the converter, 0 dB and more.
    pub digital_gain: Decibels,
    /// Temperature of the sensor.
    pub temperature: Celsius,
    /// Time from the start of one image of a series to that of the next, where it is longer than it has to be.
    pub frame_interval: Option<Seconds>,
    /// Region of interest and binning.
    pub region: RegionOfInterest,
}

/// Region of the sensor that is read out, and its binning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionOfInterest {
    /// Pixels that are read out as one.
    pub binning: Binning,
    /// The pixels that leave the sensor, before binning; `None` for all, with those that are covered. Nothing about
    /// them depends on what else is read out.
    pub pixels: Option<PixelArea>,
}

impl RegionOfInterest {
    /// Readout of the whole sensor, pixel by pixel.
    pub const WHOLE: Self = Self { binning: Binning::NONE, pixels: None };

    /// Refuses what this sensor cannot do. Keys are those of the capture file's `[exposure]` table.
    fn validate(&self, sensor: &SensorModel) -> Result<(), Invalid> {
        self.binning.validate(sensor)?;
        self.fits(sensor, sensor.resolution)?;
        let cell = self.binning.cell(&sensor.cfa);
        if let Some(PixelArea { y, .. }) = self.pixels {
            sensor.allows(Use::Region)?;
            let of_row = |invalid: Invalid| Invalid { message: format!("row {y} {}", invalid.message), ..invalid };
            if y % 2 == 1 {
                sensor.allows(Use::RegionFromOddRow).map_err(of_row)?;
            }
        }
        match self.pixels {
            Some(PixelArea { x, y, width, height })
                if [x, width].iter().any(|n| n % cell[0] != 0) || [y, height].iter().any(|n| n % cell[1] != 0) =>
            {
                let [across, down] = self.binning.factor;
                let message =
                    format!("{width} × {height} pixels at {x}, {y} do not divide into whole bins of {across} × {down}");
                let help = format!("write multiples of {} along rows and of {} along columns", cell[0], cell[1]);
                Err(Invalid::new("region_px", message).help(help))
            }
            Some(_) | None => Ok(()),
        }
    }

    /// Refuses a bin that is larger than the given columns and rows, and a region that is no part of them.
    pub(crate) fn fits(&self, sensor: &SensorModel, [columns, rows]: [usize; 2]) -> Result<(), Invalid> {
        if self.binning.whole_bins([columns, rows], &sensor.cfa).contains(&0) {
            let [across, down] = self.binning.cell(&sensor.cfa);
            let message = format!("{columns} × {rows} pixels have no whole bins, which take {across} × {down} of them");
            return Err(Invalid::new("binning", message).help("write smaller bins"));
        }
        let Some(PixelArea { x, y, width, height }) = self.pixels else { return Ok(()) };
        let refuse = |message: String, help: &str| Err(Invalid::new("region_px", message).help(help));
        let within = |first: usize, length: usize, side: usize| {
            length > 0 && first.checked_add(length).is_some_and(|end| end <= side)
        };
        if !(within(x, width, columns) && within(y, height, rows)) {
            let message = format!("{width} × {height} pixels at {x}, {y} do not lie within {columns} × {rows}");
            return refuse(message, "write [first column, first row, columns, rows]");
        }
        Ok(())
    }
}

impl Exposure {
    /// Exposure of the whole sensor for a time at 25 °C and 0 dB.
    pub const fn of(time: Seconds) -> Self {
        Self {
            time,
            gain: Decibels(0.0),
            digital_gain: Decibels(0.0),
            temperature: Celsius(25.0),
            frame_interval: None,
            region: RegionOfInterest::WHOLE,
        }
    }

    /// Refuses what this sensor cannot do. Keys are those of the capture file's `[exposure]` table.
    pub fn validate(&self, sensor: &SensorModel) -> Result<(), Invalid> {
        if !(self.time.0.is_finite() && self.time.0 > 0.0) {
            return Err(Invalid::new("time_s", format!("must be above 0, got {}", self.time.0))
                .help("for example time_s = 0.01"));
        }
        let [low, high] = sensor.converter.gain_range;
        if !(low.0..=high.0).contains(&self.gain.0) {
            let message = format!("{} dB is not among the gains of sensor {}", self.gain.0, sensor.name);
            return Err(Invalid::new("gain_db", message).help(format!("write {} to {} dB", low.0, high.0)));
        }
        if !(0.0..=MAX_DIGITAL_GAIN_DB).contains(&self.digital_gain.0) {
            let message = format!("must lie from 0 to {MAX_DIGITAL_GAIN_DB}, got {}", self.digital_gain.0);
            return Err(Invalid::new("digital_gain_db", message).help("smaller numbers would never reach white"));
        }
        self.region.validate(sensor)?;
        if !(self.temperature.0 > -photosite_core::units::ZERO_CELSIUS && self.temperature.0.is_finite()) {
            let message = format!("no sensor works at {} °C", self.temperature.0);
            return Err(Invalid::new("temperature_c", message).help("for example temperature_c = 25.0"));
        }
        if !sensor.noise.dark_electrons(self.temperature, self.time).0.is_finite() {
            let message = format!("the dark current of the sensor is infinite at {} °C", self.temperature.0);
            let help = "lower it, or raise noise.dark_current_reference_c of the sensor or its dark_current_doubling_k";
            return Err(Invalid::new("temperature_c", message).help(help));
        }
        if let Some(interval) = self.frame_interval
            && !(interval.0.is_finite() && interval.0 >= sensor.frame_interval(self.time, None).0)
        {
            let message = if interval.0 >= self.time.0 {
                let all_s = sensor.shutter.duration(sensor.rows_read_out()).0;
                format!("{} s is shorter than the {all_s} s that all rows take one after the other", interval.0)
            } else {
                format!("{} s is shorter than the exposure of {} s", interval.0, self.time.0)
            };
            // Data sets set it for cameras on a way.
            let most_hz = (1e3 / sensor.frame_interval(self.time, None).0).floor() / 1e3;
            let help = format!(
                "leave it out for one exposure after another; of a data set with a trajectory, lower its frame_rate_hz \
                 to at most {most_hz}"
            );
            return Err(Invalid::new("frame_interval_s", message).help(help));
        }
        if let Shutter::Scanning { line_time } = sensor.shutter
            && self.time.0 > line_time.0
        {
            let message = format!(
                "{} s is longer than the {} s from one line to the next, which the same pixels see",
                self.time.0, line_time.0
            );
            return Err(Invalid::new("time_s", message).help("shorten it, or lengthen sensor.shutter.row_time_us"));
        }
        Ok(())
    }

    /// Time at which the first row of an image of a series is read out, counted from the start of the series.
    pub(crate) fn read_out_time(&self, sensor: &SensorModel, frame: u64) -> Seconds {
        let interval = sensor.frame_interval(self.time, self.frame_interval);
        Seconds(interval.0 * frame as f64 + self.time.0)
    }
}
