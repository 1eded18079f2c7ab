//! The parts of learning that depend on the kind of vehicle.

use nalgebra::{DMatrix, DVector};
use scphd::models::{PositionOf, Sensor};
use scphd::numerics::{Linear, Matrix, Vector};
use scphd_filters::kind::Kind;
use scphd_filters::slam::Refusal;
use scphd_log::dimensions::Dimensions;

/// Settings with a common factor, and the coordinates of measurements that determine it.
#[derive(Debug, Clone, Copy)]
pub struct NoiseOf {
    /// `section.field`.
    pub fields: &'static [&'static str],
    /// The coordinates with this noise.
    pub coordinates: &'static [usize],
}

/// The variances that the noise of a motion adds to the pose.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Added {
    /// Along the vehicle, by the first noise (of the speed), m².
    pub along: f64,
    /// To the heading, by the first and by the second noise (of the turn), rad².
    pub turned: [f64; 2],
}

/// A kind of vehicle whose settings can be learnt.
pub trait Learn: Kind {
    /// Fields of the first and of the second noise of the motion.
    const ODOMETRY: [&'static [&'static str]; 2];
    /// Fields of the measurement noise.
    const NOISE: &'static [NoiseOf];
    /// Fields of p_D: one for the whole view, or one for each end of the range.
    const DETECTION: &'static [&'static str];
    /// The field of λ.
    const CLUTTER: &'static str;

    /// Whether the log is simulated, so that its noise has no lasting errors.
    fn is_simulated(log: &Self::Log) -> bool;

    /// Why nothing can be learnt from a log, if its measurements do not fit the models of a filter.
    fn unfit(_log: &Self::Log) -> Option<String> {
        None
    }

    /// Whether a field of the odometry noise has an effect in this log.
    fn decides(_log: &Self::Log, _field: &str) -> bool {
        true
    }

    /// Whether the log states this noise.
    fn states(log: &Self::Log, field: &str) -> bool;

    /// The default settings for the log.
    fn scheme(log: &Self::Log) -> Self::Settings;

    /// Area or volume of the view, m² or m³.
    fn view_measure(log: &Self::Log) -> f64;

    /// The greatest range at which detections are expected, m.
    fn reach_m(log: &Self::Log, settings: &Self::Settings) -> f64;

    /// Variances that a motion of `dt_s` seconds adds with the noise of these settings.
    fn added(log: &Self::Log, settings: &Self::Settings, control: &Self::Control, dt_s: f64) -> Added;

    /// The sensor with noise and view of these settings.
    fn eye<'a>(log: &'a Self::Log, settings: &'a Self::Settings) -> Result<Box<dyn Eye<Self> + 'a>, Refusal>;
}

/// The prediction for a position.
#[derive(Debug, Clone, PartialEq)]
pub struct Expected<D: Dimensions> {
    /// ẑ.
    pub measurement: D::Measurement,
    /// ∂ẑ/∂m.
    pub by_place: DMatrix<f64>,
    /// ∂ẑ/∂x.
    pub by_pose: DMatrix<f64>,
}

/// The sensor of a log, from the vehicle's pose at a scan.
pub trait Eye<D: Dimensions> {
    /// Predicts the measurement of a position; `None` if it cannot be measured.
    fn expect(&self, scan: usize, pose: &D::Pose, place: &D::Position) -> Option<Expected<D>>;

    /// z ⊖ ẑ.
    fn innovation(&self, measured: &D::Measurement, expected: &D::Measurement) -> DVector<f64>;

    /// R of a measurement with this prediction.
    fn noise(&self, expected: &D::Measurement) -> DMatrix<f64>;

    /// The position of a measurement, and the covariance by its noise; `None` if there is none.
    fn place(&self, scan: usize, pose: &D::Pose, measured: &D::Measurement) -> Option<(D::Position, DMatrix<f64>)>;

    /// The range of a measurement, m; `None` near the soft edges of the view, or outside.
    fn inside(&self, measured: &D::Measurement) -> Option<f64>;
}

/// The pose of the sensor model, and its derivative by the vehicle's pose; `None` if they are equal.
pub(super) type Seat<P> = (P, Option<DMatrix<f64>>);

/// Computes the sensor's pose at a scan from the vehicle's pose.
pub(super) type SeatAt<'a, D, P> = Box<dyn Fn(usize, &<D as Dimensions>::Pose) -> Seat<P> + 'a>;

/// See [`Eye::inside`].
pub(super) type Inside<'a, D> = Box<dyn Fn(&<D as Dimensions>::Measurement) -> Option<f64> + 'a>;

/// A sensor of the core as an [`Eye`].
pub(super) struct CoreEye<'a, D: Dimensions, S: Sensor> {
    pub(super) sensor: S,
    /// Its pose at a scan, from the vehicle's pose.
    pub(super) seat: SeatAt<'a, D, S::Pose>,
    /// See [`Eye::inside`].
    pub(super) inside: Inside<'a, D>,
}

/// A matrix of the core as a dynamic one.
fn full<R: Vector<Scalar = f64>, C: Vector<Scalar = f64>>(matrix: &Linear<R, C>) -> DMatrix<f64> {
    DMatrix::from_fn(R::DIMENSION, C::DIMENSION, |row, column| matrix.at(row, column))
}

impl<D: Dimensions, S: Sensor<Measurement: Vector<Scalar = f64>, Pose: scphd::models::Pose<Scalar = f64>>> Eye<D>
    for CoreEye<'_, D, S>
{
    fn expect(&self, scan: usize, pose: &D::Pose, place: &D::Position) -> Option<Expected<D>> {
        let (seat, by_vehicle) = (self.seat)(scan, pose);
        let frame = self.sensor.frame(&seat);
        let place = vector::<PositionOf<S::Pose>>(place.as_ref());
        let seen = self.sensor.expect(&frame, &place)?;
        let by_seat =
            full::<S::Measurement, scphd::models::TangentOf<S::Pose>>(&self.sensor.by_pose(&frame, &place, &seen));
        Some(Expected {
            measurement: coordinates(seen.measurement.as_slice()),
            by_place: full::<S::Measurement, PositionOf<S::Pose>>(&seen.jacobian),
            by_pose: by_vehicle.map_or_else(|| by_seat.clone(), |by_vehicle| &by_seat * by_vehicle),
        })
    }

    fn innovation(&self, measured: &D::Measurement, expected: &D::Measurement) -> DVector<f64> {
        let [measured, expected] = [measured, expected].map(|z| vector::<S::Measurement>(z.as_ref()));
        DVector::from_row_slice(self.sensor.innovation(&measured, &expected).as_slice())
    }

    fn noise(&self, expected: &D::Measurement) -> DMatrix<f64> {
        let expected = vector::<S::Measurement>(expected.as_ref());
        let noise = self.sensor.noise_of(&expected, &expected).unwrap_or(*self.sensor.noise());
        full::<S::Measurement, S::Measurement>(&noise.to_matrix())
    }

    fn place(&self, scan: usize, pose: &D::Pose, measured: &D::Measurement) -> Option<(D::Position, DMatrix<f64>)> {
        let frame = self.sensor.frame(&(self.seat)(scan, pose).0);
        let inverse = self.sensor.invert(&frame, &vector::<S::Measurement>(measured.as_ref()))?;
        let by_measurement = full::<PositionOf<S::Pose>, S::Measurement>(&inverse.jacobian);
        let covariance = &by_measurement * Eye::<D>::noise(self, measured) * by_measurement.transpose();
        Some((coordinates(inverse.feature.as_slice()), covariance))
    }

    fn inside(&self, measured: &D::Measurement) -> Option<f64> {
        (self.inside)(measured)
    }
}

fn vector<V: Vector<Scalar = f64>>(numbers: &[f64]) -> V {
    V::with(|k| numbers[k])
}

fn coordinates<C: scphd_log::dimensions::Coordinates>(numbers: &[f64]) -> C {
    C::with(|k| numbers[k])
}
