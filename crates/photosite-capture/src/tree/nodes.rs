//! Values with their places: the tree that TOML texts are parsed into.
//!
//! A span is a range of bytes of the imagined text that [`source`](super::source) describes.

use std::collections::BTreeMap;
use std::ops::Range;

use photosite_core::suggest::{did_you_mean, list};
use photosite_core::toml_text;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) span: Range<usize>,
    pub(crate) value: Value,
}

/// A TOML value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    String(String),
    Integer(i128),
    Float(f64),
    Boolean(bool),
    /// Date or time, which means nothing here; kept as written, for messages.
    Datetime(String),
    Array(Vec<Node>),
    Table(Table),
}

/// A TOML table.
pub(crate) type Table = BTreeMap<String, Entry>;

/// A value in a table, with the place of its key.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry {
    pub(crate) key_span: Range<usize>,
    pub(crate) node: Node,
}

impl Node {
    /// The table that the node is.
    pub(crate) fn as_table(&self) -> Option<&Table> {
        if let Value::Table(table) = &self.value { Some(table) } else { None }
    }

    /// Takes a value out of the table that the node is.
    pub(crate) fn remove(&mut self, key: &str) -> Option<Self> {
        if let Value::Table(table) = &mut self.value { table.remove(key).map(|entry| entry.node) } else { None }
    }

    /// Puts a value into the table that the node is, unless there is one of that key.
    pub(crate) fn insert_new(&mut self, key: &str, node: Self) {
        if let Value::Table(table) = &mut self.value {
            table.entry(key.to_owned()).or_insert(Entry { key_span: node.span.clone(), node });
        }
    }

    /// The value at a path of keys through tables.
    pub(crate) fn at(&self, path: &[&str]) -> Option<&Self> {
        path.iter().try_fold(self, |node, key| Some(&node.as_table()?.get(*key)?.node))
    }

    /// The value at a path of keys through tables, to be changed.
    pub(crate) fn at_mut(&mut self, path: &[&str]) -> Option<&mut Self> {
        path.iter().try_fold(self, |node, key| match &mut node.value {
            Value::Table(table) => table.get_mut(*key).map(|entry| &mut entry.node),
            Value::String(_)
            | Value::Integer(_)
            | Value::Float(_)
            | Value::Boolean(_)
            | Value::Datetime(_)
            | Value::Array(_) => None,
        })
    }

    /// The number that the node is.
    pub(crate) fn as_number(&self) -> Option<f64> {
        match self.value {
            Value::Integer(i) => Some(i as f64),
            Value::Float(x) => Some(x),
            Value::String(_) | Value::Boolean(_) | Value::Datetime(_) | Value::Array(_) | Value::Table(_) => None,
        }
    }

    /// The paths of all keys within this node, tables before what they hold.
    pub(crate) fn paths(&self) -> Vec<String> {
        let within = |(key, entry): (&String, &Entry)| {
            let inner = entry.node.paths().into_iter().map(|path| join(key, &path));
            std::iter::once(key.clone()).chain(inner).collect::<Vec<_>>()
        };
        self.as_table().into_iter().flatten().flat_map(within).collect()
    }

    /// Whether another node means the same, wherever it stands: 3 and 3.0 do.
    pub(crate) fn means(&self, other: &Self) -> bool {
        match (&self.value, &other.value) {
            (Value::Array(ours), Value::Array(others)) => {
                ours.len() == others.len() && ours.iter().zip(others).all(|(a, b)| a.means(b))
            }
            (Value::Table(ours), Value::Table(others)) => {
                ours.len() == others.len()
                    && ours.iter().zip(others).all(|((a, x), (b, y))| a == b && x.node.means(&y.node))
            }
            _ => match (self.as_number(), other.as_number()) {
                (Some(a), Some(b)) => a == b,
                _ => self.value == other.value,
            },
        }
    }

    /// The string that the node is.
    pub(crate) fn as_str(&self) -> Option<&str> {
        if let Value::String(text) = &self.value { Some(text) } else { None }
    }

    /// Follows the first step of a path such as `materials.red.reflectance` or `[0].type`; returns the node there and
    /// the rest of the path. Keys may contain dots, as names of materials do, so the longest key that fits is taken.
    pub(crate) fn step<'p>(&self, path: &'p str) -> Option<(&Self, &'p str)> {
        match &self.value {
            Value::Table(table) => {
                let rest_after = |key: &str| {
                    let rest = path.strip_prefix(key)?;
                    (rest.is_empty() || rest.starts_with(['.', '['])).then(|| rest.strip_prefix('.').unwrap_or(rest))
                };
                let fitting = table.iter().filter_map(|(key, entry)| Some((key.len(), &entry.node, rest_after(key)?)));
                fitting.max_by_key(|(len, ..)| *len).map(|(_, node, rest)| (node, rest))
            }
            Value::Array(array) => {
                let (index, rest) = path.strip_prefix('[')?.split_once(']')?;
                Some((array.get(index.parse::<usize>().ok()?)?, rest.strip_prefix('.').unwrap_or(rest)))
            }
            Value::String(_) | Value::Integer(_) | Value::Float(_) | Value::Boolean(_) | Value::Datetime(_) => None,
        }
    }

    /// The node at a path, or the innermost one on the way there, and whether it is the one asked for.
    pub(crate) fn find(&self, path: &str) -> (&Self, bool) {
        let (mut node, mut rest) = (self, path);
        while let Some((next, after)) = node.step(rest).filter(|_| !rest.is_empty()) {
            (node, rest) = (next, after);
        }
        (node, rest.is_empty())
    }

    /// Lays another value over this one: tables are merged, elements of an array can be addressed by their number or
    /// name, everything else is replaced.
    pub(crate) fn lay_over(&mut self, over: Self) -> Result<(), NoElement> {
        match (&mut self.value, over.value) {
            (Value::Table(under), Value::Table(over)) => {
                give_way(under, &over);
                for (key, entry) in over {
                    match under.get_mut(&key) {
                        Some(known) => known.node.lay_over(entry.node).map_err(|error| error.within(&key))?,
                        None => {
                            under.insert(key, entry);
                        }
                    }
                }
            }
            (Value::Array(under), Value::Table(over)) if addresses(&over, under) => {
                for (key, entry) in over {
                    let index = element(under, &key, &entry.key_span)?;
                    under[index].lay_over(entry.node).map_err(|error| error.within(&format!("[{index}]")))?;
                }
            }
            (_, value) => *self = Self { span: over.span, value },
        }
        Ok(())
    }

    /// Gives every value within this one the same place.
    pub(crate) fn place_at(&mut self, span: &Range<usize>) {
        self.span = span.clone();
        match &mut self.value {
            Value::Array(array) => array.iter_mut().for_each(|node| node.place_at(span)),
            Value::Table(table) => {
                for entry in table.values_mut() {
                    entry.key_span = span.clone();
                    entry.node.place_at(span);
                }
            }
            Value::String(_) | Value::Integer(_) | Value::Float(_) | Value::Boolean(_) | Value::Datetime(_) => {}
        }
    }
}

/// The tree of a JSON value, all of it at the place `span`. There is no null among our keys; it becomes an empty text.
pub(crate) fn from_json(value: &serde_json::Value, span: &Range<usize>) -> Node {
    use serde_json::Value as Json;
    let value = match value {
        Json::Null => Value::String(String::new()),
        Json::Bool(b) => Value::Boolean(*b),
        Json::Number(n) => match n.as_i128() {
            Some(i) => Value::Integer(i),
            None => Value::Float(n.as_f64().unwrap_or(f64::NAN)),
        },
        Json::String(text) => Value::String(text.clone()),
        Json::Array(items) => Value::Array(items.iter().map(|item| from_json(item, span)).collect()),
        Json::Object(map) => {
            let entry = |value| Entry { key_span: span.clone(), node: from_json(value, span) };
            Value::Table(map.iter().map(|(key, value)| (key.clone(), entry(value))).collect())
        }
    };
    Node { span: span.clone(), value }
}

/// Joined path, `table.key`, or what there is of it; elements of arrays need no dot.
pub(crate) fn join(table: &str, key: &str) -> String {
    match (table, key) {
        ("", _) => key.to_owned(),
        (_, "") => table.to_owned(),
        _ if key.starts_with('[') => format!("{table}{key}"),
        _ => format!("{table}.{key}"),
    }
}

/// A key that addresses no element of an array.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NoElement {
    /// Path of the array.
    pub(crate) path: String,
    /// Span of the key in the text.
    pub(crate) span: Range<usize>,
    pub(crate) message: String,
    pub(crate) help: String,
}

impl NoElement {
    fn within(self, step: &str) -> Self {
        Self { path: join(step, &self.path), ..self }
    }
}

/// Keys that say in another way what the first one says: it takes their place, as nothing can be taken away by what is
/// laid over.
const TAKES_THE_PLACE_OF: [(&str, &[&str]); 9] = [
    ("illuminant", &["spectrum", "rgb", "linear_rgb"]),
    ("spectrum", &["illuminant", "rgb", "linear_rgb"]),
    ("rgb", &["illuminant", "spectrum", "linear_rgb"]),
    ("linear_rgb", &["illuminant", "spectrum", "rgb"]),
    ("luminance_nit", &["illuminance_lux"]),
    ("illuminance_lux", &["luminance_nit", "nit_per_unit"]),
    ("nit_per_unit", &["illuminance_lux"]),
    ("direction", &["look_at_m"]),
    ("quaternion_wxyz", &["rotation_deg", "look_at_m"]),
];

/// The kinds of colours of surfaces that are tables.
const COLOURS: [&str; 3] = ["file", "linear_rgb", "texture"];
/// Keys that stand beside a texture.
const OF_TEXTURES: [&str; 3] = ["tiles", "filter", "wrap"];

/// Takes out of a table what keys of the one over it take the place of.
fn give_way(under: &mut Table, over: &Table) {
    let kind = |table: &Table| table.get("type").and_then(|entry| entry.node.as_str()).map(str::to_owned);
    // Another kind with keys of its own describes the thing anew; a kind alone may share the keys that are there.
    if over.len() > 1 && kind(under).zip(kind(over)).is_some_and(|(under, over)| under != over) {
        under.retain(|key, _| key == "name");
    }
    let is_colour = |table: &Table| table.keys().all(|key| [COLOURS, OF_TEXTURES].concat().contains(&&**key));
    let is_new = |key: &&str| over.contains_key(*key) && !under.contains_key(*key);
    if is_colour(under) && is_colour(over) && COLOURS.iter().any(is_new) {
        under.clear();
    }
    for (key, others) in TAKES_THE_PLACE_OF {
        if over.contains_key(key) {
            under.retain(|other, _| !others.contains(&&**other) || over.contains_key(other));
        }
    }
}

/// Whether the keys of a table are those of elements: numbers, or names of tables. Any node but a list of tables may be
/// replaced by a table as a whole.
fn addresses(table: &Table, elements: &[Node]) -> bool {
    let are_tables = !elements.is_empty() && elements.iter().all(|element| element.as_table().is_some());
    are_tables || table.keys().all(|key| key.parse::<usize>().is_ok_and(|index| index < elements.len()))
}

/// The index of the element of that number, else of that name.
fn element(elements: &[Node], key: &str, span: &Range<usize>) -> Result<usize, NoElement> {
    let error =
        |message: String, help: String| Err(NoElement { path: String::new(), span: span.clone(), message, help });
    let count = elements.len();
    if let Ok(index) = key.parse::<usize>() {
        if index < count {
            return Ok(index);
        }
        return error(format!("has no element {index}"), format!("there are {count}, numbered from 0"));
    }
    let name = |element: &Node| element.at(&["name"]).and_then(Node::as_str).map(str::to_owned);
    let names: Vec<Option<String>> = elements.iter().map(name).collect();
    let mut known = names.iter().enumerate().filter(|(_, name)| name.as_deref() == Some(key)).map(|(i, _)| i);
    let named = || names.iter().flatten().map(String::as_str);
    match (known.next(), known.next()) {
        (Some(index), None) => Ok(index),
        (Some(first), Some(second)) => error(
            format!("has several elements called {key:?}"),
            format!("write the number of one in place of its name: {first} or {second}"),
        ),
        (None, _) => error(
            format!("has no element called {key:?}{}", did_you_mean(key, named())),
            match list(key, named()) {
                names if names.is_empty() => {
                    format!("its elements have no names; write a number from 0 to {}", count - 1)
                }
                names => format!("its elements are {names}, or go by number from 0 to {}", count - 1),
            },
        ),
    }
}

/// Parses a TOML document that begins at byte `start` of the imagined text. The error has its span there, too.
pub(crate) fn parse(text: &str, start: usize) -> Result<Node, (Option<Range<usize>>, String)> {
    let moved = |span: Range<usize>| span.start + start..span.end + start;
    match toml_text::parse(text) {
        Ok(table) => {
            Ok(Node { span: moved(table.span()), value: Value::Table(convert_table(table.into_inner(), start)) })
        }
        Err(error) => Err((error.span.map(moved), error.message)),
    }
}

fn convert_table(table: DeTable<'_>, start: usize) -> Table {
    let entries = table.into_iter().map(|(key, value)| {
        let key_span = key.span().start + start..key.span().end + start;
        (key.into_inner().into_owned(), Entry { key_span, node: convert(value, start) })
    });
    entries.collect()
}

fn convert(value: Spanned<DeValue<'_>>, start: usize) -> Node {
    let span = value.span().start + start..value.span().end + start;
    let value = match value.into_inner() {
        DeValue::String(text) => Value::String(text.into_owned()),
        // The parser has checked the digits; a number beyond 128 bits is none of ours.
        DeValue::Integer(i) => Value::Integer(i128::from_str_radix(i.as_str(), i.radix()).unwrap_or(i128::MAX)),
        DeValue::Float(f) => Value::Float(f.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(b) => Value::Boolean(b),
        DeValue::Datetime(d) => Value::Datetime(d.to_string()),
        DeValue::Array(array) => Value::Array(array.into_iter().map(|value| convert(value, start)).collect()),
        DeValue::Table(table) => Value::Table(convert_table(table, start)),
    };
    Node { span, value }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(text: &str) -> Node {
        parse(text, 100).expect("valid TOML")
    }

    #[test]
    fn paths_lead_to_values_and_names_may_contain_dots() {
        let text = "[materials.\"a.b\"]\ntype = 'x'\n[[lights]]\ncd = 1\n[[lights]]\ncd = 2.5\n";
        let tree = tree(text);
        let value = |path: &str| Some(tree.find(path)).filter(|(_, exact)| *exact).map(|(node, _)| node.value.clone());
        assert_eq!(value("materials.a.b.type"), Some(Value::String("x".into())));
        assert_eq!(value("lights[1].cd"), Some(Value::Float(2.5)));
        assert_eq!(value("lights[2].cd"), None);
        assert_eq!(value("materials.a"), None);
        let (node, exact) = tree.find("materials.a.b.colour.deep");
        assert!(!exact && node.as_table().is_some_and(|table| table.contains_key("type")), "the innermost table");
        let one = tree.find("lights[0].cd").0.span.clone();
        assert_eq!(&text[one.start - 100..one.end - 100], "1");
    }

    #[test]
    fn tables_are_merged_and_other_values_replaced() {
        let mut under = tree("a = 1\nb = { c = 1, d = 2 }\ne = [{ f = 1 }, { f = 2 }]\ng = [1, 2]");
        under.lay_over(tree("b.c = 9\ne.1.f = 8\ng = 'none'\nh.i = 3")).expect("elements");
        let expected = tree("a = 1\nb = { c = 9, d = 2 }\ne = [{ f = 1 }, { f = 8 }]\ng = 'none'\nh.i = 3");
        let (mut found, mut expected) = (under, expected);
        found.place_at(&(0..0));
        expected.place_at(&(0..0));
        assert_eq!(found, expected);
    }

    #[test]
    fn elements_go_by_number_or_name() {
        let laid = |over: &str| {
            let mut under =
                tree("l = [{ name = 'key', x = 1 }, { name = '0', x = 2 }, { x = 3 }]\nm = [{ x = 4 }]\nn = [1]");
            under.lay_over(tree(over)).map(|()| under)
        };
        let x = |node: &Node, path: &str| node.find(path).0.as_number();
        let both = laid("l.key.x = 7\nl.2.x = 9").expect("elements");
        assert_eq!(["l[0].x", "l[1].x", "l[2].x"].map(|path| x(&both, path)), [Some(7.0), Some(2.0), Some(9.0)]);
        let numbered = laid("l.0.x = 5").expect("an element");
        assert_eq!(
            ["l[0].x", "l[1].x"].map(|path| x(&numbered, path)),
            [Some(5.0), Some(2.0)],
            "a number is not a name"
        );
        for (over, path, message, help) in [
            (
                "l.kez.x = 1",
                "l",
                "has no element called \"kez\"; did you mean `key`?",
                "key, 0, or go by number from 0 to 2",
            ),
            ("l.3.x = 1", "l", "has no element 3", "there are 3, numbered from 0"),
            ("m.a.x = 1", "m", "has no element called \"a\"", "have no names; write a number from 0 to 0"),
        ] {
            let error = laid(over).expect_err(over);
            assert_eq!((&*error.path, &*error.message), (path, message), "{over}");
            assert!(error.help.contains(help), "{}", error.help);
        }
        assert!(laid("n.a = 1").is_ok_and(|under| under.find("n.a").0.as_number() == Some(1.0)), "numbers give way");
        let mut twins = tree("l = [{ name = 'a' }, { name = 'a' }]");
        let error = twins.lay_over(tree("l.a.x = 1")).expect_err("twins");
        assert!(error.help.ends_with("0 or 1"), "{error:?}");
    }

    #[test]
    fn a_key_takes_the_place_of_what_says_the_same() {
        for (under, over, expected) in [
            ("a = { file = 'x' }", "a.texture = 'y'", "a = { texture = 'y' }"),
            ("a = { texture = 'x', tiles = [2, 2] }", "a.linear_rgb = [1, 1, 1]", "a = { linear_rgb = [1, 1, 1] }"),
            ("a = { texture = 'x', tiles = [2, 2] }", "a.texture = 'y'", "a = { texture = 'y', tiles = [2, 2] }"),
            ("a = [0, 1, 0]", "a.texture = 'y'", "a = { texture = 'y' }"),
            ("l = [{ look_at_m = 1, up = 2 }]", "l.0.direction = 3", "l = [{ up = 2, direction = 3 }]"),
            ("l = [{ rotation_deg = 1 }]", "l.0 = { quaternion_wxyz = 3 }", "l = [{ quaternion_wxyz = 3 }]"),
            ("m = { type = 'a', x = 1 }", "m = { type = 'b', y = 2 }", "m = { type = 'b', y = 2 }"),
            ("m = { type = 'a', x = 1 }", "m = { type = 'a', y = 2 }", "m = { type = 'a', x = 1, y = 2 }"),
            ("m = { type = 'a', x = 1 }", "m.type = 'b'", "m = { type = 'b', x = 1 }"),
            (
                "l = [{ name = 'n', type = 'a', x = 1 }]",
                "l.n = { type = 'b', y = 2 }",
                "l = [{ name = 'n', type = 'b', y = 2 }]",
            ),
            ("e = { illuminant = 'A', illuminance_lux = 1 }", "e.rgb = 3", "e = { rgb = 3, illuminance_lux = 1 }"),
        ] {
            let (mut laid, mut expected) = (tree(under), tree(expected));
            laid.lay_over(tree(over)).expect("elements");
            laid.place_at(&(0..0));
            expected.place_at(&(0..0));
            assert_eq!(laid, expected, "{over}");
        }
    }

    #[test]
    fn syntax_errors_have_a_place() {
        let (span, _) = parse("a = 1\nb = = 2", 100).expect_err("two equals signs");
        assert!(span.is_some_and(|span| (109..=112).contains(&span.start)));
    }
}
