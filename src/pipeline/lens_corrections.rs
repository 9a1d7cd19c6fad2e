//! What raw files say of the lens, so that developers can correct it, and what becomes of the picture when they do.

use crate::calibration::camera_files::{FittedLens, Models};
use crate::capture::{OutputSettings, RawFormat};
use crate::develop::{DevelopSettings, Resampling};
use crate::optics::{Camera, Falloff, Intrinsics, LensDescription, LensKind, Projection};
use crate::raw::{Distortion, GainMap, LensModel, PixelArea, RawMetadata, Warp};
use crate::sensor::{RegionOfInterest, SensorModel};
use glam::DVec2;
use std::sync::{Mutex, OnceLock, PoisonError};

use crate::report::ImageReport;

/// Points of the gain map along each side: straight lines between so many miss 1/cos⁴θ by less than 0.3 % up to 45°
/// from the axis.
const POINTS: [usize; 2] = [33, 25];

/// What stands for a traced lens is said to be beside it from here on, px.
const LARGEST_PX: f64 = 0.1;

/// A lens as a window of the sensor sees through it.
pub struct LensSeen<'a> {
    lens: &'a LensDescription,
    camera: &'a Camera,
    /// What stands for a lens from a prescription, which developers have no words for; `None` of other lenses.
    fitted: Option<FittedLens>,
    /// The part of the sensor that is read out, px.
    area: PixelArea,
    /// Columns and rows of the raw picture.
    size_px: [usize; 2],
    /// Pixels of the sensor in one of the raw picture.
    factor: [f64; 2],
    /// Pixel pitch of the raw picture, m.
    pitch_m: [f64; 2],
    /// Whether every second row lies half a pixel farther to the right.
    is_staggered: bool,
}

/// A lens, where it stands, and what is known of it.
pub(super) type SeenLens<'a, 'k> = (&'a LensDescription, &'a Camera, &'k KnownCorrections);

/// What takes longer to find of a lens than a small exposure, and is found once.
#[derive(Debug, Default)]
pub(super) struct KnownCorrections {
    /// The gain map through the window that it was asked for last.
    gain_map: Mutex<Option<([f64; 4], Option<GainMap>)>>,
    /// What stands for a lens from a prescription.
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

/// What a developer has done to the places of things.
pub struct Resampled {
    /// "freed of the distortion of the lens".
    pub what: String,
    /// What to write so that it is not done.
    pub keys: String,
}

impl<'a> LensSeen<'a> {
    /// A lens as a window of a sensor sees through it.
    pub fn new(lens: &'a LensDescription, camera: &'a Camera, sensor: &SensorModel, region: &RegionOfInterest) -> Self {
        Self::knowing((lens, camera, &KnownCorrections::default()), sensor, region)
    }

    /// As [`new`](Self::new), with what is known of this lens.
    pub(super) fn knowing(
        (lens, camera, known): SeenLens<'a, '_>,
        sensor: &SensorModel,
        region: &RegionOfInterest,
    ) -> Self {
        let [width, height] = sensor.resolution;
        let area = region.pixels.unwrap_or(PixelArea { x: 0, y: 0, width, height });
        let (size_px, factor) = match &sensor.frame_grabber {
            Some(grabber) => (grabber.size, grabber.pixels_per_sample(sensor.resolution)),
            None => {
                let [across, down] = region.binning.factor;
                ([area.width / across, area.height / down], [across, down].map(|n| n as f64))
            }
        };
        let pitch_m = [0, 1].map(|axis| sensor.pixel_pitch_m[axis] * factor[axis]);
        let fit = || FittedLens::new(camera, Models::Rational);
        let fitted = if lens.kind == LensKind::Prescription { *known.fitted.get_or_init(fit) } else { None };
        Self { lens, camera, fitted, area, size_px, factor, pitch_m, is_staggered: sensor.cells.is_staggered() }
    }

    /// Writes falloff and distortion into the metadata of a raw image of this window. `known` is of this lens.
    pub(super) fn write_to(&self, metadata: &mut RawMetadata, known: &KnownCorrections) {
        metadata.gain_map = match self.lens.falloff {
            Falloff::None if self.lens.stops.is_empty() => None,
            Falloff::None | Falloff::Cos4 => known.gain_map(self),
        };
        metadata.distortion = self.model().map(Distortion::Lens);
    }

    /// How a developer resamples the picture; `None` where it stays as it is.
    pub fn resampling(&self, settings: &DevelopSettings) -> Option<Resampling> {
        Resampling::new(&self.metadata(), self.size_px, settings)
    }

    /// What is corrected and changed, in words.
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
    pub(super) fn warnings(
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
                    "its picture reaches 90° from the axis, which a picture without distortion cannot show"
                };
                warnings.push(format!("image.png keeps the distortion of the {name} lens: {why}"));
            }
            Some(model) if has_dng => {
                if Warp::of_lens(&model, self.size_px, self.metadata().pixel_aspect()).is_none() {
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
        if self.is_staggered && has_dng {
            let how = "by CFALayout, which most programs pass over: they take the rows for columns";
            warnings.push(format!("raw.dng tells that every second row lies half a pixel to the right {how}"));
        }
        if let Some(Resampled { what, keys }) = self.resampled(settings).filter(|_| output.image) {
            let truth = match (!output.truth.layers.is_empty(), has_targets) {
                (true, true) => Some("ground truth and the points of targets are"),
                (true, false) => Some("ground truth is"),
                (false, true) => Some("the points of targets in capture.json are"),
                (false, false) => None,
            };
            if let Some(truth) = truth {
                warnings.push(format!(
                    "image.png is {what}, but {truth} not; write {keys}, and both show things in the same places"
                ));
            }
            if !has_dng && !output.raw.is_empty() {
                warnings.push(format!(
                    "image.png is {what}, which photosite develop cannot do with these raw files: DNG files alone tell of lens \
                     and pixels"
                ));
            }
        }
        warnings
    }

    /// The camera that the developed picture is a picture of.
    pub(super) fn image_report(&self, settings: &DevelopSettings) -> ImageReport {
        let metadata = self.metadata();
        let model = self.model().filter(|_| settings.distortion);
        let (on_grid, projection) = match &model {
            Some(model) => (model.pinhole(), Projection::Perspective),
            None => (self.intrinsics(), self.projection()),
        };
        let resampling = self.resampling(settings);
        let (size, (first, per_pixel)) = match &resampling {
            Some(resampling) => (resampling.size_px(), resampling.on_sensor()),
            None => (self.size_px, ([0.0; 2], [1.0; 2])),
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

    /// The matrix of the lens on the grid of the raw picture.
    fn intrinsics(&self) -> Intrinsics {
        let first = [self.area.x, self.area.y].map(|n| n as f64);
        let whole = self.fitted.map_or(self.camera.intrinsics(), |fitted| fitted.intrinsics);
        whole.on_grid(first, self.factor)
    }

    /// The model of the lens, or what stands for it.
    fn projection(&self) -> Projection {
        self.fitted.map_or(self.lens.projection, |fitted| fitted.projection)
    }

    /// What is known of lens and pixels.
    fn metadata(&self) -> RawMetadata {
        RawMetadata {
            pixel_pitch_m: Some(self.pitch_m),
            is_staggered: self.is_staggered,
            distortion: self.model().map(Distortion::Lens),
            ..RawMetadata::default()
        }
    }

    /// Whether straight lines are curved, but for a panorama, whose picture is meant to be as it is.
    fn is_distorted(&self) -> bool {
        !matches!(self.projection(), Projection::Perspective | Projection::Equirectangular)
    }

    /// The model that a developer corrects: of a lens whose picture a pinhole could take as well.
    fn model(&self) -> Option<LensModel> {
        let model = LensModel {
            intrinsics: self.intrinsics(),
            projection: self.projection(),
            max_angle_rad: self.lens.max_angle_rad,
        };
        let can_correct = self.is_distorted() && !self.camera.scans() && model.is_within_a_half_space(self.size_px);
        can_correct.then_some(model)
    }

    /// The window on the grid of the sensor: left, top, width, height.
    fn window_px(&self) -> [f64; 4] {
        let [width, height] = [0, 1].map(|axis| self.size_px[axis] as f64 * self.factor[axis]);
        [self.area.x as f64, self.area.y as f64, width, height]
    }

    /// 1 over the relative illumination. Where distortion leaves a pixel without light, there is nothing to correct.
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
    use crate::develop::DevelopSettings;
    use crate::optics::{BrownConrady, Focus, PixelGrid};
    use crate::sensor::Binning;
    use glam::DAffine3;

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
        let (size_px, factor) = ([area.width / across, area.height / down], [across, down].map(|n| n as f64));
        let pitch_m = [0, 1].map(|axis| pitch_m[axis] * factor[axis]);
        LensSeen { lens, camera, fitted: None, area, size_px, factor, pitch_m, is_staggered: false }
    }

    #[test]
    fn the_picture_shows_what_the_camera_of_its_report_sees() {
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
        let map = metadata.gain_map.expect("falloff");
        for (x, y) in [(0.0, 0.0), (0.5, 0.5), (1.0, 0.25), (0.73, 0.4)] {
            let across = DVec2::new((x - 0.5) * 640.0, (y - 0.5) * 480.0) * 6e-6 / 0.004;
            let gain = (1.0 + across.length_squared()).powi(2);
            // Straight lines miss a function by its second derivative times the step² over 8. Here that is at most
            // 6.7/32²/8 along x and 3.4/24²/8 along y, 1.6e-3 together; the opening adds (D/2v)² = 5e-4 at most.
            assert!((f64::from(map.at(x, y)) - gain).abs() < 2.1e-3, "{x} {y}: {} {gain}", map.at(x, y));
        }
    }

    #[test]
    fn lenses_that_no_pinhole_stands_for_keep_their_picture() {
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
