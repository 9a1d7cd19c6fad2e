//! Table of all spectra of a scene in contiguous memory, indexed by handles.

use super::{SampledSpectrum, Spectrum, TABLE_LEN, Wavelengths};

/// Handle of a spectrum in a [`SpectrumTable`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpectrumId(u32);

/// Spectra laid end to end.
#[derive(Clone, Debug, Default)]
pub struct SpectrumTable {
    /// Entries of all spectra: each value with its difference to the next one, side by side, since they are looked up
    /// together.
    entries: Vec<[f32; 2]>,
}

impl SpectrumId {
    /// Number of the spectrum in its table.
    pub fn number(self) -> u32 {
        self.0
    }
}

impl SpectrumTable {
    /// Entries of all spectra, one after the other: each value with its rise to the next.
    pub fn entries(&self) -> &[[f32; 2]] {
        &self.entries
    }

    /// Adds a spectrum. Equal spectra share a handle with the one added last, which is the common case of a file that
    /// repeats a material.
    pub fn add(&mut self, spectrum: &Spectrum) -> SpectrumId {
        let values = spectrum.values();
        let last = &self.entries[self.entries.len().saturating_sub(TABLE_LEN)..];
        if last.is_empty() || last.iter().zip(values).any(|([value, _], new)| value != new) {
            let next = values[1..].iter().chain(values.last());
            self.entries.extend(values.iter().zip(next).map(|(&value, &next)| [value, next - value]));
        }
        SpectrumId((self.entries.len() / TABLE_LEN - 1) as u32)
    }

    /// Values at the wavelengths of a path.
    #[inline]
    pub fn sample(&self, id: SpectrumId, wavelengths: &Wavelengths) -> SampledSpectrum {
        let start = id.0 as usize * TABLE_LEN;
        SampledSpectrum::from_lanes(|lane| {
            let (entry, part) = wavelengths.place_in_table(lane);
            let [value, rise] = self.entries[start + entry];
            value + rise * part
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn handles_find_their_spectra() {
        let mut table = SpectrumTable::default();
        let (a, b) = (Spectrum::constant(0.25), Spectrum::from_fn(|l| l));
        let ids = [table.add(&a), table.add(&b), table.add(&b)];
        assert_eq!(ids[1], ids[2]);
        let w = Wavelengths::new([400.0, 500.5, 1100.0, 300.0], [1.0; 4]);
        assert_eq!(table.sample(ids[0], &w), a.sample(&w));
        assert_eq!(table.sample(ids[1], &w).to_array(), [400.0, 500.5, 1100.0, 300.0]);
    }
}
