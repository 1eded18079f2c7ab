//! A drive with faults of sensor and odometry: the boards must have the states of the host, and no scan may exceed the worst
//! case.

use super::board::FIRST;
use super::output::{self, Replay, all_equal};
use super::rig::{FEW, JOINT, JOINT_MOVERS, PLANAR, Precision, Rig, SMALL, SMALL_JOINT};
use super::streams::{self, Source};
use super::{emulator, image};
use crate::budget;

/// Number of scans of `faults`: all.
const SCANS: usize = 501;

/// Warnings of too little memory: pruning tightened, map not updated, components lost.
const WANT_OF_ROOM: u16 = 0b1_1100;

/// The filters for the drive, and the configurations whose worst cases are their limits.
const TAKEN: [(Rig, &str); 6] = [
    (PLANAR, "32x2-f32"),
    (FEW, "4x1-informed-f32"),
    (JOINT, "1x1-joint-f32"),
    (JOINT_MOVERS, "1x1-joint-movers-f32"),
    // With less memory a scan must not exceed the worst case with all of it.
    (SMALL, "32x2-f32"),
    (SMALL_JOINT, "1x1-joint-f32"),
];

/// Returns the number of compared scans, or the failures.
pub fn check() -> Result<usize, String> {
    let (mut compared, mut failures) = (0, Vec::new());
    for (rig, configuration) in TAKEN {
        let source = Source { what: "faults", scans: SCANS, rig };
        let stream = streams::make(source, Precision::F32)?;
        let host = streams::on_host(&stream, rig, Precision::F32)?;
        if host.scans.len() != SCANS {
            return Err(format!("{} of {SCANS} scans of {}", host.scans.len(), stream.display()));
        }
        let mut images = Vec::new();
        for board in rig.boards {
            images.push((board, image::build_replay(board, rig, Precision::F32)?));
        }
        for (board, replay) in emulator::replay(&images, &stream)? {
            let (name, worst) = (format!("faults{} on {board}", rig.mark), replay.worst_scan());
            failures.extend(host.first_difference(&replay).map(|difference| format!("{name}: {difference}")));
            // The worst case is measured on one board.
            if board == FIRST.name {
                let why = budget::beyond_worst_case(board, configuration, worst)?;
                failures.extend(why.map(|why| name.clone() + &why));
            }
            compared += replay.scans.len();
            println!("{name}: {} scans compared, the longest of {worst} instructions", replay.scans.len());
        }
        let short = short_of_room(&host);
        println!("faults{}: {short} scans tell that there is too little room", rig.mark);
        if [SMALL, SMALL_JOINT].contains(&rig) && short == 0 {
            failures.push(format!("no scan of faults{} tells that there is too little room", rig.mark));
        }
    }
    all_equal(compared, &failures)
}

/// Number of scans with a warning of too little memory.
fn short_of_room(replay: &Replay) -> usize {
    let health = replay.scans.iter().filter_map(|scan| output::word(&scan.state, "health"));
    health.filter_map(|bits| u16::from_str_radix(bits, 16).ok()).filter(|bits| bits & WANT_OF_ROOM != 0).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::firmware::output::Scan;

    #[test]
    fn too_little_memory_is_reported_by_three_bits() {
        let scan = |health: &str| Scan { state: format!("1 in_view 2 health {health} digest 0a"), ..Scan::default() };
        let scans = ["0000", "4080", "0010", "400c", "0004"].map(scan).to_vec();
        assert_eq!(short_of_room(&Replay { scans, ..Replay::default() }), 3);
    }
}
