//! Runs programs from the root of the workspace and shows the commands.

use rayon::prelude::*;
use std::ffi::OsStr;
use std::io::Read;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// Number of lines of error output that an error quotes: those of a linker are long, and the last ones have the reason.
const QUOTED: usize = 4;

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in a directory of the workspace")
}

/// A separate build folder of a step: with other compiler flags or another compiler, cargo would otherwise rebuild everything
/// after each change.
pub fn own_target_dir(name: &str) -> PathBuf {
    target_dir().join("xtask").join(name)
}

/// The build folder of ordinary builds.
pub fn target_dir() -> PathBuf {
    root().join(std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

/// Whether committed figures are to be rewritten with measured ones instead of compared.
pub fn is_blessing() -> bool {
    std::env::var_os("SCPHD_BLESS").is_some_and(|value| value == "1")
}

/// The cargo that started this program, so that `cargo +toolchain xtask` also applies to its own calls.
pub fn cargo() -> Command {
    command(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// The compiler that cargo would use.
pub fn rustc() -> Command {
    command(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
}

/// cargo in another workspace, with this build folder.
pub fn cargo_in(command: &str, manifest: &str, folder: &Path) -> Command {
    let mut cargo = cargo();
    cargo.args([command, "--quiet", "--locked", "--manifest-path", manifest, "--target-dir"]).arg(folder);
    cargo
}

/// A command in the root of the workspace, without input.
pub fn command(program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(program);
    command.current_dir(root()).stdin(Stdio::null());
    command
}

/// Runs a command to its end; its output goes to the terminal.
pub fn run(command: &mut Command) -> Result<(), String> {
    let status = start(command)?.0.wait();
    judge(command, status.map_err(|error| error.to_string())?)
}

/// As [`run`], but the error has the command's error output, for the summary.
pub fn run_or_quote(command: &mut Command) -> Result<(), String> {
    println!("$ {}", show(command));
    let output = command.stdout(Stdio::inherit()).output().map_err(|error| format!("{}: {error}", show(command)))?;
    let complaint = String::from_utf8_lossy(&output.stderr);
    eprint!("{complaint}");
    judge(command, output.status).map_err(|reason| {
        let last: Vec<&str> = complaint.lines().rev().filter(|line| !line.trim().is_empty()).take(QUOTED).collect();
        format!("{reason}: {}", last.into_iter().rev().collect::<Vec<_>>().join(" | "))
    })
}

/// Calls `work` for every item, in parallel on all cores. Returns the results in the order of the items, or the first error.
pub fn side_by_side<T: Sync, R: Send>(
    items: &[T],
    work: impl Fn(&T) -> Result<R, String> + Sync,
) -> Result<Vec<R>, String> {
    let all = || items.par_iter().map(&work).collect::<Vec<_>>();
    let results = panic::catch_unwind(AssertUnwindSafe(all)).map_err(|_| "a run ended with a panic")?;
    results.into_iter().collect()
}

/// As [`run`], but kills the program after `limit`.
pub fn run_for(command: &mut Command, limit: Duration) -> Result<(), String> {
    let child = start(command)?;
    await_for(command, child, limit)
}

fn await_for(command: &Command, mut child: Running, limit: Duration) -> Result<(), String> {
    let started = Instant::now();
    loop {
        if let Some(status) = child.0.try_wait().map_err(|error| error.to_string())? {
            return judge(command, status);
        }
        if started.elapsed() >= limit {
            return Err(format!("{} took longer than {} s", name(command), limit.as_secs_f32()));
        }
        thread::sleep(Duration::from_millis(50));
    }
}

/// As [`run`], but returns the standard output; kills the program after `limit`.
pub fn capture_for(command: &mut Command, limit: Duration) -> Result<Vec<u8>, String> {
    let mut child = start(command.stdout(Stdio::piped()))?;
    let mut output = child.0.stdout.take().ok_or("no output to read")?;
    let reader = thread::spawn(move || {
        let mut bytes = Vec::new();
        output.read_to_end(&mut bytes).map(|_| bytes)
    });
    await_for(command, child, limit)?;
    let bytes = reader.join().map_err(|_| "the reader of a program's output failed".to_owned())?;
    bytes.map_err(|error| format!("{}: {error}", name(command)))
}

/// As [`run`], but returns the standard output.
pub fn read_loudly(command: &mut Command) -> Result<String, String> {
    println!("$ {}", show(command));
    let output = command.stderr(Stdio::inherit()).output().map_err(|error| format!("{}: {error}", show(command)))?;
    judge(command, output.status)?;
    String::from_utf8(output.stdout).map_err(|error| format!("{}: {error}", name(command)))
}

/// Runs a command without output, and returns its standard output; the error has its standard error.
pub fn read(command: &mut Command) -> Result<String, String> {
    let output = command.output().map_err(|error| format!("{}: {error}", show(command)))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    } else {
        let complaint = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        Err(format!("{}: {}: {complaint}", show(command), output.status))
    }
}

/// A process that is killed when this is dropped.
pub struct Running(pub Child);

impl Drop for Running {
    fn drop(&mut self) {
        // Both calls fail only if the process has already ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn start(command: &mut Command) -> Result<Running, String> {
    println!("$ {}", show(command));
    command.spawn().map(Running).map_err(|error| format!("{}: {error}", show(command)))
}

fn judge(command: &Command, status: ExitStatus) -> Result<(), String> {
    if status.success() { Ok(()) } else { Err(format!("{}: {status}", name(command))) }
}

/// The program and its first argument, for a command that was already shown in full.
fn name(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_stem().unwrap_or(command.get_program());
    let words = std::iter::once(program).chain(command.get_args().take(1));
    words.map(quote).collect::<Vec<_>>().join(" ")
}

/// The command line with its environment variables.
fn show(command: &Command) -> String {
    let mut words = Vec::new();
    for (name, value) in command.get_envs() {
        if let Some(value) = value {
            words.push(format!("{}={}", name.display(), quote(value)));
        }
    }
    // The path of cargo is omitted, because it would hide the arguments.
    let program = Path::new(command.get_program());
    let is_cargo = program.file_stem() == Some(OsStr::new("cargo"));
    words.push(if is_cargo { "cargo".to_owned() } else { quote(command.get_program()) });
    words.extend(command.get_args().map(quote));
    words.join(" ")
}

fn quote(word: &OsStr) -> String {
    let word = word.to_string_lossy();
    if word.contains(' ') { format!("\"{word}\"") } else { word.into_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn root_is_the_workspace() {
        assert!(root().join("Cargo.lock").is_file());
    }

    #[cfg(unix)]
    #[test]
    fn a_nonzero_exit_status_is_an_error() {
        assert!(run(&mut command("true")).is_ok());
        assert!(run(&mut command("false")).is_err());
        assert!(run_for(&mut command("true"), Duration::from_secs(30)).is_ok());
        assert!(run_for(&mut command("false"), Duration::from_secs(30)).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn an_error_quotes_the_last_lines_of_the_error_output() {
        let mut complains = command("sh");
        complains.args(["-c", "for line in 1 2 3 4 5 6; do echo $line >&2; echo >&2; done; exit 3"]);
        let message = run_or_quote(&mut complains).unwrap_err();
        assert!(message.ends_with("3 | 4 | 5 | 6"), "{message}");
        assert!(run_or_quote(&mut command("true")).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn a_program_is_killed_after_its_time_limit() {
        let started = Instant::now();
        let message = run_for(command("sleep").arg("60"), Duration::from_millis(100)).unwrap_err();
        assert!(message.contains("longer than"), "{message}");
        assert!(started.elapsed() < Duration::from_secs(30));
    }

    #[test]
    fn results_have_the_order_of_the_items() {
        let items: Vec<u64> = (0..20).collect();
        let slow_first = |&item: &u64| {
            thread::sleep(Duration::from_millis(20 - item));
            Ok(item * item)
        };
        let expected: Vec<u64> = items.iter().map(|item| item * item).collect();
        assert_eq!(side_by_side(&items, slow_first), Ok(expected));
        let message = |result: Result<Vec<u64>, String>| result.unwrap_err();
        assert_eq!(message(side_by_side(&items, |&item| if item > 6 { Err(item.to_string()) } else { Ok(item) })), "7");
        let panics = |&item: &u64| if item == 7 { panic!("on purpose") } else { Ok(item) };
        assert!(message(side_by_side(&items, panics)).contains("panic"));
    }

    #[test]
    fn commands_show_their_variables() {
        let mut command = command("/some/where/cargo");
        command.env("RUSTDOCFLAGS", "-D warnings").arg("doc").env_remove("UNSET");
        assert_eq!(show(&command), "RUSTDOCFLAGS=\"-D warnings\" cargo doc");
    }
}
