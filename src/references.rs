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
//!
//! ## Cie15
//! CIE 015:2018, *Colorimetry*, 4th edition.
//!
//! ## Srgb
//! IEC 61966-2-1:1999, *Multimedia systems and equipment – Colour measurement and management – Part 2-1: Default RGB
//! colour space – sRGB*.
//!
//! ## JakobHanika19
//! W. Jakob, J. Hanika, "A Low-Dimensional Function Space for Efficient Spectral Upsampling", Computer Graphics Forum
//! 38(2) (2019).
//!
//! ## Dng16
//! Adobe Systems, *Digital Negative (DNG) Specification*, version 1.6.0.0 (2021).
//!
//! ## Mikkelsen08
//! M. S. Mikkelsen, *Simulation of Wrinkled Surfaces Revisited*, master's thesis, University of Copenhagen (2008).
//!
//! ## Thuermer98
//! G. Thürmer, C. A. Wüthrich, "Computing Vertex Normals from Polygonal Facets", Journal of Graphics Tools 3(1) (1998).
//!
//! ## BornWolf99
//! M. Born, E. Wolf, *Principles of Optics*, 7th edition (1999).
//!
//! ## Walter07
//! B. Walter, S. Marschner, H. Li, K. Torrance, "Microfacet Models for Refraction through Rough Surfaces", EGSR (2007).
//!
//! ## Heitz14
//! E. Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2) (2014).
//!
//! ## Heitz18
//! E. Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 7(4) (2018).
//!
//! ## Dupuy23
//! J. Dupuy, A. Benyoub, "Sampling Visible GGX Normals with Spherical Caps", Computer Graphics Forum 42(8) (2023).
//!
//! ## Burley12
//! B. Burley, "Physically-Based Shading at Disney", SIGGRAPH course notes (2012).
//!
//! ## Schlick94
//! C. Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", Computer Graphics Forum 13(3) (1994).
//!
//! ## Meisters75
//! G. H. Meisters, "Polygons Have Ears", The American Mathematical Monthly 82(6) (1975).
//!
//! ## Menon07
//! D. Menon, S. Andriani, G. Calvagno, "Demosaicing With Directional Filtering and a posteriori Decision", IEEE
//! Transactions on Image Processing 16(1), 132–141 (2007).
//!
//! ## Compton07
//! J. T. Compton, J. F. Hamilton Jr., "Image sensor with improved light sensitivity", US patent application 2007/0024931
//! (Eastman Kodak, 2007).
//!
//! ## Karis13
//! B. Karis, "Real Shading in Unreal Engine 4", SIGGRAPH course notes (2013).
//!
//! ## Kelemen01
//! C. Kelemen, L. Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling",
//! Eurographics short papers (2001).
//!
//! ## KullaConty17
//! C. Kulla, A. Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH course notes (2017).
//!
//! ## Estevez17
//! A. Conty Estevez, C. Kulla, "Production Friendly Microfacet Sheen BRDF", SIGGRAPH course notes (2017).
//!
//! ## Gltf2
//! Khronos Group, *glTF 2.0 Specification* (2021), ISO/IEC 12113:2022.
//!
//! ## Fichet21
//! A. Fichet, R. Pacanowski, A. Wilkie, "An OpenEXR Layout for Spectral Images", JCGT 10(3) (2021).
//!
//! ## Rousselle11
//! F. Rousselle, C. Knaus, M. Zwicker, "Adaptive Sampling and Reconstruction using Greedy Error Minimization", ACM
//! Transactions on Graphics 30(6) (2011).
//!
//! ## Sidak67
//! Z. Šidák, "Rectangular Confidence Regions for the Means of Multivariate Normal Distributions", Journal of the
//! American Statistical Association 62(318), 626–633 (1967).
//!
//! ## Stephens70
//! M. A. Stephens, "Use of the Kolmogorov–Smirnov, Cramér–Von Mises and Related Statistics Without Extensive Tables",
//! Journal of the Royal Statistical Society B 32(1), 115–122 (1970).
//!
//! ## Jung20
//! A. Jung, J. Hanika, C. Dachsbacher, "Detecting Bias in Monte Carlo Renderers using Welch's t-test", JCGT 9(2)
//! (2020).
//!
//! ## Brewer03
//! M. Harrower, C. A. Brewer, "ColorBrewer.org: An Online Tool for Selecting Colour Schemes for Maps", The Cartographic
//! Journal 40(1), 27–37 (2003).
