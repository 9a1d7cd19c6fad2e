//! Whole exposures against those of the processor: all presets, every stage, shapes of images, and refusals.

use photosite_core::image::Planes;
use photosite_core::units::{Decibels, Electrons, Seconds};
use photosite_gpu::Card;
use photosite_sensor::packed::{PackedExposure, PackedLight};
use photosite_sensor::{
    Binning, BinningMethod, Exposure, MaskedPixels, MeasuredPattern, NoiseKey, SensorDescription, SensorModel, Stage,
    Stages, expose, presets,
};

const KEY: NoiseKey = NoiseKey { seed: 11, frame: 3 };

/// Keys of all effects that a card has, of which no preset has any.
const EFFECTS: &str = "
crosstalk = [[0.0, 0.05, 0.0], [0.06, 0.8, 0.05], [0.0, 0.04, 0.0]]
[noise]
prnu_row_percent = 0.5
prnu_column_percent = 0.7
dsnu_row_e = 1.5
dsnu_column_e = 1.2
row_noise_e = 3.0
column_noise_e = 3.0
reset.noise_e = 5.0
transmission_errors_per_million = 5000.0
dark_current_nonuniformity_percent = 50.0
read_noise_spread_percent = 30.0
[adc]
column_gain_percent = 2.0
column_offset_dn = 3.0
dnl_dn = 0.3
[defects]
dead_per_million = 20000.0
stuck_per_million = 20000.0
hot_per_million = 20000.0
hot_dark_current_e_per_s = 1000.0
";

/// Preset with keys laid over it.
fn with_keys(preset: &str, keys: &str) -> SensorModel {
    let mut table = presets::table(preset).expect("a preset");
    let mut over = table.clone();
    over.clone_from(&keys.parse().expect("TOML"));
    for (key, value) in over {
        match (table.get_mut(&key).and_then(|known| known.as_table_mut()), value.as_table()) {
            (Some(known), Some(new)) => known.extend(new.clone()),
            _ => drop(table.insert(key, value)),
        }
    }
    let description: SensorDescription = table.try_into().expect("keys of a sensor");
    SensorModel::new(preset, &description, presets::library_spectrum).expect("a sensor")
}

/// Light that rises from darkness to one and a half full wells, in each channel in its own way.
fn ramp(sensor: &SensorModel, [width, height]: [usize; 2]) -> Planes {
    let mut planes = Planes::zeros(width, height, sensor.cfa.channels());
    for (channel, plane) in planes.channels_mut().iter_mut().enumerate() {
        for (i, value) in plane.data.iter_mut().enumerate() {
            let (x, y) = ((i % width) as f32 / width as f32, (i / width) as f32 / height as f32);
            *value = sensor.full_well.0 as f32 * (1.5 - 0.4 * channel as f32) * x.powi(3) * (0.6 + 0.4 * y);
        }
    }
    planes
}

fn exposure_of(sensor: &SensorModel) -> Exposure {
    // The lines of a scanning sensor follow each other.
    Exposure::of(Seconds(if sensor.shutter.scans() { 1e-5 } else { 0.05 }))
}

/// Pixels of both that differ, and by how much at most, DN; the processor's image with all else the same.
fn compare(
    card: &Card,
    light: &Planes,
    sensor: &SensorModel,
    exposure: &Exposure,
    stages: Stages,
) -> Result<(usize, u16), photosite_core::Invalid> {
    let found = card.expose(light, sensor, exposure, stages, KEY)?;
    let expected = expose(light, sensor, exposure, stages, KEY)?;
    let apart = found.data.iter().zip(&expected.data).map(|(a, b)| a.abs_diff(*b));
    let result = (apart.clone().filter(|d| *d > 0).count(), apart.max().unwrap_or(0));
    let with_numbers = photosite_raw::RawImage { data: expected.data.clone(), ..found };
    assert_eq!(with_numbers, expected, "{}", sensor.name);
    Ok(result)
}

#[test]
fn presets_are_exposed_as_on_the_processor() {
    let Some(card) = crate::card() else { return };
    let mut exposed = Vec::new();
    for sensor in presets::names().filter_map(presets::model) {
        let light = ramp(&sensor, [512, 128]);
        match compare(card, &light, &sensor, &exposure_of(&sensor), Stages::ALL) {
            Ok((different, most)) => {
                println!("{}: {different} of 65536 pixels differ, by {most} DN at most", sensor.name);
                // All numbers are rounded alike, so that a digital number differs where a count of electrons does: by
                // the numbers of an electron or more, and in one of ten millions (`sensor_numbers`), 0.013 of these for
                // light and heat.
                assert!(different <= 1, "{}: {different} differ, by {most} DN at most", sensor.name);
                exposed.push(sensor.name.clone());
            }
            Err(refusal) => assert!(["sensor.ccd", "sensor.spad"].contains(&refusal.key.as_str()), "{refusal:?}"),
        }
    }
    assert_eq!(exposed.len(), 9, "{exposed:?}");
}

#[test]
fn every_stage_alone_or_left_out_is_exposed_alike_or_refused_by_key() {
    let Some(card) = crate::card() else { return };
    let all = presets::names().filter_map(presets::model);
    let others = ["generic-cmos-color", "automotive-hdr-color"].map(|preset| {
        let without_columns = EFFECTS.replace("column_gain_percent = 2.0\ncolumn_offset_dn = 3.0\n", "");
        with_keys(preset, if preset.starts_with("automotive") { &without_columns } else { EFFECTS })
    });
    let refused = with_keys(
        "generic-cmos-color",
        "[noise]\nflicker.noise_e = 3.0\ntelegraph = { pixels_per_million = 50000.0, amplitude_e = 50.0 }\n\
         [charge]\nbrighter_fatter_per_e = [3e-7, 3e-7]\nimage_lag.percent = 5.0\n",
    );
    let (mut exposed, mut refusals) = (0, std::collections::BTreeSet::new());
    for sensor in all.chain(others).chain([refused]) {
        let light = ramp(&sensor, [46, 10]);
        let exposure = exposure_of(&sensor);
        let without = Stage::ALL.map(|stage| Stages::ALL.without(stage));
        let alone = Stage::ALL.map(|stage| Stages::NONE.with(stage));
        // Stages that the sensor has not change nothing.
        let has = |i: &usize| sensor.has_stage(Stage::ALL[*i]);
        let chosen = (0..Stage::ALL.len()).filter(has).flat_map(|i| [without[i], alone[i]]);
        for stages in chosen.chain([Stages::NONE, Stages::ALL]) {
            match compare(card, &light, &sensor, &exposure, stages) {
                Ok((different, most)) => {
                    exposed += 1;
                    assert_eq!((different, most), (0, 0), "{} with {stages:?}", sensor.name);
                }
                Err(refusal) => drop(refusals.insert(refusal.key)),
            }
        }
    }
    let keys: Vec<&str> = refusals.iter().map(String::as_str).collect();
    let expected = [
        "sensor.ccd",
        "sensor.charge.brighter_fatter_per_e",
        "sensor.charge.image_lag",
        "sensor.noise.flicker.noise_e",
        "sensor.noise.telegraph.pixels_per_million",
        "sensor.spad",
    ];
    assert_eq!(keys, expected);
    assert!(exposed > 150, "{exposed}");
}

#[test]
fn masked_pixels_odd_widths_gains_and_curves_are_exposed_alike() {
    let Some(card) = crate::card() else { return };
    let masked = |sensor: SensorModel| SensorModel { masked: MaskedPixels { columns: [3, 2], rows: [1, 2] }, ..sensor };
    let effects = with_keys("generic-cmos-color", EFFECTS);
    let size = [31, 9];
    let pattern = |scale: f32| {
        let values = (0..31 * 9).map(|i| scale * ((i * 7 % 13) as f32 / 6.0 - 1.0)).collect();
        Some(MeasuredPattern::new(size, values).expect("finite values"))
    };
    let mut measured = SensorModel { resolution: size, ..effects.clone() };
    (measured.noise.prnu_map, measured.noise.dsnu_map) = (pattern(0.05), pattern(4.0));
    let companding = "[adc.companding]\nbits = 8\ngamma = 2.0\n";
    for sensor in [
        masked(effects.clone()),
        masked(presets::model("generic-stacked-color").expect("a preset")),
        measured,
        with_keys("generic-cmos-color", "image_circle_mm = 0.15\n"),
        with_keys("generic-cmos-color", companding),
    ] {
        let light = ramp(&sensor, size);
        // 2.5 thermal electrons on average, and after minutes more than the twelve from which they are drawn otherwise
        for (time, gain, digital_gain) in [(0.5, 0.0, 0.0), (100.0, 9.5, 3.3)] {
            let (gain, digital_gain) = (Decibels(gain), Decibels(digital_gain));
            let exposure = Exposure { gain, digital_gain, ..Exposure::of(Seconds(time)) };
            let (different, most) = compare(card, &light, &sensor, &exposure, Stages::ALL).expect("an exposure");
            assert_eq!((different, most), (0, 0), "{} {:?}", sensor.name, sensor.resolution);
        }
    }
}

#[test]
fn amplifiers_and_converters_that_bend_differ_by_rounding_alone() {
    let Some(card) = crate::card() else { return };
    let bent = "[adc]\namplifier_nonlinearity_percent = [-5.0, 1.0]\ninl_dn = 3.0\ndnl_dn = 0.3\n";
    let sensor = with_keys("generic-cmos-color", bent);
    let light = ramp(&sensor, [512, 256]);
    let (different, most) = compare(card, &light, &sensor, &exposure_of(&sensor), Stages::ALL).expect("an exposure");
    // Where the processor has f64, a card has f32: a signal of up to 2¹² DN is 2⁻¹¹ DN apart at most (an ulp), and bow
    // and displacement, of up to 4 DN, three roundings of 2⁻²³ more. A threshold lies in such a gap of both sides, on
    // average over the ramp with half of that signal.
    let pixels = (512 * 256) as f64;
    let expected = pixels * (0.5 * 2f64.powi(-11) + 3.0 * 2f64.powi(-23));
    println!("{different} of {pixels} pixels differ, by {most} DN at most; {expected} could");
    assert!(most <= 1 && different as f64 <= expected + 4.0 * expected.sqrt(), "{different} by {most}");
}

#[test]
fn light_without_electrons_and_beyond_all_wells_is_exposed_alike() {
    let Some(card) = crate::card() else { return };
    let sensor = presets::model("generic-cmos-color").expect("a preset");
    let mut light = Planes::zeros(64, 16, sensor.cfa.channels());
    let levels = [0.0, 1e-40, 1e-20, 3e-4, 12f32.next_down(), 12.0, 1e6, 2e9, 3e9, 2e15, 1e20, 3e38];
    for plane in light.channels_mut() {
        (0..plane.data.len()).for_each(|i| plane.data[i] = levels[i % 64 / 5 % levels.len()]);
    }
    for stages in [Stages::ALL, Stages::ALL.without(Stage::FullWell)] {
        let compared = compare(card, &light, &sensor, &exposure_of(&sensor), stages).expect("an exposure");
        assert_eq!(compared, (0, 0));
    }
}

#[test]
fn held_light_is_exposed_again_and_again_with_the_same_bytes() {
    let Some(card) = crate::card() else { return };
    let sensor = presets::model("sony-imx249-color").expect("a preset");
    let light = ramp(&sensor, [130, 40]);
    let exposure = exposure_of(&sensor);
    let mut held = card.hold_light(&PackedLight::new(&light, &sensor).expect("light")).expect("room");
    let pack = |frame| {
        let key = NoiseKey { frame, ..KEY };
        PackedExposure::new([130, 40], &sensor, &exposure, Stages::ALL, key).expect("an exposure")
    };
    let takes = [0, 1, 0].map(|frame| held.expose(&pack(frame)).expect("an exposure"));
    assert!(takes[0] == takes[2] && takes[0] != takes[1]);
    for (take, frame) in takes.iter().zip([0, 1, 0]) {
        let expected = expose(&light, &sensor, &exposure, Stages::ALL, NoiseKey { frame, ..KEY }).expect("an exposure");
        assert!(*take == expected, "frame {frame}");
    }
    let brighter = ramp(&SensorModel { full_well: Electrons(1.5 * sensor.full_well.0), ..sensor.clone() }, [130, 40]);
    held.replace(&PackedLight::new(&brighter, &sensor).expect("light")).expect("light of the same layout");
    let take = held.expose(&pack(2)).expect("an exposure");
    let expected = expose(&brighter, &sensor, &exposure, Stages::ALL, NoiseKey { frame: 2, ..KEY });
    assert!(take == expected.expect("an exposure"));
    let mono = presets::model("sony-imx249-mono").expect("a preset");
    assert!(held.replace(&PackedLight::new(&ramp(&mono, [130, 40]), &mono).expect("light")).is_err());
    for (image, sensor) in [([128, 40], &sensor), ([130, 40], &mono)] {
        let other = PackedExposure::new(image, sensor, &exposure, Stages::ALL, KEY).expect("an exposure");
        assert!(held.expose(&other).is_err_and(|refusal| refusal.message.contains("do not suit")));
    }
}

#[test]
fn what_a_card_does_not_do_is_named_by_its_key() {
    let preset = |name| presets::model(name).expect("a preset");
    let keys = |text| with_keys("generic-cmos-color", text);
    let of = |sensor: &SensorModel, change: fn(&mut Exposure)| {
        let mut exposure = exposure_of(sensor);
        change(&mut exposure);
        PackedExposure::new([64, 32], sensor, &exposure, Stages::ALL, KEY).err().map(|refusal| refusal.key)
    };
    let whole = |_: &mut Exposure| {};
    let binned =
        |exposure: &mut Exposure| exposure.region.binning = Binning { factor: [2, 2], method: BinningMethod::Sum };
    let colour = preset("generic-cmos-color");
    for (key, found) in [
        ("sensor.ccd", of(&preset("textbook-ccd"), whole)),
        ("sensor.spad", of(&preset("swissspad2"), whole)),
        ("exposure.binning", of(&colour, binned)),
        ("gain_db", of(&colour, |exposure| exposure.gain = Decibels(1e3))),
        (
            "sensor.noise.read_noise_degrees_of_freedom",
            of(&keys("[noise]\nread_noise_degrees_of_freedom = 4.0\n"), whole),
        ),
        (
            "sensor.charge.logarithmic_reference_e_per_s",
            of(&keys("[charge]\nlogarithmic_reference_e_per_s = 1e5\n"), whole),
        ),
        ("sensor.noise.flicker.noise_e", of(&keys("[noise]\nflicker.noise_e = 1.0\n"), whole)),
    ] {
        assert_eq!(found.as_deref(), Some(key));
    }
    assert_eq!(of(&colour, whole), None);
}
