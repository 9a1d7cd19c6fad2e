//! `photosite develop`: settings, formats and what goes wrong.

use serde_json::{Value, json};

use crate::folder::Folder;
use crate::room::room;

fn rendered(more: &str) -> Folder {
    let folder = room(&format!("[render]\nsamples_per_pixel = 16\n{more}"));
    // Dark enough that little is white.
    let capture = String::from_utf8(folder.bytes("capture.toml")).expect("UTF-8");
    folder.add("capture.toml", capture.replace("time_s = 0.0002", "time_s = 0.00004"));
    folder.succeed("render capture.toml -o out");
    folder
}

fn report(folder: &Folder, arguments: &str) -> Value {
    folder.succeed(&format!("develop {arguments} --json")).json()
}

#[test]
fn the_same_settings_give_the_image_of_render() {
    for table in ["", "[develop]\ndemosaic = 'bilinear'\nexposure_ev = 1.0\ntone_curve = 'filmic'\n"] {
        let folder = rendered(table);
        folder.succeed("develop out/raw.dng -o again.png --capture capture.toml");
        assert_eq!(folder.bytes("again.png"), folder.bytes("out/image.png"), "{table}");
        let plain = if table.is_empty() { "again.png" } else { "plain.png" };
        folder.succeed(&format!("develop out/raw.dng -o {plain} --force"));
        assert_eq!(folder.bytes(plain) == folder.bytes("out/image.png"), table.is_empty());
    }
}

#[test]
fn every_format_and_setting_can_be_chosen() {
    let folder = rendered("");
    for (i, setting) in [
        "demosaic=nearest",
        "demosaic=malvar",
        "white_balance=grey-world",
        "white_balance=white-patch",
        "highlights=blend",
        "highlights=reconstruct",
        "noise_filter=non-local-means",
        "defects=median",
        "colour_space=rec2020",
        "tone_curve=linear",
        "sharpening=0.5",
        "dither=true",
        "bits=16",
        "colour_matrix=false",
    ]
    .iter()
    .enumerate()
    {
        let image = format!("{i}.png");
        let found = report(&folder, &format!("out/raw.dng -o {image} --set develop.{setting}"));
        let (key, value) = setting.split_once('=').expect("a key and a value");
        let shown = found["settings"][key].to_string();
        assert_eq!(shown.trim_matches('"').trim_end_matches(".0"), value, "{found}");
        assert!(folder.bytes(&image) != folder.bytes("out/image.png"), "{setting}");
    }
    for image in ["a.png", "a.tiff", "a.jpg", "a.ppm", "a.exr"] {
        let found = report(&folder, &format!("out/raw.dng -o {image}"));
        assert_eq!((&found["resolution_px"], &found["demosaic"]), (&json!([32, 24]), &json!("menon")));
    }
    folder.succeed("compare a.tiff a.png");
    let warm = report(
        &folder,
        "out/raw.dng -o warm.png --set develop.white_balance=temperature --set develop.temperature_k=4000",
    );
    // The white of the temperature, through the matrix at that white, and back: the fixed point settles to 1e-6, which
    // reciprocal temperature feels to some 1e-5.
    assert!((warm["temperature_k"].as_f64().expect("known") / 4000.0 - 1.0).abs() < 1e-4, "{warm}");
}

#[test]
fn what_goes_wrong_is_told() {
    let folder = rendered("");
    folder.add("torn.dng", &folder.bytes("out/raw.dng")[..2000]);
    folder.add("notes.txt", b"not a raw file");
    for (arguments, status, wanted) in [
        ("out/raw.dng -o p.gif", 2, &["p.gif", ".png, .tiff, .jpg, .pgm, .ppm, .npy or .exr"][..]),
        ("out/raw.dng -o p.pgm", 2, &["a PGM file holds grey, the image has R, G, B", ".ppm"]),
        ("out/raw.dng -o out/image.png", 2, &["already exists", "--force"]),
        ("out/raw.dng -o nowhere/p.png", 1, &["nowhere: does not exist, or is not a folder"]),
        ("missing.dng", 1, &["missing.dng", "cannot read"]),
        ("torn.dng", 1, &["torn.dng"]),
        ("notes.txt", 1, &["notes.txt", "not a raw file", "DNG"]),
        ("out/raw.dng -o p.png --set develop.demosaic=menan", 1, &["menan", "did you mean", "menon"]),
        ("out/raw.dng -o p.png --set develop.demosaik=menon", 1, &["demosaik", "demosaic"]),
        ("out/raw.dng -o p.png --set demosaic=menon", 2, &["[develop]", "develop.demosaic=menon"]),
        ("out/raw.dng -o p.png --set lens.f_number=4", 2, &["[lens]", "develop."]),
        ("out/raw.dng -o p.png --set develop.demosaic=markesteijn", 1, &["markesteijn", "RGGB"]),
        ("out/raw.dng -o p.png --set develop.temperature_k=5000", 1, &["white_balance = \"temperature\""]),
        ("out/raw.dng -o p.png --set develop.colour_space=xyz", 1, &["colour_space", ".exr"]),
        ("out/raw.dng -o p.jpg --set develop.bits=16", 1, &["bits", "JPEG"]),
        ("out/raw.dng -o p.jpg --set develop.jpeg_quality=101", 1, &["jpeg_quality", "from 1 to 100"]),
        ("out/raw.dng -o p.png --set develop.colour_model=lab", 1, &["colour_model", "L*a*b*", ".npy"]),
        ("out/raw.dng -o p.png --set develop.kernel=[[1,2],[3,4]]", 1, &["develop.kernel", "odd", "2 × 2"]),
        ("out/raw.dng -o p.png --set develop.resize_px=[0,5]", 1, &["resize_px", "65535"]),
        ("out/raw.dng -o p.png --set develop.tone_white=2", 1, &["tone_white", "tone_curve = \"reinhard\""]),
        (
            "out/raw.dng -o p.png --memory 1 --set develop.resize_px=[60000,60000]",
            1,
            &["developing 32 × 24 pixels to 60000 × 60000", "GiB"],
        ),
        ("out/electrons.exr -o p.png", 1, &["electrons.exr", "a quantity in e-", "photosite expose"]),
        (
            "out/raw.dng -o p.png --set develop.white_balance=patch --set develop.patch_px=[30,0,9,9]",
            1,
            &["patch_px", "32 × 24"],
        ),
    ] {
        folder.fail(&format!("develop {arguments}"), status, wanted);
    }
}

#[test]
fn images_take_the_steps_that_are_not_of_raw_files() {
    let folder = rendered("");
    folder.succeed("develop out/raw.dng -o light.exr");
    // The same light, encoded now or then.
    folder.succeed("develop light.exr -o later.png");
    assert!(folder.bytes("later.png") == folder.bytes("out/image.png"));
    // Of codes comes the light that they stand for, and of that the codes.
    folder.succeed("develop later.png -o again.png");
    folder.succeed("compare again.png later.png --max-rmse 0.2");
    let settings = "--set develop.demosaic=malvar --set develop.tone_curve=reinhard --set develop.jpeg_quality=50";
    let found = report(&folder, &format!("light.exr -o shown.png {settings}"));
    let warnings = found["warnings"].as_array().expect("a list");
    let said = |key: &str| {
        warnings.iter().any(|w| w.as_str().expect("text").contains(&format!("develop.{key} does not affect")))
    };
    assert!(warnings.len() == 2 && said("demosaic") && said("jpeg_quality"), "{warnings:?}");
    assert!(folder.bytes("shown.png") != folder.bytes("later.png"));
    let zoomed =
        report(&folder, "light.exr -o zoomed.npy --set develop.digital_zoom=2 --set develop.resize_px=[50,40]");
    assert_eq!(zoomed["resolution_px"], json!([50, 40]));
}

#[test]
fn image_png_is_the_image_of_the_camera_that_the_report_tells() {
    let folder = room("[render]\nsamples_per_pixel = 4\n[develop]\ndigital_zoom = 2.0\nresize_px = [64, 48]\n");
    folder.succeed("render capture.toml -o out");
    let report = folder.report("out");
    let (image, camera) = (&report["image"], &report["camera"]);
    assert_eq!(image["resolution_px"], json!([64, 48]));
    let number = |of: &Value, row: usize, column: usize| of["camera_matrix"][row][column].as_f64().expect("a number");
    // The middle half of 32 × 24 pixels on four times as many: pixels of a quarter, centres kept at the middle.
    assert!((number(image, 0, 0) / number(camera, 0, 0) - 4.0).abs() < 1e-9, "{image}");
    let centre = (number(camera, 0, 2) + 0.5 - 8.0) * 4.0 - 0.5;
    assert!((number(image, 0, 2) - centre).abs() < 1e-9, "{image}");
}

/// A TIFF file of one strip of numbers of 8 bits.
fn tiff8(width: u8, height: u8, samples: u8, numbers: &[u8]) -> Vec<u8> {
    let interpretation = if samples == 3 { 2 } else { 1 };
    let entry = |tag: u16, value: u8| [&tag.to_le_bytes()[..], &[4, 0, 1, 0, 0, 0, value, 0, 0, 0]].concat();
    let strip = 8 + 2 + 9 * 12 + 4;
    let entries = [
        (256, width),
        (257, height),
        (258, 8),
        (259, 1),
        (262, interpretation),
        (273, strip),
        (277, samples),
        (278, height),
        (279, numbers.len() as u8),
    ];
    let entries: Vec<u8> = entries.into_iter().flat_map(|(tag, value)| entry(tag, value)).collect();
    [&b"II*\0\x08\0\0\0\x09\0"[..], &entries, &[0; 4], numbers].concat()
}

#[test]
fn files_of_numbers_of_every_kind_become_linear_light() {
    let folder = Folder::new([]);
    let grey = [0, 51, 102, 153, 204, 255];
    let colour: Vec<u8> = (0..18).map(|i| 15 * i).collect();
    let words = |numbers: &[u8]| numbers.iter().map(u8::to_string).collect::<Vec<_>>().join("\n");
    for (name, file, white, numbers) in [
        ("grey.tif", tiff8(3, 2, 1, &grey), 255.0, &grey[..]),
        ("colour.tiff", tiff8(3, 2, 3, &colour), 255.0, &colour),
        ("binary.pgm", [b"P5\n3 2\n255\n", &grey[..]].concat(), 255.0, &grey),
        ("text.pgm", format!("P2\n# 3 columns\n3 2\n300\n{}\n", words(&grey)).into_bytes(), 300.0, &grey),
        ("binary.ppm", [b"P6 3 2 255\n", &colour[..]].concat(), 255.0, &colour),
        ("text.ppm", format!("P3 3 2 1000 {}", words(&colour)).into_bytes(), 1000.0, &colour),
        ("text.pbm", b"P1\n3 2\n101\n110\n".to_vec(), 1.0, &[0, 1, 0, 0, 0, 1]),
        ("binary.pbm", b"P4 3 2\n\xa0\xc0".to_vec(), 1.0, &[0, 1, 0, 0, 0, 1]),
    ] {
        folder.add(name, file);
        folder.succeed(&format!("develop {name} -o linear.exr --force -q"));
        let file = std::fs::File::open(folder.path("linear.exr")).expect("written");
        let image = photosite::io::exr::read_exr(std::io::BufReader::new(file)).expect("EXR").planes;
        let names = if numbers.len() == 6 { vec!["Y"] } else { vec!["R", "G", "B"] };
        for (i, channel) in names.iter().enumerate() {
            let expected: Vec<f64> =
                numbers.iter().skip(i).step_by(names.len()).map(|&number| f64::from(number) / white).collect();
            let found = image.plane(channel).unwrap_or_else(|| panic!("{name}: {channel}"));
            // 32-bit floats on both sides.
            let off = expected.iter().zip(found).map(|(a, b)| (a - f64::from(*b)).abs()).fold(0.0, f64::max);
            assert!(found.len() == 6 && off < 1e-6, "{name} {channel}: {found:?} instead of {expected:?}");
        }
        folder.succeed(&format!("info {name}"));
        let said = folder.succeed(&format!("develop {name} -o shown.ppm --force")).stderr;
        assert!(said.contains(&format!("{name} holds pixel values alone")) && said.contains("develop.raw"), "{said}");
        let told = folder.succeed(&format!("develop {name} -o shown.ppm --force --set develop.raw.black_level_dn=0"));
        assert!(!told.stderr.contains("pixel values alone"), "{}", told.stderr);
    }
    // Grey goes into a PGM file: P5, its largest number 255 or 65535.
    folder.succeed("develop grey.tif -o shown.pgm -q --set develop.tone_curve=linear");
    assert_eq!(folder.bytes("shown.pgm"), [b"P5\n3 2\n255\n", &grey[..]].concat());
    folder.succeed("develop grey.tif -o deep.pgm -q --set develop.tone_curve=linear --set develop.bits=16");
    assert!(folder.bytes("deep.pgm").starts_with(b"P5\n3 2\n65535\n\0\0\x33\x33"));
    folder.add("cut.tif", &tiff8(3, 2, 1, &grey)[..100]);
    folder.add("cut.pgm", b"P2 3 2 255 1 2 3 4 5");
    for (arguments, status, wanted) in [
        ("colour.tiff -o p.pgm", 2, &["a PGM file holds grey", ".ppm"][..]),
        ("cut.tif", 1, &["cut.tif", "truncated"]),
        ("cut.pgm", 1, &["cut.pgm", "number 6 of 6", "truncated"]),
    ] {
        folder.fail(&format!("develop {arguments}"), status, wanted);
    }
}

#[test]
fn measures_of_images() {
    let folder = rendered("");
    let value = |arguments: &str| -> Value { folder.succeed(&format!("measure {arguments} --json")).json() };
    let histograms = value("histogram out/image.png --bins 16");
    let counts = histograms[0]["counts"].as_array().expect("a list").iter().filter_map(Value::as_u64);
    assert_eq!(counts.sum::<u64>(), 32 * 24);
    let same = value("similarity out/image.png out/image.png");
    assert_eq!((&same["channels"][1]["psnr_db"], &same["mean_delta_e_2000"]), (&Value::Null, &json!(0.0)));
    assert!((same["channels"][0]["ssim"].as_f64().expect("large enough") - 1.0).abs() < 1e-9);
    folder.fail("measure mtf out/image.png --channel W", 2, &["no channel W", "R, G, B"]);
    folder.fail("measure mtf out/image.png --region 1,2,3", 2, &["3 numbers instead of 4"]);
}

/// A grey wall that fills the view of a thin lens, in even light from all sides: every pixel has the radiance ρ·E/π.
const WALL: &str = "\
[scene]
geometry = ['wall.obj']
environment = { illuminant = 'D50', illuminance_lux = 1000 }
[materials.wall]
type = 'diffuse'
reflectance = 0.5
[camera]
position_m = [0, 0, 1]
look_at_m = [0, 0, 0]
[lens]
falloff = 'none'
[sensor]
resolution_px = [48, 32]
[exposure]
time_s = 0.04
[render]
samples_per_pixel = 64
[output]
ideal = true
";

#[test]
fn a_grey_wall_is_as_bright_in_the_ideal_image_as_in_the_developed_one() {
    let wall = "usemtl wall\nv -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n";
    let folder = Folder::new([("wall.obj", wall.into()), ("capture.toml", WALL.into())]);
    folder.succeed("render capture.toml -o out");
    folder.succeed("develop out/raw.dng -o out/developed.exr");
    let mean = |image: &str, channel: usize| {
        let found = folder.succeed(&format!("measure histogram {image} --json")).json();
        (
            found[channel]["mean"].as_f64().expect("a number"),
            found[channel]["standard_deviation"].as_f64().expect("one"),
        )
    };
    for channel in 0..3 {
        let ((developed, noise), (ideal, _)) = (mean("out/developed.exr", channel), mean("out/ideal.exr", channel));
        // White is kept exactly, so that what is left is noise: that of 1536 developed pixels, a quarter of which see
        // the channel, and of light transport, 100 000 paths whose weights differ by about their mean: 0.3 %. Four
        // times both.
        let tolerance = 4.0 * (noise / 384f64.sqrt()).hypot(0.003 * ideal);
        assert!(ideal > 0.05 && (developed - ideal).abs() < tolerance, "{channel}: {developed} {ideal} ± {tolerance}");
    }
    assert!(folder.bytes("out/ideal.png").starts_with(b"\x89PNG"));
}

/// Values that a key of [develop] may have by the schema.
fn values_of(schema: &Value, property: &Value) -> Vec<String> {
    if let Some(reference) = property["$ref"].as_str().or_else(|| property["allOf"][0]["$ref"].as_str()) {
        let path = reference.trim_start_matches('#');
        return values_of(schema, schema.pointer(path).expect("a definition"));
    }
    let listed = |key: &str| property[key].as_array().into_iter().flatten();
    let named: Vec<String> = (listed("oneOf").filter_map(|one| one["const"].as_str()))
        .chain(listed("enum").filter_map(Value::as_str))
        .map(str::to_owned)
        .collect();
    if property["type"] == "boolean" { vec!["true".to_owned(), "false".to_owned()] } else { named }
}

/// Values of the keys that the schema has no list of, with what they go with.
const NUMBERS: [(&str, &str); 38] = [
    ("temperature_k=4000", "white_balance=temperature"),
    ("tint=12.5", "white_balance=temperature temperature_k=5000"),
    ("patch_px=[3,5,20,12]", "white_balance=patch"),
    ("noise_radius_px=2", "noise_filter=median"),
    ("noise_strength=1.5", "noise_filter=bilateral"),
    ("noise_sigma_px=1.5", "noise_filter=gaussian"),
    ("noise_sigma_range=0.1", "noise_filter=bilateral"),
    ("kernel=[[0.0,1.0,0.0],[1.0,-3.0,1.0],[0.0,1.0,0.0]]", ""),
    ("kernel_normalised=true", "kernel=[[1,2,1],[2,4,2],[1,2,1]]"),
    ("kernel_normalised=false", "kernel=[[1,-1,1]]"),
    ("digital_zoom=2.0", ""),
    ("resize_px=[40,20]", ""),
    ("resize_filter=nearest", "resize_px=[40,20]"),
    ("resize_filter=linear", "resize_px=[20,40]"),
    ("resize_filter=cubic", "digital_zoom=1.5"),
    ("resize_filter=lanczos", "resize_px=[10,10]"),
    ("resize_antialias=false", "resize_px=[10,10]"),
    ("resize_antialias=true", "resize_px=[10,10]"),
    ("tone_key=0.36", "tone_curve=reinhard"),
    ("tone_white=2.0", "tone_curve=reinhard"),
    ("tone_bias=0.7", "tone_curve=log"),
    ("tone_contrast=20.0", "tone_curve=local"),
    ("tone_sigma_px=3.0", "tone_curve=local"),
    ("tone_sigma_range=0.3", "tone_curve=local"),
    ("threshold_level=0.25", "threshold=level colour_model=grey"),
    ("jpeg_quality=80", ""),
    ("exposure_ev=-1.5", ""),
    ("gamma=1.8", "tone_curve=gamma"),
    ("sharpening=0.5", ""),
    ("sharpening_radius_px=2.5", "sharpening=1"),
    ("bits=16", ""),
    ("raw.cfa=BGGR", ""),
    ("raw.black_level_dn=70", ""),
    ("raw.white_level_dn=3000", ""),
    ("raw.as_shot_neutral=[0.7,1,0.5]", ""),
    ("raw.colour_matrix_d65=[[0.8,-0.2,-0.1],[-0.4,1.2,0.2],[0,0.1,0.6]]", ""),
    ("white_balance=temperature", "temperature_k=3000 tint=-5"),
    ("white_balance=patch", "patch_px=[0,0,32,24]"),
];

#[test]
fn every_key_and_value_of_the_schema_develops() {
    let folder = rendered("");
    let schema = folder.succeed("schema").json();
    let develop = schema["properties"]["develop"]["$ref"].as_str().expect("a table").trim_start_matches('#');
    let properties = schema.pointer(develop).expect("a definition")["properties"].as_object().expect("keys");
    let mut tried = 0;
    for (key, property) in properties {
        let listed = values_of(&schema, property).into_iter().map(|value| (format!("{key}={value}"), ""));
        let listed = listed.filter(|(setting, _)| !NUMBERS.iter().any(|(with, _)| with == setting));
        let numbers = NUMBERS.iter().filter(|(setting, _)| setting.split(['=', '.']).next() == Some(key));
        let settings: Vec<(String, &str)> = listed.chain(numbers.map(|(s, w)| ((*s).to_owned(), *w))).collect();
        assert!(!settings.is_empty(), "{key} has no value to try");
        for (setting, with) in settings {
            tried += 1;
            let all = with.split_whitespace().chain([&setting[..]]).map(|s| format!(" --set develop.{s}"));
            // Codes cannot hold X and Z of white, nor hues.
            let extension = match &setting[..] {
                "colour_space=xyz" | "colour_model=hsv" => "exr",
                "colour_model=hsl" | "colour_model=hsi" | "colour_model=encoded-grey" => "npy",
                "colour_model=lab" => "tiff",
                "jpeg_quality=80" => "jpg",
                _ => "png",
            };
            let arguments = format!("develop out/raw.dng -o {tried}.{extension} --json{}", all.collect::<String>());
            let outcome = folder.run(&arguments);
            if ["demosaic=markesteijn"].contains(&&setting[..]) {
                assert_eq!(outcome.status, Some(1), "{arguments}: {}", outcome.stderr);
                assert!(outcome.text().contains("develop.demosaic"), "{}", outcome.stderr);
                continue;
            }
            assert_eq!(outcome.status, Some(0), "{arguments}: {}", outcome.stderr);
            let report = outcome.json();
            let (path, value) = setting.split_once('=').expect("a key and a value");
            let shown = report["settings"].pointer(&format!("/{}", path.replace('.', "/"))).expect("the key");
            let same = |text: &str| text.replace(".0", "").trim_matches('"').to_owned();
            assert_eq!(same(&shown.to_string()), same(value), "{arguments}");
            assert!(!folder.bytes(&format!("{tried}.{extension}")).is_empty());
        }
    }
    // A key that has got lost would not be missed above.
    assert!(tried > 50, "{tried}");
}

#[test]
fn files_of_numbers_alone_can_be_told_what_they_are() {
    let folder = rendered("[output]\nraw = ['dng', 'tiff', 'pgm', 'npy', 'exr']\n");
    let raw = folder.raw("out/raw.dng");
    let list = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    let neutral = raw.metadata.as_shot_neutral.clone().expect("a colour sensor");
    let matrix = raw.metadata.colour_matrix_d65().expect("a colour sensor");
    let rows: Vec<String> = matrix.iter().map(|row| format!("[{}]", list(row))).collect();
    let told = format!(
        "--set develop.raw.cfa={} --set develop.raw.black_level_dn={} --set develop.raw.white_level_dn={} --set \
         develop.raw.as_shot_neutral=[{}] --set develop.raw.colour_matrix_d65=[{}]",
        raw.cfa,
        raw.black_level_dn.mean(),
        raw.white_level_dn,
        list(&neutral),
        rows.join(",")
    );
    // The DNG file says more: matrices for another light, the lens.
    let plain = "--set develop.lens_falloff=false --set develop.distortion=false";
    folder.succeed(&format!("develop out/raw.dng -o dng.png {told} {plain}"));
    for kind in ["tiff", "pgm", "npy", "exr"] {
        folder.succeed(&format!("develop out/raw.{kind} -o {kind}.png {told}"));
        assert!(folder.bytes(&format!("{kind}.png")) == folder.bytes("dng.png"), "{kind}");
    }
    for (setting, words) in [
        ("raw.cfa=full:RGB", &["develop.raw.cfa", "3 values per pixel, the file 1"][..]),
        ("raw.cfa=RGBGR", &["develop.raw.cfa", "do not form a square tile"]),
        ("raw.white_level_dn=0", &["develop.raw.white_level_dn", "leave no range"]),
        ("raw.as_shot_neutral=[1,1]", &["develop.raw.as_shot_neutral", "2 entries"]),
        ("raw.cfo=RGGB", &["cfo", "cfa"]),
        ("demosaic=menon", &["develop.demosaic", "does nothing", "mono"]),
    ] {
        folder.fail(&format!("develop out/raw.tiff -o p.png --set develop.{setting}"), 1, words);
    }
}

#[test]
fn a_nonlinear_sensor_develops_with_and_without_its_table() {
    let nonlinear = "[sensor.adc]\ncompanding = { bits = 10, gamma = 2.2 }\n";
    let folder = rendered(nonlinear);
    // Darker, so that little of either is white.
    folder.succeed("develop out/raw.dng -o linear.png --set develop.exposure_ev=-2");
    folder
        .succeed("develop out/raw.dng -o nonlinear.png --set develop.exposure_ev=-2 --set develop.linearisation=false");
    let mean = |image: &str| -> f64 {
        let found = folder.succeed(&format!("measure histogram {image} --json")).json();
        found[1]["mean"].as_f64().expect("a number")
    };
    // A gamma lifts what lies between black and white.
    assert!(mean("nonlinear.png") > 1.1 * mean("linear.png"), "{} {}", mean("nonlinear.png"), mean("linear.png"));
}

#[test]
fn images_are_measured_in_the_colours_that_their_files_say() {
    let wall = "usemtl wall\nv -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n";
    // A colour that sRGB holds, with all its noise.
    let capture = WALL.replace("0.5", "'colour-checker/09-moderate-red'");
    let folder = Folder::new([("wall.obj", wall.into()), ("capture.toml", capture.into())]);
    folder.succeed("render capture.toml -o out");
    for (name, setting) in [
        ("wide.png", "colour_space=rec2020"),
        ("p3.tiff", "colour_space=display-p3"),
        ("gamma.png", "tone_curve=gamma"),
        ("linear.tiff", "tone_curve=linear"),
        ("aces.exr", "colour_space=acescg"),
        ("xyz.exr", "colour_space=xyz"),
        ("plain.exr", "bits=16"),
    ] {
        let bits = if name.ends_with("exr") { "" } else { "--set develop.bits=16" };
        folder.succeed(&format!("develop out/raw.dng -o {name} --set develop.{setting} {bits}"));
    }
    folder.succeed("develop out/raw.dng -o a.png --set develop.bits=16");
    folder.succeed("develop out/raw.dng -o a.jpg");
    folder.succeed("develop out/raw.dng -o a.ppm");
    let difference = |a: &str, b: &str| -> f64 {
        let found = folder.succeed(&format!("measure similarity {a} {b} --json")).json();
        found["mean_delta_e_2000"].as_f64().unwrap_or_else(|| panic!("{a} and {b} have colours: {found}"))
    };
    for (a, b) in [
        ("wide.png", "a.png"),
        ("p3.tiff", "a.png"),
        ("gamma.png", "a.png"),
        ("linear.tiff", "a.png"),
        ("aces.exr", "plain.exr"),
    ] {
        // Codes of 16 bits, and profiles with 16 bits behind the point.
        let found = difference(a, b);
        assert!(found < 0.3, "{a}: {found}");
    }
    // JPEG halves the resolution of colours; the image is small.
    let found = difference("a.jpg", "a.ppm");
    assert!(found < 5.0, "{found}");
    let numbers = folder.succeed("measure similarity out/electrons.exr out/electrons.exr --json").stdout;
    assert!(numbers.contains("\"mean_delta_e_2000\": null"), "electrons have no colours: {numbers}");
}

#[test]
fn checkers_are_found_by_capture_or_report_and_the_right_file_is_blamed() {
    let folder = rendered("");
    folder.succeed("develop out/raw.dng -o black.png --set develop.exposure_ev=-20");
    for capture in ["capture.toml", "out/capture.json"] {
        folder.fail(
            &format!("measure checker out/image.png --capture {capture}"),
            1,
            &[capture, "no patch", "colour-checker/"],
        );
    }
    folder.add("wall.obj", "usemtl wall\nv -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n");
    folder.add("chart.toml", WALL.replace("0.5", "'colour-checker/19-white'").replace("D50", "D65"));
    folder.succeed("render chart.toml -o chart");
    for capture in ["chart.toml", "chart/capture.json"] {
        let found = folder.succeed(&format!("measure checker chart/image.png --capture {capture} --json")).json();
        assert_eq!(found["patches"][0]["name"], "colour-checker/19-white");
        // The matrix of three broad channels leaves an error of 1 to 3 in a patch; the next grey is 10 away.
        assert!(found["mean_delta_e_2000"].as_f64().expect("a number") < 3.0, "{found}");
    }
    folder.succeed("develop chart/raw.dng -o black.png --force --set develop.exposure_ev=-20");
    folder.fail("measure checker black.png --capture chart.toml", 1, &["black.png: ", "shows the chart black"]);
    folder.fail("measure checker out/image.png --capture chart.toml", 1, &["out/image.png: ", "32 × 24", "48 × 32"]);
    folder.fail("measure checker chart/ideal.exr --capture out", 1, &["out: is a folder"]);
}

/// Content that a file of so many pixels would hold, and does not.
#[cfg(target_os = "linux")]
#[test]
fn files_that_claim_to_be_huge_take_no_memory() {
    let folder = rendered("[output]\nraw = ['dng', 'tiff', 'exr']\n");
    let with = |name: &str, change: &dyn Fn(&mut Vec<u8>)| {
        let mut file = folder.bytes(&format!("out/raw.{name}"));
        change(&mut file);
        folder.add(&format!("huge.{name}"), file);
    };
    // ImageWidth and ImageLength, wherever they are: entries of one LONG or SHORT.
    let sides = |file: &mut Vec<u8>| {
        let mut found = 0;
        for at in 0..file.len() - 12 {
            let is_side = file[at + 1] == 1 && file[at] <= 1 && [3, 4].contains(&file[at + 2]) && file[at + 3] == 0;
            if is_side && file[at + 4..at + 8] == [1, 0, 0, 0] {
                file[at + 8..at + 12].copy_from_slice(&60_000u32.to_le_bytes());
                found += 1;
            }
        }
        assert!(found >= 2, "width and height");
    };
    with("tiff", &sides);
    with("dng", &sides);
    let header = "{'descr': '<u2', 'fortran_order': False, 'shape': (60000, 60000), }\n";
    folder.add(
        "huge.npy",
        [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), b"1234"].concat(),
    );
    with("exr", &|file| {
        let window = file.windows(10).position(|w| w == b"dataWindow").expect("it has one") + 10 + 1 + 6 + 4;
        file[window + 8..window + 16].copy_from_slice(&[0x5f, 0xea, 0, 0, 0x5f, 0xea, 0, 0]);
    });
    folder.add("huge.pgm", b"P5 60000 60000 65535 \0\0\0\0");
    folder.add("header.npy", b"\x93NUMPY\x02\x00\xff\xff\xff\xf0{'descr'");
    for name in ["huge.tiff", "huge.dng", "huge.npy", "huge.exr", "huge.pgm", "header.npy"] {
        // What 60 000 × 60 000 numbers need is 7.2 GB.
        let script =
            format!("ulimit -v 1500000; exec {} develop {name} -o p.png --threads 2", env!("CARGO_BIN_EXE_photosite"));
        let mut shell = std::process::Command::new("sh");
        let output = shell.args(["-c", &script]).current_dir(folder.path("")).output().expect("a shell");
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{name}: {text}");
        assert!(text.contains(name) && !text.contains("panicked"), "{text}");
    }
}
