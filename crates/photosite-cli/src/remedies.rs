//! Remedies of errors, as options of the command line.

use photosite_core::Remedy;

/// Remedy of an error, as options of the command line.
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
        Remedy::Variance(image) => {
            let option = image.to_lowercase();
            format!("give it with --variance-{option} FILE, or write --variance-{option} 0 if {image} is exact")
        }
        Remedy::Moments(image) => {
            let option = image.to_lowercase();
            format!("state how many samples per pixel its second moments come from, with --samples-{option} N")
        }
        Remedy::Lenient => "add --lenient, and grey is used instead".to_owned(),
        Remedy::Nearest => "add --approximate for the closest that Mitsuba has".to_owned(),
        Remedy::Linear => "add --linear if its codes are proportional to light".to_owned(),
        Remedy::LightUnit => {
            "say what the pixel values of an image mean with --unit electrons, full-well, lux or irradiance".to_owned()
        }
    }
}
