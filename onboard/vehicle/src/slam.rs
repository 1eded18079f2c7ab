//! The common interface of both filters.

use crate::{Control, Description, Measurements, Refused, Sensor, Start, StartError, Watched};
use nalgebra::{Vector2, Vector3};
use scphd::diagnostics::Probe;
use scphd::errors::{Flaw, LoadMapError, ObserveError, PredictError, ResetError, ScanError};
use scphd::fixes::FixReport;
use scphd::models::{Fix, MovingOf, OdometryCorrection, PlanarPose};
use scphd::numerics::Symmetric;
use scphd::snapshot::{RestoreError, SaveError, SliceEnd};
use scphd::{Component, Health, JointReport, MapEstimate, PoseEstimate, PredictReport, Real, ScanReport};

/// Result of a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scanned<T> {
    /// Of a mixture.
    Mixture(ScanReport<T>),
    /// Of a joint map.
    Joint(JointReport<T>),
}

impl<T: Real> Scanned<T> {
    /// The warnings.
    #[must_use]
    pub fn health(&self) -> Health {
        match self {
            Self::Mixture(report) => report.health,
            Self::Joint(report) => report.health,
        }
    }

    /// ln of the likelihood of the scan given all previous inputs, up to a constant.
    #[must_use]
    pub fn ln_evidence(&self) -> T {
        match self {
            Self::Mixture(report) => report.ln_evidence,
            Self::Joint(report) => report.ln_evidence,
        }
    }
}

/// A sink for a snapshot.
pub type Sink<'a> = dyn FnMut(&[u8]) -> Result<(), SliceEnd> + 'a;
/// A source of a snapshot: fills a slice with the bytes from a position on.
pub type Source<'a> = dyn FnMut(usize, &mut [u8]) -> Result<(), SliceEnd> + 'a;

/// A filter of a planar vehicle with the sensors and fixes of its description: the same calls for a mixture and for a joint map.
pub trait Slam<T: Real> {
    /// Starts or restarts with an empty map.
    ///
    /// # Errors
    /// The pose or its covariance is out of range; the state is unchanged.
    fn reset(&mut self, start: &Start<T>) -> Result<(), ResetError>;

    /// Predicts by `dt_s` seconds.
    ///
    /// # Errors
    /// The control or the time is refused, which the next report shows. Only the time since the last scan advances.
    fn predict(&mut self, control: Control<T>, dt_s: T) -> Result<PredictReport, PredictError>;

    /// Updates the filter with a scan of the sensor with this index in the description.
    ///
    /// # Errors
    /// There is no such sensor, or the scan is refused; the state is unchanged.
    fn scan(&mut self, sensor: usize, measurements: Measurements<'_, T>) -> Result<Scanned<T>, Refused<ScanError>>;

    /// Updates the filter with a measured position, m, if its fix has no monitor.
    ///
    /// # Errors
    /// The description has no such fix, the fix has a monitor, or the measurement is refused; the state is unchanged.
    fn observe_position(&mut self, x_m: T, y_m: T) -> Result<FixReport<T>, Refused<ObserveError>>;

    /// Updates the filter with a measured heading, rad, if its fix has no monitor.
    ///
    /// # Errors
    /// As for a position.
    fn observe_heading(&mut self, heading_rad: T) -> Result<FixReport<T>, Refused<ObserveError>>;

    /// The estimated pose; `None` before the first reset.
    fn pose(&self) -> Option<PoseEstimate<PlanarPose<T>>>;

    /// The estimated odometry correction, if the odometry is calibrated.
    fn odometry(&self) -> Option<OdometryCorrection<T>>;

    /// Writes the static features.
    fn features(&mut self, room: &mut [Component<Vector2<T>>]) -> MapEstimate<T>;

    /// Writes the moving features.
    fn movers(&mut self, room: &mut [Component<MovingOf<PlanarPose<T>>>]) -> MapEstimate<T>;
}

/// Further operations of a filter. A separate trait, so that a program that uses only [`Slam`] as a trait object does not link
/// them.
pub trait Services<T: Real>: Slam<T> {
    /// Replaces the description between any two steps. The new one must have the same parts; their settings may differ, except
    /// those of movers, archive and hypotheses of a joint map. The monitors are reset.
    ///
    /// # Errors
    /// The new description is out of range, or has other parts; the filter keeps the previous one.
    fn configure(&mut self, description: &Description<T>) -> Result<(), StartError>;

    /// Sets the pose with a covariance; the map is unchanged.
    ///
    /// # Errors
    /// The pose or the covariance is out of range, or the filter has not been reset; the state is unchanged.
    fn relocate(&mut self, pose: PlanarPose<T>, covariance: &Symmetric<Vector3<T>>) -> Result<(), ResetError>;

    /// Adds a covariance to that of the pose.
    ///
    /// # Errors
    /// The covariance is out of range, or the filter has not been reset; the state is unchanged.
    fn scatter(&mut self, covariance: &Symmetric<Vector3<T>>) -> Result<(), ResetError>;

    /// Replaces the map; an archive is emptied.
    ///
    /// # Errors
    /// The map is refused; the state is unchanged.
    fn load_map(&mut self, features: &[Component<Vector2<T>>]) -> Result<(), LoadMapError>;

    /// Updates only the pose with a scan; the map is unchanged.
    ///
    /// # Errors
    /// As for `scan`, or the filter does not support it.
    fn localise(&mut self, sensor: usize, measurements: Measurements<'_, T>) -> Result<Scanned<T>, Refused<ScanError>>;

    /// Writes all data that influences later results, except the monitors. `kind` identifies the type of vehicle.
    ///
    /// # Errors
    /// The filter has not been reset, the state is damaged, or the sink returns an error.
    fn save(&mut self, kind: u32, sink: &mut Sink<'_>) -> Result<usize, SaveError<SliceEnd>>;

    /// Restores a saved state: the source fills a slice with the bytes from a position on.
    ///
    /// # Errors
    /// The snapshot is refused.
    fn restore(&mut self, kind: u32, source: &mut Source<'_>) -> Result<usize, RestoreError<SliceEnd>>;

    /// Updates the filter with a measured position, m, and passes the result to the monitor, if there is one.
    ///
    /// # Errors
    /// The description has no such fix, or the measurement is refused; the state is unchanged.
    fn watch_position(&mut self, x_m: T, y_m: T) -> Result<Watched<T>, Refused<ObserveError>>;

    /// Updates the filter with a measured heading, rad, and passes the result to the monitor, if there is one.
    ///
    /// # Errors
    /// As for a position.
    fn watch_heading(&mut self, heading_rad: T) -> Result<Watched<T>, Refused<ObserveError>>;

    /// A hash of the complete state, to the last bit.
    fn digest(&self) -> u64;

    /// Checks the complete state.
    ///
    /// # Errors
    /// The first flaw that is found.
    fn audit(&mut self) -> Result<(), Flaw>;
}

/// Operations of recordings and test benches, beside those of [`Services`]. They are generic: not for trait objects, and what a
/// program does not call is not linked.
pub trait Recordable<T: Real>: Services<T> {
    /// [`Slam::scan`] with a probe.
    ///
    /// # Errors
    /// As for `scan`.
    fn scan_with(
        &mut self,
        sensor: usize,
        measurements: Measurements<'_, T>,
        probe: &mut impl Probe,
    ) -> Result<Scanned<T>, Refused<ScanError>>;

    /// Updates the filter with a fix that is not in the description.
    ///
    /// # Errors
    /// The measurement is refused; the state is unchanged.
    fn observe<F: Fix<Pose = PlanarPose<T>>>(
        &mut self,
        fix: F,
        measured: &F::Measurement,
    ) -> Result<FixReport<T>, ObserveError>;

    /// Restarts with an empty map at a pose with a covariance.
    ///
    /// # Errors
    /// The pose or the covariance is out of range; the state is unchanged.
    fn reset_within(
        &mut self,
        pose: PlanarPose<T>,
        covariance: &Symmetric<Vector3<T>>,
        seed: u64,
    ) -> Result<(), ResetError>;

    /// Adds a sensor, or replaces its models.
    ///
    /// # Errors
    /// A number of the sensor is out of range, or the filter does not support it; the filter keeps the previous one.
    fn replace(&mut self, sensor: usize, models: &Sensor<T>) -> Result<(), StartError>;

    /// [Adds](Self::replace) the sensors of a description.
    ///
    /// # Errors
    /// As for [`replace`](Self::replace).
    fn add_sensors(&mut self, description: &Description<T>) -> Result<(), StartError> {
        let mut sensors = description.sensors.iter().enumerate();
        sensors.try_for_each(|(index, sensor)| sensor.as_ref().map_or(Ok(()), |sensor| self.replace(index, sensor)))
    }

    /// Number of static features that are estimated; `room` as for [`Slam::features`], which a joint map does not use.
    fn count(&mut self, room: &mut [Component<Vector2<T>>]) -> usize;

    /// Number of static features that a joint map has; 0 for a mixture.
    fn held(&self) -> usize;
}

/// The fix if it has no monitor.
pub(crate) fn unwatched<F>(fix: Option<(F, bool)>) -> Result<F, Refused<ObserveError>> {
    match fix {
        Some((fix, false)) => Ok(fix),
        Some((_, true)) => Err(Refused::Watched),
        None => Err(Refused::NotDescribed),
    }
}

/// The fix, with or without a monitor.
pub(crate) fn described<F>(fix: Option<(F, bool)>) -> Result<F, Refused<ObserveError>> {
    fix.map(|(fix, _)| fix).ok_or(Refused::NotDescribed)
}

/// Relocates the vehicle if the monitor returned a pose.
pub(crate) fn watched<T: Real>(
    slam: &mut impl Services<T>,
    report: FixReport<T>,
    to: Option<PoseEstimate<PlanarPose<T>>>,
) -> Watched<T> {
    let relocated = to.is_some_and(|to| slam.relocate(to.mean, &to.covariance).is_ok());
    Watched { report, relocated }
}
