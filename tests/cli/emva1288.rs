//! `photosite emva1288` and `photosite emva1288-report`.

use rstest::rstest;
use serde_json::{Value, json};

use crate::folder::Folder;

const SMALL: &str = "emva1288 generic-cmos-color --channels G --size 24x16 --steps 8 --spatial 4 -o sets";

#[test]
fn image_sets_are_taken_and_measured() {
    let folder = Folder::new([]);
    let printed = folder.succeed(&format!("{SMALL} --sweep 500..600:50 --temperatures 15..35:10 --json")).json();
    let contents = folder.json("sets/emva1288.json");
    assert_eq!(printed, contents);
    let channel = &contents["channels"][0];
    assert_eq!((&channel["channel"], &channel["expected"]["system_gain_dn_per_e"]), (&json!("G"), &json!(0.1344)));
    assert_eq!(channel["wavelengths"][1]["descriptor"], "G/wavelengths/0550.txt");
    assert_eq!(channel["temperatures"][2]["descriptor"], "G/temperatures/+35.txt");
    let descriptor = folder.text("sets/G/emva1288.txt");
    assert!(descriptor.starts_with("v 4.0\nn 12 24 16\nd "), "{descriptor}");
    // A bright and a dark pair a step, two stacks, at each wavelength four pairs, at each temperature ten times two.
    let images = folder.contents().into_keys().filter(|path| path.extension().is_some_and(|e| e == "tiff")).count();
    assert_eq!(images, 8 * 4 + 2 * 4 + 3 * 8 + 3 * 40);

    let measured = folder.succeed("emva1288-report sets --json").json();
    let found = &measured[0];
    assert_eq!(found["expected"]["dark_noise_e"], channel["expected"]["dark_noise_e"]);
    assert_eq!(found["wavelengths"].as_array().map(Vec::len), Some(3));
    // The slope through 5 even points, of 384 pixels: √(2/384)·√Σi⁴/Σi² = 4 %; 5 times that.
    let gain = found["measured"]["system_gain_dn_per_e"].as_f64().expect("a number");
    assert!((gain / 0.1344 - 1.0).abs() < 0.2, "{gain}");
    let doubling = found["doubling_temperature_k"][1].as_f64().expect("a number");
    assert!((doubling / 7.0 - 1.0).abs() < 0.1, "{doubling}");
    let page = folder.text("sets/report.html");
    assert!(page.contains("Photon transfer curve") && page.contains("Quantum efficiency"));
    // Nothing is fetched: no addresses but the name of the format.
    assert!(page.matches("http").count() == page.matches("http://www.w3.org/2000/svg").count());
    assert!(!page.contains("<script") && !page.contains("src="));
    folder.fail("emva1288-report sets", 2, &["report.html already exists", "--force"]);
    // A descriptor alone is any camera's.
    let text = folder.succeed("emva1288-report sets/G/emva1288.txt -o camera.html").stdout;
    assert!(text.contains("System gain"), "{text}");
}

#[test]
fn sets_without_exposure_times_are_measured_but_for_what_needs_them() {
    let folder = Folder::new([]);
    folder.succeed("emva1288 sony-imx249-mono --size 48x32 --steps 8 --spatial 4 -o sets -q");
    let descriptor = folder.text("sets/Y/emva1288.txt");
    // One dark pair, and every time the same, as a set has it whose light varies.
    let with_time = |time: &str| {
        let mut series: Vec<Vec<&str>> = Vec::new();
        for line in descriptor.lines() {
            match series.last_mut() {
                Some(last) if line.starts_with("i ") => last.push(line),
                _ => series.push(vec![line]),
            }
        }
        let is_dark_pair = |series: &[&str]| series[0].starts_with("d ") && series.len() == 3;
        let first = series.iter().position(|series| is_dark_pair(series));
        let kept = series.into_iter().enumerate().filter(|(i, series)| Some(*i) == first || !is_dark_pair(series));
        let lines: Vec<String> = kept
            .flat_map(|(_, series)| {
                let head = match series[0].split(' ').collect::<Vec<_>>()[..] {
                    ["d", _] => format!("d {time}"),
                    ["b", _, photons] => format!("b {time} {photons}"),
                    _ => series[0].to_owned(),
                };
                std::iter::once(head).chain(series[1..].iter().map(|line| (*line).to_owned())).collect::<Vec<_>>()
            })
            .collect();
        assert_eq!(lines.iter().filter(|line| line.starts_with("d ")).count(), 2, "{lines:?}");
        lines
    };
    folder.add("sets/Y/timed.txt", with_time("5000000").join("\n"));
    let untimed = format!("\u{feff}# by another program\r\n\r\n{}\r\n", with_time("000.00").join("\r\n \r\n"));
    assert!(untimed.contains("i images\\"), "{untimed}");
    folder.add("sets/Y/untimed.txt", untimed);
    let report =
        |name: &str| folder.succeed(&format!("emva1288-report sets/Y/{name} --json --force")).json()[0].clone();
    let (timed, untimed) = (report("timed.txt"), report("untimed.txt"));
    assert_eq!(untimed["measured"], timed["measured"], "no figure takes 0 for a time");
    let measured = &untimed["measured"];
    // 1536 pixels a pair: K errs by about √(2/1536)·√Σi⁴/Σi² of its 5 points, 2 %; 5 times that.
    let gain = measured["system_gain_dn_per_e"].as_f64().expect("a number");
    assert!((gain / 0.1245 - 1.0).abs() < 0.1, "{gain}");
    for figure in ["dark_current_mean_e_per_s", "dark_current_variance_e_per_s"] {
        assert_eq!(measured[figure], Value::Null);
    }
    for figure in ["total", "pixel"] {
        assert!(measured["prnu_percent"][figure].is_number() && measured["dsnu_e"][figure].is_number(), "{measured}");
    }
    let missing = &untimed["not_measured"][0];
    let reason = "the exposure times are not known: the descriptor states 0";
    assert_eq!((&missing["figure"], &missing["reason"]), (&json!("dark current"), &json!(reason)));
    let text = folder.succeed("emva1288-report sets/Y/untimed.txt --force").stdout;
    assert!(text.contains(&format!("not measured: dark current; {reason}")), "{text}");
    let page = folder.text("sets/Y/report.html");
    assert!(page.contains("Not measured: dark current;"), "{page}");
}

#[test]
fn every_format_holds_the_same_numbers_whatever_the_threads() {
    let folder = Folder::new([]);
    for (format, threads) in [("tiff", "1"), ("dng", "3"), ("png", "2")] {
        let mut command = folder.command(&format!(
            "emva1288 sony-imx249-mono --size 16x12 --steps 6 --spatial 3 --seed 7 --format {format} -o {format} -q"
        ));
        assert!(command.env("RAYON_NUM_THREADS", threads).status().expect("runs").success());
        let report = folder.succeed(&format!("emva1288-report {format} --json")).stdout;
        let first = folder.succeed("emva1288-report tiff --json -o first.html --force").stdout;
        assert_eq!(report, first, "{format}");
    }
    folder.succeed("compare tiff/Y/images/stack-bright-2.tiff dng/Y/images/stack-bright-2.dng --max-rmse 0");
}

#[test]
fn earlier_sets_are_replaced_only_if_asked_for() {
    let folder = Folder::new([]);
    folder.succeed(&format!("{SMALL} -q"));
    folder.fail(SMALL, 2, &["sets already contains image sets", "--force"]);
    folder.succeed(&format!("{SMALL} -q --force --seed 3"));
    folder.add("mine/letter.txt", "dear");
    folder.fail(&SMALL.replace("sets", "mine"), 2, &["mine contains other files", "-o"]);
    folder.fail(&format!("{} --force", SMALL.replace("sets", "mine")), 2, &["mine contains other files"]);
    folder.fail(&SMALL.replace("sets", "mine/letter.txt"), 2, &["is not a folder"]);
}

#[rstest]
#[case::sensor("emva1288 generic", 2, "photosite has no sensor \"generic\"")]
#[case::file("emva1288 nowhere.toml", 1, "nowhere.toml: cannot read")]
#[case::key("emva1288 sony-imx249-mono --set noise.read=2", 1, "--set noise.read=2: sensor.noise.read: unknown key")]
#[case::value("emva1288 sony-imx249-mono --set noise.read_noise_e=-2", 1, "must not be negative, got -2")]
#[case::channel("emva1288 sony-imx249-mono --channels R", 2, "has no channel \"R\"")]
#[case::size("emva1288 sony-imx249-mono --size 9999x9999", 2, "1936 × 1216")]
#[case::range("emva1288 sony-imx249-mono --sweep 380-1000", 2, "write first, last and step")]
#[case::wavelength("emva1288 sony-imx249-mono --wavelength-nm 2000", 2, "from 300 to 1100")]
#[case::blind("emva1288 generic-cmos-color --wavelength-nm 1000", 2, "is blind at 1000 nm")]
#[case::gain("emva1288 sony-imx249-mono --gain-db 60", 2, "gain_db: 60 dB is not among the gains")]
#[case::hot("emva1288 sony-imx249-mono --temperature-c 400", 2, "the dark current alone fills the pixels")]
#[case::no_sets("emva1288-report .", 1, "has no emva1288.json")]
#[case::no_file("emva1288-report nowhere.txt", 1, "nowhere.txt: cannot read")]
#[case::broken("emva1288-report broken.txt", 1, "broken.txt:2: b: cannot read \"b 5\"")]
#[case::lost("emva1288-report lost.txt", 1, "lost.tiff: cannot read")]
fn what_cannot_be_done_is_refused(#[case] arguments: &str, #[case] status: i32, #[case] message: &str) {
    let folder = Folder::new([
        ("broken.txt", b"v 4.0\nb 5\n".to_vec()),
        ("lost.txt", b"n 8 2 2\nd 5\ni lost.tiff\ni lost.tiff\n".to_vec()),
    ]);
    folder.fail(arguments, status, &[message]);
}

#[test]
fn two_sets_stand_side_by_side() {
    let folder = Folder::new([]);
    for (name, changes) in [("a", ""), ("b", "--seed 5"), ("c", "--set noise.read_noise_e=7.5")] {
        let size = "--size 64x48 --steps 10 --spatial 6 -q";
        folder.succeed(&format!("emva1288 sony-imx249-mono {size} -o {name} {changes}"));
    }
    let figures = |other: &str| {
        let printed = folder.succeed(&format!("emva1288-report a {other} --json --force")).json();
        printed[0]["figures"].as_array().expect("a list").clone()
    };
    let score = |figures: &[Value], symbol: &str| {
        let row = figures.iter().find(|row| row["symbol"] == symbol).expect(symbol);
        row["standard_errors"].as_f64().unwrap_or_else(|| panic!("{row}"))
    };
    let same = figures("b");
    for symbol in ["η", "K", "R", "σ_d", "σ_y.dark", "DSNU₁₂₈₈", "PRNU₁₂₈₈", "μ_I.mean"] {
        assert!(score(&same, symbol).abs() < 4.5, "{symbol}: {}", score(&same, symbol));
    }
    // The offset of a line through 10 dark pairs of 3072 pixels knows σ_d to some 2 %, of which 1.2 e⁻ of 6.3 are ten.
    let other = figures("c");
    assert!(score(&other, "σ_d") > 5.0 && score(&other, "K").abs() < 4.5, "{other:?}");
    let page = folder.text("a/comparison.html");
    assert!(page.contains("in standard errors") && page.contains("Photon transfer curve"));
    let text = folder.succeed("emva1288-report a/Y/emva1288.txt c/Y/emva1288.txt -o page.html").stdout;
    assert!(text.contains("standard errors") && text.contains("System gain"), "{text}");
}
