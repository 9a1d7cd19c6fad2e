//! What of a capture the exporter has to say something about. All structures are taken apart without leaving anything
//! out, so that a new kind or field has to be given its place here before this compiles.

use std::collections::BTreeSet;

use photosite::Capture;
use photosite::capture::{ExposureSettings, ExposureTime};
use photosite::cells::{CellLayout, CellShape};
use photosite::geometry::QuadricKind;
use photosite::light::SkyConditions;
use photosite::optics::{Falloff, Focus, Intrinsics, LensDescription, LensKind, Projection};
use photosite::scene::description::*;
use photosite::sensor::SensorModel;
use photosite::texture::{Filter, SamplerSettings, Texels, UvTransform, Wrap};

/// Declares the features, each with what the exporter says of it where Mitsuba has no exact counterpart.
macro_rules! features {
    ($($name:ident $(= $said:literal)?,)*) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub(super) enum Feature { $($name,)* }

        impl Feature {
            pub(super) const ALL: &[Self] = &[$(Self::$name),*];

            /// Message about it; `None` where Mitsuba has it.
            pub(super) fn said(self) -> Option<&'static str> {
                match self { $(Self::$name => [$($said)?].first().copied(),)* }
            }
        }
    };
}

features! {
    // Lamps.
    PointLight, HardSpot, DirectionalLight, SoftSpot = "the soft edge of light",
    ProfileLight = "of the type profile", ProjectorLight = "of the type projector",
    GaussianBeam = "of the type gaussian-beam",
    ColouredEmission, SpectralEmission,
    // Surroundings.
    ConstantEnvironment, SkyWithSun, SkyWithoutSun, ImageOfNits, ImageOfLux, TurnedImage,
    // Surfaces.
    Matt, Mirror, RoughConductor = "the correlated shadowing", Grooves = "the correlated shadowing",
    Glass, GroundGlass = "the correlated shadowing", FurtherBounces = "light that bounces more than once", Dispersive = "the dispersion of", Pane,
    TintedPane = "the absorption of", OrenNayar = "the roughness of", Phong = "Phong's lobe of",
    Translucent = "the light that passes", Retroreflective = "the retroreflection of", Mix,
    Layers = "it becomes \"principled\"", Metallic = "it becomes \"principled\"", Transmission = "the transmission of",
    Volume = "the volume of", DiffuseTransmission = "the diffuse transmission of", Film = "the iridescence of",
    LayersWithGrooves = "the anisotropy of", Sheen = "the sheen of", Coat = "the clearcoat of",
    SpecularColour = "the specular colour of", SpecularFactor = "the specular factor of",
    NormalReflectance = "the reflectance of 1 before the specular colour",
    // What surfaces have beside a model.
    NormalMap, ScaledNormalMap, Lamp, EmitterOfTwoSides = "on both sides", EmissionTexture = "the emission texture",
    Mask, Blend, OpacityOfNumber, OpacityOfTexture,
    // Colours and textures.
    Rgb, Spectral, Textured, TextureTimesRgb, TextureTimesSpectrum = "the spectrum that scales the texture",
    TexturedFactor = "it becomes \"principled\"", Repeat, Mirrored, Clamped, WrapsDiffer = "wrap modes that differ", Nearest, Linear,
    SecondUvSet, TransformedUvs, Texels8, Texels16, TexelsHdr,
    // Shapes and where they stand.
    FlatMesh, SmoothMesh, MeshWithUvs, MeshWithTangents, ColouredCorners = "the colours of the corners",
    Sphere, Disk, Cylinder, SharedMesh, MirroredMesh, Moving = "the motion of",
    // The camera.
    Pinhole, ThinLens, Hole = "the hole of [lens]", Prescription = "rays go through the glass of a lens",
    NoLens = "no camera without a lens", FocusDistance, FocusInfinity, ImageDistance, Autofocus,
    GroundLens = "the glass of [lens]", SupplementaryLens = "the glass of [lens]", Blades = "an aperture with blades",
    Cos4 = "the falloff of [lens]", NoFalloff, TransmittanceOfLens,
    Distorted = "the distortion of [lens]", Curved = "projection of [lens]", MaxAngle = "max_angle_deg of [lens]",
    PointSpread = "psf of [lens]", LateralColour = "lateral_colour of [lens]", LensStops = "stops of [lens]",
    OffCentre = "a principal point off the centre", NotSquare = "pixels that are not square",
    Hexagonal = "hexagonal cells", ImageCircle = "image_circle_mm", SensorFilter, StatedTime,
    FoundTime = "an automatic exposure",
}

/// The features of a capture.
pub(super) fn features(capture: &Capture) -> BTreeSet<Feature> {
    let mut found = Found(BTreeSet::new());
    found.scene(capture.scene());
    found.lens(capture.lens(), capture.sensor().resolution);
    found.sensor(capture.sensor());
    found.exposure(capture.exposure());
    found.note(Feature::Moving, capture.recording().is_some());
    found.0
}

struct Found(BTreeSet<Feature>);

impl Found {
    fn add(&mut self, feature: Feature) {
        self.0.insert(feature);
    }

    fn note(&mut self, feature: Feature, is_there: bool) {
        if is_there {
            self.add(feature);
        }
    }

    fn scene(&mut self, scene: &SceneDescription) {
        let SceneDescription {
            images,
            materials,
            meshes,
            instances,
            lights,
            environment,
            // What names and groups, and what has been used or said already.
            objects: _,
            surroundings: _,
            cameras: _,
            files: _,
            warnings: _,
        } = scene;
        let used = materials.iter().enumerate().filter(|(i, _)| meshes.iter().any(|mesh| mesh.material == *i));
        for (_, material) in used {
            self.material(material);
            for texture in material.textures() {
                self.texture(&texture, &images[texture.image].texels);
            }
        }
        meshes.iter().for_each(|mesh| self.mesh(mesh));
        let mut uses = vec![0; meshes.len()];
        for InstanceDescription { name: _, meshes, to_world, later, is_movable: _ } in instances {
            meshes.clone().for_each(|mesh| uses[mesh] += 1);
            self.note(Feature::MirroredMesh, to_world.matrix3.determinant() < 0.0);
            self.note(Feature::Moving, !later.is_empty());
        }
        self.note(Feature::SharedMesh, uses.iter().any(|&n| n > 1));
        lights.iter().for_each(|light| self.light(light));
        environment.iter().for_each(|environment| self.environment(environment));
    }

    fn light(&mut self, LightDescription { name: _, to_world: _, later, kind, emission }: &LightDescription) {
        self.add(match kind {
            LightKind::Point(_) => Feature::PointLight,
            LightKind::Spot(spot) if spot.outer_rad() - spot.inner_rad() < 1e-3 => Feature::HardSpot,
            LightKind::Spot(_) => Feature::SoftSpot,
            LightKind::Directional(_) => Feature::DirectionalLight,
            LightKind::Profile(_) => Feature::ProfileLight,
            LightKind::Projector(_) => Feature::ProjectorLight,
            LightKind::GaussianBeam(_) => Feature::GaussianBeam,
        });
        self.note(Feature::Moving, !later.is_empty());
        self.emission(emission);
    }

    fn emission(&mut self, EmissionDescription { colour, level: _, texture }: &EmissionDescription) {
        self.add(match colour {
            Colour::Rgb(_) => Feature::ColouredEmission,
            Colour::Spectrum(_) => Feature::SpectralEmission,
        });
        self.note(Feature::EmissionTexture, texture.is_some());
    }

    fn environment(&mut self, environment: &EnvironmentDescription) {
        match environment {
            EnvironmentDescription::Constant { colour, luminance_nit } => {
                self.add(Feature::ConstantEnvironment);
                let emission = EmissionDescription { colour: colour.clone(), level: *luminance_nit, texture: None };
                self.emission(&emission);
            }
            EnvironmentDescription::Image { image, level, rotation_deg } => {
                self.texels(&image.texels);
                self.add(match level {
                    ImageLevel::NitPerUnit(_) => Feature::ImageOfNits,
                    ImageLevel::HorizontalLux(_) => Feature::ImageOfLux,
                });
                self.note(Feature::TurnedImage, *rotation_deg != 0.0);
            }
            EnvironmentDescription::Sky(SkyConditions { towards_sun: _, turbidity: _, ground_albedo: _, has_sun }) => {
                self.add(if *has_sun { Feature::SkyWithSun } else { Feature::SkyWithoutSun });
            }
        }
    }

    fn material(&mut self, material: &MaterialDescription) {
        let MaterialDescription {
            name: _,
            model,
            normal_map,
            emission,
            alpha,
            alpha_factor: _,
            alpha_texture,
            double_sided,
        } = material;
        self.model(model);
        if let Some((_, scale)) = normal_map {
            self.add(Feature::NormalMap);
            self.note(Feature::ScaledNormalMap, *scale != 1.0);
        }
        if let Some(emission) = emission {
            self.add(Feature::Lamp);
            self.note(Feature::EmitterOfTwoSides, *double_sided);
            self.emission(emission);
        }
        match alpha {
            AlphaMode::Opaque => return,
            AlphaMode::Mask { cutoff: _ } => self.add(Feature::Mask),
            AlphaMode::Blend => self.add(Feature::Blend),
        }
        self.add(if alpha_texture.is_some() { Feature::OpacityOfTexture } else { Feature::OpacityOfNumber });
    }

    fn model(&mut self, model: &MaterialModel) {
        match model {
            MaterialModel::Diffuse(Diffuse { reflectance }) => {
                self.add(Feature::Matt);
                self.colour(reflectance);
            }
            MaterialModel::Conductor(Conductor { eta: _, k: _, distribution, energy_compensation }) => {
                let [along, across] = distribution.distribution().alpha();
                self.note(Feature::FurtherBounces, *energy_compensation && along > 0.0);
                self.add(match (along, across) {
                    (0.0, _) => Feature::Mirror,
                    _ if along == across => Feature::RoughConductor,
                    _ => Feature::Grooves,
                });
            }
            MaterialModel::Dielectric(Dielectric { index, distribution, energy_compensation }) => {
                let is_smooth = distribution.distribution().is_smooth();
                self.note(Feature::FurtherBounces, *energy_compensation && !is_smooth);
                self.add(if is_smooth { Feature::Glass } else { Feature::GroundGlass });
                self.note(Feature::Dispersive, !index.is_constant());
            }
            MaterialModel::OrenNayar(OrenNayar { reflectance, roughness: _ }) => {
                self.add(Feature::OrenNayar);
                self.colour(reflectance);
            }
            MaterialModel::Phong(Phong { diffuse, specular: _, exponent: _ }) => {
                self.add(Feature::Phong);
                self.colour(diffuse);
            }
            MaterialModel::Translucent(Translucent { reflectance, transmittance: _ }) => {
                self.add(Feature::Translucent);
                self.colour(reflectance);
            }
            MaterialModel::ThinDielectric(ThinDielectric { index, transmittance }) => {
                self.add(if transmittance.min() < 1.0 { Feature::TintedPane } else { Feature::Pane });
                self.note(Feature::Dispersive, !index.is_constant());
            }
            MaterialModel::Retroreflective(retro) => {
                let Retroreflective { retroreflectance: _, reflectance, corners: _, distribution: _ } = retro;
                self.add(Feature::Retroreflective);
                self.colour(reflectance);
            }
            MaterialModel::Layered(layers) => self.layers(layers),
            MaterialModel::Mix(mix) => {
                let Mix { models, weight: _ } = &**mix;
                self.add(Feature::Mix);
                models.iter().for_each(|model| self.model(model));
            }
        }
    }

    fn layers(&mut self, layers: &LayeredDescription) {
        let LayeredDescription {
            kind: _,
            base_colour,
            metallic,
            roughness,
            index,
            normal_reflectance,
            specular,
            specular_colour,
            transmission,
            absorption_per_m,
            diffuse_transmission,
            anisotropy,
            film,
            sheen,
            coat,
        } = layers;
        self.add(Feature::Layers);
        self.colour(base_colour);
        for factor in [metallic, roughness] {
            self.note(Feature::TexturedFactor, factor.texture.is_some());
        }
        let is_white = matches!(specular_colour.colour, Colour::Rgb([1.0, 1.0, 1.0]));
        for (feature, is_there) in [
            (Feature::Metallic, metallic.value > 0.0),
            (Feature::Dispersive, !index.is_constant()),
            (Feature::NormalReflectance, normal_reflectance.is_some()),
            (Feature::SpecularFactor, specular.value != 1.0 || specular.texture.is_some()),
            (Feature::SpecularColour, !is_white || specular_colour.texture.is_some()),
            (Feature::Transmission, transmission.value > 0.0),
            (Feature::Volume, absorption_per_m.is_some()),
            (Feature::DiffuseTransmission, diffuse_transmission.is_some()),
            (Feature::LayersWithGrooves, anisotropy.is_some()),
            (Feature::Film, film.is_some()),
            (Feature::Sheen, sheen.is_some()),
            (Feature::Coat, coat.is_some()),
        ] {
            self.note(feature, is_there);
        }
    }

    fn colour(&mut self, TexturedColour { colour, texture }: &TexturedColour) {
        self.add(match (colour, texture) {
            (Colour::Rgb(_), None) => Feature::Rgb,
            (Colour::Spectrum(_), None) => Feature::Spectral,
            (Colour::Rgb([1.0, 1.0, 1.0]), Some(_)) => Feature::Textured,
            (Colour::Rgb(_), Some(_)) => Feature::TextureTimesRgb,
            (Colour::Spectrum(_), Some(_)) => Feature::TextureTimesSpectrum,
        });
    }

    fn texture(&mut self, texture: &TextureDescription, texels: &Texels) {
        let TextureDescription { image: _, uv_set, sampler: SamplerSettings { wrap, filter }, transform } = texture;
        for wrap in wrap {
            self.add(match wrap {
                Wrap::Repeat => Feature::Repeat,
                Wrap::MirroredRepeat => Feature::Mirrored,
                Wrap::ClampToEdge => Feature::Clamped,
            });
        }
        self.note(Feature::WrapsDiffer, wrap[0] != wrap[1]);
        self.add(match filter {
            Filter::Nearest => Feature::Nearest,
            Filter::Linear => Feature::Linear,
        });
        self.note(Feature::SecondUvSet, *uv_set != 0);
        self.note(Feature::TransformedUvs, *transform != UvTransform::default());
        self.texels(texels);
    }

    fn texels(&mut self, texels: &Texels) {
        self.add(match texels {
            Texels::Rgba8(_) => Feature::Texels8,
            Texels::Rgba16(_) => Feature::Texels16,
            Texels::Rgb32F(_) => Feature::TexelsHdr,
        });
    }

    fn mesh(&mut self, mesh: &MeshDescription) {
        let MeshDescription {
            name: _,
            material: _,
            positions: _,
            normals,
            tangents,
            uvs,
            colours,
            triangles: _,
            later_shapes,
            quadric,
        } = mesh;
        self.add(match quadric {
            Some(QuadricKind::Sphere) => Feature::Sphere,
            Some(QuadricKind::Disk) => Feature::Disk,
            Some(QuadricKind::Cylinder) => Feature::Cylinder,
            None if normals.is_empty() => Feature::FlatMesh,
            None => Feature::SmoothMesh,
        });
        self.note(Feature::MeshWithUvs, !uvs.is_empty());
        self.note(Feature::MeshWithTangents, !tangents.is_empty());
        self.note(Feature::ColouredCorners, colours.iter().any(|colour| colour.to_array() != [1.0; 4]));
        self.note(Feature::Moving, !later_shapes.is_empty());
    }

    fn lens(&mut self, lens: &LensDescription, [width, height]: [usize; 2]) {
        let LensDescription {
            kind,
            focus,
            ground,
            supplementary,
            blades,
            falloff,
            transmittance,
            projection,
            max_angle_rad,
            point_spread,
            lateral_colour,
            stops,
            intrinsics,
            // Of prescriptions, whose kind tells, and numbers that the camera is placed and focused by.
            prescription: _,
            focal_length_m: _,
            f_number: _,
            focus_spectrum: _,
            min_focus_distance_m: _,
            circle_of_confusion_m: _,
            blade_rotation_deg: _,
        } = lens;
        self.add(match kind {
            LensKind::Pinhole => Feature::Pinhole,
            LensKind::Thin => Feature::ThinLens,
            LensKind::Hole => Feature::Hole,
            LensKind::Prescription => Feature::Prescription,
            LensKind::Bare => Feature::NoLens,
        });
        if *kind == LensKind::Thin {
            self.add(match focus {
                Focus::Distance(_) => Feature::FocusDistance,
                Focus::Infinity => Feature::FocusInfinity,
                Focus::ImageDistance(_) => Feature::ImageDistance,
                Focus::Autofocus { .. } => Feature::Autofocus,
            });
        }
        // Prescriptions and bare sensors have what their glass and their place let through.
        if !matches!(kind, LensKind::Prescription | LensKind::Bare) {
            self.add(match falloff {
                Falloff::Cos4 => Feature::Cos4,
                Falloff::None => Feature::NoFalloff,
            });
        }
        match projection {
            Projection::Perspective => {}
            Projection::BrownConrady(_) | Projection::Polynomial { .. } | Projection::Division { .. } => {
                self.add(Feature::Distorted);
            }
            Projection::KannalaBrandt { .. }
            | Projection::ClassicalFisheye(_)
            | Projection::Equirectangular
            | Projection::Omnidirectional { .. } => self.add(Feature::Curved),
        }
        let half = |n: usize| n as f64 / 2.0;
        let is_central = |i: &Intrinsics| (i.cx, i.cy) == (half(width), half(height));
        self.note(Feature::OffCentre, intrinsics.as_ref().is_some_and(|intrinsics| !is_central(intrinsics)));
        for (feature, is_there) in [
            (Feature::GroundLens, ground.is_some()),
            (Feature::SupplementaryLens, !supplementary.is_empty()),
            (Feature::Blades, *blades != 0),
            (Feature::TransmittanceOfLens, transmittance.min() < 1.0),
            (Feature::MaxAngle, max_angle_rad.is_some()),
            (Feature::PointSpread, point_spread.is_some()),
            (Feature::LateralColour, lateral_colour.is_some()),
            (Feature::LensStops, !stops.is_empty()),
        ] {
            self.note(feature, is_there);
        }
    }

    fn sensor(&mut self, sensor: &SensorModel) {
        let SensorModel {
            pixel_pitch_m: [width, height],
            cells: CellLayout { shape, image_circle },
            filter,
            // Size and response, which every film has.
            resolution: _,
            fill_factor: _,
            cfa: _,
            quantum_efficiency: _,
            // Names, and what becomes of the electrons after the light.
            name: _,
            description: _,
            source: _,
            serial: _,
            architecture: _,
            shutter: _,
            masked: _,
            crosstalk: _,
            noise: _,
            full_well: _,
            brighter_fatter_per_e: _,
            image_lag: _,
            logarithmic: _,
            converter: _,
            video: _,
            frame_grabber: _,
        } = sensor;
        match shape {
            CellShape::Rectangular => self.note(Feature::NotSquare, width != height),
            CellShape::Hexagonal(_) => self.add(Feature::Hexagonal),
        }
        self.note(Feature::ImageCircle, image_circle.is_some());
        self.note(Feature::SensorFilter, filter.min() < 1.0);
    }

    fn exposure(&mut self, exposure: &ExposureSettings) {
        let ExposureSettings {
            time,
            // What becomes of the electrons after the light.
            gain: _,
            digital_gain: _,
            gain_control: _,
            temperature: _,
            bracket: _,
            frames: _,
            frame_interval: _,
            region: _,
            stages: _,
        } = exposure;
        self.add(match time {
            ExposureTime::Fixed(_) => Feature::StatedTime,
            ExposureTime::Auto(_) => Feature::FoundTime,
        });
    }
}
