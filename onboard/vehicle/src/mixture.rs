//! A mixture as it is described.

use crate::slam::{described, watched};
use crate::{
    Control, Description, Filter, Fixes, Measurements, Refused, Rooms, SENSORS, Scanned, Sensor, SensorModel, Slam,
    Start, StartError, VehicleKind, Watched,
};
use nalgebra::{Vector1, Vector2, Vector3};
use scphd::errors::{Flaw, LoadMapError, ObserveError, PredictError, ResetError, ScanError};
use scphd::models::{MovingOf, OdometryCorrection, PlanarMotion, PlanarPose};
use scphd::numerics::Symmetric;
use scphd::snapshot::{RestoreError, SaveError};
use scphd::{Component, Config, MapEstimate, PoseEstimate, PredictReport, Real, ScPhd};

/// A mixture over its memory, with the sensors and fixes of its description.
#[derive(Debug)]
pub struct Mixture<'m, T: Real, const MEASUREMENTS: usize> {
    filter: ScPhd<'m, PlanarMotion<T>>,
    rooms: &'m mut Rooms<T, MEASUREMENTS>,
    kind: VehicleKind,
    sensors: [Option<Sensor<T>>; SENSORS],
    fixes: Fixes<T>,
}

/// The tuning and the motion of a description.
///
/// # Errors
/// It is out of range, or of a joint map.
pub(crate) fn parts<T: Real>(description: &Description<T>) -> Result<(Config<T>, PlanarMotion<T>), StartError> {
    description.check()?;
    let Filter::Mixture(config) = description.filter else { return Err(StartError::NoRoom { part: "joint" }) };
    Ok((config, description.vehicle.drive()?))
}

impl<'m, T: Real, const MEASUREMENTS: usize> Mixture<'m, T, MEASUREMENTS> {
    /// The filter that is described; `filter` puts its motion and tuning over a state.
    ///
    /// # Errors
    /// The description is out of range, or does not fit the state.
    pub fn start(
        description: &Description<T>,
        rooms: &'m mut Rooms<T, MEASUREMENTS>,
        filter: impl FnOnce(PlanarMotion<T>, Config<T>) -> Result<ScPhd<'m, PlanarMotion<T>>, scphd::errors::SetupError>,
    ) -> Result<Self, StartError> {
        let (config, drive) = parts(description)?;
        let filter = filter(drive, config)?;
        Self::check_sensors(&filter, description)?;
        Ok(Self {
            filter,
            rooms,
            kind: description.vehicle.kind,
            sensors: description.sensors,
            fixes: Fixes::of(description)?,
        })
    }

    fn check_sensors(filter: &ScPhd<'m, PlanarMotion<T>>, description: &Description<T>) -> Result<(), StartError> {
        for sensor in description.sensors.iter().flatten() {
            match sensor.model {
                SensorModel::RangeBearing => filter.check(&sensor.polar::<PlanarPose<T>>()?)?,
                SensorModel::Bearing => filter.check(&sensor.direction::<PlanarPose<T>>()?)?,
            }
        }
        Ok(())
    }
}

impl<T: Real, const MEASUREMENTS: usize> Slam<T> for Mixture<'_, T, MEASUREMENTS> {
    fn reset(&mut self, start: &Start<T>) -> Result<(), ResetError> {
        match start.covariance() {
            Some(covariance) => self.filter.reset_within(start.pose, &covariance, start.seed),
            None => self.filter.reset(start.pose, start.seed),
        }
    }

    fn relocate(&mut self, pose: PlanarPose<T>, covariance: &Symmetric<Vector3<T>>) -> Result<(), ResetError> {
        self.filter.relocate(pose, covariance)
    }

    fn scatter(&mut self, covariance: &Symmetric<Vector3<T>>) -> Result<(), ResetError> {
        self.filter.scatter(covariance)
    }

    fn load_map(&mut self, features: &[Component<Vector2<T>>]) -> Result<(), Refused<LoadMapError>> {
        self.filter.load_map(features).map_err(Refused::Filter)
    }

    fn predict(&mut self, control: Control<T>, dt_s: T) -> Result<PredictReport, PredictError> {
        self.fixes.wait(dt_s);
        self.filter.predict(&self.kind.control(&control), dt_s)
    }

    fn scan(&mut self, sensor: usize, measurements: Measurements<'_, T>) -> Result<Scanned<T>, Refused<ScanError>> {
        let sensor = self.sensors.get(sensor).copied().flatten().ok_or(Refused::NotDescribed)?;
        let Rooms { polar, direction } = &mut *self.rooms;
        let report = match (sensor.model, measurements) {
            (SensorModel::RangeBearing, Measurements::RangeBearing(measurements)) => {
                let detector = sensor.polar::<PlanarPose<T>>().map_err(|_| Refused::NotDescribed)?;
                let mut detector = detector.over(polar).map_err(|_| Refused::NotDescribed)?;
                self.filter.scan(&mut detector, measurements)?
            }
            (SensorModel::Bearing, Measurements::Bearing(measurements)) => {
                let detector = sensor.direction::<PlanarPose<T>>().map_err(|_| Refused::NotDescribed)?;
                let mut detector = detector.over(direction).map_err(|_| Refused::NotDescribed)?;
                self.filter.scan(&mut detector, measurements)?
            }
            _ => return Err(Refused::NotDescribed),
        };
        Ok(Scanned::Mixture(report))
    }

    fn localise(&mut self, _: usize, _: Measurements<'_, T>) -> Result<Scanned<T>, Refused<ScanError>> {
        Err(Refused::NotPossible)
    }

    fn observe_position(&mut self, x_m: T, y_m: T) -> Result<Watched<T>, Refused<ObserveError>> {
        let fix = described(self.fixes.position())?;
        let (before, measured) = (self.pose(), Vector2::new(x_m, y_m));
        let report = self.filter.observe(&fix, &measured).map_err(Refused::Filter)?;
        let to = before.and_then(|before| self.fixes.saw_position(&measured, report.accepted, &before));
        Ok(watched(self, report, to))
    }

    fn observe_heading(&mut self, heading_rad: T) -> Result<Watched<T>, Refused<ObserveError>> {
        let fix = described(self.fixes.heading())?;
        let (before, measured) = (self.pose(), Vector1::new(heading_rad));
        let report = self.filter.observe(&fix, &measured).map_err(Refused::Filter)?;
        let to = before.and_then(|before| self.fixes.saw_heading(&measured, report.accepted, &before));
        Ok(watched(self, report, to))
    }

    fn pose(&self) -> Option<PoseEstimate<PlanarPose<T>>> {
        self.filter.estimate_pose()
    }

    fn odometry(&self) -> Option<OdometryCorrection<T>> {
        None
    }

    /// What is confirmed is so as the first sensor sees it.
    fn features(&mut self, room: &mut [Component<Vector2<T>>]) -> MapEstimate<T> {
        let nothing = MapEstimate { expected_features: T::ZERO, features: 0, left_out: 0 };
        let Some(sensor) = self.sensors.iter().flatten().next() else { return nothing };
        let estimate = match sensor.model {
            SensorModel::RangeBearing => {
                sensor.polar::<PlanarPose<T>>().map(|detector| self.filter.estimate_map(&detector, room))
            }
            SensorModel::Bearing => {
                sensor.direction::<PlanarPose<T>>().map(|detector| self.filter.estimate_map(&detector, room))
            }
        };
        estimate.unwrap_or(nothing)
    }

    fn movers(&mut self, room: &mut [Component<MovingOf<PlanarPose<T>>>]) -> MapEstimate<T> {
        self.filter.estimate_moving(room)
    }

    fn configure(&mut self, description: &Description<T>) -> Result<(), StartError> {
        let (config, drive) = parts(description)?;
        let fixes = Fixes::of(description)?;
        Self::check_sensors(&self.filter, description)?;
        self.filter.configure(config)?;
        self.filter.retune(drive)?;
        (self.kind, self.sensors, self.fixes) = (description.vehicle.kind, description.sensors, fixes);
        Ok(())
    }

    fn save<E>(&mut self, kind: u32, sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<usize, SaveError<E>> {
        self.filter.save(kind, sink)
    }

    fn restore<E>(
        &mut self,
        kind: u32,
        source: impl FnMut(usize, &mut [u8]) -> Result<(), E>,
    ) -> Result<usize, RestoreError<E>> {
        self.filter.restore(kind, source)
    }

    fn digest(&self) -> u64 {
        self.filter.digest()
    }

    fn audit(&mut self) -> Result<(), Flaw> {
        self.filter.audit()
    }
}
