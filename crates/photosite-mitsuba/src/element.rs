//! XML elements of a Mitsuba scene file.

use quick_xml::Writer;
use quick_xml::events::{BytesEnd, BytesStart, Event};

use photosite_core::spectrum::{LAMBDA_MAX_NM, LAMBDA_MIN_NM, Spectrum};

/// XML element.
#[derive(Clone, Debug)]
pub(super) struct Element {
    tag: &'static str,
    attributes: Vec<(&'static str, String)>,
    children: Vec<Element>,
}

impl Element {
    /// Element `<tag>`.
    pub(super) fn new(tag: &'static str) -> Self {
        Self { tag, attributes: Vec::new(), children: Vec::new() }
    }

    /// Element `<tag type="…">`: an object of Mitsuba.
    pub(super) fn object(tag: &'static str, kind: &str) -> Self {
        Self::new(tag).attribute("type", kind)
    }

    /// Element `<ref id="…"/>`: an object that has been described before.
    pub(super) fn reference(id: &str) -> Self {
        Self::new("ref").attribute("id", id)
    }

    /// The element with another attribute.
    pub(super) fn attribute(mut self, name: &'static str, value: impl ToString) -> Self {
        self.attributes.push((name, value.to_string()));
        self
    }

    /// The element with the name by which its parent knows it.
    pub(super) fn named(self, name: impl ToString) -> Self {
        self.attribute("name", name)
    }

    /// The element with another child.
    pub(super) fn child(mut self, child: Element) -> Self {
        self.children.push(child);
        self
    }

    /// The element with more children.
    pub(super) fn with(mut self, children: impl IntoIterator<Item = Element>) -> Self {
        self.children.extend(children);
        self
    }

    /// The element with a `float` child.
    pub(super) fn float(self, name: &str, value: f64) -> Self {
        self.child(Self::new("float").named(name).attribute("value", value))
    }

    /// The element with an `integer` child.
    pub(super) fn integer(self, name: &str, value: impl ToString) -> Self {
        self.child(Self::new("integer").named(name).attribute("value", value))
    }

    /// The element with a `string` child.
    pub(super) fn string(self, name: &str, value: impl ToString) -> Self {
        self.child(Self::new("string").named(name).attribute("value", value))
    }

    /// The element with a `boolean` child.
    pub(super) fn boolean(self, name: &str, value: bool) -> Self {
        self.child(Self::new("boolean").named(name).attribute("value", value))
    }

    /// The element with a `transform` child: a matrix, rows first.
    pub(super) fn transform(self, name: &str, matrix: [[f64; 4]; 4]) -> Self {
        let value = join(" ", matrix.as_flattened().iter());
        self.child(Self::new("transform").named(name).child(Self::new("matrix").attribute("value", value)))
    }

    /// The element with a `spectrum` child, taken over point by point: Mitsuba's `regular` spectra are linear between
    /// their points, as those of photosite are.
    pub(super) fn spectrum(self, name: &str, spectrum: &Spectrum) -> Self {
        if spectrum.min() == 0.0 && spectrum.max() == 0.0 {
            // A `regular` spectrum may not be black.
            return self.child(Self::object("spectrum", "uniform").named(name).float("value", 0.0));
        }
        let values = spectrum.values();
        // Two points suffice for a constant.
        let values = if spectrum.min() == spectrum.max() { &values[..2] } else { &values[..] };
        let table = Self::object("spectrum", "regular")
            .named(name)
            .float("wavelength_min", LAMBDA_MIN_NM.into())
            .float("wavelength_max", LAMBDA_MAX_NM.into())
            .string("values", join(", ", values.iter()));
        self.child(table)
    }

    /// Text of a file with this element at its root.
    pub(super) fn to_xml(&self) -> Vec<u8> {
        let mut writer = Writer::new_with_indent(Vec::new(), b' ', 4);
        self.write(&mut writer).expect("a vector takes all bytes");
        let mut text = writer.into_inner();
        text.push(b'\n');
        text
    }

    fn write(&self, writer: &mut Writer<Vec<u8>>) -> std::io::Result<()> {
        let attributes = self.attributes.iter().map(|(name, value)| (*name, value.as_str()));
        let start = BytesStart::new(self.tag).with_attributes(attributes);
        if self.children.is_empty() {
            return writer.write_event(Event::Empty(start));
        }
        writer.write_event(Event::Start(start))?;
        self.children.iter().try_for_each(|child| child.write(writer))?;
        writer.write_event(Event::End(BytesEnd::new(self.tag)))
    }
}

fn join<T: ToString>(separator: &str, values: impl Iterator<Item = T>) -> String {
    values.map(|v| v.to_string()).collect::<Vec<_>>().join(separator)
}
