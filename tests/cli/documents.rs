//! The program and what is written about it: the JSON Schema, the scenes, the README.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use boon::{Compiler, Schemas};
use rstest::rstest;
use serde_json::{Value, json};

use crate::folder::Folder;
use crate::gltf::triangle;
use crate::room::CAPTURE;

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn readme() -> String {
    fs::read_to_string(repository().join("README.md")).expect("README.md")
}

/// What the schema has against a capture file.
fn complaint(capture: &str) -> Option<String> {
    complaint_of("capture", capture)
}

/// What the schema of a kind of file has against one.
fn complaint_of(kind: &str, file: &str) -> Option<String> {
    let schema = Folder::new([]).succeed(&format!("schema {kind}")).stdout;
    let mut compiler = Compiler::new();
    compiler.add_resource("schema.json", serde_json::from_str(&schema).expect("JSON")).expect("a new name");
    let mut schemas = Schemas::new();
    let index = compiler.compile("schema.json", &mut schemas).expect("a valid schema");
    let file: Value = toml::from_str(file).expect("TOML");
    schemas.validate(&file, index).err().map(|error| error.to_string())
}

/// All capture files in `scenes`.
fn captures() -> Vec<PathBuf> {
    let folders =
        fs::read_dir(repository().join("scenes")).expect("scenes").map(|entry| entry.expect("an entry").path());
    let files = folders.filter(|path| path.is_dir()).flat_map(|folder| fs::read_dir(folder).expect("a folder"));
    let files = files.map(|entry| entry.expect("an entry").path());
    files.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect()
}

#[test]
fn the_schemas_are_those_that_are_shipped() {
    for kind in ["capture", "dataset", "sensor", "report", "noise"] {
        let printed = Folder::new([]).succeed(&format!("schema {kind}")).stdout;
        let shipped = fs::read_to_string(repository().join(format!("assets/{kind}.schema.json")));
        assert_eq!(printed, shipped.expect("the schema"), "{kind}");
    }
    let unnamed = Folder::new([]).succeed("schema").stdout;
    assert_eq!(unnamed, Folder::new([]).succeed("schema capture").stdout);
}

#[test]
fn the_data_sets_of_the_documents_fit_their_schema() {
    let of_readme = readme();
    let guide = fs::read_to_string(repository().join("docs/data-sets.md")).expect("docs/data-sets.md");
    let blocks = [&of_readme, &guide].into_iter().flat_map(|text| text.split("```toml\n").skip(1));
    let examples = blocks.map(|rest| rest.split("```").next().unwrap_or_default());
    let data_sets: Vec<&str> = examples.filter(|text| text.contains("[[vary]]")).collect();
    assert!(data_sets.len() >= 2);
    for data_set in data_sets {
        assert_eq!(complaint_of("dataset", data_set), None, "{data_set}");
    }
}

/// What the program refuses of a data set for its shape, its schema refuses too.
#[rstest]
#[case::good("frames = 2\n", true)]
#[case::key("frame = 2\n", false)]
#[case::kind("frames = 'two'\n", false)]
#[case::nested("[[vary]]\nkey = 'exposure.gain_db'\nuniform = [0, 1]\nsweeep = [0, 1]\n", false)]
#[case::too_few("[[vary]]\nkey = 'exposure.gain_db'\nuniform = [0]\n", false)]
#[case::pose("[poses]\nlist = [{ position_m = [0, 0, 1] }]\n", false)]
fn the_schema_of_data_sets_judges_as_the_program_does(#[case] more: &str, #[case] is_good: bool) {
    let data_set = format!("capture = 'board.toml'\n{more}");
    assert_eq!(complaint_of("dataset", &data_set).is_none(), is_good, "{:?}", complaint_of("dataset", &data_set));
    let folder = crate::dataset::folder(more);
    let outcome = folder.run("dataset set.toml -o out");
    assert_eq!(outcome.status == Some(0), is_good, "{}", outcome.stderr);
}

#[test]
fn the_scenes_fit_schema_and_program() {
    let captures = captures();
    assert!(captures.len() >= 5, "{captures:?}");
    for path in captures {
        let text = fs::read_to_string(&path).expect("a capture file");
        assert_eq!(complaint(&text), None, "{}", path.display());
        Folder::new([]).succeed(&format!("info {}", path.display()));
    }
}

/// What the program refuses for its shape, the schema refuses too.
#[rstest]
#[case::good("", true)]
#[case::table("[lense]\n", false)]
#[case::key("[output]\nraws = ['dng']\n", false)]
#[case::kind("[output]\nelectrons = 'yes'\n", false)]
#[case::variant("[output]\nraw = ['dgn']\n", false)]
#[case::too_many("[output]\nirradiance = { bands_nm = [400, 700, 10, 1] }\n", false)]
#[case::too_few("[output]\nirradiance = { bands_nm = [400, 700] }\n", false)]
#[case::material("[materials.floor]\ntype = 'diffuse'\nroughness = 1\n", false)]
#[case::material_without("[materials.floor]\ntype = 'diffuse'\n", false)]
#[case::kept("[materials.floor]\ndouble_sided = true\n", true)]
#[case::light("[[lights]]\ntype = 'point'\nposition_m = [0, 0, 0]\nintensity_cd = 1\nouter_angle_deg = 3\n", false)]
#[case::sensor("[sensor.noise]\nread_noise_e = 2\n", true)]
#[case::sensor_key("[sensor.noise]\nread_noise = 2\n", false)]
fn the_schema_judges_as_the_program_does(#[case] more: &str, #[case] is_good: bool) {
    // Without the tables that the cases write anew.
    let head = CAPTURE.split("[lens]").next().expect("a beginning");
    let capture = format!("{head}\n{more}");
    assert_eq!(complaint(&capture).is_none(), is_good, "{:?}", complaint(&capture));
    let folder = crate::room::room("");
    folder.add("capture.toml", &capture);
    let outcome = folder.run("info capture.toml");
    assert_eq!(outcome.status == Some(0), is_good, "{}", outcome.stderr);
}

#[test]
fn the_capture_of_the_readme_is_one() {
    let readme = readme();
    let capture = readme.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    assert_eq!(complaint(capture), None);
    let room = triangle().with("/materials/0/name", json!("wall"));
    let folder = Folder::new([
        ("room.glb", room.binary()),
        ("vase.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl vase\nf 1 2 3\n".to_vec()),
        ("capture.toml", capture.into()),
    ]);
    let facts: Value = serde_json::from_str(&folder.succeed("info capture.toml --json").stdout).expect("JSON");
    assert_eq!(facts["materials"], json!(["wall", "vase", "chessboard-white", "chessboard-black", "ground"]));
    // The example shows every table but [output] and [[lights]].
    for table in ["scene", "materials.", "camera", "lens", "sensor", "exposure", "render"] {
        assert!(capture.contains(&format!("[{table}")), "{table}");
    }
    // Each key behind a comment's "or" is one, too: `# or autofocus_px = [320, 240]`.
    let schema = folder.succeed("schema").stdout;
    let alternatives = capture.lines().filter_map(|line| line.split_once("# or ")).map(|(_, alternative)| alternative);
    for key in alternatives.flat_map(|text| text.split([' ', '{', ',', '"'])).filter(|word| word.contains('_')) {
        assert!(schema.contains(&format!("\"{key}\": {{")), "{key} is no key");
    }
}

#[test]
fn the_commands_and_options_of_the_readme_exist() {
    let readme = readme();
    let rows: Vec<&str> = readme.lines().filter(|line| line.starts_with("| `photosite ")).collect();
    let commands: BTreeSet<&str> = rows.iter().filter_map(|row| row.split([' ', '`']).nth(3)).collect();
    let folder = Folder::new([]);
    let help = folder.succeed("--help").stdout;
    let listed = help.split("Commands:").nth(1).expect("commands").lines().skip(1).take_while(|line| !line.is_empty());
    // What a command does may go on in the next line, farther to the right.
    let names = listed.filter(|line| line.len() - line.trim_start().len() == 2);
    let listed: BTreeSet<&str> =
        names.filter_map(|line| line.split_whitespace().next()).filter(|c| *c != "help").collect();
    assert_eq!(commands, listed);
    for row in rows {
        // With a command of its own, as `noise add`: names are not capitals, dots or options.
        let is_name = |word: &&str| word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-');
        let named = row.split('`').nth(1).expect("a command").split(' ').skip(1);
        let command = named.take_while(|word| is_name(word) && !word.starts_with('-')).collect::<Vec<_>>().join(" ");
        let help = folder.succeed(&format!("{command} --help")).stdout;
        for option in row.split(['`', ' ']).filter(|word| word.starts_with('-')) {
            assert!(help.contains(option), "{command} has no {option}");
        }
    }
}

#[test]
fn the_files_of_the_readme_appear() {
    let readme = readme();
    let rows = readme.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next());
    let named: BTreeSet<&str> = rows.filter(|name| name.contains('.') && !name.contains(' ')).collect();
    let folder = crate::room::room("[render]\nsamples_per_pixel = 1");
    folder.succeed("render capture.toml -o out");
    let results = folder.results("out");
    assert_eq!(named, results.keys().map(String::as_str).collect());
}
