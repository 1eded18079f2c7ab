//! A planar pose with the parameters of the odometry calibration.

use super::{ModelError, Mounting, PlanarPose, Pose};
use crate::{Real, Vector};
use nalgebra::{Matrix2x3, SVector, Vector2};

/// Scale and offset errors of the two controls of a planar vehicle (speed v, second control ω or α). The corrected controls are v ←
/// (1 + `speed_scale`) v, ω ← (1 + `turn_scale`) ω + `turn_offset`. All zero: no correction.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OdometryCorrection<T> {
    /// Relative correction of the speed, for example for worn wheels.
    pub speed_scale: T,
    /// Relative correction of the second control, for example for another track width or steering ratio.
    pub turn_scale: T,
    /// Offset of the second control: turn rate, rad/s, or steering angle, rad. For example the bias of a gyroscope, or a wheel that
    /// is not straight.
    pub turn_offset: T,
}

impl<T: Real> OdometryCorrection<T> {
    /// No correction.
    pub const NONE: Self = Self { speed_scale: T::ZERO, turn_scale: T::ZERO, turn_offset: T::ZERO };

    /// The corrected controls.
    #[must_use]
    pub fn corrected(&self, [speed, turn]: [T; 2]) -> [T; 2] {
        [speed + self.speed_scale * speed, turn + self.turn_scale * turn + self.turn_offset]
    }

    /// The derivative of [`corrected`](Self::corrected) with respect to the correction.
    pub(super) fn by_itself([speed, turn]: [T; 2]) -> Matrix2x3<T> {
        Matrix2x3::new(speed, T::ZERO, T::ZERO, T::ZERO, turn, T::ONE)
    }

    fn numbers(&self) -> [T; 3] {
        [self.speed_scale, self.turn_scale, self.turn_offset]
    }
}

/// Position, heading and odometry correction: the state of a [`SelfCalibrating`](super::SelfCalibrating) vehicle. Coordinates are
/// x, y, heading, then those of the correction in their order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibratedPose<T> {
    /// Pose of the vehicle.
    pub vehicle: PlanarPose<T>,
    /// Correction of its odometry.
    pub odometry: OdometryCorrection<T>,
}

impl<T: Real> CalibratedPose<T> {
    /// A pose without odometry correction.
    pub const fn at(vehicle: PlanarPose<T>) -> Self {
        Self { vehicle, odometry: OdometryCorrection::NONE }
    }
}

/// A difference of planar poses, with zeros for the odometry correction.
fn widened<T: Real>(planar: &impl Vector<Scalar = T>) -> SVector<T, 6> {
    Vector::with(|k| planar.at(k))
}

impl<T: Real> Pose for CalibratedPose<T> {
    type Scalar = T;
    type Tangent = SVector<T, 6>;
    type Position = Vector2<T>;

    const ZERO: Self = Self::at(PlanarPose::ZERO);
    const HEADING: Option<usize> = PlanarPose::<T>::HEADING;

    fn coordinates(&self) -> SVector<T, 6> {
        let [scale, turn_scale, offset] = self.odometry.numbers();
        let PlanarPose { x_m, y_m, heading_rad } = self.vehicle;
        SVector::from([x_m, y_m, heading_rad, scale, turn_scale, offset])
    }

    fn to_numbers(&self, take: impl FnMut(T)) {
        self.coordinates().iter().copied().for_each(take);
    }

    fn of_numbers(mut next: impl FnMut() -> T) -> Self {
        let vehicle = PlanarPose::of_numbers(&mut next);
        Self { vehicle, odometry: OdometryCorrection { speed_scale: next(), turn_scale: next(), turn_offset: next() } }
    }

    fn difference(&self, from: &Self) -> SVector<T, 6> {
        let turned = self.vehicle.difference(&from.vehicle);
        let all = self.coordinates() - from.coordinates();
        Vector::with(|k| if k < 3 { turned.at(k) } else { all.at(k) })
    }

    fn displaced(&self, by: &SVector<T, 6>) -> Self {
        let [[x, y, heading, speed_scale, turn_scale, turn_offset]] = by.data.0;
        Self {
            vehicle: self.vehicle.displaced(&[x, y, heading].into()),
            odometry: OdometryCorrection {
                speed_scale: self.odometry.speed_scale + speed_scale,
                turn_scale: self.odometry.turn_scale + turn_scale,
                turn_offset: self.odometry.turn_offset + turn_offset,
            },
        }
    }

    fn mean(weighted: impl Iterator<Item = (T, Self)>) -> Self {
        let mut odometry = [T::ZERO; 3];
        let vehicle = PlanarPose::mean(weighted.map(|(weight, pose)| {
            odometry.iter_mut().zip(pose.odometry.numbers()).for_each(|(sum, of)| *sum += weight * of);
            (weight, pose.vehicle)
        }));
        let [speed_scale, turn_scale, turn_offset] = odometry;
        Self { vehicle, odometry: OdometryCorrection { speed_scale, turn_scale, turn_offset } }
    }

    fn on_ground(&self) -> [T; 3] {
        self.vehicle.on_ground()
    }

    fn check_mounting(mounting: &Mounting<T>) -> Result<(), ModelError> {
        PlanarPose::check_mounting(mounting)
    }

    fn mounted(&self, mounting: &Mounting<T>) -> (Self, SVector<T, 6>) {
        let (vehicle, by_heading) = self.vehicle.mounted(mounting);
        (Self { vehicle, odometry: self.odometry }, widened(&by_heading))
    }
}
