//! `completions` and `man`: describe the command line to shells and as manual pages.

use std::fs;
use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;
use extricate::files::{self, OutputLock};

use crate::args::Cli;
use crate::output::Output;

/// Arguments of `completions`.
#[derive(Args)]
pub struct CompletionsArgs {
    /// The shell to complete for
    shell: Shell,
}

/// Arguments of `man`.
#[derive(Args)]
pub struct ManArgs {
    /// Folder for the pages, one per command; it is created if it is missing
    folder: PathBuf,
}

pub fn completions(args: &CompletionsArgs) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "extricate", &mut script);
    let mut out = Output::new(false);
    out.line(String::from_utf8_lossy(&script).trim_end())?;
    out.finish()
}

pub fn man(args: &ManArgs) -> anyhow::Result<()> {
    let mut program = Cli::command().disable_help_subcommand(true);
    program.build();
    let pages = pages(&program)?;
    fs::create_dir_all(&args.folder).with_context(|| format!("cannot write {}", args.folder.display()))?;
    let pages: Vec<_> = pages.into_iter().map(|(name, page)| (args.folder.join(name), page)).collect();
    let _lock = OutputLock::take(&args.folder.join("extricate.1"))?;
    for (path, _) in &pages {
        files::check_output(path, "manual page of this program", is_manual)?;
    }
    Ok(files::write_together(&pages)?)
}

/// Renders the manual pages of a command and of all its subcommands, with their file names.
fn pages(command: &Command) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let manual = Man::new(command.clone());
    let mut page = Vec::new();
    manual.render(&mut page).context("cannot make a manual page")?;
    let mut all = vec![(manual.get_filename(), page)];
    for below in command.get_subcommands().filter(|below| !below.is_hide_set()) {
        all.extend(pages(below)?);
    }
    Ok(all)
}

/// Whether a file is one of these pages: its title begins with the program's name.
fn is_manual(head: &[u8]) -> bool {
    let title = b".TH extricate";
    head.windows(title.len()).any(|at| at == title)
}
