//! Figures of whole runs, and plots of the curves; called by `cargo xtask bench`.

mod figure;
mod growth;
mod sessions;

use clap::{Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

/// What a scan of the scphd filter costs.
#[derive(Parser)]
#[command(name = "scphd-bench", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Runs whole scenarios and a log, and prints their figures as a JSON list of objects {name, value, unit}.
    Sessions {
        /// Folder of the recorded logs; without the log in it, its figure is left out.
        #[arg(long, default_value_os_t = scphd_shared_data::folder())]
        data: PathBuf,
    },
    /// Draws the curves from what `cargo bench --bench time` has left, and writes all times.
    Growth {
        criterion: PathBuf,
        /// Folder for times.csv, growth.svg and growth.png.
        out: PathBuf,
    },
}

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Sessions { data } => sessions::run(&data),
        Command::Growth { criterion, out } => growth::draw(&criterion, &out),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
