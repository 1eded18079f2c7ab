//! Alignment of two maps: the rigid transform between them, and its covariance.

use crate::{Component, Matrix, PlanarPose, Pose, Real, Symmetric, Zero};
use nalgebra::{Vector2, Vector3};

/// A landmark in the plane.
pub(super) type Landmark<T> = Component<Vector2<T>>;

/// The alignment of a map: its pose in the vehicle's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Alignment<T: Real> {
    /// The pose of the centre of the map.
    pub(super) at: PlanarPose<T>,
    pub(super) covariance: Symmetric<Vector3<T>>,
}

/// The same with the sine and cosine of its heading.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turned<T> {
    at: Vector2<T>,
    sine: T,
    cosine: T,
}

impl<T: Real> Alignment<T> {
    pub(super) const ZERO: Self = Self { at: PlanarPose::ZERO, covariance: Symmetric::ZERO };

    pub(super) fn turned(&self) -> Turned<T> {
        let (sine, cosine) = self.at.heading_rad.sin_cos();
        Turned { at: Vector2::new(self.at.x_m, self.at.y_m), sine, cosine }
    }

    /// The alignment of two landmarks of the map with two of the vehicle: directions and midpoints are equal.
    pub(super) fn of_lines(seen: [&Vector2<T>; 2], of_map: [&Vector2<T>; 2]) -> Self {
        let [along_seen, along_map] = [seen, of_map].map(|[from, to]| to - from);
        let heading = crate::wrap(along_seen.y.atan2(along_seen.x) - along_map.y.atan2(along_map.x));
        let turn = Self { at: PlanarPose::new(T::ZERO, T::ZERO, heading), ..Self::ZERO }.turned();
        let half = T::from_f64(0.5);
        let at = (seen[0] + seen[1]) * half - turn.of(&((of_map[0] + of_map[1]) * half));
        Self { at: PlanarPose::new(at.x, at.y, heading), covariance: Symmetric::ZERO }
    }

    /// The alignment after an iteration of least squares over the pairs (landmark of the vehicle, of the map), with its covariance;
    /// `None` if they do not determine it.
    pub(super) fn fitted<'a>(
        &self,
        inflation: T,
        pairs: impl Iterator<Item = (&'a Landmark<T>, &'a Landmark<T>)>,
    ) -> Option<Self> {
        let turned = self.turned();
        let mut information = Symmetric::<Vector3<T>>::ZERO;
        let mut towards: Vector3<T> = Zero::ZERO;
        for (seen, of_map) in pairs {
            let lever = turned.lever(&of_map.mean);
            let factor = turned.relative_covariance(seen, of_map).scaled(inflation).factor()?;
            let inverse = factor.inverse();
            let jacobian: nalgebra::Matrix3x2<T> = Matrix::with(|row, column| match (row, column) {
                (0, 0) | (1, 1) => T::ONE,
                (2, 0) => lever.x,
                (2, 1) => lever.y,
                _ => T::ZERO,
            });
            information = information.plus(&inverse.congruence::<Vector3<T>>(&jacobian));
            let pull = factor.solve(&(seen.mean - turned.of(&of_map.mean)));
            towards += Vector3::new(pull.x, pull.y, lever.dot(&pull));
        }
        let factor = information.factor()?;
        let (by, covariance) = (factor.solve(&towards), factor.inverse());
        let at = self.at.displaced(&by);
        (at.is_finite() && covariance.is_finite()).then_some(Self { at, covariance })
    }

    /// Whether both alignments are equal within their covariances.
    pub(super) fn is_same(&self, other: &Self, gate: T) -> bool {
        let apart = self.at.difference(&other.at);
        let both = self.covariance.plus(&other.covariance).factor();
        both.is_some_and(|factor| factor.mahalanobis(&apart) <= gate)
    }

    /// Transforms a pose from the vehicle's frame into the map, whose centre is `middle`.
    pub(super) fn pose_in_map(&self, pose: &PlanarPose<T>, middle: &Vector2<T>) -> PlanarPose<T> {
        let turned = self.turned();
        let (dx, dy) = (pose.x_m - turned.at.x, pose.y_m - turned.at.y);
        let (x, y) = (turned.cosine * dx + turned.sine * dy, turned.cosine * dy - turned.sine * dx);
        PlanarPose::new(middle.x + x, middle.y + y, crate::wrap(pose.heading_rad - self.at.heading_rad))
    }

    /// The covariance of the transformed pose, from those of the alignment and of the pose in the vehicle's frame.
    pub(super) fn covariance_in_map(
        &self,
        pose: &PlanarPose<T>,
        covariance: &Symmetric<Vector3<T>>,
    ) -> Symmetric<Vector3<T>> {
        let turned = self.turned();
        let (dx, dy) = (pose.x_m - turned.at.x, pose.y_m - turned.at.y);
        let (s, c) = (turned.sine, turned.cosine);
        let (zero, one) = (T::ZERO, T::ONE);
        // x = Rᵀ (p − t): its derivative by the map's heading has the opposite sign.
        let by_alignment = nalgebra::Matrix3::new(-c, -s, c * dy - s * dx, s, -c, -c * dx - s * dy, zero, zero, -one);
        let by_pose = nalgebra::Matrix3::new(c, s, zero, -s, c, zero, zero, zero, one);
        self.covariance.congruence::<Vector3<T>>(&by_alignment).plus(&covariance.congruence::<Vector3<T>>(&by_pose))
    }
}

impl<T: Real> Turned<T> {
    /// Transforms a position of the map into the vehicle's frame.
    #[inline]
    pub(super) fn of(&self, place: &Vector2<T>) -> Vector2<T> {
        let (x, y) = (place.x, place.y);
        self.at + Vector2::new(self.cosine * x - self.sine * y, self.sine * x + self.cosine * y)
    }

    /// Its derivative by the heading of the map.
    #[inline]
    pub(super) fn lever(&self, place: &Vector2<T>) -> Vector2<T> {
        let (x, y) = (place.x, place.y);
        Vector2::new(-self.sine * x - self.cosine * y, self.cosine * x - self.sine * y)
    }

    /// The covariance of the difference of a landmark of the vehicle and one of the map, without that of the alignment.
    pub(super) fn relative_covariance(&self, seen: &Landmark<T>, of_map: &Landmark<T>) -> Symmetric<Vector2<T>> {
        let turn = nalgebra::Matrix2::new(self.cosine, -self.sine, self.sine, self.cosine);
        seen.covariance.plus(&of_map.covariance.congruence::<Vector2<T>>(&turn))
    }
}
