//! A mixture built from a description.

use crate::detectors::{detectors, make_detector};
use crate::slam::{Sink, Source, described, unwatched, watched};
use crate::{
    Control, Description, Filter, Fixes, Measurements, Recordable, Refused, Rooms, SENSORS, Scanned, Sensor, Services,
    Setting, Slam, Start, StartError, VehicleKind, Watched,
};
use nalgebra::{Vector1, Vector2, Vector3};
use scphd::diagnostics::Probe;
use scphd::errors::{Flaw, LoadMapError, ObserveError, PredictError, ResetError, ScanError, SetupError};
use scphd::fixes::FixReport;
use scphd::models::{Fix, MovingOf, OdometryCorrection, PlanarMotion, PlanarPose};
use scphd::numerics::Symmetric;
use scphd::snapshot::{RestoreError, SaveError, SliceEnd};
use scphd::{Component, Config, MapEstimate, PoseEstimate, PredictReport, Real, ScPhd};

/// A mixture in its memory, with the sensors and fixes of its description.
#[derive(Debug)]
pub struct Mixture<'m, T: Real, R: Rooms<T>> {
    filter: ScPhd<'m, PlanarMotion<T>>,
    rooms: &'m mut R,
    kind: VehicleKind,
    detectors: [Option<R::Detector>; SENSORS],
    fixes: Fixes<T>,
}

/// The tuning of a description for a mixture.
fn config<T: Real>(description: &Description<T>) -> Result<&Config<T>, StartError> {
    match &description.filter {
        Filter::Mixture(config) => Ok(config),
        Filter::Joint(_) => Err(StartError::NoRoom { part: Setting::FILTER }),
    }
}

/// The detector of a sensor, which the filter must be able to process.
fn detector<T: Real, R: Rooms<T>>(
    filter: &ScPhd<'_, PlanarMotion<T>>,
) -> impl Fn(&Sensor<T>) -> Result<R::Detector, StartError> {
    |sensor| {
        let detector = R::detector(sensor)?;
        R::check(filter, &detector)?;
        Ok(detector)
    }
}

impl<'m, T: Real, R: Rooms<T>> Mixture<'m, T, R> {
    /// Builds the filter of the description without its sensors, and with these fixes; `filter` constructs it from motion and tuning
    /// in a state. Not inlined, so that its temporaries are not on the stack beside those of the sensors.
    ///
    /// # Errors
    /// The description is of another filter, or does not fit the state.
    #[inline(never)]
    pub fn without_sensors(
        description: &Description<T>,
        fixes: Fixes<T>,
        rooms: &'m mut R,
        filter: impl FnOnce(PlanarMotion<T>, Config<T>) -> Result<ScPhd<'m, PlanarMotion<T>>, SetupError>,
    ) -> Result<Self, StartError> {
        let config = config(description)?;
        let filter = filter(description.vehicle.drive()?, *config)?;
        Ok(Self { filter, rooms, kind: description.vehicle.kind, detectors: [None; SENSORS], fixes })
    }
}

impl<'m, T: Real, R: Rooms<T>> Mixture<'m, T, R> {
    /// The filter, for tests.
    #[doc(hidden)]
    pub fn filter(&mut self) -> &mut ScPhd<'m, PlanarMotion<T>> {
        &mut self.filter
    }
}

impl<T: Real, R: Rooms<T>> Slam<T> for Mixture<'_, T, R> {
    fn reset(&mut self, start: &Start<T>) -> Result<(), ResetError> {
        match start.covariance() {
            Some(covariance) => self.filter.reset_within(start.pose, &covariance, start.seed),
            None => self.filter.reset(start.pose, start.seed),
        }
    }

    fn predict(&mut self, control: Control<T>, dt_s: T) -> Result<PredictReport, PredictError> {
        self.fixes.wait(dt_s);
        self.filter.predict(&self.kind.control(&control), dt_s)
    }

    fn scan(&mut self, sensor: usize, measurements: Measurements<'_, T>) -> Result<Scanned<T>, Refused<ScanError>> {
        self.scan_with(sensor, measurements, &mut ())
    }

    fn observe_position(&mut self, x_m: T, y_m: T) -> Result<FixReport<T>, Refused<ObserveError>> {
        let fix = unwatched(self.fixes.position())?;
        self.filter.observe(&fix, &Vector2::new(x_m, y_m)).map_err(Refused::Filter)
    }

    fn observe_heading(&mut self, heading_rad: T) -> Result<FixReport<T>, Refused<ObserveError>> {
        let fix = unwatched(self.fixes.heading())?;
        self.filter.observe(&fix, &Vector1::new(heading_rad)).map_err(Refused::Filter)
    }

    fn pose(&self) -> Option<PoseEstimate<PlanarPose<T>>> {
        self.filter.estimate_pose()
    }

    fn odometry(&self) -> Option<OdometryCorrection<T>> {
        None
    }

    /// The first sensor decides which features are confirmed.
    fn features(&mut self, room: &mut [Component<Vector2<T>>]) -> MapEstimate<T> {
        let nothing = MapEstimate { expected_features: T::ZERO, features: 0, left_out: 0 };
        let first = self.detectors.iter().flatten().next();
        first.map_or(nothing, |detector| R::features(&mut self.filter, detector, room))
    }

    fn movers(&mut self, room: &mut [Component<MovingOf<PlanarPose<T>>>]) -> MapEstimate<T> {
        self.filter.estimate_moving(room)
    }
}

impl<T: Real, R: Rooms<T>> Services<T> for Mixture<'_, T, R> {
    fn configure(&mut self, description: &Description<T>) -> Result<(), StartError> {
        description.check_ranges()?;
        let (config, drive, fixes) = (config(description)?, description.vehicle.drive()?, Fixes::of(description)?);
        let detectors = detectors(description, detector::<T, R>(&self.filter))?;
        self.filter.configure(*config)?;
        self.filter.retune(drive)?;
        (self.kind, self.detectors, self.fixes) = (description.vehicle.kind, detectors, fixes);
        Ok(())
    }

    fn relocate(&mut self, pose: PlanarPose<T>, covariance: &Symmetric<Vector3<T>>) -> Result<(), ResetError> {
        self.filter.relocate(pose, covariance)
    }

    fn scatter(&mut self, covariance: &Symmetric<Vector3<T>>) -> Result<(), ResetError> {
        self.filter.scatter(covariance)
    }

    fn load_map(&mut self, features: &[Component<Vector2<T>>]) -> Result<(), LoadMapError> {
        self.filter.load_map(features)
    }

    fn localise(&mut self, _: usize, _: Measurements<'_, T>) -> Result<Scanned<T>, Refused<ScanError>> {
        Err(Refused::NotPossible)
    }

    fn save(&mut self, kind: u32, sink: &mut Sink<'_>) -> Result<usize, SaveError<SliceEnd>> {
        self.filter.save(kind, sink)
    }

    fn restore(&mut self, kind: u32, source: &mut Source<'_>) -> Result<usize, RestoreError<SliceEnd>> {
        self.filter.restore(kind, source)
    }

    fn watch_position(&mut self, x_m: T, y_m: T) -> Result<Watched<T>, Refused<ObserveError>> {
        let fix = described(self.fixes.position())?;
        let (before, measured) = (self.pose(), Vector2::new(x_m, y_m));
        let report = self.filter.observe(&fix, &measured).map_err(Refused::Filter)?;
        let to = before.and_then(|before| self.fixes.saw_position(&measured, report.accepted, &before));
        Ok(watched(self, report, to))
    }

    fn watch_heading(&mut self, heading_rad: T) -> Result<Watched<T>, Refused<ObserveError>> {
        let fix = described(self.fixes.heading())?;
        let (before, measured) = (self.pose(), Vector1::new(heading_rad));
        let report = self.filter.observe(&fix, &measured).map_err(Refused::Filter)?;
        let to = before.and_then(|before| self.fixes.saw_heading(&measured, report.accepted, &before));
        Ok(watched(self, report, to))
    }

    fn digest(&self) -> u64 {
        self.filter.digest()
    }

    fn audit(&mut self) -> Result<(), Flaw> {
        self.filter.audit()
    }
}

impl<T: Real, R: Rooms<T>> Recordable<T> for Mixture<'_, T, R> {
    fn scan_with(
        &mut self,
        sensor: usize,
        measurements: Measurements<'_, T>,
        probe: &mut impl Probe,
    ) -> Result<Scanned<T>, Refused<ScanError>> {
        let detector = self.detectors.get(sensor).and_then(Option::as_ref).ok_or(Refused::NotDescribed)?;
        self.rooms.scan_with(&mut self.filter, detector, measurements, probe).map(Scanned::Mixture)
    }

    fn observe<F: Fix<Pose = PlanarPose<T>>>(
        &mut self,
        fix: F,
        measured: &F::Measurement,
    ) -> Result<FixReport<T>, ObserveError> {
        self.filter.observe(&fix, measured)
    }

    fn reset_within(
        &mut self,
        pose: PlanarPose<T>,
        covariance: &Symmetric<Vector3<T>>,
        seed: u64,
    ) -> Result<(), ResetError> {
        self.filter.reset_within(pose, covariance, seed)
    }

    fn replace(&mut self, sensor: usize, models: &Sensor<T>) -> Result<(), StartError> {
        make_detector(&mut self.detectors, sensor, models, detector::<T, R>(&self.filter))
    }

    fn count(&mut self, room: &mut [Component<Vector2<T>>]) -> usize {
        self.features(room).features
    }

    fn held(&self) -> usize {
        0
    }
}
