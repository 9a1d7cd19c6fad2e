//! Lights as plain data.

use super::area_light::AreaLight;
use super::delta_light::DeltaLight;
use super::delta_model::LightPose;
use super::emission::{SurfaceEmission, Tint};
use super::emitter::Emitter;
use super::environment::{Environment, EnvironmentImage};
use super::kind::LightKind;
use super::lights::{Light, Lights};
use super::sky::{FIRST_NM, KNOTS, STEP_NM};
use crate::geometry::{Geometry, NONE, Primitive, Word, word};
use crate::texture::packed::PackedTextures;
use photosite_core::math::distribution::{PiecewiseConstant1D, PiecewiseConstant2D};

/// Words of a light: kind, primitive, target of shadow rays, rank in the tree; what it emits, with its mesh, and the
/// colour of that; its shape. A light without a surface has in place of primitive and target where its motion begins and
/// the number of its segments, 0 where it stands still; the parameters of its kind in place of the colour; and its
/// position, axis and rotation from the world in place of the shape. One that moves is given in its own space.
pub const LIGHT_WORDS: usize = 6;
/// Words of a node of the light tree: box with intensity, its half with the cone, axis with the angle beyond it; links.
pub const TREE_WORDS: usize = 4;

/// Wavelengths at which the sky is known, evenly spaced from the first on, nm.
pub const SKY_KNOTS: usize = KNOTS;
/// First wavelength of the sky and the step to the next, nm.
pub const SKY_NM: [f32; 2] = [FIRST_NM, STEP_NM];

/// Numbers of the kinds of packed lights.
pub mod kind {
    /// A triangle that emits: a corner and two edges.
    pub const TRIANGLE: u32 = 0;
    /// A quadric that emits.
    pub const QUADRIC: u32 = 1;
    /// A point of the same intensity in all directions.
    pub const POINT: u32 = 2;
    /// A point that shines within a cone.
    pub const SPOT: u32 = 3;
    /// Parallel light.
    pub const DIRECTIONAL: u32 = 4;
    /// The environment.
    pub const ENVIRONMENT: u32 = 5;
    /// A light without area, which is never sampled.
    pub const NOTHING: u32 = 6;
    /// A triangle that emits and changes its shape: where its corners begin among the motions, three words for each
    /// shape, and the number of parts of the time.
    pub const DEFORMING: u32 = 7;
    /// A point of measured intensities.
    pub const PROFILE: u32 = 8;
    /// A projector of a slide.
    pub const PROJECTOR: u32 = 9;
    /// A laser beam.
    pub const GAUSSIAN_BEAM: u32 = 10;
}

/// Numbers of the kinds of packed environments.
pub mod environment {
    /// Darkness.
    pub const NOTHING: u32 = 0;
    /// Constant radiance.
    pub const CONSTANT: u32 = 1;
    /// Image of the radiance.
    pub const IMAGE: u32 = 2;
    /// The sky by day.
    pub const SKY: u32 = 3;
}

/// Numbers of the sources of colours in packed materials.
pub mod colour {
    /// A spectrum.
    pub const SPECTRUM: u32 = 0;
    /// A factor times a texture.
    pub const TEXTURE: u32 = 1;
    /// A spectrum times a texture.
    pub const SPECTRUM_TEXTURE: u32 = 2;
}

/// Bit of an emission whose back shines too, beside the kind of its colour.
pub const TWO_SIDED: u32 = 1 << 8;

/// Numbers that choose lights, and the environment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PackedLights {
    /// Nodes of the tree; none without lights that are somewhere.
    pub tree_nodes: u32,
    /// Number of lights infinitely far.
    pub distant: u32,
    /// Irradiance from all lights infinitely far, in the unit of the tree's importance.
    pub irradiance: f32,
    /// Kind of the environment.
    pub environment: u32,
    /// Number of the environment among the lights infinitely far; [`NONE`] where it is not sampled.
    pub environment_number: u32,
    /// Spectrum of the environment's radiance.
    pub environment_radiance: u32,
    /// Texture of its image.
    pub environment_texture: u32,
    /// Columns and rows of its distribution.
    pub environment_cells: [u32; 2],
    /// Cosine and sine of its rotation about +Y.
    pub environment_rotation: [f32; 2],
}

/// Records of lights.
#[derive(Default)]
pub(crate) struct LightTables {
    /// Lights, [`LIGHT_WORDS`] each.
    pub(crate) lights: Vec<Word>,
    /// Nodes of the tree, [`TREE_WORDS`] each.
    pub(crate) tree: Vec<Word>,
    /// Lights infinitely far: handle, probability of staying in the bin, its alias, probability as a whole.
    pub(crate) distant: Vec<Word>,
    /// Cumulative sums of the environment's distribution.
    pub(crate) environment: Vec<f32>,
    /// Angles and intensities of measured profiles.
    pub(crate) profiles: Vec<f32>,
    /// The sky, if it is the environment.
    pub(crate) sky: Vec<Word>,
}

impl Lights {
    /// Whether any light has no surface.
    pub(crate) fn has_deltas(&self) -> bool {
        self.lights.iter().any(|light| matches!(light, Light::Delta(_)))
    }

    /// Packs the lights. The environment's image becomes a texture; motions of those that move, and shapes of those
    /// that change them, are added to the others.
    pub(crate) fn packed(
        &self,
        geometry: &Geometry,
        textures: &mut PackedTextures,
        motions: &mut Vec<Word>,
    ) -> (PackedLights, LightTables) {
        let mut tables = LightTables::default();
        for (handle, light) in (0..).zip(&self.lights) {
            let rank = self.selection.rank(handle);
            let mut words = match light {
                Light::Delta(light) => delta_words(light, rank, &mut tables.profiles, textures),
                Light::Area(light) => {
                    let mesh = geometry.mesh_of(light.primitive);
                    let words = area_words(light, self.static_shapes[handle as usize].as_ref(), mesh, rank);
                    deforming(words, light, geometry, motions)
                }
                Light::Environment => {
                    let [emission, colour] = emission_words(None);
                    [[kind::ENVIRONMENT, NONE, NONE, rank], emission, colour, [0; 4], [0; 4], [0; 4]]
                }
            };
            if let Some(motion) = self.motion_of(handle) {
                [words[0][1], words[0][2]] = [motions.len() as u32, motion.segments()];
                motions.extend(motion.words());
            }
            tables.lights.extend(words);
        }
        (tables.tree, tables.distant) = (self.selection.tree_words(), self.selection.distant_words());
        let mut packed = PackedLights {
            tree_nodes: (tables.tree.len() / TREE_WORDS) as u32,
            distant: tables.distant.len() as u32,
            irradiance: self.selection.irradiance(),
            environment_number: self.environment_index.unwrap_or(NONE),
            environment_radiance: NONE,
            environment_texture: NONE,
            ..PackedLights::default()
        };
        match &self.environment {
            None => {}
            Some(Environment::Constant { radiance }) => {
                packed.environment = environment::CONSTANT;
                packed.environment_radiance = radiance.number();
            }
            Some(Environment::Image(image)) => {
                let EnvironmentImage { texture, radiance, rotation, distribution, .. } = image;
                packed.environment = environment::IMAGE;
                packed.environment_radiance = radiance.number();
                packed.environment_texture = textures.add(texture);
                packed.environment_rotation = *rotation;
                (packed.environment_cells, tables.environment) = sums(distribution);
            }
            Some(Environment::Sky(sky)) => {
                packed.environment = environment::SKY;
                tables.sky = sky.words();
                (packed.environment_cells, tables.environment) = sums(sky.distribution());
            }
        }
        (packed, tables)
    }
}

/// Columns and rows of a distribution, with its cumulative sums: of the rows, then of the columns of each.
fn sums(distribution: &PiecewiseConstant2D) -> ([u32; 2], Vec<f32>) {
    let (rows, marginal) = (distribution.rows(), distribution.marginal());
    let all = std::iter::once(marginal).chain(rows);
    ([rows[0].len() as u32, rows.len() as u32], all.flat_map(PiecewiseConstant1D::cdf).copied().collect())
}

fn area_words(light: &AreaLight, shape: Option<&Emitter>, mesh: u32, rank: u32) -> [Word; LIGHT_WORDS] {
    let AreaLight { primitive, emission } = light;
    let [[radiance, tint, texture, _], colour] = emission_words(Some(emission));
    let (kind, number) = match (primitive, shape) {
        (_, None) => (kind::NOTHING, NONE),
        (Primitive::Triangle(triangle), Some(_)) => (kind::TRIANGLE, *triangle),
        (Primitive::Quadric(quadric), Some(_)) => (kind::QUADRIC, *quadric),
    };
    let [a, b, c] = match shape {
        Some(Emitter::Triangle(triangle)) => triangle.words(),
        Some(Emitter::Quadric(_)) | None => [[0; 4]; 3],
    };
    [[kind, number, primitive.target(), rank], [radiance, tint, texture, mesh], colour, a, b, c]
}

/// The words of a light whose shape, if it changes, is found at each time.
fn deforming(
    mut words: [Word; LIGHT_WORDS],
    light: &AreaLight,
    geometry: &Geometry,
    motions: &mut Vec<Word>,
) -> [Word; LIGHT_WORDS] {
    if let Primitive::Triangle(triangle) = light.primitive
        && geometry.shape_count(triangle) > 1
    {
        [words[0][0], words[0][1]] = [kind::DEFORMING, triangle];
        words[3] = [motions.len() as u32, geometry.shape_count(triangle) as u32 - 1, 0, 0];
        motions.extend(geometry.shapes(triangle).flatten().map(|corner| word(corner, 0)));
    }
    words
}

/// Parameters of a kind of light without a surface.
struct DeltaParameters {
    kind: u32,
    /// Numbers that stand beside its position and its axis.
    beside: [f32; 2],
    parameters: Word,
    /// Texture of its slide, and the factor of that.
    slide: Option<(u32, f32)>,
}

impl DeltaParameters {
    /// Parameters of a light; the numbers of its profile and the texture of its slide are added to those that there are.
    fn new(light: &LightKind, profiles: &mut Vec<f32>, textures: &mut PackedTextures) -> Self {
        let of_kind = |kind: u32| Self { kind, beside: [0.0; 2], parameters: [0; 4], slide: None };
        match light {
            LightKind::Point(_) => of_kind(kind::POINT),
            LightKind::Spot(spot) => Self { beside: spot.cosines(), ..of_kind(kind::SPOT) },
            LightKind::Directional(_) => of_kind(kind::DIRECTIONAL),
            LightKind::Profile(profile) => {
                let ([vertical, horizontal], first) = (profile.counts(), profiles.len() as u32);
                profiles.extend(profile.numbers());
                Self { parameters: [first, vertical, horizontal, 0], ..of_kind(kind::PROFILE) }
            }
            LightKind::Projector(projector) => Self {
                beside: projector.lens(),
                parameters: projector.frame().map(f32::to_bits),
                slide: Some((textures.add(projector.slide()), projector.per_flux())),
                ..of_kind(kind::PROJECTOR)
            },
            LightKind::GaussianBeam(beam) => {
                Self { parameters: beam.numbers().map(f32::to_bits), ..of_kind(kind::GAUSSIAN_BEAM) }
            }
        }
    }
}

fn delta_words(
    light: &DeltaLight,
    rank: u32,
    profiles: &mut Vec<f32>,
    textures: &mut PackedTextures,
) -> [Word; LIGHT_WORDS] {
    let DeltaParameters { kind, beside, parameters, slide } = DeltaParameters::new(light.kind(), profiles, textures);
    let &LightPose { position, axis, world_to_light } = light.pose();
    let (texture, factor) = slide.unwrap_or((NONE, 0.0));
    let emitted = [light.level().number(), colour::SPECTRUM | TWO_SIDED, texture, factor.to_bits()];
    let [first, second] = beside.map(f32::to_bits);
    let rotation = world_to_light.to_array().map(f32::to_bits);
    [[kind, 0, 0, rank], emitted, parameters, word(position, first), word(axis, second), rotation]
}

/// Spectrum of what is emitted, [`NONE`] for nothing, with its colour.
pub(crate) fn emission_words(emission: Option<&SurfaceEmission>) -> [Word; 2] {
    let Some(SurfaceEmission { radiance, tint, two_sided }) = emission else { return [[NONE, 0, NONE, 0], [0; 4]] };
    let sides = if *two_sided { TWO_SIDED } else { 0 };
    match *tint {
        Tint::None => [[radiance.number(), colour::SPECTRUM | sides, NONE, 0], [0; 4]],
        Tint::Textured { factor: [r, g, b], texture } => [
            [radiance.number(), colour::SPECTRUM_TEXTURE | sides, texture, 0],
            [r.to_bits(), g.to_bits(), b.to_bits(), 0],
        ],
    }
}
