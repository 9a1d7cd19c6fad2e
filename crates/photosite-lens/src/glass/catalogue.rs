//! Glass catalogues: 1,611 glasses of six makers, from the database of refractiveindex.info (CC0), which are part of
//! the binary.

use std::sync::OnceLock;

use photosite_core::spectrum::Dispersion;

use crate::prescription::Glass;

/// Table with lines of catalogue, name, n_d, ν_d, fitted wavelengths, and formula.
const TABLE: &str = include_str!("../../assets/lenses/glasses.csv");

/// Makers of the catalogues. Where two glasses fit equally well, the earlier maker's is taken.
pub const CATALOGUES: [&str; 6] = ["schott", "ohara", "hoya", "hikari", "sumita", "cdgm"];

/// A glass of a catalogue.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Maker: `schott`.
    pub catalogue: &'static str,
    /// Maker's name of the glass: `N-BK7`.
    pub name: &'static str,
    /// Index at the d line, 587.56 nm, by the formula.
    pub nd: f64,
    /// Abbe number (n_d − 1)/(n_F − n_C), by the formula.
    pub vd: f64,
    /// Wavelengths that the maker fitted the formula to, nm.
    pub range_nm: [f64; 2],
    /// The formula of the index.
    pub dispersion: Dispersion,
}

impl Entry {
    /// Glass as in prescriptions. `how` explains a match by more than the name.
    pub fn to_glass(&self, how: &str) -> Glass {
        let Self { catalogue, name, range_nm, dispersion, .. } = self;
        let source = format!("refractiveindex.info (CC0): {catalogue}/{name}{how}");
        Glass { name: (*name).to_owned(), source, dispersion: dispersion.clone(), range_nm: Some(*range_nm) }
    }
}

/// All glasses, in the order of [`CATALOGUES`].
pub fn entries() -> &'static [Entry] {
    static ENTRIES: OnceLock<Vec<Entry>> = OnceLock::new();
    ENTRIES.get_or_init(|| {
        let mut entries: Vec<Entry> = TABLE
            .lines()
            .filter(|line| !line.starts_with('#'))
            .skip(1)
            .map(|line| entry(line).expect("the table is part of the program and tested"))
            .collect();
        // The sort is stable: within a catalogue the glasses stay in their order.
        entries.sort_by_key(|entry| CATALOGUES.iter().position(|catalogue| *catalogue == entry.catalogue));
        entries
    })
}

/// Entry of a line of the table.
fn entry(line: &'static str) -> Option<Entry> {
    let mut cells = line.split(',');
    let (catalogue, name) = (cells.next()?, cells.next()?);
    let mut number = || cells.next()?.parse().ok();
    let (nd, vd, range_nm) = (number()?, number()?, [number()?, number()?]);
    let kind = cells.next()?;
    let numbers = cells.map(|cell| cell.parse().ok()).collect::<Option<Vec<f64>>>()?;
    let pairs = || numbers.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
    let dispersion = match kind {
        "sellmeier" => {
            Dispersion::Sellmeier { b: pairs().map(|[b, _]| b).collect(), c_um2: pairs().map(|[_, c]| c).collect() }
        }
        "polynomial" => Dispersion::Polynomial { terms: pairs().collect() },
        _ => return None,
    };
    (numbers.len() % 2 == 0).then_some(Entry { catalogue, name, nd, vd, range_nm, dispersion })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use photosite_core::spectrum::dispersion::lines;

    use super::*;

    #[test]
    fn every_formula_gives_the_index_and_the_abbe_number_of_its_line() {
        assert_eq!(entries().len(), 1611);
        let mut sizes = BTreeMap::new();
        for entry in entries() {
            *sizes.entry(entry.catalogue).or_insert(0) += 1;
            let name = format!("{}/{}", entry.catalogue, entry.name);
            // Half a unit of the last digit that the table gives.
            let (n, abbe) = (entry.dispersion.index(lines::D), entry.dispersion.abbe_number());
            assert!((n - entry.nd).abs() <= 0.51e-6, "{name}: {n} instead of {}", entry.nd);
            assert!((abbe - entry.vd).abs() <= 0.51e-3, "{name}: {abbe} instead of {}", entry.vd);
            assert!(entry.dispersion.clone().validated().is_ok(), "{name}");
        }
        let makers = ["cdgm", "hikari", "hoya", "ohara", "schott", "sumita"];
        assert_eq!(
            sizes.into_iter().collect::<Vec<_>>(),
            makers.into_iter().zip([314, 363, 190, 410, 158, 176]).collect::<Vec<_>>()
        );
    }

    #[test]
    fn indices_are_those_of_the_makers_data_sheets() {
        // Published to five digits: Schott N-BK7 517642.251, Ohara S-LAH79 003283 (n_g 2.06155), Schott SF6 805254.518.
        for (name, line, published) in [
            ("N-BK7", 435.8343, 1.52668),
            ("N-BK7", 1013.98, 1.50731),
            ("SF6", 486.1327, 1.82775),
            ("SF6", 656.2725, 1.79609),
        ] {
            let entry =
                entries().iter().find(|entry| entry.catalogue == "schott" && entry.name == name).expect("known");
            let n = entry.dispersion.index(line);
            assert!((n - published).abs() <= 0.5e-5, "{name} at {line}: {n} instead of {published}");
        }
    }
}
