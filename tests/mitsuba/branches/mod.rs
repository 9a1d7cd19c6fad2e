//! What the exporter has to say of captures against the scenes of the suite: Mitsuba renders each feature in a scene of
//! the suite, or it is refused by name; and every refusal has a capture that it is for.

mod cases;
mod features;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use photosite::Capture;
use photosite::io::mitsuba::{Difference, export};
use photosite::pipeline::standalone_camera;
use photosite::scene::description::{Colour, MaterialModel};
use photosite::spectrum::Spectrum;

use cases::{CASES, Case};
use features::{Feature, features};

/// A capture and what the exporter says of it.
struct Described {
    name: String,
    features: BTreeSet<Feature>,
    kinds: BTreeSet<&'static str>,
    said: Vec<String>,
}

impl Described {
    fn new(name: impl Into<String>, capture: &Capture) -> Self {
        let camera = standalone_camera(capture).unwrap_or_else(|error| panic!("{error}"));
        let (kinds, said) = match export(capture, &camera, true) {
            Ok(scene) => {
                let found = &scene.differences;
                (found.iter().map(Difference::kind).collect(), found.iter().map(Difference::to_string).collect())
            }
            Err(refused) => (BTreeSet::new(), vec![refused.to_string()]),
        };
        // Whatever is listed is refused without leave to approximate.
        assert_eq!(export(capture, &camera, false).is_err(), !said.is_empty());
        Self { name: name.into(), features: features(capture), kinds, said }
    }

    fn says(&self, text: &str) -> bool {
        self.said.iter().any(|said| said.contains(text))
    }
}

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(path)
}

fn files_of(folder: &str) -> impl Iterator<Item = PathBuf> {
    let files = std::fs::read_dir(here(folder)).expect("a folder");
    files.map(|file| file.expect("an entry").path())
}

fn loaded(path: &Path, overrides: &[String]) -> Capture {
    Capture::load_with(path, overrides).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn suite() -> Vec<Described> {
    let of_scene =
        |folder: PathBuf| Described::new(folder.display().to_string(), &loaded(&folder.join("capture.toml"), &[]));
    files_of("mitsuba/scenes").map(of_scene).collect()
}

/// Captures beside the suite: the cases, every extension of glTF, and what no file can say.
fn others() -> Vec<Described> {
    let of_case = |case: &Case| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        case.write(folder.path());
        Described::new(case.names, &loaded(&folder.path().join("capture.toml"), &[]))
    };
    let gltf = files_of("gltf").filter(|path| path.extension().is_some_and(|extension| extension == "gltf"));
    let of_gltf = |path: PathBuf| {
        let geometry = format!("scene.geometry=[{:?}]", path.file_name().expect("a file"));
        Described::new(geometry.clone(), &loaded(&here("gltf/capture.toml"), &[geometry]))
    };
    CASES.iter().map(of_case).chain(gltf.map(of_gltf)).chain([spectrum_times_texture()]).collect()
}

fn spectrum_times_texture() -> Described {
    let capture = loaded(&here("mitsuba/scenes/textures/capture.toml"), &[]);
    let mut scene = capture.scene().as_ref().clone();
    for material in &mut scene.materials {
        if let MaterialModel::Diffuse(diffuse) = &mut material.model {
            diffuse.reflectance.colour = Colour::Spectrum(Spectrum::constant(0.5));
        }
    }
    Described::new("a spectrum times a texture", &Capture::of_scene(scene, &Capture::builder()).expect("a capture"))
}

#[test]
fn each_feature_is_in_a_scene_of_the_suite_or_refused_by_name() {
    let (suite, others) = (suite(), others());
    let mut faults = Vec::new();
    for &feature in Feature::ALL {
        let has = |capture: &&Described| capture.features.contains(&feature);
        let Some(text) = feature.said() else {
            let is_rendered = suite.iter().any(|scene| has(&scene));
            faults.extend((!is_rendered).then(|| format!("no scene of the suite has {feature:?}")));
            continue;
        };
        let with = || suite.iter().chain(&others).filter(has);
        faults.extend(with().next().is_none().then(|| format!("no capture has {feature:?}")));
        let silent = with().filter(|capture| !capture.says(text));
        faults.extend(silent.map(|capture| format!("{}: {feature:?} without a word", capture.name)));
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn each_difference_is_found_in_a_capture_and_names_what_it_is_of() {
    let (suite, others) = (suite(), others());
    for (case, found) in CASES.iter().zip(&others) {
        assert!(found.says(case.names), "{}: {:?} does not name {}", case.kind, found.said, case.names);
        assert!(case.kind.is_empty() || found.kinds.contains(case.kind), "{} is not in {:?}", case.kind, found.kinds);
    }
    let found: BTreeSet<&str> = suite.iter().chain(&others).flat_map(|capture| capture.kinds.clone()).collect();
    assert_eq!(found, Difference::KINDS.iter().copied().collect());
}

/// Features that meet in one scene of the suite.
const COMBINATIONS: &[&[Feature]] = &[
    &[Feature::Blend, Feature::OpacityOfTexture, Feature::PointLight],
    &[Feature::Blend, Feature::OpacityOfNumber, Feature::PointLight],
    &[Feature::Blend, Feature::HardSpot],
    &[Feature::Blend, Feature::DirectionalLight],
    &[Feature::Blend, Feature::ConstantEnvironment],
    &[Feature::Mask, Feature::OpacityOfTexture, Feature::PointLight],
    &[Feature::Mask, Feature::DirectionalLight],
    &[Feature::Mask, Feature::Lamp],
    &[Feature::MirroredMesh, Feature::NormalMap],
    &[Feature::MirroredMesh, Feature::SharedMesh],
    &[Feature::Mix, Feature::GroundGlass],
    &[Feature::Mix, Feature::RoughConductor],
    &[Feature::NormalMap, Feature::DirectionalLight],
    &[Feature::Pane, Feature::ConstantEnvironment],
];

#[test]
fn combinations_meet_in_scenes_of_the_suite() {
    let suite = suite();
    for together in COMBINATIONS {
        let has_all = |scene: &Described| together.iter().all(|feature| scene.features.contains(feature));
        assert!(suite.iter().any(has_all), "no scene of the suite has {together:?}");
    }
}
