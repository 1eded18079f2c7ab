//! `scphd-sim`: runs the filter over logs and scenarios and says how well it did.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
