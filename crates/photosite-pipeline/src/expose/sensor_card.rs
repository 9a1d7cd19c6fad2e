//! A graphics card that exposes sensors and develops their images. What it does not have, the processor does.

use std::sync::Arc;
#[cfg(feature = "gpu")]
use std::sync::{Mutex, PoisonError};

use photosite_core::Invalid;
use photosite_core::image::Estimate;
use photosite_develop::{DevelopSettings, EncodedImage};
use photosite_raw::RawImage;
use photosite_sensor::{Exposure, NoiseKey, SensorModel, Stages};

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

    pub(crate) fn lacks(&self, _: &SensorModel, _: &Exposure, _: Stages) -> Option<Invalid> {
        match self.none {}
    }

    pub(crate) fn expose(
        &self,
        _: &Arc<Estimate>,
        _: &SensorModel,
        _: &Exposure,
        _: Stages,
        _: NoiseKey,
    ) -> Result<RawImage, Invalid> {
        match self.none {}
    }

    pub(crate) fn develop(&self, _: &RawImage, _: &DevelopSettings) -> Result<Result<EncodedImage, Invalid>, Invalid> {
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

    /// First fact of sensor or exposure that the card does not have, by its key.
    pub(crate) fn lacks(&self, sensor: &SensorModel, exposure: &Exposure, stages: Stages) -> Option<Invalid> {
        photosite_sensor::packed::refusal(sensor, exposure, stages)
    }

    /// Exposes a sensor that the card does not [lack](Self::lacks) anything of.
    ///
    /// # Errors
    ///
    /// What the processor refuses, too; light that the card has no room for; words of its driver.
    pub(crate) fn expose(
        &self,
        light: &Arc<Estimate>,
        sensor: &SensorModel,
        exposure: &Exposure,
        stages: Stages,
        key: NoiseKey,
    ) -> Result<RawImage, Invalid> {
        use photosite_sensor::packed::{PackedExposure, PackedLight};
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

    /// Develops a raw image; within, the first setting that the card does not have, by its key.
    ///
    /// # Errors
    ///
    /// Images that the card has no room for, and words of its driver.
    pub(crate) fn develop(
        &self,
        raw: &RawImage,
        settings: &DevelopSettings,
    ) -> Result<Result<EncodedImage, Invalid>, Invalid> {
        match photosite_develop::packed::PackedDevelopment::new(raw, settings) {
            Ok(packed) => self.card.develop(raw, &packed).map(Ok),
            Err(lacks) => Ok(Err(lacks)),
        }
    }
}
