//! Output files of a run.

use super::failure::{Failure, is_quiet, notice, print};
use scphd_exchange::tum;
use scphd_filters::kind::Kind;
use scphd_run::session::Session;
use scphd_score::results::json::Summary;
use scphd_score::results::{json, sink};
use scphd_view::output::csv;
use scphd_view::plot;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The requested JSON file and folder.
#[derive(Debug)]
pub struct Outputs {
    pub json: Option<PathBuf>,
    pub out: Option<PathBuf>,
}

impl Outputs {
    /// Checks, before a run that may take minutes, that the files can be written, as far as possible. Nothing is created yet.
    pub fn check(&self) -> Result<(), Failure> {
        if let Some(json) = &self.json {
            check_file("--json", json)?;
        }
        if let Some(out) = &self.out {
            // The nearest existing ancestor must be a folder.
            let there = out.ancestors().find(|path| path.symlink_metadata().is_ok());
            if let Some(file) = there.filter(|path| !path.is_dir()) {
                return Err(Failure::input(format_args!(
                    "--out {}: {} is not a folder",
                    out.display(),
                    file.display()
                )));
            }
        }
        Ok(())
    }

    /// Prints text for people: to stdout, or to stderr if the JSON goes to stdout.
    pub fn print(&self, text: &str) -> Result<(), Failure> {
        print_beside(self.json.as_deref(), text)
    }

    /// Writes one run: its JSON object, its tables and its plots.
    pub fn write_one<K: Kind>(&self, log: &K::Log, session: &Session<K>) -> Result<(), Failure> {
        if let Some(out) = &self.out {
            make(out)?;
            csv::write_record(out, &session.record)?;
            tum::write(out, &session.record.scans)?;
            plot::write_plots::<K>(out, log, &[(&label(&session.summary), &session.record)])?;
            notice(format_args!("tables and plots are in {}", out.display()));
        }
        if let Some(path) = &self.json {
            json::write_summary(path, &session.summary)?;
        }
        Ok(())
    }

    /// Writes runs over the same log: a JSON list, common plots, and tables in a folder for each.
    pub fn write_all<K: Kind>(&self, log: &K::Log, sessions: &[Session<K>]) -> Result<(), Failure> {
        if let Some(out) = &self.out {
            for session in sessions {
                let folder = out.join(format!("{}-{}", session.summary.filter, session.summary.precision));
                make(&folder)?;
                csv::write_record(&folder, &session.record)?;
                tum::write(&folder, &session.record.scans)?;
            }
            let labels: Vec<String> = sessions.iter().map(|session| label(&session.summary)).collect();
            let runs: Vec<_> = labels.iter().zip(sessions).map(|(label, run)| (label.as_str(), &run.record)).collect();
            plot::write_plots::<K>(out, log, &runs)?;
            notice(format_args!("tables and plots are in {}", out.display()));
        }
        if let Some(path) = &self.json {
            let summaries: Vec<_> = sessions.iter().map(|session| session.summary.clone()).collect();
            json::write_summaries(path, &summaries)?;
        }
        Ok(())
    }
}

/// Checks that the file of `option` can be written, as far as possible.
pub fn check_file(option: &str, path: &Path) -> Result<(), Failure> {
    sink::check(path).map_err(|error| Failure::input(format_args!("{option} {}: {error}", path.display())))
}

/// Writes the file of `option`.
pub fn write_file(option: &str, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    sink::write(path, bytes).map_err(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => Failure::PipeClosed,
        _ => Failure::input(format_args!("{option} {}: {error}", path.display())),
    })
}

/// Prints text for people: to stdout, or to stderr if `file` is stdout.
pub fn print_beside(file: Option<&Path>, text: &str) -> Result<(), Failure> {
    if is_quiet() {
        return Ok(());
    }
    if file.is_some_and(sink::is_stdout) {
        notice(text);
        return Ok(());
    }
    print(text)
}

/// The name of a run in a legend: filter and precision.
pub fn label(summary: &Summary) -> String {
    format!("{} {}", summary.filter, summary.precision)
}

/// Creates the folder if it is missing.
pub fn make(dir: &Path) -> Result<(), Failure> {
    fs::create_dir_all(dir).map_err(|error| Failure::Internal(format!("cannot make {}: {error}", dir.display())))
}
