//! Tables in text files: cells of rows, with the place of each for errors.

use super::ImportError;
use std::fs;
use std::path::Path;

/// Characters of a cell that an error shows, at most.
const SHOWN: usize = 40;

/// How a file is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Writing {
    /// What stands between cells; `None` for any white space.
    pub(super) delimiter: Option<u8>,
    /// Whether the first row names the columns.
    pub(super) header: bool,
}

/// A table.
#[derive(Debug)]
pub(super) struct Text {
    file: String,
    pub(super) header: Vec<String>,
    rows: Vec<(u64, Vec<String>)>,
}

/// A row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<'t> {
    text: &'t Text,
    line: u64,
    cells: &'t [String],
}

impl Text {
    /// Reads a file; lines that begin with `#`, and empty ones, do not count.
    pub(super) fn read(path: &Path, writing: Writing) -> Result<Self, ImportError> {
        let bytes = fs::read(path).map_err(|error| ImportError::io(path, error))?;
        let file = path.display().to_string();
        let content = String::from_utf8(bytes).map_err(|_| ImportError::at(&file, "not UTF-8 text"))?;
        let mut rows = match writing.delimiter {
            None => {
                let lines = content.lines().zip(1..);
                let lines = lines.filter(|(line, _)| !line.trim().is_empty() && !line.trim_start().starts_with('#'));
                lines.map(|(line, number)| (number, line.split_whitespace().map(str::to_owned).collect())).collect()
            }
            Some(delimiter) => delimited(&file, &content, delimiter)?,
        };
        let header = if writing.header && !rows.is_empty() { rows.remove(0).1 } else { Vec::new() };
        Ok(Self { file, header, rows })
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|(line, cells)| Row { text: self, line: *line, cells })
    }

    /// The place of a column by its name, or by its number from 0.
    pub(super) fn column(&self, name: &str) -> Result<usize, ImportError> {
        if let Some(place) = self.header.iter().position(|title| title == name) {
            return Ok(place);
        }
        if self.header.is_empty()
            && let Ok(place) = name.parse()
        {
            return Ok(place);
        }
        let titles = if self.header.is_empty() { "numbers from 0 on".to_owned() } else { self.header.join(", ") };
        Err(ImportError::at(&self.file, format_args!("no column '{name}'; there are {titles}")))
    }
}

fn delimited(file: &str, content: &str, delimiter: u8) -> Result<Vec<(u64, Vec<String>)>, ImportError> {
    let mut reader = csv::ReaderBuilder::new();
    reader.has_headers(false).delimiter(delimiter).comment(Some(b'#')).flexible(true).trim(csv::Trim::All);
    let rows = reader.from_reader(content.as_bytes()).into_records().map(|row| {
        let row = row.map_err(|error| ImportError::at(file, error))?;
        let line = row.position().map_or(0, csv::Position::line);
        Ok((line, row.iter().map(str::to_owned).collect()))
    });
    rows.collect()
}

impl Row<'_> {
    /// The number in a column.
    pub(super) fn number(&self, column: usize) -> Result<f64, ImportError> {
        let cell = self.cells.get(column).map_or("", String::as_str);
        let number = cell.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| {
            let shown: String = cell.chars().take(SHOWN).collect();
            self.error(column, format_args!("not a finite number: '{shown}'"))
        })
    }

    /// The number in a column, if there is anything.
    pub(super) fn number_if_any(&self, column: usize) -> Result<Option<f64>, ImportError> {
        match self.cells.get(column).map_or("", String::as_str) {
            "" => Ok(None),
            _ => self.number(column).map(Some),
        }
    }

    /// An error in this row.
    pub(super) fn error(&self, column: usize, what: impl std::fmt::Display) -> ImportError {
        let column = self.text.header.get(column).cloned().unwrap_or_else(|| column.to_string());
        ImportError::at(format_args!("{}, line {}, column {column}", self.text.file, self.line), what)
    }
}
