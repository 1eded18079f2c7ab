//! Tables of the figures, for a reader.

use super::figures::Figures;
use super::limits;
use super::share::CHIPS;
use crate::firmware::output::STAGES;
use comfy_table::presets::ASCII_MARKDOWN;
use comfy_table::{CellAlignment, Table};

/// Number of text columns at the left of every table.
const WORDS: usize = 3;

/// Prints memory, instructions and shares, with one row for every entry.
pub fn print(all: &[Figures]) {
    println!(
        "\nbytes: flash is the whole image with startup code and output, library the filter's part of it; RAM is the \
         filter's; stack is the deepest of the run, stack bound the deepest that the code allows"
    );
    println!("{}", memory(all));
    println!(
        "\ninstructions: a prediction, a scan (p99: 99 % of scans take no more), an estimate of pose and map; pairs of a \
         component and a measurement in the costliest scan; bound: its instructions a pair times the pairs by capacity"
    );
    println!("{}", instructions(all));
    println!(
        "\ninstructions of the stages of a scan, mean (worst of each): moving features moved, candidates weighed, particles \
         selected, maps updated, maps reduced"
    );
    println!("{}", stages(all));
    println!("\nshare of a chip's time, mean and worst, for scan, predictions before it and estimate after it");
    println!("{}", shares(all));
}

fn memory(all: &[Figures]) -> Table {
    let parts = all.first().map(|figures| figures.state_parts.as_slice()).unwrap_or_default();
    let mut header = words("flash, text, rodata, library, RAM");
    header.extend(parts.iter().map(|(name, _)| name.clone()));
    header.extend(["stack".into(), "stack bound".into()]);
    table(header, all, |figures| {
        let mut row = vec![figures.flash_bytes, figures.text_bytes, figures.rodata_bytes];
        row.extend([figures.library_flash_bytes, figures.state_bytes]);
        row.extend(figures.state_parts.iter().map(|(_, bytes)| bytes));
        row.extend([figures.stack_bytes, figures.stack_bound_bytes]);
        row.into_iter().map(grouped).collect()
    })
}

fn instructions(all: &[Figures]) -> Table {
    let header = words(
        "scans, predict mean, worst, scan mean, p99, worst, estimate mean, pairs, pairs by capacity, bound, digest",
    );
    table(header, all, |figures| {
        let mut row: Vec<String> = [
            figures.scans as u64,
            figures.instructions_per_predict_mean,
            figures.instructions_per_predict_worst,
            figures.instructions_per_scan_mean,
            figures.instructions_per_scan_p99,
            figures.instructions_per_scan_worst,
            figures.instructions_per_estimate_mean,
            figures.pairs_in_worst_scan,
            figures.pairs_by_capacity,
        ]
        .into_iter()
        .map(grouped)
        .collect();
        row.push(figures.instructions_per_scan_bound.map(grouped).unwrap_or_default());
        row.push(figures.digest.clone());
        row
    })
}

fn stages(all: &[Figures]) -> Table {
    table(words(&STAGES.join(", ")), all, |figures| {
        let each = figures.stages.mean.iter().zip(figures.stages.worst);
        each.map(|(&mean, worst)| format!("{} ({})", grouped(mean), grouped(worst))).collect()
    })
}

fn shares(all: &[Figures]) -> Table {
    let mut header = words("scans/s");
    header.extend(CHIPS.iter().map(|chip| {
        format!("{} {:.0} MHz, {} cycles/instr.", chip.name, chip.clock_hz / 1e6, chip.cycles_per_instruction)
    }));
    table(header, all, |figures| {
        let rate = figures.scans_per_second;
        let mut row = vec![format!("{rate:.1}")];
        row.extend(CHIPS.iter().map(|chip| {
            if chip.like != figures.board {
                return String::new();
            }
            let percent = |instructions| 100.0 * chip.share(instructions, rate);
            let (mean, worst) = (figures.instructions_per_cycle_mean, figures.instructions_per_cycle_worst);
            format!("{:.1} % {:.1} %", percent(mean), percent(worst))
        }));
        row
    })
}

fn words(columns: &str) -> Vec<String> {
    ["board", "configuration", "scenario"].into_iter().chain(columns.split(", ")).map(str::to_owned).collect()
}

fn table(header: Vec<String>, all: &[Figures], row: impl Fn(&Figures) -> Vec<String>) -> Table {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN).set_header(header);
    for figures in all {
        let names =
            [format!("{} {}", figures.board, figures.core), figures.configuration.clone(), figures.scenario.clone()];
        table.add_row(names.into_iter().chain(row(figures)));
    }
    for column in table.column_iter_mut().skip(WORDS) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// The number in groups of three digits, as 1 234 567.
fn grouped(number: u64) -> String {
    limits::grouped(number).replace('_', " ")
}
