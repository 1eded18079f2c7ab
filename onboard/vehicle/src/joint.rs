//! A joint map built from a description.

use crate::detectors::{detectors, make_detector};
use crate::optional::{ArchiveMemory, HypothesesMemory, MoversMemory, odd, stays};
use crate::slam::{Sink, Source, described, unwatched, watched};
use crate::{
    Control, Description, Filter, Fixes, JointSettings, Measurements, PlanarState, Polar, Ranging, Recordable, Refused,
    SENSORS, Scanned, Sensor, Services, Setting, Slam, Start, StartError, VehicleKind, Watched,
};
use nalgebra::{Vector1, Vector2, Vector3};
use scphd::diagnostics::{Probe, Stage};
use scphd::errors::{Flaw, LoadMapError, ObserveError, PredictError, ResetError, ScanError, SetupError};
use scphd::fixes::FixReport;
use scphd::models::{Fix, MovingOf, OdometryCorrection, PlanarPose, RangeNoise, ScalarOf};
use scphd::numerics::Symmetric;
use scphd::settings::{HypothesesConfig, MovingConfig};
use scphd::snapshot::{RestoreError, SaveError, SliceEnd};
use scphd::storage::JointFilter;
use scphd::{Component, JointSlam, JointState, MapEstimate, PoseEstimate, PredictReport, Real};

/// A joint map in its memory, with the sensors and fixes of its description. `P` is [`PlanarPose`], or
/// [`CalibratedPose`](scphd::models::CalibratedPose) if the odometry is calibrated; the filter `F` depends on the optional parts of
/// the memory. `N` is the noise of its sensors.
#[derive(Debug)]
pub struct Joint<F, P: PlanarState, N: Ranging<ScalarOf<P>> = RangeNoise<ScalarOf<P>>> {
    slam: F,
    optional: Optional<ScalarOf<P>>,
    kind: VehicleKind,
    detectors: [Option<Polar<P, ScalarOf<P>, N>>; SENSORS],
    fixes: Fixes<ScalarOf<P>>,
}

/// Settings of the moving features, range of the sensors for the archive, and settings of the hypotheses.
type Optional<T> = (Option<MovingConfig<T>>, Option<T>, Option<HypothesesConfig<T>>);

/// The settings and the motion model of a description for a joint map.
fn parts<T: Real, P: PlanarState<Scalar = T>>(
    description: &Description<T>,
) -> Result<(&JointSettings<T>, P::Moves), StartError> {
    let Filter::Joint(joint) = &description.filter else { return Err(StartError::NoRoom { part: Setting::FILTER }) };
    let motion = P::moves(description.vehicle.drive()?, joint.odometry)?;
    Ok((joint, motion.ok_or_else(|| odd(Setting::ODOMETRY, joint.odometry.is_some()))?))
}

impl<T: Real, P: PlanarState<Scalar = T>, F: JointFilter<Motion = P::Moves>, N: Ranging<T>> Joint<F, P, N> {
    /// Builds the filter of the description without its sensors, and with these fixes, in the memory of its state, moving features,
    /// archive and hypotheses, whose content is kept: reset new ones first. The memory of an omitted part is `()`. Not inlined, so
    /// that its temporaries are not on the stack beside those of the sensors.
    ///
    /// # Errors
    /// The description is of another filter than the memory, or its parts do not fit each other.
    #[inline(never)]
    pub fn without_sensors<'m, const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize, M, B, H>(
        description: &Description<T>,
        fixes: Fixes<T>,
        state: &'m mut JointState<P, Vector2<T>, FEATURES, NUMBERS, MEASUREMENTS>,
        movers: &'m mut M,
        archive: &'m mut B,
        hypotheses: &'m mut H,
    ) -> Result<Self, StartError>
    where
        M: MoversMemory<P>,
        B: ArchiveMemory<P>,
        H: HypothesesMemory<'m, P, B::Archive<'m>, M::Movers<'m>, Filter = F>,
    {
        let (joint, motion) = parts::<T, P>(description)?;
        let slam = JointSlam::new(motion, joint.config, state)?;
        let slam = movers.add_movers(archive.add_archive(slam, joint.archive_reach_m)?, joint.movers)?;
        let slam = hypotheses.add_hypotheses(slam, joint.hypotheses)?;
        let optional = (joint.movers, joint.archive_reach_m, joint.hypotheses);
        Ok(Self { slam, optional, kind: description.vehicle.kind, detectors: [const { None }; SENSORS], fixes })
    }
}

impl<F, P: PlanarState, N: Ranging<ScalarOf<P>>> Joint<F, P, N> {
    /// The filter, for tests.
    #[doc(hidden)]
    pub fn filter(&mut self) -> &mut F {
        &mut self.slam
    }
}

/// The detector of a sensor in the description.
fn detector<D>(detectors: &[Option<D>], sensor: usize) -> Result<&D, Refused<ScanError>> {
    detectors.get(sensor).and_then(Option::as_ref).ok_or(Refused::NotDescribed)
}

/// The measurements of a scan of range and bearing.
fn polar<T>(measurements: Measurements<'_, T>) -> Result<&[Vector2<T>], Refused<ScanError>> {
    match measurements {
        Measurements::RangeBearing(measurements) => Ok(measurements),
        Measurements::Bearing(_) => Err(Refused::NotDescribed),
    }
}

/// Writes as many elements as fit. Returns the numbers of written and of left-out elements.
fn write<C>(all: impl Iterator<Item = C>, room: &mut [C]) -> (usize, usize) {
    let mut slots = room.iter_mut();
    all.fold((0, 0), |(written, left_out), one| match slots.next() {
        Some(slot) => {
            *slot = one;
            (written + 1, left_out)
        }
        None => (written, left_out + 1),
    })
}

impl<T: Real, P: PlanarState<Scalar = T>, F: JointFilter<Motion = P::Moves>, N: Ranging<T>> Slam<T> for Joint<F, P, N> {
    fn reset(&mut self, start: &Start<T>) -> Result<(), ResetError> {
        let certain = start.covariance().unwrap_or(Symmetric::ZERO);
        let (pose, covariance) = P::start(self.slam.motion(), start.pose, &certain);
        if covariance == Symmetric::ZERO { self.slam.reset(pose) } else { self.slam.reset_within(pose, &covariance) }
    }

    fn predict(&mut self, control: Control<T>, dt_s: T) -> Result<PredictReport, PredictError> {
        self.fixes.wait(dt_s);
        self.slam.predict(&self.kind.control(&control), dt_s)
    }

    fn scan(&mut self, sensor: usize, measurements: Measurements<'_, T>) -> Result<Scanned<T>, Refused<ScanError>> {
        self.scan_with(sensor, measurements, &mut ())
    }

    fn observe_position(&mut self, x_m: T, y_m: T) -> Result<FixReport<T>, Refused<ObserveError>> {
        let fix = P::fixed(unwatched(self.fixes.position())?);
        self.slam.observe(&fix, &Vector2::new(x_m, y_m)).map_err(Refused::Filter)
    }

    fn observe_heading(&mut self, heading_rad: T) -> Result<FixReport<T>, Refused<ObserveError>> {
        let fix = P::fixed(unwatched(self.fixes.heading())?);
        self.slam.observe(&fix, &Vector1::new(heading_rad)).map_err(Refused::Filter)
    }

    fn pose(&self) -> Option<PoseEstimate<PlanarPose<T>>> {
        let PoseEstimate { mean, covariance } = self.slam.estimate_pose()?;
        Some(PoseEstimate { mean: mean.parts().0, covariance: P::narrowed(&covariance) })
    }

    fn odometry(&self) -> Option<OdometryCorrection<T>> {
        self.slam.estimate_pose()?.mean.parts().1
    }

    fn features(&mut self, room: &mut [Component<Vector2<T>>]) -> MapEstimate<T> {
        let (features, left_out) = write(self.slam.features(), room);
        MapEstimate { expected_features: self.slam.expected_features(), features, left_out }
    }

    fn movers(&mut self, room: &mut [Component<MovingOf<PlanarPose<T>>>]) -> MapEstimate<T> {
        let expected_features = self.slam.moving().fold(T::ZERO, |sum, mover| sum + mover.ln_weight.exp());
        let (features, left_out) = write(self.slam.moving(), room);
        MapEstimate { expected_features, features, left_out }
    }
}

impl<T: Real, P: PlanarState<Scalar = T>, F: JointFilter<Motion = P::Moves>, N: Ranging<T>> Services<T>
    for Joint<F, P, N>
{
    fn configure(&mut self, description: &Description<T>) -> Result<(), StartError> {
        description.check_ranges()?;
        let (joint, motion) = parts::<T, P>(description)?;
        let detectors = detectors(description, Sensor::seen::<P, N>)?;
        let fixes = Fixes::of(description)?;
        stays(self.optional.0, joint.movers, Setting::MOVERS)?;
        stays(self.optional.1, joint.archive_reach_m, Setting::ARCHIVE)?;
        stays(self.optional.2, joint.hypotheses, Setting::HYPOTHESES)?;
        self.slam.configure(joint.config).map_err(SetupError::from)?;
        self.slam.retune(motion)?;
        (self.kind, self.detectors, self.fixes) = (description.vehicle.kind, detectors, fixes);
        Ok(())
    }

    fn relocate(&mut self, pose: PlanarPose<T>, covariance: &Symmetric<Vector3<T>>) -> Result<(), ResetError> {
        let before = self.slam.estimate_pose().ok_or(ResetError::NotStarted)?;
        let (pose, covariance) = P::moved(&before, pose, covariance);
        self.slam.relocate(pose, &covariance)
    }

    fn scatter(&mut self, covariance: &Symmetric<Vector3<T>>) -> Result<(), ResetError> {
        self.slam.scatter(&P::widened(covariance))
    }

    fn load_map(&mut self, features: &[Component<Vector2<T>>]) -> Result<(), LoadMapError> {
        self.slam.load_map(features)
    }

    fn localise(&mut self, sensor: usize, measurements: Measurements<'_, T>) -> Result<Scanned<T>, Refused<ScanError>> {
        let (detector, measurements) = (detector(&self.detectors, sensor)?, polar(measurements)?);
        Ok(Scanned::Joint(self.slam.localise(detector, measurements)?))
    }

    fn save(&mut self, kind: u32, sink: &mut Sink<'_>) -> Result<usize, SaveError<SliceEnd>> {
        self.slam.save(kind, sink)
    }

    fn restore(&mut self, kind: u32, source: &mut Source<'_>) -> Result<usize, RestoreError<SliceEnd>> {
        self.slam.restore(kind, source)
    }

    fn watch_position(&mut self, x_m: T, y_m: T) -> Result<Watched<T>, Refused<ObserveError>> {
        let fix = P::fixed(described(self.fixes.position())?);
        let (before, measured) = (self.pose(), Vector2::new(x_m, y_m));
        let report = self.slam.observe(&fix, &measured).map_err(Refused::Filter)?;
        let to = before.and_then(|before| self.fixes.saw_position(&measured, report.accepted, &before));
        Ok(watched(self, report, to))
    }

    fn watch_heading(&mut self, heading_rad: T) -> Result<Watched<T>, Refused<ObserveError>> {
        let fix = P::fixed(described(self.fixes.heading())?);
        let (before, measured) = (self.pose(), Vector1::new(heading_rad));
        let report = self.slam.observe(&fix, &measured).map_err(Refused::Filter)?;
        let to = before.and_then(|before| self.fixes.saw_heading(&measured, report.accepted, &before));
        Ok(watched(self, report, to))
    }

    fn digest(&self) -> u64 {
        self.slam.digest()
    }

    fn audit(&mut self) -> Result<(), Flaw> {
        self.slam.audit()
    }
}

impl<T: Real, P: PlanarState<Scalar = T>, F: JointFilter<Motion = P::Moves>, N: Ranging<T>> Recordable<T>
    for Joint<F, P, N>
{
    fn scan_with(
        &mut self,
        sensor: usize,
        measurements: Measurements<'_, T>,
        probe: &mut impl Probe,
    ) -> Result<Scanned<T>, Refused<ScanError>> {
        let (detector, measurements) = (detector(&self.detectors, sensor)?, polar(measurements)?);
        // A joint map has only one stage.
        probe.enter(Stage::Update);
        let report = self.slam.scan(detector, measurements);
        probe.leave(Stage::Update);
        Ok(Scanned::Joint(report?))
    }

    fn observe<X: Fix<Pose = PlanarPose<T>>>(
        &mut self,
        fix: X,
        measured: &X::Measurement,
    ) -> Result<FixReport<T>, ObserveError> {
        self.slam.observe(&P::fixed(fix), measured)
    }

    fn reset_within(
        &mut self,
        pose: PlanarPose<T>,
        covariance: &Symmetric<Vector3<T>>,
        _: u64,
    ) -> Result<(), ResetError> {
        let (pose, covariance) = P::start(self.slam.motion(), pose, covariance);
        self.slam.reset_within(pose, &covariance)
    }

    fn replace(&mut self, sensor: usize, models: &Sensor<T>) -> Result<(), StartError> {
        make_detector(&mut self.detectors, sensor, models, Sensor::seen::<P, N>)
    }

    fn count(&mut self, _: &mut [Component<Vector2<T>>]) -> usize {
        self.slam.features().count()
    }

    fn held(&self) -> usize {
        self.slam.held()
    }
}
