//! CSV files of spectra.

use photosite::spectrum::{Outside, SpectralTable};

pub(crate) fn target(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    for outside in [Outside::Zero, Outside::Hold] {
        if let Ok(table) = SpectralTable::parse(text, outside) {
            for name in table.names() {
                let _ = table.column(name);
            }
        }
    }
}
