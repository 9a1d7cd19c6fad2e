//! CSV files of spectra.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::spectrum::{Outside, SpectralTable};

fuzz_target!(|text: &str| {
    for outside in [Outside::Zero, Outside::Hold] {
        if let Ok(table) = SpectralTable::parse(text, outside) {
            for name in table.names() {
                let _ = table.column(name);
            }
        }
    }
});
