//! Limits of the motion of a vehicle: input beyond them is refused as invalid.

use crate::{ConfigError, Implausible, Motion, Pose, PredictError, Rates, Real};

/// Limits of the motion in a prediction. A prediction beyond them is refused: a single invalid odometry sample, even if finite,
/// would move all particles so far that no scan could correct them.
///
/// The defaults are beyond the abilities of any vehicle with a sensor, and detect damaged bytes and wrong units. The limits of the
/// actual vehicle, with some margin, detect more. Infinite: no limit.
///
/// ```
/// use scphd::settings::Plausible;
/// use scphd::Config;
///
/// // A rover of at most 2 m/s.
/// let plausible = Plausible { speed_max_mps: 4.0_f32, ..Plausible::default() };
/// assert!(Config { plausible, ..Config::default() }.check().is_ok());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Plausible<T> {
    /// Longest time step, s. 300 by default: the longest gap in the odometry of published logs is 128 s, and a time in milliseconds
    /// that is read as seconds is a thousand times too long.
    pub step_max_s: T,
    /// Greatest speed, m/s. 340 by default, the speed of sound.
    pub speed_max_mps: T,
    /// Greatest turn rate, rad/s. 70 by default: vehicle gyroscopes measure at most this (4000 °/s).
    pub turn_rate_max_radps: T,
    /// Greatest distance that the vehicle moves in one step, m, computed from the poses. 100 km by default: 300 s at the greatest
    /// speed. It limits models whose [speed](Motion::rates) is unknown, and poses or depths that are part of a control.
    pub jump_max_m: T,
}

impl<T: Real> Default for Plausible<T> {
    fn default() -> Self {
        Self {
            step_max_s: T::from_f64(300.0),
            speed_max_mps: T::from_f64(340.0),
            turn_rate_max_radps: T::from_f64(70.0),
            jump_max_m: T::from_f64(1e5),
        }
    }
}

impl<T: Real> Plausible<T> {
    /// No limits: everything finite is plausible.
    pub const ANYTHING: Self = Self {
        step_max_s: T::INFINITY,
        speed_max_mps: T::INFINITY,
        turn_rate_max_radps: T::INFINITY,
        jump_max_m: T::INFINITY,
    };

    /// Checks all limits.
    ///
    /// # Errors
    /// Every limit must be positive.
    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        let limits = [
            (self.step_max_s, "plausible.step_max_s"),
            (self.speed_max_mps, "plausible.speed_max_mps"),
            (self.turn_rate_max_radps, "plausible.turn_rate_max_radps"),
            (self.jump_max_m, "plausible.jump_max_m"),
        ];
        match limits.into_iter().find(|&(limit, _)| !(limit > T::ZERO)) {
            Some((_, field)) => Err(ConfigError { field, range: "positive" }),
            None => Ok(()),
        }
    }

    /// Whether the time step is valid. Then the time counts as elapsed for moving features, even if the control is refused.
    pub(crate) fn takes_time(&self, dt: T) -> bool {
        dt >= T::ZERO && dt.is_finite() && dt <= self.step_max_s
    }

    /// The reason for which a prediction is refused, if any. Without a pose, a valid control is not implausible.
    pub(crate) fn refusal<M: Motion<Pose: Pose<Scalar = T>>>(
        &self,
        motion: &M,
        pose: Option<&M::Pose>,
        control: &M::Control,
        dt: T,
    ) -> Option<PredictError> {
        if !(dt >= T::ZERO && dt.is_finite()) {
            return Some(PredictError::TimeStep);
        }
        if !motion.admits(control) {
            return Some(PredictError::Control);
        }
        pose.and_then(|pose| self.violated(motion, pose, control, dt)).map(PredictError::Implausible)
    }

    /// The limit that a step from `pose` exceeds, if any. NaN exceeds every limit.
    fn violated<M: Motion<Pose: Pose<Scalar = T>>>(
        &self,
        motion: &M,
        pose: &M::Pose,
        control: &M::Control,
        dt: T,
    ) -> Option<Implausible> {
        if !(dt <= self.step_max_s) {
            return Some(Implausible::Step);
        }
        let Rates { speed_mps, turn_radps } = motion.rates(control);
        if !(speed_mps <= self.speed_max_mps) {
            return Some(Implausible::Speed);
        }
        if !(turn_radps <= self.turn_rate_max_radps) {
            return Some(Implausible::TurnRate);
        }
        let jump = motion.propagate(pose, control, dt).distance_m(pose);
        // A predicted pose that is not finite is reported for each candidate.
        (jump > self.jump_max_m).then_some(Implausible::Jump)
    }
}
