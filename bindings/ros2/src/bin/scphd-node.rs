//! The filter as a node of ROS 2: `scphd-node --ros-args --params-file FILE`.

use scphd_node::middleware::Arguments;
use std::env;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::of(env::args().skip(1), "scphd");
    match arguments.and_then(|arguments| scphd_node::node::run(&arguments)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{failure}");
            ExitCode::FAILURE
        }
    }
}
