//! A second process of this program, so that steps run beside those of the workspace: one cargo alone leaves a core idle while the
//! last crate is compiled or a program is linked, a sixth of the time in all.

use std::fs::File;
use std::path::PathBuf;
use std::process::ExitStatus;

use crate::files;
use crate::process::{self, Running};

/// The line before the summary of a run, and the first word of the line behind it.
pub const SUMMARY: &str = "=== summary\n";
pub const TOTAL: &str = "total";

/// Steps that run one after the other in this process: they share the build folder of the workspace, in which only one cargo can
/// build at a time.
pub const OF_WORKSPACE: [&str; 7] = ["fmt", "packages", "lint", "doc", "unit", "libraries", "examples"];

/// The second process.
pub struct Beside {
    process: Running,
    output: PathBuf,
}

impl Beside {
    /// Starts these steps. Their output goes to a file.
    pub fn start(names: &[&str], strict: bool) -> Result<Self, String> {
        let output = process::own_target_dir("beside.log");
        files::write(&output, "")?;
        let open = || File::options().append(true).open(&output).map_err(|error| error.to_string());
        let program = std::env::current_exe().map_err(|error| error.to_string())?;
        let mut command = process::command(program);
        command.args(names).args(strict.then_some("--strict"));
        let child = command.stdout(open()?).stderr(open()?).spawn().map_err(|error| error.to_string())?;
        println!("beside: {}; their output follows, and is in {}", names.join(", "), output.display());
        Ok(Self { process: Running(child), output })
    }

    /// Waits for its end, prints its output, and returns the lines of its summary.
    pub fn finish(mut self) -> Result<Vec<String>, String> {
        let status: ExitStatus = self.process.0.wait().map_err(|error| error.to_string())?;
        let output = files::text(&self.output)?;
        let (steps, lines) = parts(&output);
        println!("{steps}");
        if lines.is_empty() { Err(format!("the steps beside ended early: {status}")) } else { Ok(lines) }
    }
}

/// The output before the summary, and the lines of the summary.
fn parts(output: &str) -> (&str, Vec<String>) {
    let (steps, summary) = output.rsplit_once(SUMMARY).unwrap_or((output, ""));
    let lines = summary.lines().filter(|line| !line.is_empty()).take_while(|line| !line.starts_with(TOTAL));
    (steps, lines.map(str::to_owned).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_summary_is_separated_from_the_output() {
        let output = "=== [1/1] fmt: x\n=== ok      fmt  1.0 s\n\n=== summary\nok      fmt  1.0 s\nFAILED  doc  2.0 s  why\ntotal   3.0 s\n1 passed\n";
        let (steps, lines) = parts(output);
        assert_eq!(lines, ["ok      fmt  1.0 s", "FAILED  doc  2.0 s  why"]);
        assert!(steps.ends_with("fmt  1.0 s\n\n"));
        assert_eq!(parts("killed\n"), ("killed\n", Vec::new()));
    }
}
