//! Charge and digital numbers on their way through the stages, each with the record of what has changed it: only a
//! stage with a [noise map](super::NoiseMaps) can change them.

use std::ops::Deref;

use super::noise_maps::Recorder;
use crate::Binning;
use crate::signal::charge_plane::{ChargePlane, Row, RowStage, for_each_row};
use crate::signal::effects::NoiseMap;
use crate::stages::amplifiers::Gain;
use crate::stages::digital_gain::DigitalGain;
use crate::stages::frame::Frame;
use crate::stages::frame_grabber::Sampling;
use photosite_raw::Cfa;

/// Charge of all pixels, which can be read by all and changed under the name of a map.
pub(super) struct Charge {
    plane: ChargePlane,
    pub(super) record: Recorder,
}

impl Deref for Charge {
    type Target = ChargePlane;

    fn deref(&self) -> &ChargePlane {
        &self.plane
    }
}

impl Charge {
    /// Mean photo-electrons, and the maps that are kept.
    pub(super) fn new(photo_electrons: ChargePlane, maps: &[NoiseMap]) -> Self {
        let record = Recorder::start(maps, &photo_electrons);
        Self { plane: photo_electrons, record }
    }

    /// Lets a stage change the whole image.
    pub(super) fn change<R>(&mut self, map: NoiseMap, stage: impl FnOnce(&mut ChargePlane) -> R) -> R {
        let result = stage(&mut self.plane);
        self.record.plane(map, &self.plane);
        result
    }

    /// Lets a stage put columns and rows around the image, `before` of them at the left and the top.
    pub(super) fn embed(
        mut self,
        before: [usize; 2],
        map: NoiseMap,
        stage: impl FnOnce(ChargePlane) -> ChargePlane,
    ) -> Self {
        self.plane = stage(self.plane);
        self.record.embed(before, &self.plane);
        self.record.plane(map, &self.plane);
        self
    }

    /// Lets stages change all rows, in any order.
    pub(super) fn for_each_row(&mut self, change: impl Fn(&mut RecordedRow<'_>) + Sync) {
        let record = &self.record;
        self.plane.for_each_row(|Row { y, values }| change(&mut RecordedRow { row: Row { y: *y, values }, record }));
    }

    /// Adds the charge of bins.
    pub(super) fn add(mut self, binning: &Binning, cfa: &Cfa) -> Self {
        self.plane = binning.add_charge(self.plane, cfa);
        self.record.add_charge(binning, cfa);
        self
    }

    /// Samples the amplified image at other places than those of the pixels.
    pub(super) fn sample(mut self, sampling: &Sampling<'_>) -> Self {
        let ChargePlane { width, samples, .. } = self.plane;
        self.record.sample(sampling, samples);
        let (electrons, [width, height]) = sampling.apply(&self.plane.electrons, [width, samples]);
        self.plane = ChargePlane { width, height, samples, electrons };
        self
    }

    /// Reads all rows out, in any order, into the digital numbers of their pixels.
    pub(super) fn read_out(
        self,
        read: impl Fn(&mut RecordedRow<'_>, &mut RecordedRow<'_, u16>) + Sync,
    ) -> DigitalNumbers {
        let Self { plane, record } = self;
        let size = [plane.width, plane.height];
        let data = plane.read_out(|charge, numbers| {
            let mut charge = RecordedRow { row: Row { y: charge.y, values: charge.values }, record: &record };
            read(&mut charge, &mut RecordedRow { row: Row { y: numbers.y, values: numbers.values }, record: &record });
        });
        DigitalNumbers { data, size, record }
    }
}

/// Digital numbers of all pixels, with their noise maps.
pub(super) struct DigitalNumbers {
    pub(super) data: Vec<u16>,
    /// Values in a row, and rows.
    pub(super) size: [usize; 2],
    pub(super) record: Recorder,
}

impl DigitalNumbers {
    /// Adds the digital numbers of bins, or takes their mean.
    pub(super) fn add(mut self, frame: &Frame<'_>) -> Self {
        (self.data, self.size) = frame.exposure.region.binning.add_numbers(
            self.data,
            self.size,
            &frame.sensor.cfa,
            [frame.black_level_dn(), frame.sensor.converter.max_dn()],
        );
        self.record.add_numbers(frame, &self.data, self.size[0]);
        self
    }

    /// Lets stages change all rows, in any order.
    pub(super) fn for_each_row(&mut self, change: impl Fn(&mut RecordedRow<'_, u16>) + Sync) {
        let record = &self.record;
        for_each_row(&mut self.data, self.size[0], |Row { y, values }| {
            change(&mut RecordedRow { row: Row { y: *y, values }, record });
        });
    }
}

/// One row of charge, signals or digital numbers, with its noise maps.
pub(super) struct RecordedRow<'a, T = f32> {
    row: Row<'a, T>,
    record: &'a Recorder,
}

impl<'a, T> Deref for RecordedRow<'a, T> {
    type Target = Row<'a, T>;

    fn deref(&self) -> &Row<'a, T> {
        &self.row
    }
}

impl<T: Copy + Into<f64>> RecordedRow<'_, T> {
    /// Lets a stage change the row.
    #[inline]
    pub(super) fn apply<S: RowStage<T>>(&mut self, stage: &S) {
        stage.apply(&mut self.row);
        self.record.note(S::MAP, self.row.y, self.row.values);
    }

    /// Marks values that are saturated.
    #[inline]
    pub(super) fn mark(&self, is_saturated: impl Fn(T) -> bool) {
        self.record.mark(&self.row, is_saturated);
    }
}

impl RecordedRow<'_> {
    /// Lets something other than a [`RowStage`] change the row.
    #[inline]
    pub(super) fn change(&mut self, map: NoiseMap, stage: impl FnOnce(&mut Row<'_>)) {
        stage(&mut self.row);
        self.record.note(map, self.row.y, self.row.values);
    }

    /// Lets the gain make signals in DN of charge.
    #[inline]
    pub(super) fn amplify(&mut self, gain: &Gain) {
        gain.apply(&mut self.row);
        self.record.amplified(&self.row);
    }
}

impl RecordedRow<'_, u16> {
    /// Lets a converter turn signals into digital numbers.
    #[inline]
    pub(super) fn convert(&mut self, frame: &Frame<'_>, convert: impl FnOnce(&mut Row<'_, u16>)) {
        convert(&mut self.row);
        self.record.converted(&self.row, frame);
    }

    /// Multiplies the digital numbers by a digital gain.
    pub(super) fn multiply(&mut self, digital_gain: Option<&DigitalGain>) {
        let Some(gain) = digital_gain else { return };
        gain.apply(&mut self.row);
        self.record.multiplied(gain, &self.row);
    }
}
