//! Builders say what the same keys say in a file: the same keys of a capture, of which reports and fingerprints
//! are made, the same settings, and the same errors.

use photosite_core::keys::{Changes, Given, below};
use serde_json::Value;

use photosite::Capture;
use photosite::calibration::truth::TruthLayer;
use photosite::keys::*;
use photosite::sensor::Stage;

use super::ranges::{documents, files};
use super::*;

/// Any value, given as builders give theirs.
struct Any<'a>(&'a Value);

impl Given for Any<'_> {
    fn toml(&self) -> String {
        match self.0 {
            Value::Object(_) => self.table().toml(),
            Value::Array(items) => items.iter().map(Any).collect::<Vec<_>>().toml(),
            Value::String(text) => text.toml(),
            Value::Number(number) => number.as_f64().expect("a number").toml(),
            Value::Bool(_) | Value::Null => self.0.to_string(),
        }
    }

    fn lay_over(&self, key: &str, changes: &mut Changes) {
        match self.0 {
            Value::Object(_) => self.table().lay_over(key, changes),
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Array(_) => {
                changes.set(key, &self.toml());
            }
        }
    }
}

impl Any<'_> {
    fn table(&self) -> Changes {
        let mut changes = Changes::default();
        for (key, value) in self.0.as_object().expect("a table") {
            let name = below("", key);
            Any(value).lay_over(name.trim_start_matches('.'), &mut changes);
        }
        changes
    }
}

/// Whole numbers as whole numbers, which is how builders write them.
fn whole(value: &mut Value) {
    match value {
        Value::Number(number) => {
            let number = number.as_f64().expect("a number");
            *value = serde_json::from_str(&number.toml()).expect("a number");
        }
        Value::Array(items) => items.iter_mut().for_each(whole),
        Value::Object(table) => table.values_mut().for_each(whole),
        Value::String(_) | Value::Bool(_) | Value::Null => {}
    }
}

/// The documents have every key of the schema with a range, and most of the others.
#[test]
fn all_keys_say_the_same_in_builders_and_in_files() {
    let files = files();
    let folder = files.0.path();
    for (name, mut document) in documents("capture-") {
        whole(&mut document);
        let text = toml::to_string(&document).expect("TOML");
        let of_file = Capture::parse(&text, folder, &[]).unwrap_or_else(|error| panic!("{name}: {error}"));
        let built =
            Capture::parse("", folder, &Any(&document).table()).unwrap_or_else(|error| panic!("{name}: {error}"));
        // The order of keys is that in which they are given.
        let keys = |capture: &Capture| capture.to_json(folder).expect("keys");
        assert_eq!(keys(&built), keys(&of_file), "{name}");
        assert_eq!(format!("{:?}", built.render()), format!("{:?}", of_file.render()), "{name}");
    }
}

#[test]
fn setters_of_all_shapes_have_the_names_of_their_keys() {
    let files = Files::new("");
    let built = Capture::builder()
        .scene(
            SceneKeys::new()
                .geometry(["room.obj"])
                .up(UpAxis::Y)
                .ground(GroundKeys::new().height_m(-1.0).reflectance([0.5, 0.4, 0.3]))
                .environment(EnvironmentKeys::new().illuminant("D65").illuminance_lux(500.0))
                .spheres([SphereKeys::new().material("ball.glass").position_m([0.0; 3]).radius_m(0.1)]),
        )
        .lights([PointKeys::new().position_m([0.0, 2.0, 0.0]).intensity_cd(1.5)])
        .targets([TargetKeys::from(ChessboardKeys::new().square_mm(20.0)).position_m([0.0, 0.0, 1.0])])
        .materials("ball.glass", DielectricKeys::new().index(1.5))
        .materials("wall", KeptKeys::new().base_colour("colour-checker/15-red"))
        .camera(CameraKeys::new().position_m([0.0, 1.0, 9.0]).look_at_m([0.0; 3]))
        .lens(
            LensKeys::new()
                .kind(LensType::Thin)
                .focus_distance_m("infinity")
                .psf(PointSpreadKeys::gaussian().sigma_um(1.0)),
        )
        .sensor(SensorKeys::new().preset("generic-cmos-color").noise(NoiseKeys::new().read_noise_e(3.0)))
        .exposure(ExposureKeys::new().time_s(0.01).stages_off([Stage::ReadNoise]))
        .render(RenderKeys::new().samples_per_pixel(4).seed(7))
        .develop(DevelopKeys::new().bits(16))
        .output(OutputKeys::new().raw([RawFormat::Tiff]).truth([TruthLayer::Depth]))
        .build(files.0.path())
        .expect("a capture");
    let of_file = "
        [scene]
        geometry = ['room.obj']
        up = 'y'
        ground = { height_m = -1, reflectance = [0.5, 0.4, 0.3] }
        environment = { illuminant = 'D65', illuminance_lux = 500 }
        spheres = [{ material = 'ball.glass', position_m = [0, 0, 0], radius_m = 0.1 }]
        [[lights]]
        type = 'point'
        position_m = [0, 2, 0]
        intensity_cd = 1.5
        [[targets]]
        type = 'chessboard'
        square_mm = 20
        position_m = [0, 0, 1]
        [materials]
        'ball.glass' = { type = 'dielectric', index = 1.5 }
        wall = { base_colour = 'colour-checker/15-red' }
        [camera]
        position_m = [0, 1, 9]
        look_at_m = [0, 0, 0]
        [lens]
        type = 'thin'
        focus_distance_m = 'infinity'
        psf = { kind = 'gaussian', sigma_um = 1 }
        [sensor]
        preset = 'generic-cmos-color'
        noise = { read_noise_e = 3 }
        [exposure]
        time_s = 0.01
        stages_off = ['read-noise']
        [render]
        samples_per_pixel = 4
        seed = 7
        [develop]
        bits = 16
        [output]
        raw = ['tiff']
        truth = ['depth']";
    let of_file = Capture::parse(of_file, files.0.path(), &[]).expect("a capture");
    let keys =
        |capture: &Capture| serde_json::to_string(&capture.to_json(files.0.path()).expect("keys")).expect("JSON");
    assert_eq!(keys(&built), keys(&of_file));
    let changes = Capture::builder().lens(LensKeys::new().f_number(2.0)).sensor(SensorKeys::new().without(["filter"]));
    let text = ["lens.f_number=2".to_owned(), "sensor.without=[\"filter\"]".to_owned()];
    assert_eq!(*changes, text);
    assert_eq!(keys(&built.with(&changes).expect("changed")), keys(&of_file.with(&text).expect("changed")));
}

#[test]
fn what_cannot_be_is_refused_by_its_key() {
    let of_file = capture(&room(""));
    for (built, text) in [
        (Capture::builder().exposure(ExposureKeys::new().time_s(-1.0)), "exposure.time_s=-1"),
        (Capture::builder().exposure(ExposureKeys::new().time_s(f64::NAN)), "exposure.time_s=nan"),
        (Capture::builder().lens(LensKeys::new().f_number(f64::INFINITY)), "lens.f_number=inf"),
        (Capture::builder().render(RenderKeys::new().splitting(300)), "render.splitting=300"),
        (
            Capture::builder().sensor(SensorKeys::new().charge(ChargeKeys::new().full_well_e(-5.0))),
            "sensor.charge.full_well_e=-5",
        ),
    ] {
        let [built, text] = [of_file.with(&built), of_file.with(&[text.to_owned()])]
            .map(|changed| changed.expect_err("refused").to_string());
        assert_eq!(built, text);
    }
}
