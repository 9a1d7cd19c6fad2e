//! Tests of the help of all commands.

use clap::Command;

use super::command;
use super::help::GROUPS;

fn all(command: &Command, found: &mut Vec<Command>) {
    for subcommand in command.get_subcommands() {
        all(subcommand, found);
        found.push(subcommand.clone());
    }
}

#[test]
fn every_command_is_in_one_group() {
    let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
    grouped.retain(|name| cfg!(feature = "view") || *name != "view");
    let command = command();
    let mut there: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
    grouped.sort_unstable();
    there.sort_unstable();
    assert_eq!(grouped, there);
}

#[test]
fn help_fits_into_80_columns() {
    let mut whole = command();
    whole.build();
    let mut commands = Vec::new();
    all(&whole, &mut commands);
    commands.push(whole);
    for mut command in commands {
        for text in [command.render_help(), command.render_long_help()] {
            for line in text.to_string().lines() {
                assert!(line.chars().count() <= 80, "{}: {line}", command.get_name());
            }
        }
    }
}

/// Test of example lines, which begin with the program, two columns in; text after three blanks explains them.
#[test]
fn examples_can_be_given_as_they_are() {
    let mut commands = Vec::new();
    all(&command(), &mut commands);
    let with_examples = commands.iter().filter(|command| command.get_after_help().is_some()).count();
    assert!(with_examples >= 26, "{with_examples}");
    commands.push(command());
    for after in commands.iter().filter_map(Command::get_after_help) {
        // A backslash joins a line to the next, as in a shell.
        let joined = after.to_string().split(" \\\n").map(str::trim_start).collect::<Vec<_>>().join(" ");
        for line in joined.lines().filter(|line| line.starts_with("  photosite")) {
            let line = line.trim().split("   ").next().unwrap_or_default().split(" > ").next().unwrap_or_default();
            let parsed = command().try_get_matches_from(line.split_whitespace());
            assert!(parsed.is_ok(), "{line}: {}", parsed.err().map(|e| e.to_string()).unwrap_or_default());
        }
    }
}
