//! The program and what is written about it: the JSON Schema, the scenes, the book. `docs/run.py` runs all pages.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use boon::{Compiler, Schemas};
use rstest::rstest;
use serde_json::Value;

use crate::folder::Folder;
use crate::room::CAPTURE;

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn page(path: &str) -> String {
    fs::read_to_string(repository().join(path)).expect("a page")
}

/// Faults that the schema finds in a capture file.
fn complaint(capture: &str) -> Option<String> {
    complaint_of("capture", capture)
}

/// Faults that the schema of a kind of file finds in one.
fn complaint_of(kind: &str, file: &str) -> Option<String> {
    let schema = Folder::new([]).succeed(&format!("schema {kind}")).json();
    let mut compiler = Compiler::new();
    compiler.add_resource("schema.json", schema).expect("a new name");
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
    let pages = ["docs/guides/data-sets.md", "docs/tutorials/calibrate-with-opencv.md"].map(page);
    let blocks = pages.iter().flat_map(|text| text.split("```toml").skip(1)).filter_map(|rest| rest.split_once('\n'));
    let examples = blocks.map(|(_, rest)| rest.split("```").next().unwrap_or_default());
    let data_sets: Vec<&str> = examples.filter(|text| text.contains("frames ")).collect();
    assert!(data_sets.len() >= 3);
    for data_set in data_sets {
        assert_eq!(complaint_of("dataset", data_set), None, "{data_set}");
    }
}

/// Data sets that the program refuses for their shape are refused by the schema, too.
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

/// Captures that the program refuses for their shape are refused by the schema, too.
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
fn the_capture_of_the_guide_is_one() {
    let guide = page("docs/guides/capture-file.md");
    let block = guide.split("```toml title=\"everything.toml\"\n").nth(1).and_then(|rest| rest.split("```").next());
    let capture = block.expect("an example");
    assert_eq!(complaint(capture), None);
    // It shows every table but [[lights]].
    for table in
        ["scene", "[targets", "materials.", "camera", "lens", "sensor", "exposure", "output", "develop", "render"]
    {
        assert!(capture.contains(&format!("[{table}")), "{table}");
    }
    // Each key behind a comment's "or" is one, too: `# or autofocus_px = [320, 240]`.
    let schema = Folder::new([]).succeed("schema").stdout;
    let alternatives = capture.lines().filter_map(|line| line.split_once("# or ")).map(|(_, alternative)| alternative);
    for key in alternatives.flat_map(|text| text.split([' ', '{', ',', '"'])).filter(|word| word.contains('_')) {
        assert!(schema.contains(&format!("\"{key}\": {{")), "{key} is not a key");
    }
}

#[test]
fn the_files_of_the_first_image_appear() {
    let tutorial = page("docs/tutorials/first-picture.md");
    let rows = tutorial.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next());
    let named: BTreeSet<&str> = rows.filter(|name| name.contains('.') && !name.contains(' ')).collect();
    let folder = crate::room::room("[render]\nsamples_per_pixel = 1");
    folder.succeed("render capture.toml -o out");
    let results = folder.results("out");
    assert_eq!(named, results.keys().map(String::as_str).collect());
}
