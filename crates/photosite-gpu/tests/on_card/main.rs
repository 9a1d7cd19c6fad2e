//! Kernels against the Rust that they follow, on Mesa's software where it is there, else on the first card of the machine.
//! Without either nothing is tested, and each test says so; with PHOTOSITE_GPU set that is a failure.
#![cfg(feature = "gpu")]

mod bsdfs;
mod developed;
mod development;
mod exposures;
mod films;
mod images;
mod lamps;
mod motions;
mod paths;
mod raws;
mod rays;
mod samplers;
mod scenes;
mod sensor_numbers;
mod skies;
mod stage;

use std::sync::{Arc, OnceLock};

use photosite_gpu::{Card, adapters, first, shared};

/// Card that is tested: PHOTOSITE_GPU has its number.
pub(crate) fn card() -> Option<&'static Card> {
    static CARD: OnceLock<Option<Arc<Card>>> = OnceLock::new();
    let card = CARD.get_or_init(|| {
        let asked = std::env::var("PHOTOSITE_GPU").ok();
        let software = adapters().iter().position(|adapter| adapter.is_software);
        let number = asked.as_ref().map(|number| number.parse().expect("PHOTOSITE_GPU is a number")).or(software);
        let number = number.or_else(first);
        let card = number.map(|number| shared(number).expect("a device that opens"));
        assert!(asked.is_none() || card.is_some(), "PHOTOSITE_GPU is set, and there is no device");
        card
    });
    match card {
        Some(card) => println!("on {}", card.adapter()),
        None => println!("skipped: this machine has neither a graphics card nor software that stands for one"),
    }
    card.as_deref()
}

#[test]
fn a_card_is_open_once_in_a_process() {
    let Some(card) = card() else { return };
    let number = adapters().iter().position(|adapter| adapter == card.adapter()).expect("it is there");
    let [one, other] = [(); 2].map(|()| shared(number).expect("it opens"));
    assert!(Arc::ptr_eq(&one, &other));
}

/// Numbers in [0, 1) for tests.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 += 1;
        photosite_core::math::hash::unit_f32(photosite_core::math::hash::hash64(7, self.0) as u32)
    }

    pub(crate) fn direction(&mut self) -> glam::Vec3 {
        photosite_core::math::warp::uniform_sphere([self.next(), self.next()])
    }
}
