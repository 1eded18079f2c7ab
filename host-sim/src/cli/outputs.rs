//! Where the files of a run go.

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

/// A JSON file and a folder, where asked for.
#[derive(Debug)]
pub struct Outputs {
    pub json: Option<PathBuf>,
    pub out: Option<PathBuf>,
}

impl Outputs {
    /// Whether the files can be written, as far as that can be told before a run that may take minutes. Nothing is
    /// made yet.
    pub fn check(&self) -> Result<(), Failure> {
        if let Some(json) = &self.json {
            check_file("--json", json)?;
        }
        if let Some(out) = &self.out {
            // The nearest that exists has to be a folder.
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

    /// Prints what is for people: to stdout, or to stderr where the JSON goes to stdout.
    pub fn print(&self, text: &str) -> Result<(), Failure> {
        print_beside(self.json.as_deref(), text)
    }

    /// One run: its JSON object, its tables and its plots.
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

    /// Runs over the same log: a JSON list, plots of all together, tables in a folder for each.
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

/// Whether a file that `option` asks for can be written, as far as that can be told before.
pub fn check_file(option: &str, path: &Path) -> Result<(), Failure> {
    sink::check(path).map_err(|error| Failure::input(format_args!("{option} {}: {error}", path.display())))
}

/// Writes a file that `option` asks for.
pub fn write_file(option: &str, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    sink::write(path, bytes).map_err(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => Failure::PipeClosed,
        _ => Failure::input(format_args!("{option} {}: {error}", path.display())),
    })
}

/// Prints what is for people: to stdout, or to stderr where `file` is stdout itself.
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

/// The run in a legend: filter and precision.
pub fn label(summary: &Summary) -> String {
    format!("{} {}", summary.filter, summary.precision)
}

/// Makes the folder where it is missing.
pub fn make(dir: &Path) -> Result<(), Failure> {
    fs::create_dir_all(dir).map_err(|error| Failure::Internal(format!("cannot make {}: {error}", dir.display())))
}
