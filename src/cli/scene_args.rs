//! What all commands that read scenes have in common on the command line.

use clap::Args;

#[derive(Args)]
pub(super) struct SceneArgs {
    /// Go on where a texture of a scene file is missing or broken: grey stands for it, and a warning says so.
    #[arg(long)]
    lenient: bool,
}

impl SceneArgs {
    /// Changes to keys of the capture, and what is said here.
    pub(super) fn after(&self, overrides: &[String]) -> Vec<String> {
        let lenient = self.lenient.then(|| "scene.lenient=true".to_owned());
        overrides.iter().cloned().chain(lenient).collect()
    }
}
