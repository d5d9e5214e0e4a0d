//! `bodyschema completions`: what a shell needs to complete its command lines.

use clap_complete::Shell;

use super::Outcome;

/// Print a script by which a shell completes bodyschema's commands, options and values.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema completions bash > bodyschema.bash
  bodyschema completions zsh > _bodyschema
  bodyschema completions fish > bodyschema.fish

Where it goes: bash ~/.local/share/bash-completion/completions/bodyschema, zsh a folder of $fpath,
fish ~/.config/fish/completions/bodyschema.fish.")]
pub struct Args {
    /// The shell
    shell: Shell,
}

pub fn run(args: &Args, mut program: clap::Command) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "bodyschema", &mut script);
    say!("{}", String::from_utf8_lossy(&script).trim_end());
    Ok(())
}
