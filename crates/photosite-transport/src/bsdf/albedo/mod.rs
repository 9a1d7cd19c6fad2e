//! Tabulated albedos of lobes, which tell how much light is left for the layers below.
//!
//! The directional albedo E(w) = ∫ f·cos θᵢ dωᵢ of a GGX reflection lobe with Schlick's Fresnel factor
//! R = F₀ + (F₉₀ − F₀)(1 − cos θ)⁵ is linear in F₀ and F₉₀, E = F₀·A(w, α) + F₉₀·B(w, α)
//! ([Karis13](photosite_core::references#karis13)), so two tables serve all materials. For any other factor, such as
//! that of a thin film, E = Σⱼ R(cⱼ)·Wⱼ(w, α) with the factor interpolated between its values at eight cosines cⱼ.
//!
//! Tables are integrated when first used.

mod film;
mod glass;
mod grid;
mod hidden;
mod lattice;
pub mod packed;
mod reflection;
mod sheen;
mod thin_film_glass;

pub(super) use film::{FILM_NODES, FilmRow, FilmWeights};
pub(super) use glass::GlassRow;
pub(super) use grid::node;
pub(super) use hidden::{COAT_F0, Hidden, HiddenPart};
pub(super) use reflection::{Albedo, Row};
pub(super) use sheen::{SheenAlbedo, SheenRow};
pub(super) use thin_film_glass::FilmGlassRow;
