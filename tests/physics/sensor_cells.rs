//! Cells that see no light, and hexagonal ones.

use photosite::cells::{CellLayout, CellShape, Hexagon, ImageCircle, REGULAR_ROWS};
use photosite::raw::PixelArea;
use photosite::sensor::{
    AutoExposure, Binning, BinningMethod, Exposure, Metering, NoiseKey, NoiseMap, RegionOfInterest, SensorModel,
    Stages, auto_exposure, expose, expose_with_maps,
};
use photosite::units::Seconds;

use crate::sensor_cases::{EXPOSURE, flat, quiet_sensor};

const SIZE: [usize; 2] = [300, 200];

fn round(diameter_px: f64) -> SensorModel {
    let mut sensor = quiet_sensor();
    sensor.resolution = SIZE;
    let pitch_m = sensor.pixel_pitch_m;
    sensor.cells.image_circle = Some(ImageCircle::new(diameter_px * pitch_m[0], SIZE, pitch_m));
    sensor
}

#[test]
fn pixels_within_the_circle_are_as_many_as_its_area() {
    for diameter in [50.0, 120.3, 199.0] {
        let sensor = round(diameter);
        let light = flat(&sensor, SIZE[0], SIZE[1], 5000.0);
        let (raw, maps) = expose_with_maps(
            &light,
            &sensor,
            &EXPOSURE,
            Stages::NONE,
            NoiseKey::default(),
            &[NoiseMap::PhotoElectronsE],
        )
        .expect("valid");
        let lit = raw.data.iter().filter(|&&dn| dn == 6000).count();
        assert_eq!(raw.data.iter().filter(|&&dn| dn == 1000).count(), SIZE[0] * SIZE[1] - lit);
        assert_eq!(maps.planes.channels()[0].data.iter().filter(|&&e| e == 5000.0).count(), lit);
        // Gauss' circle problem: the cells along the edge, some 2·√2·d of them, are right to a half at random.
        let area = std::f64::consts::PI / 4.0 * diameter * diameter;
        assert!((lit as f64 - area).abs() < 3.0 * (2.0 * 2f64.sqrt() * diameter).sqrt(), "{lit} for {area}");
    }
}

#[test]
fn dark_corners_do_not_count_for_the_exposure() {
    let target = AutoExposure { metering: Metering::Mean(0.25), ..AutoExposure::default() };
    let [all, part] = [1e4, 100.0].map(|diameter| {
        let sensor = round(diameter);
        let light = flat(&sensor, SIZE[0], SIZE[1], 5000.0);
        auto_exposure(&light, Seconds(1.0), &sensor, &EXPOSURE, target).expect("enough light").exposure.time.0
    });
    assert_eq!(all, part);
}

#[test]
fn hexagonal_cells_are_read_out_one_by_one_from_an_even_row() {
    let mut sensor = quiet_sensor();
    sensor.resolution = SIZE;
    let shape = CellShape::Hexagonal(Hexagon::new([1.0, REGULAR_ROWS]).expect("regular"));
    sensor.cells = CellLayout { shape, image_circle: None };
    let light = flat(&sensor, SIZE[0], SIZE[1], 5000.0);
    let read = |region: RegionOfInterest| {
        expose(&light, &sensor, &Exposure { region, ..EXPOSURE }, Stages::NONE, NoiseKey::default())
    };
    assert!(read(RegionOfInterest::WHOLE).expect("valid").metadata.is_staggered);
    let part =
        |y| RegionOfInterest { pixels: Some(PixelArea { x: 3, y, width: 20, height: 11 }), ..RegionOfInterest::WHOLE };
    assert_eq!(read(part(5)).expect_err("an odd row").key, "region_px");
    assert!(read(part(4)).expect("valid").metadata.is_staggered);
    let binning = Binning { factor: [2, 2], method: BinningMethod::Mean };
    assert_eq!(
        read(RegionOfInterest { binning, ..RegionOfInterest::WHOLE }).expect_err("do not form columns").key,
        "binning"
    );
}
