//! The web page with the filter: builds it, and checks its module in Node.js and the page in a headless browser.

use std::ffi::OsString;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::files;
use crate::outcome::{Missing, Outcome, Stop};
use crate::process;
use crate::toolchain::{self, Toolchain};
use crate::tools::{CHROMIUM, NODE, Tool};

pub const TARGET: &str = "wasm32-unknown-unknown";

/// Number of scans of the compared drive, and scans between its digests.
const DRIVE: [u32; 2] = [1000, 100];
/// Duration of the measurement of the frame rate, s.
const MEASURED_S: u32 = 5;
const LIMIT: Duration = Duration::from_secs(60);

fn cargo(command: &str) -> Command {
    process::cargo_in(command, "bindings/web/Cargo.toml", &process::own_target_dir("web-host"))
}

/// The tests of the crate, without the functions of the module.
pub fn test() -> Result<(), String> {
    process::run(&mut cargo("test"))
}

pub fn step() -> Result<Outcome, Stop> {
    test()?;
    let words = DRIVE.map(|number| number.to_string());
    let native = process::read(cargo("run").args(["--example", "native", "--"]).args(&words))?.replace('\n', "; ");
    let toolchain = toolchain::find_for(&[TARGET])?;
    let module = build(&toolchain)?;
    let page = write(&files::bytes(&module)?)?;
    println!("the page: {}, with the module {}", page.display(), module.display());
    let not_run = |Missing(reason)| Outcome::Partly(format!("{}; NOT RUN: {reason}", page.display()));
    match NODE.obtain() {
        Ok(node) => drive(&node, &module)?,
        Err(missing) => return Ok(not_run(missing)),
    }
    let chromium = match CHROMIUM.obtain() {
        Ok(chromium) => chromium,
        Err(missing) => return Ok(not_run(missing)),
    };
    println!("{}", chromium.version);
    let said = ask(&chromium, &page, &format!("rehearse={}", words.join(",")))?;
    if said != native {
        return Err(format!("the digests of the page\n{said}\nare not those of the host\n{native}").into());
    }
    println!("{} digests of the page are those of the host", native.split("; ").count());
    let frames = ask(&chromium, &page, &format!("measure={MEASURED_S}"))?;
    Ok(Outcome::Passed(format!("{}; in {}: {frames}", page.display(), chromium.version)))
}

/// Builds the module with a toolchain that has the target, or the sources for it.
fn build(toolchain: &Toolchain) -> Result<PathBuf, Stop> {
    let dir = process::own_target_dir(&format!("web-{}", toolchain.key()));
    let mut cargo = toolchain.cargo("rustc", "core");
    let mut flags = Vec::new();
    if let Toolchain::Debian { .. } = toolchain {
        // Debian's compiler expects a linker that is in another package.
        let linker = toolchain::linker(&mut cargo, "wasm-ld")?;
        flags = vec![format!("-Clinker={}", linker.display()), "-Clinker-flavor=wasm-ld".into()];
    }
    cargo.env("CARGO_ENCODED_RUSTFLAGS", flags.join("\x1f"));
    cargo.args(["--quiet", "--release", "--locked", "--manifest-path", "bindings/web/Cargo.toml", "--lib"]);
    cargo.args(["--features", "module", "--crate-type", "cdylib", "--target", TARGET, "--target-dir"]).arg(&dir);
    process::run(&mut cargo)?;
    Ok(dir.join(TARGET).join("release/scphd_web.wasm"))
}

/// Drives described filters in the module without a browser, and compares the digests with those of the library.
fn drive(node: &Tool, module: &Path) -> Result<(), String> {
    let path = process::own_target_dir("web").join("drive.txt");
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    process::run(cargo("run").args(["--example", "drive"]).stdout(File::create(&path).map_err(failed)?))?;
    let script = process::root().join("bindings/web/tests/module.mjs");
    process::run(node.command().arg(script).arg(module).stdin(File::open(&path).map_err(failed)?))
}

/// Writes the page as a single file.
fn write(module: &[u8]) -> Result<PathBuf, String> {
    let folder = process::root().join("bindings/web/page");
    let read = |name: &str| files::text(&folder.join(name));
    let [mut page, style, script] = [read("index.html")?, read("page.css")?, read("page.js")?];
    for (name, part) in [("style", style), ("script", script), ("module", STANDARD.encode(module))] {
        let mark = format!("{{{{{name}}}}}");
        if page.matches(&mark).count() != 1 {
            return Err(format!("bindings/web/page/index.html has not one {mark}"));
        }
        page = page.replace(&mark, part.trim_end());
    }
    let path = process::own_target_dir("web").join("scphd.html");
    files::write(&path, page)?;
    Ok(path)
}

/// Runs a task of the page in a headless browser, and returns its result, a line of the console.
fn ask(chromium: &Tool, page: &Path, task: &str) -> Result<String, String> {
    let mut browser = chromium.command();
    // A container has no support for a sandbox, and often only the user root.
    browser.args(["--headless", "--disable-gpu", "--no-sandbox", "--window-size=1280,900", "--enable-logging=stderr"]);
    let mut profile = OsString::from("--user-data-dir=");
    profile.push(process::own_target_dir("web").join("profile"));
    browser.arg(profile).arg(format!("file://{}#{task}", page.display()));
    browser.stdout(Stdio::null()).stderr(Stdio::piped());
    println!("$ {} #{task}", CHROMIUM.program);
    let mut running = process::Running(browser.spawn().map_err(|error| format!("{}: {error}", CHROMIUM.program))?);
    let console = running.0.stderr.take().ok_or("no console to read")?;
    let (send, receive) = mpsc::channel();
    thread::spawn(move || {
        let said = BufReader::new(console).split(b'\n').map_while(Result::ok).find_map(|line| result_in(&line));
        // After a timeout there is no receiver.
        let _ = send.send(said);
    });
    match receive.recv_timeout(LIMIT) {
        Ok(Some(result)) => Ok(result),
        Ok(None) => Err("the browser has ended without a result".into()),
        Err(_) => Err(format!("the page has said nothing for {} s", LIMIT.as_secs())),
    }
}

/// The text between the marks of a result.
fn result_in(line: &[u8]) -> Option<String> {
    let line = String::from_utf8_lossy(line);
    let (_, rest) = line.split_once("scphd result: ")?;
    rest.split_once(" :end").map(|(result, _)| result.to_owned())
}

#[cfg(test)]
mod tests {
    use super::result_in;

    #[test]
    fn a_result_is_found_in_a_line_of_the_console() {
        let line = b"[1:1:INFO:CONSOLE(9)] \"scphd result: 100 0a; 200 0b :end\", source: file:///x (9)";
        assert_eq!(result_in(line), Some("100 0a; 200 0b".into()));
        assert_eq!(result_in(b"[1:1:INFO:CONSOLE(9)] \"something else\""), None);
        assert_eq!(result_in(b"scphd result: torn off"), None);
    }
}
