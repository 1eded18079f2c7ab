//! One bit that flips, and what becomes of it.

use super::slam::{Refused, Slam};
use super::world::{Drive, Passage};
use crate::{Health, Noise, Scrubber};
use core::f64::consts::TAU;
use std::vec::Vec;

/// Scans after which the error must be back.
pub(crate) const SCANS: usize = 50;
/// Times the usual error that it may be then.
const TIMES: f64 = 3.0;

/// How a vehicle guards its filter's memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Guard {
    /// It scrubs so many parts after every scan, and goes back to its snapshot where that cannot mend, or a step is refused.
    Scrub(usize),
    /// And compares seals before every step.
    ScrubAndSeal(usize),
}

/// What became of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum End {
    /// The seal was broken, and the snapshot of the step before was taken.
    Sealed,
    /// Scrubbing could not mend it, or a step was refused: the snapshot was taken, and the odometry since.
    Restored,
    /// Scrubbing has mended it.
    Mended,
    /// It made no difference that lasts.
    Harmless,
    /// The error is not back, but the vehicle has been told that something is wrong.
    Told,
    /// The error is not back, and nobody knows.
    Silent,
}

impl End {
    pub(crate) const ALL: [Self; 6] =
        [Self::Sealed, Self::Restored, Self::Mended, Self::Harmless, Self::Told, Self::Silent];
}

/// Somewhere on a drive.
pub(crate) struct Start<'d> {
    pub(crate) drive: &'d Drive,
    /// Scans done.
    pub(crate) at: usize,
    pub(crate) snapshot: Vec<u8>,
    /// Conditions that a drive without faults has from here on.
    usual: Health,
    /// Errors after the last scan, m and rad, and features where there is nothing.
    pub(crate) errors: [f64; 2],
    false_features: usize,
}

/// One trial, as it is told.
pub(crate) struct Told {
    pub(crate) end: End,
    pub(crate) what: &'static str,
    pub(crate) bit: usize,
    /// m and rad.
    pub(crate) errors: [f64; 2],
    /// More features where there is nothing than without the fault.
    pub(crate) false_features: usize,
    /// Whether scrubbing, the seal or a refused step has found it.
    pub(crate) found: bool,
}

/// How wrong the estimate is, m and rad.
pub(crate) fn errors(slam: &impl Slam, passage: &Passage) -> [f64; 2] {
    let ([x, y, heading], truth) = (slam.pose(), passage.truth);
    let turn = heading - truth[2];
    [(x - truth[0]).hypot(y - truth[1]), (turn - TAU * (turn / TAU).round()).abs()]
}

/// Extracted features farther than a metre from every landmark.
fn false_features(slam: &mut impl Slam, drive: &Drive) -> usize {
    let is_false = |[x, y]: &[f64; 2]| !drive.landmarks.iter().any(|at| (at[0] - x).hypot(at[1] - y) < 1.0);
    slam.map().iter().filter(|feature| is_false(feature)).count()
}

impl<'d> Start<'d> {
    /// Goes on from where the filter is, without a fault.
    pub(crate) fn here(slam: &mut impl Slam, drive: &'d Drive, at: usize, parts: usize) -> Self {
        let snapshot = slam.save();
        let (mut usual, mut scrubber) = (Health::GOOD, Scrubber::new());
        for passage in &drive.passages[at..at + SCANS] {
            usual |= slam.predict(passage).unwrap() | slam.scan(passage).unwrap();
            let scrubbed = slam.scrub(&mut scrubber, parts).unwrap();
            assert!(scrubbed.is_clean(), "of what is sound nothing is mended: {scrubbed:?}");
        }
        let errors = errors(slam, &drive.passages[at + SCANS - 1]);
        let false_features = false_features(slam, drive);
        slam.restore(&snapshot);
        Self { drive, at, snapshot, usual, errors, false_features }
    }

    /// Flips a bit here, and drives on. `normal` are the usual errors.
    pub(crate) fn flip(&self, slam: &mut impl Slam, guard: Guard, draws: &mut Noise, normal: [f64; 2]) -> Told {
        slam.restore(&self.snapshot);
        let passages = &self.drive.passages[self.at..self.at + SCANS];
        let moved = draws.uniform::<f32>() < 0.5;
        if moved {
            slam.predict(&passages[0]).unwrap();
        }
        let seal = slam.seal();
        let (what, bit) = slam.flip(draws);
        let (mut found, mut told, mut restored) = (None, Health::GOOD, false);
        let mut scrubber = Scrubber::new();
        if matches!(guard, Guard::ScrubAndSeal(_)) && slam.seal() != seal {
            slam.restore(&self.snapshot);
            if moved {
                slam.predict(&passages[0]).unwrap();
            }
            assert_eq!(slam.seal(), seal);
            found = Some(End::Sealed);
        }
        for (scan, passage) in passages.iter().enumerate() {
            let mut step = || -> Result<Health, Refused> {
                let predicted = if scan == 0 && moved { Health::GOOD } else { slam.predict(passage)? };
                Ok(predicted | slam.scan(passage)?)
            };
            let mut done = step();
            if let (Ok(_), Guard::Scrub(parts) | Guard::ScrubAndSeal(parts)) = (&done, guard) {
                match slam.scrub(&mut scrubber, parts) {
                    Ok(scrubbed) if scrubbed.is_clean() => (),
                    Ok(_) => found = found.or(Some(End::Mended)),
                    Err(_) => done = Err(Refused),
                }
            }
            match done {
                Ok(health) => told |= health,
                // Once is enough: what is restored is sound.
                Err(Refused) if !restored => {
                    (found, restored) = (Some(End::Restored), true);
                    slam.restore(&self.snapshot);
                    passages[..=scan].iter().for_each(|passage| _ = slam.predict(passage));
                }
                Err(Refused) => found = found.or(Some(End::Told)),
            }
        }
        let errors = errors(slam, &passages[SCANS - 1]);
        let back = (0..2).all(|k| errors[k] <= TIMES * normal[k]);
        let alarm = told.bits() & !self.usual.bits() != 0;
        let end = match found {
            Some(End::Told) | None if back => End::Harmless,
            None if alarm => End::Told,
            None => End::Silent,
            Some(found) if back => found,
            Some(_) => End::Told,
        };
        let false_features = false_features(slam, self.drive).saturating_sub(self.false_features);
        Told { end, what, bit, errors, false_features, found: found.is_some() }
    }
}
