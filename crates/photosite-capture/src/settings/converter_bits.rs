//! Converter of other bits than the preset's: figures of the preset in digital numbers follow.
//!
//! A number of 12 bits is four of 10 bits. Where a capture changes `adc.bits` alone, every figure of the preset in DN
//! is multiplied by 2^(new − old), so that the converter still takes the same charge. Below 8 bits it is multiplied by
//! the ratio of the largest numbers, (2^new − 1)/(2^old − 1): of two levels, the upper one stands for the end of the
//! range. Figures that the capture states itself stay as they are. The two converters of `adc.dual_gain` are treated
//! alike, each with its own bits.

use super::super::tree::nodes::{Node, Value};

/// Figures in DN of the converter.
const IN_MERGED_DN: [&[&str]; 3] =
    [&["adc", "conversion_gain_dn_per_e"], &["adc", "black_level_dn"], &["adc", "column_offset_dn"]];

/// Figures in DN of the two converters of dual gain.
const IN_DUAL_DN: [&[&str]; 3] = [
    &["adc", "dual_gain", "black_level_dn"],
    &["adc", "dual_gain", "high_gain_dn_per_e"],
    &["adc", "dual_gain", "low_gain_dn_per_e"],
];

/// Steps of gain, whose black levels are in DN of the converter.
const GAIN_STEPS: &[&str] = &["noise", "gain_steps"];
const BLACK_LEVEL: &[&str] = &["black_level_dn"];

const BITS: &[&str] = &["adc", "bits"];
const DUAL_BITS: &[&str] = &["adc", "dual_gain", "bits"];
/// Figure of the converters that measure charge: both of dual gain where there are two.
const BEND: &[&str] = &["adc", "inl_dn"];
const KNEES: &[&str] = &["adc", "companding", "knee_points_dn"];
const STEPS: &[&str] = &["adc", "dnl_dn"];

/// Table of defective pixels, with the numbers of stuck ones.
const DEFECTIVE_PIXELS: &[&str] = &["defects", "pixels"];

/// Makes the figures of `base` follow the bits in `changes`, but for those that are given there; returns warnings about
/// those that cannot.
pub(crate) fn follow_bits(base: &mut Node, changes: &Node) -> Vec<String> {
    let mut warnings = Vec::new();
    let is_dual = base.at(&["adc", "dual_gain"]).is_some();
    let change = |key| Some([bits(base, key)?, bits(changes, key)?]).filter(|[old, new]| old != new);
    let [merged, dual] = [BITS, DUAL_BITS].map(change);
    let kind = changes.at(&["kind"]).or_else(|| base.at(&["kind"]));
    // Numbers of single-photon detectors are counts, whatever their bits.
    if kind.and_then(Node::as_str) == Some("spad") {
        warnings.extend(merged.and_then(|[_, new]| short_counter(base, changes, new)));
        return warnings;
    }
    let mut follow = |keys: &[&[&str]], [old, new]: [u32; 2]| {
        let factor = factor([old, new]);
        for key in keys.iter().filter(|key| changes.at(key).is_none()) {
            base.at_mut(key).into_iter().for_each(|node| scale(node, key, factor));
        }
    };
    if let Some(change) = merged {
        follow(&IN_MERGED_DN, change);
    }
    if let Some(change) = dual {
        follow(&IN_DUAL_DN, change);
    }
    let of_converters = if is_dual { dual } else { merged };
    if let Some(change @ [_, new]) = of_converters {
        follow(&[BEND], change);
        let steps = base.at(STEPS).and_then(Node::as_number).filter(|dnl| *dnl != 0.0 && changes.at(STEPS).is_none());
        warnings.extend(steps.map(|dnl| {
            format!(
                "sensor.adc.dnl_dn: {dnl} is that of a converter of other bits, and is taken to hold for the steps of {new} \
                 bits; state that of yours"
            )
        }));
    }
    if let Some(change) = merged {
        follow_in_steps(base, changes.at(GAIN_STEPS), factor(change));
        if base.at(DEFECTIVE_PIXELS).is_some() && changes.at(DEFECTIVE_PIXELS).is_none() {
            let [old, new] = change;
            warnings.push(format!(
                "sensor.defects.pixels: numbers of stuck pixels stay those of the table, which was made for {old} bits; name \
                 one of {new} bits"
            ));
        }
    }
    if let (Some(change), None) = (merged, changes.at(KNEES)) {
        base.at_mut(KNEES).into_iter().for_each(|knees| move_knees(knees, change));
    }
    warnings
}

/// Multiplies the black levels of steps of gain, but for those that are stated in `changes`: a list of steps in place of
/// all, or single ones by their numbers.
fn follow_in_steps(base: &mut Node, changes: Option<&Node>, factor: f64) {
    let Some(Node { value: Value::Array(steps), .. }) = base.at_mut(GAIN_STEPS) else { return };
    if changes.is_some_and(|changes| matches!(changes.value, Value::Array(_))) {
        return;
    }
    for (i, step) in steps.iter_mut().enumerate() {
        let is_stated = changes.is_some_and(|changes| changes.at(&[&i.to_string(), BLACK_LEVEL[0]]).is_some());
        if let Some(black) = step.at_mut(BLACK_LEVEL).filter(|_| !is_stated) {
            scale(black, BLACK_LEVEL, factor);
        }
    }
}

/// Digital numbers of the new bits for one of the old bits.
fn factor([old, new]: [u32; 2]) -> f64 {
    let largest = |bits: u32| f64::from((1u32 << bits) - 1);
    if old.min(new) < 8 { largest(new) / largest(old) } else { 2f64.powi(new as i32 - old as i32) }
}

/// Bits that a converter can have; others are refused elsewhere.
fn bits(sensor: &Node, key: &[&str]) -> Option<u32> {
    let Value::Integer(bits) = sensor.at(key)?.value else { return None };
    u32::try_from(bits).ok().filter(|bits| (1..=16).contains(bits))
}

/// Multiplies the number at a key; black levels stay whole.
fn scale(node: &mut Node, key: &[&str], factor: f64) {
    let Some(scaled) = node.as_number().map(|number| number * factor) else { return };
    let is_whole = key.last() == Some(&"black_level_dn");
    node.value = if is_whole { Value::Integer(scaled.round() as i128) } else { Value::Float(scaled) };
}

/// Moves the knees of a companding curve: its ends are the largest digital numbers.
fn move_knees(knees: &mut Node, [old, new]: [u32; 2]) {
    let (factor, last) = (factor([old, new]), |bits: u32| (1i128 << bits) - 1);
    let Value::Array(knees) = &mut knees.value else { return };
    for knee in knees {
        let Value::Array(knee) = &mut knee.value else { continue };
        let Some(Node { value: Value::Integer(number), .. }) = knee.first_mut() else { continue };
        *number = if *number == last(old) { last(new) } else { (*number as f64 * factor).round() as i128 };
    }
}

/// The warning of a counter that ends before its pixels do.
fn short_counter(base: &Node, changes: &Node, bits: u32) -> Option<String> {
    let number = |key: &[&str]| changes.at(key).or_else(|| base.at(key)).and_then(Node::as_number);
    let (gain, black) = (number(IN_MERGED_DN[0])?, number(IN_MERGED_DN[1])?);
    let (end, most) = ((f64::from((1u32 << bits) - 1) - black) / gain, number(&["charge", "full_well_e"])?);
    (end < most)
        .then(|| format!("sensor.adc.bits: {bits} bits count to {end}, and pixels of this sensor can count to {most}"))
}

#[cfg(test)]
mod tests {
    use crate::{NamedSensor, read_named_sensor};
    use photosite_core::Sandbox;
    use photosite_core::units::{Decibels, Seconds};
    use photosite_sensor::{Exposure, presets};

    /// Case: whatever the bits, the sensor holds the same charge. The largest number is 2^b − 1 rather than 2^b, and
    /// the black level is whole: the ends of the range are off by up to |2^Δ − 1| (below 8 bits, nothing) and by ½ of
    /// the new numbers, each of 1/K electrons.
    #[test]
    fn every_preset_holds_the_same_charge_with_any_bits() {
        let exposure = Exposure::of(Seconds(0.01));
        for name in presets::names() {
            let preset = presets::model(name).expect("listed");
            // A counter of fewer bits ends before its pixels do, and says so.
            let least = if preset.architecture.spad().is_some() { 8 } else { 1 };
            for bits in least..=16 {
                let NamedSensor { model: sensor, warnings, .. } =
                    read_named_sensor(&Sandbox::default(), name, &[format!("adc.bits={bits}")]).expect("valid");
                assert!(warnings.is_empty(), "{name}: {warnings:?}");
                let [before, after] = [&preset, &sensor].map(|s| s.saturation_capacity(&exposure).0);
                let factor = super::factor([preset.converter.bits, bits]);
                let end = if bits < 8 { 0.0 } else { (factor - 1.0).abs() };
                let bound = (end + 0.5) / sensor.converter.conversion_gain_dn_per_e;
                assert!((before - after).abs() <= bound, "{name}, {bits} bits: {after} e⁻, not {before}");
                let is_counter = sensor.architecture.spad().is_some();
                let gain = preset.converter.conversion_gain_dn_per_e * if is_counter { 1.0 } else { factor };
                assert_eq!(sensor.converter.conversion_gain_dn_per_e, gain, "{name}, {bits} bits");
            }
        }
    }

    /// Case: black levels of steps of gain are numbers of the converter, too, unless the capture states the steps.
    #[test]
    fn black_levels_of_gain_steps_follow_the_bits() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("camera.toml");
        let steps = "[[noise.gain_steps]]\ngain_db = 0\nblack_level_dn = 64\n\
                     [[noise.gain_steps]]\ngain_db = 12\nblack_level_dn = 100\n";
        let sensor = presets::table("sony-imx249-mono").expect("listed");
        std::fs::write(&path, format!("{sensor}\n{steps}")).expect("written");
        let blacks = |set: &[&str]| {
            let set: Vec<String> = set.iter().map(|&set| set.to_owned()).collect();
            let name = path.to_str().expect("a name");
            let sensor = read_named_sensor(&Sandbox::default(), name, &set).expect("valid").model;
            [0.0, 12.0].map(|db| sensor.converter.black_level_dn(Decibels(db)))
        };
        assert_eq!(blacks(&[]), [64, 100]);
        assert_eq!(blacks(&["adc.bits=10"]), [16, 25]);
        assert_eq!(
            blacks(&["adc.bits=10", "noise.gain_steps.1.read_noise_e=1.5", "noise.gain_steps.0.read_noise_e=2"]),
            [16, 25]
        );
        assert_eq!(blacks(&["adc.bits=10", "noise.gain_steps.0.black_level_dn=20"]), [20, 25]);
        assert_eq!(blacks(&["adc.bits=10", "noise.gain_steps=[{gain_db=0,black_level_dn=30}]"]), [30, 30]);
    }

    /// Case: each of two converters holds the same charge.
    #[test]
    fn the_converters_of_dual_gain_follow_their_own_bits() {
        let preset = presets::model("andor-zyla-55").expect("listed");
        let set = ["adc.dual_gain.bits=10", "adc.dual_gain.low_gain_dn_per_e=0.03"].map(str::to_owned);
        let sensor = read_named_sensor(&Sandbox::default(), "andor-zyla-55", &set).expect("valid").model;
        let [before, after] = [&preset, &sensor].map(|s| s.converter.dual_gain.as_ref().expect("two converters"));
        let gains = |dual: &photosite_sensor::DualGain| [&dual.high, &dual.low].map(|c| c.conversion_gain_dn_per_e);
        assert_eq!(gains(after), [gains(before)[0] / 4.0, 0.03]);
        // 50/4 = 12.5.
        let black = |dual: &photosite_sensor::DualGain| dual.high.black_level_dn(Decibels(0.0));
        assert_eq!((black(before), black(after)), (50, 13));
        assert_eq!(sensor.converter.bits, preset.converter.bits);
        assert_eq!(sensor.converter.conversion_gain_dn_per_e, preset.converter.conversion_gain_dn_per_e);
    }
}
