//! Corrections of the lens that raw files state for developers, and the grid of the image that is developed with them.

use glam::DVec2;
use photosite_calibration::camera_files::{FittedLens, Models};
use photosite_capture::{Capture, OutputSettings, RawFormat};
use photosite_core::image_grid::ImageGrid;
use photosite_develop::{DevelopSettings, Resampling};
use photosite_raw::{Distortion, GainMap, LensModel, Opcode, RawMetadata, Warp};
use photosite_sensor::{RegionOfInterest, SensorModel, Stages};
use photosite_transport::optics::{Camera, Falloff, Intrinsics, LensDescription, LensKind, Projection};
use std::sync::{Mutex, OnceLock, PoisonError};

use super::capture_camera::in_u32;
use photosite_capture::report::{ImageReport, PixelGridReport};

/// Points of the gain map along each side: straight lines between 33 points miss 1/cos⁴θ by less than 0.3 % up to 45°
/// from the axis.
const POINTS: [usize; 2] = [33, 25];

/// Largest error, px, of the model fitted to a traced lens that passes without a warning.
const LARGEST_PX: f64 = 0.1;

/// A lens as a window of the sensor sees through it.
pub struct LensSeen<'a> {
    lens: &'a LensDescription,
    camera: &'a Camera,
    /// Model fitted to a lens from a prescription, for which developers have no model; `None` of other lenses.
    fitted: Option<FittedLens>,
    /// The pixels of the raw image.
    grid: ImageGrid,
    /// Columns and rows of the sensor.
    sensor_px: [u32; 2],
    /// Pixel pitch of the raw image, m.
    pitch_m: [f64; 2],
}

/// The pixels that ground truth, points and camera files of a capture have.
pub fn image_grid(capture: &Capture, camera: &Camera) -> ImageGrid {
    let exposure = capture.exposure();
    let seen = LensSeen::new(capture.lens(), camera, capture.sensor(), &exposure.region, exposure.stages);
    seen.image_grid(capture.output().image.then_some(capture.develop()))
}

/// A lens, where it stands, and what is known of it.
pub(crate) type SeenLens<'a, 'k> = (&'a LensDescription, &'a Camera, &'k KnownCorrections);

/// Findings about a lens that take longer than a small exposure, and are made once.
#[derive(Debug, Default)]
pub(crate) struct KnownCorrections {
    /// The gain map through the window that it was asked for last.
    gain_map: Mutex<Option<([f64; 4], Option<GainMap>)>>,
    /// Model fitted to a lens from a prescription.
    fitted: OnceLock<Option<FittedLens>>,
}

impl KnownCorrections {
    fn gain_map(&self, seen: &LensSeen<'_>) -> Option<GainMap> {
        let window = seen.window_px();
        let mut known = self.gain_map.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, map)) = known.as_ref().filter(|(of, _)| *of == window) {
            return map.clone();
        }
        let map = seen.gain_map();
        *known = Some((window, map.clone()));
        map
    }
}

/// Resampling of an image by a developer, in words.
pub struct Resampled {
    /// Resampling in words: "freed of the distortion of the lens".
    pub what: String,
    /// Keys to write so that the image is not resampled.
    pub keys: String,
}

impl<'a> LensSeen<'a> {
    /// A lens as a window of a sensor sees through it.
    pub fn new(
        lens: &'a LensDescription,
        camera: &'a Camera,
        sensor: &SensorModel,
        region: &RegionOfInterest,
        stages: Stages,
    ) -> Self {
        Self::knowing((lens, camera, &KnownCorrections::default()), sensor, region, stages)
    }

    /// Sees a lens as [`new`](Self::new) does, with findings about it from before.
    pub(crate) fn knowing(
        (lens, camera, known): SeenLens<'a, '_>,
        sensor: &SensorModel,
        region: &RegionOfInterest,
        stages: Stages,
    ) -> Self {
        let grid = sensor.read_out_grid(region, stages);
        let pitch_m = [0, 1].map(|axis| sensor.pixel_pitch_m[axis] * grid.per_pixel[axis]);
        let fit = || FittedLens::new(camera, Models::Rational);
        let fitted = if lens.kind == LensKind::Prescription { *known.fitted.get_or_init(fit) } else { None };
        Self { lens, camera, fitted, grid, sensor_px: in_u32(sensor.resolution), pitch_m }
    }

    /// Writes falloff and distortion into the metadata of a raw image of this window. `known` is of this lens.
    pub(crate) fn write_to(&self, metadata: &mut RawMetadata, known: &KnownCorrections) {
        let map = match self.lens.falloff {
            Falloff::None if self.lens.stops.is_empty() => None,
            Falloff::None | Falloff::Cos4 => known.gain_map(self),
        };
        metadata.opcodes[1] = map.into_iter().map(Opcode::GainMap).collect();
        metadata.distortion = self.model().map(Distortion::Lens);
    }

    /// Resampling of the image by a developer; `None` where the image stays as it is.
    pub fn resampling(&self, settings: &DevelopSettings) -> Option<Resampling> {
        Resampling::new(&self.metadata(), self.size_px(), settings)
    }

    /// The pixels of the image that is delivered, which ground truth and points have: those of image.png where the
    /// settings say how one is developed, else those of the raw image. Where image.png is freed of a distortion, no
    /// scale and shift lead to its pixels, and they are those of the raw image, too.
    pub fn image_grid(&self, settings: Option<&DevelopSettings>) -> ImageGrid {
        let resampling = settings.and_then(|settings| self.resampling(settings));
        let Some(resampling) = resampling.filter(|resampling| !resampling.undistorts()) else { return self.grid };
        let (first, per_pixel) = resampling.on_sensor();
        ImageGrid {
            resolution: in_u32(resampling.size_px()),
            first: self.grid.on_sensor(DVec2::from_array(first)),
            per_pixel: self.grid.per_pixel * DVec2::from_array(per_pixel),
            is_staggered: resampling.is_staggered(),
        }
    }

    /// Place of [`image_grid`](Self::image_grid) on the sensor, for a report.
    pub(crate) fn grid_report(&self, settings: Option<&DevelopSettings>) -> PixelGridReport {
        let grid = self.image_grid(settings);
        PixelGridReport::new(&grid, &grid.intrinsics(&self.whole_intrinsics()))
    }

    /// Columns and rows of the raw image.
    fn size_px(&self) -> [usize; 2] {
        self.grid.resolution.map(|n| n as usize)
    }

    /// Corrections and changes by a developer, in words; `None` where the image stays as it is.
    pub fn resampled(&self, settings: &DevelopSettings) -> Option<Resampled> {
        let metadata = self.metadata();
        let all = [
            (
                settings.distortion && metadata.distortion.is_some(),
                "freed of the distortion of the lens",
                "develop.distortion = false",
            ),
            (
                settings.square_pixels && (metadata.pixel_aspect() != 1.0 || metadata.is_staggered),
                "brought to square pixels",
                "develop.square_pixels = false",
            ),
            (settings.resizes(), "resized", "neither develop.resize_px nor develop.digital_zoom"),
        ];
        let (whats, keys): (Vec<&str>, Vec<&str>) =
            all.into_iter().filter_map(|(is_done, what, key)| is_done.then_some((what, key))).unzip();
        (!whats.is_empty()).then(|| Resampled { what: whats.join(" and "), keys: keys.join(" and ") })
    }

    /// Warnings about images and files that lack what one might expect. `has_targets` is whether the report says where
    /// points of targets appear.
    pub(crate) fn warnings(
        &self,
        settings: &DevelopSettings,
        output: &OutputSettings,
        has_targets: bool,
    ) -> Vec<String> {
        let mut warnings = Vec::new();
        let name = match self.lens.kind {
            LensKind::Prescription => "traced",
            LensKind::Thin | LensKind::Pinhole | LensKind::Hole | LensKind::Bare => self.lens.projection.name(),
        };
        let has_dng = output.raw.contains(&RawFormat::Dng);
        match self.model() {
            None if output.image && settings.distortion && self.is_distorted() => {
                let why = if self.camera.scans() {
                    "a line of a line-scan camera does not know what lies beside it"
                } else {
                    "its image reaches 90° from the axis, which an image without distortion cannot show"
                };
                warnings.push(format!("image.png keeps the distortion of the {name} lens: {why}"));
            }
            Some(model) if has_dng => {
                if Warp::of_lens(&model, self.size_px(), self.metadata().pixel_aspect()).is_none() {
                    warnings.push(format!(
                        "of the {name} lens, raw.dng tells photosite alone: what DNG has for all developers comes no nearer to \
                         it than {} px",
                        Warp::LARGEST_ERROR_PX
                    ));
                }
            }
            None | Some(_) => {}
        }
        if let Some(fitted) = self.fitted.filter(|fitted| fitted.largest_px > LARGEST_PX) {
            let (model, off) = (fitted.projection.name(), fitted.largest_px);
            warnings.push(format!(
                "what other tools are told of the traced lens is the {model} model nearest to it, which is up to {off:.2} px \
                 beside it; capture.json has the figures (camera.fitted)"
            ));
        }
        if self.grid.is_staggered && has_dng {
            let how = "by CFALayout, which most programs pass over: they take the rows for columns";
            warnings.push(format!("raw.dng tells that every second row lies half a pixel to the right {how}"));
        }
        let truth = match (!output.truth.layers.is_empty() || output.objects, has_targets) {
            (true, true) => Some("ground truth and the points of targets are"),
            (true, false) => Some("ground truth is"),
            (false, true) => Some("the points of targets in capture.json are"),
            (false, false) => None,
        };
        if let Some(Resampled { what, keys }) = self.resampled(settings).filter(|_| output.image) {
            let undistorts = self.resampling(settings).is_some_and(|resampling| resampling.undistorts());
            match truth {
                Some(truth) if undistorts => warnings.push(format!(
                    "image.png is {what}, but {truth} not; write {keys}, and both show things in the same places"
                )),
                Some(truth) if !output.raw.is_empty() => warnings.push(format!(
                    "image.png is {what}, and {truth} in its pixels, not in those of the raw files; write {keys}, and all \
                     show things in the same places"
                )),
                Some(_) | None => {}
            }
            if !has_dng && !output.raw.is_empty() {
                warnings.push(format!(
                    "image.png is {what}, which photosite develop cannot do with these raw files: DNG files alone tell of lens \
                     and pixels"
                ));
            }
        }
        let whole = ImageGrid { is_staggered: self.grid.is_staggered, ..self.sensor_px.into() };
        let of_sensor: Vec<&str> = [
            ("electrons.exr", output.electrons),
            ("irradiance.exr", output.irradiance.is_some()),
            ("ideal.exr", output.ideal),
        ]
        .into_iter()
        .filter_map(|(name, is_written)| is_written.then_some(name))
        .collect();
        if self.grid != whole && !of_sensor.is_empty() && (truth.is_some() || output.ideal) {
            let truth = truth.unwrap_or("raw images are");
            warnings.push(format!(
                "{truth} in the pixels that are read out; {} of all pixels of the sensor, and pixel_grid in capture.json says \
                 where those lie on it",
                match &of_sensor[..] {
                    [only] => format!("{only} is"),
                    names => format!("{} are", names.join(", ")),
                }
            ));
        }
        warnings
    }

    /// Report of the camera of the developed image.
    pub(crate) fn image_report(&self, settings: &DevelopSettings) -> ImageReport {
        let metadata = self.metadata();
        let model = self.model().filter(|_| settings.distortion);
        let (on_grid, projection) = match &model {
            Some(model) => (model.pinhole(), Projection::Perspective),
            None => (self.intrinsics(), self.projection()),
        };
        let resampling = self.resampling(settings);
        let (size, (first, per_pixel)) = match &resampling {
            Some(resampling) => (resampling.size_px(), resampling.on_sensor()),
            None => (self.size_px(), ([0.0; 2], [1.0; 2])),
        };
        let intrinsics = on_grid.on_grid(first, per_pixel);
        let aspect = settings.pixel_aspect(&metadata);
        let report = ImageReport::new(size, aspect, &intrinsics, &projection, resampling.is_some());
        if self.lens.kind == LensKind::Prescription && self.fitted.is_none() {
            // The matrix alone, near the axis, as that of the camera.
            return ImageReport { projection: self.lens.projection_name().to_owned(), ..report };
        }
        report
    }

    /// Camera matrix of the lens on the grid of the raw image.
    fn intrinsics(&self) -> Intrinsics {
        self.grid.intrinsics(&self.whole_intrinsics())
    }

    /// Intrinsics on the grid of the sensor.
    fn whole_intrinsics(&self) -> Intrinsics {
        self.fitted.map_or(self.camera.intrinsics(), |fitted| fitted.intrinsics)
    }

    /// Projection of the lens, or of the model fitted to it.
    fn projection(&self) -> Projection {
        self.fitted.map_or(self.lens.projection, |fitted| fitted.projection)
    }

    /// Metadata of raw files about lens and pixels.
    fn metadata(&self) -> RawMetadata {
        RawMetadata {
            pixel_pitch_m: Some(self.pitch_m),
            is_staggered: self.grid.is_staggered,
            distortion: self.model().map(Distortion::Lens),
            ..RawMetadata::default()
        }
    }

    /// Whether straight lines are curved, but for a panorama, whose image is meant to be as it is.
    fn is_distorted(&self) -> bool {
        !matches!(self.projection(), Projection::Perspective | Projection::Equirectangular)
    }

    /// Distortion model that a developer corrects: that of a lens whose image a pinhole could take as well.
    fn model(&self) -> Option<LensModel> {
        let model = LensModel {
            intrinsics: self.intrinsics(),
            projection: self.projection(),
            max_angle_rad: self.lens.max_angle_rad,
        };
        let can_correct = self.is_distorted() && !self.camera.scans() && model.is_within_a_half_space(self.size_px());
        can_correct.then_some(model)
    }

    /// The window on the grid of the sensor: left, top, width, height.
    fn window_px(&self) -> [f64; 4] {
        let size = self.grid.per_pixel * DVec2::from_array(self.grid.resolution.map(f64::from));
        [self.grid.first.x, self.grid.first.y, size.x, size.y]
    }

    /// Gain map that corrects falloff: 1 over the relative illumination. Where distortion leaves a pixel without light,
    /// there is nothing to correct.
    fn gain_map(&self) -> Option<GainMap> {
        let [columns, rows] = POINTS;
        let [left, top, width, height] = self.window_px();
        let gain = |i: usize| {
            let part = [i % columns, i / columns].map(|n| n as f64);
            let x = left + part[0] / (columns - 1) as f64 * width;
            let y = top + part[1] / (rows - 1) as f64 * height;
            let illumination = self.camera.relative_illumination(DVec2::new(x, y)).filter(|part| *part > 0.0);
            illumination.map_or(1.0, |illumination| 1.0 / illumination as f32)
        };
        GainMap::new(columns, rows, (0..columns * rows).map(gain).collect()).ok()
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;
    use photosite_develop::DevelopSettings;
    use photosite_raw::PixelArea;
    use photosite_sensor::Binning;
    use photosite_transport::optics::{BrownConrady, Focus, PixelGrid};

    use super::*;

    const SIZE: [u32; 2] = [640, 480];

    fn brown_conrady([k1, k2]: [f64; 2], p: [f64; 2]) -> Projection {
        Projection::BrownConrady(BrownConrady { k: [k1, k2, 0.0, 0.0, 0.0, 0.0], p, ..BrownConrady::default() })
    }

    fn camera(projection: Projection, f_number: f64, pitch_m: [f64; 2]) -> (LensDescription, Camera) {
        let mut lens = LensDescription::thin(0.004, f_number, Focus::Infinity);
        lens.projection = projection;
        let grid = PixelGrid { resolution: SIZE, pitch_m };
        let camera = Camera::new(&lens, &grid, DAffine3::IDENTITY, 1.0).expect("a lens");
        (lens, camera)
    }

    fn seen<'a>(
        lens: &'a LensDescription,
        camera: &'a Camera,
        region: RegionOfInterest,
        pitch_m: [f64; 2],
    ) -> LensSeen<'a> {
        let area = region.pixels.unwrap_or(PixelArea { x: 0, y: 0, width: 640, height: 480 });
        let [across, down] = region.binning.factor;
        let grid = ImageGrid {
            first: DVec2::new(area.x as f64, area.y as f64),
            per_pixel: DVec2::new(across as f64, down as f64),
            ..ImageGrid::from([area.width / across, area.height / down].map(|n| n as u32))
        };
        let pitch_m = [0, 1].map(|axis| pitch_m[axis] * grid.per_pixel[axis]);
        LensSeen { lens, camera, fitted: None, grid, sensor_px: SIZE, pitch_m }
    }

    #[test]
    fn the_image_shows_what_the_camera_of_its_report_sees() {
        let part = RegionOfInterest {
            pixels: Some(PixelArea { x: 100, y: 60, width: 400, height: 300 }),
            binning: Binning { factor: [2, 2], ..Binning::NONE },
        };
        for projection in [
            brown_conrady([-0.12, 0.03], [1e-3, -5e-4]),
            Projection::Division { lambda: -0.1 },
            Projection::KannalaBrandt { k: [0.02, 0.0, 0.0, 0.0] },
            Projection::Omnidirectional { xi: 1.1, distortion: BrownConrady::default() },
        ] {
            for pitch_m in [[6e-6; 2], [8.3e-6, 6.2e-6]] {
                let (lens, distorting) = camera(projection, 4.0, pitch_m);
                for region in [RegionOfInterest::WHOLE, part] {
                    let seen = seen(&lens, &distorting, region, pitch_m);
                    let settings = DevelopSettings {
                        digital_zoom: if region.pixels.is_some() { 1.5 } else { 1.0 },
                        resize_px: region.pixels.map(|_| [210, 140]),
                        ..DevelopSettings::default()
                    };
                    let resampling = seen.resampling(&settings).expect("distortion");
                    let report = serde_json::to_value(seen.image_report(&settings)).expect("numbers");
                    let number =
                        |row: usize, column: usize| report["camera_matrix"][row][column].as_f64().expect("one");
                    let (width, height) = (resampling.size_px()[0] as f64, resampling.size_px()[1] as f64);
                    assert_eq!(report["resolution_px"][0], resampling.size_px()[0]);
                    for (x, y) in [(0.5, 0.5), (0.8, 0.3), (0.2, 0.7), (0.33, 0.1)] {
                        let pixel = DVec2::new(x * width, y * height);
                        let source = resampling.source_px(pixel).expect("seen");
                        // Back to the whole sensor.
                        let [across, down] = region.binning.factor.map(|n| n as f64);
                        let first = region.pixels.map_or(DVec2::ZERO, |area| DVec2::new(area.x as f64, area.y as f64));
                        let on_sensor = source * DVec2::new(across, down) + first;
                        let found = distorting.seen(on_sensor).expect("light").direction;
                        // A pinhole, with whole numbers at the centres of pixels and y down.
                        let down = (pixel.y - 0.5 - number(1, 2)) / number(1, 1);
                        let right = (pixel.x - 0.5 - number(0, 2) - number(0, 1) * down) / number(0, 0);
                        let wanted = glam::DVec3::new(right, -down, -1.0).normalize();
                        assert!((found - wanted).length() < 1e-12, "{projection:?} {pixel}: {found} {wanted}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_gains_undo_cos4() {
        let (lens, camera) = camera(Projection::Perspective, 22.0, [6e-6; 2]);
        let mut metadata = RawMetadata::default();
        seen(&lens, &camera, RegionOfInterest::WHOLE, [6e-6; 2]).write_to(&mut metadata, &KnownCorrections::default());
        let map = metadata.gain_maps().next().expect("falloff");
        for (x, y) in [(0.0, 0.0), (0.5, 0.5), (1.0, 0.25), (0.73, 0.4)] {
            let across = DVec2::new((x - 0.5) * 640.0, (y - 0.5) * 480.0) * 6e-6 / 0.004;
            let gain = (1.0 + across.length_squared()).powi(2);
            // Straight lines miss a function by its second derivative times the step² over 8. Here that is at most
            // 6.7/32²/8 along x and 3.4/24²/8 along y, 1.6e-3 together; the opening adds (D/2v)² = 5e-4 at most.
            assert!((f64::from(map.at(x, y)) - gain).abs() < 2.1e-3, "{x} {y}: {} {gain}", map.at(x, y));
        }
    }

    #[test]
    fn lenses_that_no_pinhole_stands_for_keep_their_image() {
        for (projection, is_corrected) in [
            (Projection::Perspective, false),
            (Projection::Equirectangular, false),
            (Projection::KannalaBrandt { k: [0.0; 4] }, true),
            (Projection::KannalaBrandt { k: [8.0, 0.0, 0.0, 0.0] }, true),
            (Projection::KannalaBrandt { k: [-0.15, 0.0, 0.0, 0.0] }, true),
        ] {
            let (lens, camera) = camera(projection, 4.0, [6e-6; 2]);
            let seen = seen(&lens, &camera, RegionOfInterest::WHOLE, [6e-6; 2]);
            assert_eq!(seen.model().is_some(), is_corrected, "{projection:?}");
        }
        let (mut lens, _) = camera(Projection::KannalaBrandt { k: [0.0; 4] }, 4.0, [6e-6; 2]);
        lens.focal_length_m = 0.0015;
        let grid = PixelGrid { resolution: SIZE, pitch_m: [6e-6; 2] };
        let wide = Camera::new(&lens, &grid, DAffine3::IDENTITY, 1.0).expect("a lens");
        // The corner is 2.4 mm from the axis, 92° of it.
        assert!(seen(&lens, &wide, RegionOfInterest::WHOLE, [6e-6; 2]).model().is_none());
        let middle = RegionOfInterest {
            pixels: Some(PixelArea { x: 100, y: 100, width: 400, height: 300 }),
            ..RegionOfInterest::WHOLE
        };
        assert!(seen(&lens, &wide, middle, [6e-6; 2]).model().is_some());
    }
}
