//! `photosite noise model`: the noise of a sensor over its gains.

use rstest::rstest;

use crate::folder::Folder;

/// A sensor file, 3 e⁻ of read noise at 0 dB and 1.5 e⁻ at 24 dB.
const STEPS: &str = "--set noise.read_noise_e=3 --set noise.gain_steps=[{gain_db=0,read_noise_e=3,row_noise_e=0.5},\
                     {gain_db=24,read_noise_e=1.5,row_noise_e=0.5}]";

/// Between two steps ln σ follows a line over ln K: √(3·1.5) e⁻ in the middle, and half a slope less than that of noise
/// before the gain, as the gain rises by 24 dB and the noise falls by a factor of two.
#[test]
fn a_table_has_the_noise_of_steps_and_the_line_through_them() {
    let folder = Folder::new([]);
    let sensor = "sony-imx249-mono --set adc.gain_db_range=[0,24]";
    let report = folder.succeed(&format!("noise model {sensor} {STEPS} --gains 0..24:12 --json")).json();
    for (i, (gain, read_e)) in [(0.0, 3.0), (12.0, 4.5_f64.sqrt()), (24.0, 1.5)].into_iter().enumerate() {
        let row = &report["gains"][i];
        let k = row["system_gain_dn_per_e"].as_f64().expect("K");
        assert_eq!(row["gain_db"], gain);
        assert!((row["read_noise_dn"].as_f64().expect("σ") / (read_e * k) - 1.0).abs() < 1e-9, "{row}");
        assert!((row["row_noise_dn"].as_f64().expect("σ") / (0.5 * k) - 1.0).abs() < 1e-9, "{row}");
    }
    let slope = report["lines"]["read_noise"]["slope"].as_f64().expect("a slope");
    let wanted = 1.0 - 2.0_f64.ln() / (2.4_f64 * 10.0_f64.ln() / 2.0);
    assert!((slope - wanted).abs() < 1e-9, "{slope} {wanted}");
    assert!((report["lines"]["row_noise"]["slope"].as_f64().expect("a slope") - 1.0).abs() < 1e-9);
}

/// The figures of image sets at two gains are those of the table: dark noise of pairs of 128² pixels within 3 %, five
/// of its standard errors 1/√(2n), and K within 5 %.
#[rstest]
#[case(0)]
#[case(12)]
fn image_sets_show_the_noise_of_the_table(#[case] gain: u32) {
    let folder = Folder::new([]);
    let sensor = "sony-imx249-mono --set noise.gain_steps=[{gain_db=0,read_noise_e=9},{gain_db=24,read_noise_e=5}]";
    let table = folder.succeed(&format!("noise model {sensor} --gains {gain}..{gain}:1 --time-s 1e-5 --json")).json();
    let row = &table["gains"][0];
    folder
        .succeed(&format!("emva1288 {sensor} --gain-db {gain} --steps 12 --spatial 3 --size 128x128 -o sets --quiet"));
    let measured = &folder.succeed("emva1288-report sets --json").json()[0]["measured"];
    for (key, bound) in [("dark_noise_dn", 0.03), ("system_gain_dn_per_e", 0.05)] {
        let [measured, table] = [&measured[key], &row[key]].map(|value| value.as_f64().expect(key));
        assert!((measured / table - 1.0).abs() < bound, "{key}: {measured} in images, {table} in the table");
    }
}

/// The file has the columns of the JSON, an empty cell for what a sensor does not have.
#[test]
fn the_table_is_a_file_that_others_read() {
    let folder = Folder::new([]);
    folder.succeed("noise model generic-cmos-color --gains 0..12:6 -o noise.csv");
    let report = folder.succeed("noise model generic-cmos-color --gains 0..12:6 --json").json();
    let text = folder.text("noise.csv");
    let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(lines.len(), 4);
    let place = |name: &str| lines[0].iter().position(|heading| *heading == name).expect("a column");
    for (row, line) in report["gains"].as_array().expect("rows").iter().zip(&lines[1..]) {
        for name in ["gain_db", "system_gain_dn_per_e", "dark_noise_dn", "white_level_dn"] {
            assert_eq!(row[name].as_f64(), line[place(name)].parse().ok(), "{name}");
        }
        assert_eq!(row["noise_profile"][1].as_f64(), line[place("noise_profile_o")].parse().ok());
    }
    folder.fail("noise model generic-cmos-color -o noise.csv", 2, &["noise.csv already exists", "--force"]);
}

/// The fields are those of the gain, and what they have no place for is told.
#[test]
fn a_sensor_becomes_fields_of_isetcam() {
    let folder = Folder::new([]);
    let said = folder
        .succeed("noise model sony-imx249-mono --set noise.row_noise_e=1 --gains 12..12:1 --isetcam a.json")
        .stderr;
    assert!(said.contains("no place for:") && said.contains("row-noise"), "{said}");
    let found = folder.json("a.json");
    assert!((found["analogGain"].as_f64().expect("a gain") - 10f64.powf(-0.6)).abs() < 1e-8, "{found}");
    assert_eq!(found["color"]["filterNames"], serde_json::json!(["w"]));
    let odd = "--set masked_columns=[8,0] --set shutter.kind=rolling --set shutter.row_time_us=10 --set resolution_px=[64,48]";
    let said = folder.succeed(&format!("noise model generic-cmos-color --isetcam b.json {odd}")).stderr;
    assert!(said.contains("masked pixels") && said.contains("the times of rows"), "{said}");
    folder.fail("noise model sony-imx249-mono --isetcam a.json", 2, &["a.json already exists", "--force"]);
    folder.fail("noise model generic-stacked-color --isetcam c.json", 2, &["one colour filter a pixel"]);
}

#[rstest]
#[case::fields("noise model generic-cmos-color --isetcam twin.mat", "the sensor is a .json file")]
#[case::gain("noise model generic-cmos-color --gains 0..600:100", "is not among the gains")]
#[case::ending("noise model generic-cmos-color -o noise.xlsx", "the table is a .csv file")]
#[case::steps("noise model generic-cmos-color --gains 0..6", "write first, last and step")]
#[case::time("noise model generic-cmos-color --time-s 0", "write a number above 0")]
fn what_cannot_be_is_refused(#[case] arguments: &str, #[case] said: &str) {
    Folder::new([]).fail(arguments, 2, &[said]);
}

/// What one number for each gain does not tell is said.
#[test]
fn what_a_table_does_not_tell_is_a_warning() {
    let telegraph = "--set noise.telegraph={pixels_per_million=1000,amplitude_e=20,high_s=1,low_s=1}";
    let said = Folder::new([]).succeed(&format!("noise model sony-imx249-mono {telegraph}")).stderr;
    assert!(said.contains("tails heavier"), "{said}");
}

/// Tails and unequal pixels are in no number of a gain, and stand below the table; a sensor without read noise has no
/// shape.
#[rstest]
#[case("sony-imx249-mono", "a normal distribution, the same in all pixels")]
#[case(
    "sony-imx249-mono --set noise.read_noise_degrees_of_freedom=6 --set noise.read_noise_spread_percent=30",
    "Student's t distribution with 6 degrees of freedom, pixels differ by 30 %"
)]
#[case("swissspad2", "")]
fn the_shape_of_the_read_noise_stands_below(#[case] sensor: &str, #[case] shape: &str) {
    let said = Folder::new([]).succeed(&format!("noise model {sensor}")).stdout;
    let last = said.lines().rfind(|line| line.starts_with("read noise: ") && !line.contains("ln σ"));
    assert_eq!(last.map_or("", |line| line.trim_start_matches("read noise: ")), shape, "{said}");
}
