//! Fixes that a filter refuses: left out, until they are taken for right and the filter for wrong.

use super::contract::{Refusal, Slam, refusal};
use crate::dimensions::{Dimensions, Planar, Underwater};
use crate::log::{FixNoise, PoseFix};
use nalgebra::{Vector1, Vector2};
use scphd::{HeadingFix, HeadingWatch, PlanarPose, PoseEstimate, PositionFix, PositionWatch, Symmetric};
use std::convert::Infallible;

/// What became of a fix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Taken {
    /// It lay within its gate.
    In,
    /// It was left out.
    LeftOut,
    /// It was left out as several before it; they agree with each other, and the filter was put where they say.
    Relocated,
}

/// Shows fixes to a filter, and watches those that it refuses.
pub trait WatchesFixes<D: Dimensions> {
    /// So much time has passed, s.
    fn wait(&mut self, dt_s: f64);

    /// Shows a fix.
    ///
    /// # Errors
    /// The filter refused it, and says why.
    fn show(&mut self, slam: &mut dyn Slam<D>, fix: &D::Fix) -> Result<Taken, Refusal>;
}

/// One kind of fixes: how it is modelled, the watch over it, and the time since the last, s.
#[derive(Debug)]
struct Watched<F, W> {
    fix: F,
    watch: W,
    elapsed_s: f64,
}

/// Of a vehicle in the plane.
#[derive(Debug)]
pub(crate) struct PlanarWatch {
    position: Option<Watched<PositionFix<f64>, PositionWatch<f64>>>,
    heading: Option<Watched<HeadingFix<PlanarPose<f64>>, HeadingWatch<f64>>>,
}

impl PlanarWatch {
    /// Over fixes of this noise.
    pub(crate) fn of(noise: &FixNoise) -> Result<Self, Refusal> {
        let position = |sigma_m| {
            let fix = PositionFix::new(sigma_m)?.mounted(noise.forward_m, noise.left_m)?;
            Ok(Watched { fix, watch: PositionWatch::new(noise.rule())?, elapsed_s: 0.0 })
        };
        let heading = |sigma_rad| {
            Ok(Watched { fix: HeadingFix::new(sigma_rad)?, watch: HeadingWatch::new(noise.rule())?, elapsed_s: 0.0 })
        };
        let wrong = |error: scphd::ModelError| refusal(error);
        Ok(Self {
            position: noise.position_sigma_m.map(position).transpose().map_err(wrong)?,
            heading: noise.heading_sigma_rad.map(heading).transpose().map_err(wrong)?,
        })
    }
}

impl WatchesFixes<Planar> for PlanarWatch {
    fn wait(&mut self, dt_s: f64) {
        self.position.iter_mut().for_each(|watched| watched.elapsed_s += dt_s);
        self.heading.iter_mut().for_each(|watched| watched.elapsed_s += dt_s);
    }

    fn show(&mut self, slam: &mut dyn Slam, fix: &PoseFix) -> Result<Taken, Refusal> {
        let is_in = slam.observe(fix)?;
        let estimate = if is_in { None } else { Some(estimate(slam)?) };
        let back = match fix {
            PoseFix::Position(place) => self.position.as_mut().and_then(|Watched { fix, watch, elapsed_s }| {
                let elapsed_s = std::mem::take(elapsed_s);
                let Some(estimate) = estimate else {
                    watch.accepted();
                    return None;
                };
                watch.refused(fix, &Vector2::from(*place), &estimate, elapsed_s)
            }),
            PoseFix::Heading(heading) => self.heading.as_mut().and_then(|Watched { fix, watch, elapsed_s }| {
                let elapsed_s = std::mem::take(elapsed_s);
                let Some(estimate) = estimate else {
                    watch.accepted();
                    return None;
                };
                watch.refused(fix, &Vector1::new(*heading), &estimate, elapsed_s)
            }),
        };
        let Some(PoseEstimate { mean, covariance }) = back else {
            return Ok(if is_in { Taken::In } else { Taken::LeftOut });
        };
        let covariance = std::array::from_fn(|row| std::array::from_fn(|column| covariance.get(row, column)));
        slam.relocate(&[mean.x_m, mean.y_m, mean.heading_rad], &covariance)?;
        Ok(Taken::Relocated)
    }
}

/// Of a vehicle whose logs have no fixes.
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
