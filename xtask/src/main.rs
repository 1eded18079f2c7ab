//! The project's commands: `cargo xtask test` before a commit, `cargo xtask test --all` for everything, as in CI.

mod args;
mod bench;
mod budget;
mod capi;
mod debian;
mod doctor;
mod files;
mod firmware;
mod gpu;
mod install;
mod lint;
mod msrv;
mod noalloc;
mod once;
mod options;
mod outcome;
mod package;
mod peers;
mod process;
mod python;
mod quick;
mod ros2;
mod steps;
mod target;
mod test_programs;
mod toolchain;
mod tools;
mod unit;
mod web;

use args::Request;
use std::process::ExitCode;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match args::parse(&words) {
        Ok(Request::Print(text)) => {
            print!("{text}");
            ExitCode::SUCCESS
        }
        Ok(Request::Run(chosen, options)) => ExitCode::from(u8::from(!steps::run(&chosen, &options))),
        Err(message) => {
            eprintln!("xtask: {message}\n\n{}", args::usage());
            ExitCode::from(2)
        }
    }
}
