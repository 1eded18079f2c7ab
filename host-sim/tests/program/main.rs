//! The program as its users run it, in folders of its own.

mod bad_input;
mod cli;
mod diff;
#[path = "../folders/mod.rs"]
mod folders;
mod hil;
mod import;
mod maps;
mod outputs;
mod place;
mod report;
