//! Development of raw images: `[develop]`.

use photosite_core::{Help, Remedy};
use std::path::Path;

use super::super::files::input::read_source;
use super::super::tables::SECTIONS;
use super::super::tree::overrides;
use super::super::tree::source::{CaptureSource, shown};
use photosite_core::suggest::{did_you_mean, list};
use photosite_core::{Error, Invalid, Result};
use photosite_develop::DevelopSettings;

/// The `[develop]` table alone: of a capture file, if one is given, with overrides laid over it. Their keys are
/// those of a capture file (`develop.demosaic`).
pub fn read_develop_settings(capture: Option<&Path>, overrides: &[String]) -> Result<(DevelopSettings, CaptureSource)> {
    let mut source = match capture {
        Some(path) => read_source(path)?,
        None => CaptureSource::empty("develop".as_ref()),
    };
    for argument in overrides {
        refuse_other_tables(argument)?;
        overrides::set(&mut source, argument)?;
    }
    let settings: DevelopSettings = source.read("develop")?.unwrap_or_default();
    let settings = checked(&settings).map_err(|invalid| source.error(invalid))?;
    Ok((settings, source))
}

/// Refuses keys outside `develop.`, which change nothing here; a key of the table without its name is a likely slip.
fn refuse_other_tables(argument: &str) -> Result<()> {
    let key = argument.split(['.', '=']).next().unwrap_or_default().trim();
    if key == "develop" {
        return Ok(());
    }
    let keys = keys();
    let (message, help) = if SECTIONS.contains(&key) {
        (format!("[{key}] does not affect development"), Help::from("the keys here begin with develop."))
    } else if keys.contains(&key.to_owned()) {
        ("the key stands in the table [develop]".to_owned(), Remedy::Override(format!("develop.{argument}")).into())
    } else {
        let suggestion = did_you_mean(key, keys.iter().map(String::as_str));
        let help = format!("the keys are develop. and one of {}", list(key, keys.iter().map(String::as_str)));
        (format!("unknown key `{key}`{suggestion}"), help.into())
    };
    Err(Error::Override { argument: shown(argument), message, help: Some(help) })
}

/// The keys of `[develop]`.
fn keys() -> Vec<String> {
    let value = serde_json::to_value(DevelopSettings::default()).unwrap_or_default();
    value.as_object().into_iter().flat_map(|object| object.keys().cloned()).collect()
}

/// The settings of a table, refused where they are out of range.
pub(crate) fn checked(table: &DevelopSettings) -> Result<DevelopSettings, Invalid> {
    table.validate().map_err(|invalid| invalid.within("develop"))?;
    Ok(table.clone())
}
