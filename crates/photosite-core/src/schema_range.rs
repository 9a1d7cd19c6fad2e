//! Ranges of numbers in JSON Schemas.
//!
//! `#[schemars(transform = within(0.0..=1.0))]` on a field of a table says in the schema what the code that gives the
//! table its meaning checks. It holds of the field's number, whether it may be left out or not, and of all numbers of a
//! list; tables within have ranges of their own. `src/capture/tests/ranges.rs` compares both.

use std::ops::{Bound, RangeBounds};

use schemars::Schema;
use serde_json::{Map, Number, Value};

/// Numbers in a range, its bounds included as the range says.
pub fn within(range: impl RangeBounds<f64>) -> impl FnMut(&mut Schema) {
    let low = match range.start_bound() {
        Bound::Included(low) => Some(("minimum", *low)),
        Bound::Excluded(low) => Some(("exclusiveMinimum", *low)),
        Bound::Unbounded => None,
    };
    limited([low, upper(&range)])
}

/// Numbers above the beginning of a range, and up to its end.
pub fn above(range: impl RangeBounds<f64>) -> impl FnMut(&mut Schema) {
    let low = match range.start_bound() {
        Bound::Included(low) | Bound::Excluded(low) => Some(("exclusiveMinimum", *low)),
        Bound::Unbounded => None,
    };
    limited([low, upper(&range)])
}

fn upper(range: &impl RangeBounds<f64>) -> Option<(&'static str, f64)> {
    match range.end_bound() {
        Bound::Included(high) => Some(("maximum", *high)),
        Bound::Excluded(high) => Some(("exclusiveMaximum", *high)),
        Bound::Unbounded => None,
    }
}

/// Puts bounds, each under its keyword, beside the type of every number of a schema.
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

/// A bound as it is written: whole numbers without a point.
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
