//! Patterns of file names in a data set file, such as "textures/*.png".

use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use glob::{MatchOptions, Pattern};
use walkdir::WalkDir;

use photosite_capture::relative_path;
use photosite_core::{Invalid, Result, Sandbox};

/// Largest number of files and folders that are searched: links can lead on without end.
const MOST: usize = 1_000_000;

/// Files that match a pattern, in the order of their names, as paths relative to the folder of the capture. The pattern
/// is relative to the data set file.
pub(super) fn files_of(
    pattern: &str,
    dataset: &Path,
    capture: &Path,
    sandbox: &Sandbox,
) -> Result<Vec<String>, Invalid> {
    let (folder, parts) = split(pattern);
    let folder = dataset.parent().unwrap_or(Path::new("")).join(folder);
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
    let capture = if capture.as_os_str().is_empty() { Path::new(".") } else { capture };
    let pattern_of = |part: &str| {
        Pattern::new(part).map_err(|error| {
            let message = format!("{pattern:?} is not a pattern: {}", error.msg);
            Invalid::new("", message).help("for example \"textures/*.png\"")
        })
    };
    let whole = pattern_of(&parts.join("/"))?;
    // Folders on the way are looked into where they fit, and below `**` all are.
    let way = parts.iter().take_while(|part| !part.contains("**")).map(|part| pattern_of(part));
    let way = way.collect::<Result<Vec<_>, _>>()?;
    let depth = if way.len() == parts.len() { way.len() } else { usize::MAX };
    // What is not in the sandbox is not looked into: messages would tell what there is.
    sandbox.check(folder)?;
    let mut names = BTreeSet::new();
    let mut walk = WalkDir::new(folder).follow_links(true).max_depth(depth).into_iter();
    for count in 0.. {
        let entry = match walk.next() {
            None => break,
            Some(Ok(entry)) => entry,
            // Links to a folder around them, and to nothing.
            Some(Err(error)) if error.io_error().is_none_or(|io| io.kind() == ErrorKind::NotFound) => continue,
            Some(Err(error)) => return Err(Invalid::new("", format!("cannot be looked for: {error}"))),
        };
        if count > MOST {
            let message = format!("{pattern:?} leads through more than {MOST} files and folders");
            return Err(Invalid::new("", message).help("name the folders in it, without **"));
        }
        let Some(level) = entry.depth().checked_sub(1) else { continue };
        let name = entry.file_name().to_string_lossy();
        if way.get(level).is_some_and(|part| !part.matches_with(&name, OPTIONS)) {
            if entry.file_type().is_dir() {
                walk.skip_current_dir();
            }
            continue;
        }
        if entry.path_is_symlink() {
            sandbox.check(entry.path())?;
        }
        let found = entry.path().strip_prefix(folder).unwrap_or(entry.path());
        if !entry.file_type().is_file() || !whole.matches_path_with(found, OPTIONS) {
            continue;
        }
        let path = if folder == Path::new(".") { found } else { entry.path() };
        if path.to_str().is_none() {
            return Err(Invalid::new("", format!("{} has a name that is not text", path.display())).help("rename it"));
        }
        names.insert(relative_path(path, capture));
    }
    if names.is_empty() {
        let message = format!("no file matches {pattern:?}");
        let help = "paths are relative to the data set file; * matches any part of a name, ** any folders";
        return Err(Invalid::new("", message).help(help));
    }
    Ok(names.into_iter().collect())
}

/// Options of matching: `*` matches letters of one name, and hidden files must be named in full.
const OPTIONS: MatchOptions =
    MatchOptions { case_sensitive: true, require_literal_separator: true, require_literal_leading_dot: true };

/// Leading folder of a pattern, up to the first part with a wildcard, and the parts below it.
fn split(pattern: &str) -> (PathBuf, Vec<&str>) {
    let parts: Vec<&str> = pattern.split('/').collect();
    // A name alone is looked for in the folder before it.
    let plain = parts.iter().take_while(|part| !part.contains(['*', '?', '['])).count().min(parts.len() - 1);
    let (folder, rest) = parts.split_at(plain);
    let root = if pattern.starts_with('/') { "/" } else { "" };
    (Path::new(root).join(folder.join("/")), rest.to_vec())
}
