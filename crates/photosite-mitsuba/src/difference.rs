//! Differences between Mitsuba and photosite, by name: each is refused, or listed where the nearest will do.

/// Declares the enumeration of all differences with the message of each.
macro_rules! differences {
    ($($kind:ident $({ $($field:ident: $type:ty),* })? = $text:literal,)*) => {
        /// Difference: something that has no exact counterpart in Mitsuba. Names of things are quoted with their kind.
        #[derive(Clone, Debug, PartialEq)]
        #[allow(missing_docs, reason = "each says what it is in a sentence, whose names its fields are")]
        pub enum Difference {
            $($kind $({ $($field: $type),* })?,)*
        }

        impl std::fmt::Display for Difference {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                match self {
                    $(Self::$kind $({ $($field),* })? => write!(f, $text),)*
                }
            }
        }

        impl Difference {
            /// Names of all kinds.
            pub const KINDS: &[&str] = &[$(stringify!($kind)),*];

            /// Name of the difference's kind.
            pub fn kind(&self) -> &'static str {
                match self {
                    $(Self::$kind { .. } => stringify!($kind),)*
                }
            }
        }
    };
}

differences! {
    // Camera and sensor.
    AutomaticExposure = "an automatic exposure: electrons are those of one second",
    Motion = "the motion of camera and scene: all stands where it starts",
    Falloff = "the falloff of [lens]: Mitsuba's cameras have none, as with falloff = \"none\"",
    CurvedProjection { projection: &'static str } = "the {projection} projection of [lens]: it becomes perspective",
    Distortion = "the distortion of [lens]: it is left out",
    PointSpread = "psf of [lens]: points stay points",
    LateralColour = "lateral_colour of [lens]: all wavelengths are as large",
    Stops = "stops of [lens]: they cut off nothing",
    MaxAngle = "max_angle_deg of [lens]: the image is not cut off there",
    Sensor { of: &'static str } = "{of}",
    PixelsNotSquare = "pixels that are not square: those of Mitsuba are",
    PrincipalPoint = "a principal point off the centre: it is moved there",
    Hole = "the hole of [lens]: it becomes a pinhole, whose images are sharp",
    Glass = "the glass of [lens]: all wavelengths have the focus of that at 587.6 nm",
    Blades = "an aperture with blades: it becomes round",
    NothingInFocus = "a sensor at which nothing is in focus: it is focused at infinity",
    // Lights.
    SoftEdge { light: String } = "the soft edge of {light}: Mitsuba's is linear in the angle",
    KindOfLight { light: String, kind: &'static str } =
        "{light} of the type {kind}, which Mitsuba does not have: it is left out",
    SkyBeyondItsTables = "the sky beyond 320 to 720 nm, where Mitsuba's is black",
    ImageBeyondCie = "an environment image beyond 360 to 830 nm, where it is black",
    ImageColours = "colours between the texels of the environment image: spectra are interpolated, in finer steps, not RGB",
    // Shapes.
    QuadricUvs { shape: String } = "the texture of {shape} or its grooves: its UVs are others",
    CornerColours { mesh: String } = "the colours of the corners of {mesh}: they are left out",
    GroovesWithoutUvs { material: String } =
        "the anisotropy of {material} on a mesh without UVs: its direction is another one",
    Tangents { mesh: String } = "the tangents of {mesh}: grooves and normal maps follow u of each triangle",
    CoarseNormals { mesh: String, lean_deg: f64 } =
        "the smooth normals of {mesh}, up to {lean_deg:.0}° off its triangles: where one is seen from behind, photosite \
         bends it towards the viewer",
    EmissionTexture { material: String } = "the emission texture of {material}: it shines as if the texture were white",
    HolesOfEmitter { material: String } = "the holes of the emitter of {material}: they shine too",
    EmitterOfTwoSides { material: String } = "the light of {material} on both sides: it shines on the front only",
    SmoothEmitter { material: String } =
        "the light of {material} on a smooth mesh: in Mitsuba its shading normals tell front from back",
    // Materials.
    UvsOfTheirOwn { material: String } = "textures of {material} with UVs of their own: those of the first serve all",
    NormalsFromBehind { material: String } =
        "the normal map of {material} where its normals are seen from behind: photosite bends them towards the viewer, \
         Mitsuba's reflect nothing",
    PolishedHalf { material: String } =
        "the polished half of {material}: Mitsuba's \"blendbsdf\" weighs mirrors and clear glass wrongly",
    ShadowOfPane { material: String } =
        "light of emitters without a surface through {material}: it throws a black shadow",
    PaneAmongHoles { material: String } =
        "light through {material} in a scene with holes: \"volpath\", which these want, loses what comes straight from \
         the lamps",
    Shadowing { material: String } =
        "the correlated shadowing of the microfacets of {material}: Mitsuba's is uncorrelated",
    FurtherBounces { material: String } =
        "light that bounces more than once between the microfacets of {material} (energy_compensation): it is lost",
    Dispersion { material: String } = "the dispersion of {material}: its index is that at 589.3 nm",
    Relief { material: String } = "the roughness of {material}, of the type \"oren-nayar\": it becomes \"diffuse\"",
    PhongLobe { material: String } = "Phong's lobe of {material}: it is left out",
    Translucence { material: String } =
        "the light that passes {material}, of the type \"translucent\": it is left out",
    Absorption { material: String } = "the absorption of {material}: it is left out",
    Retroreflection { material: String } =
        "the retroreflection of {material}, of the type \"retroreflective\", for which it has no plugin: it is left out",
    Model { kind: &'static str, material: String } = "the \"{kind}\" model of {material}: it becomes \"principled\"",
    Extension { extension: &'static str, material: String } = "the {extension} of {material}: it is left out",
    MaskBetweenTexels { material: String } =
        "the mask of {material}: texels are cut before they are interpolated, not after",
    SpectrumTimesTexture { material: String } =
        "the spectrum that scales the texture of {material}: it is left out",
    TextureBeyondCie { material: String } = "the texture of {material} beyond 360 to 830 nm, where it is black",
    ColoursBetweenTexels { material: String } =
        "colours between the texels of {material}: spectra are interpolated, not RGB",
    // Images.
    WrapModes = "wrap modes that differ in u and v: that of u serves both",
}
