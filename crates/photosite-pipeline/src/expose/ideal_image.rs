//! The ideal image of a render: the same light, seen by an observer with the eyes of the CIE.

use super::chain::{Chain, SensorSettings};
use photosite_core::Result;
use photosite_core::image::{Channel, Planes};
use photosite_core::spectrum::Spectrum;
use photosite_develop::ideal;
use photosite_sensor::Exposure;

impl Chain<'_> {
    /// Linear planes of the colour space that is developed to, from the planes of the film that are summed for it. `light`
    /// is that of the scene.
    pub(crate) fn ideal(&self, seen: Planes, light: &Spectrum, exposure: &Exposure) -> Result<Planes> {
        let SensorSettings { sensor, develop, source, .. } = self.settings;
        let named = |channel: Channel| Channel { name: channel.name.replace("ideal.", ""), ..channel };
        let (width, height) = (seen.width(), seen.height());
        let xyz = Planes::new(width, height, seen.into_channels().into_iter().map(named).collect());
        let light = light.product(&self.optics.transmittance);
        let saturation = sensor.pixel_saturation(exposure).0 / exposure.time.0;
        let image = xyz
            .and_then(|xyz| ideal(xyz, &light, &sensor.responses(), saturation, develop))
            .map_err(|invalid| source.error(invalid.within("output")))?;
        Ok(match self.ideal_resampling() {
            Some(resampling) => resampling.apply(image),
            None => image,
        })
    }
}
