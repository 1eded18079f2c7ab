//! Failures and their exit codes.

use scphd_filters::settings::FileError;
use scphd_log::log_folder::{LogError, Place};
use scphd_run::session::SessionError;
use scphd_score::results::OutputError;
use scphd_score::results::json::Summary;
use scphd_view::plot::PlotError;
use std::fmt::Display;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Why the program fails.
#[derive(Debug)]
pub enum Failure {
    /// Input, arguments or settings are invalid: exit code 2.
    Input(String),
    /// Anything else: exit code 1.
    Internal(String),
    /// The reader of the output has closed it, which is not a failure.
    PipeClosed,
}

impl Failure {
    pub fn input(message: impl Display) -> Self {
        Self::Input(message.to_string())
    }

    /// An error of clap without the usage, in one line.
    pub fn of_arguments(error: &clap::Error) -> Self {
        let text = error.to_string();
        let text = text.strip_prefix("error: ").unwrap_or(&text);
        let end = ["Usage:", "For more information"].iter().filter_map(|after| text.find(after)).min();
        let said = text[..end.unwrap_or(text.len())].trim_end().replace("\n\n", "; ");
        Self::input(format_args!("{said} (see --help)"))
    }

    /// A log folder cannot be read: the first reason.
    pub fn of_log(dir: &Path, errors: &[LogError]) -> Self {
        let folder = dir.display();
        match errors {
            // The error has the name of the folder.
            [error @ LogError { place: Place::Folder(_), .. }] => Self::input(error),
            [error] => Self::input(format_args!("{folder}: {error}")),
            [error, more @ ..] => Self::input(format_args!(
                "{folder}: {error}; and {} more, which scphd-sim check {folder} names",
                more.len()
            )),
            [] => Self::input(format_args!("{folder}: cannot be read")),
        }
    }

    /// What it says; empty for a closed output.
    pub fn message(self) -> String {
        match self {
            Self::Input(message) | Self::Internal(message) => message,
            Self::PipeClosed => String::new(),
        }
    }

    /// Prints the failure. Returns its exit code.
    pub fn report(self) -> ExitCode {
        let (message, code) = match self {
            Self::Input(message) => (message, 2),
            Self::Internal(message) => (message, 1),
            Self::PipeClosed => return ExitCode::SUCCESS,
        };
        // File names and messages of libraries may have line breaks. Errors of writing are ignored.
        let line = message.split_whitespace().collect::<Vec<_>>().join(" ");
        let _ = writeln!(io::stderr(), "error: {line}");
        ExitCode::from(code)
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::input(error)
    }
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        match error {
            SessionError::Start(_) | SessionError::Map(_) | SessionError::Step { .. } => Self::input(error),
            other => Self::Internal(other.to_string()),
        }
    }
}

impl From<rayon::ThreadPoolBuildError> for Failure {
    fn from(error: rayon::ThreadPoolBuildError) -> Self {
        Self::Internal(format!("cannot start threads: {error}"))
    }
}

impl From<toml::ser::Error> for Failure {
    fn from(error: toml::ser::Error) -> Self {
        Self::Internal(error.to_string())
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        match error {
            OutputError::Io { source, .. } if source.kind() == io::ErrorKind::BrokenPipe => Self::PipeClosed,
            OutputError::Io { .. } => Self::input(error),
            other => Self::Internal(other.to_string()),
        }
    }
}

impl From<PlotError> for Failure {
    fn from(error: PlotError) -> Self {
        match error {
            PlotError::Io { .. } => Self::input(error),
            other => Self::Internal(other.to_string()),
        }
    }
}

/// Writes `text` and a newline to stdout.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match writeln!(stdout, "{text}").and_then(|()| stdout.flush()) {
        Ok(()) => Ok(()),
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Err(Failure::PipeClosed),
        Err(error) => Err(Failure::Internal(format!("cannot write to stdout: {error}"))),
    }
}

/// Warns, on stderr, of runs over a log whose estimate is worse than dead reckoning.
pub fn warn_of_errors(runs: &[Summary]) {
    let worse: Vec<_> = runs.iter().filter(|run| run.worse_than_dead_reckoning == Some(true)).collect();
    let Some(first) = worse.first() else { return };
    let share = if runs.len() > 1 { format!(" in {} of {} runs", worse.len(), runs.len()) } else { String::new() };
    let metres = |rmse: Option<f64>| rmse.map_or_else(String::new, |rmse| format!("{rmse:.3} m"));
    warning(format_args!(
        "warning: {} by {} {}: the estimate is worse than dead reckoning{share} (seed {}: position RMSE {}, dead reckoning \
         {})",
        first.log,
        first.filter,
        first.precision,
        first.seed,
        metres(first.position_rmse_m),
        metres(first.dead_reckoning_rmse_m),
    ));
}

/// Notes, on stderr, that a run's innovations differ much from those expected by the settings; needs no truth.
pub fn note_innovations(run: &Summary) {
    if let Some(text) = run.nis_mean.and_then(about_innovations) {
        notice(format_args!("note: {} by {} {}: {text}", run.log, run.filter, run.precision));
    }
}

/// Advice about the noise if the innovations are at most half of the expected size, or 1.4 times as large.
fn about_innovations(nis_mean: f64) -> Option<String> {
    let times = nis_mean.sqrt();
    let advice = if nis_mean < 0.25 {
        "measurements scatter less than the settings say, or odometry does; state less noise, above all where landmarks are few"
    } else if nis_mean > 2.0 {
        "measurements scatter more than the settings say, or odometry does; state more noise, or learn it (`tune`)"
    } else {
        return None;
    };
    Some(format!("innovations are {times:.2} times what is expected of them (NIS/dim {nis_mean:.2}): {advice}"))
}

/// Whether only warnings and errors are printed.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Makes the program print only warnings and errors.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints a notice on stderr, unless quiet.
pub fn notice(text: impl Display) {
    if !is_quiet() {
        warning(text);
    }
}

/// Prints a message on stderr, also when quiet.
pub fn warning(text: impl Display) {
    // Errors of writing it are ignored.
    let _ = writeln!(io::stderr(), "{text}");
}

#[cfg(test)]
mod tests {
    use super::about_innovations;

    #[test]
    fn wrong_noise_is_reported() {
        assert!([0.25, 0.44, 1.0, 2.0].iter().all(|&nis| about_innovations(nis).is_none()));
        let text = about_innovations(0.16).unwrap();
        assert!(
            text.starts_with("innovations are 0.40 times what is expected of them (NIS/dim 0.16): ")
                && text.contains("less noise")
        );
        assert!(about_innovations(2.7).unwrap().contains("more noise"));
    }
}
