//! Values of a calibration file, which know their lines, and their reading into numbers with errors that name the key.

use std::cell::RefCell;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use photosite_core::Invalid;
use photosite_core::suggest::{did_you_mean, list};

/// Largest departure of RᵀR from the identity that is taken for rounding of what somebody typed.
const ROTATION_ERROR: f64 = 1e-3;

/// Fault of a file: what is wrong, and the line, counted from 1, where that is known.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    pub(super) line: Option<usize>,
    pub(super) invalid: Invalid,
}

impl Fault {
    pub(super) fn new(line: usize, key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { line: Some(line), invalid: Invalid::new(key, message) }
    }

    /// Fault of the file as a whole.
    pub(super) fn of_file(message: impl Into<String>) -> Self {
        Self { line: None, invalid: Invalid::new("", message) }
    }

    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.invalid = self.invalid.help(help.into());
        self
    }
}

/// Value with the line that it begins in.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    pub(super) line: usize,
    pub(super) value: Value,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// Number, word or text.
    Scalar(String),
    List(Vec<Node>),
    Table(Vec<(String, Node)>),
}

impl Value {
    fn kind(&self) -> &'static str {
        match self {
            Self::Scalar(_) => "a single value",
            Self::List(_) => "a list",
            Self::Table(_) => "a table",
        }
    }
}

/// Value at a key.
#[derive(Clone, Debug)]
pub(super) struct Item<'a> {
    pub(super) key: String,
    pub(super) node: &'a Node,
}

/// Table of values; it remembers which of them were asked for.
#[derive(Debug)]
pub(super) struct Table<'a> {
    key: String,
    line: usize,
    entries: &'a [(String, Node)],
    read: RefCell<Vec<&'a str>>,
}

impl<'a> Table<'a> {
    /// Table of a whole file.
    pub(super) fn of_file(node: &'a Node) -> Result<Self, Fault> {
        Item { key: String::new(), node }.table()
    }

    /// Value at the first of some keys that mean the same.
    pub(super) fn get_any(&self, keys: &[&str]) -> Option<Item<'a>> {
        keys.iter().find_map(|key| self.get(key))
    }

    pub(super) fn get(&self, key: &str) -> Option<Item<'a>> {
        let (name, node) = self.entries.iter().find(|(name, _)| name == key)?;
        self.read.borrow_mut().push(name);
        Some(Item { key: self.path(key), node })
    }

    /// Whether the table has one of some keys.
    pub(super) fn has_any(&self, keys: &[&str]) -> bool {
        self.entries.iter().any(|(name, _)| keys.contains(&name.as_str()))
    }

    /// Value that there must be; `example` is what to write.
    pub(super) fn require(&self, key: &str, example: &str) -> Result<Item<'a>, Fault> {
        self.get(key).ok_or_else(|| self.missing(key, example))
    }

    /// Fault of a key that is missing.
    pub(super) fn missing(&self, key: &str, example: &str) -> Fault {
        let near = did_you_mean(key, self.entries.iter().map(|(name, _)| name.as_str()));
        Fault::new(self.line, self.key.clone(), format!("the key `{key}` is missing{near}"))
            .help(format!("for example {example}"))
    }

    /// All entries, as tables where they are that.
    pub(super) fn items(&self) -> impl Iterator<Item = (&'a str, Item<'a>)> {
        self.entries.iter().map(|(name, node)| (name.as_str(), Item { key: self.path(name), node }))
    }

    /// Keys that nobody has asked for, but for those without a meaning for a camera.
    pub(super) fn unread(&self, without_meaning: &[&str]) -> Vec<String> {
        let read = self.read.borrow();
        let names = self.entries.iter().map(|(name, _)| name.as_str());
        names.filter(|name| !read.contains(name) && !without_meaning.contains(name)).map(|n| self.path(n)).collect()
    }

    fn path(&self, key: &str) -> String {
        if self.key.is_empty() { key.to_owned() } else { format!("{}.{key}", self.key) }
    }
}

impl<'a> Item<'a> {
    pub(super) fn fault(&self, message: impl Into<String>) -> Fault {
        Fault::new(self.node.line, self.key.clone(), message)
    }

    fn misfit(&self, expected: &str) -> Fault {
        self.fault(format!("expected {expected}, found {}", self.node.value.kind()))
    }

    pub(super) fn table(&self) -> Result<Table<'a>, Fault> {
        match &self.node.value {
            Value::Table(entries) => {
                Ok(Table { key: self.key.clone(), line: self.node.line, entries, read: RefCell::default() })
            }
            Value::Scalar(_) | Value::List(_) => Err(self.misfit("a table")),
        }
    }

    pub(super) fn text(&self) -> Result<&'a str, Fault> {
        match &self.node.value {
            Value::Scalar(text) => Ok(text),
            Value::List(_) | Value::Table(_) => Err(self.misfit("a word")),
        }
    }

    pub(super) fn number(&self) -> Result<f64, Fault> {
        match &self.node.value {
            Value::Scalar(text) => self.parsed(text, self.node.line),
            Value::List(_) | Value::Table(_) => Err(self.misfit("a number")),
        }
    }

    /// Columns or rows.
    pub(super) fn count(&self) -> Result<u32, Fault> {
        let number = self.number()?;
        match number {
            n if n.fract() == 0.0 && (1.0..=f64::from(u32::MAX)).contains(&n) => Ok(n as u32),
            n => Err(self.fault(format!("expected a whole number of pixels above 0, found {n}"))),
        }
    }

    /// Columns and rows, in a list.
    pub(super) fn resolution(&self) -> Result<[u32; 2], Fault> {
        let size = self.array::<2>("columns and rows")?;
        match size.iter().find(|n| !(n.fract() == 0.0 && (1.0..=f64::from(u32::MAX)).contains(*n))) {
            None => Ok(size.map(|n| n as u32)),
            Some(n) => Err(self.fault(format!("expected whole numbers of pixels above 0, found {n}"))),
        }
    }

    /// Numbers of a list, of lists in it one after the other, or of a matrix as OpenCV writes it.
    pub(super) fn numbers(&self) -> Result<Vec<f64>, Fault> {
        match &self.node.value {
            Value::Scalar(text) => text.split_whitespace().map(|word| self.parsed(word, self.node.line)).collect(),
            Value::List(nodes) => {
                let of = |node| Self { key: self.key.clone(), node }.numbers();
                nodes.iter().map(of).collect::<Result<Vec<_>, _>>().map(|lists| lists.concat())
            }
            Value::Table(_) => {
                let table = self.table()?;
                let data = table.require("data", "data: [1.0, 0.0, 0.0]")?.numbers()?;
                let mut expected = 1.0;
                for key in ["rows", "cols"] {
                    expected *= table.get(key).map_or(Ok(f64::NAN), |size| size.number())?;
                }
                if expected.is_finite() && expected != data.len() as f64 {
                    let message = format!("has {} numbers, and rows times cols are {expected}", data.len());
                    return Err(self.fault(message));
                }
                Ok(data)
            }
        }
    }

    /// Rows of numbers, of a list of lists or of a matrix as OpenCV writes it.
    pub(super) fn rows(&self) -> Result<Vec<Vec<f64>>, Fault> {
        match &self.node.value {
            Value::List(nodes) => nodes.iter().map(|node| Self { key: self.key.clone(), node }.numbers()).collect(),
            Value::Table(_) => {
                let columns = self.table()?.require("cols", "cols: 6")?.count()? as usize;
                Ok(self.numbers()?.chunks(columns).map(<[f64]>::to_vec).collect())
            }
            Value::Scalar(_) => Err(self.misfit("rows of numbers")),
        }
    }

    /// So many numbers; `names` are what they are.
    pub(super) fn array<const N: usize>(&self, names: &str) -> Result<[f64; N], Fault> {
        let numbers = self.numbers()?;
        let found = numbers.len();
        numbers.try_into().map_err(|_| self.fault(format!("expected {N} numbers, {names}, found {found}")))
    }

    /// Pose of a matrix of three or four rows, which takes points from a frame to another.
    pub(super) fn pose(&self) -> Result<DAffine3, Fault> {
        let numbers = self.numbers()?;
        let (rows, last) = numbers.split_at(numbers.len().min(12));
        let is_last = last.is_empty() || last == [0.0, 0.0, 0.0, 1.0];
        let Ok([a, b, c, x, d, e, f, y, g, h, i, z]) = <[f64; 12]>::try_from(rows) else {
            return Err(self.fault(format!("expected the 4 × 4 matrix of a pose, found {} numbers", numbers.len())));
        };
        if !is_last {
            return Err(self.fault("the last row of a pose is 0, 0, 0, 1"));
        }
        let rotation = self.rotation_of([a, b, c, d, e, f, g, h, i])?;
        Ok(DAffine3::from_mat3_translation(rotation, DVec3::new(x, y, z)))
    }

    /// Rotation of nine numbers, row by row.
    pub(super) fn rotation(&self) -> Result<DMat3, Fault> {
        self.rotation_of(self.array::<9>("a matrix row by row")?)
    }

    /// Rotation nearest to a matrix that is one but for rounding.
    fn rotation_of(&self, rows: [f64; 9]) -> Result<DMat3, Fault> {
        let matrix = DMat3::from_cols_array(&rows).transpose();
        let error = (matrix.transpose() * matrix - DMat3::IDENTITY).to_cols_array();
        let error = error.into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        if !(error < ROTATION_ERROR && matrix.determinant() > 0.0) {
            let message = format!("is no rotation: RᵀR is {error:.2e} off the identity");
            let message = if error < ROTATION_ERROR { "mirrors, and is no rotation".to_owned() } else { message };
            return Err(self.fault(message).help("its rows are unit vectors at right angles"));
        }
        Ok(DMat3::from_quat(DQuat::from_mat3(&matrix).normalize()))
    }

    fn parsed(&self, text: &str, line: usize) -> Result<f64, Fault> {
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            Ok(_) => Err(Fault::new(line, self.key.clone(), format!("must be finite, found {text}"))),
            Err(_) => Err(Fault::new(line, self.key.clone(), format!("expected a number, found {text:?}"))),
        }
    }
}

/// Fault of a name that is none of those that there are.
pub(super) fn unknown<'n>(
    item: &Item<'_>,
    what: &str,
    name: &str,
    known: impl Iterator<Item = &'n str> + Clone,
) -> Fault {
    let message = format!("photosite has no {what} {name:?}{}", did_you_mean(name, known.clone()));
    item.fault(message).help(format!("it renders {}", list(name, known)))
}
