//! Spectral data that ship with the program: the observer, standard illuminants, reflectances, filters, quantum
//! efficiencies, metals and glasses.
//!
//! Every file of `assets/spectra` is part of the binary, under its path without extension (`cornell/white`). The top of
//! each file cites the source of its figures. Names are found whatever their case.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use serde::Deserialize;

use super::{Dispersion, Outside, SpectralTable, Spectrum};

/// Name of the table of colour-matching functions.
pub const OBSERVER: &str = "cie-1931-2deg";

/// Texts of `assets/spectra/NAME.csv` for all names.
macro_rules! embed {
    ($($name:literal,)*) => {
        &[$(($name, include_str!(concat!("../../assets/spectra/", $name, ".csv")))),*]
    };
}

/// All tables, sorted by name.
const TABLES: &[(&str, &str)] = embed![
    "cie-1931-2deg",
    "colour-checker/01-dark-skin",
    "colour-checker/02-light-skin",
    "colour-checker/03-blue-sky",
    "colour-checker/04-foliage",
    "colour-checker/05-blue-flower",
    "colour-checker/06-bluish-green",
    "colour-checker/07-orange",
    "colour-checker/08-purplish-blue",
    "colour-checker/09-moderate-red",
    "colour-checker/10-purple",
    "colour-checker/11-yellow-green",
    "colour-checker/12-orange-yellow",
    "colour-checker/13-blue",
    "colour-checker/14-green",
    "colour-checker/15-red",
    "colour-checker/16-yellow",
    "colour-checker/17-magenta",
    "colour-checker/18-cyan",
    "colour-checker/19-white",
    "colour-checker/20-neutral-8",
    "colour-checker/21-neutral-6-5",
    "colour-checker/22-neutral-5",
    "colour-checker/23-neutral-3-5",
    "colour-checker/24-black",
    "cornell/green",
    "cornell/light",
    "cornell/red",
    "cornell/white",
    "filters/ir-cut-650",
    "illuminants/d-series",
    "illuminants/d50",
    "illuminants/d65",
    "illuminants/fl1",
    "illuminants/fl10",
    "illuminants/fl11",
    "illuminants/fl12",
    "illuminants/fl2",
    "illuminants/fl3",
    "illuminants/fl4",
    "illuminants/fl5",
    "illuminants/fl6",
    "illuminants/fl7",
    "illuminants/fl8",
    "illuminants/fl9",
    "illuminants/led-b1",
    "illuminants/led-b2",
    "illuminants/led-b3",
    "illuminants/led-b4",
    "illuminants/led-b5",
    "illuminants/led-bh1",
    "illuminants/led-rgb1",
    "illuminants/led-v1",
    "illuminants/led-v2",
    "metals/ag",
    "metals/al",
    "metals/au",
    "metals/cu",
    "quantum-efficiency/generic-cmos-color-b",
    "quantum-efficiency/generic-cmos-color-g",
    "quantum-efficiency/generic-cmos-color-r",
    "quantum-efficiency/generic-three-chip-b",
    "quantum-efficiency/generic-three-chip-g",
    "quantum-efficiency/generic-three-chip-r",
    "quantum-efficiency/sony-imx249-b",
    "quantum-efficiency/sony-imx249-g",
    "quantum-efficiency/sony-imx249-mono",
    "quantum-efficiency/sony-imx249-r",
    "quantum-efficiency/textbook-ccd",
    "reflectances/leaf",
    "reflectances/leaf-transmittance",
    "semiconductors/si",
];

/// Sellmeier and Cauchy coefficients of glasses, liquids and plastics.
const GLASSES: &str = include_str!("../../assets/spectra/glasses.toml");

/// The complex refractive index n + ik of a metal.
#[derive(Clone, Debug, PartialEq)]
pub struct Conductor {
    /// Real part n.
    pub eta: Spectrum,
    /// Imaginary part, the extinction coefficient k; positive where light is absorbed.
    pub k: Spectrum,
}

/// Names of all tables.
pub fn names() -> impl Iterator<Item = &'static str> {
    TABLES.iter().map(|(name, _)| *name)
}

/// Names of the tables that [`reflectance`] finds.
pub fn reflectances() -> impl Iterator<Item = &'static str> {
    TABLES.iter().filter(|(_, text)| holds(text, "reflectance")).map(|(name, _)| *name)
}

/// Names and reflectances of the 24 patches of a colour checker, in the order of reading.
pub fn colour_checker() -> impl Iterator<Item = (&'static str, Spectrum)> {
    names().filter(|name| name.starts_with("colour-checker/")).filter_map(|name| Some((name, spectrum(name)?)))
}

/// Names of tables that can serve as transmittances: measured ones, and reflectances, whose spectra serve as well.
pub fn transmittances() -> impl Iterator<Item = &'static str> {
    let is_one = |text| holds(text, "transmittance") || holds(text, "reflectance");
    TABLES.iter().filter(move |(_, text)| is_one(text)).map(|(name, _)| *name)
}

/// Symbols of the metals that [`conductor`] finds.
pub fn conductors() -> impl Iterator<Item = &'static str> {
    METALS.iter().map(|(symbol, _, _)| *symbol)
}

/// Names of the media that [`glass`] finds.
pub fn glasses() -> impl Iterator<Item = &'static str> {
    media().keys().map(String::as_str)
}

/// The columns of a table.
pub fn table(name: &str) -> Option<SpectralTable> {
    let (name, text) = TABLES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name))?;
    // The library's own files all say what lies outside, and a test parses every one.
    Some(SpectralTable::parse(text, Outside::Zero).unwrap_or_else(|error| panic!("assets/spectra/{name}.csv: {error}")))
}

/// The spectrum of a table with one column of values, in the unit that the file states.
pub fn spectrum(name: &str) -> Option<Spectrum> {
    table(name)?.single().ok()
}

/// A reflectance (0–1) by name: `cornell/white`, `colour-checker/13-blue`.
pub fn reflectance(name: &str) -> Option<Spectrum> {
    let known = reflectances().find(|known| known.eq_ignore_ascii_case(name))?;
    spectrum(known)
}

/// A metal by its chemical symbol or English name.
pub fn conductor(name: &str) -> Option<Conductor> {
    let known = |symbol: &str, english: &str| symbol.eq_ignore_ascii_case(name) || english.eq_ignore_ascii_case(name);
    let (_, _, path) = METALS.iter().find(|(symbol, english, _)| known(symbol, english))?;
    let table = table(path)?;
    Some(Conductor { eta: table.column("n").ok()?, k: table.column("k").ok()? })
}

/// Complex refractive index of silicon, of which sensors are made, at 300 K.
pub fn silicon() -> Conductor {
    let table = table("semiconductors/si").expect("listed above");
    let column = |name| table.column(name).expect("the file is part of the program and tested");
    Conductor { eta: column("n"), k: column("k") }
}

/// Symbol, English name and table of the metals.
const METALS: [(&str, &str, &str); 4] = [
    ("Au", "gold", "metals/au"),
    ("Ag", "silver", "metals/ag"),
    ("Cu", "copper", "metals/cu"),
    ("Al", "aluminium", "metals/al"),
];

/// A clear medium by name: `BK7`, `fused-silica`, `water`.
pub fn glass(name: &str) -> Option<Dispersion> {
    let known = media().keys().find(|known| known.eq_ignore_ascii_case(name))?;
    Some(media()[known].formula.clone().into())
}

/// One entry of `glasses.toml`. `title`, `source` and `range_nm` are there for the reader of the file.
#[derive(Clone, Debug, Deserialize)]
struct Medium {
    #[serde(flatten)]
    formula: Formula,
    /// Published index at 587.56 nm, for the tests; `None` where there is none.
    #[cfg_attr(not(test), expect(dead_code, reason = "a published figure that the tests compare with"))]
    nd: Option<f64>,
}

/// Formulas by the name that the file gives them.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "model", rename_all = "lowercase")]
enum Formula {
    Sellmeier { b: Vec<f64>, c_um2: Vec<f64> },
    Cauchy { a: f64, b_um2: f64, c_um4: f64 },
}

impl From<Formula> for Dispersion {
    fn from(formula: Formula) -> Self {
        match formula {
            Formula::Sellmeier { b, c_um2 } => Self::Sellmeier { b, c_um2 },
            Formula::Cauchy { a, b_um2, c_um4 } => Self::Cauchy { a, b_um2, c_um4 },
        }
    }
}

fn media() -> &'static BTreeMap<String, Medium> {
    static MEDIA: OnceLock<BTreeMap<String, Medium>> = OnceLock::new();
    MEDIA.get_or_init(|| toml::from_str(GLASSES).expect("glasses.toml is part of the program and tested"))
}

/// Whether a table declares itself to hold this quantity.
fn holds(text: &str, quantity: &str) -> bool {
    text.lines().any(|line| line.strip_prefix("# quantity: ") == Some(quantity))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;

    use super::*;
    use crate::spectrum::dispersion::lines;

    /// Paths of all CSV files below `folder`, relative and without extension.
    fn files(folder: &Path, prefix: &str, found: &mut BTreeSet<String>) {
        for entry in std::fs::read_dir(folder).expect("assets are readable") {
            let path = entry.expect("assets are readable").path();
            let stem = path.file_stem().expect("has a name").to_string_lossy().into_owned();
            if path.is_dir() {
                files(&path, &format!("{prefix}{stem}/"), found);
            } else if path.extension().is_some_and(|e| e == "csv") {
                found.insert(format!("{prefix}{stem}"));
            }
        }
    }

    #[test]
    fn no_file_of_the_folder_is_forgotten() {
        let mut found = BTreeSet::new();
        files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/spectra"), "", &mut found);
        assert_eq!(names().map(str::to_owned).collect::<BTreeSet<_>>(), found);
        assert!(names().is_sorted());
    }

    #[test]
    fn every_table_parses_and_says_what_it_holds() {
        for (name, text) in TABLES {
            let table = table(name).expect("listed");
            assert!(text.contains("# source: ") && text.contains("# outside: "), "{name}");
            for column in table.names() {
                table.column(column).expect("valid");
            }
            let quantity = text.lines().find_map(|line| line.strip_prefix("# quantity: ")).expect("stated");
            // Quantity, the words after it being remarks.
            let known = [
                "reflectance",
                "transmittance",
                "quantum efficiency",
                "refractive index",
                "emission (relative)",
                "colour-matching functions",
            ];
            assert!(known.iter().any(|q| quantity.starts_with(q)), "{name}: {quantity}");
        }
    }

    #[test]
    fn reflectances_are_physical() {
        assert_eq!(reflectances().filter(|name| name.starts_with("colour-checker/")).count(), 24);
        assert_eq!(colour_checker().count(), 24);
        for name in reflectances() {
            let spectrum = reflectance(&name.to_uppercase()).expect("listed");
            assert!(spectrum.min() >= 0.0 && spectrum.max() <= 1.0, "{name}");
            assert!(spectrum.eval(300.0) > 0.0 && spectrum.eval(1100.0) > 0.0, "{name} holds its ends");
        }
        assert!(reflectance("illuminants/d65").is_none() && reflectance("cornell/pink").is_none());
    }

    #[test]
    fn metals_reflect_as_published() {
        // Normal reflectance ((n − 1)² + k²)/((n + 1)² + k²). Johnson & Christy's silver at 1.94 eV (639 nm, n = 0.05,
        // k = 4.27 or so) reflects 98–99 %; Rakić's aluminium 91–92 % in the green; gold 94–98 % in the red and
        // about 40 % in the blue; copper between 50 and 60 % in the blue and above 93 % in the red.
        let reflectance = |metal: &str, lambda: f32| {
            let Conductor { eta, k } = conductor(metal).expect("listed");
            let (n, k) = (eta.eval(lambda), k.eval(lambda));
            ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k)
        };
        for (metal, lambda, range) in [
            ("Ag", 639.0, 0.98..=0.995),
            ("Al", 550.0, 0.91..=0.92),
            ("gold", 650.0, 0.94..=0.98),
            ("au", 450.0, 0.37..=0.42),
            ("Cu", 650.0, 0.93..=0.97),
            ("Cu", 450.0, 0.50..=0.60),
        ] {
            assert!(range.contains(&reflectance(metal, lambda)), "{metal} {lambda}: {}", reflectance(metal, lambda));
        }
        assert!(conductors().all(|symbol| conductor(symbol).is_some()));
        assert!(conductor("unobtainium").is_none());
    }

    #[test]
    fn glasses_have_their_published_index() {
        for (name, medium) in media() {
            let dispersion = glass(name).expect("listed").validated().expect("valid");
            let Some(nd) = medium.nd else { continue };
            // Half a unit of the last digit given; the plastics' fits miss theirs by up to 4e-4, as the file says.
            let decimals = nd.to_string().len() - 2;
            let tolerance = if name.starts_with('p') { 4e-4 } else { 0.5001 * 10f64.powi(-(decimals as i32)) };
            let n = dispersion.index(lines::D);
            assert!((n - nd).abs() <= tolerance, "{name}: {n} instead of {nd}");
        }
        assert_eq!(glass("BK7"), glass("bk7"));
        assert!(glasses().count() >= 27 && glass("butter").is_none());
    }
}
