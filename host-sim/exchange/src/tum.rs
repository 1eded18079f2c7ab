//! Trajectories as text, a row a pose: `timestamp tx ty tz qx qy qz qw`, in seconds and metres, the orientation as a unit
//! quaternion.
//!
//! Both files have rows at the times of scans, so that other tools pair the same rows as the scores here. In the plane z is 0,
//! and the rotation is about the vertical.

use scphd_log::dimensions::{Coordinates, Dimensions};
use scphd_ros::messages::Quaternion;
use scphd_score::record::ScanRecord;
use scphd_score::results::{OutputError, sink};
use std::fmt::Write;
use std::path::{Path, PathBuf};

const HEAD: &str = "# timestamp tx ty tz qx qy qz qw\n";

/// Writes `estimate.tum`, and `truth.tum` with the scans whose true position is known, into the existing folder `dir`; only the
/// first without truth. Returns their paths.
pub fn write<D: Dimensions>(dir: &Path, scans: &[ScanRecord<D>]) -> Result<Vec<PathBuf>, OutputError> {
    let scans = last_of_each_time(scans);
    let estimate = scans.iter().map(|scan| (scan.t_s, D::position(&scan.pose), Some(D::heading(&scan.pose))));
    let mut paths = vec![dir.join("estimate.tum")];
    save(&paths[0], &text(estimate))?;
    let truth = scans.iter().filter_map(|scan| Some((scan.t_s, scan.true_position?, scan.true_heading_rad)));
    let truth = text(truth);
    if truth != HEAD {
        paths.push(dir.join("truth.tum"));
        save(&paths[1], &truth)?;
    }
    Ok(paths)
}

fn save(path: &Path, text: &str) -> Result<(), OutputError> {
    sink::write(path, text.as_bytes()).map_err(|source| OutputError::Io { path: path.into(), source })
}

/// Programs identify a pose by its time: of several scans at one time the last is kept, which has most information.
fn last_of_each_time<D: Dimensions>(scans: &[ScanRecord<D>]) -> Vec<&ScanRecord<D>> {
    let next = scans.iter().skip(1).map(|scan| Some(scan.t_s)).chain([None]);
    scans.iter().zip(next).filter(|(scan, next)| Some(scan.t_s) != *next).map(|(scan, _)| scan).collect()
}

/// A table of poses. An unknown heading is written as 0.
fn text<P: Coordinates>(rows: impl Iterator<Item = (f64, P, Option<f64>)>) -> String {
    let mut text = HEAD.to_owned();
    for (t_s, position, heading_rad) in rows {
        let at = |k: usize| position.as_ref().get(k).copied().unwrap_or(0.0);
        let Quaternion { x, y, z, w } = Quaternion::of_yaw(heading_rad.unwrap_or(0.0));
        // The shortest digits that parse to the same number; writing to a string cannot fail.
        let _ = writeln!(text, "{t_s:?} {:?} {:?} {:?} {x:?} {y:?} {z:?} {w:?}", at(0), at(1), at(2));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_shared_data::Folder;

    #[test]
    fn rows_are_poses_at_the_times_of_scans() {
        let folder = Folder::new("tum");
        let known = ScanRecord { true_position: Some([4.0, 5.0]), ..ScanRecord::at(0.5, [1.0, 0.1 + 0.2, 0.0]) };
        let again = ScanRecord { true_heading_rad: Some(std::f64::consts::PI), ..known.clone() };
        let unknown = ScanRecord::at(0.25, [0.0, -1.0, 0.0]);
        write(&folder.0, &[unknown.clone(), known, again]).unwrap();
        let read = |name: &str| std::fs::read_to_string(folder.0.join(name)).unwrap();
        assert_eq!(
            read("estimate.tum"),
            format!("{HEAD}0.25 0.0 -1.0 0.0 0.0 0.0 0.0 1.0\n0.5 1.0 0.30000000000000004 0.0 0.0 0.0 0.0 1.0\n")
        );
        assert_eq!(read("truth.tum"), format!("{HEAD}0.5 4.0 5.0 0.0 0.0 0.0 1.0 6.123233995736766e-17\n"));
    }

    #[test]
    fn without_a_truth_there_is_no_file_of_it() {
        let folder = Folder::new("tum-alone");
        write(&folder.0, &[ScanRecord::at(0.25, [0.0; 3])]).unwrap();
        assert_eq!(folder.names(), ["estimate.tum"]);
    }
}
