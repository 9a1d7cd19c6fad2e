//! Values with their places: the tree that TOML texts are parsed into.
//!
//! A span is a range of bytes of the imagined text that [`source`](super::source) describes.

use std::collections::BTreeMap;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    pub(super) span: Range<usize>,
    pub(super) value: Value,
}

/// A TOML value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    String(String),
    Integer(i128),
    Float(f64),
    Boolean(bool),
    /// Dates mean nothing here; kept as written, for messages.
    Datetime(String),
    Array(Vec<Node>),
    Table(Table),
}

/// A TOML table.
pub(super) type Table = BTreeMap<String, Entry>;

/// A value in a table, with the place of its key.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) key_span: Range<usize>,
    pub(super) node: Node,
}

impl Node {
    /// The table that the node is.
    pub(super) fn as_table(&self) -> Option<&Table> {
        if let Value::Table(table) = &self.value { Some(table) } else { None }
    }

    /// Takes a value out of the table that the node is.
    pub(super) fn remove(&mut self, key: &str) -> Option<Self> {
        if let Value::Table(table) = &mut self.value { table.remove(key).map(|entry| entry.node) } else { None }
    }

    /// Puts a value into the table that the node is, unless there is one of that key.
    pub(super) fn insert_new(&mut self, key: &str, node: Self) {
        if let Value::Table(table) = &mut self.value {
            table.entry(key.to_owned()).or_insert(Entry { key_span: node.span.clone(), node });
        }
    }

    /// The value at a path of keys through tables.
    pub(super) fn at(&self, path: &[&str]) -> Option<&Self> {
        path.iter().try_fold(self, |node, key| Some(&node.as_table()?.get(*key)?.node))
    }

    /// The value at a path of keys through tables, to be changed.
    pub(super) fn at_mut(&mut self, path: &[&str]) -> Option<&mut Self> {
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
    pub(super) fn as_number(&self) -> Option<f64> {
        match self.value {
            Value::Integer(i) => Some(i as f64),
            Value::Float(x) => Some(x),
            Value::String(_) | Value::Boolean(_) | Value::Datetime(_) | Value::Array(_) | Value::Table(_) => None,
        }
    }

    /// The paths of all keys within this node, tables before what they hold.
    pub(super) fn paths(&self) -> Vec<String> {
        let within = |(key, entry): (&String, &Entry)| {
            let inner = entry.node.paths().into_iter().map(|path| join(key, &path));
            std::iter::once(key.clone()).chain(inner).collect::<Vec<_>>()
        };
        self.as_table().into_iter().flatten().flat_map(within).collect()
    }

    /// The string that the node is.
    pub(super) fn as_str(&self) -> Option<&str> {
        if let Value::String(text) = &self.value { Some(text) } else { None }
    }

    /// Follows the first step of a path such as `materials.red.reflectance` or `[0].type`; returns the node there and
    /// the rest of the path. Keys may contain dots, as names of materials do, so the longest key that fits is taken.
    pub(super) fn step<'p>(&self, path: &'p str) -> Option<(&Self, &'p str)> {
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
    pub(super) fn find(&self, path: &str) -> (&Self, bool) {
        let (mut node, mut rest) = (self, path);
        while let Some((next, after)) = node.step(rest).filter(|_| !rest.is_empty()) {
            (node, rest) = (next, after);
        }
        (node, rest.is_empty())
    }

    /// Lays another value over this one: tables are merged, elements of an array can be addressed by their number,
    /// everything else is replaced.
    pub(super) fn lay_over(&mut self, over: Self) {
        match (&mut self.value, over.value) {
            (Value::Table(under), Value::Table(over)) => {
                for (key, entry) in over {
                    match under.get_mut(&key) {
                        Some(known) => known.node.lay_over(entry.node),
                        None => {
                            under.insert(key, entry);
                        }
                    }
                }
            }
            (Value::Array(under), Value::Table(over)) if addresses(&over, under.len()) => {
                for (key, entry) in over {
                    if let Some(element) = key.parse::<usize>().ok().and_then(|index| under.get_mut(index)) {
                        element.lay_over(entry.node);
                    }
                }
            }
            (_, value) => *self = Self { span: over.span, value },
        }
    }

    /// Gives every value within this one the same place.
    pub(super) fn place_at(&mut self, span: &Range<usize>) {
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
pub(super) fn from_json(value: &serde_json::Value, span: &Range<usize>) -> Node {
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

/// `table.key`, or what there is of it; elements of arrays need no dot.
pub(super) fn join(table: &str, key: &str) -> String {
    match (table, key) {
        ("", _) => key.to_owned(),
        (_, "") => table.to_owned(),
        _ if key.starts_with('[') => format!("{table}{key}"),
        _ => format!("{table}.{key}"),
    }
}

/// Whether all keys of a table are numbers of elements.
fn addresses(table: &Table, len: usize) -> bool {
    table.keys().all(|key| key.parse::<usize>().is_ok_and(|index| index < len))
}

/// Parses a TOML document that begins at byte `start` of the imagined text. The error has its span there, too.
pub(super) fn parse(text: &str, start: usize) -> Result<Node, (Option<Range<usize>>, String)> {
    let moved = |span: Range<usize>| span.start + start..span.end + start;
    match DeTable::parse(text) {
        Ok(table) => {
            Ok(Node { span: moved(table.span()), value: Value::Table(convert_table(table.into_inner(), start)) })
        }
        Err(error) => Err((error.span().map(moved), error.message().to_owned())),
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
        under.lay_over(tree("b.c = 9\ne.1.f = 8\ng = 'none'\nh.i = 3"));
        let expected = tree("a = 1\nb = { c = 9, d = 2 }\ne = [{ f = 1 }, { f = 8 }]\ng = 'none'\nh.i = 3");
        let (mut found, mut expected) = (under, expected);
        found.place_at(&(0..0));
        expected.place_at(&(0..0));
        assert_eq!(found, expected);
    }

    #[test]
    fn syntax_errors_have_a_place() {
        let (span, _) = parse("a = 1\nb = = 2", 100).expect_err("two equals signs");
        assert!(span.is_some_and(|span| (109..=112).contains(&span.start)));
    }
}
