//! A CSV file whose cells have their places, for errors.

use super::error::{LogError, Place, Problem};
use crate::lines::Lines;
use csv::{ErrorKind, ReaderBuilder, StringRecord, Trim};
use std::fs;
use std::io::ErrorKind::NotFound;
use std::path::Path;

pub(super) struct Table {
    file: &'static str,
    header: StringRecord,
    rows: Vec<(u64, StringRecord)>,
}

pub(super) struct Column {
    name: &'static str,
    index: usize,
}

pub(super) struct Row<'a> {
    file: &'static str,
    line: u64,
    fields: &'a StringRecord,
}

/// The text of a file without its byte order mark; `None` if it does not exist. A file without text is an error.
pub(super) fn text(dir: &Path, file: &'static str) -> Result<Option<String>, LogError> {
    match fs::read(dir.join(file)) {
        Ok(bytes) => match String::from_utf8(bytes) {
            Ok(text) => {
                let text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
                if text.trim().is_empty() { Err(Place::File(file).error(Problem::Empty)) } else { Ok(Some(text)) }
            }
            Err(_) => Err(Place::File(file).error(Problem::NotText)),
        },
        Err(error) if error.kind() == NotFound => Ok(None),
        Err(error) => Err(Place::File(file).error(Problem::Unreadable(error))),
    }
}

impl Table {
    pub(super) fn read(dir: &Path, file: &'static str) -> Result<Self, LogError> {
        Self::read_optional(dir, file)?.ok_or_else(|| Place::File(file).error(Problem::Missing))
    }

    pub(super) fn read_optional(dir: &Path, file: &'static str) -> Result<Option<Self>, LogError> {
        let Some(text) = text(dir, file)? else {
            return Ok(None);
        };
        let mut reader = ReaderBuilder::new().trim(Trim::All).from_reader(text.as_bytes());
        let fail = |error: csv::Error| match error.kind() {
            ErrorKind::UnequalLengths { pos: Some(pos), expected_len, len } => {
                let problem = Problem::Fields { found: *len, expected: *expected_len };
                Place::Row(file, Lines::of(&text, None).at(pos.byte())).error(problem)
            }
            _ => Place::File(file).error(Problem::Syntax(error.to_string())),
        };
        let header = reader.headers().map_err(fail)?.clone();
        let (mut rows, mut lines) = (Vec::new(), Lines::of(&text, None));
        for record in reader.records() {
            let record = record.map_err(fail)?;
            let line = record.position().map_or(0, |position| lines.at(position.byte()));
            rows.push((line, record));
        }
        Ok(Some(Self { file, header, rows }))
    }

    pub(super) fn column(&self, name: &'static str) -> Result<Column, LogError> {
        let missing = || Place::Cell(self.file, 1, name).error(Problem::Missing);
        self.column_if_any(name)?.ok_or_else(missing)
    }

    pub(super) fn column_if_any(&self, name: &'static str) -> Result<Option<Column>, LogError> {
        let mut found = self.header.iter().enumerate().filter(|(_, title)| *title == name);
        let column = found.next().map(|(index, _)| Column { name, index });
        if found.next().is_some() {
            return Err(Place::Cell(self.file, 1, name).error(Problem::Twice));
        }
        Ok(column)
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|(line, fields)| Row { file: self.file, line: *line, fields })
    }
}

impl Row<'_> {
    pub(super) fn cell(&self, column: &'static str) -> Place {
        Place::Cell(self.file, self.line, column)
    }

    pub(super) fn number(&self, column: &Column) -> Result<f64, LogError> {
        let text = &self.fields[column.index];
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.cell(column.name).error(Problem::NotFinite(text.to_owned()))),
        }
    }

    /// A number within the range of single precision, which filters may use.
    pub(super) fn single(&self, column: &Column) -> Result<f64, LogError> {
        let number = self.number(column)?;
        let holds = (number as f32).is_finite();
        if holds { Ok(number) } else { Err(self.cell(column.name).error(Problem::TooLarge(number))) }
    }

    /// A finite number; `None` for an empty cell.
    pub(super) fn number_if_any(&self, column: &Column) -> Result<Option<f64>, LogError> {
        if self.fields[column.index].is_empty() { Ok(None) } else { self.number(column).map(Some) }
    }

    pub(super) fn text(&self, column: &Column) -> &str {
        &self.fields[column.index]
    }

    pub(super) fn integer(&self, column: &Column) -> Result<i64, LogError> {
        let text = &self.fields[column.index];
        text.parse().map_err(|_| self.cell(column.name).error(Problem::NotWhole(text.to_owned())))
    }
}
