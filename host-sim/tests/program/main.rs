//! The program as run by its users, each test in its own folder.

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
