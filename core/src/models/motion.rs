//! The vehicle's transition density, as a trait.

use super::ModelError;
use crate::{Linear, Noise, Pose, Real, ScalarOf, Symmetric, TangentOf, Vector};

/// The motion model: the transition density π(x_k | x_{k−1}, u_k) of (4.47).
///
/// An implementation must be a pure function of its arguments: the same pose, control, time step and random numbers must give the
/// same bits. If it returns a pose, transition or noise that is not finite, the pose is unchanged and counted as rejected.
pub trait Motion {
    /// The vehicle state.
    type Pose: Pose;
    /// The control input u, such as odometry.
    type Control: Copy;

    /// Whether a step does not depend on the position: [`propagate`](Self::propagate), [`sample`](Self::sample) and
    /// [`linearise`](Self::linearise) give the same changes of x and y at the origin and at any other position. With `true`, steps
    /// that are shorter than the resolution of the coordinates (far from the origin, or at a high rate) are accumulated without
    /// loss, with the speed from [`rates`](Self::rates). `false` for a motion that depends on the position, for example with a map
    /// of currents.
    const TRANSLATION_INVARIANT: bool = false;

    /// Checks the parameters of the model. It is called when a filter is constructed with the model or gets it as a replacement.
    ///
    /// # Errors
    /// Names the first parameter out of range, and its range. No errors by default.
    fn check(&self) -> Result<(), ModelError> {
        Ok(())
    }

    /// Whether the control is valid: every number finite and inside the domain of the model.
    fn admits(&self, control: &Self::Control) -> bool;

    /// Speed and turn rate of the vehicle under this control, for comparison with the limits of [`Plausible`](crate::Plausible).
    /// [`Rates::NONE`] if the control has no speeds: then only the length of a step is limited.
    fn rates(&self, control: &Self::Control) -> Rates<ScalarOf<Self::Pose>>;

    /// The pose after `dt` seconds without noise, f(x, u).
    fn propagate(&self, pose: &Self::Pose, control: &Self::Control, dt: ScalarOf<Self::Pose>) -> Self::Pose;

    /// Draws from the transition density (5.12).
    fn sample(
        &self,
        pose: &Self::Pose,
        control: &Self::Control,
        dt: ScalarOf<Self::Pose>,
        noise: &mut Noise,
    ) -> Self::Pose;

    /// The transition density linearised at the noise-free motion.
    fn linearise(
        &self,
        pose: &Self::Pose,
        control: &Self::Control,
        dt: ScalarOf<Self::Pose>,
    ) -> Linearised<TangentOf<Self::Pose>>;
}

/// A linearised transition: x_k ≈ f(x_{k−1}, u) + F (x_{k−1} − x̄) + w, w ~ N(0, Q).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linearised<K: Vector> {
    /// F = ∂f/∂x.
    pub transition: Linear<K, K>,
    /// Q = (∂f/∂u) Σ_u (∂f/∂u)ᵀ.
    pub noise: Symmetric<K>,
}

/// Speed and turn rate under a control, both not negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates<T> {
    /// Speed, m/s.
    pub speed_mps: T,
    /// Turn rate, rad/s.
    pub turn_radps: T,
}

impl<T: Real> Rates<T> {
    /// The rates of a control that has no speeds.
    pub const NONE: Self = Self { speed_mps: T::ZERO, turn_radps: T::ZERO };
}
