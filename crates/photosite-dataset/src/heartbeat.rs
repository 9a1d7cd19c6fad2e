//! Heartbeats of processes that make images: the lock of each image names its holder, and is rewritten every few
//! seconds.
//!
//! Times are modification times by the file system, not by the clock of a machine, so that machines whose clocks differ
//! agree on them.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::process::Command;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, SystemTime};

use serde::{Deserialize, Serialize};

use photosite_core::input;
use photosite_core::output::PARTIAL;
use photosite_files::lock::{Lock, is_held};

/// Interval between two heartbeats.
const INTERVAL: Duration = Duration::from_secs(5);
/// Silence after which a process is taken for dead where its lock does not tell, s. Writes to a busy disk may take a
/// while.
pub(super) const SILENCE_S: f64 = 30.0;

/// Holder of an image's lock, as the lock file states it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Holder {
    /// Machine of the holder.
    pub host: String,
    /// Process number on that machine.
    pub process: u32,
    /// Time at which the holder began, by the clock of the file system, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    since_s: Option<f64>,
}

/// Name of this machine.
pub(super) fn host() -> &'static str {
    static HOST: OnceLock<String> = OnceLock::new();
    HOST.get_or_init(|| {
        let of_kernel = fs::read_to_string("/proc/sys/kernel/hostname");
        // Which every other system has.
        let of_command = || Command::new("hostname").output().map(|o| String::from_utf8_lossy(&o.stdout).into_owned());
        let name = of_kernel.or_else(|_| of_command()).unwrap_or_default();
        if name.trim().is_empty() { "unknown".to_owned() } else { name.trim().to_owned() }
    })
}

/// Heartbeats of a process for all images that it makes at once.
#[derive(Debug, Default)]
pub(super) struct Heartbeat(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    ends: Condvar,
}

#[derive(Debug, Default)]
struct State {
    /// Open lock files with their texts, by number.
    locks: Vec<(u64, File, String)>,
    next: u64,
    is_started: bool,
    is_over: bool,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Heartbeat {
    /// States in the lock's file who holds it, from now until the answer is dropped, which must be before the lock is.
    ///
    /// Nothing depends on it: where the disk is full or the file system refuses, nobody learns who is at work.
    pub(super) fn of(&self, lock: &Lock) -> Beating {
        let mut state = self.0.state();
        let number = state.next;
        state.next += 1;
        if let Ok((file, text)) = lock.file().try_clone().and_then(signed) {
            state.locks.push((number, file, text));
        }
        if !state.is_started {
            let shared = Arc::clone(&self.0);
            state.is_started = thread::Builder::new().name("heartbeat".to_owned()).spawn(move || beat(&shared)).is_ok();
        }
        Beating { shared: Arc::clone(&self.0), number }
    }
}

impl Drop for Heartbeat {
    fn drop(&mut self) {
        self.0.state().is_over = true;
        self.0.ends.notify_all();
    }
}

/// Heartbeat for one image.
#[derive(Debug)]
pub(super) struct Beating {
    shared: Arc<Shared>,
    number: u64,
}

impl Drop for Beating {
    fn drop(&mut self) {
        // Its file is closed with it: a copy that stayed open would keep the lock.
        self.shared.state().locks.retain(|(number, ..)| *number != self.number);
    }
}

fn beat(shared: &Shared) {
    let mut state = shared.state();
    while !state.is_over {
        state = shared.ends.wait_timeout(state, INTERVAL).unwrap_or_else(PoisonError::into_inner).0;
        for (_, file, text) in &mut state.locks {
            // The next may succeed.
            let _ = write(file, text);
        }
    }
}

/// Writes this process's identity into a file, and returns the file with that text.
fn signed(mut file: File) -> io::Result<(File, String)> {
    let mut holder = Holder { host: host().to_owned(), process: std::process::id(), since_s: None };
    write(&mut file, &text(&holder))?;
    holder.since_s = time_s(&file);
    let text = text(&holder);
    write(&mut file, &text)?;
    Ok((file, text))
}

fn text(holder: &Holder) -> String {
    serde_json::to_string(holder).unwrap_or_default()
}

/// Replaces the text of a file, which gives it the file system's present time. Servers notice when it is synced.
fn write(file: &mut File, text: &str) -> io::Result<()> {
    file.seek(SeekFrom::Start(0))?;
    file.write_all(text.as_bytes())?;
    file.set_len(text.len() as u64)?;
    file.sync_data()
}

/// Time at which a file was last written to, s.
fn time_s(file: &File) -> Option<f64> {
    let since = file.metadata().ok()?.modified().ok()?.duration_since(SystemTime::UNIX_EPOCH);
    since.ok().map(|since| since.as_secs_f64())
}

/// Present time of a folder's file system, s, from a file that is written there and removed; `None` where nothing can
/// be written.
pub(super) fn now_s(folder: &Path) -> Option<f64> {
    let mut probe = tempfile::Builder::new().prefix(".photosite-").suffix(PARTIAL).tempfile_in(folder).ok()?;
    write(probe.as_file_mut(), "now").ok()?;
    time_s(probe.as_file())
}

/// Sign of a process behind a lock.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sign {
    /// Holder, if it has stated itself.
    pub(super) holder: Option<Holder>,
    /// Time that the holder has been at work, and time since its last heartbeat, s, where these are known.
    pub(super) age_s: Option<f64>,
    pub(super) silence_s: Option<f64>,
}

/// Sign of the process at work behind the lock at `path`; `None` where there is none. `now_s` is the file system's
/// time.
pub(super) fn sign(path: &Path, now_s: Option<f64>) -> Option<Sign> {
    // An open file has the times that the server has, whatever was remembered of it.
    let mut file = input::open(path).ok()?;
    let mut text = String::new();
    let holder = file.read_to_string(&mut text).ok().and_then(|_| serde_json::from_str::<Holder>(&text).ok());
    let since_s = |then: Option<f64>| now_s.zip(then).map(|(now, then)| (now - then).max(0.0));
    let silence_s = since_s(time_s(&file));
    let age_s = since_s(holder.as_ref().and_then(|holder| holder.since_s));
    let is_alive = is_at_work(is_held(&file), holder.as_ref().map(|holder| &*holder.host), host(), silence_s);
    is_alive.then_some(Sign { holder, age_s, silence_s })
}

/// Whether the process that wrote to a lock is alive, as far as the lock tells. Where there are no locks, or none
/// between machines, its last heartbeat decides; where even that is unknown, it is taken to be alive.
fn is_at_work(is_held: Option<bool>, holder: Option<&str>, here: &str, silence_s: Option<f64>) -> bool {
    match (is_held, holder) {
        (Some(true), _) => true,
        // A lock that is free here tells enough of processes here. One without a name was left before it was signed.
        (Some(false), None) => false,
        (Some(false), Some(host)) if host == here => false,
        (Some(false), Some(_)) | (None, _) => silence_s.is_none_or(|silence| silence < SILENCE_S),
    }
}

#[cfg(test)]
mod tests {
    use rstest::rstest;

    use super::*;

    #[test]
    fn a_lock_tells_who_holds_it_until_it_is_dropped() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(".000007.lock");
        let heartbeat = Heartbeat::default();
        assert_eq!(sign(&path, None), None, "there is none");
        let lock = Lock::try_take(&path).expect("a lock").expect("free");
        let beating = heartbeat.of(&lock);
        let sign_now = sign(&path, now_s(folder.path())).expect("alive");
        let holder = sign_now.holder.expect("signed");
        assert_eq!((&*holder.host, holder.process), (host(), std::process::id()));
        // File systems with coarse times and clocks that are set may be off by some.
        assert!(sign_now.silence_s.is_some_and(|s| s < 5.0) && sign_now.age_s.is_some_and(|s| s < 5.0));
        let left = fs::read(&path).expect("a lock");
        drop((beating, lock));
        assert_eq!(sign(&path, None), None, "let go of");
        // As a process leaves it that is killed.
        fs::write(&path, left).expect("written");
        assert_eq!(sign(&path, now_s(folder.path())), None, "nobody holds it");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "probes are gone");
    }

    /// Case: a dead holder's text is longer than that of the next one.
    #[test]
    fn an_earlier_holder_is_overwritten() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("lock");
        fs::write(&path, "x".repeat(1000)).expect("written");
        let lock = Lock::try_take(&path).expect("a lock").expect("free");
        let _beating = Heartbeat::default().of(&lock);
        assert!(sign(&path, None).is_some_and(|sign| sign.holder.is_some()));
    }

    #[rstest]
    #[case::held_here(Some(true), Some("here"), Some(0.0), true)]
    #[case::held_and_silent(Some(true), Some("there"), Some(1e4), true)]
    #[case::held_without_a_name(Some(true), None, None, true)]
    #[case::killed_here(Some(false), Some("here"), Some(0.0), false)]
    #[case::killed_before_it_signed(Some(false), None, Some(0.0), false)]
    #[case::locks_of_each_machine_alone(Some(false), Some("there"), Some(10.0), true)]
    #[case::killed_there(Some(false), Some("there"), Some(31.0), false)]
    #[case::no_locks(None, Some("here"), Some(10.0), true)]
    #[case::no_locks_and_silent(None, Some("here"), Some(31.0), false)]
    #[case::no_locks_and_no_time(None, Some("there"), None, true)]
    fn who_is_at_work(
        #[case] is_held: Option<bool>,
        #[case] holder: Option<&str>,
        #[case] silence_s: Option<f64>,
        #[case] is_alive: bool,
    ) {
        assert_eq!(is_at_work(is_held, holder, "here", silence_s), is_alive);
    }
}
