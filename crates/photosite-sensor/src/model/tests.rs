use photosite_core::Invalid;
use photosite_core::spectrum::Spectrum;
use photosite_core::units::{Electrons, PLANCK, SPEED_OF_LIGHT};

use super::*;

const TOML: &str = r#"
    resolution_px = [64, 48]
    pixel_pitch_um = [5.0, 4.0]
    fill_factor = 0.5
    cfa = "RGGB"
    filter.transmittance = 0.8
    channels.R.quantum_efficiency = 0.6
    channels.G.quantum_efficiency = 0.7
    channels.B.quantum_efficiency = 0.5
    noise = { read_noise_e = 2.0, dark_current_e_per_s = 1.0, dark_current_reference_c = 25.0, dark_current_doubling_k = 8.0, prnu_percent = 1.0, dsnu_e = 0.5 }
    charge.full_well_e = 10000.0
    adc = { bits = 12, conversion_gain_dn_per_e = 0.4, black_level_dn = 64, gain_db_range = [0.0, 24.0] }
"#;

fn number(source: &SpectrumSource) -> Result<Spectrum, Invalid> {
    match source {
        SpectrumSource::Number(value) => Ok(Spectrum::constant(*value as f32)),
        SpectrumSource::Name(_) | SpectrumSource::File(_) => Err(Invalid::new("", "no such spectrum")),
    }
}

fn model(text: &str) -> Result<SensorModel, Invalid> {
    let description: SensorDescription = toml::from_str(text).expect("right keys and types");
    SensorModel::new("test", &description, number)
}

#[test]
fn photons_of_a_monochromatic_flux_by_hand() {
    // 1e-3 W/m² in a band of 1 nm at 500 nm, on 20 µm² of which half is sensitive, through a filter of 0.8:
    // 1e-3 W/m² · 1e-11 m² · 0.8 = 8e-15 W; a photon carries 6.62607015e-34 · 299792458 / 500e-9 = 3.972891714e-19 J,
    // so 20136.466 photons/s arrive, and 0.6 of them become 12081.88 electrons/s.
    let sensor = model(TOML).expect("valid");
    let (name, red) = &sensor.responses()[0];
    assert_eq!(name, "R");
    let rate = f64::from(red.eval(500.0)) * 1e-3;
    // The table holds f32: 2⁻²⁴ relative, three roundings.
    assert!((rate / 12_081.88 - 1.0).abs() < 1e-6, "{rate}");
}

#[test]
fn the_response_integrates_a_broad_spectrum_to_its_photon_count() {
    // The number of photons grows with λ: for E = 1 W/m²/nm from 300 to 1100 nm, ∫ λ dλ = (1100² − 300²)/2 nm².
    let sensor = model(TOML).expect("valid");
    let integral = sensor.responses()[1].1.integral();
    let photons = 1e-9 / (PLANCK * SPEED_OF_LIGHT) * (1100.0f64.powi(2) - 300.0f64.powi(2)) / 2.0;
    assert!((integral / (1e-11 * 0.8 * 0.7 * photons) - 1.0).abs() < 1e-6);
}

#[test]
fn what_no_sensor_can_be_is_refused_by_key() {
    for (from, to, key) in [
        ("[64, 48]", "[64, 0]", "resolution_px"),
        ("[5.0, 4.0]", "[5.0, -4.0]", "pixel_pitch_um"),
        ("fill_factor = 0.5", "fill_factor = 1.5", "fill_factor"),
        ("\"RGGB\"", "\"RGG\"", "cfa"),
        ("\"RGGB\"", "\"mono\"", "channels.B"),
        ("channels.G.quantum_efficiency = 0.7", "", "channels.G"),
        ("quantum_efficiency = 0.6", "quantum_efficiency = 60", "channels.R.quantum_efficiency"),
        ("quantum_efficiency = 0.5", "quantum_efficiency = -0.1", "channels.B.quantum_efficiency"),
        ("quantum_efficiency = 0.5", "quantum_efficiency = \"nowhere\"", "channels.B.quantum_efficiency"),
        ("transmittance = 0.8", "transmittance = 1.1", "filter.transmittance"),
        ("read_noise_e = 2.0", "read_noise_e = -2.0", "noise.read_noise_e"),
        ("dark_current_doubling_k = 8.0", "dark_current_doubling_k = 0", "noise.dark_current_doubling_k"),
        ("prnu_percent = 1.0", "prnu_percent = nan", "noise.prnu_percent"),
        ("dsnu_e = 0.5", "dsnu_e = inf", "noise.dsnu_e"),
        ("dark_current_doubling_k = 8.0, ", "", "noise.dark_current_doubling_k"),
        ("dsnu_e = 0.5", "dsnu_e = 0.5, row_noise_e = -1", "noise.row_noise_e"),
        (
            "dsnu_e = 0.5",
            "dsnu_e = 0.5, gain_steps = [{ gain_db = 0, black_level_dn = 4095 }]",
            "noise.gain_steps[0].black_level_dn",
        ),
        (
            "dsnu_e = 0.5",
            "dsnu_e = 0.5, gain_steps = [{ gain_db = 0, black_level_dn = 64 }, { gain_db = 3, dsnu_e = 1 }]",
            "noise.gain_steps[0]",
        ),
        (
            "dsnu_e = 0.5 }",
            "dsnu_e = 0.5, gain_steps = [{ gain_db = 0, black_level_dn = 64 }, { gain_db = 3, black_level_dn = 65 }] }\nvideo.gamma = 0.45",
            "video.gamma",
        ),
        (
            "dsnu_e = 0.5",
            "dsnu_e = 0.5, gain_steps = [{ gain_db = 0, read_noise_e = -1 }]",
            "noise.gain_steps[0].read_noise_e",
        ),
        (
            "dsnu_e = 0.5",
            "dsnu_e = 0.5, gain_steps = [{ gain_db = nan, read_noise_e = 1 }]",
            "noise.gain_steps[0].gain_db",
        ),
        (
            "dsnu_e = 0.5",
            "dsnu_e = 0.5, gain_steps = [{ gain_db = 0, row_noise_e = nan }]",
            "noise.gain_steps[0].row_noise_e",
        ),
        ("dsnu_e = 0.5", "dsnu_e = 0.5, gain_steps = [{ gain_db = 3 }]", "noise.gain_steps[0]"),
        (
            "dsnu_e = 0.5",
            "dsnu_e = 0.5, gain_steps = [{ gain_db = 3, read_noise_e = 2 }, { gain_db = 3, read_noise_e = 1 }]",
            "noise.gain_steps[1].gain_db",
        ),
        (
            "dsnu_e = 0.5",
            "dsnu_e = 0.5, gain_steps = [{ gain_db = 0, read_noise_e = 2 }, { gain_db = 3, dsnu_e = 1 }]",
            "noise.gain_steps[0]",
        ),
        ("dsnu_e = 0.5", "dsnu_e = 0.5, reset = { noise_e = 3, capacitance_ff = 1 }", "noise.reset.capacitance_ff"),
        ("dsnu_e = 0.5", "dsnu_e = 0.5, flicker.exponent = 3", "noise.flicker.exponent"),
        ("dsnu_e = 0.5", "dsnu_e = 0.5, telegraph.high_s = 0", "noise.telegraph.high_s"),
        ("dsnu_e = 0.5", "dsnu_e = 0.5, read_noise_degrees_of_freedom = 2", "noise.read_noise_degrees_of_freedom"),
        (
            "dsnu_e = 0.5",
            "dsnu_e = 0.5, transmission_errors_per_million = 2e6",
            "noise.transmission_errors_per_million",
        ),
        ("fill_factor = 0.5", "defects.hot_per_million = -1", "defects.hot_per_million"),
        ("fill_factor = 0.5", "format = \"2/3\"", "format"),
        ("pixel_pitch_um = [5.0, 4.0]", "", "pixel_pitch_um"),
        ("pixel_pitch_um = [5.0, 4.0]", "format = \"3/2\"", "format"),
        ("fill_factor = 0.5", "crosstalk = [[0.5, 0.4, 0.0]]", "crosstalk"),
        ("fill_factor = 0.5", "channels.R.crosstalk = [[0.5, 0.5]]", "channels.R.crosstalk"),
        ("bits = 12", "bits = 12, inl_dn = 2000", "adc.inl_dn"),
        ("bits = 12", "bits = 12, dnl_dn = 0.5", "adc.dnl_dn"),
        ("bits = 12", "bits = 12, amplifier_nonlinearity_percent = [-60]", "adc.amplifier_nonlinearity_percent"),
        ("bits = 12", "bits = 12, column_gain_percent = nan", "adc.column_gain_percent"),
        ("full_well_e = 10000.0", "full_well_e = 0", "charge.full_well_e"),
        ("full_well_e = 10000.0", "full_well_e = 10000.0\ncharge.image_lag.percent = 100", "charge.image_lag.percent"),
        (
            "full_well_e = 10000.0",
            "full_well_e = 10000.0\ncharge.image_lag = { percent = 1, decay = 1 }",
            "charge.image_lag.decay",
        ),
        (
            "full_well_e = 10000.0",
            "full_well_e = 10000.0\ncharge.image_lag.electrons = -1",
            "charge.image_lag.electrons",
        ),
        (
            "full_well_e = 10000.0",
            "full_well_e = 10000.0\ncharge.image_lag.percent = 1\ncharge.logarithmic_reference_e_per_s = 100",
            "charge.image_lag",
        ),
        ("bits = 12", "bits = 0", "adc.bits"),
        ("bits = 12", "bits = 40", "adc.bits"),
        ("gain_dn_per_e = 0.4", "gain_dn_per_e = 0", "adc.conversion_gain_dn_per_e"),
        ("black_level_dn = 64", "black_level_dn = 4095", "adc.black_level_dn"),
        ("[0.0, 24.0]", "[24.0, 0.0]", "adc.gain_db_range"),
    ] {
        assert!(TOML.contains(from), "{from}");
        let error = model(&TOML.replacen(from, to, 1)).expect_err(to);
        assert_eq!(error.key, key, "{error}");
    }
}

#[test]
fn a_format_over_the_resolution_is_the_pitch() {
    let sensor = model(&TOML.replace("pixel_pitch_um = [5.0, 4.0]", "format = '2/3\"'")).expect("valid");
    assert_eq!(sensor.pixel_pitch_m, [8.8e-3 / 64.0, 6.6e-3 / 48.0]);
    assert_eq!(sensor.pixel_aspect(), 1.0);
}

#[test]
fn filters_follow_one_another() {
    let text = TOML.replace("filter.transmittance = 0.8", "filter = { cover_glass = 0.5, microlenses = 0.25 }");
    assert_eq!(model(&text).expect("valid").filter.eval(500.0), 0.125);
}

#[test]
fn figures_of_other_kinds_of_sensors_are_refused_by_key() {
    let interline = "kind = 'ccd'\nccd = { smear_db = -80.0, line_time_us = 30.0 }";
    let one_bit = "kind = 'spad'\nspad = { counting = 'one-bit', one_bit_frames = 16 }";
    let dual = "adc.dual_gain = { bits = 11, black_level_dn = 20, high_gain_dn_per_e = 4.0, low_gain_dn_per_e = 0.1, \
                low_gain_read_noise_e = 5.0 }";
    let toml = TOML.replace(
        "adc = { bits = 12, conversion_gain_dn_per_e = 0.4, black_level_dn = 64, \
                             gain_db_range = [0.0, 24.0] }",
        "",
    );
    let adc = "adc.bits = 16\nadc.conversion_gain_dn_per_e = 4.0\nadc.black_level_dn = 64\nadc.gain_db_range = [0, 0]";
    for (lines, from, to, key) in [
        (interline, "'ccd'", "'cmos'", "ccd"),
        (interline, "'ccd'", "'spad'", "ccd"),
        (interline, "-80.0", "80.0", "ccd.smear_db"),
        (interline, ", line_time_us = 30.0", "", "ccd.line_time_us"),
        (interline, "smear_db = -80.0", "row_shift_time_us = 1.0", "ccd.row_shift_time_us"),
        (interline, "smear_db = -80.0", "vertical_cti = 1.0", "ccd.vertical_cti"),
        (interline, "smear_db = -80.0", "horizontal_cti = -1e-6", "ccd.horizontal_cti"),
        (interline, "smear_db = -80.0", "anti_blooming_factor = 0.5", "ccd.anti_blooming_factor"),
        (interline, "smear_db = -80.0", "overscan_rows = 70000", "ccd.overscan_rows"),
        (interline, "ccd =", "masked_rows = [0, 5000]\nccd =", "masked_rows"),
        (one_bit, "'spad'", "'cmos'", "spad"),
        (one_bit, "\nspad = { counting = 'one-bit', one_bit_frames = 16 }", "", "spad"),
        (one_bit, ", one_bit_frames = 16", "", "spad.one_bit_frames"),
        (one_bit, "16", "0", "spad.one_bit_frames"),
        (one_bit, "one-bit", "free-running", "spad.one_bit_frames"),
        (one_bit, "one_bit_frames = 16", "dead_time_ns = 50.0", "spad.dead_time_ns"),
        (one_bit, "16", "16, afterpulsing_percent = 100.0", "spad.afterpulsing_percent"),
        (dual, "bits = 11", "bits = 40", "adc.dual_gain.bits"),
        (dual, "black_level_dn = 20", "black_level_dn = 2047", "adc.dual_gain.black_level_dn"),
        (dual, "high_gain_dn_per_e = 4.0", "high_gain_dn_per_e = 0.05", "adc.dual_gain.low_gain_dn_per_e"),
        (dual, "noise_e = 5.0", "noise_e = -5.0", "adc.dual_gain.low_gain_read_noise_e"),
    ] {
        // Keys of the whole sensor come before any table.
        let text = |lines: &str| format!("{lines}\n{adc}\n{toml}");
        model(&text(lines)).expect("valid");
        assert!(lines.contains(from), "{from}");
        let error = model(&text(&lines.replacen(from, to, 1))).expect_err(to);
        assert_eq!(error.key, key, "{error}");
    }
    for (from, to, key) in [
        ("full_well_e = 10000.0", "brighter_fatter_per_e = [1e-3, 0.0]", "charge.brighter_fatter_per_e"),
        ("R.quantum_efficiency = 0.6", "R.depth_um = [0.5, 0.2]", "channels.R.depth_um"),
        ("R.quantum_efficiency = 0.6", "R = {}", "channels.R.quantum_efficiency"),
        ("G.quantum_efficiency = 0.7", "G = { quantum_efficiency = 0.7, depth_um = [0, 1] }", "channels.G.depth_um"),
    ] {
        let to = if key.starts_with("charge") {
            format!("full_well_e = 10000.0\n        charge.{to}")
        } else {
            to.to_owned()
        };
        let error = model(&TOML.replacen(from, &to, 1)).expect_err(&to);
        assert_eq!(error.key, key, "{error}");
    }
}

/// A sensor of which nothing is said but what there must be.
const BARE: &str = r#"
    resolution_px = [64, 48]
    pixel_pitch_um = [5.0, 4.0]
    cfa = "mono"
    channels.Y.quantum_efficiency = 0.6
    charge.full_well_e = 10000.0
    adc = { bits = 12, conversion_gain_dn_per_e = 0.4, black_level_dn = 64 }
"#;

#[test]
fn what_is_left_out_is_not_there() {
    let bare = model(BARE).expect("valid");
    assert_eq!(bare.noise, Noise::NONE);
    assert_eq!(bare.converter.gain_range.map(|gain| gain.0), [0.0, 0.0]);
    assert_eq!(model(&format!("{BARE}noise = {{}}")).expect("valid"), bare);
    // Any one key can stand alone.
    let read = model(&format!("{BARE}noise.read_noise_e = 3")).expect("valid");
    assert_eq!(
        read.noise,
        Noise { read_out: ReadOutNoise { read: Electrons(3.0), ..ReadOutNoise::NONE }.into(), ..Noise::NONE }
    );
    let prnu = model(&format!("{BARE}noise.prnu_percent = 1")).expect("valid");
    assert_eq!(prnu.noise, Noise { prnu: FixedPattern::of_pixels(0.01), ..Noise::NONE });
}

#[test]
fn dark_current_needs_a_temperature_and_a_law() {
    let key = |noise: &str| model(&format!("{BARE}{noise}")).expect_err(noise).key;
    assert_eq!(key("noise.dark_current_e_per_s = 2"), "noise.dark_current_reference_c");
    let celsius = "noise.dark_current_reference_c = 20";
    assert_eq!(key(&format!("noise.dark_current_e_per_s = 2\n{celsius}")), "noise.dark_current_doubling_k");
    let hot = "defects = { hot_per_million = 10, hot_dark_current_e_per_s = 100 }";
    assert_eq!(key(hot), "noise.dark_current_reference_c");
    model(&format!("{BARE}{hot}\n{celsius}\nnoise.dark_current_law = 'arrhenius'")).expect("valid");
}

#[test]
fn a_sensor_can_have_a_name_of_its_own() {
    assert_eq!(model(&format!("name = 'mine'\n{BARE}")).expect("valid").name, "mine");
    assert_eq!(model(&format!("name = ' '\n{BARE}")).expect_err("blank").key, "name");
}

#[test]
fn an_error_tells_the_wavelength_of_an_impossible_efficiency() {
    let description: SensorDescription = toml::from_str(TOML).expect("valid");
    let peak = |_: &SpectrumSource| Ok(Spectrum::from_fn(|lambda| if lambda == 612.0 { 1.25 } else { 0.5 }));
    let error = SensorModel::new("test", &description, peak).expect_err("above 1");
    assert!(error.message.contains("1.25 at 612 nm"), "{error}");
}

#[test]
fn a_misspelt_key_is_refused() {
    let error = toml::from_str::<SensorDescription>(&TOML.replace("prnu_percent", "prnu_pct")).expect_err("misspelt");
    assert!(error.to_string().contains("prnu_pct"), "{error}");
}
