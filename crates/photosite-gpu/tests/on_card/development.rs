//! Images that are developed on a card against the processor's, for every kind of raw image and every value of every
//! setting.

use photosite_core::colour::ColourSpace;
use photosite_core::projection::{Intrinsics, Projection};
use photosite_develop::packed::PackedDevelopment;
use photosite_develop::{Demosaic, DevelopSettings, Highlights, ToneCurve, develop};
use photosite_gpu::probe::develop_in_strips;
use photosite_raw::{
    AreaSpec, BlackLevel, Cfa, Distortion, GainMap, LensModel, Opcode, Orientation, PerLine, PixelArea, RawImage, Reach,
};
use serde_json::{Map, Value, json};

use crate::card;
use crate::developed::{Tally, check, compare};
use crate::raws::{BLACK_DN, falloff, raw};

/// All layouts that a card knows.
const LAYOUTS: [&str; 6] = ["RGGB", "GRBG", "GBRG", "BGGR", "mono", "full:RGB"];
const SIZES: [[usize; 2]; 8] = [[1, 1], [2, 2], [1, 9], [9, 1], [3, 2], [37, 23], [300, 140], [64, 64]];

fn is_of_bayer(layout: &str) -> bool {
    Cfa::parse(layout).is_ok_and(|cfa| cfa.is_bayer())
}

#[test]
fn images_of_every_layout_and_size_are_those_of_the_processor() {
    let Some(card) = card() else { return };
    let mut all = Tally::default();
    for layout in LAYOUTS {
        let methods: &[Demosaic] = if is_of_bayer(layout) {
            &[Demosaic::Auto, Demosaic::Malvar, Demosaic::Bilinear]
        } else {
            &[Demosaic::Auto]
        };
        for (size, demosaic) in SIZES.into_iter().flat_map(|size| methods.iter().map(move |method| (size, *method))) {
            for (bits, highlights) in [(8, Highlights::Clip), (16, Highlights::None)] {
                let settings = DevelopSettings { demosaic, bits, highlights, ..DevelopSettings::default() };
                let name = format!("{layout} {size:?} {demosaic:?} {bits} bits");
                let tally = compare(card, &name, &raw(layout, size), &settings).expect("a card has it");
                if size == [300, 140] {
                    println!("{name}: {tally:?}");
                }
                all.add(tally);
            }
        }
    }
    println!("{all:?}");
    // Roundings know nothing of each other, so that the bound of 145 and more is a dozen times as far as they reach,
    // and of the values that are as near to a level a dozenth comes to lie beyond it at most.
    assert!((all.differing - all.by_ties) * 12 < all.near_levels, "{all:?}");
    // A sum of changes is near another by chance alone: both have a spread of the noise, 1e-2 and more, and are within
    // 2e-4 of each other in some hundredths. Of those the processor's rounding decides one in ten, and 11 × 11 pixels
    // lie around each.
    assert!(all.by_ties * 10 < all.codes, "{all:?}");
}

#[test]
fn strips_make_the_same_image() {
    let Some(card) = card() else { return };
    for layout in LAYOUTS {
        for number in [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0] {
            let mut raw = raw(layout, [61, 47]);
            raw.metadata.orientation = Orientation::of_number(number).expect("one of eight");
            // Strips begin at odd numbers, too
            raw.active_area = Some(PixelArea { x: 3, y: 2, width: 55, height: 44 });
            raw.metadata.default_crop = Some(PixelArea { x: 4, y: 3, width: 41, height: 38 });
            let settings = DevelopSettings::default();
            let packed = PackedDevelopment::new(&raw, &settings).expect("a card has it");
            let whole = card.develop(&raw, &packed).expect("an image");
            check(&format!("{layout} {number}"), &raw, &settings, &packed, &whole);
            for pixels in [1 << 22, 75 * 25, 75 * 33] {
                let sent = develop_in_strips(card, &raw.data, &packed, pixels).expect("an image");
                assert!(whole == sent, "{layout} {number}: strips of {pixels} pixels");
            }
        }
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let Some(card) = card() else { return };
    let raw_image = raw("RGGB", [20, 12]);
    let packed = PackedDevelopment::new(&raw_image, &DevelopSettings::default()).expect("a card has it");
    let other = card.develop(&raw("RGGB", [12, 20]), &packed).expect_err("another size");
    assert!(other.message.contains("12 × 20") && other.message.contains("20 × 12"), "{other}");
    // A row and its margin do not fit.
    let narrow = develop_in_strips(card, &raw_image.data, &packed, 40 * 20).expect_err("too long");
    assert!(narrow.key == "develop" && narrow.message.contains("40 pixels"), "{narrow}");
    let nothing = raw("RGGB", [0, 0]);
    let packed = PackedDevelopment::new(&nothing, &DevelopSettings::default()).expect("a card has it");
    let image = card.develop(&nothing, &packed).expect("an empty image");
    assert_eq!(image, develop(&nothing, &DevelopSettings::default()).expect("an empty image"));
}

/// A change of a raw image.
type Change = fn(&mut RawImage);

/// The whole of an image of 37 × 23 pixels, or every second pixel of it from the second on.
fn area(pitch: usize) -> AreaSpec {
    let first = pitch - 1;
    AreaSpec {
        area: PixelArea { x: first, y: first, width: 37 - first, height: 23 - first },
        pitch: [pitch; 2],
        plane: 0,
        planes: 3,
    }
}

#[test]
fn facts_about_a_raw_image_are_followed_or_refused_by_their_names() {
    let Some(card) = card() else { return };
    let changes: [(&str, Change, Option<&str>); 20] = [
        ("one black level", |raw| raw.black_level_dn = 250.into(), None),
        (
            "a tile of black levels",
            |raw| {
                raw.black_level_dn =
                    BlackLevel::of_tile(3, (0..6).map(|i| BLACK_DN + i as f32).collect()).expect("a tile")
            },
            None,
        ),
        (
            "black levels of columns",
            |raw| raw.black_level_dn = raw.black_level_dn.clone().with_deltas(&raw.cfa, vec![1.0; 37], vec![]),
            Some("BlackLevelDeltaH"),
        ),
        (
            "black levels of rows",
            |raw| raw.black_level_dn = raw.black_level_dn.clone().with_deltas(&raw.cfa, vec![], vec![1.0; 23]),
            Some("BlackLevelDeltaV"),
        ),
        ("white levels", |raw| raw.channel_whites_dn = Some(vec![3900, 4000, 3800]), None),
        ("a table", |raw| raw.linearisation = Some((0..4000u32).map(|dn| (dn * dn / 4000) as u16).collect()), None),
        ("masked margins", |raw| raw.active_area = Some(PixelArea { x: 5, y: 3, width: 30, height: 19 }), None),
        ("a crop", |raw| raw.metadata.default_crop = Some(PixelArea { x: 5, y: 3, width: 30, height: 19 }), None),
        ("falloff", |raw| raw.metadata.opcodes[1] = vec![falloff()], None),
        (
            "falloff of some pixels",
            |raw| {
                let gains = (0..24).map(|i| 1.0 + 0.03 * i as f32).collect();
                let reach = Reach { pixels: area(2), spacing: [0.4, 0.35], origin: [0.1, -0.1], gains_per_point: 2 };
                let some = Opcode::GainMap(GainMap::of_some(4, 3, gains, reach).expect("a map"));
                raw.metadata.opcodes[1] = vec![some, falloff()];
            },
            None,
        ),
        (
            "stored values",
            |raw| raw.metadata.opcodes[0] = vec![Opcode::MapTable(area(1), vec![7])],
            Some("OpcodeList1"),
        ),
        (
            "linear values",
            |raw| raw.metadata.opcodes[1] = vec![Opcode::MapPolynomial(area(1), vec![0.0, 0.5])],
            Some("OpcodeList2"),
        ),
        (
            "demosaicked values",
            |raw| raw.metadata.opcodes[2] = vec![Opcode::PerLine(area(1), PerLine::ScalePerRow, vec![0.5; 23])],
            Some("OpcodeList3"),
        ),
        ("hexagonal cells", |raw| raw.metadata.is_staggered = true, Some("CFALayout")),
        ("oblong pixels", |raw| raw.metadata.stated_pixel_aspect = Some(1.5), Some("develop.square_pixels")),
        (
            "distortion",
            |raw| {
                let intrinsics = Intrinsics { fx: 1.0, fy: 1.0, cx: 0.5, cy: 0.5, skew: 0.0 };
                let projection = Projection::Perspective;
                let lens = LensModel { intrinsics, projection, max_angle_rad: None };
                raw.metadata.distortion = Some(Distortion::Lens(lens));
            },
            Some("develop.distortion"),
        ),
        ("brighter", |raw| raw.metadata.baseline_exposure_ev = 0.7, None),
        ("no colours", |raw| raw.metadata.calibrations.clear(), None),
        ("no response to white", |raw| raw.metadata.as_shot_neutral = None, None),
        ("held upright", |raw| raw.metadata.orientation = Orientation::of_number(6.0).expect("one of eight"), None),
    ];
    for layout in ["GRBG", "mono", "full:RGB"] {
        for (name, change, expected) in changes {
            let mut raw = raw(layout, [37, 23]);
            change(&mut raw);
            let refused = compare(card, &format!("{layout}, {name}"), &raw, &DevelopSettings::default()).err();
            assert_eq!(refused.map(|invalid| invalid.key).as_deref(), expected, "{layout}, {name}");
        }
    }
    for layout in ["x-trans", "quad-bayer", "rgb-ir", "full:RGI"] {
        let raw = RawImage::bare(
            12,
            12,
            vec![100; 432][..if layout == "full:RGI" { 432 } else { 144 }].to_vec(),
            Cfa::parse(layout).expect("known"),
            255,
        );
        let refused = compare(card, layout, &raw, &DevelopSettings::default()).err();
        assert_eq!(refused.map(|invalid| invalid.key).as_deref(), (layout != "full:RGI").then_some("cfa"), "{layout}");
    }
}

/// Some values of a key that its schema allows: all of a choice, both ends and a place between of a range.
fn values_of(key: &str, schema: &Value, all: &Value) -> Vec<Value> {
    let parts = ["anyOf", "oneOf"].iter().filter_map(|name| schema.get(name)?.as_array()).flatten();
    let mut values: Vec<Value> = parts.flat_map(|part| values_of(key, part, all)).collect();
    if let Some(path) = schema.get("$ref").and_then(Value::as_str) {
        values.extend(values_of(key, all.pointer(path.trim_start_matches('#')).expect("a definition"), all));
    }
    values.extend(schema.get("const").cloned());
    values.extend(schema.get("enum").and_then(Value::as_array).cloned().unwrap_or_default());
    let types = schema.get("type").cloned().unwrap_or_default();
    let is_of = |name: &str| types == name || types.as_array().is_some_and(|types| types.contains(&name.into()));
    if is_of("boolean") {
        values.extend([json!(false), json!(true)]);
    }
    if (is_of("number") || is_of("integer")) && values.is_empty() {
        let end = |name: &str, default: f64| schema.get(name).and_then(Value::as_f64).unwrap_or(default);
        let [low, high] = [end("minimum", 0.0), end("maximum", 1.0)];
        let between = low + 0.3 * (high - low);
        let whole = |value: f64| if is_of("number") { json!(value) } else { json!(value.round() as u64) };
        values.extend([low, between, high].map(whole));
    }
    if is_of("array") || is_of("object") {
        values.extend(match key {
            "raw" => vec![
                json!({ "cfa": "BGGR" }),
                json!({ "cfa": "x-trans" }),
                json!({ "black_level_dn": 300.5, "white_level_dn": 3000 }),
                json!({ "as_shot_neutral": [1.0, 0.8, 0.4] }),
                json!({ "colour_matrix_d65": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] }),
            ],
            "patch_px" => vec![json!([2, 2, 8, 8])],
            "kernel" => vec![json!([[1.0]]), json!([[0.0, 0.2, 0.0], [0.2, 0.2, 0.2], [0.0, 0.2, 0.0]])],
            "resize_px" => vec![json!([20, 10])],
            _ => Vec::new(),
        });
    }
    values
}

/// Settings of a table of keys, where they are valid.
fn settings_of(table: &Map<String, Value>) -> Option<DevelopSettings> {
    let settings: DevelopSettings = serde_json::from_value(Value::Object(table.clone())).expect("known keys");
    settings.validate().is_ok().then_some(settings)
}

#[test]
fn every_value_of_every_setting_is_refused_by_its_key_or_makes_the_image_of_the_processor() {
    let Some(card) = card() else { return };
    let schema = serde_json::to_value(schemars::schema_for!(DevelopSettings)).expect("JSON");
    let keys = schema.get("properties").and_then(Value::as_object).expect("keys");
    // What goes with a choice alone is tried with it.
    let companions = [
        json!({}),
        json!({ "white_balance": "temperature", "temperature_k": 4100.0 }),
        json!({ "tone_curve": "gamma" }),
        json!({ "bits": 16, "tone_curve": "linear" }),
        json!({ "colour_model": "grey", "tone_curve": "filmic" }),
    ];
    let (mut developed, mut refusals, mut all) = (0, 0, Tally::default());
    for layout in ["GBRG", "full:RGB"] {
        let mut raw = raw(layout, [37, 23]);
        raw.metadata.opcodes[1] = vec![falloff()];
        raw.metadata.orientation = Orientation::of_number(6.0).expect("one of eight");
        for (key, schema_of_key) in keys {
            let values = values_of(key, schema_of_key, &schema);
            assert!(!values.is_empty(), "{key} has values that this test does not know");
            let mut is_tried = false;
            for (value, companions) in values.iter().flat_map(|value| companions.iter().map(move |with| (value, with)))
            {
                let mut table = companions.as_object().expect("a table").clone();
                table.insert(key.clone(), value.clone());
                let Some(settings) = settings_of(&table) else { continue };
                is_tried = true;
                let name = format!("{layout} {table:?}");
                match compare(card, &name, &raw, &settings) {
                    Ok(tally) => {
                        developed += 1;
                        all.add(tally);
                    }
                    Err(refused) => {
                        refusals += 1;
                        // The processor refuses it, too, or the key says why a card does
                        let by_key =
                            table.keys().any(|key| refused.key == format!("develop.{key}")) || refused.key == "cfa";
                        assert!(by_key || develop(&raw, &settings).is_err(), "{name}: {refused}");
                    }
                }
            }
            let goes_with_others = ["tone_", "noise_", "threshold_", "sharpening_", "resize_", "kernel_", "patch_"];
            assert!(is_tried || goes_with_others.iter().any(|start| key.starts_with(start)), "{key} is never tried");
        }
    }
    println!("{developed} developed, {refusals} refused: {all:?}");
    assert!(developed > 500 && refusals > 200, "{developed} {refusals}");
}

#[test]
fn colours_of_all_spaces_and_curves_are_those_of_the_processor() {
    let Some(card) = card() else { return };
    for (layout, colour_space) in LAYOUTS.into_iter().flat_map(|layout| ColourSpace::ALL.map(|space| (layout, space))) {
        for tone_curve in [ToneCurve::Srgb, ToneCurve::Linear, ToneCurve::Gamma, ToneCurve::Filmic] {
            let settings = DevelopSettings { colour_space, tone_curve, exposure_ev: 0.8, ..DevelopSettings::default() };
            let name = format!("{layout} {colour_space:?} {tone_curve:?}");
            compare(card, &name, &raw(layout, [37, 23]), &settings).expect("a card has it");
        }
    }
}
