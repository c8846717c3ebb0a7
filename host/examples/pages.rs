//! Writes the man pages and the completions of shells, made from the command line's own definition:
//! `cargo run --example pages -- FOLDER`. The packages take them from there.

use std::io;
use std::path::PathBuf;

use clap_complete::Shell;
use clap_complete::generate_to;

fn main() -> io::Result<()> {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        return Err(io::Error::other("usage: pages FOLDER"));
    };
    let (man, shells) = (folder.join("man"), folder.join("completions"));
    std::fs::create_dir_all(&man)?;
    std::fs::create_dir_all(&shells)?;
    let mut command = pasapas::cmd::command_line();
    for shell in [Shell::Bash, Shell::Zsh, Shell::Fish, Shell::PowerShell] {
        generate_to(shell, &mut command, "pasapas", &shells)?;
    }
    // `pasapas help upload` says what `man pasapas-upload` does: no page of its own for that.
    clap_mangen::generate_to(pasapas::cmd::command_line().disable_help_subcommand(true), &man)
}
