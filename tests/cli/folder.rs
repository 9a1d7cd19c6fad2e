//! A folder of input files, and runs of `photosite` in it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use miette::Diagnostic;
use photosite::image::Estimate;
use photosite::io::electrons::read_electrons;
use photosite::raw::{RawImage, read_dng};
use photosite::{Capture, Options};
use serde_json::Value;
use tempfile::TempDir;

/// A folder of input files that goes away with the test.
pub(crate) struct Folder(TempDir);

/// Output and status of a run of the command.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) status: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Folder {
    pub(crate) fn new<'a>(files: impl IntoIterator<Item = (&'a str, Vec<u8>)>) -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        for (name, bytes) in files {
            folder.add(name, bytes);
        }
        folder
    }

    pub(crate) fn add(&self, name: &str, bytes: impl AsRef<[u8]>) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("inside the folder")).expect("made");
        fs::write(path, bytes).expect("written");
    }

    /// Replaces a text in a file.
    pub(crate) fn change(&self, name: &str, from: &str, to: &str) {
        self.add(name, self.text(name).replace(from, to));
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The command with its arguments, which are separated by blanks, in this folder.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_photosite"));
        command.current_dir(self.0.path()).args(arguments.split_whitespace()).stdin(Stdio::null());
        // What other tests have worked out tells nothing here.
        command.env("PHOTOSITE_CACHE", "off");
        command
    }

    /// The command, which ends as if it had been killed when it reaches a fail point for the `count`-th time; whether
    /// it did.
    pub(crate) fn killed_at(&self, point: &str, count: u32, arguments: &str) -> bool {
        let mut command = self.command(arguments);
        let output = command.env("PHOTOSITE_FAIL_POINT", format!("{point}:{count}")).output().expect("the binary runs");
        match output.status.code() {
            Some(0) => false,
            Some(137) => true,
            _ => panic!("{arguments} at {point}:{count}: {}", String::from_utf8_lossy(&output.stderr)),
        }
    }

    pub(crate) fn run(&self, arguments: &str) -> Outcome {
        let output = self.command(arguments).output().expect("the binary runs");
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        Outcome { status: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }

    /// Runs a command that must succeed.
    pub(crate) fn succeed(&self, arguments: &str) -> Outcome {
        let outcome = self.run(arguments);
        assert_eq!(outcome.status, Some(0), "{arguments}: {}", outcome.stderr);
        outcome
    }

    /// Runs a command that must fail with one error that contains all of `wanted`, whatever lines it is broken into,
    /// and must leave nothing behind.
    pub(crate) fn fail(&self, arguments: &str, status: i32, wanted: &[&str]) -> Outcome {
        let mut before = self.contents();
        let outcome = self.run(arguments);
        let after = self.contents();
        // The lock of a process that was killed may go.
        before.retain(|path, _| !path.ends_with(".photosite.lock") || after.contains_key(path));
        assert_eq!(outcome.status, Some(status), "{arguments}: {outcome:?}");
        assert_eq!(outcome.stdout, "", "{arguments}");
        let text = outcome.text();
        let errors = outcome.stderr.lines().filter(|line| line.starts_with("  x ") || line.starts_with("error: "));
        assert_eq!(errors.count(), 1, "one error: {}", outcome.stderr);
        assert!(!text.contains("panicked"), "{}", outcome.stderr);
        for words in wanted {
            assert!(text.contains(words), "{words:?} is missing in: {}", outcome.stderr);
        }
        assert_eq!(after, before, "nothing is left behind");
        outcome
    }

    /// Begins to render a capture in this process, as `photosite render` does, which must fail with an error that contains
    /// all of `wanted`, in message and help, and must leave nothing behind.
    pub(crate) fn refuse(&self, capture: &str, wanted: &[&str]) {
        let before = self.contents();
        let begun = Capture::load(self.path(capture)).and_then(|it| photosite::render(&it, Options::default()));
        let error = begun.map(|_| ()).expect_err(capture);
        let help = error.help().map(|help| help.to_string()).unwrap_or_default();
        // Paths as they are printed in the folder.
        let text = format!("{error} {help}").replace(&format!("{}/", self.0.path().display()), "");
        for words in wanted {
            assert!(text.contains(words), "{words:?} is missing in: {text}");
        }
        assert_eq!(self.contents(), before, "nothing is left behind");
    }

    /// All files and folders below the folder, with the bytes of the files.
    pub(crate) fn contents(&self) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
        fn add(folder: &Path, found: &mut BTreeMap<PathBuf, Option<Vec<u8>>>) {
            for entry in fs::read_dir(folder).expect("a folder") {
                let path = entry.expect("an entry").path();
                if path.is_dir() {
                    add(&path, found);
                }
                found.insert(path.clone(), path.is_file().then(|| fs::read(&path).expect("readable")));
            }
        }
        let mut found = BTreeMap::new();
        add(self.0.path(), &mut found);
        found
    }

    /// Names and bytes of the files in a folder of results.
    pub(crate) fn results(&self, name: &str) -> BTreeMap<String, Vec<u8>> {
        let entries = fs::read_dir(self.path(name)).expect("a folder of results");
        let file = |path: PathBuf| {
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            (name, fs::read(&path).expect("a readable file"))
        };
        entries.map(|entry| file(entry.expect("an entry").path())).collect()
    }

    /// The bytes of a file.
    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect(name)
    }

    /// A file of text.
    pub(crate) fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).expect(name)
    }

    /// A file of JSON.
    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).expect("JSON")
    }

    /// `capture.json` of a folder of results.
    pub(crate) fn report(&self, name: &str) -> Value {
        self.json(&format!("{name}/capture.json"))
    }

    /// `electrons.exr` of a folder of results.
    pub(crate) fn electrons(&self, name: &str) -> Estimate {
        let file = fs::File::open(self.path(name).join("electrons.exr")).expect("electrons.exr");
        read_electrons(std::io::BufReader::new(file)).expect("electrons").0
    }

    /// A DNG file.
    pub(crate) fn raw(&self, name: &str) -> RawImage {
        read_dng(fs::File::open(self.path(name)).expect(name)).expect("a raw image")
    }
}

impl Outcome {
    /// JSON on standard output.
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).expect("JSON")
    }

    /// Text on standard error, in one line of single blanks.
    pub(crate) fn text(&self) -> String {
        self.stderr.split_whitespace().collect::<Vec<_>>().join(" ")
    }
}
