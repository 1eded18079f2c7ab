//! Fixes: measurements of the pose itself.

use super::{AuvPose, ModelError, Mounted, Mounting, PlanarPose, Pose, Sensor, require};
use crate::{Linear, Matrix, PositionOf, Real, ScalarOf, Symmetric, TangentOf, Vector, Zero, wrap};
use nalgebra::{Matrix2x3, RowVector5, Vector1, Vector2};

/// A measurement of the vehicle's pose in the frame of the map: z = h(x) + v.
///
/// An implementation must be a pure function of its arguments, and take its transcendental functions from [`Real`].
pub trait Fix {
    /// The vehicle state.
    type Pose: Pose;
    /// The measurement.
    type Measurement: Vector<Scalar = ScalarOf<Self::Pose>>;

    /// Predicted measurement ẑ = h(x); `None` if there is none from this pose.
    fn expect(&self, pose: &Self::Pose) -> Option<Self::Measurement>;

    /// ∂h/∂x, in the coordinates of [`Pose::difference`].
    fn by_pose(&self, pose: &Self::Pose) -> Linear<Self::Measurement, TangentOf<Self::Pose>>;

    /// z ⊖ ẑ: the difference of two measurements, angles wrapped.
    fn innovation(&self, measured: &Self::Measurement, expected: &Self::Measurement) -> Self::Measurement;

    /// R, the covariance of the measurement noise.
    fn noise(&self) -> &Symmetric<Self::Measurement>;

    /// Gate: a squared Mahalanobis distance. A fix whose innovation is beyond it is rejected as an outlier. Infinite: no gate.
    fn gate(&self) -> ScalarOf<Self::Pose> {
        Real::INFINITY
    }
}

fn variance<T: Real>(sigma: T, field: &'static str) -> Result<T, ModelError> {
    require(sigma >= T::from_f64(1e-6) && sigma <= T::from_f64(1e6), field, "between 1e-6 and 1e6")?;
    Ok(sigma * sigma)
}

fn gate<T: Real>(gate: T) -> Result<T, ModelError> {
    require(gate > T::ZERO, "gate", "above 0")?;
    Ok(gate)
}

/// The noise and the gate of a fix with these fields.
macro_rules! noise_and_gate {
    () => {
        fn noise(&self) -> &Symmetric<Self::Measurement> {
            &self.noise
        }

        fn gate(&self) -> ScalarOf<Self::Pose> {
            self.gate
        }
    };
}

/// The position of an antenna in the plane (x, y m), for example from a satellite receiver, transformed to the map frame.
///
/// ```
/// use scphd::models::{Fix, PlanarPose, PositionFix};
/// use nalgebra::Vector2;
///
/// // 0.5 m, the antenna half a metre behind the axle.
/// let gps = PositionFix::new(0.5)?.mounted(-0.5, 0.0)?;
/// let expected = gps.expect(&PlanarPose::new(3.0, 4.0, 0.0)).unwrap();
/// assert_eq!(expected, Vector2::new(2.5, 4.0));
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionFix<T: Real> {
    noise: Symmetric<Vector2<T>>,
    antenna: Option<Mounting<T>>,
    gate: T,
}

impl<T: Real> PositionFix<T> {
    /// A fix with the same standard deviation of the noise, m, along both axes; the antenna is at the origin of the vehicle.
    ///
    /// # Errors
    /// The noise must lie between 1e-6 and 1e6 m.
    pub fn new(sigma_m: T) -> Result<Self, ModelError> {
        let variance = variance(sigma_m, "sigma_m")?;
        Ok(Self { noise: Symmetric::from_diagonal([variance; 2]), antenna: None, gate: T::INFINITY })
    }

    /// This fix with a lever arm: the antenna is this far ahead and to the left of the vehicle's origin, m.
    ///
    /// # Errors
    /// As for [`Mounting::in_plane`].
    pub fn mounted(self, forward_m: T, left_m: T) -> Result<Self, ModelError> {
        Ok(Self { antenna: Some(Mounting::in_plane(forward_m, left_m, T::ZERO)?), ..self })
    }

    /// This fix with a gate: a squared Mahalanobis distance beyond which a fix is rejected as an outlier. For filters with a
    /// consistent covariance: a [`ScPhd`](crate::ScPhd) loses its initial uncertainty within about ten scans, so that the gate then
    /// rejects correct fixes.
    ///
    /// # Errors
    /// It must be above 0.
    pub fn gated(self, distance: T) -> Result<Self, ModelError> {
        Ok(Self { gate: gate(distance)?, ..self })
    }

    fn seat(&self, pose: &PlanarPose<T>) -> PlanarPose<T> {
        self.antenna.map_or(*pose, |antenna| pose.mounted(&antenna).0)
    }
}

impl<T: Real> Fix for PositionFix<T> {
    type Pose = PlanarPose<T>;
    type Measurement = Vector2<T>;

    fn expect(&self, pose: &PlanarPose<T>) -> Option<Vector2<T>> {
        let seat = self.seat(pose);
        Some(Vector2::new(seat.x_m, seat.y_m))
    }

    fn by_pose(&self, pose: &PlanarPose<T>) -> Matrix2x3<T> {
        let seat = self.seat(pose);
        let (zero, one) = (T::ZERO, T::ONE);
        Matrix2x3::new(one, zero, pose.y_m - seat.y_m, zero, one, seat.x_m - pose.x_m)
    }

    fn innovation(&self, measured: &Vector2<T>, expected: &Vector2<T>) -> Vector2<T> {
        measured - expected
    }

    noise_and_gate!();
}

/// The heading (rad, from the map's x axis towards its y axis), for example from a compass, for any pose that has a
/// [heading](Pose::HEADING).
///
/// ```
/// use scphd::models::{Fix, HeadingFix, PlanarPose};
///
/// let compass = HeadingFix::<PlanarPose<f64>>::new(0.05)?;
/// assert_eq!(compass.expect(&PlanarPose::new(3.0, 4.0, 0.5)).unwrap().x, 0.5);
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadingFix<P: Pose> {
    noise: Symmetric<Vector1<P::Scalar>>,
    gate: P::Scalar,
}

impl<P: Pose> HeadingFix<P> {
    /// A fix with this standard deviation of the noise, rad.
    ///
    /// # Errors
    /// It must lie between 1e-6 and 1e6 rad.
    pub fn new(sigma_rad: P::Scalar) -> Result<Self, ModelError> {
        Ok(Self { noise: Symmetric::from_diagonal([variance(sigma_rad, "sigma_rad")?]), gate: Real::INFINITY })
    }

    /// This fix with a gate: a squared Mahalanobis distance beyond which a fix is rejected as an outlier.
    ///
    /// # Errors
    /// It must be above 0.
    pub fn gated(self, distance: P::Scalar) -> Result<Self, ModelError> {
        Ok(Self { gate: gate(distance)?, ..self })
    }
}

impl<P: Pose> Fix for HeadingFix<P> {
    type Pose = P;
    type Measurement = Vector1<P::Scalar>;

    fn expect(&self, pose: &P) -> Option<Vector1<P::Scalar>> {
        P::HEADING.map(|heading| Vector1::new(pose.coordinates().at(heading)))
    }

    fn by_pose(&self, _pose: &P) -> Linear<Vector1<P::Scalar>, P::Tangent> {
        Matrix::with(|_, column| if P::HEADING == Some(column) { Real::ONE } else { Zero::ZERO })
    }

    fn innovation(&self, measured: &Vector1<P::Scalar>, expected: &Vector1<P::Scalar>) -> Vector1<P::Scalar> {
        let [[difference]] = (measured - expected).data.0;
        Vector1::new(wrap(difference))
    }

    noise_and_gate!();
}

/// The height z (m, upwards) of an underwater vehicle, which is minus its depth, from a pressure sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightFix<T: Real> {
    noise: Symmetric<Vector1<T>>,
    gate: T,
}

impl<T: Real> HeightFix<T> {
    /// A fix with this standard deviation of the noise, m.
    ///
    /// # Errors
    /// It must lie between 1e-6 and 1e6 m.
    pub fn new(sigma_m: T) -> Result<Self, ModelError> {
        Ok(Self { noise: Symmetric::from_diagonal([variance(sigma_m, "sigma_m")?]), gate: T::INFINITY })
    }

    /// This fix with a gate: a squared Mahalanobis distance beyond which a fix is rejected as an outlier.
    ///
    /// # Errors
    /// It must be above 0.
    pub fn gated(self, distance: T) -> Result<Self, ModelError> {
        Ok(Self { gate: gate(distance)?, ..self })
    }
}

impl<T: Real> Fix for HeightFix<T> {
    type Pose = AuvPose<T>;
    type Measurement = Vector1<T>;

    fn expect(&self, pose: &AuvPose<T>) -> Option<Vector1<T>> {
        Some(Vector1::new(pose.z_m))
    }

    fn by_pose(&self, _pose: &AuvPose<T>) -> RowVector5<T> {
        RowVector5::new(T::ZERO, T::ZERO, T::ONE, T::ZERO, T::ZERO)
    }

    fn innovation(&self, measured: &Vector1<T>, expected: &Vector1<T>) -> Vector1<T> {
        measured - expected
    }

    noise_and_gate!();
}

/// A beacon: an identified landmark at a known position, so that its measurement needs no data association.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeaconFix<S: Sensor> {
    /// The sensor that measures it.
    pub sensor: S,
    /// The mounting of the sensor; `None` if its pose is that of the vehicle.
    pub mounting: Option<Mounting<ScalarOf<S::Pose>>>,
    /// Position of the beacon, m.
    pub place: PositionOf<S::Pose>,
    /// Gate: a squared Mahalanobis distance beyond which a measurement is rejected as an outlier.
    pub gate: ScalarOf<S::Pose>,
}

impl<S: Sensor> BeaconFix<S> {
    fn mounted(&self) -> Mounted<'_, S> {
        Mounted { sensor: &self.sensor, mounting: self.mounting }
    }
}

impl<S: Sensor> Fix for BeaconFix<S> {
    type Pose = S::Pose;
    type Measurement = S::Measurement;

    fn expect(&self, pose: &S::Pose) -> Option<S::Measurement> {
        let sensor = self.mounted();
        sensor.expect(&sensor.frame(pose), &self.place).map(|expected| expected.measurement)
    }

    fn by_pose(&self, pose: &S::Pose) -> Linear<S::Measurement, TangentOf<S::Pose>> {
        let sensor = self.mounted();
        let frame = sensor.frame(pose);
        let expected = sensor.expect(&frame, &self.place);
        expected.map_or(Zero::ZERO, |expected| sensor.by_pose(&frame, &self.place, &expected))
    }

    fn innovation(&self, measured: &S::Measurement, expected: &S::Measurement) -> S::Measurement {
        self.sensor.innovation(measured, expected)
    }

    fn noise(&self) -> &Symmetric<S::Measurement> {
        self.sensor.noise()
    }

    fn gate(&self) -> ScalarOf<S::Pose> {
        self.gate
    }
}

#[cfg(test)]
mod tests {
    use super::{BeaconFix, Fix, HeadingFix, HeightFix, PositionFix};
    use crate::models::testing::off_by;
    use crate::{AuvPose, Matrix, Mounting, PlanarPose, Pose, RangeBearing, TangentOf, Vector};
    use nalgebra::{Vector1, Vector2};

    /// Compares ∂h/∂x with central differences.
    fn check<F: Fix<Pose: Pose<Scalar = f64>>>(fix: &F, pose: &F::Pose) {
        const STEP: f64 = 1e-6;
        let slope = fix.by_pose(pose);
        for k in 0..TangentOf::<F::Pose>::DIMENSION {
            let at = |step: f64| {
                let by = Vector::with(|coordinate| if coordinate == k { step } else { 0.0 });
                fix.expect(&pose.displaced(&by)).unwrap()
            };
            let difference = fix.innovation(&at(STEP), &at(-STEP)) * (1.0 / (2.0 * STEP));
            let off = off_by(&difference, |row| slope.at(row, k));
            assert!(off < 1e-7, "column {k}: {difference:?} {slope:?}");
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        for heading in [-3.1, 0.4, 2.0] {
            let pose = PlanarPose::new(3.0, -2.0, heading);
            check(&PositionFix::new(0.5).unwrap(), &pose);
            check(&PositionFix::new(0.5).unwrap().mounted(-0.7, 1.3).unwrap(), &pose);
            check(&HeadingFix::new(0.1).unwrap(), &pose);
            let sensor = RangeBearing::new(0.1, 0.01).unwrap();
            let ahead = Mounting::in_plane(0.4, -0.2, 0.5).unwrap();
            for mounting in [None, Some(ahead)] {
                check(&BeaconFix { sensor, mounting, place: Vector2::new(8.0, 1.0), gate: f64::INFINITY }, &pose);
            }
            let diver = AuvPose { roll_rad: 0.2, ..AuvPose::new(1.0, 2.0, -3.0, heading) };
            check(&HeadingFix::new(0.1).unwrap(), &diver);
            check(&HeightFix::new(0.1).unwrap(), &diver);
        }
    }

    #[test]
    fn headings_wrap_and_invalid_parameters_are_refused() {
        let compass = HeadingFix::<PlanarPose<f64>>::new(0.1).unwrap();
        let off = compass.innovation(&Vector1::new(3.1), &Vector1::new(-3.1));
        assert!((off.x - (6.2 - core::f64::consts::TAU)).abs() < 1e-15);
        assert_eq!(PositionFix::new(f32::NAN).unwrap_err().field, "sigma_m");
        assert_eq!(HeadingFix::<PlanarPose<f32>>::new(0.0).unwrap_err().field, "sigma_rad");
        assert_eq!(HeightFix::new(1.0_f32).unwrap().gated(f32::NAN).unwrap_err().field, "gate");
    }
}
