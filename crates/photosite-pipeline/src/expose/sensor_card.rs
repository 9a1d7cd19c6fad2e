//! A graphics card that exposes sensors and develops their images. What it does not have, the processor does.

use std::sync::Arc;
#[cfg(feature = "gpu")]
use std::sync::{Mutex, PoisonError};

use photosite_core::Invalid;
use photosite_core::image::Estimate;
use photosite_develop::{DevelopSettings, EncodedImage};
use photosite_raw::RawImage;
use photosite_sensor::{Exposure, NoiseKey, NoiseMap, SensorModel, Stages};

/// Graphics card for sensors; without the feature `gpu` there is none.
pub struct SensorCard {
    #[cfg(feature = "gpu")]
    card: Arc<photosite_gpu::Card>,
    /// Light of the last exposure, which stays on the card for those that follow.
    #[cfg(feature = "gpu")]
    held: Mutex<Option<(Arc<Estimate>, photosite_gpu::HeldLight)>>,
    #[cfg(not(feature = "gpu"))]
    none: std::convert::Infallible,
}

#[cfg(not(feature = "gpu"))]
impl SensorCard {
    pub(crate) fn name(&self) -> String {
        match self.none {}
    }

    pub(crate) fn expose(
        &self,
        _: (&Arc<Estimate>, &[NoiseMap]),
        _: &SensorModel,
        _: &Exposure,
        _: Stages,
        _: NoiseKey,
    ) -> Result<RawImage, Invalid> {
        match self.none {}
    }

    pub(crate) fn develop(&self, _: &RawImage, _: &DevelopSettings) -> Result<EncodedImage, Invalid> {
        match self.none {}
    }
}

#[cfg(feature = "gpu")]
impl SensorCard {
    /// Card for exposures.
    pub(crate) fn new(card: Arc<photosite_gpu::Card>) -> Self {
        Self { card, held: Mutex::new(None) }
    }

    /// Name of the card with its driver.
    pub(crate) fn name(&self) -> String {
        self.card.adapter().to_string()
    }

    /// Exposes a sensor, without noise maps.
    ///
    /// # Errors
    ///
    /// The first fact of sensor or exposure that the card does not have, by its key; light that it has no room for; words
    /// of its driver. The processor may expose then.
    pub(crate) fn expose(
        &self,
        (light, maps): (&Arc<Estimate>, &[NoiseMap]),
        sensor: &SensorModel,
        exposure: &Exposure,
        stages: Stages,
        key: NoiseKey,
    ) -> Result<RawImage, Invalid> {
        use photosite_sensor::packed::{PackedExposure, PackedLight};
        if !maps.is_empty() {
            let message = "noise maps cannot be drawn on a graphics card yet";
            return Err(Invalid::new("output.noise", message));
        }
        let image = [light.mean.width(), light.mean.height()];
        let packed = PackedExposure::new(image, sensor, exposure, stages, key)?;
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        let (of, mut on_card) = match held.take().filter(|(_, on_card)| on_card.suits(packed.layout()).is_ok()) {
            Some(held) if Arc::ptr_eq(&held.0, light) => held,
            Some((_, mut on_card)) => {
                on_card.replace(&PackedLight::new(&light.mean, sensor)?)?;
                (Arc::clone(light), on_card)
            }
            None => (Arc::clone(light), self.card.hold_light(&PackedLight::new(&light.mean, sensor)?)?),
        };
        let raw = on_card.expose(&packed)?;
        *held = Some((of, on_card));
        Ok(raw)
    }

    /// Develops a raw image.
    ///
    /// # Errors
    ///
    /// The first setting that the card does not have, by its key; an image that it has no room for; words of its driver.
    /// The processor may develop then.
    pub(crate) fn develop(&self, raw: &RawImage, settings: &DevelopSettings) -> Result<EncodedImage, Invalid> {
        let packed = photosite_develop::packed::PackedDevelopment::new(raw, settings)?;
        self.card.develop(raw, &packed)
    }
}
