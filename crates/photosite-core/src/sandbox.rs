//! Sandbox: a folder that all files named by a scene must lie in, for scenes from strangers.
//!
//! A file name in a scene is checked with its key and line: [`Sandbox::check`]. Files that are only found in folders
//! are checked when they are opened: a process that is confined by [`Sandbox::confine`] opens nothing else
//! ([`input`](crate::input)).

use std::io::{self, ErrorKind};
use std::path::{Component, Path, PathBuf, absolute};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use crate::{Error, Invalid, Result};

/// The sandbox of this process, once it is confined.
static WALLS: OnceLock<Walls> = OnceLock::new();

/// Walls of the sandbox, for all that a process opens.
struct Walls {
    folder: Arc<Path>,
    /// Files and folders named by the user, which may lie anywhere.
    trusted: Mutex<Vec<PathBuf>>,
    /// First file that was requested and lies outside, and why it was not opened.
    refused: Mutex<Option<(PathBuf, String)>>,
}

/// Region of the file system for files named by captures and scenes: one folder, or anywhere.
///
/// Loaders carry it along and check each named file before looking for it. Links are followed first, so that none leads
/// out. A folder that changes between check and use is not guarded against.
#[derive(Clone, Debug, Default)]
pub struct Sandbox {
    folder: Option<Arc<Path>>,
}

impl Sandbox {
    /// Sandbox of a folder and all folders below it.
    ///
    /// # Errors
    ///
    /// A folder that does not exist.
    pub fn new(folder: &Path) -> Result<Self> {
        let whole = folder.canonicalize().and_then(|whole| {
            if whole.is_dir() { Ok(whole) } else { Err(io::Error::from(io::ErrorKind::NotADirectory)) }
        });
        let whole = whole.map_err(|reason| Error::io(folder, "use as a sandbox", reason))?;
        Ok(Self { folder: Some(whole.into()) })
    }

    /// Confines the process: it opens nothing outside the sandbox except the files named by the user, and the content
    /// of named folders. A path that lies in the sandbox by its name must really lie there.
    pub fn confine(&self, named: impl IntoIterator<Item = PathBuf>) {
        let Some(folder) = &self.folder else { return };
        let walls = Walls { folder: folder.clone(), trusted: Mutex::default(), refused: Mutex::default() };
        // A process has one command line.
        let _ = WALLS.set(walls);
        named.into_iter().for_each(|path| trust(&path));
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

/// Lets a confined process open a file or a folder's content, because the user named it or results go there.
pub fn trust(path: &Path) {
    if let Some(walls) = WALLS.get() {
        walls.trust(path);
    }
}

/// Real path of a file or a folder, if this process may open it.
///
/// # Errors
///
/// A path outside of the sandbox, if there is one.
pub fn opened(path: &Path) -> io::Result<PathBuf> {
    WALLS.get().map_or_else(|| Ok(path.to_owned()), |walls| walls.opened(path))
}

/// Refuses to write into a folder that lies in the sandbox by its name, but not really: a link leads out. A link in the
/// place of a file that is written whole is replaced, not followed.
///
/// # Errors
///
/// A folder that a link leads to, outside of the sandbox, if there is one.
pub fn written(folder: &Path) -> io::Result<()> {
    WALLS.get().map_or(Ok(()), |walls| walls.written(folder))
}

/// Error of the first file that this process was refused, since the code that asked may have gone on without it.
///
/// # Errors
///
/// The refusal, if there was one.
pub fn check_refused() -> Result<()> {
    let refused = WALLS.get().and_then(|walls| walls.refused.lock().unwrap_or_else(PoisonError::into_inner).clone());
    let error =
        |(path, why): (PathBuf, String)| Error::io(&path, "read", io::Error::new(ErrorKind::PermissionDenied, why));
    refused.map_or(Ok(()), |refused| Err(error(refused)))
}

impl Walls {
    fn trust(&self, path: &Path) {
        let Ok(whole) = absolute(path) else { return };
        let is_inside = |folder: &Path| real(folder).is_some_and(|real| real.starts_with(&self.folder));
        if let Some(real) = real(&whole).filter(|_| !whole.ancestors().skip(1).any(is_inside)) {
            self.trusted.lock().unwrap_or_else(PoisonError::into_inner).push(real);
        }
    }

    fn written(&self, folder: &Path) -> io::Result<()> {
        // The parent of a bare name is empty, and means the working folder.
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let whole = without_steps_back(&absolute(folder)?);
        let is_inside = |path: &Path| real(path).is_some_and(|real| real.starts_with(&self.folder));
        if is_inside(&whole) || !whole.ancestors().skip(1).any(is_inside) {
            return Ok(());
        }
        let message = format!(
            "a link leads out of the sandbox {}; remove the link, or give a sandbox that it is in if you trust it",
            self.folder.display()
        );
        Err(io::Error::new(ErrorKind::PermissionDenied, message))
    }

    fn opened(&self, path: &Path) -> io::Result<PathBuf> {
        // What is not there is told as such by who opens it.
        let allowed = real(path).filter(|real| {
            let trusted = self.trusted.lock().unwrap_or_else(PoisonError::into_inner);
            real.starts_with(&self.folder) || trusted.iter().any(|trusted| real.starts_with(trusted))
        });
        allowed.ok_or_else(|| {
            let folder = self.folder.display();
            let message = format!(
                "it is not in the sandbox {folder}; put the file there, or give a sandbox that it is in if you trust it"
            );
            let mut refused = self.refused.lock().unwrap_or_else(PoisonError::into_inner);
            refused.get_or_insert_with(|| (path.to_owned(), message.clone()));
            io::Error::new(ErrorKind::PermissionDenied, message)
        })
    }
}

/// Lexical path, with each `..` resolved to the folder above.
fn without_steps_back(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        if part == Component::ParentDir {
            plain.pop();
        } else {
            plain.push(part);
        }
    }
    plain
}

/// Real path of a file, or the one that a missing file would have. `None` where `..` follows a missing folder, or links
/// lead nowhere.
fn real(path: &Path) -> Option<PathBuf> {
    let path = absolute(path).ok()?;
    for known in path.ancestors() {
        match known.canonicalize() {
            Ok(real) => {
                let rest = path.strip_prefix(known).ok()?;
                let is_plain = rest.components().all(|part| matches!(part, Component::Normal(_)));
                // Joined to nothing, a file would end like a folder.
                return is_plain.then(|| if rest.as_os_str().is_empty() { real } else { real.join(rest) });
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
    fn nothing_is_written_through_a_link() {
        use std::os::unix::fs::symlink;
        let place = tempfile::tempdir().expect("a folder");
        let at = |name: &str| place.path().join(name);
        for name in ["in/deep", "out"] {
            fs::create_dir_all(at(name)).expect("made");
        }
        for (to, link) in [("out", "in/link"), ("nowhere", "in/dangling"), ("in/deep", "in/fine"), ("in", "to-in")] {
            symlink(at(to), at(link)).expect("linked");
        }
        let folder = at("in").canonicalize().expect("a folder").into();
        let walls = Walls { folder, trusted: Mutex::default(), refused: Mutex::default() };
        for name in ["in", "in/deep", "in/absent/too", "in/fine", "to-in/deep", "out", "out/absent", "in/../out"] {
            assert!(walls.written(&at(name)).is_ok(), "{name}");
        }
        for name in ["in/link", "in/link/deep", "in/dangling", "in/dangling/a", "in/deep/../link", "to-in/link"] {
            assert!(walls.written(&at(name)).is_err(), "{name}");
        }
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
