//! Steps that are shorter than the resolution of the position in floating-point numbers.
//!
//! At 5 km from the origin the resolution of single precision is half a millimetre. A vehicle at 0.04 m/s with odometry at 200 Hz
//! moves by less than half of that in a step, which rounding always removes: the estimate stands still. With a slightly higher
//! speed it moves too far or not far enough, because equal steps are rounded equally. Such a step is therefore computed at the
//! origin, with all its digits, and the rounding error of the sum is stored and added to the next step (compensated summation:
//! Kahan 1965).

use crate::{Linearised, Motion, Pose, Real, ScalarOf, TangentOf, Vector, Zero};

/// Steps of fewer spacings of floating-point numbers than this are short. The rounding error of a longer step is below 1/250 of it.
const SPACINGS: f64 = 128.0;

/// Distance from the origin beyond which steps with this control are short, m. Infinite for a vehicle that stands, or whose motion
/// depends on its position.
pub(crate) fn short_beyond<T: Real, M: Motion<Pose: Pose<Scalar = T>>>(motion: &M, control: &M::Control, dt: T) -> T {
    if !M::TRANSLATION_INVARIANT || M::Pose::HEADING.is_none() {
        return T::INFINITY;
    }
    let step = motion.rates(control).speed_mps * dt;
    if step > T::ZERO { step / (T::EPSILON * T::from_f64(SPACINGS)) } else { T::INFINITY }
}

/// Whether steps are short at this pose.
#[inline]
pub(crate) fn is_short<T: Real, P: Pose<Scalar = T>>(pose: &P, short_beyond: T) -> bool {
    let [x, y, _] = pose.on_ground();
    x.abs() > short_beyond || y.abs() > short_beyond
}

/// The pose after a short step without noise, and the motion linearised there.
#[cold]
#[inline(never)]
pub(crate) fn propagated<M: Motion>(
    motion: &M,
    pose: &M::Pose,
    remainder: &mut [ScalarOf<M::Pose>; 2],
    control: &M::Control,
    dt: ScalarOf<M::Pose>,
) -> (M::Pose, Linearised<TangentOf<M::Pose>>) {
    let near = at_origin(pose);
    let (moved, left) = summed(pose, *remainder, &motion.propagate(&near, control, dt));
    *remainder = left;
    (moved, motion.linearise(&near, control, dt))
}

/// The pose moved to the origin.
pub(crate) fn at_origin<T: Real, P: Pose<Scalar = T>>(pose: &P) -> P {
    let [x, y, _] = pose.on_ground();
    pose.displaced(&on_ground::<P>([-x, -y]))
}

/// Adds a `step`, computed at the origin, and the rounding errors of x and y so far to the pose. Returns the sum and its rounding
/// errors.
pub(crate) fn summed<T: Real, P: Pose<Scalar = T>>(pose: &P, [of_x, of_y]: [T; 2], step: &P) -> (P, [T; 2]) {
    let [x, y, _] = pose.on_ground();
    let short = step.displaced(&on_ground::<P>([held(of_x, x), held(of_y, y)]));
    let moved = short.displaced(&on_ground::<P>([x, y]));
    let ([dx, dy, _], [to_x, to_y, _]) = (short.on_ground(), moved.on_ground());
    (moved, [rounded_off(x, dx, to_x), rounded_off(y, dy, to_y)])
}

/// A difference of poses in x and y, which are the first coordinates of every pose with a heading.
fn on_ground<P: Pose>(by: [P::Scalar; 2]) -> TangentOf<P> {
    Vector::with(|k| by.get(k).copied().unwrap_or(P::Scalar::ZERO))
}

/// The rounding error if it can be one of a coordinate near `at`, otherwise zero: the pose was set since, or a bit has flipped.
fn held<T: Real>(remainder: T, at: T) -> T {
    if remainder.abs() <= T::EPSILON * at.abs() { remainder } else { T::ZERO }
}

/// The rounding error of `sum` = a + b, exactly (Knuth's two-sum).
fn rounded_off<T: Real>(a: T, b: T, sum: T) -> T {
    let of_b = sum - a;
    (a - (sum - of_b)) + (b - of_b)
}

#[cfg(test)]
mod tests {
    use super::{is_short, short_beyond, summed};
    use crate::{ControlNoise, KnownPose, PlanarPose, Pose, Step, Unicycle, UnicycleControl};

    /// For pairs of numbers up to those whose smaller one is rounded away.
    #[test]
    fn sum_and_rounding_error_are_exact() {
        for (at, by) in
            [(5000.0_f32, 2e-4_f32), (-5000.0, 0.3), (32_768.0, -1.9e-3), (0.1, 7.0), (1e8, 4.0), (0.0, 0.0)]
        {
            let (pose, step) = (PlanarPose::new(at, -at, 0.3), PlanarPose::new(by, by, 0.4));
            let (moved, [x, y]) = summed(&pose, [0.0; 2], &step);
            let wide = |number: f32| f64::from(number);
            assert_eq!(wide(moved.x_m) + wide(x), wide(at) + wide(by), "{at} and {by}");
            assert_eq!(wide(moved.y_m) + wide(y), wide(by) - wide(at), "{at} and {by}");
            assert_eq!(moved.heading_rad, 0.4);
        }
    }

    #[test]
    fn impossible_rounding_errors_are_ignored() {
        let pose = PlanarPose::new(5000.0_f32, 0.0, 0.0);
        for remainder in [[f32::NAN; 2], [f32::INFINITY; 2], [1e-3, 1e-9]] {
            let (moved, _) = summed(&pose, remainder, &PlanarPose::new(0.25, 0.25, 0.0));
            assert_eq!(moved, PlanarPose::new(5000.25, 0.25, 0.0), "{remainder:?}");
        }
    }

    /// A vehicle that stands, and one whose pose is given by the control.
    #[test]
    fn steps_of_unknown_length_are_not_short() {
        let far = PlanarPose::new(1e7_f32, 0.0, 0.0);
        let known = short_beyond(&KnownPose::new(), &far, 0.1);
        let robot = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
        let [stands, moves] =
            [0.0, 0.04].map(|speed_mps| short_beyond(&robot, &UnicycleControl { speed_mps, rate_radps: 0.0 }, 0.005));
        assert!(!is_short(&far, known) && !is_short(&far, stands));
        assert!(is_short(&far, moves) && !is_short(&PlanarPose::<f32>::ZERO, moves));
    }
}
