//! Derive macro `Keys`: a builder for a table of keys, with a setter for each, made of the declaration by which the
//! table is read and documented.
//!
//! | declaration | becomes |
//! |---|---|
//! | `struct LensTable { f_number: Option<f64>, … }` | `LensKeys` with `f_number(f64)` … |
//! | a struct with a flattened other, or `#[keys(beside = "Other")]` | a trait of setters for the other's builder |
//! | an enum of names | a value of itself |
//! | an untagged enum, `ReflectanceSource` | `ReflectanceValue`, from the values of each variant |
//! | a tagged enum, `LightTable` | `LightKeys`, from the builders of its variants, or with a constructor for each variant |
//!
//! `photosite_core::keys` holds the traits that the code refers to.

#![expect(clippy::wildcard_enum_match_arm, reason = "what syn parses grows with the language")]
mod attributes;
mod enums;
mod structs;
mod types;

use proc_macro::TokenStream;
use syn::{Data, DeriveInput, Error, parse_macro_input};

/// Derives a builder, as the [crate] describes.
#[proc_macro_derive(Keys, attributes(keys))]
pub fn keys(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    let tokens = match &input.data {
        Data::Struct(data) => structs::builder(&input, data),
        Data::Enum(data) => enums::builder(&input, data),
        Data::Union(_) => Err(Error::new_spanned(&input.ident, "a union has no keys")),
    };
    tokens.unwrap_or_else(Error::into_compile_error).into()
}
