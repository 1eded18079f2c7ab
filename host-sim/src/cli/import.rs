//! Recordings as log folders.

use super::args::{ClockName, ImportArgs};
use super::check;
use super::failure::{Failure, notice};
use super::folder::export;
use scphd_sim::dimensions::Planar;
use scphd_sim::exchange::import::{Imported, recording};
use scphd_sim::log_folder;
use std::fs;

/// Reads the recording, writes the folder, and tells what was chosen and what a check of it warns of.
pub fn import(args: ImportArgs) -> Result<(), Failure> {
    let Imported { log, told } = of_recording(&args)?;
    told.iter().for_each(notice);
    export(&log, &args.out)?;
    // What is written is what is read: units, clocks and numbers are judged there.
    let read = log_folder::read(&args.out).map_err(|error| {
        let out = args.out.display();
        Failure::input(format_args!("{out} is written, but no log that can be run: {error}"))
    })?;
    check::warn::<Planar>(&read);
    Ok(())
}

fn of_recording(args: &ImportArgs) -> Result<Imported, Failure> {
    let head = args.head.as_ref().map(|path| {
        let place = path.display().to_string();
        let text = fs::read_to_string(path);
        text.map(|text| (place, text))
            .map_err(|error| Failure::input(format_args!("--head {}: {error}", path.display())))
    });
    let sensor = |named: &String| match named.split_once('=') {
        Some((name, topic)) => (name.to_owned(), topic.to_owned()),
        None => (String::new(), named.clone()),
    };
    let options = recording::Options {
        head: head.transpose()?,
        odometry: args.odometry.clone(),
        detections: args.detections.iter().map(sensor).collect(),
        fixes: args.fixes.clone(),
        truth: args.truth.clone(),
        clock: match args.clock {
            ClockName::Header => recording::Clock::Header,
            ClockName::Log => recording::Clock::Log,
        },
        partial: args.partial,
    };
    recording::read(&args.source, &options).map_err(Failure::input)
}
