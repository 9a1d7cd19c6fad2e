//! Noise of textbooks, added to any image: additive and multiplicative, of several distributions, film grain and
//! impulses. What the noise of a sensor is made of is [`sensor`](photosite_sensor)'s.
//!
//! In: planes of numbers f and a [`SyntheticNoise`]. Out: planes g. The kinds act in this order, each on what those
//! before it have left:
//!
//! | kind | g | n | file |
//! |---|---|---|---|
//! | speckle | f·s | s gamma-distributed, mean 1, standard deviation C | `distributions.rs` |
//! | film grain | f + c·f^γ·n | normal, variance 1, correlated over ℓ | `film_grain.rs` |
//! | gaussian, laplacian, uniform | f + σ·n, or f·(1 + σ·n) | variance 1 | `distributions.rs` |
//! | σ map | f + σ(x, y)·n | normal, variance 1 | `add.rs` |
//! | salt and pepper | white or black at random places | | `impulses.rs` |
//!
//! Random numbers are a pure function of (seed, kind, channel, pixel): a kind that is switched off changes no other, and
//! the size of the image no pixel. Nothing is clipped but by [`round_to_codes`], which counts what it clips.

mod add;
mod codes;
mod description;
mod distributions;
mod film_grain;
mod impulses;
mod streams;

pub use add::{Scale, add_noise};
pub use codes::{Clipped, round_to_codes};
pub use description::{
    Channels, FilmGrain, Levels, SaltAndPepper, SigmaMapFile, Speckle, SymmetricNoise, SyntheticNoise,
};
