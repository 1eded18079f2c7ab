//! Tables in text files: cells of rows, each with its place for errors.

use super::ImportError;
use scphd_log::lines::Lines;
use std::cell::Cell;
use std::fs;
use std::path::Path;

/// Greatest number of characters of a cell in an error.
const SHOWN: usize = 40;

/// Format of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Writing {
    pub(super) delimiter: Delimiter,
    /// Whether the first row has the names of the columns.
    pub(super) header: bool,
}

/// The separator of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Delimiter {
    Byte(u8),
    /// Any white space.
    Space,
    /// A comma; or a semicolon or tab if the first line has one and no comma.
    Guessed,
}

#[derive(Debug)]
pub(super) struct Text {
    file: String,
    /// Whether numbers have decimal commas.
    decimal_commas: Cell<bool>,
    pub(super) header: Vec<String>,
    rows: Vec<(u64, Vec<String>)>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Row<'t> {
    text: &'t Text,
    line: u64,
    cells: &'t [String],
}

impl Text {
    /// Reads a file; lines that begin with `#`, and empty ones, are skipped.
    pub(super) fn read(path: &Path, writing: Writing) -> Result<Self, ImportError> {
        let bytes = fs::read(path).map_err(|error| ImportError::io(path, error))?;
        let file = path.display().to_string();
        let content = String::from_utf8(bytes).map_err(|_| ImportError::at(&file, "not UTF-8 text"))?;
        let content = content.strip_prefix('\u{feff}').unwrap_or(&content);
        let counts = |(line, _): &(&str, u64)| !line.trim().is_empty() && !line.trim_start().starts_with('#');
        let lines = || content.lines().zip(1..).filter(counts);
        let first = lines().next().map_or("", |(line, _)| line);
        let has = |byte: &u8| first.as_bytes().contains(byte);
        let mut rows = match writing.delimiter {
            Delimiter::Space => {
                lines().map(|(line, number)| (number, line.split_whitespace().map(str::to_owned).collect())).collect()
            }
            Delimiter::Byte(delimiter) => delimited(&file, content, delimiter)?,
            Delimiter::Guessed => {
                let delimiter = [b',', b';', b'\t'].into_iter().find(has).unwrap_or(b',');
                delimited(&file, content, delimiter)?
            }
        };
        let header = if writing.header && !rows.is_empty() { rows.remove(0).1 } else { Vec::new() };
        if let Some((line, cells)) = rows.iter().find(|(_, cells)| !header.is_empty() && cells.len() > header.len()) {
            let what = format!(
                "{} cells, the first line has {}: where commas stand in numbers, cells are parted by another character",
                cells.len(),
                header.len()
            );
            return Err(ImportError::at(format_args!("{file}, line {line}"), what));
        }
        Ok(Self { file, decimal_commas: Cell::new(false), header, rows })
    }

    /// Reports decimal commas.
    pub(super) fn tell(&self, told: &mut Vec<String>) {
        if self.decimal_commas.get() {
            told.push(format!("{}: numbers have decimal commas", self.file));
        }
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|(line, cells)| Row { text: self, line: *line, cells })
    }

    /// The index of a column by its name, or by its number from 0.
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

/// First byte of a comment line.
const COMMENT: Option<u8> = Some(b'#');

fn delimited(file: &str, content: &str, delimiter: u8) -> Result<Vec<(u64, Vec<String>)>, ImportError> {
    let mut reader = csv::ReaderBuilder::new();
    reader.has_headers(false).delimiter(delimiter).comment(COMMENT).flexible(true).trim(csv::Trim::All);
    let mut lines = Lines::of(content, COMMENT);
    let mut rows = Vec::new();
    for row in reader.from_reader(content.as_bytes()).into_records() {
        let row = row.map_err(|error| ImportError::at(file, error))?;
        let line = row.position().map_or(0, |position| lines.at(position.byte()));
        // A line with only delimiters, as spreadsheets write it, is empty.
        if row.iter().any(|cell| !cell.is_empty()) {
            rows.push((line, row.iter().map(str::to_owned).collect()));
        }
    }
    Ok(rows)
}

impl Row<'_> {
    pub(super) fn number(&self, column: usize) -> Result<f64, ImportError> {
        let cell = self.cells.get(column).map_or("", String::as_str);
        let parsed = cell.parse().or_else(|error| match cell.split_once(',') {
            // With a point beside it, one of the two would be a thousands separator.
            Some((whole, part)) if !whole.contains('.') && !part.contains(['.', ',']) => {
                self.text.decimal_commas.set(true);
                format!("{whole}.{part}").parse()
            }
            _ => Err(error),
        });
        let number = parsed.ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| {
            let shown: String = cell.chars().take(SHOWN).collect();
            self.error(column, format_args!("not a finite number: '{shown}'"))
        })
    }

    /// The number in a column, `None` if the cell is empty.
    pub(super) fn number_if_any(&self, column: usize) -> Result<Option<f64>, ImportError> {
        match self.cells.get(column).map_or("", String::as_str) {
            "" => Ok(None),
            _ => self.number(column).map(Some),
        }
    }

    pub(super) fn error(&self, column: usize, what: impl std::fmt::Display) -> ImportError {
        let column = self.text.header.get(column).cloned().unwrap_or_else(|| column.to_string());
        ImportError::at(format_args!("{}, line {}, column {column}", self.text.file, self.line), what)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<u64> {
        delimited("a.csv", text, b',').unwrap().into_iter().map(|(line, _)| line).collect()
    }

    #[test]
    fn line_numbers_are_those_of_an_editor() {
        for end in ["\n", "\r\n"] {
            let text =
                ["a,b", "1,2", "", "# a remark", "3,4", "# one more", "#", "5,6", ",", "\"7", "8\",9", "1,1"].join(end);
            assert_eq!(lines(&text), [1, 2, 5, 8, 10, 12], "{end:?}");
        }
    }

    #[test]
    fn delimiters_are_detected_and_decimal_commas_are_read() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a.csv");
        let read = |text: &str| {
            fs::write(&path, text).unwrap();
            let text = Text::read(&path, Writing { delimiter: Delimiter::Guessed, header: true })?;
            let column = text.column("v")?;
            let numbers = text.rows().map(|row| row.number(column)).collect::<Result<Vec<_>, _>>()?;
            let mut told = Vec::new();
            text.tell(&mut told);
            Ok::<_, ImportError>((numbers, told.len()))
        };
        assert_eq!(read("\u{feff}v;t\r\n1,5;0\r\n-0,25;0\r\n1e-3;1\r\n").unwrap(), (vec![1.5, -0.25, 1e-3], 1));
        assert_eq!(read("v\tt\n1,5\t0\n").unwrap(), (vec![1.5], 1));
        assert_eq!(read("t,v\n0,\"1,5\"\n").unwrap(), (vec![1.5], 1));
        assert_eq!(read("t,v\n0,1.5\n").unwrap(), (vec![1.5], 0));
        let error = read("t,v\n0,1,5\n").unwrap_err().to_string();
        assert!(error.contains("a.csv, line 2: 3 cells, the first line has 2: where commas"), "{error}");
        for thousands in ["1.234,5", "1,234.5", "1,2,3"] {
            assert!(read(&format!("v;t\n{thousands};0\n")).unwrap_err().to_string().contains("not a finite number"));
        }
    }
}
