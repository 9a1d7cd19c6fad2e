//! Speed of the parts that a render's time goes to.
//!
//!     cargo bench --bench parts              everything, in under a minute
//!     cargo bench --bench parts -- traversal one module
//!
//! Rates are those of one core. They vary with what else the machine does; the fastest of the samples is the figure to
//! compare.

mod bsdf;
mod build;
mod develop;
mod kitchen;
mod rays;
mod sampler;
mod scenes;
mod sensor;
mod traversal;

fn main() {
    divan::main();
}
