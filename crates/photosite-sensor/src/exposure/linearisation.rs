//! Linearisation: the way back from the digital numbers that leave a sensor to those in proportion to light.

use crate::{Exposure, SensorModel};

/// Black level of linear values, DN, of sensors that bend their signal, so that noise below it is kept.
const LINEAR_BLACK_DN: u16 = 1024;

/// Linearisation table, with the levels of its linear values.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearisation {
    /// Digital numbers in proportion to light, DN, one for each number that leaves the sensor.
    pub table: Vec<u16>,
    /// The linear number of no light, DN.
    pub black_level_dn: u16,
    /// The linear number of saturation, DN.
    pub white_level_dn: u16,
}

impl SensorModel {
    /// The inverse of all that bends the response on purpose; `None` for sensors that are linear as they are.
    ///
    /// Companded numbers become those of the converter again. Those of logarithmic pixels and behind a video curve become
    /// 1024 for no light to 65 535 for saturation; where they span more than 16 bits, the table is coarser than the
    /// sensor in the dark.
    pub fn linearisation(&self, exposure: &Exposure) -> Option<Linearisation> {
        let converter = &self.converter;
        let expanded: Vec<f64> = match &converter.companding {
            Some(companding) => companding.inverse_table(converter.max_dn()),
            None if self.is_bent() => (0..=converter.max_dn()).map(f64::from).collect(),
            None => return None,
        };
        let (black, white) = (converter.black_level_dn(exposure.gain), self.nonlinear_white_level_dn(exposure));
        let linear = |dn: f64| -> u16 {
            if !self.is_bent() {
                return dn.round() as u16;
            }
            let charge = |dn: f64| {
                let signal = self.signal_of_number(dn - f64::from(black), exposure);
                self.pixel_charge(self.charge_for(signal), exposure.time)
            };
            let part = charge(dn) / charge(white.into());
            let first = f64::from(LINEAR_BLACK_DN);
            (first + part * (f64::from(u16::MAX) - first)).round().clamp(0.0, u16::MAX.into()) as u16
        };
        let table: Vec<u16> = expanded.iter().map(|&dn| linear(dn)).collect();
        // Saturation is where its own number comes back to, which companding may have rounded downwards.
        let code = converter.companding.as_ref().map_or(white, |companding| companding.code(white, converter.max_dn()));
        let black_level_dn = if self.is_bent() { LINEAR_BLACK_DN } else { black };
        let white_level_dn = table[usize::from(code)].max(black_level_dn + 1);
        Some(Linearisation { table, black_level_dn, white_level_dn })
    }

    /// Whether pixels or amplifiers bend the signal on purpose before the converter.
    fn is_bent(&self) -> bool {
        self.logarithmic.is_some() || self.video.curve.is_some()
    }

    /// Step between neighbouring numbers that leave the sensor, in DN of the converter, at a number of the converter.
    pub(crate) fn step_dn(&self, dn: u16) -> f64 {
        let converter = &self.converter;
        converter.companding.as_ref().map_or(1.0, |c| c.step_dn(dn.into(), converter.max_dn().into()))
    }
}
