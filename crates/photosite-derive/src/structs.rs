//! Builders of tables.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};
use syn::{Attribute, DataStruct, DeriveInput, Error, Field, Result, Type};

use crate::attributes::{Attributes, docs};
use crate::types::{Setter, named};

pub(crate) fn builder(input: &DeriveInput, data: &DataStruct) -> Result<TokenStream> {
    let table = &input.ident;
    let mut flat: Option<Type> = Attributes::of(&input.attrs)?.beside;
    let mut setters = Vec::new();
    for field in &data.fields {
        let attributes = Attributes::of(&field.attrs)?;
        if attributes.is_skipped {
            continue;
        }
        if attributes.is_flat {
            flat = Some(field.ty.clone());
        } else {
            setters.push((field, attributes));
        }
    }
    let Some(flat) = flat else {
        let fields = setters;
        let setters = fields.iter().map(|(field, attributes)| setter(field, attributes, &quote!(pub), true));
        let setters = setters.collect::<Result<Vec<_>>>()?;
        let keys = named(table, "Keys");
        let (definition, ranges) = (definition(&keys, &input.attrs), ranges(table, &fields)?);
        return Ok(quote! {
            #definition
            #ranges
            #[allow(private_interfaces, reason = "a table stands for what is given for it")]
            impl #keys {
                #(#setters)*
            }
            impl ::photosite_core::keys::Key for #table {
                type Given = #keys;
            }
        });
    };
    let signatures = setters.iter().map(|(field, attributes)| setter(field, attributes, &quote!(), false));
    let signatures = signatures.collect::<Result<Vec<_>>>()?;
    let bodies = setters.iter().map(|(field, attributes)| setter(field, attributes, &quote!(), true));
    let bodies = bodies.collect::<Result<Vec<_>>>()?;
    let (setters, about) = (format_ident!("{table}Keys"), docs(&input.attrs));
    Ok(quote! {
        #(#about)*
        pub trait #setters: Sized {
            #(#signatures)*
        }
        impl #setters for <#flat as ::photosite_core::keys::Key>::Given {
            #(#bodies)*
        }
        impl ::photosite_core::keys::Key for #table {
            type Given = <#flat as ::photosite_core::keys::Key>::Given;
        }
    })
}

/// Check of a table's numbers, where their ranges have examples.
fn ranges(table: &Ident, fields: &[(&Field, Attributes)]) -> Result<TokenStream> {
    let mut checks = Vec::new();
    for (field, attributes) in fields {
        let (Some(name), Some(example)) = (&field.ident, &attributes.example) else { continue };
        let Some(range) = &attributes.range else { return Err(Error::new_spanned(field, "an example of no range")) };
        let (key, kind, bounds) = (attributes.name(name, &Attributes::default()), &range.func, &range.args);
        let kind = match quote!(#kind).to_string().as_str() {
            "above" => quote!(Above),
            _ => quote!(Within),
        };
        checks.push(quote! {
            ::photosite_core::schema_range::check(
                #key, &self.#name, ::photosite_core::schema_range::Lowest::#kind, #bounds, #example,
            )?;
        });
    }
    if checks.is_empty() {
        return Ok(TokenStream::new());
    }
    Ok(quote! {
        impl #table {
            /// Refuses numbers beyond the ranges that the schema states.
            pub(crate) fn check_ranges(&self) -> ::std::result::Result<(), ::photosite_core::Invalid> {
                #(#checks)*
                Ok(())
            }
        }
    })
}

/// A type that holds changes.
pub(crate) fn definition(keys: &Ident, attributes: &[Attribute]) -> TokenStream {
    let about = docs(attributes);
    quote! {
        #(#about)*
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct #keys(::photosite_core::keys::Changes);
        impl #keys {
            /// Builder without keys, to which they are added.
            pub fn new() -> Self {
                Self::default()
            }
        }
        impl ::photosite_core::keys::Given for #keys {
            fn toml(&self) -> String {
                ::photosite_core::keys::Given::toml(&self.0)
            }
            fn lay_over(&self, key: &str, changes: &mut ::photosite_core::keys::Changes) {
                ::photosite_core::keys::Given::lay_over(&self.0, key, changes);
            }
        }
        impl ::std::convert::AsMut<::photosite_core::keys::Changes> for #keys {
            fn as_mut(&mut self) -> &mut ::photosite_core::keys::Changes {
                &mut self.0
            }
        }
        impl ::std::ops::Deref for #keys {
            type Target = [String];
            fn deref(&self) -> &[String] {
                &self.0
            }
        }
    }
}

/// The setter of a key, or its signature.
pub(crate) fn setter(
    field: &Field,
    attributes: &Attributes,
    access: &TokenStream,
    is_whole: bool,
) -> Result<TokenStream> {
    let Some(name) = &field.ident else { return Err(Error::new_spanned(field, "a key needs a name")) };
    let (about, key) = (docs(&field.attrs), attributes.name(name, &Attributes::default()));
    // A key that is a word of Rust's has the field's name.
    let name = syn::parse_str::<Ident>(&key).unwrap_or_else(|_| name.clone());
    let Setter { parameters, value, is_named } = Setter::of(attributes.with.as_ref().unwrap_or(&field.ty));
    let path = if is_named { quote!(&::photosite_core::keys::below(#key, name)) } else { quote!(#key) };
    let body = quote! {{
        let changes: &mut ::photosite_core::keys::Changes = self.as_mut();
        ::photosite_core::keys::Given::lay_over(&#value, #path, changes);
        self
    }};
    let (mutable, body) = if is_whole { (quote!(mut), body) } else { (quote!(), quote!(;)) };
    Ok(quote! {
        #(#about)*
        #[must_use]
        #access fn #name(#mutable self, #parameters) -> Self #body
    })
}
