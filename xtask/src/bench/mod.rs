//! The steps `bench` and `counts`: the cost of a scan on the host as a table, and a comparison of instructions with the committed
//! ones.

mod counts;

use crate::options::Options;
use crate::outcome::{Outcome, Stop};
use crate::{files, process};
use comfy_table::presets::ASCII_MARKDOWN;
use comfy_table::{CellAlignment, Table};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::Duration;

pub use counts::step as counts;

const PACKAGE: &str = "scphd-benches";
/// Time limit; the whole runs take a minute or two.
const LIMIT: Duration = Duration::from_secs(1800);

/// A figure of the list that `--json` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    pub name: String,
    pub value: f64,
    pub unit: String,
}

impl Figure {
    fn new(name: &str, value: f64, unit: &str) -> Self {
        Self { name: name.into(), value, unit: unit.into() }
    }
}

/// Figures of a recorded log, which may not be there.
const OF_A_LOG: [&str; 3] =
    ["victoria_park_times_real_time", "victoria_park_blind_times_real_time", "victoria_park_default_times_real_time"];

/// Times of other projects that correspond to a figure: the figure, the project, and its time on a machine like that of the
/// figures, µs.
const PEERS: [(&str, &str, f64); 3] = [
    ("rfs_slam_like_scan_us", "RFS-SLAM, SC-PHD update (C++)", 7_700.0),
    ("gmphd_20_targets_step_us", "tracktor 0.4 (Rust)", 1_100.0),
    ("gmphd_20_targets_step_us", "Stone Soup 1.9 (Python)", 279_000.0),
];

/// The step `bench`.
pub fn step(options: &Options) -> Result<Outcome, Stop> {
    let criterion = process::own_target_dir("criterion");
    let mut bench = process::cargo();
    bench.env("CRITERION_HOME", &criterion);
    process::run(bench.args(["bench", "--quiet", "--package", PACKAGE, "--bench", "time"]))?;
    let out = process::root().join("out/bench");
    process::run(program().arg("growth").arg(&criterion).arg(&out))?;
    let times = Times::read(&out.join("times.csv"))?;
    let mut figures = vec![
        Figure::new("rfs_slam_like_scan_us", times.of("scan", "rfs_slam_like")?, "us"),
        Figure::new("gmphd_20_targets_step_us", times.of("scan", "gmphd_20_targets")?, "us"),
        Figure::new("map_growth_ratio", times.ratio("map", "10000", "100")?, "1"),
        Figure::new("measurement_growth_ratio", times.ratio("measurements", "200", "20")?, "1"),
    ];
    let sessions = process::capture_for(program().arg("sessions"), LIMIT)?;
    figures.extend(serde_json::from_slice::<Vec<Figure>>(&sessions).map_err(|error| error.to_string())?);

    println!("\ntime of a scan; growth.svg and growth.png in {} show the curves\n{}", out.display(), times.table());
    println!("\nothers:\n{}", peers(&figures));
    println!("\nfigures:\n{}", table(&figures));
    options.write(&figures)?;
    let is_missing = |name: &&str| figures.iter().all(|figure| figure.name != *name);
    let left_out: Vec<&str> = OF_A_LOG.into_iter().filter(is_missing).collect();
    let note = if left_out.is_empty() { String::new() } else { format!("; NOT MEASURED: {}", left_out.join(", ")) };
    Ok(Outcome::Passed(format!("{} figures{note}", figures.len())))
}

/// The program of whole runs and plots.
fn program() -> std::process::Command {
    let mut cargo = process::cargo();
    cargo.args(["run", "--quiet", "--release", "--package", "scphd-tests", "--example", "scphd-bench", "--"]);
    cargo
}

/// Mean time of a scan for every group and case, µs.
struct Times(Vec<(String, String, f64)>);

impl Times {
    /// Reads a file of `group,id,scan_us`.
    fn read(path: &Path) -> Result<Self, String> {
        let text = files::text(path)?;
        let row = |line: &str| {
            let mut words = line.split(',');
            let (group, id) = (words.next()?, words.next()?);
            Some((group.to_owned(), id.to_owned(), words.next()?.parse().ok()?))
        };
        let rows = text.lines().skip(1).map(|line| row(line).ok_or_else(|| format!("{}: {line}", path.display())));
        rows.collect::<Result<_, _>>().map(Self)
    }

    fn of(&self, group: &str, id: &str) -> Result<f64, String> {
        let found = self.0.iter().find(|row| row.0 == group && row.1 == id);
        found.map(|row| row.2).ok_or_else(|| format!("no time of {group} {id}"))
    }

    fn ratio(&self, group: &str, more: &str, less: &str) -> Result<f64, String> {
        Ok(self.of(group, more)? / self.of(group, less)?)
    }

    /// A table with a row for each group.
    fn table(&self) -> Table {
        let mut rows: Vec<Vec<String>> = Vec::new();
        for (group, id, time_us) in &self.0 {
            let point = format!("{id}: {time_us:.0}");
            match rows.last_mut() {
                Some(row) if row[0] == *group => row.push(point),
                _ => rows.push(vec![group.clone(), point]),
            }
        }
        let columns = rows.iter().map(Vec::len).max().unwrap_or(1);
        let mut table = Table::new();
        let header = ["cases, scan in us"].into_iter().map(String::from).chain((1..columns).map(|_| String::new()));
        table.load_style(ASCII_MARKDOWN).set_header(header);
        for row in rows {
            table.add_row(row);
        }
        table
    }
}

fn peers(figures: &[Figure]) -> Table {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN).set_header(["figure", "here, us", "who", "takes, us", "times"]);
    for (name, who, takes_us) in PEERS {
        if let Some(figure) = figures.iter().find(|figure| figure.name == name) {
            let (here, ratio) = (format!("{:.1}", figure.value), format!("{:.0}", takes_us / figure.value));
            table.add_row([name.to_owned(), here, who.to_owned(), format!("{takes_us:.0}"), ratio]);
        }
    }
    table
}

fn table(figures: &[Figure]) -> Table {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN).set_header(["figure", "value", "unit"]);
    for Figure { name, value, unit } in figures {
        let text = match value.abs() {
            1000.0.. => format!("{value:.0}"),
            0.001.. => format!("{value:.3}"),
            _ => format!("{value:.1e}"),
        };
        table.add_row([name.clone(), text, unit.clone()]);
    }
    if let Some(column) = table.column_mut(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
