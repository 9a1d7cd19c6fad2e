//! `photosite view`: a page in the browser.

use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::log::say;
use super::monitor::TerminalMonitor;
use super::print::println_out;
use super::scene_args::SceneArgs;
use super::shorthands::Shorthands;
use crate::capture::Capture;
use crate::pipeline::FilmMemory;
use crate::view::{View, serve};
use crate::{Result, Sandbox};

/// See it in the browser: light is traced once, and exposure, sensor and development answer at once.
///
/// INPUT is a capture file (.toml) or a scene (.gltf, .glb, .obj, .ply, .stl). The address of the page is printed; it
/// ends with a token, and who has it may look. On another machine, forward the port: ssh -L 8000:localhost:8000 HOST
/// photosite view --port 8000 capture.toml
#[derive(Args)]
pub(super) struct ViewArgs {
    /// A capture file (.toml) or a scene.
    input: PathBuf,
    /// The port of the page [default: any that is free].
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// The address to listen at; others than 127.0.0.1 let other machines see the page, if they have its address.
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    host: IpAddr,
    /// Open the page in the browser.
    #[arg(long)]
    open: bool,
    /// A folder for the checkpoint where tracing is stopped: photosite render goes on from there.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Change a key of the capture file, for example --set exposure.time_s=0.02.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Most memory for the film, GiB.
    #[arg(long, value_name = "GIB", default_value = "4")]
    film_memory: FilmMemory,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    shorthands: Shorthands,
}

pub(super) fn run(args: &ViewArgs, sandbox: &Sandbox) -> Result<()> {
    let overrides = args.shorthands.around(args.scene.after(&args.overrides), &args.input);
    let capture = Capture::load_within(sandbox, &args.input, &overrides)?;
    let view = View {
        capture,
        name: args.input.display().to_string(),
        host: args.host,
        port: args.port,
        film_memory: args.film_memory,
        checkpoint: args.output.clone(),
    };
    serve(view, &(Arc::new(TerminalMonitor::new(false, true)) as _), |address| {
        // Who started it reads it there; on a pipe, too.
        let _ = println_out(address);
        say!("the page is at {address}; Ctrl-C ends it");
    })
}
