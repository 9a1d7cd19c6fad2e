//! `photosite camera`: the camera of a capture as other tools read it.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::log::say;
use super::print::{println_out, refuse_existing, write_result};
use super::scene_args::SceneArgs;
use photosite_calibration::camera_files::{
    CalibratedCamera, ColmapImage, FittedLens, Models, colmap_cameras, colmap_images, colmap_points, euroc, kalibr,
    opencv, ros,
};
use photosite_capture::Capture;
use photosite_core::output::create_folder;
use photosite_core::{Invalid, Result, Sandbox};
use photosite_files::lock::Lock;
use photosite_pipeline::{LensSeen, standalone_recording_camera};
use photosite_sensor::Use;
use photosite_transport::optics::{Camera, LensKind};

const EXAMPLES: &str = "\
Example:
  photosite camera capture.toml --format opencv -o camera.yaml";

/// Describe the camera to OpenCV, ROS, Kalibr or COLMAP.
///
/// The camera has the pixels of image.png, or of the raw image with output.image = false: those of exposure.region_px,
/// exposure.binning, sensor.frame_grabber and develop.resize_px, where they are given. It has the distortion of the
/// lens; where image.png is freed of that, which develop.distortion = false prevents, it has the pixels of the raw
/// image. A lens that the format cannot express is refused. For a lens from a prescription the model closest to the
/// chief rays of points at the focus distance is fitted by least squares over the image, and its deviation reported. A
/// camera that moves is described halfway through its first image, as in `capture.json` (`pose_time_s`).
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct CameraArgs {
    /// A capture file (.toml) or a scene (.gltf, .glb, .obj, .ply, .stl).
    input: PathBuf,
    /// The tool.
    #[arg(long, value_enum)]
    format: Format,
    /// File, or folder for COLMAP's text model [default: standard output].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Name of the camera in the file.
    #[arg(long, default_value = "camera")]
    name: String,
    /// Change a key of the capture file, for example --set lens.f_number=4.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    #[command(flatten)]
    scene: SceneArgs,
    /// Overwrite an earlier file.
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Format {
    /// YAML for cv2.FileStorage.
    Opencv,
    /// camera_info of ROS.
    Ros,
    /// camchain.yaml; the camera is cam0.
    Kalibr,
    /// cameras.txt, images.txt and points3D.txt; the image is image.png.
    Colmap,
    /// sensor.yaml; the body is the camera.
    Euroc,
}

pub(super) fn run(args: &CameraArgs, sandbox: &Sandbox) -> Result<()> {
    let capture = Capture::load_within(sandbox, &args.input, &args.scene.after(&args.overrides, &args.input))?;
    capture.sensor().allows(Use::CameraFile).map_err(|invalid| capture.source().error(invalid))?;
    if capture.lens().kind == LensKind::Bare {
        let message = "a bare sensor has no camera matrix: each of its pixels sees everything";
        return Err(capture.source().error(Invalid::new("lens.type", message).help("use a lens")));
    }
    let placed = standalone_recording_camera(&capture)?.halfway();
    let seen =
        LensSeen::new(capture.lens(), &placed, capture.sensor(), &capture.exposure().region, capture.exposure().stages);
    let grid = seen.image_grid(capture.output().image.then_some(capture.develop()));
    let undistorts = seen.resampling(capture.develop()).is_some_and(|resampling| resampling.undistorts());
    if let Some(done) = seen.resampled(capture.develop()).filter(|_| undistorts && capture.output().image) {
        say!(
            "warning: image.png is {}, and this is the camera of the raw image; that of image.png is in capture.json, or write {}",
            done.what,
            done.keys
        );
    }
    let camera = CalibratedCamera::new(&args.name, &placed);
    let camera = match capture.lens().kind {
        LensKind::Prescription => camera.with_fitted(&fitted(&capture, &placed, args.format)?),
        LensKind::Thin | LensKind::Pinhole | LensKind::Hole | LensKind::Bare => camera,
    };
    let camera = camera.on_grid(&grid);
    let one = std::slice::from_ref(&camera);
    let text = match args.format {
        Format::Opencv => opencv(&camera),
        Format::Ros => ros(&camera),
        Format::Kalibr => kalibr(one),
        Format::Colmap => colmap_cameras(one),
        Format::Euroc => euroc(&camera, &camera.from_world().inverse(), 20.0),
    };
    let text = text.map_err(|invalid| capture.source().error(invalid))?;
    match (args.format, &args.output) {
        (Format::Colmap, Some(folder)) => {
            let image =
                ColmapImage { name: "image.png".to_owned(), camera: 0, to_world: camera.to_world, points: Vec::new() };
            let files =
                [("cameras.txt", text), ("images.txt", colmap_images(&[image])), ("points3D.txt", colmap_points(&[]))];
            create_folder(folder)?;
            let _lock = Lock::of_folder(folder)?;
            files.iter().try_for_each(|(name, _)| refuse_existing(&folder.join(name), args.force))?;
            files.iter().try_for_each(|(name, text)| write(&folder.join(name), args.force, text))
        }
        (Format::Opencv | Format::Ros | Format::Kalibr | Format::Euroc, Some(file)) => {
            refuse_existing(file, args.force)?;
            write(file, args.force, &text)
        }
        (_, None) => println_out(text.trim_end()),
    }
}

/// Model fitted to a lens from a prescription; reports how close it is.
fn fitted(capture: &Capture, camera: &Camera, format: Format) -> Result<FittedLens> {
    let models = match format {
        Format::Opencv | Format::Ros | Format::Colmap => Models::Rational,
        Format::Kalibr | Format::Euroc => Models::Radtan,
    };
    let fitted = FittedLens::new(camera, models).ok_or_else(|| {
        let message = "no model of this format shows all that the lens shows of the image";
        let help = "choose another format or a smaller sensor; photosite project tells where points appear";
        capture.source().error(Invalid::new("lens.prescription", message).help(help))
    })?;
    let FittedLens { projection, rms_px, largest_px, distance_m, .. } = fitted;
    let at =
        if distance_m.is_finite() { format!("at {distance_m:.4} m from the camera") } else { "at infinity".to_owned() };
    say!(
        "the {} model is fitted to the chief rays of the lens {at}: rms {rms_px:.4} px, largest {largest_px:.4} px",
        projection.name()
    );
    Ok(fitted)
}

fn write(path: &Path, force: bool, text: &str) -> Result<()> {
    write_result(path, force, |to| to.write_all(text.as_bytes()))
}
