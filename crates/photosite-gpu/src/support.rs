//! Refusals by key of settings that a card does not have: what is rendered is rendered as on the processor.
//!
//! Scenes are rendered whatever they hold: a new model, light or shape does not compile until it has its words in the tables of
//! [`scene::packed`](photosite_transport::scene::packed).

use photosite_core::Invalid;
use photosite_transport::integrator::RenderSettings;

/// First setting that keeps a render from a card, with its key; `None` where a card has all of them.
pub fn unsupported(settings: &RenderSettings) -> Option<Invalid> {
    let strategies = [
        (settings.splitting() > 1, "render.splitting", "paths that split"),
        (settings.light_paths() > 0.0, "render.light_paths", "paths from lights"),
    ];
    let (_, key, what) = strategies.into_iter().find(|(is_set, ..)| *is_set)?;
    let message = format!("{what} cannot be rendered on a graphics card yet");
    Some(Invalid::new(key, message).help("render with --device cpu"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strategies_that_a_card_does_not_have_are_named_by_their_keys() {
        assert_eq!(unsupported(&RenderSettings::default()), None);
        for (settings, key) in [
            (RenderSettings { splitting: Some(4), ..Default::default() }, "render.splitting"),
            (RenderSettings { light_paths: Some(1.0), ..Default::default() }, "render.light_paths"),
        ] {
            assert_eq!(unsupported(&settings).map(|refused| refused.key), Some(key.to_owned()));
        }
    }
}
