// glTF's material at one point of a surface; photosite-transport's bsdf/layered/layers.rs. Base colour and the facets'
// reflectance at normal incidence are `first` and `second` of the BSDF. What no material of a scene has is left out of its
// kernels: constants of the scene say so, and compilers drop what depends on them.

const HAS_LAYERED = (SCENE_FEATURES & LAYERS_ANY) != 0u;
const HAS_TRANSMISSION = (SCENE_FEATURES & LAYERS_TRANSMISSION) != 0u;
/// Whether any surface bounds a medium.
const HAS_MEDIA = (SCENE_FEATURES & LAYERS_VOLUME) != 0u;
/// Whether light gets into a medium by refraction.
const HAS_VOLUMES = HAS_MEDIA && HAS_TRANSMISSION;
const HAS_DIFFUSE_TRANSMISSION = (SCENE_FEATURES & LAYERS_DIFFUSE_TRANSMISSION) != 0u;
const HAS_GROOVES = (SCENE_FEATURES & LAYERS_GROOVES) != 0u;
const HAS_FILM = (SCENE_FEATURES & LAYERS_FILM) != 0u;
const HAS_SHEEN = (SCENE_FEATURES & LAYERS_SHEEN) != 0u;
const HAS_COAT = (SCENE_FEATURES & LAYERS_COAT) != 0u;
/// Whether light passes any of these materials.
const LAYERS_PASS = HAS_TRANSMISSION || HAS_DIFFUSE_TRANSMISSION;

struct Layers {
    metallic: f32,
    specular: f32,
    transmission: f32,
    /// Whether a medium lies behind, of an index by wavelength.
    has_volume: bool,
    eta: vec4<f32>,
    diffuse_transmission: f32,
    diffuse_transmission_colour: vec4<f32>,
    /// Weight of the film, 0 without one; its index; 2·n·d/λ.
    film_weight: f32,
    film_index: f32,
    film_waves: vec4<f32>,
    has_sheen: bool,
    sheen_colour: vec4<f32>,
    sheen_alpha: f32,
    has_coat: bool,
    coat_weight: f32,
    coat_alpha: f32,
    coat_normal: vec3<f32>,
}

/// Layers of the surface where the thread is; set by `shading_at`.
var<private> layers: Layers;

/// Layers without any that extensions add.
fn plain_layers() -> Layers {
    return Layers(
        0.0, 1.0, 0.0, false, vec4<f32>(1.0), 0.0, vec4<f32>(1.0), 0.0, 1.0, vec4<f32>(0.0), false, vec4<f32>(0.0), 0.0,
        false, 0.0, 0.0, vec3<f32>(0.0, 0.0, 1.0),
    );
}

/// The parts of the base: metal, coloured, clear; `parts`.
fn parts_of() -> vec3<f32> {
    let other = 1.0 - layers.metallic;
    if (!HAS_TRANSMISSION) {
        return vec3<f32>(layers.metallic, other, 0.0);
    }
    return vec3<f32>(layers.metallic, other * (1.0 - layers.transmission), other * layers.transmission);
}

/// Whether light gets into a volume behind by refraction.
fn refracts_layered() -> bool {
    return HAS_VOLUMES && layers.has_volume && layers.transmission > 0.0;
}

fn transmits_layered() -> bool {
    return LAYERS_PASS && layers.metallic < 1.0 && (layers.transmission > 0.0 || layers.diffuse_transmission > 0.0);
}

fn is_delta_layered(bsdf: Bsdf) -> bool {
    let has_cover = HAS_SHEEN && layers.has_sheen || HAS_COAT && layers.has_coat && layers.coat_alpha > 0.0;
    return is_smooth(bsdf.roughness) && parts_of().y == 0.0 && !has_cover;
}

/// Whether dispersion keeps the BSDF from serving all wavelengths of a path.
fn layered_needs_single_wavelength(bsdf: Bsdf) -> bool {
    return bsdf.is_dispersive && refracts_layered() && !is_delta_interface(layers.eta.x, bsdf.roughness);
}
