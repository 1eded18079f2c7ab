//! The files of a recording: one file, or those of a folder of `ros2 bag record`.

use crate::import::ImportError;
use scphd_ros::{ReadError, Reader, Record, unpacked};
use std::cmp::Ordering;
use std::fs::{self, File};
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

/// The description in a folder of `ros2 bag record`.
const METADATA: &str = "metadata.yaml";
/// First bytes of recordings in other formats than MCAP, and the names of the formats.
const STRANGERS: [(&[u8], &str); 3] = [
    (b"SQLite format 3\0", "a recording in SQLite (.db3)"),
    (b"#ROSBAG V", "a recording of ROS 1 (.bag)"),
    (b"\x1f\x8b", "a file compressed by gzip"),
];

/// Whether a folder contains a recording of ROS 2.
pub fn is_bag(dir: &Path) -> bool {
    dir.join(METADATA).is_file() || names(dir).is_ok_and(|names| names.iter().any(|name| is_recording(name)))
}

fn is_recording(name: &str) -> bool {
    [".mcap", ".mcap.zstd", ".mcap.zst", ".mcap.lz4", ".db3", ".db3.zstd"].iter().any(|end| name.ends_with(end))
}

fn names(dir: &Path) -> std::io::Result<Vec<String>> {
    let entries = fs::read_dir(dir)?.collect::<Result<Vec<_>, _>>()?;
    Ok(entries.iter().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect())
}

/// The files in order: as listed in `metadata.yaml`, or by the numbers in their names if a recorder lost power before it wrote
/// the list.
pub(super) fn of(source: &Path) -> Result<Vec<PathBuf>, ImportError> {
    if !source.is_dir() {
        return Ok(vec![source.to_path_buf()]);
    }
    let metadata = source.join(METADATA);
    let mut listed = Vec::new();
    if metadata.is_file() {
        let text = fs::read_to_string(&metadata).map_err(|error| ImportError::io(&metadata, error))?;
        listed = files_in(&text);
    }
    if listed.is_empty() {
        listed = names(source).map_err(|error| ImportError::io(source, error))?;
        listed.retain(|name| is_recording(name));
        listed.sort_by(|a, b| by_numbers(a, b));
    }
    let place = |name: &String| {
        // Old recorders wrote the name of the folder in front.
        let alone = Path::new(name).file_name().map_or_else(|| source.join(name), |name| source.join(name));
        if source.join(name).is_file() { source.join(name) } else { alone }
    };
    let files: Vec<PathBuf> = listed.iter().map(place).collect();
    if let Some(missing) = files.iter().find(|file| !file.is_file()) {
        let what = format!("{METADATA} lists it, but it is not there");
        return Err(ImportError::at(missing.display(), what));
    }
    Ok(files)
}

/// The list `relative_file_paths` of a `metadata.yaml`.
fn files_in(text: &str) -> Vec<String> {
    let after = text.lines().skip_while(|line| line.trim() != "relative_file_paths:").skip(1);
    let items = after.map_while(|line| line.trim().strip_prefix('-'));
    items.map(|name| name.trim().trim_matches(['"', '\'']).to_owned()).collect()
}

/// Compares names by their numbers: `x_10` is after `x_9`.
fn by_numbers(a: &str, b: &str) -> Ordering {
    let key = |text: &str| {
        let mut parts: Vec<(u64, String)> = Vec::new();
        for c in text.chars() {
            match (c.to_digit(10), parts.last_mut()) {
                (Some(digit), Some((number, rest))) if rest.is_empty() => {
                    *number = number.saturating_mul(10).saturating_add(digit.into());
                }
                (Some(digit), _) => parts.push((digit.into(), String::new())),
                (None, Some((_, rest))) => rest.push(c),
                (None, None) => parts.push((0, c.to_string())),
            }
        }
        parts
    };
    key(a).cmp(&key(b)).then_with(|| a.cmp(b))
}

type Source = Box<dyn Read>;

/// Passes on every record of the files. Returns the error that ended the reading, if any.
pub(super) fn each(
    files: &[PathBuf],
    mut show: impl FnMut(&Reader<Source>, Record),
) -> Result<Vec<(PathBuf, ReadError)>, ImportError> {
    let mut torn = Vec::new();
    for path in files {
        let io = |error| ImportError::io(path, error);
        let mut head = Vec::new();
        File::open(path).map_err(io)?.take(16).read_to_end(&mut head).map_err(io)?;
        if let Some((_, what)) = STRANGERS.iter().find(|(begin, _)| head.starts_with(begin)) {
            let advice = "rosbags-convert --src SOURCE --dst FOLDER --dst-storage mcap (pip install rosbags) makes MCAP of \
                          recordings of SQLite and ROS 1, gunzip unpacks what is compressed by gzip";
            return Err(ImportError::at(path.display(), format_args!("{what}, which is not read here: {advice}")));
        }
        let file = BufReader::new(File::open(path).map_err(io)?);
        let mut reader = Reader::new(unpacked(file).map_err(io)?);
        loop {
            match reader.next() {
                Ok(Some(record)) => show(&reader, record),
                Ok(None) => break,
                Err(error) => {
                    torn.push((path.clone(), error));
                    break;
                }
            }
        }
    }
    Ok(torn)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_in_the_listed_order_or_else_by_their_numbers() {
        let text = "rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n    - b_1.mcap\n    - \"b_0.mcap\"\n  duration:\n    - 3\n";
        assert_eq!(files_in(text), ["b_1.mcap", "b_0.mcap"]);
        assert!(files_in("no list").is_empty());
        let mut names = ["bag_10.mcap", "bag_2.mcap", "bag_1.mcap"];
        names.sort_by(|a, b| by_numbers(a, b));
        assert_eq!(names, ["bag_1.mcap", "bag_2.mcap", "bag_10.mcap"]);
    }
}
