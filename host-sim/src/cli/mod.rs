//! The command line.

mod args;
mod check;
mod commands;
mod compare;
mod constants;
mod contender;
mod diff;
mod failure;
mod figure;
mod folder;
mod hil;
mod import;
mod maps;
mod monte_carlo;
mod offer;
mod outputs;
mod progress;
mod recording;
mod repeat;
mod source;
mod stream;
mod tune;
mod worlds;

use args::Cli;
use clap::Parser;
use failure::Failure;
use std::process::ExitCode;

/// Runs what the command line asks for: exit code 0, 2 for bad input, arguments or settings, 1 for anything that is
/// not the user's to mend. Whatever fails is told in one line.
pub fn main() -> ExitCode {
    let done = match Cli::try_parse() {
        Ok(cli) => commands::execute(cli),
        // Help and version come as errors as well; a reader that went away is none.
        Err(asked) if !asked.use_stderr() => {
            let _ = asked.print();
            return ExitCode::SUCCESS;
        }
        Err(error) => Err(Failure::of_arguments(&error)),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
