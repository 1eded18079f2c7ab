//! Execution of independent jobs, the weighting of candidates and the update of maps, on one core or several.

use crate::{LnSum, Real};

/// Executes independent jobs: in sequence ([`Serial`]), by a thread pool on the host, or by both cores of a microcontroller.
///
/// The result does not depend on the core or the order of a job: every executor gives the same state, to the last bit.
///
/// ```
/// use scphd::storage::Executor;
///
/// /// Two threads; on a microcontroller, two cores.
/// struct TwoCores;
///
/// impl Executor for TwoCores {
///     fn run<J: Send>(&self, jobs: impl Iterator<Item = J> + Send, work: impl Fn(J) + Sync) {
///         let (mut mine, mut other) = (Vec::new(), Vec::new());
///         for (index, job) in jobs.enumerate() {
///             if index % 2 == 0 { mine.push(job) } else { other.push(job) }
///         }
///         std::thread::scope(|scope| {
///             scope.spawn(|| other.into_iter().for_each(&work));
///             mine.into_iter().for_each(&work);
///         });
///     }
/// }
/// # use nalgebra::Vector2;
/// # use scphd::models::{ControlNoise, PlanarPose, RangeBearingWindow, Sensing, Step, Unicycle};
/// # use scphd::storage::{MapMemory, Static, UpdateMemory};
/// # use scphd::{Births, Config, Detector, DetectorMemory, ScPhd, State};
///
/// type Memory = State<PlanarPose<f32>, 16, 16, MapMemory<Static<Vector2<f32>>, 16, 64, 8, 128>>;
/// // The last parameter: the number of workers, each with working memory of its own.
/// let mut scratch = DetectorMemory::<Vector2<f32>, 32, 2>::new();
/// // Working memory for eight maps of such a state at a time: four for each worker.
/// let mut updates = Box::new(UpdateMemory::<Memory, 8>::new());
/// # let window = RangeBearingWindow::full_circle(15.0, 0.9)?;
/// # let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.02))?;
/// # let sensing = Sensing::range_bearing([0.2, 0.02], window, 2.0)?;
/// # let config = Config { particles: 16, ..Config::default() };
/// let mut lidar = Detector::new(sensing, Births::of_static(0.01))?.over(&mut scratch)?;
/// let mut state = Box::new(Memory::new());
/// let mut filter = ScPhd::new(motion, config, &mut *state)?;
/// filter.reset(PlanarPose::new(0.0, 0.0, 0.0), 1)?;
/// let measurements = [Vector2::new(5.0, 0.3)];
/// let report = filter.scan_on(&mut lidar, &measurements, &TwoCores, &mut updates.drafts(), &mut ())?;
/// assert_eq!(report.candidates, 16);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Executor {
    /// Calls `work` exactly once for every job, in any order and on any core, and returns when all calls have returned.
    ///
    /// If a job is left out, some moving features are not predicted, or some candidates keep the weight they had before the scan;
    /// if it is a map update, the calling core does it instead, and the state is the same.
    fn run<J: Send>(&self, jobs: impl Iterator<Item = J> + Send, work: impl Fn(J) + Sync);
}

/// Executes all jobs in sequence on the calling core.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Serial;

impl Executor for Serial {
    #[inline]
    fn run<J: Send>(&self, jobs: impl Iterator<Item = J> + Send, work: impl Fn(J) + Sync) {
        jobs.for_each(work);
    }
}

impl<X: Executor + ?Sized> Executor for &X {
    #[inline]
    fn run<J: Send>(&self, jobs: impl Iterator<Item = J> + Send, work: impl Fn(J) + Sync) {
        (**self).run(jobs, work);
    }
}

/// A job of the weighting: a part of the candidates, their ln L, and scratch.
#[derive(Debug)]
pub(crate) struct Share<'a, T> {
    /// Index of its first candidate.
    pub(crate) first: usize,
    /// ln L of its candidates.
    pub(crate) ln_likelihoods: &'a mut [T],
    /// Scratch with one element for each measurement.
    pub(crate) eta: &'a mut [LnSum<T>],
    /// |V|, the greatest number of components in view of its candidates.
    pub(crate) most_in_view: &'a mut u16,
}

/// Divides the candidates, given by their ln L, into one part for each worker. The number of workers is the length of
/// `most_in_view`; `eta` has scratch for all of them.
pub(crate) fn shares<'a, T: Real>(
    ln_likelihoods: &'a mut [T],
    eta: &'a mut [LnSum<T>],
    most_in_view: &'a mut [u16],
) -> impl Iterator<Item = Share<'a, T>> {
    let workers = most_in_view.len().max(1);
    let each = ln_likelihoods.len().div_ceil(workers).max(1);
    let scratch = (eta.len() / workers).max(1);
    let shares = ln_likelihoods.chunks_mut(each).zip(eta.chunks_mut(scratch)).zip(most_in_view).enumerate();
    shares.map(move |(index, ((ln_likelihoods, eta), most_in_view))| Share {
        first: index * each,
        ln_likelihoods,
        eta,
        most_in_view,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_candidate_is_in_exactly_one_share() {
        for (count, workers) in [(0, 1), (0, 3), (1, 4), (7, 3), (64, 5), (64, 1), (9, 9), (4, 3)] {
            let mut ln_likelihoods = std::vec![f32::NAN; count];
            let mut eta = std::vec![LnSum::ZERO; 6 * workers];
            let mut most_in_view = std::vec![0; workers];
            let all = shares(&mut ln_likelihoods, &mut eta, &mut most_in_view);
            Serial.run(all, |share| {
                assert_eq!(share.eta.len(), 6);
                for (offset, slot) in share.ln_likelihoods.iter_mut().enumerate() {
                    assert!(slot.is_nan());
                    *slot = (share.first + offset) as f32;
                }
            });
            assert!((0..count).all(|k| ln_likelihoods[k] == k as f32), "{count} by {workers}");
        }
    }
}
