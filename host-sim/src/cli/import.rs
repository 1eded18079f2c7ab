//! The command that converts recordings to log folders.

use super::args::{ClockName, ImportArgs};
use super::check;
use super::failure::{Failure, notice};
use super::folder::export;
use scphd_exchange::import::{Imported, columns, mrclam, recording, victoria_park};
use scphd_log::dimensions::Planar;
use scphd_log::log_folder;
use std::fmt::Display;
use std::fs;

/// Reads the recording, writes the folder, and reports choices and warnings of a check.
pub fn import(args: ImportArgs) -> Result<(), Failure> {
    let Imported { log, told } = read(&args)?;
    told.iter().for_each(|told| notice(plain(told)));
    export(&log, &args.out)?;
    // The written folder is read again, which checks units, clocks and numbers.
    let read = log_folder::read(&args.out).map_err(|error| {
        let out = args.out.display();
        Failure::input(format_args!("{out} is written, but no log that can be run: {error}"))
    })?;
    check::warn::<Planar>(&read);
    Ok(())
}

fn read(args: &ImportArgs) -> Result<Imported, Failure> {
    let head = args.head.as_ref().map(|path| {
        let place = path.display().to_string();
        let text = fs::read_to_string(path);
        text.map(|text| (place, text))
            .map_err(|error| Failure::input(format_args!("--head {}: {error}", path.display())))
    });
    let head = head.transpose()?;
    let source = &args.source;
    let is_map = source.extension().is_some_and(|extension| extension == "toml");
    let is_data_set = mrclam::is(source) || victoria_park::is(source);
    if !is_map && !is_data_set && (!source.is_dir() || recording::is_bag(source)) {
        return recording::read(source, &options(args, head)).map_err(|error| Failure::input(plain(error)));
    }
    let named = [&args.odometry, &args.fixes, &args.truth].iter().any(|name| name.is_some());
    if named || !args.detections.is_empty() || args.partial || args.part.is_some() {
        return Err(Failure::input(
            "--odometry, --detections, --fixes, --truth, --partial and --part: of MCAP files alone",
        ));
    }
    let head = head.map(|(place, text)| {
        log_folder::of_head(&text).map_err(|error| Failure::input(format_args!("--head {place}: {error}")))
    });
    let head = head.transpose()?;
    let read = if is_map {
        columns::read(source, head, args.range_below)
    } else if args.range_below.is_some() {
        return Err(Failure::input("--range-below: of MCAP files and tables alone"));
    } else if mrclam::is(source) {
        mrclam::read(source, args.robot, head)
    } else if victoria_park::is(source) {
        victoria_park::read(source, head)
    } else {
        let what = "neither the files of MRCLAM (RobotN_Odometry.dat) nor of Victoria Park (aa3_dr.mat) nor a recording (.mcap)";
        return Err(Failure::input(format_args!("{}: {what}", source.display())));
    };
    read.map_err(|error| Failure::input(plain(error)))
}

/// Escapes control characters, which names in a recording may contain.
fn plain(text: impl Display) -> String {
    let shown = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    text.to_string().chars().map(shown).collect()
}

fn options(args: &ImportArgs, head: Option<(String, String)>) -> recording::Options {
    let sensor = |named: &String| match named.split_once('=') {
        Some((name, topic)) => (name.to_owned(), topic.to_owned()),
        None => (String::new(), named.clone()),
    };
    recording::Options {
        head,
        odometry: args.odometry.clone(),
        detections: args.detections.iter().map(sensor).collect(),
        fixes: args.fixes.clone(),
        truth: args.truth.clone(),
        clock: match args.clock {
            ClockName::Header => recording::Clock::Header,
            ClockName::Log => recording::Clock::Log,
        },
        partial: args.partial,
        part: args.part,
        range_below_m: args.range_below,
    }
}
