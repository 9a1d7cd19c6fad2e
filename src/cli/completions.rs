//! `photosite completions`: what a shell needs to complete commands and options.

use clap::{Args, Command};
use clap_complete::{Shell, generate};

use super::print::print_out;

const EXAMPLES: &str = "\
Examples:
  photosite completions bash > ~/.local/share/bash-completion/completions/photosite
  photosite completions zsh > \"${fpath[1]}/_photosite\"
  photosite completions fish > ~/.config/fish/completions/photosite.fish";

/// Print the completions of commands and options for a shell.
///
/// Put them where the shell looks for them, and start a new shell.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

pub(super) fn run(args: &CompletionsArgs, mut command: Command) -> crate::Result<()> {
    let mut script = Vec::new();
    generate(args.shell, &mut command, "photosite", &mut script);
    print_out(&script)
}
