//! A folder that files must lie in which scenes name, for scenes from strangers.

use std::io;
use std::path::{Component, Path, PathBuf, absolute};
use std::sync::Arc;

use crate::{Error, Invalid, Result};

/// Where files may lie that captures and scenes name: in one folder, or anywhere.
///
/// It goes along with whatever is loaded, and is asked before a file that something names is looked for. Links are
/// followed first, so that none leads out. Nothing is held against a folder that somebody changes meanwhile.
#[derive(Clone, Debug, Default)]
pub struct Sandbox {
    folder: Option<Arc<Path>>,
}

impl Sandbox {
    /// Files may lie in this folder alone, and in those below it.
    ///
    /// # Errors
    ///
    /// That there is no such folder.
    pub fn new(folder: &Path) -> Result<Self> {
        let whole = folder.canonicalize().and_then(|whole| {
            if whole.is_dir() { Ok(whole) } else { Err(io::Error::from(io::ErrorKind::NotADirectory)) }
        });
        let whole = whole.map_err(|reason| Error::io(folder, "use as a sandbox", reason))?;
        Ok(Self { folder: Some(whole.into()) })
    }

    /// Refuses a file outside, whether it exists or not.
    ///
    /// # Errors
    ///
    /// Its path, and what to do.
    pub fn check(&self, path: &Path) -> Result<(), Invalid> {
        let Some(folder) = &self.folder else { return Ok(()) };
        if real(path).is_some_and(|real| real.starts_with(folder)) {
            return Ok(());
        }
        let (path, folder) = (path.display(), folder.display());
        let message = format!("names {path}, which is not in the sandbox {folder}");
        Err(Invalid::new("", message)
            .help("put the file there, or give a sandbox that it is in if you trust the scene"))
    }
}

/// The path that a file really has, or would have where it is not there. `None` where steps back follow what is not
/// there, or links lead nowhere.
fn real(path: &Path) -> Option<PathBuf> {
    let path = absolute(path).ok()?;
    for known in path.ancestors() {
        match known.canonicalize() {
            Ok(real) => {
                let rest = path.strip_prefix(known).ok()?;
                let is_plain = rest.components().all(|part| matches!(part, Component::Normal(_)));
                return is_plain.then(|| real.join(rest));
            }
            // A link that leads nowhere yet is followed by nobody.
            Err(_) if known.is_symlink() => return None,
            Err(_) => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn only_what_is_in_the_folder_is_allowed() {
        let place = tempfile::tempdir().expect("a folder");
        let at = |name: &str| place.path().join(name);
        fs::create_dir_all(at("in/deep")).expect("made");
        for name in ["in/a", "in/deep/b", "out", "in-beside"] {
            fs::write(at(name), "").expect("written");
        }
        let sandbox = Sandbox::new(&at("in")).expect("a folder");
        for name in ["in/a", "in/deep/b", "in/deep/../a", "in/../in/a", "in/absent", "in/absent/too"] {
            assert_eq!(sandbox.check(&at(name)), Ok(()), "{name}");
        }
        for name in ["out", "in/../out", "in/deep/../../out", "absent", "in/absent/../../out", "in-beside", ""] {
            let invalid = sandbox.check(&at(name)).expect_err(name);
            assert!(invalid.message.contains("not in the sandbox") && invalid.help.is_some(), "{invalid}");
        }
        assert!(sandbox.check(Path::new("/etc/passwd")).is_err());
        assert_eq!(Sandbox::default().check(Path::new("/etc/passwd")), Ok(()));
        assert!(Sandbox::new(&at("out")).is_err() && Sandbox::new(&at("absent")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_seen_through() {
        use std::os::unix::fs::symlink;
        let place = tempfile::tempdir().expect("a folder");
        let at = |name: &str| place.path().join(name);
        fs::create_dir_all(at("in")).expect("made");
        fs::write(at("out"), "").expect("written");
        fs::write(at("in/a"), "").expect("written");
        for (to, link) in
            [("out", "in/file"), ("", "in/folder"), ("nowhere", "in/dangling"), ("in/a", "in/fine"), ("in", "to-in")]
        {
            symlink(at(to), at(link)).expect("linked");
        }
        let sandbox = Sandbox::new(&at("to-in")).expect("a folder");
        for name in ["in/a", "in/fine", "to-in/a"] {
            assert_eq!(sandbox.check(&at(name)), Ok(()), "{name}");
        }
        for name in ["in/file", "in/folder/out", "in/folder/absent", "in/dangling", "in/dangling/a"] {
            assert!(sandbox.check(&at(name)).is_err(), "{name}");
        }
    }
}
