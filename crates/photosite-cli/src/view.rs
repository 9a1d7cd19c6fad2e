//! `photosite view`: a page in the browser.

use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::log::{say, warning};
use super::monitor::TerminalMonitor;
use super::print::println_out;
use super::scene_args::SceneArgs;
use super::shorthands::Shorthands;
use photosite_capture::{Capture, FileKind};
use photosite_core::{Error, Result, Sandbox};
use photosite_pipeline::{DeviceChoice, FilmMemory};
use photosite_view::{Input, Outside, View, serve};

/// Environment variable that holds the token of the address. Command lines are visible to all users of a machine; this
/// is not.
const TOKEN: &str = "PHOTOSITE_VIEW_TOKEN";

const EXAMPLES: &str = "\
Example:
  photosite view capture.toml --open";

/// Open the live view in the browser: sliders answer at once.
///
/// Light is traced once; exposure, sensor and development follow every change. INPUT is a capture file (.toml) or a
/// scene (.gltf, .glb, .obj, .ply, .stl), whose light is traced; a folder that photosite render has filled, or
/// stored light (.exr), which is exposed again; a raw file or an image of light, which is developed; or the folder
/// of a data set, whose images are shown together. A second INPUT is compared with the first.
///
/// The address of the page is printed; it ends with a token, and whoever has it may look. On another machine,
/// forward the port: ssh -L 8000:localhost:8000 HOST photosite view --port 8000 capture.toml. With a token of your
/// own in the environment variable PHOTOSITE_VIEW_TOKEN and a --port, an open page finds the next photosite view
/// after the one before has ended.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ViewArgs {
    /// A capture file, a scene, a folder of a render or of a data set, stored light or a raw file; a second one to
    /// compare it with.
    #[arg(required = true, num_args = 1..=2, value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// Open the page in the browser.
    #[arg(long)]
    open: bool,
    /// Folder for the checkpoint when tracing is stopped: photosite render continues from there.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Change a key of the capture file, for example --set exposure.time_s=0.02.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// The port of the page [default: any that is free].
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// The address to listen at; others than 127.0.0.1 let other machines see the page, if they have its address.
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    host: IpAddr,
    /// Maximum memory for the film, GiB.
    #[arg(long, value_name = "GIB", default_value = "4")]
    film_memory: FilmMemory,
    /// Device that traces light, exposes and develops: cpu; gpu, the first graphics card; gpu:1 or gpu:NAME, one of
    /// `photosite devices`; auto, a graphics card where there is one.
    #[arg(long, value_name = "DEVICE", default_value = "cpu")]
    device: DeviceChoice,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    shorthands: Shorthands,
}

pub(super) fn run(args: &ViewArgs, sandbox: &Sandbox) -> Result<()> {
    let monitor: Outside = Arc::new(TerminalMonitor::new(false, true));
    let open = |(number, path): (usize, &PathBuf)| {
        // Changes are those of the first.
        let is_scene = FileKind::of_name(path).is_none_or(|kind| kind == FileKind::Model) && !path.is_dir();
        let overrides = match (number, is_scene) {
            (0, true) => args.shorthands.around(args.scene.after(&args.overrides, path), path)?,
            (0, false) => args.overrides.clone(),
            (_, _) => Vec::new(),
        };
        Ok((path.display().to_string(), Input::open(sandbox, path, &overrides)?))
    };
    let inputs: Vec<(String, Input)> = args.inputs.iter().enumerate().map(open).collect::<Result<_>>()?;
    let traced: Vec<&Capture> = inputs.iter().filter_map(|(_, input)| input.traced()).collect();
    if args.device != DeviceChoice::Cpu && !inputs.iter().any(|(_, input)| input.is_exposed()) {
        let help = Some("leave --device out, or give a capture file, a scene or the folder of a render".into());
        return Err(Error::Usage { message: "--device: no light of these inputs is traced or exposed".into(), help });
    }
    // One device for both, which is opened once.
    let (device, card) = if traced.is_empty() {
        (None, args.device.sensor_card(&*monitor)?)
    } else {
        let device = args.device.device_for(traced, &*monitor)?;
        let card = device.is_some().then(|| args.device.sensor_card(&*monitor)).transpose()?;
        (device, card.flatten())
    };
    let view = View {
        inputs: inputs.into_iter().map(|(name, input)| (name, input.on_device(device.clone()))).collect(),
        card,
        host: args.host,
        port: args.port,
        film_memory: args.film_memory,
        checkpoint: args.output.clone(),
        token: std::env::var(TOKEN).ok(),
    };
    serve(view, &monitor, |address| {
        // Who has started it reads it there, through a pipe, too.
        let _ = println_out(address);
        say!("the page is at this address; Ctrl-C ends it");
        if args.open
            && let Err(reason) = open::that_detached(address)
        {
            warning!("cannot open a browser: {reason}");
        }
    })
}
