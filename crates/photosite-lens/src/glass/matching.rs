//! Search for a glass by its name in a file.

use photosite_core::spectrum::library;
use photosite_core::suggest;

use super::catalogue::{Entry, entries};
use crate::prescription::Glass;

/// Result of a search by name.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// A single glass. The note states assumptions, if any.
    Glass(Glass, Option<String>),
    /// Glasses of several makers with different indices, as `maker/name`.
    Ambiguous(Vec<String>),
    /// No glass; the most similar names, as `maker/name`.
    Unknown(Vec<String>),
}

/// Media that no maker's catalogue has: their names in optical programs, and in photosite's library.
const MEDIA: [(&str, &str); 17] = [
    ("SILICA", "fused-silica"),
    ("FSILICA", "fused-silica"),
    ("FUSEDSILICA", "fused-silica"),
    ("UVFS", "fused-silica"),
    ("QUARTZGLASS", "fused-silica"),
    ("CAF2", "calcium-fluoride"),
    ("FLUORITE", "calcium-fluoride"),
    ("CALCIUMFLUORIDE", "calcium-fluoride"),
    ("BAF2", "barium-fluoride"),
    ("PMMA", "pmma"),
    ("ACRYLIC", "pmma"),
    ("POLYCARB", "polycarbonate"),
    ("POLYCARBONATE", "polycarbonate"),
    ("POLYSTYR", "polystyrene"),
    ("POLYSTYRENE", "polystyrene"),
    ("WATER", "water"),
    ("SEAWATER", "water"),
];

/// Finds the glass of a name, in whatever case, with or without dashes.
///
/// `catalogues` are those named by the file, in order of preference; empty where it names none. A glass of these
/// catalogues is taken first, then the successor that Schott gave to an old name (BK7 became N-BK7), then a glass that
/// only one maker has under this name. Names that several makers have are [`Found::Ambiguous`]: F2 has n_d = 1.6200 at
/// Schott and 1.6129 at CDGM.
pub fn by_name(name: &str, catalogues: &[String]) -> Found {
    let wanted = plain(name);
    let successor = format!("N{wanted}");
    let in_catalogue = |entry: &&Entry, catalogue: &String| catalogue.eq_ignore_ascii_case(entry.catalogue);
    for catalogue in catalogues {
        let own = || entries().iter().filter(|entry| in_catalogue(entry, catalogue));
        if let Some(entry) = own().find(|entry| plain(entry.name) == wanted) {
            return Found::Glass(entry.to_glass(""), None);
        }
        if let Some(entry) = own().find(|entry| entry.catalogue == "schott" && plain(entry.name) == successor) {
            return Found::Glass(entry.to_glass(""), Some(succeeded(name, entry)));
        }
    }
    let alike: Vec<&Entry> = entries().iter().filter(|entry| plain(entry.name) == wanted).collect();
    match &alike[..] {
        [entry] => {
            let elsewhere =
                format!("{name} is in none of the catalogues that the file names, but in that of {}", entry.catalogue);
            return Found::Glass(entry.to_glass(""), (!catalogues.is_empty()).then_some(elsewhere));
        }
        [] => {}
        several => return Found::Ambiguous(several.iter().map(|entry| full_name(entry)).collect()),
    }
    if let Some(entry) = entries().iter().find(|entry| entry.catalogue == "schott" && plain(entry.name) == successor) {
        return Found::Glass(entry.to_glass(""), Some(succeeded(name, entry)));
    }
    if let Some(glass) = medium(&wanted) {
        return Found::Glass(glass, None);
    }
    Found::Unknown(nearest(&wanted))
}

fn succeeded(name: &str, entry: &Entry) -> String {
    format!("{name} is no longer made; its successor {} stands for it", entry.name)
}

/// Letters and digits of a name, in capitals: CODE V leaves out the dashes, and some files use lower case.
fn plain(name: &str) -> String {
    name.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_uppercase()).collect()
}

fn full_name(entry: &Entry) -> String {
    format!("{}/{}", entry.catalogue, entry.name)
}

fn medium(plain_name: &str) -> Option<Glass> {
    let (_, name) = MEDIA.iter().find(|(alias, _)| *alias == plain_name)?;
    let dispersion = library::glass(name)?;
    let source = format!("refractiveindex.info (CC0): {name}");
    Some(Glass { name: (*name).to_owned(), source, dispersion, range_nm: None })
}

/// Five most similar names.
fn nearest(wanted: &str) -> Vec<String> {
    let mut names: Vec<(String, &Entry)> = entries().iter().map(|entry| (plain(entry.name), entry)).collect();
    let mut best = Vec::new();
    while best.len() < 5 {
        let Some(found) = suggest::closest(wanted, names.iter().map(|(name, _)| name.as_str())).map(str::to_owned)
        else {
            break;
        };
        best.extend(names.iter().filter(|(name, _)| *name == found).map(|(_, entry)| full_name(entry)));
        names.retain(|(name, _)| *name != found);
    }
    best.truncate(5);
    best
}

#[cfg(test)]
mod tests {
    use photosite_core::spectrum::dispersion::lines;

    use super::*;

    fn found(name: &str, catalogues: &[&str]) -> (String, f64, bool) {
        let catalogues: Vec<String> = catalogues.iter().map(|&c| c.to_owned()).collect();
        match by_name(name, &catalogues) {
            Found::Glass(glass, note) => (glass.source, glass.dispersion.index(lines::D), note.is_some()),
            other @ (Found::Ambiguous(_) | Found::Unknown(_)) => panic!("{name}: {other:?}"),
        }
    }

    #[test]
    fn names_are_found_with_and_without_dashes_and_in_the_catalogue_that_is_wanted() {
        for (name, catalogues, source, nd, has_note) in [
            ("N-BK7", &[][..], "schott/N-BK7", 1.5168, false),
            ("nbk7", &["SCHOTT"][..], "schott/N-BK7", 1.5168, false),
            ("SLAL8", &["OHARA"][..], "ohara/S-LAL8", 1.712995, false),
            ("F2", &["SCHOTT", "CDGM"][..], "schott/F2", 1.62004, false),
            ("F2", &["cdgm"][..], "cdgm/F2", 1.612929, false),
            // Hikari still makes SK16, yet a file of Schott's glasses means Schott's.
            ("SK16", &[][..], "hikari/SK16", 1.620409, false),
            ("SK16", &["SCHOTT"][..], "schott/N-SK16", 1.62041, true),
            ("BK7", &[][..], "schott/N-BK7", 1.5168, true),
            ("S-LAH79", &["SCHOTT", "MISC"][..], "ohara/S-LAH79", 2.0033, true),
            ("K-CaFK95(M)", &[][..], "sumita/K-CaFK95(M)", 1.4331, false),
            ("CAF2", &["INFRARED"][..], "calcium-fluoride", 1.43384, false),
            ("F_SILICA", &[][..], "fused-silica", 1.45846, false),
        ] {
            let (from, n, noted) = found(name, catalogues);
            assert!(from.ends_with(source), "{name}: {from}");
            assert!((n - nd).abs() < 1.5e-3 * (nd - 1.0), "{name}: {n}");
            assert_eq!(noted, has_note, "{name}");
        }
    }

    #[test]
    fn names_of_several_makers_are_ambiguous_and_strangers_are_named_with_their_like() {
        let Found::Ambiguous(makers) = by_name("F2", &[]) else { panic!("one glass") };
        assert_eq!(makers, ["schott/F2", "hikari/F2", "cdgm/F2"]);
        let Found::Unknown(nearest) = by_name("D-ZK3M", &[]) else { panic!("known") };
        assert!(nearest.contains(&"cdgm/D-ZK3".to_owned()), "{nearest:?}");
        let Found::Unknown(nearest) = by_name("N-BK77", &[]) else { panic!("known") };
        assert_eq!(nearest[0], "schott/N-BK7", "{nearest:?}");
        assert!(matches!(by_name("", &[]), Found::Unknown(_)));
    }

    #[test]
    fn twenty_seven_names_need_a_maker() {
        let ambiguous = |entry: &&Entry| matches!(by_name(entry.name, &[]), Found::Ambiguous(_));
        let mut names: Vec<&str> = entries().iter().filter(ambiguous).map(|entry| entry.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), 27, "{names:?}");
    }
}
