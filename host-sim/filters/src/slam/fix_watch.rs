//! Monitor of fixes that a filter refuses: they are left out until they show that the filter is wrong.

use super::contract::{Refusal, Slam, refusal};
use super::fixes::PlanarFixes;
use nalgebra::{Vector1, Vector2};
use scphd::PoseEstimate;
use scphd::fixes::{HeadingWatch, PositionWatch};
use scphd::models::{Fix, HeadingFix, PlanarPose, PositionFix};
use scphd::numerics::Symmetric;
use scphd_log::dimensions::{Dimensions, Planar, Underwater};
use scphd_log::log::{FixNoise, PoseFix};
use std::convert::Infallible;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Taken {
    /// It was within its gate.
    In,
    LeftOut,
    /// It was left out like several before it; they are consistent with each other, and the filter was relocated to them.
    Relocated,
}

/// Passes fixes to a filter, and monitors those that it refuses.
pub trait WatchesFixes<D: Dimensions> {
    /// Adds elapsed time, s.
    fn wait(&mut self, dt_s: f64);

    fn show(&mut self, slam: &mut dyn Slam<D>, fix: &D::Fix) -> Result<Taken, Refusal>;
}

/// A type of fixes: its model, its monitor, and the time since the last, s.
#[derive(Debug)]
struct Watched<F, W> {
    fix: F,
    watch: W,
    elapsed_s: f64,
}

/// Distance between accepted fixes, in standard deviations, from which they confirm the frame of the filter. Over a shorter
/// distance, fixes may also be within the gate of a filter with a wrong initial heading.
const TOLD_SIGMAS: f64 = 30.0;

/// The monitor for a vehicle in the plane.
#[derive(Debug)]
pub(crate) struct PlanarWatch {
    /// The first accepted position, m, and the greatest distance of another one from it, in standard deviations.
    taken_in: Option<[f64; 2]>,
    told_sigmas: f64,
    position: Option<Watched<PositionFix<f64>, PositionWatch<f64>>>,
    heading: Option<Watched<HeadingFix<PlanarPose<f64>>, HeadingWatch<f64>>>,
}

impl PlanarWatch {
    /// Creates the monitor for fixes with this noise.
    pub(crate) fn of(noise: &FixNoise) -> Result<Self, Refusal> {
        let PlanarFixes { position, heading } = PlanarFixes::of(noise)?;
        let of_position = PositionWatch::new(noise.rule()).map_err(refusal)?;
        let of_heading = HeadingWatch::new(noise.rule()).map_err(refusal)?;
        Ok(Self {
            taken_in: None,
            told_sigmas: 0.0,
            position: position.map(|fix| Watched { fix, watch: of_position, elapsed_s: 0.0 }),
            heading: heading.map(|fix| Watched { fix, watch: of_heading, elapsed_s: 0.0 }),
        })
    }

    fn accepted(&mut self, fix: &PoseFix) {
        match fix {
            PoseFix::Position(place) => {
                let first = *self.taken_in.get_or_insert(*place);
                self.position.iter_mut().for_each(|watched| {
                    let apart = Vector2::from(*place) - Vector2::from(first);
                    let sigmas = (apart.norm_squared() / watched.fix.noise().get(0, 0)).sqrt();
                    self.told_sigmas = self.told_sigmas.max(sigmas);
                    watched.watch.accepted();
                    watched.elapsed_s = 0.0;
                });
            }
            PoseFix::Heading(_) => self.heading.iter_mut().for_each(|watched| {
                watched.watch.accepted();
                watched.elapsed_s = 0.0;
            }),
        }
    }
}

impl WatchesFixes<Planar> for PlanarWatch {
    fn wait(&mut self, dt_s: f64) {
        self.position.iter_mut().for_each(|watched| watched.elapsed_s += dt_s);
        self.heading.iter_mut().for_each(|watched| watched.elapsed_s += dt_s);
    }

    fn show(&mut self, slam: &mut dyn Slam, fix: &PoseFix) -> Result<Taken, Refusal> {
        if slam.observe(fix)? {
            self.accepted(fix);
            return Ok(Taken::In);
        }
        let estimate = estimate(slam)?;
        let back = match fix {
            PoseFix::Position(place) => self.position.as_mut().and_then(|Watched { fix, watch, elapsed_s }| {
                watch.refused(fix, &Vector2::from(*place), &estimate, std::mem::take(elapsed_s))
            }),
            PoseFix::Heading(heading) => self.heading.as_mut().and_then(|Watched { fix, watch, elapsed_s }| {
                watch.refused(fix, &Vector1::new(*heading), &estimate, std::mem::take(elapsed_s))
            }),
        };
        let Some(PoseEstimate { mean, covariance }) = back else { return Ok(Taken::LeftOut) };
        let covariance = std::array::from_fn(|row| std::array::from_fn(|column| covariance.get(row, column)));
        let pose = [mean.x_m, mean.y_m, mean.heading_rad];
        if self.told_sigmas < TOLD_SIGMAS {
            // The fixes were never consistent with the filter: it started wrong, and its map is in a wrong frame.
            (self.taken_in, self.told_sigmas) = (None, 0.0);
            slam.restart(&pose, &covariance)?;
        } else {
            slam.relocate(&pose, &covariance)?;
        }
        Ok(Taken::Relocated)
    }
}

/// The monitor for a vehicle whose logs have no fixes.
#[derive(Debug)]
pub(crate) struct NoFixes;

impl WatchesFixes<Underwater> for NoFixes {
    fn wait(&mut self, _dt_s: f64) {}

    fn show(&mut self, _slam: &mut dyn Slam<Underwater>, fix: &Infallible) -> Result<Taken, Refusal> {
        match *fix {}
    }
}

fn estimate(slam: &mut dyn Slam) -> Result<PoseEstimate<PlanarPose<f64>>, Refusal> {
    let ([x_m, y_m, heading_rad], covariance) = slam.pose()?;
    let covariance = Symmetric::from_fn(|row, column| covariance[row][column]);
    Ok(PoseEstimate { mean: PlanarPose { x_m, y_m, heading_rad }, covariance })
}
