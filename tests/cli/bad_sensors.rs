//! Sensors that cannot be: errors of renders, most of them in this process.

use rstest::rstest;

use crate::bad_captures::{HEAD, folder};

#[rstest]
#[case::negative_noise("[sensor.noise]\nread_noise_e = -2", "noise.read_noise_e: must not be negative", "write 0")]
#[case::no_bits("[sensor.adc]\nbits = 0", "adc.bits: must lie between 1 and 16, got 0", "for example bits = 12")]
#[case::many_bits("[sensor.adc]\nbits = 40", "adc.bits: must lie between 1 and 16, got 40", "for example bits = 12")]
#[case::black_level("[sensor.adc]\nblack_level_dn = 5000", "adc.black_level_dn: 5000 leaves no room", "less than 4095")]
#[case::efficiency("[sensor.channels.G]\nquantum_efficiency = 1.2", "quantum_efficiency: must lie between 0 and 1", "")]
#[case::no_spectrum("[sensor]\ncfa = 'rccb'", "sensor.channels.", "C")]
#[case::no_letter("[sensor.channels.W]\nquantum_efficiency = 0.5", "has no channel \"W\"", "R, G, B")]
#[case::tails("[sensor.noise]\nread_noise_degrees_of_freedom = 1.5", "must be above 2, got 1.5", "heavy tails")]
#[case::spread("[sensor.noise]\nread_noise_spread_percent = 1e300", "must lie from 0 to 1000", "same read noise")]
#[case::reset("[sensor.noise.reset]\ncapacitance_ff = -1", "noise.reset.capacitance_ff: must not be negative", "")]
#[case::flicker("[sensor.noise.flicker]\nexponent = 0", "noise.flicker.exponent: must lie above 0 and up to 2", "")]
#[case::telegraph("[sensor.noise.telegraph]\nlow_s = 0", "noise.telegraph.low_s: must be above 0", "low_s = 0.5")]
#[case::defects("[sensor.defects]\nstuck_per_million = 2e6", "defects.stuck_per_million: must lie between 0 and", "")]
#[case::crosstalk("[sensor]\ncrosstalk = [[0.1, 0.8]]", "sensor.crosstalk: must be an odd number of rows", "0.96")]
#[case::format("[sensor]\nformat = '3/4'", "sensor.format: there is no sensor format \"3/4\"", "1/3.2")]
#[case::misspelt_format("[sensor]\nformat = 'full-fram'", "sensor.format: there is no", "full-frame")]
#[case::nonlinearity("[sensor.adc]\ndnl_dn = 0.9", "adc.dnl_dn: must be at most 0.4, got 0.9", "change places")]
#[case::stage("[exposure]\nstages_off = ['red-noise']", "red-noise", "row-noise")]
#[case::interval(
    "[exposure]\ntime_s = 0.1\nframe_interval_s = 0.01",
    "frame_interval_s: 0.01 s is shorter",
    "leave it"
)]
#[case::region(
    "[exposure]\nregion_px = [790, 0, 20, 10]",
    "region_px: 20 × 10 pixels at 790, 0 do not lie within",
    "write ["
)]
#[case::parts_of_bins(
    "[exposure]\nbinning = [2, 2]\nregion_px = [1, 0, 20, 10]",
    "region_px: 20 × 10 pixels at 1, 0 do not divide into whole bins of 2 × 2",
    "multiples"
)]
#[case::large_bins(
    "[sensor]\nresolution_px = [40, 20]\n[exposure]\nbinning = [8, 16]",
    "exposure.binning: 40 × 20 pixels have no",
    "smaller"
)]
#[case::no_bins("[exposure]\nbinning = [0, 2]", "exposure.binning: must be from 1 to 16", "binning = [2, 2]")]
#[case::how_to_bin("[exposure]\nbinning_method = 'sum'", "exposure.binning_method: says how", "binning = [2, 2]")]
#[case::digital_gain("[exposure]\ndigital_gain_db = -3", "digital_gain_db: must lie from 0 to 48, got -3", "white")]
#[case::gain("[exposure]\ngain_db = 90", "gain_db: 90 dB is not among the gains", "write 0 to 24 dB")]
#[case::slow("[exposure]\niso = 1", "exposure.iso: 1 is not among the speeds", "its base ISO is")]
#[case::iso_and_gain("[exposure]\ngain_db = 6\niso = 800", "exposure.iso: cannot be combined with gain_db", "keep one")]
#[case::mean("[exposure]\nauto_mean = 1.0", "auto_mean: must lie between 0 and 1, got 1", "auto_mean = 0.18")]
#[case::two_targets(
    "[exposure]\nauto_target = 0.9\nauto_mean = 0.2",
    "auto_mean: cannot be combined with auto_target",
    "keep"
)]
#[case::no_time("[exposure]\nmax_time_s = 0", "max_time_s: must be above 0, got 0", "max_time_s = 0.04")]
#[case::compensation(
    "[exposure]\ntime_s = 1\ncompensation_ev = 1",
    "compensation_ev: only applies with automatic",
    "remove"
)]
#[case::least_gain(
    "[exposure]\nmax_time_s = 0.1\ngain_db = 6\nmax_gain_db = 3",
    "max_gain_db: must be at least 6, where the gain starts, got 3",
    "max_gain_db = 24"
)]
#[case::fixed_time(
    "[exposure]\ntime_s = 0.1\nmax_time_s = 0.2",
    "max_time_s: only applies with automatic exposure",
    "remove time_s"
)]
#[case::companding_bits(
    "[sensor.adc]\ncompanding = { bits = 14, gamma = 2 }",
    "adc.companding.bits: must lie between 1 and",
    "12"
)]
#[case::companding_curve("[sensor.adc]\ncompanding = { bits = 10 }", "adc.companding.gamma: is missing", "gamma = 2.2")]
#[case::companding_curves(
    "[sensor.adc]\ncompanding = { bits = 10, gamma = 2, knee_points_dn = [[0, 0], [4095, 1023]] }",
    "adc.companding.gamma: cannot be combined with knee_points_dn",
    "keep one"
)]
#[case::gamma(
    "[sensor.adc]\ncompanding = { bits = 10, gamma = 0.45 }",
    "gamma: must lie between 1 and 5, got 0.45",
    "2.2"
)]
#[case::knees(
    "[sensor.adc]\ncompanding = { bits = 10, knee_points_dn = [[0, 0], [900, 900], [800, 950], [4095, 1023]] }",
    "adc.companding.knee_points_dn: must rise from [0, 0] to [4095, 1023]",
    "both ends"
)]
#[case::logarithm(
    "[sensor.charge]\nlogarithmic_reference_e_per_s = 0",
    "logarithmic_reference_e_per_s: must be above 0",
    "100"
)]
#[case::single_bracket(
    "[exposure]\nbracket_ev = [0]",
    "exposure.bracket_ev: must be 2 to 32 exposures, got 1",
    "[-4, 0, 4]"
)]
#[case::twice("[exposure]\nbracket_ev = [0, 1, 1]", "exposure.bracket_ev: contains 1 twice", "for example")]
#[case::infinite("[exposure]\nbracket_ev = [0, inf]", "exposure.bracket_ev[1]: must be finite, got inf", "")]
#[case::no_time_at_all(
    "[exposure]\nbracket_times_s = [0.1, 0]",
    "exposure.bracket_times_s: must be above 0, got 0",
    "for example"
)]
#[case::bracket_and_time(
    "[exposure]\ntime_s = 1\nbracket_times_s = [0.1, 1]",
    "exposure.bracket_times_s: cannot be combined with time_s",
    "bracket_ev"
)]
#[case::bracket_of_counts(
    "[sensor]\npreset = 'swissspad2'\n[exposure]\nbracket_ev = [0, 2]",
    "exposure.bracket_ev: sensor swissspad2 counts photons",
    "write frames"
)]
#[case::bracket_and_frames(
    "[exposure]\nbracket_ev = [0, 2]\nframes = 3",
    "exposure.frames: cannot be combined with a bracket",
    "remove it"
)]
#[case::close_rows(
    "[sensor]\ncfa = 'mono'\nchannels.Y.quantum_efficiency = 0.5\nwithout = ['channels.R', 'channels.G', 'channels.B']\n\
     cells = 'hexagonal'\npixel_pitch_um = [4, 1]",
    "sensor.pixel_pitch_um: rows of hexagons lie at least half a pitch apart",
    "[4, 3.4641]"
)]
#[case::no_circle("[sensor]\nimage_circle_mm = 0", "sensor.image_circle_mm: must be above 0, got 0", "8.0")]
#[case::tiny_circle("[sensor]\nimage_circle_mm = 1e-4", "image_circle_mm: a circle of 0.0001 mm", "diameter")]
#[case::video_gamma("[sensor.video]\ngamma = 0.3", "video.gamma: must lie between 0.4 and 5, got 0.3", "0.45")]
#[case::no_clock("[sensor]\nvideo = { bandwidth_mhz = 4.2 }", "video.pixel_clock_mhz: missing", "13.5")]
#[case::no_bandwidth("[sensor.video]\npixel_clock_mhz = 13.5", "video.pixel_clock_mhz: has no effect", "4.2")]
#[case::narrow(
    "[sensor.video]\npixel_clock_mhz = 10\nbandwidth_mhz = 1e-4",
    "video.bandwidth_mhz: 0.0001 MHz",
    "at least"
)]
#[case::mosaic(
    "[sensor]\nframe_grabber = { size_px = [40, 30] }",
    "sensor.frame_grabber: cannot be combined with a mosaic",
    "keep"
)]
#[case::no_samples("[sensor.frame_grabber]\nsize_px = [40, 0]", "frame_grabber.size_px: must lie between 1", "[768")]
#[case::counts(
    "[sensor]\npreset = 'swissspad2'\nvideo.gamma = 2",
    "sensor.video: cannot be combined with kind = \"spad\"",
    "keep one"
)]
#[case::control_of_auto(
    "[exposure]\ngain_control = {}",
    "exposure.gain_control: cannot be combined with automatic",
    "keep"
)]
#[case::no_target(
    "[exposure]\ntime_s = 1\ngain_control = { target = 1 }",
    "gain_control.target: must lie between 0 and 1",
    "0.18"
)]
#[case::no_attack(
    "[exposure]\ntime_s = 1\ngain_control = { attack = 0 }",
    "gain_control.attack: must lie above 0",
    "0.3"
)]
#[case::wide_limits(
    "[exposure]\ntime_s = 1\ngain_control = { limits_db = [0, 99] }",
    "gain_control.limits_db: [0, 99] dB are not",
    "from 0 to 24 dB"
)]
fn impossible_sensors_are_refused_with_key_and_line(#[case] more: &str, #[case] message: &str, #[case] help: &str) {
    // A table that should not be there is at fault from its first line on, a value in its own.
    let line = if message.starts_with("has no channel") { 4 } else { 3 + more.lines().count() };
    // What a preset lacks has no line.
    let place =
        if message == "sensor.channels." { "capture.toml:".to_owned() } else { format!("capture.toml:{line}: ") };
    folder(format!("{HEAD}{more}\n")).refuse("capture.toml", &[&place, message, help]);
}

/// `preset` and `without` are read before the other keys of a sensor.
#[rstest]
#[case("sensor.preste=x", "did you mean `preset`?")]
#[case("sensor.withut=['adc']", "did you mean `without`?")]
fn keys_that_make_a_sensor_are_known_as_the_others(#[case] set: &str, #[case] meant: &str) {
    let folder = folder(HEAD.to_owned());
    folder.fail(&format!("render capture.toml --set {set}"), 1, &[meant, "; and ", "preset", "without"]);
}

#[test]
fn errors_in_a_sensor_file_of_ones_own_name_its_line() {
    let preset = include_str!("../../crates/photosite-sensor/assets/sensors/sony-imx249-mono.toml");
    for (key, wrong) in [("read_noise_e", "-1.0"), ("bits", "40"), ("full_well_e", "0")] {
        let folder = folder(format!("{HEAD}[sensor]\npreset = 'mine.toml'\n"));
        let line = preset.lines().position(|line| line.starts_with(&format!("{key} ="))).expect("the key");
        let lines: Vec<String> = preset
            .lines()
            .enumerate()
            .map(|(i, text)| if i == line { format!("{key} = {wrong}") } else { text.to_owned() })
            .collect();
        folder.add("mine.toml", lines.join("\n").replace("../../../photosite-core/assets/spectra/", "spectra/"));
        let curve = include_str!("../../crates/photosite-core/assets/spectra/quantum-efficiency/sony-imx249-mono.csv");
        folder.add("spectra/quantum-efficiency/sony-imx249-mono.csv", curve);
        // The value is in the line that is shown.
        folder.fail("render capture.toml", 1, &[&format!("mine.toml:{}: ", line + 1), key, wrong]);
    }
}

#[test]
fn a_sensor_file_stands_on_no_preset() {
    let folder = folder(format!("{HEAD}[sensor]\npreset = 'mine.toml'\n"));
    folder.add("mine.toml", "serial = 7\npreset = 'sony-imx249-mono'\n");
    folder.fail("render capture.toml", 1, &["mine.toml:2: ", "`preset` stands in [sensor] of a capture", "all keys"]);
}

/// A table of defective pixels is of one sensor: of its places, and of its numbers.
#[test]
fn defective_pixels_of_another_size_or_other_bits_are_told() {
    let table = "column,row,kind,value\n1,1,stuck,200\n0,0,dead,\n";
    let preset = include_str!("../../crates/photosite-sensor/assets/sensors/sony-imx249-mono.toml");
    let folder = folder(format!("{HEAD}[sensor]\npreset = 'mine.toml'\n"));
    let own = preset.replace("../../../photosite-core/assets/spectra/", "spectra/");
    folder.add("mine.toml", format!("{own}\n[defects]\npixels = {{ file = 'defects.csv' }}\n"));
    folder.add("defects.csv", table);
    let curve = include_str!("../../crates/photosite-core/assets/spectra/quantum-efficiency/sony-imx249-mono.csv");
    folder.add("spectra/quantum-efficiency/sony-imx249-mono.csv", curve);
    folder.fail("render capture.toml --size 32x24", 1, &["scaled_to_px", "cannot be combined with defects.pixels"]);
    let small = "--set sensor.resolution_px=[32,24]";
    let said = folder.succeed(&format!("render capture.toml {small} --spp 1 -o twelve")).stderr;
    assert!(!said.contains("stuck pixels"), "{said}");
    let said = folder.succeed(&format!("render capture.toml {small} --set sensor.adc.bits=10 --spp 1 -o ten")).stderr;
    assert!(said.contains("sensor.defects.pixels: numbers of stuck pixels stay"), "{said}");
    folder.fail(&format!("render capture.toml {small} --set sensor.adc.bits=7 -o x"), 1, &["line 2", "0 to 127"]);
}

/// Bytes of an NPY array of 4 × 4 values of a type.
fn array(kind: &str, values: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (4, 4), }}");
    let padded = format!("{header:<117}\n");
    [&b"\x93NUMPY\x01\x00v\x00"[..], padded.as_bytes(), values].concat()
}

#[rstest]
#[case::other_size(5, array("<f4", &1f32.to_le_bytes().repeat(16)), "is of 4 × 4 pixels, and the image of 4 × 5", "all pixels")]
#[case::not_finite(4, array("<f4", &f32::NAN.to_le_bytes().repeat(16)), "map.npy: holds NaN at column 0, row 0", "NPY image of floats")]
#[case::whole_numbers(4, array("<u2", &1u16.to_le_bytes().repeat(16)), "map.npy", "NPY image of floats")]
#[case::dark(4, array("<f4", &0f32.to_le_bytes().repeat(16)), "has a mean of 0", "about 1 of most")]
#[case::no_map(4, b"map".to_vec(), "map.npy", "NPY image of floats")]
fn maps_that_cannot_be_are_named(#[case] rows: u32, #[case] bytes: Vec<u8>, #[case] message: &str, #[case] help: &str) {
    let sensor = "noise.prnu_map = { file = 'map.npy' }\nnoise.prnu_percent = 0";
    let folder = folder(format!("{HEAD}[sensor]\n{sensor}\nresolution_px = [4, {rows}]\n"));
    folder.add("map.npy", bytes);
    folder.fail("render capture.toml", 1, &["capture.toml:5", "sensor.noise.prnu_map", message, help]);
    // The option that names another file is told, not the line that it takes the place of.
    let other = "render capture.toml --set sensor.noise.prnu_map.file=none.npy";
    folder.fail(other, 1, &["--set sensor.noise.prnu_map.file=none.npy", "cannot read", "relative to the file"]);
}
