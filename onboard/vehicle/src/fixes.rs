//! Fixes, and the monitors of rejected fixes.

use crate::Description;
use nalgebra::{Vector1, Vector2};
use scphd::fixes::{FixReport, FixRule, HeadingWatch, PositionWatch};
use scphd::models::{HeadingFix, ModelError, PlanarPose, PositionFix};
use scphd::{PoseEstimate, Real};

/// Result of a fix with a monitor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Watched<T> {
    /// The report of the filter.
    pub report: FixReport<T>,
    /// Whether the monitor has relocated the vehicle to the pose by the fixes.
    pub relocated: bool,
}

/// A type of fixes: its model, the rule of its monitor, the monitor once it is needed, and the time since the last fix, s.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Kind<F, W, T> {
    fix: F,
    rule: Option<FixRule<T>>,
    watch: Option<W>,
    since_s: T,
}

/// Models and monitors of a vehicle's fixes, with the time since the last fix of each type.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fixes<T: Real> {
    position: Option<Kind<PositionFix<T>, PositionWatch<T>, T>>,
    heading: Option<Kind<HeadingFix<PlanarPose<T>>, HeadingWatch<T>, T>>,
}

impl<T: Real> Fixes<T> {
    /// No fixes.
    pub const NONE: Self = Self { position: None, heading: None };

    /// The fixes of a description.
    ///
    /// # Errors
    /// A number is out of range.
    pub fn of(description: &Description<T>) -> Result<Self, ModelError> {
        let position = description.position.map(|spec| {
            let [forward_m, left_m] = spec.antenna_m;
            let fix = PositionFix::new(spec.sigma)?;
            let fix = if spec.antenna_m == [T::ZERO; 2] { fix } else { fix.mounted(forward_m, left_m)? };
            let fix = if spec.gate < T::INFINITY { fix.gated(spec.gate)? } else { fix };
            Ok(Kind { fix, rule: spec.watch, watch: None, since_s: T::ZERO })
        });
        let heading = description.heading.map(|spec| {
            let fix = HeadingFix::new(spec.sigma)?;
            let fix = if spec.gate < T::INFINITY { fix.gated(spec.gate)? } else { fix };
            Ok(Kind { fix, rule: spec.watch, watch: None, since_s: T::ZERO })
        });
        Ok(Self { position: position.transpose()?, heading: heading.transpose()? })
    }

    /// Adds a time to those since the last fixes, s.
    pub(crate) fn wait(&mut self, dt_s: T) {
        if dt_s >= T::ZERO && dt_s.is_finite() {
            self.position.iter_mut().for_each(|kind| kind.since_s += dt_s);
            self.heading.iter_mut().for_each(|kind| kind.since_s += dt_s);
        }
    }

    /// The model of the positions, and whether they have a monitor.
    pub(crate) fn position(&self) -> Option<(PositionFix<T>, bool)> {
        self.position.map(|kind| (kind.fix, kind.rule.is_some()))
    }

    /// The model of the headings, and whether they have a monitor.
    pub(crate) fn heading(&self) -> Option<(HeadingFix<PlanarPose<T>>, bool)> {
        self.heading.map(|kind| (kind.fix, kind.rule.is_some()))
    }

    /// Passes a position to its monitor. Returns the pose for a relocation if the filter has diverged.
    pub(crate) fn saw_position(
        &mut self,
        measured: &Vector2<T>,
        accepted: bool,
        estimate: &PoseEstimate<PlanarPose<T>>,
    ) -> Option<PoseEstimate<PlanarPose<T>>> {
        let Kind { fix, rule, watch, since_s } = self.position.as_mut()?;
        let since_s = core::mem::replace(since_s, T::ZERO);
        let watch = watch.get_or_insert(PositionWatch::new((*rule)?).ok()?);
        if accepted {
            watch.accepted();
            return None;
        }
        watch.refused(fix, measured, estimate, since_s)
    }

    /// The same for a heading.
    pub(crate) fn saw_heading(
        &mut self,
        measured: &Vector1<T>,
        accepted: bool,
        estimate: &PoseEstimate<PlanarPose<T>>,
    ) -> Option<PoseEstimate<PlanarPose<T>>> {
        let Kind { fix, rule, watch, since_s } = self.heading.as_mut()?;
        let since_s = core::mem::replace(since_s, T::ZERO);
        let watch = watch.get_or_insert(HeadingWatch::new((*rule)?).ok()?);
        if accepted {
            watch.accepted();
            return None;
        }
        watch.refused(fix, measured, estimate, since_s)
    }
}
