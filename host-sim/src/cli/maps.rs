//! Maps that are passed from one drive to the next.

use super::failure::{Failure, notice};
use super::outputs::{check_file, write_file};
use scphd_filters::slam::Search;
use scphd_run::session::{MapOutcome, MapUse};
use std::fs;
use std::path::PathBuf;

#[derive(Debug)]
pub struct Maps {
    pub map: Option<PathBuf>,
    pub locate: bool,
    pub save: Option<PathBuf>,
}

impl Maps {
    /// Reads the initial map. Checks that the final one can be written.
    pub fn read(&self) -> Result<Option<Vec<u8>>, Failure> {
        if let Some(path) = &self.save {
            check_file("--save-map", path)?;
        }
        let read = |path: &PathBuf| {
            fs::read(path).map_err(|error| Failure::input(format_args!("--map {}: {error}", path.display())))
        };
        self.map.as_ref().map(read).transpose()
    }

    /// The options for a session.
    pub fn to_use<'m>(&self, file: Option<&'m [u8]>, last_error_alone: bool) -> MapUse<'m> {
        MapUse { file, locate: self.locate, save: self.save.is_some(), last_error_alone }
    }

    /// Writes the final map if requested.
    pub fn write(&self, outcome: &MapOutcome) -> Result<(), Failure> {
        let (Some(path), Some(file)) = (&self.save, &outcome.file) else { return Ok(()) };
        write_file("--save-map", path, file)?;
        notice(format_args!("the map is in {}: {} bytes", path.display(), file.len()));
        Ok(())
    }
}

/// The result of the localisation as text.
pub fn told(search: &Search) -> String {
    let scans = search.scans;
    let Some(place) = &search.found else {
        return format!("not found in {scans} scans: somewhere else with probability {:.4}", search.elsewhere);
    };
    let [x, y, heading] = place.pose;
    format!(
        "found after {scans} scans: x {x:.2} m, y {y:.2} m, heading {:.1}°, with probability {:.4}, by {} landmarks of the map",
        heading.to_degrees(),
        place.probability,
        place.matched
    )
}
