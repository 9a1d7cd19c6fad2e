//! The dependencies between modules run one way, along the chain from light to picture, and only the modules named for
//! it touch files.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Each module with the modules that it may use besides `error`, `units`, `references` and `sabotage`. A module that is not listed
/// fails the test: new ones take their place in the chain deliberately.
const EDGES: &[(&str, &[&str])] = &[
    ("error", &[]),
    ("units", &[]),
    ("references", &[]),
    ("sabotage", &[]),
    ("math", &[]),
    ("spectrum", &["math"]),
    ("image", &["math"]),
    ("colour", &["math", "spectrum"]),
    ("geometry", &["math"]),
    ("texture", &["math", "spectrum"]),
    ("bsdf", &["math", "spectrum"]),
    ("light", &["math", "spectrum", "geometry", "texture"]),
    ("scene", &["math", "spectrum", "geometry", "texture", "bsdf", "light"]),
    ("projection", &[]),
    ("optics", &["math", "spectrum", "geometry", "projection"]),
    ("film", &["math", "spectrum", "image"]),
    ("sampler", &["math"]),
    ("integrator", &["math", "spectrum", "geometry", "bsdf", "light", "scene", "optics", "film", "sampler"]),
    ("calibration", &["math", "spectrum", "colour", "image", "geometry", "bsdf", "scene", "optics", "sampler"]),
    ("raw", &["math", "spectrum", "colour", "image", "projection"]),
    ("sensor", &["math", "spectrum", "image", "raw"]),
    ("develop", &["math", "spectrum", "colour", "image", "raw"]),
    ("validation", &["math", "image", "raw"]),
    ("measure", &["math", "colour", "image"]),
    ("characterisation", &["math", "spectrum", "image", "raw", "sensor"]),
    (
        "io",
        &[
            "math",
            "spectrum",
            "colour",
            "image",
            "geometry",
            "texture",
            "bsdf",
            "light",
            "scene",
            "optics",
            "film",
            "sampler",
            "integrator",
            "raw",
            "sensor",
            "develop",
            "validation",
            "characterisation",
            "calibration",
        ],
    ),
];

/// Modules that may touch files.
const WITH_FILES: &[&str] = &["io", "raw", "cli", "main"];

/// Every source file below `src`, with the name of its top-level module.
fn sources() -> Vec<(String, PathBuf)> {
    fn walk(folder: &Path, files: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).expect("a readable source folder") {
            let path = entry.expect("a readable entry").path();
            if path.is_dir() {
                walk(&path, files);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    walk(&root, &mut files);
    let module = |path: &Path| {
        let first = path.strip_prefix(&root).expect("below src").components().next().expect("a name");
        Path::new(first.as_os_str()).file_stem().expect("a name").to_string_lossy().into_owned()
    };
    files.into_iter().map(|path| (module(&path), path)).filter(|(name, _)| name != "lib").collect()
}

/// The code of a file without comments and without its unit tests, which may use what they like.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("a readable source file");
    if path.file_stem().is_some_and(|stem| stem.to_string_lossy().ends_with("tests")) {
        return String::new();
    }
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Names that follow `crate::`, alone or in braces.
fn used_modules(code: &str) -> BTreeSet<String> {
    let identifier = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut names = BTreeSet::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        let Some(inner) = rest.strip_prefix('{') else {
            names.insert(identifier(rest));
            continue;
        };
        let mut depth = 0;
        let mut item = String::new();
        for c in inner.chars() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => names.extend([identifier(std::mem::take(&mut item).trim())]),
                _ => {}
            }
            if !(c == ',' && depth == 0) {
                item.push(c);
            }
        }
        names.insert(identifier(item.trim()));
    }
    // Types and macros start with a capital letter or are re-exports of `error`.
    names.into_iter().filter(|n| n.starts_with(|c: char| c.is_lowercase())).collect()
}

#[test]
fn modules_use_only_what_comes_before_them_in_the_chain() {
    let mut wrong = Vec::new();
    for (module, path) in sources().iter().filter(|(module, _)| module != "cli" && module != "main") {
        let Some((_, allowed)) = EDGES.iter().find(|(name, _)| name == module) else {
            wrong.push(format!("{module} has no place in the chain yet"));
            continue;
        };
        for used in used_modules(&code(path)) {
            let always = ["error", "units", "references", "sabotage"].contains(&used.as_str());
            if !always && used != *module && !allowed.contains(&used.as_str()) {
                wrong.push(format!("{} uses {used}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn only_the_outer_modules_touch_files() {
    let touching = ["std::fs", "File::open", "File::create", "std::env", "println!", "eprintln!"];
    for (module, path) in sources().iter().filter(|(module, _)| !WITH_FILES.contains(&module.as_str())) {
        let code = code(path);
        for word in touching {
            assert!(!code.contains(word), "{module} ({}) must not use {word}", path.display());
        }
    }
}

#[test]
fn only_one_file_knows_obvhs() {
    for (_, path) in sources() {
        let (code, name) = (code(&path), path.file_name().expect("a name").to_string_lossy().into_owned());
        assert!(!code.contains("obvhs::") || name == "accel.rs", "{} uses obvhs", path.display());
    }
}

#[test]
fn braces_and_paths_are_told_apart() {
    let used = used_modules("use crate::{Invalid, raw::Cfa, math::{pdf, warp}};\nlet x = crate::film::Film::new();");
    assert_eq!(used.into_iter().collect::<Vec<_>>(), ["film", "math", "raw"]);
}
