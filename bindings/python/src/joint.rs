//! The joint map.

use crate::detector::{RangeBearing, polar_scan};
use crate::error::{Refusal, not_started, wrong_type};
use crate::estimate::{Map, Pose};
use crate::fix::Measured;
use crate::memory::{JointCell, JointMap, joint_map};
use crate::report::{FixReport, JointReport, PredictReport};
use crate::tuning;
use crate::vehicle::Vehicle;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use scphd::models::PlanarPose;
use scphd::snapshot::from_slice;
use std::convert::Infallible;
use std::sync::Mutex;

/// One Gaussian over the pose and a map of features that stand still (`JointSlam`). Single precision; the same inputs give the same bits
/// as in firmware, in C and in Rust.
///
/// One thread at a time may work with a filter; different filters work in different threads at the same time.
///
/// Parameters
/// ----------
/// vehicle : Unicycle, Ackermann, Holonomic or KnownPose
///     How it moves.
/// memory : str
///     How much room there is: 'DESK' (512 features, scans of 256 measurements), or as much as a set of the C interface has:
///     'JOINT_40', 'JOINT_100' (scans of 32).
/// birth_probability_min : float
///     A measurement gives birth where nothing else explains at least this share of it.
/// gate : float
///     Squared Mahalanobis distance beyond which a measurement says nothing of a feature.
/// visible_s, occluded_s, lifetime_s : float
///     Mean times that a landmark stays in sight before something hides it, that it stays hidden, and until it is taken away, s;
///     infinite: for ever.
/// occlusion_factor : float
///     Share of the probability of detection that is left behind a nearer detection.
/// least_existence, least_tentative : float
///     A feature is dropped below this probability that it is there; the second while it was detected less than twice.
/// extraction_existence : float
///     A feature is part of the estimate from this probability on.
/// merge_distance : float
///     Squared Mahalanobis distance within which two features are one.
/// step_max_s, speed_max_mps, turn_rate_max_radps, jump_max_m : float
///     What no vehicle does: a prediction beyond is refused.
#[pyclass(module = "scphd")]
pub struct JointFilter {
    vehicle: Vehicle,
    /// As of a `Filter`.
    cell: Mutex<JointCell>,
    last: Option<scphd::JointReport<f32>>,
}

impl JointFilter {
    fn with<R>(&mut self, work: impl FnOnce(&mut JointMap<'_>) -> R) -> R {
        let cell = self.cell.get_mut().unwrap_or_else(|poisoned| poisoned.into_inner());
        cell.with_dependent_mut(|_, filter| work(filter))
    }
}

#[pymethods]
impl JointFilter {
    #[new]
    #[pyo3(signature = (vehicle, *, memory="DESK", **settings))]
    fn new(vehicle: &Bound<'_, PyAny>, memory: &str, settings: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let vehicle = Vehicle::of(vehicle)?;
        let config = tuning::of_joint_map(settings)?;
        Ok(Self { vehicle, cell: Mutex::new(joint_map(memory, vehicle, config)?), last: None })
    }

    /// Puts the vehicle to a pose, certain of it, with an empty map.
    ///
    /// Raises InputError where the pose is not finite or farther away than 1e8 m.
    #[pyo3(signature = (x_m=0.0, y_m=0.0, heading_rad=0.0))]
    fn reset(&mut self, x_m: f32, y_m: f32, heading_rad: f32) -> PyResult<()> {
        let pose = PlanarPose::new(x_m, y_m, heading_rad);
        self.with(|filter| filter.reset(pose)).map_err(Refusal::raised)?;
        self.last = None;
        Ok(())
    }

    /// Moves the vehicle for `dt_s` seconds, as `Filter.predict` does.
    fn predict(&mut self, py: Python<'_>, control: &Bound<'_, PyAny>, dt_s: f32) -> PyResult<PredictReport> {
        let control = self.vehicle.control(control)?;
        py.detach(|| self.with(|filter| filter.predict(&control, dt_s)))
            .map(PredictReport::from)
            .map_err(Refusal::raised)
    }

    /// Takes in one scan of one of the vehicle's detectors, of which there may be any number.
    ///
    /// Parameters
    /// ----------
    /// detector : RangeBearing
    ///     Whose scan it is. Its births that move are left out: all features stand still.
    /// measurements : array_like, shape (n, 2)
    ///     Range m and bearing rad, in single precision.
    ///
    /// Raises InputError where a measurement is not finite or there are more than the memory holds; the filter is as it was.
    fn scan(
        &mut self,
        py: Python<'_>,
        detector: &Bound<'_, PyAny>,
        measurements: &Bound<'_, PyAny>,
    ) -> PyResult<JointReport> {
        let Ok(detector) = detector.cast::<RangeBearing>() else {
            return Err(wrong_type("detector", "a RangeBearing", detector));
        };
        let (scan, detector) = (polar_scan(measurements)?, detector.try_borrow()?.0.detector()?);
        let report = py.detach(|| self.with(|filter| filter.scan(&detector, &scan))).map_err(Refusal::raised)?;
        self.last = Some(report);
        Ok(report.into())
    }

    /// Takes in a measurement of the pose itself, as `Filter.observe` does.
    fn observe(&mut self, fix: &Bound<'_, PyAny>, measurement: &Bound<'_, PyAny>) -> PyResult<FixReport> {
        let measured = Measured::of(fix, measurement)?;
        let report = self.with(|filter| match &measured {
            Measured::Position(fix, position) => filter.observe(fix, position),
            Measured::Heading(fix, heading) => filter.observe(fix, heading),
        });
        report.map(FixReport::from).map_err(Refusal::raised)
    }

    /// Where the vehicle is.
    ///
    /// Raises NotStartedError before the first reset.
    fn estimate(&mut self) -> PyResult<Pose> {
        self.with(|filter| filter.estimate_pose()).map(Pose::from).ok_or_else(not_started)
    }

    /// The features that are there and were detected twice.
    fn map(&mut self) -> Map {
        Map::of(self.with(|filter| (filter.features().collect(), filter.expected_features())))
    }

    /// The report of the last scan; None before the first.
    fn report(&self) -> Option<JointReport> {
        self.last.map(JointReport::from)
    }

    /// A hash of all that the filter knows, to the last bit: the same inputs give the same on every machine and in every language.
    fn digest(&mut self) -> u64 {
        self.with(|filter| filter.digest())
    }

    /// All that decides how the filter goes on, as bytes, as `Filter.snapshot`.
    #[pyo3(signature = (*, kind=0))]
    fn snapshot<'py>(&mut self, py: Python<'py>, kind: u32) -> PyResult<Bound<'py, PyBytes>> {
        let mut bytes = Vec::new();
        let sink = |chunk: &[u8]| {
            bytes.extend_from_slice(chunk);
            Ok::<(), Infallible>(())
        };
        self.with(|filter| filter.save(kind, sink)).map_err(Refusal::raised)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Goes on from a snapshot, as if nothing had been.
    ///
    /// Raises SnapshotError where the bytes are no snapshot of such a filter; then the filter is as it was.
    #[pyo3(signature = (snapshot, *, kind=0))]
    fn restore(&mut self, snapshot: &[u8], kind: u32) -> PyResult<()> {
        self.with(|filter| filter.restore(kind, from_slice(snapshot))).map_err(Refusal::raised)?;
        self.last = None;
        Ok(())
    }
}
