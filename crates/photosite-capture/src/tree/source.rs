//! Source of a capture: its file and the command line, as one tree of values that remembers where each of them stands.
//!
//! The texts (the file, a sensor file, every override) lie one after the other in an imagined long text, and a span is
//! a range of that. So values of several texts can be laid over each other, and an error about any of them still points
//! to the right line of the right file, or to the argument.
//!
//! The sensor of a report stands beside the tree: it is complete, and what the tree says of the sensor changes it.

use photosite_core::{Help, Sandbox};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::de::{DeserializeOwned, DeserializeSeed};

use super::nodes::{Entry, NoElement, Node, Table, Value, from_json, join, parse};
use super::reader::{ReadError, Reader};
use photosite_core::json;
use photosite_core::suggest::{did_you_mean, list};
use photosite_core::{Error, Invalid, Result};
use photosite_files::file_sum::KnownSums;

/// The values of a capture and where they come from.
#[derive(Clone, Debug)]
pub struct CaptureSource {
    /// The capture file, or the scene file that was given in its place.
    path: PathBuf,
    texts: Vec<Text>,
    root: Node,
    /// Warnings about keys that overrides have replaced by others.
    displaced: Vec<String>,
    /// The whole sensor that a report holds.
    stored_sensor: Option<Node>,
    /// Sandbox in which the files that it names must lie.
    sandbox: Sandbox,
    /// Sums of the files that it names, which all captures have in common that are made of it.
    sums: Arc<KnownSums>,
}

/// Text, and the byte at which it begins in the imagined long one.
#[derive(Clone, Debug)]
struct Text {
    origin: Origin,
    start: usize,
    text: String,
}

#[derive(Clone, Debug)]
enum Origin {
    File(PathBuf),
    /// No text: values that nobody wrote.
    Nothing,
    /// A report (`capture.json`), which holds the values at its key `capture`.
    Report(PathBuf),
    /// An override, `key=value`.
    Argument(String),
}

impl CaptureSource {
    /// A source without values, for errors of the file at `path`.
    pub fn empty(path: &Path) -> Self {
        let texts = vec![Text { origin: Origin::Nothing, start: 0, text: String::new() }];
        let root = Node { span: 0..0, value: Value::Table(Table::new()) };
        Self {
            path: path.to_owned(),
            texts,
            root,
            stored_sensor: None,
            displaced: Vec::new(),
            sandbox: Sandbox::default(),
            sums: Arc::default(),
        }
    }

    /// A scene file that stands in for the capture file: its geometry.
    pub fn of_scene_file(path: &Path) -> Self {
        let mut source = Self::empty(path);
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        source.root = from_json(&serde_json::json!({ "scene": { "geometry": [name] } }), &(0..0));
        source
    }

    /// Parses the text of a capture file.
    pub fn parse(path: &Path, text: String) -> Result<Self> {
        let mut source = Self::empty(path);
        source.root = source.add_file(path, text)?;
        Ok(source)
    }

    /// Source of values that no text holds; `path` stands for their file.
    pub fn of_values(path: &Path, values: &serde_json::Value) -> Result<Self> {
        let mut source = Self::empty(path);
        if !values.is_object() {
            return Err(Invalid::new("", "a capture is a table of tables").in_file(path));
        }
        source.root = from_json(values, &(0..0));
        Ok(source)
    }

    /// Source of the values that a report holds, whose text is given for messages. The sensor in it is whole, whatever
    /// preset it names; it is called `sensor` unless it says otherwise.
    pub fn of_report(path: &Path, text: String, capture: &serde_json::Value, sensor: &str) -> Self {
        let mut root = from_json(capture, &(0..0));
        let stored_sensor = root.remove("sensor").map(|mut node| {
            node.remove("preset");
            node.insert_new("name", from_json(&sensor.into(), &(0..0)));
            node
        });
        let texts = vec![Text { origin: Origin::Report(path.to_owned()), start: 0, text }];
        Self { texts, root, stored_sensor, ..Self::empty(path) }
    }

    /// Takes the sensor out of the tree.
    pub(crate) fn take_sensor(&mut self) -> Option<Node> {
        self.root.remove("sensor")
    }

    /// Keeps a whole sensor as the base of changes, like that of a report.
    pub(crate) fn keep_sensor(&mut self, mut sensor: Node, name: &str) {
        sensor.insert_new("name", from_json(&name.into(), &(0..0)));
        self.stored_sensor = Some(sensor);
    }

    /// The source where the files that it names must lie in a sandbox.
    #[must_use]
    pub fn within(self, sandbox: &Sandbox) -> Self {
        Self { sandbox: sandbox.clone(), ..self }
    }

    /// Sandbox in which the files that it names must lie.
    pub fn sandbox(&self) -> &Sandbox {
        &self.sandbox
    }

    /// Sums of the files that it names.
    pub fn sums(&self) -> &KnownSums {
        &self.sums
    }

    /// The whole sensor that a report holds.
    pub(crate) fn stored_sensor(&self) -> Option<&Node> {
        self.stored_sensor.as_ref()
    }

    /// The capture file, or the scene file that was given in its place.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The text of the capture file; empty where a scene file was given.
    pub fn text(&self) -> &str {
        let is_file = |text: &&Text| matches!(&text.origin, Origin::File(path) if *path == self.path);
        self.texts.iter().find(is_file).map_or("", |text| &text.text)
    }

    /// Adds a TOML file to the texts and returns its values.
    pub(crate) fn add_file(&mut self, path: &Path, text: String) -> Result<Node> {
        self.add(Origin::File(path.to_owned()), text)
    }

    /// Lays an override, written as the TOML document `toml`, over the tree.
    pub fn set(&mut self, argument: &str, toml: String) -> Result<()> {
        let over = self.add(Origin::Argument(argument.to_owned()), toml)?;
        self.root.lay_over(over).map_err(|error| self.no_element("", error))
    }

    /// The error of a key below `table` that addresses no element of a list.
    pub(crate) fn no_element(&self, table: &str, error: NoElement) -> Error {
        let NoElement { path, span, message, help } = error;
        self.error_at(Some(&span), Invalid { key: join(table, &path), message, help: Some(help.into()) })
    }

    /// Takes a key out of a table at the top of the tree, if it is there.
    pub(crate) fn remove(&mut self, table: &str, key: &str) -> Option<Node> {
        let Value::Table(tables) = &mut self.root.value else { return None };
        tables.get_mut(table)?.node.remove(key)
    }

    /// Whether a value was given by an override.
    pub(crate) fn is_of_argument(&self, node: &Node) -> bool {
        let text = self.texts.iter().rev().find(|text| text.start <= node.span.start);
        text.is_some_and(|text| matches!(text.origin, Origin::Argument(_)))
    }

    /// Keeps for a warning that an override has taken the place of other keys.
    pub fn note_displaced(&mut self, argument: &str, keys: &[String]) {
        if !keys.is_empty() {
            let keys = keys.join(", ");
            self.displaced.push(format!("{argument} replaces {keys}, which cannot apply at the same time"));
        }
    }

    /// Keys that [`Self::note_displaced`] has kept.
    pub fn displaced(&self) -> &[String] {
        &self.displaced
    }

    /// Gives a key of a table at the top of the tree a value, unless it has one.
    pub fn set_default(&mut self, table: &str, key: &str, value: &serde_json::Value) {
        if self.get(table).is_none() {
            self.replace(table, from_json(&serde_json::json!({}), &(0..0)));
        }
        if let Value::Table(tables) = &mut self.root.value
            && let Some(entry) = tables.get_mut(table)
        {
            entry.node.insert_new(key, from_json(value, &(0..0)));
        }
    }

    /// Gives the table at a path of keys those that it lacks.
    pub fn complete(&mut self, path: &[&str], keys: &serde_json::Value) {
        let Some(table) = self.root.at_mut(path) else { return };
        for (key, value) in keys.as_object().into_iter().flatten() {
            table.insert_new(key, from_json(value, &(0..0)));
        }
    }

    fn add(&mut self, origin: Origin, text: String) -> Result<Node> {
        let start = self.texts.last().map_or(0, |last| last.start + last.text.len() + 1);
        let parsed = parse(&text, start);
        self.texts.push(Text { origin, start, text });
        parsed.map_err(|(span, message)| {
            self.error_at(span.as_ref(), Invalid::new("", format!("is not valid TOML: {message}")))
        })
    }

    /// Whether a value is given at a path such as `lens.f_number`.
    pub fn has(&self, path: &str) -> bool {
        self.get(path).is_some()
    }

    /// The value at a path such as `materials.red.reflectance` or `lights[0].type`.
    pub(crate) fn get(&self, path: &str) -> Option<&Node> {
        Some(self.root.find(path)).filter(|(_, is_exact)| *is_exact).map(|(node, _)| node)
    }

    /// The keys and values at the top.
    pub(crate) fn sections(&self) -> impl Iterator<Item = (&str, &Node)> {
        self.root.as_table().into_iter().flatten().map(|(key, entry)| (key.as_str(), &entry.node))
    }

    /// Replaces a value at the top of the tree.
    pub(crate) fn replace(&mut self, key: &str, node: Node) {
        if let Value::Table(table) = &mut self.root.value {
            table.insert(key.to_owned(), Entry { key_span: node.span.clone(), node });
        }
    }

    /// Reads the value at a path.
    pub fn read<T: DeserializeOwned>(&self, path: &str) -> Result<Option<T>> {
        self.get(path).map(|node| self.read_node(path, node)).transpose()
    }

    /// Reads all values together.
    pub fn read_whole<T: DeserializeOwned>(&self) -> Result<T> {
        self.read_node("", &self.root)
    }

    /// Reads a value. `path` is where it is, for messages.
    pub(crate) fn read_node<T: DeserializeOwned>(&self, path: &str, node: &Node) -> Result<T> {
        T::deserialize(Reader(node)).map_err(|error| self.type_error(path, error))
    }

    /// Reads a table as `seed` has it. Keys that belong there but are read elsewhere are suggested, too.
    pub(crate) fn read_beside<S: for<'de> DeserializeSeed<'de, Value = T>, T>(
        &self,
        path: &str,
        node: &Node,
        seed: S,
        elsewhere: &[&str],
    ) -> Result<T> {
        seed.deserialize(Reader(node)).map_err(|mut error| {
            if let Some(key) = error.unknown_key.as_ref().filter(|_| error.path.is_empty()) {
                if !error.message.contains(';') {
                    error.message += &did_you_mean(key, elsewhere.iter().copied());
                }
                error.help = error.help.map(|help| format!("{help}; and {}", list(key, elsewhere.iter().copied())));
            }
            self.type_error(path, error)
        })
    }

    /// The error of a value that does not fit its type.
    fn type_error(&self, path: &str, error: ReadError) -> Error {
        let ReadError { message, help, path: inner, unknown_key } = error;
        let help = help.map(Help::from);
        let table = join(path, &inner);
        let Some(key) = unknown_key else { return self.error(Invalid { key: table, message, help }) };
        let entries = self.get(&table).and_then(Node::as_table);
        let span = entries.and_then(|entries| entries.get(&key)).map(|entry| &entry.key_span);
        // A key that is right one table deeper, as `sensor.bits` for `sensor.adc.bits`.
        let holds_key = |entry: &Entry| entry.node.as_table().is_some_and(|inner| inner.contains_key(&key));
        let deeper = entries.into_iter().flatten().find(|(_, entry)| holds_key(entry));
        // "unknown key `x`; did you mean `y`?" gets the name of the table in its middle.
        let (unknown, suggestion) = message.split_at(message.find(';').unwrap_or(message.len()));
        let suggestion =
            deeper.map_or(suggestion.to_owned(), |(name, _)| format!("; did you mean `{}`?", join(name, &key)));
        let message = format!("{unknown} in [{table}]{suggestion}");
        self.error_at(span, Invalid { key: join(&table, &key), message, help })
    }

    /// The error of a value that cannot be used, placed at its key, or at the innermost table around it.
    pub fn error(&self, invalid: Invalid) -> Error {
        let (node, is_exact) = self.root.find(&invalid.key);
        let is_root = std::ptr::eq(node, &raw const self.root);
        // The file as a whole is better named without a line than by its first.
        let span = Some(&node.span).filter(|_| is_exact || !is_root).filter(|_| !invalid.key.is_empty());
        self.error_at(span, invalid)
    }

    /// The error of a value that cannot stand where it does.
    pub(crate) fn error_at_node(&self, node: &Node, invalid: Invalid) -> Error {
        self.error_at(Some(&node.span), invalid)
    }

    /// An error at a span of the imagined text.
    fn error_at(&self, span: Option<&Range<usize>>, invalid: Invalid) -> Error {
        let text = span.and_then(|span| self.texts.iter().rev().find(|text| text.start <= span.start));
        let (Some(span), Some(text)) = (span, text) else { return invalid.in_file(&self.path) };
        let end = (span.end - text.start).min(text.text.len());
        let start = (span.start - text.start).min(end);
        match &text.origin {
            Origin::File(path) => invalid.in_text(path, &text.text, start..end),
            Origin::Report(path) => json::located(invalid.within("capture"), path, text.text.as_bytes()),
            Origin::Nothing => invalid.in_file(&self.path),
            Origin::Argument(argument) => invalid.in_override(&shown(argument)),
        }
    }
}

/// Argument as messages name it. One that is longer than a line is cut: its key is what tells it from others.
pub(crate) fn shown(argument: &str) -> String {
    const LONGEST: usize = 80;
    match argument.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &argument[..end]),
        None => argument.to_owned(),
    }
}
