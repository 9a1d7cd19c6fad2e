//! XML as cv::FileStorage writes it, as the tree that its YAML has.

use quick_xml::Reader;
use quick_xml::events::Event;

use super::tree::{Fault, Node, Value};

/// Deepest nesting; that of calibrations is 4.
const DEEPEST: usize = 32;

/// Element whose end has not been reached.
struct Open {
    name: String,
    line: usize,
    text: String,
    children: Vec<(String, Node)>,
}

impl Open {
    fn new(name: String, line: usize) -> Self {
        Self { name, line, text: String::new(), children: Vec::new() }
    }

    fn close(self) -> Node {
        let value = match self.children {
            children if children.is_empty() => Value::Scalar(unquoted(self.text.trim())),
            // Elements of lists have no names.
            children if children.iter().all(|(name, _)| name == "_") => {
                Value::List(children.into_iter().map(|(_, node)| node).collect())
            }
            children => Value::Table(children),
        };
        Node { line: self.line, value }
    }
}

/// Values of a text of XML: those in its outermost element.
pub(super) fn parse(text: &str) -> Result<Node, Fault> {
    let mut reader = Reader::from_str(text);
    let mut open: Vec<Open> = Vec::new();
    let (mut line, mut counted) = (1, 0);
    loop {
        let at = usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX).min(text.len());
        line += text.as_bytes()[counted..at].iter().filter(|&&byte| byte == b'\n').count();
        counted = at;
        let no_xml = |what: String| Fault::new(line, "", format!("is not valid XML: {what}"));
        let closed = match reader.read_event().map_err(|error| no_xml(error.to_string()))? {
            Event::Start(start) => {
                if open.len() > DEEPEST {
                    return Err(Fault::new(line, "", format!("elements are nested more than {DEEPEST} deep")));
                }
                open.push(Open::new(start.name().as_ref().to_owned(), line));
                None
            }
            Event::Empty(start) => Some(Open::new(start.name().as_ref().to_owned(), line)),
            Event::End(_) => open.pop(),
            Event::Text(inner) => {
                if let Some(element) = open.last_mut() {
                    element.text += &inner;
                }
                None
            }
            Event::GeneralRef(name) => {
                if let Some(element) = open.last_mut() {
                    element.text += quick_xml::escape::resolve_predefined_entity(&name).unwrap_or("");
                }
                None
            }
            Event::Eof => return Err(Fault::new(line, "", "the file ends before its last element does")),
            Event::Decl(_) | Event::Comment(_) | Event::PI(_) | Event::DocType(_) | Event::CData(_) => None,
        };
        let Some(element) = closed else { continue };
        let Some(outer) = open.last_mut() else { return Ok(element.close()) };
        if element.name != "_" && outer.children.iter().any(|(name, _)| *name == element.name) {
            return Err(Fault::new(line, element.name, "stands there twice").help("keep one of them"));
        }
        outer.children.push((element.name.clone(), element.close()));
    }
}

fn unquoted(text: &str) -> String {
    let inner = text.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
    inner.unwrap_or(text).to_owned()
}
