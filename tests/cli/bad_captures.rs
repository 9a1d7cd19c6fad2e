//! Capture files that cannot be used. Each kind of message has its own test beside the reader; here are those that the
//! whole way to a render is checked with, and two that are followed to the user's screen.

use rstest::rstest;

use crate::folder::Folder;
use crate::room::encoded;

/// Line 4 begins what the cases add.
pub(crate) const HEAD: &str =
    "[scene]\ngeometry = ['room.obj']\nenvironment = { illuminant = 'D65', illuminance_lux = 500 }\n";

pub(crate) fn folder(capture: String) -> Folder {
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl wall\nf 1 2 3\n";
    Folder::new([("room.obj", obj.into()), ("capture.toml", capture.into())])
}

#[rstest]
#[case::syntax("[lens]\nf_number = = 2", 5, "is not valid TOML", "extra `=`")]
#[case::table("[lense]\nf_number = 2", 4, "lense: unknown key `lense`; did you mean `lens`?", "are lens, sensor")]
#[case::key("[lens]\nf_numbre = 2", 5, "unknown key `f_numbre` in [lens]; did you mean `f_number`?", "the keys here")]
#[case::kind("[lens]\nf_number = 'wide'", 5, "lens.f_number: expected a number, found string \"wide\"", "")]
#[case::f_number("[lens]\nf_number = 0", 5, "lens.f_number: must be above 0, got 0", "for example f_number = 2.8")]
#[case::focus(
    "[lens]\nfocal_length_mm = 50\nfocus_distance_m = 0.04",
    6,
    "lens.focus_distance_m: 0.04 m does not lie beyond the focal length of 0.05 m",
    "write a larger distance or \"infinity\""
)]
#[case::preset(
    "[sensor]\npreset = 'sony-imx294-mono'",
    5,
    "no sensor \"sony-imx294-mono\"; did you mean `sony-imx249-mono`?",
    "known names are sony-imx249-mono, sony-imx250-mono"
)]
#[case::quantum_efficiency(
    "[sensor.channels.R]\nquantum_efficiency = 1.3",
    5,
    "sensor.channels.R.quantum_efficiency: must lie between 0 and 1, but is 1.3 at 300 nm",
    "give a fraction, not a percentage"
)]
#[case::material_type(
    "[materials.wall]\ntype = 'difuse'",
    5,
    "materials.wall.type: unknown value \"difuse\"; did you mean `diffuse`?",
    "write one of \"diffuse\", \"conductor\", \"dielectric\", \"metallic-roughness\", \"oren-nayar\", \"plastic\""
)]
#[case::material_name(
    "[materials.wal]\ntype = 'diffuse'\nreflectance = 0.5",
    4,
    "materials.wal: the geometry has no material \"wal\"; did you mean `wall`?",
    "its materials are wall"
)]
#[case::texture(
    "[materials.wall]\ntype = 'diffuse'\nreflectance = { texture = 'wood.png' }",
    6,
    "materials.wall.reflectance.texture: cannot read wood.png",
    "put the image there, or correct its name"
)]
fn errors_name_file_key_and_line(#[case] more: &str, #[case] line: usize, #[case] message: &str, #[case] help: &str) {
    folder(format!("{HEAD}{more}\n")).refuse("capture.toml", &[&format!("capture.toml:{line}: "), message, help]);
}

#[rstest]
fn commands_print_them(#[values("render", "info")] command: &str) {
    let folder = folder(format!("{HEAD}[lens]\nf_number = 0\n"));
    let wanted = ["capture.toml:5: lens.f_number: must be above 0, got 0", "for example f_number = 2.8"];
    folder.fail(&format!("{command} capture.toml"), 1, &wanted);
}

#[rstest]
#[case::missing("room.obj", "rom.obj", 2, "scene.geometry[0]: there is no file rom.obj", "relative to the capture")]
#[case::kind(
    "room.obj",
    "capture.toml",
    2,
    "capture.toml is not a scene of a known kind",
    ".gltf, .glb, .obj, .ply and .stl"
)]
#[case::illuminant("D65", "D66X", 3, "there is no illuminant \"D66X\"; did you mean `D65`?", "blackbodies as 3000K")]
#[case::too_bright("500", "1e300", 1, "scene: its size or its lights are too large to compute with", "meters_per_unit")]
fn errors_of_the_scene_name_file_key_and_line(
    #[case] from: &str,
    #[case] to: &str,
    #[case] line: usize,
    #[case] message: &str,
    #[case] help: &str,
) {
    folder(HEAD.replace(from, to)).refuse("capture.toml", &[&format!("capture.toml:{line}: "), message, help]);
}

#[test]
fn an_empty_capture_is_told_what_is_missing() {
    folder(String::new()).refuse("capture.toml", &["capture.toml: camera: there is none", "write [camera]"]);
}

/// Curves: what is wrong, what the message says of the file and what it advises.
#[rstest]
#[case::word("400,0.5\n500,half\n", "curve.csv: line 2: \"half\" is not a finite number", "as in `550,0.18`")]
#[case::order("500,0.5\n400,0.5\n", "curve.csv: line 2: wavelength 400 nm does not come after 500", "sort the rows")]
#[case::empty("", "curve.csv: holds no rows of numbers", "write rows of a wavelength")]
#[case::single("500\n", "curve.csv: line 1: \"500\" is a single column", "write rows")]
#[case::percent("400,20\n500,80\n", "must lie between 0 and 1, but is 20 at", "not percentages")]
fn errors_of_curves_name_their_file_and_line(#[case] csv: &str, #[case] message: &str, #[case] help: &str) {
    let folder =
        folder(format!("{HEAD}[materials.wall]\ntype = 'diffuse'\nreflectance = {{ file = 'data/curve.csv' }}"));
    folder.add("data/curve.csv", csv);
    folder.refuse("capture.toml", &["capture.toml:6: materials.wall.reflectance: ", message, help]);
}

#[rstest]
#[case::missing(None, "cannot read sky.hdr", "relative")]
#[case::cut(
    Some("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\nab"),
    "sky.hdr: cannot decode its scanlines: the file ends too early",
    ".exr"
)]
#[case::other(
    Some("no image"),
    "sky.hdr: is neither Radiance HDR, which begins with #?RADIANCE, nor OpenEXR: it begins with \"no image\"",
    ".exr"
)]
fn broken_environments_are_refused(#[case] sky: Option<&str>, #[case] message: &str, #[case] help: &str) {
    let folder = folder(HEAD.replace("illuminant = 'D65'", "image = 'sky.hdr'"));
    if let Some(sky) = sky {
        folder.add("sky.hdr", sky);
    }
    folder.refuse("capture.toml", &["capture.toml:3: scene.environment.image: ", message, help]);
}

#[test]
fn environments_of_few_bits_are_refused() {
    let folder = folder(HEAD.replace("illuminant = 'D65'", "image = 'sky.png'"));
    folder.add("sky.png", encoded(&image::RgbImage::new(2, 1).into(), image::ImageFormat::Png));
    folder.refuse("capture.toml", &["capture.toml:3: ", "sky.png: is neither Radiance HDR", ".hdr"]);
}

#[test]
fn errors_of_a_sensor_file_name_that_file() {
    let folder = folder(format!("{HEAD}[sensor]\npreset = 'mine.toml'\n"));
    let preset = include_str!("../../crates/photosite-sensor/assets/sensors/sony-imx249-mono.toml");
    folder.add("mine.toml", preset.replace("full_well_e", "full_wel_e"));
    let line = preset.lines().position(|line| line.starts_with("full_well_e =")).expect("the key") + 1;
    folder.refuse("capture.toml", &[&format!("mine.toml:{line}: "), "did you mean `full_well_e`?"]);
}
