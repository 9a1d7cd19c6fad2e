//! Patterns of file names in a data set file, such as "textures/*.png".

use std::collections::BTreeSet;
use std::path::Path;

use glob::{MatchOptions, Pattern};

use crate::capture::relative_path;
use crate::{Invalid, Result, Sandbox};

/// The files that a pattern stands for, in the order of their names, as they read from the folder of the capture. It is
/// relative to the data set file.
pub(super) fn files_of(
    pattern: &str,
    dataset: &Path,
    capture: &Path,
    sandbox: &Sandbox,
) -> Result<Vec<String>, Invalid> {
    let folder = dataset.parent().unwrap_or(Path::new(""));
    let is_whole = Path::new(pattern).is_absolute() || folder.as_os_str().is_empty();
    let whole =
        if is_whole { pattern.to_owned() } else { format!("{}/{pattern}", Pattern::escape(&folder.to_string_lossy())) };
    let options = MatchOptions { require_literal_leading_dot: true, ..MatchOptions::new() };
    let found = glob::glob_with(&whole, options).map_err(|error| {
        Invalid::new("", format!("{pattern:?} is not a pattern: {}", error.msg)).help("for example \"textures/*.png\"")
    })?;
    let capture = if capture.as_os_str().is_empty() { Path::new(".") } else { capture };
    let mut names = BTreeSet::new();
    for path in found {
        let path = path.map_err(|error| Invalid::new("", format!("cannot be looked for: {error}")))?;
        if !path.is_file() {
            continue;
        }
        sandbox.check(&path)?;
        if path.to_str().is_none() {
            return Err(Invalid::new("", format!("{} has a name that is not text", path.display())).help("rename it"));
        }
        names.insert(relative_path(&path, capture));
    }
    if names.is_empty() {
        let message = format!("no file matches {pattern:?}");
        let help = "paths are relative to the data set file; * matches any part of a name, ** any folders";
        return Err(Invalid::new("", message).help(help));
    }
    Ok(names.into_iter().collect())
}
