//! Plays a log, a scenario or an MCAP file as messages of ROS 2: `scphd-publish SOURCE`.

use scphd_node::middleware::Arguments;
use std::env;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::of(env::args().skip(1), "scphd_publish");
    match arguments.and_then(|arguments| scphd_node::publish::run(&arguments)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{failure}");
            ExitCode::FAILURE
        }
    }
}
