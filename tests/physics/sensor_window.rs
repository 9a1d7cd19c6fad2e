//! Parts of a sensor that are read out: regions, and pixels that are read out as one.

use photosite::image::Planes;
use photosite::math::statistics::Moments;
use photosite::raw::{Cfa, PixelArea, RawImage};
use photosite::sensor::{
    AutoExposure, Binning, BinningMethod, Exposure, Metering, NoiseKey, RegionOfInterest, SensorModel, Stage, Stages,
    auto_exposure, expose,
};
use photosite::units::{Electrons, Seconds};
use rstest::rstest;

use crate::sensor_cases::{EXPOSURE, flat, noisy_sensor_with, quiet_sensor};

const SIDE: usize = 256;
const KEY: NoiseKey = NoiseKey { seed: 11, frame: 3 };

fn read_out(sensor: &SensorModel, light: &Planes, region: RegionOfInterest) -> RawImage {
    expose(light, sensor, &Exposure { region, ..EXPOSURE }, Stages::ALL, KEY).expect("a valid exposure")
}

fn binned(factor: [usize; 2], method: BinningMethod) -> RegionOfInterest {
    RegionOfInterest { binning: Binning { factor, method }, pixels: None }
}

#[rstest]
#[case::cmos(Stage::ReadNoise, Binning::NONE)]
#[case::ccd(Stage::Smear, Binning { factor: [2, 2], method: BinningMethod::Charge })]
#[case::bins(Stage::LowGainReadNoise, Binning { factor: [2, 1], method: BinningMethod::Mean })]
fn a_region_is_a_part_of_the_whole_image(#[case] kind: Stage, #[case] binning: Binning) {
    let mut sensor = noisy_sensor_with(kind);
    sensor.masked.columns = [2, 4];
    let light = flat(&sensor, 40, 30, 2000.0);
    let (x, y, width, height) = (6, 2, 24, 20);
    let whole = read_out(&sensor, &light, RegionOfInterest { binning, pixels: None });
    let part = read_out(&sensor, &light, RegionOfInterest { binning, pixels: Some(PixelArea { x, y, width, height }) });
    let ([across, down], first) = (binning.factor, whole.active());
    assert_eq!((part.width, part.height, part.active_area), (width / across, height / down, None));
    for (row, numbers) in part.data.chunks(part.width).enumerate() {
        let start = (first.y + y / down + row) * whole.width + first.x + x / across;
        assert_eq!(numbers, &whole.data[start..][..part.width], "row {row}");
    }
}

#[rstest]
#[case::mono("mono", [7, 3], [5, 10])]
#[case::bayer("RGGB", [3, 3], [12, 10])]
fn what_makes_no_whole_bin_is_left_out(#[case] cfa: &str, #[case] factor: [usize; 2], #[case] bins: [usize; 2]) {
    let mut sensor = quiet_sensor();
    sensor.cfa = Cfa::parse(cfa).expect("a layout");
    for method in [BinningMethod::Charge, BinningMethod::Sum, BinningMethod::Mean] {
        let raw = read_out(&sensor, &flat(&sensor, 40, 30, 100.0), binned(factor, method));
        raw.validate().expect("a whole image");
        assert_eq!(([raw.width, raw.height], raw.active_area), (bins, None), "{method:?}");
    }
}

#[test]
fn a_region_keeps_the_colours_of_its_pixels() {
    let mut sensor = quiet_sensor();
    sensor.cfa = Cfa::parse("RGGB").expect("a Bayer tile");
    let mut light = Planes::zeros(8, 8, sensor.cfa.channels());
    for (channel, mean_e) in light.channels_mut().iter_mut().zip([1000.0, 2000.0, 3000.0]) {
        channel.data.fill(mean_e);
    }
    let region =
        RegionOfInterest { pixels: Some(PixelArea { x: 3, y: 2, width: 4, height: 4 }), ..RegionOfInterest::WHOLE };
    let exposure = Exposure { region, ..EXPOSURE };
    let raw = expose(&light, &sensor, &exposure, Stages::NONE, KEY).expect("a valid exposure");
    assert_eq!(raw.cfa, Cfa::parse("GRBG").expect("a Bayer tile"));
    assert_eq!(raw.data[..4], [3000, 2000, 3000, 2000]);
    assert_eq!(raw.data[4..8], [4000, 3000, 4000, 3000]);
}

/// Mean and variance in DN at 1 DN/e⁻ of bins of `n` pixels of μ photo-electrons and a read noise of σ:
/// - charge is read out once: n·μ, n·μ + σ² + 1/12;
/// - numbers each bring noise and rounding: n·μ, n·(μ + σ² + 1/12), over n and n² for the mean, which is rounded again.
#[rstest]
#[case::charge(BinningMethod::Charge, 2000.0, 2000.0 + 400.0 + 1.0 / 12.0)]
#[case::sum(BinningMethod::Sum, 2000.0, 4.0 * (500.0 + 400.0 + 1.0 / 12.0))]
#[case::mean(BinningMethod::Mean, 500.0, (500.0 + 400.0 + 1.0 / 12.0) / 4.0 + 1.0 / 12.0)]
fn bins_have_the_noise_of_their_method(#[case] method: BinningMethod, #[case] mean_dn: f64, #[case] variance: f64) {
    let mut sensor = quiet_sensor();
    sensor.noise.read_out.change(|noise| noise.read = Electrons(20.0));
    let region = binned([2, 2], method);
    let raw = read_out(&sensor, &flat(&sensor, SIDE, SIDE, 500.0), region);
    assert_eq!((raw.width, raw.height), (SIDE / 2, SIDE / 2));
    let found: Moments = raw.data.iter().map(|&dn| f64::from(dn) - 1000.0).collect();
    let n = raw.data.len() as f64;
    // 5 σ of the mean and of the variance of n normal numbers.
    assert!((found.mean() - mean_dn).abs() < 5.0 * (variance / n).sqrt(), "{} for {mean_dn}", found.mean());
    assert!((found.variance() / variance - 1.0).abs() < 5.0 * (2.0 / n).sqrt(), "{} for {variance}", found.variance());

    let exposure = Exposure { region, ..EXPOSURE };
    let predicted = sensor.noise_variance(Electrons(4.0 * 500.0), &exposure) * sensor.system_gain(&exposure).powi(2);
    assert!((predicted / variance - 1.0).abs() < 1e-12, "{predicted} for {variance}");
    // x = (DN − black)/range.
    let [slope, offset] = raw.metadata.noise_profile[0];
    let range = f64::from(raw.white_level_dn - 1000);
    let stated = (slope * mean_dn / range + offset) * range * range;
    assert!((stated / variance - 1.0).abs() < 1e-12, "{stated} for {variance}");
}

#[test]
fn pixels_of_a_row_keep_its_noise_in_their_mean() {
    let mut sensor = quiet_sensor();
    sensor.noise.read_out.change(|noise| noise.row = Electrons(100.0));
    let region = binned([4, 2], BinningMethod::Mean);
    let light = flat(&sensor, 16, 8192, 500.0);
    let exposure = Exposure { region, ..EXPOSURE };
    let raw = expose(&light, &sensor, &exposure, Stages::only(&[Stage::RowNoise]), KEY).expect("valid");
    let rows: Moments = raw.data.chunks(4).map(|row| f64::from(row[0])).collect();
    // Two rows a bin; 5 σ of a variance of 4096 rows.
    let expected = 100.0 * 100.0 / 2.0;
    assert!((rows.variance() / expected - 1.0).abs() < 5.0 * (2.0f64 / 4096.0).sqrt(), "{}", rows.variance());
    sensor.noise.read_out.change(|noise| noise.read = Electrons(0.0));
    let predicted = sensor.noise_variance(Electrons(0.0), &exposure) * sensor.system_gain(&exposure).powi(2);
    // Rounding of eight numbers and of their mean.
    let rounding = (1.0 / 8.0 + 1.0) / 12.0;
    assert!((predicted - expected - rounding).abs() < 1e-9, "{predicted}");
}

/// 64 535 DN above black at 1 DN/e⁻, a full well of 60 000 e⁻.
#[rstest]
#[case::charge(BinningMethod::Charge, 64_535.0, 65_535)]
#[case::sum(BinningMethod::Sum, 64_535.0, 65_535)]
#[case::mean(BinningMethod::Mean, 4.0 * 60_000.0, 61_000)]
fn bins_saturate_where_well_or_converter_end(#[case] method: BinningMethod, #[case] bin_e: f64, #[case] white: u16) {
    let sensor = quiet_sensor();
    let region = binned([2, 2], method);
    let exposure = Exposure { region, ..EXPOSURE };
    assert_eq!(sensor.saturation_capacity(&exposure), Electrons(bin_e));
    assert_eq!(sensor.pixel_saturation(&exposure), Electrons(bin_e / 4.0));
    let raw = read_out(&sensor, &flat(&sensor, 8, 8, 1e6), region);
    assert_eq!(raw.white_level_dn, white);
    assert!(raw.data.iter().all(|&dn| dn == white));
}

#[test]
fn exposure_and_speed_know_of_bins() {
    let sensor = quiet_sensor();
    let target = AutoExposure { metering: Metering::Mean(0.5), ..AutoExposure::default() };
    let light = flat(&sensor, 64, 64, 1000.0);
    for (method, capacity) in
        [(BinningMethod::Charge, 64_535.0 / 4.0), (BinningMethod::Sum, 64_535.0 / 4.0), (BinningMethod::Mean, 60_000.0)]
    {
        let wanted = Exposure { region: binned([2, 2], method), ..EXPOSURE };
        let found = auto_exposure(&light, Seconds(1.0), &sensor, &wanted, target).expect("light").exposure;
        // 1000 e⁻/s fill half of what a pixel may hold.
        assert!((found.time.0 / (0.5 * capacity / 1000.0) - 1.0).abs() < 1e-12, "{method:?}: {:?}", found.time);
        let speed = |exposure: &Exposure| sensor.iso(exposure).expect("linear");
        assert!((speed(&wanted) / speed(&EXPOSURE) - 60_000.0 / capacity).abs() < 1e-12, "{method:?}");
        let [gain, digital] = sensor.gains_for_iso(3.0 * speed(&wanted), wanted.region.binning).expect("fast enough");
        let fast = Exposure { gain, digital_gain: digital, ..wanted };
        assert!((speed(&fast) / speed(&wanted) - 3.0).abs() < 1e-9, "{method:?}");
    }
}
