//! The figures of twelve lenses as Optiland 0.6.3 and ray-optics 0.9.8 compute them, and reflectances by the Python package
//! tmm. Each tolerance is that to which the programs agree, or what the last printed digit leaves.

mod coatings;
mod diffraction;
mod first_order;
mod focus;
mod lanes;
mod light;
mod neutral;
mod rays;
mod wave;
