//! Physics: every quantity against a closed form, a numerical integral or a published figure.

mod bsdf_cases;
mod bsdf_energy;
mod bsdf_fresnel;
mod bsdf_gltf;
mod bsdf_layered;
mod bsdf_microfacet;
mod bsdf_reciprocity;
mod bsdf_robustness;
mod bsdf_sampling;
mod bsdf_smooth;
mod chain;
mod develop_colour;
mod lens;
mod light_sampling;
mod quadrature;
mod sampling;
mod sensor_cases;
mod sensor_light;
mod sensor_photon_transfer;
mod sensor_stages;
mod stage;
mod transport;
