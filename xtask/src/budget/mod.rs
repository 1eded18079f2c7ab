//! The step `budget`: flash, RAM, stack and instructions of the firmware, compared with `budgets.toml`.

mod entry;
mod figures;
mod limits;
mod share;
mod table;

use crate::firmware::board::{Board, EMULATED, FIRST, REFERENCE};
use crate::firmware::image::{self, Image};
use crate::firmware::output::Replay;
use crate::firmware::rig::{Precision, Rig};
use crate::firmware::streams;
use crate::firmware::{PROOF, emulator};
use crate::options::Options;
use crate::outcome::{Outcome, Stop};
use crate::{files, process, toolchain};
use entry::Budget;
use figures::{Code, Figures};
use limits::FILE;
use std::collections::BTreeMap;

use table::print;

/// Measures every entry, and compares it with its limits or sets new ones.
pub fn step(options: &Options) -> Result<Outcome, Stop> {
    let measured = measure()?;
    print(&measured);
    options.write(&measured)?;
    let budgets = limits::read()?;
    let compiler = toolchain::find()?.compiler()?;
    if process::is_blessing() {
        let path = process::root().join(FILE);
        files::write(&path, budgets.rewritten(&files::text(&path)?, &measured, &compiler))?;
        return Ok(Outcome::Passed(format!("{FILE} rewritten")));
    }
    let broken = budgets.broken_by(&measured, &compiler);
    if !broken.is_empty() {
        return Err(broken.join("; ").into());
    }
    let note = format!("{} budgets kept", measured.len());
    Ok(Outcome::Passed(if compiler == budgets.compiler {
        note
    } else {
        format!("{note}, with the room for another compiler: set with {}, this is {compiler}", budgets.compiler)
    }))
}

/// Measures the entries in their order; an error if the states on a board differ from those on the host.
fn measure() -> Result<Vec<Figures>, Stop> {
    let budgets: Vec<Budget> = limits::read()?.entries;
    emulator::prepare()?;
    toolchain::find()?;
    let (mut runs, mut images) = (Vec::new(), BTreeMap::new());
    for budget in &budgets {
        let (board, (source, precision)) = (board_of(budget)?, budget.source()?);
        let stream = streams::make(source, precision)?;
        let host = streams::on_host(&stream, source.rig, precision)?;
        // Entries with the same board, name and features have the same image.
        let key = (board.name, source.rig.image(precision), source.rig.image_features());
        images.insert(key.clone(), (board, source.rig, precision));
        runs.push((budget, board, key, stream, host));
    }
    let images: Vec<_> = images.into_iter().collect();
    let built = process::side_by_side(&images, |(key, (board, rig, precision))| {
        Ok((key.clone(), built(board, *rig, *precision)?))
    })?;
    let built: BTreeMap<_, _> = built.into_iter().collect();
    // A run of QEMU uses one core, and does not influence the figures of another run.
    let measured = process::side_by_side(&runs, |(budget, board, key, stream, host)| {
        let (image, code) = &built[key];
        let replay = Replay::parse(&emulator::run(board, image, stream)?)?;
        match host.first_difference(&replay) {
            Some(difference) => {
                Err(format!("{} on {} is not what the host computes: {difference}", budget.scenario, board.name))
            }
            None => Figures::of(budget, board, *code, &replay, host.scan_interval_s),
        }
    })?;
    Ok(measured)
}

/// The image of a replay, and the figures of its code and of the image without output.
fn built(board: &Board, rig: Rig, precision: Precision) -> Result<(Image, Code), String> {
    let image = image::build_replay(board, rig, precision)?;
    // The reference board has the processor of the first one, and the step `proof` builds most of the images for it.
    let alike = if board == FIRST { &REFERENCE } else { board };
    let bare = image::build(alike, PROOF, &rig.proof_features(precision))?;
    let code = Code { image: image.sizes()?, stack_bound: image.stack_bound()?, library: bare.library_flash()? };
    Ok((image, code))
}

/// The reason why a scan with this number of instructions takes too long on a board, for which the limit of the worst case of the
/// same board and configuration holds; `None` if it does not.
pub fn beyond_worst_case(board: &str, configuration: &str, instructions: u64) -> Result<Option<String>, String> {
    let limit = limits::read()?.worst_case(board, configuration)?;
    let why = || format!(": a scan takes {instructions} instructions, the worst case {limit}");
    Ok((instructions > limit).then(why))
}

fn board_of(budget: &Budget) -> Result<&'static Board, String> {
    let found = EMULATED.iter().find(|board| board.name == budget.board);
    found.ok_or_else(|| format!("budgets.toml: no board `{}`", budget.board))
}
