//! The technology of a sensor's pixels, with the figures that only it has.

use photosite_core::Invalid;

use super::ccd::Ccd;
use super::description::SensorDescription;
use super::kind::SensorKind;
use super::spad::Spad;

/// Technology of the pixels.
#[derive(Clone, Debug, PartialEq)]
pub enum Architecture {
    /// Charge becomes a voltage inside each pixel.
    Cmos,
    /// Charge is moved to one amplifier.
    Ccd(Ccd),
    /// Single photons are counted in each pixel.
    Spad(Spad),
}

impl Architecture {
    pub(super) fn new(d: &SensorDescription) -> Result<Self, Invalid> {
        let surplus = |table: &str, kind: &str| {
            Err(Invalid::new(table, format!("belongs to another kind of sensor than kind = {kind:?}"))
                .help(format!("leave it out, or write kind = {table:?}; for a preset, write without = [{table:?}]")))
        };
        match (d.kind, &d.ccd, &d.spad) {
            (SensorKind::Cmos | SensorKind::Spad, Some(_), _) => surplus("ccd", d.kind.name()),
            (SensorKind::Cmos | SensorKind::Ccd, _, Some(_)) => surplus("spad", d.kind.name()),
            (SensorKind::Cmos, None, None) => Ok(Self::Cmos),
            (SensorKind::Ccd, ccd, None) => {
                Ccd::new(&ccd.clone().unwrap_or_default()).map(Self::Ccd).map_err(|e| e.within("ccd"))
            }
            (SensorKind::Spad, None, Some(spad)) => Spad::new(spad).map(Self::Spad).map_err(|e| e.within("spad")),
            (SensorKind::Spad, None, None) => Err(Invalid::new("spad", "missing; kind = \"spad\" needs it")
                .help("for example spad = { counting = \"one-bit\", one_bit_frames = 255 }")),
        }
    }

    /// Name of the architecture in sensor files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Cmos => SensorKind::Cmos,
            Self::Ccd(_) => SensorKind::Ccd,
            Self::Spad(_) => SensorKind::Spad,
        }
        .name()
    }

    /// The figures of a CCD, if it is one.
    pub fn ccd(&self) -> Option<&Ccd> {
        match self {
            Self::Ccd(ccd) => Some(ccd),
            Self::Cmos | Self::Spad(_) => None,
        }
    }

    /// The figures of a single-photon detector, if it is one.
    pub fn spad(&self) -> Option<&Spad> {
        match self {
            Self::Spad(spad) => Some(spad),
            Self::Cmos | Self::Ccd(_) => None,
        }
    }
}
