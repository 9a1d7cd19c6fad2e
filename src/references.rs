//! The literature that the documentation links to.
//!
//! ## Codata18
//! E. Tiesinga et al., "CODATA recommended values of the fundamental physical constants: 2018", Rev. Mod. Phys. 93,
//! 025010 (2021).
//!
//! ## Pbrt4
//! M. Pharr, W. Jakob, G. Humphreys, *Physically Based Rendering: From Theory to Implementation*, 4th edition (2023).
//!
//! ## Veach97
//! E. Veach, *Robust Monte Carlo Methods for Light Transport Simulation*, PhD thesis, Stanford (1997).
//!
//! ## Wilkie14
//! A. Wilkie et al., "Hero Wavelength Spectral Sampling", Computer Graphics Forum 33(4) (2014).
//!
//! ## Emva1288
//! EMVA Standard 1288, *Standard for Characterization of Image Sensors and Cameras*, release 4.0 Linear (2021).
