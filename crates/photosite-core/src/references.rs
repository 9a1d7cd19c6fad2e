//! The literature that the documentation links to.
//!
//! ## Codata18
//! E. Tiesinga et al., "CODATA recommended values of the fundamental physical constants: 2018", Rev. Mod. Phys. 93,
//! 025010 (2021).
//!
//! ## Pbrt4
//! M. Pharr, W. Jakob, G. Humphreys, *Physically Based Rendering: From Theory to Implementation*, 4th edition (2023).
//!
//! ## Wei20
//! K. Wei, Y. Fu, J. Yang, H. Huang, "A Physics-based Noise Formation Model for Extreme Low-light Raw Denoising", IEEE/CVF
//! Conference on Computer Vision and Pattern Recognition (2020).
//!
//! ## Conrady60
//! A. E. Conrady, *Applied Optics and Optical Design*, part 2, Dover (1960), chapter 12.
//!
//! ## Kolb95
//! C. Kolb, D. Mitchell, P. Hanrahan, "A Realistic Camera Model for Computer Graphics", Computer Graphics (SIGGRAPH)
//! (1995).
//!
//! ## Welford86
//! W. T. Welford, *Aberrations of Optical Systems*, Adam Hilger (1986).
//!
//! ## Veach97
//! E. Veach, *Robust Monte Carlo Methods for Light Transport Simulation*, PhD thesis, Stanford (1997).
//!
//! ## GrittmannEtAl22
//! P. Grittmann, Ö. Yazici, I. Georgiev, P. Slusallek, "Efficiency-aware multiple importance sampling for bidirectional
//! rendering algorithms", ACM Transactions on Graphics 41(4), article 80 (2022).
//!
//! ## Ylitie17
//! H. Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", Proceedings
//! of High Performance Graphics (2017).
//!
//! ## Conty18
//! A. Conty Estevez, C. Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", Proceedings of the
//! ACM on Computer Graphics and Interactive Techniques 1(2) (2018).
//!
//! ## Belcour14
//! L. Belcour, R. Pacanowski, M. Delahaie, A. Laville-Geay, L. Eupherte, "Bidirectional reflectance distribution
//! function measurements and analysis of retroreflective materials", Journal of the Optical Society of America A
//! 31(12), 2561–2572 (2014).
//!
//! ## Portsmouth26
//! J. Portsmouth, M. Raab, L. Belcour, F. Liu, "The Minimal Retroreflective Microfacet Model", Journal of Computer
//! Graphics Techniques 15(1) (2026).
//!
//! ## Degnan93
//! J. J. Degnan, "Millimeter Accuracy Satellite Laser Ranging: a Review", Contributions of Space Geodesy to
//! Geodynamics: Technology, Geodynamics Series 25, 133–162 (1993), on cube corners with circular openings.
//!
//! ## Baum89
//! D. R. Baum, H. E. Rushmeier, J. M. Winget, "Improving Radiosity Solutions Through the Use of Analytically Determined
//! Form-Factors", Computer Graphics (SIGGRAPH) 23(3) (1989).
//!
//! ## Arvo86
//! J. Arvo, "Backward Ray Tracing", Developments in Ray Tracing, SIGGRAPH Course Notes (1986).
//!
//! ## ArvoKirk90
//! J. Arvo, D. Kirk, "Particle Transport and Image Synthesis", Computer Graphics (SIGGRAPH) 24(4) (1990).
//!
//! ## KirkArvo91
//! D. Kirk, J. Arvo, "Unbiased Sampling Techniques for Image Synthesis", Computer Graphics (SIGGRAPH) 25(4) (1991).
//!
//! ## KingmaBa15
//! D. P. Kingma, J. Ba, "Adam: A Method for Stochastic Optimization", International Conference on Learning
//! Representations (2015), algorithm 1.
//!
//! ## Wilkie14
//! A. Wilkie et al., "Hero Wavelength Spectral Sampling", Computer Graphics Forum 33(4) (2014).
//!
//! ## Knuth97
//! D. E. Knuth, *The Art of Computer Programming*, volume 2, 3rd edition (1997), section 4.2.2.
//!
//! ## Dekker71
//! T. J. Dekker, "A Floating-Point Technique for Extending the Available Precision", Numerische Mathematik 18, 224–242
//! (1971).
//!
//! ## Devroye86
//! L. Devroye, *Non-Uniform Random Variate Generation*, Springer (1986).
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
//! ## Png3
//! W3C, *Portable Network Graphics (PNG) Specification*, 3rd edition (2025); its code points are those of ITU-T H.273.
//!
//! ## Zhang05
//! L. Zhang, X. Wu, "Color Demosaicking via Directional Linear Minimum Mean Square-Error Estimation", IEEE Transactions
//! on Image Processing 14(12), 2167–2178 (2005).
//!
//! ## Chaix07
//! B. Chaix de Lavarène, D. Alleysson, J. Hérault, "Practical Implementation of LMMSE Demosaicing Using Luminance and
//! Chrominance Spaces", Computer Vision and Image Understanding 107(1–2), 3–13 (2007).
//!
//! ## Dng16
//! Adobe Systems, *Digital Negative (DNG) Specification*, version 1.6.0.0 (2021).
//!
//! ## Iso12232
//! ISO 12232:2019, *Photography – Digital still cameras – Determination of exposure index, ISO speed ratings, standard
//! output sensitivity, and recommended exposure index*.
//!
//! ## Kavadias00
//! S. Kavadias, B. Dierickx, D. Scheffer, A. Alaerts, D. Uwaerts, J. Bogaerts, "A Logarithmic Response CMOS Image
//! Sensor with On-Chip Calibration", IEEE Journal of Solid-State Circuits 35(8), 1146–1152 (2000).
//!
//! ## Robertson03
//! M. A. Robertson, S. Borman, R. L. Stevenson, "Estimation-Theoretic Approach to Dynamic Range Enhancement Using
//! Multiple Exposures", Journal of Electronic Imaging 12(2), 219–228 (2003).
//!
//! ## Granados10
//! M. Granados, B. Ajdin, M. Wand, C. Theobalt, H.-P. Seidel, H. P. A. Lensch, "Optimal HDR Reconstruction with Linear
//! Digital Cameras", IEEE CVPR, 215–222 (2010).
//!
//! ## GarridoJurado14
//! S. Garrido-Jurado, R. Muñoz-Salinas, F. J. Madrid-Cuevas, M. J. Marín-Jiménez, "Automatic Generation and Detection
//! of Highly Reliable Fiducial Markers under Occlusion", Pattern Recognition 47(6), 2280–2292 (2014): ArUco.
//!
//! ## Olson11
//! E. Olson, "AprilTag: A Robust and Flexible Visual Fiducial System", IEEE ICRA, 3400–3407 (2011).
//!
//! ## T81
//! ITU-T Recommendation T.81 | ISO/IEC 10918-1, *Digital compression and coding of continuous-tone still images* (JPEG,
//! 1992).
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
//! ## Portsmouth25
//! J. Portsmouth, P. Kutz, S. Hill, "EON: A Practical Energy-Preserving Rough Diffuse BRDF", JCGT 14(1) (2025).
//!
//! ## LafortuneWillems94
//! E. P. Lafortune, Y. D. Willems, "Using the Modified Phong Reflectance Model for Physically Based Rendering", report
//! CW 197, Katholieke Universiteit Leuven (1994).
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
//! J. T. Compton, J. F. Hamilton Jr., "Image sensor with improved light sensitivity", US patent application
//! 2007/0024931 (Eastman Kodak, 2007).
//!
//! ## Karis13
//! B. Karis, "Real Shading in Unreal Engine 4", SIGGRAPH course notes (2013).
//!
//! ## Kelemen01
//! C. Kelemen, L. Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling",
//! Eurographics short papers (2001).
//!
//! ## Karlik19
//! O. Karlík, M. Šik, P. Vévoda, T. Skřivan, J. Křivánek, "MIS Compensation: Optimizing Sampling Techniques in Multiple
//! Importance Sampling", ACM Transactions on Graphics 38(6), 151 (2019).
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
//! ## Mtl95
//! D. Ramey, L. Rose, L. Tyerman, *File Formats*, version 4.2, "Material Library File (.mtl)", Alias|Wavefront (1995).
//!
//! ## Houston15
//! B. Houston, "Extending Wavefront OBJ MTL Material Definition for Physically-Based Rendering", Exocortex (2015).
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
//!
//! ## Janesick01
//! J. R. Janesick, *Scientific Charge-Coupled Devices*, SPIE Press (2001).
//!
//! ## Fossum14
//! E. R. Fossum, D. B. Hondongwa, "A Review of the Pinned Photodiode for CCD and CMOS Image Sensors", IEEE Journal of
//! the Electron Devices Society 2(3), 33–43 (2014).
//!
//! ## Varshni67
//! Y. P. Varshni, "Temperature dependence of the energy gap in semiconductors", Physica 34(1), 149–154 (1967).
//!
//! ## McKay79
//! M. D. McKay, R. J. Beckman, W. J. Conover, "A Comparison of Three Methods for Selecting Values of Input Variables in
//! the Analysis of Output from a Computer Code", Technometrics 21(2), 239–245 (1979): Latin hypercubes.
//!
//! ## LubyRackoff88
//! M. Luby, C. Rackoff, "How to Construct Pseudorandom Permutations from Pseudorandom Functions", SIAM Journal on
//! Computing 17(2), 373–386 (1988): Feistel networks.
//!
//! ## Shoemake92
//! K. Shoemake, "Uniform Random Rotations", Graphics Gems III, 124–132 (1992).
//!
//! ## Shoemake85
//! K. Shoemake, "Animating Rotation with Quaternion Curves", Proc. SIGGRAPH, 245–254 (1985).
//!
//! ## Kim95
//! M.-J. Kim, M.-S. Kim, S. Y. Shin, "A General Construction Scheme for Unit Quaternion Curves with Simple High Order
//! Derivatives", Proc. SIGGRAPH, 369–376 (1995).
//!
//! ## Konnik14
//! M. Konnik, J. Welsh, "High-level numerical simulations of noise in CCD and CMOS photosensors: review and tutorial",
//! arXiv:1412.4031 (2014).
//!
//! ## Icc4
//! International Color Consortium, *Image technology colour management – Architecture, profile format, and data
//! structure*, ICC.1:2022 (profile version 4.4).
//!
//! ## Sharma05
//! G. Sharma, W. Wu, E. N. Dalal, "The CIEDE2000 Color-Difference Formula: Implementation Notes, Supplementary Test
//! Data, and Mathematical Observations", Color Research & Application 30(1), 21–30 (2005).
//!
//! ## Smith78
//! A. R. Smith, "Color Gamut Transform Pairs", SIGGRAPH (1978).
//!
//! ## Joblove78
//! G. H. Joblove, D. Greenberg, "Color Spaces for Computer Graphics", SIGGRAPH (1978).
//!
//! ## Gonzalez18
//! R. C. Gonzalez, R. E. Woods, *Digital Image Processing*, 4th edition (2018).
//!
//! ## SmpteEg432
//! SMPTE EG 432-1:2010, *Digital Source Processing – Color Processing for D-Cinema*.
//!
//! ## Bt2020
//! ITU-R BT.2020-2, *Parameter values for ultra-high definition television systems* (2015).
//!
//! ## Aces14
//! Academy of Motion Image Arts and Sciences, S-2014-004, *ACEScg – A Working Space for CGI Render and Compositing*.
//!
//! ## Malvar04
//! H. S. Malvar, L. He, R. Cutler, "High-Quality Linear Interpolation for Demosaicing of Bayer-Patterned Color Images",
//! ICASSP (2004).
//!
//! ## Hirakawa05
//! K. Hirakawa, T. W. Parks, "Adaptive Homogeneity-Directed Demosaicing Algorithm", IEEE Transactions on Image
//! Processing 14(3), 360–369 (2005).
//!
//! ## Mersereau79
//! R. M. Mersereau, "The Processing of Hexagonally Sampled Two-Dimensional Signals", Proceedings of the IEEE 67(6),
//! 930–949 (1979).
//!
//! ## Knutsson93
//! H. Knutsson, C.-F. Westin, "Normalized and Differential Convolution", CVPR (1993).
//!
//! ## Narkowicz16
//! K. Narkowicz, "ACES Filmic Tone Mapping Curve", knarkowicz.wordpress.com (2016).
//!
//! ## Reinhard02
//! E. Reinhard, M. Stark, P. Shirley, J. Ferwerda, "Photographic Tone Reproduction for Digital Images", ACM Transactions on
//! Graphics 21(3), 267–276 (2002).
//!
//! ## Drago03
//! F. Drago, K. Myszkowski, T. Annen, N. Chiba, "Adaptive Logarithmic Mapping for Displaying High Contrast Scenes", Computer
//! Graphics Forum 22(3), 419–426 (2003).
//!
//! ## Durand02
//! F. Durand, J. Dorsey, "Fast Bilateral Filtering for the Display of High-Dynamic-Range Images", ACM Transactions on
//! Graphics 21(3), 257–266 (2002).
//!
//! ## Otsu79
//! N. Otsu, "A Threshold Selection Method from Gray-Level Histograms", IEEE Transactions on Systems, Man, and Cybernetics
//! 9(1), 62–66 (1979).
//!
//! ## Keys81
//! R. G. Keys, "Cubic Convolution Interpolation for Digital Image Processing", IEEE Transactions on Acoustics, Speech, and
//! Signal Processing 29(6), 1153–1160 (1981).
//!
//! ## Duchon79
//! C. E. Duchon, "Lanczos Filtering in One and Two Dimensions", Journal of Applied Meteorology 18(8), 1016–1022 (1979).
//!
//! ## Tomasi98
//! C. Tomasi, R. Manduchi, "Bilateral Filtering for Gray and Color Images", ICCV (1998).
//!
//! ## Buades05
//! A. Buades, B. Coll, J.-M. Morel, "A Non-Local Algorithm for Image Denoising", CVPR (2005).
//!
//! ## Makitalo13
//! M. Mäkitalo, A. Foi, "Optimal Inversion of the Generalized Anscombe Transformation for Poisson-Gaussian Noise", IEEE
//! Transactions on Image Processing 22(1), 91–103 (2013).
//!
//! ## Immerkaer96
//! J. Immerkær, "Fast Noise Variance Estimation", Computer Vision and Image Understanding 64(2), 300–302 (1996).
//!
//! ## Wang04
//! Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli, "Image Quality Assessment: From Error Visibility to Structural
//! Similarity", IEEE Transactions on Image Processing 13(4), 600–612 (2004).
//!
//! ## Iso12233
//! ISO 12233:2017, *Photography – Electronic still image imaging – Resolution and spatial frequency responses*.
//!
//! ## TruccoVerri98
//! E. Trucco, A. Verri, *Introductory Techniques for 3-D Computer Vision* (1998), chapter 2.
//!
//! ## Dlmf
//! *NIST Digital Library of Mathematical Functions*, <https://dlmf.nist.gov/>, chapter 8 on incomplete gamma functions.
//!
//! ## Goodman07
//! J. W. Goodman, *Speckle Phenomena in Optics: Theory and Applications* (2007), §3.2 and §4.1.
//!
//! ## Jain89
//! A. K. Jain, *Fundamentals of Digital Image Processing* (1989), §8.2 on noise that depends on the signal, §8.13 on
//! speckle.
//!
//! ## Green08
//! M. A. Green, "Self-consistent optical parameters of intrinsic silicon at 300 K including temperature coefficients",
//! Solar Energy Materials and Solar Cells 92, 1305–1310 (2008).
//!
//! ## Ruyten99
//! W. Ruyten, "Smear correction for frame transfer charge-coupled-device cameras", Optics Letters 24(13), 878–880
//! (1999).
//!
//! ## Antilogus14
//! P. Antilogus, P. Astier, P. Doherty, A. Guyonnet, N. Regnault, "The brighter-fatter effect and pixel correlations in
//! CCD sensors", Journal of Instrumentation 9, C03048 (2014).
//!
//! ## Guyonnet15
//! A. Guyonnet, P. Astier, P. Antilogus, N. Regnault, P. Doherty, "Evidence for self-interaction of charge distribution
//! in charge-coupled devices", Astronomy & Astrophysics 575, A41 (2015).
//!
//! ## Knoll10
//! G. F. Knoll, *Radiation Detection and Measurement*, 4th edition (2010).
//!
//! ## Ma20
//! S. Ma, S. Gupta, A. C. Ulku, C. Bruschini, E. Charbon, M. Gupta, "Quanta Burst Photography", ACM Transactions on
//! Graphics 39(4) (2020).
//!
//! ## Lyon02
//! R. F. Lyon, P. M. Hubel, "Eyeing the Camera: into the Next Century", IS&T/SID 10th Color Imaging Conference,
//! 349–355 (2002).
//!
//! ## Catmull74
//! E. Catmull, R. Rom, "A Class of Local Interpolating Splines", in *Computer Aided Geometric Design* (1974).
//!
//! ## FritschCarlson80
//! F. N. Fritsch, R. E. Carlson, "Monotone Piecewise Cubic Interpolation", SIAM Journal on Numerical Analysis 17(2),
//! 238–246 (1980).
//!
//! ## FritschButland84
//! F. N. Fritsch, J. Butland, "A Method for Constructing Local Monotone Piecewise Cubic Interpolants", SIAM Journal on
//! Scientific and Statistical Computing 5(2), 300–304 (1984).
//!
//! ## NelderMead65
//! J. A. Nelder, R. Mead, "A Simplex Method for Function Minimization", The Computer Journal 7(4), 308–313 (1965).
//!
//! ## Born99
//! M. Born, E. Wolf, *Principles of Optics*, 7th edition, Cambridge University Press (1999).
//!
//! ## Macleod10
//! H. A. Macleod, *Thin-Film Optical Filters*, 4th edition, CRC Press (2010).
//!
//! ## OpenCv
//! OpenCV 4, *Camera Calibration and 3D Reconstruction* (calib3d),
//! <https://docs.opencv.org/4.x/d9/d0c/group__calib3d.html>; its `fisheye` and `omnidir` namespaces.
//!
//! ## Colmap
//! J. L. Schönberger et al., COLMAP documentation, "Output Format" and "Camera Models",
//! <https://colmap.github.io/format.html>.
//!
//! ## Euroc
//! M. Burri, J. Nikolic, P. Gohl, T. Schneider, J. Rehder, S. Omari, M. W. Achtelik, R. Siegwart, "The EuRoC Micro
//! Aerial Vehicle Datasets", International Journal of Robotics Research 35(10), 1157–1163 (2016); the sensor and
//! ground-truth files of the data sets.
//!
//! ## Kalibr
//! Kalibr wiki, "Bag format", "Calibration targets", "YAML formats", <https://github.com/ethz-asl/kalibr/wiki>; its
//! program `kalibr_bagcreater`.
//!
//! ## Bop
//! T. Hodaň et al., "BOP: Benchmark for 6D Object Pose Estimation", ECCV (2018); BOP toolkit,
//! `docs/bop_datasets_format.md` and `scripts/calc_gt_info.py`, <https://github.com/thodan/bop_toolkit>.
//!
//! ## Coco
//! COCO, "Data format", <https://cocodataset.org/#format-data>; its program interface `pycocotools/mask.py`,
//! <https://github.com/cocodataset/cocoapi>.
//!
//! ## Nocs
//! H. Wang et al., "Normalized Object Coordinate Space for Category-Level 6D Object Pose and Size Estimation", CVPR
//! (2019), §3.
//!
//! ## Nerfstudio
//! Nerfstudio, "Data conventions", <https://docs.nerf.studio/quickstart/data_conventions.html>; its
//! `nerfstudio_dataparser.py`.
//!
//! ## InstantNgp
//! Instant neural graphics primitives, `src/nerf_loader.cu`, <https://github.com/NVlabs/instant-ngp>: the keys
//! `transform_matrix_start`, `transform_matrix_end` and `rolling_shutter` of `transforms.json`.
//!
//! ## Gut3d
//! Q. Wu, J. Martinez Esturo, A. Mirzaei, N. Moenne-Loccoz, Z. Gojcic, "3DGUT: Enabling Distorted Cameras and Secondary
//! Rays in Gaussian Splatting", CVPR (2025).
//!
//! ## Brown71
//! D. C. Brown, "Close-Range Camera Calibration", Photogrammetric Engineering 37(8), 855–866 (1971).
//!
//! ## KannalaBrandt06
//! J. Kannala, S. S. Brandt, "A Generic Camera Model and Calibration Method for Conventional, Wide-Angle, and Fish-Eye
//! Lenses", IEEE Transactions on Pattern Analysis and Machine Intelligence 28(8), 1335–1340 (2006).
//!
//! ## Fitzgibbon01
//! A. W. Fitzgibbon, "Simultaneous Linear Estimation of Multiple View Geometry and Lens Distortion", IEEE CVPR (2001).
//!
//! ## MeiRives07
//! C. Mei, P. Rives, "Single View Point Omnidirectional Camera Calibration from Planar Grids", IEEE ICRA, 3945–3950
//! (2007).
//!
//! ## Michalsky88
//! J. J. Michalsky, "The Astronomical Almanac's Algorithm for Approximate Solar Position (1950–2050)", Solar Energy
//! 40(3), 227–235 (1988).
//!
//! ## HosekWilkie12
//! L. Hosek, A. Wilkie, "An Analytic Model for Full Spectral Sky-Dome Radiance", ACM Transactions on Graphics 31(4)
//! (2012).
//!
//! ## HosekWilkie13
//! L. Hosek, A. Wilkie, "Adding a Solar-Radiance Function to the Hošek–Wilkie Skylight Model", IEEE Computer Graphics
//! and Applications 33(3) (2013).
//!
//! ## LM63
//! ANSI/IES LM-63, *Standard File Format for the Electronic Transfer of Photometric Data and Related Information*,
//! editions of 1986 to 2019.
//!
//! ## Siegman86
//! A. E. Siegman, *Lasers*, University Science Books (1986).
