//! Where programs keep what takes long to work out.

use std::env;
use std::ffi::OsString;
use std::path::PathBuf;

/// The environment's variable that names the folder, or is `off`.
const VARIABLE: &str = "PHOTOSITE_CACHE";

/// Keeps pictures of points through lenses from prescriptions on disk from now on: in the folder that `PHOTOSITE_CACHE` names,
/// nowhere where that is `off`, or else in the user's folder of caches. Programs call it as they start; a library does not.
pub fn keep_on_disk() {
    let lenses = folder(|name| env::var_os(name)).map(|folder| folder.join("point-spreads"));
    crate::optics::keep_point_spreads(lenses);
}

/// The folder by what the environment says.
fn folder(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    if let Some(own) = variable(VARIABLE).filter(|own| !own.is_empty()) {
        return (own != "off").then(|| own.into());
    }
    // Relative paths are to be left alone, says the XDG Base Directory Specification.
    let path = |name: &str| variable(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let caches = if cfg!(windows) {
        path("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        path("HOME").map(|home| home.join("Library/Caches"))
    } else {
        path("XDG_CACHE_HOME").or_else(|| path("HOME").map(|home| home.join(".cache")))
    };
    caches.map(|caches| caches.join("photosite"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(variables: &[(&str, &str)]) -> Option<PathBuf> {
        folder(|name| variables.iter().find(|(known, _)| *known == name).map(|(_, value)| value.into()))
    }

    #[test]
    fn a_folder_of_ones_own_goes_before_that_of_the_platform() {
        assert_eq!(found(&[(VARIABLE, "elsewhere"), ("HOME", "/home/me")]), Some("elsewhere".into()));
        assert_eq!(found(&[(VARIABLE, "off"), ("HOME", "/home/me"), ("LOCALAPPDATA", "C:\\me")]), None);
        assert_eq!(found(&[]), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn on_linux_it_is_that_of_the_desktop() {
        assert_eq!(found(&[("HOME", "/home/me")]), Some("/home/me/.cache/photosite".into()));
        assert_eq!(found(&[(VARIABLE, ""), ("HOME", "/home/me")]), Some("/home/me/.cache/photosite".into()));
        assert_eq!(found(&[("XDG_CACHE_HOME", "/c"), ("HOME", "/home/me")]), Some("/c/photosite".into()));
        assert_eq!(found(&[("XDG_CACHE_HOME", "c"), ("HOME", "/home/me")]), Some("/home/me/.cache/photosite".into()));
    }
}
