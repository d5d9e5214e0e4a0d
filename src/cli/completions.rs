//! `bodyschema completions`: what a shell needs to complete its command lines.

use clap::{Command, CommandFactory};
use clap_complete::Shell;

use super::Outcome;

/// Print a shell completion script for bodyschema's commands, options and values.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema completions bash > bodyschema.bash
  bodyschema completions zsh > _bodyschema
  bodyschema completions fish > bodyschema.fish

Install it as: bash ~/.local/share/bash-completion/completions/bodyschema, zsh in a folder of $fpath,
fish ~/.config/fish/completions/bodyschema.fish.")]
pub struct CompletionsArguments {
    /// The shell
    shell: Shell,
}

pub fn run(args: &CompletionsArguments) -> Outcome {
    let program = super::Cli::command();
    // Some of the generators would name hidden commands, too.
    let visible = program.get_subcommands().filter(|command| !command.is_hide_set()).cloned();
    let mut visible = Command::new("bodyschema")
        .version(env!("CARGO_PKG_VERSION"))
        .args(program.get_arguments().cloned())
        .subcommands(visible);
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut visible, "bodyschema", &mut script);
    say!("{}", String::from_utf8_lossy(&script).trim_end());
    Ok(())
}
