//! The one trait of both filters.

use crate::{Control, Description, Measurements, Refused, Start, StartError, Watched};
use nalgebra::{Vector2, Vector3};
use scphd::errors::{Flaw, LoadMapError, ObserveError, PredictError, ResetError, ScanError};
use scphd::models::{MovingOf, OdometryCorrection, PlanarPose};
use scphd::numerics::Symmetric;
use scphd::snapshot::{RestoreError, SaveError, SliceEnd};
use scphd::{Component, FixReport, Health, JointReport, MapEstimate, PoseEstimate, PredictReport, Real, ScanReport};

/// What a scan did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scanned<T> {
    /// In a mixture.
    Mixture(ScanReport<T>),
    /// In a joint map.
    Joint(JointReport<T>),
}

impl<T: Real> Scanned<T> {
    /// Conditions.
    #[must_use]
    pub fn health(&self) -> Health {
        match self {
            Self::Mixture(report) => report.health,
            Self::Joint(report) => report.health,
        }
    }

    /// ln of the likelihood of the scan given all before, up to a constant.
    #[must_use]
    pub fn ln_evidence(&self) -> T {
        match self {
            Self::Mixture(report) => report.ln_evidence,
            Self::Joint(report) => report.ln_evidence,
        }
    }
}

/// Takes a snapshot, part after part.
pub type Sink<'a> = dyn FnMut(&[u8]) -> Result<(), SliceEnd> + 'a;
/// Gives a snapshot: what lies at a place.
pub type Source<'a> = dyn FnMut(usize, &mut [u8]) -> Result<(), SliceEnd> + 'a;

/// A filter of a vehicle in the plane, with the sensors and fixes of its description: the same calls for a mixture and for a joint map.
pub trait Slam<T: Real> {
    /// Starts, or starts again, without a feature.
    ///
    /// # Errors
    /// The pose or its covariance is out of range; the state is as it was.
    fn reset(&mut self, start: &Start<T>) -> Result<(), ResetError>;

    /// Moves the vehicle for so many seconds.
    ///
    /// # Errors
    /// The control or the time is refused, which the next report tells; the state is as it was.
    fn predict(&mut self, control: Control<T>, dt_s: T) -> Result<PredictReport, PredictError>;

    /// Takes in a scan of the sensor in this place of the description.
    ///
    /// # Errors
    /// There is no such sensor, or the scan is refused; the state is as it was.
    fn scan(&mut self, sensor: usize, measurements: Measurements<'_, T>) -> Result<Scanned<T>, Refused<ScanError>>;

    /// Takes in a measured position, m, of fixes without a watch.
    ///
    /// # Errors
    /// The description has no such fix, or one with a watch, or it is refused; the state is as it was.
    fn observe_position(&mut self, x_m: T, y_m: T) -> Result<FixReport<T>, Refused<ObserveError>>;

    /// Takes in a measured heading, rad, of fixes without a watch.
    ///
    /// # Errors
    /// As for a position.
    fn observe_heading(&mut self, heading_rad: T) -> Result<FixReport<T>, Refused<ObserveError>>;

    /// Where the vehicle is; `None` before the first reset.
    fn pose(&self) -> Option<PoseEstimate<PlanarPose<T>>>;

    /// What the odometry is off by, of a filter that learns it.
    fn odometry(&self) -> Option<OdometryCorrection<T>>;

    /// Writes the features that stand still.
    fn features(&mut self, room: &mut [Component<Vector2<T>>]) -> MapEstimate<T>;

    /// Writes the features that move.
    fn movers(&mut self, room: &mut [Component<MovingOf<PlanarPose<T>>>]) -> MapEstimate<T>;
}

/// What a filter does beside its loop. It is a trait of its own, so that a program that has no use for it behind a trait object does not link it.
pub trait Services<T: Real>: Slam<T> {
    /// Goes on by another description, between any two steps: with the same parts, which may have other numbers, but
    /// for movers and archive of a joint map. The watches begin anew.
    ///
    /// # Errors
    /// It is out of range, or has other parts; the filter keeps the one it had.
    fn configure(&mut self, description: &Description<T>) -> Result<(), StartError>;

    /// Puts the vehicle to this pose, known to a covariance; the map stays.
    ///
    /// # Errors
    /// The pose or the covariance is out of range, or the filter has not been reset; the state is as it was.
    fn relocate(&mut self, pose: PlanarPose<T>, covariance: &Symmetric<Vector3<T>>) -> Result<(), ResetError>;

    /// Makes the pose uncertain by a further covariance.
    ///
    /// # Errors
    /// The covariance is out of range, or the filter has not been reset; the state is as it was.
    fn scatter(&mut self, covariance: &Symmetric<Vector3<T>>) -> Result<(), ResetError>;

    /// Puts this map in the place of the one that there is.
    ///
    /// # Errors
    /// The map is refused, or there is an archive behind the filter; the state is as it was.
    fn load_map(&mut self, features: &[Component<Vector2<T>>]) -> Result<(), Refused<LoadMapError>>;

    /// Takes in a scan for the pose alone: the map stays as it is.
    ///
    /// # Errors
    /// As for `scan`, or this filter cannot.
    fn localise(&mut self, sensor: usize, measurements: Measurements<'_, T>) -> Result<Scanned<T>, Refused<ScanError>>;

    /// Writes down all that decides how the filter goes on, but for its watches. The kind tells vehicles apart.
    ///
    /// # Errors
    /// There is nothing to save, it is damaged, or the sink takes no more.
    fn save(&mut self, kind: u32, sink: &mut Sink<'_>) -> Result<usize, SaveError<SliceEnd>>;

    /// Goes on from what was saved: the source fills a slice with what lies at a place.
    ///
    /// # Errors
    /// It is refused, as the library says.
    fn restore(&mut self, kind: u32, source: &mut Source<'_>) -> Result<usize, RestoreError<SliceEnd>>;

    /// Takes in a measured position, m, and has the watch see it, if there is one.
    ///
    /// # Errors
    /// The description has no such fix, or it is refused; the state is as it was.
    fn watch_position(&mut self, x_m: T, y_m: T) -> Result<Watched<T>, Refused<ObserveError>>;

    /// Takes in a measured heading, rad, and has the watch see it, if there is one.
    ///
    /// # Errors
    /// As for a position.
    fn watch_heading(&mut self, heading_rad: T) -> Result<Watched<T>, Refused<ObserveError>>;

    /// A hash of all that the filter knows, to the last bit.
    fn digest(&self) -> u64;

    /// Looks over all that the filter knows.
    ///
    /// # Errors
    /// The first flaw.
    fn audit(&mut self) -> Result<(), Flaw>;
}

/// The fix that is asked for, without a watch.
pub(crate) fn unwatched<F>(fix: Option<(F, bool)>) -> Result<F, Refused<ObserveError>> {
    match fix {
        Some((fix, false)) => Ok(fix),
        Some((_, true)) => Err(Refused::Watched),
        None => Err(Refused::NotDescribed),
    }
}

/// The fix that is asked for, with or without a watch.
pub(crate) fn described<F>(fix: Option<(F, bool)>) -> Result<F, Refused<ObserveError>> {
    fix.map(|(fix, _)| fix).ok_or(Refused::NotDescribed)
}

/// Has a watch move the vehicle to where the fixes say.
pub(crate) fn watched<T: Real>(
    slam: &mut impl Services<T>,
    report: FixReport<T>,
    to: Option<PoseEstimate<PlanarPose<T>>>,
) -> Watched<T> {
    let relocated = to.is_some_and(|to| slam.relocate(to.mean, &to.covariance).is_ok());
    Watched { report, relocated }
}
