//! Enums: names, values of several types, and tables that a key tells apart.

use proc_macro2::{Ident, TokenStream};
use quote::quote;
use syn::{Attribute, DataEnum, DeriveInput, Error, Fields, Result, Type, Variant};

use crate::attributes::{Attributes, docs};
use crate::structs::{definition, setter};
use crate::types::{bare, given, is_text, item, named};

pub(crate) fn builder(input: &DeriveInput, data: &DataEnum) -> Result<TokenStream> {
    let attributes = Attributes::of(&input.attrs)?;
    if let Some(tag) = &attributes.tag {
        return tagged(input, data, &attributes, tag);
    }
    if attributes.is_untagged {
        return untagged(input, data);
    }
    let name = &input.ident;
    Ok(quote! {
        impl ::photosite_core::keys::Key for #name {
            type Given = Self;
        }
        impl ::photosite_core::keys::Given for #name {
            fn toml(&self) -> String {
                ::photosite_core::keys::name(self)
            }
        }
    })
}

/// Conversions for an enum that is made from the value of any variant.
fn untagged(input: &DeriveInput, data: &DataEnum) -> Result<TokenStream> {
    let (table, about) = (&input.ident, docs(&input.attrs));
    let value = named(table, "Value");
    let mut kinds: Vec<(&Type, TokenStream)> = Vec::new();
    for variant in &data.variants {
        let kind = bare(inner(variant)?);
        if kinds.iter().all(|(other, _)| *other != kind) {
            let by_name = Attributes::of(&variant.attrs)?.given;
            kinds.push((kind, by_name.map_or_else(|| given(kind), |by_name| quote!(#by_name))));
        }
    }
    let sources = kinds.into_iter().map(|(kind, given_type)| {
        let from = |kind: TokenStream, value_of: TokenStream| {
            quote! {
                impl From<#kind> for #value {
                    fn from(value: #kind) -> Self {
                        Self(::photosite_core::keys::Given::toml(&#value_of))
                    }
                }
            }
        };
        let whole = from(given_type, quote!(value));
        if is_text(kind) {
            let short = from(quote!(&str), quote!(value.to_owned()));
            return quote!(#whole #short);
        }
        let Some(item) = item(kind).map(given) else { return whole };
        quote! {
            #whole
            impl<const N: usize> From<[#item; N]> for #value {
                fn from(values: [#item; N]) -> Self {
                    Self::from(Vec::from(values))
                }
            }
        }
    });
    Ok(quote! {
        #(#about)*
        #[derive(Clone, Debug, PartialEq)]
        pub struct #value(String);
        #(#sources)*
        impl ::photosite_core::keys::Key for #table {
            type Given = #value;
        }
        impl ::photosite_core::keys::Given for #value {
            fn toml(&self) -> String {
                self.0.clone()
            }
        }
    })
}

/// Builders of a table whose variants a key tells apart: those of the variants, or a constructor for each.
fn tagged(input: &DeriveInput, data: &DataEnum, around: &Attributes, tag: &str) -> Result<TokenStream> {
    let table = &input.ident;
    let keys = around.named.clone().unwrap_or_else(|| named(table, "Keys"));
    let (definition, mut set) = (definition(&keys, &input.attrs), Vec::<Ident>::new());
    let mut parts = Vec::new();
    for variant in &data.variants {
        let name = Attributes::of(&variant.attrs)?.name(&variant.ident, around);
        match &variant.fields {
            Fields::Unnamed(_) => {
                let kind = given(inner(variant)?);
                parts.push(quote! {
                    impl From<#kind> for #keys {
                        fn from(keys: #kind) -> Self {
                            Self(::photosite_core::keys::tagged(#tag, #name, &keys))
                        }
                    }
                });
            }
            fields => {
                let mut setters = vec![constructor(variant, &name, tag, &docs(&variant.attrs))];
                for field in fields {
                    // A key of several variants has one setter.
                    if let Some(ident) = field.ident.as_ref().filter(|ident| !set.contains(ident)) {
                        set.push(ident.clone());
                        setters.push(setter(field, &Attributes::of(&field.attrs)?, &quote!(pub), true)?);
                    }
                }
                parts.push(quote!(impl #keys { #(#setters)* }));
            }
        }
    }
    Ok(quote! {
        #definition
        #(#parts)*
        impl ::photosite_core::keys::Key for #table {
            type Given = #keys;
        }
    })
}

fn constructor(variant: &Variant, name: &str, tag: &str, about: &[&Attribute]) -> TokenStream {
    let function = Ident::new(&variant.ident.to_string().to_ascii_lowercase(), variant.ident.span());
    quote! {
        #(#about)*
        pub fn #function() -> Self {
            Self(::photosite_core::keys::tagged(#tag, #name, &::photosite_core::keys::Changes::default()))
        }
    }
}

fn inner(variant: &Variant) -> Result<&Type> {
    let fields = variant.fields.iter().collect::<Vec<_>>();
    let [field] = &*fields else { return Err(Error::new_spanned(variant, "one value is needed")) };
    Ok(&field.ty)
}
