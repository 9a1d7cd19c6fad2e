//! Images of even light: the same number of photons on every pixel, exactly.

use photosite_core::Invalid;
use photosite_core::image::{Channel, Planes};
use photosite_core::units::Seconds;
use photosite_raw::{BlackLevel, Cfa, RawImage, RawMetadata};
use photosite_sensor::{NoiseKey, SensorModel, Stages, expose_after};

use super::efficiency::{first_place, freed_per_photon};
use super::plan::OperatingPoint;

/// Sensor in even light, of which the pixels of one channel are looked at.
#[derive(Clone, Debug)]
pub struct FlatField<'a> {
    sensor: &'a SensorModel,
    point: OperatingPoint,
    /// Electrons per photon that are freed in every channel.
    efficiencies: Vec<f64>,
    /// Columns and rows of the plane of one channel.
    size: [usize; 2],
    /// First place of the channel in the tile of the colour filter array.
    place: [usize; 2],
    /// Columns and rows of tiles around the images that are exposed, too: pixels at an edge lack neighbours whose
    /// crosstalk those of real sensors have.
    margin: [usize; 2],
}

impl<'a> FlatField<'a> {
    /// `size`: columns and rows of the images, which show one pixel of every tile of the colour filter array, of
    /// channel `point.channel`: programs that evaluate them know of no mosaics.
    pub fn new(sensor: &'a SensorModel, point: &OperatingPoint, size: [usize; 2]) -> Self {
        let (reach, tile) = (sensor.crosstalk_reach(), pixels_of_tile(&sensor.cfa));
        Self {
            margin: [0, 1].map(|axis| reach[axis].div_ceil(tile[axis])),
            sensor,
            point: *point,
            efficiencies: freed_per_photon(sensor, point.wavelength_nm),
            size,
            place: first_place(&sensor.cfa, point.channel),
        }
    }

    /// Largest images that a sensor can give of one channel: a pixel for each whole tile.
    pub fn largest_size(sensor: &SensorModel) -> [usize; 2] {
        let [columns, rows] = pixels_of_tile(&sensor.cfa);
        [sensor.resolution[0] / columns, sensor.resolution[1] / rows]
    }

    /// Images of `photons` on every pixel, one for each frame number, one after the other under steady light.
    pub fn images(
        &self,
        photons: f64,
        time: Seconds,
        seed: u64,
        frames: impl Iterator<Item = u64>,
    ) -> impl Iterator<Item = Result<RawImage, Invalid>> {
        let [columns, rows] = pixels_of_tile(&self.sensor.cfa);
        let [width, height] =
            [(self.size[0] + 2 * self.margin[0]) * columns, (self.size[1] + 2 * self.margin[1]) * rows];
        let electrons = |(name, efficiency): (&String, &f64)| Channel {
            name: name.clone(),
            data: vec![(photons * efficiency) as f32; width * height],
        };
        let channels = self.sensor.cfa.channels().iter().zip(&self.efficiencies).map(electrons).collect();
        let planes = Planes::new(width, height, channels);
        let exposure = self.point.exposure(time);
        let mut left = None;
        let mut next = move |frame| -> Result<RawImage, Invalid> {
            let planes = planes.as_ref().map_err(Clone::clone)?;
            let key = NoiseKey { seed, frame };
            let exposed = expose_after(planes, self.sensor, &exposure, Stages::ALL, key, &[], left.as_ref())?;
            left = exposed.left;
            Ok(exposed.raw)
        };
        // The numbers of these frames are those of no image.
        let settling = self.sensor.image_lag.map_or(0, |lag| u64::from(lag.settling_frames()));
        let mut before = (0..settling).map(|i| u64::MAX - i).collect::<Vec<_>>();
        frames.map(move |frame| {
            before.drain(..).try_for_each(|frame| next(frame).map(drop))?;
            Ok(self.plane(&next(frame)?))
        })
    }

    /// Image of the pixels of the channel.
    fn plane(&self, raw: &RawImage) -> RawImage {
        let raw = raw.cropped();
        let (columns, rows) = raw.cfa.tile_size();
        let [first, top] = [self.place[0] + self.margin[0] * columns, self.place[1] + self.margin[1] * rows];
        let [width, height] = self.size;
        let lines = raw.data.chunks_exact(raw.row_length()).skip(top).step_by(rows).take(height);
        let data = lines.flat_map(|line| line[first..].iter().step_by(columns).take(width).copied()).collect();
        let noise_profile = raw.metadata.noise_profile.get(self.point.channel).copied().into_iter().collect();
        RawImage {
            width: self.size[0],
            height: self.size[1],
            data,
            cfa: Cfa::mono(),
            black_level_dn: BlackLevel::uniform(raw.black_level_dn.at(self.place[0], self.place[1])),
            metadata: RawMetadata { noise_profile, ..raw.metadata },
            ..raw
        }
    }
}

/// Columns and rows of pixels in the tile of an array: a tile of all channels at every pixel is one pixel.
fn pixels_of_tile(cfa: &Cfa) -> [usize; 2] {
    let (columns, rows) = cfa.tile_size();
    [columns / cfa.samples_per_pixel(), rows]
}
