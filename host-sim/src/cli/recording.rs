//! A run as an MCAP file.

use super::failure::{Failure, notice};
use super::offer::Offer;
use super::outputs::{check_file, write_file};
use scphd_exchange::mcap::{self, ExportError};
use scphd_run::film::Film;
use scphd_run::session::Session;
use std::path::Path;

const OPTION: &str = "--mcap";

/// Checks, before the run, that the file can be written, as far as possible.
pub fn check<K: Offer>(log: &K::Log, path: &Path) -> Result<(), Failure> {
    check_file(OPTION, path)?;
    mcap::check::<K>(log).map_err(|error| failure(&error))
}

/// Writes the run; `settings_text` are its settings as a file.
pub fn write<K: Offer>(
    path: &Path,
    log: &K::Log,
    settings: &K::Settings,
    session: &Session<K>,
    film: &Film<K>,
    settings_text: &str,
) -> Result<(), Failure> {
    const TOML: &str = "application/toml";
    let head = K::head(log);
    let mut attached = vec![("settings.toml", TOML, settings_text)];
    attached.extend(head.as_deref().map(|head| ("log.toml", TOML, head)));
    let bytes = mcap::write::<K>(log, settings, &session.record.scans, film, &attached);
    write_file(OPTION, path, &bytes.map_err(|error| failure(&error))?)?;
    notice(format_args!("the run is in {}, maps of {} scans", path.display(), film.pictures()));
    Ok(())
}

fn failure(error: &ExportError) -> Failure {
    match error {
        ExportError::Time(_) => Failure::input(format_args!("{OPTION}: {error}")),
        other => Failure::Internal(format!("{OPTION}: {other}")),
    }
}
