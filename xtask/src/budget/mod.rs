//! The step `budget`: what the firmware takes in flash, RAM, stack and instructions, against `budgets.toml`.

mod figures;
mod limits;
mod share;
mod table;

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use crate::firmware::board::{Board, EMULATED, TARGETS};
use crate::firmware::image::{self, Extra, Image};
use crate::firmware::output::Replay;
use crate::firmware::rig::Rig;
use crate::firmware::streams::{self, Precision};
use crate::firmware::{PROOF, emulator};
use crate::process;
use crate::steps::{Options, Outcome};
use crate::toolchain::{self, Toolchain};
use figures::{Code, Figures};
use limits::Budget;

pub use table::print;

/// The step.
pub fn step(options: &Options) -> Outcome {
    match judge(options) {
        Ok((measured, broken)) if broken.is_empty() => Outcome::Passed(format!("{measured} budgets kept")),
        Ok((_, broken)) => Outcome::Failed(broken.join("; ")),
        Err(reason) => Outcome::Failed(reason),
    }
}

/// Measures every entry; the number of them and the limits that are broken.
fn judge(options: &Options) -> Result<(usize, Vec<String>), String> {
    let measured = measure(|_| true)?;
    print(&measured);
    if let Some(path) = &options.json {
        let text = serde_json::to_string_pretty(&measured).map_err(|error| error.to_string())?;
        std::fs::write(path, text + "\n").map_err(|error| format!("{}: {error}", path.display()))?;
    }
    let budgets = entries()?;
    let broken = budgets.iter().zip(&measured).flat_map(|(budget, figures)| budget.broken_by(figures));
    Ok((budgets.len(), broken.collect()))
}

fn entries() -> Result<Vec<Budget>, String> {
    limits::read(&process::root().join("budgets.toml"))
}

/// Measures the entries that are `wanted`, in their order.
pub fn measure(wanted: impl Fn(&Budget) -> bool) -> Result<Vec<Figures>, String> {
    let budgets: Vec<Budget> = entries()?.into_iter().filter(wanted).collect();
    emulator::prepare()?;
    let toolchain = toolchain::find(&TARGETS)?;
    let mut images: HashMap<(&str, String, &[&str]), (Image, Code)> = HashMap::new();
    let mut measured = Vec::new();
    for budget in &budgets {
        let (board, precision) = (board_of(budget)?, budget.precision()?);
        let rig = budget.source().rig();
        let key = (board.name, rig.image(precision), rig.room);
        let (image, code) = match images.entry(key) {
            Entry::Occupied(built) => built.into_mut(),
            Entry::Vacant(place) => place.insert(built(&toolchain, board, rig, precision)?),
        };
        let stream = streams::make(budget.source(), precision)?;
        let host = streams::on_host(&stream, rig, precision, "release")?;
        let replay = Replay::parse(&emulator::run(board, image, &stream)?)?;
        if let Some(difference) = host.first_difference(&replay) {
            return Err(format!("{} on {} is not what the host computes: {difference}", budget.scenario, board.name));
        }
        measured.push(Figures::of(budget, board, *code, &replay, host.scan_interval_s)?);
    }
    Ok(measured)
}

/// The image that is measured, and what its code says, and that of the image without output.
fn built(toolchain: &Toolchain, board: &Board, rig: Rig, precision: Precision) -> Result<(Image, Code), String> {
    let image = image::build_replay(toolchain, board, rig, precision)?;
    let features = &rig.proof_features(precision)[..];
    let bare = image::build(toolchain, board, PROOF, &Extra { features, flags: &[] })?;
    let code = Code { image: image.sizes()?, stack_bound: image.stack_bound()?, library: bare.library_flash()? };
    Ok((image, code))
}

fn board_of(budget: &Budget) -> Result<&'static Board, String> {
    let found = EMULATED.iter().find(|board| board.name == budget.board);
    found.ok_or_else(|| format!("budgets.toml: no board `{}`", budget.board))
}
