//! Grid of the pixels that a sensor delivers, on those of the sensor.

use glam::DVec2;
use photosite_core::image_grid::ImageGrid;
use photosite_raw::PixelArea;

use super::{BinningMethod, RegionOfInterest};
use crate::{SensorModel, Stage, Stages};

impl SensorModel {
    /// Pixels of a raw image on those of the sensor: a region, bins, samples of a frame grabber. A video line shows
    /// things later along the row.
    pub fn read_out_grid(&self, region: &RegionOfInterest, stages: Stages) -> ImageGrid {
        let [width, height] = self.resolution;
        let area = region.pixels.unwrap_or(PixelArea { x: 0, y: 0, width, height });
        let (size, factor) = match &self.frame_grabber {
            Some(grabber) => (grabber.size, grabber.pixels_per_sample(self.resolution)),
            None => {
                let bins = region.binning.whole_bins([area.width, area.height], &self.cfa);
                (bins, region.binning.factor.map(|n| n as f64))
            }
        };
        // The line carries pixels, or the charge of bins.
        let on_line = match region.binning.method {
            BinningMethod::Charge if self.frame_grabber.is_none() => factor[0],
            BinningMethod::Charge | BinningMethod::Sum | BinningMethod::Mean => 1.0,
        };
        let low_pass = self.video.low_pass.filter(|_| stages.has(Stage::VideoBandwidth));
        let delay = low_pass.map_or(0.0, |low_pass| low_pass.delay_px() * on_line);
        ImageGrid {
            resolution: size.map(|n| n as u32),
            first: DVec2::new(area.x as f64 - delay, area.y as f64),
            per_pixel: DVec2::from_array(factor),
            is_staggered: self.cells.is_staggered(),
        }
    }
}
