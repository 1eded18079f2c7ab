//! The vehicle's transition density, as a trait.

use super::ModelError;
use crate::{Linear, Noise, Pose, Real, ScalarOf, Symmetric, TangentOf, Vector};

/// How the vehicle moves: the transition density π(x_k | x_{k−1}, u_k) of (4.47).
///
/// An implementation must be a pure function of its arguments:
/// the same pose, control, time step and random numbers must give the same bits. A pose that it returns and that is not finite, or a
/// transition or noise that is not, is taken for the pose as it was, and counted as rejected.
pub trait Motion {
    /// The vehicle state.
    type Pose: Pose;
    /// The control input u, such as odometry.
    type Control: Copy;

    /// Whether a step is the same from wherever it begins: x and y change by as much at the origin as at any other place, by
    /// [`propagate`](Self::propagate) and by [`sample`](Self::sample), and so does [`linearise`](Self::linearise). With `true` steps that are short beside
    /// the spacing of the numbers that say where the vehicle is, far from the origin or at a high rate, add up without loss; the speed is
    /// what [`rates`](Self::rates) say. Not for a motion that knows places, such as a current.
    const TRANSLATION_INVARIANT: bool = false;

    /// The parameter that the model cannot work with, if any: asked wherever a filter is made with the model, or goes on with it.
    ///
    /// # Errors
    /// Names the parameter and its range. None unless the model says otherwise.
    fn check(&self) -> Result<(), ModelError> {
        Ok(())
    }

    /// Whether the model can work with this control: every number finite and inside the model's domain.
    fn admits(&self, control: &Self::Control) -> bool;

    /// How fast the vehicle goes and turns under this control, to be held against the limits of
    /// [`Plausible`](crate::Plausible). Of a control that says nothing of speeds [`Rates::NONE`]: then only the length of a step is
    /// limited.
    fn rates(&self, control: &Self::Control) -> Rates<ScalarOf<Self::Pose>>;

    /// The pose after `dt` seconds without noise, f(x, u).
    fn propagate(&self, pose: &Self::Pose, control: &Self::Control, dt: ScalarOf<Self::Pose>) -> Self::Pose;

    /// A draw from the transition density (5.12).
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

/// How fast a control says that the vehicle goes and turns, neither below zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates<T> {
    /// Speed, m/s.
    pub speed_mps: T,
    /// Turn rate, rad/s.
    pub turn_radps: T,
}

impl<T: Real> Rates<T> {
    /// Those of a control that says nothing of speeds.
    pub const NONE: Self = Self { speed_mps: T::ZERO, turn_radps: T::ZERO };
}
