//! `scphd-sim`: runs filters over logs and scenarios, and reports their errors.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
