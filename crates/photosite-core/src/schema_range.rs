//! Ranges of numbers in JSON Schemas.
//!
//! `#[schemars(transform = within(0.0..=1.0))]` on a field of a table states in the schema the range that the code
//! checks. It applies to the field's number, optional or not, and to all numbers of a list; nested tables have ranges
//! of their own. `src/capture/tests/ranges.rs` compares both.

use std::ops::{Bound, RangeBounds};

use crate::Invalid;
use schemars::Schema;
use serde_json::{Map, Number, Value};

/// Range of a number, with its bounds included or not as the range says.
pub fn within(range: impl RangeBounds<f64>) -> impl FnMut(&mut Schema) {
    let low = match range.start_bound() {
        Bound::Included(low) => Some(("minimum", *low)),
        Bound::Excluded(low) => Some(("exclusiveMinimum", *low)),
        Bound::Unbounded => None,
    };
    limited([low, upper(&range)])
}

/// Range of a number above its beginning, which is excluded, and up to its end.
pub fn above(range: impl RangeBounds<f64>) -> impl FnMut(&mut Schema) {
    let low = match range.start_bound() {
        Bound::Included(low) | Bound::Excluded(low) => Some(("exclusiveMinimum", *low)),
        Bound::Unbounded => None,
    };
    limited([low, upper(&range)])
}

/// Kind of a range's lowest number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lowest {
    /// Bound that belongs to the range: [`within`].
    Within,
    /// Bound that does not: [`above`].
    Above,
}

/// Numbers of a key, none or one or several.
pub trait Numbers {
    /// The first that is as wanted.
    fn find(&self, is_wanted: &dyn Fn(f64) -> bool) -> Option<f64>;
}

/// Numbers that are turned into f64 exactly, or nearly so where that is beyond any range.
macro_rules! numbers {
    ($($kind:ty)*) => {
        $(impl Numbers for $kind {
            fn find(&self, is_wanted: &dyn Fn(f64) -> bool) -> Option<f64> {
                Some(*self as f64).filter(|number| is_wanted(*number))
            }
        })*
    };
}

numbers! { f64 u8 u32 u64 usize }

impl<T: Numbers> Numbers for Option<T> {
    fn find(&self, is_wanted: &dyn Fn(f64) -> bool) -> Option<f64> {
        self.as_ref()?.find(is_wanted)
    }
}

/// Refuses numbers of a key beyond a range, which is stated as in schemas; `example` is one that belongs to it.
///
/// # Errors
///
/// The first number that does not belong to it, the range and the example.
pub fn check(
    key: &str,
    numbers: &impl Numbers,
    lowest: Lowest,
    range: impl RangeBounds<f64>,
    example: &str,
) -> Result<(), Invalid> {
    let is_above = lowest == Lowest::Above;
    let is_out = |number: f64| !range.contains(&number) || is_above && range.start_bound() == Bound::Included(&number);
    let Some(number) = numbers.find(&is_out) else { return Ok(()) };
    let low = match range.start_bound() {
        Bound::Included(low) if is_above => Some(format!("above {low}")),
        Bound::Included(low) => Some(format!("at least {low}")),
        Bound::Excluded(low) => Some(format!("above {low}")),
        Bound::Unbounded => None,
    };
    let high = match range.end_bound() {
        Bound::Included(high) => Some(format!("at most {high}")),
        Bound::Excluded(high) => Some(format!("below {high}")),
        Bound::Unbounded => None,
    };
    let wanted = match (range.start_bound(), range.end_bound()) {
        (Bound::Included(low), Bound::Included(high)) if !is_above => format!("from {low} to {high}"),
        _ => low.into_iter().chain(high).collect::<Vec<_>>().join(" and "),
    };
    Err(Invalid::new(key, format!("must be {wanted}, got {number}")).help(format!("for example {key} = {example}")))
}

fn upper(range: &impl RangeBounds<f64>) -> Option<(&'static str, f64)> {
    match range.end_bound() {
        Bound::Included(high) => Some(("maximum", *high)),
        Bound::Excluded(high) => Some(("exclusiveMaximum", *high)),
        Bound::Unbounded => None,
    }
}

/// Adds bounds, each under its keyword, beside the type of every number of a schema.
fn limited(bounds: [Option<(&'static str, f64)>; 2]) -> impl FnMut(&mut Schema) {
    move |schema| {
        if let Some(object) = schema.as_object_mut() {
            limit(object, &bounds);
        }
    }
}

fn limit(schema: &mut Map<String, Value>, bounds: &[Option<(&'static str, f64)>; 2]) {
    let is_number = |kind: &Value| matches!(kind.as_str(), Some("number" | "integer"));
    let is_limited = match schema.get("type") {
        Some(Value::Array(kinds)) => kinds.iter().any(is_number),
        Some(kind) => is_number(kind),
        None => false,
    };
    if is_limited {
        // What the type's width says is no bound that anyone writes for.
        schema.remove("maximum");
        schema.extend(bounds.iter().flatten().map(|(keyword, bound)| ((*keyword).to_owned(), number(*bound))));
        return;
    }
    if let Some(items) = schema.get_mut("items").and_then(Value::as_object_mut) {
        limit(items, bounds);
    }
    for keyword in ["anyOf", "prefixItems"] {
        let parts = schema.get_mut(keyword).and_then(Value::as_array_mut).into_iter().flatten();
        parts.filter_map(Value::as_object_mut).for_each(|part| limit(part, bounds));
    }
}

/// Number of a bound, whole numbers without a decimal point.
fn number(bound: f64) -> Value {
    let is_whole = bound.fract() == 0.0 && bound.abs() < 1e15;
    if is_whole { Value::from(bound as i64) } else { Number::from_f64(bound).map_or(Value::Null, Value::Number) }
}

#[cfg(test)]
mod tests {
    use schemars::{JsonSchema, schema_for};
    use serde_json::json;

    use super::*;

    #[derive(JsonSchema)]
    #[expect(dead_code, reason = "only its schema is of interest")]
    struct Table {
        #[schemars(transform = within(0.0..=1.0))]
        part: f64,
        #[schemars(transform = above(0.0..))]
        length: Option<f64>,
        #[schemars(transform = within(1.0..=16.0))]
        bits: u8,
        #[schemars(transform = above(0.5..90.0))]
        angles: Option<[f64; 2]>,
        #[schemars(transform = within(..=-0.5))]
        rows: Vec<Vec<f64>>,
    }

    #[test]
    fn numbers_beyond_a_range_are_told_with_it() {
        let said = |error: Result<(), Invalid>| error.err().map(|invalid| invalid.message);
        let splitting = |number: u32| said(check("splitting", &number, Lowest::Within, 1.0..=256.0, "4"));
        assert_eq!((splitting(1), splitting(256)), (None, None));
        assert_eq!(splitting(300).as_deref(), Some("must be from 1 to 256, got 300"));
        let time = |number: f64| said(check("time_s", &Some(number), Lowest::Above, 0.0.., "1"));
        assert_eq!((time(1e-9), time(f64::INFINITY)), (None, None));
        assert_eq!(time(0.0).as_deref(), Some("must be above 0, got 0"));
        assert_eq!(time(f64::NAN).as_deref(), Some("must be above 0, got NaN"));
        let part = |number: f64| said(check("part", &number, Lowest::Above, 0.0..1.0, "0.5"));
        assert_eq!(part(1.0).as_deref(), Some("must be above 0 and below 1, got 1"));
        assert_eq!(said(check("none", &None::<f64>, Lowest::Within, 0.0.., "1")), None);
    }

    #[test]
    fn bounds_stand_beside_the_type_of_each_number() {
        let schema = schema_for!(Table).to_value();
        let of = |path: &str| {
            let at = schema.pointer(&format!("/properties/{path}")).expect(path);
            ["minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum"].map(|key| at.get(key).cloned())
        };
        assert_eq!(of("part"), [Some(json!(0)), None, Some(json!(1)), None]);
        assert_eq!(of("length"), [None, Some(json!(0)), None, None]);
        assert_eq!(of("bits"), [Some(json!(1)), None, Some(json!(16)), None]);
        assert_eq!(of("angles"), [const { None }; 4]);
        assert_eq!(of("angles/items"), [None, Some(json!(0.5)), None, Some(json!(90))]);
        assert_eq!(of("rows/items/items"), [None, None, Some(json!(-0.5)), None]);
    }
}
