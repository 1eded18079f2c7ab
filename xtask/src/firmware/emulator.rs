//! Runs an image in QEMU and decodes its defmt output.

use super::board::Board;
use super::image::Image;
use super::output::Replay;
use crate::once::Once;
use crate::outcome::Missing;
use crate::process;
use crate::tools::{QEMU, Tool};
use defmt_decoder::{DecodeError, Table};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(1800);

/// QEMU, if it is present or can be obtained; looked for once in a run.
pub fn qemu() -> Result<Tool, Missing> {
    static FOUND: OnceLock<Result<Tool, Missing>> = OnceLock::new();
    FOUND.get_or_init(|| QEMU.obtain()).clone()
}

/// QEMU for a step, which says which one it is.
pub fn prepare() -> Result<Tool, Missing> {
    let qemu = qemu()?;
    println!("{} ({})", qemu.version, qemu.place());
    Ok(qemu)
}

/// What images printed, by image and stream. Several steps replay the same stream with the same image, and counted instructions make
/// every run the same.
static PRINTED: Once<(PathBuf, PathBuf), String> = Once::new();

/// Runs `image` on `board` with a stream in its memory, unless this program has already done so, and returns what it printed,
/// line by line.
pub fn run(board: &Board, image: &Image, stream: &Path) -> Result<String, String> {
    PRINTED.get((image.path.clone(), stream.to_owned()), || {
        let address = board.stream.ok_or_else(|| format!("QEMU has no {}", board.name))?;
        let mut qemu = qemu()?.command();
        qemu.args(["-machine", board.name, "-nographic", "-monitor", "none", "-serial", "none"]);
        // One instruction takes one nanosecond, so that counts are reproducible.
        qemu.args(["-icount", "shift=0", "-semihosting-config", "enable=on,target=native", "-kernel"]).arg(&image.path);
        qemu.arg("-device").arg(format!("loader,file={},addr={address:#x},force-raw=on", stream.display()));
        let output = process::capture_for(&mut qemu, LIMIT);
        // The output of a failed program usually has the reason.
        let bytes = output.map_err(|error| format!("{}: {error}", image.path.display()))?;
        let lines = decode(&image.elf, &bytes)?;
        lines.first().into_iter().chain(lines.last()).for_each(|line| println!("{line}"));
        Ok(lines.join("\n"))
    })
}

/// Replays a stream on all boards side by side.
pub fn replay<'b>(images: &[(&'b Board, Image)], stream: &Path) -> Result<Vec<(&'b str, Replay)>, String> {
    process::side_by_side(images, |(board, image)| Ok((board.name, Replay::parse(&run(board, image, stream)?)?)))
}

fn decode(elf: &[u8], bytes: &[u8]) -> Result<Vec<String>, String> {
    let table = Table::parse(elf).map_err(|error| format!("defmt: {error}"))?.ok_or("the image does not use defmt")?;
    let mut decoder = table.new_stream_decoder();
    decoder.received(bytes);
    let mut lines = Vec::new();
    loop {
        match decoder.decode() {
            Ok(frame) => lines.push(match frame.level() {
                Some(level) => format!("{level:?} {}", frame.display_message()),
                None => frame.display_message().to_string(),
            }),
            Err(DecodeError::UnexpectedEof) => return Ok(lines),
            Err(DecodeError::Malformed) => return Err(format!("malformed defmt frame after {} lines", lines.len())),
        }
    }
}
