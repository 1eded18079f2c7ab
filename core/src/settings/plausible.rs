//! What no vehicle does: input beyond it is taken for garbage.

use crate::{ConfigError, Implausible, Motion, Pose, PredictError, Rates, Real};

/// What a vehicle can do. A prediction beyond it is refused: one garbage row of odometry, finite as it may be, would take all
/// particles where no scan brings them back from.
///
/// The defaults are beyond what any vehicle with a sensor does, and stop what comes of a damaged byte or a wrong unit. A
/// vehicle's own limits, with some room, stop more. Infinite: no limit.
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
    /// Longest step, s. 300 by default: the longest gap in the odometry of published logs is 128 s, and a time that has been
    /// read in milliseconds is a thousand times too long.
    pub step_max_s: T,
    /// Greatest speed, m/s. 340 by default, that of sound.
    pub speed_max_mps: T,
    /// Greatest turn rate, rad/s. 70 by default: gyroscopes of vehicles end there or below (4000 °/s).
    pub turn_rate_max_radps: T,
    /// Greatest distance that a step takes the vehicle, m, whatever the model makes of the control. 100 km by default: 300 s
    /// at the greatest speed. It bounds models that do not know their [speed](Motion::rates), and poses or depths that a control
    /// carries.
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
    /// Everything finite is plausible.
    pub const ANYTHING: Self = Self {
        step_max_s: T::INFINITY,
        speed_max_mps: T::INFINITY,
        turn_rate_max_radps: T::INFINITY,
        jump_max_m: T::INFINITY,
    };

    /// The limit that is out of range, if any.
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

    /// Whether a step takes a time that a vehicle can have moved for, whatever the control says: what moves has moved on then.
    pub(crate) fn takes_time(&self, dt: T) -> bool {
        dt >= T::ZERO && dt.is_finite() && dt <= self.step_max_s
    }

    /// Why a prediction is refused, if it is; where there is no pose yet, nothing is implausible.
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

    /// What is implausible of a step from `pose`, if anything. NaN is.
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
        // A pose beyond the range of the scalar is told of candidate by candidate.
        (jump > self.jump_max_m).then_some(Implausible::Jump)
    }
}
