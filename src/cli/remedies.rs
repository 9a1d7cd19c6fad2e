//! What to do about errors, as the options of the command line that do it.

use crate::Remedy;

/// What to do about an error, as the options of the command line that do it.
pub(super) fn in_options(remedy: &Remedy) -> String {
    match remedy {
        Remedy::Say(words) => words.clone(),
        Remedy::Overwrite => "add --force to overwrite".to_owned(),
        Remedy::StartAnew => "add --force to start again".to_owned(),
        Remedy::Elsewhere(place) => format!("choose {place} with -o"),
        Remedy::Override(change) => format!("add --set {change}"),
        Remedy::Example(change) => format!("for example --set {change}"),
        Remedy::FilmMemory(gib) => format!("add --film-memory {gib}"),
        Remedy::Memory(gib) => format!("allow it with --memory {gib}"),
        Remedy::Samples([from, to]) => format!("render them with --samples {from}..{to}"),
        Remedy::Channels(names) => format!("name channels that both have: --channels {}", names.join(",")),
        Remedy::Masked { name, area } => {
            format!("of {name} the active area is looked at, {area}; --masked looks at its masked pixels, too")
        }
        Remedy::Variance(picture) => {
            let option = picture.to_lowercase();
            format!("give it with --variance-{option} FILE, or write --variance-{option} 0 if {picture} is exact")
        }
        Remedy::Moments(picture) => {
            let option = picture.to_lowercase();
            format!("state how many samples per pixel its second moments come from, with --samples-{option} N")
        }
        Remedy::Lenient => "add --lenient, and grey is used instead".to_owned(),
        Remedy::Nearest => "add --approximate for the closest that Mitsuba has".to_owned(),
        Remedy::Linear => "add --linear if its codes are proportional to light".to_owned(),
        Remedy::LightUnit => {
            "say what the numbers of a picture mean with --unit electrons, full-well, lux or irradiance".to_owned()
        }
    }
}
