//! A joint map as it is described.

use crate::slam::{described, watched};
use crate::{
    Control, Description, Filter, Fixes, JointFilter, Measurements, PlanarState, Refused, SENSORS, Scanned, Sensor,
    SensorModel, Slam, Start, StartError, VehicleKind, Watched,
};
use nalgebra::{Vector1, Vector2, Vector3};
use scphd::errors::{Flaw, LoadMapError, ObserveError, PredictError, ResetError, ScanError, SetupError};
use scphd::models::{MovingOf, OdometryCorrection, PlanarPose, ScalarOf};
use scphd::numerics::Symmetric;
use scphd::snapshot::{RestoreError, SaveError};
use scphd::storage::{Archived, JointArchive, JointMovers, NoArchive, NoMovers, Tracked};
use scphd::{Component, JointSlam, JointState, MapEstimate, PoseEstimate, PredictReport, Real};

/// A joint map with or without an archive `A` and movers `V`.
type Map<'m, P, A, V> = JointSlam<'m, <P as PlanarState>::Moves, Vector2<ScalarOf<P>>, A, V>;

/// The joint map with what it has beside.
#[derive(Debug)]
enum Held<'m, P: PlanarState> {
    Alone(Map<'m, P, NoArchive, NoMovers>),
    Movers(Map<'m, P, NoArchive, Tracked<'m, P>>),
    Archive(Map<'m, P, Archived<'m, P>, NoMovers>),
    Both(Map<'m, P, Archived<'m, P>, Tracked<'m, P>>),
}

/// The same call, whatever the map has beside.
macro_rules! each {
    ($held:expr, |$slam:ident| $call:expr) => {
        match $held {
            Held::Alone($slam) => $call,
            Held::Movers($slam) => $call,
            Held::Archive($slam) => $call,
            Held::Both($slam) => $call,
        }
    };
}

/// The same call of maps without an archive; others cannot do it.
macro_rules! each_without_archive {
    ($held:expr, |$slam:ident| $call:expr) => {
        match $held {
            Held::Alone($slam) => $call,
            Held::Movers($slam) => $call,
            Held::Archive(_) | Held::Both(_) => Err(Refused::NotPossible),
        }
    };
}

/// A joint map over its memory, with the sensors and fixes of its description. `P` is [`PlanarPose`], or
/// [`CalibratedPose`](scphd::models::CalibratedPose) where the odometry is learnt.
#[derive(Debug)]
pub struct Joint<'m, P: PlanarState> {
    held: Held<'m, P>,
    kind: VehicleKind,
    sensors: [Option<Sensor<ScalarOf<P>>>; SENSORS],
    fixes: Fixes<ScalarOf<P>>,
}

/// The joint map of a description, and its motion, where such a state is one of it.
fn parts<P: PlanarState>(
    description: &Description<ScalarOf<P>>,
) -> Result<(JointFilter<ScalarOf<P>>, P::Moves), StartError> {
    description.check()?;
    let Filter::Joint(joint) = description.filter else { return Err(StartError::NoRoom { part: "mixture" }) };
    let has_bearings = description.sensors.iter().flatten().any(|sensor| sensor.model == SensorModel::Bearing);
    if has_bearings {
        // One bearing has no inverse, so that nothing would be born.
        return Err(StartError::NoRoom { part: "sensor.model of bearings" });
    }
    let motion = P::moves(description.vehicle.drive()?, joint.odometry)?;
    Ok((joint, motion.ok_or(StartError::NoRoom { part: "joint.odometry" })?))
}

impl<'m, T: Real, P: PlanarState<Scalar = T>> Joint<'m, P> {
    /// The filter that is described, over a state, movers and an archive, which keep what they hold: fresh ones must be reset first.
    ///
    /// # Errors
    /// The description is out of range, or of a filter that these are no memory of.
    pub fn start<
        const FEATURES: usize,
        const NUMBERS: usize,
        const MEASUREMENTS: usize,
        const MOVERS: usize,
        const ARCHIVED: usize,
    >(
        description: &Description<T>,
        state: &'m mut JointState<P, Vector2<T>, FEATURES, NUMBERS, MEASUREMENTS>,
        movers: &'m mut JointMovers<P, MOVERS>,
        archive: &'m mut JointArchive<P, ARCHIVED>,
    ) -> Result<Self, StartError> {
        let (joint, motion) = parts::<P>(description)?;
        if joint.movers.is_some() && MOVERS == 0 {
            return Err(StartError::NoRoom { part: "joint.movers" });
        }
        if joint.archive_reach_m.is_some() && ARCHIVED == 0 {
            return Err(StartError::NoRoom { part: "joint.archive" });
        }
        let alone = JointSlam::new(motion, joint.config, state)?;
        let held = match (joint.movers, joint.archive_reach_m) {
            (None, None) => Held::Alone(alone),
            (Some(moving), None) => Held::Movers(alone.with_movers(movers, moving)?),
            (None, Some(reach_m)) => Held::Archive(alone.with_archive(archive, reach_m)?),
            (Some(moving), Some(reach_m)) => {
                Held::Both(alone.with_archive(archive, reach_m)?.with_movers(movers, moving)?)
            }
        };
        Ok(Self { held, kind: description.vehicle.kind, sensors: description.sensors, fixes: Fixes::of(description)? })
    }

    fn sensor(&self, sensor: usize) -> Result<Sensor<T>, Refused<ScanError>> {
        self.sensors.get(sensor).copied().flatten().ok_or(Refused::NotDescribed)
    }

    fn estimate(&self) -> Option<PoseEstimate<P>> {
        each!(&self.held, |slam| slam.estimate_pose())
    }
}

/// Writes what there is room for: how many were written, and how many left out.
fn write<C>(all: impl Iterator<Item = C>, room: &mut [C]) -> (usize, usize) {
    let mut slots = room.iter_mut();
    let (mut written, mut left_out) = (0, 0);
    for one in all {
        match slots.next() {
            Some(slot) => (*slot, written) = (one, written + 1),
            None => left_out += 1,
        }
    }
    (written, left_out)
}

impl<T: Real, P: PlanarState<Scalar = T>> Slam<T> for Joint<'_, P> {
    fn reset(&mut self, start: &Start<T>) -> Result<(), ResetError> {
        each!(&mut self.held, |slam| {
            let certain = start.covariance().unwrap_or(Symmetric::ZERO);
            let (pose, covariance) = P::start(slam.motion(), start.pose, &certain);
            if covariance == Symmetric::ZERO { slam.reset(pose) } else { slam.reset_within(pose, &covariance) }
        })
    }

    fn relocate(&mut self, pose: PlanarPose<T>, covariance: &Symmetric<Vector3<T>>) -> Result<(), ResetError> {
        let (pose, covariance) = P::moved(&self.estimate().ok_or(ResetError::NotStarted)?, pose, covariance);
        each!(&mut self.held, |slam| slam.relocate(pose, &covariance))
    }

    fn scatter(&mut self, covariance: &Symmetric<Vector3<T>>) -> Result<(), ResetError> {
        each!(&mut self.held, |slam| slam.scatter(&P::widened(covariance)))
    }

    fn load_map(&mut self, features: &[Component<Vector2<T>>]) -> Result<(), Refused<LoadMapError>> {
        each_without_archive!(&mut self.held, |slam| slam.load_map(features).map_err(Refused::Filter))
    }

    fn predict(&mut self, control: Control<T>, dt_s: T) -> Result<PredictReport, PredictError> {
        self.fixes.wait(dt_s);
        let control = self.kind.control(&control);
        each!(&mut self.held, |slam| slam.predict(&control, dt_s))
    }

    fn scan(&mut self, sensor: usize, measurements: Measurements<'_, T>) -> Result<Scanned<T>, Refused<ScanError>> {
        let sensor = self.sensor(sensor)?;
        let Measurements::RangeBearing(measurements) = measurements else { return Err(Refused::NotDescribed) };
        let detector = sensor.polar::<P>().map_err(|_| Refused::NotDescribed)?;
        Ok(Scanned::Joint(each!(&mut self.held, |slam| slam.scan(&detector, measurements))?))
    }

    fn localise(&mut self, sensor: usize, measurements: Measurements<'_, T>) -> Result<Scanned<T>, Refused<ScanError>> {
        let sensor = self.sensor(sensor)?;
        let Measurements::RangeBearing(measurements) = measurements else { return Err(Refused::NotDescribed) };
        let detector = sensor.polar::<P>().map_err(|_| Refused::NotDescribed)?;
        each_without_archive!(&mut self.held, |slam| slam.localise(&detector, measurements).map_err(Refused::Filter))
            .map(Scanned::Joint)
    }

    fn observe_position(&mut self, x_m: T, y_m: T) -> Result<Watched<T>, Refused<ObserveError>> {
        let fix = P::fixed(described(self.fixes.position())?);
        let (before, measured) = (self.pose(), Vector2::new(x_m, y_m));
        let report = each!(&mut self.held, |slam| slam.observe(&fix, &measured)).map_err(Refused::Filter)?;
        let to = before.and_then(|before| self.fixes.saw_position(&measured, report.accepted, &before));
        Ok(watched(self, report, to))
    }

    fn observe_heading(&mut self, heading_rad: T) -> Result<Watched<T>, Refused<ObserveError>> {
        let fix = P::fixed(described(self.fixes.heading())?);
        let (before, measured) = (self.pose(), Vector1::new(heading_rad));
        let report = each!(&mut self.held, |slam| slam.observe(&fix, &measured)).map_err(Refused::Filter)?;
        let to = before.and_then(|before| self.fixes.saw_heading(&measured, report.accepted, &before));
        Ok(watched(self, report, to))
    }

    fn pose(&self) -> Option<PoseEstimate<PlanarPose<T>>> {
        let PoseEstimate { mean, covariance } = self.estimate()?;
        Some(PoseEstimate { mean: mean.parts().0, covariance: P::narrowed(&covariance) })
    }

    fn odometry(&self) -> Option<OdometryCorrection<T>> {
        self.estimate()?.mean.parts().1
    }

    fn features(&mut self, room: &mut [Component<Vector2<T>>]) -> MapEstimate<T> {
        each!(&self.held, |slam| {
            let (features, left_out) = write(slam.features(), room);
            MapEstimate { expected_features: slam.expected_features(), features, left_out }
        })
    }

    fn movers(&mut self, room: &mut [Component<MovingOf<PlanarPose<T>>>]) -> MapEstimate<T> {
        each!(&self.held, |slam| {
            let expected_features = slam.moving().fold(T::ZERO, |sum, mover| sum + mover.ln_weight.exp());
            let (features, left_out) = write(slam.moving(), room);
            MapEstimate { expected_features, features, left_out }
        })
    }

    fn configure(&mut self, description: &Description<T>) -> Result<(), StartError> {
        let (joint, motion) = parts::<P>(description)?;
        let has_movers = matches!(self.held, Held::Movers(_) | Held::Both(_));
        let has_archive = matches!(self.held, Held::Archive(_) | Held::Both(_));
        if joint.movers.is_some() != has_movers {
            return Err(StartError::NoRoom { part: "joint.movers" });
        }
        if joint.archive_reach_m.is_some() != has_archive {
            return Err(StartError::NoRoom { part: "joint.archive" });
        }
        let fixes = Fixes::of(description)?;
        each!(&mut self.held, |slam| {
            slam.configure(joint.config).map_err(SetupError::from)?;
            slam.retune(motion)?;
        });
        (self.kind, self.sensors, self.fixes) = (description.vehicle.kind, description.sensors, fixes);
        Ok(())
    }

    fn save<E>(&mut self, kind: u32, sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<usize, SaveError<E>> {
        each!(&self.held, |slam| slam.save(kind, sink))
    }

    fn restore<E>(
        &mut self,
        kind: u32,
        source: impl FnMut(usize, &mut [u8]) -> Result<(), E>,
    ) -> Result<usize, RestoreError<E>> {
        each!(&mut self.held, |slam| slam.restore(kind, source))
    }

    fn digest(&self) -> u64 {
        each!(&self.held, |slam| slam.digest())
    }

    fn audit(&mut self) -> Result<(), Flaw> {
        each!(&self.held, |slam| slam.audit())
    }
}
