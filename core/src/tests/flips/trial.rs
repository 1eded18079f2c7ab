//! A trial: one bit flip and its effect.

use super::slam::{Refused, Slam};
use super::world::{Drive, Passage};
use crate::{Health, Noise, Scrubber};
use core::f64::consts::TAU;
use std::vec::Vec;

/// Number of scans after which the error must be normal again.
pub(crate) const SCANS: usize = 50;
/// Greatest normal error, as a multiple of the usual error.
const TIMES: f64 = 3.0;

/// Protection of the filter's memory by the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Guard {
    /// Scrubs this number of parts after every scan, and restores a snapshot if the damage cannot be repaired or a step is refused.
    Scrub(usize),
    /// Also compares seals before every step.
    ScrubAndSeal(usize),
}

/// The effect of the flip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum End {
    /// The seal differed, and the snapshot of the previous step was restored.
    Sealed,
    /// Scrubbing could not repair the damage, or a step was refused: the snapshot was restored, and the odometry since then
    /// repeated.
    Restored,
    /// Scrubbing repaired the damage.
    Mended,
    /// There was no lasting effect.
    Harmless,
    /// The error did not become normal, but the vehicle was warned.
    Told,
    /// The error did not become normal, without a warning.
    Silent,
}

impl End {
    pub(crate) const ALL: [Self; 6] =
        [Self::Sealed, Self::Restored, Self::Mended, Self::Harmless, Self::Told, Self::Silent];
}

/// A start point of trials on a drive.
pub(crate) struct Start<'d> {
    pub(crate) drive: &'d Drive,
    /// Number of scans before it.
    pub(crate) at: usize,
    pub(crate) snapshot: Vec<u8>,
    /// Warnings that occur from here on without a fault.
    usual: Health,
    /// Errors after the last scan without a fault, m and rad, and number of false features.
    pub(crate) errors: [f64; 2],
    false_features: usize,
}

/// The result of a trial.
pub(crate) struct Told {
    pub(crate) end: End,
    pub(crate) what: &'static str,
    pub(crate) bit: usize,
    /// Errors, m and rad.
    pub(crate) errors: [f64; 2],
    /// Number of false features more than without the fault.
    pub(crate) false_features: usize,
    /// Whether scrubbing, the seal or a refused step detected the fault.
    pub(crate) found: bool,
}

/// Errors of the estimated pose, m and rad.
pub(crate) fn errors(slam: &impl Slam, passage: &Passage) -> [f64; 2] {
    let ([x, y, heading], truth) = (slam.pose(), passage.truth);
    let turn = heading - truth[2];
    [(x - truth[0]).hypot(y - truth[1]), (turn - TAU * (turn / TAU).round()).abs()]
}

/// Number of extracted features farther than 1 m from every landmark.
fn false_features(slam: &mut impl Slam, drive: &Drive) -> usize {
    let is_false = |[x, y]: &[f64; 2]| !drive.landmarks.iter().any(|at| (at[0] - x).hypot(at[1] - y) < 1.0);
    slam.map().iter().filter(|feature| is_false(feature)).count()
}

impl<'d> Start<'d> {
    /// A start point at the present state; drives on from here without a fault.
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
                // Restoring once is sufficient: the restored state is valid.
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
