//! Attributes of serde and schemars that state the name of a key and what stands in its place.

use proc_macro2::Ident;
use syn::{Attribute, Expr, ExprCall, ExprLit, Lit, LitStr, Meta, Result, Token, Type, punctuated::Punctuated};

/// Attributes of serde, schemars and keys on a type, a field or a variant.
#[derive(Default)]
pub(crate) struct Attributes {
    /// Name of the key in a file.
    rename: Option<String>,
    is_kebab: bool,
    /// The key that tells the variants of an enum.
    pub(crate) tag: Option<String>,
    pub(crate) is_untagged: bool,
    /// Whether a field is no key.
    pub(crate) is_skipped: bool,
    /// Whether the keys of a field are those of the table itself.
    pub(crate) is_flat: bool,
    /// The name of the builder, where it is not that of the table.
    pub(crate) named: Option<Ident>,
    /// The table that these keys stand in as well.
    pub(crate) beside: Option<Type>,
    /// Type that is given for a variant, by its name: that of a table of another crate is not known to differ from
    /// other types.
    pub(crate) given: Option<Type>,
    /// The range of a number, `within(…)` or `above(…)`.
    pub(crate) range: Option<ExprCall>,
    /// Example of a number in the range, for the error of one that is not; with it, the range is checked.
    pub(crate) example: Option<String>,
    /// The type that a field has in files.
    pub(crate) with: Option<Type>,
}

impl Attributes {
    pub(crate) fn of(attributes: &[Attribute]) -> Result<Self> {
        let mut found = Self::default();
        let ours =
            |attribute: &&Attribute| ["serde", "schemars", "keys"].iter().any(|name| attribute.path().is_ident(name));
        for attribute in attributes.iter().filter(ours) {
            for meta in attribute.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated)? {
                found.add(&meta)?;
            }
        }
        Ok(found)
    }

    fn add(&mut self, meta: &Meta) -> Result<()> {
        if let Meta::NameValue(pair) = meta
            && let Expr::Call(range) = &pair.value
            && pair.path.is_ident("transform")
        {
            self.range = Some(range.clone());
        }
        let Some(name) = meta.path().get_ident().map(ToString::to_string) else { return Ok(()) };
        match (&*name, text(meta)) {
            ("rename", Some(text)) => self.rename = Some(text.value()),
            ("rename_all", Some(text)) => self.is_kebab = text.value() == "kebab-case",
            ("tag", Some(text)) => self.tag = Some(text.value()),
            ("with", Some(text)) => self.with = Some(text.parse()?),
            ("example", Some(text)) => self.example = Some(text.value()),
            ("beside", Some(text)) => self.beside = Some(text.parse()?),
            ("given", Some(text)) => self.given = Some(text.parse()?),
            ("named", Some(text)) => self.named = Some(text.parse()?),
            ("untagged", None) => self.is_untagged = true,
            ("skip", None) => self.is_skipped = true,
            ("flatten", None) => self.is_flat = true,
            _ => {}
        }
        Ok(())
    }

    /// Name in a file of `ident`, in an enum whose attributes are `around`.
    pub(crate) fn name(&self, ident: &Ident, around: &Self) -> String {
        let name = ident.to_string();
        self.rename.clone().unwrap_or_else(|| if around.is_kebab { kebab(&name) } else { name })
    }
}

fn text(meta: &Meta) -> Option<&LitStr> {
    match meta {
        Meta::NameValue(pair) => match &pair.value {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text),
            _ => None,
        },
        _ => None,
    }
}

/// Kebab case of a name: `MetallicRoughness` as `metallic-roughness`.
fn kebab(name: &str) -> String {
    let mut kebab = String::new();
    for (i, letter) in name.char_indices() {
        if letter.is_ascii_uppercase() && i > 0 {
            kebab.push('-');
        }
        kebab.push(letter.to_ascii_lowercase());
    }
    kebab
}

/// Doc comments of the item with these attributes.
pub(crate) fn docs(attributes: &[Attribute]) -> Vec<&Attribute> {
    attributes.iter().filter(|attribute| attribute.path().is_ident("doc")).collect()
}
