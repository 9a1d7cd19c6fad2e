//! `photosite measure sensitivities`, and curves with names in one file.

use photosite::spectrum::{Outside, SpectralTable, library};
use rstest::rstest;

use crate::folder::Folder;

const CHART: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/colour-checker/capture-d50.toml");
/// Centres of the corner patches: 115 and 69 mm from the middle at 0.92 m, by a lens of 12 mm, in pixels of 20 µm.
const CORNERS: &str = "45,45,195,45,195,135,45,135";

/// A folder with a rendered chart.
fn chart() -> Folder {
    let folder = Folder::new([]);
    folder.succeed(&format!("render {CHART} --size 240x180 --spp 16 -q -o chart"));
    folder
}

#[test]
fn curves_of_a_known_sensor_come_back() {
    let folder = chart();
    let command =
        format!("measure sensitivities chart/raw.dng --light D50 --corners {CORNERS} --peak 0.6 -o camera.csv");
    // A camera profile is colour tags of a DNG file behind another magic number.
    let mut profile = folder.bytes("chart/raw.dng");
    profile[2..4].copy_from_slice(b"RC");
    folder.add("camera.dcp", profile);
    let outcome = folder.succeed(&format!("{command} --profile camera.dcp --json"));
    let report = outcome.json();
    // Shot noise of some 200 pixels of up to 30 000 e-, and PRNU.
    assert!(report["patch_error"].as_f64().is_some_and(|error| error < 0.02), "{report}");
    let text = folder.text("camera.csv");
    let table = SpectralTable::parse(&text, Outside::Hold).expect("a table");
    assert_eq!(table.outside(), Outside::Zero);
    let filter = library::spectrum("filters/ir-cut-650").expect("listed");
    let (mut pairs, mut peaks) = (Vec::new(), Vec::new());
    for channel in ["R", "G", "B"] {
        let name = format!("quantum-efficiency/generic-cmos-color-{}", channel.to_lowercase());
        let truth = library::spectrum(&name).expect("listed").product(&filter);
        let values = table.values(channel).expect("a column");
        pairs.push(
            table
                .lambda_nm()
                .iter()
                .zip(values)
                .map(|(nm, v)| (f64::from(truth.eval(*nm as f32)), *v))
                .collect::<Vec<_>>(),
        );
        peaks.push(truth.iter().map(|(_, value)| value).fold(0.0, f64::max));
    }
    let sum = |of: fn(&(f64, f64)) -> f64| pairs.iter().flatten().map(of).sum::<f64>();
    let factor = sum(|(t, q)| t * q) / sum(|(_, q)| q * q);
    for (pairs, peak) in pairs.iter().zip(peaks) {
        let square: f64 = pairs.iter().map(|(t, q)| (t - factor * q).powi(2)).sum();
        let deviation = (square / pairs.len() as f64).sqrt() / peak;
        assert!(deviation < 0.12, "{deviation}");
    }
    let largest = pairs.iter().flatten().map(|(_, q)| *q).fold(0.0, f64::max);
    for check in report["matrices"].as_array().expect("a list") {
        assert_eq!(check["profile_delta_e_2000"], check["stated_delta_e_2000"], "{check}");
        assert!(check["profile_delta_e_2000"].is_f64(), "{check}");
    }
    assert!((largest - 0.6).abs() < 1e-6, "{largest}");
    // Matrices of the file are those of the true curves, which show charts in the light of the image as well.
    let matrices = report["matrices"].as_array().expect("a list");
    let d50 = matrices.iter().find(|check| check["light"] == "D50").expect("D50");
    let [stated, derived] =
        ["stated", "derived"].map(|by| d50[format!("{by}_delta_e_2000")].as_f64().expect("a number"));
    assert!(stated < derived + 1.0 && derived < 4.0, "{d50}");
    // The printed tables are those of a sensor.
    let printed = folder.succeed(&format!("{command} --force")).stdout;
    let tables = &printed[printed.find("\n[channels.R]").expect("tables")..];
    let sensor = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/crates/photosite-sensor/assets/sensors/generic-cmos-color.toml"
    ));
    let sensor = sensor.expect("a preset");
    let (first, rest) = (sensor.find("[channels.R]").expect("channels"), sensor.find("[noise]").expect("noise"));
    folder.add("own.toml", format!("{}{tables}\n\n{}", &sensor[..first], &sensor[rest..]));
    let said = folder.succeed("info own.toml").stdout;
    assert!(peaks_of(&said).contains(&"0.6".to_owned()), "{said}");
}

/// Largest quantum efficiencies that `photosite info` prints.
fn peaks_of(info: &str) -> Vec<String> {
    let line = info.lines().find_map(|line| line.strip_prefix("peak_quantum_efficiency")).expect("printed");
    line.split(',').map(|value| value.trim().to_owned()).collect()
}

#[rstest]
#[case::no_such_light("--light D50x --corners 45,45,195,45,195,135,45,135", 2, &["no illuminant \"D50x\"", "D50"])]
#[case::two_lights("--light A --light D50 --corners 45,45,195,45,195,135,45,135", 2, &["2 times --light for 1 images"])]
#[case::seven_numbers("--light D50 --corners 45,45,195,45,195,135,45", 2, &["expected eight numbers"])]
#[case::crossed("--light D50 --corners 45,45,195,135,195,45,45,135", 1, &["do not go around the chart"])]
#[case::outside("--light D50 --corners 45,45,295,45,195,135,45,135", 1, &["295, 45 lies outside"])]
#[case::other_chart("--light D50 --corners 45,45,195,45,195,135,45,135 --grid 5x4 --reflectances two.csv", 2, &["5 x 4 patches, and 2"])]
#[case::peak("--light D50 --corners 45,45,195,45,195,135,45,135 --peak -1", 2, &["expected a number above 0, up to 1"])]
#[case::no_profile("--light D50 --corners 45,45,195,45,195,135,45,135 --profile two.csv", 1, &["two.csv", "cannot read it as TIFF"])]
#[case::no_file("--light none.csv --corners 45,45,195,45,195,135,45,135", 1, &["none.csv", "cannot read"])]
fn what_is_wrong_is_named(#[case] arguments: &str, #[case] status: i32, #[case] wanted: &[&str]) {
    let folder = chart();
    folder.add("two.csv", "nm,a,b\n400,1,1\n700,1,1\n");
    folder.fail(&format!("measure sensitivities chart/raw.dng -o camera.csv {arguments}"), status, wanted);
    assert!(!folder.path("camera.csv").exists());
}

#[test]
fn a_chart_that_lies_otherwise_is_refused() {
    let folder = chart();
    let command = "measure sensitivities chart/raw.dng --light D50 -o x.csv --corners 195,135,45,135,45,45,195,45";
    folder.fail(command, 1, &["depart by more than 30 %", "the order of reading"]);
    assert!(!folder.path("x.csv").exists());
}

#[rstest]
#[case::chosen("{ file = \"two.csv\", column = \"b\" }", None)]
#[case::open("{ file = \"two.csv\" }", Some("write column = \"a\", or another of a, b"))]
#[case::unknown("{ file = \"two.csv\", column = \"c\" }", Some("has no column \"c\", only a, b"))]
fn a_file_may_have_several_columns(#[case] source: &str, #[case] wanted: Option<&str>) {
    let folder = Folder::new([]);
    folder.add("two.csv", "nm,a,b\n400,0.1,0.2\n700,0.3,0.7\n");
    let sensor = format!(
        "kind = \"cmos\"\nresolution_px = [8, 8]\npixel_pitch_um = [5, 5]\ncfa = \"mono\"\n[channels.Y]\nquantum_efficiency = {source}\n\
         [adc]\nbits = 12\nconversion_gain_dn_per_e = 0.1\nblack_level_dn = 10\n[noise]\nread_noise_e = 2\ndark_current_e_per_s = 0\n[charge]\nfull_well_e = 20000\n"
    );
    folder.add("sensor.toml", sensor);
    match wanted {
        None => assert!(peaks_of(&folder.succeed("info sensor.toml").stdout) == ["0.7"]),
        Some(wanted) => drop(folder.fail("info sensor.toml", 1, &["two.csv", wanted])),
    }
}
