//! Noise maps: the contribution of each effect of the sensor to every digital number of one image.
//!
//! Maps are differences: the signal behind an effect less that before it, e⁻ up to the gain and DN behind it. So they
//! sum to the image, in the units of their names,
//!
//! DN = black level + K·Σ (maps in e⁻) + Σ (maps in DN)
//!
//! with the system gain K, DN/e⁻, and `photo_electrons_e` among the first. `raw_clean` is the image without temporal
//! noise, exposed once more for it. Electrons are those of the pixel that is read
//! out: maps of a bin in e⁻ are sums over its pixels, whether their charge or their numbers are added or averaged.

use std::sync::{Mutex, MutexGuard};

use photosite_core::Invalid;
use photosite_core::image::{Channel, Planes};
use photosite_raw::{Cfa, PixelArea, RawImage};

use crate::signal::charge_plane::{ChargePlane, Row, RowStage};
use crate::signal::effects::{MapUnit, NoiseMap};
use crate::stages::dark_current::DarkCurrent;
use crate::stages::digital_gain::DigitalGain;
use crate::stages::frame::Frame;
use crate::stages::frame_grabber::Sampling;
use crate::{Binning, BinningMethod, Exposure, SensorModel};

/// The maps of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseMaps {
    /// Maps under their names, with `.` and the channel behind it where every pixel has several; as large as the raw
    /// image.
    pub planes: Planes,
    /// System gain K, DN/e⁻: [`SensorModel::system_gain`](crate::SensorModel::system_gain).
    pub system_gain: f64,
    /// Black level of the sum, DN.
    pub black_level_dn: f64,
}

impl NoiseMaps {
    /// No maps of a raw image of that exposure.
    ///
    /// # Errors
    ///
    /// None: there are no planes of another size.
    pub fn none(sensor: &SensorModel, exposure: &Exposure, raw: &RawImage) -> Result<Self, Invalid> {
        Ok(Self {
            planes: Planes::new(raw.width, raw.height, Vec::new())?,
            system_gain: sensor.system_gain(exposure),
            black_level_dn: sensor.converter.black_level_dn(exposure.gain).into(),
        })
    }
}

/// Takes down what each stage does, if anybody wants to know.
pub(super) struct Recorder {
    /// Maps that are kept.
    wanted: Vec<NoiseMap>,
    /// Rows, which are written side by side, of the signal behind the last stage and of the maps, in this order.
    rows: Vec<Mutex<Vec<Vec<f32>>>>,
}

/// Index of the signal among the rows of a [`Recorder`].
const SIGNAL: usize = 0;

impl Recorder {
    /// Starts recording with the mean photo-electrons.
    pub(super) fn start(wanted: &[NoiseMap], charge: &ChargePlane) -> Self {
        let empty = vec![vec![0.0; charge.width]; 1 + wanted.len()];
        let height = if wanted.is_empty() { 0 } else { charge.height };
        let recorder = Self { wanted: wanted.to_vec(), rows: (0..height).map(|_| Mutex::new(empty.clone())).collect() };
        recorder.plane(NoiseMap::PhotoElectronsE, charge);
        recorder
    }

    fn is_off(&self) -> bool {
        self.rows.is_empty()
    }

    fn row(&self, y: usize) -> MutexGuard<'_, Vec<Vec<f32>>> {
        self.rows[y].lock().expect("nobody panics while holding it")
    }

    /// Index of a map among the rows of a line; `None` where it is not wanted.
    fn index(&self, map: NoiseMap) -> Option<usize> {
        self.wanted.iter().position(|&wanted| wanted == map).map(|i| SIGNAL + 1 + i)
    }

    /// The whole image has changed.
    pub(super) fn plane(&self, map: NoiseMap, charge: &ChargePlane) {
        let rows = charge.electrons.chunks(charge.width.max(1)).take(self.rows.len());
        rows.enumerate().for_each(|(y, row)| self.note(map, y, row));
    }

    /// A row has changed.
    #[inline]
    pub(super) fn note<T: Copy + Into<f64>>(&self, map: NoiseMap, y: usize, now: &[T]) {
        if self.is_off() {
            return;
        }
        let index = self.index(map);
        let planes = &mut *self.row(y);
        for (i, &now) in now.iter().enumerate() {
            let now: f64 = now.into();
            if let Some(index) = index {
                planes[index][i] += (now - f64::from(planes[SIGNAL][i])) as f32;
            }
            planes[SIGNAL][i] = now as f32;
        }
    }

    /// Changes the values of a map, by column and row, without a change of the signal.
    fn map(&self, map: NoiseMap, change: impl Fn(usize, usize, &mut f32)) {
        let Some(index) = self.index(map) else { return };
        for y in 0..self.rows.len() {
            self.row(y)[index].iter_mut().enumerate().for_each(|(x, value)| change(x, y, value));
        }
    }

    /// Separates the mean of thermal electrons from their shot noise.
    pub(super) fn split_dark_current(&self, dark_current: impl FnOnce() -> Option<DarkCurrent>) {
        let Some(DarkCurrent { electrons, .. }) = Some(dark_current).filter(|_| !self.is_off()).and_then(|make| make())
        else {
            return;
        };
        let (mean, of_pixel) = (electrons.mean(), |x, y| electrons.of_pixel(x, y));
        self.map(NoiseMap::DarkCurrentE, |_, _, value| *value += mean as f32);
        self.map(NoiseMap::DarkCurrentNonuniformityE, |x, y, value| *value += (of_pixel(x, y) - mean) as f32);
        self.map(NoiseMap::DarkShotNoiseE, |x, y, value| *value -= of_pixel(x, y) as f32);
    }

    /// Takes down the response of every pixel.
    pub(super) fn gains<S: RowStage>(&self, photo_response: impl FnOnce() -> S) {
        let Some(index) = self.index(NoiseMap::PrnuGain) else { return };
        let photo_response = photo_response();
        for y in 0..self.rows.len() {
            let values = &mut self.row(y)[index];
            values.fill(1.0);
            photo_response.apply(&mut Row { y, values });
        }
    }

    /// Marks the pixels of a row whose values are saturated.
    #[inline]
    pub(super) fn mark<T: Copy>(&self, row: &Row<'_, T>, is_saturated: impl Fn(T) -> bool) {
        let Some(index) = self.index(NoiseMap::Saturated) else { return };
        for (mark, value) in self.row(row.y)[index].iter_mut().zip(&*row.values) {
            *mark = if is_saturated(*value) { 1.0 } else { *mark };
        }
    }

    /// Replaces all planes (`None`: the signal), each of which is given with its columns and rows.
    fn reshape(&mut self, change: impl Fn(Option<NoiseMap>, Vec<f32>, [usize; 2]) -> (Vec<f32>, [usize; 2])) {
        let Some(first) = self.rows.first() else { return };
        let size = [first.lock().map_or(0, |row| row[SIGNAL].len()), self.rows.len()];
        let kinds = std::iter::once(None).chain(self.wanted.iter().copied().map(Some));
        let planes = kinds.enumerate().map(|(index, kind)| {
            let values = (0..self.rows.len()).flat_map(|y| self.row(y)[index].clone()).collect();
            change(kind, values, size)
        });
        let planes: Vec<(Vec<f32>, [usize; 2])> = planes.collect();
        let [width, height] = planes[SIGNAL].1;
        let row = |y: usize| planes.iter().map(|(values, _)| values[y * width..][..width].to_vec()).collect();
        self.rows = (0..height).map(|y| Mutex::new(row(y))).collect();
    }

    /// Puts new columns and rows around the maps, `before` of them at the left and the top, which have no contribution
    /// yet.
    pub(super) fn embed(&mut self, before: [usize; 2], charge: &ChargePlane) {
        self.reshape(|_, values, [width, _]| {
            let mut larger = vec![0.0; charge.width * charge.height];
            for (y, row) in values.chunks(width.max(1)).enumerate() {
                larger[(before[1] + y) * charge.width + before[0]..][..width].copy_from_slice(row);
            }
            (larger, [charge.width, charge.height])
        });
    }

    /// Charge is added in bins of pixels.
    pub(super) fn add_charge(&mut self, binning: &Binning, cfa: &Cfa) {
        if binning.method == BinningMethod::Charge && binning.pixels() > 1 {
            self.bin(binning, cfa, |_| 1.0);
        }
    }

    /// Adds digital numbers, or takes their mean, in bins of pixels, with `binned` as the result.
    pub(super) fn add_numbers(&mut self, frame: &Frame<'_>, binned: &[u16], width: usize) {
        let binning = &frame.exposure.region.binning;
        if self.is_off() || binning.method == BinningMethod::Charge || binning.pixels() == 1 {
            return;
        }
        // The black level is that of every number, and of every bin.
        let black = f32::from(frame.black_level_dn());
        self.reshape(|kind, values, size| match kind {
            None => (values.iter().map(|number| number - black).collect(), size),
            Some(_) => (values, size),
        });
        self.bin(binning, &frame.sensor.cfa, |unit| match unit {
            MapUnit::DigitalNumbers => binning.weight(),
            MapUnit::Electrons | MapUnit::None => 1.0,
        });
        for (y, numbers) in binned.chunks(width.max(1)).enumerate() {
            self.row(y)[SIGNAL].iter_mut().for_each(|signal| *signal += black);
            self.note(NoiseMap::RoundingDn, y, numbers);
        }
    }

    /// Sums over bins, times a factor that depends on the unit.
    fn bin(&mut self, binning: &Binning, cfa: &Cfa, factor: impl Fn(MapUnit) -> f64) {
        self.reshape(|kind, values, size| {
            let factor = match kind {
                None => factor(MapUnit::DigitalNumbers),
                Some(NoiseMap::PrnuGain) => 1.0 / binning.pixels() as f64,
                Some(map) => factor(map.unit()),
            };
            // One saturated pixel saturates its bin.
            let is_mask = kind == Some(NoiseMap::Saturated);
            binning.bins(&values, size, cfa, |sum| if is_mask { sum.min(1.0) } else { sum * factor } as f32)
        });
    }

    /// Samples the maps as the image is sampled.
    pub(super) fn sample(&mut self, sampling: &Sampling<'_>, samples: usize) {
        self.reshape(|kind, values, [width, _]| {
            let (mut sampled, size) = sampling.apply(&values, [width, samples]);
            if kind == Some(NoiseMap::Saturated) {
                // A saturated pixel saturates what is sampled of it.
                sampled.iter_mut().for_each(|mark| *mark = mark.ceil());
            }
            (sampled, size)
        });
    }

    /// The charge of a row has become signals in DN.
    #[inline]
    pub(super) fn amplified(&self, row: &Row<'_>) {
        if !self.is_off() {
            self.row(row.y)[SIGNAL].copy_from_slice(row.values);
        }
    }

    /// Records the conversion of a row of signals to digital numbers.
    #[inline]
    pub(super) fn converted(&self, numbers: &Row<'_, u16>, frame: &Frame<'_>) {
        if self.is_off() {
            return;
        }
        let converter = &frame.sensor.converter;
        let (black, max) = (f64::from(frame.black_level_dn()), f64::from(converter.max_dn()));
        let maps = [NoiseMap::ClippingDn, NoiseMap::AdcNonlinearityDn, NoiseMap::QuantisationDn];
        let maps = maps.map(|map| self.index(map));
        let mut planes = self.row(numbers.y);
        for (i, &number) in numbers.values.iter().enumerate() {
            let (level, number) = (f64::from(planes[SIGNAL][i]) + black, f64::from(number));
            let within = level.clamp(0.0, max);
            // With two gains, steps are those of other converters, of which the last one knows nothing.
            let ideal = if converter.dual_gain.is_some() { number } else { (within + 0.5).floor() };
            let values = [within - level, number - ideal, ideal - within];
            for (map, value) in maps.iter().zip(values).filter_map(|(map, value)| Some(((*map)?, value))) {
                planes[map][i] += value as f32;
            }
            planes[SIGNAL][i] = number as f32;
        }
        drop(planes);
        self.mark(numbers, |number| number >= converter.max_dn());
    }

    /// Records the multiplication of a row of digital numbers by a digital gain.
    pub(super) fn multiplied(&self, gain: &DigitalGain, numbers: &Row<'_, u16>) {
        if self.is_off() {
            return;
        }
        {
            let planes = &mut *self.row(numbers.y);
            planes[SIGNAL].iter_mut().for_each(|number| *number = gain.level((*number).into()) as f32);
            let maps = self.wanted.iter().zip(&mut planes[SIGNAL + 1..]);
            for (_, values) in maps.filter(|(map, _)| map.unit() == MapUnit::DigitalNumbers) {
                values.iter_mut().for_each(|value| *value *= gain.factor() as f32);
            }
        }
        self.note(NoiseMap::RoundingDn, numbers.y, numbers.values);
    }

    /// The maps, of an area of the image whose pixels have these channels.
    pub(super) fn finish(mut self, area: PixelArea, channels: &[String]) -> Result<Planes, Invalid> {
        let samples = channels.len();
        let mut planes = Vec::new();
        for map in self.wanted.clone() {
            let index = self.index(map).unwrap_or(SIGNAL);
            for (sample, channel) in channels.iter().enumerate() {
                let rows = self.rows.iter_mut().skip(area.y).take(area.height);
                let values = rows.flat_map(|row| {
                    let values = row.get_mut().map_or(&[][..], |row| &row[index]);
                    values.iter().skip(sample).step_by(samples).skip(area.x).take(area.width)
                });
                let name = if samples == 1 { map.name().to_owned() } else { format!("{}.{channel}", map.name()) };
                planes.push(Channel { name, data: values.copied().collect() });
            }
        }
        Planes::new(area.width, area.height, planes)
    }
}
