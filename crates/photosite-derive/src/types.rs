//! Types of fields, and those that setters take for them.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};
use syn::{GenericArgument, PathArguments, PathSegment, Type};

/// Name of the builder of a type: `LensTable` has `LensKeys`.
pub(crate) fn named(ident: &Ident, ending: &str) -> Ident {
    let name = ident.to_string();
    let endings = ["Table", "Description", "Settings", "Source", "File"];
    let stem = endings.iter().find_map(|ending| name.strip_suffix(ending)).unwrap_or(&name);
    format_ident!("{stem}{ending}")
}

/// The type in an `Option` or a `Box`, or the type itself.
pub(crate) fn bare(kind: &Type) -> &Type {
    // A type that a macro has taken for one stands in a group.
    if let Type::Group(group) = kind {
        return bare(&group.elem);
    }
    match last(kind) {
        Some(segment) if segment.ident == "Option" || segment.ident == "Box" => {
            arguments(segment).next().map_or(kind, bare)
        }
        _ => kind,
    }
}

/// Setter of a builder: the form in which it takes a value, and the conversion to that of the key.
pub(crate) struct Setter {
    /// Parameters behind `self`; the value is called `value`.
    pub(crate) parameters: TokenStream,
    /// The value given.
    pub(crate) value: TokenStream,
    /// Whether a name comes first, under which it is a value of a map.
    pub(crate) is_named: bool,
}

impl Setter {
    pub(crate) fn of(kind: &Type) -> Self {
        let kind = bare(kind);
        if is_plain(kind) {
            return Self { parameters: quote!(value: #kind), value: quote!(value), is_named: false };
        }
        let segment = last(kind);
        let name = segment.map(|segment| segment.ident.to_string()).unwrap_or_default();
        let inner = segment.and_then(|segment| arguments(segment).last()).map(given);
        match (&*name, inner) {
            ("Vec", Some(item)) => Self {
                parameters: quote!(value: impl IntoIterator<Item = impl Into<#item>>),
                value: quote!(value.into_iter().map(Into::<#item>::into).collect::<Vec<_>>()),
                is_named: false,
            },
            ("BTreeMap", Some(item)) => Self {
                parameters: quote!(name: &str, value: impl Into<#item>),
                value: quote!(Into::<#item>::into(value)),
                is_named: true,
            },
            _ => {
                let given = given(kind);
                Self {
                    parameters: quote!(value: impl Into<#given>),
                    value: quote!(Into::<#given>::into(value)),
                    is_named: false,
                }
            }
        }
    }
}

/// Type that is given for one of a table.
pub(crate) fn given(kind: &Type) -> TokenStream {
    let kind = bare(kind);
    match kind {
        _ if is_plain(kind) || is_text(kind) => quote!(#kind),
        Type::Array(array) => {
            let (item, length) = (given(&array.elem), &array.len);
            quote!([#item; #length])
        }
        _ => match last(kind) {
            Some(segment) if segment.ident == "Vec" => {
                let item = arguments(segment).next().map(given);
                quote!(Vec<#item>)
            }
            Some(segment) if segment.ident == "BTreeMap" => {
                let item = arguments(segment).last().map(given);
                quote!(::std::collections::BTreeMap<String, #item>)
            }
            _ => quote!(<#kind as ::photosite_core::keys::Key>::Given),
        },
    }
}

/// Whether a type is a number, a truth value, or an array of them.
fn is_plain(kind: &Type) -> bool {
    const PLAIN: [&str; 8] = ["bool", "f64", "f32", "u8", "u16", "u32", "u64", "usize"];
    match kind {
        Type::Array(array) => is_plain(&array.elem),
        _ => last(kind).is_some_and(|segment| PLAIN.iter().any(|plain| segment.ident == plain)),
    }
}

pub(crate) fn is_text(kind: &Type) -> bool {
    last(kind).is_some_and(|segment| segment.ident == "String")
}

/// The item of a `Vec`.
pub(crate) fn item(kind: &Type) -> Option<&Type> {
    last(kind).filter(|segment| segment.ident == "Vec").and_then(|segment| arguments(segment).next())
}

fn last(kind: &Type) -> Option<&PathSegment> {
    match kind {
        Type::Path(path) => path.path.segments.last(),
        _ => None,
    }
}

fn arguments(segment: &PathSegment) -> impl Iterator<Item = &Type> {
    let arguments = match &segment.arguments {
        PathArguments::AngleBracketed(arguments) => Some(&arguments.args),
        _ => None,
    };
    arguments.into_iter().flatten().filter_map(|argument| match argument {
        GenericArgument::Type(kind) => Some(kind),
        _ => None,
    })
}
