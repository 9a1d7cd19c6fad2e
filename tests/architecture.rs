//! Rules of the structure that Cargo does not enforce: within a crate no files that depend on each other in a circle, only
//! the modules named for it touch files of the disk, and nothing but the command prints. Which crate may see which
//! stands in the manifests.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Crates, or modules of them, that may touch files of the disk. All others get bytes or values.
const WITH_FILES: &[&str] = &[
    "src",
    "crates/photosite-capture/src",
    "crates/photosite-cli/src",
    "crates/photosite-dataset/src",
    "crates/photosite-files/src",
    "crates/photosite-pipeline/src",
    "crates/photosite-view/src",
    "crates/photosite-core/src/input.rs",
    "crates/photosite-core/src/memory",
    "crates/photosite-core/src/sandbox.rs",
    "crates/photosite-core/src/output.rs",
    "crates/photosite-core/src/cleanup.rs",
    "crates/photosite-core/src/fail_point.rs",
    "crates/photosite-raw/src",
    "crates/photosite-scene-io/src",
];

/// Files of code that may open files of the disk otherwise than by `photosite_core::input`, which keeps to the sandbox.
const WITHOUT_SANDBOX: &[&str] = &[
    "crates/photosite-core/src/input.rs",
    // What the kernel tells
    "crates/photosite-core/src/memory/system.rs",
    // Results, which are put in place by their names, and locks, whose content nobody reads
    "crates/photosite-core/src/output.rs",
    "crates/photosite-files/src/lock.rs",
    "crates/photosite-files/src/unfinished.rs",
    // What the program itself keeps, in a folder of the user
    "crates/photosite-pipeline/src/cache.rs",
    // Patterns, which follow links themselves, and ask the sandbox at each
    "crates/photosite-dataset/src/file_pattern.rs",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The source folders of all crates.
fn crates() -> Vec<PathBuf> {
    let folders = fs::read_dir(root().join("crates")).expect("a readable folder");
    let mut all: Vec<_> = folders.map(|entry| entry.expect("a readable entry").path().join("src")).collect();
    all.push(root().join("src"));
    all.sort();
    all
}

/// Every source file below a folder, but for unit tests in files of their own.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a readable folder") {
            let path = entry.expect("a readable entry").path();
            let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            if stem.ends_with("tests") {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// The code of a file without comments and without its unit tests, which may use what they like.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("a readable source file");
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let is_code = |line: &&str| !line.trim_start().starts_with("//");
    text.lines().filter(is_code).collect::<Vec<_>>().join("\n")
}

/// `a::{b, c::{d, e}}` as a::b, a::c::d, a::c::e; `x as y` as x.
fn paths(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some(open) = tree.find('{') else {
        let name = tree.split(" as ").next().unwrap_or_default().trim();
        return if name.is_empty() { Vec::new() } else { vec![name.to_owned()] };
    };
    let (head, inner) = (&tree[..open], tree[open + 1..].trim_end().trim_end_matches('}'));
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    // The last brace closed the tree itself; those of its parts are balanced again by this.
    let inner = format!("{inner}{}", "}".repeat(inner.matches('{').count() - inner.matches('}').count()));
    for (at, c) in inner.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(inner[start..at].to_owned());
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(inner[start..].to_owned());
    parts.iter().flat_map(|part| paths(part)).map(|path| format!("{head}{path}")).collect()
}

/// The `use` declarations of some code: whether it is a re-export, and its paths.
fn uses(code: &str) -> Vec<(bool, Vec<String>)> {
    let mut found = Vec::new();
    for statement in code.split(';') {
        let line_start = statement.rfind("use ").filter(|&at| {
            let before = statement[..at].rsplit('\n').next().unwrap_or_default().trim();
            before.is_empty() || before == "pub" || (before.starts_with("pub(") && before.ends_with(')'))
        });
        let Some(at) = line_start else { continue };
        let is_export = statement[..at].rsplit('\n').next().unwrap_or_default().trim().starts_with("pub");
        found.push((is_export, paths(&statement[at + "use ".len()..])));
    }
    found
}

/// Some code in which `pub(in a::b)` is `pub`: who may see an item is no use of a module.
fn without_visibility(code: &str) -> String {
    let mut parts = code.split("pub(in ");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |kept, part| kept + "pub" + part.split_once(')').map_or("", |(_, rest)| rest))
}

/// Some code without its `use` and `mod` declarations.
fn body(code: &str) -> String {
    let mut lines = code.lines();
    let mut kept = String::new();
    while let Some(line) = lines.next() {
        let item = line.trim_start();
        let visibility = if item.starts_with("pub(") { item.find(") ").map_or(0, |at| at + 2) } else { 0 };
        let item = item[visibility..].trim_start_matches("pub ");
        let is_declaration = item.starts_with("use ") || item.starts_with("mod ") && item.ends_with(';');
        if !is_declaration {
            kept.push_str(line);
            kept.push('\n');
        } else if !line.ends_with(';') {
            // A declaration of several lines
            lines.find(|line| line.ends_with(';'));
        }
    }
    kept
}

/// The module that a file is.
fn module(folder: &Path, path: &Path) -> Vec<String> {
    let path = path.strip_prefix(folder).expect("below the folder").with_extension("");
    let mut names: Vec<String> = path.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    if names.last().is_some_and(|last| ["mod", "lib"].contains(&last.as_str())) {
        names.pop();
    }
    names
}

/// Files of one crate, by their modules, and what each uses of the others.
struct Graph {
    files: BTreeMap<Vec<String>, PathBuf>,
    /// Re-exports of a module: names with the paths that they stand for.
    exports: BTreeMap<Vec<String>, BTreeMap<String, Vec<String>>>,
}

impl Graph {
    fn new(folder: &Path) -> Self {
        let files: BTreeMap<_, _> = sources(folder).into_iter().map(|path| (module(folder, &path), path)).collect();
        let mut exports: BTreeMap<Vec<String>, BTreeMap<String, Vec<String>>> = BTreeMap::new();
        for (module, path) in &files {
            for path in uses(&code(path)).into_iter().filter(|(is_export, _)| *is_export).flat_map(|(_, paths)| paths) {
                let whole = absolute(module, &path, &files);
                let name = whole.last().cloned().unwrap_or_default();
                exports.entry(module.clone()).or_default().insert(name, whole);
            }
        }
        Self { files, exports }
    }

    /// The module whose file defines what a path leads to.
    fn home(&self, path: &[String], depth: usize) -> Option<Vec<String>> {
        let longest = (0..=path.len()).rev().map(|n| &path[..n]).find(|part| self.files.contains_key(*part))?;
        let next = path.get(longest.len());
        let exported = next.and_then(|name| self.exports.get(longest)?.get(name));
        match exported {
            Some(whole) if depth < 8 && whole != path => {
                let rest = path[longest.len() + 1..].iter().cloned();
                self.home(&whole.iter().cloned().chain(rest).collect::<Vec<_>>(), depth + 1)
            }
            Some(_) | None => Some(longest.to_vec()),
        }
    }

    /// Other files that a module's file uses.
    fn used(&self, module: &[String]) -> BTreeSet<Vec<String>> {
        let code = without_visibility(&code(&self.files[module]));
        let (exported, declared): (Vec<_>, Vec<_>) = uses(&code).into_iter().partition(|(is_export, _)| *is_export);
        let all = |declarations: Vec<(bool, Vec<String>)>| declarations.into_iter().flat_map(|(_, paths)| paths);
        let body = body(&code);
        let words: BTreeSet<&str> = body.split(|c: char| !(c.is_alphanumeric() || c == '_')).collect();
        // What a file hands on it may use itself, too.
        let exported = all(exported).filter(|path| words.contains(path.rsplit("::").next().unwrap_or_default()));
        // Paths in the code itself.
        let inline = body.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).map(str::to_owned);
        let inline = inline.filter(|word| word.contains("::") && !word.starts_with("::") && !word.ends_with("::"));
        let found = all(declared).chain(exported).chain(inline).map(|path| absolute(module, &path, &self.files));
        found.filter_map(|path| self.home(&path, 0)).filter(|home| home != module && !home.is_empty()).collect()
    }

    /// Groups of more than one file that all reach each other.
    fn circles(&self) -> Vec<Vec<String>> {
        let direct: BTreeMap<_, _> = self.files.keys().map(|module| (module.clone(), self.used(module))).collect();
        let reached = |from: &Vec<String>| {
            let (mut seen, mut todo) = (BTreeSet::new(), vec![from]);
            while let Some(module) = todo.pop() {
                todo.extend(direct[module].iter().filter(|next| seen.insert((*next).clone())));
            }
            seen
        };
        let all: BTreeMap<_, _> = direct.keys().map(|module| (module.clone(), reached(module))).collect();
        let circle = |module: &Vec<String>| -> Vec<String> {
            let others = all[module].iter().filter(|other| all[*other].contains(module));
            others.map(|other| other.join("::")).collect()
        };
        let found: BTreeSet<_> = all.keys().map(circle).filter(|circle| circle.len() > 1).collect();
        found.into_iter().collect()
    }
}

/// A path from the root of its crate.
fn absolute(module: &[String], path: &str, files: &BTreeMap<Vec<String>, PathBuf>) -> Vec<String> {
    let mut names: Vec<String> = path.split("::").map(str::to_owned).collect();
    let mut base = module.to_vec();
    match names.first().map(String::as_str) {
        Some("crate") => {
            base.clear();
            names.remove(0);
        }
        Some("self") => drop(names.remove(0)),
        Some("super") => {
            while names.first().is_some_and(|name| name == "super") {
                base.pop();
                names.remove(0);
            }
        }
        Some(child) => {
            let own = [base.clone(), vec![child.to_owned()]].concat();
            if !files.contains_key(&own) {
                // Another crate.
                return vec!["".to_owned()];
            }
        }
        None => {}
    }
    [base, names].concat()
}

#[test]
fn no_files_depend_on_each_other_in_a_circle() {
    let circles: Vec<String> = crates()
        .iter()
        .flat_map(|folder| {
            let name = folder.strip_prefix(root()).expect("below the root").display().to_string();
            Graph::new(folder).circles().into_iter().map(move |circle| format!("{name}: {}", circle.join(", ")))
        })
        .collect();
    assert!(circles.is_empty(), "{} circles:\n{}", circles.len(), circles.join("\n"));
}

#[test]
fn only_the_outer_modules_touch_files() {
    let touching = ["std::fs", "fs::", "File::open", "File::create", "std::env", "println!", "eprintln!"];
    for folder in crates() {
        for path in sources(&folder) {
            let name = path.strip_prefix(root()).expect("below the root").display().to_string();
            if WITH_FILES.iter().any(|allowed| name.starts_with(allowed)) {
                continue;
            }
            let code = code(&path);
            for word in touching {
                assert!(!code.contains(word), "{name} must not use {word}");
            }
        }
    }
}

/// Whether a line has a word that begins there.
fn begins_in(line: &str, word: &str) -> bool {
    line.match_indices(word).any(|(at, _)| !line[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_'))
}

/// A file that a folder holds may be a link of a stranger to any other.
#[test]
fn only_one_module_opens_files() {
    let functions = ["read", "read_to_string", "copy", "hard_link", "read_dir", "metadata", "read_link"];
    let functions = functions.map(|name| format!("fs::{name}("));
    let others = ["File::open", "File::options", "OpenOptions", "ImageReader::open", "image::open", "WalkDir::new"];
    let more = ["from_file(", "use std::fs::read", "use std::fs::*", "glob::glob"];
    let words: Vec<&str> = functions.iter().map(String::as_str).chain(others).chain(more).collect();
    let opens = |line: &&str| !line.contains("\"/proc/") && words.iter().any(|word| begins_in(line, word));
    let mut found = Vec::new();
    for path in crates().iter().flat_map(|folder| sources(folder)) {
        let name = path.strip_prefix(root()).expect("below the root").display().to_string();
        if !WITHOUT_SANDBOX.contains(&&*name) {
            found.extend(code(&path).lines().filter(opens).map(|line| format!("{name}: {}", line.trim())));
        }
    }
    assert!(found.is_empty(), "not by photosite_core::input:\n{}", found.join("\n"));
}

/// Where a key stands in brackets behind a value. A map without it, or another value than a table, ends the process.
fn keys_in_brackets(code: &str) -> Vec<&str> {
    let is_value = |before: &str| before.ends_with(|c: char| c.is_alphanumeric() || "_)]?".contains(c));
    let is_key = |after: &str| {
        let name = after.split(']').next().unwrap_or_default();
        let is_constant = name.contains('_') || name.len() > 3;
        let is_text = name.len() > 2 && name.starts_with('"') && name.ends_with('"');
        is_text || name.starts_with('&') || is_constant && name.chars().all(|c| c.is_ascii_uppercase() || c == '_')
    };
    let has_key = |line: &&str| line.match_indices('[').any(|(at, _)| is_value(&line[..at]) && is_key(&line[at + 1..]));
    code.lines().filter(has_key).collect()
}

/// Files that hold schemas of ours, whose keys are those of the code, and a script in which brackets mean something else.
const WITH_KEYS_OF_OURS: &[&str] = &[
    "crates/photosite-capture/src/report/schema.rs",
    "crates/photosite-capture/src/tables",
    "crates/photosite-view/src/controls.rs",
];

/// Text that others wrote, in files or on the network, may lack any key.
#[test]
fn no_key_stands_in_brackets() {
    let mut found = Vec::new();
    let reading = ["capture", "cli", "dataset", "files", "lens", "mitsuba", "pipeline", "py", "scene-io", "view"];
    let reading = reading.map(|name| format!("crates/photosite-{name}/src"));
    for path in reading.iter().flat_map(|folder| sources(&root().join(folder))) {
        let name = path.strip_prefix(root()).expect("below the root").display().to_string();
        if !WITH_KEYS_OF_OURS.iter().any(|allowed| name.starts_with(allowed)) {
            let code = code(&path);
            found.extend(keys_in_brackets(&code).iter().map(|line| format!("{name}: {}", line.trim())));
        }
    }
    assert!(found.is_empty(), "use get, and say what is missing:\n{}", found.join("\n"));
}

#[test]
fn brackets_are_told_apart() {
    let wrong = ["part[\"fingerprint\"]", "keys?[FINGERPRINT].x", "f()[&name]"];
    assert_eq!(keys_in_brackets(&wrong.join("\n")), wrong);
    assert!(
        keys_in_brackets(
            "let a = [\"key\"];\n#[cfg(unix)]\nall[0]\nall[..n]\n(a, [NAME])\nall[XYZ]\nfind(\"all[\").x[0]"
        )
        .is_empty()
    );
}

#[test]
fn only_the_command_line_prints_and_ends_the_process() {
    let all = crates();
    let others = all.iter().filter(|folder| !folder.ends_with("photosite-cli/src") && **folder != root().join("src"));
    for path in others.flat_map(|folder| sources(folder)) {
        let code = code(&path);
        // A planted failure ends the process as a crash would.
        let may_end = path.ends_with("photosite-core/src/fail_point.rs");
        for word in ["println!", "eprintln!", "process::exit"] {
            let is_allowed = may_end && word == "process::exit";
            assert!(is_allowed || !code.contains(word), "{} must not use {word}", path.display());
        }
    }
}

#[test]
fn only_one_file_knows_obvhs() {
    for folder in crates() {
        for path in sources(&folder) {
            let is_accel = path.ends_with("photosite-transport/src/geometry/accel.rs");
            assert!(!code(&path).contains("obvhs::") || is_accel, "{} uses obvhs", path.display());
        }
    }
}

#[test]
fn only_placement_knows_the_rigid_body_engine() {
    for folder in crates().iter().filter(|folder| !folder.ends_with("photosite-placement/src")) {
        for path in sources(folder) {
            let code = code(&path);
            assert!(!code.contains("rapier3d") && !code.contains("parry3d"), "{} uses the engine", path.display());
        }
    }
}

#[test]
fn braces_and_paths_are_told_apart() {
    let found = paths("crate::{Invalid, raw::Cfa, math::{pdf, warp as w}}");
    assert_eq!(found, ["crate::Invalid", "crate::raw::Cfa", "crate::math::pdf", "crate::math::warp"]);
    let code = "use a::b;\npub(super) use c::{d, e};\nlet excuse = 1;";
    assert_eq!(uses(code), [(false, vec!["a::b".to_owned()]), (true, vec!["c::d".to_owned(), "c::e".to_owned()])]);
    assert_eq!(without_visibility("pub(in crate::a) fn b();\npub(in super) c"), "pub fn b();\npub c");
    let code = "pub(crate) mod a;\npub use b::{\n    c,\n    d,\n};\nmod tests {\n    let excuse = used;\n}\n";
    assert_eq!(body(code), "mod tests {\n    let excuse = used;\n}\n");
}
