//! `[charge.image_lag]`: charge that stays in the pixel when it is read out, as a sensor file states it, and checked.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;
use photosite_core::units::Electrons;

use super::checks::not_negative;
use super::kind::SensorKind;
use super::shutter::Shutter;

/// `[charge.image_lag]`: charge that stays in the pixel when it is read out and comes with later frames.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields, default)]
pub struct ImageLagDescription {
    /// Residual signal of the first dark frame after steady light, % of the signal, as data sheets state it.
    #[schemars(transform = within(0.0..100.0))]
    pub percent: f64,
    /// Residual signal of that frame besides, whatever the signal, e⁻.
    #[schemars(transform = within(0.0..))]
    pub electrons: f64,
    /// Residual signal of each dark frame over that of the one before it. Left out: percent/100, as where a part of the
    /// charge is not transferred.
    #[schemars(transform = within(0.0..1.0))]
    pub decay: Option<f64>,
}

/// Charge that stays in the pixel when it is read out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageLag {
    /// ℓ: residual signal of the first dark frame after steady light over that light's signal, 0 to below 1.
    pub fraction: f64,
    /// L: residual signal of that frame besides.
    pub electrons: Electrons,
    /// d: residual signal of each dark frame over that of the one before it, 0 to below 1.
    pub decay: f64,
}

impl ImageLag {
    /// `None` where nothing stays. Keys of errors are those of the sensor file.
    pub(super) fn new(
        lag: &ImageLagDescription,
        kind: SensorKind,
        is_logarithmic: bool,
        shutter: &Shutter,
    ) -> Result<Option<Self>, Invalid> {
        const KEY: &str = "charge.image_lag";
        let below_one = |key: &str, value: f64, most: f64| {
            if (0.0..most).contains(&value) {
                return Ok(value / most);
            }
            Err(Invalid::new(format!("{KEY}.{key}"), format!("must be at least 0 and below {most}, got {value}"))
                .help("write 0 to leave this out"))
        };
        let fraction = below_one("percent", lag.percent, 100.0)?;
        let electrons = Electrons(not_negative(&format!("{KEY}.electrons"), lag.electrons)?);
        let decay = lag.decay.map_or(Ok(fraction), |decay| below_one("decay", decay, 1.0))?;
        if fraction == 0.0 && electrons.0 == 0.0 {
            return Ok(None);
        }
        let clash = match kind {
            SensorKind::Cmos | SensorKind::Ccd => None,
            SensorKind::Spad => Some("kind = \"spad\", whose pixels keep no charge"),
        };
        let clash = clash
            .or(is_logarithmic.then_some("logarithmic pixels, which are never emptied"))
            .or(shutter.scans().then_some("a scanning sensor, whose lines would leave charge to each other"));
        match clash {
            Some(clash) => {
                Err(Invalid::new(KEY, format!("cannot be combined with {clash}")).help("remove charge.image_lag"))
            }
            None => Ok(Some(Self { fraction, electrons, decay })),
        }
    }

    /// Frames under steady light until what a pixel keeps is within a thousandth of what it will be.
    pub fn settling_frames(&self) -> u32 {
        if self.decay < 1e-3 { 1 } else { (1e-3_f64.ln() / self.decay.ln()).ceil() as u32 }
    }
}
