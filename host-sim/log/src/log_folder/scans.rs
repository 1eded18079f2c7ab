//! Scans and their detections, for any sensor.

use super::error::{LogError, Place, Problem};
use super::table::{Row, Table};
use super::units::{self, SCAN_INTERVAL_S, Stamp};
use std::path::Path;

/// Checks that times do not decrease from row to row. Equal times are valid.
pub(super) struct Clock(f64);

impl Clock {
    /// Before the first row.
    pub(super) fn new() -> Self {
        Self(f64::NEG_INFINITY)
    }

    pub(super) fn tick(&mut self, row: &Row, t_s: f64) -> Result<f64, LogError> {
        if t_s < self.0 {
            return Err(row.cell("t_s").error(Problem::Backwards { before: self.0, after: t_s }));
        }
        self.0 = t_s;
        Ok(t_s)
    }
}

pub(super) fn scan_times(table: &Table) -> Result<(Vec<i64>, Vec<Stamp>), LogError> {
    let (scan, time) = (table.column("scan")?, table.column("t_s")?);
    let mut clock = Clock::new();
    let (mut numbers, mut stamps): (Vec<i64>, Vec<Stamp>) = (Vec::new(), Vec::new());
    for row in table.rows() {
        let number = row.integer(&scan)?;
        let least = numbers.last().map_or(0, |last| i128::from(*last) + 1);
        if i128::from(number) < least {
            return Err(row.cell("scan").error(Problem::ScanOrder { found: number, least }));
        }
        numbers.push(number);
        let t_s = clock.tick(&row, row.number(&time)?)?;
        stamps.push(Stamp { place: row.cell("t_s"), t_s });
    }
    if numbers.is_empty() {
        return Err(Place::File("scans.csv").error(Problem::NoScans));
    }
    units::interval(&stamps, SCAN_INTERVAL_S)?;
    Ok((numbers, stamps))
}

/// Calls `add` for every detection with the index of the scan, the numbers in `columns` and the label, if there is one.
pub(super) fn each_detection<const N: usize>(
    dir: &Path,
    numbers: &[i64],
    columns: [&'static str; N],
    mut add: impl FnMut(usize, &Row, [f64; N], Option<i64>) -> Result<(), LogError>,
) -> Result<(), LogError> {
    let table = Table::read(dir, "detections.csv")?;
    let scan = table.column("scan")?;
    let columns = columns.into_iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
    let label = match table.column_if_any("label_landmark")? {
        None => table.column_if_any("label_subject")?,
        found => found,
    };
    let mut current = 0;
    for row in table.rows() {
        let number = row.integer(&scan)?;
        let Ok(index) = numbers.binary_search(&number) else {
            return Err(row.cell("scan").error(Problem::NoSuchScan(number)));
        };
        if index < current {
            let least = i128::from(numbers[current]);
            return Err(row.cell("scan").error(Problem::ScanOrder { found: number, least }));
        }
        current = index;
        let mut measured = [0.0; N];
        for (number, column) in measured.iter_mut().zip(&columns) {
            *number = row.single(column)?;
        }
        let label = label.as_ref().map(|label| row.integer(label)).transpose()?;
        add(index, &row, measured, label)?;
    }
    Ok(())
}
