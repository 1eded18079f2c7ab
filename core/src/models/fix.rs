//! Fixes: measurements of the pose itself.

use super::{AuvPose, Locating, ModelError, Mounted, Mounting, PlanarPose, Pose, Sensor, require};
use crate::{Dim, Packed, Real, Symmetric, wrap};
use nalgebra::{SMatrix, SVector, Vector1, Vector2};

/// A measurement of the vehicle's pose, from something whose place in the map's frame is known: z = h(x) + v.
///
/// K is the number of degrees of freedom of the pose, Z the dimension of the measurement. An implementation must be a pure function of
/// its arguments, and take its transcendental functions from [`Real`].
pub trait Fix<T: Real, const K: usize, const Z: usize>
where
    Dim<Z>: Packed,
{
    /// The vehicle state.
    type Pose: Pose<T, K>;

    /// ẑ = h(x); `None` where it cannot be measured from there.
    fn expect(&self, pose: &Self::Pose) -> Option<SVector<T, Z>>;

    /// ∂h/∂x, in the coordinates of [`Pose::difference`].
    fn by_pose(&self, pose: &Self::Pose) -> SMatrix<T, Z, K>;

    /// z ⊖ ẑ: the difference of two measurements, angles wrapped.
    fn innovation(&self, measured: &SVector<T, Z>, expected: &SVector<T, Z>) -> SVector<T, Z>;

    /// R, the covariance of the measurement noise.
    fn noise(&self) -> &Symmetric<T, Z>;

    /// A squared Mahalanobis distance: what lies farther from what the filter expects is left out, as an outlier. Infinite: nothing is.
    fn gate(&self) -> T {
        T::INFINITY
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

/// The position of an antenna in the plane (x, y m), such as from a satellite receiver whose fixes have been turned into the map's
/// frame.
///
/// ```
/// use scphd::{Fix, PlanarPose, PositionFix};
/// use nalgebra::Vector2;
///
/// // 0.5 m, the antenna half a metre behind the axle.
/// let gps = PositionFix::new(0.5)?.mounted(-0.5, 0.0)?;
/// let expected = gps.expect(&PlanarPose::new(3.0, 4.0, 0.0)).unwrap();
/// assert_eq!(expected, Vector2::new(2.5, 4.0));
/// # Ok::<(), scphd::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionFix<T: Real> {
    noise: Symmetric<T, 2>,
    antenna: Option<Mounting<T>>,
    gate: T,
}

impl<T: Real> PositionFix<T> {
    /// With the same noise, m, along either axis, the antenna where the vehicle's pose is.
    ///
    /// # Errors
    /// The noise must lie between 1e-6 and 1e6 m.
    pub fn new(sigma_m: T) -> Result<Self, ModelError> {
        let variance = variance(sigma_m, "sigma_m")?;
        Ok(Self { noise: Symmetric::from_diagonal([variance; 2]), antenna: None, gate: T::INFINITY })
    }

    /// With the antenna so far ahead and to the left of where the pose is, m.
    ///
    /// # Errors
    /// As for [`Mounting::in_plane`].
    pub fn mounted(self, forward_m: T, left_m: T) -> Result<Self, ModelError> {
        Ok(Self { antenna: Some(Mounting::in_plane(forward_m, left_m, T::ZERO)?), ..self })
    }

    /// With a gate: a squared Mahalanobis distance beyond which a fix is an outlier.
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

impl<T: Real> Fix<T, 3, 2> for PositionFix<T> {
    type Pose = PlanarPose<T>;

    fn expect(&self, pose: &PlanarPose<T>) -> Option<SVector<T, 2>> {
        let seat = self.seat(pose);
        Some(Vector2::new(seat.x_m, seat.y_m))
    }

    fn by_pose(&self, pose: &PlanarPose<T>) -> SMatrix<T, 2, 3> {
        let seat = self.seat(pose);
        let (zero, one) = (T::ZERO, T::ONE);
        SMatrix::<T, 2, 3>::new(one, zero, pose.y_m - seat.y_m, zero, one, seat.x_m - pose.x_m)
    }

    fn innovation(&self, measured: &SVector<T, 2>, expected: &SVector<T, 2>) -> SVector<T, 2> {
        measured - expected
    }

    fn noise(&self) -> &Symmetric<T, 2> {
        &self.noise
    }

    fn gate(&self) -> T {
        self.gate
    }
}

/// The heading (rad, from the map's x axis towards its y axis), such as from a compass; of a vehicle in the plane or in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadingFix<T: Real> {
    noise: Symmetric<T, 1>,
    gate: T,
}

impl<T: Real> HeadingFix<T> {
    /// With this noise, rad.
    ///
    /// # Errors
    /// It must lie between 1e-6 and 1e6 rad.
    pub fn new(sigma_rad: T) -> Result<Self, ModelError> {
        Ok(Self { noise: Symmetric::from_diagonal([variance(sigma_rad, "sigma_rad")?]), gate: T::INFINITY })
    }

    /// With a gate: a squared Mahalanobis distance beyond which a fix is an outlier.
    ///
    /// # Errors
    /// It must be above 0.
    pub fn gated(self, distance: T) -> Result<Self, ModelError> {
        Ok(Self { gate: gate(distance)?, ..self })
    }

    fn wrapped(measured: &SVector<T, 1>, expected: &SVector<T, 1>) -> SVector<T, 1> {
        let [[difference]] = (measured - expected).data.0;
        Vector1::new(wrap(difference))
    }
}

impl<T: Real> Fix<T, 3, 1> for HeadingFix<T> {
    type Pose = PlanarPose<T>;

    fn expect(&self, pose: &PlanarPose<T>) -> Option<SVector<T, 1>> {
        Some(Vector1::new(pose.heading_rad))
    }

    fn by_pose(&self, _pose: &PlanarPose<T>) -> SMatrix<T, 1, 3> {
        SMatrix::<T, 1, 3>::new(T::ZERO, T::ZERO, T::ONE)
    }

    fn innovation(&self, measured: &SVector<T, 1>, expected: &SVector<T, 1>) -> SVector<T, 1> {
        Self::wrapped(measured, expected)
    }

    fn noise(&self) -> &Symmetric<T, 1> {
        &self.noise
    }

    fn gate(&self) -> T {
        self.gate
    }
}

impl<T: Real> Fix<T, 5, 1> for HeadingFix<T> {
    type Pose = AuvPose<T>;

    fn expect(&self, pose: &AuvPose<T>) -> Option<SVector<T, 1>> {
        Some(Vector1::new(pose.yaw_rad))
    }

    fn by_pose(&self, _pose: &AuvPose<T>) -> SMatrix<T, 1, 5> {
        SMatrix::from_fn(|_, column| if column == 3 { T::ONE } else { T::ZERO })
    }

    fn innovation(&self, measured: &SVector<T, 1>, expected: &SVector<T, 1>) -> SVector<T, 1> {
        Self::wrapped(measured, expected)
    }

    fn noise(&self) -> &Symmetric<T, 1> {
        &self.noise
    }

    fn gate(&self) -> T {
        self.gate
    }
}

/// The height z (m, upwards) of an underwater vehicle, from a pressure sensor: minus its depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightFix<T: Real> {
    noise: Symmetric<T, 1>,
    gate: T,
}

impl<T: Real> HeightFix<T> {
    /// With this noise, m.
    ///
    /// # Errors
    /// It must lie between 1e-6 and 1e6 m.
    pub fn new(sigma_m: T) -> Result<Self, ModelError> {
        Ok(Self { noise: Symmetric::from_diagonal([variance(sigma_m, "sigma_m")?]), gate: T::INFINITY })
    }

    /// With a gate: a squared Mahalanobis distance beyond which a fix is an outlier.
    ///
    /// # Errors
    /// It must be above 0.
    pub fn gated(self, distance: T) -> Result<Self, ModelError> {
        Ok(Self { gate: gate(distance)?, ..self })
    }
}

impl<T: Real> Fix<T, 5, 1> for HeightFix<T> {
    type Pose = AuvPose<T>;

    fn expect(&self, pose: &AuvPose<T>) -> Option<SVector<T, 1>> {
        Some(Vector1::new(pose.z_m))
    }

    fn by_pose(&self, _pose: &AuvPose<T>) -> SMatrix<T, 1, 5> {
        SMatrix::from_fn(|_, column| if column == 2 { T::ONE } else { T::ZERO })
    }

    fn innovation(&self, measured: &SVector<T, 1>, expected: &SVector<T, 1>) -> SVector<T, 1> {
        measured - expected
    }

    fn noise(&self) -> &Symmetric<T, 1> {
        &self.noise
    }

    fn gate(&self) -> T {
        self.gate
    }
}

/// A beacon: a landmark with a name, at a known place, that a sensor measures without doubt which it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeaconFix<T: Real, S, const D: usize> {
    /// What it is measured with.
    pub sensor: S,
    /// Where that sits; `None` where the pose is.
    pub mounting: Option<Mounting<T>>,
    /// Where it stands, m.
    pub place: SVector<T, D>,
    /// A squared Mahalanobis distance beyond which a measurement of it is an outlier.
    pub gate: T,
}

impl<T: Real, S, const D: usize> BeaconFix<T, S, D> {
    fn mounted<const K: usize>(&self) -> Mounted<'_, T, S, (), K> {
        Mounted { sensor: &self.sensor, field_of_view: &(), mounting: self.mounting }
    }
}

impl<T, S, const K: usize, const D: usize, const Z: usize> Fix<T, K, Z> for BeaconFix<T, S, D>
where
    T: Real,
    S: Locating<T, K, D, Z> + Sensor<T, D, Z>,
    S::Pose: Pose<T, K>,
    Dim<D>: Packed,
    Dim<Z>: Packed,
{
    type Pose = S::Pose;

    fn expect(&self, pose: &S::Pose) -> Option<SVector<T, Z>> {
        let sensor = self.mounted::<K>();
        sensor.expect(&sensor.frame(pose), &self.place).map(|expected| expected.measurement)
    }

    fn by_pose(&self, pose: &S::Pose) -> SMatrix<T, Z, K> {
        let sensor = self.mounted::<K>();
        let frame = sensor.frame(pose);
        let expected = sensor.expect(&frame, &self.place);
        expected.map_or(SMatrix::zeros(), |expected| sensor.by_pose(&frame, &self.place, &expected))
    }

    fn innovation(&self, measured: &SVector<T, Z>, expected: &SVector<T, Z>) -> SVector<T, Z> {
        self.sensor.innovation(measured, expected)
    }

    fn noise(&self) -> &Symmetric<T, Z> {
        self.sensor.noise()
    }

    fn gate(&self) -> T {
        self.gate
    }
}

#[cfg(test)]
mod tests {
    use super::{BeaconFix, Fix, HeadingFix, HeightFix, PositionFix};
    use crate::{AuvPose, Dim, Mounting, Packed, PlanarPose, Pose, RangeBearing};
    use nalgebra::{SVector, Vector1, Vector2};

    /// ∂h/∂x against central differences.
    fn check<F, const K: usize, const Z: usize>(fix: &F, pose: &F::Pose)
    where
        F: Fix<f64, K, Z>,
        Dim<Z>: Packed,
    {
        const STEP: f64 = 1e-6;
        let slope = fix.by_pose(pose);
        for k in 0..K {
            let at = |step: f64| {
                let mut by = SVector::<f64, K>::zeros();
                by[k] = step;
                fix.expect(&pose.displaced(&by)).unwrap()
            };
            let difference = fix.innovation(&at(STEP), &at(-STEP)) / (2.0 * STEP);
            assert!((difference - slope.column(k)).norm() < 1e-7, "column {k}: {difference} {slope}");
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        for heading in [-3.1, 0.4, 2.0] {
            let pose = PlanarPose::new(3.0, -2.0, heading);
            check(&PositionFix::new(0.5).unwrap(), &pose);
            check(&PositionFix::new(0.5).unwrap().mounted(-0.7, 1.3).unwrap(), &pose);
            check::<_, 3, 1>(&HeadingFix::new(0.1).unwrap(), &pose);
            let sensor = RangeBearing::new(0.1, 0.01).unwrap();
            let ahead = Mounting::in_plane(0.4, -0.2, 0.5).unwrap();
            for mounting in [None, Some(ahead)] {
                check(&BeaconFix { sensor, mounting, place: Vector2::new(8.0, 1.0), gate: f64::INFINITY }, &pose);
            }
            let diver = AuvPose { roll_rad: 0.2, ..AuvPose::new(1.0, 2.0, -3.0, heading) };
            check::<_, 5, 1>(&HeadingFix::new(0.1).unwrap(), &diver);
            check(&HeightFix::new(0.1).unwrap(), &diver);
        }
    }

    #[test]
    fn headings_wrap_and_nonsense_is_refused() {
        let compass = HeadingFix::new(0.1_f64).unwrap();
        let off = Fix::<f64, 3, 1>::innovation(&compass, &Vector1::new(3.1), &Vector1::new(-3.1));
        assert!((off.x - (6.2 - core::f64::consts::TAU)).abs() < 1e-15);
        assert_eq!(PositionFix::new(f32::NAN).unwrap_err().field, "sigma_m");
        assert_eq!(HeadingFix::new(0.0_f32).unwrap_err().field, "sigma_rad");
        assert_eq!(HeightFix::new(1.0_f32).unwrap().gated(f32::NAN).unwrap_err().field, "gate");
    }
}
