//! The command line.

mod args;
mod check;
mod commands;
mod compare;
mod constants;
mod contender;
mod device;
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

/// Runs the command line. The exit code is 0, 2 for invalid input, arguments or settings, 1 for other failures. A failure is
/// reported in one line.
pub fn main() -> ExitCode {
    let done = match Cli::try_parse() {
        Ok(cli) => commands::execute(cli),
        // clap returns help and version as errors; a closed output is not an error.
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
