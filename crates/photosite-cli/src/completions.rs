//! `photosite completions`: what a shell needs to complete commands and options.

use std::fmt::Write;

use clap::{Arg, Args, Command};
use clap_complete::{Shell, generate};

use super::print::print_out;

const EXAMPLES: &str = "\
Examples:
  photosite completions bash > /etc/bash_completion.d/photosite
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

pub(super) fn run(args: &CompletionsArgs, mut command: Command) -> photosite_core::Result<()> {
    let mut script = Vec::new();
    generate(args.shell, &mut command, "photosite", &mut script);
    if args.shell == Shell::Fish {
        script.extend(values_for_fish(&command).into_bytes());
    }
    print_out(&script)
}

/// Values of positional arguments, such as kinds of targets: the generator for fish completes options alone.
fn values_for_fish(command: &Command) -> String {
    let mut lines = String::new();
    for command in command.get_subcommands() {
        for value in command.get_positionals().flat_map(Arg::get_possible_values) {
            let about = value.get_help().map(ToString::to_string).unwrap_or_default().replace('\'', "\\'");
            let (command, value) = (command.get_name(), value.get_name());
            let when = format!("__fish_photosite_using_subcommand {command}");
            let _ = writeln!(lines, "complete -c photosite -n \"{when}\" -f -a \"{value}\" -d '{about}'");
        }
    }
    lines
}
